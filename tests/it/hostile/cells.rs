//! Foot cells on which nothing stands have no CoP, whatever their noise says.

use std::fmt::Write as _;

use sesc_test_support::command::Folder;

/// Corners of a sole, m.
const CELLS: [[f64; 2]; 4] = [[0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [-0.1, 0.05]];

/// A log of four cells that carry `load(row)` N together, from the CoP of a simulated one.
fn log(folder: &Folder, name: &str, load: impl Fn(usize) -> f64) {
    folder.stdout("simulate two_link.urdf --support foot --poses 60 --noise 0.0005 --out cop.csv");
    let text = folder.read("cop.csv");
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|own| *own == name).unwrap();
    let places = ["ankle", "knee", "cop_x", "cop_y"].map(place);
    let mut out = "ankle,knee,fsr_1,fsr_2,fsr_3,fsr_4\n".to_string();
    for (k, line) in text.lines().skip(1).enumerate() {
        let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap_or(0.0)).collect();
        let [ankle, knee, x, y] = places.map(|at| cells[at]);
        let _ = write!(out, "{ankle},{knee}");
        for [px, py] in CELLS {
            // Four corners share a load so that their mean place is the CoP.
            let share = (1.0 + x / px + y / py) / 4.0;
            let _ = write!(out, ",{:e}", load(k) * share);
        }
        out += "\n";
    }
    let sidecar = format!("support = 'foot'\ncells = {CELLS:?}\n");
    folder.write(&format!("{name}.toml"), sidecar);
    folder.write(name, out);
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
    let said = found.to_string();
    assert!(said.contains("contact_lost"), "{said}");
    assert!(said.contains("In 36 rows (60 %"), "{said}");
    assert_eq!([&whole["postures"], &found["postures"]], [60, 24]);
    // In every row: nothing stands there.
    for load in [1e-300, 0.9, -30.0] {
        log(&folder, "empty.csv", |_| load);
        let fit = "fit two_link.urdf --data empty.csv --out m.toml";
        folder.refuses(fit, &["empty.csv:2", "nothing stands"]);
    }
}
