//! The functions that are generated, each said once: name, arguments, shape, unit.
//!
//! Both languages, `sesc inspect`, `sesc verify` and the documentation print from
//! [`Function::interface`].

use crate::robot::Robot;

/// A function of the generated interface. Not all robots have the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    Com,
    ComJacobian,
    GravityMoments,
    Regressor,
    RegressorCop,
    RegressorFull,
    Cop,
    /// The CoP that a reading was made of, where the model has effects of the sensor.
    CorrectCop,
}

impl Function {
    /// Those of a posture, which every robot has.
    pub const ALL: [Function; 7] = [
        Function::Com,
        Function::ComJacobian,
        Function::GravityMoments,
        Function::Regressor,
        Function::RegressorCop,
        Function::RegressorFull,
        Function::Cop,
    ];

    /// Its name in generated code and reports.
    pub fn name(self) -> &'static str {
        match self {
            Function::Com => "com",
            Function::ComJacobian => "com_jacobian",
            Function::GravityMoments => "gravity_moments",
            Function::Regressor => "regressor",
            Function::RegressorCop => "regressor_cop",
            Function::RegressorFull => "regressor_full",
            Function::Cop => "cop",
            Function::CorrectCop => "correct_cop",
        }
    }

    /// Axes of the support frame that its rows belong to; none where it gives a vector.
    pub fn axes(self) -> &'static [usize] {
        match self {
            Function::ComJacobian | Function::Regressor | Function::RegressorFull => &[0, 1, 2],
            Function::RegressorCop => &[0, 1],
            Function::GravityMoments => &[2],
            Function::Com | Function::Cop | Function::CorrectCop => &[],
        }
    }

    /// How many entries a row of its result has, or the whole where that is a vector.
    pub fn columns(self, robot: &Robot) -> usize {
        match self {
            Function::Com => 3,
            Function::Cop | Function::CorrectCop => 2,
            Function::ComJacobian | Function::GravityMoments => robot.dof(),
            Function::Regressor | Function::RegressorCop => robot.base.params.len(),
            Function::RegressorFull => robot.chain.full_params,
        }
    }

    /// How many rows its result has; none where that is a vector.
    pub fn rows(self) -> Option<usize> {
        Some(self.axes().len()).filter(|rows| *rows > 1)
    }

    /// Whether it takes the base parameters r.
    pub fn takes_parameters(self) -> bool {
        !matches!(
            self,
            Function::Regressor
                | Function::RegressorCop
                | Function::RegressorFull
                | Function::CorrectCop
        )
    }
}

/// What a function computes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Given {
    /// Joint positions `q`.
    Positions,
    /// Sines and cosines of the joint angles (`_sc`).
    SinesCosines,
    /// The same and a direction of the support frame, whose row alone is wanted
    /// (`_along`): several directions side by side are the rows of one posture.
    Direction,
}
