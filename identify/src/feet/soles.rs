//! What is said of two soles on one floor.

use serde::{Deserialize, Serialize};

/// How a sole lies on the floor, or how well that is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Lies {
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Height over the floor, m.
    pub height_m: f64,
}

impl Lies {
    /// `1.52° of roll, 0.31° of pitch and 3.1 mm of height`
    pub fn sentence(&self) -> String {
        format!(
            "{:.2}° of roll, {:.2}° of pitch and {:.1} mm of height",
            self.roll_rad.to_degrees(),
            self.pitch_rad.to_degrees(),
            1e3 * self.height_m
        )
    }
}

/// What an encoder is off by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Offset {
    /// The joint.
    pub joint: String,
    /// Offset of a revolute joint, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_rad: Option<f64>,
    /// Offset of a prismatic joint, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<f64>,
    /// Its standard deviation, rad or m.
    pub std: f64,
}

impl Offset {
    pub(super) fn new(joint: String, prismatic: bool, offset: f64, std: f64) -> Offset {
        Offset {
            joint,
            offset_rad: (!prismatic).then_some(offset),
            offset_m: prismatic.then_some(offset),
            std,
        }
    }

    /// rad or m
    pub(super) fn value(&self) -> f64 {
        self.offset_rad.or(self.offset_m).unwrap_or(0.0)
    }

    /// `1.49° of l_knee`
    fn sentence(&self) -> String {
        match self.offset_rad {
            Some(offset) => format!("{:.2}° of {}", offset.to_degrees(), self.joint),
            None => format!("{:.1} mm of {}", 1e3 * self.value(), self.joint),
        }
    }
}

/// How two soles of a log of both feet close.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClosureFound {
    /// Link whose sole is the floor.
    pub support: String,
    /// Link of the other sole.
    pub other_foot: String,
    /// Postures that were looked at.
    pub postures: usize,
    /// RMS of roll, pitch, height by CAD.
    pub before: Lies,
    /// The same with the explanation.
    pub after: Lies,
    /// Standard deviation in one posture.
    pub noise: Lies,
    /// Whether the log has this noise; else it is the least that is believed.
    pub noise_from_log: bool,
    /// Tolerance in every posture alike.
    pub tolerance: Lies,
    /// χ² of what the explanation leaves.
    pub chi2: f64,
    /// χ² that noise leaves.
    pub expected: f64,
    /// Whether only noise is left.
    pub closes: bool,
    /// Joints whose offset alone explains it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub explained_by: Vec<Offset>,
    /// The whole in words.
    pub sentence: String,
}

/// Sentences and names in a file are no longer.
const LONGEST: usize = 10_000;

impl ClosureFound {
    /// Returns the one of two logs whose soles lie worse.
    #[doc(hidden)]
    pub fn worse(self, other: ClosureFound) -> ClosureFound {
        let ratio = |found: &ClosureFound| {
            let open = if found.closes { 0.0 } else { 1e9 };
            open + found.chi2 / found.expected.max(1.0)
        };
        if ratio(&other) > ratio(&self) {
            other
        } else {
            self
        }
    }

    /// What no log gives, in a file that was read.
    pub(crate) fn invalid_reason(&self) -> Option<String> {
        let lies = [&self.before, &self.after, &self.noise, &self.tolerance];
        let sizes = lies
            .iter()
            .flat_map(|lies| [lies.roll_rad, lies.pitch_rad, lies.height_m]);
        let numbers = sizes.chain([self.chi2, self.expected]);
        let of_joints = self.explained_by.iter().map(|offset| offset.value().abs());
        let valid = numbers.chain(of_joints).all(|x| (0.0..=1e30).contains(&x))
            && self.sentence.len() <= LONGEST;
        (!valid).then(|| "`closure` that no log gives".to_string())
    }

    /// `The soles of r_sole and l_sole are 1.52° of roll … apart by CAD`
    fn apart(&self, by: &str) -> String {
        format!(
            "By {by} the sole of {} is {} RMS off that of {}",
            self.other_foot,
            self.before.sentence(),
            self.support
        )
    }

    /// What a fit says, which can do nothing about it; `left`: the best offset leaves more
    /// than noise, `by`: who has the joints there.
    pub(super) fn of_joints(&self, left: bool, by: &str) -> String {
        if self.closes {
            return format!(
                "{}, as noise and the flatness of soles allow.",
                self.apart(by)
            );
        }
        let Some(first) = self.explained_by.first() else {
            return format!(
                "{}, and no offset of one joint explains it: check that both soles are flat on \
                 one floor and that their frames lie in them, z up.",
                self.apart(by)
            );
        };
        let others: Vec<String> = self
            .explained_by
            .iter()
            .skip(1)
            .map(Offset::sentence)
            .collect();
        let or = match others.is_empty() {
            true => String::new(),
            false => format!(" (or {})", others.join(", or ")),
        };
        let most = match left {
            true => "most of it",
            false => "it",
        };
        format!(
            "{}: an offset of {}{or} explains {most}, which bends the legs and moves the CoM.",
            self.apart(by),
            first.sentence()
        )
    }

    /// What a diagnosis says, whose explanation leaves `after`; `changed` where there is one.
    #[doc(hidden)]
    pub fn explained(mut self, changed: bool) -> ClosureFound {
        let apart = self.apart("CAD");
        let flat = "check that both soles are flat on one floor, and that their frames lie in \
                    them, z up";
        self.sentence = match (self.closes, changed) {
            (true, false) => format!("{apart}, as noise and the flatness of soles allow."),
            (true, true) => format!("{apart}, {} with it.", self.after.sentence()),
            (false, false) => format!("{apart}, which noise does not explain: {flat}."),
            (false, true) => format!(
                "{apart}, still {} with it, which noise does not explain: {flat}.",
                self.after.sentence()
            ),
        };
        self
    }
}
