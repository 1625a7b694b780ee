//! `vibro design`: from arguments to the library's search.

use crate::common_arguments::{Common, names};
use crate::design_arguments::DesignArguments;
use crate::destination::{self, Destination};
use crate::interruption::{self, Second};
use crate::machine_studies::{ANY, invocation, machine, read_axes, starts_of};
use crate::output;
use crate::progress::{Progress, TIME};
use crate::ranges::in_option;
use crate::sweep::in_words;
use std::path::Path;
use std::sync::atomic::Ordering;
use vibro::Result;
use vibro::studies;
use vibro_design::{Control, DesignRequest, Goal, Limit, design};
use vibro_studies::{Machine, Measure};

/// Form of the interval of a parameter.
const INTERVAL: &str = "NAME=LOW:HIGH without a count, e.g. stop.steel.gap=1mm:8mm";

/// The goal of `--minimize` or `--maximize`.
fn goal(a: &DesignArguments, machine: &Machine) -> Result<Goal> {
    let (option, text, maximize) = match (&a.minimize, &a.maximize) {
        (_, Some(text)) => ("--maximize", text.as_str(), true),
        (text, None) => ("--minimize", text.as_deref().unwrap_or_default(), false),
    };
    let measure: Measure = text.parse().map_err(in_option(option))?;
    measure.check(&machine.description).map_err(in_option(option))?;
    Ok(Goal { measure, maximize })
}

/// The request, checked.
fn request(a: &DesignArguments, common: &Common) -> Result<(DesignRequest, Vec<(&'static str, String)>)> {
    let mut machine: Machine = machine(&a.file, &a.section, common)?;
    let typed = names(&a.vary);
    let vary = read_axes(&mut machine, &typed, INTERVAL)?;
    let over = read_axes(&mut machine, &a.over, ANY)?;
    let intervals = vary.iter().zip(&typed).map(|(axis, typed)| axis.interval(typed, INTERVAL));
    let intervals = intervals.collect::<Result<_>>()?;
    let limit = |text: &String| Limit::read(text, &machine).map_err(in_option("--subject-to"));
    let limits: Vec<Limit> = a.subject_to.iter().map(limit).collect::<Result<_>>()?;
    let mut request = DesignRequest {
        over: over.iter().map(|axis| axis.sampled(a.resolution)).collect::<Result<_>>()?,
        between: over.iter().filter_map(|axis| axis.range().map(|range| range.name.clone())).collect(),
        limits,
        robust: a.robust,
        discard: a.discard,
        periods: a.periods,
        evaluations: a.evaluations,
        again: a.again,
        ..DesignRequest::new(machine.clone(), goal(a, &machine)?, intervals)
    };
    if !a.start.is_empty() {
        request.starts = starts_of(&machine, &a.start)?;
    }
    request.check()?;
    let limits: Vec<String> = request.limits.iter().map(ToString::to_string).collect();
    let options = vec![
        (if request.goal.maximize { "maximize" } else { "minimize" }, request.goal.measure.to_string()),
        ("vary", in_words(&vary)),
        ("over", in_words(&over)),
        ("resolution", a.resolution.to_string()),
        ("subject-to", limits.join(" ")),
        ("robust", a.robust.to_string()),
        ("evaluations", a.evaluations.to_string()),
        ("discard", a.discard.to_string()),
        ("periods", a.periods.to_string()),
        ("again", a.again.to_string()),
        ("start", in_words(&request.starts)),
    ];
    Ok((request, options))
}

/// Searches for the best design. Returns `false` if the search was ended by hand; the best design
/// until then is written.
pub fn run(file: &Path, common: &Common, a: &DesignArguments) -> Result<bool> {
    let (request, options) = request(a, common)?;
    let invocation = invocation(common, &options);
    let destination = Destination::new(common, &invocation, &request.machine);
    // The folder is checked before work begins.
    let out = destination.place(&[destination.result("design")])?;
    let stop = interruption::flag(Second::Ends);
    let progress = Progress::new(0, TIME);
    let found = design(
        &request,
        &Control {
            go_on: &|| !stop.load(Ordering::Relaxed),
            progress: &|now| {
                progress.described(now.part, &|| now.to_string(), "left at most");
            },
        },
    )?;
    drop(progress);
    let study = studies::designed(&request, &found)?;
    let held = destination::hold(&common.out);
    destination.write(std::slice::from_ref(&study))?;
    if let Some(machine) = studies::best_machine(&request, &found)? {
        let verdict = format!("vibro design: {}", found.verdict);
        let name = ("best.toml", verdict.as_str());
        vibro::machine::write_with_numbers(file, &machine.description, name, &out)?;
    }
    drop(held);
    output::print(&[study], &request.machine, &out, common)?;
    Ok(!stop.load(Ordering::Relaxed))
}
