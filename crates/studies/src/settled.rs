//! Attractor of a described machine's motion: period in returns to the section, class, largest
//! exponent.
//!
//! A period is decided on three conditions: states return, the [derivative of the
//! period](super::monodromy) shows that the orbit is near, and no part of the period would do. A
//! motion that seems to return in 2T next to a doubling is followed until it returns in T, or
//! until its two states are farther apart than the remaining way. A motion still undecided after
//! the largest number of returns is settling or not settled.

use super::flight::Flows;
use super::growth::{ALIGN, Growth};
use super::monodromy::{MARGINAL, Multipliers, Period, shift};
use super::oscillations::oscillations;
use super::returns::ReturnRecord;
use super::section::{Section, frequencies, last_period};
use super::variation::{Metric, Variation};
use crate::class::{MotionClass, OBSERVED, RETURN, SAME};
use crate::error::{Error, Result};
use crate::exponent::{ExponentSign, LargestExponent, ZERO_EXPONENT};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use vibro_machine::neutral::Neutral;
use vibro_machine::{Assembly, Motion};

/// Return, relative to the sizes of states, at which a motion need not be followed further.
const STEADY: f64 = 1e-9;
/// Returns between two checks whether a motion has settled.
const LOOK: u32 = 4;
/// Growth factor of the followed time between two computations of a period's derivative.
const AGAIN: f64 = 1.25;
/// Smallest distance of distinct states of an orbit, in units of the distance from the orbit.
const APART: f64 = 20.0;
/// Cap on the returns counted for an exponent, if returns are the slowest rate of the motion; then
/// the sign stays open. This number also decides that an exponent is zero, by [`ZERO_EXPONENT`].
const MOST_RETURNS: u32 = 3_300;
/// Cap on the growth of [`MOST_RETURNS`] if a natural oscillation is slower.
const SLOWER: f64 = 4.0;
/// Cap on the returns of an undecided motion.
const PROLONGED: u32 = 8_192;
/// Returns between two checks of an exponent's sign.
const BLOCK: u32 = 8;
/// Logarithm of the growth after which rounding becomes visible.
const PARTED: f64 = 20.0;
/// Distance from the orbit at which the exponent from a period's multiplier is exact.
const NEAR: f64 = 1e-9;

/// Attractor on which a motion has settled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// Period in returns, if there is one up to [`LONGEST`](crate::class::LONGEST).
    pub period: Option<u32>,
    /// Class of the motion.
    pub class: MotionClass,
    /// Largest exponent besides neutral ones, if it was computed and the class is decided. Before
    /// that it would be the exponent of the transient.
    pub exponent: Option<LargestExponent>,
    /// Impacts and first touches per return.
    pub contacts: f64,
    /// Whether at some time a stop stays closed or a friction element sticks.
    pub rests: bool,
    /// Mean time between returns, s.
    pub interval: f64,
    /// States of one period, SI: elongations and rates of elements, and phases of harmonics that
    /// the section does not fix.
    pub states: Vec<Vec<f64>>,
    /// Sizes of the numbers in `states`, SI.
    pub scales: Vec<f64>,
    /// Time between the section and `states`, s.
    pub shift: f64,
}

impl Settled {
    /// Whether two motions are on different attractors, by class, period or states. `None` if it
    /// is undecided, for example for two chaotic motions.
    pub fn differs(&self, other: &Self) -> Option<bool> {
        if !(self.class.is_decided() && other.class.is_decided()) {
            return None;
        }
        if self.class != other.class {
            return Some(true);
        }
        if self.period.is_none() || self.shift != other.shift {
            return None;
        }
        let scales: Vec<f64> = self.scales.iter().zip(&other.scales).map(|(a, b)| a.max(*b)).collect();
        let is_same = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).zip(&scales).all(|((a, b), scale)| (a - b).abs() <= SAME * scale)
        };
        Some(!other.states.iter().all(|theirs| self.states.iter().any(|mine| is_same(mine, theirs))))
    }
}

/// A motion that is followed from return to return.
struct Follower<'a> {
    motion: &'a mut Motion,
    section: Section,
    record: ReturnRecord,
    /// Number of returns followed.
    followed: u32,
    /// Number of returns followed before the derivative of the period is computed again.
    next_look: u32,
    /// Whether the orbit near which the motion seems to return was unstable at the last check.
    is_unstable: bool,
}

impl<'a> Follower<'a> {
    fn new(motion: &'a mut Motion, section: &Section) -> Self {
        let record = ReturnRecord::new(motion, section);
        Self { motion, section: *section, record, followed: 0, next_look: 0, is_unstable: false }
    }

    fn at_event(&self) -> bool {
        matches!(self.section, Section::Stop(_) | Section::Friction(_))
    }

    fn begin(&mut self) {
        self.record = ReturnRecord::new(self.motion, &self.section);
        let at_event = self.at_event();
        self.record.arrive(self.motion, at_event);
    }

    /// Continues to the next return.
    fn advance(&mut self) -> Result<()> {
        let record = &mut self.record;
        self.section.advance(self.motion, &mut |event| record.event(event))?;
        let at_event = self.at_event();
        self.record.arrive(self.motion, at_event);
        if self.record.returns.len() == 2 {
            let interval = self.record.interval();
            self.record.look_between(self.motion, interval);
        }
        self.followed += 1;
        Ok(())
    }

    /// The period with its derivative, if it is decided. This advances the motion by one period.
    fn period(&mut self, near: f64) -> Result<Option<(u32, Period)>> {
        if self.followed < self.next_look || self.record.is_beside {
            return Ok(None);
        }
        let Some(returns) = self.record.period(near) else { return Ok(None) };
        let mut after = self.motion.clone();
        let period = Period::follow(&mut after, &self.section, &self.record, returns)?;
        self.next_look = (f64::from(self.followed) * AGAIN) as u32 + LOOK;
        let parts = (2..=returns).filter(|factor| returns.is_multiple_of(*factor));
        let mut apart = parts.map(|factor| self.record.return_distance(returns / factor));
        let is_whole = apart.all(|apart| apart > APART * period.distance);
        // A motion that stays long on an unstable orbit is exactly on it, for example by symmetry.
        let growth = period.multiplier.map_or(0.0, f64::ln);
        let turns = self.record.returns.len() as f64 / f64::from(returns);
        let stays = near <= STEADY && turns * growth > PARTED;
        self.is_unstable = growth > MARGINAL && !stays;
        if period.distance > RETURN || !is_whole || self.is_unstable {
            return Ok(None);
        }
        *self.motion = after;
        Ok(Some((returns, period)))
    }

    /// Whether the motion seems periodic by its returns, on an orbit that is not unstable.
    fn seems_periodic(&self) -> bool {
        !self.is_unstable && self.record.period(RETURN).is_some()
    }

    /// Follows the motion until its period is decided, over at most [`OBSERVED`] returns.
    fn observe(&mut self) -> Result<Option<(u32, Period)>> {
        self.begin();
        for k in 1..=OBSERVED {
            self.advance()?;
            if k % LOOK == 0
                && let Some(found) = self.period(STEADY)?
            {
                return Ok(Some(found));
            }
        }
        if self.record.is_beside
            && let Some(section) = self.section.beside()
        {
            // Contacts at the section itself may come on either side of it.
            self.section = section;
            return self.observe();
        }
        self.period(RETURN)
    }

    /// Doubles the number of returns followed, or stops when the period is decided.
    fn prolong(&mut self) -> Result<Option<(u32, Period)>> {
        for k in 1..=self.followed {
            self.advance()?;
            self.record.shorten();
            if k % LOOK == 0
                && let Some(found) = self.period(STEADY)?
            {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }
}

/// Advances a motion over `discard` returns, or until it has settled.
///
/// # Errors
/// As [`Section::advance`].
pub fn discard(motion: &mut Motion, section: &Section, discard: u32) -> Result<()> {
    let mut follower = Follower::new(motion, section);
    for k in 1..=discard {
        follower.advance()?;
        if k % LOOK == 0 && follower.period(STEADY)?.is_some() {
            return Ok(());
        }
        follower.record.shorten();
    }
    Ok(())
}

/// Refuses a study of neighbouring motions for a machine that has none.
///
/// # Errors
/// [`Error::Described`] for a machine that moves as prescribed.
pub fn require_free(assembly: &Assembly) -> Result<()> {
    if assembly.system().states() > 0 {
        return Ok(());
    }
    let problem = format!(
        "{}: all bodies have prescribed motions; expected a machine with a free body, moved by forces",
        assembly.description.name
    );
    Err(Error::Described { problem })
}

/// Slowest rate of a motion, rad/s: the rate of its returns or of a slower natural oscillation.
fn slowest(motion: &Motion, interval: f64) -> f64 {
    let own = oscillations(motion.assembly().system()).into_iter();
    own.map(|frequency| TAU * frequency).fold(TAU / interval, f64::min)
}

/// Growth of a variation. It is counted until its sign is decided and at least `least` returns
/// have passed, or up to the largest number of returns.
fn growth(follower: &mut Follower<'_>, least: u32, threshold: f64) -> Result<Growth> {
    let motion = &mut *follower.motion;
    let assembly = motion.assembly().clone();
    let system = assembly.system();
    let metric = Metric::by_frequency(
        system.coordinates,
        system.places_of_first_order().len(),
        TAU / follower.record.interval(),
    );
    let neutral = Neutral::of(system);
    let mut variation = Variation::new(system, motion.mode(), metric, &neutral);
    let mut flows = Flows::default();
    let mut growth = Growth::default();
    variation.grown(shift(motion));
    let slower = ZERO_EXPONENT * TAU / follower.record.interval() / threshold;
    let most = least.max((f64::from(MOST_RETURNS) * slower.clamp(1.0, SLOWER)) as u32);
    for k in 1..=most + ALIGN as u32 {
        let from = motion.time();
        follower.section.follow(motion, &mut flows, &mut [&mut variation])?;
        growth.add(variation.grown(shift(motion)), motion.time() - from);
        if growth.is_lost() {
            break;
        }
        let decided = || growth.sign(threshold) != ExponentSign::Undecided;
        if k % BLOCK == 0 && growth.returns() >= least && decided() {
            break;
        }
    }
    Ok(growth)
}

/// Follows a periodic motion closer to its orbit. Returns the last two periods.
fn approach(follower: &mut Follower<'_>, (returns, first): (u32, Period)) -> Result<[Period; 2]> {
    let mut periods = [first; 2];
    let mut left = PROLONGED / 4;
    while periods[1].exponent().is_some() && left >= returns {
        // The error of the multipliers is proportional to the remaining distance from the orbit.
        if periods[1].distance <= NEAR && periods[1] != first {
            break;
        }
        let next = Period::follow(follower.motion, &follower.section, &follower.record, returns)?;
        let came_nearer = next.distance < periods[1].distance;
        periods = [periods[1], next];
        left -= returns;
        if !came_nearer && left < PROLONGED / 8 {
            break;
        }
    }
    Ok(periods)
}

/// Multipliers of the periodic orbit on which a motion has settled, from the derivatives of two
/// successive periods. `None` for a motion without a period.
///
/// # Errors
/// As [`Section::advance`].
pub(super) fn multipliers(motion: &mut Motion, section: &Section) -> Result<Option<[Multipliers; 2]>> {
    let mut follower = Follower::new(motion, section);
    let Some(found) = follower.observe()? else { return Ok(None) };
    approach(&mut follower, found)?;
    let Follower { motion, section, record, .. } = follower;
    let mut next = || Multipliers::follow(motion, &section, &record, found.0);
    let [first, second] = [next()?, next()?];
    Ok(first.zip(second).map(|(first, second)| [first, second]))
}

/// Exponent of a periodic motion, from its multipliers. If these are rounding, the exponent comes
/// from the growth of a variation.
fn periodic_exponent(
    follower: &mut Follower<'_>,
    (returns, first): (u32, Period),
    least: u32,
) -> Result<LargestExponent> {
    let periods = approach(follower, (returns, first))?;
    let Some(value) = periods[1].exponent() else {
        return Ok(growth(follower, least, f64::INFINITY)?.exponent());
    };
    let before = periods[0].exponent().unwrap_or(value);
    Ok(LargestExponent { value, error: (value - before).abs(), periods: returns })
}

/// The attractor that a motion approaches. If a motion has no period, its exponent is counted over
/// at least `exponents` returns, and its sign decides the class. If `exponents` is given, the
/// exponent of a periodic motion is computed as well.
///
/// # Errors
/// As [`Section::advance`].
pub fn settled(motion: &mut Motion, section: &Section, exponents: Option<u32>) -> Result<Settled> {
    if exponents.is_some() {
        require_free(motion.assembly())?;
    }
    let has_free = motion.assembly().system().states() > 0;
    let mut follower = Follower::new(motion, section);
    let mut period = follower.observe()?;
    let (mut class, mut exponent) = (MotionClass::Settling, None);
    while period.is_none() {
        let on_its_way = follower.seems_periodic();
        class = MotionClass::Settling;
        if !has_free {
            // Prescribed motions without a common period.
            class = MotionClass::QuasiPeriodic;
            break;
        }
        if !on_its_way {
            let d = &follower.motion.assembly().description;
            let has_periods = last_period(d).is_some() || frequencies(d).next().is_none();
            let threshold = ZERO_EXPONENT * slowest(follower.motion, follower.record.interval());
            let growth = growth(&mut follower, exponents.unwrap_or(0), threshold)?;
            exponent = Some(growth.exponent());
            let sign = growth.sign(threshold);
            class = MotionClass::by_sign(None, Some(sign), follower.record.is_approaching());
            if class == MotionClass::QuasiPeriodic && follower.record.drifts() {
                class = MotionClass::NotSettled;
            }
            if class == MotionClass::Settling && !has_periods {
                // Two frequencies without a common period leave a quasi-periodic motion.
                class = MotionClass::QuasiPeriodic;
            }
            follower.followed += growth.returns();
        }
        if class.is_decided() || follower.followed >= PROLONGED {
            break;
        }
        if on_its_way || class == MotionClass::Settling {
            period = follower.prolong()?;
        }
        if period.is_none() {
            period = follower.observe()?;
        }
    }
    if let Some((returns, found)) = period {
        class = MotionClass::Periodic(returns);
        exponent = match exponents {
            Some(least) => Some(periodic_exponent(&mut follower, (returns, found), least)?),
            None => None,
        };
    } else if follower.seems_periodic() {
        class = MotionClass::Settling;
    }
    Ok(follower.seen(period.map(|p| p.0), class, exponent))
}

impl Follower<'_> {
    /// The attractor from the record of the motion.
    fn seen(&self, period: Option<u32>, class: MotionClass, exponent: Option<LargestExponent>) -> Settled {
        let record = &self.record;
        let count = period.map_or(record.returns.len().saturating_sub(1), |n| n as usize).max(1);
        let last = &record.returns[record.returns.len().saturating_sub(count)..];
        let contacts = last.iter().map(|r| f64::from(r.contacts)).sum::<f64>() / last.len() as f64;
        let shown = if period.is_some() { last } else { &last[last.len() - 1..] };
        Settled {
            period,
            class,
            exponent: exponent.filter(|_| class.is_decided()),
            contacts,
            rests: record.rests,
            interval: record.interval(),
            states: shown.iter().map(|r| r.state.clone()).collect(),
            scales: record.scales(),
            shift: match self.section {
                Section::Shifted(_, shift) => shift,
                _ => 0.0,
            },
        }
    }
}

#[cfg(test)]
mod tests;
