//! Recordings of diagnoses, read back.

use std::collections::BTreeMap;

use super::super::write::{VECTOR, written};
use super::super::{POINT, STATE};
use super::*;
use crate::logs::writer::{Recording, Track, TrackKind};

/// Postures, some of which are alike and too short to hold still, and one out of order.
fn recording(n: usize) -> (Recording, Vec<u64>) {
    let at = |k: usize| {
        let k = k as f64;
        [0.01 * (0.7 * k).sin(), 0.02 * (1.3 * k).cos()]
    };
    let track = |topic, kind, shift: f64| Track {
        topic,
        kind,
        xy: (0..n).map(|k| at(k).map(|x| x + shift)).collect(),
    };
    let mut stamps: Vec<u64> = (0..n as u64).map(|k| 10_001 * k * 1_000).collect();
    stamps.swap(1, 2);
    let joints = ["hip", "knee"].map(str::to_string).to_vec();
    let recording = Recording {
        frame: "sole".into(),
        joints,
        t: None,
        q: (0..2 * n)
            .map(|k| 0.3 * (0.1 * (k / 4) as f64).sin())
            .collect(),
        tracks: vec![
            track("/cop/measured", TrackKind::Reading, 0.0),
            track("/cop/cad", TrackKind::Point, 1e-3),
            track("/cop_gap/cad", TrackKind::Difference, -0.5),
        ],
    };
    (recording, stamps)
}

fn bytes_of(recording: &Recording, stamps: &[u64]) -> Vec<u8> {
    written(recording, stamps, Vec::new(), |_| true).unwrap()
}

#[test]
fn postures_and_readings_come_back_to_the_last_digit() {
    // The second is of several chunks.
    for n in [5, 6_000] {
        let (recording, stamps) = recording(n);
        let bytes = bytes_of(&recording, &stamps);
        assert_eq!(bytes, bytes_of(&recording, &stamps));
        let mut order: Vec<usize> = (0..n).collect();
        order.swap(1, 2);
        let q: Vec<f64> = order
            .iter()
            .flat_map(|k| recording.q[2 * k..2 * k + 2].to_vec())
            .collect();
        for (sidecar, track) in [("", 0), ("topic = '/cop/cad'", 1)] {
            let (block, warnings) = read(&bytes, sidecar).unwrap();
            assert!(warnings.is_empty(), "{warnings:?}");
            assert_eq!(block.pose, (0..n as i64).collect::<Vec<_>>());
            assert!(block.q == q);
            let xy: Vec<[f64; 2]> = order
                .iter()
                .map(|&k| recording.tracks[track].xy[k])
                .collect();
            assert!(block.reading == Some(xy), "{sidecar}");
            assert!(block.support.unwrap().iter().all(|link| &**link == "sole"));
            let t = block.t.unwrap();
            for (t, &k) in t.iter().zip(&order) {
                assert!((t - 1e-9 * stamps[k] as f64).abs() < 1e-9);
            }
        }
    }
}

/// What viewers jump by says what is there.
#[test]
fn the_summary_leads_to_every_chunk_and_message() {
    let (recording, stamps) = recording(6_000);
    let bytes = bytes_of(&recording, &stamps);
    let summary = ::mcap::Summary::read(&bytes).unwrap().unwrap();
    let messages = |chunk| summary.stream_chunk(&bytes, chunk).unwrap().count();
    let chunks = &summary.chunk_indexes;
    assert!(chunks.len() > 1);
    assert_eq!(chunks.iter().map(messages).sum::<usize>(), 4 * 6_000);
    assert_eq!(summary.stats.unwrap().message_count, 4 * 6_000);
}

#[test]
fn every_topic_has_its_type_and_differences_their_values() {
    let (recording, stamps) = recording(3);
    let bytes = bytes_of(&recording, &stamps);
    let (mut types, mut differences) = (BTreeMap::new(), Vec::new());
    for message in ::mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.clone().unwrap();
        // A type explains the types that it is made of.
        let text = std::str::from_utf8(&schema.data).unwrap();
        assert!(text.contains("MSG: std_msgs/Header") && text.contains("MSG: builtin_interfaces"));
        if schema.name == VECTOR {
            // Laid out as a point.
            let (header, [x, y, z]) = cdr::point(&message.data).unwrap();
            assert_eq!((&*header.frame, z), ("sole", 0.0));
            differences.push([x, y]);
        }
        types.insert(message.channel.topic.clone(), schema.name.clone());
    }
    let expected = [
        ("/cop/cad", POINT),
        ("/cop/measured", POINT),
        ("/cop_gap/cad", VECTOR),
        ("/joint_states", STATE),
    ];
    let types: Vec<(&str, &str)> = types.iter().map(|(a, b)| (&**a, &**b)).collect();
    assert_eq!(types, expected);
    let xy = &recording.tracks[2].xy;
    assert_eq!(differences, [xy[0], xy[2], xy[1]]);
}

#[test]
fn a_stopped_recording_leaves_no_file() {
    let (recording, stamps) = recording(3_000);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut stop = |progress: crate::Progress| match progress.done < 1_000 {
        true => std::ops::ControlFlow::Continue(()),
        false => std::ops::ControlFlow::Break(()),
    };
    let error = super::super::write::begun(&recording, &stamps, &path, &mut stop).err();
    assert_eq!(error.unwrap().kind(), crate::ErrorKind::Interrupted);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
