//! One branch of orbits of the paper's machine, as used by the follower of branches.

mod between;
mod step;

use super::cycle::Cycle;
use super::family::{ContactEquations, Family, Span};
use super::grazing::{self, Touch};
use super::orbit::eigenvalues;
use super::switching::Departure;
use super::system::System;
use crate::branch::{OrbitPoint, Special};
use crate::curve::CurvePoint;
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::orbit::Stability;
use crate::paper::sample::{DOUBLING, Sample, TESTS, UNIT, test};
use crate::path::{self, Earlier, Follow, PathEnd, closes};
use crate::path_options::PathOptions;
use crate::stop_word::OrbitWord;
use crate::test_functions::SignedLog;
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Tolerance for equal values of the parameter, in its curve unit: rounding.
const MARK: f64 = 1e-12;

/// An end of a path where other branches begin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum End {
    /// At a touch.
    Touch(Box<Touch>),
    /// At the branch where this branch is born by doubling, with the word, phases and parameter on
    /// that branch.
    Primary(OrbitWord, #[serde(with = "crate::stored::vector")] DVector<f64>),
}

type Tests = [Option<SignedLog>; TESTS];
type Position = crate::position::Position<Tests>;
type Advance = path::Advance<Tests, End>;

pub(super) struct Follower<'a> {
    pub family: &'a Family,
    pub word: &'a OrbitWord,
    pub options: &'a PathOptions,
    /// Parameter values at which points are requested.
    pub marks: &'a [f64],
}

impl Follow for Follower<'_> {
    type Tests = Tests;
    type Of = Option<[Complex<f64>; 6]>;
    type End = End;
    const SHORT: f64 = 0.0;

    /// At a birth or a touch, only the test functions that are regular there are computed.
    fn first(&self, departure: &Departure) -> Result<Position, Obstacle> {
        let Departure { u, direction: tangent, .. } = departure;
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.word.len()])?;
        let label = departure.special.as_ref().map(|s| s.label);
        if label.is_none() {
            let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
            return Ok(self.sampled(
                &system,
                CurvePoint { u: u.clone(), tangent: tangent.clone(), steps: 3 },
                sample,
            ));
        }
        let smooth = label == Some(Label::Grazing);
        let tests = [UNIT, DOUBLING].map(|index| if smooth { test(&cycle, index) } else { None });
        let own = || eigenvalues(cycle.monodromy());
        let multipliers = departure.of.or_else(own).ok_or(Obstacle::NoConvergence)?;
        let tests = [tests[0], tests[1], None];
        Ok(self.at_end(&system, (u.clone(), tangent.clone()), multipliers, tests))
    }

    fn value(&self, u: &DVector<f64>) -> f64 {
        u[self.word.len()] * self.span().unit()
    }

    fn step(&self, (_, last): (&Earlier<Tests>, &Position), step: f64, _: bool) -> Result<Advance, Obstacle> {
        self.advance(last, step)
    }

    fn leap(&self, (_, last): (&Earlier<Tests>, &Position), _: bool) -> Option<Advance> {
        self.advance_to_birth(last).ok()
    }

    fn leave(&self, first: &mut OrbitPoint, Advance { between, next, .. }: &Advance) {
        first.stability = if between.is_empty() { next.stability } else { Stability::Unstable };
    }

    /// The last point takes the stability of the piece before it.
    fn arrive(&self, points: &mut Vec<OrbitPoint>, _: &PathEnd<End>) {
        if let [.., before, last] = &mut points[..] {
            last.stability = before.stability;
        }
    }

    /// The path also closes at any orbit that equals the first one after a turn.
    fn closes(&self, (u, tangent): &(DVector<f64>, DVector<f64>), [last, next]: [&Position; 2]) -> bool {
        let n = self.word.len();
        let phases = &u.as_slice()[..n];
        self.word.symmetries(self.family.is_symmetric()).into_iter().any(|turn| {
            let turned = self.word.turned_phases(phases, turn);
            let rates =
                DVector::from_fn(n + 1, |i, _| if i < n { tangent[(i + turn.by) % n] } else { tangent[n] });
            let whole = ((last.u[0] - turned[0]) / TAU).round() * TAU;
            let there = DVector::from_fn(n + 1, |i, _| if i < n { turned[i] + whole } else { u[n] });
            closes((&there, &rates), [&last.u, &next.u], &next.tangent)
        })
    }

    fn point(&self, position: &Position, special: Option<Special>) -> OrbitPoint {
        let value = self.value(&position.u);
        let mark =
            self.marks.iter().copied().find(|mark| self.is_at(value, *mark)).filter(|_| special.is_none());
        OrbitPoint {
            value: mark.unwrap_or(value),
            period: position.period,
            multipliers: position.multipliers.clone(),
            stability: position.stability,
            special: special.or(mark.map(|_| Special::of(Label::UserValue))),
            u: position.u.clone(),
        }
    }
}

impl Follower<'_> {
    fn contacts(&self) -> ContactEquations<'_> {
        ContactEquations { family: self.family, word: self.word }
    }

    fn span(&self) -> &Span {
        self.family.span()
    }

    /// Whether a parameter value is a mark except for rounding.
    fn is_at(&self, value: f64, mark: f64) -> bool {
        (value - mark).abs() <= MARK * self.span().unit()
    }

    /// The position of a point whose cycle has been examined.
    fn sampled(&self, system: &System, at: CurvePoint, sample: Sample) -> Position {
        let stability = stability(sample.is_stable());
        let Sample { multipliers, tests, .. } = sample;
        let end = self.at_end(system, (at.u, at.tangent), multipliers, tests);
        Position { steps: at.steps, stability, ..end }
    }

    /// The position of a point where a branch begins or ends; it takes the stability of a piece.
    fn at_end(
        &self,
        system: &System,
        (u, tangent): (DVector<f64>, DVector<f64>),
        multipliers: [Complex<f64>; 6],
        tests: Tests,
    ) -> Position {
        let period = system.period(self.word);
        let (multipliers, stability) = (multipliers.to_vec(), Stability::Unstable);
        Position { u, tangent, steps: 3, period, multipliers, stability, tests }
    }

    /// Properties of a point on the curve; if it is not certified, with the touches that it
    /// indicates.
    fn look(&self, curve: CurvePoint) -> Result<(Position, Option<Vec<Touch>>), Obstacle> {
        let system = self.family.system_at(&curve.u)?;
        let cycle = Cycle::new(&system, self.word, &curve.u.as_slice()[..self.word.len()])?;
        let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
        let touches = (!sample.is_certified()).then(|| grazing::announced(&cycle, &curve.u));
        Ok((self.sampled(&system, curve, sample), touches))
    }

    /// Properties of a point within a step between two certified points. If it is not certified,
    /// the block touches stops twice in the step, and the step is too long.
    fn look_certified(&self, curve: CurvePoint) -> Result<Position, Obstacle> {
        let (position, touches) = self.look(curve)?;
        if touches.is_some() { Err(Obstacle::NoConvergence) } else { Ok(position) }
    }
}

/// The stability as an enum.
pub(super) fn stability(is_stable: bool) -> Stability {
    if is_stable { Stability::Stable } else { Stability::Unstable }
}
