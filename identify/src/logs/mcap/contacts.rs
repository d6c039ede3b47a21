//! What stands on the ground: the frame of readings against the support, and two contacts of one
//! recording, a wrench each.
//!
//! A wrench or a point in another frame of the support's rigid body is moved to the sole by the
//! URDF. One in a frame that the URDF does not have is taken as one of the sole, with a word.
//! Where two contacts are loaded, both are known at one moment:
//!
//! ```text
//! F₂(t), F₂ p₂(t)        on the line between the other contact's messages before t and after it
//! ```

use std::collections::{HashMap, VecDeque};
use std::io::Read;
use std::sync::Arc;

use super::joints::{LONGEST_S, MOST};
use super::records::Records;
use super::{LEAST_LOAD_N, POINT, STATE, cdr, centre};
use crate::logs::block::{Frame, Share, Soles};
use crate::logs::names::short;
use crate::logs::settings::Options;

/// Two contacts, that of the support first.
pub(super) struct Pair {
    pub topics: [String; 2],
    pub links: [String; 2],
}

/// Messages of a contact.
struct Seen {
    topic: String,
    link: String,
    messages: u64,
    loaded: u64,
}

impl Pair {
    /// The contacts of a recording in which two wrenches, in frames of two of the robot's links,
    /// are both loaded in half of their messages or more; none of any other recording, and where
    /// `options` do not ask for it or do not say how the two stand to each other. The support is
    /// one of them, where it is said.
    pub fn asked<R: Read>(
        mut records: Records<R>,
        dofs: usize,
        options: &Options,
    ) -> Result<Option<Pair>, String> {
        let soles = options.soles.as_ref();
        let Some(soles) = soles.filter(|_| options.both_feet != Some(false)) else {
            return Ok(None);
        };
        let mut seen: Vec<Seen> = Vec::new();
        // Messages that say whether both are loaded, at most.
        let mut left = 4000;
        while let Some(message) = records.next()? {
            let topic = &message.channel.topic;
            match message.channel.schema.as_str() {
                STATE => continue,
                // Which of them is the CoP, its sidecar says.
                POINT => return Ok(None),
                _ => {}
            }
            let (_, frame, [force, _]) = message.decoded(cdr::wrench)?;
            let at = seen.iter().position(|own| own.topic == *topic);
            let at = at.unwrap_or_else(|| {
                seen.push(Seen {
                    topic: topic.clone(),
                    link: String::new(),
                    messages: 0,
                    loaded: 0,
                });
                seen.len() - 1
            });
            let own = &mut seen[at];
            own.link = frame.trim_start_matches('/').to_string();
            own.messages += 1;
            own.loaded += u64::from(force[2].abs() >= LEAST_LOAD_N);
            left -= 1;
            if seen.len() > 2 || left == 0 {
                break;
            }
        }
        // That of the support is first, else the one that came first.
        let support = options.support.as_ref();
        seen.sort_by_key(|own| support.is_some_and(|support| own.link != *support));
        let [one, other] = &seen[..] else {
            return Ok(None);
        };
        let stands =
            |own: &Seen| 2 * own.loaded >= own.messages && options.links.contains(&own.link);
        let rest = vec![0.0; dofs];
        let is_pair = stands(one)
            && stands(other)
            && one.link != other.link
            && support.is_none_or(|support| one.link == *support)
            && soles
                .seen(&rest, &one.link, &other.link, [0.0; 2])
                .is_some();
        Ok(is_pair.then(|| Pair {
            topics: [one.topic.clone(), other.topic.clone()],
            links: [one.link.clone(), other.link.clone()],
        }))
    }

    /// What is said of it.
    pub fn sentence(&self) -> String {
        let [one, other] = [0, 1].map(|k| short(&self.topics[k]));
        format!(
            "both contacts are loaded, `{one}` and `{other}`: rows are of both feet together; \
             choose one foot by `topic = \"…\"` in the sidecar"
        )
    }
}

/// A message of the other contact.
#[derive(Clone, Copy)]
struct Other {
    t: f64,
    force: f64,
    /// Its CoP times its force, N m.
    moment: [f64; 2],
}

/// Readings of the support that wait for the other contact.
pub(super) struct Contacts<R> {
    waiting: VecDeque<(f64, f64, R)>,
    others: VecDeque<Other>,
    /// Readings in which the other foot was in the air.
    pub lifted: u64,
    /// Readings between no messages of the other contact that are close enough.
    pub alone: u64,
}

impl<R> Contacts<R> {
    pub fn new() -> Contacts<R> {
        Contacts {
            waiting: VecDeque::new(),
            others: VecDeque::new(),
            lifted: 0,
            alone: 0,
        }
    }

    /// A reading of the support at time `t`, s, under a force, N.
    pub fn reading(&mut self, t: f64, force: f64, reading: R) {
        if !t.is_finite() || self.waiting.len() >= MOST {
            self.alone += 1;
            return;
        }
        self.waiting.push_back((t, force.abs(), reading));
    }

    /// A wrench of the other contact. Stamps that go back begin anew.
    pub fn other(&mut self, t: f64, [force, torque]: [[f64; 3]; 2]) {
        if !t.is_finite() {
            return;
        }
        if self.others.back().is_some_and(|last| t < last.t) {
            self.others.clear();
        }
        let cop = centre([force, torque]).filter(|cop| cop.iter().all(|x| x.is_finite()));
        let force = cop.map_or(0.0, |_| force[2].abs());
        let moment = cop.unwrap_or([0.0; 2]).map(|x| force * x);
        self.others.push_back(Other { t, force, moment });
        let before = self.waiting.front().map_or(t, |(at, ..)| at.min(t)) - LONGEST_S;
        while self.others.len() > 2 && (self.others[1].t < before || self.others.len() > MOST) {
            self.others.pop_front();
        }
    }

    /// The next reading with what the other contact has; of the last ones where the recording has
    /// `ended`.
    pub fn next(&mut self, ended: bool) -> Option<(R, Share)> {
        while let Some((t, ..)) = self.waiting.front() {
            let t = *t;
            if !ended && self.others.back().is_none_or(|last| last.t < t) {
                return None;
            }
            let other = self.at(t);
            let (_, own, reading) = self.waiting.pop_front()?;
            match other {
                None => self.alone += 1,
                Some(other) if other.force < LEAST_LOAD_N => self.lifted += 1,
                Some(other) => {
                    let share = Share {
                        share: other.force / (own + other.force),
                        cop: other.moment.map(|moment| moment / other.force),
                    };
                    return Some((reading, share));
                }
            }
        }
        None
    }

    /// What is said of `readings` that were left out.
    pub fn left_out(&self, readings: u64) -> Option<String> {
        let Contacts { lifted, alone, .. } = self;
        (lifted + alone > 0).then(|| {
            format!(
                "of {readings} readings {lifted} have the other foot in the air, {alone} no \
                 message of it within {LONGEST_S} s; they are left out"
            )
        })
    }

    /// The other contact at time `t`; none where no messages are near enough.
    fn at(&self, t: f64) -> Option<Other> {
        let after = self.others.partition_point(|other| other.t < t);
        let next = *self.others.get(after)?;
        if next.t == t {
            return Some(next);
        }
        let last = self.others.get(after.checked_sub(1)?)?;
        if next.t - last.t > LONGEST_S {
            return None;
        }
        let part = (t - last.t) / (next.t - last.t);
        let between = |a: f64, b: f64| a + part * (b - a);
        Some(Other {
            t,
            force: between(last.force, next.force),
            moment: [0, 1].map(|axis| between(last.moment[axis], next.moment[axis])),
        })
    }
}

/// What is known of frames.
pub(super) struct Frames {
    soles: Option<Arc<dyn Soles>>,
    /// What was asked for, if it was.
    support: Option<String>,
    links: Vec<String>,
    /// Frames that came: the link that stands, empty where nothing says it, and how readings are
    /// moved to it.
    known: HashMap<String, (String, Option<Frame>)>,
    /// Frames beside the support, in the order in which they came.
    odd: Vec<String>,
}

impl Frames {
    pub fn new(soles: Option<Arc<dyn Soles>>, support: Option<String>, links: &[String]) -> Frames {
        Frames {
            soles,
            support,
            links: links.to_vec(),
            known: HashMap::new(),
            odd: Vec::new(),
        }
    }

    /// The link that is the support of a reading, empty where the frame is none, and how the
    /// reading is moved to it.
    pub fn of(&mut self, frame: &str) -> (String, Option<Frame>) {
        let frame = frame.trim_start_matches('/');
        if let Some(known) = self.known.get(frame) {
            return known.clone();
        }
        let judged = self.judge(frame);
        self.known.insert(frame.to_string(), judged.clone());
        judged
    }

    fn judge(&mut self, frame: &str) -> (String, Option<Frame>) {
        let none = (String::new(), None);
        let support = self.support.as_deref();
        if frame.is_empty() || self.links.is_empty() {
            return none;
        }
        if support != Some(frame) && !self.links.iter().any(|link| link == frame) {
            let sole = support.map_or("the support".to_string(), |own| format!("`{}`", short(own)));
            self.odd.push(format!(
                "readings are in the frame `{}`, which the URDF does not have: they are taken as \
                 those about the origin of {sole}",
                short(frame)
            ));
            return none;
        }
        if let (Some(support), Some(soles)) = (support, &self.soles)
            && support != frame
            && let Some(moved) = soles.fixed(support, frame)
        {
            self.odd.push(format!(
                "readings are in the frame `{}` and are moved to `{}`, of the same body, by the URDF",
                short(frame),
                short(support)
            ));
            return (support.to_string(), Some(moved));
        }
        (frame.to_string(), None)
    }

    /// What there is to say of frames, once.
    pub fn said(&mut self) -> Vec<String> {
        std::mem::take(&mut self.odd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force along z at a point.
    fn at(force: f64, [x, y]: [f64; 2]) -> ([f64; 3], [f64; 3]) {
        ([0.0, 0.0, force], [y * force, -x * force, 0.0])
    }

    /// Half way between 10 N at x = 0.02 m and 30 N at x = 0.06 m there are 20 N, whose moment is
    /// (0.2 + 1.8)/2 = 1 N m: x = 0.05 m.
    #[test]
    fn the_other_contact_is_on_the_line_between_its_messages() {
        let mut contacts = Contacts::new();
        for (t, force, x) in [(1.0, 10.0, 0.02), (1.02, 30.0, 0.06)] {
            let (force, torque) = at(force, [x, -x]);
            contacts.other(t, [force, torque]);
        }
        contacts.reading(1.01, -60.0, "own");
        let (own, other) = contacts.next(false).unwrap();
        assert_eq!(own, "own");
        assert!((other.share - 0.25).abs() < 1e-12, "{other:?}");
        let off = [other.cop[0] - 0.05, other.cop[1] + 0.05];
        assert!(off.iter().all(|x| x.abs() < 1e-12), "{other:?}");
    }

    #[test]
    fn readings_wait_and_those_of_one_foot_are_left_out_and_counted() {
        let mut contacts = Contacts::new();
        contacts.reading(1.0, 50.0, 0);
        assert_eq!(contacts.next(false), None);
        let (force, torque) = at(50.0, [0.0; 2]);
        contacts.other(1.0, [force, torque]);
        assert!(contacts.next(false).is_some());
        // In the air, and between messages that are half a second apart.
        contacts.reading(1.5, 50.0, 1);
        contacts.other(1.5, [[0.0; 3]; 2]);
        contacts.reading(1.75, 50.0, 2);
        contacts.other(2.0, [force, torque]);
        assert_eq!(contacts.next(false), None);
        contacts.reading(2.5, 50.0, 3);
        assert_eq!(contacts.next(true), None);
        assert_eq!((contacts.lifted, contacts.alone), (1, 2));
        let said = contacts.left_out(4).unwrap();
        assert!(said.contains("of 4 readings 1 have the other foot in the air, 2 no"));
    }

    #[test]
    fn memory_does_not_grow_with_what_lacks_its_other_half() {
        let mut contacts = Contacts::new();
        let (force, torque) = at(50.0, [0.0; 2]);
        for k in 0..2 * MOST {
            contacts.other(0.001 * k as f64, [force, torque]);
        }
        assert!(contacts.others.len() < 200, "{}", contacts.others.len());
        for k in 0..2 * MOST {
            contacts.reading(1e3 + k as f64, 50.0, 0);
        }
        assert_eq!(contacts.alone, MOST as u64);
    }
}
