//! A recording (MCAP, ROS 2) of a robot on both feet, with the wrench of each foot in its frame.
//!
//! ```text
//! p = (1 − s) p₁ + s T(φ) p₂        F₁ = (1 − s) M g,  F₂ = s M g;  T: place of the other sole
//! f = (0, 0, F)    τ = p × f = (y F, −x F, 0)
//! ```
//!
//! Postures are held for half a second; written by hand from the standards of MCAP and CDR.

use nalgebra::Point3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::World;

use crate::feet::{Noise, TwoFeet};
use crate::recording::normal;
use crate::stage::Stage;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;
/// How long a posture is held, and how long the robot then moves, s.
const HELD_S: f64 = 0.5;
const MOVES_S: f64 = 0.2;
/// Steps of joint states and of wrenches, s.
const STATES_S: f64 = 0.05;
const WRENCHES_S: f64 = 0.02;
/// How far from its origin the CoP of the other sole is drawn, m.
const ON_SOLE_M: f64 = 0.01;

/// Topics and frames of the two contacts.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Topic of its wrench.
    pub topic: String,
    /// Link whose frame it is in.
    pub frame: String,
}

/// A contact in each sole of the OP2, the support's first.
pub fn soles() -> [Contact; 2] {
    ["r_sole", "l_sole"].map(|link| Contact {
        topic: format!("/{link}/wrench"),
        frame: link.to_string(),
    })
}

/// Bytes of a recording of `count` postures of `world` on both feet; the support's contact is the
/// first of the two.
pub fn recording(
    stage: &Stage,
    world: &World,
    count: usize,
    noise: Noise,
    contacts: &[Contact; 2],
    random: &mut ChaCha8Rng,
) -> Vec<u8> {
    let feet = TwoFeet::new(stage);
    let mass: f64 = stage.robot.links().iter().map(|link| link.mass_kg).sum();
    let mut own: ChaCha8Rng = rand::SeedableRng::seed_from_u64(random.random());
    let mut normal = || normal(&mut own);
    let tilt = [(); 2].map(|()| noise.flat_rad * normal());
    let names = stage.joint_names();
    let mut messages: Vec<(f64, u16, Vec<u8>)> = Vec::new();
    let mut start = 100.0;
    for _ in 0..count {
        let joints = feet.draw(tilt, random);
        let q = TwoFeet::encoders(world, &joints);
        let read: Vec<f64> = q.iter().map(|q| q + noise.encoder_rad * normal()).collect();
        let cop = world.cop(&q);
        let place = feet.place(&joints);
        let square = place[0].powi(2) + place[1].powi(2);
        let share = ((cop[0] * place[0] + cop[1] * place[1]) / square).clamp(0.1, 0.9);
        let on_sole = [(); 2].map(|()| ON_SOLE_M * (2.0 * random.random::<f64>() - 1.0));
        let seen = feet.seen(&joints, on_sole);
        let alone = [0, 1].map(|axis| (cop[axis] - share * seen[axis]) / (1.0 - share));
        let states = (HELD_S / STATES_S).round() as usize;
        for k in 0..=states {
            let t = start + STATES_S * k as f64;
            messages.push((t, STATES, state(t, &names, &read)));
        }
        // The robot moves: joints are somewhere else on the way.
        let away: Vec<f64> = read.iter().map(|q| q + 0.1).collect();
        let t = start + HELD_S + 0.5 * MOVES_S;
        messages.push((t, STATES, state(t, &names, &away)));
        let wrenches = (HELD_S / WRENCHES_S).round() as usize;
        let mean = (wrenches as f64).sqrt();
        for k in 0..wrenches {
            let t = start + WRENCHES_S * k as f64;
            let sides = [(alone, 1.0 - share), (on_sole, share)];
            for (number, (at, share)) in sides.into_iter().enumerate() {
                // The mean of a posture has the noise that is asked for.
                let at = at.map(|x| x + noise.cop_m * mean * normal());
                let late = 0.003 * number as f64;
                let force = share * mass * GRAVITY;
                let data = wrench(t + late, &contacts[number].frame, force, at);
                messages.push((t + late, FIRST_WRENCH + number as u16, data));
            }
        }
        start += HELD_S + MOVES_S;
    }
    messages.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut records = [
        schema(1, "sensor_msgs/msg/JointState"),
        schema(2, "geometry_msgs/msg/WrenchStamped"),
        channel(STATES, 1, "/joint_states"),
    ]
    .concat();
    for (number, contact) in contacts.iter().enumerate() {
        records.extend(channel(FIRST_WRENCH + number as u16, 2, &contact.topic));
    }
    for (t, number, data) in &messages {
        let time = ((t * 1e9) as u64).to_le_bytes();
        let head = [&number.to_le_bytes()[..], &[0; 4], &time, &time].concat();
        records.extend(record(0x05, &[head, data.clone()].concat()));
    }
    let magic = &b"\x89MCAP0\r\n"[..];
    let head = record(0x01, &[text("ros2"), text("virtual")].concat());
    let (end, foot) = (record(0x0f, &[0; 4]), record(0x02, &[0; 20]));
    [magic, &head, &records, &end, &foot, magic].concat()
}

impl TwoFeet {
    /// A point on the other sole (m), seen from the support where joints are `joints`.
    pub fn seen(&self, joints: &[f64], at: [f64; 2]) -> [f64; 2] {
        let point = self.pose(joints) * Point3::new(at[0], at[1], 0.0);
        [point.x, point.y]
    }
}

const STATES: u16 = 10;
const FIRST_WRENCH: u16 = 20;

/// A record: opcode, length, content.
pub fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    [&[opcode][..], &length, content].concat()
}

/// A text behind its length.
pub fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A type of ROS messages.
pub fn schema(id: u16, name: &str) -> Vec<u8> {
    let texts = [name, "ros2msg", ""].map(text).concat();
    record(0x03, &[&id.to_le_bytes()[..], &texts].concat())
}

fn channel(id: u16, schema: u16, topic: &str) -> Vec<u8> {
    let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
    record(0x04, &[ids, text(topic), text("cdr"), vec![0; 4]].concat())
}

/// Little-endian CDR, aligned from after its first four bytes.
#[derive(Default)]
struct Body(Vec<u8>);

impl Body {
    fn header(t: f64, frame: &str) -> Body {
        let nanoseconds = (t.fract() * 1e9).round() as u32;
        Body::default().word(t as u32).word(nanoseconds).text(frame)
    }

    fn word(mut self, x: u32) -> Body {
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        self.0.extend(x.to_le_bytes());
        self
    }

    fn text(self, text: &str) -> Body {
        let mut body = self.word(text.len() as u32 + 1);
        body.0.extend(text.bytes().chain([0]));
        body
    }

    fn double(mut self, x: f64) -> Body {
        self.0.resize(self.0.len().next_multiple_of(8), 0);
        self.0.extend(x.to_le_bytes());
        self
    }

    fn doubles(self, all: &[f64]) -> Body {
        let body = self.word(all.len() as u32);
        all.iter().fold(body, |body, x| body.double(*x))
    }

    fn done(self) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &self.0].concat()
    }
}

fn state(t: f64, names: &[String], q: &[f64]) -> Vec<u8> {
    let body = Body::header(t, "").word(names.len() as u32);
    let body = names.iter().fold(body, |body, name| body.text(name));
    body.doubles(q).doubles(&[]).doubles(&[]).done()
}

/// A force along z at a point of the sole plane.
fn wrench(t: f64, frame: &str, force: f64, [x, y]: [f64; 2]) -> Vec<u8> {
    let all = [0.0, 0.0, force, y * force, -x * force, 0.0];
    let body = Body::header(t, frame);
    all.into_iter().fold(body, Body::double).done()
}
