//! What `symplex-build` writes, called as it is.

#[allow(clippy::all, unused)]
mod double {
    include!(concat!(env!("OUT_DIR"), "/symplex_f64.rs"));
}
#[allow(clippy::all, unused)]
mod single {
    include!(concat!(env!("OUT_DIR"), "/symplex_f32.rs"));
}

const DOF: usize = 20;

macro_rules! call {
    ($function:path, $q:ident) => {
        $function(
            $q[0], $q[1], $q[2], $q[3], $q[4], $q[5], $q[6], $q[7], $q[8], $q[9], $q[10], $q[11],
            $q[12], $q[13], $q[14], $q[15], $q[16], $q[17], $q[18], $q[19],
        )
    };
}

macro_rules! offer {
    ($scalar:ty, $function:path, $width:literal, $batch:ident $(, $one:ident)?) => {
        $(
            /// One posture.
            ///
            /// # Safety
            /// `q` holds 20 numbers, `out` has room for the result.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $one(q: *const $scalar, out: *mut $scalar) {
                // SAFETY: the caller passes 20 numbers and room for the result, which do not overlap.
                let q = unsafe { &*q.cast::<[$scalar; DOF]>() };
                // SAFETY: as above.
                unsafe { *out.cast::<[$scalar; $width]>() = call!($function, q) };
            }
        )?

        /// `n` postures.
        ///
        /// # Safety
        /// `q` holds 20 n numbers, `out` has room for n results.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $batch(q: *const $scalar, n: usize, out: *mut $scalar) {
            // SAFETY: the caller passes 20 n numbers, which nobody changes meanwhile.
            let q = unsafe { std::slice::from_raw_parts(q.cast::<[$scalar; DOF]>(), n) };
            // SAFETY: the caller passes room for n results, which nobody else reads or writes.
            let out = unsafe { std::slice::from_raw_parts_mut(out.cast::<[$scalar; $width]>(), n) };
            for (q, out) in q.iter().zip(out) {
                *out = call!($function, q);
            }
        }
    };
}

offer!(f64, double::com, 3, symplex_com_batch, symplex_com);
offer!(
    f64,
    double::jacobian,
    60,
    symplex_jacobian_batch,
    symplex_jacobian
);
offer!(f32, single::com, 3, symplex_com_batch_f32);
offer!(f32, single::jacobian, 60, symplex_jacobian_batch_f32);
