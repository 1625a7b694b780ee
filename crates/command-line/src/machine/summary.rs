//! Summaries of a machine and of a motion, in words.

mod drifts;
mod growth;
mod spans;
mod steep;

pub use steep::steep;

use super::{MotionRecord, event_in_words};
use crate::Result;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::description::{BodyKind, Description, Dimension};
use vibro_machine::elements::Action;
use vibro_machine::following::Following;
use vibro_machine::mode::{FrictionState, StopState};
use vibro_machine::neutral::Neutral;
use vibro_machine::system::Part;
use vibro_machine::{Assembly, Element, Motion, Quantity, What};
use vibro_studies::StopContact;
use vibro_studies::natural::{Natural, natural};

/// Real part or frequency, relative to the largest, below which it counts as zero. A double
/// eigenvalue has the square root of the rounding error as its error.
const ZERO: f64 = 1e-7;

/// A number with six digits, for sentences.
fn short(value: f64) -> String {
    let value = value + 0.0; // zero without a sign
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = (5 - value.abs().max(1e-300).log10().floor() as i32).clamp(0, 8) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{value:.5e}")
    }
}

fn units(dimension: Dimension) -> [&'static str; 3] {
    match dimension {
        Dimension::Translation => ["m", "m/s", "N"],
        Dimension::Rotation => ["rad", "rad/s", "N·m"],
    }
}

/// A count with its noun, given in the plural: `1 modal body`, `2 bodies with matrices`.
fn in_words(count: usize, plural: &str) -> String {
    let Some(noun) = plural.split(' ').find(|word| word.ends_with('s')).filter(|_| count == 1) else {
        return format!("{count} {plural}");
    };
    let one = match noun.strip_suffix("ies") {
        Some(stem) => format!("{stem}y"),
        None => noun.trim_end_matches('s').to_owned(),
    };
    format!("1 {}", plural.replacen(noun, &one, 1))
}

/// Summary of a machine at its start: bodies, elements with their states, degrees of freedom,
/// equilibrium, natural frequencies.
///
/// # Errors
/// An error if the machine's matrices or its start are not possible.
pub fn summary(machine: Description) -> Result<String> {
    let assembly = Arc::new(Assembly::new(machine)?);
    let motion = Motion::new(assembly.clone())?;
    let d = &assembly.description;
    let counts = d.counts().into_iter().filter(|(count, _)| *count > 0);
    let counts: Vec<_> = counts.map(|(count, plural)| in_words(count, plural)).collect();
    let (name, coordinates) = (&d.name, assembly.system().coordinates);
    let freedom = in_words(coordinates, "degrees of freedom");
    let mut lines = vec![format!("{name}: {}; {freedom}", counts.join(", "))];
    lines.push("bodies".into());
    for (i, body) in d.bodies.iter().enumerate().filter(|(_, body)| !body.is_inner()) {
        let ([s, v, a], [length, speed, _]) = (motion.body(i), units(body.dimension));
        let what = match body.kind {
            BodyKind::Free(free) if body.dimension == Dimension::Translation => {
                format!("{} kg", short(free.inertia))
            }
            BodyKind::Free(free) => format!("{} kg·m²", short(free.inertia)),
            BodyKind::Node(_) => "node".into(),
            BodyKind::Prescribed { .. } => "prescribed".into(),
            BodyKind::Integrated(ref motion) => format!("prescribed by its {}", motion.level.key()),
        };
        lines.push(format!(
            "  {}: {what}; s = {} {length}, v = {} {speed}, a = {} {speed}²",
            body.name,
            short(s),
            short(v),
            short(a)
        ));
    }
    lines.extend(drifts::drifts(&assembly));
    lines.push("elements at the start".into());
    lines.extend(elements(d, &motion));
    lines.extend(following(d));
    lines.extend(neutral(&assembly));
    if assembly.system().states() == 0 {
        lines.push("all bodies have prescribed motions: none is moved by forces".into());
        return Ok(lines.join("\n"));
    }
    lines.push(equilibrium(&assembly));
    let is_curved = |element: Element| element.is_curved() && !matches!(element, Element::Friction(_));
    let small = match d.elements().any(is_curved) {
        true if assembly.system().has_formulas() => ", of small motions about the start",
        true => ", of small motions about e = 0",
        false => "",
    };
    lines.push(format!("natural frequencies in the start's mode{}{small}", of_blocks(d)));
    lines.extend(frequencies(&assembly, &motion));
    lines.extend(growth::growth(&assembly));
    lines.extend(steep::steep(&assembly));
    Ok(lines.join("\n"))
}

/// Quantities that follow from named parameters, in SI.
fn following(d: &Description) -> Vec<String> {
    let line = |own: Following| {
        let unit = if own.unit == "1" { String::new() } else { format!(" {}", own.unit.replace('.', "·")) };
        format!("  {} = {}{unit} ({})", own.name, short(own.value), own.expression)
    };
    let lines: Vec<_> = d.following().into_iter().map(line).collect();
    let title = (!lines.is_empty()).then(|| "derived from parameters".to_owned());
    title.into_iter().chain(lines).collect()
}

/// Neutral directions: no force depends on them, and returns and exponents leave them out.
fn neutral(assembly: &Assembly) -> Vec<String> {
    let found = Neutral::of(assembly.system());
    let lines = found.in_words(&assembly.description, assembly.system());
    let title = (!lines.is_empty()).then(|| "neutral directions".to_owned());
    title.into_iter().chain(lines.into_iter().map(|line| format!("  {line}"))).collect()
}

fn elements(d: &Description, m: &Motion) -> Vec<String> {
    let line = |(i, element): (usize, Element)| {
        let (name, value) = (element.dotted(), |what| short(m.value(Quantity::of_element(i, what))));
        let [length, _, force] = units(element.dimension(d));
        let state = match (element.action(), m.assembly().system().parts[i].first()) {
            (Action::Tying, _) => return format!("  {name}: holds"),
            (Action::Flexing, _) => {
                return format!("  {name}: {} coordinates", m.assembly().system().parts[i].len());
            }
            (Action::Driving, _) => return format!("  {name}: {} {force}", value(What::F)),
            (Action::Giving, _) => return format!("  {name}: {}", value(What::Value)),
            (Action::Computing, _) => return block(element, &name, value),
            (_, Some(&Part::Stop(i))) if matches!(element, Element::Freewheel(_)) => {
                if m.mode().stops[i] == StopState::Closed { "engaged".into() } else { "runs free".into() }
            }
            (Action::Hitting, Some(&Part::Stop(i))) => format!("rigid, {}", of_stop(m.stop_state(i))),
            (_, Some(&Part::Stop(i))) => format!("compliant, {}", of_stop(m.stop_state(i))),
            (_, Some(&Part::Spring(_))) if matches!(element, Element::Spring(s) if s.points.len() > 2) => {
                let system = m.assembly().system();
                let corner = |part: &Part| match *part {
                    Part::Stop(i) if system.is_corner(i) => Some(m.mode().stops[i] == StopState::Pressed),
                    _ => None,
                };
                let corners: Vec<bool> = system.parts[i].iter().filter_map(corner).collect();
                let passed = corners.iter().filter(|passed| **passed).count();
                format!("on line {} of {}", passed + 1, corners.len() + 1)
            }
            (_, Some(&Part::Friction(i))) => of_friction(m.mode().frictions[i]).into(),
            _ => "acts".into(),
        };
        format!("  {name}: {state}; e = {} {length}, f = {} {force}", value(What::E), value(What::F))
    };
    d.elements().enumerate().map(line).collect()
}

/// Description of a block and its outputs.
fn block(element: Element, name: &str, value: impl Fn(What) -> String) -> String {
    let Element::Block(own) = element else { return format!("  {name}") };
    let outputs = own.outputs.iter().enumerate();
    let outputs: Vec<String> =
        outputs.map(|(j, output)| format!("{output} = {}", value(What::Output(j)))).collect();
    let when = match &own.sampling {
        None => "continuous".to_owned(),
        Some(own) if own.delay == 0.0 => format!("sampled every {} s", short(own.period)),
        Some(own) => {
            format!("sampled every {} s, acting {} s later", short(own.period), short(own.delay))
        }
    };
    let states = match own.start.len() {
        1 => "1 state".to_owned(),
        count => format!("{count} states"),
    };
    format!("  {name}: {when}, {states}; {}", outputs.join(", "))
}

fn of_stop(state: StopState) -> &'static str {
    match state {
        StopState::Open => "open",
        StopState::Closed => "closed",
        StopState::Below => "not touched",
        StopState::Pressed => "pressed",
        StopState::Free => "beyond its gap, without force",
        StopState::Capped => "pressed at its cap",
        StopState::Rebounding => "pressed without its dashpot",
        StopState::Off => "at another stiffness",
    }
}

fn of_friction(state: FrictionState) -> &'static str {
    match state {
        FrictionState::Off => "off",
        FrictionState::Up | FrictionState::Down => "slips",
        FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => "sticks",
    }
}

/// Note on how natural frequencies account for blocks.
fn of_blocks(d: &Description) -> String {
    let has = |is_sampled: bool| d.blocks.iter().any(|block| block.sampling.is_some() == is_sampled);
    let words = [(false, "with continuous blocks"), (true, "with the outputs of sampled blocks held")];
    let words: Vec<_> = words.into_iter().filter(|own| has(own.0)).map(|own| own.1).collect();
    if words.is_empty() { String::new() } else { format!(", {}", words.join(", ")) }
}

fn equilibrium(assembly: &Assembly) -> String {
    if let Some((block, read)) = assembly.description.feedback() {
        return format!(
            "equilibrium: not computed, because block.{} feeds back {read}; use `vibro run` to \
             find where it settles",
            block.name
        );
    }
    if let Some(own) = assembly.description.contacts.iter().find(|own| !own.tangents.is_empty()) {
        return format!(
            "equilibrium: not computed, because the force of friction of contact.{} depends on how the \
             loads have grown",
            own.name
        );
    }
    match assembly.equilibrium() {
        Ok(places) => {
            let bodies = assembly.description.bodies.iter().zip(places).filter(|(body, _)| !body.is_inner());
            let places = bodies.map(|(b, s)| format!("{} = {} {}", b.name, short(s), units(b.dimension)[0]));
            format!("equilibrium under the loads at time 0: {}", places.collect::<Vec<_>>().join(", "))
        }
        Err(vibro_machine::Error::NoEquilibrium { body, acceleration, unit }) => format!(
            "equilibrium under the loads at time 0: none; body.{body} keeps the acceleration {} {unit}",
            short(acceleration)
        ),
        Err(error) => format!("equilibrium under the loads at time 0: none ({error})"),
    }
}

fn frequencies(assembly: &Assembly, motion: &Motion) -> Vec<String> {
    let system = assembly.system();
    let mut linear = system.linear(motion.mode());
    if system.has_formulas() {
        linear.a = system.linearised(&linear.a, motion.state().as_slice());
    }
    // States of sampled blocks do not have a rate.
    let sampled = system.blocks.iter().filter(|block| block.sampler.is_some());
    let kept: Vec<_> = sampled.map(|block| block.first..block.first + block.kept()).collect();
    let places: Vec<usize> =
        (0..system.states()).filter(|k| !kept.iter().any(|own| own.contains(k))).collect();
    let size = places.len();
    let Natural { values, spans } = natural(system, &linear, &places);
    let values: Vec<(f64, f64)> = values.iter().map(|c| (c.re, c.im)).collect();
    let highest = spans.iter().flat_map(|span| &span.shown[1]).map(|own| own.undamped);
    let sizes = values.iter().map(|(re, im)| re.hypot(*im)).chain(highest);
    let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
    let mut oscillations: Vec<(f64, f64)> =
        values.iter().copied().filter(|v| v.1 > ZERO * largest).map(|(re, im)| (re.hypot(im), -re)).collect();
    oscillations.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lines: Vec<String> = oscillations
        .iter()
        .map(|(omega, decay)| {
            format!("  {} Hz, damping ratio {}", short(omega / TAU), short(decay / omega + 0.0))
        })
        .collect();
    let mut rates: Vec<f64> = values
        .iter()
        .filter(|v| v.1.abs() <= ZERO * largest && v.0.abs() > ZERO * largest)
        .map(|v| -v.0)
        .collect();
    rates.sort_by(f64::total_cmp);
    lines.extend(rates.iter().map(|rate| format!("  no oscillation, decay {} 1/s", short(*rate))));
    let still = values.iter().filter(|v| v.0.hypot(v.1) <= ZERO * largest).count();
    if still > 0 {
        lines.push(format!("  0 Hz: {still} of {size} states move uniformly or are held"));
    }
    lines.extend(spans.iter().flat_map(spans::in_words));
    lines
}

/// Number and extremes of the contacts of each stop and each contact with friction.
fn contacts(record: &MotionRecord) -> Vec<String> {
    let d = &record.assembly.description;
    let mut all: BTreeMap<String, Vec<StopContact>> = BTreeMap::new();
    for contact in record.followed.contacts.all() {
        all.entry(contact.element(&record.assembly)).or_default().push(contact);
    }
    let line = |element: Element| {
        let name = element.dotted();
        let own = all.get(&name)?;
        let [_, speed_unit, force] = units(element.dimension(d));
        let largest = |of: &dyn Fn(&StopContact) -> Option<f64>| own.iter().filter_map(of).reduce(f64::max);
        let speed = largest(&|c| Some(c.speed))?;
        let blow = largest(&|c| c.impulse.filter(|_| c.peak.is_none()));
        let peak = largest(&|c| c.peak);
        let part = |name: &str, value: Option<f64>, unit: &str| {
            value.map_or(String::new(), |x| format!(", {name} {} {unit}", short(x)))
        };
        Some(format!(
            "{name}: {} contacts{}{}{}",
            own.len(),
            part("largest force", peak, force),
            part("largest impulse", blow, &format!("{force}·s")),
            part("largest closing speed", Some(speed), speed_unit)
        ))
    };
    let stops = d.elements().filter(|own| matches!(own, Element::Stop(_) | Element::Contact(_)));
    stops.filter_map(line).collect()
}

/// Number of events of each kind, and the kinds that are not in the file.
fn events(record: &MotionRecord, knots: bool) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for event in &record.events {
        let [kind, element, ..] = event_in_words(&record.assembly, &event.kind);
        *counts.entry(format!("{kind} {element}").trim().into()).or_default() += 1;
    }
    let left = counts.get("knot").filter(|_| !knots);
    let left =
        left.map_or(String::new(), |n| format!("; not in events.csv: {n} × knot (--knots lists them)"));
    let counts: Vec<_> = counts.iter().map(|(what, count)| format!("{count} × {what}")).collect();
    match record.events.len() {
        0 => "events: none".into(),
        all => format!("events: {all} ({}){left}", counts.join(", ")),
    }
}

/// Extents, events and energies of a motion.
pub(super) fn account(record: &MotionRecord, knots: bool) -> Vec<String> {
    let d = &record.assembly.description;
    let mut lines = Vec::new();
    for (i, body) in d.bodies.iter().enumerate().filter(|(_, body)| !body.is_inner()) {
        let [length, speed, _] = units(body.dimension);
        let largest = |what| record.extreme(Quantity::of_body(i, what)).map_or(0.0, |own| own.largest);
        let [s, v] = [What::S, What::V].map(|what| short(largest(what)));
        lines.push(format!("{}: largest |s| {s} {length}, largest |v| {v} {speed}", body.name));
    }
    lines.extend(contacts(record));
    if record.followed.left_out > 0.0 {
        lines.push(format!(
            "extremes and contacts: for {} s only samples and events were evaluated, because a \
             body is too fast",
            short(record.followed.left_out)
        ));
    }
    lines.push(events(record, knots));
    let (kinetic, stored) = record.motion.kinetic_and_stored();
    let energy = record.motion.energy();
    let sum = |parts: &[vibro_numerics::double_double::DoubleDouble]| {
        short(parts.iter().map(|x| x.value()).sum::<f64>())
    };
    let end = kinetic + stored;
    lines.push(format!(
        "energy: {} J at the start, {} J at the end; work of loads {} J, of prescribed motions {} \
         J; lost in dashpots {} J, in compliant stops {} J, in friction {} J, at impacts {} J; \
         balance off by {:.1e} J",
        short(record.energy),
        short(end),
        sum(&energy.loads),
        short(energy.motions.value()),
        sum(&energy.dashpots),
        sum(&energy.stops),
        sum(&energy.frictions),
        short(energy.impacts.value()),
        end - record.energy - energy.balance()
    ));
    let branches = &record.motion.assembly().system().branches;
    let contacts = branches.iter().map(|own| own.stop().is_some());
    let (rubbing, series): (Vec<_>, Vec<_>) =
        energy.branches.iter().copied().zip(contacts).partition(|own| own.1);
    let [rubbing, series] = [rubbing, series].map(|all| all.into_iter().map(|own| own.0).collect::<Vec<_>>());
    if !series.is_empty() {
        lines.push(format!("lost in dashpots and sliders in series {} J", sum(&series)));
    }
    if !rubbing.is_empty() {
        lines.push(format!("lost in friction of contacts {} J", sum(&rubbing)));
    }
    if record.motion.assembly().description.steps_stiffness() {
        lines.push(format!("work of stiffness steps {} J", short(energy.switched.value())));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn golden_one_of_a_kind_is_told_in_the_singular() {
        let told =
            [(1, "modal bodies"), (1, "bodies with matrices"), (1, "degrees of freedom"), (2, "stops")];
        let told = told.map(|(count, plural)| in_words(count, plural));
        assert_eq!(told, ["1 modal body", "1 body with matrices", "1 degree of freedom", "2 stops"]);
    }
}
