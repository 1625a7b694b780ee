//! `vibro orbits`, `vibro orbit`, `vibro locus`: from their arguments to the library's studies.

use crate::arguments::Common;
use crate::long::perform_as;
use crate::ranges::{ParameterRange, shown};
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;
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

/// A constant load, as `block=0.02`.
#[derive(Clone, Copy, Debug)]
pub struct LoadArgument {
    body: usize,
    force: f64,
}

impl FromStr for LoadArgument {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form =
            || Error::form(text, "body=force in N with a body of box, block, secondary, e.g. block=-0.02");
        let (body, force) = text.split_once('=').ok_or_else(form)?;
        let body =
            ["box", "block", "secondary"].iter().position(|name| *name == body.trim()).ok_or_else(form)?;
        let force = force.trim().parse::<f64>().ok().filter(|f| f.is_finite()).ok_or_else(form)?;
        Ok(Self { body, force })
    }
}

/// Which orbit.
#[derive(Args, Debug)]
pub struct Which {
    /// Its impact word in letters U (upper stop) and L (lower stop); the orbit of the settled motion unless given. A word that
    /// ends in "-" is half of a symmetric orbit: U- is the motion with two symmetric impacts a period
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    pub word: Option<String>,
    /// Its period in drive periods, for --word
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub period: u32,
    /// A constant load in N on box, block or secondary; may be repeated. A gap off its centre by d is the pair
    /// block=-k23*d, secondary=k23*d
    #[arg(long, value_name = "BODY=FORCE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
}

impl Which {
    fn loads(&self) -> ConstantLoads {
        let mut loads = ConstantLoads::NONE;
        self.load.iter().for_each(|load| loads.forces[load.body] += load.force);
        loads
    }

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

/// Arguments of `orbit`.
#[derive(Args, Debug)]
pub struct OneOrbit {
    /// The orbit.
    #[command(flatten)]
    pub which: Which,
}

/// Arguments of `orbits`.
#[derive(Args, Debug)]
pub struct Orbits {
    /// Parameter and range [default: f10=0.5:5]
    #[arg(long, visible_alias = "range", value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    pub vary: Option<ParameterRange>,
    /// The orbit with which a single branch begins, at the value that was set.
    #[command(flatten)]
    pub which: Which,
    /// All branches: from settled motions over the whole range, rising and falling, and from every special point
    #[arg(long, conflicts_with_all = ["word", "period"])]
    pub tree: bool,
    /// Switches of branches that are followed one after another
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(0..=40))]
    pub depth: u32,
    /// Values of the parameter at which motions are settled, in each direction
    #[arg(long, value_name = "N", default_value_t = 91, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub seeds: u32,
    /// Most impacts in a word
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=128))]
    pub letters: u32,
    /// Longest step along a branch: phases in rad, the parameter in fifths of its range
    #[arg(long, value_name = "X", default_value_t = 0.05)]
    pub step: f64,
    /// At a touch, words that list it once in up to so many passages of the orbit are followed too, which have a longer period
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub repetitions: u32,
    /// Values of the parameter at which every branch gets a point, labelled UZ; separated by commas, and may be repeated
    #[arg(long, value_name = "VALUE", value_delimiter = ',', allow_hyphen_values = true)]
    pub mark: Vec<String>,
}

/// Arguments of `locus`.
#[derive(Args, Debug)]
pub struct Loci {
    /// A special point from which a curve is followed: a file written by `vibro orbits` and a row, counted from 1. May be
    /// repeated
    #[arg(long, required = true, value_name = "FILE:ROW")]
    pub from: Vec<String>,
    /// Curves of this kind only: LP, BP, PD, NS or GR
    #[arg(long, value_name = "LABEL")]
    pub label: Option<String>,
    /// The two parameters and their ranges, horizontal first; the first is that of the special points
    #[arg(
        long,
        visible_alias = "range",
        required = true,
        value_name = "NAME=FROM:TO",
        allow_hyphen_values = true
    )]
    pub vary: Vec<ParameterRange>,
    /// A constant load in N on box, block or secondary; may be repeated
    #[arg(long, value_name = "BODY=FORCE", allow_hyphen_values = true)]
    pub load: Vec<LoadArgument>,
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
    Ok(Family::new(set, a.which.loads(), span(&range)?)?)
}

/// The values that are marked.
fn marks(a: &Orbits, along: &Span) -> Result<Vec<f64>> {
    let texts: Vec<&str> = a.mark.iter().map(String::as_str).collect();
    let marks = numbers(along.name, &texts)?;
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
    let kind = StudyKind::Orbits { span, loads: a.which.loads(), options };
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
    let system = System::with_loads(set.parameters(), a.which.loads())?;
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
    let mut loads = ConstantLoads::NONE;
    a.load.iter().for_each(|load| loads.forces[load.body] += load.force);
    let family = Family::over_two(set, loads, span(&first)?, span(&second)?)?;
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
