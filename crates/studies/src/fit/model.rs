//! A machine compared with a record: residuals, weights, and how long the motion stays near.

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

/// Sample size below which, by chance, more than half may be outliers.
const FEW: usize = 8;
/// Multiples of a column's noise above which it shows the motion, and up to which it is near.
const SHOWN: f64 = 5.0;
const NOISY: f64 = 3.0;
/// Residual at the rounding level, relative to the column's standard deviation.
const EXACT: f64 = 1e-12;

/// A machine compared with a record.
#[derive(Clone)]
pub(super) struct Model<'a> {
    pub measured: &'a Measured,
    /// Sorted times of all rows.
    times: Vec<f64>,
    pub loss: Loss,
    pub unknowns: Arc<Unknowns<'a>>,
    pub compared: Arc<Compared<'a>>,
    pub watch: Arc<Watch>,
    /// Whether several records are fitted together.
    pub is_part: bool,
    /// Standard deviation of each column, then of each list of contact times.
    sigma: Vec<f64>,
    /// Whether the standard deviations are given.
    pub has_sigma: bool,
    /// Noise of each column, estimated from differences.
    noise: Vec<f64>,
}

/// Sorted times of all rows.
fn times_of(measured: &Measured) -> Vec<f64> {
    let columns = measured.columns.len();
    let samples = measured.times.iter().flat_map(|time| std::iter::repeat_n(*time, columns));
    let contacts = measured.contacts.iter().flat_map(|(_, times)| times.iter().copied());
    let mut times: Vec<f64> = samples.chain(contacts).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Given standard deviations, with one for each list of contacts.
fn given(sigma: &[f64], measured: &Measured) -> Result<Vec<f64>> {
    let wanted = measured.columns.len() + usize::from(!measured.contacts.is_empty());
    if sigma.len() != wanted || sigma.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        let problem = format!(
            "--sigma {}: expected {wanted} positive number{}, one for each column, then one for the times of \
             contacts, if there are any",
            sigma.iter().map(f64::to_string).collect::<Vec<_>>().join(","),
            if wanted == 1 { "" } else { "s" }
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
        // Outliers dominate a column's own standard deviation.
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

    /// Standard deviation of residuals; under a robust loss, outliers count little.
    pub fn spread(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        if self.loss == Loss::Linear { rms(residuals) } else { typical(residuals) }
    }

    /// Sets the standard deviations of columns and contacts from the residuals at a point.
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

    /// Standard deviations with the names of their columns and lists of contacts.
    pub fn named_deviations(&self) -> Vec<(String, f64)> {
        let columns = self.measured.columns.iter().map(|(name, _)| name.to_string());
        let names = columns.chain(self.measured.contacts.iter().map(|(name, _)| name.clone()));
        names.zip(self.sigma.iter().copied()).collect()
    }

    /// Multiplies the standard deviations by a factor.
    pub fn scale_deviations(&mut self, factor: f64) {
        self.sigma.iter_mut().for_each(|sigma| *sigma *= factor);
    }

    /// Takes the root mean square of the standard deviations of the same name, where there are
    /// any.
    pub fn take_deviations(&mut self, known: &[(String, f64)]) {
        let names = self.named_deviations();
        for (sigma, (name, _)) in self.sigma.iter_mut().zip(names) {
            let same: Vec<f64> = known.iter().filter(|own| own.0 == name).map(|own| own.1).collect();
            if !same.is_empty() {
                *sigma = rms(same.into_iter());
            }
        }
    }

    /// The model with the weights of another model of the same record.
    pub fn weighed_as(self, other: &Model) -> Self {
        let (sigma, watch) = (other.sigma.clone(), other.watch.clone());
        Self { sigma, watch, is_part: true, has_sigma: other.has_sigma, ..self }
    }

    /// The model with columns weighted by their noise, at least a fraction of their size.
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

    /// Motion minus record of one list of contact times.
    pub fn contacts_off(&self, beside: &Beside, list: usize) -> Vec<f64> {
        let times = &self.measured.contacts[list].1;
        beside.contacts(list).filter_map(|(i, time)| Some(time? - times[i])).collect()
    }

    /// Message if the record begins before the motion's start.
    pub fn begins_early(&self, values: &[f64]) -> Result<Option<String>> {
        let made = self.unknowns.with(values)?;
        let first = self.first() + made.shift;
        let why = || format!("the record begins at {first:?} s of the motion, before its start");
        Ok((first < made.start.time - EARLY * (self.end() - self.first())).then(why))
    }

    /// Sorted times of all rows.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Number of states of the machine.
    ///
    /// # Errors
    /// [`Error::Refusal`] for values outside their range.
    pub fn states(&self) -> Result<usize> {
        Ok(self.unknowns.with(&self.unknowns.begin)?.assembly.system().states())
    }

    /// Number of rows of the record.
    pub fn rows(&self) -> usize {
        self.times.len()
    }

    /// First time of the record.
    pub fn first(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }

    /// Last time of the record.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Whether the record has only contact times.
    pub fn is_of_contacts(&self) -> bool {
        self.measured.columns.is_empty()
    }

    /// Twice the longest mean interval between contacts: the last contact may be this early.
    pub fn slack(&self) -> f64 {
        2.0 * self.compared.longest_interval()
    }

    /// Time of the row `count` rows later.
    pub fn next_row(&self, time: f64, count: usize) -> f64 {
        let place = self.times.partition_point(|own| *own <= time) + count - 1;
        self.times.get(place).copied().unwrap_or_else(|| self.end())
    }

    /// Shortest horizon with `rows` rows over which each column shows more than its noise.
    pub fn least_horizon(&self, rows: usize) -> f64 {
        let enough = self.times.get(rows.saturating_sub(1)).copied().unwrap_or_else(|| self.end());
        let shown = self.measured.columns.iter().zip(&self.noise).map(|((_, values), noise)| {
            let place = deviations(values).iter().position(|own| *own > SHOWN * noise);
            place.map_or(enough, |place| self.measured.times[place])
        });
        shown.fold(enough, f64::max)
    }

    /// Simulates the motion of a point.
    pub fn beside(&self, point: &Point, reach: &Reach) -> Result<Beside> {
        self.compared.beside(&self.unknowns, point, reach, false)
    }

    /// Residuals and derivatives at a point.
    pub fn evaluate(&self, point: &Point, reach: &Reach) -> Result<Evaluated> {
        let at = self.evaluated(&self.compared.beside(&self.unknowns, point, reach, true)?, point, reach);
        let grows = || Error::Described {
            problem: "the motion grows beyond the range of floating-point numbers".into(),
        };
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

    /// End of the agreement between the motion of a point and the record: the root mean square
    /// residual after the last node is at most a fraction of the record's standard deviation, or a
    /// few times its noise. A motion that cannot be simulated is near nowhere.
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
                    // Outliers are few: never half of all samples.
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

    /// Sum of losses at a point.
    pub fn cost(&self, solved: &Solved) -> Result<f64> {
        let beside = self.beside(&solved.point, &solved.reach)?;
        let of = |own: &Followed| own.segment(self.measured, &self.sigma, (0, 0), None);
        Ok(self.loss.sum(Evaluated(beside.0.iter().map(of).collect()).residuals()))
    }

    /// Noise of a column: the given one, or the estimate from differences.
    pub fn noise_of(&self, k: usize) -> f64 {
        if self.has_sigma { self.sigma[k] } else { self.noise[k] }
    }

    /// Given standard deviation of one list of contact times.
    pub fn deviation_of_contacts(&self, list: usize) -> Option<f64> {
        self.has_sigma.then(|| self.sigma[self.noise.len() + list])
    }

    /// Standard deviations of columns, then of lists of contacts: the weights of residuals.
    pub fn deviations(&self) -> &[f64] {
        &self.sigma
    }

    /// Whether the machine has stops.
    pub fn has_stops(&self) -> bool {
        !self.unknowns.machine.description.stops.is_empty()
    }

    /// Whether a single motion from these values stays near the whole record.
    pub fn is_near(&self, values: &[f64], way: Way) -> bool {
        self.near_until(&values.to_vec().into(), &[], way) >= self.end()
    }
}
