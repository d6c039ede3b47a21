//! Effects in model files: there and back, and every way to get one wrong.

use sesc_model::effects::{self, Catalog, Effect, Stage};
use sesc_model::{EffectRecord, ModelFile, Quantity};

use super::correction::{file, with};
use super::hidden::Hidden;
use super::robots::Stand;
use sesc_test_support::command::{Folder, says};

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

/// What `sesc generate` says of a model file with this record.
fn generate(stand: &Stand, record: EffectRecord, cells: bool, words: &[&str]) {
    let mut model = file(stand, &[]);
    if !cells {
        model.cells.clear();
    }
    model.effects.push(record);
    let folder = Folder::with("two_link");
    folder.write("model.toml", toml::to_string(&model).unwrap());
    let line = "generate two_link.urdf --no-snap --model model.toml --name m --out out";
    folder.refuses(line, &[&["model.toml"], words].concat());
    assert!(!folder.join("out").exists(), "nothing is written");
}

#[test]
fn faults_of_records_name_the_effect_and_the_remedy() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let unknown = EffectRecord {
        effect: "warp".into(),
        target: "-".into(),
        ..EffectRecord::default()
    };
    let words = ["`warp`", "known are sensor_offset", "units"];
    generate(&stand, unknown, true, &words);
    for effect in Catalog::standard().iter() {
        let name = format!("`{}`", effect.id().name());
        let good = Hidden::of(effect, &context, 2)[0].record(&context);
        let nowhere = EffectRecord {
            target: "nowhere".into(),
            ..good.clone()
        };
        let offered = context.name_of(&effect.targets(&context)[0]);
        let words = [&name, "`nowhere`", "it has", &offered];
        generate(&stand, nowhere, true, &words);
        let mut stray = good.clone();
        let (value, std) = (1.0, None);
        stray
            .parameters
            .insert("colour".into(), Quantity { value, std });
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
                let words = [&name, key, "not finite", "give a number"];
                generate(&stand, bad, true, &words);
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
    let (weight, load) = (context.weight(), [-context.mass(), 0.0, 0.0, 0.0]);
    let cases: [(&str, &str, &[f64], &str); 9] = [
        ("sensor_gain", "-", &[1.0, 0.0], "gain of 0"),
        ("joint_compliance", "knee", &[0.0], "above 0"),
        ("joint_compliance", "knee", &[-5.0], "above 0"),
        ("backlash", "all", &[-0.01], "0 or wider"),
        ("payload", "shank", &load, "weighs"),
        ("external_force", "shank", &[0.0, 0.0, weight], "lifts"),
        ("cell_gain", "fsr_1", &[-0.5], "0 or more"),
        ("cell_exponent", "fsr_1", &[0.0], "above 0"),
        ("cell_saturation", "fsr_1", &[0.0], "above 0"),
    ];
    for (effect, target, values, words) in cases {
        let record = stand.hidden(effect, target, values).record(&context);
        let effect = format!("`{effect}`");
        generate(&stand, record, true, &[&effect, target, words]);
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
    let folder = Folder::with("two_link");
    let run = |hidden: &[Hidden], language: &str| {
        let text = toml::to_string(&file(&stand, hidden)).unwrap();
        folder.write("model.toml", text);
        let options = "--no-snap --model model.toml --name plain --out .";
        folder.said(&format!(
            "generate two_link.urdf --lang {language} {options}"
        ))
    };
    assert!(!run(&[], "rust").contains("left out"));
    run(&[], "c");
    let code = |file: &str| {
        let mut text = folder.read(file);
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
            let note = format!("note: effect `{}` belongs to the log", effect.id().name());
            says(run(hidden, language), &[&note]);
        }
        // Not a byte of code of it, and the header says so.
        assert_eq!(files.map(code), plain, "{}", effect.id().name());
        for file in files {
            let name = effect.id().name();
            let line = format!("left out       {name} (only a log shows it)");
            says(folder.read(file), &[&line]);
        }
        assert!(with(&stand, hidden).static_effects().next().is_none());
    }
}

#[test]
fn what_fixed_point_cannot_have_is_refused_by_name() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    for effect in Catalog::standard().iter() {
        let hidden = &Hidden::of(effect, &context, 2)[..1];
        let folder = Folder::with("two_link");
        let text = toml::to_string(&file(&stand, hidden)).unwrap();
        folder.write("model.toml", text);
        let fixed = "--no-snap --lang c --scalar fixed32 --model model.toml --name m --out out";
        let line = format!("generate two_link.urdf {fixed}");
        if effect.stage() == Stage::Cells {
            folder.refuses(&line, &["fixed32", "cop", "divi", "f32 or f64"]);
            assert!(!folder.join("out").exists(), "{}", effect.id().name());
        } else {
            folder.stdout(&line);
        }
    }
}
