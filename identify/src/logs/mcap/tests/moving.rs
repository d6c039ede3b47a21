//! Recordings of a robot that holds still nowhere, whose readings lie between its joint states.

use std::path::Path;
use std::sync::Arc;

use sesc_model::Snapping;
use sesc_reference::{Robot as Twin, Track, World};

use super::*;
use crate::diagnose::{Verdict, diagnose};
use crate::fit::{self, fit};
use crate::robot::Robot;
use crate::tests::noise;

/// The skewed robot on a sole.
fn skew() -> String {
    crate::tests::SKEW.replace("foot", "sole")
}

/// Standard deviation of a reading, m.
const NOISE: f64 = 2e-4;
/// Moments of joint states, and of readings, which lie between them, s.
const STATES_S: f64 = 0.02;
const READINGS_S: f64 = 0.023;
const SECONDS: f64 = 30.0;

/// Hip and knee at time `t`, which begins at 100 s.
fn swing(t: f64) -> Vec<f64> {
    let t = t - 100.0;
    vec![0.35 * (3.1 * t).sin(), 0.5 * (2.3 * t + 1.0).sin()]
}

fn moments(step: f64) -> Vec<f64> {
    let at = |k: usize| 100.0 + 0.004 + step * k as f64;
    (0..(SECONDS / step) as usize).map(at).collect()
}

/// What announces joint states on topics from 10 on, and points on 20.
fn head(topics: &[&str]) -> Vec<u8> {
    let mut head = [schema(1, STATE), schema(2, POINT)].concat();
    for (topic, id) in topics.iter().zip(10..) {
        head.extend(channel(id, 1, topic, "cdr"));
    }
    head.extend(channel(20, 2, "/cop", "cdr"));
    head
}

/// Joint states, hip and knee from topics of their own, and readings that the twin gives.
fn recorded() -> Vec<u8> {
    let mut messages: Vec<(f64, Vec<u8>)> = Vec::new();
    for t in moments(STATES_S) {
        // Each driver has stamps of its own.
        for (id, joint, late) in [(10, 0, 0.0), (11, 1, 0.0071)] {
            let (name, t) = (["hip", "knee"][joint], t + late);
            messages.push((t, message(id, t, &state(t, &[name], &[swing(t)[joint]]))));
        }
    }
    let times = moments(READINGS_S);
    let twin = Twin::from_urdf(&skew()).unwrap();
    let track = Track::moving(times.clone(), swing);
    let world = World::new(&twin, "sole").unwrap().unsettled();
    let readings = world.readings(&track);
    let mut noise = noise(NOISE);
    for (t, reading) in times.iter().zip(readings) {
        let data = in_plane(stamp(*t), "sole", reading.cop.map(|x| x + noise()));
        messages.push((*t, message(20, *t, &data)));
    }
    messages.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut all = head(&["/hip/joint_states", "/knee/joint_states"]);
    all.extend(messages.into_iter().flat_map(|(_, message)| message));
    file(&all)
}

fn read_by(path: &Path, stays: Stays) -> Result<(crate::logs::Block, Vec<crate::Message>), Error> {
    let options = Options {
        links: vec!["sole".into()],
        stays,
        ..Options::default()
    };
    read_file(path, &dofs(&["hip", "knee"]), &options)
}

#[test]
fn where_nothing_is_held_every_reading_is_a_row_at_its_own_joints() {
    let (_folder, path) = log("walk.mcap", &recorded(), "");
    for stays in [Stays::Pooled, Stays::Moving, Stays::Apart] {
        let (block, warnings) = read_by(&path, stays).unwrap();
        let said = format!("{warnings:?}");
        let told = said.contains("still nowhere");
        assert_eq!(told, stays != Stays::Moving, "{said}");
        // The first one has no message of the knee before it.
        assert_eq!(block.len(), moments(READINGS_S).len() - 1, "{said}");
        for (k, t) in block.t.as_ref().unwrap().iter().enumerate() {
            for (q, truth) in block.q[2 * k..2 * k + 2].iter().zip(swing(*t)) {
                // 3/128 (ω Δt)⁴ within, (ω Δt)³/16 where one message lies beyond; stamps in ns.
                let is_at_end = t - 100.0 < 0.05 || t - 100.0 > SECONDS - 0.05;
                let within = if is_at_end { 1e-5 } else { 1e-6 };
                assert!((q - truth).abs() < within, "{t}: {q}, not {truth}");
            }
        }
    }
    let said = read_by(&path, Stays::Alone(0.3)).unwrap_err().to_string();
    assert!(said.contains("no posture is held"), "{said}");
}

/// Stays are read as before where there are any, and all rows where that is asked for.
#[test]
fn a_recording_with_stays_is_read_by_them_unless_all_rows_are_asked_for() {
    let (_folder, path) = log("log.mcap", &recording(""), "");
    let (stays, warnings) = read_by(&path, Stays::Pooled).unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let (all, _) = read_by(&path, Stays::Moving).unwrap();
    // 30 readings, one in the air, the last after the last joint state but one.
    assert!(all.len() >= 28 && stays.len() < 20, "{}", stays.len());
    assert!(all.pose.windows(2).all(|pair| pair[0] != pair[1]));
}

/// Masses of CAD come back from a recording that moves, and nothing is missing in it.
#[test]
fn a_moving_recording_is_fitted_and_diagnosed_by_the_zmp() {
    let (_folder, path) = log("walk.mcap", &recorded(), "");
    let robot = Arc::new(Robot::parse(&skew(), "skew.urdf").unwrap());
    let model = robot.model("sole", Snapping::default(), None).unwrap();
    let request = fit::Request {
        robot: Some(Arc::clone(&robot)),
        logs: vec![path.as_path().into()],
        support: Some("sole".into()),
        noise: Some(NOISE),
        prior: "free".into(),
        ..fit::Request::default()
    };
    let found = fit(&request, &mut ()).unwrap().identification;
    assert!(found.motion.used, "{:?}", found.motion);
    let share = found.motion.share.unwrap();
    let off = (share.value - 1.0).abs();
    assert!(off < 4.0 * share.std + 0.02, "{share:?}");
    for (parameter, truth) in found.parameters.iter().zip(model.cad_params()) {
        let Some(std) = parameter.std else { continue };
        let off = (parameter.value - truth).abs();
        assert!(off < 4.0 * std, "{}: {off} of {std}", parameter.name);
        assert!(std < 2e-3, "{}: {std}", parameter.name);
    }
    let mut request = crate::diagnose::Request::new(robot, path.as_path());
    request.support = Some("sole".into());
    request.noise = Some(NOISE);
    let found = diagnose(&request, &mut ()).unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::None, "{}", found.sentence);
    assert!(found.motion.used);
}

/// The encoder of the knee stops after 52,000 of 60,000 readings: rows are looked at to the end.
#[test]
fn an_encoder_that_stops_late_in_a_long_recording_is_found() {
    const ROWS: usize = 60_000;
    const STOPS: usize = 52_000;
    let at = |k: usize| 100.0 + 0.01 * k as f64;
    let posture = |k: usize| {
        let t = 0.01 * k as f64;
        [0.35 * (1.1 * t).sin(), 0.5 * (0.9 * t + 1.0).sin()]
    };
    let world = World::new(&Twin::from_urdf(&skew()).unwrap(), "sole").unwrap();
    let (mut noise, mut records) = (noise(NOISE), head(&["/joint_states"]));
    for k in 0..ROWS {
        let (t, q) = (at(k), posture(k));
        let read = [q[0], posture(k.min(STOPS))[1]];
        records.extend(message(10, t, &state(t, &["hip", "knee"], &read)));
        let data = in_plane(stamp(t), "sole", world.cop(&q).map(|x| x + noise()));
        records.extend(message(20, t, &data));
    }
    let robot = Arc::new(Robot::parse(&skew(), "skew.urdf").unwrap());
    let log = crate::logs::LogSource::bytes("long.mcap", file(&records));
    let mut request = crate::diagnose::Request::new(robot, log);
    request.support = Some("sole".into());
    // With a joint that stops, the other one is slow at its turns.
    request.stays = Stays::Moving;
    let found = crate::diagnose::look(&request, &mut ()).unwrap();
    let names = found.iter().map(|one| (one.kind.name(), &*one.target));
    assert_eq!(names.collect::<Vec<_>>(), [("encoder_stuck", "knee")]);
    says(&found[0].sentence, &["rows that were looked at"]);
}
