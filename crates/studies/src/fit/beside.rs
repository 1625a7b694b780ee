//! Motion of a machine compared with a record, segment by segment.

use super::evaluated::{Point, Reach, Rows, Segment, Varied};
use super::filter::{Carried, Sensor, sensors};
use super::statistics::interval;
use super::unknowns::{Columns, Made, Unknowns};
use super::{FitRequest, Measured};
use crate::QuantityName;
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use vibro_machine::description::Description;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Differentiated, Quantity, What};

/// Step of a finite difference, relative to the value; for a value of 0, in SI units.
const MOVED: f64 = 1e-6;
/// Number of parts in which a motion with a limited number of events advances.
const PARTS: u32 = 32;

/// Record, with the motion's quantity for each column and the stop for each list of contacts.
pub(super) struct Compared<'a> {
    pub measured: &'a Measured,
    quantities: Vec<Quantity>,
    /// Rate of each column's quantity, if the machine has it.
    pub rates: Vec<Option<Quantity>>,
    /// Filters of columns.
    pub sensors: Arc<[Sensor]>,
    /// Index of the stop of each list of contacts.
    stops: Vec<usize>,
    /// Largest number of events of a motion. A motion with more is an error.
    pub most_events: usize,
    simulations: AtomicU32,
}

/// Simulated segment of the motion.
#[derive(Clone, Default)]
pub(super) struct Followed {
    /// Index of the first sample.
    first: usize,
    /// Motion minus record, for each time and column.
    pub samples: Vec<Vec<Varied>>,
    /// For each list of contacts: the indices of the record's contacts in this segment, and the
    /// times of the motion's contacts.
    contacts: Vec<(Range<usize>, Vec<Varied>)>,
    /// State at which the next segment begins; empty for the last segment.
    pub end: Vec<Varied>,
    /// Record time at which the segment ends, s.
    until: f64,
    /// Record times of impacts and first touches, with the indices of the stops.
    pub events: Vec<(f64, usize)>,
    /// Reasons for derivatives that do not exist.
    lost: Vec<String>,
}

/// Motion of the second segment, the first one that begins with its own state.
type Second = OnceLock<Differentiated>;

/// Motion with its residuals.
pub(super) struct Beside(pub Vec<Followed>);

impl Beside {
    /// Residuals of all columns, for each time.
    pub fn samples(&self) -> impl Iterator<Item = &[Varied]> {
        self.0.iter().flat_map(|own| own.samples.iter().map(Vec::as_slice))
    }

    /// Record times of impacts and first touches, with the indices of the stops.
    pub fn events(&self) -> impl Iterator<Item = &(f64, usize)> {
        self.0.iter().flat_map(|own| &own.events)
    }

    /// Number of impacts and first touches.
    pub fn contacts_of_motion(&self) -> usize {
        self.0.iter().map(|own| own.events.len()).sum()
    }

    /// Residuals of a column.
    pub fn residuals(&self, column: usize) -> impl Iterator<Item = f64> {
        self.samples().map(move |sample| sample[column].0)
    }

    /// Times of the motion's contacts, paired with the indices of the record's contacts; `None` if
    /// the motion lacks one.
    pub fn contacts(&self, list: usize) -> impl Iterator<Item = (usize, Option<f64>)> {
        self.0.iter().flat_map(move |own| {
            let (range, times) = &own.contacts[list];
            range.clone().enumerate().map(|(i, place)| (place, times.get(i).map(|(time, _)| *time)))
        })
    }

    /// Norm of the difference between two motions compared with one record. Infinite if the
    /// motions have different numbers of contacts for the record's contacts. `sigma` has the
    /// standard deviations of the columns, then of the lists of contacts.
    pub fn apart(&self, other: &Self, sigma: &[f64]) -> f64 {
        let one = |(a, b): (&Varied, &Varied), sigma: &f64| ((a.0 - b.0) / sigma).powi(2);
        let mut sum = 0.0;
        for (own, other) in self.samples().zip(other.samples()) {
            sum += own.iter().zip(other).zip(sigma).map(|(pair, sigma)| one(pair, sigma)).sum::<f64>();
        }
        for (own, other) in self.0.iter().zip(&other.0) {
            let columns = own.samples.first().map_or(sigma.len() - own.contacts.len(), Vec::len);
            for (k, ((range, a), (_, b))) in own.contacts.iter().zip(&other.contacts).enumerate() {
                if a.len().min(range.len()) != b.len().min(range.len()) {
                    return f64::INFINITY;
                }
                let pairs = a.iter().zip(b).take(range.len());
                sum += pairs.map(|pair| one(pair, &sigma[columns + k])).sum::<f64>();
            }
        }
        sum.sqrt()
    }

    /// Reasons for derivatives that do not exist.
    pub fn lost(&self) -> Vec<String> {
        self.0.iter().flat_map(|own| own.lost.iter().cloned()).collect()
    }
}

/// Rate of a quantity, if the machine has it.
fn rate_of(name: &QuantityName, d: &Description) -> Option<Quantity> {
    let what = match name.what {
        What::S => What::V,
        What::V => What::A,
        What::E => What::Rate,
        _ => return None,
    };
    QuantityName { of: name.of.clone(), what }.find(d).ok().map(|named| named.quantity)
}

/// Index of the stop for each list of contacts in a record.
pub(super) fn stops_of(measured: &Measured, d: &Description) -> Result<Vec<usize>> {
    let of = |(element, _): &(String, Vec<f64>)| {
        let plain = element.strip_prefix("stop.").unwrap_or(element);
        d.stops.iter().position(|stop| stop.name == plain).ok_or_else(|| {
            let known: Vec<&str> = d.stops.iter().map(|stop| stop.name.as_str()).collect();
            let problem = format!("no stop is named `{element}`; expected one of {}", known.join(", "));
            Error::Described { problem }
        })
    };
    measured.contacts.iter().map(of).collect()
}

impl<'a> Compared<'a> {
    pub fn new(request: &'a FitRequest) -> Result<Self> {
        let (measured, d) = (&request.measured, &request.machine.description);
        let sensors = sensors(request)?;
        let quantity = |(name, _): &(QuantityName, Vec<f64>)| {
            let filter = request.filters.iter().position(|own| own.column == *name);
            match filter.map(|k| &sensors[k]) {
                Some(sensor) => Ok((sensor.output, sensor.rate)),
                None => Ok((name.find(d)?.quantity, rate_of(name, d))),
            }
        };
        let pairs = measured.columns.iter().map(quantity).collect::<Result<Vec<_>>>()?;
        let (quantities, rates) = pairs.into_iter().unzip();
        Ok(Self {
            measured,
            quantities,
            rates,
            sensors: sensors.into(),
            stops: stops_of(measured, d)?,
            most_events: usize::MAX,
            simulations: AtomicU32::new(0),
        })
    }

    /// Advances a motion of a segment, in parts if its events are limited.
    fn advance(
        &self,
        motion: &mut Differentiated,
        until: f64,
        note: &mut dyn FnMut(&Event, &[Option<f64>]),
        count: &Cell<usize>,
    ) -> Result<()> {
        let (from, parts) = (motion.motion().time(), if self.most_events < usize::MAX { PARTS } else { 1 });
        for k in 1..=parts {
            let part = f64::from(k) / f64::from(parts);
            let time = if k == parts { until } else { from + (until - from) * part };
            motion.advance_observed(time, note)?;
            if count.get() > self.most_events {
                let problem = format!("{} events; expected at most {}", count.get(), self.most_events);
                return Err(Error::Described { problem });
            }
        }
        Ok(())
    }

    /// Largest of the mean intervals between contacts of each list, s; 0 without contacts.
    pub fn longest_interval(&self) -> f64 {
        let lists = self.measured.contacts.iter().map(|(_, times)| times);
        lists.filter(|times| !times.is_empty()).fold(0.0, |most: f64, times| most.max(interval(times)))
    }

    /// Quantity of a column, and its rate if available.
    pub fn quantities_of(&self, column: usize) -> (Quantity, Option<Quantity>) {
        (self.quantities[column], self.rates[column])
    }

    /// Number of simulations so far.
    pub fn simulations(&self) -> u32 {
        self.simulations.load(Ordering::Relaxed)
    }

    /// Simulates all segments, with derivatives on request.
    pub fn beside(&self, unknowns: &Unknowns, point: &Point, reach: &Reach, varied: bool) -> Result<Beside> {
        self.simulations.fetch_add(1, Ordering::Relaxed);
        let made = unknowns.with(&point.values)?;
        let second = Second::new();
        let one = |k: usize| {
            let found = self.follow((unknowns, &made, &second), point, reach, k, varied)?;
            if varied { self.filled(unknowns, point, reach, k, found) } else { Ok(found) }
        };
        // The second segment comes first: the later ones begin from its motion, whatever the
        // number of threads.
        let early = (!reach.nodes.is_empty()).then(|| one(1)).transpose()?;
        let others = (0..=reach.nodes.len()).into_par_iter().filter(|k| *k != 1).map(one);
        let mut all = others.collect::<Result<Vec<_>>>()?;
        early.into_iter().for_each(|own| all.insert(1, own));
        Ok(Beside(all))
    }

    /// Motion at the start of a segment. A segment after the second one uses the machine and the
    /// modes of the second one again.
    fn begin(
        &self,
        (made, second): (&Made, &Second),
        point: &Point,
        (k, node): (usize, f64),
        columns: &Columns,
        note: &mut dyn FnMut(&Event, &[Option<f64>]),
    ) -> Result<Differentiated> {
        let assembly = made.assembly.clone();
        if k == 0 {
            return Ok(made.start.differentiated_by(assembly, &columns.by, note)?);
        }
        let (time, state) = (node + made.shift, &point.states[k - 1]);
        Ok(match second.get() {
            Some(other) => other.again_observed(time, state, note)?,
            None => Differentiated::from_state_observed(assembly, time, state, &columns.by, note)?,
        })
    }

    /// Simulates a segment.
    fn follow(
        &self,
        (unknowns, made, second): (&Unknowns, &Made, &Second),
        point: &Point,
        reach: &Reach,
        k: usize,
        varied: bool,
    ) -> Result<Followed> {
        let node = |k: usize| k.checked_sub(1).map_or(f64::NEG_INFINITY, |k| reach.nodes[k]);
        let (from, next) = (node(k), reach.nodes.get(k).copied());
        let until = next.unwrap_or(reach.end);
        let states = (k > 0).then(|| point.states[k - 1].len());
        let mut columns = if varied { unknowns.columns(states) } else { Columns::default() };
        // Only in the first segment do the filters' initial states depend on other parameters.
        // Later segments begin with fitted states.
        let begins = if varied && k == 0 { &self.sensors[..] } else { &[] };
        let carried = Carried::of(begins, (&made.assembly, &made.start), &mut columns.by)?;
        let inside = |times: &[f64]| {
            let end = |time: &f64| if next.is_some() { *time < until } else { *time <= until };
            times.partition_point(|time| *time < from)..times.partition_point(end)
        };
        let lists = self.measured.contacts.iter();
        let mut contacts: Vec<_> = lists.map(|(_, times)| (inside(times), Vec::new())).collect();
        let (mut events, count) = (Vec::new(), Cell::new(0));
        let mut note = |event: &Event, by: &[Option<f64>]| {
            count.set(count.get() + 1);
            let (EventKind::Impact { stop, .. } | EventKind::Press { stop, .. }) = event.kind else { return };
            events.push((event.time - made.shift, stop));
            if let Some(list) = self.stops.iter().position(|own| *own == stop) {
                let by = columns.all(&|k| by[k], Some(-1.0), None);
                contacts[list].1.push((event.time - made.shift, by));
            }
        };
        let mut motion = self.begin((made, second), point, (k, from), &columns, &mut note)?;
        let begin = motion.motion().time();
        let mut samples = Vec::new();
        let data = &self.measured.columns;
        let range = if data.is_empty() { 0..0 } else { inside(&self.measured.times) };
        for row in range.clone() {
            // The motion does not exist before its start.
            let time = (self.measured.times[row] + made.shift).max(begin);
            self.advance(&mut motion, time, &mut note, &count)?;
            let sample = |k: usize| {
                let value = motion.motion().value(self.quantities[k]) + made.offsets[k] - data[k].1[row];
                let rate = self.rates[k].map(|rate| motion.motion().value(rate));
                let by = |p| carried.with(p, &|p| motion.derivative(self.quantities[k], p));
                (value, columns.all(&by, rate, Some(k)))
            };
            samples.push((0..data.len()).map(sample).collect());
        }
        if (next.is_some() || !self.stops.is_empty()) && until + made.shift > motion.motion().time() {
            self.advance(&mut motion, until + made.shift, &mut note, &count)?;
        }
        let end = if next.is_some() { end_of(&motion, &columns, &carried) } else { Vec::new() };
        let lost =
            (0..columns.by.len()).filter_map(|p| Some(format!("{}: {}", columns.by[p], motion.lost(p)?)));
        let lost = lost.collect();
        if next.is_none() && !self.stops.is_empty() {
            // A contact of the motion may come later than the record's last contact, so the motion
            // is continued by one interval. If it cannot be continued, it already covers the
            // record.
            let later = until + made.shift + self.longest_interval();
            let _ = self.advance(&mut motion, later, &mut note, &count);
            events.retain(|(time, _)| *time <= until);
        }
        if k == 1 {
            second.get_or_init(|| motion);
        }
        Ok(Followed { first: range.start, samples, contacts, end, until, events, lost })
    }

    /// Segment with finite differences in place of missing derivatives.
    fn filled(
        &self,
        unknowns: &Unknowns,
        point: &Point,
        reach: &Reach,
        k: usize,
        mut found: Followed,
    ) -> Result<Followed> {
        let count = point.values.len();
        let states = if k > 0 { point.states[k - 1].len() } else { 0 };
        for column in (0..count + states).filter(|&column| found.lacks(column)).collect::<Vec<_>>() {
            let moved = |sign: f64| {
                let mut other = point.clone();
                let own = match column.checked_sub(count) {
                    None => &mut other.values[column],
                    Some(i) => &mut other.states[k - 1][i],
                };
                let by = sign * if *own == 0.0 { MOVED } else { MOVED * own.abs() };
                *own += by;
                self.simulations.fetch_add(1, Ordering::Relaxed);
                let made = unknowns.with(&other.values).ok()?;
                Some((by, self.follow((unknowns, &made, &Second::new()), &other, reach, k, false).ok()?))
            };
            // A central difference; beyond a limit of the range, a one-sided difference.
            let same = || Some((0.0, found.clone()));
            let (Some((high, after)), Some((low, before))) =
                (moved(1.0).or_else(same), moved(-1.0).or_else(same))
            else {
                continue;
            };
            if high > low {
                found.fill(column, &after, &before, high - low);
            }
        }
        Ok(found)
    }
}

impl Followed {
    /// All values, with the first `counts` entries of each contact list.
    fn numbers<'f>(&'f mut self, counts: &'f [usize]) -> impl Iterator<Item = &'f mut Varied> {
        let contacts = self.contacts.iter_mut().zip(counts).flat_map(|((_, own), n)| own.iter_mut().take(*n));
        self.samples.iter_mut().flatten().chain(contacts).chain(&mut self.end)
    }

    /// Whether a value lacks a derivative in a column.
    fn lacks(&self, column: usize) -> bool {
        let contacts = self.contacts.iter().flat_map(|(_, own)| own.iter());
        let mut all = self.samples.iter().flatten().chain(contacts).chain(&self.end);
        all.any(|(_, by)| by[column].is_none())
    }

    /// Fills missing derivatives of a column from two motions whose parameter differs by `width`.
    fn fill(&mut self, column: usize, after: &Self, before: &Self, width: f64) {
        let lists = self.contacts.iter().zip(&after.contacts).zip(&before.contacts);
        let counts: Vec<usize> = lists.map(|((a, b), c)| a.1.len().min(b.1.len()).min(c.1.len())).collect();
        let (mut after, mut before) = (after.clone(), before.clone());
        let pairs = after.numbers(&counts).zip(before.numbers(&counts));
        for ((_, by), ((a, _), (b, _))) in self.numbers(&counts).zip(pairs) {
            by[column].get_or_insert((*a - *b) / width);
        }
    }

    /// Residuals and derivatives in units of the standard deviations, sorted by time.
    pub fn segment(
        &self,
        measured: &Measured,
        sigma: &[f64],
        shape: (usize, usize),
        joint: Option<(&[f64], &[f64])>,
    ) -> Segment {
        let mut rows: Vec<((f64, usize), (Varied, f64))> = Vec::new();
        let columns = measured.columns.len();
        let times = &measured.times[self.first.min(measured.times.len())..];
        for (time, sample) in times.iter().zip(&self.samples) {
            rows.extend(sample.iter().enumerate().map(|(k, own)| ((*time, k), (own.clone(), sigma[k]))));
        }
        for (k, ((_, times), (range, own))) in measured.contacts.iter().zip(&self.contacts).enumerate() {
            for (i, time) in times[range.clone()].iter().enumerate() {
                // A missing contact counts as one at the segment's end.
                let none = || (self.until, vec![None; shape.0 + shape.1]);
                let (at, by) = own.get(i).cloned().unwrap_or_else(none);
                rows.push(((*time, columns + k), ((at - time, by), sigma[columns + k])));
            }
        }
        rows.sort_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (places, rows): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        let defect = joint.map(|(next, weights)| {
            let own = self.end.iter().zip(next).zip(weights);
            let rows: Vec<_> =
                own.map(|(((end, by), next), weight)| ((end - next, by.clone()), 1.0 / weight)).collect();
            Rows::of(&rows, shape)
        });
        let weights = joint.map_or(Vec::new(), |(_, weights)| weights.to_vec());
        let has_differences = !self.lost.is_empty();
        Segment { rows: Rows::of(&rows, shape), places, defect, weights, has_differences, record: 0 }
    }
}

/// State of a motion with its derivatives.
pub(super) fn end_of(motion: &Differentiated, columns: &Columns, carried: &Carried) -> Vec<Varied> {
    let own = motion.motion();
    let by: Vec<_> = (0..columns.by.len()).map(|p| motion.state_derivative(p)).collect();
    let rates = own.state_derivatives();
    let all = |(i, state): (usize, f64)| {
        (state, columns.all(&|p| carried.with(p, &|p| Some(by[p].as_ref()?[i])), Some(rates[i]), None))
    };
    own.states().into_iter().enumerate().map(all).collect()
}
