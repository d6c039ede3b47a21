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
    let supports = found.supports.join(" and ");
    let mut out = format!(
        "{} on {supports}: {} postures, {} readings\n\n",
        found.robot, found.postures, found.readings
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
        let correlation = minus(&format!("{:+.3}", pair.correlation));
        let (a, b) = (&pair.a, &pair.b);
        let _ = writeln!(
            out,
            "known together   {a} and {b} (correlation {correlation})"
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
    let all = found.unobservable.iter();
    let named = all.filter(|unseen| !structural(&unseen.name));
    let named: Vec<String> = named.map(|unseen| unseen.sentence.clone()).collect();
    let moved = found.unobservable.len() - named.len();
    let moved = (moved > 0).then(|| {
        format!(
            "along {moved} joints mass moves to the parent without a trace (all are named in JSON \
             and on the page)"
        )
    });
    let all = gathered(&named, long).into_iter().chain(moved);
    lines(all.map(|sentence| ("cannot be seen", sentence)))
}

/// All parameters, or those that are furthest from CAD, in their deviations.
fn parameters(found: &Identification, long: bool) -> String {
    let mut parameters: Vec<&ParameterFound> = found.parameters.iter().collect();
    let all = long || parameters.len() <= LISTED;
    if !all {
        let moved = |own| moved(own).map_or(0.0, f64::abs);
        parameters.sort_by(|a, b| moved(b).total_cmp(&moved(a)));
    }
    let titles = [
        "parameter",
        "CAD, mm",
        "identified, mm",
        "± std, mm",
        "told by",
    ];
    let rows = parameters.into_iter().map(|own| {
        let std = own.std.map_or("not seen".to_string(), mm);
        let source = own.source.to_string();
        [own.name.clone(), mm(own.cad), mm(own.value), std, source]
    });
    let table = Table::of(&titles, rows);
    let said = match all {
        true => "",
        false => "The parameters that moved most, in their deviations:\n",
    };
    format!("{said}{}", table.listed(long))
}

/// What to read first, and the rest.
fn facts(found: &Identification) -> (Vec<Fact>, Vec<Fact>) {
    let rank = format!(
        "{} of {} base parameters, condition number {:.0}",
        found.rank, found.base_params, found.condition_number
    );
    let noise = match found.noise_axes {
        [x, y] if (x / y).ln().abs() > 0.05 => format!("{} mm in x, {} mm in y", mm(x), mm(y)),
        _ => format!("{} mm per axis", mm(found.noise_floor)),
    };
    // How well it is known, where that is little.
    let known = found.noise_df.filter(|df| *df < FEW);
    let known = known.map(|df| format!(" with {df:.0} degrees of freedom"));
    let source = found.noise_source.phrase().to_string() + &known.unwrap_or_default();
    let mut facts = vec![
        ("rank", rank),
        ("prior", found.prior.clone()),
        ("noise", format!("{noise}, {source}")),
    ];
    facts.extend(about_data(
        found.samples.sentence(),
        &found.motion,
        found.again.as_ref(),
        found.closure.as_ref(),
        found.visits.as_ref(),
    ));
    let lack_of_fit = match found.lack_of_fit {
        Some(test) => format!(
            "{:.2} times the noise's mean square ({}): {}",
            test.ratio,
            chance(test.p_value),
            misfit(found, test.p_value)
        ),
        None => "not known: the noise is taken from what the fit leaves; repeated readings tell it"
            .to_string(),
    };
    let mut first = vec![("lack of fit", lack_of_fit)];
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

/// The console's account of a corrected URDF: links that changed, by how much.
pub fn corrections(corrected: &Corrected, long: bool) -> String {
    let titles = [
        "corrected link",
        "CAD, kg",
        "mass, kg",
        "change, %",
        "CoM moved, mm",
    ];
    let rows = corrected.links.iter().map(|change| {
        let [old, new] = change.mass;
        let relative = match old > 0.0 {
            true => format!("{:+.2}", 100.0 * (new / old - 1.0)),
            false => "new".to_string(),
        };
        let ([old, new], moved) = (
            [old, new].map(|x| format!("{x:.4}")),
            table::mm(change.shift()),
        );
        [change.link.clone(), old, new, relative, moved]
    });
    let bounds = corrected.active_bounds.iter();
    let bounds = bounds.map(|bound| format!("held by a bound  {bound}\n"));
    format!(
        "\n{}\nThe URDF weighs {:.4} kg; inertia is scaled with the mass of its link: a robot at \
         rest tells nothing of it.\n{}",
        Table::of(&titles, rows).listed(long),
        corrected.total_mass,
        bounds.collect::<String>()
    )
}
