//! The motion of a machine beside a record.

use super::errors::Uncertainty;
use super::evaluated::{Evaluated, Varied};
use super::statistics::{deviation, deviations, interval, noise, rms, size, typical};
use super::unknowns::{Made, Unknowns};
use super::{FitRequest, Fitted, Loss, Measured, Way};
use crate::assembly::QuantityName;
use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use vibro_assembly::description::Description;
use vibro_assembly::motion::{Event, EventKind};
use vibro_assembly::{Assembly, Quantity, What};

/// Samples of which more than half may be outliers by chance.
const FEW: usize = 8;
/// Noise of a column above which it shows the motion, and up to which residuals are noise.
const SHOWN: f64 = 5.0;
const NOISY: f64 = 3.0;
/// Residual of a column, in parts of its standard deviation, that is rounding.
const EXACT: f64 = 1e-12;
/// Intervals between contacts that a contact's time may be off and still be near.
const OFF: f64 = 0.3;

/// Time up to which a record counts, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Horizon(pub f64);

/// A machine beside a record.
pub(super) struct Model<'a> {
    measured: &'a Measured,
    /// The times of all rows, sorted.
    times: Vec<f64>,
    pub loss: Loss,
    pub unknowns: Unknowns<'a>,
    quantities: Vec<Quantity>,
    /// The rate of each column's quantity, where a quantity has it.
    rates: Vec<Option<Quantity>>,
    /// Index of the stop of each list of contacts.
    stops: Vec<usize>,
    /// Standard deviation of each column, then of the contacts' times.
    sigma: Vec<f64>,
    /// Whether these are given.
    pub has_sigma: bool,
    /// Noise of each column, by its differences.
    noise: Vec<f64>,
    simulations: AtomicU32,
}

/// A motion beside the record.
struct Beside {
    /// Why there is no derivative by a number any more, in words.
    lost: Vec<String>,
    /// For each time and column the motion's value less the record's.
    samples: Vec<Vec<Varied>>,
    /// For each list of contacts the times of the motion's.
    contacts: Vec<Vec<Varied>>,
}

impl Beside {
    /// The residuals of a column.
    fn residuals(&self, column: usize) -> impl Iterator<Item = f64> {
        self.samples.iter().map(move |sample| sample[column].0)
    }

    /// The times of the motion's contacts less those of the record, of a list of them.
    fn contacts_off(&self, list: usize, measured: &[f64]) -> Vec<f64> {
        self.contacts[list].iter().zip(measured).map(|((time, _), measured)| time - measured).collect()
    }
}

/// The quantity that is the rate of another, where there is one.
fn rate_of(name: &QuantityName, d: &Description) -> Option<Quantity> {
    let what = match name.what {
        What::S => What::V,
        What::V => What::A,
        What::E => What::Rate,
        _ => return None,
    };
    QuantityName { of: name.of.clone(), what }.find(d).ok().map(|named| named.quantity)
}

/// The indices of the stops whose contacts a record has.
fn stops_of(measured: &Measured, d: &Description) -> Result<Vec<usize>> {
    let of = |(element, _): &(String, Vec<f64>)| {
        let plain = element.strip_prefix("stop.").unwrap_or(element);
        d.stops.iter().position(|stop| stop.name == plain).ok_or_else(|| {
            let known: Vec<&str> = d.stops.iter().map(|stop| stop.name.as_str()).collect();
            let problem = format!("no stop is named `{element}`; allowed are {}", known.join(", "));
            Error::Described { problem }
        })
    };
    measured.contacts.iter().map(of).collect()
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
        let FitRequest { machine, measured, sigma, loss, .. } = request;
        let (d, columns) = (&machine.description, &measured.columns);
        let quantity = |(name, _): &(QuantityName, Vec<f64>)| Ok(name.find(d)?.quantity);
        let quantities = columns.iter().map(quantity).collect::<Result<_>>()?;
        let rates: Vec<_> = columns.iter().map(|(name, _)| rate_of(name, d)).collect();
        let stops = stops_of(measured, d)?;
        let noise: Vec<f64> = columns.iter().map(|(_, values)| noise(values)).collect();
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
            unknowns: Unknowns::new(request, &rates)?,
            times: times_of(measured),
            measured,
            loss: *loss,
            quantities,
            rates,
            stops,
            noise,
            simulations: AtomicU32::new(0),
        })
    }

    /// Standard deviation of residuals, in which outliers count little where they do in the fit.
    fn spread(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        if self.loss == Loss::Linear { rms(residuals) } else { typical(residuals) }
    }

    /// Takes the residuals at some values for the standard deviations of columns and contacts.
    pub fn reweigh(&mut self, values: &[f64]) -> Result<()> {
        let beside = self.beside(values, Horizon(self.end()), false)?;
        let columns = (0..self.quantities.len()).map(|k| self.spread(beside.residuals(k)));
        let contacts = self.measured.contacts.iter().enumerate();
        let contacts = contacts.map(|(k, (_, times))| self.spread(beside.contacts_off(k, times).into_iter()));
        let found: Vec<f64> = columns.chain(contacts).collect();
        let pairs = self.sigma.iter_mut().zip(found);
        pairs.for_each(|(sigma, found)| *sigma = found.max(EXACT * *sigma));
        Ok(())
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

    /// The shortest horizon with a number of rows over which each column shows more than its noise.
    pub fn least_horizon(&self, rows: usize) -> f64 {
        let enough = self.times.get(rows.saturating_sub(1)).copied().unwrap_or_else(|| self.end());
        let shown = self.measured.columns.iter().zip(&self.noise).map(|((_, values), noise)| {
            let place = deviations(values).iter().position(|own| *own > SHOWN * noise);
            place.map_or(enough, |place| self.measured.times[place])
        });
        shown.fold(enough, f64::max)
    }

    /// Follows the motion with some values up to a horizon, with derivatives on request.
    fn beside(&self, values: &[f64], Horizon(end): Horizon, varied: bool) -> Result<Beside> {
        self.simulations.fetch_add(1, Ordering::Relaxed);
        let Made { machine, start, shift, offsets } = self.unknowns.with(values)?;
        let assembly = Arc::new(Assembly::new(machine.description)?);
        let names = if varied { &self.unknowns.names[..] } else { &[] };
        let mut contacts: Vec<Vec<Varied>> = vec![Vec::new(); self.stops.len()];
        let mut note = |event: &Event, by: &[Option<f64>]| {
            if let EventKind::Impact { stop, .. } | EventKind::Press { stop, .. } = event.kind
                && let Some(k) = self.stops.iter().position(|own| *own == stop)
            {
                contacts[k].push((event.time - shift, self.unknowns.by_all(by, Some(-1.0), None)));
            }
        };
        let mut motion = start.differentiated(assembly, names, &mut note)?;
        let mut samples = Vec::new();
        let columns = &self.measured.columns;
        let times = self.measured.times.iter().take_while(|time| !columns.is_empty() && **time <= end);
        for (row, time) in times.enumerate() {
            // Before its start there is no motion.
            motion.advance_observed((time + shift).max(start.time), &mut note)?;
            let sample = |k: usize| {
                let quantity = self.quantities[k];
                let value = motion.motion().value(quantity) + offsets[k] - columns[k].1[row];
                let by: Vec<Option<f64>> = (0..names.len()).map(|p| motion.derivative(quantity, p)).collect();
                let rate = self.rates[k].map(|rate| motion.motion().value(rate));
                (value, self.unknowns.by_all(&by, rate, Some(k)))
            };
            samples.push((0..columns.len()).map(sample).collect());
        }
        if !self.stops.is_empty() && end + shift > motion.motion().time() {
            motion.advance_observed(end + shift, &mut note)?;
        }
        let lost = |(p, name): (usize, &&str)| Some(format!("{name}: {}", motion.lost(p)?));
        let lost = names.iter().enumerate().filter_map(lost).collect();
        Ok(Beside { lost, samples, contacts })
    }

    /// Residuals and derivatives with some values over a horizon.
    pub fn evaluate(&self, values: &[f64], horizon: Horizon) -> Result<Evaluated> {
        let at = self.evaluated(&self.beside(values, horizon, true)?, horizon);
        let grows = || Error::Described { problem: "the motion grows beyond all numbers".into() };
        at.is_finite().then_some(at).ok_or_else(grows)
    }

    fn evaluated(&self, beside: &Beside, horizon: Horizon) -> Evaluated {
        let mut rows = Vec::new();
        for (time, sample) in self.measured.times.iter().zip(&beside.samples) {
            rows.extend(sample.iter().enumerate().map(|(k, own)| ((*time, k), own.clone())));
        }
        let (columns, unknowns) = (self.measured.columns.len(), self.unknowns.begin.len());
        for (k, ((_, measured), own)) in self.measured.contacts.iter().zip(&beside.contacts).enumerate() {
            for (i, time) in measured.iter().take_while(|time| **time <= horizon.0).enumerate() {
                // A contact that the motion does not have counts as one at the horizon.
                let none = || (horizon.0, vec![None; unknowns]);
                let (at, by) = own.get(i).cloned().unwrap_or_else(none);
                rows.push(((*time, columns + k), (at - time, by)));
            }
        }
        Evaluated::of(rows, unknowns, &self.sigma)
    }

    /// The time up to which the motion with some values keeps near the record: the root mean square of
    /// the residuals so far is at most a part of the record's own deviation, or little more than its
    /// noise. A motion that breaks off is near nowhere.
    pub fn near_until(&self, values: &[f64], way: Way) -> f64 {
        let beside = self.beside(values, Horizon(self.end()), false);
        beside.map_or_else(|_| self.first(), |beside| self.near(&beside, way))
    }

    fn near(&self, beside: &Beside, way: Way) -> f64 {
        let mut until = self.end();
        for (k, (_, all)) in self.measured.columns.iter().enumerate() {
            let (own, whole, mut sum, mut far) = (deviations(all), deviation(all), 0.0, 0);
            let leaves = |(i, residual): (usize, f64)| {
                let own = if way.of_whole { whole } else { own[i] };
                let limit = (way.near * own).max(NOISY * self.noise[k]);
                sum += residual * residual;
                far += usize::from(residual.abs() > limit);
                match self.loss {
                    Loss::Linear => (sum / (i + 1) as f64).sqrt() > limit,
                    // Outliers are few: half of all samples are not.
                    Loss::SoftL1 | Loss::Huber => i >= FEW && 2 * far > i,
                }
            };
            if let Some(i) = beside.residuals(k).enumerate().position(leaves) {
                until = until.min(self.measured.times[i.saturating_sub(1)]);
            }
        }
        for ((_, measured), own) in self.measured.contacts.iter().zip(&beside.contacts) {
            let limit = OFF * interval(measured);
            let near = |i: usize| own.get(i).is_some_and(|(time, _)| (time - measured[i]).abs() <= limit);
            if let Some(i) = (0..measured.len()).find(|&i| !near(i)) {
                until = until.min(measured[i.saturating_sub(1)]);
            }
        }
        until
    }

    /// Whether the residuals with some values are not much more than the noise.
    pub fn is_noise(&self, values: &[f64]) -> Result<bool> {
        let beside = self.beside(values, Horizon(self.end()), false)?;
        let mut columns = self.noise.iter().enumerate();
        Ok(columns.all(|(k, noise)| self.spread(beside.residuals(k)) <= NOISY * noise))
    }

    /// The machine fitted with some values.
    pub fn finish(&self, request: &FitRequest, values: &[f64], cost: f64) -> Result<Fitted> {
        let end = Horizon(self.end());
        let beside = self.beside(values, end, true)?;
        let Made { machine, start, .. } = self.unknowns.with(values)?;
        let columns = &self.measured.columns;
        let of_column =
            |(k, (name, _)): (usize, &(QuantityName, _))| (name.to_string(), rms(beside.residuals(k)));
        let mut sizes: Vec<(String, f64)> = columns.iter().enumerate().map(of_column).collect();
        let mut contacts = Vec::new();
        for (k, (name, measured)) in self.measured.contacts.iter().enumerate() {
            let off = beside.contacts_off(k, measured);
            sizes.push((name.clone(), rms(off.iter().copied())));
            contacts.push((name.clone(), off));
        }
        let names: Vec<String> = request.free.iter().map(|own| own.name.clone()).collect();
        let at = self.evaluated(&beside, end);
        Ok(Fitted {
            machine,
            start,
            uncertainty: Uncertainty::of(&at, &names, values, (self.loss, self.has_sigma)),
            values: names.into_iter().zip(values.iter().copied()).collect(),
            rms: sizes,
            residuals: beside
                .samples
                .iter()
                .map(|all| all.iter().map(|(residual, _)| *residual).collect())
                .collect(),
            contacts,
            // Outliers that count little do not end it.
            near_until: if self.loss == Loss::Linear { self.near(&beside, super::WAYS[0]) } else { end.0 },
            lost: beside.lost,
            simulations: self.simulations.load(Ordering::Relaxed),
            cost,
        })
    }
}
