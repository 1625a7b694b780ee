//! Values of the outputs: the motion at the present time, as plain numbers or as numbers with a
//! variation.

use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul, Neg, Sub};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, EnergyAccounts, ImpactRecord, Simulator, State};

/// A number and its first-order variation along a direction of states and loads. The expression of
/// an output is evaluated unchanged on such numbers; a product varies by the product rule.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Varied {
    /// The value.
    pub value: f64,
    /// Its derivative along the direction.
    pub rate: f64,
}

impl Add for Varied {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, rate: self.rate + other.rate }
    }
}

impl Sub for Varied {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, rate: self.rate - other.rate }
    }
}

impl Mul for Varied {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let rate = self.rate * other.value + self.value * other.rate;
        Self { value: self.value * other.value, rate }
    }
}

impl Neg for Varied {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, rate: -self.rate }
    }
}

/// Quantities of the motion that determine the outputs. `T` is `f64`, or [`Varied`] for
/// directional derivatives. A quantity that changes at events only is always a plain number, since
/// it does not vary between events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutputValues<T = f64> {
    /// Time, s.
    pub time: T,
    /// Displacements of box, block and secondary oscillator, m.
    pub x: [T; 3],
    /// Their velocities, m/s.
    pub v: [T; 3],
    /// Their accelerations, m/s².
    pub acceleration: [T; 3],
    /// Relative displacement w (m) and velocity w' (m/s) of block and box.
    pub relative: (T, T),
    /// Contact force in rest, N: never negative, and exactly 0 in flight.
    pub contact_force: T,
    /// Force in the coupling spring, N.
    pub coupling_force: T,
    /// Event indicators, dimensionless: distances to the upper and the lower stop, and the
    /// acceleration that presses the block on the stop in rest.
    pub indicators: [T; 3],
    /// Kinetic and elastic energy, J.
    pub mechanical: T,
    /// Work of drive and loads since the start, J.
    pub input: T,
    /// Energy dissipated in the dampers since the start, J.
    pub damped: T,
    /// Energy lost at impacts since the start, J.
    pub impact_loss: f64,
    /// Flight or rest.
    pub contact: Contact,
    /// Impacts so far.
    pub impacts: ImpactRecord,
}

/// The next event up to a horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Time of the event, s, or the horizon without an event.
    pub time: f64,
    /// Whether there is an event.
    pub known: bool,
}

/// Derivatives of the state at the end of a step, in the order of
/// [`STATES`](super::structure::STATES). The default holds for a step of length zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepMatrices {
    /// Derivatives with respect to the state at the step's beginning.
    pub transition: [[f64; 6]; 6],
    /// Derivatives with respect to the load on each body: its value and derivatives 1 to 3 at the
    /// step's beginning.
    pub response: [[f64; 12]; 6],
}

impl Default for StepMatrices {
    fn default() -> Self {
        let mut transition = [[0.0; 6]; 6];
        for (i, row) in transition.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        Self { transition, response: [[0.0; 12]; 6] }
    }
}

/// The clock of impacts, and the impact at its last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tick {
    /// Whether the clock ticks now.
    pub active: bool,
    /// Time of the impact, s.
    pub time: f64,
    /// Its impulse, N·s.
    pub impulse: f64,
    /// Relative speed of approach, m/s.
    pub speed: f64,
    /// Its stop: +1 upper, -1 lower, 0 before the first impact.
    pub side: i8,
}

/// Value of an indicator whose event cannot occur in the present contact.
const IDLE: f64 = 1.0;

/// Quantities that determine the event indicators.
pub(crate) struct Approach {
    /// L, m.
    pub gap: f64,
    /// The relative displacement, m.
    pub w: f64,
    /// The free relative acceleration that presses the block on the stop, m/s².
    pub pressing: f64,
    /// k1/m1 + k23/m2, 1/s².
    pub spring: f64,
    /// F10/m1, m/s².
    pub drive: f64,
}

impl Approach {
    /// Computes the quantities; `w` is the relative displacement, `contact_force` in N.
    pub(crate) fn new(p: &Parameters, w: f64, contact_force: f64) -> Self {
        Self {
            gap: p.stop_gap,
            w,
            pressing: contact_force * (1.0 / p.box_mass + 1.0 / p.block_mass),
            spring: p.box_stiffness / p.box_mass + p.coupling_stiffness / p.block_mass,
            drive: p.drive_amplitude / p.box_mass,
        }
    }

    /// The event indicators. In flight: the distances to the upper and lower stop, in gaps. In
    /// rest: the free relative acceleration that presses the block on the stop, in units of the
    /// largest acceleration by springs and drive at a displacement of one gap.
    pub(crate) fn indicators(&self, contact: Contact) -> [f64; 3] {
        let Self { gap, w, pressing, spring, drive } = *self;
        match contact {
            Contact::Flight => [(gap - w) / gap, (gap + w) / gap, IDLE],
            Contact::RestUpper | Contact::RestLower => {
                let scale = spring * gap + drive.abs();
                [IDLE, IDLE, if scale > 0.0 { pressing / scale } else { pressing }]
            }
        }
    }
}
/// Force in the coupling spring, k23 (x2 - x3), N.
pub(crate) fn coupling_force(p: &Parameters, x: &[f64; 3]) -> f64 {
    p.coupling_stiffness * (x[1] - x[2])
}

impl OutputValues {
    /// Values of the present state of a simulator.
    pub fn of(simulator: &Simulator) -> Self {
        let State { x, v } = simulator.state();
        let EnergyAccounts { mechanical, input, damped, impact } = simulator.energy_accounts();
        let (contact, relative) = (simulator.contact(), simulator.relative_motion());
        let contact_force = simulator.contact_force();
        Self {
            time: simulator.time(),
            x,
            v,
            acceleration: simulator.acceleration(),
            relative,
            contact_force,
            coupling_force: coupling_force(simulator.parameters(), &x),
            indicators: Approach::new(simulator.parameters(), relative.0, contact_force).indicators(contact),
            mechanical,
            input,
            damped,
            impact_loss: impact,
            contact,
            impacts: *simulator.impacts(),
        }
    }

    /// Whether every number is finite, without a branch for each number: 0 times a number that is
    /// not finite is NaN.
    pub(crate) fn is_finite(&self) -> bool {
        let impacts = &self.impacts;
        let lists = [self.x, self.v, self.acceleration, self.indicators];
        let last = [impacts.last_time, impacts.last_impulse, impacts.last_speed];
        let sums = [impacts.total_impulse, impacts.box_impulse];
        let forces = [self.time, self.relative.0, self.relative.1, self.contact_force, self.coupling_force];
        let energies = [self.mechanical, self.input, self.damped, self.impact_loss];
        let numbers = lists.iter().flatten().chain(&last).chain(&sums).chain(&forces).chain(&energies);
        numbers.map(|number| number * 0.0).sum::<f64>() == 0.0
    }

    /// Displacements and velocities.
    pub fn state(&self) -> State {
        State { x: self.x, v: self.v }
    }

    /// Each value together with its rate. Values that change at events only come from `self`.
    pub fn varied(&self, rate: &Self) -> OutputValues<Varied> {
        self.with(rate, |value, rate| Varied { value, rate })
    }
}

impl<T: Copy> OutputValues<T> {
    /// Combines each value with the value of `other` by `f`. Values that change at events only
    /// come from `self`.
    pub(crate) fn with<U: Copy, V>(&self, other: &OutputValues<U>, f: impl Fn(T, U) -> V) -> OutputValues<V> {
        let three = |own: [T; 3], other: [U; 3]| std::array::from_fn(|i| f(own[i], other[i]));
        OutputValues {
            time: f(self.time, other.time),
            x: three(self.x, other.x),
            v: three(self.v, other.v),
            acceleration: three(self.acceleration, other.acceleration),
            relative: (f(self.relative.0, other.relative.0), f(self.relative.1, other.relative.1)),
            contact_force: f(self.contact_force, other.contact_force),
            coupling_force: f(self.coupling_force, other.coupling_force),
            indicators: three(self.indicators, other.indicators),
            mechanical: f(self.mechanical, other.mechanical),
            input: f(self.input, other.input),
            damped: f(self.damped, other.damped),
            impact_loss: self.impact_loss,
            contact: self.contact,
            impacts: self.impacts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_variation_of_a_polynomial() {
        // f(a, b) = a b - a + b² at (3, 2) along (1, 5): df = (b - 1) da + (a + 2 b) db
        let (a, b) = (Varied { value: 3.0, rate: 1.0 }, Varied { value: 2.0, rate: 5.0 });
        let f = a * b + -a + b * b;
        assert_eq!(f, Varied { value: 7.0, rate: 36.0 });
        assert_eq!(f - a, Varied { value: 4.0, rate: 35.0 });
    }
}
