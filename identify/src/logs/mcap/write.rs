//! A [`Recording`] as an MCAP file, with the index that viewers ask for.
//!
//! Messages are CDR, little end first, and numbers are aligned to their own size from after the
//! four bytes that name the encoding, see [`cdr`](super::cdr), which reads them. The same messages
//! give the same bytes: there is no date in them.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions};

use crate::files::{self, NewFile};

use super::{OWN_POSTURES, POINT, STATE};
use crate::logs::writer::{Recording, TrackKind};
use crate::watch::tell;
use crate::{Error, Watch};

/// The topic of joint states.
const JOINT_STATES: &str = "/joint_states";

/// `geometry_msgs/msg/Vector3Stamped`, which is laid out as a point is.
pub(super) const VECTOR: &str = "geometry_msgs/msg/Vector3Stamped";

const STATE_TEXT: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
";
/// Of a point and a vector, whose words these are.
const TRIPLE_TEXT: &str = "\
std_msgs/Header header
geometry_msgs/@ $
================================================================================
MSG: geometry_msgs/@
float64 x
float64 y
float64 z
";
const HEADER_TEXT: &str = "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

impl Recording {
    /// Whether this build can write one.
    ///
    /// # Errors
    /// Where the format is left out, naming the file that was asked for.
    pub fn check_format(_: &Path) -> Result<(), Error> {
        Ok(())
    }

    /// The recording as a file, not yet in its place.
    ///
    /// # Errors
    /// Times that stamps do not hold, a file that cannot be written,
    /// [`check_format`](Self::check_format), and the kind `Interrupted` where `watch` stops it.
    pub fn begun(&self, path: &Path, watch: &mut dyn Watch) -> Result<NewFile, Error> {
        begun(self, &self.stamps()?, path, watch)
    }
}

/// A recording whose postures have these stamps (ns), as a file that is not yet in its place.
///
/// # Errors
/// When it cannot be written, or `watch` stops it.
pub(super) fn begun(
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
    let file = file.map_err(|error| match error {
        McapError::Io(source) => source,
        other => io::Error::other(other),
    });
    file.map_err(|source| files::failed(path, source).into())
}

/// Messages in the order of time; of one time, postures in their order. `go_on` is told how many
/// postures are written, and may end it by an error.
pub(super) fn written<W: Write>(
    recording: &Recording,
    stamps: &[u64],
    out: W,
    mut go_on: impl FnMut(usize) -> bool,
) -> McapResult<W> {
    let mut writer = WriteOptions::new()
        .compression(None)
        .disable_seeking(true)
        .profile("ros2")
        .library(concat!("sesc ", env!("CARGO_PKG_VERSION")))
        .create(NoSeek::new(out))?;
    let triple = |kind, field| TRIPLE_TEXT.replace('@', kind).replace('$', field);
    let states = (JOINT_STATES, STATE, STATE_TEXT.to_string(), true);
    let tracks = recording.tracks.iter().map(|track| {
        let (name, text) = match track.kind {
            TrackKind::Reading | TrackKind::Point => (POINT, triple("Point", "point")),
            TrackKind::Difference => (VECTOR, triple("Vector3", "vector")),
        };
        (track.topic, name, text, track.kind == TrackKind::Reading)
    });
    let mut channels = Vec::new();
    for (topic, name, text, own_postures) in [states].into_iter().chain(tracks) {
        let schema = writer.add_schema(name, "ros2msg", (text + HEADER_TEXT).as_bytes())?;
        let about = own_postures.then_some(OWN_POSTURES);
        let about = about.map(|[key, value]| (key.to_string(), value.to_string()));
        let about: BTreeMap<_, _> = about.into_iter().collect();
        channels.push(writer.add_channel(schema, topic, "cdr", &about)?);
    }
    let dof = recording.joints.len();
    let mut order: Vec<usize> = (0..stamps.len()).collect();
    order.sort_by_key(|&k| stamps[k]);
    for (done, k) in order.into_iter().enumerate() {
        // A millisecond's worth.
        if done % 256 == 0 && !go_on(done) {
            return Err(io::Error::other("stopped").into());
        }
        let (stamp, q) = (stamps[k], &recording.q[k * dof..(k + 1) * dof]);
        let state = joint_state(stamp, &recording.joints, q);
        let points = recording.tracks.iter();
        let points = points.map(|track| in_plane(stamp, &recording.frame, track.xy[k]));
        for (&channel_id, message) in channels.iter().zip([state].into_iter().chain(points)) {
            let header = MessageHeader {
                channel_id,
                sequence: done as u32,
                log_time: stamp,
                publish_time: stamp,
            };
            writer.write_to_known_channel(&header, &message)?;
        }
    }
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}

/// A message being put together, without the name of the encoding.
pub(super) struct Cdr(Vec<u8>);

impl Cdr {
    /// A message that begins with a header: `stamp` is in ns.
    pub fn stamped(stamp: u64, frame: &str) -> Cdr {
        let mut cdr = Cdr(Vec::new());
        // A stamp is below 2^31 s.
        cdr.u32((stamp / 1_000_000_000) as u32);
        cdr.u32((stamp % 1_000_000_000) as u32);
        cdr.text(frame);
        cdr
    }

    fn align(&mut self, size: usize) {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
    }

    fn u32(&mut self, x: u32) {
        self.align(4);
        self.0.extend(x.to_le_bytes());
    }

    pub fn f64(&mut self, x: f64) {
        self.align(8);
        self.0.extend(x.to_le_bytes());
    }

    /// A length counts the closing zero.
    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.bytes().chain([0]));
    }

    pub fn bytes(self) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &self.0].concat()
    }
}

/// A `sensor_msgs/msg/JointState` of positions `q`, rad or m, alone; `stamp` is in ns.
pub(super) fn joint_state(stamp: u64, names: &[String], q: &[f64]) -> Vec<u8> {
    let mut cdr = Cdr::stamped(stamp, "");
    cdr.u32(names.len() as u32);
    names.iter().for_each(|name| cdr.text(name));
    cdr.u32(q.len() as u32);
    q.iter().for_each(|q| cdr.f64(*q));
    // Neither velocities nor efforts.
    cdr.u32(0);
    cdr.u32(0);
    cdr.bytes()
}

/// A point or a vector (m) of the plane z = 0 in a frame; `stamp` is in ns.
pub(super) fn in_plane(stamp: u64, frame: &str, xy: [f64; 2]) -> Vec<u8> {
    let mut cdr = Cdr::stamped(stamp, frame);
    let [x, y] = xy;
    [x, y, 0.0].into_iter().for_each(|x| cdr.f64(x));
    cdr.bytes()
}

#[cfg(test)]
mod tests {
    use super::super::cdr;
    use super::*;

    /// Bytes written out by hand from the standard: `f` takes two, and the doubles begin two
    /// later.
    #[test]
    fn a_point_has_the_bytes_of_the_standard() {
        let bytes = in_plane(7_500_000_000, "f", [0.25, -2.0]);
        let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0];
        expected.extend(500_000_000_u32.to_le_bytes());
        expected.extend([2, 0, 0, 0, b'f', 0, 0, 0]);
        for x in [0.25_f64, -2.0, 0.0] {
            expected.extend(x.to_le_bytes());
        }
        assert_eq!(bytes, expected);
        let (header, at) = cdr::point(&bytes).unwrap();
        assert_eq!((header.stamp, &*header.frame), (Some(7.5), "f"));
        assert_eq!(at, [0.25, -2.0, 0.0]);
    }
}
