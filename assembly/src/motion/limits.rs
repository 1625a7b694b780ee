//! Limits of a motion and of the work in one call.

use super::Motion;
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest coordinate or rate, m, rad, m/s or rad/s. It is checked every 16 sub-steps, in which
/// values grow by at most 1e21, so that energies stay finite.
const MOST: f64 = 1e100;

/// Sub-steps between checks for an interruption: some hundredths of a second.
const LOOK: u64 = 1 << 16;

impl Motion {
    /// Limits the sub-steps in a call: one that needs more ends with [`Error::TooStiff`], and a
    /// further call continues. The default is 20 million.
    #[must_use]
    pub fn with_most_work(mut self, sub_steps: u64) -> Self {
        self.most_work = sub_steps;
        self
    }

    /// Makes calls end with [`Error::Interrupted`] soon after `asked` is set; a further call
    /// continues.
    #[must_use]
    pub fn with_interruption(mut self, asked: Arc<AtomicBool>) -> Self {
        self.asked = Some(asked);
        self
    }

    /// Ends a call that is interrupted, given its number of sub-steps so far.
    pub(super) fn hear(&self, sub_steps: u64) -> Result<(), Error> {
        let is_asked = || self.asked.as_ref().is_some_and(|asked| asked.load(Ordering::Relaxed));
        if (sub_steps + 1).is_multiple_of(LOOK) && is_asked() {
            return Err(Error::Interrupted { time: self.time() });
        }
        Ok(())
    }

    /// Refuses coordinates and rates whose energies would overflow.
    pub(super) fn check_sizes(&self) -> Result<(), Error> {
        let (system, z) = (&self.assembly.system, self.hybrid.z.as_slice());
        let beyond = z[..system.signals.one].iter().position(|x| x.abs() > MOST || x.is_nan());
        beyond.map_or(Ok(()), |k| {
            let n = system.coordinates;
            let body = &self.assembly.description.bodies[system.bodies_of[k % n]].name;
            let name = format!("body.{body}: {}", if k < n { "s" } else { "v" });
            Err(Error::Beyond { time: self.time(), name, value: z[k] })
        })
    }

    /// The error of a call that would take hours.
    pub(super) fn too_stiff(&self) -> Error {
        let (table, system, n) = (self.table(), &self.assembly.system, self.assembly.system.coordinates);
        let rate = |k: usize| {
            let row = table.a.row_of(n + k);
            row[k].abs().sqrt().max(row[n + k].abs())
        };
        let fastest = (0..n).max_by(|i, j| rate(*i).total_cmp(&rate(*j)));
        let name = fastest.map_or("", |k| &self.assembly.description.bodies[system.bodies_of[k]].name);
        let cause = format!(
            "{} sub-steps in one call; here a sub-step is {:e} s for rates up to {:e} rad/s, those of body.{name} by the stiffness and \
             damping that act on it; softer springs, more damping or a greater mass make them longer, and a further call goes on from here",
            self.most_work, table.length, table.rate
        );
        Error::TooStiff { time: self.time(), cause }
    }

    /// The error of a call whose events follow one another too fast for it to reach its end.
    pub(super) fn too_many(&self, sub_steps: u64, began: f64) -> Error {
        let cause = format!(
            "{sub_steps} sub-steps in one call, which went on from t = {began} s: events end them long before the {:e} s that one could last; a \
             lower restitution, damping or a heavier body where they happen makes them fewer, and a further call goes on from here",
            self.table().length
        );
        self.stuck(&cause)
    }

    /// The error of a motion whose events do not end, with the last element.
    pub(super) fn stuck(&self, cause: &str) -> Error {
        let last = self.hybrid.last.map(|watch| self.assembly.name_of(watch));
        let cause = match last {
            Some(name) => format!("{cause}; events follow one another at {name}"),
            None => cause.into(),
        };
        Error::Stuck { time: self.time(), cause }
    }
}
