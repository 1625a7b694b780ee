//! Description of the result of a design search.

use crate::studies::design_sweep::with_spread;
use crate::wording::shown_unit;
use vibro_design::{Attractor, Best, DesignRequest, Designed, Rival, Side, Stage, Value, Verdict};
use vibro_studies::Measure;

/// Cap on the listed other designs, and on the listed attractors.
const LISTED: usize = 4;

/// A value with half its error bar and its unit.
fn value(request: &DesignRequest, measure: &Measure, own: &Value) -> String {
    let unit = measure.unit(&request.machine.description);
    let (factor, symbol) = shown_unit(unit, own.value.abs());
    let symbol = if symbol == "1" { String::new() } else { format!(" {symbol}") };
    format!("{}{symbol}", with_spread(factor * own.value, factor * own.error()))
}

/// The parameters of a design in the units of the file.
fn numbers(request: &DesignRequest, values: &[f64]) -> String {
    let told = |(name, value): (String, &f64)| format!("{name} = {}", request.machine.told(&name, *value));
    request.names().into_iter().zip(values).map(told).collect::<Vec<_>>().join(", ")
}

/// Remarks, line by line.
pub fn remarks(request: &DesignRequest, found: &Designed) -> Vec<String> {
    let mut lines = vec![format!("verdict: {}", found.verdict)];
    if let Some(best) = &found.best {
        lines.extend(best_in_words(request, found, best));
        lines.extend(found.rivals.iter().take(LISTED).map(|own| rival(request, own)));
        lines.extend(attractors(request, best));
    }
    lines.push(what_was_done(request, found));
    lines
}

fn best_in_words(request: &DesignRequest, found: &Designed, best: &Best) -> Vec<String> {
    let measure = &request.goal.measure;
    let worst = if best.place.is_empty() { String::new() } else { format!(", worst at {}", best.place) };
    let head = match found.verdict {
        Verdict::NoneFound(_) => "nearest design",
        _ => "best",
    };
    let mut lines = vec![
        format!("{head}: {measure} = {}{worst}", value(request, measure, &best.goal)),
        format!("  {}", numbers(request, &best.values)),
    ];
    let own = found.evaluations.iter().find(|own| own.stage == Stage::Own).and_then(|own| own.goal);
    if let Some(goal) = own {
        lines.push(format!("  with the parameters of the file: {}", value(request, measure, &goal)));
    }
    if !best.at_ends.is_empty() {
        lines.push(format!("  at an end of its range: {}", best.at_ends.join(", ")));
    }
    for (limit, (own, check)) in request.limits.iter().zip(&best.limits) {
        let sign = if limit.side == Side::AtMost { "<=" } else { ">=" };
        let bound = Value { value: limit.value, bar: (limit.value, limit.value), is_exact: true };
        let own = own.map_or("no value".into(), |own| value(request, &limit.measure, &own));
        let bound = value(request, &limit.measure, &bound);
        lines.push(format!("  limit {}: {own} {sign} {bound}: {}", limit.measure, check.name()));
    }
    if request.robust > 0.0 {
        lines.push(format!("  worst value within ±{} % of the varied parameters", 100.0 * request.robust));
    }
    lines
}

fn rival(request: &DesignRequest, own: &Rival) -> String {
    let apart = if own.is_told_apart { "distinguishable" } else { "not distinguishable from the best" };
    let goal = value(request, &request.goal.measure, &own.goal);
    format!("  other: {goal} at {}: {apart}", numbers(request, &own.values))
}

/// Descriptions of the motions that the starts lead to at the point with the worst value.
fn attractors(request: &DesignRequest, best: &Best) -> Vec<String> {
    let all: usize = best.attractors.iter().map(|own| own.starts).sum();
    let one = |own: &Attractor| {
        let goal = value(request, &request.goal.measure, &own.goal);
        let impacts = vibro_studies::significant(own.impacts);
        let worse = match (own.is_worse, own.is_requested) {
            (false, _) => String::new(),
            (true, _) => format!(", worse than the value of the design; start {}", own.start),
        };
        format!(
            "  {} with {impacts} contacts per period: {goal} from {} of {all} starts{worse}",
            own.class.name(),
            own.starts
        )
    };
    match &best.attractors[..] {
        [] => Vec::new(),
        [own] if own.starts > 1 => vec![format!("  one motion from {all} starts: {}", own.class.name())],
        [_] => Vec::new(),
        several => {
            let mut lines = vec!["motions that coexist at its worst value:".to_owned()];
            lines.extend(several.iter().take(LISTED).map(one));
            if several.len() > LISTED {
                lines.push(format!("  and {} more", several.len() - LISTED));
            }
            lines
        }
    }
}

fn what_was_done(request: &DesignRequest, found: &Designed) -> String {
    let count = |stage: Stage| found.evaluations.iter().filter(|own| own.stage == stage).count();
    let stages = [Stage::Sobol, Stage::Evolution, Stage::Gradient, Stage::Nearby];
    let words = stages.into_iter().filter(|stage| count(*stage) > 0);
    let words: Vec<String> = words.map(|stage| format!("{} by {}", count(stage), stage.words())).collect();
    let gradients = match (found.orbits, found.has_gradients) {
        (0, _) => "; no gradients, because no motion has a stable periodic orbit with derivatives".to_owned(),
        (n, true) => format!("; the best was found by exact derivatives of {n} orbits"),
        (n, false) => format!("; exact derivatives of {n} orbits did not lead to a better design"),
    };
    let over = if request.over.is_empty() { "" } else { ", each by its worst value over the band" };
    format!("{} designs{over}: {}{gradients}", found.evaluations.len(), words.join(", "))
}
