//! `vibro fit`: converts arguments, runs the fit and writes its files.

use crate::common_arguments::{Common, SectionArguments, names};
use crate::destination::{self, Claim, Destination};
use crate::earlier_fit;
use crate::fit_arguments::FitArguments;
use crate::interruption::{self, Second};
use crate::machine_studies::{invocation, machine, read_axis, start_of};
use crate::output;
use crate::progress::{Progress, TIME};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use vibro::machine::{check_record, read_record, write_with_numbers};
use vibro::report::fit_page;
use vibro::studies::{self, Study, fit_json};
use vibro::whole_file::write_whole;
use vibro::{Error, Result};
use vibro_machine::Start;
use vibro_numerics::quantities::{quantity_in, symbols};
use vibro_studies::fit::{
    self, Filter, FitRequest, Fitted, Free, Measured, Misfit, Segments, fit_records, misfit,
};
use vibro_studies::{Machine, QuantityName};

/// Parses a number with an optional unit of a dimension, SI.
fn number(name: &str, unit: &'static str, text: &str) -> Result<f64> {
    let units: Vec<_> = symbols(unit).collect();
    let plain = text.trim().parse::<f64>().ok();
    let read = plain.or_else(|| quantity_in(unit, text.trim()).map(|quantity| quantity.value));
    read.filter(|x| x.is_finite()).ok_or_else(|| Error::Refused {
        what: format!("{name} = {text}"),
        problem: match unit {
            "1" => "expected a number".into(),
            _ => format!("expected a number in {unit}, or with a unit: {}", units.join(", ")),
        },
    })
}

/// Parses the range of a record or start parameter, SI.
fn range_of(machine: &Machine, text: &str) -> Result<(f64, f64)> {
    let (name, range) = text.split_once('=').ok_or_else(|| form(text))?;
    let (low, high) = range.split_once(':').ok_or_else(|| form(text))?;
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

/// Form of the range of a parameter.
const FORM: &str = "NAME=LOW:HIGH without a count, e.g. stop.steel.gap=3mm:5mm";

/// Error for a range of another form.
fn form(text: &str) -> Error {
    Error::Refused { what: format!("--within {text}"), problem: format!("expected {FORM}") }
}

/// Error for a range whose end is not above its begin.
fn reversed(text: &str) -> Error {
    let problem = "LOW must be less than HIGH in NAME=LOW:HIGH".into();
    Error::Refused { what: format!("--within {text}"), problem }
}

/// Parses the range of a machine parameter, SI, with the syntax of an axis.
fn range_of_parameter(machine: &mut Machine, name: &str, text: &str) -> Result<(f64, f64)> {
    let (_, range) = text.split_once('=').filter(|own| own.1.contains(':')).ok_or_else(|| form(text))?;
    let ends: Vec<f64> =
        range.split(':').filter_map(|end| Some(machine.quantity(name, end).ok()?.value)).collect();
    if let [low, high] = ends[..]
        && low >= high
    {
        return Err(reversed(text));
    }
    let axis = read_axis(machine, text, FORM)?;
    Ok(axis.range().filter(|range| range.count.is_none()).ok_or_else(|| form(text))?.ends)
}

/// Free parameters with their ranges. A machine parameter's range has the syntax of an axis.
fn free(machine: &mut Machine, a: &FitArguments) -> Result<Vec<Free>> {
    let given = |list: &[String], is_own| {
        let one = move |name: String| Free { name: name.trim().to_owned(), within: None, is_own };
        names(list).into_iter().filter(|name| !name.is_empty()).map(one).collect::<Vec<_>>()
    };
    let mut all = [given(&a.free, false), given(&a.own, true)].concat();
    for text in &names(&a.within) {
        let name = text.split('=').next().unwrap_or_default().trim();
        let own = all.iter_mut().find(|own| own.name == name).ok_or_else(|| Error::Refused {
            what: format!("--within {text}"),
            problem: format!(
                "{name} is not free; expected one of {}",
                [a.free.join(","), a.own.join(",")].join(",").trim_matches(',')
            ),
        })?;
        if own.within.is_some() {
            let problem = format!("{name} has two ranges; expected one");
            return Err(Error::Refused { what: format!("--within {text}"), problem });
        }
        own.within = Some(match machine.description.parameter(name) {
            Err(_) => range_of(machine, text)?,
            Ok(_) => range_of_parameter(machine, name, text)?,
        });
    }
    Ok(all)
}

/// Standard deviations from `--sigma`, in the order of the columns.
fn sigma(
    machine: &Machine,
    measured: &Measured,
    (given, others): (&[String], &[String]),
) -> Result<Option<Vec<f64>>> {
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
        let (name, value) = text
            .split_once('=')
            .ok_or_else(|| Error::form(text, "COLUMN=VALUE, because another value has this form"))?;
        // Another record may have the column.
        if others.iter().any(|own| own == name.trim()) && names.iter().all(|(own, _)| own != name.trim()) {
            continue;
        }
        let place = names.iter().position(|(own, _)| own == name.trim()).ok_or_else(|| Error::Refused {
            what: format!("--sigma {text}"),
            problem: format!(
                "the record has no column {name}; expected one of {}",
                names.iter().map(|n| n.0.clone()).collect::<Vec<_>>().join(", ")
            ),
        })?;
        if found[place].is_some() {
            let problem = format!("{name} has two standard deviations; expected one");
            return Err(Error::Refused { what: format!("--sigma {text}"), problem });
        }
        found[place] = Some(number(name, names[place].1, value)?);
    }
    match found.iter().position(Option::is_none) {
        Some(place) => Err(Error::Refused {
            what: "--sigma".into(),
            problem: format!("has no value for {}; expected a value for each column", names[place].0),
        }),
        None => Ok(Some(found.into_iter().flatten().collect())),
    }
}

/// Parses the filter of a column's sensor.
fn filter(text: &str) -> Result<Filter> {
    let form = || Error::form(text, "COLUMN=ORDER,FREQUENCY, e.g. box.a=2,400Hz");
    let (column, own) = text.split_once('=').ok_or_else(form)?;
    let (order, frequency) = own.split_once(',').ok_or_else(form)?;
    let order = order.trim().parse().map_err(|_| form())?;
    Ok(Filter { column: column.trim().parse()?, order, frequency: number("--filter", "Hz", frequency)? })
}

/// Text of --segments in the account of a run.
fn segments_text(segments: Segments) -> String {
    match segments {
        Segments::Auto => "auto".into(),
        Segments::None => "none".into(),
        Segments::Length(length) => format!("{length:?}s"),
    }
}

/// Stage, costs and simulations of a fit, as text.
fn in_words(now: &fit::Progress) -> String {
    let cost = |name: &str, cost: Option<f64>| cost.map(|cost| format!(", {name} {cost:.4e}"));
    let costs = [cost("cost", now.cost), cost("best", now.best)];
    let costs: String = costs.into_iter().flatten().collect();
    format!("{}{costs}, {} simulations", now.stage, now.simulations)
}

/// A record with its tables and its request.
struct Record {
    /// Name of its table without extension.
    name: String,
    data: Option<PathBuf>,
    events: Option<PathBuf>,
    request: FitRequest,
}

/// Name of a record, and its tables of values and of contacts.
type Tables = (String, Option<PathBuf>, Option<PathBuf>);

/// Name and tables of each record.
fn tables(a: &FitArguments) -> Result<Vec<Tables>> {
    let (data, events) = (&a.data, &a.events);
    if !data.is_empty() && !events.is_empty() && data.len() != events.len() {
        return Err(Error::Refused {
            what: "--events".into(),
            problem: format!(
                "has {} tables where --data has {}; expected one for each record",
                events.len(),
                data.len()
            ),
        });
    }
    let mut all: Vec<Tables> = Vec::new();
    for k in 0..data.len().max(events.len()) {
        let (data, events) = (data.get(k).cloned(), events.get(k).cloned());
        let stem = data.as_ref().or(events.as_ref()).and_then(|path| path.file_stem());
        let name = stem.map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
        if all.iter().any(|(own, ..)| *own == name) {
            let problem = "is the name of two records; expected tables with different names".into();
            return Err(Error::Refused { what: name, problem });
        }
        all.push((name, data, events));
    }
    Ok(all)
}

/// Parameters that `--set-in` sets for a record, in the form of `--set`.
fn set_in(a: &FitArguments, record: &str, all: &[&str]) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for text in &a.set_in {
        let form = || Error::form(text, "RECORD:NAME=VALUE, e.g. run2:load.shaker.frequency=11Hz");
        let (name, set) = text.split_once(':').ok_or_else(form)?;
        if !all.contains(&name) {
            return Err(Error::Refused {
                what: format!("--set-in {text}"),
                problem: format!("no record is named {name}; expected one of {}", all.join(", ")),
            });
        }
        if name == record {
            found.push(set.to_owned());
        }
    }
    Ok(found)
}

/// Records to fit, each with its machine.
fn records(common: &Common, a: &FitArguments) -> Result<Vec<Record>> {
    let tables = tables(a)?;
    let all: Vec<&str> = tables.iter().map(|(name, ..)| name.as_str()).collect();
    let filters: Vec<Filter> = a.filter.iter().map(|text| filter(text)).collect::<Result<_>>()?;
    let read = |(name, data, events): &Tables| {
        let set = [common.set.clone(), set_in(a, name, &all)?].concat();
        let common = Common { set, ..common.clone() };
        let machine = machine(&a.file, &SectionArguments { period: None, section: None }, &common)?;
        let measured = read_record(data.as_deref(), events.as_deref(), &machine.description)?;
        Ok((machine, measured))
    };
    let read = tables.iter().map(read).collect::<Result<Vec<_>>>()?;
    // An option may name a column that another record has.
    let columns = read.iter().flat_map(|(_, own)| own.columns.iter().map(|(name, _)| name.to_string()));
    let contacts = read.iter().any(|(_, own)| !own.contacts.is_empty()).then(|| "contacts".to_owned());
    let columns: Vec<String> = columns.chain(contacts).collect();
    let one = |((name, data, events), (mut machine, measured)): (Tables, (Machine, Measured))| {
        let start = start_of(&machine, &a.start)?;
        let free = free(&mut machine, a)?;
        check_record(&measured, (data.as_deref(), events.as_deref()), (&machine, &start), &free)?;
        let sigma = sigma(&machine, &measured, (&a.sigma, &columns))?;
        let has = |own: &Filter| measured.columns.iter().any(|(name, _)| *name == own.column);
        let is_elsewhere = |own: &Filter| !has(own) && columns.contains(&own.column.to_string());
        let filters = filters.iter().filter(|own| !is_elsewhere(own)).cloned().collect();
        let request = FitRequest {
            name: name.clone(),
            machine,
            start,
            measured,
            free,
            sigma,
            filters,
            loss: a.loss.into(),
            segments: a.segments,
            starts: a.starts,
        };
        Ok(Record { name, data, events, request })
    };
    tables.clone().into_iter().zip(read).map(one).collect()
}

/// Options of a fit for the account of a run.
fn options(a: &FitArguments, start: &Start) -> Vec<(&'static str, String)> {
    let paths = |paths: &[PathBuf]| {
        let all: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        all.join(",")
    };
    let mut all = vec![
        ("data", paths(&a.data)),
        ("events", paths(&a.events)),
        ("free", a.free.join(",")),
        ("within", a.within.join(",")),
        ("sigma", a.sigma.join(",")),
        ("filter", a.filter.join(" ")),
        ("loss", format!("{:?}", a.loss)),
        ("segments", segments_text(a.segments)),
        ("starts", a.starts.to_string()),
        ("start", start.to_string()),
    ];
    // The account of a single record's fit has only the original options.
    if !a.own.is_empty() {
        all.push(("own", a.own.join(",")));
    }
    if !a.set_in.is_empty() {
        all.push(("set_in", a.set_in.join(" ")));
    }
    all
}

/// Fits a machine to a record, or to several records together.
pub fn run(common: &Common, a: &FitArguments) -> Result<bool> {
    let records = records(common, a)?;
    let invocation = invocation(common, &options(a, &records[0].request.start));
    let machine = &records[0].request.machine;
    let destination = Destination::new(common, &invocation, machine);
    // Checks the folder before work begins.
    let names: &[&str] = if records.len() == 1 { &["fit", "report"] } else { &["numbers"] };
    let claims: Vec<Claim> = names.iter().map(|name| destination.result(name)).collect();
    let out = destination.place(&claims)?;
    let own = |record: &Record| Common { out: out.join(&record.name), ..common.clone() };
    let commons: Vec<Common> =
        if records.len() == 1 { Vec::new() } else { records.iter().map(own).collect() };
    let destinations: Vec<Destination> = commons
        .iter()
        .zip(&records)
        .map(|(common, record)| Destination::new(common, &invocation, &record.request.machine))
        .collect();
    for destination in &destinations {
        destination.place(&[destination.result("fit"), destination.result("report")])?;
    }
    let stop = interruption::flag(Second::Ends);
    let progress = Progress::new(0, TIME);
    let requests: Vec<FitRequest> = records.iter().map(|own| own.request.clone()).collect();
    let fitted = fit_records(&requests, &|now| {
        progress.described(now.part, &|| in_words(now), "left at most");
        !stop.load(Ordering::Relaxed)
    })?;
    // After an interruption the files are written at once.
    let goes_on = || !stop.load(Ordering::Relaxed);
    let explained = |(request, fitted): (&FitRequest, &Fitted)| match goes_on() {
        true => misfit(request, fitted, &goes_on).unwrap_or_else(|error| {
            crate::note(&format!("no explanation of the residuals: {error}"));
            Misfit::default()
        }),
        false => Misfit::default(),
    };
    let misfits: Vec<Misfit> = requests.iter().zip(&fitted).map(explained).collect();
    drop(progress);
    if common.replace {
        let tables = records.iter().flat_map(|own| [own.data.as_ref(), own.events.as_ref()]).flatten();
        let inputs: Vec<&Path> = tables.chain([&a.file]).map(PathBuf::as_path).collect();
        earlier_fit::remove(&out, &inputs)?;
    }
    if let ([record], [fitted]) = (&records[..], &fitted[..]) {
        let study = write(&destination, a, (record, fitted, &misfits[0]), &invocation.command_line, &out)?;
        output::print(&[study], machine, &out, common)?;
        return Ok(!stop.load(Ordering::Relaxed));
    }
    let mut studies = vec![studies::fit_numbers(
        &records.iter().map(|own| own.name.as_str()).collect::<Vec<_>>(),
        &requests,
        &fitted,
    )?];
    destination.write_into(&studies, &out)?;
    let found = records.iter().zip(&fitted).zip(&misfits);
    for (((record, fitted), misfit), (destination, common)) in found.zip(destinations.iter().zip(&commons)) {
        let found = (record, fitted, misfit);
        let study = write(destination, a, found, &invocation.command_line, &common.out)?;
        studies.push(Study { name: record.name.clone(), ..study });
    }
    output::print(&studies, machine, &out, common)?;
    Ok(!stop.load(Ordering::Relaxed))
}

/// Writes the files of a fitted record.
fn write(
    destination: &Destination,
    a: &FitArguments,
    (record, fitted, misfit): (&Record, &Fitted, &Misfit),
    command_line: &str,
    out: &Path,
) -> Result<Study> {
    let study = studies::fit(&record.request, fitted, misfit)?;
    let held = destination::hold(out);
    destination.write_into(std::slice::from_ref(&study), out)?;
    write_whole(&out.join("fit.json"), fit_json(fitted, misfit).as_bytes())?;
    // The file has no start of the command line; `start.toml` next to it has.
    let start = if fitted.start.is_own() { "" } else { "; simulate its motion with --start start.toml" };
    let verdict = format!("vibro fit: {}{start}", fitted.verdict);
    write_with_numbers(&a.file, &fitted.machine.description, ("fitted.toml", &verdict), out)?;
    let files = [Some(&a.file), record.data.as_ref(), record.events.as_ref()];
    let files: Vec<&Path> = files.into_iter().flatten().map(PathBuf::as_path).collect();
    let page = fit_page((&record.request, fitted, misfit), &study, command_line, &files)?;
    destination.write_page("report", &page, out)?;
    if !fitted.start.is_own() {
        write_whole(&out.join("start.toml"), fitted.start.to_toml().as_bytes())?;
    }
    drop(held);
    Ok(study)
}
