//! MCAP recordings of ROS 2: `sensor_msgs/msg/JointState`, and the CoP as
//! `geometry_msgs/msg/WrenchStamped` or `PointStamped`.
//!
//! A wrench is measured at the origin of the support frame, on the sole plane,
//! with axes along the frame's. A ground force `f` at `p` makes `τ = p × f`:
//!
//! ```text
//! x = −τ_y / f_z        y = τ_x / f_z
//! ```
//!
//! whichever of sole and ground is said to push, since both signs change. A
//! point is the CoP itself. The message's `frame_id` is the support where it
//! is a link of the robot. Where two wrenches in frames of two links are both loaded, a row is
//! of both feet ([`joints::Contacts`]).
//!
//! Stretches in which the robot holds still are postures, see [`StillnessLimits`]; each
//! reading in one is a row, with the joints' means. A log without readings has
//! one row per posture. Of a robot that holds still nowhere, or where [`Stays::Moving`] is asked
//! for, every reading is a row, with the joints between their messages ([`joints`]).

mod cdr;
mod joints;
mod records;
mod survey;
#[cfg(test)]
pub(super) mod tests;

use std::collections::VecDeque;
use std::sync::Arc;

use sesc_model::tree::Dof;

use self::cdr::JointState;
use self::joints::{Contacts, LONGEST_S, State, States, Waiting};
use self::records::Records;
use self::survey::{Frames, Survey};
use super::block::Share;
use super::bounds::LEAST_LOAD_N;
use super::columns::{COP, Columns, FZ, POSE, SUPPORT, T};
use super::input::{Metered, Place};
use super::names::short;
use super::settings::{Options, Sidecar, Stays, StillnessLimits};
use super::source::{Raw, RowSource};
use super::stillness::{Posture, StillnessCutter};
use crate::Error;

const STATE: &str = "sensor_msgs/msg/JointState";
const WRENCH: &str = "geometry_msgs/msg/WrenchStamped";
const POINT: &str = "geometry_msgs/msg/PointStamped";

/// Columns before the joints; a recording without readings has three of them, one of points has
/// no force.
const FIRST: [&str; 6] = [POSE, T, SUPPORT, COP[0], COP[1], FZ];
const T_PLACE: usize = 1;
const FORCE_PLACE: usize = 5;

/// A reading of the CoP.
#[derive(Default)]
struct Reading {
    /// Which of the recording's, from 1.
    number: u64,
    t: f64,
    frame: Arc<str>,
    cop: [f64; 2],
    /// Force along z, N; none of a point.
    force: f64,
    /// The other contact's, of a recording of both feet.
    other: Option<Share>,
}

/// A row that waits to be read.
struct Ready {
    pose: i64,
    q: Arc<[f64]>,
    reading: Reading,
}

/// A recording being read.
pub(super) struct McapSource {
    records: Records,
    header: Vec<String>,
    survey: Survey,
    joints: States,
    /// Readings since the last joint state, which waits for the next one.
    since: Vec<Reading>,
    q: Vec<f64>,
    contacts: Contacts<Reading>,
    frames: Frames,
    cutter: StillnessCutter<Reading>,
    /// Readings that wait for their joints, where the recording is one of a robot that moves.
    moving: Option<Waiting<Reading, 1>>,
    ready: VecDeque<Ready>,
    /// Messages that name a joint without its position.
    without_positions: u64,
    readings: u64,
    /// Readings that are not numbers.
    no_numbers: u64,
    airborne: u64,
    postures: u64,
    ended: bool,
    warnings: Vec<String>,
}

impl McapSource {
    /// Look which joints and readings the recording has, then start over.
    pub(super) fn open(
        place: &Place,
        dofs: &[Dof],
        options: &Options,
        sidecar: &Sidecar,
    ) -> Result<McapSource, Error> {
        let bad = |message| Error::row(None, message);
        let start = || Records::new(Metered::open(place)?).map_err(bad);
        let options = &Options {
            support: options.support.clone().or_else(|| sidecar.support.clone()),
            both_feet: options.both_feet.or(sidecar.both_feet),
            ..options.clone()
        };
        let survey = Survey::of(start()?, dofs, options, sidecar).map_err(bad)?;
        let mut warnings = Vec::new();
        if let Some(pair) = survey.pair.as_ref().filter(|_| survey.frame.is_none()) {
            let [one, other] = pair.each_ref().map(|own| short(&own.topic));
            warnings.push(format!(
                "both contacts are loaded, `{one}` and `{other}`: rows are of both feet together; \
                 choose one foot by `topic = \"…\"` in the sidecar"
            ));
        }
        let mut moves = survey.topic.is_some() && options.stays == Stays::Moving;
        if survey.topic.is_some() && matches!(options.stays, Stays::Pooled | Stays::Apart) {
            let joints = Survey {
                topic: None,
                pair: None,
                ..survey.clone()
            };
            let joints = McapSource::new(start()?, joints, dofs, options);
            let StillnessLimits { speed, duration } = joints.cutter.stillness;
            moves = !joints.holds_still().map_err(bad)?;
            if moves {
                warnings.push(format!(
                    "the robot holds still nowhere ({duration} s with every joint below {speed} \
                     rad/s): every reading is a row of a robot that moves"
                ));
            }
        }
        let source = McapSource::new(start()?, survey, dofs, options);
        Ok(McapSource {
            moving: moves.then(|| Waiting::for_joints(source.q.len())),
            warnings,
            ..source
        })
    }

    /// A recording from its start on.
    fn new(records: Records, survey: Survey, dofs: &[Dof], options: &Options) -> McapSource {
        let first = match (&survey.topic, survey.is_wrench) {
            (None, _) => 3,
            (_, false) => FORCE_PLACE,
            (_, true) => FIRST.len(),
        };
        let names = FIRST[..first].iter().map(|name| name.to_string());
        // Which stretches are postures, s.
        let duration = match options.stays {
            Stays::Alone(duration) => duration,
            _ => 0.3,
        };
        McapSource {
            records,
            header: names.chain(survey.joints.iter().cloned()).collect(),
            joints: States::new(&survey.joints, dofs),
            since: Vec::new(),
            q: vec![f64::NAN; survey.joints.len()],
            survey,
            contacts: Contacts::new(),
            frames: Frames::new(options),
            cutter: StillnessCutter::new(StillnessLimits::lasting(duration)),
            moving: None,
            ready: VecDeque::new(),
            without_positions: 0,
            readings: 0,
            no_numbers: 0,
            airborne: 0,
            postures: 0,
            ended: false,
            warnings: Vec::new(),
        }
    }

    /// Whether the robot holds still anywhere; reads up to the end of the first such stretch.
    fn holds_still(mut self) -> Result<bool, String> {
        while self.ready.is_empty() && self.advance()? {}
        Ok(!self.ready.is_empty())
    }

    /// The next row; none at the end.
    fn next_row(&mut self) -> Result<Option<Ready>, Error> {
        while self.ready.is_empty() && !self.ended {
            let advanced = match self.advance() {
                Ok(false) => self.conclude(),
                other => other.map(drop),
            };
            advanced.map_err(|message| Error::row(None, message))?;
        }
        Ok(self.ready.pop_front())
    }

    /// Take one message; false at the end.
    fn advance(&mut self) -> Result<bool, String> {
        let Some(message) = self.records.next()? else {
            self.ended = true;
            self.take_both();
            let last = self.joints.held.take();
            self.joints_are(last);
            let last = self.cutter.end();
            self.keep(last);
            return Ok(false);
        };
        let topic = &message.channel.topic;
        if message.channel.schema == STATE {
            let topics = &self.survey.joint_topics;
            if topics.is_empty() || topics.contains_key(topic) {
                let (t, _, state) = message.decoded(JointState::decode)?;
                self.without_positions += u64::from(state.misses_positions);
                let before = self.joints.push(t, &state);
                self.joints_are(before);
            }
            return Ok(true);
        }
        let pair = self.survey.pair.as_ref();
        if pair.is_some_and(|pair| pair[1].topic == *topic) {
            let (t, _, wrench) = message.decoded(cdr::wrench)?;
            self.contacts.other(t, wrench);
            self.take_both();
            return Ok(true);
        }
        match &self.survey.topic {
            Some(own) if own == topic => {}
            Some(own) if !self.survey.chosen => {
                return Err(format!(
                    "the CoP is on `{}` and on `{}`; choose one by `topic = \"…\"` in the sidecar",
                    short(own),
                    short(topic)
                ));
            }
            _ => return Ok(true),
        }
        let (t, link, force, cop) = if message.channel.schema == POINT {
            let (t, frame, at) = message.decoded(cdr::point)?;
            let (link, moved) = self.frames.of(&frame);
            let [x, y, _] = moved.map_or(at, |frame| frame.placed(at));
            (t, link, 0.0, Some([x, y]))
        } else {
            let (t, frame, wrench) = message.decoded(cdr::wrench)?;
            let frame = self.survey.frame.as_ref().unwrap_or(&frame);
            let (link, moved) = self.frames.of(frame);
            let wrench = moved.map_or(wrench, |frame| frame.moved(wrench));
            (t, link, wrench[0][2], centre(wrench))
        };
        self.readings += 1;
        match cop {
            _ if force.is_nan() => self.no_numbers += 1,
            None => self.airborne += 1,
            Some(cop) if cop.iter().any(|x| !x.is_finite()) => self.no_numbers += 1,
            Some(cop) => {
                let reading = Reading {
                    number: self.readings,
                    t,
                    frame: link,
                    cop,
                    force,
                    other: None,
                };
                if self.survey.pair.is_some() {
                    self.contacts.reading(t, force, reading);
                    self.take_both();
                } else {
                    self.place(reading);
                }
            }
        }
        Ok(true)
    }

    /// Readings of the support for which the other contact is known by now.
    fn take_both(&mut self) {
        while let Some((mut reading, other)) = self.contacts.next(self.ended) {
            reading.other = Some(other);
            self.place(reading);
        }
    }

    /// A reading among the joints.
    fn place(&mut self, reading: Reading) {
        self.since.push(reading);
        if self.joints.held.is_none() {
            self.joints_are(None);
        }
    }

    /// Joint positions that are the robot's, and the readings after them.
    fn joints_are(&mut self, state: Option<State>) {
        let since = std::mem::take(&mut self.since);
        if let Some(moving) = &mut self.moving {
            if let Some(State { t, q, .. }) = state {
                let positions = q.into_iter();
                positions.for_each(|(place, q)| moving.message(place, t, [q]));
            }
            for reading in since {
                moving.reading(reading.t, reading);
            }
            while let Some((reading, q)) = moving.next(self.ended) {
                self.postures += 1;
                self.ready.push_back(Ready {
                    pose: reading.number as i64,
                    q: q.into_flattened().into(),
                    reading,
                });
            }
            return;
        }
        if let Some(State { t, q, speed }) = state {
            q.iter().for_each(|(place, q)| self.q[*place] = *q);
            let ended = self.cutter.state(t, &self.q, speed);
            self.keep(ended);
        }
        for reading in since {
            let part = self.cutter.reading(reading);
            self.keep(part);
        }
    }

    /// Rows of a posture.
    fn keep(&mut self, posture: Option<Posture<Reading>>) {
        let Some(mut posture) = posture else {
            return;
        };
        self.postures += 1;
        if self.survey.topic.is_none() {
            posture.readings = vec![Reading {
                number: self.postures,
                t: posture.t,
                ..Reading::default()
            }];
        }
        let q: Arc<[f64]> = posture.q.into();
        let rows = posture.readings.into_iter().map(|reading| Ready {
            pose: posture.pose,
            q: q.clone(),
            reading,
        });
        self.ready.extend(rows);
    }

    /// What to say at the end of the recording.
    fn conclude(&mut self) -> Result<(), String> {
        let pair = self.survey.pair.as_ref();
        if let Some(pair) = pair.filter(|_| self.contacts.has_no_other()) {
            return Err(format!(
                "no wrench on topic `{}`; mend the `topic` of its sensor in the sidecar",
                short(&pair[1].topic)
            ));
        }
        let said = &mut self.warnings;
        said.append(&mut self.frames.odd);
        said.extend(self.joints.conclude()?);
        if self.postures == 0 {
            return Err(match self.moving {
                Some(_) => format!(
                    "no reading of the CoP lies between joint states that are at most \
                     {LONGEST_S} s apart"
                ),
                None => self.cutter.stillness.nothing(),
            });
        }
        let left_out = self.moving.as_ref().map_or(0, |moving| moving.left_out);
        let apart = format!(
            "readings lie between no joint states that are at most {LONGEST_S} s apart, and are \
             left out"
        );
        let missing = "joint states name a joint without its position; the joint is where the next \
                       one says";
        let none = "readings are no numbers and are left out";
        let light = format!("readings had less than {LEAST_LOAD_N} N on the sole and are left out");
        for (count, of, what) in [
            (left_out, self.readings, &*apart),
            (self.without_positions, self.joints.seen, missing),
            (self.no_numbers, self.readings, none),
            (self.airborne, self.readings, &*light),
        ] {
            said.extend((count > 0).then(|| format!("{count} of {of} {what}")));
        }
        said.extend(self.contacts.conclude(self.readings));
        Ok(())
    }
}

impl RowSource for McapSource {
    fn header(&self) -> &[String] {
        &self.header
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        for _ in 0..count {
            let Some(Ready { pose, q, reading }) = self.next_row()? else {
                break;
            };
            raw.line.push(reading.number);
            raw.pose.extend(columns.pose.map(|_| pose));
            raw.support
                .extend(columns.support.map(|_| reading.frame.clone()));
            raw.other.extend(reading.other);
            let first = self.header.len() - q.len();
            for (own, to) in columns.numbers.iter().zip(&mut raw.numbers) {
                to.push(match own.column {
                    T_PLACE => reading.t,
                    k if k >= first => q[k - first],
                    FORCE_PLACE => reading.force / (1.0 - reading.other.map_or(0.0, |o| o.share)),
                    k => reading.cop[usize::from(k == FORCE_PLACE - 1)],
                });
            }
        }
        Ok(())
    }

    fn knows_stays(&self) -> bool {
        true
    }

    fn both(&self) -> Option<[String; 2]> {
        Some(self.survey.pair.clone()?.map(|own| own.link))
    }

    fn progress(&self) -> (u64, Option<u64>) {
        self.records.input.progress()
    }

    fn warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    fn hash(&self) -> u64 {
        self.records.input.hash()
    }
}

/// CoP of a wrench in the support frame; nothing if nothing stands on it.
fn centre([force, torque]: [[f64; 3]; 2]) -> Option<[f64; 2]> {
    let f = force[2];
    (f.abs() >= LEAST_LOAD_N).then(|| [-torque[1] / f, torque[0] / f])
}
