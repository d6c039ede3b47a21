//! A first look at a recording: which joints and which CoP it has.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::io::Read;

use sesc_model::tree::Dof;
use sesc_model::urdf::suggestion;

use super::cdr::JointState;
use super::records::Records;
use super::states::States;
use super::{FIRST, POINT, STATE, WRENCH, check_encoding};
use crate::logs::names::{list, short};
use crate::logs::options::StillnessLimits;
use crate::logs::stillness::StillnessCutter;

/// Names kept for messages about joints that are missing.
const MOST_JOINTS: usize = 10_000;
/// Messages after which no further topic of joints is expected, once all joints were seen.
const BEYOND: usize = 500;
/// The topic of a robot's joints by convention, which goes before others.
const JOINTS_TOPIC: &str = "/joint_states";

/// What a recording has of what is wanted.
pub(super) struct Survey {
    /// The robot's joints that were seen; all joints if one is missing.
    pub joints: Vec<String>,
    /// Topics of their positions.
    pub joint_topics: JointTopics,
    /// Topic of the CoP, if it is wanted.
    pub topic: Option<String>,
    /// Whether the recording says that this is the topic.
    pub said: bool,
    /// Whether that topic is of wrenches.
    pub is_wrench: bool,
}

impl Survey {
    /// Place of each joint among the joints.
    pub fn places(&self) -> HashMap<String, usize> {
        self.joints.iter().cloned().zip(0..).collect()
    }

    /// Whether the robot holds still anywhere, or each joint state is a posture of its own; reads
    /// up to the end of the first such stretch.
    pub fn holds_still<R: Read>(
        &self,
        mut records: Records<R>,
        dofs: &[Dof],
        stillness: StillnessLimits,
    ) -> Result<bool, String> {
        let places = self.places();
        let mut states = States::new(self.places(), dofs);
        let mut q = vec![f64::NAN; self.joints.len()];
        let mut cutter: StillnessCutter<()> = StillnessCutter::new(stillness);
        while let Some(message) = records.next()? {
            let channel = &message.channel;
            if channel.schema != STATE {
                continue;
            }
            if channel.own_postures {
                return Ok(true);
            }
            if !self.joint_topics.takes(&channel.topic) {
                continue;
            }
            check_encoding(channel)?;
            let state = JointState::decode(&records.data)?;
            let t = state.header.stamp.unwrap_or(message.log_time);
            if let Some((t, state)) = states.push(t, state) {
                let speed = state.put(&places, &mut q);
                if cutter.state(t, &q, speed).is_some() {
                    return Ok(true);
                }
            }
        }
        if let Some((t, state)) = states.end() {
            let speed = state.put(&places, &mut q);
            if cutter.state(t, &q, speed).is_some() {
                return Ok(true);
            }
        }
        Ok(cutter.end().is_some())
    }

    /// Read until every joint and a reading were seen, and some messages on.
    pub fn of<R: Read>(
        mut records: Records<R>,
        dofs: &[Dof],
        (topic, joints_topic): (Option<&str>, Option<&str>),
        wanted: bool,
    ) -> Result<Survey, String> {
        let own: HashSet<&str> = dofs.iter().map(|dof| dof.joint.trim()).collect();
        let mut missing = own.clone();
        let mut joint_topics = JointTopics::default();
        let (mut seen, mut found, mut said) = (HashSet::new(), None, false);
        let mut is_wrench = false;
        let mut beyond = 0;
        while beyond < BEYOND {
            let Some(message) = records.next()? else {
                break;
            };
            if missing.is_empty() && !(wanted && found.is_none()) {
                beyond += 1;
            }
            let channel = &message.channel;
            match channel.schema.as_str() {
                STATE if joints_topic.is_none_or(|topic| topic == channel.topic) => {
                    check_encoding(channel)?;
                    let of = joint_topics.0.entry(channel.topic.clone()).or_default();
                    for name in JointState::decode(&records.data)?.name {
                        let name = name.trim();
                        missing.remove(name);
                        if own.contains(name) {
                            of.insert(name.to_string());
                        }
                        if seen.len() < MOST_JOINTS {
                            seen.insert(name.to_string());
                        }
                    }
                }
                WRENCH | POINT
                    if found.is_none() && topic.is_none_or(|topic| topic == channel.topic) =>
                {
                    (found, said) = (Some(channel.topic.clone()), channel.own_postures);
                    is_wrench = channel.schema == WRENCH;
                }
                _ => {}
            }
        }
        let all = || {
            let mut topics: Vec<String> = records
                .channels()
                .map(|channel| format!("{} ({})", channel.topic, channel.schema))
                .collect();
            topics.sort();
            let topics: Vec<&str> = topics.iter().map(String::as_str).collect();
            list(&topics)
        };
        if seen.is_empty() {
            let on = joints_topic.map_or(String::new(), |topic| format!(" on topic `{topic}`"));
            return Err(format!("no {STATE}{on}; the topics are {}", all()));
        }
        joint_topics.choose()?;
        if let (true, Some(topic), None) = (wanted, topic, &found) {
            let topics = records.channels().map(|channel| channel.topic.as_str());
            let meant = suggestion(topic, topics.filter(|other| *other != topic));
            return Err(format!(
                "no CoP on topic `{topic}`; the topics are {}{meant}",
                all()
            ));
        }
        let joints = if missing.is_empty() {
            dofs.iter()
                .map(|dof| dof.joint.trim().to_string())
                .collect()
        } else {
            let mut seen: Vec<String> = seen.into_iter().collect();
            seen.retain(|name| !FIRST.contains(&name.as_str()));
            seen.sort();
            seen
        };
        Ok(Survey {
            joints,
            joint_topics,
            topic: found.filter(|_| wanted),
            said,
            is_wrench,
        })
    }
}

/// The topics of a recording that have positions of the robot's joints, and which joints.
#[derive(Debug, Clone, Default)]
pub(super) struct JointTopics(BTreeMap<String, BTreeSet<String>>);

impl JointTopics {
    /// Leave those of which the positions are taken: [`JOINTS_TOPIC`] before others that have
    /// the same joints; topics of different joints together.
    fn choose(&mut self) -> Result<(), String> {
        self.0.retain(|_, joints| !joints.is_empty());
        if let Some(first) = self.0.get(JOINTS_TOPIC).cloned() {
            let apart = |joints: &BTreeSet<String>| first.is_disjoint(joints);
            self.0
                .retain(|topic, joints| topic == JOINTS_TOPIC || apart(joints));
        }
        let mut owners: BTreeMap<&str, &str> = BTreeMap::new();
        for (topic, joints) in &self.0 {
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
        Ok(())
    }

    /// Whether positions on a topic are taken.
    pub fn takes(&self, topic: &str) -> bool {
        // Of a recording without the robot's joints it is told what is missing.
        self.0.is_empty() || self.0.contains_key(topic)
    }
}
