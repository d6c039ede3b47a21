//! Foot cells on which nothing stands have no CoP, whatever their noise says.

use sesc_test_support::command::{Folder, says};

/// Corners of a sole, m.
const CELLS: [[f64; 2]; 4] = [[0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [-0.1, 0.05]];

/// A log of four cells that carry `load(row)` N together, from the CoP of a simulated one.
fn log(folder: &Folder, name: &str, load: impl Fn(usize) -> f64) {
    folder.stdout("simulate two_link.urdf --support foot --poses 60 --noise 0.0005 --out cop.csv");
    let mut log = folder.sheet("cop.csv");
    let cop = log.cop();
    log.keep(|name| ["ankle", "knee"].contains(&name));
    for (cell, [px, py]) in CELLS.into_iter().enumerate() {
        // Four corners share a load so that their mean place is the CoP.
        let share = |[x, y]: [f64; 2]| (1.0 + x / px + y / py) / 4.0;
        let cell = format!("fsr_{}", cell + 1);
        log.add(&cell, |k| format!("{:e}", load(k) * share(cop[k])));
    }
    let sidecar = format!("support = 'foot'\ncells = {CELLS:?}\n");
    folder.write(&format!("{name}.toml"), sidecar);
    folder.write(name, log.to_string());
}

#[test]
fn less_than_a_newton_is_no_contact() {
    let folder = Folder::with("two_link");
    log(&folder, "loaded.csv", |_| 30.0);
    let whole = folder.json("fit two_link.urdf --data loaded.csv");
    assert!(!whole.to_string().contains("contact_lost"), "{whole}");
    // In most rows noise of next to nothing, of either sign.
    log(&folder, "lifted.csv", |k| match k % 5 {
        0 | 1 => 30.0,
        2 => 0.9,
        3 => -0.4,
        _ => 1e-300,
    });
    let found = folder.json("fit two_link.urdf --data lifted.csv");
    says(found.to_string(), &["contact_lost", "In 36 rows (60 %"]);
    assert_eq!([&whole["postures"], &found["postures"]], [60, 24]);
    // In every row: nothing stands there.
    for load in [1e-300, 0.9, -30.0] {
        log(&folder, "empty.csv", |_| load);
        let fit = "fit two_link.urdf --data empty.csv --out m.toml";
        folder.refuses(fit, &["empty.csv:2", "nothing stands"]);
    }
}
