//! Natural frequencies of large parts of a machine, in words.

use super::short;
use std::f64::consts::TAU;
use vibro_studies::natural::{Oscillation, Span};

/// The lowest and highest oscillations of a large part of a machine.
pub(super) fn in_words(span: &Span) -> Vec<String> {
    let [low, high] = &span.shown;
    let all = span.coordinates - span.still;
    let of = |own: &Oscillation| match own.damped {
        Some(value) => {
            let (omega, ratio) = (value.norm(), -value.re / value.norm());
            format!("  {} Hz, damping ratio {}", short(omega / TAU), short(ratio))
        }
        None => format!("  {} Hz undamped, damping ratio undecided", short(own.undamped / TAU)),
    };
    let still = match span.still {
        0 => String::new(),
        still => format!("; {still} of them without a restoring force"),
    };
    let mut lines = vec![format!(
        "  a part with {} coordinates{still}: {all} oscillations; listed are",
        span.coordinates
    )];
    lines.push(format!("  the {} lowest", low.len()));
    lines.extend(low.iter().map(of));
    lines.push(format!("  and, after {} that are not listed, the {} highest", span.between(), high.len()));
    lines.extend(high.iter().map(of));
    lines
}
