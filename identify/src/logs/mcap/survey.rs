//! A first look at a recording: which joints and which CoP it has.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use sesc_model::tree::Dof;
use sesc_model::urdf::suggestion;

use super::cdr::{self, JointState};
use super::contacts::{Pair, Wrenches};
use super::records::{Channel, Records};
use super::{FIRST, STATE, WRENCH};
use crate::logs::names::{list, short};
use crate::logs::settings::{Options, Readings};

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
    /// Frame of these wrenches, where the sidecar says it.
    pub frame: Option<String>,
    /// The two contacts of a recording of both feet.
    pub pair: Option<Pair>,
}

impl Survey {
    /// Read until every joint and a reading were seen, and some messages on.
    pub fn of(
        mut records: Records,
        dofs: &[Dof],
        [topic, joints_topic]: [Option<&str>; 2],
        options: &Options,
    ) -> Result<Survey, String> {
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
        let pair = wrenches.pair(dofs.len(), options);
        let support = pair.as_ref().map(|pair| pair.topics[0].clone());
        Ok(Survey {
            joints,
            joint_topics,
            topic: support.or(found).filter(|_| wanted),
            chosen: topic.is_some() || pair.is_some(),
            is_wrench,
            frame: None,
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
