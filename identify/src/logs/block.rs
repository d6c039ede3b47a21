//! Rows of a log, column by column, in SI units; and the CoP of two contacts together, from that of
//! each.
//!
//! ```text
//! p = (1 − s) p₁ + s T(q) p₂        s = F₂ / (F₁ + F₂)
//! ```
//!
//! T places the other sole in the support frame; the robot knows it, a log does not.

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::Rotation3;

/// Some rows of a log, column by column; every column has one entry per row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// Where the row is: line of a CSV file, row of a Parquet file, reading of
    /// an MCAP recording, each from 1.
    pub line: Vec<u64>,
    /// Rows that share it are repeated readings; counted from 0 in logs without.
    pub pose: Vec<i64>,
    /// s
    pub t: Option<Vec<f64>>,
    /// Link on the ground, from the row or else from the sidecar; empty where
    /// neither says.
    pub support: Option<Vec<Arc<str>>>,
    /// Joint values row by row, in the order of the robot's joints, rad or m.
    pub q: Vec<f64>,
    /// CoP, m, support frame.
    pub reading: Option<Vec<[f64; 2]>>,
    /// Standard deviation of `reading` as it stands in the row, m.
    pub std: Option<Vec<[f64; 2]>>,
    /// What the foot cells said.
    pub cells: Option<Cells>,
    /// Total force on the support, N, up positive or down.
    pub load: Option<Vec<f64>>,
    /// Gravity, m/s², support frame, from the row or else from the sidecar.
    pub gravity: Option<Vec<[f64; 3]>>,
    /// The other foot's share of the load, and that times its CoP in the frame of its sole, m, of
    /// logs in which each foot has its own sensor.
    #[doc(hidden)]
    pub other: Option<Vec<[f64; 3]>>,
}

/// Raw forces of the foot cells.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    /// Cells of a row.
    pub count: usize,
    /// Row by row, N.
    pub force: Vec<f64>,
    /// Standard deviation of each force as it stands in the row, N.
    pub std: Option<Vec<f64>>,
}

impl Block {
    /// Rows.
    pub fn len(&self) -> usize {
        self.line.len()
    }

    /// Joints of a row, rad or m.
    pub(crate) fn joints(&self, row: usize) -> &[f64] {
        let dof = self.q.len() / self.len().max(1);
        &self.q[row * dof..(row + 1) * dof]
    }

    /// Forces of the foot cells in a row, N; none of a log without cells.
    pub(crate) fn forces(&self, row: usize) -> &[f64] {
        let of = |cells: &Cells| row * cells.count..(row + 1) * cells.count;
        let cells = self.cells.as_ref();
        cells.map_or(&[], |cells| &cells.force[of(cells)])
    }

    /// Total force of a row on the support, N: of its own column, else of the foot cells.
    pub(crate) fn total_force(&self, row: usize) -> Option<f64> {
        match &self.load {
            Some(load) => Some(load[row].abs()),
            None => self.cells.as_ref().map(|_| self.forces(row).iter().sum()),
        }
    }

    /// Keep the rows for which `keep` says so.
    pub fn retain(&mut self, keep: &[bool]) {
        let is_kept = |row: &usize| keep.get(*row).copied().unwrap_or(true);
        *self = self.select((0..self.len()).filter(is_kept));
    }

    /// Add the rows of `other`, which has the same columns.
    pub(crate) fn append(&mut self, other: Block) {
        match self.is_empty() {
            true => *self = other,
            false => self.extend(&other, 0..other.len()),
        }
    }

    /// Some of the rows, in this order.
    pub(crate) fn select(&self, rows: impl Iterator<Item = usize> + Clone) -> Block {
        let mut block = Block::default();
        block.extend(self, rows);
        block
    }

    /// Add some rows of `other`, which has the same columns, in this order.
    fn extend(&mut self, other: &Block, rows: impl Iterator<Item = usize> + Clone) {
        let width = other.q.len() / other.len().max(1);
        extend(&mut self.line, &other.line, 1, rows.clone());
        extend(&mut self.pose, &other.pose, 1, rows.clone());
        extend(&mut self.q, &other.q, width, rows.clone());
        join(&mut self.t, &other.t, 1, rows.clone());
        join(&mut self.support, &other.support, 1, rows.clone());
        join(&mut self.reading, &other.reading, 1, rows.clone());
        join(&mut self.std, &other.std, 1, rows.clone());
        if let Some(from) = &other.cells {
            let cells = self.cells.get_or_insert_default();
            cells.count = from.count;
            extend(&mut cells.force, &from.force, from.count, rows.clone());
            join(&mut cells.std, &from.std, from.count, rows.clone());
        }
        join(&mut self.load, &other.load, 1, rows.clone());
        join(&mut self.gravity, &other.gravity, 1, rows.clone());
        join(&mut self.other, &other.other, 1, rows);
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.line.is_empty()
    }
}

/// Add the entries of some rows, `width` in each.
fn extend<T: Clone>(to: &mut Vec<T>, from: &[T], width: usize, rows: impl Iterator<Item = usize>) {
    to.reserve(width * rows.size_hint().0);
    rows.for_each(|row| to.extend_from_slice(&from[row * width..(row + 1) * width]));
}

fn join<T: Clone>(
    to: &mut Option<Vec<T>>,
    from: &Option<Vec<T>>,
    width: usize,
    rows: impl Iterator<Item = usize>,
) {
    if let Some(from) = from {
        extend(to.get_or_insert_default(), from, width, rows);
    }
}

/// Rows of `width` entries each for which `keep` says so.
pub(crate) fn keep_some<T>(values: &mut Vec<T>, width: usize, keep: &[bool]) {
    let mut at = 0;
    values.retain(|_| {
        let row = at / width.max(1);
        at += 1;
        keep.get(row).copied().unwrap_or(true)
    });
}

/// Where soles are against each other.
pub trait Soles: Debug + Send + Sync {
    /// x and y of the point `at` (m) on the sole of link `of`, seen from link `from`, where joints
    /// are at `q` (rad or m); none where nothing that a log knows holds the two together.
    fn seen(&self, q: &[f64], from: &str, of: &str, at: [f64; 2]) -> Option<[f64; 2]>;

    /// Axes and origin (m) of link `of` in the frame of link `from`, where both are of one rigid
    /// body.
    fn fixed(&self, from: &str, of: &str) -> Option<Frame>;
}

/// Axes, as columns, and origin of a frame in another one, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Its axes in the other frame.
    pub axes: [[f64; 3]; 3],
    /// m
    pub origin: [f64; 3],
}

impl Frame {
    /// The frame at x, y, z (m) with roll, pitch and yaw (rad), as a URDF turns frames.
    pub(super) fn posed([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Frame {
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        Frame {
            axes: rotation.into_inner().into(),
            origin: [x, y, z],
        }
    }

    /// A point of this frame in the other one, m.
    pub fn placed(&self, own: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(own);
        [0, 1, 2].map(|k| self.origin[k] + turned[k])
    }

    /// A vector in the other frame.
    pub fn turned(&self, own: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (0..3).map(|axis| self.axes[axis][k] * own[axis]).sum())
    }

    /// A wrench about the origin of this frame as one about that of the other.
    pub fn moved(&self, [force, torque]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        let (force, torque) = (self.turned(force), self.turned(torque));
        let at = self.origin;
        let of = |a: usize, b: usize| at[a] * force[b] - at[b] * force[a];
        let moment = [of(1, 2), of(2, 0), of(0, 1)];
        [force, [0, 1, 2].map(|k| torque[k] + moment[k])]
    }
}

/// What the other contact has of the load, and its CoP on its own sole, m.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Share {
    pub share: f64,
    pub cop: [f64; 2],
}

impl Share {
    /// The CoP of both contacts in the newest row of a block, which is told of the other one: `own`
    /// is what the support's adds to it, m; `links` are the support and the other sole.
    pub(super) fn join(
        &self,
        (soles, [from, of]): (&dyn Soles, [&str; 2]),
        own: [f64; 2],
        (q, block): (&[f64], &mut Block),
    ) -> [f64; 2] {
        let [x, y] = self.cop.map(|x| self.share * x);
        let contacts = block.other.get_or_insert_default();
        contacts.push([self.share, x, y]);
        match soles.seen(q, from, of, self.cop) {
            Some(seen) => [0, 1].map(|axis| own[axis] + self.share * seen[axis]),
            None => own.map(|x| x / (1.0 - self.share)),
        }
    }
}
