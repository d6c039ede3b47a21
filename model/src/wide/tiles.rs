//! Rows to columns, and back, in squares of four by four numbers in registers of 256 bits.
//!
//! ```text
//! a0 a1 a2 a3        a0 a1 c0 c1        a0 b0 c0 d0
//! b0 b1 b2 b3   ─▶   b0 b1 d0 d1   ─▶   a1 b1 c1 d1
//! c0 c1 c2 c3        a2 a3 c2 c3        a2 b2 c2 d2
//! d0 d1 d2 d3        b2 b3 d2 d3        a3 b3 c3 d3
//! ```
//!
//! The compiler makes sixteen loads of one number each of the same in plain Rust. Of slices it
//! keeps so many lengths in mind that pointers are loaded again for every square: squares are
//! addressed from the first number of the first row, whose last one is checked before.

/// Numbers in a side of a square.
pub(crate) const SIDE: usize = 4;

/// Columns that are written together: a line of the cache in each row.
pub(crate) const LINE: usize = 8;

/// The first numbers of `count` rows of `width` numbers to the first `count` numbers of as many
/// columns.
///
/// # Panics
/// Where there are more rows than numbers in a column, or the last row ends beyond `rows`.
pub(crate) fn to_columns<const N: usize>(
    rows: &[f64],
    width: usize,
    count: usize,
    mut columns: [&mut [f64; N]; SIDE],
) {
    let done = squares(count);
    #[cfg(target_arch = "x86_64")]
    if done > 0 {
        // SAFETY: `squares` has seen that the processor and the system have AVX2, and AVX with it.
        #[allow(unsafe_code)]
        unsafe {
            x86::to_columns(rows, width, done / SIDE, &mut columns);
        }
    }
    for k in done..count {
        let row = &rows[k * width..][..SIDE];
        for (column, value) in columns.iter_mut().zip(row) {
            column[k] = *value;
        }
    }
}

/// The first `count` numbers of columns, each times its factor, to `count` rows of `width`
/// numbers: to the first of each row.
///
/// # Panics
/// Where there are more rows than numbers in a column, or the last row ends beyond `rows`.
pub(crate) fn to_rows<const N: usize>(
    columns: [&[f64; N]; LINE],
    factors: &[f64; LINE],
    rows: &mut [f64],
    width: usize,
    count: usize,
) {
    let done = squares(count);
    #[cfg(target_arch = "x86_64")]
    if done > 0 {
        // SAFETY: `squares` has seen that the processor and the system have AVX2, and AVX with it.
        #[allow(unsafe_code)]
        unsafe {
            x86::to_rows(&columns, factors, rows, width, done / SIDE);
        }
    }
    for k in done..count {
        let row = &mut rows[k * width..][..LINE];
        for ((to, column), factor) in row.iter_mut().zip(columns).zip(factors) {
            *to = column[k] * factor;
        }
    }
}

/// How many of `count` rows go in squares on this processor.
#[inline(always)]
fn squares(count: usize) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        return count / SIDE * SIDE;
    }
    let _ = count;
    0
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;
    use std::array::from_fn;

    use super::{LINE, SIDE};

    /// See [`to_columns`](super::to_columns): of `fours` times four rows.
    #[target_feature(enable = "avx2")]
    pub(super) fn to_columns<const N: usize>(
        rows: &[f64],
        width: usize,
        fours: usize,
        columns: &mut [&mut [f64; N]; SIDE],
    ) {
        check::<N>(fours, rows.len(), width, SIDE);
        let first = rows.as_ptr();
        for four in 0..fours {
            // SAFETY: see `check`.
            unsafe {
                let square = transposed(from_fn(|k| first.add((four * SIDE + k) * width)));
                for (column, line) in columns.iter_mut().zip(square) {
                    _mm256_storeu_pd(column.as_mut_ptr().add(four * SIDE), line);
                }
            }
        }
    }

    /// See [`to_rows`](super::to_rows): of `fours` times four rows.
    #[target_feature(enable = "avx2")]
    pub(super) fn to_rows<const N: usize>(
        columns: &[&[f64; N]; LINE],
        factors: &[f64; LINE],
        rows: &mut [f64],
        width: usize,
        fours: usize,
    ) {
        check::<N>(fours, rows.len(), width, LINE);
        let first = rows.as_mut_ptr();
        let columns = columns.map(|column| column.as_ptr());
        for four in 0..fours {
            // SAFETY: see `check`.
            unsafe {
                let squares: [[__m256d; SIDE]; LINE / SIDE] = from_fn(|side| {
                    let lines = from_fn(|k| columns[side * SIDE + k].add(four * SIDE));
                    let factors = _mm256_loadu_pd(factors.as_ptr().add(side * SIDE));
                    transposed(lines).map(|line| _mm256_mul_pd(line, factors))
                });
                // A row at a time: its line of the cache is fetched once.
                for k in 0..SIDE {
                    let row = first.add((four * SIDE + k) * width);
                    for (side, square) in squares.iter().enumerate() {
                        _mm256_storeu_pd(row.add(side * SIDE), square[k]);
                    }
                }
            }
        }
    }

    /// So many rows end within the columns, and within `len` numbers.
    fn check<const N: usize>(fours: usize, len: usize, width: usize, columns: usize) {
        let last = (fours * SIDE).saturating_sub(1);
        assert!(last < N, "a column holds a number of each row");
        let end = last.checked_mul(width).and_then(|k| k.checked_add(columns));
        assert!(
            end.is_some_and(|end| end <= len),
            "rows end within the slice"
        );
    }

    /// Four lines as columns.
    ///
    /// # Safety
    /// Four numbers can be read of each line.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn transposed([a, b, c, d]: [*const f64; SIDE]) -> [__m256d; SIDE] {
        // SAFETY: as for the function.
        let half = |line: *const f64, start| unsafe { _mm_loadu_pd(line.add(start)) };
        let halves = |low, high, start| {
            let low = _mm256_castpd128_pd256(half(low, start));
            _mm256_insertf128_pd::<1>(low, half(high, start))
        };
        let [ac, bd] = [halves(a, c, 0), halves(b, d, 0)];
        let [ca, db] = [halves(a, c, 2), halves(b, d, 2)];
        [
            _mm256_unpacklo_pd(ac, bd),
            _mm256_unpackhi_pd(ac, bd),
            _mm256_unpacklo_pd(ca, db),
            _mm256_unpackhi_pd(ca, db),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 12;

    /// A number of its own for each place.
    fn numbers(len: usize) -> Vec<f64> {
        (0..len).map(|k| 1.0 + k as f64).collect()
    }

    #[test]
    fn rows_become_columns() {
        for (count, width) in (0..=N).flat_map(|count| [4, 5, 8, 11].map(|width| (count, width))) {
            // The last row ends where four of it end.
            let rows = numbers(count.saturating_sub(1) * width + SIDE);
            let mut columns = [[0.0; N]; SIDE];
            to_columns(&rows, width, count, columns.each_mut());
            for (k, column) in columns.iter().enumerate() {
                for (row, value) in column.iter().enumerate() {
                    let read = || rows[row * width + k];
                    let wanted = if row < count { read() } else { 0.0 };
                    assert_eq!(*value, wanted, "row {row} of {count}, of {width} numbers");
                }
            }
        }
    }

    #[test]
    fn columns_become_rows() {
        let all = numbers(N * LINE);
        let columns: [&[f64; N]; LINE] = std::array::from_fn(|k| &all.as_chunks().0[k]);
        let factors = [1.0, -1.0, 2.0, 1.0, -3.0, 1.0, 1.0, 0.5];
        for (count, width) in (0..=N).flat_map(|count| [8, 9, 12, 15].map(|width| (count, width))) {
            let mut rows = vec![0.0; count.saturating_sub(1) * width + LINE];
            to_rows(columns, &factors, &mut rows, width, count);
            for (place, value) in rows.iter().enumerate() {
                let (row, k) = (place / width, place % width);
                let written = || columns[k][row] * factors[k];
                let is_written = row < count && k < LINE;
                let wanted = if is_written { written() } else { 0.0 };
                assert_eq!(*value, wanted, "row {row} of {count}, of {width} numbers");
            }
        }
    }

    #[test]
    #[should_panic]
    fn rows_that_end_too_early_are_not_read() {
        let mut columns = [[0.0; N]; SIDE];
        to_columns(&numbers(3 * 5 + 3), 5, 4, columns.each_mut());
    }

    #[test]
    #[should_panic]
    fn rows_that_end_too_early_are_not_written() {
        let all = numbers(N * LINE);
        let columns: [&[f64; N]; LINE] = std::array::from_fn(|k| &all.as_chunks().0[k]);
        to_rows(columns, &[1.0; LINE], &mut numbers(3 * 9 + 7), 9, 4);
    }
}
