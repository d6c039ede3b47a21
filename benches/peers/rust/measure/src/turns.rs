//! Contestants in turns: what disturbs one disturbs its neighbours alike.
//!
//! ```text
//! ratio = median over rounds of  time(peer, round) / time(ours, round)
//! ```

use std::time::{Duration, Instant};

/// A contestant: its name, and one pass over all postures.
pub struct Entry<'a> {
    pub name: String,
    /// Does the work and says how long it took, s.
    pub pass: Box<dyn FnMut() -> f64 + 'a>,
}

impl<'a> Entry<'a> {
    /// Work that this program times.
    pub fn new(name: &str, mut work: impl FnMut() + 'a) -> Entry<'a> {
        Entry::timed(name, move || {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
    }

    /// Work that times itself.
    pub fn timed(name: &str, pass: impl FnMut() -> f64 + 'a) -> Entry<'a> {
        Entry {
            name: name.to_string(),
            pass: Box::new(pass),
        }
    }
}

/// What was found about a contestant.
#[derive(Debug, Clone)]
pub struct Found {
    pub name: String,
    /// Median time of a pass, s.
    pub time: f64,
    /// Quartiles of its time over that of the first contestant of the same round.
    pub ratio: [f64; 3],
}

/// Run `rounds` rounds, each contestant about `slot` long in each, in an order that
/// turns from round to round; a slot of zero is a single pass. The first contestant is the one to compare with.
pub fn compare(mut entries: Vec<Entry>, rounds: usize, slot: Duration) -> Vec<Found> {
    let slot = slot.as_secs_f64();
    let passes: Vec<usize> = entries
        .iter_mut()
        .map(|entry| {
            if slot == 0.0 {
                return 1;
            }
            (entry.pass)();
            let once = (entry.pass)().max(1e-9);
            ((slot / once).ceil() as usize).clamp(1, 1_000_000)
        })
        .collect();
    let count = entries.len();
    let mut times = vec![Vec::with_capacity(rounds); count];
    for round in 0..rounds {
        for turn in 0..count {
            let k = (round + turn) % count;
            // Warm again: the others have used the caches.
            if passes[k] > 1 {
                (entries[k].pass)();
            }
            let total: f64 = (0..passes[k]).map(|_| (entries[k].pass)()).sum();
            times[k].push(total / passes[k] as f64);
        }
    }
    let found = |k: usize| {
        let ratios = times[k]
            .iter()
            .zip(&times[0])
            .map(|(peer, ours)| peer / ours);
        let ratios: Vec<f64> = ratios.collect();
        Found {
            name: entries[k].name.clone(),
            time: quantile(&times[k], 0.5),
            ratio: [0.25, 0.5, 0.75].map(|at| quantile(&ratios, at)),
        }
    };
    (0..count).map(found).collect()
}

fn quantile(values: &[f64], at: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = at * (sorted.len() - 1) as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    sorted[low] + (sorted[high] - sorted[low]) * (place - place.floor())
}
