//! A first look at a recording: which joints, which CoP and which contacts it has, and how the
//! frames of readings lie to the support.
//!
//! A wrench or a point in another frame of the support's rigid body is moved to the sole by the
//! URDF. One in a frame that the URDF does not have is taken as one of the sole, with a word.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use sesc_model::tree::Dof;
use sesc_model::urdf::suggestion;

use super::cdr::{self, JointState};
use super::records::{Channel, Records};
use super::{FIRST, LEAST_LOAD_N, STATE, WRENCH};
use crate::logs::block::Frame;
use crate::logs::names::{list, short};
use crate::logs::settings::{Options, Readings, Sidecar};

/// The topic of a robot's joints by convention, which goes before others.
const JOINTS_TOPIC: &str = "/joint_states";

/// Topics that have positions of the robot's joints, and which joints.
type JointTopics = BTreeMap<String, BTreeSet<String>>;

/// What a recording has of what is wanted.
#[derive(Clone)]
pub(super) struct Survey {
    /// The robot's joints that were seen; all joints if one is missing.
    pub joints: Vec<String>,
    /// Topics of their positions; none of a recording without the robot's joints, of which it is
    /// told what is missing.
    pub joint_topics: JointTopics,
    /// Topic of the CoP, if it is wanted.
    pub topic: Option<String>,
    /// Whether others beside it are passed over.
    pub chosen: bool,
    /// Whether that topic is of wrenches.
    pub is_wrench: bool,
    /// Frame of these wrenches, where a sensor of the sidecar says it.
    pub frame: Option<String>,
    /// The two contacts of a recording of both feet, that of the support first.
    pub pair: Option<[Contact; 2]>,
}

impl Survey {
    /// Read until every joint and a reading were seen, and some messages on.
    pub(super) fn of(
        mut records: Records,
        dofs: &[Dof],
        options: &Options,
        sidecar: &Sidecar,
    ) -> Result<Survey, String> {
        let named = named(sidecar, options)?;
        let topic = named
            .first()
            .map(|own| &own.topic)
            .or(sidecar.topic.as_ref());
        let joints_topic = sidecar.joints_topic.as_ref();
        let wanted = options.readings != Readings::Ignored;
        let is_one_foot = options.both_feet == Some(false) || options.soles.is_none();
        let mut wrenches = Wrenches::new(wanted && topic.is_none() && !is_one_foot);
        let own: HashSet<&str> = dofs.iter().map(|dof| dof.joint.trim()).collect();
        let mut missing = own.clone();
        let mut joint_topics = JointTopics::default();
        let (mut seen, mut found, mut is_wrench) = (HashSet::new(), None, false);
        let mut beyond = 0;
        while beyond < 500 || wrenches.undecided() {
            let Some(message) = records.next()? else {
                break;
            };
            if missing.is_empty() && !(wanted && found.is_none()) {
                beyond += 1;
            }
            let Channel {
                topic: on, schema, ..
            } = &*message.channel;
            if schema != STATE {
                if found.is_none() && topic.is_none_or(|topic| topic == on) {
                    found = Some(on.clone());
                    is_wrench = schema == WRENCH;
                }
                if schema != WRENCH {
                    wrenches.point();
                } else if wrenches.undecided() {
                    let (_, frame, [force, _]) = message.decoded(cdr::wrench)?;
                    wrenches.see(on, &frame, force);
                }
            } else if beyond < 500 && joints_topic.is_none_or(|topic| topic == on) {
                let of = joint_topics.entry(on.clone()).or_default();
                let (_, _, state) = message.decoded(JointState::decode)?;
                for name in state.joints.iter().map(|(name, ..)| name.trim()) {
                    missing.remove(name);
                    if own.contains(name) {
                        of.insert(name.to_string());
                    }
                    // For messages about joints that are missing.
                    if seen.len() < 10_000 {
                        seen.insert(name.to_string());
                    }
                }
            }
        }
        let all = || {
            let named = |channel: &Channel| format!("{} ({})", channel.topic, channel.schema);
            let mut topics: Vec<String> = records.channels().map(named).collect();
            topics.sort();
            list(topics)
        };
        if seen.is_empty() {
            let on = joints_topic.map_or(String::new(), |topic| format!(" on topic `{topic}`"));
            return Err(format!("no {STATE}{on}; the topics are {}", all()));
        }
        let joint_topics = chosen(joint_topics)?;
        if let (true, Some(topic), None) = (wanted, topic, &found) {
            let topics = records.channels().map(|channel| channel.topic.as_str());
            let meant = suggestion(topic, topics.filter(|other| *other != topic));
            return Err(format!(
                "no CoP on topic `{topic}`; the topics are {}{meant}",
                all()
            ));
        }
        let names = dofs.iter().map(|dof| dof.joint.trim().to_string());
        let mut joints: Vec<String> = names.collect();
        if !missing.is_empty() {
            joints = seen.into_iter().collect();
            joints.retain(|name| !FIRST.contains(&name.as_str()));
            joints.sort();
        }
        let frame = named.first().map(|own| own.link.clone());
        let mut pair = wrenches.pair(dofs.len(), options);
        if let [own, other] = &named[..] {
            let link = options.support.as_ref().unwrap_or(&own.link).clone();
            let own = Contact {
                link,
                ..own.clone()
            };
            pair = Some([own, other.clone()]);
        }
        let chosen = topic.is_some() || pair.is_some();
        let topic = pair.as_ref().map(|pair| pair[0].topic.clone()).or(found);
        Ok(Survey {
            joints,
            joint_topics,
            topic: topic.filter(|_| wanted),
            chosen,
            is_wrench,
            frame,
            pair,
        })
    }
}

/// The topics of which the positions are taken, and their joints: [`JOINTS_TOPIC`] before others
/// that have the same joints; topics of different joints together.
fn chosen(mut topics: JointTopics) -> Result<JointTopics, String> {
    topics.retain(|_, joints| !joints.is_empty());
    if let Some(first) = topics.get(JOINTS_TOPIC).cloned() {
        topics.retain(|topic, joints| topic == JOINTS_TOPIC || first.is_disjoint(joints));
    }
    let mut owners: BTreeMap<&str, &str> = BTreeMap::new();
    for (topic, joints) in &topics {
        for joint in joints {
            if let Some(other) = owners.insert(joint, topic) {
                return Err(format!(
                    "positions of joint `{}` are on `{}` and on `{}`; choose one by \
                     `joints_topic = \"…\"` in the sidecar",
                    short(joint),
                    short(other),
                    short(topic)
                ));
            }
        }
    }
    Ok(topics)
}

/// What stands on the ground, by its wrenches.
#[derive(Clone, Default)]
pub(super) struct Contact {
    pub topic: String,
    pub link: String,
}

/// Topics and frames of the sensors that a sidecar names, that of the support first.
///
/// # Errors
/// A sensor without a topic or a frame, and a third one.
fn named(sidecar: &Sidecar, options: &Options) -> Result<Vec<Contact>, String> {
    let mut named = Vec::new();
    for (name, sensor) in sidecar.sensors.iter().flatten() {
        let (Some(topic), Some(link)) = (sensor.topic.clone(), sensor.frame.clone()) else {
            return Err(format!(
                "sensor `{}` of the sidecar: a recording needs its `topic` and its `frame`",
                short(name)
            ));
        };
        named.push(Contact { topic, link });
    }
    if named.len() > 2 {
        let said = "a recording is read with the wrenches of two sensors at most; remove others \
                    from `[sensors]` of the sidecar";
        return Err(said.into());
    }
    let is_own = |frame: &str| {
        let support = options.support.as_deref();
        let fixed = || options.soles.as_ref()?.fixed(support?, frame);
        support == Some(frame) || fixed().is_some()
    };
    named.sort_by_key(|own| !is_own(&own.link));
    Ok(named)
}

/// Messages of a contact.
#[derive(Default)]
struct Seen {
    contact: Contact,
    messages: u64,
    loaded: u64,
}

/// The wrenches of a recording, until it is known whether two of them are a pair.
struct Wrenches {
    seen: Vec<Seen>,
    /// Messages that say whether both are loaded, at most; none where it is known already.
    left: u64,
}

impl Wrenches {
    /// Nothing is seen yet, or wanted at all.
    pub(crate) fn new(are_wanted: bool) -> Wrenches {
        Wrenches {
            seen: Vec::new(),
            left: if are_wanted { 4000 } else { 0 },
        }
    }

    /// Whether more messages are wanted.
    pub(crate) fn undecided(&self) -> bool {
        self.left > 0
    }

    /// A point: which topic is the CoP, the sidecar says.
    pub(crate) fn point(&mut self) {
        (self.seen, self.left) = (Vec::new(), 0);
    }

    /// A wrench on a topic, in a frame.
    pub(crate) fn see(&mut self, topic: &str, frame: &str, force: [f64; 3]) {
        let at = self.seen.iter().position(|own| own.contact.topic == *topic);
        let at = at.unwrap_or(self.seen.len());
        if at == self.seen.len() {
            self.seen.push(Seen::default());
        }
        let own = &mut self.seen[at];
        own.contact.topic = topic.to_string();
        own.contact.link = frame.trim_start_matches('/').to_string();
        own.messages += 1;
        own.loaded += u64::from(force[2].abs() >= LEAST_LOAD_N);
        self.left = if at > 1 { 0 } else { self.left - 1 };
    }

    /// The contacts of a recording in which two wrenches, in frames of two of the robot's links,
    /// are both loaded in half of their messages or more; none of any other recording, and where
    /// `options` do not say how the two stand to each other. The support is one of them, where it
    /// is said.
    pub(crate) fn pair(mut self, dofs: usize, options: &Options) -> Option<[Contact; 2]> {
        // That of the support is first, else the one that came first.
        let support = options.support.as_ref();
        let is_support = |own: &Seen| support.is_none_or(|support| own.contact.link == *support);
        self.seen.sort_by_key(|own| !is_support(own));
        let [one, other] = &self.seen[..] else {
            return None;
        };
        let stands = |own: &Seen| {
            2 * own.loaded >= own.messages && options.links.contains(&own.contact.link)
        };
        let links = [&one.contact.link, &other.contact.link];
        let is_pair = stands(one) && stands(other) && links[0] != links[1] && is_support(one);
        let soles = options.soles.as_ref().filter(|_| is_pair)?;
        soles.seen(&vec![0.0; dofs], links[0], links[1], [0.0; 2])?;
        Some([one.contact.clone(), other.contact.clone()])
    }
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
    pub(super) fn new(options: &Options) -> Frames {
        Frames {
            options: options.clone(),
            known: HashMap::new(),
            odd: Vec::new(),
        }
    }

    /// The link that is the support of a reading, empty where the frame is none, and how the
    /// reading is moved to it.
    pub(super) fn of(&mut self, frame: &str) -> (Arc<str>, Option<Frame>) {
        let frame = frame.trim_start_matches('/');
        if !self.known.contains_key(frame) {
            let judged = self.judge(frame);
            self.known.insert(frame.to_string(), judged);
        }
        self.known[frame].clone()
    }

    fn judge(&mut self, frame: &str) -> (Arc<str>, Option<Frame>) {
        let Options {
            support,
            links,
            soles,
            ..
        } = &self.options;
        let other = support.as_deref().filter(|own| *own != frame);
        let is_support = support.is_some() && other.is_none();
        if frame.is_empty() || links.is_empty() {
            return ("".into(), None);
        } else if !is_support && !links.iter().any(|link| link == frame) {
            let sole = other.map_or("the support".to_string(), |own| format!("`{}`", short(own)));
            self.odd.push(format!(
                "readings are in the frame `{}`, which the URDF does not have: they are taken as \
                 those about the origin of {sole}",
                short(frame)
            ));
            return ("".into(), None);
        }
        let moved = other.and_then(|own| Some((own, soles.as_ref()?.fixed(own, frame)?)));
        let Some((support, moved)) = moved else {
            return (frame.into(), None);
        };
        self.odd.push(format!(
            "readings are in the frame `{}` and are moved to `{}`, of the same body, by the URDF",
            short(frame),
            short(support)
        ));
        (support.into(), Some(moved))
    }
}
