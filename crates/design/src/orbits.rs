//! Measures of periodic orbits with their exact derivatives, at points of a design's band.

use crate::candidate::TOLERANCE;
use crate::contact_points::ContactPoint;
use crate::evaluation::Evaluator;
use vibro_machine::Start;
use vibro_orbits::{Orbit, Stability};
use vibro_studies::common_period;

/// Largest number of secant steps towards a peak of the band. The secant method converges
/// superlinearly, so that a few steps suffice near a peak.
const STEPS: u32 = 8;
/// Step of the band's parameter, as a fraction of the bracket, below which the search for a peak
/// ends. At a peak the slope is zero, so that the measure's error is of second order in this step.
const FOUND: f64 = 1e-5;
/// First step towards a peak, as a fraction of the distance to the end of the bracket.
const FIRST: f64 = 0.05;

/// An orbit followed while the parameters of the design change.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    /// Point of the band at which the orbit is measured. Along the axis of the bracket the point
    /// follows the peak.
    pub point: ContactPoint,
    /// State on the last orbit found.
    seed: Start,
    /// Period of the last orbit found, in common drive periods.
    periods: Option<u32>,
    /// Common drive period of the last orbit found, s; the seed's time is scaled with it.
    period: Option<f64>,
}

/// The measure of a followed orbit, signed so that large is bad, and its derivatives with respect
/// to the varied parameters.
#[derive(Clone, Debug)]
pub(crate) struct Slope {
    pub value: f64,
    pub gradient: Vec<f64>,
}

fn is_attractor(orbit: &Orbit) -> bool {
    orbit.is_certified() && orbit.stability() == Stability::Stable
}

impl Followed {
    /// The orbit on which the motion of a point settles; `None` if it does not settle on one.
    pub fn new(evaluator: &Evaluator, values: &[f64], point: ContactPoint) -> Option<Self> {
        let machine = evaluator.machine(values, &point.place)?;
        let start = evaluator.sweep.starts.get(point.start)?;
        let orbit = Orbit::settled(&machine, start, evaluator.sweep.discard).ok().filter(is_attractor)?;
        let period = common_period(&machine.description);
        Some(Self { point, seed: orbit.start(), periods: orbit.word().periods, period })
    }

    /// The orbit for other values, near the last orbit found.
    fn orbit(&mut self, evaluator: &Evaluator, values: &[f64], place: &[f64]) -> Option<Orbit> {
        let machine = evaluator.machine(values, place)?;
        let period = common_period(&machine.description);
        let mut seed = self.seed.clone();
        if let (Some(now), Some(before)) = (period, self.period) {
            seed.time *= now / before;
        }
        let time = period.zip(self.periods).map(|(period, count)| period * f64::from(count));
        let near = time.and_then(|time| Orbit::near(&machine, &seed, time).ok()).filter(is_attractor);
        let found = near.or_else(|| {
            let own = evaluator.sweep.starts.get(self.point.start)?;
            let settled = |start| Orbit::settled(&machine, start, evaluator.sweep.discard).ok();
            settled(&seed).filter(is_attractor).or_else(|| settled(own).filter(is_attractor))
        })?;
        (self.seed, self.periods, self.period) = (found.start(), found.word().periods, period);
        Some(found)
    }

    /// The signed measure with its derivatives with respect to given parameters.
    fn slope(
        &mut self,
        evaluator: &Evaluator,
        (values, place): (&[f64], &[f64]),
        names: &[String],
    ) -> Option<Slope> {
        let signed = &evaluator.sweep.measures[self.point.measure];
        let orbit = self.orbit(evaluator, values, place)?;
        let value = signed.sign() * orbit.measure(&signed.measure).ok()?;
        let by = orbit.gradient_by(&signed.measure, names).ok()?;
        let gradient = by.into_iter().map(|own| Some(signed.sign() * own.derivative.ok()?));
        Some(Slope { value, gradient: gradient.collect::<Option<_>>()? })
    }

    /// Moves the point towards the nearby peak of the band. `None` if the point has no bracket, or
    /// if an orbit or its derivative is missing on the way; the point then stays at the last place
    /// with both.
    fn climb(&mut self, evaluator: &Evaluator, values: &[f64]) -> Option<()> {
        let (axis, low, high) = self.point.bracket.filter(|own| own.1 < own.2)?;
        let name = [evaluator.sweep.over[axis].name.clone()];
        let at = |own: &mut Self, x: f64| {
            let mut place = own.point.place.clone();
            place[axis] = x;
            let slope = own.slope(evaluator, (values, &place), &name)?;
            own.point.place = place;
            Some(slope.gradient[0])
        };
        let mut before = self.point.place[axis];
        let mut slope_before = at(self, before)?;
        let end = |slope: f64| if slope > 0.0 { high } else { low };
        let mut x = before + FIRST * (end(slope_before) - before);
        for _ in 0..STEPS {
            if (x - before).abs() <= FOUND * (high - low) {
                break;
            }
            let slope = at(self, x)?;
            let curvature = (slope - slope_before) / (x - before);
            // If the curve is not concave, the secant leads away from the peak.
            let next = if curvature < 0.0 { x - slope / curvature } else { 0.5 * (x + end(slope)) };
            (before, slope_before, x) = (x, slope, next.clamp(low, high));
        }
        Some(())
    }

    /// The signed measure at the peak near the point.
    pub fn peak(&mut self, evaluator: &Evaluator, values: &[f64]) -> Option<f64> {
        self.climb(evaluator, values);
        let place = self.point.place.clone();
        Some(self.slope(evaluator, (values, &place), &[])?.value)
    }

    /// The measure at the point, with its derivatives with respect to the varied parameters.
    pub fn at(&mut self, evaluator: &Evaluator, values: &[f64]) -> Option<Slope> {
        let (names, place) = (evaluator.request.names(), self.point.place.clone());
        let mut slope = self.slope(evaluator, (values, &place), &names)?;
        if let Some(k) = evaluator.sweep.over.iter().position(|axis| axis.name == TOLERANCE) {
            let factors = evaluator.candidate.factors(place[k]);
            slope.gradient.iter_mut().zip(factors).for_each(|(slope, factor)| *slope *= factor);
        }
        Some(slope)
    }
}
