//! The console's account of a corrected URDF.

use std::fmt::Write as _;

use crate::report::table::{Table, mm};
use sesc_identify::fit::corrected::Corrected;

/// Links that changed, by how much.
pub fn corrections(corrected: &Corrected) -> String {
    let mut table = Table::new(&[
        "corrected link",
        "CAD, kg",
        "mass, kg",
        "change, %",
        "CoM moved, mm",
    ]);
    for change in &corrected.links {
        let [old, new] = change.mass;
        let relative = match old > 0.0 {
            true => format!("{:+.2}", 100.0 * (new / old - 1.0)),
            false => "new".to_string(),
        };
        table.row(&[
            change.link.clone(),
            format!("{old:.4}"),
            format!("{new:.4}"),
            relative,
            mm(change.shift()),
        ]);
    }
    let mut out = format!("\n{table}");
    let _ = writeln!(
        out,
        "\nThe URDF weighs {:.4} kg; inertia is scaled with the mass of its link: a robot at rest \
         tells nothing of it.",
        corrected.total_mass
    );
    for bound in &corrected.active_bounds {
        let _ = writeln!(out, "held by a bound  {bound}");
    }
    out
}
