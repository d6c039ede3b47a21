//! Parameters from postures and CoP readings in memory.
//!
//! Everyone starts from joint angles and readings and ends with parameters; the
//! CoP that these predict for other postures is compared.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use sesc_identify::simulate::Simulator;
use sesc_model::Function;

use crate::functions::largest;
use crate::ours::One;
use crate::peers::{BASE, Fit, Peers, add_columns};
use crate::turns::{Entry, Found, compare};
use crate::{our_fit, ours};

/// Standard deviation of a CoP reading, m.
const NOISE: f64 = 0.00493;
/// Postures are drawn from ±this, rad.
const RANGE: f64 = 0.5;
/// Postures that parameters are compared on.
const OTHERS: usize = 200;
/// Predictions may differ by this much, m.
const AGREE: f64 = 1e-9;

/// Name, maker of rows, solver.
const PIPELINES: [(&str, &str, &str); 5] = [
    ("CasADi rows, Eigen LDLT", "casadi_cop", "eigen_fit"),
    ("Pinocchio rows, Eigen LDLT", "pinocchio_cop", "eigen_fit"),
    (
        "CasADi rows, faer Gram + Cholesky",
        "casadi_cop",
        "faer_normal_fit",
    ),
    (
        "CasADi rows, nalgebra Gram + Cholesky",
        "casadi_cop",
        "nalgebra_normal_fit",
    ),
    ("CasADi rows, faer QR", "casadi_cop", "faer_qr_fit"),
];

/// Python in a process of its own, which times itself.
struct Numpy {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Numpy {
    fn start(python: &Path, folder: &Path) -> Result<Numpy, String> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../numpy_fit.py");
        let mut child = Command::new(python)
            .arg(script)
            .arg(folder)
            .env("OPENBLAS_NUM_THREADS", "1")
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", python.display()))?;
        let (Some(to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipe to Python".into());
        };
        let from = BufReader::new(from);
        Ok(Numpy { child, to, from })
    }

    /// One fit: seconds, parameters.
    fn fit(&mut self) -> Result<(f64, Vec<f64>), String> {
        let gone = |error: std::io::Error| format!("numpy_fit.py: {error}");
        self.to.write_all(b"fit\n").map_err(gone)?;
        self.to.flush().map_err(gone)?;
        let mut line = String::new();
        self.from.read_line(&mut line).map_err(gone)?;
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match numbers.as_deref() {
            Ok([seconds, params @ ..]) if params.len() == BASE => Ok((*seconds, params.to_vec())),
            _ => Err("numpy_fit.py has failed; its complaint stands above".into()),
        }
    }
}

impl Drop for Numpy {
    fn drop(&mut self) {
        // It ends by itself when the pipe closes; this is for one that hangs.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn write(path: &Path, values: &[f64]) -> Result<(), String> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_ne_bytes()).collect();
    std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// Ours first: parameters alone. `progress` is told of each contestant.
pub fn measure(
    peers: &Peers,
    folder: &Path,
    python: &Path,
    postures: usize,
    rounds: usize,
) -> Result<Vec<Found>, String> {
    let model = ours::model();
    let mut simulator = Simulator::new(&model.tree.dofs, Some(RANGE), 1);
    let q = simulator.batch(postures);
    let com = ours::one(Function::Com);
    let reading: Vec<[f64; 2]> = q
        .chunks(ours::DOF)
        .map(|q| {
            let mut at = [0.0; 3];
            com(q.as_ptr(), at.as_mut_ptr());
            [
                at[0] + simulator.gauss(NOISE),
                at[1] + simulator.gauss(NOISE),
            ]
        })
        .collect();
    let others = simulator.batch(OTHERS);
    let peers_q = peers.reordered(&q);
    let flat = reading.as_flattened();
    write(&folder.join("fit_q.bin"), &peers_q)?;
    write(&folder.join("fit_reading.bin"), flat)?;

    let robot = ours::robot();
    let log = our_fit::log(&q, &reading);
    let expected = predicted_by_ours(&our_fit::parameters(&q, &reading), &others);
    let everything = predicted_by_ours(&our_fit::everything(&robot, &log), &others);
    let casadi = peers.symbol::<One<f64>>("casadi_cop")?;
    let others = peers.reordered(&others);
    let check = |name: &str, cop: &[f64]| -> Result<(), String> {
        let difference = largest(cop, &expected);
        if difference.is_nan() || difference > AGREE {
            return Err(format!(
                "after the fit, {name} and ours differ by {difference:.1e} m of CoP"
            ));
        }
        Ok(())
    };
    check("ours in full", &everything)?;

    eprintln!("  numpy");
    let numpy = RefCell::new(Numpy::start(python, folder)?);
    let (_, params) = numpy.borrow_mut().fit()?;
    check("numpy", &predicted(casadi, &params, &others))?;
    let broken = RefCell::new(None);

    let mut entries = vec![
        Entry::new("ours, parameters alone", || {
            std::hint::black_box(our_fit::parameters(&q, &reading));
        }),
        Entry::new("ours, all that `sesc fit` says", || {
            std::hint::black_box(our_fit::everything(&robot, &log));
        }),
    ];
    for (name, rows, solver) in PIPELINES {
        eprintln!("  {name}");
        let rows = peers.symbol::<One<f64>>(rows)?;
        let fit = peers.symbol::<Fit>(solver)?;
        let (q, mut params) = (&peers_q, vec![0.0; BASE]);
        let run = move |params: &mut Vec<f64>| {
            fit(
                rows,
                q.as_ptr(),
                flat.as_ptr(),
                postures,
                params.as_mut_ptr(),
            );
        };
        run(&mut params);
        check(name, &predicted(casadi, &params, &others))?;
        entries.push(Entry::new(name, move || run(&mut params)));
    }
    entries.push(Entry::timed(
        "numpy rows, numpy.linalg.lstsq",
        || match numpy.borrow_mut().fit() {
            Ok((seconds, _)) => seconds,
            Err(error) => {
                *broken.borrow_mut() = Some(error);
                f64::NAN
            }
        },
    ));
    let found = compare(entries, rounds, Duration::ZERO);
    match broken.take() {
        None => Ok(found),
        Some(error) => Err(error),
    }
}

fn predicted_by_ours(params: &[f64], q: &[f64]) -> Vec<f64> {
    let rows_of = ours::one(Function::RegressorCop);
    let mut rows = vec![0.0; 2 * params.len()];
    let each = q.chunks(ours::DOF).flat_map(|q| {
        rows_of(q.as_ptr(), rows.as_mut_ptr());
        let row = |row: &[f64]| row.iter().zip(params).map(|(x, r)| x * r).sum();
        let cop: Vec<f64> = rows.chunks(params.len()).map(row).collect();
        cop
    });
    each.collect()
}

fn predicted(rows_of: One<f64>, params: &[f64], q: &[f64]) -> Vec<f64> {
    let mut columns = vec![0.0; 2 * BASE];
    let each = q.chunks(ours::DOF).flat_map(|q| {
        rows_of(q.as_ptr(), columns.as_mut_ptr());
        let mut cop = [0.0; 2];
        add_columns(&mut cop, &columns, params);
        cop
    });
    each.collect()
}
