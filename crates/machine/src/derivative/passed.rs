//! An event that a motion has passed, over which derivatives can be carried.

use super::crossing::{Crossing, Met};
use super::jump::jumped;
use super::machine::{Instant, Machine};
use super::mode::VariedMode;
use crate::error::Error;
use crate::mode::Mode;
use crate::motion::{Event, Impulse, Motion};
use nalgebra::DVector;
use std::collections::HashMap;
use std::sync::Arc;

/// Largest size of the kept modes, bytes. Beyond it all are dropped, and made again when needed.
const KEPT: usize = 128 << 20;

/// The modes that a motion has met, with their derivatives by some columns.
#[derive(Clone, Default)]
pub(super) struct Modes {
    known: HashMap<Mode, Arc<VariedMode>>,
    /// Bytes are counted again at this number of modes, since counting takes time.
    recount: usize,
}

impl Modes {
    /// The present mode of a motion, with the derivatives by all columns or by none.
    pub fn of(&mut self, machine: &Machine, motion: &Motion, varied: bool) -> Arc<VariedMode> {
        if let Some(known) = self.known.get(motion.mode()) {
            return known.clone();
        }
        self.make_room(KEPT);
        let own = machine.at_mode(motion.mode());
        let made = Arc::new(own.as_deref().unwrap_or(machine).mode_of(motion, varied));
        self.known.insert(motion.mode().clone(), made.clone());
        made
    }

    /// Drops all modes if they take more than `most` bytes.
    fn make_room(&mut self, most: usize) {
        let count = self.known.len();
        if count < self.recount {
            return;
        }
        self.recount = count + count / 32 + 1;
        if self.known.values().map(|mode| mode.numbers() * size_of::<f64>()).sum::<usize>() > most {
            self.known.clear();
            self.recount = 0;
        }
    }
}

/// An event: the mode, the state and z' before and after its law, and the events that happened.
pub(super) struct Passed {
    pub time: f64,
    pub modes: [Arc<VariedMode>; 2],
    pub states: [DVector<f64>; 2],
    pub rates: [DVector<f64>; 2],
    sizes: DVector<f64>,
    /// Index, in the mode before, of the event function that has passed zero; `None` at a knot.
    pub due: Option<usize>,
    pub impulses: Vec<Impulse>,
    pub events: Vec<Event>,
    /// The machine with the rows of the mode after the law, if they are others.
    pub next: Option<Arc<Machine>>,
}

impl Passed {
    /// Applies the law of the pending event of a motion in a mode. `enter` returns the mode that
    /// follows.
    pub fn new(
        machine: &Machine,
        motion: &mut Motion,
        mode: &Arc<VariedMode>,
        enter: impl FnOnce(&Motion) -> Arc<VariedMode>,
    ) -> Result<Self, Error> {
        let z = machine.widened(motion.state()).into_owned();
        // An `ElastoGap` has two event functions with the same `watch`: take the one at zero.
        let due = motion.due().and_then(|watch| {
            let rows = mode.watched.iter().enumerate().filter(|(_, own)| own.0 == watch);
            let off = |(_, row): &(usize, &(_, crate::functional::Functional))| row.1.at(z.as_slice()).abs();
            rows.min_by(|a, b| off(a).total_cmp(&off(b))).map(|row| row.0)
        });
        let mut events = Vec::new();
        motion.apply_event(&mut |event| events.push(event.clone()))?;
        Ok(Self::applied(machine, motion, mode, (z, due, events), enter))
    }

    /// Records the event of a motion whose law has been applied, given the state before it, the
    /// event function and the reported events.
    pub fn applied(
        machine: &Machine,
        motion: &Motion,
        mode: &Arc<VariedMode>,
        (z, due, events): (DVector<f64>, Option<usize>, Vec<Event>),
        enter: impl FnOnce(&Motion) -> Arc<VariedMode>,
    ) -> Self {
        let next = if *motion.mode() == mode.mode { mode.clone() } else { enter(motion) };
        let after = machine.widened(motion.state()).into_owned();
        let begun = due.is_none().then(|| jumped(&machine.system, &z, &after));
        let impulses = Impulse::all(&machine.system, &events, begun.as_ref().unwrap_or(&z));
        Self {
            next: machine.at_mode(motion.mode()),
            time: motion.time(),
            rates: [mode.rates(&z), next.rates(&after)],
            sizes: machine.widened(&motion.sizes().0).into_owned(),
            modes: [mode.clone(), next],
            states: [z, after],
            due,
            impulses,
            events,
        }
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
        let next = self.next.as_deref().unwrap_or(machine);
        let mut crossing = Crossing {
            machine,
            next,
            together: machine.approaching(&before),
            still: next.still(&after, false),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::file::{no_records, parse};

    #[test]
    fn modes_are_dropped_where_they_take_too_much() {
        let text = "name = \"A\"\n[body.a]\nmass = 1.0\n\
                    [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 4.0\n";
        let assembly = Arc::new(Assembly::new(parse(text, "a.toml", &no_records).unwrap()).unwrap());
        let motion = Motion::new(assembly.clone()).unwrap();
        let machine = Machine::new(assembly, vec!["spring.k.stiffness".into()]).unwrap();
        let mut modes = Modes::default();
        let mode = modes.of(&machine, &motion, true);
        assert!(Arc::ptr_eq(&mode, &modes.of(&machine, &motion, true)) && mode.numbers() > 10);
        modes.make_room(mode.numbers() * size_of::<f64>());
        assert_eq!(modes.known.len(), 1);
        modes.recount = 0;
        modes.make_room(mode.numbers() * size_of::<f64>() - 1);
        assert_eq!(modes.known.len(), 0);
    }
}
