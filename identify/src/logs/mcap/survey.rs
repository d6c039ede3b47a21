//! A first look at a recording: which joints and which CoP it has.

use std::collections::{HashMap, HashSet};
use std::io::Read;

use sesc_model::tree::Dof;
use sesc_model::urdf::suggestion;

use super::cdr::JointState;
use super::records::Records;
use super::{FIRST, POINT, STATE, WRENCH, check_encoding};
use crate::logs::names::list;
use crate::logs::options::StillnessLimits;
use crate::logs::stillness::StillnessCutter;

/// Names kept for messages about joints that are missing.
const MOST_JOINTS: usize = 10_000;

/// What a recording has of what is wanted.
pub(super) struct Survey {
    /// The robot's joints that were seen; all joints if one is missing.
    pub joints: Vec<String>,
    /// Topic of the CoP, if it is wanted.
    pub topic: Option<String>,
    /// Whether the recording says that this is the topic.
    pub said: bool,
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
        stillness: StillnessLimits,
    ) -> Result<bool, String> {
        let places = self.places();
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
            check_encoding(channel)?;
            let state = JointState::decode(&records.data)?;
            let speed = state.put(&places, &mut q);
            let t = state.header.stamp.unwrap_or(message.log_time);
            if cutter.state(t, &q, speed).is_some() {
                return Ok(true);
            }
        }
        Ok(cutter.end().is_some())
    }

    /// Read until every joint and a reading were seen.
    pub fn of<R: Read>(
        mut records: Records<R>,
        dofs: &[Dof],
        topic: Option<&str>,
        wanted: bool,
    ) -> Result<Survey, String> {
        let mut missing: HashSet<&str> = dofs.iter().map(|dof| dof.joint.trim()).collect();
        let (mut seen, mut found, mut said) = (HashSet::new(), None, false);
        while !missing.is_empty() || (wanted && found.is_none()) {
            let Some(message) = records.next()? else {
                break;
            };
            let channel = &message.channel;
            match channel.schema.as_str() {
                STATE => {
                    check_encoding(channel)?;
                    for name in JointState::decode(&records.data)?.name {
                        missing.remove(name.trim());
                        if seen.len() < MOST_JOINTS {
                            seen.insert(name.trim().to_string());
                        }
                    }
                }
                WRENCH | POINT
                    if found.is_none() && topic.is_none_or(|topic| topic == channel.topic) =>
                {
                    (found, said) = (Some(channel.topic.clone()), channel.own_postures);
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
            return Err(format!("no {STATE}; the topics are {}", all()));
        }
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
            topic: found.filter(|_| wanted),
            said,
        })
    }
}
