//! Derivatives of a motion that is under way.

use super::super::by::By;
use super::super::columns::Columns;
use super::super::flight::Memory;
use super::super::machine::{Instant, Machine};
use super::super::passed::Modes;
use super::super::start::{Given, Start};
use super::{Differentiated, VariedObserver, throughout};
use crate::error::Error;
use crate::motion::{Motion, Reached};
use nalgebra::DVector;
use std::sync::Arc;

impl Differentiated {
    /// Differentiates a motion under way with respect to numbers that change at the present time.
    /// The present state does not vary, except to follow the constraints of held contacts. After
    /// [`from_state`](Self::from_state) it does not follow them.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_motion(motion: Motion, columns: &[impl Into<By> + Clone]) -> Result<Self, Error> {
        Self::of(motion, columns, false)
    }

    /// Returns partial derivatives of a motion's present values, with its coordinates, rates and
    /// mode fixed. Read them by [`derivative`](Self::derivative) before advancing.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn at_fixed_state(motion: Motion, columns: &[impl Into<By> + Clone]) -> Result<Self, Error> {
        Self::of(motion, columns, true)
    }

    fn of(motion: Motion, columns: &[impl Into<By> + Clone], is_fixed: bool) -> Result<Self, Error> {
        let (assembly, motion) = (motion.assembly().clone(), motion.noting_touches());
        let columns: Vec<By> = columns.iter().cloned().map(Into::into).collect();
        let machine = Machine::new(assembly, columns)?;
        let begun = machine.widened(motion.state()).into_owned();
        let machine = Arc::new(machine.under_way(motion.time(), &begun));
        let machine = machine.at_mode(motion.mode()).unwrap_or(machine);
        let mut modes = Modes::default();
        let mode = modes.of(&machine, &motion, true);
        let z = machine.widened(motion.state()).into_owned();
        let (rates, sizes) = (mode.rates(&z), machine.widened(&motion.sizes().0).into_owned());
        let at = Instant { mode: &mode, z: &z, rates: &rates, sizes: &sizes, time: motion.time() };
        let count = machine.columns.len();
        let (mut deltas, mut lost) = (Columns::zeros(z.len(), count), vec![None; count]);
        deltas.put_state(z.as_slice());
        let throughout = throughout(&mode, &motion).map(|own| own.0.contact()).collect();
        let start = Start { machine: &machine, given: Given::Motion, begun: &z, events: &[], at, throughout };
        for (p, place) in lost.iter_mut().enumerate() {
            match if is_fixed { Ok(fixed(&start, p)) } else { start.derivative(p) } {
                Ok(delta) => deltas.put(p, &delta),
                Err(found) => *place = Some(found),
            }
        }
        let mut scales = Columns::zeros(z.len(), count);
        scales.include(&deltas);
        let names = machine.columns.iter().map(By::to_string).collect();
        let (memory, vectors, met) = (Memory::default(), pulp::Arch::new(), Vec::new());
        Ok(Self { machine, motion, names, modes, mode, deltas, scales, lost, memory, vectors, met })
    }

    /// Advances to a time or to an earlier event, whose law is not yet applied.
    ///
    /// # Errors
    /// As [`Motion::advance_before_event`].
    pub fn advance_before_event(&mut self, end: f64) -> Result<Reached, Error> {
        loop {
            let outcome = self.follow(end, &mut [])?;
            if !self.motion.is_renewal_due() {
                return Ok(outcome);
            }
            self.pass(&mut [], &mut |_, _| ())?;
        }
    }

    /// Applies the law of the pending event.
    ///
    /// # Errors
    /// As [`Motion::apply_event`].
    pub fn apply_event(&mut self, observer: &mut VariedObserver) -> Result<(), Error> {
        self.pass(&mut [], observer)
    }
}

/// Column `p` with the state fixed: only the signals vary.
fn fixed(start: &Start, p: usize) -> DVector<f64> {
    let (machine, at) = (start.machine, &start.at);
    let (one, mut delta) = (machine.system.signals.one, DVector::zeros(at.z.len()));
    machine.fill(p, at.time, at.z, &mut delta);
    match machine.columns[p] {
        By::Start(place) => delta[place] = 1.0,
        By::Time => delta.rows_range_mut(one..).copy_from(&at.rates.rows_range(one..)),
        By::Parameter(_) => {}
    }
    machine.take_given(p, at.z, &mut delta);
    machine.vary_curved(p, at.z, &mut delta);
    delta
}
