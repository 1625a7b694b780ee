//! Maps of a measure over two parameters, in steps of colour.

use super::words::Labelled;
use vibro_figures::canvas::palette::{BLACK, VERMILLION};
use vibro_figures::chart::{Axis, Colour, Layer, Mark, Panel, Shape};
use vibro_studies::design_sweep::SampledAxis;
use vibro_studies::significant;

/// Colours from the smallest to the largest value (viridis), increasingly dark, so that they also
/// differ in greyscale.
const SCALE: [Colour; 8] = [
    Colour(253, 231, 37),
    Colour(160, 218, 57),
    Colour(74, 193, 109),
    Colour(31, 161, 135),
    Colour(39, 127, 142),
    Colour(54, 92, 141),
    Colour(70, 50, 126),
    Colour(68, 1, 84),
];
/// Beginning of the legend of the smallest value.
pub(super) const LEAST: &str = "least, ";
/// Colour of a cell without a value.
const NOTHING: Colour = Colour(200, 200, 200);
/// Tolerance of equal distances on an axis, relative to its length.
const EVEN: f64 = 1e-9;

/// Equally spaced round numbers that enclose a range in at most one step per colour.
fn steps(least: f64, largest: f64) -> Vec<f64> {
    if least >= largest {
        return vec![least];
    }
    let span = largest - least;
    let power = 10f64.powf((span / SCALE.len() as f64).log10().floor());
    let enclosing = |step: f64| {
        let (from, count) = ((least / step).floor(), (largest / step).ceil() - (least / step).floor());
        let limits = || (0..=count as u32).map(|k| (from + f64::from(k)) * step).collect();
        (count <= SCALE.len() as f64).then(limits)
    };
    // 20 times the power is at least two eighths of the range, which is enough for any position of
    // the range.
    let found = [1.0, 2.0, 5.0, 10.0, 20.0].into_iter().find_map(|times| enclosing(times * power));
    found.unwrap_or_else(|| vec![least, largest])
}

/// The axis of a map, the range of its cells, and the position of each value. Unequally spaced
/// values have cells of equal size, labelled individually.
fn axis<M: Labelled>(set: &M, of: &SampledAxis<M::Name>) -> (Axis, (f64, f64), Vec<f64>) {
    let (values, count) = (&of.values, of.values.len());
    let (first, last) = (values[0], values[count - 1]);
    let part = |k: usize| k as f64 / (count - 1).max(1) as f64;
    let even =
        |k: usize| (values[k] - first * (1.0 - part(k)) - last * part(k)).abs() <= EVEN * (last - first);
    if first < last && (0..count).all(even) {
        let half = 0.5 * (last - first) / (count - 1) as f64;
        let range = (first - half, last + half);
        let axis = Axis { range: Some(range), ..set.axis(&of.name) };
        return (axis, range, values.clone());
    }
    let range = (0.5, count as f64 + 0.5);
    let unit = set.shown(&of.name);
    let names = values.iter().map(|v| significant(v * unit)).collect();
    let places = (1..=count).map(|k| k as f64).collect();
    let label = set.axis(&of.name).label;
    (Axis { names, ..Axis::over(label, range.0, range.1) }, range, places)
}

/// Range of the values that are present.
fn range<'a>(values: impl IntoIterator<Item = &'a Option<f64>>) -> (f64, f64) {
    let met = values.into_iter().flatten();
    met.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
}

/// Limits of the colour steps for values of one or several maps; empty without a value.
pub(in crate::studies) fn limits<'a>(values: impl IntoIterator<Item = &'a Option<f64>>) -> Vec<f64> {
    let (least, largest) = range(values);
    if least <= largest { steps(least, largest) } else { Vec::new() }
}

/// Map of `values` in steps between these limits. Values are numbered as designs are, with the
/// second axis varying fastest.
pub(in crate::studies) fn map<M: Labelled>(
    set: &M,
    title: String,
    unit: &str,
    axes: [&SampledAxis<M::Name>; 2],
    values: &[Option<f64>],
    limits: &[f64],
) -> Panel {
    let [(x, across, x_places), (y, up, y_places)] = axes.map(|of| axis(set, of));
    let (columns, rows) = (x_places.len(), y_places.len());
    let least = range(values).0;
    let count = limits.len().saturating_sub(1).max(1);
    // The last step includes its upper limit.
    let step = |v: f64| limits.iter().skip(1).take(count - 1).filter(|limit| v >= **limit).count();
    let colour =
        |step: usize| SCALE[(step * (SCALE.len() - 1)).div_ceil((count - 1).max(1)).min(SCALE.len() - 1)];
    let value = |i: usize, j: usize| values[i * rows + j];
    let code = |found: Option<f64>| found.map_or(0, |v| 1 + step(v) as u8);
    let cells: Vec<u8> =
        (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))).map(|(i, j)| code(value(i, j))).collect();
    let missing = cells.contains(&0);
    let mut colours = vec![Some(NOTHING)];
    colours.extend((0..count).map(|k| Some(colour(k))));
    let mut layers = vec![Layer::new("", BLACK, Shape::Cells { x: across, y: up, columns, cells, colours })];
    let entry = |name: &str, colour| Layer::band(name, colour, 1.0, Vec::new());
    match limits {
        [] => {}
        [only] => layers.push(entry(&format!("{}{unit}", significant(*only)), colour(0))),
        limits => {
            let colours = (0..count).map(colour).collect();
            let limits = limits.iter().map(|limit| significant(*limit)).collect();
            // A bar is in the legend by its name, also without a unit.
            let unit = if unit.is_empty() { " " } else { unit.trim_start() };
            layers.push(Layer::new(unit, BLACK, Shape::Bar { colours, limits }));
        }
    }
    if missing {
        layers.push(entry("no value", NOTHING));
    }
    let least_at =
        (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))).find(|&(i, j)| value(i, j) == Some(least));
    // If all values are equal, none is marked as the smallest.
    if let (Some((i, j)), true) = (least_at, limits.len() > 1) {
        let name = format!("{LEAST}{}{unit}", significant(least));
        layers.push(Layer::marks(&name, VERMILLION, Mark::Disc, vec![(x_places[i], y_places[j])]));
    }
    Panel { title, x, y, layers }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_of_round_steps() {
        assert_eq!(steps(0.0193, 0.0395), [0.015, 0.02, 0.025, 0.03, 0.035, 0.04]);
        assert_eq!(steps(0.0, 2.0), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(steps(3.0, 3.0), [3.0]);
        for (least, largest) in [(-1.0, 1e-9), (0.999, 1.001), (1e-12, 7.9), (-5e8, 3.1e8), (1.95, 9.05)] {
            let found = steps(least, largest);
            assert!(found[0] <= least && found[found.len() - 1] >= largest, "{found:?}");
            assert!((2..=SCALE.len() + 1).contains(&found.len()), "{found:?}");
        }
    }
}
