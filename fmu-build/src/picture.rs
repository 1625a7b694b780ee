//! The picture of a run: time histories and phase portraits.

use crate::run::{Run, STEPS_PER_PERIOD};
use plotters::coord::Shift;
use plotters::prelude::*;
use vibro::figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, VERMILLION};
use vibro::figures::canvas::{Drawing, FONT};
use vibro_impact::State;

/// Periods of the first time history: the transient.
const TRANSIENT: u32 = 12;
/// Periods of the second time history, and of the phase portraits.
const STEADY: u32 = 3;
const LABEL: u32 = 42;
const TITLE: u32 = 46;
const LINE: u32 = 5;

/// The picture of a run.
pub struct Picture<'a>(pub &'a Run);

/// A curve with its name and style.
struct Curve {
    name: String,
    style: ShapeStyle,
    dash: Option<(u32, u32)>,
    pieces: Vec<Vec<(f64, f64)>>,
}

/// One of the four diagrams.
struct Diagram {
    title: String,
    x: &'static str,
    y: &'static str,
    curves: Vec<Curve>,
    x_range: Option<(f64, f64)>,
}

impl Drawing for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (2400, 1700)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), String> {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let (left, right) = area.split_horizontally(1320);
        let (upper, lower) = (left.split_evenly((2, 1)), right.split_evenly((2, 1)));
        let run = self.0;
        let transient = TRANSIENT.min(run.periods);
        diagram(&upper[0], &history("(a) Transient", run, 0, transient))?;
        let from = run.periods.saturating_sub(STEADY);
        let title = format!("(b) Periods {from} to {}", run.periods);
        diagram(&upper[1], &history(&title, run, from, run.periods))?;
        diagram(&lower[0], &relative(run))?;
        diagram(&lower[1], &portraits(run))
    }
}

/// Curves of the three bodies over some periods, each point made from time in periods, displacement and velocity.
fn bodies(
    run: &Run,
    from: u32,
    to: u32,
    names: [&str; 3],
    point: impl Fn(f64, f64, f64) -> (f64, f64),
) -> Vec<Curve> {
    let period = run.parameters.period();
    // Half a communication step of room for the rounding of communication points.
    let half = 0.5 / f64::from(STEPS_PER_PERIOD);
    let path = run.path((f64::from(from) - half) * period, (f64::from(to) + half) * period);
    let styles = [(BLUE, None), (VERMILLION, None), (GREEN, Some((22, 14)))];
    let curve = |(body, ((colour, dash), name)): (usize, ((RGBColor, _), &str))| {
        let at = |(time, state): &(f64, State)| point(time / period, state.x[body], state.v[body]);
        let cut = path.iter().map(|piece| piece.iter().map(at).collect());
        // Impacts do not touch the secondary oscillator; one piece keeps its dashes even.
        let pieces = if body == 2 { vec![path.iter().flatten().map(at).collect()] } else { cut.collect() };
        Curve { name: name.into(), style: colour.stroke_width(LINE), dash, pieces }
    };
    styles.into_iter().zip(names).enumerate().map(curve).collect()
}

fn history(title: &str, run: &Run, from: u32, to: u32) -> Diagram {
    Diagram {
        title: title.into(),
        x: "time t/T (–)",
        y: "displacement x (m)",
        curves: bodies(run, from, to, ["box x₁", "block x₂", "secondary x₃"], |t, x, _| (t, x)),
        x_range: Some((f64::from(from), f64::from(to))),
    }
}

/// Relative displacement and velocity; an impact is a jump along the stop.
fn relative(run: &Run) -> Diagram {
    let begin = run.tail(STEADY).first().map_or(0.0, |s| s.time);
    let gap = run.parameters.stop_gap;
    let at = |(_, s): (f64, State)| (s.x[1] - s.x[0], s.v[1] - s.v[0]);
    let points: Vec<_> = run.path(begin, f64::INFINITY).into_iter().flatten().map(at).collect();
    let speed = points.iter().map(|(_, v)| v.abs()).fold(0.0, f64::max);
    let stop = |side: f64| Curve {
        name: "stops ±L".into(),
        style: BLACK.stroke_width(LINE),
        dash: Some((14, 12)),
        pieces: vec![vec![(side * gap, -1.15 * speed), (side * gap, 1.15 * speed)]],
    };
    let orbit = Curve {
        name: "w = x₂ − x₁".into(),
        style: VERMILLION.stroke_width(LINE),
        dash: None,
        pieces: vec![points],
    };
    Diagram {
        title: format!("(c) Block in the box, last {STEADY} periods"),
        x: "relative displacement w (m)",
        y: "relative velocity dw/dt (m/s)",
        curves: vec![stop(-1.0), stop(1.0), orbit],
        x_range: Some((-1.15 * gap, 1.15 * gap)),
    }
}

fn portraits(run: &Run) -> Diagram {
    let from = run.periods.saturating_sub(STEADY);
    let mut curves = bodies(run, from, run.periods, ["box", "block", "secondary"], |_, x, v| (x, v));
    for curve in &mut curves {
        // Orbits that repeat would fill the dashes.
        curve.dash = None;
        let ends = |pair: &[Vec<(f64, f64)>]| Some(vec![*pair[0].last()?, *pair[1].first()?]);
        let jumps: Vec<_> = curve.pieces.windows(2).filter_map(ends).collect();
        curve.pieces.extend(jumps);
    }
    Diagram {
        title: format!("(d) Phase portraits, last {STEADY} periods"),
        x: "displacement x (m)",
        y: "velocity v (m/s)",
        curves,
        x_range: None,
    }
}

/// A range with some air around it.
fn range(values: impl Iterator<Item = f64>, below: f64, above: f64) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let span = (high - low).max(f64::MIN_POSITIVE);
    low - below * span..high + above * span
}

fn diagram<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, d: &Diagram) -> Result<(), String> {
    let text = |e: DrawingAreaErrorKind<DB::ErrorType>| e.to_string();
    let points = || d.curves.iter().flat_map(|c| c.pieces.iter().flatten());
    let x = d.x_range.map_or_else(|| range(points().map(|p| p.0), 0.06, 0.06), |(low, high)| low..high);
    // Room for the legend above the curves.
    let y = range(points().map(|p| p.1), 0.06, 0.24);
    let font = |size: u32| (FONT, size).into_font();
    let mut chart = ChartBuilder::on(area)
        .caption(&d.title, font(TITLE))
        .margin(24)
        .margin_right(48)
        .x_label_area_size(110)
        .y_label_area_size(150)
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(text)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GREY.mix(0.25))
        .axis_style(BLACK.stroke_width(2))
        .x_desc(d.x)
        .y_desc(d.y)
        .x_labels(7)
        .y_labels(7)
        .label_style(font(LABEL))
        .axis_desc_style(font(LABEL))
        .draw()
        .map_err(text)?;
    for curve in &d.curves {
        for piece in &curve.pieces {
            let points = piece.iter().copied();
            match curve.dash {
                None => chart.draw_series(LineSeries::new(points, curve.style)).map_err(text)?,
                Some((dash, space)) => chart
                    .draw_series(DashedLineSeries::new(points, dash, space, curve.style))
                    .map_err(text)?,
            };
        }
    }
    legend(&chart, d, &x, &y)
}

type Chart<'a, DB> = ChartContext<
    'a,
    DB,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// One line along the top of the diagram, with a piece of each curve before its name.
fn legend<DB: DrawingBackend>(
    chart: &Chart<'_, DB>,
    d: &Diagram,
    x: &std::ops::Range<f64>,
    y: &std::ops::Range<f64>,
) -> Result<(), String> {
    let area = chart.plotting_area();
    let text = |e: DrawingAreaErrorKind<DB::ErrorType>| e.to_string();
    let (left, top) = area.map_coordinate(&(x.start, y.end));
    let (right, _) = area.map_coordinate(&(x.end, y.end));
    let mut names: Vec<&Curve> = d.curves.iter().collect();
    names.dedup_by(|a, b| a.name == b.name);
    // Each name gets room by its length; seven letters are as long as the piece of curve before it.
    let letters = |curve: &Curve| curve.name.chars().count() as i32 + 7;
    let letter = (right - left) / names.iter().map(|c| letters(c)).sum::<i32>();
    let mut begin = 24;
    let unit = (x.end - x.start) / f64::from(right - left);
    let (_, bottom) = area.map_coordinate(&(x.start, y.start));
    let rise = (y.end - y.start) / f64::from(bottom - top);
    for curve in names {
        let at = |dx: i32, dy: i32| (x.start + f64::from(dx) * unit, y.end - f64::from(dy) * rise);
        let piece = vec![at(begin, 44), at(begin + 84, 44)];
        match curve.dash {
            None => area.draw(&PathElement::new(piece, curve.style)).map_err(text)?,
            Some((dash, space)) => {
                for part in DashedLineSeries::new(piece, dash, space, curve.style) {
                    area.draw(&part).map_err(text)?;
                }
            }
        }
        let name = Text::new(curve.name.clone(), at(begin + 100, 26), (FONT, LABEL).into_font());
        area.draw(&name).map_err(text)?;
        begin += letters(curve) * letter;
    }
    Ok(())
}
