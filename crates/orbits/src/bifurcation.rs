//! Test functions of bifurcations, and the parts of a step where one changes sign.

use super::position::{Examined, Position};
use crate::label::Label;

/// A test function of a bifurcation.
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

    /// The test's value at a position; for determinants in units of the value at another position.
    pub fn of(self, at: &Position<Examined>, unit: &Position<Examined>) -> f64 {
        match self {
            Self::Fold => at.fold(),
            Self::Crossing => at.tests.crossing.relative_to(unit.tests.crossing),
            Self::Doubling => at.tests.doubling.relative_to(unit.tests.doubling),
            Self::Pair => at.tests.pair,
        }
    }
}

/// The end of a step, as used by the tests of bifurcations.
pub(super) struct Ends<'a> {
    pub next: &'a Position<Examined>,
    /// The arc of the step.
    pub arc: f64,
    /// A position before the end, with its arc. It is used for tests that vanish or have no value
    /// at the end itself.
    pub before: Option<(Position<Examined>, f64)>,
    /// Whether a condition ceases to hold at the end.
    pub is_touch: bool,
}

impl Ends<'_> {
    /// The position at which a test is evaluated, with its arc. At a touch, multipliers may be
    /// unbounded, but determinants of the equations are smooth. At a birth, all tests except the
    /// fold test vanish or belong to the shorter orbit.
    pub fn of(&self, test: Test) -> (&Position<Examined>, f64) {
        match (&self.before, test) {
            (Some((before, arc)), Test::Pair) => (before, *arc),
            (Some((before, arc)), _) if !self.is_touch => (before, *arc),
            _ => (self.next, self.arc),
        }
    }

    /// The same end for a step that begins next to this step's start.
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

/// A part of a step whose ends have different signs of a test.
pub(super) struct Bracket {
    /// Arc from the start of the step.
    pub begin: f64,
    /// The positions at both ends.
    pub ends: [Position<Examined>; 2],
    /// Arc from the first end to the second.
    pub arc: f64,
}
