//! Functions of any robot at near-native speed: programs on tape.

use std::sync::LazyLock;

use sesc_model::effects::PostureContext;
use sesc_model::expr::Argument;
use sesc_model::program::Program;
use sesc_model::tape::{BLOCK, Kernels, SHORT, Tape, Values};
use sesc_model::wide::{Loops, widest};
use sesc_model::{Function, Given, Model};
use sesc_runtime::{Simd, power, trig};

/// The support frame's.
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Sines and cosines, velocities, accelerations, parameters and a direction.
const MOST_ARGUMENTS: usize = 6;

/// Additions that take as long as a sine with its cosine, a division or a power.
const LONG_OPERATION: usize = 20;

/// One function of a model, ready for batches of postures.
///
/// ```
/// use sesc_identify::evaluate::Evaluator;
/// use sesc_identify::robot::{Robot, Stance};
/// use sesc_model::Function;
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <mass value='2'/></inertial></link><joint name='hip' type='revolute'>\
/// #   <parent link='foot'/><child link='top'/><origin xyz='0.1 0 1'/><axis xyz='0 1 0'/>\
/// #   <limit lower='-1' upper='1'/></joint></robot>";
/// let model = Stance::new(Robot::parse(urdf, "pole.urdf")?).on("foot").model()?;
/// let com = Evaluator::new(&model, Function::Com);
/// assert_eq!(com.run(&[0.0, 0.5], 2)[..3], [0.1, 0.0, 1.0]);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
pub struct Evaluator {
    tape: Tape,
    given: Given,
    /// Values per posture of the first argument: positions of joints, or a reading.
    entries: usize,
    /// Cost of a posture, in additions.
    operations: usize,
    /// Which joints are prismatic: `_sc` functions take their positions as they are.
    prismatic: Vec<bool>,
    /// Whether the function takes velocities of joints, and accelerations.
    moving: [bool; 2],
    /// Those of joints that stand.
    still: Vec<f64>,
    params: Option<Vec<f64>>,
    kernels: Kernels,
}

impl Evaluator {
    /// Prepare `function` of `model` with the model's parameters.
    pub fn new(model: &Model, function: Function) -> Evaluator {
        Evaluator::with_params(model, function, model.params())
    }

    /// Prepare `function` with parameters `params` (base parameters, m).
    pub fn with_params(model: &Model, function: Function, params: Vec<f64>) -> Evaluator {
        Evaluator::variant(model, function, Given::Positions, params)
            .expect("every function can be had from joint positions")
    }

    /// Prepare the variant of `function` from what is `given`, where there is one; along
    /// directions, for the axes of the support frame: the rows of the function.
    pub fn variant(
        model: &Model,
        function: Function,
        given: Given,
        params: Vec<f64>,
    ) -> Option<Evaluator> {
        let program = model.program(function, given)?;
        Some(Evaluator::of_function(
            model, &program, function, given, params,
        ))
    }

    /// Prepare the variant of `function` from what is `given`, of the `program` that
    /// [`Model::program`] made of these two.
    pub fn of_function(
        model: &Model,
        program: &Program,
        function: Function,
        given: Given,
        params: Vec<f64>,
    ) -> Evaluator {
        let takes = |argument| function.arguments(given).contains(&argument);
        let counts = program.counts();
        let arithmetic = counts.mul + counts.add + counts.neg + counts.angle;
        Evaluator {
            tape: Tape::new(program),
            given,
            entries: program.inputs.first().map_or(0, |array| array.len),
            operations: arithmetic + LONG_OPERATION * (counts.sin_cos + counts.other),
            prismatic: model.tree.dofs.iter().map(|dof| dof.prismatic).collect(),
            moving: [Argument::Velocities, Argument::Accelerations].map(takes),
            still: vec![0.0; model.dof()],
            params: function.takes_parameters().then_some(params),
            kernels: PORTABLE,
        }
    }

    /// Use the fastest kernels, where results are not written to files that are compared.
    pub fn fastest(self) -> Evaluator {
        Evaluator {
            kernels: FASTEST,
            ..self
        }
    }

    /// Directions that the function is evaluated along.
    fn directions(&self) -> usize {
        match self.given {
            Given::Positions | Given::SinesCosines => 1,
            Given::Direction => AXES.len(),
        }
    }

    /// Values per posture.
    pub fn width(&self) -> usize {
        self.directions() * self.tape.outputs()
    }

    /// Cost of a posture, in additions: it says whether a batch is worth a thread, and no more.
    pub fn operations(&self) -> usize {
        self.directions() * self.operations
    }

    /// Evaluate `postures` postures, `q[posture * dof + joint]`, row by row. What takes no
    /// posture, [`Function::CorrectCop`], takes its readings, `q[reading * 2 + axis]`.
    pub fn run(&self, q: &[f64], postures: usize) -> Vec<f64> {
        self.run_moving(q, [Values::Shared(&self.still); 2], postures)
    }

    /// The same of joints that move, as [`run_moving_into`](Self::run_moving_into) takes it.
    pub fn run_moving(&self, q: &[f64], motion: [Values; 2], postures: usize) -> Vec<f64> {
        let mut out = vec![0.0; postures * self.width()];
        self.run_moving_into(q, motion, postures, &mut out);
        out
    }

    /// The same into the caller's memory: new pages cost more than wide rows do.
    ///
    /// # Panics
    /// Where `q` or `out` is too short.
    pub fn run_into(&self, q: &[f64], postures: usize, out: &mut [f64]) {
        self.run_moving_into(q, [Values::Shared(&self.still); 2], postures, out);
    }

    /// The same with velocities and accelerations, where the function takes them: rad/s or m/s,
    /// and rad/s² or m/s², of all postures or `[posture * dof + joint]`.
    ///
    /// # Panics
    /// Where an array is too short.
    pub fn run_moving_into(
        &self,
        q: &[f64],
        motion: [Values; 2],
        postures: usize,
        out: &mut [f64],
    ) {
        let q = &q[..postures * self.entries];
        let (sin, cos);
        let positions = match self.given {
            Given::Positions => [Some(Values::PerPosture(q)), None],
            Given::SinesCosines | Given::Direction => {
                (sin, cos) = self.sines(q);
                [&sin, &cos].map(|x| Some(Values::PerPosture(x)))
            }
        };
        // A call of one posture is shorter than to ask for memory a few times.
        let mut places = [Values::Shared(&[]); MOST_ARGUMENTS];
        let params = [self.params.as_deref().map(Values::Shared)];
        let taken = motion.into_iter().zip(self.moving);
        let moving = taken.map(|(values, takes)| takes.then_some(values));
        let given = positions.into_iter().chain(moving).chain(params).flatten();
        let mut count = 0;
        for (place, value) in places.iter_mut().zip(given) {
            *place = value;
            count += 1;
        }
        if self.given != Given::Direction {
            return self.tape.run(&places[..count], postures, out, self.kernels);
        }
        let columns = self.tape.outputs();
        let mut row = vec![0.0; postures * columns];
        for (k, along) in AXES.iter().enumerate() {
            places[count] = Values::Shared(along);
            self.tape
                .run(&places[..=count], postures, &mut row, self.kernels);
            let places = out[k * columns..].chunks_mut(self.width().max(1));
            for (place, row) in places.zip(row.chunks(columns.max(1))) {
                place[..columns].copy_from_slice(row);
            }
        }
    }

    /// What `_sc` functions take: sines (positions of prismatic joints) and cosines.
    fn sines(&self, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let of = |(&x, &prismatic): (&f64, &bool)| {
            if prismatic {
                (x, 0.0)
            } else {
                trig::sin_cos(x)
            }
        };
        q.iter().zip(self.prismatic.iter().cycle()).map(of).unzip()
    }
}

/// The runtime's portable arithmetic, in the widest registers of this machine: what generated
/// code computes from scalars, the tape computes to the bit, on any machine.
pub const PORTABLE: Kernels = Kernels {
    sin_cos: |angles, sin, cos| widest(Sines { angles, sin, cos }),
    power: |bases, exponents, out| {
        let exponents = exponents.as_chunks::<SHORT>().0;
        let out = out.as_chunks_mut::<SHORT>().0;
        for ((x, y), out) in bases.as_chunks().0.iter().zip(exponents).zip(out) {
            power::power_block(x, y, out);
        }
    },
};

/// The runtime's kernels on the widest registers of this machine: within the same bounds.
pub(crate) const FASTEST: Kernels = Kernels {
    sin_cos: |angles, sin, cos| sines(*BEST, angles, sin, cos),
    power: PORTABLE.power,
};

static BEST: LazyLock<Simd> = LazyLock::new(Simd::best);

/// Portable sines and cosines of a block.
struct Sines<'a> {
    angles: &'a [f64],
    sin: &'a mut [f64],
    cos: &'a mut [f64],
}

impl Loops for Sines<'_> {
    #[inline(always)]
    fn run(self) {
        let places = self.sin.iter_mut().zip(self.cos);
        for (angle, (sin, cos)) in self.angles.iter().zip(places) {
            (*sin, *cos) = trig::sin_cos(*angle);
        }
    }
}

/// Sines and cosines of a block by the runtime's kernels, by one call where it is long.
fn sines(simd: Simd, angles: &[f64], sin: &mut [f64], cos: &mut [f64]) {
    match angles.len() {
        SHORT => chunks::<SHORT>(simd, angles, sin, cos),
        _ => chunks::<BLOCK>(simd, angles, sin, cos),
    }
}

fn chunks<const N: usize>(simd: Simd, angles: &[f64], sin: &mut [f64], cos: &mut [f64]) {
    let sin = sin.as_chunks_mut::<N>().0;
    let cos = cos.as_chunks_mut::<N>().0;
    for ((angles, sin), cos) in angles.as_chunks().0.iter().zip(sin).zip(cos) {
        simd.sin_cos(angles, sin, cos);
    }
}

/// Predicts what motion adds to the CoP: the ZMP less the static one, on level ground.
///
/// Effects of the body are part of both.
pub struct MotionPredictor {
    zmp: Evaluator,
    com: Evaluator,
}

impl MotionPredictor {
    /// Prepare a model with its parameters and effects.
    pub fn new(model: &Model) -> MotionPredictor {
        MotionPredictor {
            zmp: Evaluator::new(model, Function::Zmp),
            com: Evaluator::new(model, Function::Com),
        }
    }

    /// x and y of each of `n` postures, m, whose joints move at `rates` (rad/s or m/s) with
    /// `accelerations`; zero where nothing holds the robot.
    pub fn shifts(
        &self,
        q: &[f64],
        n: usize,
        (rates, accelerations): (&[f64], &[f64]),
    ) -> Vec<[f64; 2]> {
        let motion = [rates, accelerations].map(Values::PerPosture);
        let zmp = self.zmp.run_moving(q, motion, n);
        let com = self.com.run(q, n);
        let pairs = zmp.chunks_exact(2).zip(com.chunks_exact(3));
        let of = |(zmp, com): (&[f64], &[f64])| {
            let shift = [zmp[0] - com[0], zmp[1] - com[1]];
            shift.map(|x| if x.is_finite() { x } else { 0.0 })
        };
        pairs.map(of).collect()
    }
}

/// What the log around postures says of them; nothing where these are empty.
#[derive(Debug, Default)]
pub struct InLog {
    /// Time since the log began, s.
    pub since_s: Vec<f64>,
    /// Sides from which joints came, posture by posture.
    pub sides: Vec<f64>,
}

/// Predicts CoM and reading of a model with its effects, under any gravity.
///
/// ```text
/// CoP = CoM − z_CoM g / g_z + shift        without effects: along gravity on the sole plane
/// ```
pub struct ReadingPredictor {
    com: Tape,
    cop: Tape,
    layout: PostureContext,
    params: Vec<f64>,
}

impl ReadingPredictor {
    /// Prepare a model with its parameters, and its effects that a posture shows.
    pub fn new(model: &Model) -> ReadingPredictor {
        ReadingPredictor {
            com: Tape::new(&sesc_model::tilted_com(model)),
            cop: Tape::new(&sesc_model::tilted_cop(model)),
            layout: PostureContext::of(model),
            params: model.params(),
        }
    }

    /// CoM (x, y, z) and reading (x, y) of `postures` postures, m, as they stand in `log`, with
    /// gravity per posture and what motion adds to the CoP; level ground and joints that stand
    /// where these are empty.
    pub fn run(
        &self,
        (q, postures): (&[f64], usize),
        log: &InLog,
        gravity: &[[f64; 3]],
        shifts: &[[f64; 2]],
    ) -> (Vec<f64>, Vec<f64>) {
        let mut context = vec![0.0; postures * self.layout.len()];
        let width = self.layout.len();
        for (k, t) in log.since_s.iter().enumerate() {
            context[k * width + self.layout.time()] = *t;
        }
        let sides = log
            .sides
            .chunks_exact((log.sides.len() / postures.max(1)).max(1));
        for (k, sides) in sides.enumerate() {
            let at = k * width + self.layout.approach(0);
            context[at..at + sides.len()].copy_from_slice(sides);
        }
        for axis in 0..2 {
            for (k, g) in gravity.iter().enumerate() {
                context[k * width + self.layout.tilt(axis)] = -g[axis] / g[2];
            }
            for (k, shift) in shifts.iter().enumerate() {
                context[k * width + self.layout.shift(axis)] = shift[axis];
            }
        }
        let arguments = [
            Values::PerPosture(q),
            Values::Shared(&self.params),
            Values::PerPosture(&context),
        ];
        let (mut com, mut cop) = (vec![0.0; 3 * postures], vec![0.0; 2 * postures]);
        self.com.run(&arguments, postures, &mut com, PORTABLE);
        self.cop.run(&arguments, postures, &mut cop, PORTABLE);
        (com, cop)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::robot::{Robot, Stance};

    #[test]
    fn level_readings_have_the_bits_of_the_functions() {
        let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/op2/op2.urdf");
        let robot = Robot::read(Path::new(urdf)).unwrap();
        let model = Stance::new(robot).on("r_sole").model().unwrap();
        let n = 100;
        let q: Vec<f64> = (0..n * model.dof()).map(|k| f64::sin(k as f64)).collect();
        let (com, cop) = ReadingPredictor::new(&model).run((&q, n), &InLog::default(), &[], &[]);
        assert_eq!(com, Evaluator::new(&model, Function::Com).run(&q, n));
        assert_eq!(cop, Evaluator::new(&model, Function::Cop).run(&q, n));
    }

    #[test]
    fn a_posture_alone_has_the_bits_of_its_batch() {
        let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/op2/op2.urdf");
        let robot = Robot::read(Path::new(urdf)).unwrap();
        let model = Stance::new(robot).on("r_sole").model().unwrap();
        let (all, dof) = (200, model.dof());
        let q: Vec<f64> = (0..all * dof).map(|k| f64::sin(k as f64)).collect();
        for function in Function::ALL {
            let made = || Evaluator::variant(&model, function, Given::Positions, model.params());
            let evaluators = made().zip(made().map(Evaluator::fastest));
            for evaluator in evaluators.into_iter().flat_map(|(a, b)| [a, b]) {
                // Velocities and accelerations for those that take them.
                let run =
                    |q: &[f64], n: usize| evaluator.run_moving(q, [Values::PerPosture(q); 2], n);
                let batch = run(&q, all);
                // Around the ends of short and of long blocks.
                for n in [1, 7, 8, 9, 16, 17, 63, 64, 65, 128, 130] {
                    let few = run(&q[dof..], n);
                    let same = &batch[evaluator.width()..][..few.len()];
                    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(&few), bits(same), "{function:?}, {n} postures");
                }
            }
        }
    }

    #[test]
    fn powers_of_short_blocks_are_those_of_long_ones() {
        let x: Vec<f64> = (0..BLOCK).map(|k| 0.03 * k as f64).collect();
        let y: Vec<f64> = (0..BLOCK).map(|k| 0.1 + 0.02 * k as f64).collect();
        let (mut long, mut short) = (vec![0.0; BLOCK], vec![0.0; BLOCK]);
        (PORTABLE.power)(&x, &y, &mut long);
        for k in (0..BLOCK).step_by(SHORT) {
            let to = k + SHORT;
            (PORTABLE.power)(&x[k..to], &y[k..to], &mut short[k..to]);
        }
        assert_eq!(long, short);
        assert!((long[20] - f64::powf(x[20], y[20])).abs() < 1e-15);
    }
}
