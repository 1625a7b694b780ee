//! Phase of the drive in extended precision, without drift even in a long motion.

use super::double_double::DoubleDouble;
use serde::{Deserialize, Serialize};

/// 2π to 32 digits.
const TAU: DoubleDouble = DoubleDouble { hi: std::f64::consts::TAU, lo: 2.449_293_598_294_706_4e-16 };
/// 1/(2π) to 32 digits.
const INVERSE_TAU: DoubleDouble =
    DoubleDouble { hi: 0.159_154_943_091_895_35, lo: -9.839_338_440_020_25e-18 };

/// Bound on the times of motions, s: 1e15 time constants of a slow motion.
const LATEST: f64 = 1e30;

/// Phase of the drive in turns, `turns(t) = base + ω (t - from)/2π`, re-based if ω changes so that
/// it stays continuous.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivePhase {
    base: DoubleDouble,
    from: DoubleDouble,
}

/// Turns of a phase in rad. For the largest doubles, 32 digits of π are not enough: they are
/// reduced by the standard library's sine and cosine.
fn turns_of(phase: f64) -> DoubleDouble {
    const PLAIN: f64 = 1e9;
    let phase = if phase.abs() <= PLAIN { phase } else { phase.sin().atan2(phase.cos()) };
    DoubleDouble::new(phase).times(INVERSE_TAU)
}

impl DrivePhase {
    /// Phase of `sin(ω t + phase)`.
    pub fn new(phase: f64) -> Self {
        Self { base: turns_of(phase).fraction(), from: DoubleDouble::default() }
    }

    #[inline(always)]
    fn turns(&self, omega: f64, time: DoubleDouble) -> DoubleDouble {
        let rate = INVERSE_TAU.times(DoubleDouble::new(omega));
        (time.minus(self.from).times(rate) + self.base).fraction()
    }

    /// Phase in [-π, π], rad.
    #[inline(always)]
    pub fn angle(&self, omega: f64, time: DoubleDouble) -> f64 {
        self.turns(omega, time).times(TAU).value()
    }

    /// Whether base and time are in their ranges: a base of at most one turn, and a time that a
    /// motion can reach. Always true for an undamaged phase.
    pub fn is_sound(&self) -> bool {
        let within = |e: &DoubleDouble, most: f64| e.hi.abs() <= most && e.lo.abs() <= e.hi.abs();
        within(&self.base, 1.0) && within(&self.from, LATEST)
    }

    /// Re-bases the phase at `time`, up to which the frequency was `omega`; the caller then uses
    /// another frequency. Adds the change from the drive phase `from` to `to`, rad.
    pub fn rebase(&mut self, omega: f64, time: DoubleDouble, (from, to): (f64, f64)) {
        let shift = turns_of(to).minus(turns_of(from));
        self.base = (self.turns(omega, time) + shift).fraction();
        self.from = time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance: a few units in the last place of an angle of order 1, and of its 2π.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn closed_form_phase_after_a_million_periods() {
        // For a frequency that is a power of two, t = n 2π/ω in extended precision is exactly n
        // periods.
        let omega = 0.5;
        let time = TAU.times(DoubleDouble::new(2.0 * 1_000_000.0)).plus(0.25);
        let angle = DrivePhase::new(1.0).angle(omega, time);
        assert!((angle - 1.125).abs() < ROUNDING, "{angle}");
    }

    #[test]
    fn invariant_a_change_of_frequency_keeps_the_phase() {
        let mut phase = DrivePhase::new(0.3);
        let time = DoubleDouble::new(123_456.789);
        let before = phase.angle(1.04, time);
        phase.rebase(1.04, time, (0.3, 0.3));
        assert!((phase.angle(7.0, time) - before).abs() < ROUNDING);
    }

    #[test]
    fn closed_form_phases_of_any_size() {
        let far = [1e9, -3e12, 1e22, -9.2e305, f64::MAX];
        for from in far {
            let (sine, cosine) = DrivePhase::new(from).angle(1.0, DoubleDouble::default()).sin_cos();
            assert!(
                (sine - from.sin()).abs() < ROUNDING && (cosine - from.cos()).abs() < ROUNDING,
                "{from:e}"
            );
            for to in far {
                let mut phase = DrivePhase::new(from);
                phase.rebase(1.0, DoubleDouble::new(0.0), (from, to));
                let sine = phase.angle(1.0, DoubleDouble::default()).sin();
                assert!((sine - to.sin()).abs() < ROUNDING, "{from:e} {to:e}");
            }
        }
    }
}
