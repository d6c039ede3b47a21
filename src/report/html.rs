//! Pages that stand alone in one file: figures, style and script inline, nothing loaded
//! from elsewhere; without the script every figure is there and stands still.
//!
//! Every name comes from somebody's URDF and is escaped by the template
//! engine; only the figures, which escape their own texts, pass as they are.

use minijinja::value::{Serde, Value};
use minijinja::{
    Environment, Error, HtmlEscape, Output, State, UndefinedBehavior, escape_formatter,
};
use sesc_model::text::{minus, visible_lines};

use super::{svg, table};

/// What makes pages answer to a pointer; they say the same without it.
pub(super) const SCRIPT: [&str; 6] = [
    include_str!("script/pose.js"),
    include_str!("script/robot.js"),
    include_str!("script/controls.js"),
    include_str!("script/plots.js"),
    include_str!("script/tables.js"),
    include_str!("script/start.js"),
];

/// The hash of that script by which a browser knows it: it runs no other.
pub(super) const SCRIPT_HASH: &str = "sha256-NPBSac0U4bnK8tZ5Lj8SqvK2XwQyhb34SVq/881hx2Y=";

/// A page of this folder in the frame that all share.
pub(super) fn render(page: &str, context: Value) -> Result<String, Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_formatter(spelled_out);
    environment.add_filter("mm", table::mm);
    environment.add_filter("scientific", scientific);
    environment.add_filter("code", code);
    environment.add_filter("name", name);
    environment.add_filter("verbatim", verbatim);
    environment.add_filter("chance", table::chance);
    // Columns of a table line up at the point.
    environment.add_filter("hundredths", table::hundredths);
    environment.add_filter("digits", |value: f64, digits: usize| {
        minus(&format!("{value:.digits$}"))
    });
    environment.add_filter("signed", |value: f64| minus(&format!("{value:+.2}")));

    environment.add_filter("degrees", |radians: f64| {
        format!("{:.0}", radians.to_degrees())
    });
    environment.add_filter("plain", |value: f64| minus(&value.to_string()));
    environment.add_global("colors", Serde(svg::PALETTE));
    let script = format!("\n'use strict';\n{}", SCRIPT.concat());
    environment.add_global("version", env!("CARGO_PKG_VERSION"));
    environment.add_global("policy", SCRIPT_HASH);
    environment.add_global("script", Value::from_safe_string(script));
    // The ending of a page's name turns escaping on.
    for (name, source) in [
        ("page.css", include_str!("page.css")),
        ("page.html", include_str!("page.html")),
        ("again.html", include_str!("again.html")),
        ("compare.html", include_str!("compare.html")),
        ("data.html", include_str!("data.html")),
        ("demo.html", include_str!("demo.html")),
        ("diagnose.html", include_str!("diagnose.html")),
        ("health.html", include_str!("health.html")),
        ("fit.html", include_str!("fit.html")),
        ("fleet.html", include_str!("fleet.html")),
        ("fleet_robot.html", include_str!("fleet_robot.html")),
        ("origin.html", include_str!("origin.html")),
        ("next.html", include_str!("next.html")),
        ("plan.html", include_str!("plan.html")),
        ("robot.html", include_str!("robot.html")),
        ("unusable.html", include_str!("unusable.html")),
    ] {
        environment.add_template(name, source)?;
    }
    environment.get_template(page)?.render(context)
}

/// The name of a file, without the folders of this machine.
pub(super) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// A value as the engine writes it, numbers with a true minus and what is hidden in names spelled
/// out: a browser turns text around where a name says so.
fn spelled_out(
    out: &mut Output<'_>,
    state: &mut State<'_, '_>,
    value: &Value,
) -> Result<(), Error> {
    match value.as_str().filter(|_| !value.is_safe()) {
        Some(text) => escape_formatter(out, state, &Value::from(minus(&visible_lines(text)))),
        None => escape_formatter(out, state, value),
    }
}

/// A sentence with its `names` set as code.
fn code(sentence: &str) -> Value {
    let mut html = svg::escaped(&minus(sentence));
    if html.matches('`').count().is_multiple_of(2) {
        while html.contains('`') {
            html = html.replacen('`', "<code>", 1).replacen('`', "</code>", 1);
        }
    }
    Value::from_safe_string(html)
}

/// Text of programs, with the hyphens that they read.
fn verbatim(text: &str) -> Value {
    Value::from_safe_string(HtmlEscape(&visible_lines(text)).to_string())
}

/// A name that breaks behind its parts where it has to.
fn name(name: &str) -> Value {
    let breaks = svg::escaped(name)
        .replace('_', "_<wbr/>")
        .replace('.', "<wbr/>.");
    Value::from_safe_string(breaks)
}

/// A small number as people write it: 4.4 × 10⁻¹⁶.
fn scientific(value: f64) -> String {
    let text = minus(&format!("{value:.1e}"));
    let Some((digits, exponent)) = text.split_once('e').filter(|_| value != 0.0) else {
        return if value == 0.0 { "0".to_string() } else { text };
    };
    let raised = exponent.chars().map(|c| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    });
    format!("{digits} × 10{}", raised.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_sentences_are_code() {
        assert_eq!(
            code("`a<b` moves to `c`").to_string(),
            "<code>a&lt;b</code> moves to <code>c</code>"
        );
        assert_eq!(code("a stray ` stays").to_string(), "a stray ` stays");
    }

    #[test]
    fn powers_of_ten_are_raised() {
        let shown = [4.4e-16, 1.0, 0.0, 2.5e12, f64::NAN].map(scientific);
        assert_eq!(
            shown,
            ["4.4 × 10⁻¹⁶", "1.0 × 10⁰", "0", "2.5 × 10¹²", "NaN"]
        );
    }
}
