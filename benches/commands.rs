//! Whole commands as people wait for them, in processor time and as multiples of the numbers
//! alone: what [`Estimator::batch`] takes for as many postures in memory, measured in the same
//! run on the same machine.
//!
//! `cargo bench --bench commands` takes a million postures; `-- --poses 100000` fewer, and
//! `-- --program FILE` another `sesc`. Time is that of all threads, read from `/proc`: Linux alone.

use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS, CAD_PARAMS, DOF, Op2RSole};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_runtime::Simd;
use sesc_runtime::fit::Estimator;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Ticks of the clock that `/proc` counts in, 1/s.
const TICKS: f64 = 100.0;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let after = |flag: &str| {
        let at = arguments.iter().position(|argument| argument == flag)?;
        arguments.get(at + 1).cloned()
    };
    let tested = arguments.iter().any(|argument| argument == "--test");
    let poses = after("--poses").map_or(if tested { 2000 } else { 1_000_000 }, |poses| {
        poses.parse().expect("--poses is followed by a number")
    });
    let program = after("--program").unwrap_or_else(|| env!("CARGO_BIN_EXE_sesc").to_string());
    let folder = std::env::temp_dir().join(format!("sesc-commands-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("the temporary folder can be written to");
    let bench = Bench { program, folder };
    let unit = numbers_alone(poses);
    println!("{poses} postures; the numbers alone take {unit:.3} s of processor time");
    println!(
        "{:<44} {:>9} {:>9} {:>9}",
        "command", "wall s", "proc. s", "/ numbers"
    );
    for (name, line) in bench.lines(poses) {
        let (wall, processor) = bench.run(&line);
        println!(
            "{name:<44} {wall:>9.2} {processor:>9.2} {:>9.1}",
            processor / unit
        );
    }
    // What is left behind does no harm.
    let _ = fs::remove_dir_all(&bench.folder);
}

struct Bench {
    program: String,
    folder: PathBuf,
}

impl Bench {
    /// Names and arguments; earlier ones write the logs of later ones.
    fn lines(&self, poses: usize) -> Vec<(String, Vec<String>)> {
        let robot = |name: &str| format!("{ROOT}/robots/{name}/{name}.urdf");
        let file = |name: &str| self.folder.join(name).display().to_string();
        let (op2, skewed) = (robot("op2"), robot("skew_humanoid"));
        let simulate = |poses: usize, log: &str, more: &str| {
            format!(
                "simulate {op2} --support r_sole --poses {poses} --range 30 {more} --out {}",
                file(log)
            )
        };
        let on = |command: &str, log: &str| format!("{command} {op2} --data {}", file(log));
        let hidden = "--noise 0.0005 --hide joint_offset:r_knee=1.5deg";
        let three = "--hide joint_offset:right_knee=2deg --hide payload:chest=0.5,0,0,0.1 \
                     --hide joint_compliance:right_ankle_pitch=800";
        let on_chain = |joints: usize, poses: usize| {
            format!(
                "simulate {} --support l0 --poses {poses} --range 30 --noise 0.0005 \
                 --hide joint_offset:j40=1.5deg --out {}",
                self.chain(joints),
                file(&format!("chain{joints}.csv"))
            )
        };
        let lines = [
            (
                "simulate, Parquet",
                simulate(poses, "stand.parquet", "--noise 0.005"),
            ),
            (
                "simulate in motion, Parquet",
                simulate(poses, "move.parquet", "--noise 0.001 --rate 100"),
            ),
            (
                "simulate, CSV",
                simulate(poses, "stand.csv", "--noise 0.005"),
            ),
            ("fit, Parquet", on("fit", "stand.parquet")),
            ("fit in motion, Parquet", on("fit", "move.parquet")),
            (
                "fit in motion, Parquet, --motion off",
                on("fit --motion off", "move.parquet"),
            ),
            ("fit, CSV", on("fit", "stand.csv")),
            ("predict", on("predict", "stand.parquet")),
            ("predict in motion", on("predict", "move.parquet")),
            ("diagnose", on("diagnose", "stand.parquet")),
            ("diagnose in motion", on("diagnose", "move.parquet")),
            (
                "simulate 100 with an effect",
                simulate(100, "hidden100.csv", hidden),
            ),
            ("diagnose 100", on("diagnose", "hidden100.csv")),
            (
                "simulate 1000 with an effect",
                simulate(1000, "hidden1000.csv", hidden),
            ),
            ("diagnose 1000", on("diagnose", "hidden1000.csv")),
            (
                "simulate 500, skewed humanoid, three effects",
                format!(
                    "simulate {skewed} --support right_sole --poses 500 --range 30 --noise 0.0005 \
                     {three} --out {}",
                    file("skewed.csv")
                ),
            ),
            (
                "diagnose 500, skewed humanoid, three effects",
                format!("diagnose {skewed} --data {}", file("skewed.csv")),
            ),
            ("inspect, OP2", format!("inspect {op2} --support r_sole")),
            ("verify, OP2", format!("verify {op2} --support r_sole")),
            (
                "inspect, chain of 2000 joints",
                format!("inspect {} --support l0", self.chain(2000)),
            ),
            (
                "verify, chain of 500 joints",
                format!("verify {} --support l0", self.chain(500)),
            ),
            ("simulate 4000, chain of 100 joints", on_chain(100, 4000)),
            (
                "diagnose 4000, chain of 100 joints",
                format!(
                    "diagnose {} --data {}",
                    self.chain(100),
                    file("chain100.csv")
                ),
            ),
            ("simulate 300, chain of 300 joints", on_chain(300, 300)),
            (
                "diagnose 300, chain of 300 joints",
                format!(
                    "diagnose {} --data {}",
                    self.chain(300),
                    file("chain300.csv")
                ),
            ),
        ];
        let split = |line: String| line.split_whitespace().map(str::to_string).collect();
        let lines = lines.into_iter();
        lines
            .map(|(name, line)| (name.to_string(), split(line)))
            .collect()
    }

    /// The URDF of a chain of so many skewed joints.
    fn chain(&self, joints: usize) -> String {
        let mut urdf = String::from("<robot name='chain'><link name='l0'/>");
        for k in 1..=joints {
            // No two links alike, and no angle a right one.
            let part = |n: usize| 0.1 + 0.8 * ((k * n) % 97) as f64 / 97.0;
            let [a, b, c] = [13, 29, 41].map(part);
            urdf += &format!(
                "<link name='l{k}'><inertial><origin xyz='{} {} {}'/><mass value='{}'/></inertial>\
                 </link><joint name='j{k}' type='revolute'><parent link='l{}'/>\
                 <child link='l{k}'/><origin xyz='{} {} 0.05' rpy='{a} {b} {c}'/>\
                 <axis xyz='{c} {} {b}'/><limit lower='-1' upper='1'/></joint>",
                0.02 * a,
                -0.02 * b,
                0.05 * c,
                0.5 + a,
                k - 1,
                0.01 * b,
                0.01 * c,
                -a
            );
        }
        let path = self.folder.join(format!("chain-{joints}.urdf"));
        fs::write(&path, urdf + "</robot>").expect("the temporary folder can be written to");
        path.display().to_string()
    }

    /// Wall and processor time of one command, s.
    fn run(&self, line: &[String]) -> (f64, f64) {
        let (start, before) = (Instant::now(), processor_s(Whose::Children));
        let status = Command::new(Path::new(&self.program))
            .args(line)
            .arg("--quiet")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .expect("the program runs");
        // A diagnosis that names an effect ends with 1.
        assert!(matches!(status.code(), Some(0 | 1)), "{line:?}: {status}");
        let spent = processor_s(Whose::Children) - before;
        (start.elapsed().as_secs_f64(), spent)
    }
}

/// Processor time of a fit of postures in memory with the generated rows, s.
fn numbers_alone(poses: usize) -> f64 {
    let robot = Robot::parse(sesc::OP2_URDF, "op2.urdf").expect("the robot is read");
    let model = robot.model("r_sole", Snapping::default(), None);
    let model = model.expect("the robot stands");
    let mut simulator = Simulator::new(&model.tree.dofs, Some(0.5), 1);
    let q: Vec<[f64; DOF]> = (0..poses)
        .map(|_| simulator.posture().try_into().expect("one angle a joint"))
        .collect();
    let cop: Vec<[f64; 2]> = q.iter().map(|q| op2::cop(q, &CAD_PARAMS)).collect();
    let start = Estimator::<f64, BASE_PARAMS>::with_nominal(&CAD_PARAMS).expect("CAD is finite");
    let before = processor_s(Whose::Own);
    let rounds = 3;
    for _ in 0..rounds {
        let found = start.batch::<Op2RSole>(Simd::best(), black_box(&q), &cop, &[1e-3; 2]);
        black_box(found.expect("postures are finite").params());
    }
    (processor_s(Whose::Own) - before) / f64::from(rounds)
}

/// Whose processor time is asked for.
enum Whose {
    Own,
    Children,
}

/// Time in user code and in the system since the start, s.
fn processor_s(whose: Whose) -> f64 {
    let text = fs::read_to_string("/proc/self/stat").expect("Linux tells processor times");
    // The second field is a name in brackets, which may hold blanks.
    let (_, fields) = text.rsplit_once(')').expect("the name ends");
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let first = match whose {
        Whose::Own => 11,
        Whose::Children => 13,
    };
    let ticks = fields[first..first + 2].iter().map(|x| x.parse::<f64>());
    ticks.map(|x| x.expect("a number")).sum::<f64>() / TICKS
}
