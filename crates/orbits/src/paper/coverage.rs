//! Orbits of a tree: whether a branch contains an orbit, and on which branch a settled motion
//! lies.

use super::branch::Branch;
use super::family::Family;
use super::grower::SAME_PLACE;
use super::orbit::{Orbit, canonical, newton, same_phases};
use super::settled::first_phase;
use super::system::System;
use super::tree::Tree;
use crate::branch::OrbitPoint;
use crate::stop_word::REPETITION;
use std::f64::consts::{PI, TAU};
use vibro_studies::Result;
use vibro_studies::paper::attractor::Attractor;
use vibro_studies::paper::stroboscopic::{StroboscopicState, dimensionless};

/// Tolerance for equal phases of two orbits at one parameter value, rad.
const SAME_ORBIT: f64 = 1e-6;

/// Largest difference, rad, between interpolated phases and an orbit's phases for a Newton
/// attempt.
const NEAR_ORBIT: f64 = 0.2;

/// An orbit of a tree at a parameter value.
#[derive(Clone, Debug)]
pub struct TreeOrbit {
    /// The number of its branch.
    pub branch: usize,
    /// The orbit, certified.
    pub orbit: Orbit,
}

/// Position of a settled motion in a tree.
#[derive(Clone, Debug)]
pub struct Covering {
    /// The number of the branch.
    pub branch: usize,
    /// The stable orbit of the branch at the motion's parameter value.
    pub orbit: Orbit,
    /// The largest difference of a coordinate between the states of the motion and of the orbit at
    /// whole drive periods, units of L and L ω10: the remaining transient of the motion.
    pub distance: f64,
}

impl Tree {
    /// The largest [`distance`](Covering::distance) at which a motion counts as settled on an
    /// orbit. Motions on one attractor from different starts differ by less; distinct orbits
    /// differ by more.
    pub const SETTLED_DISTANCE: f64 = 1e-3;

    /// The branch that contains an orbit, if there is one.
    pub fn passing(
        &self,
        family: &Family,
        word: &super::OrbitWord,
        phases: &[f64],
        value: f64,
    ) -> Option<usize> {
        if phases.len() != word.len() {
            return None;
        }
        let mirror = family.is_symmetric();
        let (word, phases) = canonical(word, phases, mirror);
        self.branches
            .iter()
            .find(|b| *b.word() == word && b.passes(family, &phases, value, mirror))
            .map(|b| b.id)
    }

    /// The orbits of all branches at a parameter value, in the order of the branches.
    ///
    /// # Errors
    /// The error of [`Family::system`] at `value`.
    pub fn orbits_at(&self, family: &Family, value: f64) -> Result<Vec<TreeOrbit>> {
        let system = family.system(&[value])?;
        let of = |branch: &Branch| {
            let id = branch.id;
            branch
                .orbits_in(&system, value, |_| true)
                .into_iter()
                .map(move |orbit| TreeOrbit { branch: id, orbit })
        };
        Ok(self.branches.iter().flat_map(of).collect())
    }

    /// The stable orbit of the tree on which a simulated motion has settled at a parameter value:
    /// the nearest stable orbit, if it is within [`SETTLED_DISTANCE`](Self::SETTLED_DISTANCE). For
    /// a symmetric machine, an orbit's mirror image counts as the orbit.
    ///
    /// The comparison uses the states at whole drive periods over one period of the motion, which
    /// must be a multiple of the orbit's period. The result is `None` if the tree has no such
    /// orbit: the motion is not periodic, rests at a stop or is still transient, or its branch is
    /// missing. The fraction of a simulated diagram that the tree explains is the number of
    /// covered rows divided by the number of periodic rows without rest.
    ///
    /// ```
    /// use vibro_studies::paper::attractor::observe;
    /// use vibro_orbits::paper::{Family, Span, TreeOptions, settle, tree};
    /// use vibro_studies::paper::stroboscopic::moving_block;
    /// use vibro_studies::paper::{ParameterSet, find_group};
    /// use vibro_impact::Simulator;
    ///
    /// let span = Span::new(find_group("f10")?, 1.4, 1.6)?;
    /// let family = Family::new(&ParameterSet::basic(), span)?;
    /// let few = TreeOptions { seeds: 2, settle: 300, starts: 0, ..TreeOptions::default() };
    /// let options = TreeOptions { depth: 0, ..few };
    /// let found = tree(&family, &options, &|_, _| ())?;
    ///
    /// let system = family.system(&[1.5])?;
    /// let settled = settle(&system, &moving_block(system.parameters()), 300)?;
    /// let attractor = observe(&mut Simulator::new(system.parameters(), &settled, 0.0)?)?;
    /// let covering = found.covering(&family, 1.5, &attractor)?.expect("the symmetric motion");
    /// assert!(covering.distance < 1e-9);
    /// assert_eq!(found.branches[covering.branch].word().to_string(), "U");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The error of [`Family::system`] at `value`.
    pub fn covering(&self, family: &Family, value: f64, attractor: &Attractor) -> Result<Option<Covering>> {
        if attractor.period.is_none() || attractor.rests {
            return Ok(None);
        }
        let system = family.system(&[value])?;
        let of = |b: &Branch| {
            let stable =
                b.orbits_in(&system, value, OrbitPoint::is_stable).into_iter().filter(Orbit::is_stable);
            stable.map(|orbit| (b.id, orbit)).collect::<Vec<_>>()
        };
        let compared = self.branches.iter().flat_map(of).filter_map(|(branch, orbit)| {
            let distance = distance(&orbit, &attractor.states)?;
            (distance <= Self::SETTLED_DISTANCE).then_some(Covering { branch, orbit, distance })
        });
        Ok(compared.min_by(|a, b| a.distance.total_cmp(&b.distance)))
    }
}

/// The largest difference of a coordinate between the states of an orbit and of a motion at whole
/// drive periods. The motion may begin in any drive period of the orbit or, for a symmetric
/// machine, of its mirror image; the smallest value is returned. `None` unless the motion's period
/// is a multiple of the orbit's.
fn distance(orbit: &Orbit, states: &[StroboscopicState]) -> Option<f64> {
    let p = orbit.system().parameters();
    let period = orbit.word().period() as usize;
    if states.is_empty() || !states.len().is_multiple_of(period) {
        return None;
    }
    let strobe = |shift: f64, sign: f64| -> Vec<StroboscopicState> {
        let phase = |k: usize| first_phase(p) + TAU * k as f64 + shift;
        (0..period).map(|k| dimensionless(p, &orbit.state(phase(k))).map(|x| sign * x)).collect()
    };
    let image = orbit.system().is_symmetric().then(|| strobe(PI, -1.0));
    let apart = |own: &[StroboscopicState], first: usize| {
        let pairs = states.iter().zip(own.iter().cycle().skip(first));
        pairs.flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let ways = std::iter::once(strobe(0.0, 1.0)).chain(image);
    let all = ways.flat_map(|own| (0..period).map(|first| apart(&own, first)).collect::<Vec<_>>());
    all.min_by(f64::total_cmp)
}

impl Branch {
    /// Whether the branch contains an orbit of the family's machine at a parameter value.
    pub fn holds(&self, family: &Family, orbit: &Orbit, value: f64) -> bool {
        let mirror = family.is_symmetric();
        let (word, phases) = orbit.word().reduced(orbit.phases(), mirror, REPETITION);
        let (word, phases) = canonical(&word, &phases, mirror);
        word == *self.word() && self.passes(family, &phases, value, mirror)
    }

    /// The pairs of adjacent points with a value between them.
    fn pieces_around(&self, value: f64) -> impl Iterator<Item = [&OrbitPoint; 2]> {
        let inside = move |pair: &[&OrbitPoint; 2]| {
            let [a, b] = pair.map(|p| p.value);
            (a.min(b) - SAME_PLACE..=a.max(b) + SAME_PLACE).contains(&value)
        };
        self.points.windows(2).map(|pair| [&pair[0], &pair[1]]).filter(inside)
    }

    /// Guesses of the phases of an orbit between two points: the interpolated phases, and the
    /// phases of both points, since interpolation is poor near a fold or a birth.
    fn guesses(value: f64, [a, b]: [&OrbitPoint; 2]) -> [Vec<f64>; 3] {
        let way = b.value - a.value;
        let part = if way == 0.0 { 0.5 } else { ((value - a.value) / way).clamp(0.0, 1.0) };
        let between = a.phases().iter().zip(b.phases()).map(|(a, b)| a + part * (b - a)).collect();
        [between, a.phases().to_vec(), b.phases().to_vec()]
    }

    /// Whether the branch contains an orbit of its word with given phases.
    fn passes(&self, family: &Family, phases: &[f64], value: f64, mirror: bool) -> bool {
        if self.word().is_empty() {
            return self.pieces_around(value).next().is_some();
        }
        self.pieces_around(value).any(|pair| {
            let guesses = Self::guesses(value, pair);
            let near = |tolerance, found: &[f64]| same_phases(self.word(), phases, found, mirror, tolerance);
            if !near(NEAR_ORBIT, &guesses[0]) {
                return false;
            }
            let Ok(system) = family.system(&[value]) else { return false };
            guesses
                .iter()
                .any(|guess| newton(&system, self.word(), guess).is_ok_and(|found| near(SAME_ORBIT, &found)))
        })
    }

    /// Certified orbits of the branch at a parameter value. Only pieces whose first point
    /// satisfies `begins` are searched.
    fn orbits_in(&self, system: &System, value: f64, begins: impl Fn(&OrbitPoint) -> bool) -> Vec<Orbit> {
        let mut found: Vec<Orbit> = Vec::new();
        for pair in self.pieces_around(value).filter(|pair| begins(pair[0])) {
            let guesses = Self::guesses(value, pair);
            let near =
                |phases: &[f64]| phases.iter().zip(&guesses[0]).all(|(a, b)| (a - b).abs() < NEAR_ORBIT);
            let reached = |guess: &Vec<f64>| {
                let phases = newton(system, self.word(), guess).ok().filter(|phases| near(phases))?;
                Orbit::at(system, self.word(), &phases).ok().filter(Orbit::is_certified)
            };
            // Two pieces that meet at the value share one orbit; it is kept once.
            found.extend(
                guesses
                    .iter()
                    .find_map(reached)
                    .filter(|new| !found.iter().any(|old| old.is_same(new, SAME_ORBIT))),
            );
        }
        found
    }
}
