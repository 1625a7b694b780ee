//! Whether a fitted motion is the record's: compares residuals with the noise.

use super::beside::Beside;
use super::evaluated::{Point, Reach};
use super::loss::Loss;
use super::model::Model;
use super::statistics::{correlated, interval, persistence, size};
use crate::error::Result;
use crate::significant;
use std::fmt;

/// Limits of the ratio of residuals to noise. If the noise is estimated from differences of the
/// record, the motion fits up to `FITS`. If the noise is given, only chance deviations are
/// permitted. Above `MISSES` the motion never fits.
const FITS: f64 = 1.05;
const MISSES: f64 = 2.5;
/// Ratio of residuals to estimated noise at which a search strategy ends: restarts improve the
/// point further.
const NEARLY: f64 = 1.3;
/// Chance deviation of a root mean square, in standard deviations: one exact record in 700 exceeds
/// it.
const CHANCE: f64 = 3.0;
/// Variance of the median of |x| relative to the root mean square's, for normal samples.
const MEDIAN: f64 = 2.72;
/// Chance deviation, in standard deviations, if the noise is estimated from differences of the
/// record. Such an estimate is less accurate than a root mean square.
const VAGUE: f64 = 5.0;
/// Correlation of successive residuals above which they are more than noise.
const FOLLOWS: f64 = 0.3;
/// Part of the variance that earlier residuals may explain; above it, residuals are more than
/// noise. `SHARE` is for the verdict, `SEARCHED` for the end of the search. In wrong minima, with
/// the true motion 10 % better, the part was 8 % or more.
const SHARE: f64 = 0.05;
const SEARCHED: f64 = 0.02;
/// Size of an outlier, in standard deviations of the residuals: a robust loss limits residuals to
/// it before they are tested.
const OUTLIER: f64 = 3.0;
/// Deviation of the explained part, in standard deviations: up to `WHITE` residuals are white; one
/// white record in 6000 exceeds `COLOURED` (χ² of 40 lags).
const WHITE: f64 = 2.0;
const COLOURED: f64 = 4.5;
/// Sample size above which white residuals give the noise better than differences do. The estimate
/// from differences may then be off by twice the chance variation.
const MANY: usize = 200;
/// Deviation of contact times, relative to their mean interval: up to `MET` it counts as noise if
/// no noise is given; above `APART` the motion is a different one. Contacts of a wrong motion are
/// off by a quarter of the interval on average.
const MET: f64 = 0.01;
const APART: f64 = 0.25;
/// Smallest noise of a column, relative to its size: in a record without noise, the differences
/// are rounding.
const LEAST: f64 = 1e-6;

/// Whether a fitted motion is the record's.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Residuals are noise, and no restart near the fitted parameters finds another minimum as
    /// good.
    Fits,
    /// Residuals exceed noise, for the reason given: the standard errors hold for a motion other
    /// than the record's.
    Misses(String),
    /// Neither is certain, for the reason given.
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
    /// Verdict for a fit that its observer has ended.
    pub(super) fn ended() -> Self {
        Self::Undecided("ended by hand, with the best values so far".into())
    }
}

impl Model<'_> {
    /// Whether the motion of a point is the record's, or so near that restarts can reach it.
    pub(super) fn fits(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Ok(self.judged(&self.beside(point, reach)?, (NEARLY, FOLLOWS, SEARCHED)) == Verdict::Fits)
    }

    /// Whether residuals exceed what chance permits for white noise.
    pub(super) fn misses(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Ok(self.judged(&self.beside(point, reach)?, (1.0, 0.0, 0.0)) != Verdict::Fits)
    }

    /// Whether the residuals of all columns exceed the rounding of a record without noise.
    pub(super) fn is_noisy(&self, point: &Point, reach: &Reach) -> Result<bool> {
        let beside = self.beside(point, reach)?;
        let mut all = self.measured.columns.iter().enumerate();
        Ok(all.all(|(k, (_, values))| self.spread(beside.residuals(k)) > LEAST * size(values)))
    }

    /// Verdict from the residuals alone.
    pub(super) fn verdict(&self, beside: &Beside) -> Verdict {
        self.judged(beside, (FITS, FOLLOWS, SHARE))
    }

    /// Verdict from residuals for given limits: on the ratio of residuals to estimated noise, on
    /// the correlation of successive residuals, and on the part that earlier residuals explain.
    fn judged(&self, beside: &Beside, (limit, follows, explained): (f64, f64, f64)) -> Verdict {
        let mut doubt = None;
        for (k, (name, values)) in self.measured.columns.iter().enumerate() {
            let (spread, least) = (self.spread(beside.residuals(k)), LEAST * size(values));
            let times = spread / self.noise_of(k).max(least);
            let most = if self.loss == Loss::Linear { f64::INFINITY } else { OUTLIER * spread };
            let all: Vec<f64> = beside.residuals(k).map(|r| r.clamp(-most, most)).collect();
            let found = correlated(&all);
            let is_white = values.len() >= MANY && found.deviations < WHITE;
            // If there are few samples, differences give a less certain estimate than a root mean
            // square.
            let share = match (self.has_sigma, is_white) {
                (true, _) => self.chance(),
                (false, true) => 2.0 * VAGUE,
                (false, false) => VAGUE,
            };
            let chance = 1.0 + share / (values.len() as f64).sqrt();
            let allowed = if self.has_sigma { chance } else { limit.max(chance) };
            let many = format!("the residuals of {name} are {} times its noise", significant(times));
            if times > MISSES.max(chance) {
                return Verdict::Misses(many);
            }
            // Residuals at the rounding level are correlated because the record was rounded.
            let follow = if spread > least { persistence(beside.residuals(k)) } else { 0.0 };
            if times > allowed {
                doubt.get_or_insert(many);
            } else if follow > f64::max(follows, CHANCE / (values.len() as f64).sqrt()) {
                doubt.get_or_insert(format!("successive residuals of {name} are correlated, by {follow:.2}"));
            } else if spread > least && found.share > explained && found.deviations > COLOURED {
                let percent = significant((100.0 * found.share).round());
                doubt.get_or_insert(format!(
                    "earlier residuals of {name} explain {percent} % of the variance of later ones"
                ));
            }
        }
        for (k, (name, times)) in self.measured.contacts.iter().enumerate() {
            let off = self.contacts_off(beside, k);
            if off.len() < times.len() {
                let lacks = times.len() - off.len();
                return Verdict::Misses(format!(
                    "{lacks} of {} contacts of {name} have no contact of the fitted motion",
                    times.len()
                ));
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
                    "successive time differences of contacts of {name} are correlated, by {follow:.2}"
                ));
            }
        }
        doubt.map_or(Verdict::Fits, Verdict::Undecided)
    }

    /// Chance variation of a residual's deviation: its relative excess over the noise.
    fn chance(&self) -> f64 {
        let variance = if self.loss == Loss::Linear { 0.5 } else { 0.5 * MEDIAN };
        CHANCE * variance.sqrt()
    }

    /// Objection to a motion from the deviation of a list of contact times. Without a given noise
    /// this deviation is its only estimate: differences of contact times are not noise.
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
                Some(Verdict::Undecided(why() + "; give the noise by --sigma contacts=TIME for a verdict"))
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
