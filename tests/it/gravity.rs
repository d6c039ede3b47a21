//! Which sign `gravity_moments` have: of generated code by closed forms, and in words.

use std::fs;

use sesc_generated::two_link_foot as two_link;
use sesc_test_support::command::ROOT;

const G: f64 = 9.80665;

/// A shank (3 kg, its CoM 0.2 m above the ankle) and a thigh (5 kg, 0.2 m above a knee that is
/// 0.4 m above the ankle): what two motors have to apply, N m.
#[test]
fn motors_that_hold_two_links_apply_minus_mass_times_g_times_the_moments() {
    for q in [[0.3, -0.1], [-0.4, -1.2], [0.5, 0.0]] {
        let (ankle, knee) = (q[0], q[0] + q[1]);
        // U = g Σ m z; a motor does the work dU.
        let of_thigh = -G * 5.0 * 0.2 * f64::sin(knee);
        let of_ankle = -G * (3.0 * 0.2 + 5.0 * 0.4) * f64::sin(ankle) + of_thigh;
        let moments = two_link::gravity_moments(&q, &two_link::CAD_PARAMS);
        let applied = moments.map(|moment| -two_link::TOTAL_MASS_KG * G * moment);
        for (applied, expected) in applied.iter().zip([of_ankle, of_thigh]) {
            assert!((applied - expected).abs() < 1e-12, "{q:?}: {applied} N m");
        }
    }
    // Leaning forward, gravity turns the ankle further forward.
    assert!(two_link::gravity_moments(&[0.3, -0.1], &two_link::CAD_PARAMS)[0] > 0.0);
}

#[test]
fn every_page_says_in_the_same_words_what_gravity_exerts_and_a_motor_applies() {
    for file in [
        "README.md",
        "docs/controller.md",
        "docs/firmware.md",
        "docs/glossary.md",
        "docs/limits.md",
        "docs/model-functions.md",
        "docs/python.md",
        "examples/controller/src/main.rs",
        "generated/c/op2_r_sole.h",
        "generated/src/op2_r_sole.rs",
        "python/sesc/_sesc.pyi",
        "python/src/model.rs",
        "runtime/src/model.rs",
    ] {
        let text = fs::read_to_string(format!("{ROOT}/{file}")).unwrap();
        let words: Vec<&str> = text.split_whitespace().collect();
        let marks = ["*", "///", "//", "#"];
        let words: Vec<&str> = words.into_iter().filter(|w| !marks.contains(w)).collect();
        let text = words.join(" ").to_lowercase();
        for said in [
            "the moment that gravity exerts",
            "a motor that holds the posture applies the opposite",
        ] {
            assert!(text.contains(said), "{file} does not say: {said}");
        }
    }
}
