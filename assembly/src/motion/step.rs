//! Advancing: sub-steps in which no event happens, proved, and the way to the first event.

use super::{Due, Hybrid, Motion, Observer, Outcome};
use crate::energy::NODES;
use crate::error::Error;
use crate::flow::{ORDERS, SAMPLES, WatchTable};
use crate::mode::Watch;
use nalgebra::DVector;
use vibro_impact::events::first_crossing;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A sub-step is halved while a stop's e may move by more than this many times its largest size so far: beyond, the roots would
/// lose digits. Not more often than [`HALVINGS`], since what begins at zero has no size yet.
const REACH: f64 = 4.0;
/// Halvings of a sub-step for its reach.
const HALVINGS: i32 = 6;
/// Sub-steps in one call, and for each sub-step's length of time.
const WORK: (u64, f64) = (20_000, 64.0);
/// Events at one instant without progress, for each element and one more.
const CHAIN: usize = 100;

/// Parts of a mode's sub-step that count as progress of time: a few roundings.
const PROGRESS: f64 = 1e-15;
/// A functional that was zero throughout is watched again beyond this many times the size under which it counts as zero.
const LEAVES_ZERO: f64 = 16.0;

/// What an advance does at an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pause {
    Never,
    AfterEvent,
    BeforeEvent,
}

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
        self.advance(end, Pause::Never, &mut None).map(drop)
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
        self.advance(end, Pause::Never, &mut Some(observer)).map(drop)
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
        self.advance(end, Pause::AfterEvent, &mut Some(observer))
    }

    /// Advances to a time or, if it is earlier, to the next event, before its law: [`apply_event`](Self::apply_event) or any further
    /// advance applies it.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_before_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Outcome, Error> {
        self.advance(end, Pause::BeforeEvent, &mut Some(observer))
    }

    /// Whether it stands at an event whose law is still to be applied.
    pub fn is_event_due(&self) -> bool {
        self.hybrid.due.is_some()
    }

    /// Applies the law of the event before which the last advance has paused; without one nothing happens.
    ///
    /// # Errors
    /// [`Error::Jammed`], [`Error::Violated`] and [`Error::Stuck`] where the motion cannot go on.
    pub fn apply_event(&mut self, observer: &mut dyn FnMut(&super::Event)) -> Result<(), Error> {
        self.pass_event(&mut Some(observer))
    }

    /// Applies the law of an event that is due.
    pub(super) fn pass_event(&mut self, observer: &mut Observer) -> Result<(), Error> {
        match self.hybrid.due.take() {
            Some(Due::Passage(watch)) => self.settle(&[watch], observer),
            Some(Due::Knot) => {
                self.refill();
                self.knot(observer)
            }
            None => Ok(()),
        }
    }

    fn advance(&mut self, end: f64, pause: Pause, observer: &mut Observer) -> Result<Outcome, Error> {
        if !(end.is_finite() && end >= self.time()) {
            return Err(Error::Step { time: self.time(), end });
        }
        self.pass_event(observer)?;
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
            self.hybrid.due = self.substep(goal, at_knot)?;
            if self.hybrid.due.is_some() {
                if pause != Pause::BeforeEvent {
                    self.pass_event(observer)?;
                }
                if pause != Pause::Never {
                    return Ok(Outcome::Event);
                }
            }
            work -= 1.0;
            work += WORK.1 * (self.time() - from) / self.table.length;
            from = self.time();
            if work < 0.0 {
                return Err(self.stuck("the limit of work in one call is reached"));
            }
        }
    }

    pub(super) fn stuck(&self, cause: &str) -> Error {
        let last = self.hybrid.last.map(|watch| self.assembly.name_of(watch));
        let cause = match last {
            Some(name) => format!("{cause}; events follow one another at {name}"),
            None => cause.into(),
        };
        Error::Stuck { time: self.time(), cause }
    }

    /// A sub-step of at most the table's length towards `goal`, or to the event before which it ends.
    fn substep(&mut self, goal: DoubleDouble, at_knot: bool) -> Result<Option<Due>, Error> {
        let table = self.table.clone();
        let remaining = goal.minus(self.hybrid.time).value();
        let mut span = table.length.min(remaining);
        let z = &self.hybrid.z.clone();
        let sizes = z.abs();
        span = self.within_reach(span, &sizes);
        let whole = span == table.length;
        let mut passage = self.first_passage(span, whole, &sizes);
        // A root early in the span is found anew in a shorter one, of which the coefficients' rounding is smaller.
        if let Some(near) =
            passage.as_ref().map(|p| 2.0 * p.u * span).filter(|&near| near > 0.0 && near < 0.5 * span)
            && let Some(again) = self.first_passage(near, false, &sizes)
        {
            (span, passage) = (near, Some(again));
        }
        let part = passage.as_ref().map_or(1.0, |p| p.u);
        let dt = part * span;
        let reaches = passage.is_none() && span >= remaining;
        let Hybrid { energy, mode, .. } = &mut self.hybrid;
        let next = if whole && passage.is_none() {
            energy.add(&self.assembly.system, mode, &table, table.nodes.iter().map(|m| m * z), dt);
            &table.transition * z
        } else {
            let series = table.taylor(z, dt);
            energy.add(&self.assembly.system, mode, &table, NODES.iter().map(|node| series.at(node.0)), dt);
            series.at(1.0)
        };
        self.hybrid.z = next;
        self.hybrid.time = if reaches { goal } else { self.hybrid.time.plus(dt) };
        if dt > PROGRESS * table.length {
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
            self.hybrid.last = Some(table.watched[passage.place].watch);
            if self.hybrid.chain > CHAIN * (self.hybrid.departing.len() + 1) {
                return Err(self.stuck("the modes change without end"));
            }
            return Ok(Some(Due::Passage(table.watched[passage.place].watch)));
        }
        self.watch_again();
        Ok(knot.then_some(Due::Knot))
    }

    /// Watched functionals begin the next sub-step away from zero, but for those that are zero throughout the mode, of which every
    /// coefficient is rounding.
    fn watch_again(&mut self) {
        let Hybrid { departing, z, sizes, .. } = &mut self.hybrid;
        for (order, w) in departing.iter_mut().zip(&self.table.watched) {
            let stays = *order == ORDERS && w.row.dot(z).abs() <= LEAVES_ZERO * sizes.zero(&w.row);
            *order = if stays { ORDERS } else { 0 };
        }
    }

    /// The longest span of `span`, `span`/2, … in which the watched stops' e stay within reach.
    fn within_reach(&self, mut span: f64, sizes: &DVector<f64>) -> f64 {
        let table = &self.table;
        let least = span * 0.5f64.powi(HALVINGS);
        for w in &table.watched {
            if !matches!(w.watch, Watch::Meets(_) | Watch::Presses(_)) {
                continue;
            }
            let size = self.hybrid.sizes.of(&w.row);
            let slope = column_dot(&w.coefficients, 1, &self.hybrid.z).abs() / table.length;
            let curvature = w.curvature.dot(sizes);
            while span * (slope + 0.5 * curvature * span) > REACH * size && span > least {
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
                *ck = column_dot(&w.coefficients, k, z) * scale;
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

/// A column of a matrix times a vector.
pub fn column_dot(matrix: &nalgebra::DMatrix<f64>, column: usize, z: &DVector<f64>) -> f64 {
    let size = z.len();
    let column = &matrix.as_slice()[column * size..(column + 1) * size];
    column.iter().zip(z.as_slice()).map(|(a, b)| a * b).sum()
}

/// Whether samples and the bound between them prove that a functional stays below zero throughout a whole sub-step: between two
/// samples a distance h apart it lies within M h²/8 of their chord.
fn clear_by_samples(w: &WatchTable, z: &DVector<f64>, sizes: &DVector<f64>, length: f64) -> bool {
    let h = length / SAMPLES as f64;
    let margin = w.curvature.dot(sizes) * h * h * 0.125;
    w.row.dot(z) < -margin && (0..SAMPLES).all(|k| column_dot(&w.samples, k, z) < -margin)
}
