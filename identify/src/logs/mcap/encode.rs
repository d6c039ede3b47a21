//! Messages of ROS 2 as CDR, little end first, and what their types are.
//!
//! Numbers are aligned to their own size from after the four bytes that name the encoding,
//! see [`cdr`](super::cdr), which reads them.

use super::{POINT, STATE};

/// `geometry_msgs/msg/Vector3Stamped`, which is laid out as a point is.
pub(super) const VECTOR: &str = "geometry_msgs/msg/Vector3Stamped";

const STATE_TEXT: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
";
const POINT_TEXT: &str = "\
std_msgs/Header header
geometry_msgs/Point point
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
";
const VECTOR_TEXT: &str = "\
std_msgs/Header header
geometry_msgs/Vector3 vector
================================================================================
MSG: geometry_msgs/Vector3
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

/// Every type that is written: its name and its text, without the header's.
const TYPES: [(&str, &str); 3] = [
    (STATE, STATE_TEXT),
    (POINT, POINT_TEXT),
    (VECTOR, VECTOR_TEXT),
];

/// Names and whole texts of the types that are written, in the order of their numbers from 1.
pub(super) fn types() -> impl Iterator<Item = (&'static str, String)> {
    TYPES
        .iter()
        .map(|(name, text)| (*name, format!("{text}{HEADER_TEXT}")))
}

/// A message being put together, without the name of the encoding.
struct Cdr(Vec<u8>);

impl Cdr {
    /// A message that begins with a header: `stamp` is in ns.
    fn stamped(stamp: u64, frame: &str) -> Cdr {
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

    fn f64(&mut self, x: f64) {
        self.align(8);
        self.0.extend(x.to_le_bytes());
    }

    /// A length counts the closing zero.
    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.bytes().chain([0]));
    }

    fn bytes(self) -> Vec<u8> {
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
    use super::super::cdr::{self, JointState};
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

    #[test]
    fn joint_states_are_read_as_they_were_written() {
        let names = ["hip", "knee_left"].map(str::to_string);
        for q in [[0.1, -0.2], [f64::MIN_POSITIVE, 1e300]] {
            let state = JointState::decode(&joint_state(1, &names, &q)).unwrap();
            assert_eq!(state.header.stamp, Some(1e-9));
            assert_eq!(state.name, names);
            assert_eq!((state.position, state.velocity), (q.to_vec(), vec![]));
        }
    }

    #[test]
    fn every_type_explains_the_types_that_it_is_made_of() {
        for (name, text) in types() {
            let known: Vec<&str> = text
                .lines()
                .filter_map(|line| line.strip_prefix("MSG: "))
                .collect();
            let fields = text.lines().filter(|line| !line.contains("MSG: "));
            let made_of = fields.filter_map(|line| line.split(' ').next());
            for part in made_of.filter(|part| part.contains('/')) {
                assert!(known.contains(&part), "{name}: {part}");
            }
            assert!(known.contains(&"builtin_interfaces/Time"));
        }
    }
}
