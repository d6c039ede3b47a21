//! The frame in which a recording has its readings, against the support.
//!
//! A wrench or a point in another frame of the support's rigid body is moved to the sole by the
//! URDF. One in a frame that the URDF does not have is taken as one of the sole, with a word.

use std::collections::HashMap;
use std::sync::Arc;

use crate::logs::contacts::{Frame, Soles};
use crate::logs::names::short;

/// What is known of frames.
pub(super) struct Frames {
    soles: Option<Arc<dyn Soles>>,
    /// What was asked for, if it was.
    support: Option<String>,
    links: Vec<String>,
    known: HashMap<String, Known>,
    /// Frames beside the support, in the order in which they came.
    odd: Vec<String>,
}

/// A frame that came.
#[derive(Clone)]
enum Known {
    /// That of the support, or of a link that stands by itself; empty where nothing says it.
    Link(String),
    /// Of the support's body.
    Moved(Frame),
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
        let known = match self.known.get(frame) {
            Some(known) => known.clone(),
            None => {
                let known = self.judge(frame);
                self.known.insert(frame.to_string(), known.clone());
                known
            }
        };
        match known {
            Known::Link(link) => (link, None),
            Known::Moved(frame) => (self.support.clone().unwrap_or_default(), Some(frame)),
        }
    }

    fn judge(&mut self, frame: &str) -> Known {
        let is_link = self.links.iter().any(|link| link == frame);
        let none = Known::Link(String::new());
        let support = match &self.support {
            _ if frame.is_empty() || self.links.is_empty() => return none,
            Some(support) if support == frame => return Known::Link(frame.to_string()),
            support => support.as_deref(),
        };
        if !is_link {
            let sole = support.map_or("the support".to_string(), |own| format!("`{}`", short(own)));
            self.odd.push(format!(
                "readings are in the frame `{}`, which the URDF does not have: they are taken as \
                 those about the origin of {sole}",
                short(frame)
            ));
            return none;
        }
        let moved = support.and_then(|own| self.soles.as_ref()?.fixed(own, frame));
        match (support, moved) {
            (Some(support), Some(moved)) => {
                self.odd.push(format!(
                    "readings are in the frame `{}` and are moved to `{}`, of the same body, by the \
                     URDF",
                    short(frame),
                    short(support)
                ));
                Known::Moved(moved)
            }
            _ => Known::Link(frame.to_string()),
        }
    }

    /// What there is to say of frames, once.
    pub fn said(&mut self) -> Vec<String> {
        std::mem::take(&mut self.odd)
    }
}
