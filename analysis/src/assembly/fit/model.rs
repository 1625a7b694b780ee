//! The motion of a machine beside a record: residuals and their derivatives by the free numbers.

use super::errors::Uncertainty;
use super::{FitRequest, Fitted, Loss, Measured, Way};
use crate::assembly::{Machine, QuantityName};
use crate::error::{Error, Result};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use vibro_assembly::motion::{Event, EventKind};
use vibro_assembly::{Assembly, Quantity, Start, What};

/// A positive number's least value, in parts of the value from which the fit begins.
const LEAST: f64 = 1e-6;
/// Samples of which more than half may be outliers by chance.
const FEW: usize = 8;
/// Prefix of the numbers of a start among names of derivatives.
const OF_START: &str = "start.";
/// Noise of a column above which it shows the motion, and up to which residuals are noise.
const SHOWN: f64 = 5.0;
const NOISY: f64 = 3.0;
/// Residual of a column, in parts of its own deviation, that is rounding.
const EXACT: f64 = 1e-12;
/// Intervals between contacts that a contact's time may be off and still be near.
const OFF: f64 = 0.3;

/// Time up to which a record counts, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Horizon(pub f64);

/// What a free number is.
#[derive(Clone, Debug, PartialEq)]
enum Unknown {
    /// Of the machine or of the start; with the column of its derivatives.
    Number(usize),
    /// Time of the motion at the record's time 0.
    Shift,
    /// What a column shows above the quantity.
    Offset(usize),
}

/// A machine beside a record.
pub(super) struct Model<'a> {
    machine: &'a Machine,
    start: &'a Start,
    measured: &'a Measured,
    unknowns: Vec<Unknown>,
    names: Vec<&'a str>,
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
    /// Whether large residuals count less than by their squares.
    is_robust: bool,
    simulations: AtomicU32,
}

/// Residuals over a horizon in units of the standard deviations, and their derivatives; rows of a
/// time stand together.
pub(super) struct Evaluated {
    pub residuals: Vec<f64>,
    pub jacobian: DMatrix<f64>,
    /// Time and column of each row; the columns of contacts follow those of quantities.
    pub places: Vec<(f64, usize)>,
}

/// Place of a row (time and column), residual, and its derivatives.
type Row = ((f64, usize), f64, Vec<Option<f64>>);

/// A motion beside the record.
struct Beside {
    /// Why there is no derivative by a number any more, in words.
    lost: Vec<String>,
    /// For each time and column the motion's value less the record's, with its derivatives.
    samples: Vec<Vec<(f64, Vec<Option<f64>>)>>,
    /// For each list of contacts the times of the motion's, with their derivatives.
    contacts: Vec<Vec<(f64, Vec<Option<f64>>)>>,
}

/// Standard deviation of noise on a signal: the least that its differences of several orders say. A
/// quarter of normal numbers are below 0.3186 standard deviations, and those of order m have √C(2m, m)
/// of them. Coarse samples of a motion raise low orders, its contacts most of high ones.
fn noise(values: &[f64]) -> f64 {
    let (mut all, mut least, mut variance) = (values.to_vec(), f64::INFINITY, 1.0);
    for order in 1..=6 {
        all = all.windows(2).map(|pair| pair[1] - pair[0]).collect();
        variance *= f64::from(2 * (2 * order - 1)) / f64::from(order);
        let mut sizes: Vec<f64> = all.iter().map(|x| x.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let quarter = sizes.get(sizes.len() / 4).map_or(0.0, |size| size / (0.3186 * variance.sqrt()));
        if order > 1 {
            least = least.min(quarter);
        }
    }
    least
}

/// Standard deviation of normal residuals by their median, whatever a few outliers are: half of them
/// are below 0.6745 of it.
fn typical(residuals: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = residuals.map(f64::abs).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).map_or(0.0, |median| median / 0.6745)
}

/// Standard deviation of the values up to each place.
fn deviations(values: &[f64]) -> Vec<f64> {
    let (mut mean, mut squares) = (0.0, 0.0);
    let so_far = |(i, x): (usize, &f64)| {
        let off = x - mean;
        mean += off / (i + 1) as f64;
        squares += off * (x - mean);
        f64::sqrt(squares / (i + 1) as f64)
    };
    values.iter().enumerate().map(so_far).collect()
}

/// Standard deviation.
fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Mean interval of rising times.
fn interval(times: &[f64]) -> f64 {
    match times {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        [only] => *only,
        [] => 1.0,
    }
}

impl<'a> Model<'a> {
    pub fn new(request: &'a FitRequest) -> Result<Self> {
        let FitRequest { machine, start, measured, free, sigma, .. } = request;
        let d = &machine.description;
        let refused = |problem: String| Err(Error::Described { problem });
        let found: Vec<_> = measured.columns.iter().map(|(name, _)| name.find(d)).collect::<Result<_>>()?;
        let quantities = found.iter().map(|named| named.quantity).collect();
        let rate = |name: &QuantityName| {
            let what = match name.what {
                What::S => What::V,
                What::V => What::A,
                What::E => What::Rate,
                _ => return None,
            };
            QuantityName { of: name.of.clone(), what }.find(d).ok().map(|named| named.quantity)
        };
        let rates: Vec<_> = measured.columns.iter().map(|(name, _)| rate(name)).collect();
        let names: Vec<String> = d.stops.iter().map(|stop| stop.name.clone()).collect();
        let mut stops = Vec::new();
        for (element, _) in &measured.contacts {
            let plain = element.strip_prefix("stop.").unwrap_or(element);
            match names.iter().position(|name| name == plain) {
                Some(stop) => stops.push(stop),
                None => {
                    let all = names.join(", ");
                    return refused(format!("no stop is named `{element}`; allowed are {all}"));
                }
            }
        }
        let count = measured.columns.len() + measured.contacts.len();
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        // A column that never changes weighs by its size.
        let sigma_of = |values: &[f64]| match (deviation(values), largest(values)) {
            (own, _) if own > 0.0 => own,
            (_, size) if size > 0.0 => size,
            _ => 1.0,
        };
        let is_robust = request.loss != Loss::Linear;
        // Beside outliers a column's own deviation is theirs.
        let of_column = |values: &[f64]| match noise(values) {
            noise if is_robust && noise > 0.0 && noise.is_finite() => noise,
            _ => sigma_of(values),
        };
        let own = || {
            let columns = measured.columns.iter().map(|(_, values)| of_column(values));
            columns.chain(measured.contacts.iter().map(|(_, times)| interval(times))).collect::<Vec<f64>>()
        };
        let sigma = match sigma {
            None => own(),
            Some(given) => {
                let wanted = measured.columns.len() + usize::from(!measured.contacts.is_empty());
                if given.len() != wanted || given.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
                    return refused(format!(
                        "sigma {given:?}: allowed are {wanted} positive numbers, one for each column, then one for times of contacts"
                    ));
                }
                let last = given.last().copied().unwrap_or(1.0);
                (0..count).map(|k| given.get(k).copied().unwrap_or(last)).collect()
            }
        };
        let (mut unknowns, mut named) = (Vec::new(), Vec::new());
        for own in free {
            unknowns.push(match own.name.as_str() {
                "record.shift" => {
                    if let Some(k) = rates.iter().position(Option::is_none) {
                        let name = &measured.columns[k].0;
                        return refused(format!(
                            "record.shift beside {name}: allowed are columns s, v of bodies and e of elements"
                        ));
                    }
                    Unknown::Shift
                }
                name => match name.strip_prefix("record.offset.") {
                    Some(column) => {
                        let place = measured.columns.iter().position(|(own, _)| own.to_string() == column);
                        let all =
                            || measured.columns.iter().map(|(own, _)| own.to_string()).collect::<Vec<_>>();
                        match place {
                            Some(place) => Unknown::Offset(place),
                            None => {
                                let all = all().join(", ");
                                return refused(format!(
                                    "{name}: the record has no such column; allowed are {all}"
                                ));
                            }
                        }
                    }
                    None => {
                        named.push(name);
                        Unknown::Number(named.len() - 1)
                    }
                },
            });
        }
        let assembly = Assembly::new(d.clone())?;
        start.columns(&assembly, &named)?;
        Ok(Self {
            machine,
            start,
            measured,
            unknowns,
            names: named,
            quantities,
            rates,
            stops,
            sigma,
            has_sigma: request.sigma.is_some(),
            noise: measured.columns.iter().map(|(_, values)| noise(values)).collect(),
            is_robust,
            simulations: AtomicU32::new(0),
        })
    }

    /// The model with the residuals at some values as the standard deviations of the columns, where
    /// none are given.
    pub fn reweighted(&self, values: &[f64], loss: Loss) -> Result<Self> {
        let at = self.evaluate(values, Horizon(self.end()))?;
        let median = |k: usize| {
            let own = at.places.iter().zip(&at.residuals).filter(move |(place, _)| place.1 == k);
            typical(own.map(|(_, r)| *r))
        };
        let squares = |k: usize| {
            let own = at.places.iter().zip(&at.residuals).filter(move |(place, _)| place.1 == k);
            own.fold((0.0, 0usize), |(sum, count), (_, r)| (sum + r * r, count + 1))
        };
        let weighed = |(k, sigma): (usize, &f64)| {
            if loss != Loss::Linear {
                return sigma * median(k).max(EXACT);
            }
            let (sum, count) = squares(k);
            sigma * (sum / count.max(1) as f64).sqrt().max(EXACT)
        };
        let sigma = match self.has_sigma {
            true => self.sigma.clone(),
            false => self.sigma.iter().enumerate().map(weighed).collect(),
        };
        Ok(Self {
            sigma,
            unknowns: self.unknowns.clone(),
            names: self.names.clone(),
            quantities: self.quantities.clone(),
            rates: self.rates.clone(),
            noise: self.noise.clone(),
            stops: self.stops.clone(),
            simulations: AtomicU32::new(self.simulations.load(Ordering::Relaxed)),
            ..*self
        })
    }

    /// Number of rows of the record.
    pub fn rows(&self) -> usize {
        let contacts: usize = self.measured.contacts.iter().map(|(_, times)| times.len()).sum();
        self.measured.columns.len() * self.measured.times.len() + contacts
    }

    /// The record's first time.
    pub fn first(&self) -> f64 {
        let contacts = self.measured.contacts.iter().filter_map(|(_, times)| times.first());
        let samples = self.measured.times.first().filter(|_| !self.measured.columns.is_empty());
        samples.into_iter().chain(contacts).copied().fold(f64::INFINITY, f64::min)
    }

    /// The record's last time.
    pub fn end(&self) -> f64 {
        let contacts = self.measured.contacts.iter().filter_map(|(_, times)| times.last());
        let samples = self.measured.times.last().filter(|_| !self.measured.columns.is_empty());
        samples.into_iter().chain(contacts).copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The shortest horizon with a number of rows over which each column shows more than its noise.
    pub fn least_horizon(&self, rows: usize) -> f64 {
        let columns = self.measured.columns.len();
        let mut times: Vec<f64> =
            self.measured.times.iter().flat_map(|t| std::iter::repeat_n(*t, columns)).collect();
        times.extend(self.measured.contacts.iter().flat_map(|(_, times)| times));
        times.sort_by(f64::total_cmp);
        let enough = times.get(rows.saturating_sub(1)).copied().unwrap_or_else(|| self.end());
        let shown = self.measured.columns.iter().zip(&self.noise).map(|((_, values), noise)| {
            let place = deviations(values).iter().position(|own| *own > SHOWN * noise);
            place.map_or(enough, |place| self.measured.times[place])
        });
        shown.fold(enough, f64::max)
    }

    /// The values from which the fit begins.
    pub fn begin(&self) -> Vec<f64> {
        self.unknowns
            .iter()
            .map(|unknown| match unknown {
                Unknown::Number(k) => self.present(self.names[*k]),
                Unknown::Shift | Unknown::Offset(_) => 0.0,
            })
            .collect()
    }

    /// The present value of a number of the machine or of its start.
    fn present(&self, name: &str) -> f64 {
        if let Ok(value) = self.machine.description.get(name) {
            return value;
        }
        let name = name.strip_prefix(OF_START).unwrap_or(name);
        let is_own = |(own, _): &(String, f64)| own == name || format!("body.{own}") == name;
        if let Some((_, value)) = self.start.numbers().into_iter().find(is_own) {
            return value;
        }
        let plain = name.strip_prefix("body.").unwrap_or(name);
        let of_file = plain.rsplit_once('.').map(|(body, key)| format!("body.{body}.start.{key}"));
        of_file.and_then(|name| self.machine.description.get(&name).ok()).unwrap_or(0.0)
    }

    /// The values that a free number may have.
    pub fn allowed(&self, k: usize) -> (f64, f64) {
        let Unknown::Number(place) = self.unknowns[k] else { return (f64::MIN, f64::MAX) };
        let Ok(parameter) = self.machine.description.parameter(self.names[place]) else {
            return (f64::MIN, f64::MAX);
        };
        let range = parameter.range();
        let low = if range.open_min { range.min + LEAST * parameter.value.abs() } else { range.min };
        (low.max(f64::MIN), range.max.min(f64::MAX))
    }

    /// The machine, its start, the shift and the offsets with some values.
    fn with(&self, values: &[f64]) -> Result<(Machine, Start, f64, Vec<f64>)> {
        let (mut of_machine, mut start) = (Vec::new(), self.start.clone());
        let (mut shift, mut offsets) = (0.0, vec![0.0; self.measured.columns.len()]);
        for (unknown, &value) in self.unknowns.iter().zip(values) {
            match unknown {
                Unknown::Number(k) => match self.machine.description.get(self.names[*k]) {
                    Ok(_) => of_machine.push((self.names[*k], value)),
                    Err(_) => {
                        let name = self.names[*k];
                        let own = name.strip_prefix(OF_START).unwrap_or(name);
                        start.set(&self.machine.description, own, value)?;
                    }
                },
                Unknown::Shift => shift = value,
                Unknown::Offset(k) => offsets[*k] = value,
            }
        }
        Ok((self.machine.with(of_machine)?, start, shift, offsets))
    }

    /// Follows the motion with some values up to a horizon, with derivatives on request.
    fn beside(&self, values: &[f64], Horizon(end): Horizon, varied: bool) -> Result<Beside> {
        self.simulations.fetch_add(1, Ordering::Relaxed);
        let (machine, start, shift, offsets) = self.with(values)?;
        let assembly = Arc::new(Assembly::new(machine.description)?);
        let names = if varied { &self.names[..] } else { &[] };
        let count = names.len();
        let mut contacts: Vec<Vec<(f64, Vec<Option<f64>>)>> = vec![Vec::new(); self.stops.len()];
        let places: BTreeMap<usize, usize> =
            self.stops.iter().enumerate().map(|(k, stop)| (*stop, k)).collect();
        let mut note = |event: &Event, by: &[Option<f64>]| {
            if let EventKind::Impact { stop, .. } | EventKind::Press { stop, .. } = event.kind
                && let Some(&k) = places.get(&stop)
            {
                contacts[k].push((event.time - shift, self.by_all(by, Some(-1.0), None)));
            }
        };
        let mut motion = start.differentiated(assembly, names, &mut note)?;
        let mut samples = Vec::new();
        let columns = self.measured.columns.len();
        let times = self.measured.times.iter().take_while(|time| columns > 0 && **time <= end);
        for (row, time) in times.enumerate() {
            // Before its start there is no motion.
            let at = (time + shift).max(start.time);
            motion.advance_observed(at, &mut note)?;
            let sample = |k: usize| {
                let quantity = self.quantities[k];
                let value = motion.motion().value(quantity) + offsets[k] - self.measured.columns[k].1[row];
                let by: Vec<Option<f64>> = (0..count).map(|p| motion.derivative(quantity, p)).collect();
                let rate = self.rates[k].map(|rate| motion.motion().value(rate));
                (value, self.by_all(&by, rate, Some(k)))
            };
            samples.push((0..columns).map(sample).collect());
        }
        if !self.stops.is_empty() && end + shift > motion.motion().time() {
            motion.advance_observed(end + shift, &mut note)?;
        }
        let lost =
            names.iter().enumerate().filter_map(|(p, name)| Some(format!("{name}: {}", motion.lost(p)?)));
        let lost = lost.collect();
        Ok(Beside { lost, samples, contacts })
    }

    /// Derivatives by all free numbers, from those by numbers of the machine and of the start, that by
    /// the shift, and the column of an offset.
    fn by_all(&self, by: &[Option<f64>], by_shift: Option<f64>, column: Option<usize>) -> Vec<Option<f64>> {
        self.unknowns
            .iter()
            .map(|unknown| match unknown {
                Unknown::Number(k) => by.get(*k).copied().flatten(),
                Unknown::Shift => by_shift,
                Unknown::Offset(k) => Some(if Some(*k) == column { 1.0 } else { 0.0 }),
            })
            .collect()
    }

    /// Residuals and derivatives with some values over a horizon.
    pub fn evaluate(&self, values: &[f64], horizon: Horizon) -> Result<Evaluated> {
        let beside = self.beside(values, horizon, true)?;
        let mut rows: Vec<Row> = Vec::new();
        for (time, sample) in self.measured.times.iter().zip(&beside.samples) {
            for (k, (residual, by)) in sample.iter().enumerate() {
                rows.push(((*time, k), *residual, by.clone()));
            }
        }
        let columns = self.measured.columns.len();
        for (k, ((_, measured), own)) in self.measured.contacts.iter().zip(&beside.contacts).enumerate() {
            for (i, time) in measured.iter().take_while(|time| **time <= horizon.0).enumerate() {
                // A contact that the motion does not have counts as one at the horizon.
                let none = || (horizon.0, vec![None; self.unknowns.len()]);
                let (at, by) = own.get(i).cloned().unwrap_or_else(none);
                rows.push(((*time, columns + k), at - time, by));
            }
        }
        rows.sort_by(|a, b| a.0.0.total_cmp(&b.0.0).then(a.0.1.cmp(&b.0.1)));
        let mut jacobian = DMatrix::zeros(rows.len(), self.unknowns.len());
        let (mut residuals, mut places) = (Vec::new(), Vec::new());
        for (i, (place, residual, by)) in rows.into_iter().enumerate() {
            let sigma = self.sigma[place.1];
            residuals.push(residual / sigma);
            by.iter().enumerate().for_each(|(j, by)| jacobian[(i, j)] = by.unwrap_or(0.0) / sigma);
            places.push(place);
        }
        let is_finite = residuals.iter().chain(jacobian.iter()).all(|x| x.is_finite());
        if !is_finite {
            return Err(Error::Described { problem: "the motion grows beyond all numbers".into() });
        }
        Ok(Evaluated { residuals, jacobian, places })
    }

    /// The time up to which the motion with some values keeps near the record: the root mean square of
    /// the residuals so far is at most a part of the record's own deviation, or little more than its
    /// noise.
    pub fn near_until(&self, values: &[f64], way: Way) -> Result<f64> {
        let end = self.end();
        // What is followed before an error counts.
        let beside = match self.beside(values, Horizon(end), false) {
            Ok(beside) => beside,
            Err(error) => return if self.measured.columns.is_empty() { Err(error) } else { Ok(0.0) },
        };
        let mut until = end;
        for (k, (_, all)) in self.measured.columns.iter().enumerate() {
            let (own, whole, mut sum, mut far) = (deviations(all), deviation(all), 0.0, 0);
            for (i, sample) in beside.samples.iter().enumerate() {
                sum += sample[k].0.powi(2);
                let own = if way.of_whole { whole } else { own[i] };
                let limit = (way.near * own).max(NOISY * self.noise[k]);
                far += usize::from(sample[k].0.abs() > limit);
                // Outliers are few: half of all samples are not.
                let leaves = match self.is_robust {
                    true => i >= FEW && 2 * far > i,
                    false => (sum / (i + 1) as f64).sqrt() > limit,
                };
                if leaves {
                    until = until.min(self.measured.times[i.saturating_sub(1)]);
                    break;
                }
            }
        }
        for ((_, measured), own) in self.measured.contacts.iter().zip(&beside.contacts) {
            let limit = OFF * interval(measured);
            let near = |i: usize| own.get(i).is_some_and(|(time, _)| (time - measured[i]).abs() <= limit);
            if let Some(i) = (0..measured.len()).find(|&i| !near(i)) {
                until = until.min(measured[i.saturating_sub(1)]);
            }
        }
        Ok(until)
    }

    /// Whether the residuals with some values are not much more than the noise.
    pub fn is_noise(&self, values: &[f64]) -> Result<bool> {
        let at = self.evaluate(values, Horizon(self.end()))?;
        let rms = |k: usize| {
            let own = at.places.iter().zip(&at.residuals).filter(|(place, _)| place.1 == k);
            if self.is_robust {
                return self.sigma[k] * typical(own.map(|(_, r)| *r));
            }
            let (sum, count) = own.fold((0.0, 0usize), |(sum, count), (_, r)| (sum + r * r, count + 1));
            self.sigma[k] * (sum / count.max(1) as f64).sqrt()
        };
        Ok(self.noise.iter().enumerate().all(|(k, noise)| rms(k) <= NOISY * noise))
    }

    /// The fitted machine.
    pub fn finish(&self, request: &FitRequest, values: &[f64], cost: f64) -> Result<Fitted> {
        let end = Horizon(self.end());
        let at = self.evaluate(values, end)?;
        let beside = self.beside(values, end, true)?;
        let (machine, start, ..) = self.with(values)?;
        let columns = &self.measured.columns;
        let rms_of = |squares: f64, count: usize| (squares / count.max(1) as f64).sqrt();
        let mut rms = Vec::new();
        for (k, (name, _)) in columns.iter().enumerate() {
            let squares = beside.samples.iter().map(|sample| sample[k].0.powi(2)).sum();
            rms.push((name.to_string(), rms_of(squares, beside.samples.len())));
        }
        let mut contacts = Vec::new();
        for ((name, measured), own) in self.measured.contacts.iter().zip(&beside.contacts) {
            let off: Vec<f64> =
                own.iter().zip(measured).map(|((time, _), measured)| time - measured).collect();
            rms.push((name.clone(), rms_of(off.iter().map(|x| x * x).sum(), off.len())));
            contacts.push((name.clone(), off));
        }
        let residuals = beside
            .samples
            .iter()
            .map(|sample| sample.iter().map(|(residual, _)| *residual).collect())
            .collect();
        let names: Vec<String> = request.free.iter().map(|own| own.name.clone()).collect();
        let uncertainty = Uncertainty::of(&at, &names, values, (request.loss, self.has_sigma));
        // Outliers that count little do not end it.
        let near_until = match request.loss {
            Loss::Linear => self.near_until(values, super::WAYS[0])?,
            Loss::SoftL1 | Loss::Huber => end.0,
        };
        Ok(Fitted {
            machine,
            start,
            values: names.into_iter().zip(values.iter().copied()).collect(),
            uncertainty,
            rms,
            residuals,
            contacts,
            lost: beside.lost,
            simulations: self.simulations.load(Ordering::Relaxed),
            near_until,
            cost,
        })
    }
}
