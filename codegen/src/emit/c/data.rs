//! Constants of the robot: names, limits, mass, parameters.

use crate::emit::header::printable;
use serde::Serialize;

use super::exported::{Exported, array_bits};
use super::points::mass_bits;
use super::{Options, Scalar, columns, fixed, float, number, quoted};
use crate::facts::Facts;
use sesc_model::expr::Argument;
use sesc_model::names;

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
pub(super) fn enumerators(facts: &Facts) -> Vec<String> {
    names::constants(facts.dofs.iter().map(|dof| dof.joint.as_str()))
}

/// Every constant, in the order of the header.
pub(super) fn constants(
    facts: &Facts,
    options: &Options,
    routines: &[Exported],
    name: &str,
) -> Vec<Constant> {
    let scalar = options.scalar;
    let mut constants = vec![total_mass(facts, scalar, name)];
    if facts.dof() > 0 {
        constants.extend(joints(
            facts,
            scalar,
            array_bits(routines, Argument::Positions),
            name,
        ));
    }
    if !facts.context.is_empty() {
        constants.push(strings(
            name,
            "context_names",
            "CONTEXT",
            "What effects depend on beside q: time (s), side of approach (-1 to 1), columns of a log.",
            facts.context.iter().map(|(variable, _)| variable.as_str()),
        ));
    }
    constants.extend(parameters(
        facts,
        scalar,
        array_bits(routines, Argument::Parameters),
        name,
    ));
    let information = facts
        .identified
        .as_ref()
        .and_then(|found| found.information.as_ref());
    constants.extend(
        information
            .filter(|_| options.estimator)
            .map(|factor| information_factor(facts, factor, scalar, name)),
    );
    constants
}

/// How well the identified parameters are known: the packed triangle, a parameter's name where
/// its row begins.
fn information_factor(facts: &Facts, factor: &[f64], scalar: Scalar, name: &str) -> Constant {
    let rows = facts.params.iter().enumerate().flat_map(|(i, param)| {
        let others = facts.params.len() - i - 1;
        std::iter::once(printable(param.name)).chain(std::iter::repeat_n(String::new(), others))
    });
    let values: Vec<Entry> = (factor.iter().zip(rows))
        .map(|(value, comment)| Entry {
            value: number(*value, scalar, 0),
            comment,
        })
        .collect();
    Constant {
        brief: "How well they are known together: R with R'R their inverse covariance, row by row \
                from the diagonal on, 1/m."
            .to_string(),
        declaration: format!(
            "const {name}_real {name}_model_information[{}]",
            values.len()
        ),
        values,
        is_array: true,
    }
}

/// The binary point that `quantity` has in fixed point, behind a unit.
fn scale(scalar: Scalar, name: &str, quantity: &str) -> String {
    match scalar {
        Scalar::Fixed32 => format!(" / 2^{name}_{quantity}_FRACTION_BITS"),
        _ => String::new(),
    }
}

fn total_mass(facts: &Facts, scalar: Scalar, name: &str) -> Constant {
    let mass = facts.total_mass_kg;
    let unit = scale(scalar, name, "TOTAL_MASS");
    let bits = mass_bits(mass);
    Constant {
        brief: format!(
            "Total mass, kg{unit}: gravity_moments times this and g are N m; a motor applies the opposite."
        ),
        declaration: format!("const {name}_real {name}_total_mass_kg"),
        values: vec![Entry {
            value: number(mass, scalar, bits),
            comment: match scalar {
                Scalar::Fixed32 => format!("{mass:?} kg, {bits} bits below the point"),
                Scalar::F64 | Scalar::F32 => String::new(),
            },
        }],
        is_array: false,
    }
}

fn joints(facts: &Facts, scalar: Scalar, bits: i32, name: &str) -> [Constant; 3] {
    let unit = scale(scalar, name, "Q");
    let ends = ["lower", "upper"];
    let limits = |end: usize| Constant {
        brief: format!(
            "{} joint limits in the unit of q: rad (m for prismatic joints){unit}; {} where a joint has none.",
            ["Lower", "Upper"][end],
            unlimited(end, scalar)
        ),
        declaration: format!("const {name}_real {name}_joint_{}[{name}_DOF]", ends[end]),
        values: facts
            .dofs
            .iter()
            .map(|dof| Entry {
                value: inward(dof.limits()[end], end, scalar, bits),
                comment: match dof.continuous {
                    true => format!("{}, without limits", printable(&dof.joint)),
                    false => printable(&dof.joint),
                },
            })
            .collect(),
        is_array: true,
    };
    let names = facts.dofs.iter().map(|dof| dof.joint.as_str());
    [
        strings(
            name,
            "joint_names",
            "DOF",
            "Joints in the order of q.",
            names,
        ),
        limits(0),
        limits(1),
    ]
}

/// The lower or upper limit of a joint that has none.
fn unlimited(end: usize, scalar: Scalar) -> &'static str {
    match (scalar, end) {
        (Scalar::Fixed32, 0) => "INT32_MIN",
        (Scalar::Fixed32, _) => "INT32_MAX",
        (_, 0) => "-INFINITY",
        (_, _) => "INFINITY",
    }
}

/// Whether values need `<math.h>`, for its constant alone.
pub(super) fn has_infinity(facts: &Facts, options: &Options) -> bool {
    let unlimited = facts.dofs.iter().any(|dof| dof.continuous);
    options.scalar != Scalar::Fixed32 && (unlimited || options.estimator)
}

/// A limit as the scalar holds it, rounded into the range where it is rounded.
fn inward(limit: f64, end: usize, scalar: Scalar, bits: i32) -> String {
    let endless = unlimited(end, scalar);
    match scalar {
        // The macro is a float: widened in so many words.
        Scalar::F64 if limit.is_infinite() => endless.replace("INF", "(double)INF"),
        _ if limit.is_infinite() => endless.to_string(),
        Scalar::F64 => float::literal(limit, scalar),
        Scalar::F32 => {
            let near = limit as f32;
            let held = match end {
                0 if f64::from(near) < limit => near.next_up(),
                1 if f64::from(near) > limit => near.next_down(),
                _ => near,
            };
            float::literal(f64::from(held), scalar)
        }
        Scalar::Fixed32 => {
            let round = [libm::ceil, libm::floor][end];
            fixed::literal(round(libm::ldexp(limit, bits)), 0)
        }
    }
}

fn parameters(facts: &Facts, scalar: Scalar, bits: i32, name: &str) -> Vec<Constant> {
    let unit = scale(scalar, name, "R");
    let array = |array: &str, brief: String, values: &[f64]| Constant {
        brief,
        declaration: format!("const {name}_real {name}_{array}[{name}_BASE_PARAMS]"),
        values: values
            .iter()
            .zip(&facts.params)
            .map(|(value, param)| Entry {
                value: number(*value, scalar, bits),
                comment: printable(param.name),
            })
            .collect(),
        is_array: true,
    };
    let names = facts.params.iter().map(|param| param.name);
    let brief = "Base parameters in the order of r: link and axis.";
    let mut constants = vec![
        strings(name, "param_names", "BASE_PARAMS", brief, names),
        array(
            "cad_params",
            format!("Base parameters from CAD, m{unit}."),
            &facts.cad_params(),
        ),
        array(
            "param_limits",
            "Largest |r[k]| that ranges and rounding bounds are proven for.".to_string(),
            &facts
                .params
                .iter()
                .map(|param| param.limit)
                .collect::<Vec<_>>(),
        ),
    ];
    if let Some(identified) = &facts.identified {
        let brief = format!(
            "Identified base parameters, m{unit}, from a model file (source: {}).",
            printable(&identified.source)
        );
        constants.push(array("model_params", brief, &identified.values));
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
