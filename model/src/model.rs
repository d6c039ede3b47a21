//! The measurement model of a robot: from a URDF to the functions of its CoM.
//!
//! One pass through the stages, each importing only from those before it:
//!
//! ```text
//! urdf → tree (re-rooted) → chain → frames → base parameters → programs
//! ```

use nalgebra::{DVector, Matrix3};

use crate::base::{self, Base, Column};
use crate::bounds::{self, Bound, Formats, Precision, Unfit};
use crate::chain::{self, Chain};
use crate::effects::Instance;
use crate::frames::{self, Frame};
use crate::functions::{self, Parameters};
use crate::names;
use crate::numeric;
use crate::program::Program;
use crate::snap::Snapping;
use crate::tree::{self, Tree};
use crate::urdf::Description;
use crate::{Error, ModelFile};

/// How far beyond CAD and model file parameters may be, as a part of the robot's reach.
const ROOM: f64 = 0.02;

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

/// A robot on its support link, ready to be turned into functions.
#[derive(Debug, Clone)]
pub struct Model {
    pub tree: Tree,
    pub chain: Chain,
    pub frames: Vec<Frame>,
    pub base: Base,
    /// Identified parameters, if a model file was given.
    pub file: Option<ModelFile>,
    /// Effects of that file with their unknowns; part of [`Function::Cop`].
    pub effects: Vec<(Instance, Vec<f64>)>,
    /// Largest |r_k| that bounds hold for, m (a mass fraction for a slide's).
    pub param_limits: Vec<f64>,
    /// Identifier stem of each body: its joint, made a legal and unique word.
    pub(crate) keys: Vec<String>,
}

impl Model {
    /// Run all stages up to the base parameters.
    pub fn new(
        description: &Description,
        support: &str,
        snapping: Snapping,
    ) -> Result<Model, Error> {
        let tree = tree::reroot(description, support, snapping)?;
        let chain = chain::expand(&tree);
        let frames = frames::choose(&chain);
        let base = base::group(&tree, &chain, &frames);
        let stems = chain
            .bodies
            .iter()
            .map(|body| body.joint.as_deref().unwrap_or(&body.name));
        let keys = names::unique(stems);
        let mut model = Model {
            tree,
            chain,
            frames,
            base,
            file: None,
            effects: Vec::new(),
            param_limits: Vec::new(),
            keys,
        };
        model.param_limits = model.limits_of(&model.cad_params());
        Ok(model)
    }

    /// Number of independent joints.
    pub fn dof(&self) -> usize {
        self.tree.dofs.len()
    }

    /// CAD values of the base parameters, m.
    pub fn cad_params(&self) -> Vec<f64> {
        self.base.params.iter().map(|param| param.cad).collect()
    }

    /// The parameters to compute with: identified ones where a model file gives them.
    pub fn params(&self) -> Vec<f64> {
        match &self.file {
            Some(file) => file.values(),
            None => self.cad_params(),
        }
    }

    /// Take identified parameters from a model file.
    pub fn with_file(mut self, file: ModelFile) -> Result<Model, Error> {
        file.check(&self)?;
        self.param_limits = self.limits_of(&file.values());
        self.effects = file.instances(&self)?;
        self.file = Some(file);
        Ok(self)
    }

    /// Effects that one posture shows, with their unknowns: those of [`Function::Cop`].
    pub fn static_effects(&self) -> impl Iterator<Item = &(Instance, Vec<f64>)> {
        self.effects.iter().filter(|(i, _)| i.effect.is_static())
    }

    /// Effects of the model file that generated code leaves out, as sentences.
    pub fn left_out(&self) -> Vec<String> {
        let of_log = self.effects.iter().filter(|(i, _)| !i.effect.is_static());
        of_log
            .map(|(instance, _)| {
                format!(
                    "effect `{}` belongs to the log it was found in and is left out here",
                    instance.effect.id().name()
                )
            })
            .collect()
    }

    /// Bounds hold for CAD parameters, those of a model file, and all up to
    /// [`ROOM`] of the robot's reach beyond: what is identified differs from CAD.
    fn limits_of(&self, values: &[f64]) -> Vec<f64> {
        let reach = self.reach();
        let params = self.base.params.iter().zip(values);
        let limit = |(param, value): (&base::BaseParam, &f64)| {
            let room = match param.column {
                Column::Slide { .. } => ROOM,
                Column::Axis { .. } => ROOM * reach,
            };
            libm::fabs(param.cad).max(libm::fabs(*value)) + room
        };
        params.map(limit).collect()
    }

    /// Straight-line code of one function; `None` where it cannot be had (sines
    /// and cosines of q do not give those of q/2, which a mimic may need).
    pub fn program(&self, function: Function, given: Given) -> Option<Program> {
        functions::build(self, function, given, Parameters::Argument)
    }

    /// The same with the parameters of the model file (CAD's without one) as
    /// constants: zeros vanish, sums of constants fold.
    pub fn baked_program(&self, function: Function, given: Given) -> Option<Program> {
        functions::build(self, function, given, Parameters::Baked)
    }

    /// Binary points and the rounding bound of `program` in 32-bit fixed point.
    ///
    /// # Errors
    /// When a quantity does not fit, or an operation of effects is asked for.
    pub fn fixed_point(&self, program: &Program) -> Result<Formats, Unfit> {
        Formats::choose(program, &self.input_ranges(program))
    }

    /// Proven bound on the rounding error in 32-bit fixed point.
    pub fn rounding_fixed(&self, program: &Program, formats: &Formats) -> Bound {
        bounds::prove_fixed(program, &self.input_ranges(program), formats)
    }

    /// Proven bound on the rounding error of each kind of output.
    pub fn rounding(&self, program: &Program, precision: Precision) -> Bound {
        bounds::prove(program, &self.input_ranges(program), precision)
    }

    /// What the inputs of `program` may be: joint limits, parameters within theirs.
    pub fn input_ranges(&self, program: &Program) -> Vec<Vec<bounds::Input>> {
        let joint = |dof: &tree::Dof| bounds::Input::exact(dof.lower, dof.upper);
        let full = self.chain.full_cad();
        let parameter = |(k, param): (usize, &base::BaseParam)| {
            let size = self.param_limits[k];
            // A parameter is itself a rounded sum of rounded products.
            let sum: f64 = param
                .terms
                .iter()
                .map(|(&k, w)| libm::fabs(w * full[k]))
                .sum();
            bounds::Input {
                lower: -size,
                upper: size,
                ulps_of: sum * (8.0 + param.terms.len() as f64),
                absolute: 0.0,
                rounded: true,
            }
        };
        program
            .inputs
            .iter()
            .map(|array| match array.name {
                "q" => self.tree.dofs.iter().map(joint).collect(),
                "r" => self.base.params.iter().enumerate().map(parameter).collect(),
                "reading" => self
                    .largest_reading()
                    .map(|most| bounds::Input {
                        rounded: true,
                        ..bounds::Input::exact(-most, most)
                    })
                    .to_vec(),
                // No longer than one.
                "along" => vec![bounds::Input::exact(-1.0, 1.0); 3],
                // A slide passes its position where a turn passes its sine.
                _ => self
                    .tree
                    .dofs
                    .iter()
                    .map(|dof| match dof.prismatic {
                        true => joint(dof),
                        false => bounds::Input {
                            lower: -1.0,
                            upper: 1.0,
                            ulps_of: 0.0,
                            absolute: 0.0,
                            rounded: true,
                        },
                    })
                    .collect(),
            })
            .collect()
    }

    /// Height of the CAD CoM over the sole with every joint at zero (or at its
    /// nearest limit), m.
    pub fn cad_height(&self) -> f64 {
        let rest = |dof: &tree::Dof| 0.0_f64.max(dof.lower).min(dof.upper);
        let q: Vec<f64> = self.tree.dofs.iter().map(rest).collect();
        libm::fabs(self.com_by_sum(&q)[2])
    }

    /// How far the CoM can be from the support, m: Σ‖r_i‖ and every stroke.
    pub fn reach(&self) -> f64 {
        let reach = |body: &chain::Body| match (body.motion, body.s) {
            (tree::Motion::Slide { by, .. }, Some(s)) => body.r.norm() + s * self.tree.stroke(&by),
            _ => body.r.norm(),
        };
        self.chain.bodies.iter().map(reach).sum()
    }

    /// Largest Σ|factor| of the joints that one independent joint moves.
    pub fn largest_tie(&self) -> f64 {
        let mut sums = vec![1.0; self.dof()];
        for body in self
            .chain
            .bodies
            .iter()
            .filter(|body| body.parent.is_some())
        {
            if let tree::Motion::Turn { by, .. } | tree::Motion::Slide { by, .. } = body.motion {
                sums[by.dof] += libm::fabs(by.factor);
            }
        }
        sums.into_iter().fold(1.0, f64::max)
    }

    /// A posture inside the limits with every joint off its ends and its middle,
    /// in steps of 2^-16: the same in every scalar.
    pub fn self_test_posture(&self) -> Vec<f64> {
        // Not the first of the sequence: some way in, no joint is near another.
        let mut postures = numeric::postures(&self.tree.dofs, 8);
        let coarse = |(x, dof): (f64, &tree::Dof)| {
            let rounded = libm::rint(x * 65536.0) / 65536.0;
            match (dof.lower..=dof.upper).contains(&rounded) {
                true => rounded,
                false => x,
            }
        };
        let posture = postures.nth(7).unwrap_or_default();
        posture
            .into_iter()
            .zip(&self.tree.dofs)
            .map(coarse)
            .collect()
    }

    /// CoM as the plain sum r_0 + Σ B_i r_i over full CAD parameters, m; by
    /// numeric rotations, without frames, expressions or programs.
    pub fn com_by_sum(&self, q: &[f64]) -> [f64; 3] {
        let cad = DVector::from_vec(self.chain.full_cad());
        let com = numeric::full_regressor(&self.chain, q) * cad;
        [com[0], com[1], com[2]]
    }

    /// Index of the base parameter on canonical axis `axis` of `body`.
    pub(crate) fn axis_param(&self, body: usize, axis: usize) -> Option<usize> {
        self.position(Column::Axis { body, axis })
    }

    /// Index of the base parameter s of a sliding body.
    pub(crate) fn slide_param(&self, body: usize) -> Option<usize> {
        self.position(Column::Slide { body })
    }

    fn position(&self, column: Column) -> Option<usize> {
        // Parameters are in preorder of bodies: a binary search keeps 1000 joints linear.
        let key = |c: &Column| match *c {
            Column::Axis { body, axis } => (body, axis),
            Column::Slide { body } => (body, 3),
        };
        self.base
            .params
            .binary_search_by_key(&key(&column), |param| key(&param.column))
            .ok()
    }

    /// Canonical axes of body `i` in its link frame, as columns.
    pub(crate) fn axes(&self, i: usize) -> &Matrix3<f64> {
        &self.frames[i].axes
    }
}
