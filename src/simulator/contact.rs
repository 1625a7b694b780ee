//! Laws of the events: impact, the closing of a chatter run, release.

use super::step::EventObserver;
use super::{Contact, DueEvent, Event, Simulator};
use crate::flow::{CENTRED, Series};
use crate::model::{Augmented, Impact, RELATIVE, RELATIVE_RATE, SmoothMode};

/// e_c of docs/theory.md (18): a chatter run is closed when its remaining bounces move the block
/// by at most this distance, in gaps. The distance is less than a unit in the last place of the
/// gap.
const CHATTER: f64 = 0.5 * f64::EPSILON;
/// Loss 1 - κ below which [`LEAST_BOUNCE`] limits a run, not [`CHATTER`] (docs/numerics.md,
/// "Chatter").
const LEAST_LOSS: f64 = 1e-3;
/// e_h of docs/theory.md (18): height of a bounce, in gaps, below which a nearly elastic run is
/// closed. No program that uses the results resolves this height. A run that is computed down to
/// this height has 10⁵ bounces per second; down to round-off it would have 10⁹.
const LEAST_BOUNCE: f64 = 1e-12;
/// Largest change of the merged motion's free acceleration within t_c, relative to the
/// acceleration, at which a run is closed. The rate of change must keep this bound over 2 t_c
/// (docs/theory.md (19); docs/numerics.md, "Chatter").
const STEADY: f64 = 0.125;

#[inline(always)]
fn report(observer: &mut EventObserver<'_, '_>, event: Event) {
    if let Some(observer) = observer {
        observer(&event);
    }
}

impl Simulator {
    /// Applies the law of the event at stop `side`; true for an impact.
    #[inline(always)]
    pub(super) fn apply_event_law<const LOADS: usize>(
        &mut self,
        z: &mut Augmented,
        side: f64,
        observer: &mut EventObserver<'_, '_>,
    ) -> bool {
        let (time, stop) = (self.time(), side as i8);
        z[RELATIVE] = side * self.model.gap;
        if self.hybrid.contact != Contact::Flight {
            z[RELATIVE_RATE] = 0.0;
            self.hybrid.contact = Contact::Flight;
            // w' and w'' are zero. The block leaves with the third derivative of w, or with the
            // first higher derivative that is larger than rounding.
            let (_, certain) = self.flight_from_stop(z);
            self.hybrid.departing = certain.map_or(3, |order| order.max(3)) as u8;
            self.hybrid.doubtful = certain.is_none();
            report(observer, Event::Release { time, side: stop });
            return false;
        }
        // If round-off makes the approach speed negative, the speed is set to zero: the block only
        // touches the stop.
        z[RELATIVE_RATE] = side * (side * z[RELATIVE_RATE]).max(0.0);
        let Impact { speed, impulse, lost } = self.model.impact(z, side);
        self.hybrid.sums.impact = self.hybrid.sums.impact.plus(lost);
        self.hybrid.record.count(side, time, speed, impulse);
        report(observer, Event::Impact { time, side: stop, speed, impulse });
        self.hybrid.departing = 1;
        let rebound = z[RELATIVE_RATE].abs();
        if rebound == 0.0 {
            self.rest_or_depart(z, side);
            if self.hybrid.contact != Contact::Flight {
                report(observer, Event::Rest { time, side: stop });
            }
        } else if let Some(left) = self.chatter_to_be_closed::<LOADS>(z, side, rebound) {
            self.hybrid.record.box_impulse += self.model.reduced_mass * z[RELATIVE_RATE];
            let lost = self.model.merge(z);
            self.hybrid.sums.impact = self.hybrid.sums.impact.plus(lost);
            (self.hybrid.contact, self.hybrid.departing) = (Contact::at(side), 0);
            // The impacts accumulate `left` s later. The block rests already at the present time,
            // which changes its position by no more than round-off.
            report(observer, Event::Rest { time: time + left, side: stop });
        }
        true
    }

    /// Time until the impacts of the chatter run with rebound speed `u` accumulate, s, if the run
    /// is to be closed now (0 for nearly elastic runs); otherwise `None`.
    ///
    /// At constant acceleration a the run lasts t_c = 2u/(a(1-κ)) (docs/theory.md (16)). The
    /// conditions, and why they suffice: docs/numerics.md, "Chatter".
    #[inline(always)]
    fn chatter_to_be_closed<const LOADS: usize>(&self, z: &Augmented, side: f64, u: f64) -> Option<f64> {
        let forces = [(); LOADS].map(|()| self.forces_now());
        let now = forces.first().map(|f| f.map(|d| d[0]));
        let a = side * self.model.acceleration(SmoothMode::Flight, z, now).free;
        if a <= 0.0 || u * u > self.chatter_closing_limit() * a {
            return None;
        }
        let loss = 1.0 - self.model.restitution;
        let elastic = loss < LEAST_LOSS;
        let span = if elastic { 2.0 * u / a } else { 2.0 * u / (a * loss) };
        let longest = 2.0 * span;
        if longest > 0.5 * self.interval() {
            return None; // the series below is not accurate that far
        }
        // State with box and block moving as one body. The run deviates from this motion by less
        // than the height of its bounces.
        let mut merged = *z;
        self.model.merge(&mut merged);
        let series =
            Series::<CENTRED>::expand(&self.model, SmoothMode::Rest, &merged, forces.first(), longest);
        // Bound on the acceleration's rate of change over `longest`, with `longest` as unit of
        // time.
        let rate: f64 = series.free.iter().enumerate().map(|(k, c)| k as f64 * c.abs()).sum();
        (rate * (span / longest) <= STEADY * a).then_some(if elastic { 0.0 } else { span })
    }

    /// Limit for u²/a, the squared rebound speed divided by the acceleration, m, below which a run
    /// is closed.
    #[inline(always)]
    pub(super) fn chatter_closing_limit(&self) -> f64 {
        let loss = 1.0 - self.model.restitution;
        let part = if loss < LEAST_LOSS { 2.0 * LEAST_BOUNCE } else { 0.5 * loss * CHATTER };
        part * self.model.gap
    }

    /// Determines contact, departure and the due event from state, parameters and loads; called
    /// whenever one of these is set from outside.
    pub(super) fn classify_contact(&mut self) {
        let (gap, y) = (self.model.gap, &mut self.hybrid.y);
        let due = self.hybrid.due.take();
        (self.hybrid.departing, self.hybrid.departure) = (0, None);
        self.hybrid.contact = Contact::Flight;
        if y[1].abs() < gap {
            return;
        }
        if let Some(DueEvent::Impact { .. }) = due {
            self.hybrid.due = due; // the law of the impact decides, with the new values
            return;
        }
        let side = y[1].signum();
        if side * y[RELATIVE_RATE] > 0.0 {
            return; // an impact is due at once
        }
        if y[RELATIVE_RATE] != 0.0 {
            self.hybrid.departing = 1;
            return;
        }
        self.rest_or_depart(&self.augmented(), side);
    }

    /// Rest or departure at stop `side` with w' = 0.
    fn rest_or_depart(&mut self, z: &Augmented, side: f64) {
        let (series, certain) = self.flight_from_stop(z);
        let excess = series.excess_polynomial(side, self.model.gap);
        let first = certain.or_else(|| (2..9).find(|&k| excess[k] != 0.0));
        match first {
            Some(order) if excess[order] < 0.0 => {
                self.hybrid.contact = Contact::Flight;
                (self.hybrid.departing, self.hybrid.doubtful) = (order as u8, certain.is_none());
            }
            // The block is pressed to the stop, or has no motion at all relative to the box.
            _ => {
                (self.hybrid.contact, self.hybrid.departing) = (Contact::at(side), 0);
            }
        }
    }
}
