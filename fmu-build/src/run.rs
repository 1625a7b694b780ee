//! Runs the binaries from their archives and the native library, and compares the results bit for
//! bit.

use crate::archive;
use crate::compile::SHARED_LIBRARY;
use crate::error::{Error, Result};
use crate::host;
use crate::version::{MODEL_DESCRIPTION, Version};
use crate::xml::Element;
use std::path::Path;
use std::time::{Duration, Instant};
use vibro_impact::simulator::{DueEvent, Pause};
use vibro_impact::{Parameters, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;
use vibro_paper_component::component::variables;
use vibro_paper_component::fmi3::description::{MAIN, MODEL_IDENTIFIER, value_reference};

/// Communication steps per drive period: enough for a smooth picture, and for amplitudes to eight
/// digits (`ComparedRun::amplitudes`).
pub const STEPS_PER_PERIOD: u32 = 200;

const NAMES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];
const COUNTS: [&str; 2] = ["impacts.upper", "impacts.lower"];

/// The motion at a communication point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// Displacements and velocities.
    pub state: State,
    /// Impacts at the upper and the lower stop so far.
    pub impacts: [i32; 2],
}

/// The motion on both sides of an impact, which is between communication points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactSample {
    /// Time, s.
    pub time: f64,
    /// State just before.
    pub before: State,
    /// State just after.
    pub after: State,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct ComparedRun {
    /// Parameters of the run, from the FMU's start values.
    pub parameters: Parameters,
    /// Drive periods.
    pub periods: u32,
    /// The motion at every communication point, including the start.
    pub samples: Vec<Sample>,
    /// Every impact, from a native run that pauses before each.
    pub impacts: Vec<ImpactSample>,
    /// Wall time of all steps together, of FMI 2.0 and 3.0.
    pub stepping: [Duration; 2],
    /// Wall time of the whole run of the FMU of FMI 2.0: instantiate, initialize, step, read.
    pub whole: Duration,
}

/// Runs the FMU of FMI 2.0 in `archive`, the FMU of FMI 3.0 next to it and the native library for
/// `periods` drive periods from the start values, and compares the three.
///
/// # Errors
/// [`Error::Differs`] if they are not equal bit for bit; [`Error::Binaries`] if the archives hold
/// different libraries; the errors of loading and calling.
pub fn run(archive: &Path, periods: u32) -> Result<ComparedRun> {
    let folder = tempfile::tempdir().map_err(Error::file("making a folder in", &std::env::temp_dir()))?;
    let beside = Version::Fmi3.beside(archive);
    let library = archive::read(archive, &Version::Fmi2.own_binary())?;
    if archive::read(&beside, &Version::Fmi3.own_binary())? != library {
        return Err(Error::Binaries { first: archive.to_owned(), second: beside });
    }
    let file = folder.path().join(format!("{MODEL_IDENTIFIER}{SHARED_LIBRARY}"));
    archive::write_file(&file, &library)?;
    let token = |archive: &Path, name| -> Result<String> {
        let text = archive::read(archive, MODEL_DESCRIPTION)?;
        let root = Element::parse(&String::from_utf8_lossy(&text))?;
        Ok(root.attribute(name).unwrap_or_default().to_owned())
    };
    let (guid, token) = (token(archive, "guid")?, token(&beside, "instantiationToken")?);

    let parameters = Parameters::default();
    let step = parameters.period() / f64::from(STEPS_PER_PERIOD);
    let steps = periods * STEPS_PER_PERIOD;
    let mut native = Simulator::new(&parameters, &State::default(), 0.0)?;

    let begin = Instant::now();
    let binary = host::Binary::load(&file)?;
    let mut instance = binary.instantiate(&guid)?;
    instance.initialize(0.0)?;
    let mut whole = begin.elapsed();
    let binary3 = host::fmi3::Binary::load(&file)?;
    let mut instance3 = binary3.instantiate(&token)?;
    instance3.initialize(0.0)?;
    let (reals, counts) = (references(NAMES)?, references(COUNTS)?);
    let (reals3, counts3) = (references3(NAMES)?, references3(COUNTS)?);
    let mut stepping = [Duration::ZERO; 2];
    let mut samples = vec![Sample { time: 0.0, state: State::default(), impacts: [0; 2] }];
    for i in 0..steps {
        let from = f64::from(i) * step;
        let begin = Instant::now();
        instance.step(from, step)?;
        stepping[0] += begin.elapsed();
        let (values, impacts) = (instance.real(&reals)?, instance.integer(&counts)?);
        whole += begin.elapsed();
        let begin = Instant::now();
        instance3.step(from, step)?;
        stepping[1] += begin.elapsed();

        native.advance_until(DoubleDouble::sum(from, step), Pause::Never, None)?;
        let sample = Sample { time: native.time(), state: native.state(), impacts };
        same_sample(Version::Fmi2, &native, values, impacts)?;
        same_sample(Version::Fmi3, &native, instance3.real(&reals3)?, instance3.integer(&counts3)?)?;
        samples.push(sample);
    }
    instance.terminate()?;
    instance3.terminate()?;
    let impacts = impacts(&parameters, native.time())?;
    Ok(ComparedRun { parameters, periods, samples, impacts, stepping, whole })
}

/// Checks that the outputs of a packaged binary equal the native run's, bit for bit.
fn same_sample(version: Version, native: &Simulator, values: [f64; 6], impacts: [i32; 2]) -> Result<()> {
    let (State { x, v }, record, time) = (native.state(), native.impacts(), native.time());
    for ((name, packaged), native) in NAMES.into_iter().zip(values).zip([x, v].concat()) {
        same(version, name, time, packaged, native)?;
    }
    for ((name, packaged), native) in COUNTS.into_iter().zip(impacts).zip([record.upper, record.lower]) {
        same(version, name, time, f64::from(packaged), native as f64)?;
    }
    Ok(())
}

/// The motion at every impact up to `end`, from a native run that pauses before each event.
fn impacts(parameters: &Parameters, end: f64) -> Result<Vec<ImpactSample>> {
    let mut simulator = Simulator::new(parameters, &State::default(), 0.0)?;
    let mut found = Vec::new();
    while simulator.time() < end {
        simulator.advance_until(end, Pause::BeforeEvent, None)?;
        let (time, before) = (simulator.time(), simulator.state());
        if let Some(DueEvent::Impact { .. }) = simulator.apply_due_event(None) {
            found.push(ImpactSample { time, before, after: simulator.state() });
        }
    }
    Ok(found)
}

/// Value references in the archive of FMI 2.0.
fn references<const N: usize>(names: [&'static str; N]) -> Result<[u32; N]> {
    numbered(names, |name| variables::find(name).map(|variable| variable.reference))
}

/// Value references in the main archive of FMI 3.0.
fn references3<const N: usize>(names: [&'static str; N]) -> Result<[u32; N]> {
    numbered(names, |name| value_reference(MAIN, name))
}

fn numbered<const N: usize>(
    names: [&'static str; N],
    number: impl Fn(&str) -> Option<u32>,
) -> Result<[u32; N]> {
    let mut references = [0; N];
    for (reference, name) in references.iter_mut().zip(names) {
        *reference = number(name).ok_or_else(|| Error::Variable(name.into()))?;
    }
    Ok(references)
}

fn same(version: Version, name: &'static str, time: f64, packaged: f64, native: f64) -> Result<()> {
    if packaged.to_bits() == native.to_bits() {
        return Ok(());
    }
    Err(Error::Differs { version: version.name(), name, time, packaged, native })
}

/// The extreme, between two times, of the cubic with the given values and slopes at these times;
/// `None` unless the slopes have opposite signs.
fn extreme_between((t0, x0, v0): (f64, f64, f64), (t1, x1, v1): (f64, f64, f64)) -> Option<f64> {
    if v0 * v1 >= 0.0 {
        return None;
    }
    let h = t1 - t0;
    let (a, b, rise) = (v0 * h, v1 * h, x1 - x0);
    // p(u) = x0 + a u + c u² + d u³; p'(u) = a + 2 c u + 3 d u² changes its sign once.
    let (c, d) = (3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise);
    let root = (c * c - 3.0 * a * d).max(0.0).sqrt();
    // The root of p' at which the slope changes from the sign of a to the opposite one, in the
    // form without cancellation for small d.
    let u = a / (root.copysign(a) - c);
    (0.0..=1.0).contains(&u).then_some(x0 + u * (a + u * (c + u * d)))
}

impl ComparedRun {
    /// Samples of the last `periods` drive periods. For the default set, the transient has decayed
    /// by then.
    pub fn tail(&self, periods: u32) -> &[Sample] {
        let count = (periods.min(self.periods) * STEPS_PER_PERIOD) as usize;
        &self.samples[self.samples.len() - 1 - count..]
    }

    /// The path of the motion between two times, in s, cut at its impacts; each piece holds (time,
    /// state).
    pub fn path(&self, from: f64, to: f64) -> Vec<Vec<(f64, State)>> {
        let mut impacts = self.impacts.iter().filter(|c| (from..=to).contains(&c.time)).peekable();
        let mut pieces = Vec::new();
        let mut piece = Vec::new();
        for sample in self.samples.iter().filter(|s| (from..=to).contains(&s.time)) {
            while let Some(impact) = impacts.next_if(|c| c.time <= sample.time) {
                piece.push((impact.time, impact.before));
                pieces.push(std::mem::take(&mut piece));
                piece.push((impact.time, impact.after));
            }
            piece.push((sample.time, sample.state));
        }
        pieces.push(piece);
        pieces
    }

    /// Half the range of each displacement over the last periods, including impacts, m. Between
    /// two samples a displacement is approximated by the cubic with their values and velocities,
    /// and the range includes the cubic's extremes. The error is below 1e-8 of the amplitude with
    /// 200 samples per period.
    pub fn amplitudes(&self, periods: u32) -> [f64; 3] {
        let begin = self.tail(periods).first().map_or(0.0, |s| s.time);
        let pieces = self.path(begin, f64::INFINITY);
        std::array::from_fn(|body| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            let mut take = |x: f64| (low, high) = (low.min(x), high.max(x));
            for piece in &pieces {
                piece.iter().for_each(|(_, state)| take(state.x[body]));
                for pair in piece.windows(2) {
                    let end = |(time, state): (f64, State)| (time, state.x[body], state.v[body]);
                    extreme_between(end(pair[0]), end(pair[1])).into_iter().for_each(&mut take);
                }
            }
            (high - low) / 2.0
        })
    }

    /// Impacts per period at the upper and the lower stop over the last periods.
    pub fn impacts_per_period(&self, periods: u32) -> [f64; 2] {
        let tail = self.tail(periods);
        let count = f64::from(periods.min(self.periods));
        std::array::from_fn(|side| {
            let at = |sample: Option<&Sample>| sample.map_or(0, |s| s.impacts[side]);
            f64::from(at(tail.last()) - at(tail.first())) / count
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_is_a_difference() {
        let same = |packaged, native| same(Version::Fmi3, "box.s", 1.0, packaged, native);
        assert!(same(0.1, 0.1).is_ok());
        for (packaged, native) in [(0.1, 0.1_f64.next_up()), (0.0, -0.0)] {
            let error = same(packaged, native).unwrap_err();
            assert!(matches!(error, Error::Differs { name: "box.s", .. }), "{error}");
        }
    }

    #[test]
    fn closed_form_extremes_of_a_sine_between_samples() {
        // Tolerance. The cubic's error is h⁴/384 of the amplitude: 2.5e-9 with 200 samples per
        // period.
        const CUBIC: f64 = 3e-9;
        let h = std::f64::consts::TAU / f64::from(STEPS_PER_PERIOD);
        for shift in [0.0, 0.1, 0.5, 0.93] {
            let at = |k: f64| ((k + shift) * h, ((k + shift) * h).sin(), ((k + shift) * h).cos());
            let quarter = f64::from(STEPS_PER_PERIOD) / 4.0;
            let top: Vec<f64> = [-2.0, -1.0, 0.0]
                .into_iter()
                .filter_map(|k| extreme_between(at(quarter + k), at(quarter + k + 1.0)))
                .collect();
            let exact = at(quarter).1 == 1.0; // a sample at the maximum
            assert!(top.len() == 1 || exact, "{top:?}");
            assert!(top.iter().all(|x| (x - 1.0).abs() < CUBIC), "{top:?}");
        }
        assert_eq!(extreme_between((0.0, 0.0, 1.0), (1.0, 1.0, 1.0)), None);
    }

    #[test]
    fn path_is_cut_at_impacts() {
        let parameters = Parameters::default();
        let impacts = impacts(&parameters, 10.0 * parameters.period()).unwrap();
        assert!(impacts.len() > 5);
        for impact in &impacts {
            let (b, a) = (impact.before, impact.after);
            assert_eq!(b.x, a.x);
            let ratio = (a.v[1] - a.v[0]) / (b.v[1] - b.v[0]);
            // Round-off of the differences of velocities of about 1 m/s.
            assert!((ratio + parameters.stop_restitution).abs() < 1e-12, "{ratio}");
        }
        let sample = |time| Sample { time, state: State::default(), impacts: [0; 2] };
        let end = impacts[1].time + 1.0;
        let samples = vec![sample(0.0), sample(end)];
        let run = ComparedRun {
            parameters,
            periods: 1,
            samples,
            impacts: impacts[..2].to_vec(),
            stepping: [Duration::ZERO; 2],
            whole: Duration::ZERO,
        };
        let lengths: Vec<_> = run.path(0.0, end).iter().map(Vec::len).collect();
        assert_eq!(lengths, [2, 2, 2]);
    }
}
