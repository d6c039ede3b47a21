//! Made-up rows in; every figure must be a tree of shapes that says its numbers.

use super::super::svg::tests::sound;
use super::super::tests::{report, says};
use super::super::{CopRow, DemoReport, HeightRow, LengthRow};
use super::demo::*;

fn all(report: &DemoReport) -> Vec<String> {
    vec![
        errors(report),
        cop_over_postures(&report.cop, 0, 100),
        cop_over_postures(&report.cop, 1, 100),
        cop_plane(&report.cop, [0.105, 0.066], 100),
        lengths_full(&report.lengths),
        lengths_base(&report.lengths),
        height_level(&report.height, report.height_offset_m, 100),
        height_shape(&report.height, 100),
        parameters(report),
    ]
}

/// Every dot of a figure poses the robot or says what it stands for.
#[test]
fn dots_stand_for_a_posture_or_have_words() {
    let report = report();
    let figures = all(&report);
    let groups = |svg: &str, attribute: &str| svg.matches(&format!("<g {attribute}=")).count();
    for k in [1, 2, 3, 6, 7] {
        assert!(groups(&figures[k], "data-p") >= report.cop.len(), "{k}");
        says(&figures[k], &["data-p=\"100\"", "data-p=\"125\""]);
    }
    for k in [4, 5] {
        assert_eq!(groups(&figures[k], "data-v"), report.lengths.len(), "{k}");
    }
}

#[test]
fn figures_are_sound_and_say_their_numbers_and_names() {
    let report = report();
    let figures = all(&report);
    let texts = figures.iter().flat_map(|svg| {
        let texts = sound(svg);
        assert!(!texts.is_empty());
        texts
    });
    let texts = texts.collect::<Vec<_>>().join("|");
    let errors = ["4.00 mm", "3.85 mm", "0.72 mm", "noise alone 3.93 mm"];
    says(&texts, &errors);
    says(&texts, &["theory 0.71 mm", "42 from flat CoP", "33.6 mm"]);
    // Names are escaped, and long ones are shortened.
    says(&texts, &["|<b>&\"foot\"|", "|a_link_wi…long_name|"]);
    // The paper, 42 seen, 1 height, 20 hollow ones; the key has one of each kind.
    let squares = parameters(&report).matches("<rect").count();
    assert_eq!(squares, 1 + 42 + 1 + 20 + 3);
}

#[test]
fn unseen_lengths_are_hollow() {
    let mut rows = report().lengths;
    let hollow = "class=\"orange hollow\"";
    let rings = |rows: &[LengthRow]| lengths_full(rows).matches(hollow).count();
    assert!(rings(&rows) > 0);
    rows.iter_mut().for_each(|row| row.unseen.clear());
    assert_eq!(rings(&rows), 0);
}

#[test]
fn cad_is_drawn_only_where_it_differs() {
    let mut rows = report().cop;
    let shows_cad =
        |rows: &[CopRow]| sound(&cop_over_postures(rows, 0, 0)).contains(&"CAD".to_string());
    assert!(!shows_cad(&rows));
    rows[0].cad[0] += 0.01;
    assert!(shows_cad(&rows));
}

/// No rows, one row, values that are no numbers: still figures.
#[test]
fn odd_rows_are_drawn_too() {
    let mut odd = report();
    odd.cop.truncate(1);
    odd.height = vec![HeightRow {
        pose: 1,
        truth: f64::NAN,
        identified: 0.2,
        anchored: f64::INFINITY,
    }];
    odd.lengths.truncate(1);
    odd.lengths[0].full_m = f64::NAN;
    odd.errors.measured_mae_m = f64::NAN;
    odd.full_params = 0;
    odd.base_params = 0;
    odd.rank_cop = 0;
    let mut empty = odd.clone();
    empty.cop.clear();
    empty.height.clear();
    empty.lengths.clear();
    for svg in all(&odd).into_iter().chain(all(&empty)) {
        sound(&svg);
    }
}
