//! The peers' libraries, and what their answers mean.
//!
//! Every contestant, ours included, is a C function of the shapes of `peers.h`,
//! called through a pointer, with the results in an array of the caller.

use std::error::Error as _;
use std::ffi::{CStr, CString, c_char};
use std::path::Path;

use libloading::{Library, Symbol};
use sesc_model::Function;

use crate::ours::{self, One};

/// Postures one after the other.
pub type Batch<T> = extern "C" fn(*const T, usize, *mut T);
/// Least squares: a maker of rows, postures, readings, how many, parameters.
pub type Fit = extern "C" fn(One<f64>, *const f64, *const f64, usize, *mut f64);

/// Columns of the CoP rows as the peers have them.
pub const BASE: usize = 42;

/// What the numbers of an answer are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    Com,
    /// 3 × joints, one row after the other.
    JacobianRows,
    /// 3 × joints, one column after the other.
    JacobianColumns,
    /// 3 × 3 per joint, one column after the other: the turn of its body.
    Full,
    /// 3 × 4 per joint: columns of mass and first moments.
    Standard,
    /// 2 × 42, one column after the other.
    Cop,
}

impl Answer {
    pub fn len(self) -> usize {
        match self {
            Answer::Com => 3,
            Answer::JacobianRows | Answer::JacobianColumns => 3 * ours::DOF,
            Answer::Full => 9 * ours::DOF,
            Answer::Standard => 12 * ours::DOF,
            Answer::Cop => 2 * BASE,
        }
    }
}

/// Who answers what: name in the table, prefix of the symbols, answer.
pub fn contestants(function: Function) -> &'static [(&'static str, &'static str, Answer)] {
    match function {
        Function::Com => &[
            ("Pinocchio", "pinocchio_com", Answer::Com),
            ("CasADi", "casadi_com", Answer::Com),
            ("MuJoCo", "mujoco_com", Answer::Com),
            ("k", "k_com", Answer::Com),
            ("symplex", "symplex_com", Answer::Com),
        ],
        Function::ComJacobian => &[
            ("Pinocchio", "pinocchio_jacobian", Answer::JacobianColumns),
            ("CasADi", "casadi_jacobian", Answer::JacobianColumns),
            ("MuJoCo", "mujoco_jacobian", Answer::JacobianRows),
            ("symplex", "symplex_jacobian", Answer::JacobianRows),
        ],
        Function::RegressorFull => &[
            ("Pinocchio", "pinocchio_full", Answer::Full),
            ("Pinocchio, 3×80", "pinocchio_standard", Answer::Standard),
            ("CasADi", "casadi_full", Answer::Full),
        ],
        _ => &[
            ("Pinocchio", "pinocchio_cop", Answer::Cop),
            ("CasADi", "casadi_cop", Answer::Cop),
        ],
    }
}

pub struct Peers {
    libraries: Vec<Library>,
    /// Our joint that stands where the peers have joint i.
    order: Vec<usize>,
    full: Vec<f64>,
    base: Vec<f64>,
}

impl Peers {
    /// Load what `benches/peers/run` has built in `folder`.
    pub fn open(folder: &Path) -> Result<Peers, String> {
        let mut libraries = Vec::new();
        for name in ["pinocchio", "casadi", "casadi_f32", "mujoco", "crates", "lanes"] {
            let path = folder.join(format!("libpeer_{name}.so"));
            // SAFETY: built from the sources beside this program; no initialiser of
            // theirs does more than set up a robot.
            let library = unsafe { Library::new(&path) };
            libraries.push(library.map_err(|error| {
                let cause = error
                    .source()
                    .map_or(String::new(), |cause| format!(": {cause}"));
                format!(
                    "{error}{cause}; benches/peers/run builds {}",
                    path.display()
                )
            })?);
        }
        let mut peers = Peers {
            libraries,
            order: Vec::new(),
            full: Vec::new(),
            base: Vec::new(),
        };
        peers.agree(folder)?;
        Ok(peers)
    }

    /// Names of joints, parameters, and the robot's file for those who read it.
    fn agree(&mut self, folder: &Path) -> Result<(), String> {
        let name = self.symbol::<extern "C" fn(i32) -> *const c_char>("peer_joint")?;
        let names: Vec<*const c_char> = (0..ours::DOF as i32).map(|i| name(i)).collect();
        for &name in &names {
            // SAFETY: a string constant of the library.
            let name = unsafe { CStr::from_ptr(name) }.to_string_lossy();
            let ours = ours::JOINT_NAMES.iter().position(|ours| *ours == name);
            self.order
                .push(ours.ok_or_else(|| format!("the peers' joint {name} is none of ours"))?);
        }
        let array = |name: &str, len: usize| -> Result<Vec<f64>, String> {
            let get = self.symbol::<extern "C" fn() -> *const f64>(name)?;
            // SAFETY: a constant array of the library, of this length.
            Ok(unsafe { std::slice::from_raw_parts(get(), len) }.to_vec())
        };
        let (full, base) = (array("robot_full", 63)?, array("robot_base", BASE)?);
        (self.full, self.base) = (full, base);

        let urdf = folder
            .join("robot.urdf")
            .into_os_string()
            .into_encoded_bytes();
        let urdf = CString::new(urdf).map_err(|_| "a path with a zero byte".to_string())?;
        type MujocoOpen = extern "C" fn(*const c_char) -> *const c_char;
        let complaint = self.symbol::<MujocoOpen>("mujoco_open")?(urdf.as_ptr());
        if !complaint.is_null() {
            // SAFETY: a string of the library that outlives this line.
            let complaint = unsafe { CStr::from_ptr(complaint) }.to_string_lossy();
            return Err(format!("MuJoCo does not read robot.urdf: {complaint}"));
        }
        type KOpen = extern "C" fn(*const c_char, *const *const c_char) -> i32;
        match self.symbol::<KOpen>("k_open")?(urdf.as_ptr(), names.as_ptr()) {
            0 => Ok(()),
            _ => Err("the crate k does not read robot.urdf".into()),
        }
    }

    /// A function of any of the libraries.
    pub fn symbol<F: Copy>(&self, name: &str) -> Result<F, String> {
        // SAFETY: `F` is what `peers.h` and `crates/` say of this name, and the
        // libraries live as long as the program.
        let found = |library| unsafe { Library::get(library, name.as_bytes()) }.ok();
        let symbol: Option<Symbol<F>> = self.libraries.iter().find_map(found);
        let symbol = symbol.ok_or_else(|| format!("no library has the function {name}"))?;
        Ok(*symbol)
    }

    /// The same function, where a peer has it.
    pub fn maybe<F: Copy>(&self, name: &str) -> Option<F> {
        self.symbol(name).ok()
    }

    /// Postures in the peers' order of the joints.
    pub fn reordered<T: Copy>(&self, q: &[T]) -> Vec<T> {
        q.chunks(ours::DOF)
            .flat_map(|q| self.order.iter().map(|&ours| q[ours]))
            .collect()
    }

    /// What our function says to the same question: CoM, or Jacobian in rows.
    pub fn expected(answer: Answer, q: &[f64]) -> Vec<f64> {
        let function = match answer {
            Answer::JacobianRows | Answer::JacobianColumns => Function::ComJacobian,
            _ => Function::Com,
        };
        let mut out = vec![0.0; 3 * ours::DOF];
        ours::one(function)(q.as_ptr(), out.as_mut_ptr());
        let len = match (function, answer) {
            (Function::Com, Answer::Cop) => 2,
            (Function::Com, _) => 3,
            _ => out.len(),
        };
        out.truncate(len);
        out
    }

    /// The numbers of an answer, to be compared with `expected`.
    pub fn meaning(&self, answer: Answer, out: &[f64]) -> Vec<f64> {
        match answer {
            Answer::Com => out.to_vec(),
            Answer::JacobianRows | Answer::JacobianColumns => {
                let mut rows = vec![0.0; 3 * ours::DOF];
                for (peer, &joint) in self.order.iter().enumerate() {
                    for row in 0..3 {
                        rows[row * ours::DOF + joint] = match answer {
                            Answer::JacobianRows => out[row * ours::DOF + peer],
                            _ => out[3 * peer + row],
                        };
                    }
                }
                rows
            }
            Answer::Full => {
                let mut com = self.full[..3].to_vec();
                add_columns(&mut com, out, &self.full[3..]);
                com
            }
            Answer::Standard => {
                let mut com = vec![0.0; 3];
                if let Some(of) = self.maybe::<One<f64>>("pinocchio_com_of_standard") {
                    of(out.as_ptr(), com.as_mut_ptr());
                }
                com
            }
            Answer::Cop => {
                let mut cop = vec![0.0; 2];
                add_columns(&mut cop, out, &self.base);
                cop
            }
        }
    }
}

/// sum += columns · params
pub fn add_columns(sum: &mut [f64], columns: &[f64], params: &[f64]) {
    for (column, param) in columns.chunks(sum.len()).zip(params) {
        for (sum, x) in sum.iter_mut().zip(column) {
            *sum += x * param;
        }
    }
}
