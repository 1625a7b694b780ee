//! The places of the three bodies to which the states of an orbit refer: where springs hold constant loads, docs/theory.md (99), unless
//! that is far beyond the stops, and then places near each other, at which the loads push.

use super::system::{Anchor, ConstantLoads};
use vibro_analysis::Result;
use vibro_impact::parameters::{LOADS, Parameters};
use vibro_impact::steady::exact_orbit::Vector6;

/// Displacement of the block in the box, units of L, beyond which states refer to places near each other. Two digits are lost by then,
/// and no motion without impacts keeps within the stops.
const FAR: f64 = 100.0;

/// Places of the bodies, units of L, and what pushes them there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    /// Those to which states refer.
    pub places: [f64; 3],
    /// The constant part of the rate of a state there, d of docs/theory.md (111).
    pub push: Vector6,
    /// Where the springs hold the loads; a block without a spring in the middle of the box.
    held: [f64; 3],
}

impl Balance {
    /// Displacement of the block in the box where the springs hold the loads.
    pub fn offset(&self) -> f64 {
        self.held[1] - self.held[0]
    }

    /// The same loads with states that refer to where the springs hold them.
    pub fn at_rest(self) -> Self {
        if self.places == self.held {
            self
        } else {
            Self { places: self.held, push: Vector6::zeros(), ..self }
        }
    }
}

/// The places for a machine under loads.
///
/// # Errors
/// A load that is not finite, or on what no spring holds.
pub(super) fn balance(p: &Parameters, loads: ConstantLoads) -> Result<Balance> {
    let held = rest(p, loads)?;
    let anchor = Anchor::of(std::iter::once(p)).filter(|_| (held[1] - held[0]).abs() > FAR);
    let places = anchor.map_or(held, |anchor| near(p, loads, held, anchor));
    let acceleration = |force: f64, mass: f64| force / (mass * p.stop_gap * p.drive_frequency.powi(2));
    let [f1, f2, f3] = loads.forces;
    let mut push = Vector6::zeros();
    if anchor.is_some() {
        let [x1, x2, x3] = places.map(|x| x * p.stop_gap);
        let coupling = p.coupling_stiffness * (x2 - x3);
        push[3] = acceleration(f1 - p.box_stiffness * x1, p.box_mass);
        push[4] = acceleration(f2 - coupling, p.block_mass);
        push[5] = acceleration(f3 + coupling - p.secondary_stiffness * x3, p.secondary_mass);
    } else if p.coupling_stiffness == 0.0 {
        push[4] = acceleration(f2, p.block_mass);
    }
    Ok(Balance { places, push, held })
}

/// Places near each other at which all bodies are in balance but those that a spring hardly holds.
fn near(p: &Parameters, loads: ConstantLoads, [x1, x2, x3]: [f64; 3], anchor: Anchor) -> [f64; 3] {
    let [_, f2, f3] = loads.forces.map(|force| force / p.stop_gap);
    let (coupling, ground) = (p.coupling_stiffness, p.secondary_stiffness);
    match anchor {
        Anchor::Box => [x2, x2, x3],
        Anchor::Block => [x1, x1, (f3 + coupling * x1) / (coupling + ground)],
        Anchor::Pair => [x1, x1, x1 - f2 / coupling],
    }
}

/// The displacements at which the springs hold the loads, units of L: docs/theory.md (99).
fn rest(p: &Parameters, loads: ConstantLoads) -> Result<[f64; 3]> {
    let [f1, f2, f3] = loads.forces;
    for (field, value) in LOADS.iter().zip(loads.forces) {
        if !value.is_finite() {
            let name = field.name;
            let error = vibro_impact::Error::OutOfRange { name, value, allowed: "a finite number" };
            return Err(error.into());
        }
    }
    let held = |name, load: f64, stiffness: f64, allowed| {
        if load == 0.0 {
            Ok(0.0)
        } else if stiffness > 0.0 {
            Ok(load / stiffness)
        } else {
            let needed_by = "orbit under a constant load";
            Err(vibro_impact::Error::Undefined { name, value: stiffness, needed_by, allowed })
        }
    };
    let x1 = held("box.k", f1, p.box_stiffness, "box.k > 0, or load.box = 0")?;
    let third = |load, allowed| held("secondary.k", load, p.secondary_stiffness, allowed);
    let x = if p.coupling_stiffness == 0.0 {
        [x1, x1, third(f3, "secondary.k > 0, or load.secondary = 0")?]
    } else {
        let x3 = third(f2 + f3, "secondary.k > 0, or load.block + load.secondary = 0")?;
        [x1, x3 + f2 / p.coupling_stiffness, x3]
    };
    Ok(x.map(|x| x / p.stop_gap))
}
