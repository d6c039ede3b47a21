//! Constants of the robot: names, limits, mass, parameters.

use serde::Serialize;

use super::points::mass_bits;
use super::routine::{Routine, array_bits};
use super::{Scalar, columns, comment, fixed, float, number, quoted};
use sesc_model::expr::Argument;
use sesc_model::tree::Dof;
use sesc_model::{Model, names};

/// A public constant.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Constant {
    /// What the header says of it.
    brief: String,
    declaration: String,
    /// Values of an array, or the one of a scalar.
    values: Vec<Entry>,
    is_array: bool,
}

#[derive(Debug, Clone, Serialize)]
struct Entry {
    value: String,
    /// Behind the value; empty where there is nothing to say.
    comment: String,
}

/// Names of the enumerators that index joints, in the order of `q`.
pub(super) fn enumerators(model: &Model) -> Vec<String> {
    names::constants(model.tree.dofs.iter().map(|dof| dof.joint.as_str()))
}

/// Every constant, in the order of the header.
pub(super) fn constants(
    model: &Model,
    scalar: Scalar,
    routines: &[Routine],
    name: &str,
) -> Vec<Constant> {
    let mut constants = vec![total_mass(model, scalar, name)];
    if model.dof() > 0 {
        constants.extend(joints(
            model,
            scalar,
            array_bits(routines, Argument::Positions),
            name,
        ));
    }
    constants.extend(parameters(
        model,
        scalar,
        array_bits(routines, Argument::Parameters),
        name,
    ));
    constants
}

/// The binary point that `quantity` has in fixed point, behind a unit.
fn scale(scalar: Scalar, name: &str, quantity: &str) -> String {
    match scalar {
        Scalar::Fixed32 => format!(" / 2^{name}_{quantity}_FRACTION_BITS"),
        _ => String::new(),
    }
}

fn total_mass(model: &Model, scalar: Scalar, name: &str) -> Constant {
    let mass = model.tree.mass;
    let unit = scale(scalar, name, "TOTAL_MASS");
    Constant {
        brief: format!("Total mass, kg{unit}: gravity_moments times this and g are N m."),
        declaration: format!("const {name}_real {name}_total_mass_kg"),
        values: vec![Entry {
            value: number(mass, scalar, mass_bits(mass)),
            comment: String::new(),
        }],
        is_array: false,
    }
}

fn joints(model: &Model, scalar: Scalar, bits: i32, name: &str) -> [Constant; 3] {
    let unit = scale(scalar, name, "Q");
    let limits = |array: &str, which: &str, limit: &dyn Fn(&Dof) -> String| Constant {
        brief: format!("{which} in the unit of q: rad (m for prismatic joints){unit}."),
        declaration: format!("const {name}_real {name}_{array}[{name}_DOF]"),
        values: model
            .tree
            .dofs
            .iter()
            .map(|dof| Entry {
                value: limit(dof),
                comment: match dof.continuous {
                    true => format!("{}, without limits", comment(&dof.joint)),
                    false => comment(&dof.joint),
                },
            })
            .collect(),
        is_array: true,
    };
    let names = model.tree.dofs.iter().map(|dof| dof.joint.as_str());
    [
        strings(
            name,
            "joint_names",
            "DOF",
            "Joints in the order of q.",
            names,
        ),
        limits(
            "joint_lower",
            "Lower ends of the ranges that rounding bounds hold in (the joint limits),",
            &|dof| inward(dof.lower, scalar, bits, true),
        ),
        limits("joint_upper", "Upper ends of these ranges,", &|dof| {
            inward(dof.upper, scalar, bits, false)
        }),
    ]
}

/// A limit as the scalar holds it, rounded into the range where it is rounded.
fn inward(limit: f64, scalar: Scalar, bits: i32, up: bool) -> String {
    match scalar {
        Scalar::F64 => float::literal(limit, scalar),
        Scalar::F32 => {
            let near = limit as f32;
            let held = match up {
                true if f64::from(near) < limit => near.next_up(),
                false if f64::from(near) > limit => near.next_down(),
                _ => near,
            };
            float::literal(f64::from(held), scalar)
        }
        Scalar::Fixed32 => {
            let round = if up { libm::ceil } else { libm::floor };
            fixed::literal(round(libm::ldexp(limit, bits)), 0)
        }
    }
}

fn parameters(model: &Model, scalar: Scalar, bits: i32, name: &str) -> Vec<Constant> {
    let unit = scale(scalar, name, "R");
    let params = &model.base.params;
    let array = |array: &str, brief: String, values: &[f64]| Constant {
        brief,
        declaration: format!("const {name}_real {name}_{array}[{name}_BASE_PARAMS]"),
        values: values
            .iter()
            .zip(params)
            .map(|(value, param)| Entry {
                value: number(*value, scalar, bits),
                comment: comment(&param.name),
            })
            .collect(),
        is_array: true,
    };
    let names = params.iter().map(|param| param.name.as_str());
    let brief = "Base parameters in the order of r: link and axis.";
    let mut constants = vec![
        strings(name, "param_names", "BASE_PARAMS", brief, names),
        array(
            "cad_params",
            format!("Base parameters from CAD, m{unit}."),
            &model.cad_params(),
        ),
        array(
            "param_limits",
            "Largest |r[k]| that ranges and rounding bounds are proven for.".to_string(),
            &model.param_limits,
        ),
    ];
    if let Some(file) = &model.file {
        let brief = format!(
            "Identified base parameters, m{unit}, from a model file (source: {}).",
            comment(&file.source())
        );
        constants.push(array("model_params", brief, &file.values()));
    }
    constants
}

fn strings<'a>(
    name: &str,
    array: &str,
    length: &str,
    brief: &str,
    strings: impl Iterator<Item = &'a str>,
) -> Constant {
    let entry = |text| Entry {
        value: quoted(text),
        comment: String::new(),
    };
    Constant {
        brief: brief.to_string(),
        declaration: format!("const char *const {name}_{array}[{name}_{length}]"),
        values: strings.map(entry).collect(),
        is_array: true,
    }
}

/// `sin(k π / 2048)`, k = 0 … 1024, as many to a line as fit.
pub(super) fn quarter(scalar: Scalar) -> Vec<String> {
    let values: Vec<String> = (0..=1024)
        .map(|k| {
            let sine = match k {
                // sin 30° and sin 90°: exact.
                1024 => 1.0,
                _ => libm::sin(f64::from(k) * std::f64::consts::PI / 2048.0),
            };
            number(sine, scalar, 30)
        })
        .collect();
    columns::filled(&values)
}
