//! Both feet on one floor: postures that a robot can really stand in, and their logs.
//!
//! ```text
//! h(φ) = (p_z, R_zx, R_zy) = 0      of the other sole, by link poses of the reference
//! φ ← φ − Jᵀ (J Jᵀ + λ)⁻¹ h(φ)      J by differences, joints of both legs
//! q with φ(q) = φ                   what the encoders of the true robot read there
//! ```

use nalgebra::{IsometryMatrix3, Matrix3, Vector3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Reference, World};

use crate::command::Sheet;
use crate::recording::{Recording, normal};
use crate::stage::{Platform, Stage};

/// Joints are drawn within this of zero before the soles are put on the floor, rad.
const DRAWN: f64 = 0.45;
/// The least distance of two soles on the OP2, m; the largest.
const APART: (f64, f64) = (0.055, 0.14);
/// How far the CoP may be before or behind the soles on the OP2, m.
const AHEAD: f64 = 0.04;

/// The soles of a robot that stands on both.
pub struct TwoFeet {
    reference: Reference,
    other: usize,
    size: f64,
    limits: Vec<(f64, f64)>,
}

impl TwoFeet {
    /// The robot of `stage` on both soles.
    pub fn new(stage: &Stage) -> TwoFeet {
        let other = match stage.platform {
            Platform::Op2 => "l_sole",
            _ => "left_sole",
        };
        let reference =
            Reference::new(&stage.robot, stage.support).expect("the stage names a sole");
        let limits = stage.robot.movable_joints().map(|joint| joint.range());
        TwoFeet {
            other: stage.robot.link_index(other).expect("it has another sole"),
            limits: limits
                .map(|(low, high)| (low.max(-1.5), high.min(1.5)))
                .collect(),
            size: stage.size,
            reference,
        }
    }

    /// Height (m) and the sines of the tilt of the other sole.
    pub fn lies(&self, joints: &[f64]) -> Vector3<f64> {
        let pose = self.pose(joints);
        let up = pose.rotation.matrix();
        Vector3::new(pose.translation.z, up[(2, 0)], up[(2, 1)])
    }

    /// The other sole's origin on the floor, m.
    pub fn place(&self, joints: &[f64]) -> [f64; 2] {
        let place = self.pose(joints).translation;
        [place.x, place.y]
    }

    /// The other sole's frame.
    pub(crate) fn pose(&self, joints: &[f64]) -> IsometryMatrix3<f64> {
        self.reference.link_poses(joints)[self.other]
    }

    /// A posture of the joints in which the other sole lies on the floor, or at `tilt` to it,
    /// and the robot balances.
    pub fn draw(&self, tilt: [f64; 2], random: &mut ChaCha8Rng) -> Vec<f64> {
        let still = self.place(&vec![0.0; self.limits.len()]);
        loop {
            let start = self.limits.iter().map(|&(low, high)| {
                let x = DRAWN * (2.0 * random.random::<f64>() - 1.0);
                x.clamp(low, high)
            });
            let Some(joints) = self.put_down(start.collect(), tilt) else {
                continue;
            };
            let place = self.place(&joints);
            let apart = place[0].hypot(place[1]) / self.size;
            let beside = place[1] * still[1] > 0.0 && place[0].abs() < place[1].abs();
            let com = self.reference.com(&joints);
            let share = com.y / place[1];
            let ahead = (com.x - share * place[0]).abs() / self.size;
            let stands = (0.05..0.95).contains(&share) && ahead < AHEAD;
            if (APART.0..APART.1).contains(&apart) && beside && stands {
                return joints;
            }
        }
    }

    /// The nearest joints at which the other sole lies on the floor, or at `tilt` to it, the
    /// sines of its frame; none beyond limits.
    pub fn put_down(&self, mut joints: Vec<f64>, tilt: [f64; 2]) -> Option<Vec<f64>> {
        let wanted = Vector3::new(0.0, tilt[0], tilt[1]);
        let step = 1e-6;
        for _ in 0..60 {
            let here = self.lies(&joints);
            let miss = here - wanted;
            if miss.amax() < 1e-11 {
                let mut within = joints.iter().zip(&self.limits);
                let fits = |(x, (low, high)): (&f64, &(f64, f64))| (*low..=*high).contains(x);
                return within.all(fits).then_some(joints);
            }
            let columns: Vec<Vector3<f64>> = (0..joints.len())
                .map(|j| {
                    let mut moved = joints.clone();
                    moved[j] += step;
                    (self.lies(&moved) - here) / step
                })
                .collect();
            let square = columns.iter().map(|column| column * column.transpose());
            let damped = square.sum::<Matrix3<f64>>() + Matrix3::identity() * 1e-9;
            let pull = damped.try_inverse()? * miss;
            for (column, x) in columns.iter().zip(&mut joints) {
                *x -= column.dot(&pull).clamp(-0.3, 0.3);
            }
        }
        None
    }

    /// What the encoders of `world` read where its joints are `joints`.
    pub fn encoders(world: &World, joints: &[f64]) -> Vec<f64> {
        let mut q = joints.to_vec();
        for _ in 0..200 {
            let there = world.true_posture(&q);
            let misses = joints.iter().zip(&there).map(|(x, y)| x - y);
            let misses: Vec<f64> = misses.collect();
            if misses.iter().all(|miss| miss.abs() < 1e-12) {
                break;
            }
            q.iter_mut().zip(misses).for_each(|(q, miss)| *q += miss);
        }
        q
    }

    /// The log, as CSV, of `world` in the postures of a plan on both feet, whose file has angles to a
    /// microradian or so; readings are `off` by that, m.
    pub fn log_of_plan(&self, world: &World, plan: &str, off: [f64; 2]) -> String {
        let plan = Sheet::read(plan);
        let mut log = format!("{},cop_x,cop_y\n", plan.names.join(","));
        for (row, joints) in plan.rows.iter().zip(plan.numbers(&plan.names[1..])) {
            assert!(self.lies(&joints).amax() < 1e-5, "{row:?}");
            let q = TwoFeet::encoders(world, &joints);
            let cop = world.cop(&q);
            let q: Vec<String> = q.iter().map(|x| format!("{x:.7}")).collect();
            let [x, y] = [0, 1].map(|axis| cop[axis] + off[axis]);
            log += &format!("{},{},{x:.6},{y:.6}\n", row[0], q.join(","));
        }
        log
    }
}

/// Noise of a log of both feet.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// Noise of the CoP, m.
    pub cop_m: f64,
    /// Noise of every encoder, rad.
    pub encoder_rad: f64,
    /// Tilt of the floor and the other sole in every posture alike, rad.
    pub flat_rad: f64,
}

/// `count` postures of `world`, whose joints differ from what its encoders say, with the CoP of both
/// feet together in the support frame.
pub fn record(
    stage: &Stage,
    world: &World,
    count: usize,
    noise: Noise,
    random: &mut ChaCha8Rng,
) -> Recording {
    let feet = TwoFeet::new(stage);
    let mut own: ChaCha8Rng = rand::SeedableRng::seed_from_u64(random.random());
    let mut normal = || normal(&mut own);
    // A sole that is not flat is a tilt of its mount.
    let tilt = [(); 2].map(|()| noise.flat_rad * normal());
    let mut log = Recording {
        joints: stage.joint_names(),
        ..Recording::default()
    };
    for _ in 0..count {
        let joints = feet.draw(tilt, random);
        let q = TwoFeet::encoders(world, &joints);
        log.cop
            .push(world.cop(&q).map(|x| x + noise.cop_m * normal()));
        log.q
            .push(q.iter().map(|q| q + noise.encoder_rad * normal()).collect());
    }
    log
}
