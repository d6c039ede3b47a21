//! Servos: what a tick of each joint means.
//!
//! ```text
//! revolute    q = sign (ticks - zero) 2π / resolution
//! prismatic   q = sign (ticks - zero) metres_per_tick
//! ```
//!
//! ```toml
//! [default]
//! zero = 2048
//! resolution = 4096        # ticks a turn
//! [joints.l_knee]
//! zero = 2050
//! sign = -1
//! [joints.lift]
//! metres_per_tick = 1e-5   # prismatic joints
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::Error;
use crate::error::Problem;
use sesc_model::files;
use sesc_model::text::{listed, shortened, visible};
use sesc_model::tree::Dof;
use sesc_model::urdf::suggestion;

/// What a servo file says of one joint, or of all.
///
/// ```
/// let mirrored = sesc_codegen::Setting { sign: Some(-1), ..Default::default() };
/// assert_eq!(mirrored.zero, None); // 2048
/// ```
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Ticks at q = 0; 2048 unless given.
    pub zero: Option<i32>,
    /// 1 or −1; 1 unless given.
    pub sign: Option<i32>,
    /// Ticks a turn; 4096 unless given.
    pub resolution: Option<f64>,
    /// Stroke of one tick of a prismatic joint, m.
    pub metres_per_tick: Option<f64>,
}

/// A servo file.
///
/// ```
/// use sesc_codegen::{Servos, Setting};
///
/// let mut servos = Servos::default();
/// let zero = Setting { zero: Some(2050), ..Setting::default() };
/// servos.joints.insert("l_knee".to_string(), zero);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servos {
    /// Settings of joints that are not named.
    #[serde(default)]
    pub default: Setting,
    /// Settings by name of the joint.
    #[serde(default)]
    pub joints: BTreeMap<String, Setting>,
}

/// One joint's servo, complete.
///
/// ```
/// use sesc_codegen::{Setting, Servos};
///
/// let mut servos = Servos::default();
/// servos.default = Setting { sign: Some(-1), ..Setting::default() };
/// let (joint, servo) = servos.of([("knee", false)].into_iter())?.remove(0);
/// assert_eq!((joint.as_str(), servo.zero, servo.sign), ("knee", 2048, -1));
/// # Ok::<(), sesc_codegen::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Ticks at q = 0.
    pub zero: i32,
    /// 1 or −1.
    pub sign: i32,
    /// How far one tick goes.
    pub scale: Scale,
}

/// How far one tick goes.
///
/// ```
/// use sesc_codegen::{Scale, Servos};
///
/// let servos = Servos::default().of([("knee", false)].into_iter())?;
/// assert_eq!(servos[0].1.scale, Scale::TicksPerTurn(4096.0));
/// # Ok::<(), sesc_codegen::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Resolution of a revolute joint, ticks per turn.
    TicksPerTurn(f64),
    /// Resolution of a prismatic joint, metres per tick.
    MetresPerTick(f64),
}

impl Servo {
    /// rad or m per tick, with the sign.
    pub(super) fn per_tick(self) -> f64 {
        f64::from(self.sign)
            * match self.scale {
                Scale::TicksPerTurn(ticks) => std::f64::consts::TAU / ticks,
                Scale::MetresPerTick(metres) => metres,
            }
    }

    /// Steps of the table per tick, where that is whole.
    pub(super) fn steps(self) -> Option<u32> {
        match self.scale {
            Scale::TicksPerTurn(ticks) => {
                let steps = TABLE_STEPS / ticks;
                (steps == libm::rint(steps)).then_some(steps as u32)
            }
            Scale::MetresPerTick(_) => None,
        }
    }
}

/// Steps of a turn in the table of sines.
const TABLE_STEPS: f64 = 4096.0;

impl Servos {
    /// Read and parse `path`.
    ///
    /// ```
    /// # use sesc_codegen::Servos;
    /// let file = std::env::temp_dir().join("sesc_servos.toml");
    /// std::fs::write(&file, "[joints.l_knee]\nzero = 2050\n").unwrap();
    /// assert_eq!(Servos::read(&file)?.joints["l_knee"].zero, Some(2050));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    ///
    /// # Errors
    /// When it cannot be read or is no servo file.
    pub fn read(path: &Path) -> Result<Servos, Error> {
        let file = path.display().to_string();
        let text = files::read_text(path, files::SETTINGS).map_err(|source| Problem::Read {
            file: file.clone(),
            source,
        })?;
        files::parse_toml(&text, FORMAT).map_err(|error| {
            let reason = format!("{file}: {error}");
            Problem::Servos { reason }.into()
        })
    }

    /// The servo of each joint that has one, by name: joints without a mimic that turn, or that
    /// are prismatic (`true`) and have a stroke per tick.
    ///
    /// ```
    /// # use sesc_codegen::Servos;
    /// // A prismatic joint has no stroke of its own accord.
    /// let servos = Servos::default().of([("knee", false), ("lift", true)].into_iter())?;
    /// assert_eq!(servos.len(), 1);
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    ///
    /// # Errors
    /// When the file names another joint, or a setting is out of range.
    pub fn of<'j>(
        &self,
        joints: impl Iterator<Item = (&'j str, bool)>,
    ) -> Result<Vec<(String, Servo)>, Error> {
        let joints: Vec<(&str, bool)> = joints.collect();
        let names = || joints.iter().map(|joint| joint.0);
        if let Some(stray) = self
            .joints
            .keys()
            .find(|name| !names().any(|own| own == *name))
        {
            let meant = suggestion(stray, names());
            let reason = format!(
                "no joint `{}` to set a servo of; the robot has {}{meant}",
                shortened(&visible(stray), NAME),
                listed(names().map(|joint| shortened(joint, NAME)), NAMED)
            );
            return Err(Problem::Servos { reason }.into());
        }
        let mut servos = Vec::new();
        for (joint, prismatic) in joints {
            let servo = self.servo(joint, prismatic)?;
            servos.extend(servo.map(|servo| (joint.to_string(), servo)));
        }
        Ok(servos)
    }

    /// The servo of each joint; `None` when a prismatic joint has no stroke per tick.
    pub(super) fn of_dofs(&self, dofs: &[Dof]) -> Result<Option<Vec<Servo>>, Error> {
        let joints = dofs.iter().map(|dof| (dof.joint.as_str(), dof.prismatic));
        let servos = self.of(joints)?.into_iter().map(|(_, servo)| servo);
        Ok((servos.len() == dofs.len()).then(|| servos.collect()))
    }

    fn servo(&self, joint: &str, prismatic: bool) -> Result<Option<Servo>, Error> {
        let own = self.joints.get(joint);
        let first = |get: fn(&Setting) -> Option<f64>| own.and_then(get).or(get(&self.default));
        let bad = |what: String| -> Error {
            let reason = format!("servo of joint `{joint}`: {what}");
            Problem::Servos { reason }.into()
        };
        let sign = own.and_then(|s| s.sign).or(self.default.sign).unwrap_or(1);
        if sign.abs() != 1 {
            return Err(bad(format!("sign is {sign}; give 1 or -1")));
        }
        let zero = own.and_then(|s| s.zero).or(self.default.zero);
        let zero = zero.unwrap_or(2048);
        if zero.unsigned_abs() > LARGEST_ZERO {
            return Err(bad(format!(
                "zero is {zero}; give ticks within ±{LARGEST_ZERO}"
            )));
        }
        let scale = if prismatic {
            let Some(stroke) = first(|s| s.metres_per_tick) else {
                return Ok(None);
            };
            if !STROKES.contains(&stroke) {
                return Err(bad(format!(
                    "metres_per_tick is {stroke:?}; give metres above zero, {:e} to {:e}",
                    STROKES.start(),
                    STROKES.end()
                )));
            }
            Scale::MetresPerTick(stroke)
        } else {
            let resolution = first(|s| s.resolution).unwrap_or(4096.0);
            if !(1.0..=LARGEST_RESOLUTION).contains(&resolution) {
                return Err(bad(format!(
                    "resolution is {resolution:?}; give ticks a turn, 1 to {LARGEST_RESOLUTION}"
                )));
            }
            Scale::TicksPerTurn(resolution)
        };
        Ok(Some(Servo { zero, sign, scale }))
    }
}

/// The newest format of servo files that is read.
const FORMAT: u32 = 1;
/// Letters of a name in a message, and names of joints, at most.
const NAME: usize = 64;
const NAMED: usize = 30;
/// Beyond 2^24, f32 does not hold a tick.
const LARGEST_ZERO: u32 = 1 << 24;
const LARGEST_RESOLUTION: f64 = 16_777_216.0;
/// A tick of a prismatic joint, m: from a tenth of a nanometre to a metre.
const STROKES: std::ops::RangeInclusive<f64> = 1e-10..=1.0;
