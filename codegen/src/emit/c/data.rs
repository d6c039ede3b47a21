//! Constants of the robot: names, limits, mass, parameters.

use crate::emit::header::printable;
use serde::Serialize;

use super::exported::{Exported, array_bits};
use super::points::mass_bits;
use super::{Options, Scalar, columns, fixed, float, number, quoted};
use crate::facts::Facts;
use sesc_model::expr::Argument;
use sesc_model::names;
use sesc_model::tree::Dof;

/// A public constant.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Constant {
    /// What the header says of it.
    brief: String,
    declaration: String,
    /// Values of an array, or the one of a scalar, each with what stands behind it.
    values: Vec<(String, String)>,
    is_array: bool,
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
    // The binary point that a quantity has in fixed point, behind its unit.
    let scale = |quantity: &str| match scalar {
        Scalar::Fixed32 => format!(" / 2^{name}_{quantity}_FRACTION_BITS"),
        _ => String::new(),
    };
    let array = |of: &str, stem: &str, length: String, brief: &str, values| Constant {
        brief: brief.to_string(),
        declaration: format!("const {of}{name}_{stem}[{length}]"),
        values,
        is_array: true,
    };
    let strings = |stem: &str, length: &str, brief: &str, texts: Vec<&str>| {
        let values = texts.into_iter().map(|text| (quoted(text), String::new()));
        array(
            "char *const ",
            stem,
            format!("{name}_{length}"),
            brief,
            values.collect(),
        )
    };
    let real = format!("{name}_real ");
    let mut constants = vec![total_mass(facts, scalar, name, &scale("TOTAL_MASS"))];
    if facts.dof() > 0 {
        let joints = facts.dofs.iter().map(|dof| dof.joint.as_str());
        let brief = "Joints in the order of q.";
        constants.push(strings("joint_names", "DOF", brief, joints.collect()));
        let (unit, bits) = (scale("Q"), array_bits(routines, Argument::Positions));
        for (end, title) in ["Lower", "Upper"].into_iter().enumerate() {
            let limit = |dof: &Dof| {
                let without = if dof.continuous {
                    ", without limits"
                } else {
                    ""
                };
                let comment = format!("{}{without}", printable(&dof.joint));
                (inward(dof.limits()[end], end, scalar, bits), comment)
            };
            constants.push(array(
                &real,
                &format!("joint_{}", title.to_lowercase()),
                format!("{name}_DOF"),
                &format!(
                    "{title} joint limits in the unit of q: rad (m for prismatic joints){unit}; {} \
                     where a joint has none.",
                    unlimited(end, scalar)
                ),
                facts.dofs.iter().map(limit).collect(),
            ));
        }
    }
    if !facts.context.is_empty() {
        let variables = facts.context.iter().map(|(variable, _)| variable.as_str());
        let brief = "What effects depend on beside q: time (s), side of approach (-1 to 1), columns of a log.";
        constants.push(strings(
            "context_names",
            "CONTEXT",
            brief,
            variables.collect(),
        ));
    }
    let names = facts.param_names();
    let brief = "Base parameters in the order of r: link and axis.";
    constants.push(strings("param_names", "BASE_PARAMS", brief, names.clone()));
    let (unit, bits) = (scale("R"), array_bits(routines, Argument::Parameters));
    let by_param = |stem: &str, brief: &str, values: &[f64]| {
        let values = values
            .iter()
            .map(|x| number(*x, scalar, bits))
            .zip(names.iter().map(|name| printable(name)));
        array(
            &real,
            stem,
            format!("{name}_BASE_PARAMS"),
            brief,
            values.collect(),
        )
    };
    let cad = format!("Base parameters from CAD, m{unit}.");
    constants.push(by_param("cad_params", &cad, &facts.model.cad_params()));
    let brief = "Largest |r[k]| that ranges and rounding bounds are proven for.";
    constants.push(by_param("param_limits", brief, &facts.model.param_limits));
    let Some(identified) = &facts.identified else {
        return constants;
    };
    let brief = format!(
        "Identified base parameters, m{unit}, from a model file (source: {}).",
        printable(&identified.source)
    );
    constants.push(by_param("model_params", &brief, &identified.values));
    if let Some(factor) = identified
        .information
        .as_ref()
        .filter(|_| options.estimator)
    {
        // A parameter's name where its row of the packed triangle begins.
        let comments = names.iter().enumerate().flat_map(|(i, name)| {
            let others = names.len() - i - 1;
            std::iter::once(printable(name)).chain(std::iter::repeat_n(String::new(), others))
        });
        let values = factor.iter().map(|x| number(*x, scalar, 0)).zip(comments);
        let brief = "How well they are known together: R with R'R their inverse covariance, row by row \
                     from the diagonal on, 1/m.";
        let length = factor.len().to_string();
        constants.push(array(
            &real,
            "model_information",
            length,
            brief,
            values.collect(),
        ));
    }
    constants
}

fn total_mass(facts: &Facts, scalar: Scalar, name: &str, scale: &str) -> Constant {
    let mass = facts.model.total_mass_kg();
    let bits = mass_bits(mass);
    let comment = match scalar {
        Scalar::Fixed32 => format!("{mass:?} kg, {bits} bits below the point"),
        Scalar::F64 | Scalar::F32 => String::new(),
    };
    Constant {
        brief: format!(
            "Total mass, kg{scale}: gravity_moments times this and g are N m; a motor applies the opposite."
        ),
        declaration: format!("const {name}_real {name}_total_mass_kg"),
        values: vec![(number(mass, scalar, bits), comment)],
        is_array: false,
    }
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
