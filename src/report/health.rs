//! What is wrong with data themselves, as pages show it.

use minijinja::{Value, context};

use super::figures;
use sesc_identify::health::Finding;

/// A finding each: its kind in words, target, sentence and figure.
pub fn rows(findings: &[Finding]) -> Vec<Value> {
    let row = |finding: &Finding| {
        context! {
            kind => finding.kind.name().replace('_', " "),
            target => &finding.target,
            sentence => &finding.sentence,
            figure => finding.picture.as_ref().map(|picture| {
                Value::from_safe_string(figures::health(picture))
            }),
        }
    };
    findings.iter().map(row).collect()
}
