//! Long studies: in parts on disk, as shards, merged, and all together.

use crate::arguments::{Basin, Bifurcation, Common, Isoperiodic, Lyapunov, Merge, Reproduce};
use crate::output;
use crate::progress::Progress;
use std::path::{Path, PathBuf};
use vibro::report;
use vibro::words;
use vibro::work::{Kind, Work};
use vibro_analysis::basin::{self, Axis};
use vibro_analysis::bifurcation::Sweep;
use vibro_analysis::isoperiodic;
use vibro_analysis::lyapunov::Options;
use vibro_analysis::parts::{Parts, Shard, Task};
use vibro_analysis::plane::PlaneAxis;
use vibro_analysis::{Error, Result, Settings};

/// Ending of the folders of parts.
const PARTS: &str = "parts";

fn kind(a: &Bifurcation, exponents: Option<Options>, at: &[f64]) -> Result<Kind> {
    let (group, range) = words::range(&a.range)?;
    let axis = PlaneAxis::new(group, range, a.resolution.into())?;
    let sweep = Sweep { axis, discard: a.discard, keep: a.keep, exponents };
    Ok(Kind::Sweep { sweep, at: at.to_vec() })
}

pub fn bifurcation(settings: &Settings, common: &Common, a: &Bifurcation) -> Result<()> {
    perform(&Work::new("bifurcation", kind(a, None, &[])?, settings), common, a.share.shard)
}

pub fn lyapunov(settings: &Settings, common: &Common, a: &Lyapunov) -> Result<()> {
    if !(a.threshold >= 0.0 && a.threshold.is_finite()) {
        let text = format!("--threshold {}", a.threshold);
        return Err(Error::Form { text, expected: "a finite number >= 0" });
    }
    let options = Options { periods: a.periods, threshold: a.threshold, ..Options::default() };
    let kind = kind(&a.sweep, Some(options), &a.at)?;
    perform(&Work::new("lyapunov", kind, settings), common, a.sweep.share.shard)
}

pub fn basin(settings: &Settings, common: &Common, a: &Basin) -> Result<()> {
    let count = usize::from(a.resolution);
    let (x, y) = (Axis::parse(&a.x, count)?, Axis::parse(&a.y, count)?);
    let kind = Kind::Basin(basin::Request { x, y, discard: a.discard });
    perform(&Work::new("basin", kind, settings), common, a.share.shard)
}

pub fn isoperiodic(
    settings: &Settings,
    common: &Common,
    a: &Isoperiodic,
    planes: &[(PlaneAxis, PlaneAxis)],
) -> Result<()> {
    let exponents = (a.periods > 0).then(|| Options { periods: a.periods, ..Options::default() });
    for &(x, y) in planes {
        let request = isoperiodic::Request { x, y, start: a.start, discard: a.discard, exponents };
        let name = format!("isoperiodic-{}-{}", x.group.name, y.group.name);
        perform(&Work::new(&name, Kind::Isoperiodic(request), settings), common, a.share.shard)?;
    }
    Ok(())
}

fn folder(out: &Path, work: &Work) -> PathBuf {
    out.join(format!("{}.{PARTS}", work.name))
}

/// Computes a study or a share of it; draws it when all of it is there.
fn perform(work: &Work, common: &Common, shard: Option<Shard>) -> Result<()> {
    let (out, count) = (&common.out, work.count());
    let parts = Parts::open(&folder(out, work), work)?;
    let progress = Progress::new(count.div_ceil(shard.map_or(1, |s| s.count)), "parts");
    let found =
        work.run(&Task { parts: &parts, shard: shard.unwrap_or(Shard::ALL), done: &|_| progress.step() })?;
    drop(progress);
    match found {
        Some(studies) => {
            output::write(&studies, out)?;
            parts.remove()?;
            output::print(&studies, &work.settings, out)
        }
        None => output::say(&format!(
            "{} of {count} parts of `{}` are in {}; `vibro merge` draws it when all are there",
            count - parts.missing(count),
            work.name,
            folder(out, work).display()
        )),
    }
}

/// The folders of parts in a folder, or itself if it is one.
fn folders_of_parts(given: &Path) -> Result<Vec<PathBuf>> {
    let is_parts = |p: &Path| p.extension().is_some_and(|e| e == PARTS) && p.is_dir();
    if is_parts(given) {
        return Ok(vec![given.into()]);
    }
    let entries = std::fs::read_dir(given).map_err(Error::file("reading", given))?;
    let mut found: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| is_parts(p)).collect();
    found.sort();
    Ok(found)
}

pub fn merge(common: &Common, a: &Merge) -> Result<()> {
    let mut works: Vec<(Work, Vec<PathBuf>)> = Vec::new();
    for given in &a.folders {
        let found = folders_of_parts(given)?;
        if found.is_empty() {
            let problem = "holds no shard: no folder that ends in .parts".into();
            return Err(Error::Config { path: given.clone(), problem });
        }
        for path in found {
            let work: Work = Parts::manifest(&path)?;
            match works.iter_mut().find(|w| w.0.name == work.name) {
                Some(known) if known.0 != work => {
                    let problem = format!("is part of another study than {}", known.1[0].display());
                    return Err(Error::Config { path, problem });
                }
                Some(known) => known.1.push(path),
                None => works.push((work, vec![path])),
            }
        }
    }
    for (work, sources) in &works {
        let parts = Parts::open(&folder(&common.out, work), work)?;
        sources.iter().try_for_each(|source| parts.take_over(source))?;
        let count = work.count();
        let missing = parts.missing(count);
        if missing > 0 {
            let problem = format!("{missing} of {count} parts are missing; run the other shards too");
            return Err(Error::Config { path: folder(&common.out, work), problem });
        }
        perform(work, common, None)?;
    }
    Ok(())
}

pub fn reproduce(settings: &Settings, common: &Common, a: &Reproduce) -> Result<()> {
    let plan = report::Plan::new(settings, a.quick)?;
    let progress = Progress::new(plan.steps(), "steps");
    let home = common.out.join(format!("reproduce.{PARTS}"));
    let report = plan.run(&home, &|_| progress.step())?;
    drop(progress);
    output::write(&report.studies, &common.out)?;
    let path = common.out.join("report.html");
    vibro_analysis::parts::write_whole(&path, report.html.as_bytes())?;
    std::fs::remove_dir_all(&home).map_err(Error::file("writing", &home))?;
    output::say(&report.summary(&path))
}
