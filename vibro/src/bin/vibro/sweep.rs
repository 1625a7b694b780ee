//! `vibro sweep`: from its arguments to the library's study.

use crate::common_arguments::Common;
use crate::long::perform_as;
use crate::sweep_arguments::{AxisArgument, Sweep};
use vibro::design_file;
use vibro::long_study::{LongStudy, StudyKind};
use vibro::{Error, Result};
use vibro_analysis::ParameterSet;
use vibro_analysis::design_sweep::{Designs, SweepRequest, spread_starts};
use vibro_analysis::measures::Measure;
use vibro_analysis::sobol::DIMENSIONS;
use vibro_analysis::start::StartRule;

/// The designs that were asked for.
fn designs(set: &ParameterSet, a: &Sweep) -> Result<Designs> {
    if let Some(path) = &a.design {
        return design_file::read(path, set);
    }
    match a.sobol {
        None => {
            Ok(Designs::Grid(a.vary.iter().map(|axis| axis.sampled(a.resolution)).collect::<Result<_>>()?))
        }
        Some(count) if (1..=DIMENSIONS).contains(&a.vary.len()) => {
            let intervals = a.vary.iter().map(AxisArgument::interval).collect::<Result<_>>()?;
            Ok(Designs::Sobol { intervals, count })
        }
        Some(_) => {
            let what = format!("--sobol with {} parameters", a.vary.len());
            Err(Error::Refused {
                what,
                problem: format!("allowed are 1 to {DIMENSIONS}, each by --vary NAME=FROM:TO"),
            })
        }
    }
}

fn request(set: &ParameterSet, a: &Sweep) -> Result<SweepRequest> {
    let over = a.over.iter().map(|axis| axis.sampled(a.resolution)).collect::<Result<Vec<_>>>()?;
    let mut starts = if a.start.is_empty() { vec![StartRule::default()] } else { a.start.clone() };
    starts.extend(spread_starts(a.starts));
    let mut measures: Vec<Measure> = Vec::new();
    for measure in &a.output {
        if !measures.contains(measure) {
            measures.push(*measure);
        }
    }
    let ranges = a.over.iter().zip(&over).filter(|(axis, _)| axis.is_range());
    let between = ranges.map(|(_, axis)| axis.name).collect();
    let request = SweepRequest {
        designs: designs(set, a)?,
        over,
        starts,
        discard: a.discard,
        periods: a.periods,
        measures,
        between,
        again: a.again,
    };
    request.check()?;
    Ok(request)
}

pub fn sweep(set: &ParameterSet, common: &Common, a: &Sweep) -> Result<()> {
    let request = request(set, a)?;
    let mut invocation = common.invocation.clone();
    let words = |axes: &[AxisArgument]| axes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    for (option, axes) in [("vary", &a.vary), ("over", &a.over)] {
        if !axes.is_empty() {
            invocation.options.insert(option.into(), words(axes));
        }
    }
    if let Designs::Rows { names, rows } = &request.designs {
        invocation.options.insert("design".into(), design_file::in_words(names, rows));
    }
    perform_as(
        &LongStudy::new("sweep", StudyKind::DesignSweep(request), set),
        common,
        &invocation,
        a.share.shard,
    )
}

/// All outputs with unit and meaning.
pub fn list() -> String {
    let mut text = String::from("outputs of `vibro sweep --output NAME,…`, in SI:\n");
    for measure in Measure::all() {
        let unit = if measure.unit() == "1" { "" } else { measure.unit() };
        text.push_str(&format!("  {:24} {unit:4} {}\n", measure.name(), measure.description()));
    }
    text
}
