//! Foot cells on which nothing stands have no CoP, whatever their noise says.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use sesc_test_support::command::{ROOT, folder, refused, sesc, stdout, write};

/// Corners of a sole, m.
const CELLS: [[f64; 2]; 4] = [[0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [-0.1, 0.05]];

/// A log of four cells that carry `load(row)` N together, from the CoP of a simulated one.
fn log(at: &Path, name: &str, load: impl Fn(usize) -> f64) -> String {
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    let cop = at.join("cop.csv").display().to_string();
    let robot = ["simulate", &urdf, "--support", "foot"];
    let what = ["--poses", "60", "--noise", "0.0005", "--out", &cop];
    stdout(&sesc(&[&robot[..], &what].concat()));
    let text = fs::read_to_string(cop).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|own| *own == name).unwrap();
    let joints = ["ankle", "knee"].map(place);
    let [x, y] = ["cop_x", "cop_y"].map(place);
    let mut out = "ankle,knee,fsr_1,fsr_2,fsr_3,fsr_4\n".to_string();
    for (k, line) in text.lines().skip(1).enumerate() {
        let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap_or(0.0)).collect();
        let _ = write!(out, "{},{}", cells[joints[0]], cells[joints[1]]);
        for [px, py] in CELLS {
            // Four corners share a load so that their mean place is the CoP.
            let share = (1.0 + cells[x] / px + cells[y] / py) / 4.0;
            let _ = write!(out, ",{:e}", load(k) * share);
        }
        out += "\n";
    }
    let sidecar = format!("support = 'foot'\ncells = {CELLS:?}\n");
    write(at, &format!("{name}.toml"), sidecar);
    write(at, name, out)
}

fn fit(log: &str, out: &str) -> std::process::Output {
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    sesc(&["fit", &urdf, "--data", log, "--out", out, "--json"])
}

#[test]
fn less_than_a_newton_is_no_contact() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let loaded = log(folder.path(), "loaded.csv", |_| 30.0);
    let whole = stdout(&fit(&loaded, &at("loaded.toml")));
    assert!(!whole.contains("contact_lost"), "{whole}");
    // In most rows noise of next to nothing, of either sign.
    let lifted = log(folder.path(), "lifted.csv", |k| match k % 5 {
        0 | 1 => 30.0,
        2 => 0.9,
        3 => -0.4,
        _ => 1e-300,
    });
    let found = stdout(&fit(&lifted, &at("lifted.toml")));
    assert!(found.contains("contact_lost"), "{found}");
    assert!(found.contains("In 36 rows (60 %"), "{found}");
    let postures = |json: &str| {
        let json: serde_json::Value = serde_json::from_str(json).unwrap();
        json["postures"].as_u64().unwrap()
    };
    assert_eq!((postures(&whole), postures(&found)), (60, 24));
    // In every row: nothing stands there.
    for load in [1e-300, 0.9, -30.0] {
        let empty = log(folder.path(), "empty.csv", |_| load);
        refused(
            &fit(&empty, &at("m.toml")),
            &["empty.csv:2", "nothing stands"],
        );
    }
}
