//! Early recognition of a motion that has settled on a period, so that the rest of the discarded
//! periods need not be simulated.
//!
//! First, at no cost, impacts must repeat: their sequence, times and speeds, summed over each
//! drive period. Then the states at whole drive periods decide. The verdict at the end would be
//! the same (docs/theory.md, "A settled motion is not simulated further").

use super::attractor::{StroboscopicRecord, appended, distance};
use super::stroboscopic::StroboscopicState;
use crate::class::{RETURN, SAME};

/// Upper limit of early recognized periods, in drive periods.
const LONGEST: u32 = 8;
/// Lower limit of the drive periods with repeated impacts.
const REPEATED: u32 = 16;
/// Number of drive periods with repeated impacts for the longest period.
const REMEMBERED: u32 = 4 * LONGEST;
/// Drive periods between checks of the impacts.
const CHECK: u32 = 4;
/// Tolerance for equal sums over two drive periods: sums of the speeds of the impacts (units of L
/// ω10) and of their times (drive periods).
const SIMILAR: f64 = 1e-6;
/// Difference that may be rounding and need not decrease.
const ROUNDING: f64 = 1e-11;
/// Lower limit for the fraction of its way to an orbit that a motion covers per period. Next to a
/// period doubling a motion approaches its orbit from alternating sides, and the fraction is the
/// ratio of returns after two periods and after one; below the limit the motion has twice the
/// period. Next to a symmetry breaking the mirrored return after half a period is used.
pub(crate) const LEAST_APPROACH: f64 = 1e-5;
/// Upper limit for the return of a settled motion, in units of L and L ω10. Returns that do not
/// grow add up, over the skipped drive periods, to at most this times their number.
const STEADY: f64 = 1e-7;
/// Lower limit for the number of returns in [`moves`].
const RETURNS: f64 = 1000.0;

/// Bound on the distance between a state and its near return after a number of returns. A shorter
/// period stays excluded through all of these returns if its return exceeds [`RETURN`] by more
/// than this bound. So does a mirror image that exceeds [`SAME`] by more than this bound.
fn moves(returns: f64) -> f64 {
    2.0 * returns.max(RETURNS) * STEADY
}

/// Impacts of one drive period.
#[derive(Clone, Copy, Debug, Default)]
struct PeriodImpacts {
    /// Sequence, encoded as a number.
    pattern: u64,
    /// Sum of the speeds, and of the times since the start of the period.
    sums: [f64; 2],
}

/// Impacts of the last drive periods of a motion.
#[derive(Debug, Default)]
pub(crate) struct ImpactRepetition {
    /// The last periods, each at its index modulo the length.
    periods: [PeriodImpacts; REMEMBERED as usize],
    /// Index of the current period.
    number: u32,
    open: PeriodImpacts,
}

impl ImpactRepetition {
    /// Forgets everything because another motion begins.
    pub(crate) fn clear(&mut self) {
        (self.number, self.open) = (0, PeriodImpacts::default());
    }

    /// Records an impact at `time` (drive periods since the start) with `speed` (in any unit of
    /// the machine). Returns the period with which the impacts before it repeat, if they do.
    pub(crate) fn impact(&mut self, time: f64, upper: bool, speed: f64) -> Option<u32> {
        let (number, before) = (time as u32, self.number);
        while self.number < number {
            self.periods[(self.number % REMEMBERED) as usize] = std::mem::take(&mut self.open);
            self.number += 1;
        }
        let PeriodImpacts { pattern, sums } = &mut self.open;
        *pattern = appended(*pattern, upper);
        sums[0] += speed;
        sums[1] += time - f64::from(number);
        if number / CHECK == before / CHECK { None } else { (1..=LONGEST).find(|&n| self.repeats(n)) }
    }

    /// Whether the last periods repeat after `lag` periods, more exactly in their later half than
    /// in their earlier half.
    fn repeats(&self, lag: u32) -> bool {
        let pairs = REPEATED.max(4 * lag) - lag;
        if self.number < pairs + lag {
            return false;
        }
        let at = |back: u32| &self.periods[((self.number - 1 - back) % REMEMBERED) as usize];
        let mut most = [0.0f64; 2]; // of the later half and of the earlier
        for back in 0..pairs {
            let (a, b) = (at(back), at(back + lag));
            let difference = a.sums.iter().zip(&b.sums).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if a.pattern != b.pattern || difference > SIMILAR {
                return false;
            }
            let half = &mut most[usize::from(2 * back >= pairs)];
            *half = half.max(difference);
        }
        most[0] <= most[1].max(ROUNDING)
    }
}

/// Motion whose impacts repeat, while its states are compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Confirmation {
    /// Period with which the impacts repeat.
    pub(crate) period: u32,
    /// Index of the first sample, in half drive periods.
    pub(crate) first: u32,
    /// State at the first sample.
    pub(crate) start: StroboscopicState,
}

impl Confirmation {
    /// Begins at `time` (drive periods since the start). The first sample is at the next whole
    /// period.
    pub(crate) fn new(period: u32, time: f64) -> Self {
        Self { period, first: 2 * (time as u32 + 1), start: [0.0; 6] }
    }

    /// Index of the last sample: after two periods of the motion.
    pub(crate) fn last(&self) -> u32 {
        self.first + 4 * self.period
    }

    /// Whether the motion has settled. States and sequence of impacts over the two periods since
    /// `start` must repeat with the period and with no shorter one, and must still do so after
    /// `left` drive periods. For a `symmetric` machine it must be decided whether the motion is
    /// its own mirror image.
    pub(crate) fn holds(&self, record: &StroboscopicRecord, left: u32, symmetric: bool) -> bool {
        let n = self.period as usize;
        let moves = moves(f64::from(left) / f64::from(self.period));
        let state = |k: usize| if k == 0 { &self.start } else { &record.periods[k - 1].state };
        let same = |lag: usize, k: usize, near: f64| distance(state(k), state(k + lag)) < near;
        let repeats = (0..=n).all(|k| same(n, k, STEADY))
            && (0..n).all(|k| record.periods[k].pattern == record.periods[k + n].pattern);
        // If a shorter period nearly fits, rounding would later decide whether it is found.
        let shorter = |lag: usize| (0..=2 * n - lag).all(|k| same(lag, k, RETURN + moves));
        let most = |lag| (0..=2 * n - lag).map(|k| distance(state(k), state(k + lag))).fold(0.0, f64::max);
        let alternates = |lag: usize| n.is_multiple_of(lag) && most(n) >= LEAST_APPROACH * most(lag);
        // The mirrored return after half of an odd period is either as exact, or too large to be a
        // part of an approach to a symmetric orbit.
        let half = record.mirror_distance(self.period);
        let decided = half < STEADY || (half > SAME + moves && most(n) < LEAST_APPROACH * half);
        repeats
            && (!symmetric || n.is_multiple_of(2) || decided)
            && !(1..n).any(|lag| shorter(lag) || alternates(lag))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of impacts after which repetition is found, and its period. The impacts have
    /// these speeds and come in the middle of each drive period.
    fn found(speed: impl Fn(f64) -> f64) -> Option<(u32, u32)> {
        let mut impacts = ImpactRepetition::default();
        (0..400).find_map(|k| Some((k, impacts.impact(f64::from(k) + 0.5, true, speed(f64::from(k)))?)))
    }

    #[test]
    fn closed_form_repetition_of_made_up_impacts() {
        use std::f64::consts::TAU;
        assert_eq!(found(|_| 0.3), Some((16, 1)));
        // The smallest period of the impacts, once four such periods have passed.
        assert_eq!(found(|k| (TAU * k / 4.0).cos()), Some((16, 4)));
        assert_eq!(found(|k| (TAU * k / 8.0).cos()), Some((32, 8)));
        assert_eq!(found(|k| (TAU * k / 9.0).cos()), None);
        assert_eq!(found(|k| (TAU * k * 0.381_966_011).cos()), None);
        // A transient: differences of (1 - q) times q^k are similar once the first of sixteen is
        // under 1e-6.
        let (at, n) = found(|k| 1.0 + 0.9f64.powf(k)).unwrap();
        assert!(n == 1 && (124..=132).contains(&at), "{at} {n}");
        // Near an unstable motion even the smallest differences grow.
        assert_eq!(found(|k| 1.0 + 1e-16 * 1.06f64.powf(k)).map(|f| f.1), Some(1), "round-off tells nothing");
        assert_eq!(found(|k| if k < 16.0 { k } else { 1.0 + 1e-10 * 1.06f64.powf(k) }), None);
    }

    #[test]
    fn closed_form_confirmation_of_made_up_states() {
        let mut record = StroboscopicRecord::default();
        let mut confirmed_of = |symmetric: bool, left: u32, period: u32, coordinate: &dyn Fn(f64) -> f64| {
            record.clear();
            let confirmation = Confirmation { period, first: 0, start: [coordinate(0.0); 6] };
            for j in 1..=confirmation.last() {
                record.sample(j, [coordinate(0.5 * f64::from(j)); 6]);
            }
            confirmation.holds(&record, left, symmetric)
        };
        // Symmetric motions: one; one that approaches its orbit from alternating sides in 10,000
        // periods; one that approaches too slowly to be noticed; and one so near that the verdict
        // at the end would be symmetric.
        let breaking = |size: f64, taken: f64| move |k: f64| size * (1.0 - taken).powf(2.0 * k);
        assert!(confirmed_of(true, 0, 3, &|k| (std::f64::consts::TAU * k / 3.0).cos()));
        assert!(
            !confirmed_of(true, 0, 1, &breaking(1e-3, 2e-5))
                && confirmed_of(true, 0, 1, &breaking(1e-3, 5e-6))
        );
        assert!(
            confirmed_of(false, 0, 1, &breaking(1e-3, 2e-5))
                && !confirmed_of(true, 0, 1, &breaking(4e-4, 5e-6))
        );
        let mut confirmed_for = |left: u32, period: u32, coordinate: &dyn Fn(f64) -> f64| {
            confirmed_of(false, left, period, coordinate)
        };
        // Nearly of period 1: the more periods are skipped, the farther it must be from period 1.
        let far = |size: f64| move |k: f64| size * (std::f64::consts::PI * k).cos();
        assert!(confirmed_for(2000, 2, &far(1.1e-4)) && !confirmed_for(8192, 2, &far(1.1e-4)));
        assert!(!confirmed_for(8192, 2, &far(4.1e-4)) && confirmed_for(8192, 2, &far(4.2e-4)));
        let mut confirmed =
            |period: u32, coordinate: &dyn Fn(f64) -> f64| confirmed_for(0, period, coordinate);
        let wave = |k: f64| (std::f64::consts::TAU * k / 3.0).cos();
        assert!(confirmed(1, &|_| 0.3) && confirmed(3, &wave));
        assert!(!confirmed(2, &|_| 0.3) && !confirmed(2, &wave) && !confirmed(6, &wave));
        assert!(!confirmed(1, &|k| 2e-7 * k) && confirmed(1, &|k| 0.5e-7 * k));
        // Nearly of period 1: the verdict at the end must decide.
        let nearly = |size: f64| move |k: f64| size * (std::f64::consts::PI * k).cos();
        assert!(!confirmed(2, &nearly(1e-4)) && confirmed(2, &nearly(1.1e-4)));
        // An approach from alternating sides to an orbit of period 1 in 10,000 periods, and one so
        // slow that it has period 2 for the whole observation.
        let turns =
            |taken: f64| move |k: f64| 4e-4 * (1.0 - taken).powf(k) * (std::f64::consts::PI * k).cos();
        assert!(!confirmed(2, &turns(1e-4)) && confirmed(2, &turns(1e-6)));
    }
}
