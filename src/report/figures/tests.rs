//! Made-up rows in; every figure must be a tree of shapes that says its numbers.

use super::super::svg::tests::sound;
use super::super::tests::report;
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

#[test]
fn figures_are_sound_on_light_and_dark_pages() {
    for svg in all(&report()) {
        assert!(!sound(&svg).is_empty());
    }
}

/// Every dot of a figure poses the robot or says what it stands for.
#[test]
fn dots_stand_for_a_posture_or_have_words() {
    let report = report();
    let figures = all(&report);
    let groups = |svg: &str, attribute: &str| svg.matches(&format!("<g {attribute}=")).count();
    for k in [1, 2, 3, 6, 7] {
        assert!(groups(&figures[k], "data-p") >= report.cop.len(), "{k}");
        let [first, last] = ["data-p=\"100\"", "data-p=\"125\""];
        assert!(
            figures[k].contains(first) && figures[k].contains(last),
            "{k}"
        );
    }
    for k in [4, 5] {
        assert_eq!(groups(&figures[k], "data-v"), report.lengths.len(), "{k}");
    }
}

#[test]
fn errors_are_labelled_with_their_millimetres() {
    let texts = sound(&errors(&report()));
    for label in [
        "4.00 mm",
        "3.85 mm",
        "0.72 mm",
        "noise alone 3.93 mm",
        "theory 0.71 mm",
    ] {
        assert!(
            texts.iter().any(|text| text == label),
            "{label} in {texts:?}"
        );
    }
}

#[test]
fn each_parameter_is_one_square() {
    let svg = parameters(&report());
    // The paper, 42 seen, 1 height, 20 hollow ones of two squares each; the key has 1 + 1 + 2.
    assert_eq!(svg.matches("<rect").count(), 1 + 42 + 1 + 2 * 20 + 4);
    assert!(sound(&svg).iter().any(|text| text == "42 from flat CoP"));
}

#[test]
fn names_are_escaped_and_long_ones_shortened() {
    let texts = sound(&lengths_full(&report().lengths));
    assert!(texts.iter().any(|text| text == "<b>&\"foot\""));
    assert!(texts.iter().any(|text| text == "a_link_with_a_very…"));
}

#[test]
fn unseen_lengths_are_hollow() {
    let mut rows = report().lengths;
    let rings = |rows: &[LengthRow]| {
        lengths_full(rows)
            .matches("class=\"orange hollow\"")
            .count()
    };
    assert!(rings(&rows) > 0);
    rows.iter_mut().for_each(|row| row.unseen.clear());
    assert_eq!(rings(&rows), 0);
}

#[test]
fn the_height_constant_is_written_where_it_fits() {
    let report = report();
    let texts = sound(&height_level(&report.height, report.height_offset_m, 0));
    assert!(texts.iter().any(|text| text.contains("33.6 mm")));
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
