//! The picture of a run: histories with impacts marked, the phase portrait between the stops, impact speeds, loads.

use super::history::{History, RunImpact, RunInstant};
use super::short;
use crate::figures::canvas::palette::{BLACK, BLOCK, BOX, GREY, RELATIVE, SECONDARY};
use crate::figures::chart::{Axis, Colour, Dash, Figure, Layer, Mark, Panel, Path, THIN};
use crate::studies::PANEL;
use crate::studies::lengths::LengthUnit;
use vibro_analysis::ParameterSet;
use vibro_impact::load::Load;

/// Drive periods shown of a run without loads; of one with loads all is shown.
const SHOWN: f64 = 20.0;
/// Most columns into which a curve is thinned; a panel has fewer pixels.
const COLUMNS: usize = 1500;
/// Most instants of a portrait.
const PORTRAIT: usize = 12_000;
/// Most marks of a panel.
const MARKS: usize = 4000;
/// Half the size of the marks of impacts.
const SMALL: u32 = 8;
const COLOURS: [Colour; 3] = [BOX, BLOCK, SECONDARY];

/// What is shown of a run.
struct Shown<'a> {
    history: &'a History,
    unit: LengthUnit,
    gap: f64,
    from: f64,
}

/// A curve with, in each of many columns, its first, lowest, highest and last point only: it looks the same.
fn thinned(path: Path) -> Path {
    let (Some(first), Some(last)) = (path.first(), path.last()) else { return path };
    if path.len() <= 4 * COLUMNS {
        return path;
    }
    let (from, width) = (first.0, (last.0 - first.0) / COLUMNS as f64);
    let column = |p: &(f64, f64)| ((p.0 - from) / width) as usize;
    let mut found = Path::new();
    for points in path.chunk_by(|a, b| column(a) == column(b)) {
        let by = |extreme: fn(f64, f64) -> bool| {
            (1..points.len()).fold(0, |best, i| if extreme(points[i].1, points[best].1) { i } else { best })
        };
        let mut kept = [0, by(|a, b| a < b), by(|a, b| a > b), points.len() - 1];
        kept.sort_unstable();
        found.extend(kept.map(|i| points[i]));
    }
    found.dedup();
    found
}

impl Shown<'_> {
    fn end(&self) -> f64 {
        self.history.duration
    }

    fn instants(&self) -> impl Iterator<Item = &RunInstant> {
        self.history.instants().filter(|i| i.time >= self.from)
    }

    fn time(&self) -> Axis {
        Axis::over("time (s)", self.from, self.end())
    }

    /// Curve of a displacement over time.
    fn curve(&self, index: usize) -> Path {
        thinned(self.instants().map(|i| (i.time, self.unit.per_metre * i.x[index])).collect())
    }

    /// The last impacts as points.
    fn impacts(&self, y: impl Fn(&RunImpact) -> Option<f64>) -> Path {
        let shown = self.history.impacts.iter().rev().filter(|i| i.time >= self.from);
        shown.filter_map(|i| Some((i.time, y(i)?))).take(MARKS).collect()
    }

    fn displacements(&self) -> Panel {
        let curve =
            |(i, name)| Layer::line("", COLOURS[i], Dash::Solid, self.curve(i)).stroke(THIN).labelled(name);
        Panel {
            title: "(a) Box, block and secondary oscillator".into(),
            x: self.time(),
            y: Axis::new(format!("displacement ({})", self.unit.symbol)),
            layers: ["x₁, box", "x₂, block", "x₃, secondary"].into_iter().enumerate().map(curve).collect(),
        }
    }

    fn relative(&self) -> Panel {
        let stop = self.unit.per_metre * self.gap;
        let line = |y: f64| vec![(self.from, y), (self.end(), y)];
        let marks = self.impacts(|i| Some(f64::from(i.side) * stop));
        Panel {
            title: "(b) Block in the box, w = x₂ − x₁, with its impacts; dashed: stops".into(),
            x: self.time(),
            y: Axis::over(format!("w ({})", self.unit.symbol), -1.15 * stop, 1.15 * stop),
            layers: vec![
                Layer::lines("", GREY, Dash::Dashed, vec![line(stop), line(-stop)]).stroke(THIN),
                Layer::line("w", RELATIVE, Dash::Solid, self.curve(3)).stroke(THIN),
                Layer::marks("impact", BLACK, Mark::Disc, marks).stroke(SMALL),
            ],
        }
    }

    fn portrait(&self) -> Panel {
        let (stop, scale) = (self.unit.per_metre * self.gap, self.unit.per_metre);
        let mut count = 0;
        let mut pieces: Vec<Path> = Vec::new();
        for piece in self.history.pieces.iter().rev() {
            let path: Path = piece
                .iter()
                .filter(|i| i.time >= self.from)
                .map(|i| (scale * i.x[3], scale * i.v[3]))
                .collect();
            count += path.len();
            pieces.push(path);
            if count > PORTRAIT {
                break;
            }
        }
        let top = pieces.iter().flatten().map(|p| p.1.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let line = |x: f64| vec![(x, -1.1 * top), (x, 1.1 * top)];
        Panel {
            title: "(c) Phase portrait between the stops (dashed)".into(),
            x: Axis::over(format!("w ({})", self.unit.symbol), -1.15 * stop, 1.15 * stop),
            y: Axis::over(format!("dw/dt ({}/s)", self.unit.symbol), -1.1 * top, 1.1 * top),
            layers: vec![
                Layer::lines("", GREY, Dash::Dashed, vec![line(stop), line(-stop)]).stroke(THIN),
                Layer::lines("", RELATIVE, Dash::Solid, pieces).stroke(2).labelled("w"),
            ],
        }
    }

    fn speeds(&self) -> Panel {
        let of = |side: i8| self.impacts(move |i| (i.side == side).then_some(self.unit.per_metre * i.speed));
        let (upper, lower) = (of(1), of(-1));
        let top = upper.iter().chain(&lower).map(|p| p.1).fold(0.0, f64::max);
        let top = if top > 0.0 { 1.1 * top } else { 1.0 };
        Panel {
            title: if self.history.impacts.is_empty() { "(d) No impacts" } else { "(d) Impact speeds" }
                .into(),
            x: self.time(),
            y: Axis::over(format!("speed ({}/s)", self.unit.symbol), 0.0, top),
            layers: vec![
                Layer::marks("upper stop", BLACK, Mark::Triangle, upper),
                Layer::marks("lower stop", GREY, Mark::Ring, lower),
            ],
        }
    }

    fn loads(&self, loads: &[Load]) -> Panel {
        let curve = |load: &Load| {
            let points = self.history.instants().map(|i| (i.time, load.force(i.time))).collect();
            let name = format!("on {}", load.body().name());
            Layer::line("", COLOURS[load.body() as usize], Dash::Solid, thinned(points))
                .stroke(THIN)
                .labelled(name)
        };
        Panel {
            title: "(e) Loads".into(),
            x: self.time(),
            y: Axis::new("force (N)"),
            layers: loads.iter().map(curve).collect(),
        }
    }
}

/// The figure of a run.
pub(super) fn figure(set: &ParameterSet, history: &History, loads: &[Load], beginning: String) -> Figure {
    let p = set.parameters();
    let all = !loads.is_empty() || history.duration <= SHOWN * p.period();
    let from = if all { 0.0 } else { history.duration - SHOWN * p.period() };
    let shown = Shown { history, unit: LengthUnit::of(set), gap: p.stop_gap, from };
    let mut panels = vec![shown.displacements(), shown.relative(), shown.portrait(), shown.speeds()];
    if !loads.is_empty() {
        panels.push(shown.loads(loads));
    }
    let mut caption = vec![format!("Run: {beginning}.")];
    if !all {
        caption.push(format!(
            "The last {SHOWN} drive periods of {} are shown.",
            short(history.duration / p.period())
        ));
    }
    caption.push(set.caption());
    Figure {
        title: "A motion of the machine".into(),
        caption,
        panels,
        columns: 2,
        panel: PANEL,
        shared_legend: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_a_thinned_curve_keeps_its_ends_and_extremes() {
        let path: Path = (0..100_000).map(|i| (f64::from(i), (f64::from(i) * 0.37).sin())).collect();
        let thin = thinned(path.clone());
        assert!(thin.len() <= 4 * COLUMNS + 4 && thin.is_sorted_by(|a, b| a.0 < b.0));
        let extremes = |p: &Path| p.iter().fold((1.0f64, -1.0f64), |(a, b), x| (a.min(x.1), b.max(x.1)));
        assert_eq!((extremes(&thin), thin[0]), (extremes(&path), path[0]));
        assert_eq!(thin.last(), path.last());
        assert_eq!(thinned(path[..50].to_vec()), path[..50]);
    }
}
