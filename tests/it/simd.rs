//! Generated functions on every set of instructions that this machine has: within the
//! bound that the head of the generated file states, one posture at a time and in batches.

use sesc::OP2_URDF;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::bounds::Precision;
use sesc_model::expr::Argument;
use sesc_model::{Function, Given, Model, ModelFile, Snapping};
use sesc_runtime::{Batch, F32x16, F64x8, Sesc as _, Simd, Single, pack};
use sesc_test_support::exact::{Double, Interpreter, Number as _};

/// Blocks of each function: 32 postures, whose exact values take a microsecond an operation.
const BLOCKS: usize = 4;

/// Joint velocities of every posture, rad/s or m/s; single precision holds them.
fn rates(dof: usize) -> Vec<f64> {
    let rate = |j| f64::from(1.0 / (1.0 + j as f32));
    (0..dof).map(rate).collect()
}

/// What one function gives for each posture, and what it may be off by.
struct Truth {
    values: Vec<Vec<Double>>,
    bound: f64,
}

impl Truth {
    fn new(model: &Model, function: Function, given: Given, p: Precision, q: &[Vec<f64>]) -> Truth {
        let positions = model.program(function, Given::Positions).unwrap();
        let interpreter = Interpreter::new(&positions);
        let params: Vec<Double> = model.cad_params().into_iter().map(Double::of).collect();
        let rates: Vec<Double> = rates(model.dof()).into_iter().map(Double::of).collect();
        let gains: Vec<Double> = rates.iter().rev().copied().collect();
        let values = q.iter().map(|q| {
            let q: Vec<Double> = q.iter().map(|x| Double::of(*x)).collect();
            let arguments = function.arguments(Given::Positions).into_iter();
            let inputs = arguments.map(|argument| match argument {
                Argument::Velocities => rates.as_slice(),
                Argument::Accelerations => gains.as_slice(),
                Argument::Parameters => &params,
                _ => &q,
            });
            interpreter.run(&inputs.collect::<Vec<_>>())
        });
        let program = model.program(function, given).unwrap();
        Truth {
            values: values.collect(),
            bound: model.rounding(&program, p).worst,
        }
    }

    /// Largest error of the values found for posture `k`, which must not pass the bound.
    fn check(&self, what: &str, k: usize, found: &[f64]) -> f64 {
        let exact = &self.values[k];
        assert_eq!(exact.len(), found.len(), "{what}");
        let errors = exact.iter().zip(found).map(|(exact, x)| exact.distance(*x));
        let worst = errors.fold(0.0, |worst: f64, error| match error.is_nan() {
            true => f64::INFINITY,
            false => worst.max(error),
        });
        assert!(worst <= self.bound, "{what}: {worst:e} > {:e}", self.bound);
        worst
    }
}

/// Proven bound of the rows of one posture, which are taken along the axes side by side.
fn along(model: &Model, function: Function, precision: Precision) -> Option<f64> {
    let rows = match function {
        Function::RegressorCop => Function::Regressor,
        function => function,
    };
    let program = model.program(rows, Given::Direction)?;
    Some(model.rounding(&program, precision).worst)
}

/// Lane `lane` of flat blocks.
macro_rules! lane {
    ($blocks:expr, $lane:expr) => {
        $blocks
            .iter()
            .map(|block| f64::from(block.0[$lane]))
            .collect::<Vec<f64>>()
    };
}

macro_rules! functions {
    ([$($which:ident)+], $home:ident::$module:ident, $robot:ident, $model:expr, $block:ty, $scalar:ty, $precision:expr) => {{
        #[allow(unused_imports)] // not every function is on every list
        use $home::$module::{BASE_PARAMS, CAD_PARAMS, DOF, FULL_PARAMS, $robot};
        const LANES: usize = size_of::<$block>() / size_of::<$scalar>();
        let model: &Model = $model;
        let mut simulator = Simulator::new(&model.tree.dofs, None, 17);
        let postures: Vec<[$scalar; DOF]> = (0..LANES * BLOCKS)
            .map(|_| {
                let q: [f64; DOF] = simulator.posture().try_into().unwrap();
                q.map(|x| x as $scalar)
            })
            .collect();
        let q: Vec<[$block; DOF]> =
            postures.chunks(LANES).map(|rows| pack::<$scalar, LANES, DOF>(rows.try_into().unwrap())).collect();
        let widened: Vec<Vec<f64>> =
            postures.iter().map(|q| q.iter().map(|x| f64::from(*x)).collect()).collect();
        let r = CAD_PARAMS.map(|x| x as $scalar);
        #[allow(unused_variables)] // not every function is on every list
        let rates: [$scalar; DOF] = std::array::from_fn(|j| rates(DOF)[j] as $scalar);
        #[allow(unused_variables)]
        let qd = vec![rates.map(|x| <$block>::splat(x)); BLOCKS];
        #[allow(unused_variables)]
        let gains: [$scalar; DOF] = std::array::from_fn(|j| rates[DOF - 1 - j]);
        #[allow(unused_variables)]
        let qdd = vec![gains.map(|x| <$block>::splat(x)); BLOCKS];
        let zero = <$block>::splat(0.0);
        assert_eq!($robot::PRISMATIC.to_vec(), model.tree.dofs.iter().map(|dof| dof.prismatic).collect::<Vec<_>>());

        macro_rules! one {
            ($function:ident, $batch:ident($r_or_not:tt), $single:ident, $start:expr, $flat:expr) => {{
                let truth = |given| Truth::new(model, Function::$function, given, $precision, &widened);
                let batch = truth(Given::Positions);
                let mut single = truth(Given::SinesCosines);
                if let Some(bound) = along(model, Function::$function, $precision) {
                    single.bound = bound;
                }
                for simd in Simd::available() {
                    let what = format!("{} {} on {}", stringify!($module), stringify!($batch), simd.name());
                    let mut out = vec![$start; BLOCKS];
                    one!(@batch simd, $batch, $r_or_not, out);
                    let mut worst = [0.0_f64; 2];
                    for (k, posture) in postures.iter().enumerate() {
                        let flat = $flat(&out[k / LANES]);
                        let found = lane!(flat, k % LANES);
                        worst[0] = worst[0].max(batch.check(&what, k, &found));
                        let one = one!(@single simd, $single, $r_or_not, posture);
                        let one: Vec<f64> = $flat(&one).iter().map(|x| f64::from(*x)).collect();
                        worst[1] = worst[1].max(single.check(&what, k, &one));
                    }
                    println!("{what}: {:.1e}, single {:.1e} of {:.1e}", worst[0], worst[1], batch.bound);
                }
            }};
            (@ Com) => { one!(Com, com_batch(r), com_single, [zero; 3], vector) };
            (@ ComJacobian) => {
                one!(ComJacobian, com_jacobian_batch(r), com_jacobian_single, [[zero; DOF]; 3], matrix)
            };
            (@ ComVelocity) => {
                one!(ComVelocity, com_velocity_batch(v), com_velocity_single, [zero; 3], vector)
            };
            (@ GravityMoments) => {
                one!(GravityMoments, gravity_moments_batch(r), gravity_moments_single, [zero; DOF], vector)
            };
            (@ Regressor) => {
                one!(Regressor, regressor_batch(-), regressor_single, [[zero; BASE_PARAMS]; 3], matrix)
            };
            (@ RegressorCop) => {
                one!(RegressorCop, regressor_cop_batch(-), regressor_cop_single, [[zero; BASE_PARAMS]; 2], matrix)
            };
            (@ RegressorFull) => {
                one!(RegressorFull, regressor_full_batch(-), regressor_full_single, [[zero; FULL_PARAMS]; 3], matrix)
            };
            (@ Cop) => { one!(Cop, cop_batch(r), cop_single, [zero; 2], vector) };
            (@ Zmp) => { one!(Zmp, zmp_batch(a), zmp_single, [zero; 2], vector) };
            (@batch $simd:ident, $batch:ident, a, $out:ident) => {
                $robot::$batch($simd, &q, &qd, &qdd, &r, &mut $out)
            };
            (@single $simd:ident, $single:ident, a, $q:ident) => {
                $robot::$single($simd, $q, &rates, &gains, &r)
            };
            (@batch $simd:ident, $batch:ident, r, $out:ident) => { $robot::$batch($simd, &q, &r, &mut $out) };
            (@batch $simd:ident, $batch:ident, -, $out:ident) => { $robot::$batch($simd, &q, &mut $out) };
            (@batch $simd:ident, $batch:ident, v, $out:ident) => { $robot::$batch($simd, &q, &qd, &r, &mut $out) };
            (@single $simd:ident, $single:ident, v, $q:ident) => { $robot::$single($simd, $q, &rates, &r) };
            (@single $simd:ident, $single:ident, r, $q:ident) => { $robot::$single($simd, $q, &r) };
            (@single $simd:ident, $single:ident, -, $q:ident) => { $robot::$single::<$scalar>($simd, $q) };
        }
        fn vector<T, const N: usize>(x: &[T; N]) -> &[T] { x }
        fn matrix<T, const N: usize, const M: usize>(x: &[[T; N]; M]) -> &[T] { x.as_flattened() }
        $(one!(@ $which);)+
    }};
}

fn model(urdf: &str, support: &str) -> Model {
    let robot = Robot::parse(urdf, "robot.urdf").unwrap();
    robot.model(support, Snapping::default(), None).unwrap()
}

#[test]
fn op2_in_doubles() {
    functions!([Com ComJacobian ComVelocity GravityMoments Regressor RegressorCop RegressorFull Cop],
        sesc_generated::op2_r_sole, Op2RSole, &model(OP2_URDF, "r_sole"), F64x8, f64, Precision::F64);
}

#[test]
fn op2_in_singles() {
    functions!([Com ComJacobian ComVelocity GravityMoments Regressor RegressorCop RegressorFull Cop],
        sesc_bench_robots::op2_l_sole, Op2LSole, &model(OP2_URDF, "l_sole"), F32x16, f32, Precision::F32);
}

/// Skewed axes, constants everywhere; its other functions take the compiler minutes.
#[test]
fn a_skewed_humanoid() {
    let urdf = include_str!("../../robots/skew_humanoid/skew_humanoid.urdf");
    let model = model(urdf, "right_sole");
    functions!([Com RegressorCop], sesc_bench_robots::skew_humanoid_right_sole,
        SkewHumanoidRightSole, &model, F64x8, f64, Precision::F64);
}

/// Effects of the body are part of every function, in batches and one posture at a time.
#[test]
fn a_robot_with_a_load_springs_and_an_offset() {
    let file = include_str!("../../benches/robots/two_link_bent.toml");
    let file = ModelFile::parse(file, "two_link_bent.toml").unwrap();
    let urdf = include_str!("../../robots/two_link/two_link.urdf");
    let model = model(urdf, "foot").with_file(file).unwrap();
    assert_eq!(model.effects_of(Function::ComJacobian).len(), 3);
    functions!([Com ComJacobian ComVelocity GravityMoments Regressor RegressorCop RegressorFull Cop Zmp],
        sesc_bench_robots::two_link_bent, TwoLinkBent, &model, F64x8, f64, Precision::F64);
}
