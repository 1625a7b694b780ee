//! Request of a design search: goal, limits, and ranges of the varied parameters.

use crate::candidate::{Candidate, Signed, TOLERANCE};
use std::fmt;
use vibro_machine::Start;
use vibro_numerics::quantities::quantity_in;
use vibro_studies::design_sweep::{DesignMachine, Designs, ParameterInterval, SampledAxis, SweepRequest};
use vibro_studies::sobol::DIMENSIONS;
use vibro_studies::{Error, Machine, Measure, Result, Section};

/// Smallest and largest number of evaluations: fewer are less than a generation, more take days.
const EVALUATIONS: std::ops::RangeInclusive<u32> = 10..=1_000_000;
/// Largest relative tolerance of [`DesignRequest::robust`]; a parameter must keep its sign.
const MAX_TOLERANCE: f64 = 0.5;

/// A measure to minimise or maximise.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// The measure.
    pub measure: Measure,
    /// Whether large values are wanted.
    pub maximize: bool,
}

/// Permitted side of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Up to the limit.
    AtMost,
    /// From the limit upwards.
    AtLeast,
}

/// A measure with a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The measure.
    pub measure: Measure,
    /// The permitted side.
    pub side: Side,
    /// The limit, in the measure's SI unit.
    pub value: f64,
}

impl Limit {
    /// Reads `OUTPUT<=VALUE` or `OUTPUT>=VALUE`; the value is in SI or has a unit.
    ///
    /// # Errors
    /// [`Error::Form`] for another form, and if the value is not a number in the output's unit;
    /// [`Error::Described`] for an output that the machine does not have.
    ///
    /// # Examples
    /// ```
    /// use vibro_design::{Limit, Side};
    /// use vibro_studies::Machine;
    ///
    /// # let text = r#"
    /// #     name = "Lid"
    /// #     body.block = { mass = "350 g" }
    /// #     stop.lid = { between = ["ground", "block"], gap = "4 mm", restitution = 0.7 }
    /// # "#;
    /// let machine = Machine::parse(text, "lid.toml", &vibro_machine::file::no_records)?;
    /// let limit = Limit::read("impact.speed.lid <= 50 cm/s", &machine)?;
    /// assert_eq!((limit.side, limit.value), (Side::AtMost, 0.5));
    /// assert_eq!(limit.to_string(), "impact.speed.lid<=0.5");
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn read(text: &str, machine: &Machine) -> Result<Self> {
        let form = |expected| Error::Form { text: text.into(), expected };
        let of = |sign: &str, side| text.split_once(sign).map(|(output, value)| (output, side, value));
        let signs = [("<=", Side::AtMost), (">=", Side::AtLeast), ("≤", Side::AtMost), ("≥", Side::AtLeast)];
        let found = signs.into_iter().find_map(|(sign, side)| of(sign, side));
        let (output, side, value) =
            found.ok_or_else(|| form("OUTPUT<=VALUE or OUTPUT>=VALUE, e.g. impact.speed.steel<=0.5 m/s"))?;
        let measure: Measure = output.parse()?;
        measure.check(&machine.description)?;
        let unit = measure.unit(&machine.description);
        let value = quantity_in(unit, value.trim()).map(|own| own.value).filter(|x| x.is_finite());
        let value =
            value.ok_or_else(|| form("a number after the sign, in SI or with a unit of the output"))?;
        Ok(Self { measure, side, value })
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.side {
            Side::AtMost => "<=",
            Side::AtLeast => ">=",
        };
        write!(f, "{}{sign}{}", self.measure, self.value)
    }
}

/// Request of a design search.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignRequest {
    /// The machine; its own values are evaluated first if they lie in the ranges.
    pub machine: Machine,
    /// The goal to optimise.
    pub goal: Goal,
    /// Varied parameters, with their ranges, SI.
    pub vary: Vec<ParameterInterval<String>>,
    /// Parameters over which a design is judged by its worst value.
    pub over: Vec<SampledAxis<String>>,
    /// Parameters of [`over`](Self::over) whose values sample an interval.
    pub between: Vec<String>,
    /// Limits that the worst motion must meet.
    pub limits: Vec<Limit>,
    /// Relative tolerance of the varied parameters; the worst value within it counts. 0 for none.
    pub robust: f64,
    /// Starts of the motions of each design.
    pub starts: Vec<Start>,
    /// Returns discarded before a motion is measured.
    pub discard: u32,
    /// Returns over which a motion is measured.
    pub periods: u32,
    /// Largest number of evaluated designs.
    pub evaluations: u32,
    /// Largest number of periods for longer measurements of possible best designs.
    pub again: u64,
}

impl DesignRequest {
    /// A request without limits, band and tolerances; otherwise with the defaults of a sweep.
    pub fn new(machine: Machine, goal: Goal, vary: Vec<ParameterInterval<String>>) -> Self {
        let defaults = SweepRequest::<Candidate>::default();
        Self {
            machine,
            goal,
            vary,
            over: Vec::new(),
            between: Vec::new(),
            limits: Vec::new(),
            robust: 0.0,
            starts: defaults.starts,
            discard: defaults.discard,
            periods: defaults.periods,
            evaluations: 200,
            again: defaults.again,
        }
    }

    /// Names of the varied parameters.
    pub fn names(&self) -> Vec<String> {
        self.vary.iter().map(|interval| interval.name.clone()).collect()
    }

    /// The goal and the limits as measures to minimise: the largest value is the worst.
    pub(crate) fn measures(&self) -> Vec<Signed> {
        let goal = Signed { measure: self.goal.measure.clone(), is_negative: self.goal.maximize };
        let limit =
            |own: &Limit| Signed { measure: own.measure.clone(), is_negative: own.side == Side::AtLeast };
        std::iter::once(goal).chain(self.limits.iter().map(limit)).collect()
    }

    /// The sweep that measures designs, with an empty list of designs.
    pub(crate) fn sweep(&self, candidate: &Candidate) -> SweepRequest<Candidate> {
        let mut over = self.over.clone();
        if candidate.tolerances() > 1 {
            let values = (0..candidate.tolerances()).map(|k| k as f64).collect();
            over.push(SampledAxis { name: TOLERANCE.into(), values });
        }
        SweepRequest {
            designs: Designs::Rows { names: self.names(), rows: Vec::new() },
            over,
            starts: self.starts.clone(),
            discard: self.discard,
            periods: self.periods,
            measures: self.measures(),
            between: self.between.clone(),
            again: self.again,
        }
    }

    /// Checks everything that each evaluation requires.
    ///
    /// # Errors
    /// [`Error::Described`] with the number or name, and what is expected; otherwise as
    /// [`SweepRequest::check`] and [`Section::of`].
    pub fn check(&self) -> Result<()> {
        let refused = |problem: String| Err(Error::Described { problem });
        if !(1..=DIMENSIONS).contains(&self.vary.len()) {
            return refused(format!(
                "{} parameters are varied; expected 1 to {DIMENSIONS}: keep the most important ones",
                self.vary.len()
            ));
        }
        for ParameterInterval { name, from, to } in &self.vary {
            self.machine.description.parameter(name)?;
            if !(from < to && (to - from).is_finite()) {
                return refused(format!(
                    "{name} = {from}:{to}: expected a range LOW:HIGH with LOW below HIGH"
                ));
            }
            if name.contains(".start.") {
                return refused(format!(
                    "{name}: start values cannot be varied; expected a parameter of the machine, and start values by `--start` \
                     (`start=` in Python)"
                ));
            }
        }
        if !Machine::is_of_window(&self.goal.measure) {
            return refused(format!(
                "{}: cannot be the goal, because it has no error bar; expected an output such as amplitude.box.s",
                self.goal.measure
            ));
        }
        for measure in self.measures() {
            measure.measure.check(&self.machine.description)?;
        }
        for limit in &self.limits {
            if limit.measure == Measure::Class || !limit.value.is_finite() {
                return refused(format!(
                    "{} cannot be limited by {}; expected an output that is a number, and a finite limit",
                    limit.measure, limit.value
                ));
            }
        }
        if !(0.0..=MAX_TOLERANCE).contains(&self.robust) {
            let percent = 100.0 * self.robust;
            return refused(format!(
                "robust = {percent} %: expected a tolerance of 0 % to {} %",
                100.0 * MAX_TOLERANCE
            ));
        }
        if !EVALUATIONS.contains(&self.evaluations) {
            let (least, most) = (EVALUATIONS.start(), EVALUATIONS.end());
            return refused(format!("evaluations = {}: expected {least} to {most}", self.evaluations));
        }
        let mut sweep = self.sweep(&Candidate::new(&self.machine, self.names(), self.robust));
        let middle = self.vary.iter().map(|own| 0.5 * (own.from + own.to)).collect();
        sweep.designs = Designs::Rows { names: self.names(), rows: vec![middle] };
        sweep.check()?;
        Section::of(&self.machine.description, &self.machine.section).map(drop)
    }
}
