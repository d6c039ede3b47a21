//! Options that nothing would come of are errors that name them and the remedy.

use sesc_test_support::command::Folder;

#[test]
fn options_of_logs_are_refused_beside_two_model_files() {
    let folder = Folder::empty();
    for option in [
        "--noise 0.001",
        "--prior=cad",
        "--support r_sole",
        "--degrees",
        "--floor 0.0001",
        "--motion off",
        "--both-feet",
        "--settle 0.3",
    ] {
        let name = option.split(['=', ' ']).next().unwrap();
        for urdf in ["", "--urdf op2.urdf"] {
            let line = format!("compare monday.toml friday.toml {option} {urdf}");
            folder.refuses(&line, &[name, "two model files", "leave it out"]);
        }
    }
    folder.refuses_each(
        "compare monday.toml friday.toml --no-snap | --no-snap | add --urdf
         compare monday.toml friday.toml --no-snap --urdf op2.urdf | --no-snap | add --report",
    );
}

#[test]
fn options_of_parts_are_refused_without_parts_and_those_of_logs_without_logs() {
    let folder = Folder::with_log("--poses 40 --noise 0.0005");
    folder.stdout("fit op2.urdf --data log.csv --unit r07 --partial log.part");
    folder.stdout("fit log.part --unit r07 --duplicates skip");
    folder.refuses_each(
        "fit op2.urdf --data log.csv --unit r07 | --unit | factor files | --partial
         fit op2.urdf --data log.csv --duplicates skip | factor files | none is read
         fit log.part --both-feet | --both-feet | --data
         fit log.part --other-foot=top | --other-foot | --data
         fleet op2.urdf --data logs --out fleet.csv --only parameters --floor 0.0002 | --floor
            | --only parameters makes none
         inspect op2.urdf --support r_sole --long --json | --long | cannot be used with | --json",
    );
}
