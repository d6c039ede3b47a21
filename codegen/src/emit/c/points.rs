//! Macros of the header that give the binary points of fixed-point numbers.

use serde::Serialize;

use super::exported::Exported;
use sesc_model::bounds;
use sesc_model::expr::Argument;

/// A macro that gives a binary point.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Point {
    name: String,
    of: String,
    bits: i32,
}

/// Fraction bits of a mass, kg.
pub(super) fn mass_bits(mass: f64) -> i32 {
    bounds::fitting(mass)
}

/// Binary points of inputs, results and the mass, each once; none in floats.
pub(super) fn points(routines: &[Exported], mass: f64) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    let mut push = |name: String, of: String, bits: i32| {
        if points.iter().all(|point| point.name != name) {
            points.push(Point { name, of, bits });
        }
    };
    for routine in routines {
        let Some(formats) = &routine.formats else {
            continue;
        };
        for (array, bits) in routine.program.inputs.iter().zip(&formats.arrays) {
            let (name, of) = match array.argument {
                Argument::Reading => ("READING", "readings of the CoP, m or the record's unit"),
                Argument::Positions => ("Q", "joint positions and limits, rad or m"),
                Argument::Velocities => ("QD", "joint velocities, rad/s or m/s"),
                Argument::Accelerations => ("QDD", "joint accelerations, rad/s2 or m/s2"),
                Argument::Parameters => ("R", "parameters, m"),
                Argument::Context => ("CONTEXT", "the context"),
                _ => ("SC", "sines and cosines (m of prismatic joints in sin_q)"),
            };
            push(name.to_string(), of.to_string(), *bits);
        }
        let name = routine.function.name();
        push(
            name.to_uppercase(),
            format!("the results of {name}"),
            formats.output,
        );
    }
    if !points.is_empty() {
        let of = "the total mass, kg".to_string();
        points.push(Point {
            name: "TOTAL_MASS".to_string(),
            of,
            bits: mass_bits(mass),
        });
    }
    points
}
