//! Postures with points of the sole plane, in time, as a recording of ROS 2 that viewers show.
//!
//! ```text
//! posture k ─▶ JointState at t_k, and a point or a vector (x, y, 0) of each track at t_k
//! ```
//!
//! Stamps are whole nanoseconds from 0 to 2^31 s. Times that reach beyond begin at zero.

use crate::Error;

/// Stamps of ROS 2 count seconds in a signed number of 32 bits.
const LARGEST_S: f64 = 2_147_483_648.0;

/// Postures and what is shown of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The link in whose frame points are.
    pub frame: String,
    /// Names of the joints, in the order of `q`.
    pub joints: Vec<String>,
    /// Time of each posture, s; one posture a second from 0 unless given.
    pub t: Option<Vec<f64>>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// What is shown of every posture; readings come first.
    pub tracks: Vec<Track>,
}

/// Points or vectors in the sole plane, one for each posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Its topic.
    pub topic: &'static str,
    /// What they are.
    pub kind: TrackKind,
    /// x and y of each, m.
    pub xy: Vec<[f64; 2]>,
}

/// What a track is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrackKind {
    /// The CoP that was read: a log that is read from the recording has it.
    Reading,
    /// Points.
    Point,
    /// Differences of points.
    Difference,
}

impl Recording {
    /// Stamp of each posture, ns.
    ///
    /// # Errors
    /// Times that stamps do not hold.
    pub(super) fn stamps(&self) -> Result<Vec<u64>, Error> {
        let Some(t) = &self.t else {
            let n = self.tracks.first().map_or(0, |track| track.xy.len());
            return Ok((0..n as u64).map(|k| k * 1_000_000_000).collect());
        };
        let first = t.iter().copied().fold(f64::INFINITY, f64::min);
        let last = t.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let origin = match first >= 0.0 && last < LARGEST_S {
            true => 0.0,
            false => first,
        };
        if last - origin >= LARGEST_S {
            return Err(Error::request(format!(
                "the times of the log span {:.3e} s, and stamps of ROS 2 hold 2^31 s; give the \
                 log its column `t` in seconds",
                last - first
            )));
        }
        let stamp = |t: &f64| ((t - origin) * 1e9).round() as u64;
        Ok(t.iter().map(stamp).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::says;

    fn at(t: Option<Vec<f64>>) -> Recording {
        let track = Track {
            topic: "/cop",
            kind: TrackKind::Reading,
            xy: vec![[0.0; 2]; 3],
        };
        Recording {
            frame: "foot".into(),
            joints: vec!["hip".into()],
            t,
            q: vec![0.0; 3],
            tracks: vec![track],
        }
    }

    #[test]
    fn stamps_are_those_of_the_log_where_they_can_be() {
        const SECOND: u64 = 1_000_000_000;
        let stamps = |t: [f64; 3]| at(Some(t.to_vec())).stamps();
        assert_eq!(at(None).stamps().unwrap(), [0, SECOND, 2 * SECOND]);
        let today = stamps([1.7e9, 1.7e9 + 0.5, 1.7e9 + 1.0]).unwrap();
        assert_eq!(today[1], 1_700_000_000_500_000_000);
        let early = stamps([-2.0, 0.0, 0.5]).unwrap();
        assert_eq!(early, [0, 2 * SECOND, 5 * SECOND / 2]);
        // Milliseconds since 1970: the day is lost, the order is not.
        let milli = stamps([1.7e12, 1.7e12 + 5.0, 1.7e12]).unwrap();
        assert_eq!(milli[1], 5 * SECOND);
        let said = stamps([0.0, 1.0, 3e9]).unwrap_err().to_string();
        says(said, &["3.000e9 s", "`t` in seconds"]);
    }
}
