//! A machine for a sweep: signed measures, whose largest value is the worst, and tolerances of the
//! varied parameters as an axis.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;
use vibro_machine::Start;
use vibro_studies::design_sweep::{DesignMachine, Designs, MotionMeasures, SweepRequest};
use vibro_studies::sobol::{DIMENSIONS, coordinate};
use vibro_studies::{Machine, Measure, Result, significant};

/// Name of the axis of tolerances. Its values are indices of [`Candidate::tolerances`].
pub const TOLERANCE: &str = "tolerance";
/// Largest number of parameters for measuring all corners of the tolerances.
const ALL_CORNERS: usize = 4;
/// Cap on the measured corners if more parameters vary.
const SOME_CORNERS: u32 = 16;

/// A measure whose largest value is the worst: the measure itself, or its negative if large values
/// are good.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Signed {
    /// The measure.
    pub measure: Measure,
    /// Whether large values are good.
    pub is_negative: bool,
}

impl Signed {
    /// Factor from the measure to the compared value.
    pub fn sign(&self) -> f64 {
        if self.is_negative { -1.0 } else { 1.0 }
    }
}

impl fmt::Display for Signed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.measure.fmt(f)
    }
}

/// Request for measures of a machine's motions; `returns` are the numbers discarded and kept.
pub(crate) fn of_machine(
    starts: Vec<Start>,
    returns: (u32, u32),
    measures: Vec<Measure>,
) -> SweepRequest<Machine> {
    let (discard, periods) = returns;
    let designs = Designs::Grid(Vec::new());
    SweepRequest { designs, starts, discard, periods, measures, ..SweepRequest::default() }
}

/// A machine with the tolerances of the varied parameters.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The machine.
    pub machine: Machine,
    /// Names of the varied parameters.
    names: Arc<[String]>,
    /// Relative deviations of these parameters; [`Self::new`] begins with zero deviations.
    tolerances: Arc<[Vec<f64>]>,
}

/// Signs of the corners of a box: all corners for up to [`ALL_CORNERS`] parameters, otherwise the
/// corners nearest to points of the Sobol sequence.
fn corners(count: usize) -> Vec<Vec<f64>> {
    let sign = |is_up: bool| if is_up { 1.0 } else { -1.0 };
    if count <= ALL_CORNERS {
        return (0..1usize << count).map(|k| (0..count).map(|i| sign(k >> i & 1 == 1)).collect()).collect();
    }
    let corner = |k: u32| (0..count).map(|i| sign(coordinate(k, i % DIMENSIONS) >= 0.5)).collect();
    let mut all: Vec<Vec<f64>> = (1..=SOME_CORNERS).map(corner).collect();
    all.dedup();
    all
}

impl Candidate {
    /// A candidate whose tolerances are zero and, if `half` is positive, the corners of a box
    /// around the parameters with the relative half width `half`.
    pub fn new(machine: &Machine, names: Vec<String>, half: f64) -> Self {
        let mut tolerances = vec![vec![0.0; names.len()]];
        if half > 0.0 {
            let scaled = |corner: Vec<f64>| corner.into_iter().map(|sign| half * sign).collect();
            tolerances.extend(corners(names.len()).into_iter().map(scaled));
        }
        Self { machine: machine.clone(), names: names.into(), tolerances: tolerances.into() }
    }

    /// The same candidate with `count` points of the Sobol sequence inside its tolerances.
    pub fn inside(&self, half: f64, count: u32) -> Self {
        let point = |k: u32| {
            (0..self.names.len()).map(|i| half * (2.0 * coordinate(k, i % DIMENSIONS) - 1.0)).collect()
        };
        Self { tolerances: (1..=count).map(point).collect(), ..self.clone() }
    }

    /// Number of points on the axis of tolerances.
    pub fn tolerances(&self) -> usize {
        self.tolerances.len()
    }

    /// Factors of the varied parameters at an index of the axis of tolerances.
    pub fn factors(&self, index: f64) -> Vec<f64> {
        let deviations = self.tolerances.get(index as usize);
        (0..self.names.len()).map(|i| 1.0 + deviations.map_or(0.0, |own| own[i])).collect()
    }
}

impl DesignMachine for Candidate {
    type Name = String;
    type Start = Start;
    type Measure = Signed;
    const PART: usize = Machine::PART;
    const AGAIN: u64 = Machine::AGAIN;

    fn name(name: &String) -> String {
        name.clone()
    }

    fn is_same_quantity(a: &String, b: &String) -> bool {
        a == b
    }

    fn with_unit(&self, name: &String, value: f64) -> String {
        if name != TOLERANCE {
            return self.machine.told(name, value);
        }
        let factors = self.factors(value);
        let told = |(name, factor): (&String, &f64)| {
            let part = 100.0 * (factor - 1.0);
            format!("{name} {}{} %", if part > 0.0 { "+" } else { "" }, significant(part))
        };
        self.names.iter().zip(&factors).map(told).collect::<Vec<_>>().join(", ")
    }

    fn varied(&self, values: &[(String, f64)]) -> Result<Self> {
        let named = values.iter().filter(|(name, _)| name != TOLERANCE);
        let mut machine = self.machine.with(named.map(|(name, value)| (name.as_str(), *value)))?;
        if let Some((_, index)) = values.iter().find(|(name, _)| name == TOLERANCE) {
            let mut moved = Vec::with_capacity(self.names.len());
            for (name, factor) in self.names.iter().zip(self.factors(*index)) {
                moved.push((name.as_str(), machine.description.get(name)? * factor));
            }
            machine = machine.with(moved)?;
        }
        Ok(Self { machine, ..self.clone() })
    }

    fn outcomes(&self, request: &SweepRequest<Self>) -> Vec<MotionMeasures> {
        let measures = request.measures.iter().map(|own| own.measure.clone()).collect();
        let own = of_machine(request.starts.clone(), (request.discard, request.periods), measures);
        let mut found = self.machine.outcomes(&own);
        for (measured, _) in &mut found {
            for (number, measure) in measured.numbers.iter_mut().zip(&request.measures) {
                *number = number.map(|x| measure.sign() * x);
            }
        }
        found
    }

    fn spread_starts(_: u32) -> Vec<Start> {
        Vec::new()
    }

    fn is_of_window(measure: &Signed) -> bool {
        Machine::is_of_window(&measure.measure)
    }

    fn resonances(&self, name: &String) -> Vec<f64> {
        self.machine.resonances(name)
    }
}
