//! Effects that a simulated robot has: `joint_offset:r_knee=1.5deg`.
//!
//! ```text
//! EFFECT[:TARGET][=VALUE[UNIT][,VALUE[UNIT]…]]      values in the order of its parameters
//! ```
//!
//! A number without its unit that was hardly meant in rad, m or kg is refused.

use std::collections::BTreeMap;

use sesc_model::effects::{Catalog, EffectContext, Parameter, Unit};
use sesc_model::{EffectRecord, Model, ModelFile, Quantity};

use crate::Error;

/// An angle (rad) and a length (m) that are given without their unit are no larger.
const ANGLE_RAD: f64 = 0.6;
const LENGTH_M: f64 = 1.0;
/// A mass that is given without its unit is no larger a part of what the robot weighs.
const PART: f64 = 3.0;

/// The model with effects hidden in it, in the words of the module's head.
///
/// ```
/// use sesc_identify::hide::hide;
/// use sesc_identify::robot::Robot;
/// use sesc_identify::stance::Stance;
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <mass value='2'/></inertial></link><joint name='hip' type='revolute'>\
/// #   <parent link='foot'/><child link='top'/><origin xyz='0 0 1'/><axis xyz='0 1 0'/>\
/// #   <limit lower='-1' upper='1'/></joint></robot>";
/// let model = Stance::new(Robot::parse(urdf, "pole.urdf")?).on("foot").model()?;
/// let hidden = hide(model, &["joint_offset:hip=1.5deg", "sensor_offset=3mm,0"])?;
/// assert_eq!(hidden.effects.len(), 2);
/// assert!((hidden.effects[0].1[0] - 1.5_f64.to_radians()).abs() < 1e-15);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// An effect, target, value or unit that is none, in a sentence with the remedy.
pub fn hide<S: AsRef<str>>(model: Model, effects: &[S]) -> Result<Model, Error> {
    if effects.is_empty() {
        return Ok(model);
    }
    let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
    let context = EffectContext::new(&model, cells, false, Catalog::standard());
    let robot_kg = model.tree.mass;
    let records = effects.iter();
    let records = records.map(|text| record(&context, robot_kg, text.as_ref()));
    let records: Vec<EffectRecord> = records.collect::<Result<_, _>>()?;
    let mut file = match &model.file {
        Some(file) => file.clone(),
        None => ModelFile::from_values(&model, &model.params(), None, "cad"),
    };
    // Messages about them begin so.
    file.file = "hidden effects".to_string();
    file.effects.extend(records);
    // No file says them.
    let hidden = model.clone().with_file(file);
    hidden.map_err(|error| Error::request(error.to_string()))
}

/// One effect as a model file has it.
fn record(context: &EffectContext, robot_kg: f64, text: &str) -> Result<EffectRecord, Error> {
    let bad = |reason: String| Error::request(format!("`{text}`: {reason}"));
    let (name, values) = match text.rsplit_once('=') {
        Some((name, values)) => (name, Some(values)),
        None => (text, None),
    };
    let (effect, target) = name.split_once(':').unwrap_or((name, "-"));
    let record = EffectRecord {
        effect: effect.to_string(),
        target: target.to_string(),
        parameters: BTreeMap::new(),
    };
    // What is wrong with the name or the target, the model file will say.
    let known = context.catalog.named(effect);
    if let Some(effect) = known
        && effect.targets(context).is_empty()
    {
        let mut moving = context.clone();
        moving.times = true;
        return Err(bad(match effect.targets(&moving).is_empty() {
            true => {
                "acts on the cells of a foot, and this robot has none; give a model file \
                     with `cells`, or take another effect"
            }
            false => {
                "acts on joint angles over time, which are logged as they are; to try it, \
                      shift the joint columns of a log against its readings"
            }
        }
        .to_string()));
    }
    let target = known.and_then(|effect| context.target_named(effect, target));
    let (Some(effect), Some(target)) = (known, target) else {
        return Ok(record);
    };
    let parameters = effect.parameters(context, &target);
    let values: Vec<&str> = values.map_or_else(Vec::new, |values| values.split(',').collect());
    if values.len() != parameters.len() {
        let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
        return Err(bad(match names.is_empty() {
            true => "takes no value; leave out what follows `=`".to_string(),
            false => format!(
                "has {} values where {} are wanted: {}",
                values.len(),
                names.len(),
                names.join(", ")
            ),
        }));
    }
    let mut record = record;
    for (parameter, value) in parameters.iter().zip(values) {
        let value = quantity(parameter, robot_kg, value.trim()).map_err(bad)?;
        let value = Quantity { value, std: None };
        record.parameters.insert(parameter.name.to_string(), value);
    }
    Ok(record)
}

/// `1.5deg` of a parameter in radians.
fn quantity(parameter: &Parameter, robot_kg: f64, text: &str) -> Result<f64, String> {
    let units = parameter.unit.spellings();
    let unit = units.iter().find(|(unit, _)| text.ends_with(unit));
    let (number, factor) = match unit {
        Some((unit, factor)) => (&text[..text.len() - unit.len()], *factor),
        None => (text, 1.0),
    };
    let value = number.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let value = value.ok_or_else(|| {
        let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
        format!(
            "`{text}` is no value of {}; give a number, with one of the units {} or none",
            parameter.name,
            names.join(", ")
        )
    })?;
    let bound = match parameter.unit {
        Unit::Radian => Some((
            ANGLE_RAD,
            "deg",
            "rad",
            format!("{:.0}°", value.to_degrees()),
        )),
        Unit::Metre => Some((LENGTH_M, "mm", "m", format!("{} mm", 1e3 * value))),
        Unit::Kilogram => {
            let shown = format!("the robot weighs {robot_kg:.3} kg");
            Some((PART * robot_kg, "g", "kg", shown))
        }
        _ => None,
    };
    match bound.filter(|(most, ..)| unit.is_none() && value.abs() > *most) {
        Some((_, meant, own, shown)) => Err(format!(
            "{text} of {} is {text} {own} ({shown}); give its unit: {text}{meant}, or {text}{own} \
             if that is meant",
            parameter.name
        )),
        None => Ok(factor * value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use crate::stance::Stance;

    fn model() -> Model {
        let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
            <mass value='2'/></inertial></link><link name='bob'><inertial><mass value='1'/>\
            </inertial></link><joint name='hip' type='revolute'><parent link='foot'/>\
            <child link='top'/><origin xyz='0 0 1'/><axis xyz='0 1 0'/>\
            <limit lower='-1' upper='1'/></joint><joint name='lift' type='prismatic'>\
            <parent link='top'/><child link='bob'/><axis xyz='0 0 1'/>\
            <limit lower='0' upper='1'/></joint></robot>";
        let robot = Robot::parse(urdf, "pole.urdf").unwrap();
        Stance::new(robot).on("foot").model().unwrap()
    }

    fn values(text: &str) -> BTreeMap<String, f64> {
        let hidden = hide(model(), &[text]).unwrap();
        let record = &hidden.file.as_ref().unwrap().effects[0];
        let parameters = record.parameters.iter();
        parameters
            .map(|(name, x)| (name.clone(), x.value))
            .collect()
    }

    #[test]
    fn values_are_taken_with_their_units() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        let quarter = values("joint_offset:hip=90deg")["offset_rad"];
        near(quarter, std::f64::consts::FRAC_PI_2);
        near(values("joint_offset:hip=0.02")["offset_rad"], 0.02);
        near(values("joint_offset:lift=3mm")["offset_m"], 3e-3);
        near(values("joint_scale:hip=-2%")["scale"], -0.02);
        let payload = values("payload:bob=200g,1cm,0,-2e-2");
        near(payload["mass_kg"], 0.2);
        near(payload["z_m"], -0.02);
        assert!(values("joint_sign:hip").is_empty());
        assert_eq!(values("backlash:all=0.9°").len(), 1);
    }

    #[test]
    fn what_is_no_effect_is_refused_with_the_remedy() {
        let wanted = "has 0 values where 1 are wanted: offset_rad";
        for (text, words) in [
            ("joint_ofset:hip=1", "known are sensor_offset"),
            ("joint_ofset:hip=1", "did you mean `joint_offset`?"),
            ("joint_offset:hib=1", "it has hip, lift"),
            ("joint_offset:hib=1", "did you mean `hip`?"),
            ("joint_offset:hip=1kg", "units deg, °, rad or none"),
            ("joint_offset:hip", wanted),
            ("joint_sign:hip=1", "takes no value"),
            ("joint_offset:hip=NaN", "no value of offset_rad"),
            (
                "joint_offset:hip=1.2",
                "is 1.2 rad (69°); give its unit: 1.2deg, or 1.2rad",
            ),
            (
                "joint_offset:lift=-3",
                "is -3 m (-3000 mm); give its unit: -3mm",
            ),
            (
                "payload:bob=200,0,0,0",
                "the robot weighs 3.000 kg); give its unit: 200g",
            ),
            ("time_delay=20ms", "shift the joint columns"),
            ("cell_gain:0=1%", "give a model file with `cells`"),
        ] {
            crate::tests::says(hide(model(), &[text]).unwrap_err(), &[words]);
        }
    }
}
