//! The first moments of a departure from a stop, in which w still rounds to the stop.
//!
//! A state at such a moment tells only to rounding, or not at all, that the block is on its way
//! out. So a sub-step that would begin there begins at the departure itself, where w and the
//! derivatives that are zero are exactly so (docs/numerics.md, section 2).

use super::{HybridState, Simulator};
use crate::energy::{Pending, Sums};
use crate::flow::{Series, shifted};
use crate::model::{
    Augmented, BOX, BOX_RATE, Forces, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE, SmoothMode,
};
use crate::numerics::double_double::DoubleDouble;
use serde::{Deserialize, Serialize};

/// A derivative of w of order k larger than this times k², in ε rᵏ S with the size S of
/// docs/numerics.md, section 1, is no rounding: a w'' is a sum of some eight products, with the
/// rounding of the state's coordinates in them, and off by less than half of it.
const CERTAIN: f64 = 4.0;

/// Where the block has left the stop that w still rounds to, less than a sub-step ago.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Departure {
    pub(super) time: DoubleDouble,
    pub(super) z: Augmented,
    /// What input and damped energy have gained from there to the present, J.
    pub(super) gained: [f64; 2],
}

/// A sub-step that begins at a departure.
pub(super) struct Departing {
    from: Departure,
    order: u8,
    /// The accounts at the departure.
    accounts: [DoubleDouble; 2],
    /// Where the sub-step would have begun.
    present: Present,
}

/// A moment of a motion, with its accounts.
struct Present {
    time: DoubleDouble,
    z: Augmented,
    sums: Sums,
    pending: Pending,
}

impl Simulator {
    /// Whether the next sub-step, of at most `remaining` s, begins at a departure that has to be
    /// known at its end: its end may be so near that w still rounds to the stop.
    #[inline(always)]
    pub(super) fn is_departing(&self, remaining: f64) -> bool {
        match self.hybrid.departing {
            0 => false,
            1 => remaining <= self.interval() || self.hybrid.departure.is_some(),
            _ => true,
        }
    }

    /// Whether nothing but rounding moves a block that is at a stop without speed.
    #[inline(always)]
    pub(super) fn is_doubtful(&self) -> bool {
        self.hybrid.departing > 1 && self.hybrid.doubtful
    }

    /// Goes back to the departure, if the block has left a stop that w still rounds to; `z` becomes
    /// the state there.
    #[cold]
    #[inline(never)]
    pub(super) fn return_to_departure(&mut self, z: &mut Augmented) -> Departing {
        let Self { hybrid: HybridState { time, sums, .. }, pending, .. } = *self;
        let present = Present { time, z: *z, sums, pending };
        let here = Departure { time, z: *z, gained: [0.0; 2] };
        let from = self.hybrid.departure.take().unwrap_or(here);
        (self.hybrid.time, *z) = (from.time, from.z);
        // Where accounts are no longer kept, as while a batch reports, nothing would give it again.
        if self.keeps_energy_accounts {
            let sums = &mut self.hybrid.sums;
            (sums.input, sums.damped) = (sums.input.plus(-from.gained[0]), sums.damped.plus(-from.gained[1]));
        }
        // What nothing but rounding moved may have got a derivative beyond it by now, of another
        // order.
        if self.is_doubtful()
            && let (_, Some(order)) = self.flight_from_stop(z)
        {
            (self.hybrid.departing, self.hybrid.doubtful) = (order as u8, false);
        }
        Departing { from, order: self.hybrid.departing, accounts: self.accounts(), present }
    }

    /// Ends a sub-step that began at a departure. If it has come to `end`, and w still rounds to
    /// the stop there, the next one begins at the same departure, unless that is a whole sub-step
    /// ago.
    #[cold]
    #[inline(never)]
    pub(super) fn keep_departure(
        &mut self,
        z: &mut Augmented,
        begun: &Departing,
        passage: Option<f64>,
        end: DoubleDouble,
    ) {
        let Departing { from, order, accounts, present } = begun;
        if passage.is_some() {
            // Another way of rounding may find an event where none was found before: it takes place
            // at the present, and not in its past.
            if self.hybrid.time.minus(present.time).value() < 0.0 {
                *z = present.z;
                (self.hybrid.time, self.hybrid.sums, self.pending) =
                    (present.time, present.sums, present.pending);
            }
            return;
        }
        let stop = from.z[RELATIVE];
        let touches = z[RELATIVE] * stop.signum() >= self.model.gap;
        if touches && self.hybrid.time == end && end.minus(from.time).value() < self.substep {
            z[RELATIVE] = stop;
            let now = self.accounts();
            let gained = [0, 1].map(|account| now[account].minus(accounts[account]).value());
            self.hybrid.departing = *order;
            self.hybrid.departure = Some(Departure { gained, ..*from });
        }
    }

    /// The flight from a stop at which the block has no speed: its series over 1/r, and the order
    /// of the first derivative of w, from the second to the eighth, that is no rounding.
    pub(super) fn flight_from_stop(&self, z: &Augmented) -> (Series<9>, Option<usize>) {
        let forces = self.forces_now();
        let radius = 1.0 / self.model.rate;
        let series = Series::<9>::expand(&self.model, SmoothMode::Flight, z, Some(&forces), radius);
        let mut rounding = CERTAIN * f64::EPSILON * self.largest_acceleration(z, &forces); // of the order k, over k²
        let certain = (2..9).find(|&k| {
            let certain = series.free[k - 2].abs() > (k * k) as f64 * rounding;
            rounding /= (k - 1) as f64;
            certain
        });
        (series, certain)
    }

    /// r² S, which the terms of an acceleration are of (docs/numerics.md, section 1); they may
    /// cancel.
    fn largest_acceleration(&self, z: &Augmented, forces: &Forces) -> f64 {
        let model = &self.model;
        let place = model.gap + z[BOX].abs().max(z[SECONDARY].abs());
        let rate = z[BOX_RATE].abs().max(z[SECONDARY_RATE].abs()).max(z[RELATIVE_RATE].abs());
        let own = model.rate * (model.rate * place + rate) + model.drive.abs();
        if !self.loaded() {
            return own;
        }
        // Of loads that were set some time ago the terms of their polynomials, and of all of them
        // the derivatives over r.
        let since = self.hybrid.time.minus(self.hybrid.loads_from).value().abs();
        let terms = shifted(&self.hybrid.loads.map(|f| f.map(f64::abs)), since);
        let load = |now: &[f64; 4], terms: &[f64; 4]| {
            let orders = now.iter().zip(terms).rev();
            orders.fold(0.0, |sum, (now, terms)| sum / model.rate + now.abs().max(*terms))
        };
        let loads = forces.iter().zip(&terms).zip(&model.inverse_mass);
        own + loads.map(|((now, terms), inverse)| load(now, terms) * inverse).sum::<f64>()
    }

    /// Input and damped energy with what is pending.
    fn accounts(&self) -> [DoubleDouble; 2] {
        let mut sums = self.hybrid.sums;
        sums.settle(&mut self.pending.clone());
        [sums.input, sums.damped]
    }
}
