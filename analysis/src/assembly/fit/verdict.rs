//! Whether a fitted motion is the record's: its residuals beside the noise, and other minima.

use super::beside::Beside;
use super::evaluated::{Point, Reach};
use super::model::Model;
use super::statistics::{interval, persistence, size};
use crate::error::Result;
use crate::significant;
use std::fmt;

/// Residuals, in units of the noise, up to which a motion fits, and above which it does not.
const FITS: f64 = 1.3;
const MISSES: f64 = 2.5;
/// Standard deviations of a root mean square, by which few residuals may be larger.
const CHANCE: f64 = 3.0;
/// Standard deviations where differences say the noise, which is the least of several orders.
const VAGUE: f64 = 5.0;
/// Correlation of a residual with the next one above which residuals are more than noise.
const FOLLOWS: f64 = 0.3;
/// Noise of contacts' times, in parts of their interval, where it is not given.
const MET: f64 = 0.01;
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

impl Model<'_> {
    /// Whether the motion of a point is the record's.
    pub(super) fn fits(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Ok(self.verdict(&self.beside(point, reach)?) == Verdict::Fits)
    }

    /// What residuals say of a motion beside the record.
    pub(super) fn verdict(&self, beside: &Beside) -> Verdict {
        let mut doubt = None;
        for (k, (name, values)) in self.measured.columns.iter().enumerate() {
            let noise = self.noise_of(k).max(LEAST * size(values));
            let times = self.spread(beside.residuals(k)) / noise;
            // What differences say of few samples is vaguer than a root mean square.
            let share = if self.has_sigma { CHANCE / 2f64.sqrt() } else { VAGUE };
            let chance = 1.0 + share / (values.len() as f64).sqrt();
            let many = format!("the residuals of {name} are {} times its noise", significant(times));
            if times > MISSES.max(chance) {
                return Verdict::Misses(many);
            }
            let follow = persistence(beside.residuals(k));
            if times > FITS.max(chance) {
                doubt.get_or_insert(many);
            } else if follow > FOLLOWS.max(CHANCE / (values.len() as f64).sqrt()) {
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
            let limit = self.deviation_of_contacts(k).unwrap_or(MET * interval(times));
            let many = self.spread(off.iter().copied()) / limit;
            let chance = 1.0 + CHANCE / (2.0 * times.len() as f64).sqrt();
            if many > MISSES.max(chance) {
                let many = significant(many);
                return Verdict::Misses(format!("contacts of {name} are off by {many} times what they may"));
            }
            let follow = persistence(off.into_iter());
            if follow > FOLLOWS.max(CHANCE / (times.len() as f64).sqrt()) {
                doubt.get_or_insert(format!(
                    "times of contacts of {name} are off alike, with a correlation of {follow:.2}"
                ));
            }
        }
        doubt.map_or(Verdict::Fits, Verdict::Undecided)
    }
}
