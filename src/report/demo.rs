//! The page of `sesc demo`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use super::html::render;
use super::next_steps::Worded;
use super::origin::Origin;
use super::robot::Shown;
use super::{CopRow, DemoReport, HiddenAct, diagnose, figures, next_steps};

/// Outline of the OP2's sole around its sole frame: length, width, m.
const OP2_SOLE_M: [f64; 2] = [0.105, 0.066];

/// The page of `sesc demo`; `command` makes it again.
pub fn page(report: &DemoReport, steps: &[Worded], command: &str) -> Result<String, Error> {
    let figure = Value::from_safe_string;
    let hidden = report.hidden.as_ref();
    // The robot of the second act is shown in the first one's postures, too.
    let first = hidden.map_or(0, |hidden| hidden.view.postures.len());
    let context = context! {
        report => Serde(report),
        origin => Origin {
            robot: [&report.robot, &report.hash],
            command,
            ..Origin::default()
        }
        .context(),
        next => next_steps::context(steps),
        robot => hidden.map(|hidden| of_hidden(hidden, held_out(report))),
        sole_mm => OP2_SOLE_M.map(|length| format!("{:.0}", 1e3 * length)).to_vec(),
        all_within => report.functions.iter().all(|row| row.worst_error_m <= row.bound_m),
        worst_error_m => report.functions.iter().map(|row| row.worst_error_m).fold(0.0, f64::max),
        figures => context! {
            errors => figure(figures::demo::errors(report)),
            cop_x => figure(figures::demo::cop_over_postures(&report.cop, 0, first)),
            cop_y => figure(figures::demo::cop_over_postures(&report.cop, 1, first)),
            plane => figure(figures::demo::cop_plane(&report.cop, OP2_SOLE_M, first)),
            lengths_full => figure(figures::demo::lengths_full(&report.lengths)),
            lengths_base => figure(figures::demo::lengths_base(&report.lengths)),
            height_level => figure(figures::demo::height_level(&report.height, report.height_offset_m, first)),
            height_shape => figure(figures::demo::height_shape(&report.height, first)),
            parameters => figure(figures::demo::parameters(report)),
            course => figure(report.hidden.as_ref().map_or_else(String::new, |h| figures::diagnose::course(&h.view.postures))),
            waterfall => figure(report.hidden.as_ref().map_or_else(String::new, |h| figures::diagnose::waterfall(&h.view.stages))),
        },
    };
    render("demo.html", context)
}

/// The robot of the second act, which stands in the postures `apart` where figures ask for it.
fn of_hidden(hidden: &HiddenAct, apart: Vec<Shown>) -> Value {
    let mut card = diagnose::card(&hidden.diagnosis, &hidden.view);
    card.caption = format!("As the last part below finds it. {}", card.caption);
    card.apart = apart;
    card.context()
}

/// The postures of the first act's figures, with what these draw of them.
fn held_out(report: &DemoReport) -> Vec<Shown> {
    let signed = |text: String| text.replace('-', "−");
    let place = |at: [f64; 2]| {
        let [x, y] = at.map(|x| 1e3 * x);
        signed(format!("x {x:.2}, y {y:.2} mm"))
    };
    let shown = |(k, row): (usize, &CopRow)| {
        let mut said = vec![
            format!("true CoP {}", place(row.truth)),
            format!("identified {}", place(row.identified)),
        ];
        said.extend(report.height.get(k).map(|height| {
            let [truth, level, shape] =
                [height.truth, height.identified, height.anchored].map(|z| 1e3 * z);
            signed(format!(
                "height of the CoM {truth:.2} mm, identified {level:.2} mm, with the constant from \
                 CAD {shape:.2} mm"
            ))
        }));
        Shown {
            pose: i64::try_from(row.pose).unwrap_or(i64::MAX),
            q: row.q.clone(),
            measured: Some(row.measured),
            row: Some(format!(
                "row {} of {} that were held out",
                k + 1,
                report.cop.len()
            )),
            said,
            ..Shown::default()
        }
    };
    report.cop.iter().enumerate().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::super::html::{SCRIPT, SCRIPT_HASH};
    use super::super::tests::{report, says, still};
    use super::page as demo;
    use sesc_model::hash::fnv1a;

    #[test]
    fn the_page_says_the_numbers_escapes_names_and_stands_alone() {
        let made = |report| demo(&report, &[], "sesc demo").unwrap();
        let page = made(report());
        let numbers = ["0.72 mm", "3.93 mm", "4.93 mm", "±30°", "500 others"];
        says(&page, &numbers);
        let counts = ["42 <small>of 63</small>", "4.4 × 10⁻¹⁶"];
        says(&page, &counts);
        assert_eq!(page.matches("class=\"ok\">within").count(), 1);
        assert_eq!(page.matches("class=\"bad\">exceeded").count(), 1);
        says(&page, &["functions disagree with the reference"]);
        let mut fine = report();
        fine.functions.truncate(1);
        says(&made(fine), &["functions agree with the reference"]);
        for raw in ["op<2>", "<b>&", "<l_knee>"] {
            assert!(!page.contains(raw), "{raw}");
        }
        says(&page, &["op&lt;2&gt;", "&lt;l_knee&gt;"]);
        still(&page, 1);
        assert_eq!(page.matches("<svg ").count(), 9);
        assert_eq!(page, made(report()));
    }

    /// The script whose SHA-256 pages name, by a hash that is at hand.
    const KNOWN: u64 = 0x39d3_7892_8013_1f56;

    /// The policy of a page lets its one script run and nothing else, and that is small.
    #[test]
    fn a_page_may_run_its_own_script_and_load_nothing() {
        assert!(SCRIPT.concat().len() < 150_000);
        let page = demo(&report(), &[], "sesc demo").unwrap();
        let head = "Content-Security-Policy\" content=\"";
        let (_, policy) = page.split_once(head).unwrap();
        let (policy, _) = policy.split_once('"').unwrap();
        // That it is the hash of the script, `cargo test --test pages` checks.
        let known = fnv1a(0, (SCRIPT.concat() + SCRIPT_HASH).as_bytes());
        assert_eq!(
            known, KNOWN,
            "the script changed: see `cargo test --test pages`"
        );
        let own = "default-src 'none'; style-src 'unsafe-inline'; script-src";
        assert_eq!(policy, format!("{own} '{SCRIPT_HASH}'"));
        for handler in ["onclick=", "onload=", "javascript:", " style=\""] {
            assert!(!page.contains(handler), "{handler}");
        }
    }
}
