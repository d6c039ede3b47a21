//! The rows around a row: averaged where they are dense, as far as a log goes on.

use std::ops::Range;

use sesc_runtime::F64x8;

use crate::observations::correlation::GAP;

/// Halves of windows, s.
const HALVES_S: [f64; 4] = [0.15, 0.3, 0.6, 1.2];
/// Rows of a window on either side where they are far apart.
const SIDE: f64 = 3.4;
/// Rows are averaged over this part of half a window.
const NODE: f64 = 0.05;
/// Nodes of a whole window, at least: one beyond the five coefficients of order 4.
pub(super) const FEWEST: usize = 6;
/// Part of half a window that rows must span on either side.
const SPANNED: f64 = 0.55;

/// Rows averaged over a few milliseconds, and the windows around them.
pub(super) struct Nodes {
    pub dof: usize,
    /// Half a window, s.
    pub half: f64,
    /// Nodes further apart are beside a pause, s.
    pause: f64,
    /// Rows that are averaged to a node where they are dense.
    pub rows: usize,
    pub t: Vec<f64>,
    /// Joints of each node in blocks of eight, zero beyond the last.
    pub q: Vec<F64x8>,
    /// Blocks of a node.
    pub width: usize,
    /// The node of each row.
    pub of_row: Vec<usize>,
    /// How often the rows had moved when a node began, and when it ended.
    pub moved: Vec<[usize; 2]>,
}

impl Nodes {
    /// Place nodes over rows `step_s` apart, for windows of half `half` (s).
    pub(super) fn of(t: &[f64], q: &[f64], dof: usize, step_s: f64, half: f64) -> Nodes {
        let rows = ((NODE * half / step_s) as usize).max(1);
        let mut nodes = Nodes {
            dof,
            half,
            pause: GAP * step_s.max(NODE * half),
            rows,
            t: Vec::with_capacity(t.len() / rows + 1),
            q: Vec::with_capacity(q.len() / rows / 8 + dof),
            width: dof.div_ceil(8),
            of_row: Vec::with_capacity(t.len()),
            moved: Vec::with_capacity(t.len() / rows + 1),
        };
        let (mut count, mut moved) = (0.0_f64, 0);
        for (row, &now) in t.iter().enumerate() {
            let own = &q[row * dof..(row + 1) * dof];
            let last = row.checked_sub(1);
            let step = last.map_or(f64::INFINITY, |last| now - t[last]);
            let joins =
                count > 0.0 && (count as usize) < rows && (0.0..=NODE * half).contains(&step);
            if last.is_some_and(|last| q[last * dof..row * dof] != *own) {
                moved += 1;
            }
            if !joins {
                count = 0.0;
                nodes.t.push(0.0);
                let zero = F64x8::splat(0.0);
                nodes.q.resize(nodes.q.len() + nodes.width, zero);
                nodes.moved.push([moved; 2]);
            }
            count += 1.0;
            let node = nodes.t.len() - 1;
            nodes.of_row.push(node);
            nodes.moved[node][1] = moved;
            nodes.t[node] += (now - nodes.t[node]) / count;
            let mean = nodes.q[node * nodes.width..].iter_mut();
            for (mean, x) in mean.flat_map(|block| &mut block.0).zip(own) {
                *mean += (x - *mean) / count;
            }
        }
        nodes
    }

    /// The nodes of some rows in line, each with those that are its own.
    pub(super) fn with_rows(
        &self,
        rows: Range<usize>,
    ) -> impl Iterator<Item = (usize, Range<usize>)> {
        let mut end = rows.start;
        let nodes = self.of_row[rows].chunk_by(|a, b| a == b);
        nodes.map(move |own| {
            end += own.len();
            (own[0], end - own.len()..end)
        })
    }

    /// Positions of a node, in blocks.
    pub(super) fn blocks(&self, nodes: Range<usize>) -> &[F64x8] {
        &self.q[nodes.start * self.width..nodes.end * self.width]
    }

    /// Position of a joint in a node.
    pub(super) fn position(&self, node: usize, joint: usize) -> f64 {
        self.q[node * self.width + joint / 8].0[joint % 8]
    }

    /// Whether nothing moves in all of some nodes.
    pub(super) fn are_still(&self, around: &Range<usize>) -> bool {
        self.moved[around.start][0] == self.moved[around.end - 1][1]
    }

    /// Nodes around one without a pause.
    pub(super) fn around(&self, node: usize) -> Range<usize> {
        let here = self.t[node];
        let joins = |a: usize, b: usize| {
            let step = self.t[b] - self.t[a];
            (0.0..=self.pause).contains(&step)
        };
        let (mut first, mut last) = (node, node);
        while first > 0 && joins(first - 1, first) && here - self.t[first - 1] <= self.half {
            first -= 1;
        }
        while last + 1 < self.t.len()
            && joins(last, last + 1)
            && self.t[last + 1] - here <= self.half
        {
            last += 1;
        }
        first..last + 1
    }

    /// Whether nodes reach far enough to one side, and to the other as far as in a whole window
    /// of half `least`.
    pub(super) fn reaches(&self, node: usize, around: &Range<usize>, least: f64) -> bool {
        let here = self.t[node];
        let sides = [here - self.t[around.start], self.t[around.end - 1] - here];
        sides[0].min(sides[1]) >= SPANNED * least
            && sides[0].max(sides[1]) >= SPANNED * self.half
            && around.len() >= FEWEST
    }

    /// Every `stride`-th node whose window is whole and in which joints move, with the window.
    pub(super) fn moving(&self, stride: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
        let all = (0..self.t.len()).step_by(stride);
        let all = all.map(|node| (node, self.around(node)));
        all.filter(|(node, around)| {
            self.reaches(*node, around, self.half) && !self.are_still(around)
        })
    }
}

/// Halves of the windows that rows `step_s` apart may have, the shortest first, s; stamps that
/// jitter leave the outermost rows inside.
pub(super) fn halves(step_s: f64) -> Vec<f64> {
    let mut halves = HALVES_S.map(|half| 1.02 * half.max(SIDE * step_s)).to_vec();
    halves.dedup();
    halves
}

/// How far around a row the nodes of its window reach, s.
pub(super) fn reach(half: f64) -> f64 {
    (1.0 + 2.0 * NODE) * half
}
