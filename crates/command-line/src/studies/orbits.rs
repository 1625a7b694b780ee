//! Periodic orbits of described machines: one orbit, and branches over a parameter.

use super::Study;
use super::design_sweep::Labelled;
use super::paper::orbits::{DrawnBranch, MARKS, branch_layers};
use crate::Result;
use crate::table::{CsvRows, exact};
use rayon::prelude::*;
use std::collections::BTreeMap;
use vibro_figures::canvas::palette::{BLACK, FAMILY, GREY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path};
use vibro_machine::motion::EventKind;
use vibro_machine::{Motion, What};
use vibro_orbits::{Branch, Family, Kind, LocusStart, Orbit, OrbitPoint, Stability, check_measure};
use vibro_studies::significant;
use vibro_studies::{Machine, Measure, QuantityName, columns, named};

/// Special points beyond which the picture marks only those where stability changes.
const MARKED: usize = 150;
/// Lengths below this, m, are shown in mm, angles, rad, in mrad.
const SMALL: f64 = 0.1;
/// Samples of a period in pictures.
const SAMPLES: u32 = 800;

/// Marks of the special points that the 3-DOF machine does not have.
const FURTHER: [(Kind, &str, Mark); 3] = [
    (Kind::Stick, "ST stick", Mark::Diamond),
    (Kind::Crossing, "CC events change places", Mark::Frame),
    (Kind::Saturation, "SA limit of an output", Mark::Funnel),
];

/// The study of a machine's branches over a parameter: tables of points and special points, and a
/// picture of a measure.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output); an error if the machine does not have the measure.
pub fn assembly_orbits(
    machine: &Machine,
    family: &Family,
    branches: &[Branch],
    measure: &Measure,
    name: &str,
) -> Result<Study> {
    check_measure(measure, &machine.description)?;
    study_of(machine, family, branches, (measure, &measured(branches, measure)), name)
}

/// A measure of each orbit of branches; NaN where it has none.
pub(super) fn measured(branches: &[Branch], measure: &Measure) -> Vec<Vec<f64>> {
    let value = |branch: &Branch, point: &OrbitPoint| {
        branch.orbit(point).and_then(|orbit| orbit.measure(measure).ok()).unwrap_or(f64::NAN)
    };
    branches.par_iter().map(|b| b.points.iter().map(|p| value(b, p)).collect()).collect()
}

/// Number of units in one of SI in which a picture shows values, and their symbol.
pub(super) fn shown_unit(unit: &str, largest: f64) -> (f64, String) {
    match unit {
        "m" if largest < SMALL => (1e3, "mm".to_owned()),
        "rad" if largest < SMALL => (1e3, "mrad".to_owned()),
        unit => (1.0, unit.replace('.', "·").replace("s2", "s²")),
    }
}

/// Axis of a quantity whose values are up to `largest` in size, SI.
pub(super) fn shown_axis(name: &str, unit: &str, largest: f64) -> Axis {
    let (factor, symbol) = shown_unit(unit, largest);
    let label = if symbol == "1" { name.to_owned() } else { format!("{name} ({symbol})") };
    Axis::new(label).times(factor)
}

/// As [`assembly_orbits`], with the measure's values.
pub(super) fn study_of(
    machine: &Machine,
    family: &Family,
    branches: &[Branch],
    (measure, tops): (&Measure, &[Vec<f64>]),
    name: &str,
) -> Result<Study> {
    let parameter = &family.parameter;
    let unit = measure.unit(&machine.description);
    let largest = tops.iter().flatten().copied().filter(|x| x.is_finite()).map(f64::abs).fold(0.0, f64::max);
    let marks = marks(branches, tops);
    let mut caption = vec!["Full: stable; dashed: unstable. One colour for each period.".to_owned()];
    if marks.of_stable_only {
        caption.push("Marks: where stability changes; special-points.csv has the others.".into());
    }
    caption.push(format!("Elsewhere {}", machine.caption_but(std::slice::from_ref(parameter))));
    let panel = Panel {
        title: String::new(),
        x: Axis { range: Some(family.range), ..machine.axis(parameter) },
        y: shown_axis(&measure.to_string(), unit, largest),
        layers: layers(branches, tops, marks),
    };
    let figure = Figure {
        title: format!("{}: periodic orbits over {parameter}", machine.description.name),
        caption,
        panels: vec![panel],
        columns: 1,
        panel: (2900, 1700),
        shared_legend: false,
    };
    let what = format!("{} branches of periodic orbits over {parameter}", branches.len());
    Ok(Study {
        tables: vec![
            ("branches".into(), branch_table(family, branches, (measure, tops))?),
            ("special-points".into(), special_table(family, branches)?),
        ],
        figure: Some(figure),
        subject: machine.caption_of_all(std::slice::from_ref(parameter)),
        ..Study::without_figure(name, what).with_remarks(remarks(branches))
    })
}

fn remarks(branches: &[Branch]) -> Vec<String> {
    let mut labels: BTreeMap<&str, usize> = BTreeMap::new();
    let points = || branches.iter().flat_map(|b| &b.points);
    for special in points().filter_map(|p| p.special.as_ref()) {
        *labels.entry(special.kind.name()).or_default() += 1;
    }
    let counts: Vec<String> = labels.iter().map(|(label, count)| format!("{count} {label}")).collect();
    let is_stable = |b: &&Branch| b.points.iter().any(|p| p.stability == Stability::Stable);
    let stable = branches.iter().filter(is_stable).count();
    vec![
        format!("{} orbits; {stable} branches are stable somewhere", points().count()),
        format!("{} special points: {}", labels.values().sum::<usize>(), counts.join(", ")),
    ]
}

fn cell(value: f64) -> String {
    if value.is_finite() { exact(value) } else { String::new() }
}

/// The events of a branch in words.
pub(super) fn words(family: &Family, branch: &Branch) -> String {
    let place = family.place(branch.points[0].value);
    place.map_or_else(|_| String::new(), |place| branch.word().in_words(&place.assembly))
}

fn branch_table(
    family: &Family,
    branches: &[Branch],
    (measure, tops): (&Measure, &[Vec<f64>]),
) -> Result<Vec<u8>> {
    let most = branches.iter().flat_map(|b| &b.points).map(|p| p.multipliers.len()).max().unwrap_or(0);
    let mut header: Vec<String> =
        ["branch", "parent", "point", "label"].into_iter().map(str::to_owned).collect();
    header.extend([family.parameter.clone(), "period".into(), "periods".into(), "stability".into()]);
    header.extend([measure.to_string(), "word".into()]);
    header.extend((1..=most).flat_map(|k| [format!("mu{k}_re"), format!("mu{k}_im")]));
    let mut table = CsvRows::new(&header)?;
    for (branch, tops) in branches.iter().zip(tops) {
        let parent = branch.parent.map_or(String::new(), |(id, point)| format!("{id}:{point}"));
        let word = words(family, branch);
        for (i, (point, top)) in branch.points.iter().zip(tops).enumerate() {
            let label = point.special.as_ref().map_or("", |s| s.kind.name());
            let mut row = vec![branch.id.to_string(), parent.clone(), i.to_string(), label.into()];
            row.extend([exact(point.value), exact(point.period)]);
            row.push(branch.word().periods.map_or(String::new(), |n| n.to_string()));
            row.extend([point.stability.to_string(), cell(*top), word.clone()]);
            let numbers = (0..most).map(|k| point.multipliers.get(k));
            row.extend(
                numbers.flat_map(|m| m.map_or([String::new(), String::new()], |m| [cell(m.re), cell(m.im)])),
            );
            table.push(row)?;
        }
    }
    table.text()
}

/// Table of the special points, each with an orbit of its branch beside it, from which a curve over
/// two parameters starts.
pub(super) fn special_table(family: &Family, branches: &[Branch]) -> Result<Vec<u8>> {
    let mut table = CsvRows::new([
        "label",
        "branch",
        "point",
        "parameter",
        "value",
        "value_error",
        "word",
        "periods",
        "period",
        "stability_before",
        "stability_after",
        "element",
        "beside_value",
        "beside_period",
        "beside_start",
    ])?;
    let rows: Vec<_> = branches.par_iter().map(|branch| special_rows(family, branch)).collect();
    rows.into_iter().flatten().try_for_each(|row| table.push(row))?;
    table.text()
}

/// Rows of the special points of a branch.
fn special_rows(family: &Family, branch: &Branch) -> Vec<[String; 15]> {
    let word = words(family, branch);
    let row = |(i, point): (usize, &OrbitPoint)| {
        let special = point.special.as_ref()?;
        let after = point.stability;
        let before = i.checked_sub(1).map_or(after, |last| branch.points[last].stability);
        let start = branch.locus_start(i);
        let again = start.as_ref().and_then(LocusStart::located_again);
        let beside = start.and_then(|_| branch.beside(i));
        let number = |of: &dyn Fn(&Orbit) -> f64| beside.as_ref().map_or(String::new(), |o| exact(of(o)));
        Some([
            special.kind.name().into(),
            branch.id.to_string(),
            i.to_string(),
            family.parameter.clone(),
            exact(point.value),
            again.map_or(String::new(), |again| exact((again - point.value).abs())),
            word.clone(),
            branch.word().periods.map_or(String::new(), |n| n.to_string()),
            exact(point.period),
            before.to_string(),
            after.to_string(),
            special.element.clone(),
            number(&|orbit| orbit.value()),
            number(&|orbit| orbit.period()),
            beside.as_ref().map_or(String::new(), |orbit| orbit.start().to_string()),
        ])
    };
    branch.points.iter().enumerate().filter_map(row).collect()
}

/// The marks of special points.
pub(super) struct SpecialMarks {
    pub layers: Vec<Layer>,
    of_stable_only: bool,
}

pub(super) fn marks(branches: &[Branch], tops: &[Vec<f64>]) -> SpecialMarks {
    let marked = |kind: Kind, all: bool| -> Path {
        let mut points = Path::new();
        for (branch, tops) in branches.iter().zip(tops) {
            for (i, (point, top)) in branch.points.iter().zip(tops).enumerate() {
                let before = i.checked_sub(1).map_or(point.stability, |k| branch.points[k].stability);
                let ends = i == 0 || i + 1 == branch.points.len();
                let bounds = before != point.stability || (ends && point.stability == Stability::Stable);
                let is_own = point.special.as_ref().is_some_and(|s| s.kind == kind);
                if is_own && top.is_finite() && (all || bounds) {
                    points.push((point.value, *top));
                }
            }
        }
        points
    };
    let kinds = MARKS.into_iter().map(|(label, name, mark)| (Kind::As(label), name, mark)).chain(FURTHER);
    let kinds: Vec<(Kind, &str, Mark)> = kinds.collect();
    let count: usize = kinds.iter().map(|(kind, ..)| marked(*kind, true).len()).sum();
    let of_stable_only = count > MARKED;
    let layers = kinds.into_iter().filter_map(|(kind, name, mark)| {
        let points = marked(kind, !of_stable_only);
        (!points.is_empty()).then(|| Layer::marks(name, BLACK, mark, points).stroke(9))
    });
    SpecialMarks { layers: layers.collect(), of_stable_only }
}

fn layers(branches: &[Branch], tops: &[Vec<f64>], marks: SpecialMarks) -> Vec<Layer> {
    let is_stable = |p: &OrbitPoint| p.stability == Stability::Stable;
    let drawn: Vec<DrawnBranch> = branches
        .iter()
        .zip(tops)
        .map(|(branch, tops)| DrawnBranch {
            period: branch.word().periods.unwrap_or(1),
            points: branch.points.iter().map(|p| (p.value, is_stable(p))).collect(),
            tops,
        })
        .collect();
    branch_layers(&drawn).into_iter().chain(marks.layers).collect()
}

/// The study of one orbit: events, multipliers, energies, a start on it, history and portrait.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output), and the errors of the machine's motion.
pub fn assembly_orbit(machine: &Machine, orbit: &Orbit, name: &str) -> Result<Study> {
    let place = orbit.place();
    let told = match orbit.word().periods {
        Some(1) => "1 period of the drive".to_owned(),
        Some(n) => format!("{n} periods of the drive"),
        None => "its own period".to_owned(),
    };
    let words = orbit.word().in_words(&place.assembly);
    let words = if words.is_empty() { "no event".into() } else { words };
    let mut remarks = vec![
        format!("events: {words}"),
        format!(
            "{}; largest multiplier {}{}",
            orbit.stability(),
            significant(orbit.spectral_radius()),
            match orbit.trivial_multipliers() {
                0 => String::new(),
                n => format!(", beside {n} that are 1 by theory"),
            }
        ),
    ];
    match (orbit.violation(), orbit.check_by_motion()) {
        (Some(violation), _) => remarks.push(format!("it is no motion of the machine: {violation}")),
        (None, Ok(apart)) => {
            remarks.push(format!("the machine's own motion meets each event within {} s", significant(apart)))
        }
        (None, Err(error)) => remarks.push(format!("the machine's own motion differs: {error}")),
    }
    if orbit.drifts().iter().any(|drift| *drift != 0.0) {
        let drifts: Vec<String> = orbit.drifts().iter().map(|x| significant(*x)).collect();
        remarks
            .push(format!("it drifts by {} (SI) a period along what no force depends on", drifts.join(", ")));
    }
    let mut tables = vec![
        ("orbit-events".into(), event_table(orbit)?),
        ("orbit-multipliers".into(), multiplier_table(orbit)?),
    ];
    match orbit.energies()? {
        Some(energies) => tables.push(("orbit-energies".into(), energy_table(&energies)?)),
        None => remarks.push("energies: no motion stays on so unstable an orbit for a period".into()),
    }
    let what = format!("periodic orbit of {} s, {told}", significant(orbit.period()));
    let figure = Figure {
        title: format!("{}: periodic orbit", machine.description.name),
        caption: vec![format!("{}; {words}", orbit.stability()), machine.caption_but(&[])],
        panels: panels(machine, orbit)?,
        columns: 2,
        panel: (1450, 1150),
        shared_legend: false,
    };
    Ok(Study { tables, figure: Some(figure), ..Study::without_figure(name, what).with_remarks(remarks) })
}

fn event_table(orbit: &Orbit) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["time", "kind", "element", "value"])?;
    let assembly = &orbit.place().assembly;
    for event in orbit.events().iter().filter(|event| event.is_listed()) {
        let named = named(assembly, &event.kind);
        let value = match event.kind {
            EventKind::Impact { speed, .. } | EventKind::Press { speed, .. } => exact(speed),
            _ => String::new(),
        };
        table.push([exact(event.time), named.kind.into(), named.element, value])?;
    }
    table.text()
}

fn multiplier_table(orbit: &Orbit) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["real", "imaginary", "modulus"])?;
    for m in orbit.multipliers() {
        table.push([exact(m.re), exact(m.im), exact(m.norm())])?;
    }
    table.text()
}

fn energy_table(energies: &[(String, f64)]) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["element", "energy"])?;
    energies.iter().try_for_each(|(name, energy)| table.push([name.clone(), exact(*energy)]))?;
    table.text()
}

/// History and portrait of the first free body, from samples of the machine's own motion by
/// flights.
fn panels(machine: &Machine, orbit: &Orbit) -> Result<Vec<Panel>> {
    let d = &machine.description;
    let quantity = Measure::usual(d).into_iter().find_map(|m| m.quantity().cloned());
    let Some(quantity) = quantity else { return Ok(Vec::new()) };
    let names = columns(d);
    let of_body = |what: What| {
        let own = QuantityName { of: quantity.of.clone(), what };
        let place = names.iter().position(|name| *name == own.to_string())?;
        Some((place, own.find(d).ok()?.unit))
    };
    let (Some(s), Some(v)) = (of_body(What::S), of_body(What::V)) else { return Ok(Vec::new()) };
    let rows = samples(orbit)?;
    let axis = |(place, unit): (usize, &str)| {
        let largest = rows.iter().fold(0.0, |most: f64, (_, values)| most.max(values[place].abs()));
        shown_axis(&names[place], unit, largest)
    };
    let history: Path = rows.iter().map(|(time, values)| (*time, values[s.0])).collect();
    let portrait: Path = rows.iter().map(|(_, values)| (values[s.0], values[v.0])).collect();
    Ok(vec![
        Panel {
            title: "(a) History".into(),
            x: Axis::new("time (s)"),
            y: axis(s),
            layers: vec![Layer::line("", FAMILY[0], Dash::Solid, history)],
        },
        Panel {
            title: "(b) Portrait".into(),
            x: axis(s),
            y: axis(v),
            layers: vec![Layer::line("", GREY, Dash::Solid, portrait)],
        },
    ])
}

/// The columns at instants of a period. Each flight is followed from its begin, so that instability
/// has no time to grow.
fn samples(orbit: &Orbit) -> Result<Vec<(f64, Vec<f64>)>> {
    let mut rows = Vec::new();
    for leg in orbit.legs() {
        let count = (f64::from(SAMPLES) * leg.span / orbit.period()).ceil().max(2.0);
        let assembly = orbit.place().assembly.clone();
        let start = assembly.system().given(&leg.states[0]);
        let mut motion = Motion::from_state(assembly, leg.time, &start)?;
        for k in 0..=count as u32 {
            motion.advance_to(leg.time + leg.span * f64::from(k) / count)?;
            rows.push((motion.time(), vibro_studies::values(&motion)));
        }
    }
    Ok(rows)
}
