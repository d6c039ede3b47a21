//! Where the CoP may be, and how far it must stay away from the edge.
//!
//! ```text
//! the sole     n_e · c ≤ d_e                      every edge e, n_e of length one
//! balanced     n_e · c + margin + k √(n_eᵀ Σ n_e) ≤ d_e        Σ = φ S Sᵀ φᵀ
//! ```
//!
//! Σ is what CAD does not know about the CoP of this posture: the covariance S Sᵀ
//! of the parameters through the regressor rows φ. Along every edge's normal the
//! true CoP then keeps within it by k standard deviations.

use std::path::Path;

use nalgebra::{Matrix2, Vector2};
use sesc_model::files;

use crate::observations::postures::range;
use crate::{Error, Setting, message};

/// A convex region of the sole plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corners, counter-clockwise, m.
    pub corners: Vec<[f64; 2]>,
    /// Kept from the edge, m.
    pub margin: f64,
    /// Why it is so, where nobody said.
    pub source: Option<&'static str>,
    edges: Vec<(Vector2<f64>, f64)>,
}

/// No foot is larger, m.
const LARGEST: f64 = 10.0;

impl Region {
    /// |x|, |y| ≤ `half`.
    ///
    /// # Errors
    /// A square too small to aim at.
    pub fn square(half: f64, margin: f64) -> Result<Region, Error> {
        let corners = [[half, half], [-half, half], [-half, -half], [half, -half]];
        let hull = Region::hull(corners.to_vec(), margin);
        hull.filter(|_| half.is_finite() && half > 0.0)
            .ok_or_else(|| {
                let small = format!(" {half}: too small for any foot; give metres, 0.0001 or more");
                Error::request(message![Setting::CopBox, small])
            })
    }

    /// The convex hull of a foot's points: `x,y; x,y; …`, or a file with a point a line.
    ///
    /// # Errors
    /// Points that are not numbers or enclose nothing.
    pub fn sole(given: &str, margin: f64) -> Result<Region, Error> {
        let path = Path::new(given);
        let inline = given.contains(';');
        let text = match inline {
            true => given.replace(';', "\n"),
            false => files::read_text(path, files::SETTINGS).map_err(|source| {
                let takes = " takes a file of points, or \"x,y; x,y; …\"";
                Error::read(given, source).saying(message![Setting::Sole, takes])
            })?,
        };
        let mut points = Vec::new();
        for (k, line) in text.lines().enumerate() {
            let line = line.trim();
            let heading = k == 0 && !inline && line.starts_with(|c: char| c.is_alphabetic());
            if line.is_empty() || line.starts_with('#') || heading {
                continue;
            }
            let numbers: Vec<Option<f64>> = line
                .split([',', ' ', '\t'])
                .filter(|cell| !cell.is_empty())
                .map(|cell| cell.parse().ok().filter(|x: &f64| x.abs() <= LARGEST))
                .collect();
            let [Some(x), Some(y)] = numbers[..] else {
                let point = format!(": point {} `{line}`", k + 1);
                let remedy = ": give x,y in metres in the support frame";
                return Err(Error::request(message![Setting::Sole, point, remedy]));
            };
            points.push([x, y]);
        }
        Region::hull(points, margin).ok_or_else(|| {
            let flat = ": the points enclose nothing; give three or more corners, x,y in metres";
            Error::request(message![Setting::Sole, flat])
        })
    }

    /// The convex hull of points, by the monotone chain.
    pub(crate) fn hull(mut points: Vec<[f64; 2]>, margin: f64) -> Option<Region> {
        points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        points.dedup();
        let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
            (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
        };
        let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            let mut chain: Vec<[f64; 2]> = Vec::new();
            for p in points {
                while chain.len() >= 2
                    && cross(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
                {
                    chain.pop();
                }
                chain.push(p);
            }
            chain.pop();
            chain
        };
        let mut corners = half(&mut points.iter().copied());
        corners.extend(half(&mut points.iter().rev().copied()));
        let n = corners.len();
        let area: f64 = (0..n)
            .map(|k| cross([0.0; 2], corners[k], corners[(k + 1) % n]))
            .sum();
        if n < 3 || area < 1e-8 {
            return None;
        }
        let edge = |k: usize| {
            let [a, b] = [corners[k], corners[(k + 1) % n]].map(Vector2::from);
            let along = (b - a).normalize();
            let normal = Vector2::new(along.y, -along.x);
            (normal, normal.dot(&a))
        };
        let edges = (0..n).map(edge).collect();
        Some(Region {
            corners,
            margin,
            source: None,
            edges,
        })
    }

    /// How far the CoP is beyond what is allowed, m; negative when balanced.
    pub(crate) fn violation(
        &self,
        cop: Vector2<f64>,
        covariance: &Matrix2<f64>,
        sigmas: f64,
    ) -> f64 {
        let beyond = |(normal, distance): &(Vector2<f64>, f64)| {
            let std = normal.dot(&(covariance * normal)).max(0.0).sqrt();
            normal.dot(&cop) + self.margin + sigmas * std - distance
        };
        range(self.edges.iter().map(beyond)).1
    }

    /// The mean of the corners.
    pub(crate) fn centre(&self) -> Vector2<f64> {
        let sum: Vector2<f64> = self.corners.iter().map(|&c| Vector2::from(c)).sum();
        sum / self.corners.len() as f64
    }

    /// Smallest and largest x and y.
    pub fn bounds(&self) -> [(f64, f64); 2] {
        [0, 1].map(|axis| range(self.corners.iter().map(|c| c[axis])))
    }

    /// In a few words.
    pub fn sentence(&self) -> String {
        let [(x0, x1), (y0, y1)] = self.bounds();
        let margin = match self.margin {
            0.0 => String::new(),
            m => format!(", {:.1} mm from its edge", 1e3 * m),
        };
        let source = self
            .source
            .map_or_else(String::new, |why| format!(", {why}"));
        let square = self.corners.len() == 4 && x0 == -x1 && y0 == -y1 && x1 == y1;
        match square {
            true => format!("|x|, |y| <= {:.1} mm{margin}{source}", 1e3 * x1),
            false => format!(
                "a sole of {} corners, x {:.1} to {:.1} mm, y {:.1} to {:.1} mm{margin}{source}",
                self.corners.len(),
                1e3 * x0,
                1e3 * x1,
                1e3 * y0,
                1e3 * y1
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_what_it_says() {
        let square = Region::square(0.02, 0.001).unwrap();
        let zero = Matrix2::zeros();
        assert!((square.violation(Vector2::new(0.015, -0.018), &zero, 2.0) + 0.001).abs() < 1e-15);
        let std = Matrix2::from_diagonal(&Vector2::new(1e-6, 4e-6));
        // Edges at 20 mm; 15 + 1 + 2 · 1 mm along x, 12 + 1 + 2 · 2 mm along y.
        assert!((square.violation(Vector2::new(0.015, 0.012), &std, 2.0) + 0.002).abs() < 1e-12);
        let said = "|x|, |y| <= 20.0 mm, 1.0 mm from its edge";
        assert_eq!(square.sentence(), said);
    }

    #[test]
    fn a_sole_is_the_hull_of_its_points() {
        let sole = Region::sole("0,0; 0.1,0; 0.05,0.02; 0.1,0.05; 0,0.05", 0.0).unwrap();
        let corners = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.05], [0.0, 0.05]];
        assert_eq!(sole.corners, corners);
        assert_eq!(sole.bounds(), [(0.0, 0.1), (0.0, 0.05)]);
        let outside = sole.violation(Vector2::new(0.12, 0.02), &Matrix2::zeros(), 2.0);
        assert!((outside - 0.02).abs() < 1e-15);
        let flat = ["0,0; 1,0", "0,0; 1,0; 2,0"];
        let odd = ["0,0; 1,x; 1,1", "0,0; NaN,1; 1,1", "0;1;2"];
        for bad in odd.into_iter().chain(flat) {
            assert!(Region::sole(bad, 0.0).is_err(), "{bad}");
        }
        let said = Region::sole("gone.csv", 0.0).unwrap_err().to_string();
        assert!(said.contains("gone.csv"), "{said}");
    }
}
