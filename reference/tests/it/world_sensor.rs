//! Cells under a sole and what is written down.

use crate::common::{bushy_on_sole, kind, near, postures, stick};
use sesc_reference::{ErrorKind, Track, World};

/// Half the length and half the width of the rectangle of cells, m.
const X: f64 = 0.04;
const Y: f64 = 0.025;
const CELLS: [[f64; 2]; 4] = [[X, Y], [X, -Y], [-X, -Y], [-X, Y]];

/// A stick that stands on cells; its lean puts the CoP at `0.5 sin q`, 0.
fn standing() -> World {
    stick().cells(&CELLS).unwrap()
}

fn loads(world: &World, q: f64) -> Vec<f64> {
    let track = Track::still(vec![vec![q]]);
    world.readings(&track).remove(0).cells_n
}

#[test]
fn true_cells_carry_the_weight_and_keep_the_cop() {
    let world = standing();
    let weight = world.nominal_weight();
    for q in [-0.2, -0.05, 0.0, 0.03, 0.1] {
        let x = 0.5 * f64::sin(q);
        near(world.cop(&[q]), [x, 0.0], 1e-14);
        let loads = loads(&world, q);
        assert!((loads.iter().sum::<f64>() - weight).abs() < 1e-12);
        // A plate: the front pair shares what the lever gives it.
        assert!((loads[0] - weight / 4.0 * (1.0 + x / X)).abs() < 1e-12);
        assert!((loads[1] - loads[0]).abs() < 1e-12);
        assert!((loads[2] - weight / 4.0 * (1.0 - x / X)).abs() < 1e-12);
    }
    // Outside the cells the front must pull.
    assert!(loads(&world, -0.2)[0] < 0.0);
}

#[test]
fn a_cell_that_would_pull_lifts_off() {
    // Over the front left: three cells carry it, the fourth hangs.
    let world = standing().payload("foot", 0.0, [0.0; 3]).unwrap();
    let (x, y) = (0.6 * X, 0.7 * Y);
    let world = world.link_mass("stick", 1.0, [x, y, 0.0]).unwrap();
    near(world.cop(&[0.0]), [x, y], 1e-14);
    let weight = world.nominal_weight();
    // Rear right free; the others by their moments alone.
    let expected = [0.65, 0.15, 0.0, 0.2].map(|share| share * weight);
    near(loads(&world, 0.0).try_into().unwrap(), expected, 1e-12);
}

#[test]
fn each_cell_has_its_own_faults() {
    // Upright every cell carries a quarter: CoP = X (f_front - f_rear) / Σ f.
    let world = standing();
    let quarter = world.nominal_weight() / 4.0;
    let moved = |felt: f64| {
        let (sum, excess) = (3.0 * quarter + felt, felt - quarter);
        [X * excess / sum, Y * excess / sum]
    };
    let gain = world.clone().cell_gain(1, 1.2).unwrap();
    assert!((loads(&gain, 0.0)[0] - 1.2 * quarter).abs() < 1e-12);
    for (wrong, felt) in [
        (gain, 1.2 * quarter),
        (world.clone().cell_offset(1, 0.7).unwrap(), quarter + 0.7),
        (
            world.clone().cell_exponent(1, 0.9).unwrap(),
            4.0 * quarter * 0.25_f64.powf(0.9),
        ),
        (
            world.clone().cell_saturation(1, 3.0).unwrap(),
            3.0 * (quarter / 3.0).tanh(),
        ),
    ] {
        near(wrong.cop(&[0.0]), moved(felt), 1e-14);
    }
    // The third cell is the rear right one.
    let third = world.cell_gain(3, 1.2).unwrap();
    near(third.cop(&[0.0]), moved(1.2 * quarter).map(|x| -x), 1e-14);
}

#[test]
fn a_payload_shows_in_the_sum_of_cells() {
    let world = standing().payload("stick", 0.5, [0.0; 3]).unwrap();
    let sum: f64 = loads(&world, 0.1).iter().sum();
    assert!((sum - world.nominal_weight() * 2.5 / 2.0).abs() < 1e-12);
    let lifted = standing().external_force("stick", [0.0, 0.0, 4.0]).unwrap();
    let sum: f64 = loads(&lifted, 0.1).iter().sum();
    assert!((sum - (lifted.nominal_weight() - 4.0)).abs() < 1e-12);
}

#[test]
fn the_sensor_has_gain_then_turn_then_shift_then_axes_and_units() {
    let (_, reference, world) = bushy_on_sole();
    let bent = world
        .clone()
        .sensor_offset([0.01, 0.02])
        .sensor_rotation(std::f64::consts::FRAC_PI_2)
        .sensor_gain([2.0, 0.5]);
    let written = world.clone().sensor_offset([0.001, 0.0]);
    let written = written.sensor_axes(true, [1.0, -1.0]).sensor_unit(1000.0);
    for q in postures(&reference, 20) {
        let [x, y] = world.cop(&q);
        near(bent.cop(&q), [-0.5 * y + 0.01, 2.0 * x + 0.02], 1e-14);
        let metres = written.cop(&q).map(|c| c / 1000.0);
        near(metres, [y, -x - 0.001], 1e-14);
    }
}

#[test]
fn cells_report_what_is_wrong_behind_them() {
    let world = standing().sensor_offset([0.01, 0.0]);
    let loads = loads(&world, 0.0);
    let quarter = world.nominal_weight() / 4.0;
    assert!((loads[0] - quarter * (1.0 + 0.01 / X)).abs() < 1e-12);
    assert!((loads[2] - quarter * (1.0 - 0.01 / X)).abs() < 1e-12);
}

#[test]
fn cells_that_cannot_carry_are_refused() {
    let world = stick();
    let line = [[0.0, 0.0], [0.01, 0.01], [0.02, 0.02]];
    assert_eq!(kind(world.clone().cells(&line)), ErrorKind::Cells);
    assert_eq!(kind(world.clone().cells(&[])), ErrorKind::Cells);
    for k in [0, 5] {
        let error = standing().cell_gain(k, 1.1).unwrap_err();
        assert!(error.to_string().contains(&format!("fsr_{k}")), "{error}");
    }
    assert!(world.cell_offset(1, 0.1).is_err(), "no cells at all");
}
