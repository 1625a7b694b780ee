//! Knots of signals at which only the signals change: by far the commonest event of a motion that
//! a record drives.

use super::super::passed::Passed;
use super::Differentiated;
use crate::error::Error;
use crate::motion::{Event, EventKind};

/// Outcome of a knot: passed without a change of the columns, or left to the general treatment.
pub(super) enum Knot {
    /// The columns stay as they are.
    Kept(Vec<Event>),
    /// The law has been applied; the columns still have to be carried over the event.
    Applied(Box<Passed>),
}

impl Differentiated {
    /// Whether the pending event is a knot at which no contact is held and no event function is
    /// zero, so that no column changes.
    pub(super) fn is_lone_knot(&self) -> bool {
        let Self { machine, motion, mode, .. } = self;
        motion.is_knot_due()
            && machine.is_fixed_at_knots()
            && mode.mode.contacts().next().is_none()
            && machine.is_clear(mode, &machine.widened(motion.state()), &machine.widened(&motion.sizes().0))
    }

    /// Applies the law at a [lone knot](Self::is_lone_knot).
    pub(super) fn pass_knot(&mut self) -> Result<Knot, Error> {
        let Self { machine, motion, modes, mode, deltas, .. } = self;
        let z = machine.widened(motion.state()).into_owned();
        let mut events = Vec::new();
        motion.apply_event(&mut |event| events.push(event.clone()))?;
        let is_alone = events.iter().all(|event| matches!(event.kind, EventKind::Knot))
            && *motion.mode() == mode.mode
            && machine.is_clear(mode, &machine.widened(motion.state()), &machine.widened(&motion.sizes().0));
        if is_alone {
            deltas.put_state(machine.widened(motion.state()).as_slice());
            return Ok(Knot::Kept(events));
        }
        let enter = |motion: &_| modes.of(machine, motion, true);
        Ok(Knot::Applied(Box::new(Passed::applied(machine, motion, mode, (z, None, events), enter))))
    }
}
