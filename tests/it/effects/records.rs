//! Effects in model files: there and back, and every way to get one wrong.

use std::fs;

use sesc_model::effects::{self, Catalog, Effect, Stage};
use sesc_model::{EffectRecord, ModelFile, Quantity};

use super::correction::{file, with};
use super::hidden::Hidden;
use super::robots::{Stand, urdf};
use sesc_test_support::command::{folder, in_words, refused, sesc, stdout, write};

fn near(a: &[f64], b: &[f64]) -> bool {
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * (1.0 + a.abs().max(b.abs()));
    a.len() == b.len() && a.iter().zip(b).all(close)
}

#[test]
fn values_and_unknowns_are_inverse() {
    for stand in Stand::all() {
        let context = stand.context();
        for instance in effects::instances(&context) {
            let (effect, target) = (instance.effect, &instance.target);
            let scales = instance.scales(&context);
            for size in [0.5, 3.0, -0.7] {
                let unknowns: Vec<f64> = scales.iter().map(|scale| size * scale).collect();
                let values = effect.values(&context, target, &unknowns);
                let back = effect.unknowns(&context, target, &values);
                let label = instance.label(&context);
                assert!(near(&back, &unknowns), "{label}: {back:?} {unknowns:?}");
                let again = effect.values(&context, target, &back);
                assert!(near(&again, &values), "{label}: {again:?} {values:?}");
            }
        }
    }
}

#[test]
fn model_files_give_back_what_was_written() {
    for stand in Stand::all() {
        let context = stand.context();
        for effect in Catalog::standard().iter() {
            for hidden in Hidden::of(effect, &context, 3) {
                let written = file(&stand, std::slice::from_ref(&hidden));
                let text = toml::to_string(&written).unwrap();
                let read = ModelFile::parse(&text, "model.toml").unwrap();
                assert_eq!(read.effects, written.effects, "{text}");
                let model = stand.model.clone().with_file(read).unwrap();
                let [(instance, unknowns)] = &model.effects[..] else {
                    panic!("{text}");
                };
                assert_eq!(*instance, hidden.instance);
                assert!(near(unknowns, &hidden.unknowns(&context)), "{text}");
            }
        }
    }
}

/// A plain record, made wrong by `change`, as `sesc generate` takes it.
fn generate(stand: &Stand, record: EffectRecord, cells: bool, words: &[&str]) {
    let mut model = file(stand, &[]);
    if !cells {
        model.cells.clear();
    }
    model.effects.push(record);
    let folder = folder();
    let path = write(
        folder.path(),
        "model.toml",
        toml::to_string(&model).unwrap(),
    );
    let out = folder.path().join("out");
    let text = out.display().to_string();
    let arguments = ["--no-snap", "--model", &path, "--name", "m", "--out", &text];
    let output = sesc(&[&["generate", &urdf(stand.name)][..], &arguments].concat());
    refused(&output, &[&["model.toml"], words].concat());
    assert!(!out.exists(), "nothing is written");
}

#[test]
fn faults_of_records_name_the_effect_and_the_remedy() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let unknown = EffectRecord {
        effect: "warp".into(),
        target: "-".into(),
        parameters: Default::default(),
    };
    generate(
        &stand,
        unknown,
        true,
        &["`warp`", "known are sensor_offset", "units"],
    );
    for effect in Catalog::standard().iter() {
        let name = format!("`{}`", effect.id().name());
        let good = Hidden::of(effect, &context, 2)[0].record(&context);
        let nowhere = EffectRecord {
            target: "nowhere".into(),
            ..good.clone()
        };
        let offered = context.name_of(&effect.targets(&context)[0]);
        generate(
            &stand,
            nowhere,
            true,
            &[&name, "`nowhere`", "it has", &offered],
        );
        let mut stray = good.clone();
        let quantity = Quantity {
            value: 1.0,
            std: None,
        };
        stray.parameters.insert("colour".into(), quantity);
        let remedy = good.parameters.keys().next().map_or("remove", |key| key);
        generate(&stand, stray, true, &[&name, "`colour`", remedy]);
        for key in good.parameters.keys() {
            let mut missing = good.clone();
            missing.parameters.remove(key);
            let add = format!("add parameters.{key} = ");
            generate(&stand, missing, true, &[&name, "is missing", &add]);
            for wrong in [f64::NAN, f64::INFINITY] {
                let mut bad = good.clone();
                bad.parameters.get_mut(key).unwrap().value = wrong;
                generate(
                    &stand,
                    bad,
                    true,
                    &[&name, key, "not finite", "give a number"],
                );
            }
        }
        if effect.stage() == Stage::Cells {
            generate(&stand, good, false, &[&name, "fsr_1", "add cells = [["]);
        }
    }
}

/// Finite numbers that mean nothing, and what each message says of them.
#[test]
fn values_that_no_robot_has_are_refused() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let weight = context.weight();
    let cases: [(&str, &str, &[f64], &str); 9] = [
        ("sensor_gain", "-", &[1.0, 0.0], "gain of 0"),
        ("joint_compliance", "knee", &[0.0], "above 0"),
        ("joint_compliance", "knee", &[-5.0], "above 0"),
        ("backlash", "all", &[-0.01], "0 or wider"),
        (
            "payload",
            "shank",
            &[-context.mass(), 0.0, 0.0, 0.0],
            "weighs",
        ),
        ("external_force", "shank", &[0.0, 0.0, weight], "lifts"),
        ("cell_gain", "fsr_1", &[-0.5], "0 or more"),
        ("cell_exponent", "fsr_1", &[0.0], "above 0"),
        ("cell_saturation", "fsr_1", &[0.0], "above 0"),
    ];
    for (effect, target, values, words) in cases {
        let record = Hidden::named(&context, effect, target, values).record(&context);
        generate(
            &stand,
            record,
            true,
            &[&format!("`{effect}`"), target, words],
        );
    }
}

#[test]
fn effects_of_a_log_are_left_out_with_a_note() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let catalog = Catalog::standard();
    let of_log: Vec<&dyn Effect> = catalog.iter().filter(|e| !e.is_static()).collect();
    let names: Vec<&str> = of_log.iter().map(|effect| effect.id().name()).collect();
    let expected = ["sensor_drift", "time_delay"];
    assert_eq!(names, expected);
    let folder = folder();
    let out = folder.path().display().to_string();
    let run = |name: &str, hidden: &[Hidden], language: &str| {
        let text = toml::to_string(&file(&stand, hidden)).unwrap();
        let model = write(folder.path(), "model.toml", text);
        let arguments = [
            "--no-snap",
            "--model",
            &model,
            "--name",
            name,
            "--out",
            &out,
        ];
        let urdf = urdf(stand.name);
        let output = sesc(&[&["generate", &urdf, "--lang", language][..], &arguments].concat());
        stdout(&output);
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(!run("plain", &[], "rust").contains("left out"));
    run("plain", &[], "c");
    let code = |file: &str| {
        let mut text = fs::read_to_string(folder.path().join(file)).unwrap();
        // The hash of header and source, of what is left out, too.
        if let Some((_, rest)) = text.split_once("plain_PAIR_") {
            let pair = rest[..16].to_string();
            text = text.replace(&pair, "");
        }
        let lines = text.lines().filter(|line| !line.contains("left out"));
        lines.map(|line| format!("{line}\n")).collect::<String>()
    };
    let files = ["plain.rs", "plain.h", "plain.c"];
    let plain = files.map(code);
    for effect in of_log {
        let hidden = &Hidden::of(effect, &context, 2)[..1];
        for language in ["rust", "c"] {
            let said = run("plain", hidden, language);
            let note = format!("note: effect `{}` belongs to the log", effect.id().name());
            assert!(said.contains(&note), "{said}");
        }
        // Not a byte of code of it, and the header says so.
        assert_eq!(files.map(code), plain, "{}", effect.id().name());
        for file in files {
            let text = fs::read_to_string(folder.path().join(file)).unwrap();
            let line = format!(
                "left out       {} (only a log shows it)",
                effect.id().name()
            );
            assert!(text.contains(&line), "{file}");
        }
        assert!(with(&stand, hidden).static_effects().next().is_none());
    }
}

#[test]
fn what_fixed_point_cannot_have_is_refused_by_name() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let folder = folder();
    let out = folder.path().join("out");
    for effect in Catalog::standard().iter() {
        let hidden = &Hidden::of(effect, &context, 2)[..1];
        let text = toml::to_string(&file(&stand, hidden)).unwrap();
        let model = write(folder.path(), "model.toml", text);
        let (urdf, out_text) = (urdf(stand.name), out.display().to_string());
        let output = sesc(&in_words(
            "generate @ --no-snap --lang c --scalar fixed32 --model @ --name m --out @",
            &[&urdf, &model, &out_text],
        ));
        let divides = effect.stage() == Stage::Cells;
        match divides {
            true => {
                refused(&output, &["fixed32", "cop", "divi", "f32 or f64"]);
                assert!(!out.exists(), "{}", effect.id().name());
            }
            false => {
                stdout(&output);
                fs::remove_dir_all(&out).unwrap();
            }
        }
    }
}
