//! Advancing: sub-steps in which no event happens, proved, and the way to the first event.

use super::{Motion, Observer, Outcome};
use crate::error::Error;
use crate::flow::{ORDERS, SAMPLES, WatchTable};
use crate::mode::Watch;
use nalgebra::DVector;
use vibro_impact::events::first_crossing;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A sub-step is shortened until no stop's e moves by more than this many times its largest size so far: beyond, the roots would
/// lose digits.
const REACH: f64 = 4.0;
/// Sub-steps in one call, and for each sub-step's length of time.
const WORK: (u64, f64) = (20_000, 64.0);
/// Events at one instant without progress, for each element and one more.
const CHAIN: usize = 100;

/// The end of a sub-step: how far, and the watched functional that ends it.
struct Passage {
    /// Part of the span.
    u: f64,
    place: usize,
}

impl Motion {
    /// Advances to a time.
    ///
    /// # Errors
    /// [`Error::Step`] for an end before the present or not finite; [`Error::Jammed`], [`Error::Violated`] and [`Error::Stuck`]
    /// where the motion cannot go on: the state then stands at the time reached.
    pub fn advance_to(&mut self, end: f64) -> Result<(), Error> {
        self.advance(end, false, &mut None).map(drop)
    }

    /// Advances to a time and reports every event on the way.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_observed(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<(), Error> {
        self.advance(end, false, &mut Some(observer)).map(drop)
    }

    /// Advances to a time or, if it is earlier, to the state after the next event.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_to_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Outcome, Error> {
        self.advance(end, true, &mut Some(observer))
    }

    fn advance(&mut self, end: f64, pause: bool, observer: &mut Observer) -> Result<Outcome, Error> {
        if !(end.is_finite() && end >= self.time()) {
            return Err(Error::Step { time: self.time(), end });
        }
        let target = DoubleDouble::new(end);
        let (mut work, mut from) = (WORK.0 as f64, self.time());
        loop {
            let remaining = target.minus(self.hybrid.time).value();
            if remaining <= 0.0 {
                self.hybrid.time = target;
                return Ok(Outcome::End);
            }
            let knot = self.assembly.system.signals.next_knot(self.time()).filter(|&t| t <= end);
            let (goal, at_knot) = knot.map_or((target, false), |t| (DoubleDouble::new(t), true));
            if self.substep(goal, at_knot, observer)? && pause {
                return Ok(Outcome::Event);
            }
            work -= 1.0;
            work += WORK.1 * (self.time() - from) / self.table.length;
            from = self.time();
            if work < 0.0 {
                return Err(self.stuck(
                    "the limit of work in one call is reached; events follow one another without end",
                ));
            }
        }
    }

    pub(super) fn stuck(&self, cause: &str) -> Error {
        Error::Stuck { time: self.time(), cause: cause.into() }
    }

    /// A sub-step of at most the table's length towards `goal`; true where an event's law was applied.
    fn substep(&mut self, goal: DoubleDouble, at_knot: bool, observer: &mut Observer) -> Result<bool, Error> {
        let table = self.table.clone();
        let remaining = goal.minus(self.hybrid.time).value();
        let mut span = table.length.min(remaining);
        let z = &self.hybrid.z;
        let sizes = z.abs();
        span = self.within_reach(span, &sizes);
        let whole = span == table.length;
        let passage = self.first_passage(span, whole, &sizes);
        let part = passage.as_ref().map_or(1.0, |p| p.u);
        let dt = part * span;
        let reaches = passage.is_none() && span >= remaining;
        let next = if whole && passage.is_none() { &table.transition * z } else { table.state_after(z, dt) };
        let mut energy = std::mem::take(&mut self.hybrid.energy);
        energy.add(&self.assembly.system, &self.hybrid.mode, &table, z, dt);
        self.hybrid.energy = energy;
        self.hybrid.z = next;
        self.hybrid.time = if reaches { goal } else { self.hybrid.time.plus(dt) };
        if dt > 0.0 {
            self.hybrid.chain = 0;
        }
        let knot = reaches && at_knot;
        if !knot {
            self.refill();
        }
        self.hybrid.sizes.include(&self.hybrid.z);
        self.keep_contacts();
        if let Some(passage) = passage {
            self.hybrid.chain += 1;
            if self.hybrid.chain > CHAIN * (self.hybrid.departing.len() + 1) {
                return Err(self.stuck("the modes change without end"));
            }
            let watch = table.watched[passage.place].watch;
            self.settle(&[watch], observer)?;
            return Ok(true);
        }
        self.hybrid.departing.iter_mut().for_each(|order| *order = 0);
        if knot {
            self.refill();
            self.knot(observer)?;
            return Ok(true);
        }
        Ok(false)
    }

    /// The longest span of `span`, `span`/2, … in which the watched stops' e stay within reach.
    fn within_reach(&self, mut span: f64, sizes: &DVector<f64>) -> f64 {
        let table = &self.table;
        for w in &table.watched {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let size = self.hybrid.sizes.of(&w.row);
            let slope = row_dot(&w.coefficients, 1, &self.hybrid.z).abs() / table.length;
            let curvature = w.curvature.dot(sizes);
            while span * (slope + 0.5 * curvature * span) > REACH * size
                && size > 0.0
                && span > f64::MIN_POSITIVE
            {
                span *= 0.5;
            }
        }
        span
    }

    /// The first passage of a watched functional from below zero to above within a span, or the proof that there is none.
    fn first_passage(&self, span: f64, whole: bool, sizes: &DVector<f64>) -> Option<Passage> {
        let (table, z) = (&self.table, &self.hybrid.z);
        let mut first: Option<Passage> = None;
        for (place, w) in table.watched.iter().enumerate() {
            let order = self.hybrid.departing.get(place).copied().unwrap_or(0);
            if order == 0 && whole && first.is_none() && clear_by_samples(w, z, sizes, table.length) {
                continue;
            }
            let mut c = [0.0; ORDERS];
            let ratio = span / table.length;
            let mut scale = 1.0;
            for (k, ck) in c.iter_mut().enumerate() {
                *ck = row_dot(&w.coefficients, k, z) * scale;
                scale *= ratio;
            }
            if order >= ORDERS {
                continue; // zero throughout
            }
            if order > 0 {
                c.copy_within(order.., 0);
                c[ORDERS - order..].fill(0.0);
                c[0] = c[0].min(-f64::MIN_POSITIVE);
            } else {
                c[0] = c[0].min(0.0);
            }
            let rest: f64 = c[1..].iter().map(|x| x.abs()).sum();
            if c[0] + rest < 0.0 {
                continue;
            }
            let hi = first.as_ref().map_or(1.0, |p| p.u);
            if let Some(u) = first_crossing(&c, 0.0, hi, &mut 0) {
                first = Some(Passage { u, place });
            }
        }
        first
    }
}

/// A row of a matrix times a vector.
pub fn row_dot(matrix: &nalgebra::DMatrix<f64>, row: usize, z: &DVector<f64>) -> f64 {
    (0..z.len()).map(|j| matrix[(row, j)] * z[j]).sum()
}

/// Whether samples and the bound between them prove that a functional stays below zero throughout a whole sub-step: between two
/// samples a distance h apart it lies within M h²/8 of their chord.
fn clear_by_samples(w: &WatchTable, z: &DVector<f64>, sizes: &DVector<f64>, length: f64) -> bool {
    let h = length / SAMPLES as f64;
    let margin = w.curvature.dot(sizes) * h * h * 0.125;
    w.row.dot(z) < -margin && (0..SAMPLES).all(|k| row_dot(&w.samples, k, z) < -margin)
}
