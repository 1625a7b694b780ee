//! `vibro fit`: its arguments, and their conversion to the library's fit.

use crate::assembly_studies::{invocation, machine, start_of};
use crate::common_arguments::{Common, START_VALUE, SectionArguments, start_help};
use crate::destination::{self, Destination};
use crate::output;
use crate::progress::Progress;
use crate::ranges::whole;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use vibro::assembly::read_record;
use vibro::part_folder::write_whole;
use vibro::studies::{self, fit_json};
use vibro::{Error, Result};
use vibro_analysis::assembly::fit::{FitRequest, Free, Loss, Measured, fit};
use vibro_analysis::assembly::{Machine, QuantityName};
use vibro_assembly::What;
use vibro_impact::quantities::quantity_in;

/// Arguments of `fit`.
#[derive(Args, Debug)]
pub struct FitArguments {
    /// The machine's file (TOML); its numbers, with --set, are the values from which the fit begins
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The record: a table whose first line names `time` and columns such as box.s, SI
    #[arg(long, value_name = "TABLE", required_unless_present = "events")]
    pub data: Option<PathBuf>,
    /// Times of impacts and first touches of stops: a table with the columns `element` and `time`
    #[arg(long, value_name = "TABLE")]
    pub events: Option<PathBuf>,
    /// The numbers that are fitted: parameters, numbers of the start (body.box.start.s, or
    /// start.box.s), record.shift, record.offset.COLUMN
    #[arg(long, required = true, value_name = "NAME,…", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Range of a free number [default: what it may be]. May be repeated
    #[arg(long, value_name = "NAME=LOW:HIGH", value_delimiter = ',', allow_hyphen_values = true)]
    pub within: Vec<String>,
    /// Standard deviation of the noise: a number for each column in the record's order, then one for
    /// the times of contacts; or COLUMN=VALUE with a unit, `contacts=1ms`
    /// [default: by the residuals]
    #[arg(long, value_name = "VALUE,…|COLUMN=VALUE", value_delimiter = ',')]
    pub sigma: Vec<String>,
    /// How residuals count
    #[arg(long, value_name = "LOSS", default_value = "linear")]
    pub loss: LossArgument,
    /// Number of further starts of the fit, spread over --within
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=10_000))]
    pub starts: u32,
    /// Start of the motion.
    #[arg(long, help = start_help!("Start of the motion"), value_name = START_VALUE, allow_hyphen_values = true)]
    pub start: Vec<String>,
}

/// How residuals count.
#[derive(Clone, Copy, Debug, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum LossArgument {
    /// By their squares
    Linear,
    /// Large ones by their size, smoothly
    #[value(name = "soft_l1")]
    SoftL1,
    /// Large ones by their size
    Huber,
}

impl From<LossArgument> for Loss {
    fn from(loss: LossArgument) -> Self {
        match loss {
            LossArgument::Linear => Self::Linear,
            LossArgument::SoftL1 => Self::SoftL1,
            LossArgument::Huber => Self::Huber,
        }
    }
}

/// A number with an optional unit of a dimension, SI.
fn number(name: &str, unit: &'static str, text: &str) -> Result<f64> {
    let plain = text.trim().parse::<f64>().ok();
    let read = plain.or_else(|| quantity_in(unit, text.trim()).map(|quantity| quantity.value));
    read.filter(|x| x.is_finite()).ok_or_else(|| Error::Refused {
        what: format!("{name} = {text}"),
        problem: format!("allowed is a number, in {unit} or with a unit of it"),
    })
}

/// The unit of a free number.
fn unit_of(machine: &Machine, name: &str) -> &'static str {
    if name == "record.shift" {
        return "s";
    }
    let column = name.strip_prefix("record.offset.").or_else(|| name.strip_prefix("start."));
    let quantity =
        column.and_then(|column| column.parse::<QuantityName>().ok()?.find(&machine.description).ok());
    quantity.map_or_else(|| machine.si_unit(name), |named| named.unit)
}

/// The free numbers with their ranges.
fn free(machine: &Machine, a: &FitArguments) -> Result<Vec<Free>> {
    let mut all: Vec<Free> =
        a.free.iter().map(|name| Free { name: name.trim().to_owned(), within: None }).collect();
    for text in &a.within {
        let form = || Error::form(text, "NAME=LOW:HIGH, e.g. stop.steel.gap=3mm:5mm");
        let (name, range) = text.split_once('=').ok_or_else(form)?;
        let (low, high) = range.split_once(':').ok_or_else(form)?;
        let own = all.iter_mut().find(|own| own.name == name.trim()).ok_or_else(|| Error::Refused {
            what: format!("--within {text}"),
            problem: format!("{name} is not free; allowed are {}", a.free.join(", ")),
        })?;
        let unit = unit_of(machine, name.trim());
        own.within = Some((number(name, unit, low)?, number(name, unit, high)?));
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

/// Fits a machine to a record.
pub fn run(common: &Common, a: &FitArguments) -> Result<bool> {
    let machine = machine(&a.file, &SectionArguments { period: None, section: None }, common)?;
    let start = start_of(&machine, &a.start)?;
    let measured = read_record(a.data.as_deref(), a.events.as_deref())?;
    for (name, _) in &measured.columns {
        if name.what == What::A {
            let problem = "allowed are s and v of bodies, e, rate and f of elements".into();
            return Err(Error::Refused { what: format!("column {name}"), problem });
        }
    }
    let (free, sigma) = (free(&machine, a)?, sigma(&machine, &measured, &a.sigma)?);
    let path =
        |path: &Option<PathBuf>| path.as_ref().map_or(String::new(), |path| path.display().to_string());
    let options = [
        ("data", path(&a.data)),
        ("events", path(&a.events)),
        ("free", a.free.join(",")),
        ("within", a.within.join(",")),
        ("sigma", a.sigma.join(",")),
        ("loss", format!("{:?}", a.loss)),
        ("starts", a.starts.to_string()),
        ("start", start.to_string()),
    ];
    let invocation = invocation(common, &options);
    let destination = Destination::new(common, &invocation, &machine);
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result("fit")])?;
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    // Without a handler Ctrl-C ends the program too, but nothing is written.
    drop(ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed)));
    let progress = Progress::new(0, "fit").ticking();
    let request = FitRequest {
        machine: machine.clone(),
        start,
        measured,
        free,
        sigma,
        loss: a.loss.into(),
        starts: a.starts,
    };
    let fitted = fit(&request, &|| !stop.load(Ordering::Relaxed))?;
    drop(progress);
    let study = studies::assembly_fit(&request, &fitted)?;
    let held = destination::hold(&common.out);
    destination.write(std::slice::from_ref(&study))?;
    write_whole(&out.join("fit.json"), fit_json(&fitted).as_bytes())?;
    write_whole(&out.join("fitted.toml"), fitted.machine.description.to_toml().as_bytes())?;
    if !fitted.start.is_own() {
        write_whole(&out.join("start.toml"), fitted.start.to_toml().as_bytes())?;
    }
    drop(held);
    output::print(&[study], &machine, &out, common)?;
    Ok(!stop.load(Ordering::Relaxed))
}
