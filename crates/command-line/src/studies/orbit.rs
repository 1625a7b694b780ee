//! One periodic orbit of a described machine: events, multipliers, energies, history and portrait.

use super::Study;
use super::design_sweep::Labelled;
use crate::Result;
use crate::table::{CsvRows, exact};
use crate::wording::{self, axis};
use vibro_figures::canvas::palette::FAMILY;
use vibro_figures::chart::{Dash, Figure, Layer, Panel, Path};
use vibro_machine::motion::EventKind;
use vibro_machine::{Motion, What};
use vibro_orbits::Orbit;
use vibro_studies::significant;
use vibro_studies::{Machine, Measure, QuantityName, columns, named};

/// Number of samples per period in pictures.
const SAMPLES: u32 = 800;

/// The study of one orbit: events, multipliers, energies, a start on it, history and portrait.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output), and the errors of the machine's motion.
pub fn orbit(machine: &Machine, orbit: &Orbit, name: &str) -> Result<Study> {
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
                n => format!(", not counting {n} that are exactly 1"),
            }
        ),
    ];
    match (orbit.violation(), orbit.check_by_motion()) {
        (Some(violation), _) => remarks.push(format!("it is not a motion of the machine: {violation}")),
        (None, Ok(apart)) => remarks
            .push(format!("a simulation reaches each event within {} s of the orbit", significant(apart))),
        (None, Err(error)) => remarks.push(format!("a simulation differs from the orbit: {error}")),
    }
    if orbit.drifts().iter().any(|drift| *drift != 0.0) {
        let drifts: Vec<String> = orbit.drifts().iter().map(|x| significant(*x)).collect();
        remarks.push(format!("it drifts by {} (SI) per period along neutral directions", drifts.join(", ")));
    }
    let held: Vec<String> =
        orbit.held().into_iter().map(|contact| place.assembly.name_of_contact(contact)).collect();
    if !held.is_empty() {
        let (names, verb) = (held.join(", "), if held.len() == 1 { "sticks" } else { "stick" });
        remarks.push(format!(
            "{names} {verb} for the whole period: other places where friction sticks give other orbits"
        ));
    }
    let mut tables = vec![
        ("orbit-events".into(), event_table(orbit)?),
        ("orbit-multipliers".into(), multiplier_table(orbit)?),
    ];
    match orbit.energies()? {
        Some(energies) => tables.push(("orbit-energies".into(), energy_table(&energies)?)),
        None => remarks.push(
            "energies: not available, because the orbit is too unstable to simulate for a period".into(),
        ),
    }
    let what = format!("periodic orbit of {} s, {told}", significant(orbit.period()));
    let figure = Figure {
        title: format!("{}: periodic orbit", wording::title(&machine.description.name)),
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

/// History and portrait of the first free body, from samples of the machine's motion along its
/// flights.
fn panels(machine: &Machine, orbit: &Orbit) -> Result<Vec<Panel>> {
    let d = &machine.description;
    let quantity = Measure::usual(d).into_iter().find_map(|m| m.quantity().cloned());
    let Some(quantity) = quantity else { return Ok(Vec::new()) };
    let names = columns(d);
    let of_body = |what: What| {
        let own = QuantityName { of: quantity.of.clone(), what };
        let place = names.iter().position(|name| *name == own.to_string())?;
        Some((place, own.find(d).ok()?.unit, wording::quantity(d, &own)))
    };
    let (Some(s), Some(v)) = (of_body(What::S), of_body(What::V)) else { return Ok(Vec::new()) };
    let legs = samples(orbit)?;
    let shown = |(place, unit, words): &(usize, &str, String)| {
        let all = legs.iter().flatten();
        axis(words, unit, all.fold(0.0, |most: f64, (_, values)| most.max(values[*place].abs())))
    };
    // Each flight is a piece, so that no line joins the velocities before and after an impact.
    let pieces = |of: &dyn Fn(&Sample) -> (f64, f64)| -> Vec<Path> {
        legs.iter().map(|leg| leg.iter().map(of).collect()).collect()
    };
    let history = pieces(&|(time, values)| (*time, values[s.0]));
    let portrait = pieces(&|(_, values)| (values[s.0], values[v.0]));
    Ok(vec![
        Panel {
            title: "(a) History".into(),
            x: axis("time", "s", orbit.period()),
            y: shown(&s),
            layers: vec![Layer::lines("", FAMILY[0], Dash::Solid, history)],
        },
        Panel {
            title: "(b) Portrait".into(),
            x: shown(&s),
            y: shown(&v),
            layers: vec![Layer::lines("", FAMILY[0], Dash::Solid, portrait)],
        },
    ])
}

/// Time and columns at an instant.
type Sample = (f64, Vec<f64>);

/// The columns at instants of each flight of a period. Each flight is followed from its beginning,
/// so that instability has no time to grow.
fn samples(orbit: &Orbit) -> Result<Vec<Vec<Sample>>> {
    let mut legs = Vec::new();
    for leg in orbit.legs() {
        let count = (f64::from(SAMPLES) * leg.span / orbit.period()).ceil().max(2.0);
        let assembly = orbit.place().assembly.clone();
        let start = assembly.system().given(&leg.states[0]);
        let mut motion = Motion::from_state(assembly, leg.time, &start)?;
        let mut rows = Vec::new();
        for k in 0..=count as u32 {
            motion.advance_to(leg.time + leg.span * f64::from(k) / count)?;
            rows.push((motion.time(), vibro_studies::values(&motion)));
        }
        legs.push(rows);
    }
    Ok(legs)
}
