//! Robots to generate C for, with their servos and effects.

use std::path::Path;

use nalgebra::DMatrix;
use sesc_codegen::emit::c::{self, Options, Package, Scalar, Servos, Setting};
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::PORTABLE;
use sesc_identify::robot::Robot;
use sesc_model::expr::Argument;
use sesc_model::tape::{Tape, Values};
use sesc_model::{
    EffectRecord, Function, Given, Information, Model, ModelFile, Quantity, Snapping,
};

use sesc_test_support::exact::{Double, Number as _};
use sesc_test_support::trees::{Kind, tree};

use super::draw::Draw;
use super::entry::Entry;

pub(crate) const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Robot folder under `robots/`, and a support.
pub(crate) const ROBOTS: [(&str, &str); 9] = [
    ("op2", "r_sole"),
    ("op2", "body_link"),
    ("arm6", "base_link"),
    ("quadruped", "lf_foot"),
    ("lift_base", "base_link"),
    ("lift_base", "hand"),
    ("skew_humanoid", "left_sole"),
    ("plain_humanoid", "right_sole"),
    ("two_link", "foot"),
];

pub(crate) const SCALARS: [Scalar; 3] = [Scalar::F64, Scalar::F32, Scalar::Fixed32];

/// An effect, its target and its parameters.
type Named<'a> = (&'a str, &'a str, &'a [(&'a str, f64)]);

/// A payload, and a spring.
pub(crate) const LOAD: &[(&str, f64)] = &[
    ("mass_kg", 0.4),
    ("x_m", 0.02),
    ("y_m", -0.01),
    ("z_m", 0.05),
];
pub(crate) const SOFT: &[(&str, f64)] = &[("stiffness_nm_per_rad", 300.0)];

/// A robot on a support, with servos.
pub(crate) struct Case {
    /// Prefix of its C names.
    pub name: String,
    pub model: Model,
    pub servos: Servos,
    /// What is generated and called.
    pub functions: Vec<Function>,
    /// Whether the estimator is wanted, in floats.
    pub estimator: bool,
    /// Lanes of functions of many postures, in floats.
    pub lanes: Option<u32>,
}

/// What a joint's tick is: zero, and radians or metres a tick.
#[derive(Clone, Copy)]
pub(crate) struct Servo {
    pub zero: i32,
    pub per_tick: f64,
    /// Ticks a turn, negative where the servo runs backwards.
    pub resolution: f64,
}

impl Servo {
    /// The angle of `away` ticks from zero, 2π away / resolution, beyond doubles.
    pub(crate) fn turned(self, away: f64) -> Double {
        let turn = Double {
            high: std::f64::consts::TAU,
            low: 2.4492935982947064e-16,
        };
        Double::of(away).mul(turn).over(self.resolution)
    }
}

impl Case {
    pub(crate) fn new(model: Model, name: &str, servos: Servos) -> Case {
        Case {
            name: c::suggest(name),
            model,
            servos,
            functions: Function::ALL.to_vec(),
            estimator: false,
            lanes: None,
        }
    }

    /// With functions of many postures, in floats.
    pub(crate) fn of_many(mut self, lanes: u32) -> Case {
        self.lanes = Some(lanes);
        self.name += &format!("_x{lanes}");
        self
    }

    /// One of `robots/`.
    pub(crate) fn robot(robot: &str, support: &str) -> Case {
        let path = Path::new(ROOT).join(format!("robots/{robot}/{robot}.urdf"));
        let read = Robot::read(&path).unwrap();
        let model = read.model(support, Snapping::default(), None).unwrap();
        let servos = match support {
            "r_sole" => Servos::default(),
            _ => servos(&model),
        };
        let case = Case::new(model, &format!("{robot}_{support}"), servos);
        match (robot, support) {
            ("skew_humanoid" | "plain_humanoid" | "op2", _) => case.standing(),
            _ => case,
        }
    }

    /// Without the ZMP, of which compilers would make thousands of instructions once more; the
    /// OP2's is run by `tests/firmware` and `tests/c_packages`.
    fn standing(mut self) -> Case {
        self.functions.retain(|function| *function != Function::Zmp);
        self
    }

    /// A random tree of `joints` joints of every type.
    pub(crate) fn random(seed: u64, joints: usize) -> Case {
        let kind = Kind {
            joints,
            canonical: false,
            revolute: false,
            chained: 0.6,
        };
        let (text, links) = tree(seed, kind);
        let support = &links[seed as usize % links.len()];
        let case = Case::of_text(&text, support, &format!("random_{seed}"));
        match joints > 8 {
            true => case.standing(),
            false => case,
        }
    }

    pub(crate) fn of_text(text: &str, support: &str, name: &str) -> Case {
        let robot = Robot::parse(text, &format!("{name}.urdf")).unwrap();
        let model = robot.model(support, Snapping::Off, None).unwrap();
        let servos = servos(&model);
        Case::new(model, name, servos)
    }

    /// The two-link robot with an effect.
    pub(crate) fn with_effect(effect: &str, target: &str, parameter: (&str, f64)) -> Case {
        let case = Case::robot("two_link", "foot");
        case.and(effect, &[(effect, target, &[parameter])])
    }

    /// Takes a model file whose parameters are CAD's, changed.
    pub(crate) fn take_values(&mut self, change: impl Fn(usize, f64) -> f64) {
        let cad = self.model.cad_params();
        let values: Vec<f64> = cad.iter().enumerate().map(|(k, x)| change(k, *x)).collect();
        let file = ModelFile::from_values(&self.model, &values, None, "data");
        self.model = self.model.clone().with_file(file).unwrap();
    }

    /// With the estimator, and a model file that knows its parameters from 30 postures and a
    /// prior of 2 cm.
    pub(crate) fn informed(self) -> Case {
        let model = &self.model;
        let n = model.base.params.len();
        let q = 0..30 * model.dof();
        let q: Vec<f64> = q.map(|k| (0.7 * k as f64).sin()).collect();
        let rows = self.tape(Function::RegressorCop, &q, &[], &Draw::default());
        let rows = DMatrix::from_row_slice(rows.len() / n, n, &rows) * 1e3;
        let mut all = DMatrix::identity(n + rows.nrows(), n) * 50.0;
        all.rows_mut(n, rows.nrows()).copy_from(&rows);
        let fresh = || ModelFile::from_values(model, &model.cad_params(), None, "data");
        let mut file = model.file.clone().unwrap_or_else(fresh);
        file.inform(Information::of(&all));
        Case {
            model: self.model.clone().with_file(file).unwrap(),
            estimator: true,
            ..self
        }
    }

    /// With effects, each with its target and parameters; `what` ends the name.
    pub(crate) fn and(mut self, what: &str, effects: &[Named]) -> Case {
        let mut file = ModelFile::from_values(&self.model, &self.model.cad_params(), None, "data");
        file.cells = vec![[0.1, 0.06], [0.1, -0.06], [-0.1, -0.06], [-0.1, 0.06]];
        let known =
            |&(name, value): &(&str, f64)| (name.to_string(), Quantity { value, std: None });
        let record = |&(effect, target, parameters): &Named| EffectRecord {
            effect: effect.to_string(),
            target: target.to_string(),
            parameters: parameters.iter().map(known).collect(),
            ..EffectRecord::default()
        };
        file.effects = effects.iter().map(record).collect();
        self.model = self.model.with_file(file).unwrap();
        self.name += &format!("_{what}");
        self
    }

    /// Effects whose reading divides, clamps or takes powers.
    pub(crate) fn of_cells() -> Vec<Case> {
        let cases = [
            Case::with_effect("cell_gain", "fsr_1", ("gain", 0.8)),
            Case::with_effect("cell_exponent", "fsr_2", ("exponent", 1.1)),
            Case::with_effect("cell_saturation", "fsr_3", ("level_n", 15.0)),
            Case::with_effect("backlash", "knee", ("width_rad", 0.05)),
        ];
        cases.map(Case::standing).into()
    }

    /// Effects that act on every function of the body, and leave all of them smooth.
    pub(crate) fn bodies() -> [Case; 5] {
        [
            Case::with_effect("joint_compliance", "all", ("stiffness_nm_per_rad", 200.0)),
            Case::with_effect("joint_offset", "knee", ("offset_rad", 0.03)),
            Case::with_effect("joint_scale", "knee", ("scale", 1.05)),
            Case::robot("two_link", "foot").and("payload", &[("payload", "shank", LOAD)]),
            Case::robot("op2", "r_sole").and(
                "bent",
                &[
                    ("payload", "body_link", LOAD),
                    ("joint_compliance", "r_knee", SOFT),
                    ("joint_compliance", "r_ank_pitch", SOFT),
                    ("joint_offset", "r_knee", &[("offset_rad", 0.03)]),
                ],
            ),
        ]
    }

    /// Scalars it can be had in: fixed point does not divide or take powers, as cells do.
    pub(crate) fn scalars(&self) -> &'static [Scalar] {
        let of_cell = |name: &str| name.starts_with("cell_");
        let effects = &self.model.effects;
        match effects.iter().any(|(i, _)| of_cell(i.effect.id().name())) {
            false => &SCALARS,
            true => &SCALARS[..2],
        }
    }

    pub(crate) fn has_springs(&self) -> bool {
        let of_spring = |name| name == "joint_compliance";
        let mut effects = self.model.effects.iter();
        effects.any(|(i, _)| of_spring(i.effect.id().name()))
    }

    pub(crate) fn package(&self, scalar: Scalar) -> Package {
        let mut options = Options::of(scalar);
        options.servos = Some(self.servos.clone());
        options.estimator = scalar != Scalar::Fixed32 && self.estimator;
        options.lanes = self.lanes.filter(|_| scalar != Scalar::Fixed32);
        // What is not called need not be optimised or read by linters.
        let facts = Facts::with(&self.model, &self.functions);
        let package = c::package(&facts, &self.name, &options);
        package.unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// Every C function there must be: the load on the ground divides the ZMP, which fixed
    /// point does not.
    pub(crate) fn entries(&self, scalar: Scalar) -> Vec<Entry> {
        let mut entries = Vec::new();
        let divides = |function| function == Function::Zmp && scalar == Scalar::Fixed32;
        let functions = self.functions().into_iter();
        for (function, baked) in functions.filter(|(function, _)| !divides(*function)) {
            let stem = match baked {
                true => format!("model_{}", function.name()),
                false => function.name().to_string(),
            };
            for (given, suffix) in [
                (Some(Given::Positions), ""),
                (Some(Given::SinesCosines), "_sc"),
                (None, "_ticks"),
            ] {
                let entry = Entry {
                    function,
                    baked,
                    given,
                    name: format!("{stem}{suffix}"),
                    width: 0,
                };
                let of_ticks = given.is_none();
                if let Some(program) = entry.program(self)
                    && (!of_ticks || self.takes_ticks(&entry))
                {
                    let width = program.outputs.len();
                    entries.push(Entry { width, ..entry });
                }
            }
        }
        entries
    }

    /// Ticks become sines where the CoM can be had from those, else positions.
    fn takes_ticks(&self, entry: &Entry) -> bool {
        let sines = Some(Given::SinesCosines);
        let entry_of = |function, given| Entry {
            function,
            given,
            ..entry.clone()
        };
        entry_of(Function::Com, sines).program(self).is_none()
            || entry_of(entry.function, sines).program(self).is_some()
    }

    /// Functions, and whether their parameters are constants.
    fn functions(&self) -> Vec<(Function, bool)> {
        let mut functions: Vec<(Function, bool)> =
            self.functions.iter().map(|f| (*f, false)).collect();
        if self.model.file.is_some() {
            use Function::{Com, ComJacobian, Cop, CopJacobian};
            let baked = [Com, ComJacobian, Cop, CopJacobian];
            let baked = baked.into_iter().filter(|f| self.functions.contains(f));
            functions.extend(baked.map(|function| (function, true)));
        }
        functions
    }

    /// What each joint's servo is, read from the settings by their documentation.
    pub(crate) fn servos(&self) -> Vec<Servo> {
        let dofs = self.model.tree.dofs.iter();
        dofs.map(|dof| {
            let own = self.servos.joints.get(&dof.joint).cloned();
            let own = own.unwrap_or_default();
            let sign = f64::from(own.sign.unwrap_or(1));
            let resolution = sign * own.resolution.unwrap_or(4096.0);
            Servo {
                zero: own.zero.unwrap_or(2048),
                resolution,
                per_tick: match dof.prismatic {
                    true => sign * own.metres_per_tick.unwrap(),
                    false => std::f64::consts::TAU / resolution,
                },
            }
        })
        .collect()
    }

    /// Results of `function` by the tape; one row of `q`, `r` and the joint motion that it
    /// takes per posture.
    pub(crate) fn tape(&self, function: Function, q: &[f64], r: &[f64], drawn: &Draw) -> Vec<f64> {
        let [qd, qdd] = drawn.motion(function);
        let program = self.model.program(function, Given::Positions).unwrap();
        let tape = Tape::new(&program);
        let count = q.len() / self.model.dof();
        let mut out = vec![0.0; count * tape.outputs()];
        let arguments = function.arguments(Given::Positions).into_iter();
        let arguments = arguments.map(|argument| match argument {
            Argument::Velocities => qd,
            Argument::Accelerations => qdd,
            Argument::Parameters => r,
            _ => q,
        });
        let arguments: Vec<Values> = arguments.map(Values::PerPosture).collect();
        tape.run(&arguments, count, &mut out, PORTABLE);
        out
    }
}

/// Robots, with and without a model file; one has long names.
pub(crate) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = ROBOTS.iter().map(|(r, s)| Case::robot(r, s)).collect();
    cases.push(Case::robot("skew_humanoid", "right_sole"));
    cases.extend((0..4).map(|k| Case::random(740 + k, 3 + 4 * k as usize)));
    for (robot, support) in [
        ("op2", "l_sole"),
        ("lift_base", "base_link"),
        ("two_link", "foot"),
    ] {
        let mut case = Case::robot(robot, support);
        case.take_values(|_, x| x);
        case.name += "_model";
        cases.push(case);
    }
    cases.push(estimating());
    cases.extend(Case::of_cells());
    cases.extend(Case::bodies());
    cases.extend([4, 8, 16].map(|lanes| Case::robot("lift_base", "hand").of_many(lanes)));
    cases.push(exponent().of_many(8));
    cases
}

/// A robot with the estimator, which frees readings of a sensor effect and goes on from a fit.
pub(crate) fn estimating() -> Case {
    let mut case = Case::with_effect("sensor_rotation", "-", ("yaw_rad", 0.02)).informed();
    case.name = "two_link_estimator".to_string();
    case
}

/// A robot whose reading takes a power and is clamped.
pub(crate) fn exponent() -> Case {
    let mut case = Case::with_effect("cell_exponent", "fsr_2", ("exponent", 1.1));
    case.functions = Function::ALL.to_vec();
    case
}

/// Those that differ in kind.
pub(crate) fn few() -> Vec<Case> {
    let alike = ["humanoid_left", "plain", "quad", "arm", "op2_body"];
    let mut cases = cases();
    cases.retain(|case| !alike.iter().any(|name| case.name.contains(name)));
    cases
}

/// Every case in every scalar.
pub(crate) fn jobs(cases: &[Case]) -> Vec<(&Case, Scalar)> {
    let mut jobs = Vec::new();
    for case in cases {
        jobs.extend(case.scalars().iter().map(|scalar| (case, *scalar)));
    }
    jobs
}

/// Servos of every make, one after the other.
pub(crate) fn servos(model: &Model) -> Servos {
    let settings = model.tree.dofs.iter().enumerate().map(|(k, dof)| {
        let setting = Setting {
            zero: Some([2048, 512, 0, -77][k % 4]),
            sign: Some([1, -1, -1][k % 3]),
            resolution: Some([4096.0, 1024.0, 16384.0, 1228.8, 300.5][k % 5]),
            metres_per_tick: dof.prismatic.then_some([1e-5, 3.3e-4][k % 2]),
        };
        (dof.joint.clone(), setting)
    });
    Servos {
        default: Setting::default(),
        joints: settings.collect(),
    }
}
