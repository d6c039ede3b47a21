//! A made-up report for the tests of pages and figures, and what holds for every page.

use super::{CopRow, DemoReport, Errors, FunctionRow, HeightRow, LengthRow};

/// OP2-like numbers under names that need escaping.
pub(super) fn report() -> DemoReport {
    let function =
        |name: &str, [mul, add]: [usize; 2], [worst_error_m, bound_m]: [f64; 2]| FunctionRow {
            name: name.to_string(),
            mul,
            add,
            sin_cos: 20,
            worst_error_m,
            bound_m,
        };
    let length = |[body, joint, unseen]: [&str; 3], cad_m: f64, full_m: f64| LengthRow {
        body: body.to_string(),
        joint: joint.to_string(),
        cad_m,
        full_m,
        base_cad_m: cad_m,
        base_m: cad_m + 0.0004,
        unseen: unseen.to_string(),
    };
    let wave = |k: usize| (k as f64 * 1.7).sin();
    DemoReport {
        robot: "op<2>".to_string(),
        hash: "00c0ffee".to_string(),
        support: "r_sole".to_string(),
        dof: 20,
        bodies: 21,
        full_params: 63,
        base_params: 43,
        rank_cop: 42,
        postures: 1000,
        range_deg: 30.0,
        noise_m: 0.00493,
        held_out: 500,
        functions: vec![
            function("com", [80, 78], [4.4e-16, 8.9e-15]),
            function("regressor", [218, 106], [2e-12, 1e-12]),
        ],
        lengths: vec![
            length(["<b>&\"foot\"", "", "its height"], 0.034, 0.014),
            length(["r_knee_link", "pitch", "along pitch"], 0.084, 0.085),
            length(
                ["a_link_with_a_very_long_name", "j", "along j"],
                0.002,
                0.015,
            ),
        ],
        errors: Errors {
            measured_mae_m: 0.004,
            in_sample_mae_m: 0.00385,
            noise_mae_m: 0.003_933,
            clean_rmse_base_m: 0.00072,
            clean_rmse_full_m: 0.00072,
            theory_rmse_m: 0.000_714,
            cad_clean_rmse_m: 0.0,
        },
        cop: (1..=26)
            .map(|k| {
                let truth @ [x, y] = [0.1 * wave(k), 0.05 + 0.07 * wave(k + 3)];
                CopRow {
                    pose: k,
                    q: vec![wave(k)],
                    measured: [x + 0.005 * wave(k + 1), y - 0.004 * wave(k + 2)],
                    truth,
                    cad: truth,
                    identified: [x + 0.0007 * wave(k + 5), y],
                }
            })
            .collect(),
        height: (1..=26)
            .map(|k| {
                let truth = 0.2 + 0.03 * wave(k);
                HeightRow {
                    pose: k,
                    truth,
                    identified: truth - 0.0336,
                    anchored: truth + 0.001 * wave(k + 1),
                }
            })
            .collect(),
        height_offset_m: -0.0336,
        unobservable: vec!["mass along the axis of <l_knee> moves to its parent".to_string()],
        hidden: None,
    }
}

/// A page without its scripts, of which it has as many as are expected and none from elsewhere:
/// it refers to nothing outside, and data in scripts end no script.
pub(super) fn still(page: &str, scripts: usize) -> String {
    let mut parts = page.split("<script");
    let mut out = parts.next().unwrap().to_string();
    let mut count = 0;
    for part in parts {
        let (script, rest) = part.split_once("</script>").expect("a script ends");
        assert!(!script.contains("<!--") && !script.contains('\u{2028}'));
        out.push_str(rest);
        count += 1;
    }
    assert_eq!(count, scripts);
    true_minus(&out);
    let outside = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let outside = outside.replace("http-equiv", "");
    let references = "http src= href @import url( eval( innerHTML";
    for reference in references.split(' ') {
        assert!(!outside.contains(reference), "{reference}");
    }
    out
}

/// Numbers of a page have a true minus; programs' text in `pre` and `code` is as programs write it.
#[track_caller]
pub(super) fn true_minus(page: &str) {
    let mut rest = page
        .split_once("<body>")
        .map_or(page, |(_, body)| body)
        .to_string();
    for (begin, end) in [
        ("<pre", "</pre>"),
        ("<code", "</code>"),
        ("<style", "</style>"),
    ] {
        while let Some((before, after)) = rest.split_once(begin) {
            rest = format!("{before} {}", after.split_once(end).unwrap().1);
        }
    }
    let texts = rest
        .split('<')
        .filter_map(|part| Some(part.split_once('>')?.1));
    for text in texts {
        let words = text.split(|c: char| c.is_whitespace() || "(±".contains(c));
        let hyphen = |word: &str| {
            word.starts_with('-') && word[1..].starts_with(|c: char| c.is_ascii_digit())
        };
        assert!(!words.clone().any(hyphen), "a hyphen for a minus: {text}");
    }
}

/// Asserts that a text holds all of these words.
#[track_caller]
pub(super) fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}
