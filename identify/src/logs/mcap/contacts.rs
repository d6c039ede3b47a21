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

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::Arc;

use super::joints::{LONGEST_S, Track, Waiting};
use super::{LEAST_LOAD_N, centre};
use crate::logs::block::{Frame, Share};
use crate::logs::names::short;
use crate::logs::settings::{Options, Sensor};

/// Two contacts, that of the support first.
#[derive(Clone)]
pub(super) struct Pair {
    pub topics: [String; 2],
    pub links: [String; 2],
}

/// Topics and frames of the sensors that a sidecar names, that of the support first.
///
/// # Errors
/// A sensor without a topic or a frame, and a third one.
pub(super) fn named(
    sensors: &BTreeMap<String, Sensor>,
    options: &Options,
) -> Result<Vec<(String, String)>, String> {
    let of = |(name, sensor): (&String, &Sensor)| {
        let both = sensor.topic.clone().zip(sensor.frame.clone());
        both.ok_or_else(|| {
            format!(
                "sensor `{}` of the sidecar: a recording needs its `topic` and its `frame`",
                short(name)
            )
        })
    };
    let mut named = sensors.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    if named.len() > 2 {
        return Err(
            "a recording is read with the wrenches of two sensors at most; remove others \
                    from `[sensors]` of the sidecar"
                .into(),
        );
    }
    let is_own = |frame: &str| {
        let support = options.support.as_deref();
        let fixed = || options.soles.as_ref()?.fixed(support?, frame);
        support == Some(frame) || fixed().is_some()
    };
    named.sort_by_key(|(_, frame)| !is_own(frame));
    Ok(named)
}

impl Pair {
    /// The two sensors that a sidecar names.
    pub fn named(named: &[(String, String)], options: &Options) -> Option<Pair> {
        let [(own, frame), (other, link)] = named else {
            return None;
        };
        let support = options.support.as_ref().unwrap_or(frame);
        Some(Pair {
            topics: [own.clone(), other.clone()],
            links: [support.clone(), link.clone()],
        })
    }
}

/// Messages of a contact.
struct Seen {
    topic: String,
    link: String,
    messages: u64,
    loaded: u64,
}

/// The wrenches of a recording, until it is known whether two of them are a pair.
pub(super) struct Wrenches {
    seen: Vec<Seen>,
    /// Messages that say whether both are loaded, at most; none where it is known already.
    left: u64,
}

impl Wrenches {
    /// Nothing is seen yet, or wanted at all.
    pub fn new(are_wanted: bool) -> Wrenches {
        Wrenches {
            seen: Vec::new(),
            left: if are_wanted { 4000 } else { 0 },
        }
    }

    /// Whether more messages are wanted.
    pub fn undecided(&self) -> bool {
        self.left > 0
    }

    /// A point: which topic is the CoP, the sidecar says.
    pub fn point(&mut self) {
        (self.seen, self.left) = (Vec::new(), 0);
    }

    /// A wrench on a topic, in a frame.
    pub fn see(&mut self, topic: &str, frame: &str, force: [f64; 3]) {
        let at = self.seen.iter().position(|own| own.topic == *topic);
        let at = at.unwrap_or_else(|| {
            self.seen.push(Seen {
                topic: topic.to_string(),
                link: String::new(),
                messages: 0,
                loaded: 0,
            });
            self.seen.len() - 1
        });
        let own = &mut self.seen[at];
        own.link = frame.trim_start_matches('/').to_string();
        own.messages += 1;
        own.loaded += u64::from(force[2].abs() >= LEAST_LOAD_N);
        self.left = if at > 1 { 0 } else { self.left - 1 };
    }

    /// The contacts of a recording in which two wrenches, in frames of two of the robot's links,
    /// are both loaded in half of their messages or more; none of any other recording, and where
    /// `options` do not say how the two stand to each other. The support is one of them, where it
    /// is said.
    pub fn pair(mut self, dofs: usize, options: &Options) -> Option<Pair> {
        // That of the support is first, else the one that came first.
        let support = options.support.as_ref();
        let seen = &mut self.seen;
        seen.sort_by_key(|own| support.is_some_and(|support| own.link != *support));
        let [one, other] = &seen[..] else {
            return None;
        };
        let stands =
            |own: &Seen| 2 * own.loaded >= own.messages && options.links.contains(&own.link);
        let rest = vec![0.0; dofs];
        let soles = options.soles.as_ref()?;
        let is_pair = stands(one)
            && stands(other)
            && one.link != other.link
            && support.is_none_or(|support| one.link == *support);
        soles
            .seen(&rest, &one.link, &other.link, [0.0; 2])
            .filter(|_| is_pair)?;
        Some(Pair {
            topics: [one.topic.clone(), other.topic.clone()],
            links: [one.link.clone(), other.link.clone()],
        })
    }
}

/// Readings of the support that wait for the other contact.
pub(super) struct Contacts<R> {
    /// Under which force, N.
    waiting: Waiting<(f64, R)>,
    /// Force of the other contact, N, and its CoP times that, N m.
    others: Track<3>,
    /// Readings in which the other foot was in the air.
    lifted: u64,
}

impl<R> Contacts<R> {
    pub fn new() -> Contacts<R> {
        Contacts {
            waiting: Waiting::new(),
            others: Track(VecDeque::new()),
            lifted: 0,
        }
    }

    /// A reading of the support at time `t`, s, under a force, N.
    pub fn reading(&mut self, t: f64, force: f64, reading: R) {
        self.waiting.push(t, (force.abs(), reading));
    }

    /// Whether the other contact never came.
    pub fn has_no_other(&self) -> bool {
        self.others.0.is_empty()
    }

    /// A wrench of the other contact.
    pub fn other(&mut self, t: f64, [force, torque]: [[f64; 3]; 2]) {
        let cop = centre([force, torque]).filter(|cop| cop.iter().all(|x| x.is_finite()));
        let force = cop.map_or(0.0, |_| force[2].abs());
        let [x, y] = cop.unwrap_or([0.0; 2]).map(|x| force * x);
        let first = self.waiting.first(t) - LONGEST_S;
        self.others.push(t, [force, x, y], first);
    }

    /// The next reading with what the other contact has; of the last ones where the recording has
    /// `ended`.
    pub fn next(&mut self, ended: bool) -> Option<(R, Share)> {
        let others = &self.others;
        let is_known = |t: f64| ended || others.0.back().is_some_and(|(last, _)| *last >= t);
        loop {
            let known = self.waiting.next(is_known, |t| between(others, t))?;
            let ((own, reading), [force, x, y]) = known;
            if force >= LEAST_LOAD_N {
                let share = Share {
                    share: force / (own + force),
                    cop: [x, y].map(|moment| moment / force),
                };
                return Some((reading, share));
            }
            self.lifted += 1;
        }
    }

    /// What is said of `readings` that were left out.
    pub fn conclude(&self, readings: u64) -> Option<String> {
        let (lifted, alone) = (self.lifted, self.waiting.left_out);
        (lifted + alone > 0).then(|| {
            format!(
                "of {readings} readings {lifted} have the other foot in the air, {alone} no \
                 message of it within {LONGEST_S} s; they are left out"
            )
        })
    }
}

/// The other contact at time `t`; none where no messages are near enough.
fn between(others: &Track<3>, t: f64) -> Option<[f64; 3]> {
    let [before, after] = others.around(t)?.map(|k| others.0[k]);
    let part = match after.0 - before.0 {
        0.0 => 0.0,
        time => (t - before.0) / time,
    };
    Some([0, 1, 2].map(|k| before.1[k] + part * (after.1[k] - before.1[k])))
}

/// What is known of frames.
pub(super) struct Frames {
    options: Options,
    /// Frames that came: the link that stands, empty where nothing says it, and how readings are
    /// moved to it.
    known: HashMap<String, (Arc<str>, Option<Frame>)>,
    /// What there is to say of frames beside the support, in the order in which they came.
    pub odd: Vec<String>,
}

impl Frames {
    pub fn new(options: &Options) -> Frames {
        Frames {
            options: options.clone(),
            known: HashMap::new(),
            odd: Vec::new(),
        }
    }

    /// The link that is the support of a reading, empty where the frame is none, and how the
    /// reading is moved to it.
    pub fn of(&mut self, frame: &str) -> (Arc<str>, Option<Frame>) {
        let frame = frame.trim_start_matches('/');
        if let Some(known) = self.known.get(frame) {
            return known.clone();
        }
        let (link, moved) = self.judge(frame);
        let judged = (Arc::from(link), moved);
        self.known.insert(frame.to_string(), judged.clone());
        judged
    }

    fn judge<'a>(&'a mut self, frame: &'a str) -> (&'a str, Option<Frame>) {
        let Options { support, links, .. } = &self.options;
        let support = support.as_deref();
        if frame.is_empty() || links.is_empty() {
            return ("", None);
        }
        if support != Some(frame) && !links.iter().any(|link| link == frame) {
            let sole = support.map_or("the support".to_string(), |own| format!("`{}`", short(own)));
            self.odd.push(format!(
                "readings are in the frame `{}`, which the URDF does not have: they are taken as \
                 those about the origin of {sole}",
                short(frame)
            ));
            return ("", None);
        }
        let other = support.filter(|own| *own != frame);
        let soles = self.options.soles.as_ref().zip(other);
        let Some((support, moved)) =
            soles.and_then(|(soles, support)| Some((support, soles.fixed(support, frame)?)))
        else {
            return (frame, None);
        };
        self.odd.push(format!(
            "readings are in the frame `{}` and are moved to `{}`, of the same body, by the URDF",
            short(frame),
            short(support)
        ));
        (support, Some(moved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::stillness::MOST;

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
        assert_eq!((contacts.lifted, contacts.waiting.left_out), (1, 2));
        let said = contacts.conclude(4).unwrap();
        assert!(said.contains("of 4 readings 1 have the other foot in the air, 2 no"));
    }

    #[test]
    fn memory_does_not_grow_with_what_lacks_its_other_half() {
        let mut contacts = Contacts::new();
        let (force, torque) = at(50.0, [0.0; 2]);
        for k in 0..2 * MOST {
            contacts.other(0.001 * k as f64, [force, torque]);
        }
        assert!(contacts.others.0.len() < 200, "{}", contacts.others.0.len());
        for k in 0..2 * MOST {
            contacts.reading(1e3 + k as f64, 50.0, 0);
        }
        assert_eq!(contacts.waiting.left_out, MOST as u64);
    }
}
