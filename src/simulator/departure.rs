//! The first moments of a departure from a stop, while w still rounds to the stop.
//!
//! The state at such a moment shows the block's motion only inaccurately or not at all, since the
//! motion is lost in rounding. So a sub-step from there begins at the departure itself, where w
//! and the vanishing derivatives are exact (docs/numerics.md, section 2).

use super::{HybridState, Simulator};
use crate::energy::{Pending, Sums};
use crate::flow::{Series, shifted};
use crate::model::{
    Augmented, BOX, BOX_RATE, Forces, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE, SmoothMode,
};
use serde::{Deserialize, Serialize};
use vibro_numerics::double_double::DoubleDouble;

/// Rounding of a derivative of w; a larger derivative is certain. For order k the unit is k² ε rᵏ
/// S, with the size S of docs/numerics.md, section 1. The value is twice the rounding of w'',
/// which is a sum of some eight products of rounded coordinates.
const CERTAIN: f64 = 4.0;

/// Moment, less than a sub-step ago, at which the block left a stop, while w still rounds to that
/// stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Departure {
    pub(super) time: DoubleDouble,
    pub(super) z: Augmented,
    /// Gain of input and damped energy from the departure to the present, J.
    pub(super) gained: [f64; 2],
}

/// A sub-step that begins at a departure.
pub(super) struct Departing {
    from: Departure,
    order: u8,
    /// Input and damped energy at the departure, J.
    accounts: [DoubleDouble; 2],
    /// Moment at which the sub-step would otherwise have begun.
    present: Present,
}

/// Moment of a motion, with its energy accounts.
struct Present {
    time: DoubleDouble,
    z: Augmented,
    sums: Sums,
    pending: Pending,
}

impl Simulator {
    /// Whether the next sub-step begins at a departure that must be stored. It must be stored if w
    /// may still round to the stop after the sub-step, which takes at most `remaining` s.
    #[inline(always)]
    pub(super) fn is_departing(&self, remaining: f64) -> bool {
        match self.hybrid.departing {
            0 => false,
            1 => remaining <= self.interval() || self.hybrid.departure.is_some(),
            _ => true,
        }
    }

    /// Whether the block leaves a stop with w' = 0 and all derivatives of w are within rounding.
    #[inline(always)]
    pub(super) fn is_doubtful(&self) -> bool {
        self.hybrid.departing > 1 && self.hybrid.doubtful
    }

    /// Returns to the departure, or begins one at the present state if none is stored; `z` becomes
    /// the state at the departure.
    #[cold]
    #[inline(never)]
    pub(super) fn return_to_departure(&mut self, z: &mut Augmented) -> Departing {
        let Self { hybrid: HybridState { time, sums, .. }, pending, .. } = *self;
        let present = Present { time, z: *z, sums, pending };
        let here = Departure { time, z: *z, gained: [0.0; 2] };
        let from = self.hybrid.departure.take().unwrap_or(here);
        (self.hybrid.time, *z) = (from.time, from.z);
        // Without energy accounts (also while a batch reports) the gain is not subtracted, because
        // the sub-step would not add it again.
        if self.keeps_energy_accounts {
            let sums = &mut self.hybrid.sums;
            (sums.input, sums.damped) = (sums.input.plus(-from.gained[0]), sums.damped.plus(-from.gained[1]));
        }
        // A doubtful departure may now be certain and have another order.
        if self.is_doubtful()
            && let (_, Some(order)) = self.flight_from_stop(z)
        {
            (self.hybrid.departing, self.hybrid.doubtful) = (order as u8, false);
        }
        Departing { from, order: self.hybrid.departing, accounts: self.accounts(), present }
    }

    /// Ends a sub-step that began at a departure. The next sub-step begins at the same departure
    /// if the sub-step reached `end`, if w still rounds to the stop, and if the departure is less
    /// than a sub-step ago.
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
            // An earlier sub-step found no event before the present. Because of different
            // rounding, this sub-step may find one. The event then takes place at the present.
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

    /// Flight from a stop at which w' = 0. Returns the series of the flight over the time 1/r, and
    /// the order (2 to 8) of the first derivative of w that is larger than rounding.
    pub(super) fn flight_from_stop(&self, z: &Augmented) -> (Series<9>, Option<usize>) {
        let forces = self.forces_now();
        let radius = 1.0 / self.model.rate;
        let series = Series::<9>::expand(&self.model, SmoothMode::Flight, z, Some(&forces), radius);
        // Limit of rounding for the derivative of order k, divided by k².
        let mut rounding = CERTAIN * f64::EPSILON * self.largest_acceleration(z, &forces);
        let certain = (2..9).find(|&k| {
            let certain = series.free[k - 2].abs() > (k * k) as f64 * rounding;
            rounding /= (k - 1) as f64;
            certain
        });
        (series, certain)
    }

    /// Size r² S of the terms of an acceleration (docs/numerics.md, section 1). The terms may
    /// cancel.
    fn largest_acceleration(&self, z: &Augmented, forces: &Forces) -> f64 {
        let model = &self.model;
        let place = model.gap + z[BOX].abs().max(z[SECONDARY].abs());
        let rate = z[BOX_RATE].abs().max(z[SECONDARY_RATE].abs()).max(z[RELATIVE_RATE].abs());
        let own = model.rate * (model.rate * place + rate) + model.drive.abs();
        if !self.loaded() {
            return own;
        }
        // The size of a load is the sum of d_j/rʲ over the orders j. The number d_j is the larger
        // of the size of the load's present derivative of order j and the sum of the sizes of this
        // derivative's terms, which are powers of the time since the load was set.
        let since = self.hybrid.time.minus(self.hybrid.loads_from).value().abs();
        let terms = shifted(&self.hybrid.loads.map(|f| f.map(f64::abs)), since);
        let load = |now: &[f64; 4], terms: &[f64; 4]| {
            let orders = now.iter().zip(terms).rev();
            orders.fold(0.0, |sum, (now, terms)| sum / model.rate + now.abs().max(*terms))
        };
        let loads = forces.iter().zip(&terms).zip(&model.inverse_mass);
        own + loads.map(|((now, terms), inverse)| load(now, terms) * inverse).sum::<f64>()
    }

    /// Input and damped energy, pending sums included, J.
    fn accounts(&self) -> [DoubleDouble; 2] {
        let mut sums = self.hybrid.sums;
        sums.settle(&mut self.pending.clone());
        [sums.input, sums.damped]
    }
}
