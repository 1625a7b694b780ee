//! Reference results in the archives, by the layered standard FMI-LS-REF 1.0.0-alpha.1
//! (modelica/fmi-ls-ref): results of the default experiment and of its impacts, this experiment as
//! a smoke test, sets of parameters with start values, and a saved state of the settled motion.

use crate::archive::Content;
use crate::error::Result;
use fmi_doors::description::Experiment;
use fmi_doors::{Component as _, Model as _};
use std::fmt::Write;
use vibro_figures::html::escape;
use vibro_impact::parameters::{FIELDS, Groups, Scales};
use vibro_impact::simulator::{DueEvent, Pause};
use vibro_impact::{Parameters, Simulator, State};
use vibro_pack::reference::{ALWAYS, manifest, smoke_test};
use vibro_paper_component::component::identity::default_experiment;
use vibro_paper_component::component::log::Silence;
use vibro_paper_component::component::variables::{Bases, reference};
use vibro_paper_component::component::{Instance, Interface, structure};

pub use vibro_pack::reference::FOLDER;

/// Results that are committed, since their last digits depend on the processor that makes them.
static DEFAULT: &str = include_str!("../../modelDescription/reference/default.csv");
static IMPACTS: &str = include_str!("../../modelDescription/reference/impacts.csv");

/// Displacements and velocities of the default motion after 1000 drive periods, m and m/s, to nine
/// decimals: start values on the settled motion at drive phase zero.
pub const SETTLED: [f64; 6] =
    [-0.213938687, -0.150042033, 0.942518231, -0.317291698, -0.865976145, 0.163384581];

/// The files by their names in the folder.
///
/// # Errors
/// [`Error::Native`](crate::Error::Native) if a set of parameters is not possible.
pub fn files() -> Result<Content> {
    let mut content = Content::from([
        ("default.csv".to_owned(), DEFAULT.as_bytes().to_vec()),
        ("impacts.csv".to_owned(), IMPACTS.as_bytes().to_vec()),
        ("settled.state".to_owned(), settled_state()),
        ("smoke-test.xml".to_owned(), own_smoke_test().into_bytes()),
    ]);
    let sets = sets()?;
    for set in &sets {
        content.insert(format!("{}.ssv", set.name), set.ssv().into_bytes());
    }
    content.insert("fmi-ls-manifest.xml".to_owned(), own_manifest(&sets).into_bytes());
    Ok(content)
}

/// Explanation of the files for a reader (`documentation/fmi-ls-ref.txt`).
pub const EXPLANATION: &str = "Reference files in extra/org.fmi-standard.fmi-ls-ref (FMI-LS-REF 1.0.0-alpha.1)\n\n\
default.csv      the default experiment, 50 rows a drive period (its step is a quarter of their distance): displacements to nine\n\
                 places, numbers of impacts so far\n\
smoke-test.xml   that experiment and its result, in the form of the draft's schema of experiments: an importer that reproduces\n\
                 default.csv to 1e-8 m runs this FMU right\n\
impacts.csv      every impact of it: two rows at its time, the states before and after the law\n\
settled.ssv      start values on the settled motion, at drive phase zero; settled.state is an instance for Co-Simulation that was\n\
                 initialized with them and serialized (FMI 2.0 and FMI 3.0 of this same build take it, on every platform)\n\
figure-*.ssv     parameters of the figures of Nonlinear Dynamics 106 (2021) 81-103 as far as this reconstruction has them, with\n\
                 start values: a moving block, since from rest a weak drive never reaches the stops. The figures show the motion\n\
                 after 400 drive periods\n\n\
The motion is stable: other processors differ in the last digits alone. A run to compare with: start values as they are, any\n\
communication step, 1e-8 m.\n";

/// A set of parameters, or of start values.
struct Set {
    name: String,
    description: String,
    values: Vec<(&'static str, f64)>,
}

impl Set {
    /// The set as parameter set of SSP 1.0.
    fn ssv(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "<ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" version=\"1.0\" name=\"{}\" \
             description=\"{}\">\n  <ssv:Parameters>",
            self.name,
            escape(&self.description)
        );
        for (name, value) in &self.values {
            let _ = writeln!(
                text,
                "    <ssv:Parameter name=\"{name}\"><ssv:Real value=\"{value}\"/></ssv:Parameter>"
            );
        }
        text + "  </ssv:Parameters>\n</ssv:ParameterSet>\n"
    }
}

fn parameters(p: &Parameters) -> Vec<(&'static str, f64)> {
    FIELDS.iter().map(|field| (field.name, (field.get)(p))).collect()
}

/// The set of a machine with the start values of the studies: all bodies are in the middle, the
/// block moves towards the upper stop with the speed L ω10, and the other bodies are at rest.
fn set(name: String, description: String, groups: &Groups) -> Result<Set> {
    let p = groups.to_parameters(Scales::default())?;
    let start = [0.0, 0.0, 0.0, 0.0, p.stop_gap * p.box_frequency(), 0.0];
    let start = structure::STATES.into_iter().zip(start);
    Ok(Set { name, description, values: parameters(&p).into_iter().chain(start).collect() })
}

/// The sets: one for each figure with motions, with the values of `vibro paper reproduce`.
fn sets() -> Result<Vec<Set>> {
    let basic = Groups::basic();
    let force = |f10: f64| Groups { f10, ..basic };
    let mut sets = vec![Set {
        name: "settled".into(),
        description: "Start values on the settled motion of the default parameters".into(),
        values: structure::STATES.into_iter().zip(SETTLED).collect(),
    }];
    let text = "The basic set: symmetric motion with two impacts a period".to_owned();
    sets.push(set("figure-8".into(), text, &basic)?);
    let text = "Modulated motion at the drive amplitude f10 = 0.6 (figure 13)".to_owned();
    sets.push(set("figure-13-f10-0.6".into(), text, &force(0.6))?);
    for f10 in [1.2, 2.5] {
        let text =
            format!("A motion with the drive amplitude f10 = {f10}, whose fixed points figure 9 shows");
        sets.push(set(format!("figure-9-f10-{f10}"), text, &force(f10))?);
    }
    for f10 in [2.2, 2.44, 2.7, 2.82, 2.88, 3.1, 3.6, 3.9] {
        let text = format!("A motion with the drive amplitude f10 = {f10} (figure 15)");
        sets.push(set(format!("figure-15-f10-{f10}"), text, &force(f10))?);
    }
    for epsilon in [0.05, 0.02, 0.01, 0.005] {
        let text = format!("A motion with the mass ratio epsilon = {epsilon} (figure 17)");
        // With m3 = m2 and β² = ε α̂23, the weak coupling of `Groups::weak`.
        let groups = Groups { epsilon, beta2: epsilon * basic.alpha23, mu13: 1.0 / epsilon, ..basic };
        sets.push(set(format!("figure-17-epsilon-{epsilon}"), text, &groups)?);
    }
    let strong = Groups { beta2: 0.3, alpha23: 3.0, mu13: 1.0, sigma30: 0.5, ..basic };
    let text = "Strong coupling; numbers of this program's own".to_owned();
    sets.push(set("figure-19".into(), text, &strong)?);
    Ok(sets)
}

/// Entries of the manifest for this machine's files.
fn own_manifest(sets: &[Set]) -> String {
    let results = [
        (
            "text/csv",
            "default.csv",
            "result",
            "Displacements and counts of impacts in the default experiment",
        ),
        (
            "text/csv",
            "impacts.csv",
            "result",
            "States before and after every impact of the default experiment",
        ),
        (
            "application/octet-stream",
            "settled.state",
            "serialized-state",
            "Co-Simulation instance on the settled motion, for every platform",
        ),
    ];
    let sources: Vec<_> = sets.iter().map(|set| format!("{}.ssv", set.name)).collect();
    let sets = sets.iter().zip(&sources);
    let sets = sets.map(|(set, source)| {
        ("application/x-ssp-parameter-set", source.as_str(), "parameter", set.description.as_str())
    });
    manifest(results.into_iter().chain(ALWAYS).chain(sets))
}

/// The default experiment as a smoke test, with the reported steps.
fn own_smoke_test() -> String {
    let experiment = default_experiment();
    let step_size = f64::from(REPORTED) * experiment.step_size;
    smoke_test(Experiment { step_size, ..experiment }, "1e-8 m")
}

/// A serialized instance that was initialized with [`SETTLED`]. No digit depends on the rounding
/// of a processor.
fn settled_state() -> Vec<u8> {
    let mut instance = Instance::new(Interface::CoSimulation);
    let references = structure::STATES.map(reference);
    let made = instance
        .set(Bases::REAL, &references, |i| SETTLED[i])
        .and_then(|()| instance.set_experiment(None, 0.0, None))
        .and_then(|()| {
            instance.enter_initialization();
            instance.exit_initialization(&mut Silence)
        })
        .and_then(|()| instance.save().serialize());
    // The numbers are constants, and a test restores them.
    made.unwrap_or_default()
}

/// Recomputes the results with the native library: path in the workspace → content.
///
/// # Errors
/// [`Error::Native`](crate::Error::Native): only in case of a defect in this crate.
pub fn results() -> Result<Content> {
    let file = |name: &str| format!("modelDescription/reference/{name}");
    Ok(Content::from([
        (file("default.csv"), default_result()?.into_bytes()),
        (file("impacts.csv"), impact_result()?.into_bytes()),
    ]))
}

fn simulator() -> Result<Simulator> {
    Ok(Simulator::new(&Parameters::default(), &State::default(), 0.0)?)
}

/// Steps of the default experiment per row of its result.
const REPORTED: u32 = 4;

/// Displacements at every fourth step of the default experiment, to nine decimals, on which
/// different processors agree.
fn default_result() -> Result<String> {
    let Experiment { start_time, stop_time, step_size, .. } = default_experiment();
    let mut simulator = simulator()?;
    let mut text = String::from("time,box.s,block.s,secondary.s,impacts.upper,impacts.lower\n");
    let interval = f64::from(REPORTED) * step_size;
    let steps = ((stop_time - start_time) / interval).round() as u32;
    for i in 0..=steps {
        let time = start_time + f64::from(i) * interval;
        simulator.advance_to(time)?;
        let ([x1, x2, x3], record) = (simulator.state().x, simulator.impacts());
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{time},{x1:.9},{x2:.9},{x3:.9},{},{}", record.upper, record.lower);
    }
    Ok(text)
}

/// Two rows for each impact: the states before and after it.
fn impact_result() -> Result<String> {
    let mut simulator = simulator()?;
    let mut text = String::from("time,box.s,block.s,secondary.s,box.v,block.v,secondary.v\n");
    let stop = default_experiment().stop_time;
    while simulator.time() < stop {
        simulator.advance_until(stop, Pause::BeforeEvent, None)?;
        let (time, before) = (simulator.time(), simulator.state());
        if let Some(DueEvent::Impact { .. }) = simulator.apply_due_event(None) {
            for State { x: [x1, x2, x3], v: [v1, v2, v3] } in [before, simulator.state()] {
                // Writing to a String cannot fail.
                let _ = writeln!(text, "{time},{x1},{x2},{x3},{v1},{v2},{v3}");
            }
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The motion contracts, so the transient after 1000 periods is only rounding.
    #[test]
    fn second_method_of_the_settled_state() {
        const PLACES: f64 = 1e-9;
        let mut simulator = simulator().unwrap();
        simulator.advance_to(1000.0 * Parameters::default().period()).unwrap();
        let State { x, v } = simulator.state();
        for (settled, reached) in SETTLED.iter().zip([x, v].concat()) {
            assert!((settled - reached).abs() < PLACES, "{:?}", [x, v].concat());
        }
        assert!(!settled_state().is_empty());
    }

    /// Like the figures: 400 periods from the start values of the set, and then motion with
    /// impacts, at both stops and modulated if the figure states it.
    #[test]
    fn second_method_sets_reproduce_the_motions_they_name() {
        for set in sets().unwrap().iter().filter(|set| set.name != "settled") {
            let value = |name: &str| set.values.iter().find(|(n, _)| *n == name).map(|(_, v)| *v).unwrap();
            let mut parameters = Parameters::default();
            FIELDS.iter().for_each(|field| (field.set)(&mut parameters, value(field.name)));
            let [x1, x2, x3, v1, v2, v3] = structure::STATES.map(value);
            let start = State { x: [x1, x2, x3], v: [v1, v2, v3] };
            let mut simulator = Simulator::new(&parameters, &start, 0.0).unwrap();
            let mut counts = Vec::new();
            for period in 400..=450 {
                simulator.advance_to(f64::from(period) * parameters.period()).unwrap();
                counts.push([simulator.impacts().upper, simulator.impacts().lower]);
            }
            let [first, last] = [counts[0], counts[50]];
            let met = [last[0] - first[0], last[1] - first[1]];
            let name = &set.name;
            assert!(met.iter().all(|n| *n >= 10), "{name}: {met:?} impacts in 50 periods");
            if name == "figure-8" {
                assert_eq!(met, [50, 50], "{name}");
            }
            let even = counts.windows(2).all(|w| w[1][0] - w[0][0] == 1 && w[1][1] - w[0][1] == 1);
            assert!(name != "figure-13-f10-0.6" || !even, "{name} is modulated");
        }
    }

    /// Compares every number of the committed results, to 2e-9.
    #[test]
    fn committed_results_are_what_is_computed() {
        const PLACES: f64 = 2e-9;
        for (committed, computed) in
            [(DEFAULT, default_result().unwrap()), (IMPACTS, impact_result().unwrap())]
        {
            assert_eq!(
                committed.lines().count(),
                computed.lines().count(),
                "run `cargo run --bin fmu-build -- refresh`"
            );
            for (a, b) in committed.lines().zip(computed.lines()).skip(1) {
                for (a, b) in a.split(',').zip(b.split(',')) {
                    let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
                    assert!((a - b).abs() < PLACES, "{a} {b}");
                }
            }
        }
    }
}
