//! What to change: a sentence for every effect, the zero of a servo, lines of the URDF.
//!
//! ```text
//! q = s u (n − z)                  n: ticks, s: sign, z: zero, u: rad (m) a tick
//! φ = a q + b = s' u' (n − z')     s' = s sign a,  u' = |a| u,  z' = z − s' b / u'
//! ```
//!
//! Whole ticks: a corrected zero is known to half a tick. The servo, the URDF and the model
//! file say the same; a robot is corrected in one of them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use sesc_model::effects::{EncoderMap, Stage, Target};
use sesc_model::urdf::Description;

use super::corrected_urdf::edited;
use super::findings::Explained;
pub use super::findings::{Change, Remedy, UrdfChange};
use super::hypothesis::Term;
use super::problem::Problem;
use super::words;

/// What a tick of a joint's servo means: `q = sign (ticks − zero) step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Ticks at q = 0.
    pub zero: i32,
    /// 1 or −1.
    pub sign: i32,
    /// How far one tick goes.
    pub step: Step,
}

/// How far one tick goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Resolution of a revolute joint, ticks per turn.
    TicksPerTurn(f64),
    /// Resolution of a prismatic joint, metres per tick.
    MetresPerTick(f64),
}

impl Default for Servo {
    fn default() -> Servo {
        Servo {
            zero: 2048,
            sign: 1,
            step: Step::TicksPerTurn(4096.0),
        }
    }
}

impl Servo {
    /// rad or m per tick, without the sign.
    pub fn per_tick(self) -> f64 {
        match self.step {
            Step::TicksPerTurn(ticks) => TAU / ticks,
            Step::MetresPerTick(metres) => metres,
        }
    }

    /// The servo whose readings are true, where this one's are `map`ped to the truth; `None`
    /// where its zero would be out of range.
    pub fn corrected(self, map: EncoderMap) -> Option<Servo> {
        let sign = if map.scale < 0.0 {
            -self.sign
        } else {
            self.sign
        };
        let stretch = map.scale.abs();
        let step = match self.step {
            Step::TicksPerTurn(ticks) => Step::TicksPerTurn(ticks / stretch),
            Step::MetresPerTick(metres) => Step::MetresPerTick(metres * stretch),
        };
        let by = f64::from(sign) * map.offset / (stretch * self.per_tick());
        let zero = (f64::from(self.zero) - by).round();
        let fits = zero.abs() <= f64::from(i32::MAX);
        fits.then_some(Servo {
            zero: zero as i32,
            sign,
            step,
        })
    }
}

impl Remedy {
    /// Settings of the servo that change, as a servo file names them: `zero 2048 → 2031`.
    pub fn servo_words(&self) -> Vec<String> {
        fn of<T: std::fmt::Display>(name: &str, change: Option<&Change<T>>) -> Option<String> {
            change.map(|c| format!("{name} {} → {}", c.before, c.after))
        }
        let resolution = self.servo_resolution.map(|c| Change {
            before: c.before,
            after: (c.after * 100.0).round() / 100.0,
        });
        [
            of("zero", self.servo_zero.as_ref()),
            of("sign", self.servo_sign.as_ref()),
            of("resolution", resolution.as_ref()),
            of("metres_per_tick", self.servo_metres_per_tick.as_ref()),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn set_servo(&mut self, old: Servo, new: Servo) {
        fn change<T: PartialEq + Copy>(before: T, after: T) -> Option<Change<T>> {
            (before != after).then_some(Change { before, after })
        }
        self.servo_zero = change(old.zero, new.zero);
        self.servo_sign = change(old.sign, new.sign);
        match (old.step, new.step) {
            (Step::TicksPerTurn(a), Step::TicksPerTurn(b)) => self.servo_resolution = change(a, b),
            (Step::MetresPerTick(a), Step::MetresPerTick(b)) => {
                self.servo_metres_per_tick = change(a, b);
            }
            _ => {}
        }
    }
}

/// The remedy of every step of a diagnosis.
pub(super) fn add(
    problem: &Problem,
    found: &mut Explained,
    description: &Description,
    servos: &BTreeMap<String, Servo>,
) {
    let values: Vec<Vec<f64>> = words::values(problem, &found.best)
        .iter()
        .map(|found| found.iter().map(|value| value.value).collect())
        .collect();
    let terms = &found.best.terms;
    let order = corrections(terms);
    for (step, &at) in found.diagnosis.steps.iter_mut().zip(&found.told) {
        let (term, own) = (&terms[at], &values[at]);
        step.remedy = of_term(problem, term, own, description);
        if let Some(place) = order.iter().position(|stage| term.stage() == Some(*stage)) {
            step.remedy.sentence += match place {
                0 => "; of the corrections of the reading, apply this one first",
                1 => {
                    "; of the corrections of the reading, apply this one second, to what the first gives"
                }
                _ => "; of the corrections of the reading, apply this one last",
            };
        }
        if let Some(joint) = joint_of(term, own) {
            let dof = &problem.first().context.robot.tree.dofs[joint];
            let map = encoder_of(joint, terms, &values);
            if let (Some(&old), Some(map)) = (servos.get(&dof.joint), map)
                && let Some(new) = old.corrected(map)
            {
                step.remedy.set_servo(old, new);
            }
        }
    }
}

/// Stages of corrections of the reading in the order in which they are applied, the last that acts
/// first; empty where the order does not matter.
fn corrections(terms: &[Term]) -> Vec<Stage> {
    let own = [Stage::Offset, Stage::Rotation, Stage::Gain];
    let has = |stage: &Stage| terms.iter().any(|term| term.stage() == Some(*stage));
    let own: Vec<Stage> = own.into_iter().filter(has).collect();
    if own.len() > 1 { own } else { Vec::new() }
}

/// The joint whose encoder an effect is about.
fn joint_of(term: &Term, values: &[f64]) -> Option<usize> {
    let instance = term.effect()?;
    instance.effect.encoder_map(values)?;
    match instance.target {
        Target::Joint(joint) => Some(joint),
        _ => None,
    }
}

/// How all effects on a joint map its encoder; `None` where its channel is another's.
fn encoder_of(joint: usize, terms: &[Term], values: &[Vec<f64>]) -> Option<EncoderMap> {
    let mut map = EncoderMap::TRUE;
    for (term, values) in terms.iter().zip(values) {
        match term.effect().map(|instance| &instance.target) {
            Some(Target::Joints(a, b)) if joint == *a || joint == *b => return None,
            _ => {}
        }
        if joint_of(term, values) == Some(joint) {
            let own = term.effect()?.effect.encoder_map(values)?;
            map = map.and(own);
        }
    }
    Some(map)
}

fn of_term(problem: &Problem, term: &Term, values: &[f64], description: &Description) -> Remedy {
    let context = &problem.first().context;
    let instance = match term {
        Term::Effect(instance) => instance,
        Term::Outliers => {
            return Remedy {
                sentence: "readings of the poses named as outliers come from elsewhere; repeat \
                           them or leave them out"
                    .to_string(),
                not_in_urdf: Some("it says nothing of the robot".to_string()),
                ..Remedy::default()
            };
        }
        Term::Masses => {
            return Remedy {
                sentence: "true masses differ from CAD; the model file holds the parameters that \
                           these data know, a corrected URDF the masses nearest to CAD that have \
                           them"
                    .to_string(),
                ..Remedy::default()
            };
        }
    };
    let (effect, target) = (instance.effect, &instance.target);
    let parameters = effect.parameters(context, target);
    let value = |name: &str| {
        let at = parameters
            .iter()
            .position(|parameter| parameter.name == name);
        at.map_or(0.0, |at| values[at])
    };
    let edit = effect.urdf_edit(&context.name_of(target), &value);
    let edited = match edit {
        Some(edit) => edited(description, &edit).map(|text| changed(&description.text, &text)),
        None => Err(effect.urdf_gap().to_string()),
    };
    let (urdf, not_in_urdf) = match edited {
        Ok(change) => (change, None),
        Err(reason) => (None, Some(reason)),
    };
    Remedy {
        sentence: effect.remedy(context, target, values),
        urdf,
        not_in_urdf,
        ..Remedy::default()
    }
}

/// Elements that differ; `None` where none does.
pub(super) fn changed(old: &str, new: &str) -> Option<UrdfChange> {
    let (a, b) = (elements(old), elements(new));
    let (mut i, mut j) = (0, 0);
    let (mut before, mut after, mut line) = (Vec::new(), Vec::new(), None);
    while i < a.len() || j < b.len() {
        // The next elements that are alike, with as few as possible between.
        let rest = a.len() - i + b.len() - j;
        let (x, y) = (0..rest)
            .flat_map(|sum| (0..=sum).map(move |x| (x, sum - x)))
            .find(|&(x, y)| match (a.get(i + x), b.get(j + y)) {
                (Some(a), Some(b)) => a.text == b.text,
                _ => false,
            })
            .unwrap_or((a.len() - i, b.len() - j));
        if x + y > 0 && line.is_none() {
            line = a.get(i).or(a.last()).map(|element| element.line);
        }
        before.extend(&a[i..i + x]);
        after.extend(&b[j..j + y]);
        (i, j) = ((i + x + 1).min(a.len()), (j + y + 1).min(b.len()));
    }
    line.map(|line| UrdfChange {
        line,
        before: indented(&before),
        after: indented(&after),
    })
}

/// A tag with the text after it.
struct Element<'t> {
    line: usize,
    /// Spaces before its line.
    indent: usize,
    text: &'t str,
}

/// Elements below each other, indented as they were against each other.
fn indented(elements: &[&Element]) -> String {
    let least = elements.iter().map(|own| own.indent).min().unwrap_or(0);
    let line = |own: &&Element| " ".repeat(own.indent - least) + own.text;
    elements.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn elements(text: &str) -> Vec<Element<'_>> {
    let mut starts: Vec<usize> = text.match_indices('<').map(|(at, _)| at).collect();
    starts.push(text.len());
    let mut line = 1;
    let mut counted = 0;
    let mut out = Vec::with_capacity(starts.len());
    for pair in starts.windows(2) {
        line += text[counted..pair[0]].matches('\n').count();
        counted = pair[0];
        let whole = &text[text[..pair[0]].rfind('\n').map_or(0, |end| end + 1)..];
        out.push(Element {
            line,
            indent: whole.len() - whole.trim_start_matches([' ', '\t']).len(),
            text: text[pair[0]..pair[1]].trim(),
        });
    }
    out
}
