//! `vibro assembly bifurcation|lyapunov|sweep`: from arguments to the library's studies.

use crate::assembly_arguments::{Bifurcation, Drawn, Lyapunov, Sweep, Which};
use crate::common_arguments::Common;
use crate::destination::{self, Destination};
use crate::long::perform_as;
use crate::output;
use crate::ranges::Share;
use vibro::long_study::{AssemblyStudy, LongStudy, Work};
use vibro::manifest::Invocation;
use vibro::studies::assembly_exponent;
use vibro::{Error, Result, assembly};
use vibro_analysis::assembly::{FileStart, Machine, Measure, QuantityName, SectionRule, diagram};
use vibro_analysis::design_sweep::{Designs, ParameterInterval, Request, SampledAxis};
use vibro_analysis::isoperiodic;
use vibro_analysis::plane::ParameterAxis;
use vibro_analysis::sobol::DIMENSIONS;

/// Values in a range without a count, of a diagram and of a plane.
const VALUES: u16 = 200;
const PLANE_VALUES: u16 = 60;
/// Most values on an axis of a plane.
const MOST_OF_PLANE: usize = 3_000;

/// Reads the machine.
fn machine(which: &Which, common: &Common) -> Result<Machine> {
    let mut machine = assembly::read(&which.file, &common.set, &mut |words| crate::note(&words))?;
    machine.section = match (which.period, &which.section) {
        (Some(period), _) => SectionRule::Period(period),
        (None, Some(element)) => SectionRule::Element(element.clone()),
        (None, None) => SectionRule::Auto,
    };
    Ok(machine)
}

/// A parameter, its numbers as texts, and whether they are a range.
fn split(text: &str) -> Result<(String, Vec<&str>, bool)> {
    let form = || {
        Error::form(text, "NAME=FROM:TO, NAME=FROM:TO:COUNT or NAME=V,V,…, e.g. stop.upper.gap=1mm:8mm:200")
    };
    let (name, numbers) = text.split_once('=').ok_or_else(form)?;
    let is_range = numbers.contains(':');
    let numbers: Vec<&str> = numbers.split(if is_range { ':' } else { ',' }).map(str::trim).collect();
    if is_range && !(2..=3).contains(&numbers.len()) {
        return Err(form());
    }
    Ok((name.trim().into(), numbers, is_range))
}

/// Numbers of a parameter, with or without units: at all or at none. Without, they are in that in
/// which the parameter was written.
fn numbers(machine: &mut Machine, name: &str, texts: &[&str], whole: &str) -> Result<Vec<f64>> {
    let read = texts.iter().map(|text| Ok(machine.quantity(name, text)?)).collect::<Result<Vec<_>>>()?;
    let is_bare = |text: &&str| text.parse::<f64>().is_ok();
    if texts.iter().any(|text| is_bare(text) != is_bare(&texts[0])) {
        return Err(Error::form(whole, "a unit at every number or at none"));
    }
    assembly::taken(texts, &read[0], whole).iter().for_each(|words| crate::note(words));
    texts.iter().for_each(|text| machine.note_unit(name, text));
    Ok(read.into_iter().map(|quantity| quantity.value).collect())
}

/// A range or list as its numbers are in SI, for manifests.
fn in_si(machine: &Machine, text: &str) -> Result<String> {
    let (name, texts, is_range) = split(text)?;
    let numbers = texts.iter().enumerate().map(|(i, number)| match (is_range, i) {
        (true, 2) => Ok((*number).to_owned()),
        _ => Ok(machine.quantity(&name, number)?.value.to_string()),
    });
    Ok(format!("{name}={}", numbers.collect::<Result<Vec<_>>>()?.join(if is_range { ":" } else { "," })))
}

/// The axis of a range.
fn axis(machine: &mut Machine, text: &str, resolution: usize, most: usize) -> Result<ParameterAxis<String>> {
    let (name, texts, is_range) = split(text)?;
    if !is_range {
        return Err(Error::form(text, "a range, NAME=FROM:TO or NAME=FROM:TO:COUNT"));
    }
    let ends = numbers(machine, &name, &texts[..2], text)?;
    let count = match texts.get(2) {
        Some(count) => count.parse().map_err(|_| Error::form(text, "a whole number of values"))?,
        None => resolution,
    };
    if !(2..=most).contains(&count) {
        let problem = format!("allowed are 2 to {most}");
        return Err(Error::Refused { what: format!("{name}: {count} values"), problem });
    }
    Ok(ParameterAxis::of(name, (ends[0], ends[1]), count)?)
}

/// A range or list as values.
fn sampled(machine: &mut Machine, text: &str, resolution: u32) -> Result<SampledAxis<String>> {
    let (name, texts, is_range) = split(text)?;
    if !is_range {
        let values = numbers(machine, &name, &texts, text)?;
        return Ok(SampledAxis { name, values });
    }
    let axis = axis(machine, text, resolution as usize, 1_000_000)?;
    Ok(SampledAxis { values: (0..axis.count).map(|i| axis.value(i)).collect(), name })
}

/// The invocation of a command, with the options on which its results depend.
fn invocation(common: &Common, command: &str, options: &[(&str, String)]) -> Invocation {
    let mut found = common.invocation.clone();
    found.command = format!("assembly-{command}");
    found.options.extend(options.iter().map(|(name, words)| ((*name).into(), words.clone())));
    found
}

fn request(
    machine: &mut Machine,
    vary: &str,
    a: &Drawn,
    exponents: Option<u32>,
) -> Result<diagram::DiagramRequest> {
    let of = match &a.of {
        Some(of) => of.clone(),
        None => default_quantity(machine)?,
    };
    let axis = axis(machine, vary, a.resolution.unwrap_or(VALUES).into(), diagram::MOST_VALUES)?;
    let request = diagram::DiagramRequest {
        axis,
        of,
        at_section: a.at_section,
        discard: a.discard,
        keep: a.keep,
        exponents,
        anew: a.anew,
    };
    request.check(machine)?;
    Ok(request)
}

/// The first free body's coordinate.
fn default_quantity(machine: &Machine) -> Result<QuantityName> {
    let all = Measure::usual(&machine.description);
    let found = all.iter().find_map(|m| m.quantity().cloned());
    found.ok_or_else(|| Error::form("--of", "a quantity such as box.s; the machine has no free body"))
}

fn draw(
    which: &Which,
    common: &Common,
    command: &str,
    (vary, a): (&[String], &Drawn),
    (exponents, share): (Option<u32>, &Share),
) -> Result<()> {
    if !a.pair.is_empty() {
        return draw_planes(which, common, command, (vary, a), (exponents, share));
    }
    let [vary] = vary else {
        let what = format!("--vary {}", vary.join(" --vary "));
        let problem = "allowed is one parameter, or --pair NAME,NAME for a plane of two".into();
        return Err(Error::Refused { what, problem });
    };
    let mut machine = machine(which, common)?;
    let request = request(&mut machine, vary, a, exponents)?;
    let axis = &request.axis;
    let options = [
        ("vary", format!("{}={}:{}:{}", axis.name, axis.from, axis.to, axis.count)),
        ("of", request.of.to_string()),
        ("at-section", a.at_section.to_string()),
        ("discard", a.discard.to_string()),
        ("keep", a.keep.to_string()),
        ("anew", a.anew.to_string()),
        ("periods", exponents.map_or(String::new(), |n| n.to_string())),
    ];
    let invocation = invocation(common, command, &options);
    let work = Work::Assembly { kind: AssemblyStudy::Diagram(request), machine };
    perform_as(&LongStudy::of(&invocation.command, work), common, &invocation, share.shard)
}

/// The planes of the pairs, each a study of its own.
fn draw_planes(
    which: &Which,
    common: &Common,
    command: &str,
    (vary, a): (&[String], &Drawn),
    (exponents, share): (Option<u32>, &Share),
) -> Result<()> {
    let mut machine = machine(which, common)?;
    let resolution = a.resolution.unwrap_or(PLANE_VALUES).into();
    let axes = vary.iter().map(|text| axis(&mut machine, text, resolution, MOST_OF_PLANE));
    let axes: Vec<ParameterAxis<String>> = axes.collect::<Result<_>>()?;
    let named = |name: &str| {
        let found = axes.iter().find(|axis| axis.name == name.trim()).cloned();
        found.ok_or_else(|| Error::form(name, "a parameter of which --vary tells the range"))
    };
    let mut studies = Vec::new();
    for pair in &a.pair {
        let names = pair.split_once(',');
        let form =
            || Error::form(pair, "two names with a comma between, e.g. stop.upper.gap,body.block.mass");
        let (x, y) = names.ok_or_else(form)?;
        let (x, y) = (named(x)?, named(y)?);
        let words =
            |axis: &ParameterAxis<String>| format!("{}={}:{}:{}", axis.name, axis.from, axis.to, axis.count);
        let options = [
            ("vary", format!("{} {}", words(&x), words(&y))),
            ("pair", format!("{},{}", x.name, y.name)),
            ("discard", a.discard.to_string()),
            ("periods", exponents.map_or(String::new(), |n| n.to_string())),
        ];
        let invocation = invocation(common, command, &options);
        let name = format!("{}-{}-{}", invocation.command, x.name, y.name);
        let request = isoperiodic::IsoperiodicRequest::<Machine> {
            x,
            y,
            start: FileStart::File,
            discard: a.discard,
            exponents,
        };
        let work = Work::Assembly { kind: AssemblyStudy::Isoperiodic(request), machine: machine.clone() };
        let study = LongStudy::of(&name, work);
        // All are refused before the first begins.
        study.check()?;
        studies.push((study, invocation));
    }
    studies.iter().try_for_each(|(study, invocation)| perform_as(study, common, invocation, share.shard))
}

pub fn bifurcation(a: &Bifurcation, common: &Common) -> Result<()> {
    draw(&a.which, common, "bifurcation", (&a.vary, &a.drawn), (None, &a.share))
}

pub fn lyapunov(a: &Lyapunov, common: &Common) -> Result<()> {
    if !(a.vary.is_empty() && a.drawn.pair.is_empty()) {
        return draw(&a.which, common, "lyapunov", (&a.vary, &a.drawn), (Some(a.periods), &a.share));
    }
    let machine = machine(&a.which, common)?;
    let options = [("discard", a.drawn.discard.to_string()), ("periods", a.periods.to_string())];
    let invocation = invocation(common, "lyapunov", &options);
    let destination = Destination::new(common, &invocation, &machine);
    // Refused before work begins.
    destination.place(&[destination.result(&invocation.command)])?;
    let study = assembly_exponent(&machine, a.drawn.discard, a.periods, &invocation.command)?;
    let held = destination::hold(&common.out);
    let out = destination.write(std::slice::from_ref(&study))?;
    drop(held);
    output::print(&[study], &machine, &out, common)
}

pub fn sweep(a: &Sweep, common: &Common) -> Result<()> {
    let mut machine = machine(&a.which, common)?;
    if a.list {
        return output::say(list(&machine).trim_end());
    }
    let designs = match a.samples {
        None => {
            let axes = a.vary.iter().map(|text| sampled(&mut machine, text, a.resolution));
            Designs::Grid(axes.collect::<Result<_>>()?)
        }
        Some(count) if (1..=DIMENSIONS).contains(&a.vary.len()) => {
            let interval = |text: &String| {
                if split(text)?.1.len() != 2 {
                    return Err(Error::form(
                        text,
                        "NAME=FROM:TO without a count: --samples decides on the number of points",
                    ));
                }
                let axis = axis(&mut machine, text, 2, 2)?;
                Ok(ParameterInterval { name: axis.name, from: axis.from, to: axis.to })
            };
            Designs::Sobol { intervals: a.vary.iter().map(interval).collect::<Result<_>>()?, count }
        }
        Some(_) => {
            let what = format!("--samples with {} parameters", a.vary.len());
            let problem = format!("allowed are 1 to {DIMENSIONS}, each by --vary NAME=FROM:TO");
            return Err(Error::Refused { what, problem });
        }
    };
    let over =
        a.over.iter().map(|text| sampled(&mut machine, text, a.resolution)).collect::<Result<Vec<_>>>()?;
    let ranges = a.over.iter().zip(&over).filter(|(text, _)| text.contains(':'));
    let between = ranges.map(|(_, axis)| axis.name.clone()).collect();
    let mut measures: Vec<Measure> = Vec::new();
    let usual = || Measure::usual(&machine.description);
    for measure in if a.output.is_empty() { usual() } else { a.output.clone() } {
        measure.check(&machine.description)?;
        if !measures.contains(&measure) {
            measures.push(measure);
        }
    }
    let request = SweepRequest::<Machine> {
        designs,
        over,
        discard: a.discard,
        periods: a.periods,
        measures,
        between,
        again: a.again,
        ..SweepRequest::default()
    };
    request.check()?;
    // What no design could do without.
    vibro_analysis::assembly::Section::of(&machine.description, &machine.section)?;
    let words = |texts: &[String]| {
        let all = texts.iter().map(|text| in_si(&machine, text));
        Ok::<_, Error>(all.collect::<Result<Vec<_>>>()?.join(" "))
    };
    let outputs: Vec<String> = request.measures.iter().map(ToString::to_string).collect();
    let options = [
        ("vary", words(&a.vary)?),
        ("over", words(&a.over)?),
        ("resolution", a.resolution.to_string()),
        ("samples", a.samples.map_or(String::new(), |n| n.to_string())),
        ("output", outputs.join(" ")),
        ("discard", a.discard.to_string()),
        ("periods", a.periods.to_string()),
        ("again", a.again.to_string()),
    ];
    let invocation = invocation(common, "sweep", &options);
    let work = Work::Assembly { kind: AssemblyStudy::DesignSweep(request), machine };
    perform_as(&LongStudy::of(&invocation.command, work), common, &invocation, a.share.shard)
}

/// All outputs of a machine with unit and meaning.
fn list(machine: &Machine) -> String {
    let d = &machine.description;
    let mut text = format!("outputs of `vibro assembly sweep --output NAME,…` for {}, in SI:\n", d.name);
    for measure in Measure::all(d) {
        let unit = measure.unit(d);
        let unit = if unit == "1" { "" } else { unit };
        text.push_str(&format!("  {:32} {unit:6} {}\n", measure.to_string(), measure.description()));
    }
    text
}
