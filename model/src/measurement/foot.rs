//! The cells of a foot: where they stand, and what they say once one is wrong.

use crate::expr::Id;

/// What the cells of the foot say, once one of them is wrong.
pub(crate) struct Foot {
    /// The true CoP, m.
    pub(crate) cop: [Id; 2],
    /// True and felt load of each cell that is wrong, over the weight on the ground.
    pub(crate) wrong: Vec<Option<(Id, Id)>>,
}

/// Middle and half lengths of the rectangle that four cells form, m: where a CoP can
/// be. `None` where they form none, and loads of cells do not follow from the CoP.
pub fn rectangle(cells: &[[f64; 2]]) -> Option<([f64; 2], [f64; 2])> {
    let [a, b, c, d] = cells else { return None };
    let cells = [a, b, c, d];
    let extent = |axis: usize| {
        let values = cells.map(|cell| cell[axis]);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (0.5 * (high + low), 0.5 * (high - low))
    };
    let ((mx, hx), (my, hy)) = (extent(0), extent(1));
    let corner = |cell: &[f64; 2]| {
        let off = |x: f64, middle: f64, half: f64| libm::fabs(libm::fabs(x - middle) - half);
        off(cell[0], mx, hx) < 1e-6 && off(cell[1], my, hy) < 1e-6
    };
    let all = hx > 0.0 && hy > 0.0 && cells.iter().all(|cell| corner(cell));
    let side = |cell: &[f64; 2]| (cell[0] > mx, cell[1] > my);
    let distinct = (0..4).all(|k| (0..k).all(|j| side(cells[j]) != side(cells[k])));
    (all && distinct).then_some(([mx, my], [hx, hy]))
}
