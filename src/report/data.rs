//! The data of a page before anything is made of them: how many, how far joints moved, what
//! came back, and what is wrong with them.

use minijinja::{Value, context};

use super::figures::plan::range_bar;
use super::health;
use super::table::position;
use sesc_identify::fit::Visits;
use sesc_identify::health::Finding;
use sesc_model::text::listed;
use sesc_model::tree::Dof;

/// A joint that used less than this part of its range hardly moved; more than the other, much.
const HARDLY: f64 = 0.05;
const MUCH: f64 = 0.5;
/// Joints that a sentence names.
const NAMED: usize = 8;

/// How often postures were reached.
pub(super) fn visits(found: Option<&Visits>) -> String {
    let nothing = || "no posture was reached twice".to_string();
    found.map_or_else(nothing, Visits::sentence)
}

/// What a card says of data.
pub(super) struct Data<'a> {
    /// Names and sentences, in their order.
    pub lines: Vec<(&'static str, String)>,
    /// Joints of the robot.
    pub dofs: &'a [Dof],
    /// Least and largest position of every joint, rad or m; empty where they are not at hand.
    pub used: &'a [[f64; 2]],
    /// Some of the postures, rad or m.
    pub postures: Vec<&'a [f64]>,
    /// What is wrong.
    pub health: &'a [Finding],
    /// The number that the page gives the first posture of their figures, where it has a robot.
    pub first_posed: Option<usize>,
}

impl Data<'_> {
    /// What `data.html` takes.
    pub(super) fn context(mut self) -> Value {
        let ranges: Vec<Value> = self.ranges();
        if !ranges.is_empty() {
            self.lines.push(("joints", self.coverage()));
        }
        self.lines.push((
            "health",
            match self.health.len() {
                0 => "nothing is wrong with the data themselves".to_string(),
                1 => "one finding, below".to_string(),
                n => format!("{n} findings, below"),
            },
        ));
        context! {
            lines => self.lines.iter().map(|(name, said)| vec![name.to_string(), said.clone()])
                .collect::<Vec<Vec<String>>>(),
            ranges => ranges,
            health => health::rows(self.health, self.first_posed),
        }
    }

    /// Joints with limits and data.
    fn known(&self) -> impl Iterator<Item = (usize, &Dof, [f64; 2])> {
        let both = self.dofs.iter().zip(self.used).enumerate();
        let known = both.filter(|(_, (_, used))| used[0] <= used[1]);
        known.map(|(k, (dof, used))| (k, dof, *used))
    }

    fn ranges(&self) -> Vec<Value> {
        let row = |(k, dof, used): (usize, &Dof, [f64; 2])| {
            let limits = [dof.lower, dof.upper];
            let values: Vec<f64> = self
                .postures
                .iter()
                .filter_map(|q| q.get(k))
                .copied()
                .collect();
            let allowed = match dof.continuous {
                true => "without limits".to_string(),
                false if dof.lower == -dof.upper => {
                    format!("of ±{}", position(dof.upper, dof.prismatic))
                }
                false => format!("of {}", between(limits, dof.prismatic)),
            };
            context! {
                joint => &dof.joint,
                bar => Value::from_safe_string(range_bar(limits, used, &values)),
                used => between(used, dof.prismatic),
                allowed,
            }
        };
        self.known().map(row).collect()
    }

    /// How much of their ranges the joints used.
    fn coverage(&self) -> String {
        let share = |dof: &Dof, used: [f64; 2]| (used[1] - used[0]) / (dof.upper - dof.lower);
        let count = self.known().count();
        let much = self
            .known()
            .filter(|(_, dof, used)| share(dof, *used) > MUCH);
        let much = much.count();
        let still = self
            .known()
            .filter(|(_, dof, used)| share(dof, *used) < HARDLY);
        let still: Vec<&str> = still.map(|(_, dof, _)| dof.joint.as_str()).collect();
        let said = format!("{much} of {count} use more than half of their range");
        match still.is_empty() {
            true => said,
            false => format!("{said}; hardly moved: {}", listed(&still, NAMED)),
        }
    }
}

/// `−29° to 57°`
fn between([low, high]: [f64; 2], prismatic: bool) -> String {
    format!(
        "{} to {}",
        position(low, prismatic),
        position(high, prismatic)
    )
}
