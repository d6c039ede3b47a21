//! Least squares by `faer` and `nalgebra`, rows from any function that makes them.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::{Llt, SolveCore, SolveLstsqCore};
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par, Side};
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

const DOF: usize = 20;
const BASE: usize = 42;
/// Postures whose rows are made at a time.
const BLOCK: usize = 512;

/// Rows of one posture: columns of 2.
type Rows = unsafe extern "C" fn(*const f64, *mut f64);

struct Data<'a> {
    rows: Rows,
    q: &'a [f64],
    reading: &'a [f64],
}

impl Data<'_> {
    /// # Safety
    /// The arrays hold `n` postures and readings.
    unsafe fn new<'a>(rows: Rows, q: *const f64, reading: *const f64, n: usize) -> Data<'a> {
        Data {
            rows,
            // SAFETY: the caller passes `n` postures of 20 numbers.
            q: unsafe { std::slice::from_raw_parts(q, DOF * n) },
            // SAFETY: the caller passes `n` readings of 2 numbers.
            reading: unsafe { std::slice::from_raw_parts(reading, 2 * n) },
        }
    }

    fn postures(&self) -> usize {
        self.reading.len() / 2
    }

    /// Rows of postures from `start` on into `to`, column by column, `height` apart.
    fn fill(&self, start: usize, count: usize, to: &mut [f64], height: usize) {
        let mut columns = [0.0; 2 * BASE];
        for k in 0..count {
            let q = &self.q[DOF * (start + k)..DOF * (start + k + 1)];
            // SAFETY: `q` has 20 numbers, and `columns` the room that rows of one posture take.
            unsafe { (self.rows)(q.as_ptr(), columns.as_mut_ptr()) };
            for (column, pair) in columns.as_chunks::<2>().0.iter().enumerate() {
                to[column * height + 2 * k..][..2].copy_from_slice(pair);
            }
        }
    }

    /// Blocks of rows and readings, one after the other.
    fn blocks(&self, mut each: impl FnMut(&[f64], &[f64])) {
        let mut block = vec![0.0; 2 * BLOCK * BASE];
        for start in (0..self.postures()).step_by(BLOCK) {
            let count = BLOCK.min(self.postures() - start);
            let used = &mut block[..2 * count * BASE];
            self.fill(start, count, used, 2 * count);
            each(used, &self.reading[2 * start..2 * (start + count)]);
        }
    }
}

/// # Safety
/// `params` has room for 42 numbers, which nobody else reads or writes.
unsafe fn answer(found: impl Iterator<Item = f64>, params: *mut f64) {
    // SAFETY: as the caller says.
    let params = unsafe { std::slice::from_raw_parts_mut(params, BASE) };
    params.iter_mut().zip(found).for_each(|(to, x)| *to = x);
}

/// `faer`: Gram matrix of blocks, Cholesky.
///
/// # Safety
/// `q` holds 20 n numbers, `reading` 2 n, `params` has room for 42.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn faer_normal_fit(
    rows: Rows,
    q: *const f64,
    reading: *const f64,
    n: usize,
    params: *mut f64,
) {
    // SAFETY: the caller passes `n` postures and readings.
    let data = unsafe { Data::new(rows, q, reading, n) };
    let mut gram = Mat::<f64>::zeros(BASE, BASE);
    let mut right = Mat::<f64>::zeros(BASE, 1);
    data.blocks(|block, reading| {
        let a = MatRef::from_column_major_slice(block, reading.len(), BASE);
        let y = MatRef::from_column_major_slice(reading, reading.len(), 1);
        triangular::matmul(
            gram.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            a.transpose(),
            BlockStructure::Rectangular,
            a,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        faer::linalg::matmul::matmul(right.as_mut(), Accum::Add, a.transpose(), y, 1.0, Par::Seq);
    });
    let factor = Llt::new(gram.as_ref(), Side::Lower).expect("rows of full rank");
    factor.solve_in_place_with_conj(Conj::No, right.as_mut());
    // SAFETY: the caller passes room for 42 numbers.
    unsafe { answer((0..BASE).map(|i| right[(i, 0)]), params) };
}

/// `faer`: all rows as one matrix, QR.
///
/// # Safety
/// As [`faer_normal_fit`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn faer_qr_fit(
    rows: Rows,
    q: *const f64,
    reading: *const f64,
    n: usize,
    params: *mut f64,
) {
    // SAFETY: the caller passes `n` postures and readings.
    let data = unsafe { Data::new(rows, q, reading, n) };
    let mut all = vec![0.0; 2 * n * BASE];
    data.fill(0, n, &mut all, 2 * n);
    let mut y = reading_of(&data);
    let factor = MatRef::from_column_major_slice(&all, 2 * n, BASE).qr();
    let mut y = MatMut::from_column_major_slice_mut(&mut y, 2 * n, 1);
    factor.solve_lstsq_in_place_with_conj(Conj::No, y.as_mut());
    // SAFETY: the caller passes room for 42 numbers.
    unsafe { answer((0..BASE).map(|i| y[(i, 0)]), params) };
}

fn reading_of(data: &Data) -> Vec<f64> {
    data.reading.to_vec()
}

/// `nalgebra`: Gram matrix of blocks, Cholesky.
///
/// # Safety
/// As [`faer_normal_fit`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nalgebra_normal_fit(
    rows: Rows,
    q: *const f64,
    reading: *const f64,
    n: usize,
    params: *mut f64,
) {
    // SAFETY: the caller passes `n` postures and readings.
    let data = unsafe { Data::new(rows, q, reading, n) };
    let mut gram = DMatrix::<f64>::zeros(BASE, BASE);
    let mut right = DVector::<f64>::zeros(BASE);
    data.blocks(|block, reading| {
        let a = DMatrixView::from_slice(block, reading.len(), BASE);
        let y = DVectorView::from_slice(reading, reading.len());
        // A product of matrices takes the quick kernel, A' A by itself does not.
        gram.gemm(1.0, &a.transpose(), &a, 1.0);
        right.gemv_tr(1.0, &a, &y, 1.0);
    });
    let factor = gram.cholesky().expect("rows of full rank");
    // SAFETY: the caller passes room for 42 numbers.
    unsafe { answer(factor.solve(&right).iter().copied(), params) };
}
