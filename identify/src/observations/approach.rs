//! From which side joints came to where they stand.

use sesc_model::tree::Dof;

use super::criteria::approach::{LEAST_M, LEAST_RAD};

/// The sides of all joints, row by row: the sign of the last move that is no noise of an encoder,
/// 0 before the first.
#[derive(Debug, Clone)]
pub(crate) struct Approach {
    /// The least move of each joint that counts, rad or m.
    least: Vec<f64>,
    /// Where each joint was when its side was last told, rad or m.
    told_at: Vec<f64>,
    sides: Vec<f64>,
}

impl Approach {
    /// Before the first row of a log of these joints.
    pub(crate) fn of(joints: &[Dof]) -> Approach {
        let least = joints.iter().map(|joint| match joint.prismatic {
            true => LEAST_M,
            false => LEAST_RAD,
        });
        Approach {
            least: least.collect(),
            told_at: Vec::new(),
            sides: vec![0.0; joints.len()],
        }
    }

    /// Sides at the next row, whose joints stand at `q`.
    pub(crate) fn at(&mut self, q: &[f64]) -> &[f64] {
        if self.told_at.is_empty() {
            self.told_at = q.to_vec();
        }
        let joints = self.told_at.iter_mut().zip(&mut self.sides);
        for (((told_at, side), q), least) in joints.zip(q).zip(&self.least) {
            let moved = q - *told_at;
            if moved.abs() > *least {
                (*told_at, *side) = (*q, moved.signum());
            }
        }
        &self.sides
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_moves_count_once_they_are_a_large_one() {
        let mut approach = Approach {
            least: vec![LEAST_RAD],
            told_at: Vec::new(),
            sides: vec![0.0],
        };
        let walked = [0.1, 0.1005, 0.102, 0.1037, 0.101, 0.2, 0.19, 0.1899];
        let sides: Vec<f64> = walked.iter().map(|q| approach.at(&[*q])[0]).collect();
        assert_eq!(sides, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, -1.0, -1.0]);
    }
}
