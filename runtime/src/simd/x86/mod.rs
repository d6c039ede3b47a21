//! Registers of x86-64, and the operations that a [`Real`](crate::Real) takes.
//!
//! Every operation is `inline(always)` around one instruction, and ends up inside one of
//! the entry functions that are compiled for the set.
//!
//! # Safety
//!
//! What an instruction needs is a processor that has it, and a system that saves its
//! registers. A [`Simd`](crate::Simd) of a set comes from `Simd::available` alone, which asks
//! for both; a register comes from a task alone, which [`Dispatch`](crate::scalar::sealed)
//! runs on a `Simd`, and both traits are sealed. So whoever holds a register may use it, also
//! in code of a robot that the compiler did not put into the entry function: there an
//! instruction is a call, registers go through memory as Rust's own calling convention passes
//! them, and only time is lost. No function of C takes or returns a register.
//!
//! There is no stack of our own: `align_stack` is a local variable with an alignment, for
//! which the compiler moves the stack pointer within the caller's stack and describes that
//! to debuggers and unwinding as for any other function. Panics unwind through it, signals
//! interrupt it, guard pages and probes see it as usual.

#![allow(unsafe_code)]

pub(super) mod avx2;
pub(super) mod avx512;
mod fused;

/// True where the processor, and the system, have all that the entry of AVX2 is compiled for.
#[cfg(feature = "std")]
pub(super) fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

/// True where the processor, and the system, have all that the entry of AVX-512 is compiled for;
/// F16C is part of AVX-512 F for the compiler, though no instruction of it is used here.
#[cfg(feature = "std")]
pub(super) fn has_avx512() -> bool {
    has_avx2()
        && std::arch::is_x86_feature_detected!("f16c")
        && std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512dq")
        && std::arch::is_x86_feature_detected!("avx512vl")
}

/// True on processors of AMD, which alone have SSE4a: Zen 4 executes 512 bits in two halves, and
/// the three rows of one posture fill no more than one. Those of Intel close a port while 512 bits
/// are under way, so that there sines and rows have to be of one width.
#[cfg(feature = "std")]
pub(super) fn prefers_short() -> bool {
    std::arch::is_x86_feature_detected!("sse4a")
}

#[cfg(not(feature = "std"))]
pub(super) fn prefers_short() -> bool {
    cfg!(target_feature = "sse4a")
}

#[cfg(not(feature = "std"))]
pub(super) fn has_avx2() -> bool {
    cfg!(all(target_feature = "avx2", target_feature = "fma"))
}

#[cfg(not(feature = "std"))]
pub(super) fn has_avx512() -> bool {
    has_avx2()
        && cfg!(all(
            target_feature = "avx512f",
            target_feature = "avx512dq",
            target_feature = "avx512vl"
        ))
}

/// Lets the caller's stack begin at a cache line.
///
/// The compiler saves registers on the stack wherever it happens to begin, 16 bytes after
/// a multiple of 64 as often as not, unless a local asks for more: then every register of
/// 512 bits that is saved straddles two cache lines, and a Jacobian takes a third longer.
#[inline(always)]
fn align_stack() {
    #[repr(align(64))]
    struct Line(#[allow(dead_code)] u8);
    core::hint::black_box(&mut Line(0));
}

/// A register as a [`Real`](crate::Real), from its instructions.
macro_rules! register {
    (
        $(#[$doc:meta])*
        $name:ident($raw:ty): $lanes:literal of $scalar:ty;
        $splat:ident $load:ident $store:ident
        $add:ident $sub:ident $mul:ident $div:ident $fused:ident
        $max:ident $min:ident
        negate $negate:expr;
        sin_cos $sin_cos:expr;
        power $power:path;
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $name($raw);

        register!(@operator $name Add add $add);
        register!(@operator $name Sub sub $sub);
        register!(@operator $name Mul mul $mul);
        register!(@operator $name Div div $div);

        impl core::ops::Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see the head of this module.
                Self(unsafe { $negate(self.0) })
            }
        }

        impl $name {
            #[inline(always)]
            pub(super) fn splat(x: $scalar) -> Self {
                // SAFETY: see the head of this module.
                Self(unsafe { $splat(x) })
            }

            #[inline(always)]
            pub(super) fn array(self) -> [$scalar; $lanes] {
                let mut array = [0.0; $lanes];
                // SAFETY: see the head of this module; the array has room for the register.
                unsafe { $store(array.as_mut_ptr(), self.0) };
                array
            }

            #[inline(always)]
            pub(super) fn of(array: &[$scalar; $lanes]) -> Self {
                // SAFETY: see the head of this module; the array fills the register.
                Self(unsafe { $load(array.as_ptr()) })
            }
        }

        impl crate::Real for $name {
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self::splat(x as $scalar)
            }

            #[inline(always)]
            fn mul_plus(self, factor: Self, term: Self) -> Self {
                // SAFETY: see the head of this module.
                Self(unsafe { $fused(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }

            #[inline(always)]
            fn clamp_unit(self) -> Self {
                let (low, high) = (Self::from_f64(-1.0), Self::from_f64(1.0));
                // Of two operands the second is the answer where either is NaN.
                // SAFETY: see the head of this module.
                Self(unsafe { $min(high.0, $max(low.0, self.0)) })
            }

            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                // Of two operands the second is the answer where neither is larger.
                // SAFETY: see the head of this module.
                Self(unsafe { $max(other.0, self.0) })
            }

            #[inline(always)]
            fn power(self, exponent: Self) -> Self {
                let (mut array, exponents) = (self.array(), exponent.array());
                for (x, exponent) in array.iter_mut().zip(&exponents) {
                    *x = $power(*x, *exponent);
                }
                Self::of(&array)
            }
        }
    };
    (@operator $name:ident $trait:ident $method:ident $instruction:ident) => {
        impl core::ops::$trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: see the head of this module.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}
use register;

/// Registers as a [`Machine`](crate::scalar::sealed::Machine) of each set.
macro_rules! machine {
    (
        $vector:ident, $lanes:literal of $scalar:ty, $count:literal a block,
        $one:ty, rows $($set:ident: $rows:ident),+;
        columns $columns:path;
        sin_cos $sin_cos:path;
    ) => {
        $(impl crate::scalar::sealed::Machine<$scalar> for $set {
            type Vector = $vector;
            const PARTS: usize = $count / $lanes;
            type One = $one;
            type Rows = $rows;

            #[inline(always)]
            fn splat(x: $scalar) -> $vector {
                <$vector>::splat(x)
            }

            #[inline(always)]
            fn load<const N: usize>(
                blocks: &[crate::Lanes<$scalar, $count>; N],
                part: usize,
            ) -> [$vector; N] {
                core::array::from_fn(|k| {
                    let (values, _) = blocks[k].0[part * $lanes..].as_chunks();
                    $vector::of(&values[0])
                })
            }

            #[inline(always)]
            fn columns<const N: usize>(rows: &[[$scalar; N]], part: usize) -> [$vector; N] {
                match rows.first_chunk() {
                    Some(rows) => $columns(rows, part),
                    None => [<$vector>::splat(0.0); N],
                }
            }

            #[inline(always)]
            fn store(
                vectors: &[$vector],
                blocks: &mut [crate::Lanes<$scalar, $count>],
                part: usize,
            ) {
                let len = vectors.len().min(blocks.len());
                if $lanes == $count {
                    // SAFETY: a register and a block have the same size and alignment and
                    // hold numbers of any bits, `len` of both are there, and what is borrowed
                    // for writing does not overlap what is borrowed for reading. One copy,
                    // which the compiler can dissolve.
                    unsafe {
                        let from = vectors.as_ptr().cast::<crate::Lanes<$scalar, $count>>();
                        core::ptr::copy_nonoverlapping(from, blocks.as_mut_ptr(), len);
                    }
                } else {
                    for (vector, block) in vectors.iter().zip(blocks) {
                        block.0[part * $lanes..][..$lanes].copy_from_slice(&vector.array());
                    }
                }
            }

            #[inline(always)]
            fn place<'a, const N: usize, const M: usize>(
                blocks: &'a mut [[crate::Lanes<$scalar, $count>; N]; M],
                room: &'a mut [[$vector; N]; M],
            ) -> &'a mut [[$vector; N]; M] {
                match $lanes == $count {
                    // SAFETY: a register and a block have the same size and alignment, any
                    // bits are numbers in both, and the borrow goes on in the result.
                    true => unsafe { &mut *core::ptr::from_mut(blocks).cast() },
                    false => room,
                }
            }

            #[inline(always)]
            fn ones<const N: usize>(scalars: &[$scalar; N]) -> &[$one; N] {
                // SAFETY: the one is a transparent wrapper of the other.
                unsafe { &*core::ptr::from_ref(scalars).cast() }
            }

            #[inline(always)]
            fn scalars(ones: &[$one]) -> &[$scalar] {
                // SAFETY: the one is a transparent wrapper of the other, and there are as many.
                unsafe { core::slice::from_raw_parts(ones.as_ptr().cast(), ones.len()) }
            }

            #[inline(always)]
            fn every_row(x: $scalar) -> $rows {
                $rows::splat(x)
            }

            #[inline(always)]
            fn rows(numbers: [$scalar; ROWS]) -> $rows {
                let mut lanes = $rows::splat(0.0).array();
                for (lane, x) in lanes.iter_mut().zip(numbers) {
                    *lane = x;
                }
                $rows::of(&lanes)
            }

            #[inline(always)]
            fn numbers(rows: $rows) -> [$scalar; ROWS] {
                let lanes = rows.array();
                [lanes[0], lanes[1], lanes[2], lanes[3]]
            }

            #[inline(always)]
            fn sin_cos<const N: usize>(
                angles: &[$scalar; N],
                sin: &mut [$scalar; N],
                cos: &mut [$scalar; N],
            ) {
                $sin_cos(angles, sin, cos)
            }
        })+
    };
}
use machine;
