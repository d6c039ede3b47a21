//! Odd rows in: still trees of shapes.

use super::{bodies, changes, correlation, sole};
use crate::report::svg::tests::sound;
use sesc_identify::fit::residuals::Residual;
use sesc_identify::fit::{BodyLength, ParameterFound};

#[test]
fn figures_of_nothing_and_of_no_numbers() {
    for svg in [bodies(&[]), changes(&[]), correlation(&[])] {
        sound(&svg);
    }
    let body = BodyLength {
        body: "a<b> & a name that is too long".to_string(),
        joint: None,
        cad: f64::NAN,
        identified: 0.1,
        std: Some(f64::INFINITY),
    };
    sound(&bodies(&[body.clone(), BodyLength { std: None, ..body }]));
    let parameter = ParameterFound {
        name: "<x>".to_string(),
        value: 0.1,
        std: Some(0.0),
        cad: 0.0,
        source: "data",
    };
    let mut other = parameter.clone();
    other.std = Some(0.01);
    sound(&changes(&[parameter, other]));
    let rows = [vec![1.0, 0.5], vec![f64::NAN, 1.0], vec![-0.99, 0.2, 1.0]];
    sound(&correlation(&rows));
    let residual = Residual {
        pose: 0,
        support: String::new(),
        measured: [0.0, 0.01],
        cad: [f64::NAN, 0.0],
        q: Vec::new(),
        fitted: [0.0, 0.0],
    };
    for rows in [&[][..], std::slice::from_ref(&residual)] {
        sole(rows).iter().for_each(|svg| drop(sound(svg)));
    }
}

#[test]
fn strong_correlations_are_coloured() {
    let svg = correlation(&[vec![1.0], vec![0.95, 1.0], vec![0.05, -0.5, 1.0]]);
    assert_eq!(svg.matches("fill-opacity=").count(), 2);
}
