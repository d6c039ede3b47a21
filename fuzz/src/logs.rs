//! Posture logs of every format, told by their first bytes.

use sesc_identify::logs::{LogSource, Options, PostureReader, Sidecar};

use crate::two_link;

/// Rows that are looked at.
const ROWS: usize = 20_000;
/// What MCAP, gzip and Parquet begin with.
const MCAP: &[u8] = b"\x89MCAP0\r\n";
const GZIP: &[u8] = b"\x1f\x8b\x08";
const PARQUET: &[u8] = b"PAR1";

/// Reads all rows that come, each of which must be numbers.
pub fn read(log: impl Into<LogSource>) {
    let dofs = &two_link().1.tree.dofs;
    let Ok(mut reader) = PostureReader::open(log, dofs, &Options::default()) else {
        return;
    };
    let mut rows = 0;
    while let Ok(block) = reader.block(97) {
        if block.is_empty() || rows > ROWS {
            return;
        }
        rows += block.len();
        assert!(block.q.iter().all(|q| q.is_finite()), "an angle");
        let readings = block.reading.iter().flatten().flatten();
        assert!(readings.into_iter().all(|x| x.is_finite()), "a reading");
    }
}

fn with_cells(bytes: Vec<u8>) {
    let sidecar = Sidecar {
        cells: Some(vec![[0.01, 0.02], [0.01, -0.02], [-0.01, 0.0]]),
        ..Sidecar::default()
    };
    read(LogSource::bytes("fuzz", bytes).with_sidecar(sidecar));
}

/// Text, or anything that begins like none of the others.
pub fn csv(data: &[u8]) {
    with_cells(data.to_vec());
}

/// The same with what others begin with before it, unless it is there.
fn beginning(start: &[u8], data: &[u8]) {
    match data.starts_with(start) {
        true => with_cells(data.to_vec()),
        false => with_cells([start, data].concat()),
    }
}

/// Packed text, packed anew or as it is.
pub fn gzip(data: &[u8]) {
    beginning(GZIP, data);
}

/// A table by columns; it ends as it begins.
pub fn parquet(data: &[u8]) {
    let mut bytes = data.to_vec();
    if !bytes.ends_with(PARQUET) {
        bytes.extend(PARQUET);
    }
    beginning(PARQUET, &bytes);
}

/// A recording.
pub fn mcap(data: &[u8]) {
    beginning(MCAP, data);
}
