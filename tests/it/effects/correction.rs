//! `correct_cop` takes back what the sensor did to a CoP.

use sesc_model::effects::{Catalog, Instance};
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model, ModelFile};

use super::hidden::Hidden;
use super::robots::{Stand, distance, run};
use crate::c99::bounds::larger;

/// Largest error that firmware may rely on, m.
const LARGEST_ERROR: f64 = 1e-9;

/// The model with these effects, cells given.
pub(crate) fn with(stand: &Stand, hidden: &[Hidden]) -> Model {
    stand.model.clone().with_file(file(stand, hidden)).unwrap()
}

pub(crate) fn file(stand: &Stand, hidden: &[Hidden]) -> ModelFile {
    let context = stand.context();
    let mut file = ModelFile::from_values(&stand.model, &stand.model.cad_params(), None, "data");
    file.cells = stand.cells.clone();
    file.effects = hidden.iter().map(|h| h.record(&context)).collect();
    file
}

/// CoPs between the cells, up to a part of the way to their edges.
fn cops(stand: &Stand, part: f64) -> Vec<[f64; 2]> {
    let [a, _, c, _] = stand.cells[..] else {
        panic!("four cells")
    };
    let along = |axis: usize, x: f64| 0.5 * (a[axis] + c[axis]) + 0.5 * x * (a[axis] - c[axis]);
    let steps: Vec<f64> = (-10..=10).map(|k| part * f64::from(k) / 10.0).collect();
    let pairs = steps
        .iter()
        .flat_map(|x| steps.iter().map(move |y| [*x, *y]));
    pairs.map(|[x, y]| [along(0, x), along(1, y)]).collect()
}

fn pair(program: &Program, at: [f64; 2]) -> [f64; 2] {
    let out = run(program, &[&at]);
    [out[0], out[1]]
}

#[test]
fn every_effect_of_the_sensor_is_taken_back() {
    let stand = Stand::new("op2", "r_sole");
    let context = stand.context();
    let mut of_sensor = 0;
    for effect in Catalog::standard().iter() {
        for hidden in Hidden::of(effect, &context, 5) {
            let model = with(&stand, std::slice::from_ref(&hidden));
            let correction = model.program(Function::CorrectCop, Given::Positions);
            let Instance { effect, target } = &hidden.instance;
            let expected = effect.is_sensor_effect(target) && effect.is_static();
            assert_eq!(correction.is_some(), expected, "{hidden:?}");
            let Some(correction) = correction else {
                continue;
            };
            of_sensor += 1;
            let forwards = sesc_model::sensor_reading(&model).unwrap();
            let mut off = 0.0_f64;
            let mut moved = 0.0_f64;
            // A dead cell tells nothing where only two others touch.
            let dead = effect.id().name() == "cell_gain" && hidden.values[0] == 0.0;
            let all = cops(&stand, if dead { 0.48 } else { 0.95 });
            for cop in all {
                let reading = pair(&forwards, cop);
                off = larger(off, distance(pair(&correction, reading), cop));
                moved = moved.max(distance(reading, cop));
            }
            assert!(off <= LARGEST_ERROR, "{hidden:?}: {off:.1e}");
            assert!(moved > 1e-4, "{hidden:?}");
        }
    }
    assert!(of_sensor > 20, "{of_sensor}");
}

#[test]
fn stages_are_taken_back_in_reverse() {
    let stand = Stand::new("op2", "r_sole");
    let model = with(
        &stand,
        &[
            stand.hidden("units", "centimetres", &[]),
            stand.hidden("sensor_offset", "-", &[0.003, -0.002]),
            stand.hidden("sensor_axes", "flip_y", &[]),
            stand.hidden("joint_offset", "l_knee", &[0.05]),
            stand.hidden("cell_exponent", "fsr_2", &[1.2]),
            stand.hidden("cell_gain", "fsr_4", &[0.8]),
            stand.hidden("sensor_gain", "-", &[1.1, 0.95]),
            stand.hidden("sensor_axes", "swapped", &[]),
            stand.hidden("sensor_rotation", "-", &[0.3]),
            stand.hidden("sensor_drift", "-", &[0.01, 0.0]),
        ],
    );
    let forwards = sesc_model::sensor_reading(&model).unwrap();
    let backwards = model
        .program(Function::CorrectCop, Given::Positions)
        .unwrap();
    for cop in cops(&stand, 0.95) {
        let back = pair(&backwards, pair(&forwards, cop));
        assert!(distance(back, cop) <= LARGEST_ERROR, "{cop:?}: {back:?}");
    }
    // By hand, where no cell is wrong: y = 100 A (Rot(ψ) diag(g) p + o).
    let by_hand = with(
        &stand,
        &[
            stand.hidden("sensor_axes", "swapped", &[]),
            stand.hidden("sensor_rotation", "-", &[0.3]),
            stand.hidden("units", "centimetres", &[]),
            stand.hidden("sensor_gain", "-", &[1.1, 0.95]),
            stand.hidden("sensor_offset", "-", &[0.003, -0.002]),
        ],
    );
    let backwards = by_hand
        .program(Function::CorrectCop, Given::Positions)
        .unwrap();
    let ([x, y], (s, c)) = ([0.02, -0.01], 0.3_f64.sin_cos());
    let turned = [c * 1.1 * x - s * 0.95 * y, s * 1.1 * x + c * 0.95 * y];
    let reading = [100.0 * (turned[1] - 0.002), 100.0 * (turned[0] + 0.003)];
    assert!(distance(pair(&backwards, reading), [x, y]) < 1e-15);
    // Without a division, a clamp or a power: firmware in integers can have it.
    assert_eq!(backwards.counts().other, 0);
}
