//! What must return for a motion of a described machine to be periodic: what forces depend on.
//!
//! Elongations of springs with stiffness and of stops, rates of all elements, and the phases of
//! harmonics where the section does not hold them. The angle of a shaft that nothing holds, and the
//! elongation of a dashpot, do not act.

use super::section::{Section, harmonics};
use crate::attractor::{LONGEST, RETURN, least_period, nears};
use std::f64::consts::TAU;
use vibro_assembly::Motion;
use vibro_assembly::description::{Description, Dimension};
use vibro_assembly::motion::{Event, EventKind};
use vibro_assembly::system::{Elongation, Part, StateRow, System};

/// Contacts slower than this part of the fastest are chatter, of which the number does not make a
/// period.
const CHATTER: f64 = 1e-6;
/// Part of a size that stands still, beside which changes of it count: a buffer of which the
/// deflection is 10⁵ times what it swings by is at rest.
const STANDING: f64 = 1e-5;
/// Roundings of the terms of a functional beside one another.
const ROUNDINGS: f64 = 64.0;
/// Roundings are at most this part of the sizes by which states are compared.
const ROUNDING_PART: f64 = 1e-4;
/// An event this near to a section, in parts of the interval, may come on either side of it.
const BESIDE: f64 = 1e-6;
/// Of fewer returns each may be larger than the one before by chance.
const FEW: usize = 16;
/// Points between two returns at which sizes are taken.
const SAMPLES: u32 = 8;

/// The numbers that must return.
#[derive(Clone, Debug)]
pub struct Functionals {
    rows: Vec<StateRow>,
    /// The kind of each: elongation or rate, of translation or rotation.
    kinds: Vec<usize>,
    /// Of a rate the place of its elongation, where a stiffness makes forces of it, and the
    /// frequency, rad/s, with which these turn roundings of the elongation into ones of the rate.
    stiff: Vec<Option<(usize, f64)>>,
    /// Frequencies, Hz, whose phases must return.
    phases: Vec<f64>,
}

impl Functionals {
    /// Those of a machine that is looked at in a section.
    pub fn of(d: &Description, system: &System, section: &Section) -> Self {
        let (mut all, mut kinds, mut stiff) = (Vec::new(), Vec::new(), Vec::new());
        let mut push = |row: &StateRow, kind: usize, stiffness: Option<(&Elongation, f64)>| {
            let frequency = |(e, k): (&Elongation, f64)| (k * e.w.dot(&e.mobility)).max(0.0).sqrt();
            stiff.push(stiffness.map(|own| (all.len() - 1, frequency(own))));
            all.push(row.clone());
            kinds.push(kind);
        };
        for (element, parts) in d.elements().zip(&system.parts) {
            let rotates = usize::from(element.dimension(d) == Dimension::Rotation);
            for &part in parts {
                let Some(e) = system.elongation_of_part(part) else { continue };
                let stiffness = match part {
                    Part::Spring(i) => Some(system.springs[i].stiffness).filter(|k| *k != 0.0),
                    Part::Stop(i) => Some(system.stops[i].stiffness()),
                    Part::Friction(_) | Part::Load(_) => None,
                };
                let damps = !matches!(part, Part::Spring(i) if system.springs[i].damping == 0.0);
                if let Some(stiffness) = stiffness {
                    push(&e.e, rotates, None);
                    push(&e.rate, 2 + rotates, Some((e, stiffness)));
                } else if damps {
                    push(&e.rate, 2 + rotates, None);
                }
            }
        }
        let phases = harmonics(d).map(|h| h.frequency).filter(|f| !section.holds(*f)).collect();
        Self { rows: all, kinds, stiff, phases }
    }

    /// Their values, cosine and sine of the phases last, and the sums of their terms' sizes.
    fn at(&self, motion: &Motion) -> (Vec<f64>, Vec<f64>) {
        let z = motion.state();
        let size = |row: &StateRow| row.iter().zip(z.iter()).map(|(r, x)| (r * x).abs()).sum::<f64>();
        let mut values: Vec<f64> = self.rows.iter().map(|row| row.dot(z)).collect();
        let mut sizes: Vec<f64> = self.rows.iter().map(size).collect();
        for (i, stiff) in self.stiff.iter().enumerate() {
            sizes[i] += stiff.map_or(0.0, |(place, frequency)| frequency * sizes[place]);
        }
        for frequency in &self.phases {
            let turns = frequency * motion.time();
            let (sine, cosine) = (TAU * turns.fract()).sin_cos();
            values.extend([cosine, sine]);
            sizes.extend([turns.max(1.0); 2]);
        }
        (values, sizes)
    }

    /// How a change of the state (q, q') changes each, phases left out.
    fn changes(&self, change: &[f64]) -> Vec<f64> {
        let along = |row: &StateRow| row.iter().zip(change).map(|(r, x)| r * x).sum();
        self.rows.iter().map(along).collect()
    }
}

/// A return: the values of the functionals.
#[derive(Clone, Debug)]
pub struct Return {
    pub state: Vec<f64>,
    /// The contacts since the last one, and a number that tells how many of each stop.
    pub contacts: u32,
    pattern: u64,
    /// s.
    pub time: f64,
}

/// Returns of a motion.
#[derive(Clone, Debug)]
pub struct Record {
    functionals: Functionals,
    pub returns: Vec<Return>,
    /// The least and the largest value of each functional.
    extents: Vec<[f64; 2]>,
    /// The largest sum of each one's terms.
    terms: Vec<f64>,
    fastest: f64,
    contacts: u32,
    pattern: u64,
    /// The times of contacts since the last return but one, s.
    struck: Vec<f64>,
    /// Whether a contact lies beside a return.
    pub is_beside: bool,
    /// Whether a stop stays closed or a friction sticks.
    pub rests: bool,
}

impl Record {
    /// Without a return so far.
    pub fn new(motion: &Motion, section: &Section) -> Self {
        let assembly = motion.assembly();
        let functionals = Functionals::of(&assembly.description, assembly.system(), section);
        let count = functionals.kinds.len() + 2 * functionals.phases.len();
        Self {
            functionals,
            returns: Vec::new(),
            extents: vec![[f64::INFINITY, f64::NEG_INFINITY]; count],
            terms: vec![0.0; count],
            fastest: 0.0,
            contacts: 0,
            pattern: 0,
            struck: Vec::new(),
            is_beside: false,
            rests: motion.mode().contacts().next().is_some(),
        }
    }

    pub fn event(&mut self, event: &Event) {
        match event.kind {
            EventKind::Impact { stop, speed, .. } | EventKind::Press { stop, speed } => {
                self.contacts += 1;
                self.fastest = self.fastest.max(speed);
                if speed > CHATTER * self.fastest {
                    // A sum, since of two contacts at one instant rounding says which comes first.
                    let own = (1 + stop as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                    self.pattern = self.pattern.wrapping_add(own ^ (own >> 29));
                    self.struck.push(event.time);
                }
            }
            EventKind::Close { .. } | EventKind::Stick { .. } => self.rests = true,
            _ => {}
        }
    }

    /// Takes a state into the sizes.
    fn include(&mut self, motion: &Motion) -> Vec<f64> {
        let (values, terms) = self.functionals.at(motion);
        for (([least, largest], size), (x, terms)) in
            self.extents.iter_mut().zip(&mut self.terms).zip(values.iter().zip(terms))
        {
            *least = least.min(*x);
            *largest = largest.max(*x);
            *size = size.max(terms);
        }
        values
    }

    /// Takes the way to the next return into the sizes, on a copy of the motion.
    pub fn look_between(&mut self, motion: &Motion, interval: f64) {
        let mut copy = motion.clone();
        for k in 1..=SAMPLES {
            let end = motion.time() + interval * f64::from(k) / f64::from(SAMPLES + 1);
            if copy.advance_to(end).is_err() {
                return;
            }
            self.include(&copy);
        }
    }

    pub fn arrive(&mut self, motion: &Motion, at_event: bool) {
        let time = motion.time();
        if let (false, Some(before)) = (at_event, self.returns.last().map(|r| r.time)) {
            let beside = BESIDE * (time - before);
            self.is_beside |=
                self.struck.iter().any(|t| (t - time).abs() <= beside || (t - before).abs() <= beside);
        }
        self.struck.clear();
        let state = self.include(motion);
        let (contacts, pattern) = (std::mem::take(&mut self.contacts), std::mem::take(&mut self.pattern));
        self.returns.push(Return { state, contacts, pattern, time });
    }

    /// Mean time between returns, s.
    pub fn interval(&self) -> f64 {
        match &self.returns[..] {
            [first, .., last] => (last.time - first.time) / (self.returns.len() - 1) as f64,
            _ => 1.0,
        }
    }

    /// The sizes of elongations and rates of a kind: how far they have been apart, in the way from
    /// one return to the next too, and at least a small part of what they are.
    fn size_of(&self, kind: usize) -> f64 {
        let kinds = self.functionals.kinds.iter().zip(&self.extents);
        let own = kinds
            .filter(|(own, _)| **own == kind)
            .map(|(_, [least, largest])| (largest - least).max(STANDING * largest.abs().max(least.abs())));
        own.fold(0.0, f64::max)
    }

    /// Sizes of lengths, angles, rates and spins: each at least what the other of its pair makes at
    /// the frequency of the returns.
    pub fn sizes(&self) -> [f64; 4] {
        let omega = TAU / self.interval();
        let [length, angle, rate, spin] = [0, 1, 2, 3].map(|kind| self.size_of(kind));
        [length.max(rate / omega), angle.max(spin / omega), rate.max(omega * length), spin.max(omega * angle)]
    }

    /// The sizes by which states are compared, number by number: of a shaft that has turned far, at
    /// least so much that rounding is a small part.
    pub fn scales(&self) -> Vec<f64> {
        let sizes = self.sizes();
        let kinds = self.functionals.kinds.iter().map(|kind| sizes[*kind]);
        let kinds = kinds.chain(std::iter::repeat(1.0)).zip(&self.terms);
        kinds.map(|(size, terms)| size.max(ROUNDINGS * f64::EPSILON * terms / ROUNDING_PART)).collect()
    }

    /// The largest difference of two states in parts of the sizes, roundings left out.
    fn distance(&self, a: &[f64], b: &[f64], scales: &[f64]) -> f64 {
        let parts = a.iter().zip(b).zip(scales.iter().zip(&self.terms));
        let part = |((a, b), (scale, terms)): ((&f64, &f64), (&f64, &f64))| {
            let apart = (a - b).abs() - ROUNDINGS * f64::EPSILON * terms;
            if apart > 0.0 && *scale > 0.0 { apart / scale } else { 0.0 }
        };
        parts.map(part).fold(0.0, f64::max)
    }

    /// A change of the state (q, q') in parts of the sizes, roundings left out.
    pub fn size_of_change(&self, change: &[f64]) -> f64 {
        let changes = self.functionals.changes(change);
        self.distance(&changes, &vec![0.0; changes.len()], &self.scales())
    }

    /// The least period up to [`LONGEST`] after which states return to a part of their sizes.
    pub fn period(&self, near: f64) -> Option<u32> {
        let scales = self.scales();
        least_period(&self.returns, |a, b| {
            a.pattern == b.pattern && self.distance(&a.state, &b.state, &scales) <= near
        })
    }

    /// The largest distance of the last returns from those so many before.
    pub fn return_distance(&self, period: u32) -> f64 {
        let (lag, scales) = (period as usize, self.scales());
        let last = &self.returns[self.returns.len().saturating_sub(2 * lag)..];
        let pairs = last.iter().zip(last.iter().skip(lag));
        pairs.map(|(a, b)| self.distance(&a.state, &b.state, &scales)).fold(0.0, f64::max)
    }

    /// Whether returns come nearer from one eighth of the record to the next.
    pub fn is_approaching(&self) -> bool {
        let scales = self.scales();
        nears(&self.returns, |a, b| self.distance(&a.state, &b.state, &scales))
    }

    /// Whether in the later half of the record a number that must return has changed in one
    /// direction from each return to the next: a motion that is braked or driven on.
    pub fn drifts(&self) -> bool {
        let later = &self.returns[self.returns.len() / 2..];
        let (Some(first), Some(last)) = (later.first(), later.last()) else { return false };
        let scales = self.scales();
        let goes = |j: usize| {
            let way = last.state[j] - first.state[j];
            let all = later.windows(2).all(|pair| (pair[1].state[j] - pair[0].state[j]) * way > 0.0);
            all && way.abs() > RETURN * scales[j]
        };
        later.len() >= FEW && (0..self.functionals.kinds.len()).any(goes)
    }

    /// Forgets early returns where there are more than are needed.
    pub fn shorten(&mut self) {
        if self.returns.len() >= 8 * LONGEST as usize {
            self.returns.drain(..4 * LONGEST as usize);
        }
    }
}
