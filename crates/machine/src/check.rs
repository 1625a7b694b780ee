//! Checks of a whole description, used by the file reader and by the setting of parameters.

mod blocks;
mod contacts;
mod flexible;
mod links;
mod names;
mod residual;
mod starts;
mod stepped;

pub(crate) use flexible::MOST_COORDINATES;
pub(crate) use names::{GROUND, problem_of as problem_of_name};
pub(crate) use residual::RIGID;

use crate::description::{
    Arms, Body, BodyKind, Description, Dimension, Follows, Interpolation, Record, Signal, Spring, Stop,
    StopLaw, Sweep, SweepLaw,
};
use crate::elements::Element;
use crate::polyline::slopes;
use crate::refusal::{Problem, Refusal};
use crate::slots::{of_sweep, slots};
use crate::what::What;

/// Largest number of bodies, of elements, and of harmonics and steps of a machine; checked before
/// memory is allocated for them.
pub(crate) const MOST: usize = 10_000;

/// Largest number of turns of an integrated sweep.
const MOST_TURNS: f64 = 100_000.0;

/// Least time between knots of a record with slopes, s.
const LEAST_APART: f64 = 1e-12;

/// Largest number of knots of a record.
pub(crate) const MOST_KNOTS: usize = 1_000_000;

impl Description {
    /// Checks a description that a program has put together, as strictly as a file.
    ///
    /// ```
    /// let machine = vibro_machine::Description { name: "Nothing".into(), ..Default::default() };
    /// let refused = machine.check().unwrap_err();
    /// assert_eq!(refused.to_string(), "body: expected at least one body");
    /// ```
    ///
    /// # Errors
    /// A [`Refusal`] with every problem found.
    pub fn check(&self) -> Result<(), Refusal> {
        match check(self) {
            problems if problems.is_empty() => Ok(()),
            problems => Err(Refusal { file: String::new(), problems }),
        }
    }
}

/// All problems of a machine. Problems of names, numbers and structure come first; problems that
/// would follow from them are not reported.
pub(crate) fn check(machine: &Description) -> Vec<Problem> {
    let mut problems = check_under_way(machine);
    if problems.is_empty() {
        starts::check(machine, &mut problems);
    }
    problems
}

/// All problems of a machine whose motion has begun: as [`check`], without the start.
pub(crate) fn check_under_way(machine: &Description) -> Vec<Problem> {
    let mut problems = check_structure(machine);
    if !problems.is_empty() {
        return problems;
    }
    if machine.starts_at_rest {
        blocks::at_rest(machine, &mut problems);
    }
    for slot in slots(&mut machine.clone()) {
        if !slot.kind.contains(*slot.value) {
            let text = slot.kind.fault(*slot.value, slot.dimension);
            problems.push(refused(slot.name, *slot.value, text));
        }
    }
    for element in machine.elements() {
        for arms in element.all_arms() {
            check_arms(machine, &element.dotted(), arms, &mut problems);
        }
    }
    machine.springs.iter().for_each(|spring| check_points(spring, &mut problems));
    machine.signals().for_each(|of| check_signal(&of.name, of.signal, &mut problems));
    check_integrated(machine, &mut problems);
    loads(machine, &mut problems);
    series(machine, &mut problems);
    curves(machine, &mut problems);
    contacts::check(machine, &mut problems);
    residual::check(machine, &mut problems);
    stepped::check(machine, &mut problems);
    blocks::check(machine, &mut problems);
    if !problems.is_empty() {
        return problems;
    }
    levels(machine, &mut problems);
    bodies(machine, &mut problems);
    links::check(machine, &mut problems);
    problems
}

/// Problems of names and structure, which no change of numbers can solve.
pub(crate) fn check_structure(machine: &Description) -> Vec<Problem> {
    let mut problems = names::check(machine);
    if problems.is_empty() {
        flexible::check(machine, &mut problems);
    }
    problems
}

/// A problem of a number, with its value.
fn refused(name: impl Into<String>, value: f64, text: impl Into<String>) -> Problem {
    Problem::new(name, Some(format!("{value:?}")), text)
}

fn check_arms(machine: &Description, name: &str, arms: &Arms, problems: &mut Vec<Problem>) {
    if arms.terms.is_empty() {
        problems.push(Problem::new(
            format!("{name}.arms"),
            None,
            "names no body; expected one or more bodies",
        ));
    }
    let signs: Vec<_> = arms.terms.iter().map(|term| term.1).collect();
    if !arms.levers && ![&[-1.0][..], &[1.0], &[-1.0, 1.0]].contains(&&signs[..]) {
        let text = "an element without levers must have the arms -1 (first end) and 1 (second end)";
        problems.push(Problem::new(format!("{name}.arms"), Some(format!("{signs:?}")), text));
    }
    let mut seen = vec![false; machine.bodies.len()];
    for &(body, arm) in &arms.terms {
        let of = |body: &Body| format!("{name}.arms.{}", body.name);
        match machine.bodies.get(body) {
            None => problems.push(Problem::new(
                name,
                None,
                format!("no body has the index {body}, counted from 0"),
            )),
            Some(found) if std::mem::replace(&mut seen[body], true) => {
                problems.push(refused(of(found), arm, "the body is named twice"));
            }
            Some(found) if !arms.levers && found.dimension != arms.dimension => {
                problems.push(refused(
                    of(found),
                    arm,
                    "an element without levers requires a body of its own dimension",
                ));
            }
            Some(_) => {}
        }
    }
}

fn check_signal(name: &str, signal: &Signal, problems: &mut Vec<Problem>) {
    for (i, pair) in signal.steps.windows(2).enumerate() {
        if pair[1].time <= pair[0].time {
            let text = format!("must be after {:?} s, the time of the previous step", pair[0].time);
            problems.push(refused(format!("{name}.steps[{}].time", i + 1), pair[1].time, text));
        }
    }
    for (i, sweep) in signal.sweeps.iter().enumerate() {
        check_sweep(&of_sweep(name, i, signal.sweeps.len()), sweep, problems);
    }
    let Some(record) = &signal.table else {
        check_repeat(name, signal, problems);
        return;
    };
    let table = format!("{name}.table");
    if record.knots.len() < 2 {
        problems.push(Problem::new(&table, None, too_few(record.knots.len())));
    } else if record.knots.len() > MOST_KNOTS {
        let text = format!("has {} rows; expected at most {MOST_KNOTS}", record.knots.len());
        problems.push(Problem::new(&table, None, text));
    }
    if let Some(i) = record.knots.iter().position(|k| !(k.0.is_finite() && k.1.is_finite())) {
        let knot = format!("[{:?}, {:?}]", record.knots[i].0, record.knots[i].1);
        problems.push(Problem::new(format!("{table}[{i}]"), Some(knot), "expected finite numbers"));
    } else if let Some(i) = record.knots.windows(2).position(|k| k[1].0 <= k[0].0) {
        let text = format!("must be after {:?} s, the time of the previous row", record.knots[i].0);
        problems.push(refused(format!("{table}[{}]", i + 1), record.knots[i + 1].0, text));
    } else if let Some(i) = too_near(record) {
        let text = format!(
            "must be at least {LEAST_APART:e} s after {:?} s, the time of the previous row; only \
             interpolation = \"hold\" allows less",
            record.knots[i].0
        );
        problems.push(refused(format!("{table}[{}]", i + 1), record.knots[i + 1].0, text));
    } else if record.knots.len() > 1 {
        check_repeat(name, signal, problems);
    }
}

/// The fault of a record with too few rows.
pub(crate) fn too_few(count: usize) -> String {
    let rows = match count {
        0 => "no rows".into(),
        1 => "1 row".into(),
        _ => format!("{count} rows"),
    };
    format!("has {rows} with numbers; a record requires at least 2, each with a time and a value")
}

/// Index of a knot whose slope to the next knot cannot be distinguished from a step.
fn too_near(record: &Record) -> Option<usize> {
    let has_slopes = record.interpolation != Interpolation::Hold;
    let near = |pair: &[(f64, f64)]| pair[1].0 - pair[0].0 < LEAST_APART;
    record.knots.windows(2).position(near).filter(|_| has_slopes)
}

/// Problems of a sweep: both frequencies (if logarithmic) or one (if linear) must be above 0.
fn check_sweep(name: &str, sweep: &Sweep, problems: &mut Vec<Problem>) {
    for (key, frequency) in [("from", sweep.from), ("to", sweep.to)] {
        if frequency == 0.0 && sweep.law == SweepLaw::Logarithmic {
            let text = "must be above 0 Hz in a logarithmic sweep";
            problems.push(refused(format!("{name}.{key}"), frequency, text));
        }
    }
    if sweep.from.max(sweep.to) == 0.0 && sweep.law == SweepLaw::Linear {
        let text = "`from` and `to` are both 0 Hz; one of them must be above 0 Hz";
        problems.push(refused(format!("{name}.to"), sweep.to, text));
    }
}

/// Problems of an integrated sweep, whose cells are summed before the motion begins.
fn check_integrated(machine: &Description, problems: &mut Vec<Problem>) {
    for named in machine.signals().filter(|named| named.motion.is_some_and(|order| order > 0)) {
        for (i, sweep) in named.signal.sweeps.iter().enumerate() {
            let name = of_sweep(&named.name, i, named.signal.sweeps.len());
            if sweep.turns() > MOST_TURNS {
                let text = format!(
                    "the sweep makes {:.0} turns; expected at most {MOST_TURNS:.0} in a rate or an acceleration",
                    sweep.turns()
                );
                problems.push(refused(format!("{name}.duration"), sweep.duration, text));
            }
        }
    }
}

/// Problems of a period: steps and knots lie within it, and a record has equal ends.
fn check_repeat(name: &str, signal: &Signal, problems: &mut Vec<Problem>) {
    let Some(period) = signal.repeat else { return };
    for (i, step) in signal.steps.iter().enumerate() {
        if !(0.0..period).contains(&step.time) {
            let text = format!("must be at least 0 s and less than repeat = {period:?} s");
            problems.push(refused(format!("{name}.steps[{i}].time"), step.time, text));
        }
    }
    let Some(record) = &signal.table else { return };
    let outside = |knot: &(f64, f64)| !(0.0..=period).contains(&knot.0);
    if let Some(i) = record.knots.iter().position(outside) {
        let text = format!("the time must be from 0 s to repeat = {period:?} s");
        problems.push(refused(format!("{name}.table[{i}]"), record.knots[i].0, text));
        return;
    }
    let (first, last) = (record.knots[0], record.knots[record.knots.len() - 1]);
    if first.0 == 0.0 && last.0 == period && first.1 != last.1 {
        let text = format!("the value at repeat = {period:?} s must equal the value at 0 s, {:?}", first.1);
        problems.push(refused(format!("{name}.table[{}]", record.knots.len() - 1), last.1, text));
    }
}

/// Problems of the points of a spring's force: two or more, increasing e, finite slopes.
fn check_points(spring: &Spring, problems: &mut Vec<Problem>) {
    let (name, points) = (format!("spring.{}.points", spring.name), &spring.points);
    if points.is_empty() {
        return;
    }
    if points.len() < 2 {
        problems.push(Problem::new(&name, None, "expected at least two points"));
    }
    if let Some(i) = points.windows(2).position(|pair| pair[1].e <= pair[0].e) {
        let unit = What::E.unit(spring.arms.dimension);
        let text = format!("must be greater than {:?} {unit}, the e of the previous point", points[i].e);
        problems.push(refused(format!("{name}[{}].e", i + 1), points[i + 1].e, text));
    } else if let Some(i) = slopes(points).iter().position(|slope| !slope.is_finite()) {
        let text = "must be nearer to the force of the previous point: the slope between them is not finite";
        problems.push(refused(format!("{name}[{}].f", i + 1), points[i + 1].f, text));
    }
    if (spring.stiffness, spring.preload) != (0.0, 0.0) {
        problems.push(refused(
            format!("spring.{}.stiffness", spring.name),
            spring.stiffness,
            "stiffness and preload must be 0 if the spring has points",
        ));
    }
}

/// Problems of loads: each acts on a free body.
fn loads(machine: &Description, problems: &mut Vec<Problem>) {
    for load in &machine.loads {
        let name = format!("load.{}.on", load.name);
        match machine.bodies.get(load.body) {
            None => problems.push(Problem::new(
                name,
                None,
                format!("no body has the index {}, counted from 0", load.body),
            )),
            Some(Body { name: body, kind, .. }) if kind.is_prescribed() => {
                let text = "the motion of this body is prescribed; expected a body with mass or inertia";
                problems.push(Problem::new(name, Some(format!("{body:?}")), text));
            }
            Some(_) => {}
        }
    }
}

pub(crate) use contacts::FOLLOWS;

/// The first spring with a falling line.
fn falling(machine: &Description) -> Option<&Spring> {
    machine.springs.iter().find(|own| slopes(&own.points).iter().any(|slope| *slope < 0.0))
}

/// Problems of curved springs: the curve is the whole force next to the dashpot, and a start at
/// rest follows either curves or falling lines.
fn curves(machine: &Description, problems: &mut Vec<Problem>) {
    for spring in machine.springs.iter().filter(|own| own.is_curved()) {
        let name = format!("spring.{}", spring.name);
        if !spring.points.is_empty() || spring.series.is_some() || spring.stepped.is_some() {
            let text = "a curve cannot be combined with points, a partner in series or a stiffness that \
                        steps: use two springs in parallel";
            problems.push(Problem::new(name, None, text));
        }
    }
    for element in machine.elements() {
        let Some(Err(text)) = element.formula().map(|own| own.compiled()) else { continue };
        problems.push(Problem::new(format!("{}.force", element.dotted()), None, text));
    }
    let curved = crate::system::first_curved(machine);
    if let (true, Some(element), Some(spring)) = (machine.starts_at_rest, curved, falling(machine)) {
        let text =
            format!("falling lines cannot be combined with {element} in a machine that starts at rest");
        problems.push(Problem::new(format!("spring.{}.points", spring.name), None, text));
    }
}

/// Problems of springs in series: the inner displacement at time 0 replaces a preload.
fn series(machine: &Description, problems: &mut Vec<Problem>) {
    for spring in machine.springs.iter().filter(|own| own.series.is_some() && own.preload != 0.0) {
        let text = "must be 0 for a spring in series";
        problems.push(refused(format!("spring.{}.preload", spring.name), spring.preload, text));
    }
}

/// Problems of friction levels: a static level is at least the sliding level, if both are
/// constants.
fn levels(machine: &Description, problems: &mut Vec<Problem>) {
    for friction in &machine.frictions {
        if let Some(follows) = &friction.follows {
            check_follows(machine, &format!("friction.{}", friction.name), follows, problems);
            continue;
        }
        let Some(largest) = &friction.static_force else { continue };
        let force = friction.force.constant;
        if friction.force.is_constant() && largest.is_constant() && largest.constant < force {
            let unit = crate::kinds::PRELOAD.unit(friction.arms.dimension);
            let text = format!(
                "must be at least {force:?} {unit}, the sliding friction friction.{}.force",
                friction.name
            );
            problems.push(refused(format!("friction.{}.static", friction.name), largest.constant, text));
        }
    }
}

/// Problems of levels that follow a stop: the stop is compliant, and the static coefficient is at
/// least the sliding coefficient.
fn check_follows(machine: &Description, name: &str, follows: &Follows, problems: &mut Vec<Problem>) {
    let Follows { stop, coefficient, static_coefficient } = *follows;
    match machine.stops.get(stop) {
        None => problems.push(Problem::new(
            format!("{name}.follows"),
            None,
            format!("no stop has the index {stop}, counted from 0"),
        )),
        Some(Stop { name: rigid, law: StopLaw::Rigid { .. }, .. }) => {
            let text = "friction at a rigid stop is not supported: its impacts would have friction; \
                        use a compliant stop";
            problems.push(Problem::new(format!("{name}.follows"), Some(format!("{rigid:?}")), text));
        }
        Some(_) => {}
    }
    if let Some(largest) = static_coefficient.filter(|largest| *largest < coefficient) {
        let text = format!("must be at least {coefficient:?}, the sliding friction {name}.coefficient");
        problems.push(refused(format!("{name}.static_coefficient"), largest, text));
    }
}

/// Problems of bodies: there is at least one, an element acts on each free body, and gravity acts
/// on no rotating body.
fn bodies(machine: &Description, problems: &mut Vec<Problem>) {
    if machine.bodies.is_empty() {
        problems.push(Problem::new("body", None, "expected at least one body"));
    }
    let mut touched = vec![false; machine.bodies.len()];
    machine
        .elements()
        .flat_map(Element::all_arms)
        .flat_map(|arms| &arms.terms)
        .for_each(|t| touched[t.0] = true);
    machine.loads.iter().for_each(|load| touched[load.body] = true);
    for (body, touched) in machine.bodies.iter().zip(touched) {
        let name = format!("body.{}", body.name);
        let moves_by_forces = matches!(body.kind, BodyKind::Free(_)) && !body.is_inner();
        if !touched && moves_by_forces {
            let text = "nothing acts on this body; connect an element to it";
            problems.push(Problem::new(&name, None, text));
        }
        if let (Dimension::Rotation, BodyKind::Free(free)) = (body.dimension, &body.kind)
            && free.gravity != 0.0
        {
            problems.push(refused(
                format!("{name}.gravity"),
                free.gravity,
                "must be 0, since gravity does not turn a body",
            ));
        }
    }
}
