//! The console's account of a plan.

use std::fmt::Write as _;

use crate::report::next_steps::{self, Worded};
use crate::report::table::mm;
use sesc_identify::plan::Plan;

/// What was drawn, what was chosen, and what it will be good for.
pub fn text(plan: &Plan, next: &[Worded]) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{} on {}: {} postures of {} candidates\n",
        plan.robot, plan.support, plan.poses, plan.candidates
    );
    let mut line = |name: &str, text: String| {
        let _ = writeln!(out, "{name:<17}{text}");
    };
    line("drawn", plan.drawn());
    line(
        "CoP",
        format!(
            "{}, with {} standard deviations to spare ({} mm each on average)",
            plan.cop_region,
            plan.sigmas,
            mm(plan.draws.cop_std)
        ),
    );
    if let Some(feet) = &plan.both_feet {
        line("soles", feet.sentence());
    }
    line("revisits", plan.revisits.sentence.clone());
    line("ground", plan.clearance.clone());
    line("collisions", plan.collision.clone());
    if !plan.collision_exempt.is_empty() {
        let pairs: Vec<String> = plan
            .collision_exempt
            .iter()
            .take(8)
            .map(|p| p.join("–"))
            .collect();
        let more = plan.collision_exempt.len() - pairs.len();
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        line(
            "",
            format!("touching at rest, not watched: {}{more}", pairs.join(", ")),
        );
    }
    line("prior", plan.prior.clone());
    if let (Some(error), Some(random)) = (plan.expected_error, plan.expected_error_random) {
        line(
            "expected error",
            format!(
                "{} mm over all candidates, from readings to {} mm",
                mm(error),
                mm(plan.noise)
            ),
        );
        line(
            "",
            format!(
                "{} mm with postures chosen at random: {}",
                mm(random),
                match 100.0 * (1.0 - error / random) {
                    less if less >= 0.5 => format!("{less:.0} % less"),
                    _ => "here any postures do".to_string(),
                }
            ),
        );
    }
    line(
        "conditioning",
        format!(
            "{} directions told, condition number {:.0}",
            plan.rank, plan.condition_number
        ),
    );
    let gain = plan.log_det[plan.log_det.len() - 1] - plan.log_det[0];
    line(
        "choice",
        format!(
            "greedy, then {} exchanges: log det + {gain:.2}",
            plan.exchanges
        ),
    );
    line(
        "motion",
        format!(
            "{:.0}° in this order, {:.0}° as chosen (largest joint, summed)",
            plan.motion.ordered.to_degrees(),
            plan.motion.as_chosen.to_degrees()
        ),
    );
    for note in &plan.notes {
        line("note", note.clone());
    }
    line(
        "note",
        "only the postures are checked, not the way from one to the next".to_string(),
    );
    out + &next_steps::text(next)
}
