//! The machine in the units of an orbit: lengths in L, the drive's phase as time (docs/theory.md, sections 9 and 14).

use crate::error::Result;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use vibro_impact::State;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Loads;
use vibro_impact::steady::exact_orbit::{Flight, Vector6};

/// Loads on box, block and secondary oscillator that do not change, N: gravity, the tilt of the machine, a gap off its centre.
///
/// They act on impacts through one number, the displacement w_s of the block in the box that they cause without impacts
/// (docs/theory.md (100)). A gap whose middle lies b above the centre is the machine under the loads (0, -k23 b, k23 b),
/// docs/theory.md (97).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConstantLoads {
    /// On the box, the block and the secondary oscillator.
    pub forces: [f64; 3],
}

impl ConstantLoads {
    /// Names of the three, in order.
    pub const NAMES: [&str; 3] = ["load.box", "load.block", "load.secondary"];

    /// None.
    pub const NONE: Self = Self { forces: [0.0; 3] };

    /// The same as loads of the simulator.
    pub fn loads(&self) -> Loads {
        Loads { derivatives: self.forces.map(|f| [f, 0.0, 0.0, 0.0]) }
    }
}

/// A machine with its constant loads, prepared for orbits. Lengths are in L and a prime is a derivative with respect to the
/// drive's phase, so that its period is 2π.
#[derive(Clone, Copy, Debug)]
pub struct System {
    parameters: Parameters,
    loads: ConstantLoads,
    pub(super) flight: Flight,
    /// H of docs/theory.md (71): without impacts the box swings as Im(H e^{iφ}).
    response: Complex<f64>,
    /// Where the loads hold the three bodies.
    rest: [f64; 3],
    /// Changes of v1 and v2 at an impact per unit of w'⁻, docs/theory.md (27).
    kick: [f64; 2],
}

impl System {
    /// A machine under its drive alone.
    ///
    /// # Errors
    /// As [`Flight::new`], and for an undamped box at resonance.
    pub fn new(parameters: &Parameters) -> Result<Self> {
        Self::with_loads(parameters, ConstantLoads::NONE)
    }

    /// A machine under constant loads, to which those of its parameters add.
    ///
    /// # Errors
    /// As [`new`](Self::new); a load that no spring holds or that is not finite.
    pub fn with_loads(parameters: &Parameters, loads: ConstantLoads) -> Result<Self> {
        let forces = std::array::from_fn(|body| loads.forces[body] + parameters.constant_loads[body]);
        let loads = ConstantLoads { forces };
        let parameters = &Parameters { constant_loads: [0.0; 3], ..*parameters };
        let flight = Flight::new(parameters)?;
        let response = flight.harmonic(parameters)?;
        let k = (1.0 + flight.kappa) / (1.0 + flight.epsilon);
        let rest = rest(parameters, loads)?;
        Ok(Self { parameters: *parameters, loads, flight, response, rest, kick: [k * flight.epsilon, -k] })
    }

    /// The machine's parameters, without its [loads](Self::loads).
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Its loads.
    pub fn loads(&self) -> ConstantLoads {
        self.loads
    }

    /// w_s, the displacement of the block in the box that the loads cause without impacts, units of L.
    pub fn offset(&self) -> f64 {
        self.rest[1] - self.rest[0]
    }

    /// Whether the mirror image of a motion is one too: without loads.
    pub fn is_symmetric(&self) -> bool {
        self.loads == ConstantLoads::NONE
    }

    /// |H|, the amplitude of the block in the box without impacts, units of L.
    pub fn amplitude(&self) -> f64 {
        self.response.norm()
    }

    /// Amplitude and angle of the gap's motion without impacts, `offset + amplitude sin(φ + angle)`.
    pub(super) fn wave(&self) -> (f64, f64) {
        (self.response.norm(), (-self.response).arg())
    }

    /// The gap w, its rate w' and w'' of the motion without impacts at a phase.
    pub(super) fn forced_gap(&self, phase: f64) -> [f64; 3] {
        let turned = -self.response * Complex::cis(phase);
        [turned.im + self.offset(), turned.re, -turned.im]
    }

    /// The motion without impacts at a phase.
    pub(super) fn forced(&self, phase: f64) -> Vector6 {
        let turned = self.response * Complex::cis(phase);
        let [x1, x2, x3] = self.rest;
        Vector6::new(x1 + turned.im, x2, x3, turned.re, 0.0, 0.0)
    }

    /// The rest positions under the loads.
    pub(super) fn rest_positions(&self) -> [f64; 3] {
        self.rest
    }

    /// A z: the rate of the free part of a state in flight.
    pub(super) fn rate(&self, z: &Vector6) -> Vector6 {
        let [a1, a2, a3] = self.flight.accelerations(z, 0.0);
        Vector6::new(z[3], z[4], z[5], a1, a2, a3)
    }

    /// The impact law J of docs/theory.md (27), with the rate `forced` of the gap that is not part of `z`.
    pub(super) fn strike(&self, z: &Vector6, forced: f64) -> Vector6 {
        let rate = z[4] - z[3] + forced;
        let mut after = *z;
        after[3] += self.kick[0] * rate;
        after[4] += self.kick[1] * rate;
        after
    }

    /// A state in units of L and ω1 L in SI units.
    pub(super) fn si(&self, y: &Vector6) -> State {
        let length = self.parameters.stop_gap;
        let speed = length * self.parameters.drive_frequency;
        State { x: [0, 1, 2].map(|i| length * y[i]), v: [3, 4, 5].map(|i| speed * y[i]) }
    }

    /// The parameter that makes the periodic response to impulses singular, with its value: the motion without impacts then has
    /// a neutral direction.
    pub(super) fn neutral_parameter(&self) -> (&'static str, f64, &'static str) {
        let p = &self.parameters;
        let damped = "a value > 0, since without it an undamped mode is in resonance with the orbit";
        if p.coupling_stiffness == 0.0 {
            ("coupling.k", 0.0, "a value > 0, since a block without a spring has no place of its own")
        } else if p.box_stiffness == 0.0 {
            ("box.k", 0.0, "a value > 0, since a box without a spring has no place of its own")
        } else if p.box_damping == 0.0 {
            ("box.c", 0.0, damped)
        } else if p.secondary_damping == 0.0 {
            ("secondary.c", 0.0, damped)
        } else {
            ("drive.frequency", p.drive_frequency, "a value away from the resonance of a hardly damped mode")
        }
    }
}

/// The displacements at which the springs hold the loads, units of L: docs/theory.md (99).
fn rest(p: &Parameters, loads: ConstantLoads) -> Result<[f64; 3]> {
    let [f1, f2, f3] = loads.forces;
    for (name, value) in ConstantLoads::NAMES.into_iter().zip(loads.forces) {
        if !value.is_finite() {
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
    let x3 = held(
        "secondary.k",
        f2 + f3,
        p.secondary_stiffness,
        "secondary.k > 0, or load.block + load.secondary = 0",
    )?;
    let stretch = held("coupling.k", f2, p.coupling_stiffness, "coupling.k > 0, or load.block = 0")?;
    Ok([x1, x3 + stretch, x3].map(|x| x / p.stop_gap))
}
