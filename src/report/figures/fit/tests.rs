//! Odd rows in: still trees of shapes.

use super::{bodies, changes, correlation, sole};
use sesc_identify::fit::identification::{BodyLength, ParameterFound};
use sesc_identify::fit::residuals::Residual;

fn well_formed(svg: &str) -> roxmltree::Document<'_> {
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    roxmltree::Document::parse(svg).expect("a figure is well-formed")
}

#[test]
fn figures_of_nothing_and_of_no_numbers() {
    for svg in [bodies(&[]), changes(&[]), correlation(&[]), sole(&[], true)] {
        well_formed(&svg);
    }
    let body = BodyLength {
        body: "a<b> & a name that is too long".to_string(),
        joint: None,
        cad: f64::NAN,
        identified: 0.1,
        std: Some(f64::INFINITY),
    };
    well_formed(&bodies(&[body.clone(), BodyLength { std: None, ..body }]));
    let parameter = ParameterFound {
        name: "<x>".to_string(),
        value: 0.1,
        std: Some(0.0),
        cad: 0.0,
        source: "data",
    };
    well_formed(&changes(&[
        parameter.clone(),
        ParameterFound {
            std: Some(0.01),
            ..parameter
        },
    ]));
    well_formed(&correlation(&[
        vec![1.0, 0.5],
        vec![f64::NAN, 1.0],
        vec![-0.99, 0.2, 1.0],
    ]));
    let residual = Residual {
        pose: 0,
        support: String::new(),
        measured: [0.0, 0.01],
        cad: [f64::NAN, 0.0],
        fitted: [0.0, 0.0],
    };
    well_formed(&sole(std::slice::from_ref(&residual), true));
}

#[test]
fn strong_correlations_are_coloured() {
    let svg = correlation(&[vec![1.0], vec![0.95, 1.0], vec![0.05, -0.5, 1.0]]);
    let tree = well_formed(&svg);
    let squares = tree
        .descendants()
        .filter(|node| node.attribute("opacity").is_some());
    let strong = squares
        .filter(|node| node.attribute("opacity") != Some("1"))
        .count();
    assert_eq!(strong, 2);
}
