//! Description of the best design of a sweep.

use super::collected::value_in_words;
use super::words::Labelled;
use vibro_studies::design_sweep::{Choice, DesignRow, SweepRequest, row};

/// Maximum number of designs listed one by one.
const MAX_LISTED: usize = 8;

/// The best design, or the designs that may be the best, and the method of the search.
pub(super) fn best_in_words<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    choice: &Choice,
    all: &[(usize, DesignRow)],
) -> Vec<String> {
    let measure = &request.measures[choice.measure];
    let names = request.designs.names();
    let told = |(_, row): &(usize, DesignRow)| {
        let found = row.outputs[choice.measure]?;
        let place = request.place_in_words(set, row.motion(request, found.at));
        let place = if place.is_empty() { place } else { format!(", largest at {place}") };
        Some(format!("{}{place}", value_in_words(set, measure, found, row, &names)))
    };
    let mut lines = Vec::new();
    let undecided = match all {
        [] => return lines,
        [_] if choice.left > 0 => {
            Some("undecided: the motions of one design could be measured longer".into())
        }
        [one] if one.1.reason.is_some() => {
            Some("undecided: not all motions of one design have settled".into())
        }
        [_] => None,
        _ => Some(format!("undecided between {} designs", choice.possible.len())),
    };
    match (undecided, all) {
        (None, [one, ..]) => {
            lines.extend(told(one).map(|words| {
                format!("best by {measure}: {words}; better than the others beyond the error bars")
            }));
        }
        (undecided, _) => {
            lines.push(format!("best by {measure}: {}", undecided.unwrap_or_default()));
            lines.extend(all.iter().filter_map(told).map(|words| format!("  {words}")));
            if let more @ 1.. = choice.possible.len() - all.len() {
                lines.push(format!("  and {more} more"));
            }
        }
    }
    if let [one] = all {
        lines.extend(from_more_starts(set, request, choice, &one.1));
    }
    lines.extend(what_was_done::<M>(request, choice));
    lines
}

/// The indices of the listed designs.
pub(super) fn told(choice: &Choice) -> &[usize] {
    &choice.possible[..choice.possible.len().min(MAX_LISTED)]
}

/// Number of remeasured designs, and the method.
fn what_was_done<M: Labelled>(request: &SweepRequest<M>, choice: &Choice) -> Vec<String> {
    let again = || choice.rows.values().filter_map(|row| row.again.as_ref());
    let mut lines = Vec::new();
    if let Some(periods) = again().map(|again| again.periods).max() {
        let between = again().map(|again| again.between.len()).max().unwrap_or(0);
        let names: Vec<String> = request.between.iter().map(M::name).collect();
        let between = match between {
            0 => String::new(),
            most => format!(", and at up to {most} values between the values of {}", names.join(", ")),
        };
        let count = match choice.rows.len() {
            1 => "1 design that may be the best was".into(),
            n => format!("{n} designs that may be the best were"),
        };
        lines.push(format!("  {count} measured again, over up to {periods} {}{between}", M::periods()));
    }
    if choice.left > 0 {
        lines.push(format!(
            "  {} of them could be measured longer, but the limit of {} {} for measuring again \
             (--again) is reached",
            choice.left,
            request.again,
            M::periods()
        ));
    }
    lines
}

/// The best design's measure from other starts, if it is larger.
fn from_more_starts<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    choice: &Choice,
    best: &DesignRow,
) -> Option<String> {
    let measure = &request.measures[choice.measure];
    let more = request.from_more_starts(best.values.clone(), measure.clone())?;
    let (found, own) = (row(set, &more, 0), best.outputs[choice.measure]?);
    let largest = found.outputs.first().copied().flatten()?;
    let bar = 2.0 * largest.spread.hypot(own.spread) + 1e-6 * own.largest.abs();
    (largest.largest > own.largest + bar).then(|| {
        let words = value_in_words(set, measure, largest, &found, &request.designs.names());
        let place = more.place_in_words(set, found.motion(&more, largest.at));
        format!("  from other starts it is larger: {words}, {place}")
    })
}
