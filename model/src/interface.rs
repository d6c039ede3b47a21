//! The functions that are generated, each said once: name, arguments, shape, unit.
//!
//! Both languages, `sesc inspect`, `sesc verify` and the documentation print from
//! [`Function::interface`].

use crate::expr::Argument;
use crate::robot::Robot;

/// What is said of a generated function once, for every place that prints it.
#[derive(Debug, Clone, Copy)]
pub struct Interface {
    /// Its name in generated code and reports.
    pub name: &'static str,
    /// What its result is called in C.
    pub result: &'static str,
    /// Axes of the support frame that its rows belong to; none where it gives a vector.
    pub axes: &'static [usize],
    /// How many entries a row of its result has, or the whole where that is a vector.
    pub columns: Extent,
    /// Whether it takes the base parameters r.
    pub takes_parameters: bool,
    /// Unit of its result.
    pub unit: &'static str,
    /// One sentence about it.
    pub sentence: &'static str,
    /// The same in ASCII, as C has it.
    pub ascii: &'static str,
}

/// Sentences about [`Function::Cop`] where the model has effects: one, and one in ASCII.
const COP_WITH_EFFECTS: [&str; 2] = [
    "Predicted reading of the CoP in a static posture, with the effects at the top of this \
     file, m unless they change its unit.",
    "CoP reading that a static posture gives, with the effects named above, m.",
];

/// A function of the generated interface. Not all robots have the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// The centre of mass.
    Com,
    /// Its derivative with respect to joint positions.
    ComJacobian,
    /// The velocity of the centre of mass.
    ComVelocity,
    /// The moments that gravity exerts about the joints.
    GravityMoments,
    /// The base regressor of the CoM.
    Regressor,
    /// Its x and y rows.
    RegressorCop,
    /// The regressor of all parameters of the chain.
    RegressorFull,
    /// The predicted reading of the centre of pressure.
    Cop,
    /// Its derivative with respect to what encoders read.
    CopJacobian,
    /// The zero-moment point of a robot that moves.
    Zmp,
    /// The CoP that a reading was made of, where the model has effects of the sensor.
    CorrectCop,
}

const XYZ: &[usize] = &[0, 1, 2];

impl Function {
    /// Those of a posture, which every robot has.
    pub const ALL: [Function; 10] = [
        Function::Com,
        Function::ComJacobian,
        Function::ComVelocity,
        Function::GravityMoments,
        Function::Regressor,
        Function::RegressorCop,
        Function::RegressorFull,
        Function::Cop,
        Function::CopJacobian,
        Function::Zmp,
    ];

    /// The table of functions: the one place that says what each is.
    pub const fn interface(self) -> Interface {
        match self {
            Function::Com => Interface {
                name: "com",
                result: "com",
                axes: &[],
                columns: Extent::Fixed(3),
                takes_parameters: true,
                unit: "m",
                sentence: "Centre of mass in the support frame, m: r_0 + Σ B_i(q) r_i, Eq. (4).",
                ascii: "Centre of mass in the support frame, m: r_0 + sum of B_i(q) r_i.",
            },
            Function::ComJacobian => Interface {
                name: "com_jacobian",
                result: "jac",
                axes: XYZ,
                columns: Extent::Dof,
                takes_parameters: true,
                unit: "m/rad (m/m for prismatic joints)",
                sentence: "∂CoM/∂q, m/rad (m/m for prismatic joints), one row per axis.",
                ascii: "d CoM / d q, m/rad (m/m for prismatic joints), row-major: x, y, z.",
            },
            Function::ComVelocity => Interface {
                name: "com_velocity",
                result: "velocity",
                axes: &[],
                columns: Extent::Fixed(3),
                takes_parameters: true,
                unit: "m/s",
                sentence: "Velocity of the centre of mass, m/s: J(q) q̇ without forming J.",
                ascii: "Velocity of the centre of mass, m/s, without the Jacobian.",
            },
            Function::GravityMoments => Interface {
                name: "gravity_moments",
                result: "moments",
                axes: &[2],
                columns: Extent::Dof,
                takes_parameters: true,
                unit: "m",
                sentence: "The moment that gravity exerts about each joint, per kg of total mass \
                           times g, m: −∂CoM_z/∂q; a motor that holds the posture applies the \
                           opposite.",
                ascii: "The moment that gravity exerts about each joint, per kg of total mass \
                        times g, m: -d CoM_z / d q; a motor that holds the posture applies the \
                        opposite.",
            },
            Function::Regressor => Interface {
                name: "regressor",
                result: "rows",
                axes: XYZ,
                columns: Extent::BaseParams,
                takes_parameters: false,
                unit: "1 (m for prismatic joints)",
                sentence: "Rows of the base regressor: CoM = rows · r.",
                ascii: "Rows of the base regressor, row-major: CoM = rows r.",
            },
            Function::RegressorCop => Interface {
                name: "regressor_cop",
                result: "rows",
                axes: &[0, 1],
                columns: Extent::BaseParams,
                takes_parameters: false,
                unit: "1 (m for prismatic joints)",
                sentence: "The x and y rows of the base regressor: CoP = rows · r.",
                ascii: "The x and y rows of the base regressor, row-major: CoP = rows r.",
            },
            Function::RegressorFull => Interface {
                name: "regressor_full",
                result: "rows",
                axes: XYZ,
                columns: Extent::FullParams,
                takes_parameters: false,
                unit: "1 (m for prismatic joints)",
                sentence: "Rows [B_0 B_1 …] of the full regressor, Eq. (5), in link frames.",
                ascii: "Rows [B_0 B_1 ...] of the full regressor in link frames, row-major.",
            },
            Function::Cop => Interface {
                name: "cop",
                result: "cop",
                axes: &[],
                columns: Extent::Fixed(2),
                takes_parameters: true,
                unit: "m",
                sentence: "Centre of pressure that a static posture shows on a level sole, m.",
                ascii: "Centre of pressure of a static posture on a level sole, m.",
            },
            Function::CopJacobian => Interface {
                name: "cop_jacobian",
                result: "jac",
                axes: &[0, 1],
                columns: Extent::Dof,
                takes_parameters: true,
                unit: "m/rad (m/m for prismatic joints)",
                sentence: "∂cop/∂q, m/rad (m/m for prismatic joints), rows x and y: how the \
                           predicted reading moves with what encoders read.",
                ascii: "d cop / d q, m/rad (m/m for prismatic joints), row-major: x, y; how the \
                        predicted reading moves with what encoders read.",
            },
            Function::Zmp => Interface {
                name: "zmp",
                result: "zmp",
                axes: &[],
                columns: Extent::Fixed(2),
                takes_parameters: true,
                unit: "m",
                sentence: "Zero-moment point, m: c − (c_z c̈ + L̇⊥/M)/(g + c̈_z), L̇ by the URDF's masses and inertias.",
                ascii: "Zero-moment point on the level sole plane, m: c and its acceleration by r, \
                        angular momentum by the URDF's masses and inertias.",
            },
            Function::CorrectCop => Interface {
                name: "correct_cop",
                result: "cop",
                axes: &[],
                columns: Extent::Fixed(2),
                takes_parameters: false,
                unit: "m",
                sentence: "The CoP, m, that a reading (as `cop` predicts it) was made of: inverts \
                           the effects of the sensor.",
                ascii: "CoP behind a reading, m: the inverse of the sensor's effects.",
            },
        }
    }

    /// What effects of the model mean for it, where any acts on it.
    pub const fn effects_sentence(self) -> Option<&'static str> {
        match self {
            Function::Com | Function::ComVelocity | Function::Zmp => Some(
                "Of the robot as it is when its encoders read q: with the effects named above.",
            ),
            Function::ComJacobian => Some(
                "With respect to what encoders read, of the robot with the effects named above.",
            ),
            Function::GravityMoments => Some(
                "About the joints of the robot with the effects named above, per kg of the \
                 mass with its loads.",
            ),
            Function::Regressor | Function::RegressorCop | Function::RegressorFull => {
                Some("With the wiring, offsets and scales named above; rows know no masses.")
            }
            Function::Cop | Function::CopJacobian | Function::CorrectCop => None,
        }
    }

    /// Unit of an error of its result, of revolute joints where those differ; empty for a
    /// plain number.
    pub fn error_unit(self) -> &'static str {
        let unit = self.interface().unit;
        match unit.split_once(" (").map_or(unit, |(unit, _)| unit) {
            "1" => "",
            unit => unit,
        }
    }

    /// Its name in generated code and reports.
    pub const fn name(self) -> &'static str {
        self.interface().name
    }

    /// The function of a posture that has this name.
    pub fn named(name: &str) -> Option<Function> {
        Function::ALL.into_iter().find(|f| f.name() == name)
    }

    /// Its sentence, and that in ASCII, where the model has effects or none.
    pub const fn sentences(self, with_effects: bool) -> [&'static str; 2] {
        match (self, with_effects) {
            (Function::Cop, true) => COP_WITH_EFFECTS,
            _ => [self.interface().sentence, self.interface().ascii],
        }
    }

    /// Axes of the support frame that its rows belong to; none where it gives a vector.
    pub const fn axes(self) -> &'static [usize] {
        self.interface().axes
    }

    /// How many rows its result has; none where that is a vector.
    pub fn rows(self) -> Option<usize> {
        Some(self.axes().len()).filter(|rows| *rows > 1)
    }

    /// How many entries a row of its result has, or the whole where that is a vector.
    pub const fn columns(self) -> Extent {
        self.interface().columns
    }

    /// Whether it takes the base parameters r.
    pub const fn takes_parameters(self) -> bool {
        self.interface().takes_parameters
    }

    /// Its arguments, in order.
    #[doc(hidden)]
    pub fn arguments(self, given: Given) -> Vec<Argument> {
        if self == Function::CorrectCop {
            return vec![Argument::Reading];
        }
        let mut arguments = match given {
            Given::Positions => vec![Argument::Positions],
            Given::SinesCosines | Given::Direction => vec![Argument::Sines, Argument::Cosines],
        };
        if let Function::ComVelocity | Function::Zmp = self {
            arguments.push(Argument::Velocities);
        }
        if self == Function::Zmp {
            arguments.push(Argument::Accelerations);
        }
        if self.takes_parameters() {
            arguments.push(Argument::Parameters);
        }
        if given == Given::Direction {
            arguments.push(Argument::Direction);
        }
        arguments
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
    /// What effects depend on beside positions and parameters: time, approach, columns of a log.
    Context,
}

impl Extent {
    /// The length of an input array of generated functions; none for those of fits.
    #[doc(hidden)]
    pub fn of(argument: Argument) -> Extent {
        match argument {
            Argument::Positions
            | Argument::Sines
            | Argument::Cosines
            | Argument::Velocities
            | Argument::Accelerations => Extent::Dof,
            Argument::Parameters => Extent::BaseParams,
            Argument::Direction => Extent::Fixed(3),
            Argument::Reading | Argument::Free => Extent::Fixed(2),
            Argument::Context => Extent::Context,
            Argument::Unknowns => Extent::Fixed(0),
        }
    }

    /// The length on a robot.
    pub fn on(self, robot: &Robot) -> usize {
        match self {
            Extent::Fixed(n) => n,
            Extent::Dof => robot.dof(),
            Extent::BaseParams => robot.base.params.len(),
            Extent::FullParams => robot.chain.full_params,
            // Effects have one, robots none.
            Extent::Context => 0,
        }
    }
}
