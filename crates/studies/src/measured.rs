//! Measures of a motion with their spreads, and whether the motion had settled.

use crate::class::MotionClass;
use serde::{Deserialize, Serialize};

/// Measures of one motion.
///
/// An oscillator with k - mω² = -12 N/m and cω = 5 N/m follows a force of 26 N with the amplitude
/// 26/13 m, and its dashpot loses ½ c ω² 2²:
///
/// ```
/// use vibro_studies::{Machine, Measure, Start, measure, settle};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "4 rad/s" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let measures: Vec<Measure> = vec!["amplitude.a.s".parse()?, "power.k".parse()?];
/// let (mut motion, section) = machine.motion(&Start::default())?;
/// settle(&mut motion, &section, 100)?;
/// let found = measure(&mut motion, &section, &measures, 20)?;
/// let [amplitude, power] = [0, 1].map(|k| found.numbers[k].unwrap());
/// // The motion counts as settled when its returns differ by less than 1e-9.
/// assert!((amplitude - 2.0).abs() < 1e-8 && (power - 40.0).abs() < 4e-7);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Value of each measure, in order and in the measure's unit. `None` for the class, for an
    /// undecided exponent, for a closed form that has no value, and if the motion was not
    /// measured.
    pub numbers: Vec<Option<f64>>,
    /// Spread of each value: the standard deviation that it would have between windows of this
    /// length, docs/theory.md (N3) and (N4). It is computed from six parts of this window. If the
    /// motion repeats, each part is a whole number of its periods, and the spread is only
    /// rounding. An exponent has its standard error or, for the paper's machine, the standard
    /// deviation of the running exponents. Exact values have 0.
    pub spreads: Vec<f64>,
    /// Class, if it was requested.
    pub class: Option<MotionClass>,
    /// Index of the first measure whose value drifts from part to part: the motion has not
    /// settled. Equal to the number of measures if no measure drifts, but another quantity does.
    pub unsettled: Option<usize>,
}

/// Spread of a value between windows, computed from its values in the parts of one window.
/// The extreme of a long window scatters like the extreme of a part, since the scale of the limit
/// law of extremes does not depend on the number of parts, docs/theory.md (N3). A mean scatters
/// less by the root of the number of parts, (N4). A value that is monotone from part to part is
/// still drifting, (N5).
pub(crate) fn spread_of(numbers: &[f64], is_extreme: bool) -> f64 {
    if numbers.len() < 2 {
        return 0.0;
    }
    let way = drift(numbers).unwrap_or(0.0);
    if is_extreme {
        return deviation(numbers).max(way);
    }
    // Neighbouring parts are not independent. Pairs of parts are less dependent.
    let pairs: Vec<f64> = numbers.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let error = |of: &[f64]| deviation(of) / (of.len() as f64).sqrt();
    let scatter = if pairs.len() < 2 { error(numbers) } else { error(numbers).max(error(&pairs)) };
    scatter.max(way)
}

/// Number of parts needed to show a drift.
const DRIFT_PARTS: usize = 5;

/// Largest ratio of successive steps of a drift.
const STEP_GROWTH: f64 = 1.01;

/// Cap on the ratio of successive steps for which the rest of a drift is extrapolated.
const SLOWEST_DECAY: f64 = 0.9;

/// Tolerance for a drift, relative to the value; a smaller drift is ignored.
const NEGLIGIBLE: f64 = 1e-3;

/// Drift of a value that is monotone over the parts with steps that do not grow: the change so far
/// plus the remaining change, extrapolated from the ratio of the last two steps. `None` for other
/// values. About two in 100,000 sets of six independent normal values look like a drift.
fn drift(numbers: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let [.., before, last] = steps[..] else { return None };
    let is_way = steps.iter().all(|step| step * last > 0.0)
        && steps.windows(2).all(|pair| pair[1].abs() <= STEP_GROWTH * pair[0].abs());
    let ratio = (last / before).min(SLOWEST_DECAY);
    let way = (numbers[numbers.len() - 1] - numbers[0]).abs() + last.abs() * ratio / (1.0 - ratio);
    (numbers.len() >= DRIFT_PARTS && is_way).then_some(way)
}

/// Whether a value, known in parts, has not settled to three digits.
pub(crate) fn is_drifting(numbers: &[f64]) -> bool {
    let size = numbers.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    drift(numbers).is_some_and(|way| way > NEGLIGIBLE * size)
}

/// Caveat about a motion that was measured before it had settled.
pub(crate) fn unsettled_in_words(found: &Measured, measures: &[impl std::fmt::Display]) -> Option<String> {
    let name = measures.get(found.unsettled?).map_or("the motion".into(), ToString::to_string);
    Some(format!("not settled: {name} drifts while it is measured; discard more periods (--discard)"))
}

/// Standard deviation of at least two numbers.
fn deviation(numbers: &[f64]) -> f64 {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let scatter = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (scatter / (count - 1.0)).sqrt()
}
