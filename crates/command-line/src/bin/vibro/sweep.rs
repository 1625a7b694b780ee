//! `vibro sweep`: conversion of its arguments to the library's study, for either machine.

use crate::common_arguments::Common;
use crate::long::perform_as;
use crate::ranges::texts;
use crate::sweep_arguments::{AxisArgument, Sweep};
use std::fmt::Display;
use vibro::design_file;
use vibro::long_study::{LongStudy, StudyKind};
use vibro::{Error, Result};
use vibro_studies::AxisName;
use vibro_studies::design_sweep::{DesignMachine, Designs, SweepRequest};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::design_sweep::spread_starts;
use vibro_studies::paper::measures::Measure;
use vibro_studies::paper::start::StartRule;
use vibro_studies::sobol::DIMENSIONS;

/// The designs of `--vary`: a grid, or a Sobol sequence.
fn designs<N: AxisName>(a: &Sweep, vary: &[AxisArgument<N>]) -> Result<Designs<N>> {
    match a.sobol {
        None => Ok(Designs::Grid(vary.iter().map(|axis| axis.sampled(a.resolution)).collect::<Result<_>>()?)),
        Some(count) if (1..=DIMENSIONS).contains(&vary.len()) => {
            const EXPECTED: &str = "NAME=FROM:TO without a count: --sobol sets the number of points";
            let intervals = vary.iter().zip(&a.vary).map(|(axis, typed)| axis.interval(typed, EXPECTED));
            let intervals = intervals.collect::<Result<_>>()?;
            Ok(Designs::Sobol { intervals, count })
        }
        Some(_) => {
            let what = format!("--sobol with {} parameters", vary.len());
            let problem = format!("expected 1 to {DIMENSIONS}, each by --vary NAME=FROM:TO");
            Err(Error::Refused { what, problem })
        }
    }
}

/// The request for either machine, with the default start and without repeated measures. It is not
/// yet checked.
///
/// # Errors
/// An error if a range is not valid or has too many values.
pub fn request<M: DesignMachine>(
    a: &Sweep,
    vary: &[AxisArgument<M::Name>],
    over: &[AxisArgument<M::Name>],
    asked: Vec<M::Measure>,
) -> Result<SweepRequest<M>> {
    let ranges = over.iter().filter_map(|axis| axis.range().map(|range| range.name.clone()));
    let between = ranges.collect();
    let mut measures: Vec<M::Measure> = Vec::new();
    for measure in asked {
        if !measures.contains(&measure) {
            measures.push(measure);
        }
    }
    Ok(SweepRequest {
        designs: designs(a, vary)?,
        over: over.iter().map(|axis| axis.sampled(a.resolution)).collect::<Result<_>>()?,
        discard: a.discard,
        periods: a.periods,
        measures,
        between,
        again: a.again,
        ..SweepRequest::default()
    })
}

/// Text of axes or measures, in SI, for manifests.
pub fn in_words<T: Display>(axes: &[T]) -> String {
    axes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// The sweep of the paper's machine.
///
/// # Errors
/// An error if a design, measure or start is not valid; the errors of [`perform_as`].
pub fn sweep(set: &ParameterSet, common: &Common, a: &Sweep) -> Result<()> {
    let own = &a.of_paper;
    let measures: Vec<Measure> = texts("--output", &a.output)?;
    let mut request = request::<ParameterSet>(a, &own.vary, &own.over, measures)?;
    if let Some(path) = &own.design {
        request.designs = design_file::read(path, set)?;
    }
    request.starts = if own.start.is_empty() { vec![StartRule::default()] } else { own.start.clone() };
    request.starts.extend(spread_starts(own.starts));
    request.check()?;
    let mut invocation = common.invocation.clone();
    for (option, axes) in [("vary", &own.vary), ("over", &own.over)] {
        if !axes.is_empty() {
            invocation.options.insert(option.into(), in_words(axes));
        }
    }
    if let Designs::Rows { names, rows } = &request.designs {
        invocation.options.insert("design".into(), design_file::in_words(names, rows));
    }
    let study = LongStudy::new("sweep", StudyKind::DesignSweep(request), set);
    perform_as(&study, common, &invocation, a.share.shard)
}

/// All outputs of the paper's machine with unit and meaning.
pub fn list() -> String {
    let mut text = String::from("outputs of `vibro paper sweep --output NAME,…`, in SI:\n");
    for measure in Measure::all() {
        let unit = if measure.unit() == "1" { "" } else { measure.unit() };
        text.push_str(&format!("  {:24} {unit:4} {}\n", measure.name(), measure.description()));
    }
    text
}
