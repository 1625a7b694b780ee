//! Tests of bifurcations, and the parts of a step in which one changes its sign.

use super::position::{Examined, Position};
use crate::label::Label;

/// A bifurcation's test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Test {
    Fold,
    Crossing,
    Doubling,
    Pair,
}

impl Test {
    pub const ALL: [Self; 4] = [Self::Fold, Self::Crossing, Self::Doubling, Self::Pair];

    pub fn label(self) -> Label {
        match self {
            Self::Fold => Label::Fold,
            Self::Crossing => Label::BranchPoint,
            Self::Doubling => Label::PeriodDoubling,
            Self::Pair => Label::NeimarkSacker,
        }
    }

    /// The test's value in units of a position's.
    pub fn of(self, at: &Position<Examined>, unit: &Position<Examined>) -> f64 {
        match self {
            Self::Fold => at.fold(),
            Self::Crossing => at.tests.crossing.relative_to(unit.tests.crossing),
            Self::Doubling => at.tests.doubling.relative_to(unit.tests.doubling),
            Self::Pair => at.tests.pair,
        }
    }
}

/// The end of a step, as the tests of bifurcations see it.
pub(super) struct Ends<'a> {
    pub next: &'a Position<Examined>,
    /// The arc of the step.
    pub arc: f64,
    /// A position before the end at which tests have a value that have none at the end itself, or
    /// vanish there, with its arc.
    pub before: Option<(Position<Examined>, f64)>,
    /// Whether a condition ceases to hold at the end.
    pub is_touch: bool,
}

impl Ends<'_> {
    /// The position at which a test is taken, with its arc. At a touch multipliers may have no
    /// bound, but determinants of the equations are smooth; at a birth all tests but that of a fold
    /// vanish or are those of the shorter orbit.
    pub fn of(&self, test: Test) -> (&Position<Examined>, f64) {
        match (&self.before, test) {
            (Some((before, arc)), Test::Pair) => (before, *arc),
            (Some((before, arc)), _) if !self.is_touch => (before, *arc),
            _ => (self.next, self.arc),
        }
    }

    /// The same end for a step that begins beside the step's begin.
    pub fn seen_from(&self, last: &Position<Examined>, begins: &Position<Examined>) -> Ends<'_> {
        let way = begins.tangent.dot(&(&begins.u - &last.u));
        let arc_to = |at: &Position<Examined>| begins.tangent.dot(&(&at.u - &begins.u));
        let seen = |(at, arc): &(Position<Examined>, f64)| match *arc > way {
            true => (at.clone(), arc_to(at)),
            false => (begins.clone(), 0.0),
        };
        let before = self.before.as_ref().map(seen);
        Ends { next: self.next, arc: arc_to(self.next), before, is_touch: self.is_touch }
    }
}

/// A part of a step at whose ends a test has different signs.
pub(super) struct Bracket {
    /// Arc from the step's begin.
    pub begin: f64,
    /// The positions at both ends.
    pub ends: [Position<Examined>; 2],
    /// Arc from the first end to the second.
    pub arc: f64,
}
