//! Classes of settled motions, and the limits for deciding them from returns.

use crate::exponent::ExponentSign;
use serde::{Deserialize, Serialize};

/// Drive periods over which a motion is observed.
pub const OBSERVED: u32 = 128;

/// Upper limit of recognized periods, in drive periods. [`OBSERVED`] contains four such periods.
pub const LONGEST: u32 = 32;

/// Tolerance of a return: largest change of a coordinate (units of L and L ω10) over a period.
/// After hundreds of periods the remaining transient is smaller, except near a bifurcation.
pub const RETURN: f64 = 1e-5;

/// Tolerance within which states from two motions count as states of one attractor. Different
/// attractors are farther apart.
pub(crate) const SAME: f64 = 1e-3;

/// Relation of two attractors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// Equal.
    Same,
    /// Each is the mirror image of the other.
    Mirror,
    /// Neither equal nor mirror images.
    Different,
    /// Neither has a period, and their windows are too short to decide whether they are the same.
    Undecided,
}

/// Class of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionClass {
    /// Repeats after this number of drive periods.
    Periodic(u32),
    /// Never repeats; two exponents are zero.
    QuasiPeriodic,
    /// λ1 > 0.
    Chaotic,
    /// Becomes periodic, since the largest exponent is negative or the returns come closer. No
    /// period is recognized yet: the transient has not ended, or the period exceeds [`LONGEST`].
    Settling,
    /// Undecided: the followed part has no period up to [`LONGEST`], and the exponent's sign is
    /// uncertain.
    NotSettled,
}

impl MotionClass {
    /// Name in tables: `1T`, `2T`, `quasi-periodic`, `chaotic`.
    pub fn name(self) -> String {
        match self {
            Self::Periodic(n) => format!("{n}T"),
            Self::QuasiPeriodic => "quasi-periodic".into(),
            Self::Chaotic => "chaotic".into(),
            Self::Settling => "periodic, settling".into(),
            Self::NotSettled => "not settled".into(),
        }
    }

    /// Whether the motion is periodic or becomes periodic.
    pub fn is_periodic(self) -> bool {
        matches!(self, Self::Periodic(_) | Self::Settling)
    }

    /// Whether the class would stay the same if the motion were followed further; false for a
    /// motion that is settling or not settled.
    pub fn is_decided(self) -> bool {
        !matches!(self, Self::Settling | Self::NotSettled)
    }

    /// Whether the class is decided and needs no second observation. A quasi-periodic class needs
    /// one: the motion may have left a slightly unstable orbit and reached another orbit while its
    /// exponent was measured.
    pub(crate) fn is_final(self) -> bool {
        self.is_decided() && self != Self::QuasiPeriodic
    }

    /// The class from the period, the sign of the largest exponent, and whether returns come
    /// closer.
    pub(crate) fn by_sign(period: Option<u32>, sign: Option<ExponentSign>, approaching: bool) -> Self {
        match (period, sign) {
            (Some(n), _) => Self::Periodic(n),
            (None, Some(ExponentSign::Positive)) => Self::Chaotic,
            (None, Some(ExponentSign::Negative)) => Self::Settling,
            (None, Some(ExponentSign::Zero)) if !approaching => Self::QuasiPeriodic,
            (None, Some(ExponentSign::Zero)) => Self::Settling,
            (None, Some(ExponentSign::Undecided) | None) => Self::NotSettled,
        }
    }
}

/// The smallest period n up to [`LONGEST`], in returns: each of the last 3 n returns equals the
/// return n earlier. At least 4 n returns are required.
pub(crate) fn least_period<R>(returns: &[R], same: impl Fn(&R, &R) -> bool) -> Option<u32> {
    (1..=LONGEST).take_while(|&n| 4 * n as usize <= returns.len()).find(|&n| {
        let lag = n as usize;
        let last = &returns[returns.len() - 4 * lag..];
        last[lag..].iter().zip(last).all(|(a, b)| same(a, b))
    })
}

/// Whether returns come closer. For some lag, the largest distance between a return and the return
/// that many steps earlier must decrease from each eighth of the record to the next.
pub(crate) fn comes_nearer<R>(returns: &[R], distance: impl Fn(&R, &R) -> f64) -> bool {
    const EIGHTHS: usize = 8;
    (1..=LONGEST as usize).take_while(|lag| lag + EIGHTHS <= returns.len()).any(|lag| {
        let (later, earlier) = (&returns[lag..], &returns[..returns.len() - lag]);
        let eighth = later.len().div_ceil(EIGHTHS);
        let gap = |(a, b): (&R, &R)| distance(a, b);
        let mut most = later
            .chunks(eighth)
            .zip(earlier.chunks(eighth))
            .map(|(later, earlier)| later.iter().zip(earlier).map(gap).fold(0.0, f64::max));
        let mut before = f64::INFINITY;
        // Stops at the first eighth whose largest distance has not decreased.
        most.all(|most| std::mem::replace(&mut before, most) > most)
    })
}
