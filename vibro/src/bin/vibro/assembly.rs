//! Commands with a machine's file: its check, its sketch, its motion.

use crate::arguments::Command;
use crate::assembly_studies;
use crate::common_arguments::{Common, DEFAULT_OUT};
use crate::destination;
use crate::output;
use crate::progress::{Progress, TIME};
use crate::run::Run;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use vibro::assembly::{self, Ended, Record};
use vibro::manifest::{Invocation, Manifest};
use vibro::part_folder::write_whole;
use vibro::{Error, Result};
use vibro_assembly::Description;
use vibro_figures::canvas;
use vibro_sketch::Sketch;

/// Stem of the manifest of a motion.
const RESULT: &str = "assembly-run";

/// Carries out a command for the machine of a file. `false` where a motion was interrupted, and all
/// that was computed is written.
///
/// # Errors
/// What is wrong with the file, its parameters or its motion; [`Error::File`].
pub fn run(file: &Path, command: &Command, common: &Common) -> Result<bool> {
    match command {
        Command::Draw { .. } => sketch(file, common)?,
        Command::Run(a) => return follow(file, a, common),
        Command::Bifurcation(a) => assembly_studies::bifurcation(file, common, a)?,
        Command::Lyapunov(a) => assembly_studies::lyapunov(file, common, a)?,
        Command::Sweep(a) => assembly_studies::sweep(file, common, a)?,
        // `vibro check`; no other command takes a file.
        _ => output::say(&assembly::summary(read(file, common)?)?)?,
    }
    Ok(true)
}

/// The machine, with what `--set` changes.
fn read(file: &Path, common: &Common) -> Result<Description> {
    Ok(assembly::read(file, &common.set, &mut |words| crate::note(&words))?.description)
}

/// Writes NAME.svg and NAME.png, without whatever else the folder holds.
fn sketch(file: &Path, common: &Common) -> Result<()> {
    let machine = read(file, common)?;
    let (svg, png) = canvas::svg_and_png(&Sketch::new(&machine))?;
    std::fs::create_dir_all(&common.out).map_err(Error::file("making folder", &common.out))?;
    let stem = common.out.join(&machine.name);
    write_whole(&stem.with_extension("svg"), svg.as_bytes())?;
    write_whole(&stem.with_extension("png"), &png)?;
    output::say(&format!("drawn in {}.svg and .png", stem.display()))
}

fn follow(file: &Path, Run { samples, of_file: a, .. }: &Run, common: &Common) -> Result<bool> {
    let times = match (&a.times, a.until) {
        (Some(path), _) => assembly::times_of(path)?,
        (None, Some(until)) => assembly::even_times(until, *samples as usize)?,
        (None, None) => {
            let problem = "needs the end of the motion, --until TIME, or --times FILE".into();
            return Err(Error::Refused { what: format!("run {}", file.display()), problem });
        }
    };
    let machine = read(file, common)?;
    let mut manifest = manifest(&machine, &times, common);
    manifest.invocation.options.insert("knots".into(), a.knots.to_string());
    // Refused before work begins.
    let out = place(common, &manifest)?;
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    // Without a handler Ctrl-C ends the program as well, but nothing is written.
    drop(ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed)));
    let progress = Progress::new(0, TIME).ticking();
    let record = assembly::record(machine, &times, &stop, &mut |part| progress.part(part))?;
    drop(progress);
    let held = destination::hold(&out);
    let account = write(&record, &out, &manifest, a.knots)?;
    drop(held);
    let stem = out.join("motion");
    output::say(&format!(
        "followed {} up to {} s: {}, {}; drawn in {}.svg and .png\n{account}",
        record.assembly.description.name,
        record.motion.time(),
        out.join("states.csv").display(),
        out.join("events.csv").display(),
        stem.display()
    ))?;
    match record.ended {
        Some(Ended::Error(error)) => Err(error.into()),
        Some(Ended::Stopped) => Ok(false),
        None => Ok(true),
    }
}

/// What the motion is computed from: the machine's numbers by their names, and the file of the
/// whole machine.
fn manifest(machine: &Description, times: &[f64], common: &Common) -> Manifest {
    let si = machine.parameters().into_iter().map(|p| (p.name, p.value)).collect();
    let mut invocation: Invocation = common.invocation.clone();
    invocation.options.insert("machine".into(), machine.to_toml());
    let ends = (times.len(), times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    invocation.options.insert("times".into(), format!("{} from {:?} to {:?} s", ends.0, ends.1, ends.2));
    Manifest {
        program: "vibro".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        study: RESULT.into(),
        invocation,
        si,
        groups: BTreeMap::new(),
        long_study: None,
    }
}

/// The folder where the result can be written: the named one, or one of its own beside another
/// result of the default folder.
fn place(common: &Common, manifest: &Manifest) -> Result<PathBuf> {
    let refusal =
        |out: &Path| if common.replace { Ok(None) } else { destination::other_result(out, manifest) };
    match refusal(&common.out)? {
        None => Ok(common.out.clone()),
        Some(_) if common.out == Path::new(DEFAULT_OUT) => {
            let apart = common.out.join(format!("{RESULT}-{}", manifest.digest()));
            refusal(&apart)?.map_or(Ok(apart), Err)
        }
        Some(error) => Err(error),
    }
}

/// Writes tables, picture and account; returns the account.
fn write(record: &Record, out: &Path, manifest: &Manifest, knots: bool) -> Result<String> {
    std::fs::create_dir_all(out).map_err(Error::file("making folder", out))?;
    destination::write_manifest(out, manifest)?;
    write_whole(&out.join("states.csv"), &record.states()?)?;
    write_whole(&out.join("events.csv"), &record.events(knots)?)?;
    write_whole(&out.join("contacts.csv"), &record.contacts()?)?;
    let mut lines = record.account(knots);
    match &record.ended {
        Some(Ended::Error(error)) => lines.push(format!("ended early: {error}")),
        Some(Ended::Stopped) => lines.push(format!("interrupted at t = {} s", record.motion.time())),
        None => {}
    }
    let account = lines.join("\n");
    write_whole(&out.join("account.txt"), format!("{account}\n").as_bytes())?;
    if let Some(figure) = assembly::figure(record, lines) {
        let (svg, png) = canvas::svg_and_png(&figure)?;
        write_whole(&out.join("motion.svg"), svg.as_bytes())?;
        write_whole(&out.join("motion.png"), &png)?;
    }
    Ok(account)
}
