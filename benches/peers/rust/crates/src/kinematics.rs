//! The crate `k`: forward kinematics with cached transforms, and the CoM of its links.

use std::ffi::{CStr, c_char};
use std::sync::OnceLock;

const DOF: usize = 20;

struct Robot {
    chain: k::Chain<f64>,
    /// Where `k` wants joint i.
    place: [usize; DOF],
}

static ROBOT: OnceLock<Robot> = OnceLock::new();

fn open(urdf: &str, joints: &[&str]) -> Option<Robot> {
    let chain = k::Chain::<f64>::from_urdf_file(urdf).ok()?;
    let names: Vec<String> = chain
        .iter_joints()
        .map(|joint| joint.name.clone())
        .collect();
    let mut place = [0; DOF];
    for (joint, at) in joints.iter().zip(&mut place) {
        *at = names.iter().position(|name| name == joint)?;
    }
    Some(Robot { chain, place })
}

/// 0, or 1 if `k` does not make this robot of the file.
///
/// # Safety
/// `urdf` is a C string, `joints` an array of 20 of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn k_open(urdf: *const c_char, joints: *const *const c_char) -> i32 {
    // SAFETY: the caller passes C strings, which live until this returns.
    let text = |at: *const c_char| unsafe { CStr::from_ptr(at) }.to_str().unwrap_or("");
    // SAFETY: the caller passes an array of 20 of them.
    let joint = |i| unsafe { *joints.add(i) };
    let joints: Vec<&str> = (0..DOF).map(|i| text(joint(i))).collect();
    match open(text(urdf), &joints) {
        Some(robot) => i32::from(ROBOT.set(robot).is_err()),
        None => 1,
    }
}

/// CoM of one posture.
///
/// # Safety
/// `q` holds 20 numbers, `out` has room for 3; `k_open` has returned 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn k_com(q: *const f64, out: *mut f64) {
    let robot = ROBOT.get().expect("k_open comes first");
    // SAFETY: the caller passes 20 numbers.
    let q = unsafe { &*q.cast::<[f64; DOF]>() };
    let mut positions = [0.0; DOF];
    for (x, &at) in q.iter().zip(&robot.place) {
        positions[at] = *x;
    }
    robot.chain.set_joint_positions_unchecked(&positions);
    let com = k::center_of_mass(&robot.chain);
    // SAFETY: the caller passes room for 3 numbers.
    unsafe { *out.cast::<[f64; 3]>() = [com.x, com.y, com.z] };
}

/// CoM of `n` postures.
///
/// # Safety
/// As [`k_com`], `n` times.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn k_com_batch(q: *const f64, n: usize, out: *mut f64) {
    for i in 0..n {
        // SAFETY: the caller passes n times what `k_com` asks for.
        unsafe { k_com(q.add(DOF * i), out.add(3 * i)) };
    }
}
