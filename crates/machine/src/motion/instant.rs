//! Instants: times that differ only by rounding. A time event is a knot of a signal, a sample of a
//! block, or the time at which a sample's outputs act. A time that precedes a time event by only
//! rounding counts as after it: a row, a step's end, a start, a point of a host's solver
//! (docs/assembly-law.md, section 16).

use super::Motion;
use crate::system::{Sampler, System};

/// Largest difference of times of one instant, in units in the last place. Products k·T, fractions
/// of an end time and decimal texts of one time differ by no more.
const INSTANT: f64 = 4.0;

/// Largest number of successive time events of one instant. It is exceeded only by samples as
/// close as neighbouring doubles.
const MOST: usize = 8;

/// Returns the latest time of the instant that contains `time`.
pub(crate) fn end_of_instant(time: f64) -> f64 {
    time + INSTANT * f64::EPSILON * time.abs()
}

impl Sampler {
    /// Returns the first time after `from` and up to `until`, both of one instant, at which the
    /// block reads its inputs or its outputs act.
    fn event_within(&self, from: f64, until: f64) -> Option<f64> {
        let nearest = |first: f64| Some(((from - first) / self.period).round()).filter(|k| *k >= 0.0);
        let reads = nearest(0.0).map(|k| self.time_of_sample(k as i64));
        let acts = nearest(self.delay).map(|k| self.time_of_acting(k as i64));
        reads.into_iter().chain(acts).filter(|time| from < *time && *time <= until).reduce(f64::min)
    }
}

impl System {
    /// Returns the last time event of the instant of a time; the time itself if no event is later.
    pub(crate) fn last_of_instant(&self, time: f64) -> f64 {
        let mut last = time;
        for _ in 0..MOST {
            let until = end_of_instant(last);
            let knot = self.signals.next_knot(last).filter(|knot| *knot <= until);
            let samplers = self.blocks.iter().filter_map(|own| own.sampler.as_ref());
            let samples = samplers.filter_map(|own| own.event_within(last, until));
            match knot.into_iter().chain(samples).reduce(f64::min) {
                Some(event) => last = event,
                None => break,
            }
        }
        last
    }
}

impl Motion {
    /// Whether a time event is still due up to the end of the instant that contains `time`.
    pub fn has_time_event_until(&self, time: f64) -> bool {
        self.next_time_event().is_some_and(|event| event <= end_of_instant(time))
    }

    /// The next knot of a signal after a time, if it is at the present instant.
    pub(super) fn knot_now(&self, after: f64) -> Option<f64> {
        let knot = self.assembly.system.signals.next_knot(after);
        knot.filter(|knot| *knot <= end_of_instant(self.time()))
    }

    /// Whether a block is sampled, or outputs act, at the present instant.
    pub(super) fn is_at_sample(&self) -> bool {
        self.next_sample().is_some_and(|sample| sample <= end_of_instant(self.time()))
    }
}
