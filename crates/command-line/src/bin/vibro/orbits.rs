//! `vibro orbits`, `vibro orbit`, `vibro locus`: from their arguments to the library's studies.

use crate::common_arguments::Common;
use crate::loci::{Curves, chosen, followed};
use crate::long::perform_as;
use crate::orbits_arguments::{Loci, OneOrbit, Orbits, Which};
use crate::ranges::{ParameterRange, in_option, shown};
use vibro::long_study::{LongStudy, StudyOfMachine};
use vibro::special_points::SpecialPoint;
use vibro::studies::{self, Study};
use vibro::{Error, Result};
use vibro_orbits::paper::{
    Branch, Family, LocusPoint, LocusStart, Orbit, OrbitWord, PathOptions, Span, System, TreeOptions, branch,
    locus, orbit_of, search, settle,
};
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{Name, ParameterSet, find_group, number, numbers};

/// Number of guesses of the phases for the orbits of a word.
const TRIES: u32 = 400;
/// Drive periods discarded before the orbit of a settled motion is searched.
const SETTLE: u32 = 2000;

impl Which {
    /// The orbits of the word: orbits without a shorter word come before the others, and in both
    /// groups the orbit nearest to stability comes first. Without a word, the orbit of the settled
    /// motion.
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
            let problem = "a symmetric orbit requires a machine without constant loads; give the whole word";
            return Err(Error::Refused { what: format!("--word {text}"), problem: problem.into() });
        }
        let mut found = search(system, &word, TRIES)?;
        found.sort_by(|a, b| a.spectral_radius().total_cmp(&b.spectral_radius()));
        found.sort_by_key(|orbit| !orbit.is_shortest());
        Ok(found)
    }
}

fn span(range: &ParameterRange) -> Result<Span> {
    if range.count.is_some() {
        let expected = "name=from:to without a count: the steps along a branch are chosen by the program";
        return Err(Error::form(range.name.name(), expected));
    }
    Ok(Span::new(range.name, range.ends.0, range.ends.1)?)
}

/// The family over the parameter of the command.
fn family(set: &ParameterSet, a: &Orbits) -> Result<Family> {
    let default = || Ok::<_, Error>(shown(set, Name::from(find_group("f10")?), (0.5, 5.0)));
    let range = a.range.map_or_else(default, Ok)?;
    Ok(Family::new(set, span(&range)?)?)
}

/// Values at which branches get a point.
fn marks(a: &Orbits, along: &Span) -> Result<Vec<f64>> {
    let texts: Vec<&str> = a.of_paper.mark.iter().map(String::as_str).collect();
    let (marks, _) = numbers(along.name, &texts).map_err(in_option("--mark"))?;
    marks.iter().try_for_each(|mark| along.name.check(*mark)).map_err(in_option("--mark"))?;
    match marks.iter().find(|mark| !(along.from..=along.to).contains(*mark)) {
        None => Ok(marks),
        Some(mark) => {
            let what = format!("--mark {mark}");
            let problem = format!("must lie in the range {} to {}", along.from, along.to);
            Err(Error::Refused { what, problem })
        }
    }
}

/// Computes all branches, in parts that are stored until the study is finished.
fn whole_tree(set: &ParameterSet, common: &Common, a: &Orbits) -> Result<()> {
    let family = family(set, a)?;
    let span = *family.span();
    let options = TreeOptions {
        seeds: a.seeds as usize,
        starts: a.of_paper.starts as usize,
        depth: a.depth,
        most_letters: a.of_paper.letters as usize,
        longest_step: a.step,
        repetitions: a.of_paper.repetitions,
        marks: marks(a, &span)?,
        ..TreeOptions::default()
    };
    let work = StudyOfMachine::Branches { set: set.clone(), span, options };
    perform_as(&LongStudy::of("orbits", work), common, &common.invocation, None)
}

/// The branches of single orbits; `None` with `--tree`, whose branches [`whole_tree`] computes and
/// writes.
pub fn orbits(set: &ParameterSet, common: &Common, a: &Orbits) -> Result<Option<Study>> {
    if a.tree {
        return whole_tree(set, common, a).map(|()| None);
    }
    let family = family(set, a)?;
    let span = *family.span();
    let value = span.name.value(set);
    if !(span.from..=span.to).contains(&value) {
        let what = format!("{} = {value}", span.name.name());
        let problem = format!(
            "must lie in the range {} to {}, because the branch begins at this value",
            span.from, span.to
        );
        return Err(Error::Refused { what, problem });
    }
    let orbits = a.of_paper.which.orbits(&family.system(&[value])?)?;
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
    studies::paper::orbits(set, &family, &branches, None).map(Some)
}

pub fn orbit(set: &ParameterSet, a: &OneOrbit) -> Result<Study> {
    let system = System::new(set.parameters())?;
    studies::paper::orbit(set, &a.which()?.orbits(&system)?)
}

pub fn loci(set: &ParameterSet, a: &Loci) -> Result<Study> {
    let [first, second] = a.ranges[..] else {
        return Err(Error::form(
            format!("{} --vary", a.vary.len()),
            "two parameters, e.g. --vary f10=0.5:3 --vary kappa=0.5:0.9",
        ));
    };
    let family = Family::over_two(set, span(&first)?, span(&second)?)?;
    let curves = PaperCurves { family, held: second.name.value(set) };
    let points = chosen(a, first.name.name(), &|text| Ok(number(first.name, text)?))?;
    let (found, problems) = followed(&curves, &points)?;
    studies::paper::loci(set, &curves.family, &found, &problems)
}

/// The curves over the two parameters of a family, with the present value of the second one.
struct PaperCurves {
    family: Family,
    held: f64,
}

impl Curves for PaperCurves {
    type Point = SpecialPoint;
    type Start = LocusStart;
    type Shown = LocusStart;

    fn start(&self, point: &SpecialPoint) -> Result<LocusStart> {
        let SpecialPoint { label, word, phases, value, .. } = point.clone();
        let start = LocusStart { label, word, phases, values: [value, self.held] };
        Ok(start.shortest(&self.family)?)
    }

    fn is_same(&self, one: &LocusStart, other: &LocusStart) -> bool {
        one.is_same(other, &self.family).unwrap_or(false)
    }

    fn follow(&self, _: &SpecialPoint, start: &LocusStart) -> Result<(LocusStart, Vec<LocusPoint>)> {
        Ok((start.clone(), locus(&self.family, start)?))
    }
}
