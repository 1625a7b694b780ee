//! Whether a fitted motion is the record's: its residuals beside the noise, and other minima.

use super::beside::Beside;
use super::evaluated::{Point, Reach};
use super::loss::Loss;
use super::model::Model;
use super::statistics::{interval, persistence, size};
use crate::error::Result;
use crate::significant;
use std::fmt;

/// Residuals, in units of a noise that the record's differences say, up to which a motion fits, and
/// in units of any noise, above which it does not. Of a given noise chance alone is allowed.
const FITS: f64 = 1.05;
const MISSES: f64 = 2.5;
/// Residuals, in units of such a noise, at which the search of a way ends: starts beside the point
/// lead on from there.
const NEARLY: f64 = 1.3;
/// Standard deviations of a root mean square, by which residuals may be larger: one exact record in
/// 700 is beyond.
const CHANCE: f64 = 3.0;
/// Variance of a median of sizes over that of a root mean square of as many normal numbers.
const MEDIAN: f64 = 2.72;
/// Standard deviations where differences say the noise, which tell it less well than a root mean
/// square.
const VAGUE: f64 = 5.0;
/// Correlation of a residual with the next one above which residuals are more than noise.
const FOLLOWS: f64 = 0.3;
/// Deviation of contacts' times, in parts of their interval, up to which it is taken for noise
/// where that is not given, and above which contacts are those of another motion: a wrong one lies
/// a quarter of the interval off in the mean, wherever it is.
const MET: f64 = 0.01;
const APART: f64 = 0.25;
/// Least noise of a column, in parts of its size: differences of records without noise are
/// rounding.
const LEAST: f64 = 1e-6;

/// Whether a fitted motion is the record's.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Residuals are noise, and no start beside the fitted numbers leads to another minimum as
    /// good.
    Fits,
    /// Residuals are more than noise, as these words say: errors hold for another motion than the
    /// record's.
    Misses(String),
    /// Neither is certain, as these words say.
    Undecided(String),
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fits => f.write_str("fits"),
            Self::Misses(why) => write!(f, "does not fit: {why}"),
            Self::Undecided(why) => write!(f, "undecided: {why}"),
        }
    }
}

impl Verdict {
    /// The verdict of a fit that its observer has ended.
    pub(super) fn ended() -> Self {
        Self::Undecided("ended by hand, with the best values so far".into())
    }
}

impl Model<'_> {
    /// Whether the motion of a point is the record's, or so near to it that starts beside the point
    /// lead to it.
    pub(super) fn fits(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Ok(self.judged(&self.beside(point, reach)?, (NEARLY, FOLLOWS)) == Verdict::Fits)
    }

    /// Whether residuals are more than chance leaves of white noise.
    pub(super) fn misses(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Ok(self.judged(&self.beside(point, reach)?, (1.0, 0.0)) != Verdict::Fits)
    }

    /// What residuals say of a motion beside the record.
    pub(super) fn verdict(&self, beside: &Beside) -> Verdict {
        self.judged(beside, (FITS, FOLLOWS))
    }

    /// What residuals say of a motion beside the record, with a limit in units of a noise that the
    /// record's differences say, and one of the correlation of a residual with the next one.
    fn judged(&self, beside: &Beside, (limit, follows): (f64, f64)) -> Verdict {
        let mut doubt = None;
        for (k, (name, values)) in self.measured.columns.iter().enumerate() {
            let (spread, least) = (self.spread(beside.residuals(k)), LEAST * size(values));
            let times = spread / self.noise_of(k).max(least);
            // What differences say of few samples is vaguer than a root mean square.
            let share = if self.has_sigma { self.chance() } else { VAGUE };
            let chance = 1.0 + share / (values.len() as f64).sqrt();
            let allowed = if self.has_sigma { chance } else { limit.max(chance) };
            let many = format!("the residuals of {name} are {} times its noise", significant(times));
            if times > MISSES.max(chance) {
                return Verdict::Misses(many);
            }
            // Residuals within rounding of the record follow each other as it was rounded.
            let follow = if spread > least { persistence(beside.residuals(k)) } else { 0.0 };
            if times > allowed {
                doubt.get_or_insert(many);
            } else if follow > f64::max(follows, CHANCE / (values.len() as f64).sqrt()) {
                doubt.get_or_insert(format!(
                    "residuals of {name} follow each other, with a correlation of {follow:.2}"
                ));
            }
        }
        for (k, (name, times)) in self.measured.contacts.iter().enumerate() {
            let off = self.contacts_off(beside, k);
            if off.len() < times.len() {
                let lacks = times.len() - off.len();
                return Verdict::Misses(format!("{lacks} of {} contacts of {name} have none", times.len()));
            }
            let spread = self.spread(off.iter().copied());
            match self.contacts_off_by(k, spread, times) {
                Some(Verdict::Undecided(why)) => _ = doubt.get_or_insert(why),
                Some(verdict) => return verdict,
                None => {}
            }
            let follow = persistence(off.into_iter());
            if follow > f64::max(follows, CHANCE / (times.len() as f64).sqrt()) {
                doubt.get_or_insert(format!(
                    "times of contacts of {name} are off alike, with a correlation of {follow:.2}"
                ));
            }
        }
        doubt.map_or(Verdict::Fits, Verdict::Undecided)
    }

    /// Part by which the deviation of one residual may be larger than its noise by chance.
    fn chance(&self) -> f64 {
        let variance = if self.loss == Loss::Linear { 0.5 } else { 0.5 * MEDIAN };
        CHANCE * variance.sqrt()
    }

    /// What the deviation of a list of contacts' times says against a motion. Without a given noise
    /// it is itself the only measure of it: a contact has no neighbour whose difference is noise.
    fn contacts_off_by(&self, list: usize, spread: f64, times: &[f64]) -> Option<Verdict> {
        let name = &self.measured.contacts[list].0;
        let chance = 1.0 + CHANCE / (2.0 * times.len() as f64).sqrt();
        let Some(noise) = self.deviation_of_contacts(list) else {
            let part = spread / interval(times);
            let why = || {
                let (off, percent) = (significant(spread), significant(100.0 * part));
                format!("contacts of {name} are off by {off} s, {percent} % of their interval")
            };
            return if part > APART {
                Some(Verdict::Misses(why()))
            } else if part > MET * FITS.max(chance) {
                Some(Verdict::Undecided(why() + "; --sigma contacts=TIME tells whether this is noise"))
            } else {
                None
            };
        };
        let (allowed, times) = (1.0 + self.chance() / (times.len() as f64).sqrt(), spread / noise);
        let why = || format!("contacts of {name} are off by {} times their noise", significant(times));
        if times > MISSES.max(chance) {
            Some(Verdict::Misses(why()))
        } else {
            (times > allowed).then(|| Verdict::Undecided(why()))
        }
    }
}
