//! Pictures and tables of simulated motion over a plane of two groups.

use super::Study;
use crate::Result;
use crate::table::{csv_in_groups, exact};
use std::borrow::Cow;
use vibro_analysis::ParameterSet;
use vibro_analysis::attractor::MotionClass;
use vibro_analysis::isoperiodic::{Agreement, Isoperiodic, PlanePoint, Request, SettledMotion};
use vibro_analysis::plane::{SteadyStateClass, check_cells};
use vibro_figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, HERE, ORANGE, PURPLE, SKY, VERMILLION};
use vibro_figures::chart::{Colour, Dash, Figure, LINE, Layer, Panel, Path, Shape, THIN};

const PALE: Colour = Colour(228, 228, 228);
const YELLOW: Colour = Colour(240, 228, 66);
const MINT: Colour = Colour(150, 220, 190);

/// An entry of a legend and what it stands for.
type Entry<T> = (&'static str, Colour, fn(T) -> bool);

/// Kinds of motion as the first panel tells them apart; the last takes what no other does.
const KINDS: [Entry<SettledMotion>; 11] = [
    ("(a) without impacts", PALE, |m| m.impacts == [0.0; 2] && !m.rests),
    ("(a) 1T, two symmetric impacts", BLUE, |m| m.is_two_impact()),
    ("(a) 1T, others", SKY, |m| m.class == MotionClass::Periodic(1)),
    ("(a) 2T", GREEN, |m| m.class == MotionClass::Periodic(2)),
    ("(a) 3T", PURPLE, |m| m.class == MotionClass::Periodic(3)),
    ("(a) 4T", MINT, |m| m.class == MotionClass::Periodic(4)),
    ("(a) longer periods", ORANGE, |m| matches!(m.class, MotionClass::Periodic(_))),
    ("(a) periodic, settling", GREY, |m| m.class == MotionClass::Settling),
    ("(a) quasi-periodic", YELLOW, |m| m.class == MotionClass::QuasiPeriodic),
    ("(a) chaotic", BLACK, |m| m.class == MotionClass::Chaotic),
    ("(a) not settled", VERMILLION, |_| true),
];

/// Impacts per drive period, dark where there are many, as the second panel tells them apart.
const IMPACTS: [Entry<f64>; 8] = [
    ("(b) none", PALE, |n| n == 0.0),
    ("(b) under 2", Colour(253, 231, 37), |n| n < 2.0),
    ("(b) 2", Colour(160, 218, 57), |n| n == 2.0),
    ("(b) 2 to 3", Colour(74, 193, 109), |n| n < 3.0),
    ("(b) 3", Colour(31, 161, 135), |n| n == 3.0),
    ("(b) 3 to 4", Colour(39, 127, 142), |n| n < 4.0),
    ("(b) 4", Colour(54, 92, 141), |n| n == 4.0),
    ("(b) over 4", Colour(68, 1, 84), |_| true),
];

/// The most that a point takes in the table and in the codes of the two pictures, bytes: a row with all numbers in full has 167.
pub const POINT_IN_TABLE: usize = 180;

/// Most classes listed on the screen.
const TOLD: usize = 8;

/// Checks that a plane fits into memory with its table, before it is computed.
///
/// # Errors
/// [`TooMany`](vibro_analysis::Error::TooMany), with the number that would fit.
pub fn check_isoperiodic(request: &Request) -> Result<()> {
    let held = size_of::<PlanePoint>() + POINT_IN_TABLE;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of motions.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn isoperiodic(set: &ParameterSet, request: &Request, plane: &Isoperiodic, name: &str) -> Result<Study> {
    let pair = format!("({}, {})", set.symbol(request.x.name), set.symbol(request.y.name));
    let (table, panels) = rayon::join(|| csv(request, plane), || panels(set, request, plane));
    let figure = Figure {
        title: format!("Simulated motion over {pair}"),
        caption: vec![
            method(request),
            format!("Elsewhere {}", set.caption_but(&[request.x.name, request.y.name])),
        ],
        panels,
        columns: 2,
        panel: (1700, 1400),
        shared_legend: true,
    };
    let what = format!("simulated motion over {pair}: period, impacts and class");
    Ok(Study {
        tables: vec![(name.into(), table?)],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks(plane))
    })
}

/// How the motions were computed, for the caption.
fn method(request: &Request) -> String {
    let mut method = format!(
        "{} × {} motions from {}; {} periods discarded.",
        request.x.count, request.y.count, request.start, request.discard
    );
    if let Some(periods) = &request.exponents {
        method.push_str(&format!(
            " Exponents where there are impacts and no period, over at most {periods} periods."
        ));
    }
    method
}

/// The classes, and the impacts per period.
fn panels(set: &ParameterSet, request: &Request, plane: &Isoperiodic) -> Vec<Panel> {
    let panel = PanelOver { set, request, plane, border: border(request, plane) };
    // The last entry of either list takes every motion, so that a code is always found.
    let kind = |m: &SettledMotion| KINDS.iter().take_while(|k| !k.2(*m)).count();
    let impacts = |m: &SettledMotion| {
        let all = m.impacts[0] + m.impacts[1];
        IMPACTS.iter().take_while(|k| !k.2(all)).count()
    };
    vec![
        panel.of("(a) Class of the motion", KINDS.iter().map(|k| (k.0, k.1)), kind),
        panel.of("(b) Impacts per drive period", IMPACTS.iter().map(|k| (k.0, k.1)), impacts),
    ]
}

/// What the panels have in common.
struct PanelOver<'a> {
    set: &'a ParameterSet,
    request: &'a Request,
    plane: &'a Isoperiodic,
    border: Vec<Path>,
}

impl PanelOver<'_> {
    /// A panel whose cells have the colour of the entry that `code` gives; points the simulator refused are left white.
    fn of<'e>(
        &self,
        title: &str,
        entries: impl Iterator<Item = (&'e str, Colour)> + Clone,
        code: impl Fn(&SettledMotion) -> usize,
    ) -> Panel {
        let (x, y) = (&self.request.x, &self.request.y);
        let points = &self.plane.points;
        let cells: Vec<u8> = points.iter().map(|p| p.motion.map_or(0, |m| 1 + code(&m) as u8)).collect();
        let colours = std::iter::once(None).chain(entries.clone().map(|e| Some(e.1))).collect();
        let met = entries.zip(1..).filter(|(_, code)| cells.contains(code));
        let mut layers: Vec<Layer> = met.map(|((n, c), _)| Layer::band(n, c, 1.0, Vec::new())).collect();
        let shape = Shape::Cells { x: x.edges(), y: y.edges(), columns: x.count, cells, colours };
        layers.insert(0, Layer::new("", GREY, shape));
        let edge = |name, colour| Layer::lines(name, colour, Dash::Solid, self.border.clone());
        layers.push(edge("", Colour(255, 255, 255)).stroke(LINE + 2 * THIN));
        layers.push(edge("limit of the stable exact orbit", HERE));
        layers.extend(super::here(self.set, x.name, y.name));
        Panel {
            title: title.into(),
            x: super::parameter_axis(self.set, x.name, x.edges()),
            y: super::parameter_axis(self.set, y.name, y.edges()),
            layers,
        }
    }
}

/// The limit of the points where the exact orbit is stable, along the edges of their cells.
fn border(request: &Request, plane: &Isoperiodic) -> Vec<Path> {
    let (columns, rows) = (request.x.count, request.y.count);
    let stable = |i: usize, j: usize| plane.points[j * columns + i].theory == SteadyStateClass::Stable;
    let part = |(from, to): (f64, f64), i: usize, count: usize| from + (to - from) * i as f64 / count as f64;
    let at = |i: usize, j: usize| (part(request.x.edges(), i, columns), part(request.y.edges(), j, rows));
    let across = (1..rows).flat_map(|j| {
        let edges = (0..columns).filter(move |&i| stable(i, j - 1) != stable(i, j));
        edges.map(move |i| vec![at(i, j), at(i + 1, j)])
    });
    let up = (1..columns).flat_map(|i| {
        let edges = (0..rows).filter(move |&j| stable(i - 1, j) != stable(i, j));
        edges.map(move |j| vec![at(i, j), at(i, j + 1)])
    });
    across.chain(up).collect()
}

fn csv(request: &Request, plane: &Isoperiodic) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let header = [
        x.name.name(),
        y.name.name(),
        "class",
        "impacts_upper",
        "impacts_lower",
        "rests",
        "symmetric",
        "lambda1",
        "lambda1_error",
        "exact_orbit",
        "on_exact_orbit",
    ];
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&plane.points[j * x.count..]).try_for_each(|(x, point)| {
            let cells = cells(x, &value, point);
            rows.push(cells.iter().map(|cell| cell.as_bytes()))
        })
    })
}

/// The cells of a point's row; those of its motion are empty where the simulator refused it.
fn cells<'a>(x: &'a str, y: &'a str, point: &PlanePoint) -> [Cow<'a, str>; 11] {
    const EMPTY: Cow<str> = Cow::Borrowed("");
    let (x, y, theory) = (x.into(), y.into(), point.theory.name().into());
    let Some(m) = &point.motion else {
        return [x, y, "refused".into(), EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, theory, EMPTY];
    };
    let number = |value: f64| Cow::Owned(exact(value));
    let word = |holds: bool| Cow::Borrowed(if holds { "true" } else { "false" });
    let [upper, lower] = m.impacts.map(number);
    let [lambda, error] = m.exponent.map_or([EMPTY; 2], |e| e.map(number));
    let class = m.class.name().into();
    [x, y, class, upper, lower, word(m.rests), word(m.symmetric), lambda, error, theory, word(m.on_orbit)]
}

fn remarks(plane: &Isoperiodic) -> Vec<String> {
    let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
    let motions = || plane.points.iter().filter_map(|p| p.motion);
    let mut counts: Vec<(MotionClass, usize)> = Vec::new();
    for class in motions().map(|m| m.class) {
        match counts.iter_mut().find(|c| c.0 == class) {
            Some(count) => count.1 += 1,
            None => counts.push((class, 1)),
        }
    }
    let mut classes: Vec<(String, usize)> = counts.into_iter().map(|(c, count)| (c.name(), count)).collect();
    classes.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let told: Vec<String> = classes
        .iter()
        .take(TOLD)
        .map(|(n, c)| format!("{n} {:.1} %", percent(*c, plane.points.len())))
        .collect();
    let Agreement { stable, reached, two_impact, predicted } = plane.agreement();
    let mut lines = vec![
        format!("{}{}", told.join(", "), if classes.len() > TOLD { ", others less" } else { "" }),
        format!(
            "the exact orbit is stable at {stable} points; at {reached} of them ({:.1} %) the motion settles on it",
            percent(reached, stable)
        ),
        format!(
            "{two_impact} motions are symmetric with two impacts a period and without rest; {predicted} of them ({:.1} %) are the stable exact orbit",
            percent(predicted, two_impact)
        ),
    ];
    let resting = motions().filter(|m| m.rests).count();
    if resting > 0 {
        lines.push(format!("in {resting} motions the block rests at a stop"));
    }
    let refused = plane.points.len() - motions().count();
    if refused > 0 {
        lines.push(format!("{refused} points left out: there is no such system, or the simulator refused"));
    }
    lines
}
