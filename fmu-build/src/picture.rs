//! The picture of a run: time histories and phase portraits.

use crate::canvas::colour::{BLACK, BLUE, GREEN, GREY, VERMILLION};
use crate::canvas::{Drawing, FONT};
use crate::run::{Run, Sample};
use plotters::coord::Shift;
use plotters::prelude::*;
use vibro_impact::simulator::Event;

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
    points: Vec<(f64, f64)>,
}

/// One of the four diagrams.
struct Diagram {
    title: String,
    x: &'static str,
    y: &'static str,
    curves: Vec<Curve>,
    x_range: Option<(f64, f64)>,
    legend: bool,
}

impl Drawing for Picture<'_> {
    const NAME: &'static str = "the picture of the run";
    const SIZE: (u32, u32) = (2400, 1700);

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), String> {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let (left, right) = area.split_horizontally(1380);
        let (upper, lower) = (left.split_evenly((2, 1)), right.split_evenly((2, 1)));
        let run = self.0;
        diagram(&upper[0], &history("(a) Transient", run, &run.samples, 0.0, TRANSIENT.min(run.periods)))?;
        let from = run.periods.saturating_sub(STEADY);
        let title = format!("(b) Periods {} to {}", from, run.periods);
        diagram(&upper[1], &history(&title, run, run.tail(STEADY), f64::from(from), run.periods))?;
        diagram(&lower[0], &relative(run))?;
        diagram(&lower[1], &portraits(run))
    }
}

/// The three bodies: names, colours, dashes.
fn bodies() -> [(&'static str, RGBColor, Option<(u32, u32)>); 3] {
    [("box x₁", BLUE, None), ("block x₂", VERMILLION, None), ("secondary x₃", GREEN, Some((22, 14)))]
}

fn history(title: &str, run: &Run, samples: &[Sample], from: f64, to: u32) -> Diagram {
    let period = run.parameters.period();
    let to = f64::from(to);
    let inside = |s: &&Sample| s.time / period <= to + 1e-9; // rounding of the last communication point
    let curves = bodies().into_iter().enumerate().map(|(body, (name, colour, dash))| Curve {
        name: name.into(),
        style: colour.stroke_width(LINE),
        dash,
        points: samples.iter().take_while(inside).map(|s| (s.time / period, s.state.x[body])).collect(),
    });
    Diagram {
        title: title.into(),
        x: "time t/T (–)",
        y: "displacement x (m)",
        curves: curves.collect(),
        x_range: Some((from, to)),
        legend: true,
    }
}

/// Relative displacement and velocity, with the points just before and after each impact, which fall between samples.
fn relative(run: &Run) -> Diagram {
    let tail = run.tail(STEADY);
    let begin = tail.first().map_or(0.0, |s| s.time);
    let gap = run.parameters.stop_gap;
    let mut points: Vec<(f64, (f64, f64))> =
        tail.iter().map(|s| (s.time, (s.state.x[1] - s.state.x[0], s.state.v[1] - s.state.v[0]))).collect();
    for event in &run.events {
        if let Event::Impact { time, side, speed, .. } = *event
            && time > begin
        {
            let side = f64::from(side);
            points.push((time, (side * gap, side * speed)));
            points.push((time, (side * gap, -side * speed * run.parameters.stop_restitution)));
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable: before comes before after
    let speed = points.iter().map(|(_, (_, v))| v.abs()).fold(0.0, f64::max);
    let stop = |side: f64| Curve {
        name: "stops ±L".into(),
        style: BLACK.stroke_width(LINE),
        dash: Some((14, 12)),
        points: vec![(side * gap, -1.08 * speed), (side * gap, 1.08 * speed)],
    };
    let orbit = Curve {
        name: "w = x₂ − x₁".into(),
        style: VERMILLION.stroke_width(LINE),
        dash: None,
        points: points.into_iter().map(|(_, point)| point).collect(),
    };
    Diagram {
        title: format!("(c) Block in the box, last {STEADY} periods"),
        x: "relative displacement w (m)",
        y: "relative velocity dw/dt (m/s)",
        curves: vec![stop(-1.0), stop(1.0), orbit],
        x_range: Some((-1.15 * gap, 1.15 * gap)),
        legend: true,
    }
}

fn portraits(run: &Run) -> Diagram {
    let curves = bodies().into_iter().enumerate().map(|(body, (name, colour, dash))| Curve {
        name: name.into(),
        style: colour.stroke_width(LINE),
        dash,
        points: run.tail(STEADY).iter().map(|s| (s.state.x[body], s.state.v[body])).collect(),
    });
    Diagram {
        title: format!("(d) Phase portraits, last {STEADY} periods"),
        x: "displacement x (m)",
        y: "velocity v (m/s)",
        curves: curves.collect(),
        x_range: None,
        legend: true,
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
    let points = || d.curves.iter().flat_map(|c| &c.points);
    let x = d.x_range.map_or_else(|| range(points().map(|p| p.0), 0.06, 0.06), |(low, high)| low..high);
    // Room for the legend above the curves.
    let y = range(points().map(|p| p.1), 0.06, if d.legend { 0.24 } else { 0.06 });
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
        let points = curve.points.iter().copied();
        match curve.dash {
            None => chart.draw_series(LineSeries::new(points, curve.style)).map_err(text)?,
            Some((dash, space)) => {
                chart.draw_series(DashedLineSeries::new(points, dash, space, curve.style)).map_err(text)?
            }
        };
    }
    if d.legend {
        legend(&chart, d, &x, &y)?;
    }
    Ok(())
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
    let width = (right - left) / names.len() as i32;
    let unit = (x.end - x.start) / f64::from(right - left);
    let (_, bottom) = area.map_coordinate(&(x.start, y.start));
    let rise = (y.end - y.start) / f64::from(bottom - top);
    for (i, curve) in names.into_iter().enumerate() {
        let begin = width * i as i32 + 24;
        let at = |dx: i32, dy: i32| (x.start + f64::from(dx) * unit, y.end - f64::from(dy) * rise);
        let piece = vec![at(begin, 44), at(begin + 84, 44)];
        match curve.dash {
            None => area.draw(&PathElement::new(piece, curve.style)).map_err(text)?,
            Some((dash, space)) => {
                for part in DashedLineSeries::new(piece.into_iter(), dash, space, curve.style) {
                    area.draw(&part).map_err(text)?;
                }
            }
        }
        let name = Text::new(curve.name.clone(), at(begin + 100, 22), (FONT, LABEL).into_font());
        area.draw(&name).map_err(text)?;
    }
    Ok(())
}
