//! `bifurcation`, `lyapunov` and `sweep` with a machine's file: from arguments to the library's
//! studies.

use crate::arguments::one_of;
use crate::common_arguments::{Common, SectionArguments, names};
use crate::destination::{self, Destination};
use crate::long::perform_as;
use crate::output;
use crate::plane_arguments::SectionOfFile;
use crate::progress::Progress;
use crate::ranges::{ParameterRange, ParameterValues, in_option, texts};
use crate::study_arguments::{Bifurcation, Lyapunov};
use crate::sweep::{in_words, request};
use crate::sweep_arguments::{AxisArgument, Sweep};
use std::path::Path;
use vibro::long_study::{LongStudy, StudyKind};
use vibro::manifest::Invocation;
use vibro::studies::{self, SectionAxes, Study, diagram_family};
use vibro::{Error, Result};
use vibro_machine::Start;
use vibro_studies::isoperiodic;
use vibro_studies::{
    Machine, Measure, ParameterAxis, PoincareRequest, QuantityName, Section, SectionRule, diagram, poincare,
    section_of,
};

/// Largest number of values on an axis of a plane.
const MOST_OF_PLANE: usize = 3_000;
/// Valid numbers of periods over which an exponent is computed.
const EXPONENT_PERIODS: std::ops::RangeInclusive<u32> = 8..=1_000_000;

/// Form of a range or list of a parameter.
pub const ANY: &str = "NAME=FROM:TO, NAME=FROM:TO:COUNT or NAME=V,V,…, e.g. stop.steel.gap=1mm:8mm:200";
/// Form of a range that may have a count.
const COUNTED: &str = "NAME=FROM:TO or NAME=FROM:TO:COUNT, e.g. stop.steel.gap=1mm:8mm:200";
/// Form of a range without a count.
pub const RANGE: &str = "NAME=FROM:TO, e.g. stop.steel.gap=1mm:8mm";

/// Reads the machine, with the changes of `--set`.
pub fn machine(file: &Path, section: &SectionArguments, common: &Common) -> Result<Machine> {
    let mut machine = vibro::machine::read(file, &common.set, &mut |words| crate::note(&words))?;
    machine.section = match (section.period, &section.section) {
        (Some(period), _) => SectionRule::Period(period),
        (None, Some(element)) => SectionRule::Element(element.clone()),
        (None, None) => SectionRule::Auto,
    };
    Ok(machine)
}

fn read_start(machine: &Machine, given: &str) -> Result<Start> {
    vibro::machine::read_start(machine, given, &mut |words| crate::note(&words))
}

/// The start given by `--start`, or the machine's own.
pub fn start_of(machine: &Machine, given: &[String]) -> Result<Start> {
    one_of(given)?.map_or_else(|| Ok(Start::default()), |given| read_start(machine, given))
}

/// The starts given by `--start`.
pub fn starts_of(machine: &Machine, given: &[String]) -> Result<Vec<Start>> {
    given.iter().map(|given| read_start(machine, given)).collect()
}

/// Parses a range or list of a parameter; `expected` describes its form. Either all its numbers
/// have units or none has. Numbers without units are in the parameter's written unit.
pub fn read_axis(machine: &mut Machine, text: &str, expected: &'static str) -> Result<AxisArgument<String>> {
    let form = || Error::form(text, expected);
    let named = text.split_once('=').filter(|(name, _)| !name.trim().is_empty());
    let (name, numbers) = named.ok_or_else(form)?;
    let (name, is_range) = (name.trim(), numbers.contains(':'));
    let mut numbers: Vec<&str> = numbers.split(if is_range { ':' } else { ',' }).map(str::trim).collect();
    let count = if is_range && numbers.len() == 3 { numbers.pop() } else { None };
    if is_range && numbers.len() != 2 {
        return Err(form());
    }
    let is_one = !is_range && numbers.len() == 1 && machine.description.parameter(name).is_ok();
    if is_one && machine.quantity(name, numbers[0]).is_err() {
        return Err(form());
    }
    let read =
        numbers.iter().map(|number| Ok(machine.quantity(name, number)?)).collect::<Result<Vec<_>>>()?;
    let is_bare = |number: &&str| number.parse::<f64>().is_ok();
    if numbers.iter().any(|number| is_bare(number) != is_bare(&numbers[0])) {
        return Err(Error::form(text, "a unit on every number or on none"));
    }
    vibro::machine::note_if_not_si(&numbers, &read[0], text).iter().for_each(|words| crate::note(words));
    numbers.iter().for_each(|number| machine.note_unit(name, number));
    let (name, values): (_, Vec<f64>) =
        (name.to_owned(), read.iter().map(|quantity| quantity.value).collect());
    if !is_range {
        return Ok(AxisArgument::List(ParameterValues { name, values, unit: None }));
    }
    let whole = |count: &str| count.parse::<usize>().ok().filter(|count| *count >= 2);
    let count =
        count.map(|count| whole(count).ok_or_else(|| Error::form(text, "a count of 2 or more values")));
    let range = ParameterRange { name, ends: (values[0], values[1]), count: count.transpose()?, unit: None };
    ParameterAxis::of(range.name.clone(), range.ends, 2)
        .map_err(|_| Error::form(text, "NAME=FROM:TO with FROM < TO"))?;
    Ok(AxisArgument::Range(range))
}

/// Parses ranges or lists of parameters, as [`read_axis`].
pub fn read_axes(
    machine: &mut Machine,
    texts: &[String],
    expected: &'static str,
) -> Result<Vec<AxisArgument<String>>> {
    texts.iter().map(|text| read_axis(machine, text, expected)).collect()
}

/// The axis of a range.
fn axis(machine: &mut Machine, text: &str, resolution: u16, most: usize) -> Result<ParameterAxis<String>> {
    let axis = read_axis(machine, text, COUNTED)?;
    let range = axis.range();
    let range = range.ok_or_else(|| Error::form(text, COUNTED))?;
    range.axis(resolution.into(), 2..=most)
}

/// The invocation with the options that affect the results.
pub fn invocation(common: &Common, options: &[(&str, String)]) -> Invocation {
    let mut found = common.invocation.clone();
    found.options.extend(options.iter().map(|(name, words)| ((*name).into(), words.clone())));
    found
}

fn diagram_request(
    machine: &mut Machine,
    vary: &str,
    a: &Bifurcation,
    exponents: Option<u32>,
) -> Result<diagram::DiagramRequest<Machine>> {
    let of = match &a.of {
        Some(of) => {
            let of: QuantityName = of.parse().map_err(in_option("--of"))?;
            of.find(&machine.description).map_err(in_option("--of"))?;
            of
        }
        None => default_quantity(machine)?,
    };
    let request = diagram::DiagramRequest {
        axis: axis(machine, vary, a.resolution, diagram::MOST_VALUES)?,
        of,
        at_section: a.of_file.at_section,
        discard: a.discard,
        keep: a.keep,
        exponents,
        anew: a.of_file.anew,
        start: start_of(machine, &a.start)?,
    };
    request.check(machine)?;
    Ok(request)
}

/// The first free body's coordinate.
pub fn default_quantity(machine: &Machine) -> Result<QuantityName> {
    let all = Measure::usual(&machine.description);
    let found = all.iter().find_map(|m| m.quantity().cloned());
    found.ok_or_else(|| Error::form("--of", "a quantity such as box.s, because the machine has no free body"))
}

/// An axis with its number of values, for manifests.
fn counted(axis: &ParameterAxis<String>) -> String {
    format!("{}={}:{}:{}", axis.name, axis.from, axis.to, axis.count)
}

fn draw(file: &Path, common: &Common, a: &Bifurcation, exponents: Option<u32>) -> Result<()> {
    let mut machine = machine(file, &a.of_file.section, common)?;
    if !a.of_file.pair.is_empty() {
        return draw_planes(machine, common, a, exponents);
    }
    let [vary] = &a.vary[..] else {
        let problem = format!(
            "expected one parameter, as --vary NAME=FROM:TO[:COUNT]; found {}; use --pair NAME,NAME for a \
             plane of two parameters",
            a.vary.len()
        );
        return Err(Error::Refused { what: "--vary".into(), problem });
    };
    let request = diagram_request(&mut machine, vary, a, exponents)?;
    let mut options = vec![
        ("vary", counted(&request.axis)),
        ("of", request.of.to_string()),
        ("at-section", request.at_section.to_string()),
        ("discard", a.discard.to_string()),
        ("keep", a.keep.to_string()),
        ("anew", request.anew.to_string()),
        ("start", request.start.to_string()),
        ("periods", exponents.map_or(String::new(), |n| n.to_string())),
    ];
    if a.orbits {
        options.push(("orbits", true.to_string()));
        diagram_family(&machine, &request)?;
    }
    let invocation = invocation(common, &options);
    let kind = StudyKind::Diagram { request, over: a.orbits };
    perform_as(&LongStudy::new(&invocation.command, kind, &machine), common, &invocation, a.share.shard)
}

/// Draws the planes of the pairs, each as a separate study.
fn draw_planes(mut machine: Machine, common: &Common, a: &Bifurcation, exponents: Option<u32>) -> Result<()> {
    let axes = a.vary.iter().map(|text| axis(&mut machine, text, a.resolution, MOST_OF_PLANE));
    let axes: Vec<ParameterAxis<String>> = axes.collect::<Result<_>>()?;
    let named = |pair: &str, name: &str| {
        let found = axes.iter().find(|axis| axis.name == name.trim()).cloned();
        found.ok_or_else(|| {
            let problem = format!("{name} has no range; add --vary {name}=FROM:TO");
            Error::Refused { what: format!("--pair {pair}"), problem }
        })
    };
    let start = start_of(&machine, &a.start)?;
    let mut studies = Vec::new();
    for pair in &a.of_file.pair {
        let of_pair = names(std::slice::from_ref(pair));
        let [x, y] = &of_pair[..] else {
            let form = "two names separated by a comma, e.g. stop.steel.gap,body.block.mass";
            return Err(Error::form(pair, form));
        };
        let (x, y) = (named(pair, x)?, named(pair, y)?);
        let options = [
            ("vary", format!("{} {}", counted(&x), counted(&y))),
            ("pair", format!("{},{}", x.name, y.name)),
            ("start", start.to_string()),
            ("discard", a.discard.to_string()),
            ("periods", exponents.map_or(String::new(), |n| n.to_string())),
        ];
        let invocation = invocation(common, &options);
        let name = format!("{}-{}-{}", invocation.command, x.name, y.name);
        let request = isoperiodic::IsoperiodicRequest::<Machine> {
            x,
            y,
            start: start.clone(),
            discard: a.discard,
            exponents,
        };
        let study = LongStudy::new(&name, StudyKind::Isoperiodic(request), &machine);
        // All studies are checked before the first begins.
        study.check()?;
        studies.push((study, invocation));
    }
    studies.iter().try_for_each(|(study, invocation)| perform_as(study, common, invocation, a.share.shard))
}

pub fn bifurcation(file: &Path, common: &Common, a: &Bifurcation) -> Result<()> {
    draw(file, common, a, None)
}

pub fn lyapunov(
    file: &Path,
    common: &Common,
    Lyapunov { sweep: a, periods, spectrum, .. }: &Lyapunov,
) -> Result<()> {
    if !EXPONENT_PERIODS.contains(periods) {
        let problem = format!("expected {} to {}", EXPONENT_PERIODS.start(), EXPONENT_PERIODS.end());
        return Err(Error::Refused { what: format!("--periods {periods}"), problem });
    }
    if !(a.vary.is_empty() && a.of_file.pair.is_empty()) {
        return draw(file, common, a, Some(*periods));
    }
    let machine = machine(file, &a.of_file.section, common)?;
    let start = start_of(&machine, &a.start)?;
    let mut options = vec![
        ("start", start.to_string()),
        ("discard", a.discard.to_string()),
        ("periods", periods.to_string()),
    ];
    options.extend(spectrum.then(|| ("spectrum", true.to_string())));
    let invocation = invocation(common, &options);
    short(&machine, common, &invocation, &invocation.command, &mut || match spectrum {
        true => {
            let progress = Progress::new(*periods as usize, "periods");
            let mut step = || progress.step();
            studies::spectrum(&machine, &start, (a.discard, *periods), &mut step, &invocation.command)
        }
        false => studies::exponent(&machine, &start, (a.discard, *periods), &invocation.command),
    })
}

/// Computes and writes one study of a machine, after its folder has been checked.
fn short(
    machine: &Machine,
    common: &Common,
    invocation: &Invocation,
    name: &str,
    study: &mut dyn FnMut() -> Result<Study>,
) -> Result<()> {
    let destination = Destination::new(common, invocation, machine);
    destination.place(&[destination.result(name)])?;
    let study = study()?;
    let held = destination::hold(&common.out);
    let out = destination.write(std::slice::from_ref(&study))?;
    drop(held);
    output::print(&[study], machine, &out, common)
}

/// Poincaré section of a settled motion.
pub fn section(file: &Path, common: &Common, a: &SectionOfFile) -> Result<()> {
    let machine = machine(file, &a.section, common)?;
    let start = start_of(&machine, &a.start)?;
    let request = PoincareRequest { start, phase: a.phase, discard: a.discard, keep: a.keep };
    section_of(&machine, a.phase)?;
    let shown = SectionAxes::new(&machine, a.of.as_deref())?;
    let options = [
        ("start", request.start.to_string()),
        ("phase", a.phase.to_string()),
        ("discard", a.discard.to_string()),
        ("keep", a.keep.to_string()),
        ("of", shown.to_string()),
    ];
    let invocation = invocation(common, &options);
    short(&machine, common, &invocation, "section", &mut || {
        let progress = Progress::new(a.keep as usize, "points");
        let mut go_on = || {
            progress.step();
            true
        };
        let points = poincare(&machine, &request, &mut go_on)?;
        studies::section(&machine, &request, &points, &shown, "section")
    })
}

pub fn sweep(file: &Path, common: &Common, a: &Sweep) -> Result<()> {
    let mut machine = machine(file, &a.section, common)?;
    if a.list {
        return output::say(list(&machine).trim_end());
    }
    let (vary, over) = (read_axes(&mut machine, &a.vary, ANY)?, read_axes(&mut machine, &a.over, ANY)?);
    let usual = || Ok(Measure::usual(&machine.description));
    let measures: Vec<Measure> = if a.output.is_empty() { usual() } else { texts("--output", &a.output) }?;
    let check = |measure: &Measure| measure.check(&machine.description);
    measures.iter().try_for_each(check).map_err(in_option("--output"))?;
    let mut request = request::<Machine>(a, &vary, &over, measures)?;
    if !a.start.is_empty() {
        request.starts = starts_of(&machine, &a.start)?;
    }
    request.check()?;
    // Every design needs a section.
    Section::of(&machine.description, &machine.section)?;
    let options = [
        ("vary", in_words(&vary)),
        ("over", in_words(&over)),
        ("resolution", a.resolution.to_string()),
        ("samples", a.sobol.map_or(String::new(), |n| n.to_string())),
        ("output", in_words(&request.measures)),
        ("start", in_words(&request.starts)),
        ("discard", a.discard.to_string()),
        ("periods", a.periods.to_string()),
        ("again", a.again.to_string()),
    ];
    let invocation = invocation(common, &options);
    let kind = StudyKind::DesignSweep(request);
    perform_as(&LongStudy::new(&invocation.command, kind, &machine), common, &invocation, a.share.shard)
}

/// All outputs of a machine with unit and meaning.
fn list(machine: &Machine) -> String {
    let d = &machine.description;
    let mut text = format!("outputs of `vibro sweep FILE --output NAME,…` for {}, in SI:\n", d.name);
    for measure in Measure::all(d) {
        let unit = measure.unit(d);
        let unit = if unit == "1" { "" } else { unit };
        text.push_str(&format!("  {:32} {unit:6} {}\n", measure.to_string(), measure.description()));
    }
    text
}
