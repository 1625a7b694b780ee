//! Concentrations of residuals: in time, in the phase of the period, and after contacts.

use super::beside::Beside;
use super::model::Model;
use crate::{common_period, significant};
use std::fmt;
use vibro_machine::description::Description;

/// Number of equal windows over the record, and over the period.
const WINDOWS: usize = 20;
const PHASES: usize = 12;
/// Length of the window after a contact, relative to the mean interval between contacts.
const AFTER: f64 = 0.2;
/// Residuals count as concentrated in a window if its share of the squared residuals exceeds its
/// share of the samples by this factor. White residuals with a hundred samples per window reach
/// 1.5.
const CONCENTRATED: f64 = 2.0;
/// Smallest number of samples in a window.
const SAMPLES: usize = 5;

/// Part of the record with a concentration of residuals.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// From a time of the record to another, s.
    Time(f64, f64),
    /// From one phase to another, as fractions of the period, and the period, s. Phase 0 is at
    /// time 0 of the motion.
    Phase(f64, f64, f64),
    /// Within a time, s, after contacts of the named stop.
    After(String, f64),
}

/// Concentration of a column's residuals in a part of the record.
#[derive(Clone, Debug, PartialEq)]
pub struct Concentration {
    /// Column.
    pub column: String,
    /// Part of the record.
    pub place: Place,
    /// Share of the column's squared residuals in this part, and share of its samples.
    pub shares: (f64, f64),
}

impl fmt::Display for Concentration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (squares, samples) = (100.0 * self.shares.0, 100.0 * self.shares.1);
        write!(f, "{}: {squares:.0} % of the squared residuals are ", self.column)?;
        let rounded = |x: f64| significant(format!("{x:.3e}").parse().unwrap_or(x));
        match &self.place {
            Place::Time(from, to) => write!(f, "from {} s to {} s", rounded(*from), rounded(*to))?,
            Place::Phase(from, to, period) => {
                let period = rounded(*period);
                write!(f, "at {from:.2} to {to:.2} of the period of {period} s")?;
            }
            Place::After(stop, time) => write!(f, "within {} s after contacts of {stop}", rounded(*time))?,
        }
        write!(f, ", in {samples:.0} % of the samples")
    }
}

/// Window with the largest share of squared residuals, with this share and the share of samples;
/// `None` if residuals are not concentrated.
fn largest(all: impl Iterator<Item = (usize, f64)>, windows: usize) -> Option<(usize, (f64, f64))> {
    let (mut squares, mut samples) = (vec![0.0; windows], vec![0usize; windows]);
    for (window, residual) in all {
        squares[window.min(windows - 1)] += residual * residual;
        samples[window.min(windows - 1)] += 1;
    }
    let (whole, count) = (squares.iter().sum::<f64>(), samples.iter().sum::<usize>());
    let k = (0..windows).max_by(|&a, &b| squares[a].total_cmp(&squares[b]))?;
    let shares = (squares[k] / whole, samples[k] as f64 / count as f64);
    (samples[k] >= SAMPLES && shares.0 > CONCENTRATED * shares.1).then_some((k, shares))
}

impl Model<'_> {
    /// Concentrations of each column's residuals.
    pub(super) fn places_of(&self, beside: &Beside, d: &Description, shift: f64) -> Vec<Concentration> {
        let (times, mut found) = (&self.measured.times, Vec::new());
        let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
        let window = (last - first) / WINDOWS as f64;
        for (k, (name, _)) in self.measured.columns.iter().enumerate() {
            let mut add = |place: Place, shares: (f64, f64)| {
                found.push(Concentration { column: name.to_string(), place, shares });
            };
            let all = || times.iter().copied().zip(beside.residuals(k));
            let in_time = all().map(|(time, r)| (((time - first) / window) as usize, r));
            if let Some((k, shares)) = largest(in_time, WINDOWS) {
                let from = first + k as f64 * window;
                add(Place::Time(from, from + window), shares);
            }
            if let Some(period) = common_period(d).filter(|period| 2.0 * period < last - first) {
                let phase = |time: f64| ((time + shift) / period).rem_euclid(1.0);
                let in_phase = all().map(|(time, r)| ((phase(time) * PHASES as f64) as usize, r));
                if let Some((k, shares)) = largest(in_phase, PHASES) {
                    let [from, to] = [k, k + 1].map(|k| k as f64 / PHASES as f64);
                    add(Place::Phase(from, to, period), shares);
                }
            }
            for (i, stop) in d.stops.iter().enumerate() {
                let contacts = beside.events().filter(|(_, own)| *own == i).map(|(time, _)| *time);
                let contacts: Vec<f64> = contacts.collect();
                let within = AFTER * (last - first) / contacts.len().max(1) as f64;
                let is_after = |time: f64| {
                    let before = contacts.partition_point(|own| *own <= time);
                    before.checked_sub(1).is_some_and(|k| time - contacts[k] <= within)
                };
                let split = all().map(|(time, r)| (usize::from(is_after(time)), r));
                if let Some((1, shares)) = largest(split, 2) {
                    add(Place::After(stop.name.clone(), within), shares);
                }
            }
        }
        found
    }
}
