//! Long sub-steps of a stiff machine whose fast motions have decayed or move no event function
//! (docs/assembly-law.md (A27)).

use super::passage::PassageSearch;
use super::{Hybrid, Motion, Scratch};
use crate::flow::{FlowTable, RUNGS};
use vibro_numerics::double_double::DoubleDouble;

impl Motion {
    /// Advances by 2, 4, 8, … sub-steps at once, ending before `goal`, if it is proved that no
    /// event function passes zero in them; returns whether it has advanced.
    #[inline(never)]
    pub(super) fn long_step(&mut self, goal: DoubleDouble) -> bool {
        let Self { tables, place, hybrid, scratch, assembly, .. } = self;
        let met = tables.at(*place);
        let table = &*met.table;
        let remaining = goal.minus(hybrid.time).value();
        if table.is_curved() {
            return false;
        }
        let Some(k) = safe_rung(table, hybrid, remaining, scratch) else { return false };
        let rung = table.rung(k);
        if hybrid.energy.are_kept() {
            hybrid.energy.add_long(met.powers(&assembly.system), k, table, hybrid.z.as_slice());
        }
        rung.at_end(hybrid.z.as_slice(), &scratch.rates, scratch.start.as_mut_slice());
        std::mem::swap(&mut hybrid.z, &mut scratch.start);
        hybrid.time = hybrid.time.plus(rung.length);
        hybrid.chain = 0;
        self.refill();
        self.hybrid.sizes.include(self.hybrid.z.as_slice());
        self.keep_contacts();
        self.watch_again(true);
        true
    }
}

/// Returns the longest rung that is shorter than `remaining` and free of passages: no event
/// function passes its limit in it. The bound value + slope t + bend t²/2 is convex: it is below
/// the limit throughout if it is below at both ends. Writes z' to the scratch memory.
fn safe_rung(table: &FlowTable, hybrid: &Hybrid, remaining: f64, scratch: &mut Scratch) -> Option<usize> {
    let z = hybrid.z.as_slice();
    let Scratch { rates, second, .. } = scratch;
    rates.resize(z.len(), 0.0);
    second.resize(z.len(), 0.0);
    table.rates(z, rates);
    table.rates(rates, second);
    let flight = PassageSearch { table, hybrid };
    let own = table.watched.iter().enumerate();
    // Value of an event function minus its limit; negative before an event.
    let beyond = |place: usize, value: f64| value - flight.limit(place);
    let stays_below = |value: f64, slope: f64, bend: f64, t: f64| value + t * (slope + 0.5 * bend * t) < 0.0;
    let longest = (1..RUNGS).take_while(|k| table.long_length(*k) < remaining).last()?;
    // The present second derivatives are not bounds, but they rule out lengths that are too long.
    let mut k = longest;
    for (place, w) in own.clone() {
        let (value, slope, bend) = (beyond(place, w.row.dot(z)), w.slope.dot(z), w.slope.dot(rates).abs());
        if flight.order(place) > 0 || value >= 0.0 {
            return None;
        }
        while !stays_below(value, slope, bend, table.long_length(k)) {
            k = k.checked_sub(1).filter(|k| *k > 0)?;
        }
    }
    let safe = |k: usize| {
        let rung = table.rung(k);
        own.clone().all(|(place, w)| {
            let value = beyond(place, w.row.dot(z));
            stays_below(value, w.slope.dot(z), rung.bend(place, second), rung.length)
        })
    };
    (1..=k).rev().find(|&k| safe(k))
}
