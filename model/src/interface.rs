//! The functions that are generated, each said once: name, arguments, shape, unit.
//!
//! Both languages, `sesc inspect`, `sesc verify` and the documentation print from
//! [`Function::interface`].

use crate::expr::Argument;
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
    pub fn columns(self) -> Extent {
        match self {
            Function::Com => Extent::Fixed(3),
            Function::Cop | Function::CorrectCop => Extent::Fixed(2),
            Function::ComJacobian | Function::GravityMoments => Extent::Dof,
            Function::Regressor | Function::RegressorCop => Extent::BaseParams,
            Function::RegressorFull => Extent::FullParams,
        }
    }

    /// Its arguments, in order.
    pub fn arguments(self, given: Given) -> Vec<Argument> {
        if self == Function::CorrectCop {
            return vec![Argument::Reading];
        }
        let mut arguments = match given {
            Given::Positions => vec![Argument::Positions],
            Given::SinesCosines | Given::Direction => vec![Argument::Sines, Argument::Cosines],
        };
        if self.takes_parameters() {
            arguments.push(Argument::Parameters);
        }
        if given == Given::Direction {
            arguments.push(Argument::Direction);
        }
        arguments
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

/// A length that is a constant of every generated module.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Extent {
    /// The same for every robot.
    Fixed(usize),
    /// Independent joints.
    Dof,
    /// Base parameters.
    BaseParams,
    /// Parameters of the full chain.
    FullParams,
}

impl Extent {
    /// The length of an input array of generated functions; none for those of fits.
    pub fn of(argument: Argument) -> Extent {
        match argument {
            Argument::Positions | Argument::Sines | Argument::Cosines => Extent::Dof,
            Argument::Parameters => Extent::BaseParams,
            Argument::Direction => Extent::Fixed(3),
            Argument::Reading | Argument::Free => Extent::Fixed(2),
            Argument::Unknowns | Argument::Context => Extent::Fixed(0),
        }
    }

    /// The length on a robot.
    pub fn on(self, robot: &Robot) -> usize {
        match self {
            Extent::Fixed(n) => n,
            Extent::Dof => robot.dof(),
            Extent::BaseParams => robot.base.params.len(),
            Extent::FullParams => robot.chain.full_params,
        }
    }
}
