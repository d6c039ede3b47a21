//! Damaged files: whatever the bytes, an answer or an error, never a panic.

use std::fs;
use std::path::Path;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::super::*;
use super::{dofs, gzip};

const TIMES: usize = 20_000;

/// Read `bytes` damaged in many ways. One in a hundred must be refused, or the
/// damage was not of a kind that tells.
fn survive(name: &str, bytes: &[u8], times: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let sidecar = "cells = [[0.01, 0.02], [0.01, -0.02], [-0.01, 0.0]]";
    fs::write(Sidecar::path(&path), sidecar).unwrap();
    fs::write(&path, bytes).unwrap();
    assert!(read(&path).unwrap() > 0);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut refused = 0;
    for _ in 0..times {
        fs::write(&path, damaged(bytes, &mut rng)).unwrap();
        refused += usize::from(read(&path).is_err());
    }
    assert!(refused > times / 100, "only {refused} were refused");
}

fn read(path: &Path) -> Result<usize, crate::Error> {
    let mut reader = PostureReader::open(path, &dofs(&["hip", "knee"]), &Options::default())?;
    let mut rows = 0;
    loop {
        let block = reader.block(7)?;
        if block.is_empty() {
            return Ok(rows);
        }
        rows += block.len();
        assert!(block.q.iter().all(|q| q.is_finite()));
        let readings = block.reading.iter().flatten().flatten();
        assert!(readings.into_iter().all(|x| x.is_finite()));
    }
}

/// A few bytes changed, put in, left out, doubled or cut off.
fn damaged(bytes: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..bytes.len().max(1));
        let end = (at + rng.random_range(1..9)).min(bytes.len());
        let odd = [0, 1, 0x7f, 0x80, 0xff, b'"', b',', b'\n', b'-', b'9'];
        match rng.random_range(0..6) {
            0 => bytes[at..end].fill(odd[rng.random_range(0..odd.len())]),
            1 => bytes.insert(at, rng.random()),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.extend_from_within(at..end),
            4 if rng.random_range(0..4) == 0 => bytes.truncate(at.max(1)),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << rng.random_range(0..8);
                }
            }
        }
        if bytes.is_empty() {
            bytes.push(b'x');
        }
    }
    bytes
}

fn table() -> String {
    let header = "pose,t,support,hip,knee,cop_x,cop_y,cop_x_std,cop_y_std,fsr_1,fsr_2,fsr_3\n";
    let row = |k| format!("{k},{k}.5,sole,0.{k},-0.2,0.01,0.02,0.05,0.05,1,2,{k}\n");
    header.to_string() + &(0..9).map(row).collect::<String>()
}

#[test]
fn csv_survives_packed_or_not() {
    survive("log.csv", table().as_bytes(), TIMES);
    survive("log.csv.gz", &gzip(table().as_bytes()), TIMES);
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_survives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    let columns = Written {
        support: true,
        cop: true,
        ..Written::default()
    };
    let mut writer = PostureWriter::create(&path, &dofs(&["hip", "knee"]), columns).unwrap();
    for k in 0..9 {
        let row = Row {
            pose: k,
            support: "sole",
            q: &[0.5, 0.25 * k as f64],
            cop: [0.01, 0.02],
            ..Row::default()
        };
        writer.row(&row).unwrap();
    }
    writer.finish(&Sidecar::default()).unwrap();
    survive("log.parquet", &fs::read(&path).unwrap(), TIMES);
}

#[cfg(feature = "mcap")]
#[test]
fn mcap_survives() {
    for compression in ["", "lz4"] {
        survive("log.mcap", &mcap::tests::recording(compression), TIMES / 2);
    }
}
