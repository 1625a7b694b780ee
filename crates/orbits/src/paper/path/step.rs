//! One step along a branch: to the next point, or to an earlier end of the branch.

use super::{Advance, End, Follower, Position};
use crate::branch::Special;
use crate::curve::{self, CurvePoint, correct};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::paper::cycle::Cycle;
use crate::paper::grazing::{self, ExaminedTouch, Touch};
use crate::paper::orbit::{Orbit, eigenvalues, newton, unfolded_phases};
use crate::paper::sample::{DOUBLING, UNIT, test};
use crate::paper::special;
use crate::paper::switching::FlightTouch;
use crate::path::{COSINE, Follow, LEAST_STEP, PathEnd};
use crate::stop_word::OrbitWord;
use nalgebra::DVector;

/// Largest correction of a step, as a fraction of the step.
const CORRECTION: f64 = 0.3;
/// Distance, in steps, within which the birth of a branch is sought if the branch cannot be
/// continued.
const BEYOND: f64 = 2.0;

impl Follower<'_> {
    /// One step: to the next point, or to an earlier end of the path.
    pub(super) fn advance(&self, last: &Position, step: f64) -> Result<Advance, Obstacle> {
        let predicted = &last.u + &last.tangent * step;
        if !self.span().contains(self.value(&predicted)) {
            return self.advance_to_end(last, self.value(&predicted));
        }
        let follows = |curve: &CurvePoint| {
            let turned = curve.tangent.dot(&last.tangent) < COSINE;
            !turned && (&curve.u - &predicted).norm() <= CORRECTION * step
        };
        let Some(curve) = correct(&self.contacts(), &predicted, &last.tangent).ok().filter(follows) else {
            // The corrector may end on the branch where this one is born.
            let beyond = &last.u + &last.tangent * (BEYOND * step);
            let primary = special::primary(self.family, self.word, &last.u, &beyond)?;
            return self.end_at_primary(last, primary.ok_or(Obstacle::NoConvergence)?);
        };
        if !self.span().contains(self.value(&curve.u)) {
            return self.advance_to_end(last, self.value(&curve.u));
        }
        self.arrive(last, curve, None)
    }

    /// A step exactly to the birth of a branch. Near the birth the equations are nearly singular,
    /// so continuation fails there.
    pub(super) fn advance_to_birth(&self, last: &Position) -> Result<Advance, Obstacle> {
        let within = self.options.longest_step;
        let beyond = special::beyond_birth(self.word, &last.u, &last.tangent, within)
            .ok_or(Obstacle::NoConvergence)?;
        let primary = special::primary(self.family, self.word, &last.u, &beyond)?;
        self.end_at_primary(last, primary.ok_or(Obstacle::NoConvergence)?)
    }

    /// A step to the end of the parameter's range, which is reached before `beyond`.
    fn advance_to_end(&self, last: &Position, beyond: f64) -> Result<Advance, Obstacle> {
        let n = self.word.len();
        let end = if beyond < self.span().from { self.span().from } else { self.span().to };
        let arc = (end / self.span().unit() - last.u[n]) / last.tangent[n];
        if !(arc.is_finite() && arc >= 0.0) {
            return Err(Obstacle::NoConvergence);
        }
        let predicted = &last.u + &last.tangent * arc;
        let phases = newton(&self.family.system(&[end])?, self.word, &predicted.as_slice()[..n])?;
        let u = self.family.point(&phases, &[end]);
        if (&u - &predicted).norm() > CORRECTION * arc + LEAST_STEP {
            return Err(Obstacle::NoConvergence);
        }
        let tangent = curve::tangent(&self.contacts(), &u, &last.tangent)?;
        let curve = CurvePoint { u, tangent, steps: 3 };
        self.arrive(last, curve, Some(Label::EndPoint))
    }

    /// Accepts a point as the next one, unless the path ends before it.
    fn arrive(&self, last: &Position, curve: CurvePoint, label: Option<Label>) -> Result<Advance, Obstacle> {
        let (next, touches) = self.look(curve)?;
        if let Some(touches) = touches {
            return self.end_at_touch(last, &next, touches);
        }
        if let Some(primary) = special::primary(self.family, self.word, &last.u, &next.u)? {
            return self.end_at_primary(last, primary);
        }
        let between = self.between(last, &next)?;
        let end = label.map(|_| PathEnd::Plain);
        Ok(Advance { between, next, special: label.map(Special::of), end, begins: None })
    }

    /// Ends the path at the first of the touches on the way to `next`.
    fn end_at_touch(
        &self,
        last: &Position,
        next: &Position,
        touches: Vec<Touch>,
    ) -> Result<Advance, Obstacle> {
        let length = last.tangent.dot(&(&next.u - &last.u));
        let arc = |touch: &Touch| {
            let way = touch.on_branch() - &last.u;
            let arc = last.tangent.dot(&way);
            let aside = (way - &last.tangent * arc).norm();
            let near = aside <= CORRECTION * length + LEAST_STEP;
            (near && arc >= -LEAST_STEP && arc <= length + LEAST_STEP).then_some(arc)
        };
        let located = touches.iter().filter_map(|touch| grazing::locate(self.family, touch).ok());
        let placed = located.filter_map(|touch| Some((arc(&touch)?, touch)));
        // If two touches coincide (a repeated orbit touches in each repetition), the touch listed
        // by the word is chosen.
        let order = |a: &(f64, Touch), b: &(f64, Touch)| {
            if (a.0 - b.0).abs() < LEAST_STEP {
                b.1.from_longer.cmp(&a.1.from_longer)
            } else {
                a.0.total_cmp(&b.0)
            }
        };
        let (_, touch) = placed.min_by(order).ok_or(Obstacle::NoConvergence)?;
        let ExaminedTouch { touch, is_orbit, pressed } = grazing::examine(self.family, touch)?;
        if !is_orbit {
            return Err(Obstacle::NoConvergence);
        }
        let u = touch.on_branch();
        let system = self.family.system_at(&u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.word.len()])?;
        let tests = [test(&cycle, UNIT), test(&cycle, DOUBLING), None];
        let without = FlightTouch::of(self.family, &touch);
        let phases = &without.u.as_slice()[..without.shorter.len()];
        let multipliers = Orbit::at(&system, &without.shorter, phases)?.multipliers();
        let at = self.at_end(&system, (u, last.tangent.clone()), multipliers, tests);
        let between = self.between(last, &at)?;
        let label = if pressed { Label::Chatter } else { Label::Grazing };
        let special = Special { longer: Some(touch.longer.clone()), ..Special::of(label) };
        let end = Some(if pressed { PathEnd::Plain } else { PathEnd::At(End::Touch(Box::new(touch))) });
        Ok(Advance { between, next: at, special: Some(special), end, begins: None })
    }

    /// Ends the path at the branch where it is born by doubling.
    fn end_at_primary(
        &self,
        last: &Position,
        (word, u): (OrbitWord, DVector<f64>),
    ) -> Result<Advance, Obstacle> {
        let n = word.len();
        let phases = unfolded_phases(&word, &u.as_slice()[..n]);
        let values = self.family.values(&u);
        let doubled = self.family.point(&phases, &values);
        let system = self.family.system(&values)?;
        let cycle = Cycle::new(&system, self.word, &phases)?;
        let multipliers = eigenvalues(cycle.monodromy()).ok_or(Obstacle::NoConvergence)?;
        // Before the birth, the doubling test function may change sign; the test function for a
        // multiplier 1 touches zero at the end.
        let tests = [None, test(&cycle, DOUBLING), None];
        let next = self.at_end(&system, (doubled, last.tangent.clone()), multipliers, tests);
        let between = self.between(last, &next)?;
        let label = if word.closing() < 0 { Label::BranchPoint } else { Label::PeriodDoubling };
        let (special, end) = (Some(Special::of(label)), Some(PathEnd::At(End::Primary(word, u))));
        Ok(Advance { between, next, special, end, begins: None })
    }
}
