//! Jets (truncated Taylor series in time) of the quantities that outputs read, within a smooth
//! piece of the motion. Jets are added, subtracted and multiplied like numbers (products by
//! Leibniz' rule), so that each output is evaluated on jets as it is on numbers.

use super::values::OutputValues;
use std::ops::{Add, Mul, Neg, Sub};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Contact;

/// A value with its time derivatives 1 to 3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet(pub [f64; 4]);

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[0] * b[2] + 2.0 * (a[1] * b[1]) + a[2] * b[0],
            a[0] * b[3] + 3.0 * (a[1] * b[2] + a[2] * b[1]) + a[3] * b[0],
        ])
    }
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Jet {
    fn times(self, factor: f64) -> Self {
        Self(self.0.map(|x| factor * x))
    }

    /// The integral whose time derivative is `self`, with the given value.
    fn integral(self, value: f64) -> Self {
        let [first, second, third, _] = self.0;
        Self([value, first, second, third])
    }
}

/// A motion at one time, with its time derivatives.
pub(crate) struct MotionJet<'a> {
    pub(crate) values: &'a OutputValues,
    /// Time derivatives of the displacements, `[body][order]`.
    pub(crate) motion: &'a [[f64; 6]; 3],
    pub(crate) parameters: &'a Parameters,
    /// The loads with their derivatives, `[body][order]`.
    pub(crate) loads: &'a [[f64; 4]; 3],
    /// Phase of the drive, rad.
    pub(crate) theta: f64,
}

/// Jets of the quantities that outputs read. The event indicators are left out, since they are not
/// outputs.
pub(crate) fn jets(course: &MotionJet<'_>) -> OutputValues<Jet> {
    let MotionJet { values, motion, parameters: p, loads, theta } = course;
    let body = |order: usize| {
        let of = |b: usize| Jet(std::array::from_fn(|k| motion[b][order + k]));
        [of(0), of(1), of(2)]
    };
    let (x, v, acceleration) = (body(0), body(1), body(2));
    let load = loads.map(Jet);
    let coupling_force = (x[1] - x[2]).times(p.coupling_stiffness);
    let mut contact_force = Jet::default();
    if values.contact != Contact::Flight {
        // Force of the block on the stop: load and coupling force, less the force that accelerates
        // the block with the box.
        let push = load[1] - coupling_force - acceleration[1].times(p.block_mass);
        contact_force = push.times(values.contact.side());
        contact_force.0[0] = values.contact_force;
    }
    let energy = |mass: f64, v: Jet| (v * v).times(0.5 * mass);
    let stretch = x[1] - x[2];
    let mechanical = energy(p.box_mass, v[0])
        + energy(p.block_mass, v[1])
        + energy(p.secondary_mass, v[2])
        + energy(p.box_stiffness, x[0])
        + energy(p.secondary_stiffness, x[2])
        + energy(p.coupling_stiffness, stretch);
    let power = (drive(p, *theta) + load[0]) * v[0] + load[1] * v[1] + load[2] * v[2];
    let damping = (v[0] * v[0]).times(p.box_damping) + (v[2] * v[2]).times(p.secondary_damping);
    OutputValues {
        time: Jet([values.time, 1.0, 0.0, 0.0]),
        x,
        v,
        acceleration,
        relative: (x[1] - x[0], v[1] - v[0]),
        contact_force,
        coupling_force,
        indicators: [Jet::default(); 3],
        mechanical,
        input: power.integral(values.input),
        damped: damping.integral(values.damped),
        impact_loss: values.impact_loss,
        contact: values.contact,
        impacts: values.impacts,
    }
}

impl OutputValues<Jet> {
    /// First-order change of all values in a short time; values that change at events only do not
    /// change.
    pub(crate) fn rates(&self, time: f64) -> OutputValues {
        self.with(self, |jet, _| time * jet.0[1])
    }
}

/// The drive's force F10 sin θ.
fn drive(p: &Parameters, theta: f64) -> Jet {
    let (sin, cos) = theta.sin_cos();
    let (a, w) = (p.drive_amplitude, p.drive_frequency);
    Jet([a * sin, a * w * cos, -a * w * w * sin, -a * w * w * w * cos])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_derivatives_of_a_product() {
        // f = t³ (2 - t) at t = 1: 1, 2, 0, -12
        let t = Jet([1.0, 1.0, 0.0, 0.0]);
        let two = Jet([2.0, 0.0, 0.0, 0.0]);
        assert_eq!(t * t * t * (two + -t), Jet([1.0, 2.0, 0.0, -12.0]));
        assert_eq!((t * t - t), Jet([0.0, 1.0, 2.0, 0.0]));
    }
}
