//! A row to be written, in any format.

/// The columns of a log besides the joints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Written {
    /// `t`
    pub t: bool,
    /// `support`
    pub support: bool,
    /// `cop_x`, `cop_y`
    pub cop: bool,
    /// `cop_x_std`, `cop_y_std`
    pub cop_std: bool,
}

/// One row; what the log has no column for is not looked at.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row<'a> {
    /// Rows that share it are repeated readings.
    pub pose: i64,
    /// s
    pub t: f64,
    /// Link on the ground.
    pub support: &'a str,
    /// rad or m, in the order of the robot's joints
    pub q: &'a [f64],
    /// m, support frame
    pub cop: [f64; 2],
    /// Standard deviation of a single reading, m.
    pub cop_std: [f64; 2],
}

/// Joint values and readings of a row, in the order of their columns.
pub(super) fn numbers<'a>(row: &'a Row, columns: Written) -> impl Iterator<Item = f64> + 'a {
    let cop = columns.cop.then_some(row.cop).into_iter().flatten();
    let std = columns.cop_std.then_some(row.cop_std).into_iter().flatten();
    row.q.iter().copied().chain(cop).chain(std)
}
