//! `vibro fit`: from arguments to the library's fit.

use crate::common_arguments::{Common, SectionArguments, names};
use crate::destination::{self, Destination};
use crate::fit_arguments::FitArguments;
use crate::interruption::{self, Second};
use crate::machine_studies::{invocation, machine, read_axis, start_of};
use crate::output;
use crate::progress::{Progress, TIME};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use vibro::machine::{check_record, read_record, write_with_numbers};
use vibro::report::fit_page;
use vibro::studies::{self, fit_json};
use vibro::whole_file::write_whole;
use vibro::{Error, Result};
use vibro_numerics::quantities::quantity_in;
use vibro_studies::fit::{self, Filter, FitRequest, Free, Measured, Segments, fit};
use vibro_studies::{Machine, QuantityName};

/// A number with an optional unit of a dimension, SI.
fn number(name: &str, unit: &'static str, text: &str) -> Result<f64> {
    let plain = text.trim().parse::<f64>().ok();
    let read = plain.or_else(|| quantity_in(unit, text.trim()).map(|quantity| quantity.value));
    read.filter(|x| x.is_finite()).ok_or_else(|| Error::Refused {
        what: format!("{name} = {text}"),
        problem: format!("allowed is a number, in {unit} or with a unit of it"),
    })
}

/// The range of a number of the record or of the start, SI.
fn range_of(machine: &Machine, text: &str) -> Result<(f64, f64)> {
    let form = || Error::form(text, "NAME=LOW:HIGH, e.g. stop.steel.gap=3mm:5mm");
    let (name, range) = text.split_once('=').ok_or_else(form)?;
    let (low, high) = range.split_once(':').ok_or_else(form)?;
    let name = name.trim();
    let column = name.strip_prefix("record.offset.").or_else(|| name.strip_prefix("start."));
    let column =
        column.and_then(|column| column.parse::<QuantityName>().ok()?.find(&machine.description).ok());
    let unit = match column {
        Some(named) => named.unit,
        None if name == "record.shift" => "s",
        None => "1",
    };
    let ends = (number(name, unit, low)?, number(name, unit, high)?);
    if ends.0 < ends.1 { Ok(ends) } else { Err(reversed(text)) }
}

/// A range that ends where it begins or below.
fn reversed(text: &str) -> Error {
    let problem = "its ends do not rise; allowed is NAME=LOW:HIGH with LOW below HIGH".into();
    Error::Refused { what: format!("--within {text}"), problem }
}

/// The range of a parameter, SI, with numbers as those of an axis.
fn range_of_parameter(machine: &mut Machine, name: &str, text: &str) -> Result<(f64, f64)> {
    let (_, range) = text.split_once('=').unwrap_or_default();
    let ends: Vec<f64> =
        range.split(':').filter_map(|end| Some(machine.quantity(name, end).ok()?.value)).collect();
    // An axis of values would speak of their number.
    if let [low, high] = ends[..]
        && low >= high
    {
        return Err(reversed(text));
    }
    let axis = read_axis(machine, text)?;
    let form = || Error::form(text, "a range without a count, NAME=LOW:HIGH");
    Ok(axis.range().filter(|range| range.count.is_none()).ok_or_else(form)?.ends)
}

/// The free numbers with their ranges. Numbers of a parameter's range are read as those of an axis.
fn free(machine: &mut Machine, a: &FitArguments) -> Result<Vec<Free>> {
    let mut all: Vec<Free> = names(&a.free)
        .iter()
        .map(|name| Free { name: name.trim().to_owned(), within: None, is_own: false })
        .collect();
    for text in &names(&a.within) {
        let name = text.split('=').next().unwrap_or_default().trim();
        let own = all.iter_mut().find(|own| own.name == name).ok_or_else(|| Error::Refused {
            what: format!("--within {text}"),
            problem: format!("{name} is not free; allowed are {}", a.free.join(", ")),
        })?;
        if own.within.is_some() {
            let problem = format!("{name} has two ranges; allowed is one");
            return Err(Error::Refused { what: format!("--within {text}"), problem });
        }
        own.within = Some(match machine.description.parameter(name) {
            Err(_) => range_of(machine, text)?,
            Ok(_) => range_of_parameter(machine, name, text)?,
        });
    }
    Ok(all)
}

/// The standard deviations of `--sigma`, in the order of the columns.
fn sigma(machine: &Machine, measured: &Measured, given: &[String]) -> Result<Option<Vec<f64>>> {
    if given.is_empty() {
        return Ok(None);
    }
    if given.iter().all(|text| !text.contains('=')) {
        return given.iter().map(|text| number("--sigma", "1", text)).collect::<Result<_>>().map(Some);
    }
    let mut names: Vec<(String, &'static str)> = Vec::new();
    for (name, _) in &measured.columns {
        names.push((name.to_string(), name.find(&machine.description)?.unit));
    }
    if !measured.contacts.is_empty() {
        names.push(("contacts".into(), "s"));
    }
    let mut found: Vec<Option<f64>> = vec![None; names.len()];
    for text in given {
        let (name, value) =
            text.split_once('=').ok_or_else(|| Error::form(text, "COLUMN=VALUE beside another"))?;
        let place = names.iter().position(|(own, _)| own == name.trim()).ok_or_else(|| Error::Refused {
            what: format!("--sigma {text}"),
            problem: format!(
                "the record has no column {name}; allowed are {}",
                names.iter().map(|n| n.0.clone()).collect::<Vec<_>>().join(", ")
            ),
        })?;
        if found[place].is_some() {
            let problem = format!("{name} has two deviations; allowed is one");
            return Err(Error::Refused { what: format!("--sigma {text}"), problem });
        }
        found[place] = Some(number(name, names[place].1, value)?);
    }
    match found.iter().position(Option::is_none) {
        Some(place) => Err(Error::Refused {
            what: "--sigma".into(),
            problem: format!("has no value for {}; allowed is one for each column", names[place].0),
        }),
        None => Ok(Some(found.into_iter().flatten().collect())),
    }
}

/// The filter of a column's sensor.
fn filter(text: &str) -> Result<Filter> {
    let form = || Error::form(text, "COLUMN=ORDER,FREQUENCY, e.g. box.a=2,400Hz");
    let (column, own) = text.split_once('=').ok_or_else(form)?;
    let (order, frequency) = own.split_once(',').ok_or_else(form)?;
    let order = order.trim().parse().map_err(|_| form())?;
    Ok(Filter { column: column.trim().parse()?, order, frequency: number("--filter", "Hz", frequency)? })
}

/// The value of --segments in the account of a run.
fn segments_text(segments: Segments) -> String {
    match segments {
        Segments::Auto => "auto".into(),
        Segments::None => "none".into(),
        Segments::Length(length) => format!("{length:?}s"),
    }
}

/// Stage, costs and simulations of a fit.
fn in_words(now: &fit::Progress) -> String {
    let cost = |name: &str, cost: Option<f64>| cost.map(|cost| format!(", {name} {cost:.4e}"));
    let costs = [cost("cost", now.cost), cost("best", now.best)];
    let costs: String = costs.into_iter().flatten().collect();
    format!("{}{costs}, {} simulations", now.stage, now.simulations)
}

/// Fits a machine to a record.
pub fn run(common: &Common, a: &FitArguments) -> Result<bool> {
    let mut machine = machine(&a.file, &SectionArguments { period: None, section: None }, common)?;
    let start = start_of(&machine, &a.start)?;
    let measured = read_record(a.data.as_deref(), a.events.as_deref(), &machine.description)?;
    let free = free(&mut machine, a)?;
    check_record(&measured, (a.data.as_deref(), a.events.as_deref()), (&machine, &start), &free)?;
    let filters = a.filter.iter().map(|text| filter(text)).collect::<Result<_>>()?;
    let sigma = sigma(&machine, &measured, &a.sigma)?;
    let path =
        |path: &Option<PathBuf>| path.as_ref().map_or(String::new(), |path| path.display().to_string());
    let options = [
        ("data", path(&a.data)),
        ("events", path(&a.events)),
        ("free", a.free.join(",")),
        ("within", a.within.join(",")),
        ("sigma", a.sigma.join(",")),
        ("filter", a.filter.join(" ")),
        ("loss", format!("{:?}", a.loss)),
        ("segments", segments_text(a.segments)),
        ("starts", a.starts.to_string()),
        ("start", start.to_string()),
    ];
    let invocation = invocation(common, &options);
    let destination = Destination::new(common, &invocation, &machine);
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result("fit"), destination.result("report")])?;
    let stop = interruption::flag(Second::Ends);
    let request = FitRequest {
        machine: machine.clone(),
        start,
        measured,
        free,
        sigma,
        filters,
        loss: a.loss.into(),
        segments: a.segments,
        starts: a.starts,
    };
    let progress = Progress::new(0, TIME);
    let fitted = fit(&request, &|now| {
        progress.described(now.part, &|| in_words(now), "left at most");
        !stop.load(Ordering::Relaxed)
    })?;
    drop(progress);
    let study = studies::fit(&request, &fitted)?;
    let held = destination::hold(&common.out);
    destination.write(std::slice::from_ref(&study))?;
    write_whole(&out.join("fit.json"), fit_json(&fitted).as_bytes())?;
    let verdict = format!("vibro fit: {}", fitted.verdict);
    write_with_numbers(&a.file, &fitted.machine.description, ("fitted.toml", &verdict), &out)?;
    let files = [Some(&a.file), a.data.as_ref(), a.events.as_ref()].map(|path| path.map(PathBuf::as_path));
    let files: Vec<&Path> = files.into_iter().flatten().collect();
    let page = fit_page((&request, &fitted), &study, &invocation.command_line, &files)?;
    destination.write_page("report", &page, &out)?;
    if !fitted.start.is_own() {
        write_whole(&out.join("start.toml"), fitted.start.to_toml().as_bytes())?;
    }
    drop(held);
    output::print(&[study], &machine, &out, common)?;
    Ok(!stop.load(Ordering::Relaxed))
}
