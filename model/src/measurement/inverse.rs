//! The measurement backwards: the CoP that a reading was made of.
//!
//! ```text
//! p ← p + (∂F/∂p)⁻¹ (y − F(p))        from p = y
//! ```
//!
//! Newton's method with the symbolic derivative of the effect itself, unrolled:
//! near the end each round squares what is left. Where the places of foot cells are
//! known the CoP lies between them, and is kept there; the first round stays where
//! all four carry load, for beyond one of them hangs and the reading bends.
//!
//! Measured up to 0.95 of the way to the edges: 2e-13 m and less for gains 0.6 to 2,
//! offsets of 5 % of the weight, exponents 0.7 to 1.5, saturation at a quarter of the
//! weight; for a dead cell while all others touch. A reading that two CoPs have, or
//! none, has no inverse: what comes out means nothing, and may be no number.

use super::{Measured, foot};
use crate::expr::Id;

/// Rounds of Newton's method, each with the part of the way from the middle of the
/// cells to their edges that it stays within: all four touch up to a half. Roots of
/// faint loads take the most of them.
const ROUNDS: [f64; 8] = [0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];

impl Measured<'_> {
    /// Slopes of the reading that `rewrite` makes of the CoP, by those of the CoP: rows x and y.
    pub(crate) fn through(&mut self, slopes: &[Id], rewrite: impl FnOnce(&mut Self)) -> Vec<Id> {
        let cop = self.reading;
        let (free, found) = self.freely(rewrite);
        let by_cop = free.map(|x| self.g().derivative(&found, x));
        let [by_x, by_y] = by_cop.map(|by| self.g().substitute(&by, &free, &cop));
        let (x, y) = slopes.split_at(slopes.len() / 2);
        let mut rows = Vec::with_capacity(slopes.len());
        for axis in 0..2 {
            for (x, y) in x.iter().zip(y) {
                rows.push(self.g().dot(&[by_x[axis], by_y[axis]], &[*x, *y]));
            }
        }
        rows
    }

    /// A CoP that is free, and the reading that `rewrite` makes of it.
    fn freely(&mut self, rewrite: impl FnOnce(&mut Self)) -> ([Id; 2], [Id; 2]) {
        let free = self.free_cop();
        self.reading = free;
        rewrite(self);
        (free, self.reading)
    }

    /// The reading becomes the one that `rewrite` turns into it.
    pub fn solve(&mut self, rewrite: impl FnOnce(&mut Self)) {
        let goal = self.reading;
        let (free, found) = self.freely(rewrite);
        let [by_x, by_y] = free.map(|x| self.g().derivative(&found, x));
        let g = self.g();
        let [ex, ey] = [0, 1].map(|axis| g.sub(goal[axis], found[axis]));
        let minor = |a, b, c, d| {
            let whole = g.mul(a, d);
            g.sub(whole, g.mul(b, c))
        };
        let whole = minor(by_x[0], by_y[0], by_x[1], by_y[1]);
        let along_x = minor(ex, by_y[0], ey, by_y[1]);
        let along_y = minor(by_x[0], ex, by_x[1], ey);
        let step = [along_x, along_y].map(|part| g.div(part, whole));
        let next = [0, 1].map(|axis| g.add(free[axis], step[axis]));
        self.reading = self.kept(goal, ROUNDS[0]);
        for part in ROUNDS {
            let at = self.reading;
            let round = self.g().substitute(&next, &free, &at);
            self.reading = self.kept([round[0], round[1]], part);
        }
    }

    /// A CoP, no further out than this part of the way to the foot's cells.
    fn kept(&self, cop: [Id; 2], part: f64) -> [Id; 2] {
        let Some((middle, half)) = foot::rectangle(&self.cells) else {
            return cop;
        };
        [0, 1].map(|axis| {
            let most = part * half[axis];
            let [back, scale, out] = [-middle[axis], 1.0 / most, most];
            let [back, scale, out] = [back, scale, out].map(|x| self.constant(x));
            let [off, middle] = [self.add(cop[axis], back), self.constant(middle[axis])];
            let inside = self.g().clamp(self.mul(scale, off));
            self.add(self.mul(out, inside), middle)
        })
    }
}
