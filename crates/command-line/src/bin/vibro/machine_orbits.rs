//! `orbit`, `orbits`, `locus` and `response` with a machine's file: from arguments to the
//! library's studies.

use crate::common_arguments::{Common, SectionArguments, time};
use crate::destination::{self, Destination};
use crate::interruption::{self, Second};
use crate::loci::{Curves, chosen, followed};
use crate::machine_studies::{RANGE, default_quantity, invocation, machine, read_axis, start_of};
use crate::orbits_arguments::{Loci, OneOrbit, Orbits, ResponseOfFile, Settling};
use crate::output;
use crate::progress::Progress;
use crate::ranges::{in_option, other_number};
use crate::study_arguments::Response;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use vibro::special_points::PointOfFile;
use vibro::studies::{self, Study};
use vibro::whole_file::write_whole;
use vibro::{Error, Result};
use vibro_machine::{Assembly, Start};
use vibro_orbits::paper::PathOptions;
use vibro_orbits::{
    Branch, Family, KeptPaths, LocusPoint, LocusStart, Orbit, TreeOptions, WantedPeriod, WantedWord,
    WordSearch, branch, check_second, locus, read_measure, tree_on,
};
use vibro_studies::{Machine, Measure};

/// Longest period in common periods of the drive.
const MOST_PERIODS: u32 = 32;

/// The measure of an option: a measure, or the largest value of a quantity.
fn measure(machine: &Machine, of: Option<&String>, option: &'static str) -> Result<Measure> {
    match of {
        Some(of) => read_measure(of, &machine.description).map_err(in_option(option)),
        None => Ok(Measure::Amplitude(default_quantity(machine)?)),
    }
}

fn written(studies: &[Study], machine: &Machine, destination: &Destination, common: &Common) -> Result<()> {
    let held = destination::hold(&common.out);
    let out = destination.write(studies)?;
    drop(held);
    output::print(studies, machine, &out, common)
}

/// The error of a study of orbits, whose commands have no option for the period of a section.
pub fn without_period(error: Error) -> Error {
    match error {
        Error::Analysis(vibro_studies::Error::NoSection { problem, has_elements }) => {
            let problem = match has_elements {
                true => format!("{problem}; give a stop or friction as section (--section)"),
                false => {
                    let required = "orbits require harmonics with a common period, a stop or a friction";
                    format!("{problem}; {required}{}", vibro_studies::OR_NEW_SECTION)
                }
            };
            vibro_studies::Error::Described { problem }.into()
        }
        other => other,
    }
}

/// The period of `--period`: `2T`, or a time.
fn period(text: &String) -> Result<WantedPeriod> {
    let turns = text.trim().strip_suffix('T').map(|n| n.trim().parse::<u32>());
    let found = match turns {
        Some(Ok(n @ 1..=MOST_PERIODS)) => Some(WantedPeriod::Drive(n)),
        Some(_) => None,
        None => time(text).ok().map(WantedPeriod::Time),
    };
    found.ok_or_else(|| {
        let problem = format!("expected 1T to {MOST_PERIODS}T, or a finite time > 0, e.g. 0.1s");
        Error::Refused { what: format!("--period {text}"), problem }
    })
}

/// The requested orbit; `None` for the orbit of the settled motion.
fn wanted(machine: &Machine, a: &OneOrbit, start: &Start) -> Result<Option<WordSearch>> {
    if a.word.is_none() && a.period.is_none() {
        return Ok(None);
    }
    let assembly = Assembly::new(machine.description.clone())?;
    let word = a.word.as_ref().map(|word| WantedWord::parse(word, &assembly)).transpose()?;
    let period = a.period.as_ref().map(period).transpose()?;
    let (start, starts, discard) = (start.clone(), a.starts, a.settling.discard);
    Ok(Some(WordSearch { start, word, period, starts, discard }))
}

/// Finds one orbit: the orbit on which a motion settles, or one with a given word or period.
pub fn orbit(file: &Path, common: &Common, a: &OneOrbit) -> Result<()> {
    let settling = &a.settling;
    let machine = machine(file, &settling.section(), common)?;
    let start = start_of(&machine, &settling.start)?;
    let of = a.gradient.as_ref().map(|of| measure(&machine, Some(of), "--gradient")).transpose()?;
    let wanted = wanted(&machine, a, &start)?;
    let mut options = vec![("start", start.to_string()), ("discard", settling.discard.to_string())];
    options.extend(of.as_ref().map(|of| ("gradient", of.to_string())));
    if let Some(WordSearch { word, period, starts, .. }) = &wanted {
        options.extend(word.as_ref().map(|word| ("word", word.to_string())));
        options.extend(period.map(|period| ("period", format!("{period:?}"))));
        options.push(("starts", starts.to_string()));
    }
    let invocation = invocation(common, &options);
    let destination = Destination::new(common, &invocation, &machine);
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result("orbit")])?;
    let orbit = match &wanted {
        None => Orbit::settled(&machine, &start, settling.discard)?,
        Some(wanted) => {
            let progress = Progress::new(wanted.most_returns(), "returns at most");
            Orbit::search(&machine, wanted, &|| {
                progress.step();
                true
            })?
        }
    };
    let mut study = studies::orbit(&machine, &orbit, "orbit")?;
    if let Some(of) = of {
        studies::add_gradient(&mut study, &machine, &orbit, &of)?;
    }
    written(&[study], &machine, &destination, common)?;
    write_whole(&out.join("start.toml"), orbit.start().to_toml().as_bytes())
}

/// The family of the one parameter of `--vary`.
fn family(machine: &mut Machine, vary: &[String]) -> Result<Family> {
    let [vary] = vary else {
        let expected = "expected one parameter, as --vary NAME=FROM:TO, e.g. stop.steel.gap=1mm:8mm";
        return Err(other_number("--vary", expected, vary.len()));
    };
    family_over(machine, vary)
}

/// The family over a range of a parameter.
fn family_over(machine: &mut Machine, vary: &str) -> Result<Family> {
    let axis = read_axis(machine, vary, RANGE)?;
    let range = axis.range().ok_or_else(|| Error::form(vary, RANGE))?;
    if range.count.is_some() {
        let form = "NAME=FROM:TO without a count: the steps along a branch are chosen by the program";
        return Err(Error::form(vary, form));
    }
    Ok(Family::new(machine, &range.name, range.ends)?)
}

/// The family's parameter and its range, for manifests.
fn in_words(family: &Family) -> String {
    format!("{}={}:{}", family.parameter, family.range.0, family.range.1)
}

/// A folder of paths, one file per path.
struct FolderOfPaths(PathBuf);

impl FolderOfPaths {
    fn file(&self, key: u64) -> PathBuf {
        self.0.join(format!("{key:016x}.path"))
    }
}

impl KeptPaths for FolderOfPaths {
    fn find(&self, key: u64) -> Option<Vec<u8>> {
        std::fs::read(self.file(key)).ok()
    }

    fn keep(&self, key: u64, bytes: &[u8]) {
        // A path that cannot be stored is followed again.
        let _ = std::fs::create_dir_all(&self.0);
        let _ = write_whole(&self.file(key), bytes);
    }
}

/// The branches of a tree, and whether all were followed. Ctrl-C ends the growth; stored paths let
/// a later run continue.
fn grown(family: &Family, options: &TreeOptions, paths: PathBuf) -> Result<(Vec<Branch>, bool)> {
    let stop = interruption::flag(Second::Waits);
    let progress = Progress::new(0, "branches");
    let kept = FolderOfPaths(paths);
    let found = tree_on(family, options, &kept, &mut |found, all| {
        progress.at(found.len(), all);
        !stop.load(Ordering::Relaxed)
    })?;
    let is_whole = !stop.load(Ordering::Relaxed);
    if is_whole {
        // The folder is absent if nothing was followed.
        let _ = std::fs::remove_dir_all(&kept.0);
    }
    Ok((found, is_whole))
}

/// Branches over a parameter, as requested by a command.
struct Asked<'a> {
    name: &'static str,
    vary: &'a [String],
    of: Option<&'a String>,
    settling: &'a Settling,
    step: f64,
    /// Number of values with settled motions, and largest number of branch switches in a row;
    /// `None` for the single branch of the settled motion.
    tree: Option<(u32, u32)>,
}

type MakeStudy = fn(&Machine, &Family, &[Branch], &Measure, &str) -> Result<Study>;

/// Follows branches and writes their study. `options` are the command's own options, for
/// manifests; `vary` is the option of the range. Returns whether all branches were followed.
fn branches(
    file: &Path,
    common: &Common,
    asked: &Asked,
    (vary, options): (&'static str, Vec<(&'static str, String)>),
    study: MakeStudy,
) -> Result<bool> {
    let Asked { name, settling, step, .. } = *asked;
    let mut machine = machine(file, &settling.section(), common)?;
    let family = family(&mut machine, asked.vary)?;
    let start = start_of(&machine, &settling.start)?;
    // A section that the machine lacks would be an error of each motion, and no orbit would be found.
    machine.motion(&start)?;
    let measure = measure(&machine, asked.of, "--of")?;
    let all = [
        (vary, in_words(&family)),
        ("of", measure.to_string()),
        ("start", start.to_string()),
        ("discard", settling.discard.to_string()),
        ("step", step.to_string()),
    ];
    let invocation = invocation(common, &[&all, &options[..]].concat());
    let destination = Destination::new(common, &invocation, &machine);
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result(name)])?;
    let (path, discard) = (PathOptions { longest_step: step, ..PathOptions::default() }, settling.discard);
    let (branches, is_whole) = match asked.tree {
        Some((seeds, depth)) => {
            let options = TreeOptions { start, seeds: seeds as usize, discard, depth, path };
            grown(&family, &options, out.join(format!("{name}-paths")))?
        }
        None => (vec![branch(&family, &Orbit::settled(&machine, &start, discard)?, &path)?], true),
    };
    let mut study = study(&machine, &family, &branches, &measure, name)?;
    if !is_whole {
        study
            .remarks
            .push("interrupted before all branches were followed; the same command line continues".into());
    }
    written(&[study], &machine, &destination, common).map(|()| is_whole)
}

/// The branches over a parameter: the branch of the settled motion, or all.
pub fn orbits(file: &Path, common: &Common, a: &Orbits) -> Result<bool> {
    let (of, settling) = (a.of_file.of.as_ref(), &a.of_file.settling);
    let tree = a.tree.then_some((a.seeds, a.depth));
    let asked = Asked { name: "orbits", vary: &a.vary, of, settling, step: a.step, tree };
    let options = vec![("tree", a.tree.to_string())];
    branches(file, common, &asked, ("vary", options), studies::orbits)
}

/// The response: the branches of the orbits on which motions settle, rising and falling.
pub fn response(file: &Path, common: &Common, a: &Response) -> Result<bool> {
    let ResponseOfFile { settling, seeds, depth, step } = &a.of_file;
    let (of, tree) = (a.of.as_ref(), Some((*seeds, *depth)));
    let asked = Asked { name: "response", vary: &a.range, of, settling, step: *step, tree };
    let options = vec![("seeds", seeds.to_string()), ("depth", depth.to_string())];
    branches(file, common, &asked, ("range", options), studies::response)
}

/// Curves of special points over two parameters.
pub fn loci(file: &Path, common: &Common, a: &Loci) -> Result<()> {
    let mut machine = machine(file, &SectionArguments { period: None, section: None }, common)?;
    let [first, second] = &a.vary[..] else {
        let expected = "expected two parameters, first the parameter of the special points, e.g. --vary \
                        load.shaker.amplitude=1N:9N --vary stop.steel.gap=1mm:8mm";
        return Err(other_number("--vary", expected, a.vary.len()));
    };
    let families = [family_over(&mut machine, first)?, family_over(&mut machine, second)?];
    let [over, second] = &families;
    check_second(over, second)?;
    let number = |text: &str| Ok(machine.quantity(&over.parameter, text)?.value);
    let points = chosen(a, &over.parameter, &number)?;
    let from: Vec<&str> = points.iter().map(|(from, _)| from.as_str()).collect();
    let options = [("vary", format!("{} {}", in_words(over), in_words(second))), ("from", from.join(" "))];
    let invocation = invocation(common, &options);
    let destination = Destination::new(common, &invocation, &machine);
    // The folder is checked before work begins.
    destination.place(&[destination.result("locus")])?;
    let (curves, problems) = followed(&families, &points)?;
    let study = studies::loci(&machine, [over, second], &curves, &problems)?;
    written(&[study], &machine, &destination, common)
}

/// The curves over the parameters of two families.
impl Curves for [Family; 2] {
    type Point = PointOfFile;
    /// The special point with the word of its row, and with its shortest word.
    type Start = (LocusStart, LocusStart);
    type Shown = LocusStart;

    /// The special point is searched for on the branch of the orbit next to it.
    fn start(&self, point: &PointOfFile) -> Result<Self::Start> {
        let PointOfFile { special, value, beside: (at, period, start), .. } = point;
        let start = LocusStart::from_beside(&self[0], (special, *value), (*at, *period, start))?;
        let shortest = start.shortest();
        Ok((start, shortest))
    }

    fn is_same(&self, (_, one): &Self::Start, (_, other): &Self::Start) -> bool {
        one.is_same(other)
    }

    fn follow(
        &self,
        point: &PointOfFile,
        (start, shortest): &Self::Start,
    ) -> Result<(LocusStart, Vec<LocusPoint>)> {
        let mut shown = shortest.clone();
        shown.special = point.special.clone();
        Ok((shown, locus(start, &self[1])?))
    }
}
