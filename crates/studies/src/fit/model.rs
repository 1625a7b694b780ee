//! A machine beside a record: how far its motion keeps near it, and what is fitted in the end.

use super::beside::{Beside, Compared, Followed};
use super::checks::EARLY;
use super::evaluated::{Evaluated, Point, Reach, Solved};
use super::loss::Loss;
use super::progress::Watch;
use super::statistics::{deviation, deviations, interval, noise, rms, rounding, size, typical};
use super::unknowns::Unknowns;
use super::{FitRequest, Measured, Way};
use crate::QuantityName;
use crate::error::{Error, Result};
use std::sync::Arc;

/// Samples of which more than half may be outliers by chance.
const FEW: usize = 8;
/// Noise of a column above which it shows the motion, and up to which residuals are noise.
const SHOWN: f64 = 5.0;
const NOISY: f64 = 3.0;
/// Residual of a column, in parts of its standard deviation, that is rounding.
const EXACT: f64 = 1e-12;

/// A machine beside a record.
#[derive(Clone)]
pub(super) struct Model<'a> {
    pub measured: &'a Measured,
    /// The times of all rows, sorted.
    times: Vec<f64>,
    pub loss: Loss,
    pub unknowns: Arc<Unknowns<'a>>,
    pub compared: Arc<Compared<'a>>,
    pub watch: Arc<Watch>,
    /// Whether the record is one of several that are fitted together.
    pub is_part: bool,
    /// Standard deviation of each column, then of the contacts' times.
    sigma: Vec<f64>,
    /// Whether these are given.
    pub has_sigma: bool,
    /// Noise of each column, by its differences.
    noise: Vec<f64>,
}

/// The times of all rows, sorted.
fn times_of(measured: &Measured) -> Vec<f64> {
    let columns = measured.columns.len();
    let samples = measured.times.iter().flat_map(|time| std::iter::repeat_n(*time, columns));
    let contacts = measured.contacts.iter().flat_map(|(_, times)| times.iter().copied());
    let mut times: Vec<f64> = samples.chain(contacts).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// The standard deviations that are given, for each list of contacts too.
fn given(sigma: &[f64], measured: &Measured) -> Result<Vec<f64>> {
    let wanted = measured.columns.len() + usize::from(!measured.contacts.is_empty());
    if sigma.len() != wanted || sigma.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        let problem = format!(
            "sigma {sigma:?}: allowed are {wanted} positive numbers, one for each column, then one for times of contacts"
        );
        return Err(Error::Described { problem });
    }
    let last = sigma.last().copied().unwrap_or(1.0);
    let count = measured.columns.len() + measured.contacts.len();
    Ok((0..count).map(|k| sigma.get(k).copied().unwrap_or(last)).collect())
}

impl<'a> Model<'a> {
    pub fn new(request: &'a FitRequest) -> Result<Self> {
        let FitRequest { measured, sigma, loss, .. } = request;
        let columns = &measured.columns;
        let compared = Compared::new(request)?;
        let noise = |(_, values): &(QuantityName, Vec<f64>)| noise(values).max(rounding(values));
        let noise: Vec<f64> = columns.iter().map(noise).collect();
        // Beside outliers a column's own deviation is theirs.
        let is_robust = *loss != Loss::Linear;
        let of_column = |(noise, (_, values)): (&f64, &(QuantityName, Vec<f64>))| match *noise {
            noise if is_robust && noise > 0.0 && noise.is_finite() => noise,
            _ => size(values),
        };
        let of_contacts = measured.contacts.iter().map(|(_, times)| interval(times));
        let own = noise.iter().zip(columns).map(of_column).chain(of_contacts);
        Ok(Self {
            sigma: sigma.as_ref().map_or_else(|| Ok(own.collect()), |sigma| given(sigma, measured))?,
            has_sigma: sigma.is_some(),
            unknowns: Arc::new(Unknowns::new(request, &compared.rates, compared.sensors.clone())?),
            times: times_of(measured),
            measured,
            loss: *loss,
            compared: Arc::new(compared),
            watch: Arc::default(),
            is_part: false,
            noise,
        })
    }

    /// Standard deviation of residuals, in which outliers count little where they do in the fit.
    pub fn spread(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        if self.loss == Loss::Linear { rms(residuals) } else { typical(residuals) }
    }

    /// Takes the residuals at a point for the standard deviations of columns and contacts.
    pub fn reweigh(&mut self, point: &Point, reach: &Reach) -> Result<()> {
        self.watch.reweigh();
        let beside = self.beside(point, reach)?;
        let columns = (0..self.noise.len()).map(|k| self.spread(beside.residuals(k)));
        let contacts = 0..self.measured.contacts.len();
        let contacts = contacts.map(|k| self.spread(self.contacts_off(&beside, k).into_iter()));
        let found: Vec<f64> = columns.chain(contacts).collect();
        let pairs = self.sigma.iter_mut().zip(found);
        pairs.for_each(|(sigma, found)| *sigma = found.max(EXACT * *sigma));
        Ok(())
    }

    /// The model with the weights of another model of the same record.
    pub fn weighed_as(self, other: &Model) -> Self {
        let (sigma, watch) = (other.sigma.clone(), other.watch.clone());
        Self { sigma, watch, is_part: true, has_sigma: other.has_sigma, ..self }
    }

    /// The model with columns weighed by their noise, or by a part of their own size that is more.
    pub fn by_noise(&self, least: f64) -> Self {
        let of_column = |(noise, (_, values)): (&f64, &(QuantityName, Vec<f64>))| {
            let own = if noise.is_finite() { *noise } else { 0.0 };
            own.max(least * size(values))
        };
        let columns = self.noise.iter().zip(&self.measured.columns).map(of_column);
        let contacts = self.measured.contacts.iter().map(|(_, times)| least * interval(times));
        let sigma = if self.has_sigma { self.sigma.clone() } else { columns.chain(contacts).collect() };
        Self { sigma, ..self.clone() }
    }

    /// The times of the motion's contacts less those of the record, of a list of them.
    pub fn contacts_off(&self, beside: &Beside, list: usize) -> Vec<f64> {
        let times = &self.measured.contacts[list].1;
        beside.contacts(list).filter_map(|(i, time)| Some(time? - times[i])).collect()
    }

    /// Why rows of the record are not those of the motion, in words: it begins before the start.
    pub fn begins_early(&self, values: &[f64]) -> Result<Option<String>> {
        let made = self.unknowns.with(values)?;
        let first = self.first() + made.shift;
        let why = || format!("the record begins at {first:?} s of the motion, before its start");
        Ok((first < made.start.time - EARLY * (self.end() - self.first())).then(why))
    }

    /// The times of all rows, sorted.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Number of states of the machine.
    ///
    /// # Errors
    /// [`Error::Refusal`] for values that are not allowed.
    pub fn states(&self) -> Result<usize> {
        Ok(self.unknowns.with(&self.unknowns.begin)?.assembly.system().states())
    }

    /// Number of rows of the record.
    pub fn rows(&self) -> usize {
        self.times.len()
    }

    /// The record's first time.
    pub fn first(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }

    /// The record's last time.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Whether the record has times of contacts only.
    pub fn is_of_contacts(&self) -> bool {
        self.measured.columns.is_empty()
    }

    /// Twice the longest mean interval between contacts: a contact before a time is as near.
    pub fn slack(&self) -> f64 {
        2.0 * self.compared.longest_interval()
    }

    /// The time of the row some rows after a time.
    pub fn next_row(&self, time: f64, count: usize) -> f64 {
        let place = self.times.partition_point(|own| *own <= time) + count - 1;
        self.times.get(place).copied().unwrap_or_else(|| self.end())
    }

    /// The shortest horizon with a number of rows over which each column shows more than its noise.
    pub fn least_horizon(&self, rows: usize) -> f64 {
        let enough = self.times.get(rows.saturating_sub(1)).copied().unwrap_or_else(|| self.end());
        let shown = self.measured.columns.iter().zip(&self.noise).map(|((_, values), noise)| {
            let place = deviations(values).iter().position(|own| *own > SHOWN * noise);
            place.map_or(enough, |place| self.measured.times[place])
        });
        shown.fold(enough, f64::max)
    }

    /// Follows the motion of a point.
    pub fn beside(&self, point: &Point, reach: &Reach) -> Result<Beside> {
        self.compared.beside(&self.unknowns, point, reach, false)
    }

    /// Residuals and derivatives at a point.
    pub fn evaluate(&self, point: &Point, reach: &Reach) -> Result<Evaluated> {
        let at = self.evaluated(&self.compared.beside(&self.unknowns, point, reach, true)?, point, reach);
        let grows = || Error::Described { problem: "the motion grows beyond all numbers".into() };
        at.is_finite().then_some(at).ok_or_else(grows)
    }

    pub fn evaluated(&self, beside: &Beside, point: &Point, reach: &Reach) -> Evaluated {
        let of = |(k, own): (usize, &Followed)| {
            let states = if k > 0 { point.states[k - 1].len() } else { 0 };
            let joint = point.states.get(k).map(|next| (&next[..], &reach.weights[..]));
            own.segment(self.measured, &self.sigma, (point.values.len(), states), joint)
        };
        Evaluated(beside.0.iter().enumerate().map(of).collect())
    }

    /// The time up to which the motion of a point keeps near the record: the root mean square of
    /// the residuals so far, from a time on, is at most a part of the record's own deviation, or
    /// little more than its noise. A motion that breaks off is near nowhere.
    pub fn near_until(&self, point: &Point, nodes: &[f64], way: Way) -> f64 {
        let from = nodes.last().copied().unwrap_or(f64::NEG_INFINITY);
        let beside = self.beside(point, &Reach { nodes: nodes.to_vec(), ..Reach::whole(self.end()) });
        beside.map_or_else(|_| self.first().max(from), |beside| self.near(&beside, from, way))
    }

    pub fn near(&self, beside: &Beside, from: f64, way: Way) -> f64 {
        let (mut until, first) = (self.end(), self.measured.times.partition_point(|time| *time < from));
        for (k, (_, all)) in self.measured.columns.iter().enumerate() {
            let (own, whole, mut sum, mut far) = (deviations(all), deviation(all), 0.0, 0);
            let leaves = |(i, residual): (usize, f64)| {
                let own = if way.of_whole { whole } else { own[first + i] };
                let limit = (way.near * own).max(NOISY * self.noise[k]);
                sum += residual * residual;
                far += usize::from(residual.abs() > limit);
                match self.loss {
                    Loss::Linear => (sum / (i + 1) as f64).sqrt() > limit,
                    // Outliers are few: half of all samples are not.
                    Loss::SoftL1 | Loss::Huber => i >= FEW && 2 * far > i,
                }
            };
            if let Some(i) = beside.residuals(k).skip(first).enumerate().position(leaves) {
                until = until.min(self.measured.times[(first + i).saturating_sub(1)]);
            }
        }
        for (list, (_, measured)) in self.measured.contacts.iter().enumerate() {
            let limit = way.near * interval(measured);
            let is_near =
                |(i, time): &(usize, Option<f64>)| time.is_some_and(|t| (t - measured[*i]).abs() <= limit);
            if let Some((i, _)) = beside.contacts(list).find(|own| measured[own.0] >= from && !is_near(own)) {
                until = until.min(measured[i.saturating_sub(1)]);
            }
        }
        until
    }

    /// The sum of losses at a point that was reached.
    pub fn cost(&self, solved: &Solved) -> Result<f64> {
        let beside = self.beside(&solved.point, &solved.reach)?;
        let of = |own: &Followed| own.segment(self.measured, &self.sigma, (0, 0), None);
        Ok(self.loss.sum(Evaluated(beside.0.iter().map(of).collect()).residuals()))
    }

    /// Noise of a column: what is given, else what its differences say.
    pub fn noise_of(&self, k: usize) -> f64 {
        if self.has_sigma { self.sigma[k] } else { self.noise[k] }
    }

    /// Standard deviation of the times of contacts of a list, where it is given.
    pub fn deviation_of_contacts(&self, list: usize) -> Option<f64> {
        self.has_sigma.then(|| self.sigma[self.noise.len() + list])
    }

    /// Standard deviations of columns, then of lists of contacts, by which residuals are weighed.
    pub fn deviations(&self) -> &[f64] {
        &self.sigma
    }

    /// Whether the machine has stops.
    pub fn has_stops(&self) -> bool {
        !self.unknowns.machine.description.stops.is_empty()
    }

    /// Whether one motion keeps near the record from values on: there is but one way to it.
    pub fn is_near(&self, values: &[f64], way: Way) -> bool {
        self.near_until(&values.to_vec().into(), &[], way) >= self.end()
    }
}
