//! The value of a design with its error bar, and all designs evaluated by a search.

use crate::candidate::{Candidate, Signed};
use crate::request::DesignRequest;
use std::cmp::Ordering;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};
use vibro_studies::Machine;
use vibro_studies::design_sweep::{BARS, DesignMachine, SearchedRow, Summary, SweepRequest, searched};

/// Stage of the search that requests an evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The machine's own values.
    Own,
    /// A point of the Sobol sequence.
    Sobol,
    /// Differential evolution over the whole ranges.
    Evolution,
    /// A local search by exact gradients of orbits.
    Gradient,
    /// Differential evolution in a smaller box around the best design.
    Nearby,
}

impl Stage {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Sobol => "sobol",
            Self::Evolution => "evolution",
            Self::Gradient => "gradient",
            Self::Nearby => "nearby",
        }
    }

    /// Name in progress messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Own => "the machine's own numbers",
            Self::Sobol => "sampling",
            Self::Evolution => "evolution",
            Self::Gradient => "gradients",
            Self::Nearby => "evolution around the best",
        }
    }
}

/// A measure's worst value over the motions of a design, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Ends of its error bar, the lower one first.
    pub bar: (f64, f64),
    /// Whether every motion repeats, so that the error bar is only rounding.
    pub is_exact: bool,
}

impl Value {
    pub(crate) fn of(summary: &Summary, signed: &Signed) -> Self {
        let upper = summary.largest + BARS * summary.spread;
        let ends = [summary.lower, upper].map(|x| signed.sign() * x);
        Self {
            value: signed.sign() * summary.largest,
            bar: (ends[0].min(ends[1]), ends[0].max(ends[1])),
            is_exact: summary.is_exact,
        }
    }

    /// Distance from the value to the farther end of its error bar.
    pub fn error(&self) -> f64 {
        (self.value - self.bar.0).max(self.bar.1 - self.value).max(0.0)
    }
}

/// Rank of a design: violation of limits, then signed goal. Designs without a value come last.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Score(pub f64, pub f64);

impl Score {
    /// Rank of a design without a value.
    pub const WORST: Self = Self(f64::INFINITY, f64::INFINITY);

    /// Order of two ranks, the better one first.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.total_cmp(&other.1))
    }

    /// Whether no limit is violated.
    pub fn is_feasible(self) -> bool {
        self.0 == 0.0
    }
}

/// A design that was evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The varied parameters, SI.
    pub values: Vec<f64>,
    /// The stage that requested it.
    pub stage: Stage,
    /// The goal; `None` if a motion has no value.
    pub goal: Option<Value>,
    /// The limited measures.
    pub limits: Vec<Option<Value>>,
    /// The motion with the worst goal, in words; empty if there is one motion or no value.
    pub place: String,
    /// Reason for missing values, or a caveat.
    pub reason: Option<String>,
    /// Rank.
    pub(crate) score: Score,
}

impl Evaluation {
    /// Whether all values are known and meet the limits.
    pub fn is_feasible(&self) -> bool {
        self.score.is_feasible()
    }

    /// The evaluation of a row of a sweep.
    pub(crate) fn of(
        request: &DesignRequest,
        (candidate, sweep): (&Candidate, &SweepRequest<Candidate>),
        (row, stage): (&vibro_studies::design_sweep::DesignRow, Stage),
    ) -> Self {
        let value = |k: usize| row.outputs[k].map(|summary| Value::of(&summary, &sweep.measures[k]));
        let limits: Vec<Option<Value>> = (1..sweep.measures.len()).map(value).collect();
        let place = row.outputs[0]
            .map_or(String::new(), |own| sweep.place_in_words(candidate, row.motion(sweep, own.at)));
        let mut found = Self {
            values: row.values.clone(),
            stage,
            goal: value(0),
            limits,
            place,
            reason: row.reason.clone(),
            score: Score::WORST,
        };
        found.score = found.scored(request, sweep);
        found
    }

    /// Replaces a measure's value by a peak within the band if the peak is worse, and shifts the
    /// error bar with it. `peak` has the sign for minimization: larger is worse. `start` is the index
    /// of its start.
    pub(crate) fn raise(
        &mut self,
        evaluator: &Evaluator,
        (measure, peak): (usize, f64),
        (place, start): (&[f64], usize),
    ) {
        let (request, sweep) = (evaluator.request, &evaluator.sweep);
        let sign = sweep.measures[measure].sign();
        let value = match measure {
            0 => &mut self.goal,
            k => &mut self.limits[k - 1],
        };
        let Some(value) = value.as_mut().filter(|own| peak > sign * own.value) else { return };
        let moved = sign * peak - value.value;
        value.bar = (value.bar.0 + moved, value.bar.1 + moved);
        value.value = sign * peak;
        if measure == 0 {
            let start = sweep.starts.get(start).cloned().unwrap_or_default();
            self.place = sweep.place_in_words(&evaluator.candidate, (place.to_vec(), start));
        }
        self.score = self.scored(request, sweep);
    }

    fn scored(&self, request: &DesignRequest, sweep: &SweepRequest<Candidate>) -> Score {
        let Some(goal) = self.goal else { return Score::WORST };
        let mut violation = 0.0;
        for ((limit, value), signed) in request.limits.iter().zip(&self.limits).zip(&sweep.measures[1..]) {
            let Some(value) = value else { return Score::WORST };
            let over = signed.sign() * (value.value - limit.value);
            let size = if limit.value == 0.0 { 1.0 } else { limit.value.abs() };
            violation += over.max(0.0) / size;
        }
        let goal = sweep.measures[0].sign() * goal.value;
        if goal.is_finite() && violation.is_finite() { Score(violation, goal) } else { Score::WORST }
    }
}

/// Progress of a search.
#[derive(Clone, Copy, Debug)]
pub struct Now {
    /// Stage of the last evaluation.
    pub stage: Stage,
    /// Number of evaluated designs.
    pub done: usize,
    /// Best goal of a design that meets the limits, SI.
    pub best: Option<f64>,
    /// Completed fraction of the search, from 0 to 1.
    pub part: f64,
}

impl fmt::Display for Now {
    /// Stage, number of designs and best goal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} designs", self.stage.words(), self.done)?;
        self.best.map_or(Ok(()), |best| write!(f, ", best {best:.4e}"))
    }
}

/// Callbacks for progress and cancellation.
pub struct Control<'a> {
    /// Whether to continue; called at each evaluation.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
    /// Called after each evaluation.
    pub progress: &'a (dyn Fn(&Now) + Sync),
}

/// Share of local searches and comparison in the progress, in evaluations.
const FURTHER: f64 = 30.0;

/// Evaluates designs and keeps all of them.
pub(crate) struct Evaluator<'a> {
    pub request: &'a DesignRequest,
    pub candidate: Candidate,
    pub sweep: SweepRequest<Candidate>,
    pub control: &'a Control<'a>,
    all: Mutex<Kept>,
}

/// Evaluated designs. A stage's designs are sorted by their values when it ends.
#[derive(Default)]
struct Kept {
    designs: Vec<Evaluation>,
    /// Goal of the best feasible design: with the sign for minimization, and as it is.
    best: Option<(f64, f64)>,
}

impl Kept {
    fn push(&mut self, own: Evaluation) {
        if let Some(goal) = own.goal.filter(|_| own.is_feasible())
            && self.best.is_none_or(|best| own.score.1 < best.0)
        {
            self.best = Some((own.score.1, goal.value));
        }
        self.designs.push(own);
    }
}

/// Whether two points of the unit box are near each other in every coordinate.
pub(crate) fn is_near(a: &[f64], b: &[f64], distance: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < distance)
}

impl<'a> Evaluator<'a> {
    pub fn new(request: &'a DesignRequest, control: &'a Control<'a>) -> Self {
        let candidate = Candidate::new(&request.machine, request.names(), request.robust);
        let sweep = request.sweep(&candidate);
        Self { request, candidate, sweep, control, all: Mutex::default() }
    }

    /// Values at a point of the unit box.
    pub fn values(&self, unit: &[f64]) -> Vec<f64> {
        let vary = self.request.vary.iter();
        vary.zip(unit).map(|(own, u)| (own.from * (1.0 - u) + own.to * u).clamp(own.from, own.to)).collect()
    }

    /// The point of the unit box with given values.
    pub fn unit(&self, values: &[f64]) -> Vec<f64> {
        self.request.vary.iter().zip(values).map(|(own, x)| (x - own.from) / (own.to - own.from)).collect()
    }

    /// Evaluates and records a design; `None` if the search was cancelled.
    pub fn evaluate(&self, values: Vec<f64>, stage: Stage) -> Option<(Evaluation, SearchedRow)> {
        if !(self.control.go_on)() {
            return None;
        }
        let found = searched(&self.candidate, &self.sweep, values);
        let own = Evaluation::of(self.request, (&self.candidate, &self.sweep), (&found.row, stage));
        let (done, best) = {
            let mut all = self.kept();
            all.push(own.clone());
            (all.designs.len(), all.best.map(|(_, goal)| goal))
        };
        let part = (done as f64 / (f64::from(self.request.evaluations) + FURTHER)).min(1.0);
        (self.control.progress)(&Now { stage, done, best, part });
        Some((own, found))
    }

    /// The machine of a design at a point of the band.
    pub fn machine(&self, values: &[f64], place: &[f64]) -> Option<Machine> {
        let names = self.request.names().into_iter().zip(values.iter().copied());
        let own = self.candidate.varied(&names.collect::<Vec<_>>()).ok()?;
        let over = self.sweep.over.iter().map(|axis| axis.name.clone()).zip(place.iter().copied());
        Some(own.varied(&over.collect::<Vec<_>>()).ok()?.machine)
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of evaluations.
    pub fn count(&self) -> usize {
        self.kept().designs.len()
    }

    /// Sorts the evaluations beginning at index `first`: their order then does not depend on
    /// threads.
    pub fn sort_from(&self, first: usize) {
        let all = &mut self.kept().designs;
        let first = first.min(all.len());
        all[first..].sort_by(|a, b| {
            let pairs = a.values.iter().zip(&b.values).map(|(a, b)| a.total_cmp(b));
            pairs.fold(Ordering::Equal, Ordering::then)
        });
    }

    /// All evaluations.
    pub fn all(&self) -> Vec<Evaluation> {
        self.kept().designs.clone()
    }

    /// Evaluations in ascending order of rank, without designs that have no value. If ranks are
    /// equal, the earlier evaluation comes first.
    pub fn ranked(&self) -> Vec<Evaluation> {
        let mut all: Vec<Evaluation> =
            self.all().into_iter().filter(|own| own.score < Score::WORST).collect();
        all.sort_by(|a, b| a.score.order(&b.score));
        all
    }

    /// At most `most` of the best designs. Any two differ by at least `distance` in some
    /// coordinate of the unit box.
    pub fn apart(&self, distance: f64, most: usize) -> Vec<Evaluation> {
        let mut kept: Vec<(Vec<f64>, Evaluation)> = Vec::new();
        for own in self.ranked() {
            let unit = self.unit(&own.values);
            if kept.len() < most && !kept.iter().any(|(other, _)| is_near(other, &unit, distance)) {
                kept.push((unit, own));
            }
        }
        kept.into_iter().map(|(_, own)| own).collect()
    }
}
