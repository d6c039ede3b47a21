//! What the inputs of an expression are.

/// An array of inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Argument {
    /// Joint positions q, rad or m.
    Positions,
    /// Sines of the joint angles; positions of prismatic joints.
    Sines,
    /// Cosines of the joint angles.
    Cosines,
    /// Joint velocities q̇, rad/s or m/s.
    Velocities,
    /// Joint accelerations q̈, rad/s² or m/s².
    Accelerations,
    /// Base parameters r, m.
    Parameters,
    /// A direction d of the support frame, ‖d‖ ≤ 1.
    Direction,
    /// A CoP reading, in the record's unit.
    Reading,
    /// Unknowns of effects.
    Unknowns,
    /// The context of a posture, beside its joint positions: of one of a log, or what effects of
    /// generated code depend on.
    Context,
    /// What an expression is solved for; never the input of a program.
    Free,
}

impl Argument {
    /// Its name in generated Rust.
    pub const fn name(self) -> &'static str {
        match self {
            Argument::Positions => "q",
            Argument::Sines => "sin",
            Argument::Cosines => "cos",
            Argument::Velocities => "qd",
            Argument::Accelerations => "qdd",
            Argument::Parameters => "r",
            Argument::Direction => "along",
            Argument::Reading => "reading",
            Argument::Unknowns => "e",
            Argument::Context => "context",
            Argument::Free => "x",
        }
    }
}
