//! What must come out: the bits of this machine, within the proven bound of f64.

use std::fs;

use sesc_generated::op2_r_sole as op2;

use super::build::{
    Config, HOST_F32, HOST_FIXED, M3_F32, M3_FIXED, M4F_F32, M4F_F32_EXACT, TARGETS,
};
use super::postures::{DOF, POSTURES, postures};
use super::{LIMIT, ROOT};
use sesc_runtime::fit::Estimator;
use sesc_test_support::machine;

/// A function in f64.
fn in_f64(
    function: &str,
    q: &[f64; DOF],
    [qd, slow, qdd]: [&[f64; DOF]; 3],
    r: &[f64; op2::BASE_PARAMS],
) -> Vec<f64> {
    match function {
        "com" => op2::com(q, r).to_vec(),
        "com_jacobian" => op2::com_jacobian(q, r).concat(),
        "com_velocity" => op2::com_velocity(q, qd, r).to_vec(),
        "gravity_moments" => op2::gravity_moments(q, r).to_vec(),
        "regressor" => op2::regressor(q).concat(),
        "regressor_cop" => op2::regressor_cop(q).concat(),
        "regressor_full" => op2::regressor_full(q).concat(),
        "cop" => op2::cop(q, r).to_vec(),
        "zmp" => op2::zmp(q, slow, qdd, r).to_vec(),
        other => panic!("{other} is no function"),
    }
}

impl Config {
    /// The proven bound that the header states; a micrometre where none is of use, a thousandth of
    /// what a user is promised.
    fn bound(self, name: &str) -> f64 {
        let header = self.header();
        let words = header.lines().find_map(|line| {
            let mut words = line.strip_prefix(" * ")?.split_whitespace();
            (words.next()? == name).then(|| words.skip(5).collect::<Vec<&str>>())
        });
        match words.expect("the header has a table of bounds")[..] {
            ["none;", ..] => 1e-6,
            [bound, ..] => bound.parse().unwrap(),
            [] => panic!("{name} has no bound"),
        }
    }

    /// What `agree` prints: of each line, the function and the bits it returned.
    fn results(self) -> Vec<(String, Vec<u32>)> {
        let printed = machine::printed(&mut self.command("agree"), "", LIMIT);
        let line = |line: &str| {
            let mut words = line.split_whitespace();
            let name = words.next().unwrap().to_string();
            (
                name,
                words.map(|x| u32::from_str_radix(x, 16).unwrap()).collect(),
            )
        };
        printed.lines().map(line).collect()
    }

    fn value(self, bits: u32, unit: f64) -> f64 {
        match self.fixed {
            true => f64::from(bits as i32) / unit,
            false => f64::from(f32::from_bits(bits)),
        }
    }

    /// Results within the proven bound of f64; returns the worst share of the bound.
    fn check(self, results: &[(String, Vec<u32>)]) -> f64 {
        assert_eq!(
            results[0],
            ("selftest".to_string(), vec![0]),
            "{}",
            self.name
        );
        let of_estimator = if self.fixed { 0 } else { ESTIMATES.len() };
        assert_eq!(
            results.len(),
            1 + POSTURES * self.names().count() + of_estimator,
            "{}",
            self.name
        );
        let r = op2::CAD_PARAMS.map(|x| self.meant(x, "R"));
        let mut results = results[1..].iter();
        let mut worst: f64 = 0.0;
        for posture in postures() {
            let qd = posture.qd.map(|x| self.meant(x, "QD"));
            let [slow, qdd] = [posture.slow, posture.qdd].map(|x| x.map(|x| f64::from(x as f32)));
            for (name, function, kind) in self.names() {
                let q = match kind {
                    "" => posture.q.map(|q| self.meant(q, "Q")),
                    "_sc" => posture.q,
                    _ => posture
                        .ticks
                        .map(|t| f64::from(t - 2048) * std::f64::consts::TAU / 4096.0),
                };
                let (printed, got) = results.next().unwrap();
                assert_eq!(*printed, name);
                let expected = in_f64(function, &q, [&qd, &slow, &qdd], &r);
                assert_eq!(got.len(), expected.len(), "{name}");
                let unit = if self.fixed {
                    self.unit(&function.to_uppercase())
                } else {
                    1.0
                };
                let bound = self.bound(&name);
                for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
                    let error = (self.value(*got, unit) - expected).abs();
                    assert!(
                        error <= bound,
                        "{}: {name}[{k}] is off by {error:e}, proven {bound:e}",
                        self.name
                    );
                    worst = worst.max(error / bound);
                }
            }
        }
        worst
    }
}

/// What `agree` prints of the estimator: calls that were refused, what it found.
const ESTIMATES: [&str; 3] = ["refused", "estimator_params", "estimator_std"];

/// The runtime's estimator with the postures and readings of `agree.c`.
#[test]
fn estimates_are_those_of_the_runtime() {
    const N: usize = op2::BASE_PARAMS;
    let r = op2::CAD_PARAMS.map(|x| x as f32);
    let mut estimator = Estimator::<f32, N>::with_prior(&r, &[0.01; N]).unwrap();
    for posture in postures() {
        let q = posture.q.map(|q| q as f32);
        let [x, y] = op2::cop(&q, &r);
        let reading = [x + 0.003, y];
        estimator
            .add_posture::<op2::Op2RSole>(&q, &reading, &[1e-3, 2e-3])
            .unwrap();
    }
    let expected = [
        vec![0],
        estimator.params().map(f32::to_bits).to_vec(),
        estimator.deviations().map(f32::to_bits).to_vec(),
    ];
    for config in [HOST_F32, M3_F32, M4F_F32_EXACT, M4F_F32] {
        let results = config.results();
        let found = &results[results.len() - ESTIMATES.len()..];
        for (((name, found), expected), title) in found.iter().zip(&expected).zip(ESTIMATES) {
            assert_eq!(name, title, "{}", config.name);
            if config != M4F_F32 {
                assert_eq!(found, expected, "{}: {name} to the last bit", config.name);
            }
        }
    }
}

#[test]
fn results_are_those_of_f64_and_of_this_machine() {
    let fixed = HOST_FIXED.results();
    let float = HOST_F32.results();
    for config in TARGETS {
        let results = config.results();
        let worst = config.check(&results);
        println!(
            "{}: at most {:.0} % of the proven bound",
            config.name,
            100.0 * worst
        );
        let host = if config.fixed { &fixed } else { &float };
        if config == M4F_F32 {
            // Fused operations round less often: near, and not the same everywhere.
            assert_ne!(&results, host, "the compiler fuses");
        } else {
            for (got, expected) in results.iter().zip(host) {
                assert_eq!(got, expected, "{}: to the last bit", config.name);
            }
        }
    }
}

/// CoM, CoP and margin in mm of every line that the example prints.
fn read_example(printed: &str) -> Vec<[f64; 6]> {
    let line = |line: &str| {
        let numbers: Vec<f64> = line
            .split_whitespace()
            .filter_map(|x| x.parse().ok())
            .collect();
        numbers.try_into().expect("six numbers a line")
    };
    printed.lines().map(line).collect()
}

#[test]
fn the_example_reads_ticks_and_tells_the_margin() {
    let input = fs::read_to_string(format!("{ROOT}/tests/firmware/postures.txt")).unwrap();
    for config in [M3_FIXED, M3_F32, M4F_F32, HOST_FIXED, HOST_F32] {
        let printed = machine::printed(&mut config.command("main"), &input, LIMIT);
        let rows = read_example(&printed);
        assert_eq!(
            rows.len(),
            input.lines().count(),
            "{}: {printed}",
            config.name
        );
        for (row, line) in rows.iter().zip(input.lines()) {
            let ticks: Vec<f64> = line
                .split_whitespace()
                .map(|t| t.parse().unwrap())
                .collect();
            let q = std::array::from_fn(|k| (ticks[k] - 2048.0) * std::f64::consts::TAU / 4096.0);
            let [x, y, z] = op2::com(&q, &op2::CAD_PARAMS).map(|m| 1000.0 * m);
            // The outline of the sole, without the example's way to it.
            let margin = (53.0 - x).min(x + 52.0).min(33.0 - y).min(y + 33.0);
            for (got, expected) in row.iter().zip([x, y, z, x, y, margin]) {
                assert!(
                    (got - expected).abs() < 0.003,
                    "{}: {got} {expected}",
                    config.name
                );
            }
        }
        // All zero: what Pinocchio and MuJoCo say; and it falls over, being on one foot.
        for (got, expected) in rows[0]
            .iter()
            .zip([-4.057, 46.476, 228.231, -4.057, 46.476, -13.476])
        {
            assert!((got - expected).abs() < 0.002, "{}: {printed}", config.name);
        }
        assert!(rows[2][5] > 30.0, "leaning over the foot: {printed}");

        let short = machine::run(&mut config.command("main"), "1 2 3\n", LIMIT);
        assert_eq!(short.status.code(), Some(2), "{}", config.name);
        let message = String::from_utf8_lossy(&short.stderr);
        assert!(
            message.contains("line 1: give 20 ticks, head_pan to r_el"),
            "{message}"
        );
    }
}
