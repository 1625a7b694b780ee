//! `vibro orbits`, `vibro orbit`, `vibro locus`: from their arguments to the library's studies.

use crate::arguments::Common;
use crate::long::perform_as;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits, Which};
use crate::ranges::{ParameterRange, shown};
use std::path::PathBuf;
use vibro::long_study::{LongStudy, StudyKind};
use vibro::studies::{self, Study};
use vibro::{Error, Result};
use vibro_analysis::orbits::{
    Branch, ConstantLoads, Family, Label, LocusStart, Orbit, OrbitWord, PathOptions, Span, System,
    TreeOptions, branch, locus, orbit_of, search, settle,
};
use vibro_analysis::stroboscopic::moving_block;
use vibro_analysis::{Name, ParameterSet, find_group, numbers};

/// Guesses of the phases from which the orbits of a word are sought.
const TRIES: u32 = 400;
/// Drive periods in which the transient of a motion dies out whose orbit is sought.
const SETTLE: u32 = 2000;

impl Which {
    /// The orbits of the word, those nearest to stability first; or the one of the settled motion.
    fn orbits(&self, system: &System) -> Result<Vec<Orbit>> {
        let Some(text) = &self.word else {
            let state = settle(system, &moving_block(system.parameters()), SETTLE)?;
            return Ok(vec![orbit_of(system, &state)?]);
        };
        let word = match text.strip_suffix('-') {
            Some(half) => OrbitWord::new(half, -1, self.period)?,
            None => OrbitWord::new(text.strip_suffix('+').unwrap_or(text), 1, 2 * self.period)?,
        };
        if word.closing() < 0 && !system.is_symmetric() {
            let problem = "a symmetric orbit needs a machine without loads; give the whole word";
            return Err(Error::Refused { what: format!("--word {text}"), problem: problem.into() });
        }
        let mut found = search(system, &word, TRIES)?;
        found.sort_by(|a, b| a.spectral_radius().total_cmp(&b.spectral_radius()));
        Ok(found)
    }
}

fn span(range: &ParameterRange) -> Result<Span> {
    if range.count.is_some() {
        let expected =
            "name=from:to without a count: branches are followed and have no fixed number of values";
        return Err(Error::form(range.name.name(), expected));
    }
    Ok(Span::new(range.name, range.ends.0, range.ends.1)?)
}

/// The family over the parameter of the command.
fn family(set: &ParameterSet, a: &Orbits) -> Result<Family> {
    let default = || Ok::<_, Error>(shown(set, Name::from(find_group("f10")?), (0.5, 5.0)));
    let range = a.vary.map_or_else(default, Ok)?;
    if !PathOptions::STEPS.contains(&a.step) {
        return Err(Error::form(format!("--step {}", a.step), "a length from 1e-5 to 0.2"));
    }
    Ok(Family::new(set, ConstantLoads::NONE, span(&range)?)?)
}

/// The values that are marked.
fn marks(a: &Orbits, along: &Span) -> Result<Vec<f64>> {
    let texts: Vec<&str> = a.mark.iter().map(String::as_str).collect();
    let (marks, _) = numbers(along.name, &texts)?;
    marks.iter().try_for_each(|mark| along.name.check(*mark))?;
    match marks.iter().find(|mark| !(along.from..=along.to).contains(*mark)) {
        None => Ok(marks),
        Some(mark) => {
            let what = format!("--mark {mark}");
            let problem = format!("must lie in the range {} to {}", along.from, along.to);
            Err(Error::Refused { what, problem })
        }
    }
}

/// All branches, in parts that are kept until they are finished.
fn whole_tree(set: &ParameterSet, common: &Common, a: &Orbits) -> Result<()> {
    let family = family(set, a)?;
    let span = *family.span();
    let options = TreeOptions {
        seeds: a.seeds as usize,
        depth: a.depth,
        most_letters: a.letters as usize,
        longest_step: a.step,
        repetitions: a.repetitions,
        marks: marks(a, &span)?,
        ..TreeOptions::default()
    };
    let kind = StudyKind::Orbits { span, loads: ConstantLoads::NONE, options };
    perform_as(&LongStudy::new("orbits", kind, set), common, &common.invocation, None)
}

/// The branches of single orbits; `None` where all branches are asked for, which are computed and written in parts.
pub fn orbits(set: &ParameterSet, common: &Common, a: &Orbits) -> Result<Option<Study>> {
    if a.tree {
        return whole_tree(set, common, a).map(|()| None);
    }
    let family = family(set, a)?;
    let span = *family.span();
    let value = span.name.value(set);
    if !(span.from..=span.to).contains(&value) {
        let what = format!("{} = {value}", span.name.name());
        let problem =
            format!("the branch begins here, so it must lie in the range {} to {}", span.from, span.to);
        return Err(Error::Refused { what, problem });
    }
    let orbits = a.which.orbits(&family.system(&[value])?)?;
    let options = PathOptions { longest_step: a.step, ..PathOptions::default() };
    let marks = marks(a, &span)?;
    let mut branches: Vec<Branch> = Vec::new();
    for orbit in &orbits {
        if !branches.iter().any(|b| b.holds(&family, orbit, value)) {
            let mut found = branch(&family, orbit.word(), orbit.phases(), value, &options, &marks)?;
            found.id = branches.len();
            branches.push(found);
        }
    }
    studies::orbits(set, &family, &branches).map(Some)
}

pub fn orbit(set: &ParameterSet, a: &OneOrbit) -> Result<Study> {
    let system = System::new(set.parameters())?;
    let found = a.which.orbits(&system)?;
    studies::orbit(set, &found[0], found.len() - 1)
}

pub fn loci(set: &ParameterSet, a: &Loci) -> Result<Study> {
    let [first, second] = a.vary[..] else {
        return Err(Error::form(
            format!("{} --vary", a.vary.len()),
            "two, e.g. --vary f10=0.5:3 --vary kappa=0.5:0.9",
        ));
    };
    let family = Family::over_two(set, ConstantLoads::NONE, span(&first)?, span(&second)?)?;
    let held = second.name.value(set);
    let mut curves = Vec::new();
    for from in &a.from {
        let start = start(from, first.name, held)?;
        if a.label.as_ref().is_some_and(|label| label != start.label.name()) {
            continue;
        }
        let points = locus(&family, &start)?;
        curves.push((start, points));
    }
    if curves.is_empty() {
        let what = format!("--label {}", a.label.as_deref().unwrap_or_default());
        return Err(Error::Refused { what, problem: "none of the points has this label".into() });
    }
    studies::loci(set, &family, &curves)
}

/// A special point of a table, as `special-points.csv:12`.
fn start(text: &str, along: Name, held: f64) -> Result<LocusStart> {
    let form = || Error::form(text, "file:row with a table of special points and a row counted from 1");
    let (path, row) = text.rsplit_once(':').ok_or_else(form)?;
    let (path, row) = (PathBuf::from(path), row.parse::<usize>().ok().filter(|r| *r > 0).ok_or_else(form)?);
    let wrong = |problem: String| Error::Config { path: path.clone(), problem };
    let mut reader = csv::Reader::from_path(&path).map_err(|e| wrong(e.to_string()))?;
    let header = reader.headers().map_err(|e| wrong(e.to_string()))?.clone();
    let record = reader.records().nth(row - 1).ok_or_else(|| wrong(format!("has no row {row}")))?;
    let record = record.map_err(|e| wrong(e.to_string()))?;
    let cell = |name: &str| -> Result<&str> {
        let index = header.iter().position(|h| h == name);
        index
            .and_then(|i| record.get(i))
            .ok_or_else(|| wrong(format!("has no column `{name}`: is it special-points.csv?")))
    };
    if Name::find(cell("parameter")?)? != along {
        let problem =
            format!("has points over {}, but the first --vary is of {}", cell("parameter")?, along.name());
        return Err(wrong(problem));
    }
    let label =
        [Label::Fold, Label::BranchPoint, Label::PeriodDoubling, Label::NeimarkSacker, Label::Grazing];
    let name = cell("label")?;
    let no_curve = || wrong(format!("row {row} is {name}; curves start from LP, BP, PD, NS and GR"));
    let label = label.into_iter().find(|l| l.name() == name).ok_or_else(no_curve)?;
    let number =
        |text: &str| text.parse::<f64>().map_err(|_| wrong(format!("row {row}: `{text}` is no number")));
    let phases = cell("phases")?.split_whitespace().map(number).collect::<Result<Vec<_>>>()?;
    let closing: i8 = if cell("closing")? == "-" { -1 } else { 1 };
    let period: u32 = cell("period")?.parse().map_err(|_| wrong(format!("row {row}: no period")))?;
    let half = if closing < 0 { period } else { 2 * period };
    let text = cell("word")?;
    if label == Label::Grazing && text != cell("longer_word")? {
        return Err(wrong(format!(
            "row {row} is a touch seen from the word without it; take the row of the branch {}",
            cell("longer_word")?
        )));
    }
    let word = OrbitWord::new(text, closing, half)?;
    Ok(LocusStart { label, word, phases, values: [number(cell("value")?)?, held] })
}
