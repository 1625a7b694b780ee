//! An event that a motion has passed, for carrying derivatives over it.

use super::crossing::{Crossing, Met};
use super::impulse::Impulse;
use super::jump::jumped;
use super::machine::{Instant, Machine};
use super::mode::VariedMode;
use crate::error::Error;
use crate::mode::Mode;
use crate::motion::{Event, Motion};
use nalgebra::DVector;
use std::collections::HashMap;
use std::sync::Arc;

/// The modes that a motion has met, made with their derivatives by some columns.
#[derive(Clone, Default)]
pub(super) struct Modes(HashMap<Mode, Arc<VariedMode>>);

impl Modes {
    /// The present mode of a motion, with the derivatives by all columns or by none.
    pub fn of(&mut self, machine: &Machine, motion: &Motion, varied: bool) -> Arc<VariedMode> {
        if let Some(known) = self.0.get(motion.mode()) {
            return known.clone();
        }
        let made = Arc::new(machine.mode_of(motion, varied));
        self.0.insert(motion.mode().clone(), made.clone());
        made
    }
}

/// An event: the mode, the state and z' before and after its law, and what has happened.
pub(super) struct Passed {
    pub time: f64,
    pub modes: [Arc<VariedMode>; 2],
    pub states: [DVector<f64>; 2],
    pub rates: [DVector<f64>; 2],
    sizes: DVector<f64>,
    /// Place among the functionals of the mode before of the one that has passed zero; `None` at a
    /// knot.
    pub due: Option<usize>,
    pub impulses: Vec<Impulse>,
    pub events: Vec<Event>,
}

impl Passed {
    /// Applies the law of the pending event of a motion in a mode; `enter` finds the mode that
    /// follows.
    pub fn new(
        machine: &Machine,
        motion: &mut Motion,
        mode: &Arc<VariedMode>,
        enter: impl FnOnce(&Motion) -> Arc<VariedMode>,
    ) -> Result<Self, Error> {
        let (z, time) = (machine.widened(motion.state()).into_owned(), motion.time());
        // An `ElastoGap` has two functionals with one `watch`: the one that is zero here.
        let due = motion.due().and_then(|watch| {
            let rows = mode.watched.iter().enumerate().filter(|(_, own)| own.0 == watch);
            let off = |(_, row): &(usize, &(_, crate::system::Functional))| row.1.at(z.as_slice()).abs();
            rows.min_by(|a, b| off(a).total_cmp(&off(b))).map(|row| row.0)
        });
        let mut events = Vec::new();
        motion.apply_event(&mut |event| events.push(event.clone()))?;
        let next = if *motion.mode() == mode.mode { mode.clone() } else { enter(motion) };
        let after = machine.widened(motion.state()).into_owned();
        let begun = due.is_none().then(|| jumped(&machine.system, &z, &after));
        let impulses = Impulse::all(&machine.system, &events, begun.as_ref().unwrap_or(&z));
        Ok(Self {
            time,
            rates: [mode.rates(&z), next.rates(&after)],
            sizes: machine.widened(&motion.sizes().0).into_owned(),
            modes: [mode.clone(), next],
            states: [z, after],
            due,
            impulses,
            events,
        })
    }

    /// The instant before (`k` 0) or after the law.
    pub fn instant(&self, k: usize) -> Instant<'_, '_> {
        Instant {
            mode: &self.modes[k],
            z: &self.states[k],
            rates: &self.rates[k],
            sizes: &self.sizes,
            time: self.time,
        }
    }

    /// The crossing of a machine's derivatives, after `earlier` events of the same instant.
    pub fn crossing<'a>(&'a self, machine: &'a Machine, earlier: &'a [Met]) -> Crossing<'a> {
        let [before, after] = [0, 1].map(|k| self.instant(k));
        let mut crossing = Crossing {
            machine,
            together: machine.approaching(&before),
            still: machine.still(&after, false),
            before,
            after,
            due: self.due.map(|k| (self.modes[0].watched[k].0, &self.modes[0].watched[k].1)),
            impulses: &self.impulses,
            events: &self.events,
            earlier,
        };
        let still = std::mem::take(&mut crossing.still);
        crossing.still = still.into_iter().filter(|own| !crossing.stays_still(own.0)).collect();
        crossing
    }
}
