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
//! of both feet ([`contacts`]).
//!
//! Stretches in which the robot holds still are postures, see [`StillnessLimits`]; each
//! reading in one is a row, with the joints' means. A log without readings has
//! one row per posture. Of a robot that holds still nowhere, or where [`Stays::Moving`] is asked
//! for, every reading is a row, with the joints between their messages ([`joints`]). In a
//! recording of [`Recording`](super::writer::Recording) each joint state is a posture, and the
//! CoP's topic is the one that it names.

mod cdr;
mod contacts;
mod joints;
mod records;
mod survey;
#[cfg(test)]
pub(super) mod tests;
mod write;

use std::collections::VecDeque;
use std::sync::Arc;

use sesc_model::tree::Dof;

use self::cdr::JointState;
use self::contacts::{Contacts, Frames, Pair};
use self::joints::{LONGEST_S, Moving, Row, State, States};
use self::records::Records;
use self::survey::Survey;
use super::block::Share;
use super::bounds::LEAST_LOAD_N;
use super::columns::{COP, Columns, FZ, POSE, SUPPORT, T};
use super::input::{Metered, Place};
use super::names::short;
use super::settings::{Options, Readings, Stays, StillnessLimits};
use super::source::{Interner, Raw, RowSource};
use super::stillness::{Posture, StillnessCutter};
use crate::{Error, Message};

const STATE: &str = "sensor_msgs/msg/JointState";
const WRENCH: &str = "geometry_msgs/msg/WrenchStamped";
const POINT: &str = "geometry_msgs/msg/PointStamped";

/// Key and value in the description of a topic each message of which is a posture of its own, or
/// the reading that belongs to it, however short the robot held still.
const OWN_POSTURES: [&str; 2] = ["sesc", "a message is a posture"];

/// Columns before the joints; a recording without readings has three of them, one of points has
/// no force.
const FIRST: [&str; 6] = [POSE, T, SUPPORT, COP[0], COP[1], FZ];
const T_PLACE: usize = 1;
const FORCE_PLACE: usize = 5;

/// A reading of the CoP.
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
    file: String,
    records: Records<Metered>,
    meter: Metered,
    header: Vec<String>,
    survey: Survey,
    joints: States,
    /// Readings since the last joint state, which waits for the next one.
    since: Vec<Reading>,
    q: Vec<f64>,
    /// The user named the topic of the readings, or the recording does.
    chosen: bool,
    /// The two contacts of a recording of both feet, and readings that wait for both.
    both: Option<(Pair, Contacts<Reading>)>,
    frames_of: Frames,
    stillness: StillnessLimits,
    cutter: StillnessCutter<Reading>,
    /// Joints and readings, where the recording is one of a robot that moves.
    moving: Option<Moving<Reading>>,
    ready: VecDeque<Ready>,
    frames: Interner,
    /// Messages of joints, and those that name a joint without its position.
    states: u64,
    without_positions: u64,
    readings: u64,
    /// Readings that are not numbers.
    no_numbers: u64,
    airborne: u64,
    postures: u64,
    ended: bool,
    warnings: Vec<Message>,
}

impl McapSource {
    /// Look which joints and readings the recording has, then start over. `topics`: of the CoP
    /// and of the joints, where the caller says.
    pub fn open(
        place: &Place,
        file: &str,
        dofs: &[Dof],
        options: &Options,
        topics: (Option<&str>, Option<&str>),
    ) -> Result<McapSource, Error> {
        let bad = |message| Error::log(file.to_string(), None, message);
        let start = || -> Result<(Records<_>, Metered), Error> {
            let input = Metered::open(place, file)?;
            Ok((Records::new(input.clone()).map_err(bad)?, input))
        };
        let wanted = options.readings != Readings::Ignored;
        let mut survey = Survey::of(start()?.0, dofs, topics, wanted).map_err(bad)?;
        let mut warnings = Vec::new();
        let mut both = None;
        if topics.0.is_none() && survey.topic.is_some() && !survey.said {
            both = Pair::asked(start()?.0, dofs.len(), options).map_err(bad)?;
        }
        if let Some(pair) = &both {
            warnings.push(format!("{file}: {}", pair.sentence()).into());
            survey.topic = Some(pair.topics[0].clone());
        }
        let moves = match options.stays {
            _ if survey.topic.is_none() || survey.said => false,
            Stays::Moving => true,
            Stays::Alone(_) => false,
            Stays::Pooled | Stays::Apart => {
                let alone = Survey {
                    topic: None,
                    ..survey.clone()
                };
                let joints = McapSource::new(file, start()?, alone, dofs, options);
                !joints.holds_still().map_err(bad)?
            }
        };
        if moves && options.stays != Stays::Moving {
            let StillnessLimits { speed, duration } = options.stillness;
            let warning = format!(
                "{file}: the robot holds still nowhere ({duration} s with every joint below \
                 {speed} rad/s): every reading is a row of a robot that moves"
            );
            warnings.push(warning.into());
        }
        let source = McapSource::new(file, start()?, survey, dofs, options);
        Ok(McapSource {
            moving: moves.then(|| Moving::new(source.q.len())),
            chosen: topics.0.is_some() || source.survey.said || both.is_some(),
            both: both.map(|pair| (pair, Contacts::new())),
            warnings,
            ..source
        })
    }

    /// A recording from its start on.
    fn new(
        file: &str,
        (records, meter): (Records<Metered>, Metered),
        survey: Survey,
        dofs: &[Dof],
        options: &Options,
    ) -> McapSource {
        let first = match (&survey.topic, survey.is_wrench) {
            (None, _) => 3,
            (_, false) => FORCE_PLACE,
            (_, true) => FIRST.len(),
        };
        let names = FIRST[..first].iter().map(|name| name.to_string());
        let (soles, support) = (options.soles.clone(), options.support.clone());
        McapSource {
            file: file.to_string(),
            records,
            meter,
            header: names.chain(survey.joints.iter().cloned()).collect(),
            joints: States::new(&survey.joints, dofs),
            since: Vec::new(),
            q: vec![f64::NAN; survey.joints.len()],
            survey,
            chosen: false,
            both: None,
            frames_of: Frames::new(soles, support, &options.links),
            stillness: options.stillness,
            cutter: StillnessCutter::new(options.stillness),
            moving: None,
            ready: VecDeque::new(),
            frames: Interner::default(),
            states: 0,
            without_positions: 0,
            readings: 0,
            no_numbers: 0,
            airborne: 0,
            postures: 0,
            ended: false,
            warnings: Vec::new(),
        }
    }

    /// Whether the robot holds still anywhere, or each joint state is a posture of its own; reads
    /// up to the end of the first such stretch.
    fn holds_still(mut self) -> Result<bool, String> {
        while self.ready.is_empty() && self.advance()? {}
        Ok(!self.ready.is_empty())
    }

    /// The next row; none at the end.
    fn next_row(&mut self) -> Result<Option<Ready>, Error> {
        while self.ready.is_empty() && !self.ended {
            let advanced = self.advance();
            let advanced = advanced.and_then(|more| if more { Ok(()) } else { self.conclude() });
            advanced.map_err(|message| Error::log(self.file.clone(), None, message))?;
        }
        Ok(self.ready.pop_front())
    }

    /// Take one message; false at the end.
    fn advance(&mut self) -> Result<bool, String> {
        let Some(message) = self.records.next()? else {
            self.ended = true;
            self.take_both();
            let last = self.joints.end();
            self.joints_are(last);
            let last = self.cutter.end();
            self.keep(last);
            self.take_moving();
            return Ok(false);
        };
        let topic = &message.channel.topic;
        if message.channel.schema == STATE {
            if self.survey.joint_topics.takes(topic) {
                let (t, _, state) = message.decoded(JointState::decode)?;
                let apart = message.channel.own_postures;
                self.state(t, &state, apart);
            }
            return Ok(true);
        }
        if let Some((pair, contacts)) = &mut self.both
            && pair.topics[1] == *topic
        {
            let (t, _, wrench) = message.decoded(cdr::wrench)?;
            contacts.other(t, wrench);
            self.take_both();
            return Ok(true);
        }
        match &self.survey.topic {
            Some(own) if own == topic => {}
            Some(own) if !self.chosen => {
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
            let (link, moved) = self.frames_of.of(&frame);
            let [x, y, _] = moved.map_or(at, |frame| frame.placed(at));
            (t, link, 0.0, Some([x, y]))
        } else {
            let (t, frame, wrench) = message.decoded(cdr::wrench)?;
            let (link, moved) = self.frames_of.of(&frame);
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
                    frame: self.frames.get(&link),
                    cop,
                    force,
                    other: None,
                };
                self.reading(reading);
            }
        }
        Ok(true)
    }

    /// Joint positions, as a posture of its own where it is `apart`.
    fn state(&mut self, t: f64, state: &JointState, apart: bool) {
        self.states += 1;
        self.without_positions += u64::from(state.misses_positions);
        let state = self.joints.placed(t, state);
        if apart {
            state.q.iter().for_each(|(place, q)| self.q[*place] = *q);
            let ended = self.cutter.posture(t, &self.q);
            self.keep(ended);
            return;
        }
        let before = self.joints.push(state);
        self.joints_are(before);
    }

    /// Joint positions that are the robot's, and the readings after them.
    fn joints_are(&mut self, state: Option<State>) {
        if let Some(State { t, q, speed }) = state {
            if let Some(moving) = &mut self.moving {
                q.iter()
                    .for_each(|(place, q)| moving.position(*place, t, *q));
                self.take_moving();
            } else {
                q.iter().for_each(|(place, q)| self.q[*place] = *q);
                let ended = self.cutter.state(t, &self.q, speed);
                self.keep(ended);
            }
        }
        for reading in std::mem::take(&mut self.since) {
            self.place_now(reading);
        }
    }

    /// A CoP, once the other contact is known where there are two.
    fn reading(&mut self, reading: Reading) {
        match &mut self.both {
            Some((_, contacts)) => {
                contacts.reading(reading.t, reading.force, reading);
                self.take_both();
            }
            None => self.place(reading),
        }
    }

    /// Readings of the support for which the other contact is known by now.
    fn take_both(&mut self) {
        let ended = self.ended;
        while let Some((mut reading, other)) =
            self.both.as_mut().and_then(|(_, all)| all.next(ended))
        {
            reading.other = Some(other);
            self.place(reading);
        }
    }

    /// A reading among the joints.
    fn place(&mut self, reading: Reading) {
        match self.joints.waits() {
            true => self.since.push(reading),
            false => self.place_now(reading),
        }
    }

    fn place_now(&mut self, reading: Reading) {
        if let Some(moving) = &mut self.moving {
            moving.reading(reading.t, reading);
            self.take_moving();
            return;
        }
        let part = self.cutter.reading(reading);
        self.keep(part);
    }

    /// Rows of a robot that moves, whose joints are known by now.
    fn take_moving(&mut self) {
        let Some(moving) = &mut self.moving else {
            return;
        };
        while let Some(Row { q, reading }) = moving.next(self.ended) {
            self.postures += 1;
            self.ready.push_back(Ready {
                pose: reading.number as i64,
                q: q.into(),
                reading,
            });
        }
    }

    /// Rows of a posture.
    fn keep(&mut self, posture: Option<Posture<Reading>>) {
        let Some(posture) = posture else {
            return;
        };
        self.postures += 1;
        let Posture {
            pose,
            t,
            q,
            mut readings,
        } = posture;
        if self.survey.topic.is_none() {
            readings = vec![Reading {
                number: self.postures,
                t,
                frame: self.frames.get(""),
                cop: [f64::NAN; 2],
                force: f64::NAN,
                other: None,
            }];
        }
        let q: Arc<[f64]> = q.into();
        let rows = readings.into_iter().map(|reading| Ready {
            pose,
            q: q.clone(),
            reading,
        });
        self.ready.extend(rows);
    }

    /// What to say at the end of the recording.
    fn conclude(&mut self) -> Result<(), String> {
        let mut said = self.frames_of.said();
        said.extend(self.joints.conclude()?);
        if self.postures == 0 {
            return Err(match self.moving {
                Some(_) => format!(
                    "no reading of the CoP lies between joint states that are at most \
                     {LONGEST_S} s apart"
                ),
                None => self.stillness.nothing(),
            });
        }
        let readings = self.readings;
        let mut count = |count: u64, of: u64, what: &str| {
            if count > 0 {
                said.push(format!("{count} of {of} {what}"));
            }
        };
        let apart = format!(
            "readings lie between no joint states that are at most {LONGEST_S} s apart, and are \
             left out"
        );
        let left_out = self.moving.as_ref().map_or(0, |moving| moving.left_out);
        count(left_out, readings, &apart);
        let missing = "joint states name a joint without its position; the joint is where the next \
                       one says";
        count(self.without_positions, self.states, missing);
        let none = "readings are no numbers and are left out";
        count(self.no_numbers, readings, none);
        let light = format!("readings had less than {LEAST_LOAD_N} N on the sole and are left out");
        count(self.airborne, readings, &light);
        said.extend(
            self.both
                .as_ref()
                .and_then(|(_, all)| all.left_out(readings)),
        );
        let named = said
            .into_iter()
            .map(|said| format!("{}: {said}", self.file).into());
        self.warnings.extend(named);
        Ok(())
    }
}

impl RowSource for McapSource {
    fn header(&self) -> &[String] {
        &self.header
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        for _ in 0..count {
            let Some(row) = self.next_row()? else {
                break;
            };
            raw.line.push(row.reading.number);
            if columns.pose.is_some() {
                raw.pose.push(row.pose);
            }
            if columns.support.is_some() {
                raw.support.push(row.reading.frame.clone());
            }
            raw.other.extend(row.reading.other);
            let first = self.header.len() - row.q.len();
            raw.numbers.extend(columns.numbers.iter().map(|&k| match k {
                T_PLACE => row.reading.t,
                _ if k >= first => row.q[k - first],
                FORCE_PLACE => {
                    row.reading.force / (1.0 - row.reading.other.map_or(0.0, |o| o.share))
                }
                _ => row.reading.cop[usize::from(k == FORCE_PLACE - 1)],
            }));
        }
        Ok(())
    }

    // Every message is read, since the next row needs the joints of those before it.
    fn skip(&mut self, _: &Columns, rows: u64) -> Result<(), Error> {
        for _ in 0..rows {
            if self.next_row()?.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn knows_stays(&self) -> bool {
        true
    }

    fn both(&self) -> Option<[String; 2]> {
        self.both.as_ref().map(|(pair, _)| pair.links.clone())
    }

    fn progress(&self) -> (u64, Option<u64>) {
        self.meter.progress()
    }

    fn warnings(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.warnings)
    }

    fn hash(&self) -> u64 {
        self.meter.hash()
    }
}

/// CoP of a wrench in the support frame; nothing if nothing stands on it.
fn centre([force, torque]: [[f64; 3]; 2]) -> Option<[f64; 2]> {
    let f = force[2];
    (f.abs() >= LEAST_LOAD_N).then(|| [-torque[1] / f, torque[0] / f])
}
