//! Every number that decides what is said of soles and of readings on two feet; chosen, not
//! calibrated.

/// What the soles say of joints.
pub mod closure {
    /// χ² from which a column is more than noise: five standard deviations.
    pub const CLEAR: f64 = 25.0;
    /// Joints named in a sentence.
    pub const NAMED: usize = 4;
    /// A slope that is none, m/rad or rad/rad.
    pub const NO_SLOPE: f64 = 1e-9;
    /// What an explanation leaves is more than noise from this part of it on.
    pub const MORE: f64 = 3.0;
    /// An offset that is known no better, rad or m, is not known.
    pub const UNKNOWN: f64 = 0.5;
}

/// Whether readings are of both feet together.
pub mod one_foot {
    /// CAD's CoP moves at least so much, RMS, before anything can be said, m.
    pub const MOVES_M: f64 = 5e-3;
    /// Readings of both feet go with it by more than this.
    pub const GOES_WITH: f64 = 0.4;
    /// Standard errors by which it has to be less.
    pub const ERRORS: f64 = 3.0;
    /// Postures that say it.
    pub const FEWEST: usize = 10;
}
