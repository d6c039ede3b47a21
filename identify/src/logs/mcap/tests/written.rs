//! Recordings of diagnoses, read back.

use std::collections::BTreeMap;

use super::super::encode::VECTOR;
use super::super::write::written;
use super::super::{POINT, STATE};
use super::*;
use crate::logs::recording::{Recording, Track, TrackKind};

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

#[test]
fn postures_and_readings_come_back_to_the_last_digit() {
    // The second is of several chunks.
    for n in [5, 6_000] {
        let (recording, stamps) = recording(n);
        let bytes = written(&recording, &stamps, Vec::new(), |_| true).unwrap();
        assert_eq!(
            bytes,
            written(&recording, &stamps, Vec::new(), |_| true).unwrap()
        );
        let mut order: Vec<usize> = (0..n).collect();
        order.swap(1, 2);
        let q: Vec<f64> = order
            .iter()
            .flat_map(|k| recording.q[2 * k..2 * k + 2].to_vec())
            .collect();
        for (topic, track) in [("", 0), ("/cop/cad", 1)] {
            let sidecar = match topic {
                "" => String::new(),
                topic => format!("topic = \"{topic}\""),
            };
            let (block, warnings) = read(&bytes, &sidecar).unwrap();
            assert!(warnings.is_empty(), "{warnings:?}");
            assert_eq!(block.pose, (0..n as i64).collect::<Vec<_>>());
            assert!(block.q == q);
            let xy: Vec<[f64; 2]> = order
                .iter()
                .map(|&k| recording.tracks[track].xy[k])
                .collect();
            assert!(block.reading == Some(xy), "{topic}");
            assert!(block.support.unwrap().iter().all(|link| &**link == "sole"));
            let t = block.t.unwrap();
            for (t, &k) in t.iter().zip(&order) {
                assert!((t - 1e-9 * stamps[k] as f64).abs() < 1e-9);
            }
        }
    }
}

/// Records of the file itself, those of chunks not among them: opcode, place and content.
fn outer(bytes: &[u8]) -> Vec<(u8, usize, &[u8])> {
    let (mut at, mut found) = (8, Vec::new());
    while at < bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        found.push((bytes[at], at, &bytes[at + 9..at + 9 + length]));
        at += 9 + length;
    }
    found
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

/// What viewers jump by leads to what the standard says is there.
#[test]
fn the_summary_leads_to_every_chunk_and_message() {
    let (recording, stamps) = recording(6_000);
    let bytes = written(&recording, &stamps, Vec::new(), |_| true).unwrap();
    let records = outer(&bytes);
    let of = |opcode: u8| -> Vec<&[u8]> {
        let own = records.iter().filter(|record| record.0 == opcode);
        own.map(|record| record.2).collect()
    };
    let (chunks, indexes) = (of(0x06), of(0x08));
    assert!(chunks.len() > 1 && chunks.len() == indexes.len());
    let mut messages = 0;
    for (chunk, about) in chunks.iter().zip(indexes) {
        let start = u64_at(about, 16) as usize;
        assert_eq!(
            (bytes[start], u64_at(about, 24)),
            (0x06, chunk.len() as u64 + 9)
        );
        assert_eq!(about[..16], chunk[..16]);
        // Behind the compression's name: four letters are three.
        let packed = &chunk[28 + 4 + 3 + 8..];
        let unpacked = super::super::records::unpack("lz4", packed, u64_at(chunk, 16)).unwrap();
        // Four topics, 10 bytes each.
        assert_eq!(u32::from_le_bytes(about[32..36].try_into().unwrap()), 40);
        for entry in about[36..76].chunks(10) {
            let at = u64_at(entry, 2) as usize;
            assert_eq!((bytes[at], &bytes[at + 9..at + 11]), (0x07, &entry[..2]));
            let length = u32::from_le_bytes(bytes[at + 11..at + 15].try_into().unwrap()) as usize;
            for message in bytes[at + 15..at + 15 + length].chunks(16) {
                let own = &unpacked[u64_at(message, 8) as usize..];
                assert_eq!((own[0], &own[9..11]), (0x05, &entry[..2]));
                assert_eq!(own[15..23], message[..8], "its time");
                messages += 1;
            }
        }
    }
    assert_eq!(messages, 4 * 6_000);
    assert_eq!(u64_at(of(0x0b)[0], 0), 4 * 6_000);
    let (_, place, footer) = *records.last().unwrap();
    let summary = u64_at(footer, 0) as usize;
    assert_eq!(bytes[summary], 0x03);
    assert_eq!(bytes[u64_at(footer, 8) as usize], 0x0e);
    let mut crc = flate2::Crc::new();
    crc.update(&bytes[summary..place + 25]);
    assert_eq!(footer[16..], crc.sum().to_le_bytes());
    for group in of(0x0e) {
        let (from, length) = (u64_at(group, 1) as usize, u64_at(group, 9) as usize);
        assert_eq!(bytes[from], group[0]);
        assert!(length > 9 && from + length <= place);
    }
}

#[test]
fn every_topic_has_its_type_and_differences_their_values() {
    let (recording, stamps) = recording(3);
    let bytes = written(&recording, &stamps, Vec::new(), |_| true).unwrap();
    let mut records = Records::new(&bytes[..]).unwrap();
    let (mut types, mut differences) = (BTreeMap::new(), Vec::new());
    while let Some(message) = records.next().unwrap() {
        let channel = records.channel_of(&message).unwrap();
        if channel.schema == VECTOR {
            // Laid out as a point.
            let (header, [x, y, z]) = cdr::point(records.data(&message)).unwrap();
            assert_eq!((&*header.frame, z), ("sole", 0.0));
            differences.push([x, y]);
        }
        types.insert(channel.topic.clone(), channel.schema.clone());
    }
    let expected = [
        ("/cop/cad", POINT),
        ("/cop/measured", POINT),
        ("/cop_gap/cad", VECTOR),
        ("/joint_states", STATE),
    ];
    let expected = expected.map(|(topic, schema)| (topic.to_string(), schema.to_string()));
    assert_eq!(types, BTreeMap::from(expected));
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
    let error = super::super::begun(&recording, &stamps, &path, &mut stop).err();
    assert_eq!(error.unwrap().kind(), crate::ErrorKind::Interrupted);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
