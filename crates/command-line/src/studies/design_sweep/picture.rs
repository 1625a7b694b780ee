//! The picture of a sweep: lines over one parameter; maps over two; for more parameters, maps of
//! the smallest value over all others; for designs that are not a grid, marks over each parameter.

use super::collected::{Collected, MeasureRecord, Reach};
use super::map::{LEAST, limits, map};
use super::words::Labelled;
use super::{method, varied};
use crate::wording::with_capital;
use vibro_figures::canvas::palette::BLACK;
use vibro_figures::chart::{Axis, Dash, Figure, Layer, MARK, Mark, Panel, Path, THIN, lettered};
use vibro_studies::design_sweep::{Choice, Designs, SampledAxis, SweepRequest};

/// Largest number of panels of a picture.
const PANELS: usize = 6;
/// Relative tolerance of equal values.
const SAME: f64 = 1e-9;

/// The picture; `None` for a single design and for too many designs.
pub(super) fn figure<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    found: &Collected<M>,
    choice: Option<&Choice>,
) -> Option<Figure> {
    if !found.draws() || found.records.is_empty() {
        return None;
    }
    let names = request.designs.names();
    let (records, left_out) = changing(set, found);
    if records.is_empty() {
        return None;
    }
    let (mut panels, columns, panel) = match &request.designs {
        Designs::Grid(axes) => {
            let long: Vec<&SampledAxis<M::Name>> = axes.iter().filter(|a| a.values.len() > 1).collect();
            match &long[..] {
                [] => return None,
                [axis] => (lines(set, axis, request, &records), 1, (2400, 900)),
                [x, y] => (maps(set, [x, y], request, &records), 2, (1500, 1250)),
                all => (projections(set, all, request, records[0]), 3.min(all.len()), (1300, 1150)),
            }
        }
        _ if request.designs.count() < 2 => return None,
        _ => (clouds(set, &names, request, (found, records[0])), 2.min(names.len()), (1500, 1000)),
    };
    // All projections share one scale.
    let is_projection = matches!(&request.designs, Designs::Grid(axes) if axes.iter().filter(|a| a.values.len() > 1).count() > 2);
    let symbols: Vec<_> = names.iter().map(|n| set.parameter_words(n)).collect();
    lettered(&mut panels);
    Some(Figure {
        title: with_capital(&format!("{}designs over {}", set.title(), symbols.join(", "))),
        caption: std::iter::once(method(set, request, choice))
            .chain(left_out)
            .chain([format!("Elsewhere {}", set.caption_but(&varied(request)))])
            .collect(),
        columns: columns.min(panels.len()),
        panels,
        panel,
        shared_legend: is_projection,
    })
}

/// Title of a panel.
fn title<M: Labelled>(set: &M, measure: &M::Measure, request: &SweepRequest<M>) -> String {
    match request.motions() {
        1 => set.measure_words(measure),
        motions => format!("{}, largest of {motions} motions", set.measure_words(measure)),
    }
}

/// The value of a measure if it is equal for all designs; `None` if a design has another value or
/// none.
fn constant<M: Labelled>(record: &MeasureRecord<M>) -> Option<f64> {
    let all: Option<Vec<(f64, f64)>> = record.reaches.iter().copied().collect();
    let ends = all?.into_iter().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    (ends.1 - ends.0 <= SAME * ends.0.abs().max(ends.1.abs())).then_some(ends.1)
}

/// The measures that change from design to design, and a sentence on the others.
fn changing<'a, M: Labelled>(
    set: &M,
    found: &'a Collected<M>,
) -> (Vec<&'a MeasureRecord<M>>, Option<String>) {
    let (same, changing): (Vec<_>, Vec<_>) = found.records.iter().partition(|r| constant(r).is_some());
    let told = same.iter().filter_map(|record| {
        let value = set.measure_shown(&record.measure).told(constant(record)?);
        Some(format!("{} is {value}", M::words(&record.measure)))
    });
    let told = told.collect::<Vec<_>>().join("; ");
    (changing, (!told.is_empty()).then(|| format!("Not drawn, since it is the same at all designs: {told}.")))
}

/// Kind and unit of a measure. Measures of equal kind and unit share a panel.
fn kind<M: Labelled>(set: &M, measure: &M::Measure) -> (String, &'static str) {
    let name = measure.to_string();
    let kind = name.split('.').next().unwrap_or_default().to_owned();
    // Speed and impulse have their own units.
    (kind, set.measure_unit(measure))
}

/// Axis of a parameter over the range of the data, in its written unit.
fn unbounded_axis<M: Labelled>(set: &M, name: &M::Name) -> Axis {
    Axis { range: None, ..set.axis(name) }
}

/// Panels over one parameter, one for each kind of measure. For several motions, the largest value
/// is a curve, with a pale area between it and the smallest value.
fn lines<M: Labelled>(
    set: &M,
    axis: &SampledAxis<M::Name>,
    request: &SweepRequest<M>,
    records: &[&MeasureRecord<M>],
) -> Vec<Panel> {
    let mut order: Vec<usize> = (0..axis.values.len()).collect();
    order.sort_by(|a, b| axis.values[*a].total_cmp(&axis.values[*b]));
    let mut groups: Vec<Vec<&MeasureRecord<M>>> = Vec::new();
    for &record in records {
        match groups.iter_mut().find(|g| kind(set, &g[0].measure) == kind(set, &record.measure)) {
            Some(group) => group.push(record),
            None => groups.push(vec![record]),
        }
    }
    groups.truncate(PANELS);
    let panel = |group: Vec<&MeasureRecord<M>>| {
        let mut layers = Vec::new();
        for record in &group {
            layers.extend(curve(set, axis, &order, record, (request.motions() > 1, group.len() > 1)));
        }
        let bad: Path = order
            .iter()
            .filter(|i| group.iter().any(|r| r.reaches[**i].is_none()))
            .map(|i| (axis.values[*i], 0.0))
            .collect();
        if !bad.is_empty() {
            layers.push(Layer::marks("no value (at 0)", BLACK, Mark::Cross, bad).stroke(MARK));
        }
        let label = match &group[..] {
            [one] => set.measure_words(&one.measure),
            several => kind(set, &several[0].measure).0.replace('_', " "),
        };
        let largest = if request.motions() > 1 {
            format!("largest of {} motions, and down to the least", request.motions())
        } else {
            String::new()
        };
        let y = set.measure_axis(&group[0].measure, &label);
        Panel { title: largest, x: unbounded_axis(set, &axis.name), y, layers }
    };
    groups.into_iter().map(panel).collect()
}

/// The layers of one measure over one parameter, for several motions of a design and named among
/// others in the panel.
fn curve<M: Labelled>(
    set: &M,
    axis: &SampledAxis<M::Name>,
    order: &[usize],
    record: &MeasureRecord<M>,
    (several, named): (bool, bool),
) -> Vec<Layer> {
    let mut pieces: Vec<Path> = vec![Vec::new()];
    let mut band: Vec<(f64, f64, f64)> = Vec::new();
    for &i in order {
        match record.reaches[i] {
            Some((least, largest)) => {
                pieces.last_mut().into_iter().for_each(|p| p.push((axis.values[i], largest)));
                band.push((axis.values[i], least, largest));
            }
            None => pieces.push(Vec::new()),
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    let (name, colour) = (set.measure_words(&record.measure), set.colour(&record.measure));
    let dash = if M::is_closed_form(&record.measure) { Dash::Dashed } else { Dash::Solid };
    // A design between two designs without values is drawn as a mark, since a line of one point is
    // not visible.
    let lonely: Path = pieces.iter().filter(|p| p.len() == 1).flatten().copied().collect();
    let mut layers = Vec::new();
    if several && pieces.len() == 1 {
        layers.push(Layer::band("", colour, 0.25, band));
    }
    layers.push(match named {
        true => Layer::lines(&name, colour, dash, pieces).labelled(name.clone()),
        false => Layer::lines("", colour, dash, pieces),
    });
    if !lonely.is_empty() {
        layers.push(Layer::marks("", colour, Mark::Disc, lonely).stroke(THIN));
    }
    layers
}

fn largest(reach: &Reach) -> Option<f64> {
    reach.map(|r| r.1)
}

/// A map whose legend shows the smallest value with its spread.
fn with_least(mut panel: Panel, least: Option<String>, unit: &str) -> Panel {
    let marked =
        panel.layers.iter_mut().find(|layer| layer.name.as_ref().is_some_and(|name| name.starts_with(LEAST)));
    if let (Some(layer), Some(least)) = (marked, least) {
        layer.name = Some(format!("{LEAST}{least}{unit}"));
    }
    panel
}

/// Maps over two parameters, one for each measure.
fn maps<M: Labelled>(
    set: &M,
    axes: [&SampledAxis<M::Name>; 2],
    request: &SweepRequest<M>,
    records: &[&MeasureRecord<M>],
) -> Vec<Panel> {
    let panel = |record: &&MeasureRecord<M>| {
        let unit = set.measure_shown(&record.measure);
        let shown = |reach: &Reach| largest(reach).map(|value| unit.number(value));
        let values: Vec<Option<f64>> = record.reaches.iter().map(shown).collect();
        let least = record.least_in(unit.number(1.0));
        let panel =
            map(set, title(set, &record.measure, request), &unit.spaced(), axes, &values, &limits(&values));
        with_least(panel, least, &unit.spaced())
    };
    records.iter().take(PANELS).map(panel).collect()
}

/// Maps for more than two parameters: for each pair the smallest value of the first measure over
/// all other parameters, all on one scale.
fn projections<M: Labelled>(
    set: &M,
    axes: &[&SampledAxis<M::Name>],
    request: &SweepRequest<M>,
    record: &MeasureRecord<M>,
) -> Vec<Panel> {
    let unit = set.measure_shown(&record.measure);
    let reaches: Vec<Reach> =
        record.reaches.iter().map(|r| r.map(|(a, b)| (unit.number(a), unit.number(b)))).collect();
    let pairs = (0..axes.len()).flat_map(|i| (i + 1..axes.len()).map(move |j| [i, j]));
    let best: Vec<_> =
        pairs.take(PANELS).map(|pair| (pair, best_over_others(axes, pair, &reaches))).collect();
    let limits = limits(best.iter().flat_map(|(_, values)| values));
    let panel = |(pair, values): ([usize; 2], Vec<Option<f64>>)| {
        let others = (0..axes.len()).filter(|k| !pair.contains(k));
        let others: Vec<_> = others.map(|k| set.parameter_words(&axes[k].name)).collect();
        let words = format!("{}; least over {}", title(set, &record.measure, request), others.join(", "));
        let panel = map(set, words, &unit.spaced(), pair.map(|k| axes[k]), &values, &limits);
        with_least(panel, record.least_in(unit.number(1.0)), &unit.spaced())
    };
    best.into_iter().map(panel).collect()
}

/// The smallest value over all axes except a pair, the second of the pair varying fastest.
fn best_over_others<N>(axes: &[&SampledAxis<N>], [i, j]: [usize; 2], reaches: &[Reach]) -> Vec<Option<f64>> {
    let counts: Vec<usize> = axes.iter().map(|a| a.values.len()).collect();
    let place = |design: usize, axis: usize| {
        let inner: usize = counts[axis + 1..].iter().product();
        design / inner % counts[axis]
    };
    let mut best: Vec<Option<f64>> = vec![None; counts[i] * counts[j]];
    for (design, reach) in reaches.iter().enumerate() {
        let cell = &mut best[place(design, i) * counts[j] + place(design, j)];
        *cell = match (*cell, largest(reach)) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
    best
}

/// Panels of the first measure over each parameter.
fn clouds<M: Labelled>(
    set: &M,
    names: &[M::Name],
    request: &SweepRequest<M>,
    (found, record): (&Collected<M>, &MeasureRecord<M>),
) -> Vec<Panel> {
    let panel = |(index, name): (usize, &M::Name)| {
        let (mut points, mut bad) = (Path::new(), Path::new());
        for (values, reach) in found.values.iter().zip(&record.reaches) {
            match largest(reach) {
                Some(y) => points.push((values[index], y)),
                None => bad.push((values[index], 0.0)),
            }
        }
        let mut layers =
            vec![Layer::marks("", set.colour(&record.measure), Mark::Disc, points).stroke(MARK / 2)];
        if !bad.is_empty() {
            layers.push(Layer::marks("no value (at 0)", BLACK, Mark::Cross, bad));
        }
        let y = set.measure_axis(&record.measure, &set.measure_words(&record.measure));
        Panel { title: title(set, &record.measure, request), x: unbounded_axis(set, name), y, layers }
    };
    names.iter().enumerate().take(PANELS).map(panel).collect()
}
