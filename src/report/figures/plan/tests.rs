//! Odd plans in: still trees of shapes.

use super::{efficiency, joints};
use crate::report::svg::tests::sound;
use sesc_identify::plan::Efficiency;
use sesc_identify::plan::JointUse;

#[test]
fn figures_of_nothing_and_of_odd_numbers() {
    sound(&joints(&[]));
    let odd = JointUse {
        joint: "<joint> & a name that is too long".to_string(),
        prismatic: true,
        limits: [0.5, 0.5],
        values: vec![0.5, f64::NAN],
        used: [0.5, 0.5],
    };
    let drawn = joints(&[
        JointUse {
            prismatic: false,
            limits: [-0.5, 1.0],
            values: vec![-0.9; 5000],
            used: [-0.9, 0.2],
            ..odd.clone()
        },
        odd,
    ]);
    sound(&drawn);
    for text in ["500 mm", "−29°", "57°"] {
        assert!(drawn.contains(text), "{text}");
    }
    assert!(drawn.matches("<path").count() < 200, "ticks stay apart");

    sound(&efficiency(&[]));
    let point = |postures: usize, planned: f64, random: f64| Efficiency {
        postures,
        planned,
        random,
    };
    sound(&efficiency(&[point(3, 0.001, 0.002)]));
    // What hardly tells all directions leaves the rest readable.
    let drawn = efficiency(&[
        point(3, 0.9, 1e9),
        point(4, 0.002, f64::INFINITY),
        point(5, 0.001, 0.002),
    ]);
    sound(&drawn);
    assert!(drawn.contains("1.00 mm") && drawn.contains("2.00 mm"));
}
