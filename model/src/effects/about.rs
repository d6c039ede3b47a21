//! What there is to know of an effect without a robot: its name, what it acts on, its
//! parameters, its page.

use std::fmt;

use serde::{Serialize, Serializer};

use super::{Catalog, Effect, EffectContext, Target};
use crate::robot::Robot;
use crate::snap::Snapping;
use crate::urdf;

/// One effect, as `sesc effects` lists it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectAbout {
    /// Name in reports and model files: `joint_offset`.
    pub name: &'static str,
    /// What it acts on.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub target: TargetKind,
    /// Its parameters; of a joint those of revolute and of prismatic ones.
    pub parameters: Vec<ParameterAbout>,
    /// What it is, in a sentence.
    pub sentence: &'static str,
    /// Sentence, equation, imitators; Markdown.
    pub page: &'static str,
}

/// What an effect acts on; shown and serialised in a few words.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum TargetKind {
    /// The whole robot or its sensor: `-`.
    Whole,
    /// `joint`.
    Joint,
    /// All revolute joints alike: `all`.
    AllJoints,
    /// `joint or all`.
    JointOrAll,
    /// `two joints`.
    TwoJoints,
    /// `link`.
    Link,
    /// `cell`.
    Cell,
    /// One of a few ways, by name.
    Ways(Vec<&'static str>),
}

impl fmt::Display for TargetKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            TargetKind::Whole => "-",
            TargetKind::Joint => "joint",
            TargetKind::AllJoints => Target::ALL_JOINTS,
            TargetKind::JointOrAll => "joint or all",
            TargetKind::TwoJoints => "two joints",
            TargetKind::Link => "link",
            TargetKind::Cell => "cell",
            TargetKind::Ways(names) => return f.write_str(&names.join(", ")),
        })
    }
}

impl Serialize for TargetKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ParameterAbout {
    /// With its unit at the end: `offset_rad`.
    pub name: &'static str,
    /// `rad`, `m`, `kg`, `N`, `s`, `Nm/rad`; `1` where it has none.
    pub unit: &'static str,
}

/// A robot with a joint of each kind, for what depends on the kind.
const EXAMPLE: &str = "<robot name='example'>\
    <link name='foot'/>\
    <link name='shank'><inertial><mass value='1'/></inertial></link>\
    <link name='thigh'><inertial><mass value='1'/></inertial></link>\
    <link name='trunk'><inertial><mass value='1'/></inertial></link>\
    <joint name='ankle' type='revolute'><parent link='foot'/><child link='shank'/>\
    <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    <joint name='knee' type='revolute'><parent link='shank'/><child link='thigh'/>\
    <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    <joint name='lift' type='prismatic'><parent link='thigh'/><child link='trunk'/>\
    <axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint></robot>";
/// Its cells, m.
const CELLS: [[f64; 2]; 4] = [[0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [-0.1, 0.05]];

/// Site and function of an effect of the standard list, by its name.
pub fn form(name: &str) -> (&'static str, &'static str) {
    match name {
        "joint_offset" => ("joint", "offset"),
        "joint_scale" => ("joint", "(scale - 1.0) * q"),
        "joint_sign" => ("joint", "-2.0 * q"),
        "joint_swap" => ("joint", "q[\"other\"] - q"),
        "joint_compliance" => ("joint", "tau / stiffness"),
        "backlash" => ("joint", "0.5 * width * sign(tau)"),
        "sensor_offset" => ("sensor", "offset"),
        "sensor_gain" => ("sensor", "(gain - 1.0) * x"),
        "sensor_rotation" => ("sensor", "angle * y"),
        "sensor_drift" => ("sensor", "drift * t"),
        "ground_slope" => ("ground", "slope"),
        "payload" => ("load", "mass"),
        "external_force" => ("load", "force"),
        "cell_gain" => ("cell", "(gain - 1.0) * load"),
        "cell_offset" => ("cell", "offset"),
        "cell_exponent" => ("cell", "pow(load, exponent) - load"),
        "cell_saturation" => ("cell", "min(load, limit) - load"),
        "mass_distribution" => ("load", "masses"),
        "time_delay" => ("record", "q(t + delay) - q"),
        "units" => ("record", "unit"),
        _ => ("record", "reading"),
    }
}

/// All effects of `catalog`, in its order.
pub fn about(catalog: &Catalog) -> Vec<EffectAbout> {
    let robot = urdf::parse(EXAMPLE, "example.urdf")
        .ok()
        .and_then(|read| Robot::new(&read, "foot", Snapping::default()).ok())
        .expect("the example is a robot");
    let context = EffectContext::new(&robot, &CELLS, true, catalog.clone());
    catalog.iter().map(|effect| one(effect, &context)).collect()
}

/// The subject of a sentence about an effect that a file names, with that name beside it: `an
/// offset of l_knee (joint_offset:l_knee)`; the name alone of an effect that is not known.
#[doc(hidden)]
pub fn subject(effect: &str, target: &str) -> String {
    let label = match target {
        "-" => effect.to_string(),
        target => format!("{effect}:{target}"),
    };
    let catalog = Catalog::standard();
    let own = catalog.iter().find(|known| known.id().name() == effect);
    let Some(own) = own else {
        return label;
    };
    let ways = about(&catalog)
        .into_iter()
        .find(|known| known.name == effect);
    let way = match ways.map(|known| known.target) {
        Some(TargetKind::Ways(names)) => names.into_iter().find(|name| *name == target),
        _ => None,
    };
    let name = match target {
        Target::ALL_JOINTS => "every joint",
        target => target,
    };
    let phrase = own.phrase(&way.map_or(Target::Whole, Target::Way), name);
    format!("{phrase} ({label})")
}

fn one(effect: &dyn Effect, context: &EffectContext) -> EffectAbout {
    let targets = effect.targets(context);
    let mut parameters: Vec<ParameterAbout> = Vec::new();
    for target in &targets {
        for parameter in effect.parameters(context, target) {
            if parameters.iter().all(|known| known.name != parameter.name) {
                parameters.push(ParameterAbout {
                    name: parameter.name,
                    unit: parameter.unit.symbol(),
                });
            }
        }
    }
    let page = effect.page();
    EffectAbout {
        name: effect.id().name(),
        target: kind(&targets),
        parameters,
        sentence: page.lines().next().unwrap_or_default(),
        page,
    }
}

/// What all of these are.
fn kind(targets: &[Target]) -> TargetKind {
    let ways: Vec<&str> = targets
        .iter()
        .filter_map(|target| match target {
            Target::Way(name) => Some(*name),
            _ => None,
        })
        .collect();
    let has = |wanted: fn(&Target) -> bool| targets.iter().any(wanted);
    let joint = has(|t| matches!(t, Target::Joint(_)));
    let all = has(|t| matches!(t, Target::AllJoints));
    match (joint, all) {
        (true, true) => TargetKind::JointOrAll,
        (true, false) => TargetKind::Joint,
        (false, true) => TargetKind::AllJoints,
        _ if has(|t| matches!(t, Target::Joints(..))) => TargetKind::TwoJoints,
        _ if has(|t| matches!(t, Target::Link(_))) => TargetKind::Link,
        _ if has(|t| matches!(t, Target::Cell(_))) => TargetKind::Cell,
        _ if !ways.is_empty() => TargetKind::Ways(ways),
        _ => TargetKind::Whole,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_a_sentence_an_equation_and_units() {
        let all = about(&Catalog::standard());
        assert_eq!(all.len(), Catalog::standard().iter().len());
        for effect in &all {
            assert!(effect.sentence.ends_with('.'), "{}", effect.name);
            assert!(effect.sentence.len() < 90, "{}", effect.name);
            assert!(effect.page.contains("```text\n"), "{}", effect.name);
        }
        let named = |name: &str| all.iter().find(|effect| effect.name == name).unwrap();
        let parameters = |name: &str| -> Vec<(&str, &str)> {
            let parameters = named(name).parameters.iter();
            parameters.map(|p| (p.name, p.unit)).collect()
        };
        let both = [("offset_rad", "rad"), ("offset_m", "m")];
        assert_eq!(parameters("joint_offset"), both);
        assert_eq!(parameters("joint_sign"), []);
        assert_eq!(parameters("payload")[0], ("mass_kg", "kg"));
        for (name, target) in [
            ("joint_offset", "joint"),
            ("backlash", "joint or all"),
            ("joint_swap", "two joints"),
            ("payload", "link"),
            ("cell_gain", "cell"),
            ("sensor_offset", "-"),
            (
                "units",
                "degrees, millimetres, centimetres, inches, kilograms_force, pounds_force",
            ),
        ] {
            assert_eq!(named(name).target.to_string(), target);
        }
    }

    #[test]
    fn an_effect_of_a_file_is_said_in_words_with_its_name() {
        for (label, said) in [
            ("joint_offset:l_knee", "an offset of l_knee"),
            ("backlash:all", "backlash in every joint"),
            ("sensor_axes:flip_x", "a flipped x axis of the sensor"),
            (
                "joint_swap:l_el,r_el",
                "encoders of l_el and r_el plugged into each other's channel",
            ),
        ] {
            let (effect, target) = label.split_once(':').unwrap();
            assert_eq!(subject(effect, target), format!("{said} ({label})"));
        }
        let slope = "a slope of the ground (ground_slope)";
        assert_eq!(subject("ground_slope", "-"), slope);
        assert_eq!(subject("of_tomorrow", "l_knee"), "of_tomorrow:l_knee");
    }
}
