//! Position limits of a joint; effort and velocity only pass through.

use roxmltree::Node;

use super::description::{JointType, Limit};
use super::limits;
use super::values::{At, Reader};

pub(super) fn read_limit(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    kind: JointType,
    subject: &str,
) -> Limit {
    let mut limit = Limit::NONE;
    let found = match kind {
        JointType::Fixed => None,
        _ => reader.only(node, "limit", subject),
    };
    let text = |reader: &Reader<'_>, name| found.and_then(|found| reader.attribute(found, name));
    if let Some(text) = text(reader, "effort") {
        limit.effort = reader.unneeded(&text, subject, "limit effort");
    }
    if let Some(text) = text(reader, "velocity") {
        limit.velocity = reader.unneeded(&text, subject, "limit velocity");
    }
    if !kind.has_limits() {
        return limit;
    }
    let given = ["lower", "upper"].map(|name| text(reader, name));
    let line = given.iter().flatten().map(|text| text.line).next();
    let Some(line) = line else {
        let line = reader.line(found.unwrap_or(node));
        reader.note(
            line,
            format!("{subject}: no lower and upper limit; taken as unlimited"),
        );
        return limit;
    };
    let Some(low) = read_bound(reader, given[0].as_ref(), subject, "limit lower") else {
        return limit;
    };
    let Some(high) = read_bound(reader, given[1].as_ref(), subject, "limit upper") else {
        return limit;
    };
    if low > high || low == f64::INFINITY || high == f64::NEG_INFINITY {
        let missing = match &given {
            [None, _] => " (lower is missing, which counts as 0)",
            [_, None] => " (upper is missing, which counts as 0)",
            _ => "",
        };
        // Some simulators write "free" this way; nothing else depends on limits.
        reader.note(
            line,
            format!(
                "{subject}: limit lower {low} is above upper {high}{missing}; taken as unlimited"
            ),
        );
        return limit;
    }
    let largest = [low, high]
        .into_iter()
        .map(f64::abs)
        .filter(|v| v.is_finite());
    let largest = largest.fold(0.0, f64::max);
    if kind == JointType::Revolute && (limits::TURN_RAD..limits::UNLIMITED_RAD).contains(&largest) {
        reader.note(
            line,
            format!("{subject}: limit {largest} rad; is it in degrees?"),
        );
    }
    Limit {
        lower: low,
        upper: high,
        ..limit
    }
}

/// A missing bound counts as 0; an infinite one is none.
fn read_bound(
    reader: &mut Reader<'_>,
    text: Option<&At<&str>>,
    subject: &str,
    what: &str,
) -> Option<f64> {
    let Some(text) = text else { return Some(0.0) };
    let [value] = reader.extended_numbers::<1>(text, subject, what)?;
    if value.is_nan() {
        reader.complain(
            text.line,
            format!("{subject}: {what} is NaN, not finite; give a plain number"),
        );
        return None;
    }
    Some(value)
}
