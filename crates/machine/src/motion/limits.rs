//! Limits of a motion and of a call, and the errors when they are exceeded.

use super::Motion;
use crate::curved::Curved;
use crate::elements::Element;
use crate::error::Error;
use crate::steep::Steep;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest coordinate or rate, m, rad, m/s or rad/s. It is checked at least every 16 sub-steps, in
/// which numbers grow by a factor of at most 1e21, so that energies stay finite.
const MOST: f64 = 1e100;

/// The same for machines with curved forces, whose fifth powers stay finite. A motion that gets
/// there ends soon: it grows without bounds in finite time.
const MOST_CURVED: f64 = 1e30;

/// Length of a series relative to the time reached, below which the clock does not show it. A
/// motion with such series ends in finite time, with rates beyond all bounds.
const INVISIBLE: f64 = 1e-18;

/// Distance from the edge of the domain of an operation at which a motion ends, relative to the
/// largest terms of the argument. Closer to the edge, roundings of the argument exceed 1e-7 of it.
const EDGE: f64 = 1e-9;

/// Distance at which a motion without a proved series counts as ending at the edge of a domain.
const NEAR: f64 = 1e-4;

/// Series of curved forces after which the pace of a call is checked, a second or two of computing;
/// and the multiple of the call's limit at which it ends there. A call that is slow for a short time
/// is not ended.
pub(super) const PACE: (u64, f64) = (500_000, 10.0);

/// Sub-steps between two checks of the interruption flag: some hundredths of a second.
const LOOK: u64 = 1 << 16;

impl Motion {
    /// Sets the largest number of sub-steps in one call, default 20 million. A call that needs
    /// more ends with [`Error::TooStiff`]; another call continues.
    ///
    ///
    /// ```
    /// use vibro_machine::{Assembly, Error, Motion, file};
    ///
    /// # let text = r#"
    /// #     name = "Oscillator"
    /// #     body.a = { mass = 1.0, start = { s = 1.0 } }
    /// #     spring.k = { between = ["ground", "a"], stiffness = 1.0 }
    /// #     stop.far = { between = ["ground", "a"], gap = 2.0, restitution = 0.5 }
    /// # "#;
    /// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?.with_most_work(10);
    /// let mut calls = 1;
    /// while let Err(error) = motion.advance_to(200.0) {
    ///     assert!(matches!(error, Error::TooStiff { .. }));
    ///     calls += 1;
    /// }
    /// assert!(calls > 1);
    /// assert!((motion.coordinate(0) - 200.0f64.cos()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_most_work(mut self, sub_steps: u64) -> Self {
        self.most_work = sub_steps;
        self
    }

    /// Sets an interruption flag: a call ends with [`Error::Interrupted`] soon after `asked` is
    /// set; another call continues.
    #[must_use]
    pub fn with_interruption(mut self, asked: Arc<AtomicBool>) -> Self {
        self.asked = Some(asked);
        self
    }

    /// Checks the interruption flag every [`LOOK`] sub-steps.
    pub(super) fn check_interruption(&self, sub_steps: u64) -> Result<(), Error> {
        let is_asked = || self.asked.as_ref().is_some_and(|asked| asked.load(Ordering::Relaxed));
        if (sub_steps + 1).is_multiple_of(LOOK) && is_asked() {
            return Err(Error::Interrupted { time: self.time() });
        }
        Ok(())
    }

    /// Refuses a call under curved forces that would need many times its limit of sub-steps at the
    /// pace of the last [`PACE`] ones, which covered `progress`; `left` is the time to its end, s.
    pub(super) fn check_pace(&self, left: f64, progress: f64) -> Result<(), Error> {
        let (series, multiple) = PACE;
        let needed = left / progress * series as f64;
        match self.table().is_curved() && needed > multiple * self.most_work as f64 {
            true => Err(self.too_stiff(series)),
            false => Ok(()),
        }
    }

    /// Refuses coordinates and rates whose energies would not be finite.
    pub(super) fn check_sizes(&self) -> Result<(), Error> {
        let (system, z) = (&self.assembly.system, self.hybrid.z.as_slice());
        let is_curved = !system.curved.is_empty();
        let limit = if is_curved { MOST_CURVED } else { MOST };
        let beyond = z[..system.signals.one].iter().position(|x| x.abs() > limit || x.is_nan());
        let Some(k) = beyond else { return Ok(()) };
        if is_curved {
            return Err(self.ends_in_finite_time());
        }
        let name = self.assembly.name_of_state(k);
        let name = name.rsplit_once('.').map_or(name.clone(), |(of, what)| format!("{of}: {what}"));
        Err(Error::Beyond { time: self.time(), name, value: z[k] })
    }

    /// Refuses a series of curved forces, of a length in s, that the clock does not show, although
    /// it shows the time `left` up to the goal.
    pub(super) fn check_series(&self, length: f64, left: f64) -> Result<(), Error> {
        let time = self.time().abs();
        if length > INVISIBLE * time || left <= f64::EPSILON * time {
            return Ok(());
        }
        Err(self.at_edge(NEAR).map_or_else(|| self.ends_in_finite_time(), |own| self.leaves_domain(own)))
    }

    fn ends_in_finite_time(&self) -> Error {
        let name = self.steepest().0;
        let cause = format!(
            "the motion ends in finite time; the force of {name} lets coordinates or rates grow \
             beyond all bounds"
        );
        Error::Stuck { time: self.time(), cause }
    }

    /// Refuses a state at the edge of the domain of a formula. Within a series no operation leaves
    /// its domain, as its remainder is proved: a motion towards the edge takes ever shorter series.
    pub(super) fn check_domains(&self) -> Result<(), Error> {
        self.at_edge(EDGE).map_or(Ok(()), |own| Err(self.leaves_domain(own)))
    }

    /// An operation whose argument is near the edge of its domain, or beyond it. `near` is relative
    /// to the terms of the argument: to their present sizes if they are curved themselves, as a
    /// square has only the rounding of its own value.
    fn at_edge(&self, near: f64) -> Option<&Curved> {
        let (system, z) = (&self.assembly.system, self.hybrid.z.as_slice());
        let is_at_edge = |own: &Curved, sizes: &[f64]| {
            let argument = own.argument.at(z);
            let is_near = argument.abs() <= near * own.argument.size(sizes);
            own.operation.has_domain() && (is_near || !own.operation.is_defined(argument))
        };
        // The largest sizes of the motion are at least the present ones.
        let largest = self.hybrid.sizes.0.as_slice();
        let first = system.curved.iter().position(|own| is_at_edge(own, largest))?;
        let mut sizes = largest.to_vec();
        system.set_curved_sizes(z, &mut sizes);
        system.curved[first..].iter().find(|own| is_at_edge(own, &sizes))
    }

    /// Error of a motion that reaches the edge of the domain of an operation.
    fn leaves_domain(&self, own: &Curved) -> Error {
        let cause = format!(
            "{} in the force of {} reaches 0, where the formula is not defined",
            own.operation.argument(),
            self.name_of_curved(own)
        );
        Error::Stuck { time: self.time(), cause }
    }

    /// Dotted name of the element that has an operation.
    fn name_of_curved(&self, own: &Curved) -> String {
        let element = self.assembly.system.element_of(own.owner);
        self.assembly.description.elements().nth(element).map(Element::dotted).unwrap_or_default()
    }

    /// Error of curved forces that are too large for numbers: it names the element whose force
    /// grows fastest.
    pub(super) fn too_large(&self) -> Error {
        if let Some(own) = self.at_edge(NEAR) {
            return self.leaves_domain(own);
        }
        let (name, value) = self.steepest();
        let cause = format!(
            "the force of {name} is {value:e} N or N m here, which changes too fast for any step \
             in time; reduce its coefficients or the displacements"
        );
        Error::Stuck { time: self.time(), cause }
    }

    /// Dotted name and force of the element whose curved force grows fastest.
    fn steepest(&self) -> (String, f64) {
        let (assembly, z) = (&self.assembly, self.hybrid.z.as_slice());
        let slope = |own: &&Curved| {
            let slopes = own.operation.slopes(own.arguments(z));
            slopes[0].abs().max(slopes[1].abs())
        };
        let steepest = assembly.system.curved.iter().max_by(|a, b| slope(a).total_cmp(&slope(b)));
        let Some(steepest) = steepest else { return Default::default() };
        (self.name_of_curved(steepest), steepest.operation.value(steepest.arguments(z)))
    }

    /// Error of a call that exceeds its limit of sub-steps.
    pub(super) fn too_stiff(&self, sub_steps: u64) -> Error {
        let curved = self.assembly.steepest(&self.hybrid.z).filter(|_| self.table().is_curved());
        if let Some(Steep { element, rate }) = curved {
            let cause = format!(
                "{sub_steps} series in one call; here a series is {:e} s long, since the force of {element} \
                 changes as fast as {rate:e} 1/s; a flatter curve makes series longer, dry friction is a \
                 [friction.NAME], and another call continues from here",
                self.full_length()
            );
            return Error::TooStiff { time: self.time(), cause };
        }
        let (table, system, n) = (self.table(), &self.assembly.system, self.assembly.system.coordinates);
        let rate = |k: usize| {
            let row = table.a.row_of(n + k);
            row[k].abs().sqrt().max(row[n + k].abs())
        };
        let fastest = (0..n).max_by(|i, j| rate(*i).total_cmp(&rate(*j)));
        let name = fastest.map_or("", |k| &self.assembly.description.bodies[system.bodies_of[k]].name);
        let cause = format!(
            "{sub_steps} sub-steps in one call; here a sub-step is {:e} s for rates up to {:e} rad/s, which \
             stiffness and damping \
             give body.{name}; softer springs, more damping or a greater mass make sub-steps \
             longer, and another call continues from here",
            table.length, table.rate
        );
        Error::TooStiff { time: self.time(), cause }
    }

    /// Returns the error of a call whose events follow one another too fast for it to end.
    pub(super) fn too_many(&self, sub_steps: u64, began: f64) -> Error {
        let cause = format!(
            "{sub_steps} sub-steps in one call, which continued from t = {began} s: events end \
             sub-steps long before the {:e} s that one could last; a \
             lower restitution, damping or a heavier body makes the events fewer, and another call \
             continues from here",
            self.full_length()
        );
        self.stuck(&cause)
    }

    /// Error of a motion whose events accumulate.
    pub(super) fn stuck(&self, cause: &str) -> Error {
        let last = self.hybrid.last.map(|watch| self.assembly.name_of(watch));
        let cause = match last {
            Some(name) => format!("{cause}; events follow one another at {name}"),
            None => cause.into(),
        };
        Error::Stuck { time: self.time(), cause }
    }
}
