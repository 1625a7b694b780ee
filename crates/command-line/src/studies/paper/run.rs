//! One motion of the 3-DOF machine: table, impacts, picture, account.

mod envelope;
mod history;
mod picture;

use super::steady_motion::SteadyMotion;
use crate::studies::Study;
use crate::table::{CsvRows, TextTable, exact};
use crate::{Error, Result};
use history::{Extent, History, RunImpact};
use vibro_impact::load::Load;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Simulator, State};
use vibro_studies::MotionClass;
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::motion::settled_simulator;
use vibro_studies::paper::start::{Coordinate, StartRule, state};
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::trajectories;
use vibro_studies::paper::verdict::{PROLONGED, verdict};

/// Drive periods discarded if neither a start nor a load is given.
const DISCARD: u32 = 400;
/// Drive periods recorded by default.
const PERIODS: u32 = 20;
/// Smallest number of steps per drive period: cubic interpolation between them is accurate to
/// about 1e-8 of the amplitudes.
const LEAST: u32 = 128;
/// Largest number of steps of a run; they take a few hundred megabytes.
const MOST: u32 = 3_000_000;
/// Names of the displacements; the fourth one is x2 - x1.
const NAMES: [&str; 4] = ["x1", "x2", "x3", "w"];

/// Length of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunLength {
    /// In drive periods.
    Periods(f64),
    /// In s.
    Seconds(f64),
    /// To the last sample of the loads, or 20 drive periods without loads.
    Default,
}

/// A run to be computed.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// Length of the run.
    pub length: RunLength,
    /// Drive periods discarded before the run begins, without loads; by default 400, and 0 with a
    /// start or a load.
    pub discard: Option<u32>,
    /// The start, before the discarded periods; by default the moving block (v2 = 1).
    pub start: Option<StartRule>,
    /// Rows of the table per drive period.
    pub samples: u32,
    /// Loads from records; time 0 is the beginning of the run. Constant loads are parameters.
    pub loads: Vec<Load>,
}

impl RunRequest {
    fn duration(&self, p: &Parameters) -> Result<f64> {
        let last = self.loads.iter().map(|load| load.span().1).reduce(f64::max);
        let duration = match (self.length, last) {
            (RunLength::Seconds(s), _) => s,
            (RunLength::Default, Some(last)) => last,
            (RunLength::Periods(n), _) => n * p.period(),
            (RunLength::Default, None) => f64::from(PERIODS) * p.period(),
        };
        if duration > 0.0 && duration.is_finite() {
            return Ok(duration);
        }
        Err(Error::Refused {
            what: format!("a run of {duration} s"),
            problem: "expected a finite time > 0".into(),
        })
    }

    fn discarded(&self) -> u32 {
        let given = self.start.is_some() || !self.loads.is_empty();
        self.discard.unwrap_or(if given { 0 } else { DISCARD })
    }

    /// State at the start of the discarded periods or of the run, and its description.
    fn first_state(&self, p: &Parameters) -> Result<(State, String)> {
        match self.start.unwrap_or_default() {
            StartRule::State(start) => {
                let units = if start.iter().any(|c| matches!(c, Coordinate::Si(_))) {
                    "names with a point in m and m/s, others in units of L and L ω10"
                } else {
                    "units of L and L ω10"
                };
                Ok((state(p, &start), format!("{} ({units}), the rest 0", StartRule::State(start))))
            }
            StartRule::Orbit => match SteadyMotion::exact(p)? {
                Some(SteadyMotion::Exact(orbit)) if orbit.is_stable() => {
                    Ok((orbit.state(p.drive_phase), "the stable exact orbit".into()))
                }
                _ => {
                    Ok((moving_block(p), "v2=1 (units of L ω10), since no exact orbit is stable here".into()))
                }
            },
        }
    }
}

/// Runs the machine of a parameter set.
///
/// # Errors
/// The errors of the simulator; an error if the run is too long for its samples.
pub fn run(set: &ParameterSet, request: &RunRequest) -> Result<Study> {
    let p = set.parameters();
    let duration = request.duration(p)?;
    let grid = history::grid(p, duration, request.samples, LEAST, MOST)?;
    let (first, start) = request.first_state(p)?;
    let discarded = request.discarded();
    let state = settled_simulator(p, &first, f64::from(discarded))?.state();
    // After whole drive periods the phase equals the phase at time 0.
    let mut simulator = Simulator::new(p, &state, 0.0)?;
    let history = history::record(&mut simulator, &request.loads, duration, grid)?;
    let mut remarks = account(p, &history);
    if request.loads.is_empty() {
        remarks.push(class(&mut simulator)?);
    }
    remarks.push(beginning(&start, discarded, &request.loads));
    let figure = picture::figure(set, &history, &request.loads, remarks.last().cloned().unwrap_or_default());
    let tables =
        vec![("run".into(), motion_table(&history)?), ("run-impacts".into(), impact_table(&history).csv()?)];
    let nothing = if figure.is_some() { "" } else { "; no picture, because nothing changes" };
    let (seconds, periods) = (short(duration), short(duration / p.period()));
    let what = format!("a motion over {seconds} s ({periods} drive periods){nothing}");
    Ok(Study { tables, figure, ..Study::without_figure("run", what).with_remarks(remarks) })
}

/// A number with six digits, for sentences.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = 5 - value.abs().max(1e-300).log10().floor().clamp(-3.0, 5.0) as i32;
        let text = format!("{value:.*}", digits.max(0) as usize);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{value:.5e}")
    }
}

/// Description of how the run begins.
fn beginning(start: &str, discarded: u32, loads: &[Load]) -> String {
    let mut words = format!("started with {start}; {discarded} drive periods discarded before time 0");
    for load in loads {
        let (from, to) = load.span();
        words.push_str(&format!("; load on {} from {} to {} s", load.body().name(), short(from), short(to)));
    }
    words
}

/// Amplitudes, impacts and energies, line by line.
fn account(p: &Parameters, history: &History) -> Vec<String> {
    let gap = p.stop_gap;
    let mut lines = Vec::new();
    for (i, name) in NAMES.iter().enumerate() {
        let Extent { amplitude, rms } = history.extent(i);
        let gaps = (short(amplitude / gap), short(rms / gap));
        let (amplitude, rms) = (short(amplitude), short(rms));
        lines.push(format!(
            "{name}: largest |{name}| {amplitude} m ({} L), rms {rms} m ({} L)",
            gaps.0, gaps.1
        ));
    }
    let periods = history.duration / p.period();
    let [upper, lower] = history.impacts_by_side().map(|n| n as f64 / periods);
    lines.push(format!(
        "impacts: {} in all; {} a drive period at the upper stop, {} at the lower; the block came to rest {} times",
        history.impacts.len(),
        short(upper),
        short(lower),
        history.rests
    ));
    if !history.impacts.is_empty() {
        let most = |of: fn(&RunImpact) -> f64| history.impacts.iter().map(of).fold(0.0, f64::max);
        let (speed, impulse) = (short(most(|i| i.speed)), short(most(|i| i.impulse)));
        lines.push(format!("largest impact speed {speed} m/s, largest impulse {impulse} N·s"));
    }
    let e = &history.energy;
    lines.push(format!(
        "energy: input {} J, damped {} J, lost at impacts {} J, mechanical from {} to {} J; \
         balance off by {:.1e} J",
        short(e.input),
        short(e.damped),
        short(e.impact),
        short(history.initial_energy),
        short(e.mechanical),
        history.balance_error()
    ));
    lines
}

/// The class of the motion after the run, observed from the next whole drive period.
fn class(simulator: &mut Simulator) -> Result<String> {
    let parameters = *simulator.parameters();
    let period = parameters.period();
    let mut ahead = simulator.clone().without_energy_accounts();
    ahead.advance_to(((simulator.time() / period - 1e-9).ceil() * period).max(simulator.time()))?;
    let found = verdict(&trajectories::Start { parameters, state: ahead.state() }, 0)?;
    let (class, attractor) = (found.class, &found.attractor);
    let mut words = format!("class: {}, from the motion after the run", class.name());
    // The symmetry of a settling motion is undecided.
    if matches!(class, MotionClass::Periodic(_)) {
        words.push_str(if attractor.is_symmetric() { "; its own mirror image" } else { "; not symmetric" });
    }
    if class == MotionClass::NotSettled {
        words.push_str(&format!(" over {PROLONGED} drive periods or more"));
    }
    if let Some(exponent) = found.exponent {
        let [value, error] = [exponent.value, exponent.error].map(|rate| rate / parameters.box_frequency());
        words.push_str(&format!("; largest exponent {:.4} ± {error:.4} per unit of τ", value.max(0.0)));
    }
    Ok(words)
}

fn motion_table(history: &History) -> Result<Vec<u8>> {
    let mut csv = CsvRows::new(["time", "x1", "x2", "x3", "w", "v1", "v2", "v3", "dw", "contact"])?;
    for i in history.instants().filter(|i| i.row) {
        let contact = match i.contact {
            Contact::Flight => "flight",
            Contact::RestUpper => "upper",
            Contact::RestLower => "lower",
        };
        let [x1, x2, x3, w] = i.x.map(exact);
        let [v1, v2, v3, dw] = i.v.map(exact);
        csv.push([&exact(i.time), &x1, &x2, &x3, &w, &v1, &v2, &v3, &dw, contact])?;
    }
    csv.text()
}

fn impact_table(history: &History) -> TextTable {
    let mut table = TextTable::new(&["time", "side", "speed", "impulse"]);
    for i in &history.impacts {
        let side = if i.side > 0 { "upper" } else { "lower" };
        table.rows.push(vec![exact(i.time), side.into(), exact(i.speed), exact(i.impulse)]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use vibro_impact::load::{Body, Interpolation};
    use vibro_impact::steady::exact_orbit;

    /// Tolerance for the interpolation between the steps of a run, in gaps.
    const INTERPOLATION: f64 = 1e-7;

    fn recorded(p: &Parameters, start: &State, loads: &[Load], duration: f64) -> History {
        let mut simulator = Simulator::new(p, start, 0.0).unwrap();
        let grid = history::grid(p, duration, 100, LEAST, MOST).unwrap();
        history::record(&mut simulator, loads, duration, grid).unwrap()
    }

    #[test]
    fn second_method_amplitudes_impacts_and_energy_of_the_exact_orbit() {
        let p = Parameters::default();
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let found = recorded(&p, &orbit.state(p.drive_phase), &[], 10.0 * p.period());
        for (i, q) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]].iter().enumerate()
        {
            assert!((found.extent(i).amplitude - orbit.amplitude_of(*q)).abs() < INTERPOLATION, "{i}");
            // Reference: a plain sum over many phases.
            let count = 20_000;
            let square: f64 = (0..count)
                .map(|k| {
                    let x = orbit.state(TAU * f64::from(k) / f64::from(count)).x;
                    (q[0] * x[0] + q[1] * x[1] + q[2] * x[2]).powi(2)
                })
                .sum();
            let rms = (square / f64::from(count)).sqrt();
            assert!((found.extent(i).rms - rms).abs() < 1e-6, "{i}: {} {rms}", found.extent(i).rms);
        }
        assert_eq!(found.impacts_by_side(), [10, 10]);
        assert!(found.balance_error().abs() < 1e-12, "{}", found.balance_error());
        assert_eq!(found.instants().filter(|i| i.row).count(), 1001);
    }

    #[test]
    fn closed_form_of_a_free_box_under_a_constant_load() {
        // x1 = f t²/2m up to the end of the record: the largest x is at the end, rms x(T)/√5. The
        // gap is too wide for impacts.
        let p = Parameters {
            box_stiffness: 0.0,
            box_damping: 0.0,
            drive_amplitude: 0.0,
            stop_gap: 1e4,
            ..Parameters::default()
        };
        let load = Load::new(Body::Box, &[(0.0, 2.0), (30.0, 2.0)], Interpolation::Linear).unwrap();
        let found = recorded(&p, &State::default(), &[load], 30.0);
        let end = 2.0 * 450.0 / p.box_mass;
        assert!((found.extent(0).amplitude / end - 1.0).abs() < 1e-12);
        assert!((found.extent(0).rms / end * 5f64.sqrt() - 1.0).abs() < INTERPOLATION);
        assert!((found.energy.input / (2.0 * end) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn numbers_in_words() {
        let words: Vec<String> = [0.0, 1.5, -0.012_345_678, 123_456.7, 1e-9, 20.0].map(short).into();
        assert_eq!(words, ["0", "1.5", "-0.0123457", "123457", "1.00000e-9", "20"]);
    }
}
