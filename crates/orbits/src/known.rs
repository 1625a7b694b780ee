//! Orbits of a branch at a parameter value, and whether an orbit lies on a branch.

use super::branch::{Branch, OrbitPoint};
use super::cycle::Leg;
use super::orbit::{Orbit, newton, within};
use super::place::Place;
use super::word::Word;
use crate::curve::correct;
use crate::curve::zero;
use nalgebra::DVector;

/// Distance limit from the chord, as a fraction of the distance to the nearer end. Within it,
/// Newton's method at a parameter value has found the piece's own orbit. A curve bends less than
/// this within a step; another branch that crosses the piece at one of its ends is further away.
const NEAR: f64 = 0.5;
/// Largest distance between equal points.
const SAME: f64 = 1e-6;
/// Accuracy of a position along a chord, as a fraction of the chord.
const ALONG: f64 = 1e-13;

impl Branch {
    /// The events of all its orbits.
    pub fn word(&self) -> &Word {
        &self.of.word
    }

    /// The orbit of one of its points; `None` if it cannot be recomputed.
    pub fn orbit(&self, point: &OrbitPoint) -> Option<Orbit> {
        let place = self.of.place(&point.u).ok()?;
        Orbit::at(self.of.clone(), place, point.u.clone()).ok()
    }

    /// Whether an orbit of this family lies on the branch.
    pub fn passes(&self, orbit: &Orbit) -> bool {
        // A run of impacts is simulated, so the contacts after its first impact need not agree.
        let is_run =
            self.word().has_run() && orbit.word().has_run() && has_same_impacts(self.word(), orbit.word());
        (is_run || orbit.has_word(self.word()))
            && self
                .orbits_at(orbit.value())
                .iter()
                .any(|own| own.is_same(orbit) || is_run && own.moves_as(orbit))
    }

    /// Whether all its orbits are the same.
    pub(super) fn is_point(&self) -> bool {
        self.points.iter().all(|point| (&point.u - &self.points[0].u).norm() < SAME)
    }

    /// Orbits of the branch at a parameter value, from the points on either side.
    pub fn orbits_at(&self, value: f64) -> Vec<Orbit> {
        let Ok(place) = self.of.family.place(value) else { return Vec::new() };
        let mut found: Vec<Orbit> = Vec::new();
        for pair in self.points.windows(2) {
            let [a, b] = [&pair[0], &pair[1]];
            if (a.value - value) * (b.value - value) > 0.0 {
                continue;
            }
            let Some(u) = self.between(&place, [a, b], value) else { continue };
            if found.iter().any(|own| (&own.u - &u).norm() < SAME) {
                continue;
            }
            let place = self.of.family.place(value).ok();
            let orbit = place.and_then(|place| Orbit::at(self.of.clone(), place, u).ok());
            found.extend(orbit.filter(Orbit::is_certified));
        }
        found
    }

    /// The unknowns of the orbit at a parameter value between two adjacent points.
    fn between(&self, place: &Place, [a, b]: [&OrbitPoint; 2], value: f64) -> Option<DVector<f64>> {
        let (last, at) = (self.of.size(), value / self.of.family.unit());
        let (chord, way) = (&b.u - &a.u, b.value - a.value);
        let part = if way == 0.0 { 0.5 } else { (value - a.value) / way };
        let mut guess = &a.u + &chord * part;
        guess[last] = at;
        let near = NEAR * part.min(1.0 - part) * chord.norm() + SAME;
        newton(&self.of, place, &guess).ok().filter(|u| (u - &guess).norm() <= near).or_else(|| {
            let mut u = self.on_chord([a, b], &chord, at)?;
            u[last] = at;
            Some(u)
        })
    }

    /// The point of the curve between two points at a parameter value, in its unit. Near a turn in
    /// the parameter, Newton's method at the value finds the branch that crosses there. Points in
    /// planes perpendicular to the chord stay on the piece.
    fn on_chord(&self, [a, b]: [&OrbitPoint; 2], chord: &DVector<f64>, at: f64) -> Option<DVector<f64>> {
        let (last, along) = (self.of.size(), chord.normalize());
        let point = |part: f64| correct(&self.of, &(&a.u + chord * part), &along).map(|at| at.u);
        let ends = (a.u[last] - at, b.u[last] - at);
        point(zero(&|part| Ok(point(part)?[last] - at), 1.0, ends, ALONG)?).ok()
    }
}

impl Orbit {
    /// Whether another orbit of this driven machine is the same motion.
    fn moves_as(&self, other: &Self) -> bool {
        let (Some(period), units) = (self.place.period, &self.problem.units.state) else { return false };
        let (time, state) = other.middle_state();
        let is_near = |leg: &Leg, after: f64| {
            let own = within(&self.place, leg, after / leg.span).1;
            let pairs = own.iter().zip(&state).zip(units);
            pairs.into_iter().all(|((a, b), unit)| ((a - b) / unit).abs() < SAME)
        };
        (0..self.word().periods.unwrap_or(0)).any(|turn| {
            let begun = |leg: &Leg| (time + f64::from(turn) * period - leg.time).rem_euclid(self.period());
            self.legs().iter().any(|leg| begun(leg) < leg.span && is_near(leg, begun(leg)))
        })
    }
}

/// Whether two words have the same period and hit the same stops in the same order, up to a cyclic
/// shift.
fn has_same_impacts(a: &Word, b: &Word) -> bool {
    let hits =
        |word: &Word| word.letters.iter().flat_map(|letter| letter.hits().collect::<Vec<_>>()).collect();
    let (own, other): (Vec<usize>, Vec<usize>) = (hits(a), hits(b));
    let is_from = |first: usize| own.iter().cycle().skip(first).zip(&other).all(|(own, other)| own == other);
    a.periods == b.periods && own.len() == other.len() && (0..own.len().max(1)).any(is_from)
}
