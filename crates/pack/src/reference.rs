//! Reference results in the archives of described machines, as in the layered standard FMI-LS-REF
//! 1.0.0-alpha.1 (modelica/fmi-ls-ref): the default experiment and its events, computed by the
//! engine on the computer that builds the archive.

use crate::archive::Content;
use fmi_doors::description::Experiment;
use std::fmt::Write;
use std::sync::Arc;
use vibro_figures::html::escape;
use vibro_machine::motion::Reached;
use vibro_machine::{Assembly, Error, Motion};
use vibro_machine_component::Plan;

/// Folder of the files in an archive.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// Version of the layered standard.
const VERSION: &str = "1.0.0-alpha.1";

/// Number of steps of the default experiment per row of its result.
const REPORTED: u32 = 4;
/// Largest number of events in the result.
const EVENTS: usize = 1000;
/// Relative perturbation of the second motion's start: some tens of roundings.
const SHIFT: f64 = 1e-14;
/// Largest difference of the two motions, relative to a column's largest value so far. The result
/// ends before a row with a larger difference. Up to that row, other processors agree as well.
const AGREEMENT: f64 = 1e-9;

/// Explanation of the files for a reader (`documentation/fmi-ls-ref.txt`).
pub const EXPLANATION: &str = "Reference files in extra/org.fmi-standard.fmi-ls-ref (FMI-LS-REF 1.0.0-alpha.1)\n\n\
default.csv      the default experiment, every fourth step: coordinates and rates of all bodies, numbers of impacts so far. If\n\
                 the motion amplifies rounding errors, the file ends where fewer than ten digits are certain\n\
smoke-test.xml   the default experiment and its result, in the draft's schema of experiments: an importer for Co-Simulation\n\
                 that reproduces default.csv to 1e-8 of each column's largest value runs this FMU correctly\n\
events.csv       the events, at most 1000: two rows at the time of each, with the states before and after its law\n";

/// The files by name in the folder; empty for a machine whose motion cannot begin.
pub fn files(plan: &Plan) -> Content {
    let experiment = plan.description().experiment;
    let Ok((rows, end)) = default_result(plan, experiment) else { return Content::new() };
    let step_size = f64::from(REPORTED) * experiment.step_size;
    let told = Experiment { stop_time: end, step_size, ..experiment };
    let results = [
        (
            "text/csv",
            "default.csv",
            "result",
            "Coordinates, rates and counts of impacts in the default experiment",
        ),
        ("text/csv", "events.csv", "result", "States before and after every event of the default experiment"),
    ];
    Content::from([
        ("default.csv".to_owned(), rows.into_bytes()),
        ("events.csv".to_owned(), events(plan, end).into_bytes()),
        ("smoke-test.xml".to_owned(), smoke_test(told, "1e-8 of each column's largest value").into_bytes()),
        ("fmi-ls-manifest.xml".to_owned(), manifest(results.into_iter().chain(ALWAYS)).into_bytes()),
    ])
}

/// A file listed in the manifest: media type, path, role, description.
pub type Related<'a> = (&'a str, &'a str, &'a str, &'a str);

/// Files that every such folder has: the explanation and the default experiment.
pub const ALWAYS: [Related<'_>; 2] = [
    (
        "application/xml",
        "smoke-test.xml",
        "experiment/smoke-test",
        "The default experiment with its result: does an importer run this FMU right?",
    ),
    ("text/plain", "../../documentation/fmi-ls-ref.txt", "document", "Explanation of these files"),
];

/// `fmi-ls-manifest.xml`.
pub fn manifest<'a>(files: impl IntoIterator<Item = Related<'a>>) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" \
         fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\" fmi-ls:fmi-ls-version=\"{VERSION}\" \
         fmi-ls:fmi-ls-description=\"Layered Standard providing information on related files included in an FMU.\">\n"
    );
    for (kind, source, role, description) in files {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  <Related type=\"{kind}\" source=\"{source}\" role=\"{role}\" description=\"{}\"/>",
            escape(description)
        );
    }
    text + "</fmiReferences>\n"
}

/// `smoke-test.xml`: an experiment whose result is `default.csv`, in the draft's schema of
/// experiments. `agreement` is the text on the expected reproducibility.
pub fn smoke_test(experiment: Experiment, agreement: &str) -> String {
    let Experiment { start_time, stop_time, tolerance, step_size } = experiment;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Experiments>\n  <Experiment name=\"default\" description=\"The default experiment from \
         the start values, to be reproduced to {agreement}\" startTime=\"{start_time}\" stopTime=\"{stop_time}\" stepSize=\"{step_size}\" \
         tolerance=\"{tolerance}\">\n    <References source=\"default.csv\"/>\n  </Experiment>\n</Experiments>\n"
    )
}

/// Coordinates and rates of all bodies.
fn states(motion: &Motion) -> Vec<f64> {
    let bodies = 0..motion.assembly().description.bodies.len();
    bodies.flat_map(|i| [motion.coordinate(i), motion.rate(i)]).collect()
}

fn heading(plan: &Plan) -> String {
    let bodies = &plan.assembly.description.bodies;
    bodies.iter().map(|body| format!(",{0}.s,{0}.v", body.name)).collect()
}

fn push(text: &mut String, time: f64, states: &[f64]) {
    // Writing to a String cannot fail.
    let _ = write!(text, "{time}");
    for value in states {
        let _ = write!(text, ",{:.9e}", value + 0.0);
    }
}

/// A motion whose start differs by some tens of roundings from the machine's own.
fn beside(plan: &Plan, motion: &Motion) -> Result<Motion, Error> {
    let states = states(motion);
    let starts =
        states.chunks_exact(2).map(|pair| (pair[0] * (1.0 + SHIFT), pair[1] * (1.0 - SHIFT))).collect();
    let machine = Assembly::new(plan.assembly.description.clone())?.starting_from(starts);
    Motion::new(Arc::new(machine))
}

/// The rows of the result, to ten digits, and the time of the last row.
fn default_result(plan: &Plan, experiment: Experiment) -> Result<(String, f64), Error> {
    let mut motion = Motion::new(plan.assembly.clone())?;
    let mut other = beside(plan, &motion)?;
    let stops = &plan.assembly.description.stops;
    let counted: Vec<usize> = (0..stops.len())
        .filter(|&i| plan.table.reference(&format!("{}.impacts", stops[i].name)).is_some())
        .collect();
    let mut text = format!("time{}", heading(plan));
    counted.iter().for_each(|&i| text += &format!(",{}.impacts", stops[i].name));
    text.push('\n');
    let interval = f64::from(REPORTED) * experiment.step_size;
    let steps = (experiment.stop_time / interval).round() as u32;
    let (mut largest, mut end) = (vec![0.0_f64; states(&motion).len()], 0.0);
    for k in 0..=steps {
        let time = f64::from(k) * interval;
        if motion.advance_to(time).and_then(|()| other.advance_to(time)).is_err() {
            break;
        }
        let (own, others) = (states(&motion), states(&other));
        largest.iter_mut().zip(&own).for_each(|(most, x)| *most = most.max(x.abs()));
        let counts =
            |motion: &Motion| -> Vec<u64> { counted.iter().map(|&i| motion.impacts(i).count).collect() };
        let near =
            own.iter().zip(&others).zip(&largest).all(|((a, b), most)| (a - b).abs() <= AGREEMENT * most);
        if !near || counts(&motion) != counts(&other) {
            break;
        }
        push(&mut text, time, &own);
        counts(&motion).iter().for_each(|count| text += &format!(",{count}"));
        text.push('\n');
        end = time;
    }
    Ok((text, end))
}

/// Two rows for each event up to `end`, at most [`EVENTS`] events: before and after its law.
fn events(plan: &Plan, end: f64) -> String {
    let mut text = format!("time{}\n", heading(plan));
    let Ok(mut motion) = Motion::new(plan.assembly.clone()) else { return text };
    for _ in 0..EVENTS {
        if !matches!(motion.advance_before_event(end, &mut |_| ()), Ok(Reached::Event)) {
            break;
        }
        let before = states(&motion);
        if motion.apply_event(&mut |_| ()).is_err() {
            break;
        }
        for states in [before, states(&motion)] {
            push(&mut text, motion.time(), &states);
            text.push('\n');
        }
    }
    text
}
