//! Long studies: computed in parts that are kept on disk, divided into shards, merged; and the
//! whole report.

use crate::common_arguments::Common;
use crate::destination::{Claim, Destination};
use crate::plane_arguments::Basin;
use crate::progress::Progress;
use crate::ranges::{self, in_option};
use crate::study_arguments::{Bifurcation, Isoperiodic, Lyapunov, Merge, Reproduce};
use crate::{interruption, output};
use std::path::{Path, PathBuf};
use vibro::long_study::{LongStudy, OverSweep, StudyKind};
use vibro::manifest::{Invocation, Manifest};
use vibro::part_folder::PartFolder;
use vibro::{Error, Result, report, studies};
use vibro_orbits::paper::TreeOptions;
use vibro_studies::basin::BasinRequest;
use vibro_studies::paper::basin::{InitialValueRange, in_the_middle};
use vibro_studies::paper::bifurcation::Sweep;
use vibro_studies::paper::isoperiodic;
use vibro_studies::paper::lyapunov::SpectrumOptions;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::{ParameterSet, find_group, numbers};
use vibro_studies::parts::{PartStore, Shard, Task};

/// Values of f10 whose spectra are listed by default.
const SPECTRA: [f64; 4] = [0.6, 1.5, 2.45, 3.6];

/// Ending of the folders of parts.
const PARTS: &str = "parts";

/// The axis of a sweep; by default f10.
fn axis(set: &ParameterSet, a: &Bifurcation) -> Result<ParameterAxis> {
    let default = || Ok::<_, Error>(ranges::shown(set, find_group("f10")?.into(), (0.5, 5.0)));
    a.of_paper.range.map_or_else(default, Ok)?.axis(a.resolution.into(), 2..=20_000)
}

fn kind(
    axis: ParameterAxis,
    a: &Bifurcation,
    exponents: Option<SpectrumOptions>,
    at: Vec<f64>,
) -> Result<StudyKind<ParameterSet>> {
    let of = displacement(a)?;
    let request = Sweep { exponents, start: a.of_paper.start, ..Sweep::new(axis, of, (a.discard, a.keep)) };
    Ok(StudyKind::Diagram { request, over: OverSweep { at, orbits: a.orbits.then(TreeOptions::default) } })
}

fn displacement(a: &Bifurcation) -> Result<Displacement> {
    a.of.as_ref().map_or(Ok(Displacement::X2), |of| of.parse().map_err(in_option("--of")))
}

/// Values at which spectra are listed: the given values; otherwise the value that was set, if the
/// axis contains it; otherwise the defaults of the axis.
fn listed(set: &ParameterSet, axis: &ParameterAxis, given: &[String]) -> Result<Vec<f64>> {
    if !given.is_empty() {
        let texts: Vec<&str> = given.iter().map(String::as_str).collect();
        let (values, _) = numbers(axis.name, &texts).map_err(in_option("--at"))?;
        values.iter().try_for_each(|value| axis.name.check(*value)).map_err(in_option("--at"))?;
        return Ok(values);
    }
    let own = axis.name.value(set);
    Ok(if set.is_set(axis.name) && (axis.from..=axis.to).contains(&own) {
        vec![own]
    } else if axis.name.name() == "f10" {
        SPECTRA.to_vec()
    } else {
        [0.25, 0.5, 0.75].map(|part| axis.from * (1.0 - part) + axis.to * part).to_vec()
    })
}

/// The study's name; a displacement other than the paper's X2 is appended to it.
fn name(study: &str, of: Displacement) -> String {
    if of == Displacement::X2 { study.into() } else { format!("{study}-{of}") }
}

/// Before work begins, refuses a parameter that orbits cannot vary.
fn check_orbits(set: &ParameterSet, kind: &StudyKind<ParameterSet>) -> Result<()> {
    match kind {
        StudyKind::Diagram { request: sweep, over: OverSweep { orbits: Some(_), .. } } => {
            studies::paper::sweep_family(set, sweep).map(drop)
        }
        _ => Ok(()),
    }
}

pub fn bifurcation(set: &ParameterSet, common: &Common, a: &Bifurcation) -> Result<()> {
    let kind = kind(axis(set, a)?, a, None, Vec::new())?;
    check_orbits(set, &kind)?;
    perform(&LongStudy::new(&name("bifurcation", displacement(a)?), kind, set), common, a.share.shard)
}

pub fn lyapunov(set: &ParameterSet, common: &Common, a: &Lyapunov) -> Result<()> {
    let options =
        SpectrumOptions { periods: a.periods, threshold: a.threshold, ..SpectrumOptions::default() };
    let axis = axis(set, &a.sweep)?;
    let kind = kind(axis, &a.sweep, Some(options), listed(set, &axis, &a.at)?)?;
    check_orbits(set, &kind)?;
    perform(
        &LongStudy::new(&name("lyapunov", displacement(&a.sweep)?), kind, set),
        common,
        a.sweep.share.shard,
    )
}

pub fn basin(set: &ParameterSet, common: &Common, a: &Basin) -> Result<()> {
    let p = set.parameters();
    let cells = |range: InitialValueRange| Ok::<_, Error>(range.scaled(p)?.cells(a.resolution.into()));
    let start = a.of_paper.start.unwrap_or_else(in_the_middle);
    let (x, y) = (cells(a.of_paper.x)?, cells(a.of_paper.y)?);
    let kind = StudyKind::Basin(BasinRequest { x, y, discard: a.discard, start });
    perform(&LongStudy::new("basin", kind, set), common, a.share.shard)
}

pub fn isoperiodic(
    set: &ParameterSet,
    common: &Common,
    a: &Isoperiodic,
    planes: &[(ParameterAxis, ParameterAxis)],
) -> Result<()> {
    let exponents = (a.periods > 0).then_some(a.periods);
    for &(x, y) in planes {
        let request = isoperiodic::IsoperiodicRequest { x, y, start: a.start, discard: a.discard, exponents };
        let name = format!("isoperiodic-{}-{}", x.name.name(), y.name.name());
        perform(&LongStudy::new(&name, StudyKind::Isoperiodic(request), set), common, a.share.shard)?;
    }
    Ok(())
}

/// Folder of a study's parts, relative to the folder of its results.
fn folder(study: &LongStudy) -> PathBuf {
    format!("{}.{PARTS}", study.name).into()
}

/// The folder for the parts and results of a study.
fn place(study: &LongStudy, common: &Common, invocation: &Invocation) -> Result<PathBuf> {
    let destination = Destination::new(common, invocation, study.work.subject());
    let mut claims = vec![Claim::Parts(folder(study), Manifest::of_parts(study, invocation))];
    claims.extend(study.results().iter().map(|name| destination.result(name)));
    destination.place(&claims)
}

/// Computes a study or a shard of it, and draws it when all parts are finished.
fn perform(study: &LongStudy, common: &Common, shard: Option<Shard>) -> Result<()> {
    perform_as(study, common, &common.invocation, shard)
}

/// Like [`perform`], but writes the given invocation, which the study may have extended, to the
/// manifests.
pub fn perform_as(
    study: &LongStudy,
    common: &Common,
    invocation: &Invocation,
    shard: Option<Shard>,
) -> Result<()> {
    study.check()?;
    let out = place(study, common, invocation)?;
    let manifest = Manifest::of_parts(study, invocation);
    let parts = PartFolder::open(&out.join(folder(study)), &manifest, common.discard_unfinished)?;
    complete(study, common, invocation, &out, parts, shard)
}

/// Computes the missing parts in an open folder of parts, which lies in `out`, and draws the study
/// when all are finished.
fn complete(
    study: &LongStudy,
    common: &Common,
    invocation: &Invocation,
    out: &Path,
    parts: PartFolder,
    shard: Option<Shard>,
) -> Result<()> {
    let (count, home) = (study.count(), out.join(folder(study)));
    interruption::announce(&study.name, home.clone(), vec![home.clone()], count);
    let progress = Progress::new(count.div_ceil(shard.map_or(1, |s| s.count)), "parts");
    let task = Task { store: &parts, shard: shard.unwrap_or(Shard::ALL), done: &|_| progress.step() };
    let found = study.run_telling(&task, &|done, total| progress.at(done, total))?;
    drop(progress);
    match found {
        Some(studies) => {
            Destination::new(common, invocation, study.work.subject()).write_into(&studies, out)?;
            study.write_tables(&Task { store: &parts, ..Task::ALL }, out)?;
            parts.remove()?;
            output::print(&studies, study.work.subject(), out, common)?;
            match studies.into_iter().find_map(|study| Some((study.name, study.failure?))) {
                Some((what, problem)) => Err(Error::Failed { what, problem }),
                None => Ok(()),
            }
        }
        None => output::say(&format!(
            "{} of {count} parts of `{}` are in {}; run `vibro merge` when all parts are finished",
            count - parts.missing(count),
            study.name,
            home.display()
        )),
    }
}

/// The folders of parts in `given`, or `given` itself if it is a folder of parts.
fn folders_of_parts(given: &Path) -> Result<Vec<PathBuf>> {
    let is_parts = |p: &Path| p.extension().is_some_and(|e| e == PARTS) && p.is_dir();
    if is_parts(given) {
        return Ok(vec![given.into()]);
    }
    if !given.exists() {
        return Err(Error::Config { path: given.into(), problem: "no such folder".into() });
    }
    let entries = std::fs::read_dir(given).map_err(Error::file("reading", given))?;
    let mut found: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| is_parts(p)).collect();
    found.sort();
    Ok(found)
}

/// Shards of one study: the study, its invocation, and the folders of the shards.
struct Shards {
    study: LongStudy,
    invocation: Invocation,
    folders: Vec<PathBuf>,
}

/// The shards in the given folders, by study.
fn shards(given: &[PathBuf]) -> Result<Vec<Shards>> {
    let mut found: Vec<Shards> = Vec::new();
    for given in given {
        let folders = folders_of_parts(given)?;
        if folders.is_empty() {
            let problem = "contains no shard (a folder NAME.parts); give the --out folder of a run with \
                           --shard (a study with one part is drawn by the shard that computes this part)"
                .into();
            return Err(Error::Config { path: given.clone(), problem });
        }
        for path in folders {
            let there = PartFolder::manifest(&path)?;
            let Manifest { invocation, long_study: Some(study), .. } = there.clone() else { continue };
            match found.iter_mut().find(|known| known.study.name == study.name) {
                Some(known) if known.study != study => {
                    let first = Manifest::of_parts(&known.study, &known.invocation);
                    let problem = format!(
                        "belongs to another study than {}, which is `there` in these differences: {}",
                        known.folders[0].display(),
                        first.differences_in_words(&there)
                    );
                    return Err(Error::Config { path, problem });
                }
                Some(known) => known.folders.push(path),
                None => found.push(Shards { study, invocation, folders: vec![path] }),
            }
        }
    }
    Ok(found)
}

pub fn merge(common: &Common, a: &Merge) -> Result<()> {
    for Shards { study, invocation, folders } in shards(&a.folders)? {
        let out = place(&study, common, &invocation)?;
        let home = out.join(folder(&study));
        let parts =
            PartFolder::open(&home, &Manifest::of_parts(&study, &invocation), common.discard_unfinished)?;
        folders.iter().try_for_each(|source| parts.take_over(source))?;
        let count = study.count();
        let missing = parts.missing(count);
        if missing > 0 {
            let problem = format!("{missing} of {count} parts are missing; run the other shards first");
            return Err(Error::Config { path: home, problem });
        }
        complete(&study, common, &invocation, &out, parts, None)?;
    }
    Ok(())
}

pub fn reproduce(set: &ParameterSet, common: &Common, a: &Reproduce) -> Result<()> {
    let (plan, invocation) = (report::Plan::new(set, a.quick)?, &common.invocation);
    let (destination, home) =
        (Destination::new(common, invocation, set), PathBuf::from(format!("reproduce.{PARTS}")));
    let manifests = plan.long_studies().map(|s| (home.join(&s.name), Manifest::of_parts(s, invocation)));
    let results = plan.results()?;
    let results = results.iter().map(|(name, set)| Claim::Result(Manifest::of_result(name, invocation, set)));
    let parts = manifests.iter().cloned().map(|(folder, manifest)| Claim::Parts(folder, manifest));
    let out = destination.place(&parts.chain(results).collect::<Vec<_>>())?;
    let open = |(folder, manifest): &(PathBuf, Manifest)| {
        PartFolder::open(&out.join(folder), manifest, common.discard_unfinished)
    };
    let [coarse, fine, basin] = &manifests;
    let folders = [open(coarse)?, open(fine)?, open(basin)?];
    let count = plan.long_studies().iter().map(|s| s.count()).sum();
    let paths = manifests.iter().map(|(folder, _)| out.join(folder)).collect();
    interruption::announce("reproduce", out.join(&home), paths, count);
    let progress = Progress::new(plan.steps(), "steps");
    let report = plan.run(&folders, &|_| progress.step())?;
    drop(progress);
    destination.write_into(&report.studies, &out)?;
    let page = destination.write_page("report", &report.html, &out)?;
    folders.into_iter().try_for_each(PartFolder::remove)?;
    // `remove_dir` fails if other files are in the folder; they are kept.
    let _ = std::fs::remove_dir(out.join(&home));
    output::say(&format!("{}{}", output::apart(&out, common), report.summary(&page)))
}
