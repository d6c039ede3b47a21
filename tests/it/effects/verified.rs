//! `sesc verify --model`: every function of a model against the virtual robot that has its
//! effects, by the command and by the library.

use std::path::Path;

use sesc::verify::verify;
use sesc_identify::robot::Robot;

use super::compiled::{alone, together};
use super::correction::{file, with};
use super::robots::{Stand, urdf};
use sesc_test_support::command::{Folder, says};

/// The virtual robot takes the effects from the file, the functions have them built in: a model
/// with any effect is verified, and a hundredth more of one of its sizes is not.
#[test]
fn a_model_with_any_effect_is_verified_and_one_with_another_size_is_not() {
    let stand = Stand::new("op2", "r_sole");
    let robot = Robot::read(Path::new(&urdf(stand.name))).unwrap();
    let mut tampered = 0;
    for (name, hidden) in alone(&stand).into_iter().chain(together(&stand)) {
        let mut model = with(&stand, &hidden);
        let found = verify(&robot, &model, 60, 5, &mut ()).unwrap();
        assert!(found.pass && found.samples > 0, "{name}: {found:#?}");
        let has = |name| hidden.iter().any(|h| h.instance.effect.id().name() == name);
        let springs = has("joint_compliance");
        assert!(springs || found.springs_left_out == 0.0, "{name}");
        // One posture shows nothing of drift and delay; and where springs give way beside
        // dead bands, 2 mm are allowed for.
        let mixed = springs && has("backlash");
        if mixed || hidden.iter().any(|h| !h.instance.effect.is_static()) {
            continue;
        }
        let records = &mut model.file.as_mut().unwrap().effects;
        let mut values = records.iter_mut().flat_map(|r| r.parameters.values_mut());
        let Some(value) = values.find(|value| value.value != 0.0) else {
            continue; // a sign or a swap has no size
        };
        value.value *= 1.01;
        tampered += 1;
        let found = verify(&robot, &model, 60, 5, &mut ()).unwrap();
        assert!(!found.pass, "{name}: {found:#?}");
    }
    assert!(tampered > 10, "{tampered}");
}

#[test]
fn the_command_says_what_springs_and_dead_bands_leave_out() {
    let stand = Stand::new("two_link", "foot");
    let hidden = [
        stand.hidden("joint_compliance", "all", &[400.0]),
        stand.hidden("backlash", "knee", &[0.02]),
        stand.hidden("payload", "shank", &[0.4, 0.02, -0.01, 0.05]),
        stand.hidden("ground_slope", "-", &[0.02, 0.01]),
    ];
    let folder = Folder::with("two_link");
    let text = toml::to_string(&file(&stand, &hidden)).unwrap();
    folder.write("model.toml", text);
    let text = folder.stdout("verify two_link.urdf --model model.toml --samples 300");
    let springs = "springs: 4 rounds leave out up to";
    says(
        text,
        &[
            springs,
            "postures left out",
            "com_velocity",
            "m/s",
            "pass on",
        ],
    );
    says(folder.stdout("verify --help"), &["--model model.toml"]);
    // A file that is not there is named.
    folder.refuses("verify two_link.urdf --model gone.toml", &["gone.toml"]);
}
