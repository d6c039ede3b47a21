//! The console's account of a fit.

use std::fmt::Write as _;

use crate::report::figures::fit::moved;
use crate::report::next_steps::{self, Worded};
use crate::report::table::{
    self, LISTED, Table, chance, gathered, hundredths as mm, lines, listed, wrapped,
};
use crate::report::{Fact, about_data};
use sesc_identify::fit::corrected::Corrected;
use sesc_identify::fit::{Identification, ParameterFound};
use sesc_model::text::{minus, visible};

/// A misfit that noise makes less often is one.
const MISSES: f64 = 1e-3;
/// Fewer degrees of freedom than this are mentioned.
const FEW: f64 = 50.0;

/// Parameters with uncertainty, observability and held-out error; lists in full with `long`.
pub fn text(found: &Identification, next: &[Worded], long: bool) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{} on {}: {} postures, {} readings\n",
        found.robot,
        found.supports.join(" and "),
        found.postures,
        found.readings
    );
    for finding in &found.health {
        let _ = writeln!(out, "{}\n", wrapped(&finding.sentence, ""));
    }
    if !found.is_usable() {
        return out + &next_steps::text(next);
    }
    let (first, facts) = facts(found);
    let _ = write!(out, "{}{}", lines(first), unseen(found, long));
    let _ = writeln!(out, "\n{}\n{}", parameters(found, long), lines(facts));
    let bounds = found.active_bounds.iter().flatten();
    let bounds: Vec<String> = bounds
        .map(|bound| format!("held by a bound  {bound}"))
        .collect();
    out += &listed(&bounds, long);
    for pair in found.correlations.iter().take(5) {
        let _ = writeln!(
            out,
            "known together   {} and {} (correlation {})",
            pair.a,
            pair.b,
            minus(&format!("{:+.3}", pair.correlation))
        );
    }
    let less = found.down_weighted.iter().map(|posture| {
        format!(
            "trusted less     pose {} ({}:{}): {} mm off, weight {:.2}",
            posture.pose,
            visible(&posture.file),
            posture.line,
            mm(posture.residual),
            posture.weight
        )
    });
    out += &listed(&less.collect::<Vec<String>>(), long);
    // Those about the logs stand on stderr.
    for warning in &found.warnings[found.warnings_of_logs..] {
        let _ = writeln!(out, "warning          {warning}");
    }
    out + &next_steps::text(next)
}

/// What is said of a misfit that noise alone makes with the probability `p`.
pub(super) fn misfit(found: &Identification, p: f64) -> &'static str {
    match p {
        p if p < MISSES => "the model misses something",
        p if p < 0.05 => "perhaps more than noise",
        _ if found.misses_something() => "noise explains it, but not what is warned of",
        _ => "noise explains it",
    }
}

/// What cannot be seen; what no such data ever tell only as a number.
fn unseen(found: &Identification, long: bool) -> String {
    let structural = |name: &str| name.starts_with("axis of ") || name.starts_with("r of ");
    let (moved, named): (Vec<_>, Vec<_>) = found
        .unobservable
        .iter()
        .partition(|unseen| structural(&unseen.name));
    let named = named.iter().map(|unseen| unseen.sentence.clone());
    let named = gathered(&named.collect::<Vec<String>>(), long);
    let moved = (!moved.is_empty()).then(|| {
        format!(
            "along {} joints mass moves to the parent without a trace (all are named in JSON and \
             on the page)",
            moved.len()
        )
    });
    lines(
        named
            .into_iter()
            .chain(moved)
            .map(|sentence| ("cannot be seen", sentence)),
    )
}

/// All parameters, or those that are furthest from CAD, in their deviations.
fn parameters(found: &Identification, long: bool) -> String {
    let mut table = Table::new(&[
        "parameter",
        "CAD, mm",
        "identified, mm",
        "± std, mm",
        "told by",
    ]);
    let mut parameters: Vec<&ParameterFound> = found.parameters.iter().collect();
    let all = long || parameters.len() <= LISTED;
    if !all {
        let moved = |own| moved(own).map_or(0.0, f64::abs);
        parameters.sort_by(|a, b| moved(b).total_cmp(&moved(a)));
    }
    for parameter in parameters {
        table.row(&[
            parameter.name.clone(),
            mm(parameter.cad),
            mm(parameter.value),
            parameter.std.map_or("not seen".to_string(), mm),
            parameter.source.to_string(),
        ]);
    }
    let said = match all {
        true => "",
        false => "The parameters that moved most, in their deviations:\n",
    };
    format!("{said}{}", table.listed(long))
}

/// What to read first, and the rest.
fn facts(found: &Identification) -> (Vec<Fact>, Vec<Fact>) {
    let condition = found.condition_number;
    let rank = format!("{} of {} base parameters", found.rank, found.base_params);
    let noise = match found.noise_axes {
        [x, y] if (x / y).ln().abs() > 0.05 => format!("{} mm in x, {} mm in y", mm(x), mm(y)),
        _ => format!("{} mm per axis", mm(found.noise_floor)),
    };
    let mut facts = vec![
        ("rank", format!("{rank}, condition number {condition:.0}")),
        ("prior", found.prior.clone()),
        ("noise", format!("{noise}, {}", source(found))),
    ];
    facts.extend(about_data(
        found.samples.sentence(),
        &found.motion,
        found.again.as_ref(),
        found.closure.as_ref(),
        found.visits.as_ref(),
    ));
    let mut first = Vec::new();
    if let Some(test) = found.lack_of_fit {
        let (ratio, chance) = (test.ratio, chance(test.p_value));
        let misfit = misfit(found, test.p_value);
        let text = format!("{ratio:.2} times the noise's mean square ({chance}): {misfit}");
        first.push(("lack of fit", text));
    } else {
        let text =
            "not known: the noise is taken from what the fit leaves; repeated readings tell it";
        first.push(("lack of fit", text.to_string()));
    }
    if found.folds > 0 {
        let text = format!(
            "{} ± {} mm RMS per axis, on readings of postures the fit did not see ({} folds); CAD \
             alone {} mm",
            mm(found.held_out_rmse),
            mm(found.held_out_error),
            found.folds,
            mm(found.cad_rmse)
        );
        first.push(("held-out error", text));
    }
    let expected = format!(
        "{} mm where data were taken, {} mm over {} (of the CoP itself, noise apart)",
        mm(found.expected_error_data),
        mm(found.expected_error_range),
        found.range
    );
    facts.push(("expected error", expected));
    let height = &found.com_height_constant;
    let (name, value, source) = (&height.name, mm(height.value), height.source);
    let deviation = height.std.map(|std| format!("± {} mm", mm(std)));
    let deviation = deviation.unwrap_or("from CAD".to_string());
    let text = format!("its constant {name} is {value} mm {deviation}, told by {source}");
    facts.push(("CoM height", text));
    (first, facts)
}

/// Where the noise comes from, and how well it is known where that is little.
fn source(found: &Identification) -> String {
    let from = found.noise_source.phrase();
    match found.noise_df.filter(|df| *df < FEW) {
        Some(df) => format!("{from} with {df:.0} degrees of freedom"),
        None => from.to_string(),
    }
}

/// The console's account of a corrected URDF: links that changed, by how much.
pub fn corrections(corrected: &Corrected, long: bool) -> String {
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
            table::mm(change.shift()),
        ]);
    }
    let mut out = format!("\n{}", table.listed(long));
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
