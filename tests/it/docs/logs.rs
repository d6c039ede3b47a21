//! Logs of all kinds, for tables of keys.

use std::fs;

use sesc_test_support::command::{ROOT, folder};

use super::run;

/// A folder with the OP2 and logs of it: of all that a log can be, so that every key is said.
pub fn folder_of_logs() -> tempfile::TempDir {
    let folder = folder();
    let at = folder.path();
    fs::copy(format!("{ROOT}/robots/op2/op2.urdf"), at.join("op2.urdf")).unwrap();
    let lift = format!("{ROOT}/robots/lift_base/lift_base.urdf");
    fs::copy(lift, at.join("lift.urdf")).unwrap();
    let simulate = "sesc simulate op2.urdf --support r_sole --poses 60";
    run(
        at,
        &format!("{simulate} --noise 0.001 --hide joint_offset:r_knee=3deg --out knee.csv"),
    );
    let knee = fs::read_to_string(at.join("knee.csv")).unwrap();
    let write = |name: &str, text: String, more: &str| {
        fs::write(at.join(name), text).unwrap();
        let sidecar = format!("support = \"r_sole\"\n{more}");
        fs::write(at.join(format!("{name}.toml")), sidecar).unwrap();
    };
    let changed = |column: &str, by: &dyn Fn(usize, f64) -> f64| {
        let mut log = Rows::of(&knee);
        log.change(column, by);
        log.text()
    };
    write("clipped.csv", changed("cop_x", &|_, x| x.min(0.01)), "");
    write("dead.csv", changed("cop_x", &|_, _| 0.01), "");
    let far = |row: usize, x: f64| if row.is_multiple_of(20) { x + 0.012 } else { x };
    write("outliers.csv", changed("cop_x", &far), "");
    let uneven = |row: usize, std: f64| std * (1.0 + row as f64 / 60.0);
    write("uneven.csv", changed("cop_x_std", &uneven), "");

    // Every posture once more after the last, 2 mm to either side.
    let mut again = Rows::of(&knee);
    again.change("cop_x", |row, x| x + [0.002, -0.002][row % 2]);
    let again = again.text();
    let rest = again.split_once('\n').unwrap().1;
    write("again.csv", format!("{knee}{rest}"), "");

    // A row every 5 s, of which nothing says the noise; and stays of 1.2 s.
    let mut timed = Rows::of(&knee);
    timed.drop_std();
    write("timed.csv", timed.clone().with_times(5.0).text(), "");
    timed.rows = timed
        .rows
        .iter()
        .flat_map(|row| vec![row.clone(); 12])
        .collect();
    write("stays.csv", timed.with_times(0.1).text(), "");

    let mut cells = Rows::of(&knee);
    cells.read_by_cells();
    let places = "cells = [[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]\n";
    write("cells.csv", cells.text(), places);

    // Both feet on the floor, and a knee that is off.
    run(
        at,
        "sesc plan op2.urdf --support r_sole --both-feet --poses 30 --candidates 60 --out both.csv; \
         sesc predict op2.urdf --data both.csv --out cop.csv; \
         paste -d, both.csv <(cut -d, -f5,6 cop.csv) > feet.csv; cp both.csv.toml feet.csv.toml",
    );
    let mut feet = Rows::of(&fs::read_to_string(at.join("feet.csv")).unwrap());
    feet.change("l_knee", |_, q| q - 0.026);
    fs::write(at.join("feet.csv"), feet.text()).unwrap();
    folder
}

/// Rows of a log, and the names of its columns.
#[derive(Clone)]
struct Rows {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn of(text: &str) -> Rows {
        let cells = |line: &str| line.split(',').map(str::to_string).collect::<Vec<String>>();
        let mut lines = text.lines();
        Rows {
            names: cells(lines.next().unwrap()),
            rows: lines.map(cells).collect(),
        }
    }

    fn text(&self) -> String {
        let all = [&self.names].into_iter().chain(&self.rows);
        all.map(|row| row.join(",") + "\n").collect()
    }

    fn at(&self, name: &str) -> usize {
        self.names.iter().position(|own| own == name).unwrap()
    }

    fn change(&mut self, name: &str, by: impl Fn(usize, f64) -> f64) {
        let at = self.at(name);
        for (k, row) in self.rows.iter_mut().enumerate() {
            row[at] = by(k, row[at].parse().unwrap()).to_string();
        }
    }

    /// Without what is said of the noise.
    fn drop_std(&mut self) {
        while let Some(at) = self.names.iter().position(|name| name.ends_with("_std")) {
            self.names.remove(at);
            self.rows.iter_mut().for_each(|row| drop(row.remove(at)));
        }
    }

    /// With a time, a row every `step` seconds, in place of numbers of postures.
    fn with_times(mut self, step: f64) -> Rows {
        self.names[0] = "t".to_string();
        for (k, row) in self.rows.iter_mut().enumerate() {
            row[0] = (step * k as f64).to_string();
        }
        self
    }

    /// The CoP as four cells at (±0.5 m, ±0.5 m) read it that bear 30 N, the first with a gain
    /// of 1.3.
    fn read_by_cells(&mut self) {
        self.drop_std();
        let at = self.at("cop_x");
        self.names.truncate(at);
        self.names.extend((1..=4).map(|k| format!("fsr_{k}")));
        for row in &mut self.rows {
            let [x, y] = [0, 1].map(|k| 2.0 * row[at + k].parse::<f64>().unwrap());
            row.truncate(at);
            let signs = [
                (1.3, 1.0, 1.0),
                (1.0, 1.0, -1.0),
                (1.0, -1.0, -1.0),
                (1.0, -1.0, 1.0),
            ];
            let force = |(gain, a, b): (f64, f64, f64)| 7.5 * gain * (1.0 + a * x) * (1.0 + b * y);
            row.extend(signs.map(|of| force(of).to_string()));
        }
    }
}
