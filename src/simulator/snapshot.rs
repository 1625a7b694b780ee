//! Snapshots: the state of a simulator as plain data, for restoring it.

use super::departure::Departure;
use super::limits::{check_constant_forces, check_contact, check_time};
use super::{HybridState, Simulator};
use crate::error::{Error, Result};
use crate::flow::{shifted, substep};
use crate::model::{Model, RELATIVE};
use crate::parameters::Parameters;
use serde::{Deserialize, Serialize};
use vibro_numerics::double_double::DoubleDouble;

/// Everything that changes as the simulator advances, with its parameters, as plain data. A motion
/// restored from it continues bit-identically.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    parameters: Parameters,
    hybrid: HybridState,
}

/// Largest number in a state; above it the squares in energies overflow. An allowed start leads to
/// such displacements and speeds only if loads drive the motion for 1e8 of its time constants, or
/// stay in force for a machine for which they would be refused.
const MAX_NUMBER: f64 = 1e150;

impl Simulator {
    /// Snapshot of the present point of the motion.
    #[inline]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot { parameters: self.parameters, hybrid: self.hybrid }
    }

    /// Overwrites `snapshot` with the present point of the motion, without an intermediate copy.
    #[inline]
    pub fn snapshot_into(&self, snapshot: &mut Snapshot) {
        snapshot.parameters = self.parameters;
        snapshot.hybrid = self.hybrid;
    }

    /// Restores a snapshot, its parameters included. The motion continues bit-identical to the
    /// original one.
    ///
    /// # Errors
    /// As [`new`](Self::new) if parameters or state are invalid (a foreign or damaged snapshot);
    /// nothing has changed then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        let hybrid = snapshot.hybrid;
        let finite = |e: &DoubleDouble| e.hi.is_finite() && e.lo.is_finite();
        let record = [hybrid.record.last_time, hybrid.record.last_impulse, hybrid.record.last_speed];
        let numbers = hybrid.y.iter().chain(hybrid.loads.iter().flatten()).chain(&record);
        let sums_of_impulses = [&hybrid.record.total_impulse, &hybrid.record.box_impulse];
        let plain = numbers.chain(sums_of_impulses).all(|x| x.is_finite());
        let sums = [&hybrid.sums.input, &hybrid.sums.damped, &hybrid.sums.impact].into_iter().all(finite);
        if !(plain && sums && finite(&hybrid.time) && finite(&hybrid.loads_from) && hybrid.phase.is_sound()) {
            return Err(Error::OutOfRange { name: "snapshot", value: f64::NAN, allowed: "finite numbers" });
        }
        if let Some(&value) = hybrid.y.iter().find(|x| x.abs() > MAX_NUMBER) {
            return Err(Error::OutOfRange { name: "snapshot", value, allowed: "states up to 1e150" });
        }
        let gap = snapshot.parameters.stop_gap;
        if hybrid.y[1].abs() > gap {
            return Err(Error::Penetration { value: hybrid.y[1], gap });
        }
        check_contact(&hybrid, gap)?;
        if snapshot.parameters != self.parameters {
            let model = Model::new(&snapshot.parameters)?;
            check_motion(&model, &hybrid)?;
            self.hybrid = hybrid;
            self.install(&snapshot.parameters, model);
        } else {
            check_motion(&self.model, &hybrid)?;
            self.hybrid = hybrid;
            self.prepare_load_tables();
        }
        Ok(())
    }
}

/// Checks time, departure, drive and loads of a snapshot against the limits of a machine.
fn check_motion(model: &Model, hybrid: &HybridState) -> Result<()> {
    check_time(model.rate, hybrid.time.value())?;
    check_constant_forces(model)?;
    check_departure(model, hybrid)?;
    let loads = shifted(&hybrid.loads, hybrid.time.minus(hybrid.loads_from).value());
    for derivatives in loads {
        let mut most = MAX_NUMBER;
        for value in derivatives {
            if value.is_nan() || value.abs() > most {
                let allowed = "loads up to 1e150, also for their derivatives over the fastest rate";
                return Err(Error::OutOfRange { name: "snapshot", value, allowed });
            }
            most *= model.rate;
        }
    }
    Ok(())
}

/// Checks that the state of a snapshot can have come from its departure.
fn check_departure(model: &Model, hybrid: &HybridState) -> Result<()> {
    let Some(Departure { time, z, gained }) = hybrid.departure else { return Ok(()) };
    let since = hybrid.time.minus(time).value();
    let sound = z.iter().all(|x| x.abs() <= MAX_NUMBER) && gained.iter().all(|energy| energy.is_finite());
    let fits =
        hybrid.departing > 0 && z[RELATIVE] == hybrid.y[RELATIVE] && (0.0..substep(model)).contains(&since);
    if sound && fits {
        return Ok(());
    }
    let allowed = "0 to a sub-step, from a state at the same stop";
    Err(Error::OutOfRange { name: "snapshot: time since departure", value: since, allowed })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::State;

    #[test]
    fn a_snapshot_whose_energies_would_overflow_is_refused() {
        let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
        let sound = simulator.snapshot();
        for coordinate in [0, 2, 3, 4, 5] {
            let mut damaged = sound;
            damaged.hybrid.y[coordinate] = -1e160;
            let refused = simulator.restore(&damaged);
            assert!(
                matches!(refused, Err(Error::OutOfRange { name: "snapshot", value: -1e160, .. })),
                "{refused:?}"
            );
            assert_eq!(simulator.snapshot(), sound);
        }
    }

    #[test]
    fn a_snapshot_whose_departure_is_another_ones_is_refused() {
        let p = Parameters { stop_restitution: 0.5, ..Parameters::default() };
        let start = State { x: [0.0, p.stop_gap, 0.0], v: [0.0, -1.0, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.advance_to(1e-20).unwrap();
        let sound = simulator.snapshot();
        assert!(sound.hybrid.departure.is_some());
        simulator.restore(&sound).unwrap();
        let damages: [fn(&mut Departure); 6] = [
            |departure| departure.time.hi = 1.0,
            |departure| departure.time.hi = -1e3,
            |departure| departure.time.lo = f64::NAN,
            |departure| departure.z[1] = -departure.z[1],
            |departure| departure.z[7] = f64::NAN,
            |departure| departure.gained[1] = f64::INFINITY,
        ];
        for damage in damages {
            let mut damaged = sound;
            damage(damaged.hybrid.departure.as_mut().unwrap());
            let refused = simulator.restore(&damaged);
            assert!(matches!(refused, Err(Error::OutOfRange { .. })), "{refused:?}");
            assert_eq!(simulator.snapshot(), sound);
        }
    }

    /// Energies are of the size of squared speeds and may exceed the limit on a speed.
    #[test]
    fn a_departure_of_a_fast_machine_is_restored() {
        let p = Parameters { stop_gap: 1e90, ..Parameters::default() };
        let start = State { x: [0.0, p.stop_gap, 0.0], v: [1e90, 0.0, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.advance_to(1e-20).unwrap();
        let snapshot = simulator.snapshot();
        assert!(snapshot.hybrid.departure.is_some_and(|departure| departure.gained[1] > MAX_NUMBER));
        simulator.restore(&snapshot).unwrap();
        assert_eq!(simulator.snapshot(), snapshot);
    }

    #[test]
    fn a_snapshot_whose_loads_would_overflow_is_refused() {
        let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
        let sound = simulator.snapshot();
        let damages: [fn(&mut Snapshot); 3] = [
            |damaged| damaged.parameters.constant_loads[2] = 6.9e274,
            |damaged| damaged.hybrid.loads[1][2] = 2.9e273,
            |damaged| (damaged.hybrid.loads[1][3], damaged.hybrid.loads_from.hi) = (1.0, -1.8e108),
        ];
        for damage in damages {
            let mut damaged = sound;
            damage(&mut damaged);
            let refused = simulator.restore(&damaged);
            assert!(
                matches!(refused, Err(Error::OutOfRange { .. } | Error::PrecisionLost { .. })),
                "{refused:?}"
            );
            assert_eq!(simulator.snapshot(), sound);
        }
    }
}
