//! Derivatives of the motion at a point: with respect to time, for quadrature, and with respect to
//! states and forces.

use super::values::{OutputValues, coupling_force};
use vibro_impact::flow::Series;
use vibro_impact::model::{
    Acceleration, Augmented, BOX_RATE, COORDINATES, Model, RELATIVE, RELATIVE_RATE, SECONDARY_RATE,
    SmoothMode,
};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, ImpactRecord, State};

/// v1 and v3 with three derivatives each.
pub(crate) type Velocities = [[f64; 4]; 2];

/// v1 and v3 with three derivatives at one point; `slope` is the time derivative of the forces.
pub(crate) fn velocities(
    model: &Model,
    mode: SmoothMode,
    z: &Augmented,
    forces: [f64; 3],
    slope: [f64; 3],
) -> Velocities {
    let forces = std::array::from_fn(|i| [forces[i], slope[i], 0.0, 0.0]);
    let series = Series::<4>::expand(model, mode, z, Some(&forces), 1.0 / model.rate);
    let rate = model.rate;
    let scale = [1.0, rate, 2.0 * rate * rate, 6.0 * rate * rate * rate]; // k!/r^k
    [BOX_RATE, SECONDARY_RATE].map(|rate| std::array::from_fn(|k| series.states[k][rate] * scale[k]))
}

/// Integral over an interval of length h from the values and three derivatives at its ends.
pub(crate) fn quadrature(h: f64, a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let h2 = h * h;
    h * (0.5 * (a[0] + b[0])
        + h * (3.0 / 28.0) * (a[1] - b[1])
        + h2 / 84.0 * (a[2] + b[2])
        + h2 * h / 1680.0 * (a[3] - b[3]))
}

/// A direction in the space of a host's knowns: states, loads, parameters, time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction {
    pub(crate) state: State,
    pub(crate) forces: [f64; 3],
    pub(crate) parameters: Parameters,
    pub(crate) time: f64,
}

impl Direction {
    /// Variation of the forces on the bodies at a state and a drive with the given sin θ and cos
    /// θ, without the part from the variation of the state. A change of the drive's frequency
    /// keeps the phase continuous, so it does not change the present forces.
    fn push(&self, p: &Parameters, State { x, v }: &State, (sin, cos): (f64, f64)) -> [f64; 3] {
        let (d, stretch) = (&self.parameters, x[1] - x[2]);
        let turn = d.drive_phase + p.drive_frequency * self.time;
        let drive = d.drive_amplitude * sin + p.drive_amplitude * cos * turn;
        [
            self.forces[0] + drive - d.box_stiffness * x[0] - d.box_damping * v[0],
            self.forces[1] - d.coupling_stiffness * stretch,
            self.forces[2] + d.coupling_stiffness * stretch
                - d.secondary_stiffness * x[2]
                - d.secondary_damping * v[2],
        ]
    }
}

/// Variation of the outputs with states, loads, tunable parameters and time in a given contact.
/// All outputs are linear in states and forces, except the mechanical energy, for which the
/// gradient is used. Accumulated energies do not vary, with one exception: the energy that a
/// change of a spring adds immediately counts as input.
pub(crate) fn variation(
    model: &Model,
    p: &Parameters,
    contact: Contact,
    state: &State,
    drive: (f64, f64),
    along: &Direction,
) -> OutputValues {
    let (dx, d) = (&along.state, &along.parameters);
    let df = along.push(p, state, drive);
    let mut z = [0.0; COORDINATES];
    z[..6].copy_from_slice(&dx.to_relative());
    let mode = contact.mode();
    let Acceleration { coordinates: a, free } = model.acceleration(mode, &z, Some(df));
    let (x, v) = (&state.x, &state.v);
    let (relative, contact_force) = match contact {
        Contact::Flight => ((z[RELATIVE], z[RELATIVE_RATE]), 0.0),
        contact => ((0.0, 0.0), model.reduced_mass * contact.side() * free),
    };
    let mechanical = p.box_mass * v[0] * dx.v[0]
        + p.block_mass * v[1] * dx.v[1]
        + p.secondary_mass * v[2] * dx.v[2]
        + p.box_stiffness * x[0] * dx.x[0]
        + p.secondary_stiffness * x[2] * dx.x[2]
        + p.coupling_stiffness * (x[1] - x[2]) * (dx.x[1] - dx.x[2]);
    let stretch = x[1] - x[2];
    let springs = 0.5
        * (d.box_stiffness * x[0] * x[0]
            + d.secondary_stiffness * x[2] * x[2]
            + d.coupling_stiffness * stretch * stretch);
    // The indicators are linear; indicators unused in this contact do not vary.
    let indicators = match contact {
        Contact::Flight => [-z[RELATIVE] / model.gap, z[RELATIVE] / model.gap, 0.0],
        contact => {
            let scale = (model.k1 + model.k2) * model.gap + model.drive.abs();
            let pressing = contact.side() * free;
            [0.0, 0.0, if scale > 0.0 { pressing / scale } else { pressing }]
        }
    };
    OutputValues {
        time: along.time,
        x: dx.x,
        v: dx.v,
        acceleration: [a[0], a[0] + a[1], a[2]],
        relative,
        contact_force,
        coupling_force: coupling_force(p, &dx.x) + d.coupling_stiffness * stretch,
        indicators,
        mechanical: mechanical + springs,
        input: springs,
        damped: 0.0,
        // Values that change at events only do not have a rate.
        impact_loss: 0.0,
        contact,
        impacts: ImpactRecord::default(),
    }
}
