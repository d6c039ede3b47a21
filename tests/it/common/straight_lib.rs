//! The functions whose machine code is read; part of a crate that the tests write.

use sesc_generated::op2_r_sole as op2;

#[unsafe(no_mangle)]
pub fn straight_com(q: &[f64; op2::DOF], r: &[f64; op2::BASE_PARAMS], out: &mut [f64; 3]) {
    *out = op2::com(q, r);
}

#[unsafe(no_mangle)]
pub fn straight_com_f32(q: &[f32; op2::DOF], r: &[f32; op2::BASE_PARAMS], out: &mut [f32; 3]) {
    *out = op2::com(q, r);
}

#[unsafe(no_mangle)]
pub fn straight_com_jacobian(
    q: &[f64; op2::DOF],
    r: &[f64; op2::BASE_PARAMS],
    out: &mut [[f64; op2::DOF]; 3],
) {
    *out = op2::com_jacobian(q, r);
}

#[unsafe(no_mangle)]
pub fn straight_regressor(q: &[f64; op2::DOF], out: &mut [[f64; op2::BASE_PARAMS]; 3]) {
    *out = op2::regressor(q);
}
