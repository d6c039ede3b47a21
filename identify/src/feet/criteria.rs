//! Every number that decides what is said of soles and of readings on two feet; chosen, not
//! calibrated.

/// What the soles say of joints.
pub mod closure {
    /// χ² from which a column is more than noise: five standard deviations. Chosen: by chance
    /// in one column of 1,700,000 (closed form); half of it in one of 2500.
    pub const CLEAR: f64 = 25.0;
    /// Joints named in a sentence. Chosen: it shortens a sentence alone.
    pub const NAMED: usize = 4;
    /// A slope that is none, m/rad or rad/rad. Chosen: far below what any joint has, far above
    /// rounding.
    pub const NO_SLOPE: f64 = 1e-9;
    /// What an explanation leaves is more than noise from this part of it on. Chosen: half of
    /// it calls a fit of soles that bend a little unexplained.
    pub const MORE: f64 = 3.0;
    /// An offset that is known no better, rad or m, is not known. Chosen: 29°; half of it
    /// leaves offsets unnamed that soles do show.
    pub const UNKNOWN: f64 = 0.5;
}

/// Whether readings are of both feet together.
pub mod one_foot {
    /// CAD's CoP moves at least so much, RMS, before anything can be said, m. Chosen: half of
    /// it judges by noise.
    pub const MOVES_M: f64 = 5e-3;
    /// Readings of both feet go with it by more than this. Chosen: half of it takes readings of
    /// one foot for both.
    pub const GOES_WITH: f64 = 0.4;
    /// Standard errors by which it has to be less. Chosen: one log of 740 by chance (closed
    /// form).
    pub const ERRORS: f64 = 3.0;
    /// Postures that say it. Chosen: with half as many a correlation is off by 0.4 (closed
    /// form, 1/√n).
    pub const FEWEST: usize = 10;
}
