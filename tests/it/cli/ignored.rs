//! Options that nothing would come of are errors that name them and the remedy.

use sesc_test_support::command::{folder, in_words, op2, refused, sesc, stdout};

#[test]
fn options_of_logs_are_refused_beside_two_model_files() {
    let models = ["compare", "monday.toml", "friday.toml"];
    for option in [
        &["--noise", "0.001"][..],
        &["--prior=cad"],
        &["--support", "r_sole"],
        &["--degrees"],
        &["--floor", "0.0001"],
        &["--motion", "off"],
        &["--both-feet"],
        &["--settle", "0.3"],
    ] {
        let name = option[0].split('=').next().unwrap();
        for urdf in [&[][..], &["--urdf", "op2.urdf"]] {
            let output = sesc(&[&models[..], option, urdf].concat());
            refused(&output, &[name, "two model files", "leave it out"]);
        }
    }
    refused(
        &sesc(&[&models[..], &["--no-snap"]].concat()),
        &["--no-snap", "add --urdf"],
    );
    refused(
        &sesc(&[&models[..], &["--no-snap", "--urdf", "op2.urdf"]].concat()),
        &["--no-snap", "add --report"],
    );
}

#[test]
fn options_of_what_is_not_made_are_refused() {
    let fleet = ["fleet", "op2.urdf", "--data", "logs", "--out", "fleet.csv"];
    let words = ["--only", "parameters", "--floor", "0.0002"];
    refused(
        &sesc(&[&fleet[..], &words].concat()),
        &["--floor", "--only parameters makes none"],
    );
    let urdf = op2();
    let inspect = ["inspect", &urdf, "--support", "r_sole", "--long", "--json"];
    refused(
        &sesc(&inspect),
        &["--long", "cannot be used with", "--json"],
    );
}

#[test]
fn options_of_parts_are_refused_without_parts_and_those_of_logs_without_logs() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (urdf, log, part) = (op2(), at("log.csv"), at("log.part"));
    let simulate = ["simulate", &urdf, "--support", "r_sole", "--poses", "40"];
    stdout(&sesc(
        &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
    ));
    let fit = ["fit", &urdf, "--data", &log];
    refused(
        &sesc(&[&fit[..], &["--unit", "r07"]].concat()),
        &["--unit", "factor files", "--partial"],
    );
    refused(
        &sesc(&[&fit[..], &["--duplicates", "skip"]].concat()),
        &["--duplicates", "factor files", "none is read"],
    );
    stdout(&sesc(
        &[&fit[..], &["--unit", "r07", "--partial", &part]].concat(),
    ));
    stdout(&sesc(&in_words(
        "fit @ --unit r07 --duplicates skip",
        &[&part],
    )));
    for option in ["--both-feet", "--other-foot=top"] {
        let name = option.split('=').next().unwrap();
        refused(&sesc(&["fit", &part, option]), &[name, "--data"]);
    }
}
