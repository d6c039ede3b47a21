//! Further experiments on the same robot, and what becomes of an effect in them.

/// What one can do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Experiment {
    /// New postures on the same foot.
    Postures,
    /// The same postures after a turn by 180° on the floor.
    Turned,
    /// Postures on the other foot.
    OtherFoot,
    /// The same postures with a known mass on a link.
    KnownWeight,
    /// The same postures, each approached from the other side.
    BothSides,
    /// The same postures with raw loads of the cells.
    RawCells,
    /// The same postures without whatever touches the robot.
    Untouched,
}

impl Experiment {
    /// All of them.
    pub const ALL: [Experiment; 7] = [
        Experiment::Postures,
        Experiment::Turned,
        Experiment::OtherFoot,
        Experiment::KnownWeight,
        Experiment::BothSides,
        Experiment::RawCells,
        Experiment::Untouched,
    ];

    /// Its name in sidecar files.
    pub fn name(self) -> &'static str {
        match self {
            Experiment::Postures => "postures",
            Experiment::Turned => "turned",
            Experiment::OtherFoot => "other_foot",
            Experiment::KnownWeight => "known_weight",
            Experiment::BothSides => "both_sides",
            Experiment::RawCells => "raw_cells",
            Experiment::Untouched => "untouched",
        }
    }
}

/// What becomes of an effect's unknowns in an experiment.
#[derive(Debug, Clone, PartialEq)]
pub enum Carry {
    /// They are the same.
    Same,
    /// Each is multiplied by its factor.
    Scaled(Vec<f64>),
    /// The effect is not there.
    Gone,
}
