//! Pictures and tables of simulated motion over a plane of two parameters, of either machine.

mod described;

use super::Study;
use super::design_sweep::Labelled;
use crate::Result;
use crate::table::{csv_in_groups, exact};
use crate::wording::with_capital;
use std::borrow::Cow;
use vibro_figures::canvas::palette::{BLACK, GREY};
use vibro_figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use vibro_studies::MotionClass;
use vibro_studies::isoperiodic::{Isoperiodic, IsoperiodicRequest, PlaneMachine};
use vibro_studies::{ParameterAxis, check_cells};

/// Motions without impacts.
const PALE: Colour = Colour(239, 239, 239);

/// Properties of a motion that pictures show.
#[derive(Clone, Copy, Debug)]
pub struct ClassifiedMotion {
    pub(super) class: MotionClass,
    /// Impacts, or impacts and first touches, per period.
    pub(super) contacts: f64,
    pub(super) rests: bool,
    /// Whether it is the motion of the closed forms: symmetric, with one impact at each stop per
    /// period.
    pub(super) is_two_impact: bool,
}

/// A machine whose planes have pictures and tables.
pub trait ShownPlane: PlaneMachine + Labelled {
    /// Name of motions of period one other than the motion of the closed forms.
    const ONE_PERIOD: &str;
    /// Title of the second panel, the panel of contacts.
    const CONTACTS: &str;
    /// Columns of the table after the columns of the parameters.
    const COLUMNS: &[&str];

    /// The motion at a point, if any.
    fn motion(point: &Self::Point) -> Option<ClassifiedMotion>;
    /// Cells of the [`COLUMNS`](Self::COLUMNS); empty without a motion.
    fn cells(point: &Self::Point) -> Vec<Cow<'static, str>>;
    /// Description of how exponents were computed, for captions.
    fn exponents_in_words(periods: u32) -> String;
    /// Layers over the colours: the machine's own values, limits.
    fn over(&self, request: &IsoperiodicRequest<Self>, plane: &Isoperiodic<Self::Point>) -> Vec<Layer>;
    /// Further panels.
    fn more(&self, request: &IsoperiodicRequest<Self>, plane: &Isoperiodic<Self::Point>) -> Vec<Panel>;
    /// Further remarks.
    fn remarks(plane: &Isoperiodic<Self::Point>) -> Vec<String>;
}

/// Entry of a legend: name, colour, and the motions that it covers unless an earlier entry covers
/// them.
type Entry<T> = (&'static str, Colour, fn(T) -> bool);

/// Placeholder for the entry of motions with one period, whose name is the machine's
/// [`ShownPlane::ONE_PERIOD`].
const ONE_PERIOD: &str = "1T";

/// Kinds of motion in the first panel; the last one takes all others. The colours have even steps
/// of lightness.
const KINDS: [Entry<ClassifiedMotion>; 11] = [
    ("without impacts", PALE, |m| m.contacts == 0.0 && !m.rests),
    ("1T, two symmetric impacts", Colour(16, 0, 128), |m| m.is_two_impact),
    (ONE_PERIOD, Colour(141, 185, 223), |m| m.class == MotionClass::Periodic(1)),
    ("2T", Colour(25, 105, 63), |m| m.class == MotionClass::Periodic(2)),
    ("3T", Colour(88, 25, 116), |m| m.class == MotionClass::Periodic(3)),
    ("4T", Colour(170, 76, 166), |m| m.class == MotionClass::Periodic(4)),
    ("longer periods", Colour(222, 135, 0), |m| matches!(m.class, MotionClass::Periodic(_))),
    ("periodic, settling", Colour(133, 133, 133), |m| m.class == MotionClass::Settling),
    ("quasi-periodic", Colour(226, 211, 26), |m| m.class == MotionClass::QuasiPeriodic),
    ("chaotic", BLACK, |m| m.class == MotionClass::Chaotic),
    ("not settled", Colour(149, 20, 0), |_| true),
];

/// Impacts per period in the second panel; darker colours mean more.
const IMPACTS: [Entry<f64>; 8] = [
    ("none", PALE, |n| n == 0.0),
    ("under 2", Colour(189, 223, 38), |n| n < 2.0),
    ("2", Colour(109, 205, 89), |n| n == 2.0),
    ("2 to 3", Colour(47, 180, 124), |n| n < 3.0),
    ("3", Colour(31, 152, 139), |n| n == 3.0),
    ("3 to 4", Colour(42, 120, 142), |n| n < 4.0),
    ("4", Colour(54, 92, 141), |n| n == 4.0),
    ("over 4", Colour(68, 1, 84), |_| true),
];

/// Largest size of a point in the table and in the codes of the two pictures, bytes: a row with
/// all digits has 167.
pub const POINT_IN_TABLE: usize = 180;

/// Largest number of classes listed on the screen.
const MAX_LISTED: usize = 8;

/// Checks that a plane and its table fit into memory.
///
/// # Errors
/// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
pub fn check_isoperiodic<M: ShownPlane>(request: &IsoperiodicRequest<M>) -> Result<()> {
    let held = size_of::<M::Point>() + POINT_IN_TABLE;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of motions.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn isoperiodic<M: ShownPlane>(
    machine: &M,
    request: &IsoperiodicRequest<M>,
    plane: &Isoperiodic<M::Point>,
    name: &str,
) -> Result<Study> {
    let names = [request.x.name.clone(), request.y.name.clone()];
    let pair = format!("({}, {})", machine.symbol(&names[0]), machine.symbol(&names[1]));
    let words = names.each_ref().map(|name| machine.parameter_words(name)).join(", ");
    let (table, panels) = rayon::join(|| csv(request, plane), || panels(machine, request, plane));
    let figure = Figure {
        title: with_capital(&format!("{}simulated motion over {words}", machine.title())),
        caption: vec![method(request), format!("Elsewhere {}", machine.caption_but(&names))],
        panels,
        columns: 2,
        panel: (1700, 1400),
        shared_legend: true,
    };
    let what = format!("simulated motion over {pair}: period, impacts and class");
    Ok(Study {
        tables: vec![(name.into(), table?)],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks::<M>(plane))
    })
}

/// Description of how the motions were computed, for captions.
fn method<M: ShownPlane>(request: &IsoperiodicRequest<M>) -> String {
    let mut method = format!(
        "{} × {} motions, start {}; {} periods discarded.",
        request.x.count, request.y.count, request.start, request.discard
    );
    if let Some(periods) = request.exponents {
        method.push_str(&M::exponents_in_words(periods));
    }
    method
}

/// Panels of classes and of impacts per period, followed by the machine's own panels.
fn panels<M: ShownPlane>(
    machine: &M,
    request: &IsoperiodicRequest<M>,
    plane: &Isoperiodic<M::Point>,
) -> Vec<Panel> {
    let over = machine.over(request, plane);
    // The last entry of either list takes every motion, so there is always a code.
    let kind = |m: ClassifiedMotion| KINDS.iter().take_while(|k| !k.2(m)).count();
    let impacts = |m: ClassifiedMotion| IMPACTS.iter().take_while(|k| !k.2(m.contacts)).count();
    let kinds = KINDS.iter().map(|k| (if k.0 == ONE_PERIOD { M::ONE_PERIOD } else { k.0 }, k.1));
    let counts = IMPACTS.iter().map(|k| (k.0, k.1));
    let title = format!("(b) {}", M::CONTACTS);
    let mut panels = vec![
        coloured((machine, request, plane), "(a) Class of the motion", kinds.collect(), &kind, &over),
        coloured((machine, request, plane), &title, counts.collect(), &impacts, &over),
    ];
    panels.extend(machine.more(request, plane));
    panels
}

/// The axis of a plane's parameter.
fn plane_axis<M: Labelled>(machine: &M, axis: &ParameterAxis<M::Name>) -> Axis {
    Axis { range: Some(axis.edges()), ..machine.axis(&axis.name) }
}

/// A panel whose cells have the colour of the entry given by `code`. Points without a motion stay
/// white. The entries' names begin with the panel's letter.
fn coloured<M: ShownPlane>(
    (machine, request, plane): (&M, &IsoperiodicRequest<M>, &Isoperiodic<M::Point>),
    title: &str,
    entries: Vec<(&str, Colour)>,
    code: &dyn Fn(ClassifiedMotion) -> usize,
    over: &[Layer],
) -> Panel {
    let (x, y) = (&request.x, &request.y);
    let cells: Vec<u8> = plane.points.iter().map(|p| M::motion(p).map_or(0, |m| 1 + code(m) as u8)).collect();
    let colours = std::iter::once(None).chain(entries.iter().map(|e| Some(e.1))).collect();
    let letter = title.split(' ').next().unwrap_or_default();
    let met = entries.iter().zip(1..).filter(|(_, code)| cells.contains(code));
    let entry = |((name, colour), _): (&(&str, Colour), u8)| {
        Layer::band(&format!("{letter} {name}"), *colour, 1.0, Vec::new())
    };
    let mut layers: Vec<Layer> = met.map(entry).collect();
    let shape = Shape::Cells { x: x.edges(), y: y.edges(), columns: x.count, cells, colours };
    layers.insert(0, Layer::new("", GREY, shape));
    layers.extend(over.iter().cloned());
    Panel { title: title.into(), x: plane_axis(machine, x), y: plane_axis(machine, y), layers }
}

fn csv<M: ShownPlane>(request: &IsoperiodicRequest<M>, plane: &Isoperiodic<M::Point>) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let names = [M::name(&x.name), M::name(&y.name)];
    let header: Vec<&str> = names.iter().map(String::as_str).chain(M::COLUMNS.iter().copied()).collect();
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&plane.points[j * x.count..]).try_for_each(|(x, point)| {
            let cells = M::cells(point);
            let own = [x.as_str(), &value].into_iter().chain(cells.iter().map(|cell| &**cell));
            rows.push(own.map(str::as_bytes))
        })
    })
}

/// Cell of a number.
pub(super) fn number(value: f64) -> Cow<'static, str> {
    Cow::Owned(exact(value))
}

/// Cell of a truth value.
pub(super) fn word(holds: bool) -> Cow<'static, str> {
    Cow::Borrowed(if holds { "true" } else { "false" })
}

/// A part of a whole in percent.
pub(super) fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

fn remarks<M: ShownPlane>(plane: &Isoperiodic<M::Point>) -> Vec<String> {
    let motions = || plane.points.iter().filter_map(M::motion);
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
        .take(MAX_LISTED)
        .map(|(n, c)| format!("{n} {:.1} %", percent(*c, plane.points.len())))
        .collect();
    let mut lines =
        vec![format!("{}{}", told.join(", "), if classes.len() > MAX_LISTED { ", others less" } else { "" })];
    lines.extend(M::remarks(plane));
    let refused = plane.points.len() - motions().count();
    if refused > 0 {
        lines.push(format!(
            "{refused} points left out: the parameters are not valid there, or the simulation failed"
        ));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::apart::{DISTANCE, apart};

    #[test]
    fn invariant_colours_of_a_plane_are_told_apart_in_grey_and_with_any_vision() {
        /// Ratio of two luminances that grey prints show: eleven equal steps from black to white
        /// have 1.32.
        const STEP: f64 = 1.3;
        let kinds = KINDS.map(|kind| kind.1);
        for colours in [&kinds[..], &IMPACTS.map(|entry| entry.1)] {
            let (step, distance) = apart(colours);
            assert!(step > STEP && distance > DISTANCE, "{step} {distance}");
        }
    }
}
