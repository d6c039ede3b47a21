//! A [`Recording`] as an MCAP file.

use std::io::{self, Write};
use std::path::Path;

use crate::files::{self, NewFile};

use super::encode::{self, VECTOR, in_plane, joint_state};
use super::writer::{McapWriter, Topic};
use super::{POINT, STATE};
use crate::logs::recording::{Recording, TrackKind};
use crate::watch::tell;
use crate::{Error, Watch};

/// Postures that are written between looks whether to go on: a millisecond's worth.
const BETWEEN_LOOKS: usize = 256;
/// The topic of joint states.
const JOINT_STATES: &str = "/joint_states";

/// A recording whose postures have these stamps (ns), as a file that is not yet in its place.
///
/// # Errors
/// When it cannot be written, or `watch` stops it.
pub(in crate::logs) fn begun(
    recording: &Recording,
    stamps: &[u64],
    path: &Path,
    watch: &mut dyn Watch,
) -> Result<NewFile, Error> {
    let file = NewFile::create(path)?;
    let total = stamps.len() as u64;
    let mut stopped = Ok(());
    let go_on = |done: usize| {
        stopped = tell(watch, "writing", done as u64, total);
        stopped.is_ok()
    };
    let file = written(recording, stamps, file, go_on);
    stopped?;
    file.map_err(|source| files::failed(path, source).into())
}

/// Place of a type among those that are written.
fn place_of(name: &str) -> usize {
    let place = encode::types().position(|(own, _)| own == name);
    place.expect("every type of a track is in the table of types")
}

/// Messages in the order of time; of one time, postures in their order. `go_on` is told how many
/// postures are written, and may end it by an error.
pub(super) fn written<W: Write>(
    recording: &Recording,
    stamps: &[u64],
    out: W,
    mut go_on: impl FnMut(usize) -> bool,
) -> io::Result<W> {
    let states = Topic {
        name: JOINT_STATES,
        schema: place_of(STATE),
        own_postures: true,
    };
    let tracks = recording.tracks.iter().map(|track| Topic {
        name: track.topic,
        schema: place_of(match track.kind {
            TrackKind::Reading | TrackKind::Point => POINT,
            TrackKind::Difference => VECTOR,
        }),
        own_postures: track.kind == TrackKind::Reading,
    });
    let topics: Vec<Topic> = [states].into_iter().chain(tracks).collect();
    let mut writer = McapWriter::begin(out, encode::types(), &topics)?;
    let dof = recording.joints.len();
    let mut order: Vec<usize> = (0..stamps.len()).collect();
    order.sort_by_key(|&k| stamps[k]);
    for (done, k) in order.into_iter().enumerate() {
        if done % BETWEEN_LOOKS == 0 && !go_on(done) {
            return Err(io::Error::other("stopped"));
        }
        let (stamp, q) = (stamps[k], &recording.q[k * dof..(k + 1) * dof]);
        writer.message(0, stamp, &joint_state(stamp, &recording.joints, q))?;
        for (topic, track) in recording.tracks.iter().enumerate() {
            let message = in_plane(stamp, &recording.frame, track.xy[k]);
            writer.message(1 + topic, stamp, &message)?;
        }
    }
    writer.finish()
}
