//! An order of postures that spares motion.
//!
//! ```text
//! d(a, b) = max_j |a_j − b_j|        the time between two postures at equal joint speeds
//! ```
//!
//! From the posture closest to zero always on to the nearest one left, then
//! 2-opt: reverse every stretch whose reversal shortens the way, until none
//! does. Prismatic joints count a metre as a radian. Only postures are planned;
//! the way between two of them is not checked for balance or collisions.

/// Rounds of 2-opt; far more than it ever takes.
const ROUNDS: usize = 100;

/// Indices of postures `q[k * dof + joint]` in a short order.
pub fn shorten(q: &[f64], dof: usize) -> Vec<usize> {
    let n = q.len() / dof.max(1);
    let posture = |k: usize| &q[k * dof..(k + 1) * dof];
    let from_rest = |k: usize| distance(posture(k), &vec![0.0; dof]);
    let Some(first) = (0..n).min_by(|&a, &b| from_rest(a).total_cmp(&from_rest(b))) else {
        return Vec::new();
    };
    let pairs = (0..n * n).map(|at| (posture(at / n), posture(at % n)));
    let table: Vec<f64> = pairs.map(|(a, b)| distance(a, b)).collect();
    let between = |a: usize, b: usize| table[a * n + b];
    let mut order = vec![first];
    let mut left: Vec<usize> = (0..n).filter(|&k| k != first).collect();
    while let Some(at) = (0..left.len()).min_by(|&a, &b| {
        let here = order[order.len() - 1];
        between(here, left[a]).total_cmp(&between(here, left[b]))
    }) {
        order.push(left.remove(at));
    }
    for _ in 0..ROUNDS {
        if !untangle(&mut order, &between) {
            break;
        }
    }
    order
}

/// One round of 2-opt with the first posture kept; whether the way became shorter.
fn untangle(order: &mut [usize], between: &impl Fn(usize, usize) -> f64) -> bool {
    let n = order.len();
    let mut shorter = false;
    for i in 0..n.saturating_sub(2) {
        for j in i + 2..n {
            // Reverse i+1 ..= j; the end of the way is open.
            let (a, b, c) = (order[i], order[i + 1], order[j]);
            let after = order.get(j + 1).copied();
            let end = |from: usize| after.map_or(0.0, |to| between(from, to));
            let gain = between(a, b) + end(c) - between(a, c) - end(b);
            if gain > 1e-12 {
                order[i + 1..=j].reverse();
                shorter = true;
            }
        }
    }
    shorter
}

/// Length of the way through postures in this order.
pub fn length(q: &[f64], dof: usize, order: &[usize]) -> f64 {
    let posture = |k: usize| &q[k * dof..(k + 1) * dof];
    let steps = order.windows(2);
    let length = |pair: &[usize]| distance(posture(pair[0]), posture(pair[1]));
    steps.map(length).sum()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let gaps = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_are_walked_along_it() {
        let q = [0.9, -0.1, 0.4, 0.2, 0.7, 0.05];
        let order = shorten(&q, 1);
        assert_eq!(order[0], 5);
        assert!((length(&q, 1, &order) - (0.15 + 1.0)).abs() < 1e-12);
    }

    #[test]
    fn every_posture_is_visited_once_on_a_shorter_way() {
        let n = 60;
        let q: Vec<f64> = (0..3 * n)
            .map(|k| ((k * k * 7 + k) as f64 * 0.37).sin())
            .collect();
        let order = shorten(&q, 3);
        let plain: Vec<usize> = (0..n).collect();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, plain);
        assert!(length(&q, 3, &order) < 0.6 * length(&q, 3, &plain));
        assert_eq!(shorten(&[], 3), Vec::<usize>::new());
        assert_eq!(shorten(&[0.1, 0.2], 2), [0]);
    }
}
