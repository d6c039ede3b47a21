//! Planned postures tell more than random ones: fits of robots that weigh what nobody knows.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc::OP2_URDF;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::fit::prior::Prior;
use sesc_identify::lsq::Factor;
use sesc_identify::lsq::solve;
use sesc_model::Function;
use sesc_reference::{Reference, Robot as TrueRobot};

use sesc_test_support::examine::bought::bought;

use super::{NOISE, POSES, op2_plan};

/// Readings of one robot, and what a fit of them knows beforehand.
struct Lab<'a> {
    rows: DMatrix<f64>,
    truth: DVector<f64>,
    cad: DVector<f64>,
    prior: Option<&'a DMatrix<f64>>,
}

impl Lab<'_> {
    /// RMS error of the CoP over postures never fitted, without noise, m.
    fn clean_error(&self, fitted: &[usize], held_out: &[usize], noise: &[f64]) -> f64 {
        let at = |postures: &[usize]| -> Vec<usize> {
            postures.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect()
        };
        let lines = at(fitted);
        let reading = self.truth.select_rows(&lines) + DVector::from_row_slice(noise);
        let mut factor = Factor::new(self.cad.len());
        factor.push(
            &self.rows.select_rows(&lines),
            &reading,
            &vec![1.0; lines.len()],
        );
        let found = solve(&factor, NOISE, &self.cad, self.prior);
        let lines = at(held_out);
        let off = self.rows.select_rows(&lines) * found.params - self.truth.select_rows(&lines);
        (off.norm_squared() / off.len() as f64).sqrt()
    }
}

/// Mean clean held-out errors of planned and of random postures over 20 robots, m.
fn yardstick(prior: &str) -> (f64, f64) {
    let (mut planned, mut random) = (0.0, 0.0);
    let seeds = 20;
    let cad = TrueRobot::from_urdf(OP2_URDF).unwrap();
    for seed in 1..=seeds {
        let (_, model, found) = op2_plan(prior, seed, 1000);
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let reference = Reference::new(&bought(&cad, &mut rng), "r_sole").unwrap();
        let postures: Vec<&[f64]> = found.q.chunks(model.dof()).collect();
        let truth = postures.iter().flat_map(|q| {
            let com = reference.com(q);
            [com.x, com.y]
        });
        let truth = DVector::from_iterator(2 * postures.len(), truth);
        let values = Evaluator::new(&model, Function::RegressorCop).run(&found.q, postures.len());
        let factor = Prior::named(prior, &model)
            .unwrap()
            .covariance_factor(&model);
        let lab = Lab {
            rows: DMatrix::from_row_slice(2 * postures.len(), model.base.params.len(), &values),
            truth,
            cad: DVector::from_vec(model.cad_params()),
            prior: factor.as_ref(),
        };
        let drawn = index::sample(&mut rng, postures.len(), POSES).into_vec();
        let held_out: Vec<usize> = (0..postures.len())
            .filter(|k| !drawn.contains(k) && !found.chosen.contains(k))
            .collect();
        let noise: Vec<f64> = (0..2 * POSES)
            .map(|_| {
                let x: f64 = StandardNormal.sample(&mut rng);
                NOISE * x
            })
            .collect();
        planned += lab.clean_error(&found.chosen, &held_out, &noise) / seeds as f64;
        random += lab.clean_error(&drawn, &held_out, &noise) / seeds as f64;
    }
    eprintln!(
        "{prior}: planned {:.4} mm, random {:.4} mm, {:.1} % less",
        1e3 * planned,
        1e3 * random,
        100.0 * (1.0 - planned / random)
    );
    (planned, random)
}

#[test]
fn planned_postures_tell_a_third_more_than_random_ones() {
    let (planned, random) = yardstick("free");
    assert!(planned < 0.7 * random, "{planned} {random}");
}

#[test]
fn with_cad_as_prior_they_still_tell_more() {
    let (planned, random) = yardstick("cad");
    // CAD already tells what few postures would: about a tenth is left to gain.
    assert!(planned < 0.95 * random, "{planned} {random}");
}
