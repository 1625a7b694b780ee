//! `vibro reduce --verify`: compares the motion of a machine with the reduced body and its motion
//! with more modes.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use vibro::machine::event_in_words;
use vibro::{Error, Result};
use vibro_machine::motion::Event;
use vibro_machine::quantity::{NamedQuantity, What};
use vibro_machine::{Assembly, Motion, file};
use vibro_reduce::job::{Job, Made};

/// More modes, as a factor: the frequency of the highest mode then about doubles.
const FACTOR: f64 = 1.5;
/// Positions are compared at this number of times.
const SAMPLES: u32 = 2000;

/// A motion.
struct Followed {
    /// The positions of all bodies and nodes.
    columns: Vec<NamedQuantity>,
    /// Their values at the compared times.
    values: Vec<Vec<f64>>,
    /// Times, s, and names of all events.
    events: Vec<(f64, String)>,
}

/// Simulates the machine in `path` until `end`, in s, with the body in `made` and with the body
/// that `job` makes with more modes. Returns lines about the differences.
///
/// # Errors
/// [`Error::File`]; [`Error::Refused`] for a machine, or a reduction to more modes.
pub fn verify(job: &Job, made: &Made, path: &Path, end: f64) -> Result<Vec<String>> {
    let rest = fs::read_to_string(path).map_err(Error::file("reading", path))?;
    let finer = Job { modes: (FACTOR * job.modes as f64).ceil() as usize, ..job.clone() };
    let body = finer.run().map_err(|error| Error::Refused {
        what: format!("--verify with {} modes: {}", finer.modes, error.what),
        problem: error.problem,
    })?;
    if body.reduced.values.len() == made.reduced.values.len() {
        return Ok(vec!["not verified: the body has all its modes, so that none can be added".into()]);
    }
    let [own, other] = [&made.toml, &body.toml].map(|body| follow(&format!("{body}\n{rest}"), path, end));
    let (own, other) = (own?, other?);
    let mut lines = vec![format!(
        "{} with {} and {} modes over {end} s, positions at {SAMPLES} times:",
        path.display(),
        job.modes,
        finer.modes
    )];
    for (k, column) in own.columns.iter().enumerate() {
        let differs = |(own, other): (&Vec<f64>, &Vec<f64>)| (own[k] - other[k]).abs();
        let largest = other.values.iter().map(|own| own[k].abs()).fold(0.0, f64::max);
        let apart = own.values.iter().zip(&other.values).map(differs).fold(0.0, f64::max);
        let share = if largest > 0.0 { format!(", {:.2} %", 100.0 * apart / largest) } else { String::new() };
        let [largest, apart] = [largest, apart].map(short);
        let (name, unit) = (&column.name, column.unit);
        lines.push(format!("  {name}: largest {largest} {unit}, differs by at most {apart} {unit}{share}"));
    }
    lines.push(format!("  {}", compared(&own, &other, [job.modes, finer.modes])));
    Ok(lines)
}

/// The motion of a machine's text until a time.
fn follow(text: &str, path: &Path, end: f64) -> Result<Followed> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let records = |name: &str| fs::read_to_string(folder.join(name));
    let shown = format!("the reduced body followed by {}", path.display());
    let refused = |problem: String| Error::Refused { what: "--verify".into(), problem };
    let d = file::parse(text, &shown, &records).map_err(|error| refused(error.to_string()))?;
    let columns = d.named_quantities().into_iter().filter(|own| own.quantity.what == What::S);
    let columns: Vec<NamedQuantity> = columns.collect();
    let assembly = Arc::new(Assembly::new(d).map_err(|error| refused(error.to_string()))?);
    let (mut values, mut events) = (Vec::new(), Vec::new());
    let mut note = |event: &Event| {
        let [kind, element, ..] = event_in_words(&assembly, &event.kind);
        events.push((event.time, format!("{kind} {element}").trim().to_owned()));
    };
    let mut motion = Motion::new(assembly.clone()).map_err(|error| refused(error.to_string()))?;
    for k in 1..=SAMPLES {
        let time = end * f64::from(k) / f64::from(SAMPLES);
        motion.advance_observed(time, &mut note).map_err(|error| refused(error.to_string()))?;
        values.push(columns.iter().map(|own| motion.value(own.quantity)).collect());
    }
    Ok(Followed { columns, values, events })
}

/// A sentence about the events that two motions have in common.
fn compared(own: &Followed, other: &Followed, modes: [usize; 2]) -> String {
    let all = [&own.events, &other.events];
    let counts = all.map(Vec::len);
    let same = all[0].iter().zip(all[1]).take_while(|(own, other)| own.1 == other.1).count();
    if counts == [same; 2] {
        let apart = all[0].iter().zip(all[1]).map(|(own, other)| (own.0 - other.0).abs());
        let apart = short(apart.fold(0.0, f64::max));
        return match same {
            0 => "events: none with either".into(),
            _ => format!("events: the same {same} in the same order, times differ by at most {apart} s"),
        };
    }
    let at = |i: usize| match all[i].get(same) {
        Some((time, name)) => format!("{name} at {} s with {} modes", short(*time), modes[i]),
        None => format!("no further event with {} modes", modes[i]),
    };
    let [few, many] = counts;
    format!(
        "events: {few} with {} modes, {many} with {}; the first {same} are the same, then {}, {}",
        modes[0],
        modes[1],
        at(0),
        at(1)
    )
}

/// A number with three digits.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let plain = rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs());
    if plain { format!("{rounded}") } else { format!("{rounded:e}") }
}
