//! The ROS 2 messages that a posture is made of, from their CDR bytes.
//!
//! CDR aligns every number to its own size, counted from the end of the four
//! bytes that name the encoding (in its second edition to 4 bytes at most).
//! Strings and sequences start with their length, a u32; a string's length
//! counts its closing zero. Every length is checked against the bytes that
//! are there, so that no message can claim more than it has.

use sesc_model::urdf::limits;

const NAME: usize = limits::NAME_BYTES + 1;

/// What a message has: of its `std_msgs/msg/Header` the stamp, s, which is none where the sender left
/// it zero, and the frame; then what `content` reads of the bytes behind it.
pub(super) fn decoded<T>(
    bytes: &[u8],
    content: impl FnOnce(&mut Cdr) -> Result<T, String>,
) -> Result<(Option<f64>, String, T), String> {
    let mut cdr = Cdr::new(bytes)?;
    let seconds = i32::from_le_bytes(cdr.number()?);
    let nanoseconds = cdr.u32()?;
    let stamp = f64::from(seconds) + 1e-9 * f64::from(nanoseconds);
    let stamp = (stamp != 0.0).then_some(stamp);
    Ok((stamp, cdr.string()?, content(&mut cdr)?))
}

/// `sensor_msgs/msg/JointState`, of joints that have a position in it; effort is not looked at.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JointState {
    /// Name, position (rad or m), and velocity (rad/s or m/s), zero where it is not measured.
    pub joints: Vec<(String, f64, f64)>,
    /// Whether a joint has a name and no position.
    pub misses_positions: bool,
}

impl JointState {
    pub(super) fn decode(cdr: &mut Cdr) -> Result<JointState, String> {
        let (names, positions, velocities) = (cdr.strings()?, cdr.doubles()?, cdr.doubles()?);
        let count = names.len();
        // The standard allows a message of velocities alone.
        if !positions.is_empty() && positions.len() != count {
            return Err(format!("{} positions for {count} joints", positions.len()));
        }
        // Drivers that do not measure a velocity send nothing or NaN.
        let measured = |k: usize| velocities.get(k).copied().filter(|v| v.is_finite());
        let all = names.into_iter().zip(positions).enumerate();
        let known = all.filter(|(_, (_, q))| q.is_finite());
        let joints: Vec<_> = known
            .map(|(k, (name, q))| (name, q, measured(k).unwrap_or(0.0)))
            .collect();
        Ok(JointState {
            misses_positions: joints.len() < count,
            joints,
        })
    }
}

/// Force (N) and torque (Nm) of a `geometry_msgs/msg/WrenchStamped`.
pub(super) fn wrench(cdr: &mut Cdr) -> Result<[[f64; 3]; 2], String> {
    Ok([cdr.vector()?, cdr.vector()?])
}

/// Place (m) of a `geometry_msgs/msg/PointStamped`.
pub(super) fn point(cdr: &mut Cdr) -> Result<[f64; 3], String> {
    cdr.vector()
}

/// Bytes being decoded.
pub(super) struct Cdr<'a> {
    /// Without the encoding's name: alignment counts from here.
    body: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Largest alignment.
    widest: usize,
}

impl<'a> Cdr<'a> {
    fn new(bytes: &'a [u8]) -> Result<Cdr<'a>, String> {
        let (name, body) = bytes
            .split_first_chunk::<4>()
            .ok_or("a message of less than 4 bytes")?;
        let widest = match name[..2] {
            [0, 0 | 1] => 8,
            [0, 6 | 7] => 4,
            _ => {
                return Err(format!(
                    "a message in the unknown encoding {:02x?}",
                    &name[..2]
                ));
            }
        };
        Ok(Cdr {
            body,
            at: 0,
            big_endian: name[1].is_multiple_of(2),
            widest,
        })
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.body.get(self.at..end));
        let taken = taken
            .ok_or_else(|| format!("a message that ends after {} of its bytes", self.body.len()))?;
        self.at += count;
        Ok(taken)
    }

    /// A number of `N` bytes in the order of this machine's reading: little end first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let align = N.min(self.widest);
        let gap = self.at.next_multiple_of(align) - self.at;
        self.take(gap)?;
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.number()?))
    }

    fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.number()?))
    }

    /// The length of a sequence whose items take `least` bytes or more.
    fn length(&mut self, least: usize) -> Result<usize, String> {
        let length = self.u32()? as usize;
        let left = self.body.len() - self.at;
        if length > left / least {
            return Err(format!(
                "a message that claims {length} items in {left} bytes"
            ));
        }
        Ok(length)
    }

    fn string(&mut self) -> Result<String, String> {
        let length = self.length(1)?;
        if length > NAME {
            return Err(format!("a message with a name of {length} bytes"));
        }
        let text = self.take(length)?;
        let text = text.strip_suffix(&[0]).unwrap_or(text);
        let text = std::str::from_utf8(text);
        text.map(str::to_string)
            .map_err(|_| "a message whose names are not text".to_string())
    }

    fn strings(&mut self) -> Result<Vec<String>, String> {
        let count = self.length(4)?;
        if count > limits::LINKS {
            return Err(format!("a message with {count} names"));
        }
        (0..count).map(|_| self.string()).collect()
    }

    fn doubles(&mut self) -> Result<Vec<f64>, String> {
        // The gap before the first item belongs to the sequence: an empty one has none.
        (0..self.length(8)?).map(|_| self.f64()).collect()
    }

    fn vector(&mut self) -> Result<[f64; 3], String> {
        Ok([self.f64()?, self.f64()?, self.f64()?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written out by hand from the standard: strings of odd lengths before doubles.
    #[test]
    fn both_byte_orders_and_editions_decode_alike() {
        let value = 0.25f64;
        for (kind, big, wide) in [(0, true, 8), (1, false, 8), (6, true, 4), (7, false, 4)] {
            let mut body: Vec<u8> = Vec::new();
            let word = |body: &mut Vec<u8>, x: u32| {
                body.resize(body.len().next_multiple_of(4), 0);
                body.extend(if big {
                    x.to_be_bytes()
                } else {
                    x.to_le_bytes()
                });
            };
            let double = |body: &mut Vec<u8>, x: f64| {
                body.resize(body.len().next_multiple_of(wide), 0);
                body.extend(if big {
                    x.to_be_bytes()
                } else {
                    x.to_le_bytes()
                });
            };
            word(&mut body, 7);
            word(&mut body, 500_000_000);
            word(&mut body, 2);
            body.extend(b"f\0");
            word(&mut body, 2);
            word(&mut body, 6);
            body.extend(b"ankle\0");
            word(&mut body, 4);
            body.extend(b"hip\0");
            word(&mut body, 2);
            double(&mut body, value);
            double(&mut body, -value);
            word(&mut body, 0);
            word(&mut body, 0);
            let mut bytes = vec![0, kind, 0, 0];
            bytes.extend(body);
            let (stamp, frame, message) = decoded(&bytes, JointState::decode).unwrap();
            assert_eq!((stamp, &*frame), (Some(7.5), "f"));
            let joint = |name: &str, q| (name.to_string(), q, 0.0);
            let expected = [joint("ankle", value), joint("hip", -value)];
            assert_eq!(message.joints, expected);
            // Effort may be missing, nothing else.
            for cut in 0..bytes.len() - 4 {
                assert!(decoded(&bytes[..cut], JointState::decode).is_err(), "{cut}");
            }
            let mut body = Vec::new();
            word(&mut body, 7);
            word(&mut body, 500_000_000);
            word(&mut body, 5);
            body.extend(b"sole\0");
            (1..=6).for_each(|k| double(&mut body, f64::from(k)));
            let bytes = [vec![0, kind, 0, 0], body].concat();
            let (stamp, frame, [force, torque]) = decoded(&bytes, wrench).unwrap();
            assert_eq!((stamp, &*frame), (Some(7.5), "sole"));
            assert_eq!((force, torque), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
        }
    }

    #[test]
    fn claims_beyond_the_message_are_refused() {
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend([0; 8]);
        bytes.extend(u32::MAX.to_le_bytes());
        let message = decoded(&bytes, point).unwrap_err();
        assert!(message.contains("claims 4294967295"), "{message}");
        let message = decoded(&[0, 9, 0, 0], wrench).unwrap_err();
        assert!(message.contains("encoding"), "{message}");
    }
}
