//! Panels, tables and remarks common to all bifurcation diagrams: with exponents, with orbits, and
//! of described machines.

use crate::Result;
use crate::table::{CsvRows, TextTable, exact};
use vibro_figures::canvas::palette::{BLACK, SKY};
use vibro_figures::chart::{Axis, Colour, Dash, Layer, Panel, Path, Shape, THIN};
use vibro_studies::diagram::{Diagram, DiagramPoint, Window};
use vibro_studies::{AxisName, ParameterAxis};

/// Number of rows of cells in a diagram, and largest number of columns. If there are more values,
/// neighbours share a column.
const ROWS: usize = 380;
const COLUMNS: usize = 1300;
/// Limits between the four shades, as fractions of the kept periods that fall into a cell.
const STEPS: [f64; 3] = [0.005, 0.03, 0.2];
const SHADES: [Colour; 4] = [Colour(120, 120, 120), Colour(85, 85, 85), Colour(45, 45, 45), Colour(0, 0, 0)];
/// Colours of rare and of frequent maxima of the falling direction, at values where it settles on
/// another motion than the rising direction. Both colours are lighter than any shade, so that they
/// differ in greyscale too.
const FALLING: [Colour; 2] = [Colour(150, 205, 240), SKY];

/// Stroke of the curves over which others are drawn.
pub(super) const WIDE: u32 = 14;
/// Largest number of windows listed on the screen.
const MAX_LISTED: usize = 40;

/// The two directions through a range of values.
pub(super) const DIRECTIONS: [&str; 2] = ["rising", "falling"];

/// Converts a maximum at a point to units of the set's own gap.
type Length<'a, P> = &'a dyn Fn(&P, f64) -> f64;

/// Range of all maxima, extended by the margin `air`.
pub(super) fn reach<P: DiagramPoint>(diagram: &Diagram<P>, length: Length<'_, P>, air: f64) -> (f64, f64) {
    let points = diagram.up.iter().chain(&diagram.down).flatten();
    let all = points.flat_map(|p| p.maxima().iter().map(|m| length(p, m.0)));
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if low > high { (0.0, 1.0) } else { (low - 0.03 * (high - low) - air, high + 0.03 * (high - low) + air) }
}

/// Cells of the maxima: 0 for none, 1 to 4 for the shades of the rising direction, 5 and 6 for the
/// falling direction at values where it settles on another motion.
fn cells<N: AxisName, P: DiagramPoint>(
    (axis, kept): (&ParameterAxis<N>, u32),
    diagram: &Diagram<P>,
    apart: &[Option<bool>],
    (y, length): ((f64, f64), Length<'_, P>),
) -> Shape {
    let columns = axis.count.min(COLUMNS);
    // Values that share a column; their periods are counted together.
    let mut shares = vec![0_u32; columns];
    let mut counts = vec![[0u32; 2]; ROWS * columns];
    let row = |x: f64| (((x - y.0) / (y.1 - y.0) * ROWS as f64) as usize).min(ROWS - 1);
    (0..axis.count).for_each(|value| shares[value * columns / axis.count] += 1);
    for (direction, points) in [&diagram.up, &diagram.down].into_iter().enumerate() {
        for (value, point) in points.iter().enumerate() {
            if direction == 1 && apart[value] != Some(true) {
                continue;
            }
            let Some(p) = point else { continue };
            for (x, count) in p.maxima() {
                counts[row(length(p, *x)) * columns + value * columns / axis.count][direction] += count;
            }
        }
    }
    let class = |(place, [up, down]): (usize, [u32; 2])| {
        let kept = f64::from(kept) * f64::from(shares[place % columns]);
        let level = |count: u32| STEPS.iter().filter(|s| f64::from(count) > **s * kept).count() as u8;
        match (up, down) {
            (0, 0) => 0,
            (0, down) => 5 + u8::from(level(down) > 1),
            (up, _) => 1 + level(up),
        }
    };
    let mut colours = vec![None];
    colours.extend(SHADES.into_iter().chain(FALLING).map(Some));
    let (x, cells) = (axis.edges(), counts.into_iter().enumerate().map(class).collect());
    Shape::Cells { x, y, columns, cells, colours }
}

/// The layers of the maxima, named for the legend.
pub(super) fn shaded<N: AxisName, P: DiagramPoint>(
    axis: (&ParameterAxis<N>, u32),
    diagram: &Diagram<P>,
    apart: &[Option<bool>],
    lengths: ((f64, f64), Length<'_, P>),
) -> Vec<Layer> {
    vec![
        Layer::new("", BLACK, cells(axis, diagram, apart, lengths)),
        Layer::band("value rising", SHADES[3], 1.0, Vec::new()),
        Layer::band("value falling, where it ends elsewhere", FALLING[1], 1.0, Vec::new()),
    ]
}

/// The counts of contacts as level pieces, `width` for each value: no line joins different counts.
fn levels(points: impl Iterator<Item = Option<(f64, f64)>>, width: f64) -> Vec<Path> {
    let mut pieces: Vec<Path> = Vec::new();
    let mut before = None;
    for point in points {
        let count = point.map(|own| own.1);
        if let Some((value, count)) = point {
            let ends = [-0.5, 0.5].map(|part| (value + part * width, count));
            match pieces.last_mut().filter(|_| before == Some(count)) {
                Some(piece) => piece.extend(ends),
                None => pieces.push(ends.to_vec()),
            }
        }
        before = count;
    }
    pieces
}

/// The contacts per period if they are equal at all values in both directions.
pub(super) fn same_contacts<P: DiagramPoint>(diagram: &Diagram<P>) -> Option<f64> {
    let mut all = diagram.up.iter().chain(&diagram.down).flatten().map(DiagramPoint::contacts);
    let first = all.next()?;
    all.all(|count| count == first).then_some(first)
}

/// Panel of the impacts per period in both directions.
pub(super) fn contact_panel<N: AxisName, P: DiagramPoint>(
    title: &str,
    x: Axis,
    label: &str,
    (axis, diagram): (&ParameterAxis<N>, &Diagram<P>),
) -> Panel {
    let (from, to) = axis.edges();
    let width = (to - from) / axis.count as f64;
    let curve = |name, colour, points: &[Option<P>]| {
        let counts = points.iter().map(|own| own.as_ref().map(|own| (own.value(), own.contacts())));
        Layer::lines(name, colour, Dash::Solid, levels(counts, width))
    };
    Panel {
        title: title.into(),
        x,
        y: Axis::counts(label),
        layers: vec![
            curve("value falling", SKY, &diagram.down).stroke(WIDE),
            curve("value rising", BLACK, &diagram.up).stroke(THIN),
        ],
    }
}

/// Table of all maxima with their counts; `text` formats a maximum.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub(super) fn maxima_rows<P: DiagramPoint>(
    (name, maximum): (&str, &str),
    diagram: &Diagram<P>,
    text: &dyn Fn(f64) -> String,
) -> Result<Vec<u8>> {
    let mut csv = CsvRows::new([name, "direction", maximum, "count"])?;
    for (direction, points) in DIRECTIONS.into_iter().zip([&diagram.up, &diagram.down]) {
        for point in points.iter().flatten() {
            let value = exact(point.value());
            for (x, count) in point.maxima() {
                csv.push([&value, direction, &text(*x), &count.to_string()])?;
            }
        }
    }
    csv.text()
}

/// Table of the ranges of one class.
pub(super) fn window_table<P: DiagramPoint>(name: &str, diagram: &Diagram<P>) -> TextTable {
    let mut table = TextTable::new(&["direction", &format!("{name}_from"), &format!("{name}_to"), "class"]);
    for (direction, points) in DIRECTIONS.into_iter().zip([&diagram.up, &diagram.down]) {
        for Window { from, to, class } in Diagram::windows(points) {
            table.rows.push(vec![direction.into(), exact(from), exact(to), class.name()]);
        }
    }
    table
}

/// Whether the two directions settle on different motions at a value, in words.
pub(super) fn hysteresis(apart: Option<bool>) -> String {
    apart.map_or_else(|| "undecided".into(), |apart| apart.to_string())
}

/// Remarks on a diagram: ranges of one class in the rising direction, values at which the
/// directions differ, and missing values. If `apart` is `None`, there is one direction.
pub(super) fn remarks<P: DiagramPoint>(
    name: &str,
    diagram: &Diagram<P>,
    apart: Option<&[Option<bool>]>,
    told: &dyn Fn(f64) -> String,
) -> Vec<String> {
    let windows = Diagram::windows(&diagram.up);
    let window = |w: &Window| format!("{name} {} … {}: {}", told(w.from), told(w.to), w.class.name());
    let mut lines: Vec<String> = windows.iter().take(MAX_LISTED).map(window).collect();
    if windows.len() > MAX_LISTED {
        lines.push(format!("… and {} more windows in the table", windows.len() - MAX_LISTED));
    }
    if let Some(apart) = apart {
        let count = |sought: Option<bool>| apart.iter().filter(|apart| **apart == sought).count();
        let (elsewhere, undecided) = (count(Some(true)), count(None));
        let undecided =
            if undecided > 0 { format!("; undecided at {undecided} values") } else { String::new() };
        lines.push(format!(
            "{elsewhere} of {} values have another motion if the value falls{undecided}",
            apart.len()
        ));
    }
    let falling = diagram.down.iter().filter(|_| apart.is_some());
    let refused = diagram.up.iter().chain(falling).filter(|p| p.is_none()).count();
    if refused > 0 {
        lines.push(format!("{refused} values left out: the simulation failed"));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::levels;

    /// Two impacts, two, three, a value without a motion, and three.
    #[test]
    fn golden_no_line_joins_different_counts() {
        let counts = [Some((1.0, 2.0)), Some((2.0, 2.0)), Some((3.0, 3.0)), None, Some((5.0, 3.0))];
        let expected = [
            vec![(0.5, 2.0), (1.5, 2.0), (1.5, 2.0), (2.5, 2.0)],
            vec![(2.5, 3.0), (3.5, 3.0)],
            vec![(4.5, 3.0), (5.5, 3.0)],
        ];
        assert_eq!(levels(counts.into_iter(), 1.0), expected);
    }
}
