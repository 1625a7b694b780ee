//! Commands with a machine's file: summary, sketch, motion.

use crate::arguments::Command;
use crate::common_arguments::{Common, names};
use crate::destination::{self, Destination};
use crate::interruption::{self, Second};
use crate::machine_orbits::without_period;
use crate::machine_studies::start_of;
use crate::output;
use crate::packing;
use crate::progress::{Progress, TIME};
use crate::run::RunArguments;
use crate::{machine_basin, machine_design, machine_fit, machine_orbits, machine_studies};
use std::path::Path;
use std::sync::atomic::Ordering;
use vibro::machine::{Chosen, DerivativeRecord, Ended, MotionRecord};
use vibro::manifest::Manifest;
use vibro::whole_file::write_whole;
use vibro::{Error, Result};
use vibro_figures::canvas;
use vibro_figures::print::POINTS;
use vibro_machine::{Assembly, Description, Element, Start};
use vibro_sketch::{Printed, Sketch};
use vibro_studies::Machine;

/// Stem of the manifest of a motion.
const RESULT: &str = "run";
/// Stem of the picture of a motion.
const PICTURE: &str = "motion";
/// Begin of the account's line for a motion that an error ended.
const ENDED: &str = "ended early: ";

/// Carries out a command for the machine of a file. Returns `false` if it was interrupted;
/// everything computed until then is written.
///
/// # Errors
/// An error if the file, its parameters or its motion is not valid; [`Error::File`] if a file
/// cannot be read or written.
pub fn run(file: &Path, command: &Command, common: &Common) -> Result<bool> {
    carry_out(file, command, common).map_err(|error| at_start(file, error))
}

/// The error of a machine without an equilibrium, with the file's line of `start`.
fn at_start(file: &Path, error: Error) -> Error {
    use vibro_machine::Error::{GivesWay, NoEquilibrium};
    match error {
        Error::Assembly(own @ (NoEquilibrium { .. } | GivesWay { .. }))
        | Error::Analysis(vibro_studies::Error::Assembly(own @ (NoEquilibrium { .. } | GivesWay { .. }))) => {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            // The key is above the first heading.
            let mut keys = text.lines().take_while(|line| !line.trim_start().starts_with('['));
            let line = keys.position(|line| line.trim_start().starts_with("start"));
            let line = line.map_or(String::new(), |line| format!(":{}", line + 1));
            Error::Refused { what: format!("{}{line}", file.display()), problem: own.to_string() }
        }
        other => other,
    }
}

fn carry_out(file: &Path, command: &Command, common: &Common) -> Result<bool> {
    match command {
        Command::Draw { .. } => sketch(file, common)?,
        Command::Fmu(a) => packing::pack(&read(file, common)?.description, a, common)?,
        Command::Run(a) => return follow(file, a, common),
        Command::Bifurcation(a) => machine_studies::bifurcation(file, common, a)?,
        Command::Lyapunov(a) => machine_studies::lyapunov(file, common, a)?,
        Command::Sweep(a) => machine_studies::sweep(file, common, a)?,
        Command::Basin(a) => machine_basin::basin(file, common, a)?,
        Command::Section(a) => machine_studies::section(file, common, a)?,
        Command::Response(a) => return machine_orbits::response(file, common, a).map_err(without_period),
        Command::Orbit(a) => machine_orbits::orbit(file, common, a).map_err(without_period)?,
        Command::Design(a) => return machine_design::run(file, common, a),
        Command::Fit(a) => return machine_fit::run(common, a),
        Command::Orbits(a) => return machine_orbits::orbits(file, common, a).map_err(without_period),
        Command::Locus(a) => machine_orbits::loci(file, common, a).map_err(without_period)?,
        // `vibro check`: no other command takes a file.
        _ => output::say(&vibro::machine::summary(read(file, common)?.description)?)?,
    }
    Ok(true)
}

/// The machine, with the changes of `--set`.
fn read(file: &Path, common: &Common) -> Result<Machine> {
    vibro::machine::read(file, &common.set, &mut |words| crate::note(&words))
}

/// Writes NAME.svg and NAME.png, regardless of the folder's other content.
fn sketch(file: &Path, common: &Common) -> Result<()> {
    let machine = read(file, common)?.description;
    let sketch = Sketch::new(&machine);
    let (svg, png) = match common.width {
        Some(millimetres) => {
            let printed = sketch.printed(millimetres);
            note_small(&printed, millimetres);
            canvas::svg_and_png(&printed)?
        }
        None => canvas::svg_and_png(&sketch)?,
    };
    std::fs::create_dir_all(&common.out).map_err(Error::file("making folder", &common.out))?;
    let stem = common.out.join(&machine.name);
    write_whole(&stem.with_extension("svg"), svg.as_bytes())?;
    write_whole(&stem.with_extension("png"), &png)?;
    output::say(&format!("drawn in {}.svg and .png", stem.display()))
}

/// Prints a note on a sketch that is too wide for names of the usual size.
fn note_small(printed: &Printed, millimetres: f64) {
    let points = printed.points();
    if points < POINTS {
        let (full, millimetres) = (printed.full_width().ceil(), (100.0 * millimetres).round() / 100.0);
        crate::note(&format!(
            "with --width {millimetres}mm names have {points:.1} points; --width {full}mm or more gives {POINTS}"
        ));
    }
}

/// Prints a note on a curved force that makes the motion slow. Other faults of the machine are
/// reported when its motion begins.
fn note_steep(machine: &Description) {
    if machine.elements().any(Element::is_curved) {
        let words = Assembly::new(machine.clone()).ok().and_then(|own| vibro::machine::steep(&own));
        words.iter().for_each(|words| crate::note(words));
    }
}

fn follow(
    file: &Path,
    RunArguments { samples, start, of_file: a, .. }: &RunArguments,
    common: &Common,
) -> Result<bool> {
    // The machine is read first, since another kind of file needs other options.
    let machine = read(file, common)?;
    let start = start_of(&machine, start)?;
    let times = match (&a.times, a.until) {
        (Some(path), until) => {
            let mut times = vibro::machine::times_of(path, start.time)?;
            let (last, end) = (times.last().copied(), until.unwrap_or(f64::INFINITY));
            if let Some(last) = last.filter(|last| *last > end) {
                let problem = format!("has the time {last} s; times must not be after --until, {end} s");
                return Err(Error::Refused { what: format!("--times {}", path.display()), problem });
            }
            times.extend(until.filter(|end| last.is_none_or(|last| last < *end)));
            times
        }
        (None, Some(until)) => vibro::machine::even_times((start.time, until), *samples as usize)?,
        (None, None) => {
            let problem = "requires the end of the motion (--until TIME) or a file of times \
                           (--times FILE)"
                .into();
            return Err(Error::Refused { what: format!("run {}", file.display()), problem });
        }
    };
    let mut invocation = common.invocation.clone();
    let ends = (times.len(), times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    invocation.options.insert("times".into(), format!("{} from {:?} to {:?} s", ends.0, ends.1, ends.2));
    invocation.options.insert("knots".into(), a.knots.to_string());
    if !a.columns.is_empty() {
        invocation.options.insert("columns".into(), a.columns.join(","));
    }
    if !start.is_own() {
        invocation.options.insert("start".into(), start.to_string());
    }
    let destination = Destination::new(common, &invocation, &machine);
    let by = names(&a.derivatives);
    vibro::machine::check_parameters(&machine.description, &start, &by)?;
    let columns = Chosen::of(&machine.description, &a.columns)?;
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result(RESULT)])?;
    let stop = interruption::flag(Second::Waits);
    note_steep(&machine.description);
    let progress = Progress::new(0, TIME);
    let what = (&times[..], &columns.further[..]);
    let record =
        vibro::machine::record_with(machine.description.clone(), &start, what, &stop, &mut |part| {
            progress.part(part)
        })?;
    let derivatives = match by.is_empty() {
        true => None,
        false => Some(DerivativeRecord::new(&record, &by, &stop)?),
    };
    drop(progress);
    let held = destination::hold(&out);
    let manifest = Manifest::of_result(RESULT, &invocation, &machine);
    let account =
        write((&record, derivatives.as_ref()), &out, &manifest, (a.knots, &columns.names), common.width)?;
    drop(held);
    let stem = out.join(PICTURE);
    // The error that ended the motion is printed after the account.
    let shown: Vec<&str> = account.lines().filter(|line| !line.starts_with(ENDED)).collect();
    output::say(&format!(
        "simulated {} up to {} s: {}, {}; drawn in {}.svg and .png\n{}",
        record.assembly.description.name,
        record.motion.time(),
        out.join("states.csv").display(),
        out.join("events.csv").display(),
        stem.display(),
        shown.join("\n")
    ))?;
    match record.ended {
        Some(Ended::Error(error)) => Err(error.into()),
        Some(Ended::Stopped) => Ok(false),
        None => Ok(!stop.load(Ordering::Relaxed)),
    }
}

/// Writes tables, picture and account; returns the account.
fn write(
    (record, derivatives): (&MotionRecord, Option<&DerivativeRecord>),
    out: &Path,
    manifest: &Manifest,
    (knots, columns): (bool, &[String]),
    width: Option<f64>,
) -> Result<String> {
    let mut lines = record.account(knots);
    lines.extend(derivatives.into_iter().flat_map(DerivativeRecord::lost).cloned());
    match &record.ended {
        Some(Ended::Error(error)) => lines.push(format!("{ENDED}{error}")),
        Some(Ended::Stopped) => lines.push(format!("interrupted at t = {} s", record.motion.time())),
        None => {}
    }
    let account = lines.join("\n");
    let figure = vibro::machine::figure(record, lines);
    let caption = figure.is_some().then(|| destination::caption_file(PICTURE));
    std::fs::create_dir_all(out).map_err(Error::file("making folder", out))?;
    destination::write_manifest(out, &Manifest { caption, ..manifest.clone() })?;
    write_whole(&out.join("states.csv"), &record.states(columns)?)?;
    write_whole(&out.join("events.csv"), &record.events(knots)?)?;
    write_whole(&out.join("contacts.csv"), &record.contacts()?)?;
    write_whole(&out.join("end.toml"), Start::of(&record.motion).to_toml().as_bytes())?;
    if let Some(derivatives) = derivatives {
        write_whole(&out.join("derivatives.csv"), &derivatives.states(record)?)?;
        write_whole(&out.join("event-derivatives.csv"), &derivatives.events(knots)?)?;
    }
    write_whole(&out.join("account.txt"), format!("{account}\n").as_bytes())?;
    figure.iter().try_for_each(|own| destination::write_picture((own, width), PICTURE, manifest, out))?;
    Ok(account)
}
