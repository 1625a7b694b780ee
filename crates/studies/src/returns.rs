//! Returns of a described machine's motion: the quantities that must repeat in a periodic motion.
//!
//! Forces depend on elongations of stops and of springs with stiffness, on forces of springs in
//! series, on rates of all elements, and on phases of harmonics, unless the section fixes these.
//! The angle of a free shaft and the elongation of a dashpot have no effect.

use super::section::{Section, frequencies};
use crate::class::{LONGEST, RETURN, comes_nearer, least_period};
use std::f64::consts::TAU;
use vibro_machine::Motion;
use vibro_machine::description::{Description, Dimension};
use vibro_machine::functional::StateRow;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::system::{Elongation, Part, System};

/// Contacts slower than this fraction of the fastest one are chatter, and their number does not
/// count for a period.
const CHATTER: f64 = 1e-6;
/// Smallest size of changes relative to a constant part: a buffer whose deflection is 10⁵ times
/// its swing is at rest.
const STANDING: f64 = 1e-5;
/// Tolerance for the rounding of a functional, in units of `f64::EPSILON` times its terms.
const ROUNDINGS: f64 = 64.0;
/// Largest rounding relative to the sizes used to compare states.
const ROUNDING_PART: f64 = 1e-4;
/// Distance of an event from a section, relative to the interval, within which it may come on
/// either side.
const BESIDE: f64 = 1e-6;
/// Number of returns needed to show a drift; fewer may change in one direction by chance.
const FEW: usize = 16;
/// Number of kinds for lengths, angles and their rates. Each number of a block is a further kind.
const COMMON: usize = 4;
/// Number of samples between two returns for finding sizes.
const SAMPLES: u32 = 8;

/// Functionals that must repeat.
#[derive(Clone, Debug)]
pub struct Functionals {
    rows: Vec<StateRow>,
    /// Kind of each row: elongation or rate, of translation or rotation.
    kinds: Vec<usize>,
    /// For the rate of an element with stiffness: the index of its elongation, and the factor,
    /// rad/s, between the rounding of the elongation and that of the rate.
    stiff: Vec<Option<(usize, f64)>>,
    /// Frequencies, Hz, whose phases must repeat.
    phases: Vec<f64>,
}

impl Functionals {
    /// The functionals of a machine with a section.
    pub fn of(d: &Description, system: &System, section: &Section) -> Self {
        let (mut all, mut kinds, mut stiff) = (Vec::new(), Vec::new(), Vec::new());
        let mut push = |row: &StateRow, kind: usize, stiffness: Option<(&Elongation, f64)>| {
            let frequency = |(e, k): (&Elongation, f64)| (k * e.w.along(&e.mobility)).max(0.0).sqrt();
            stiff.push(stiffness.map(|own| (all.len() - 1, frequency(own))));
            all.push(row.clone());
            kinds.push(kind);
        };
        for (element, parts) in d.elements().zip(&system.parts) {
            let rotates = usize::from(element.dimension(d) == Dimension::Rotation);
            let acts = parts
                .iter()
                .any(|part| matches!(part, Part::Spring(i) if system.springs[*i].stiffness != 0.0));
            for &part in parts {
                let Some(e) = system.elongation_of_part(part) else { continue };
                let stiffness = match part {
                    Part::Spring(i) => Some(system.springs[i].stiffness).filter(|k| *k != 0.0),
                    // A spring with corners always has the stiffness of one of its lines.
                    Part::Stop(i) if system.is_corner(i) && acts => continue,
                    Part::Stop(i) if system.stops[i].is_freewheel => None,
                    Part::Stop(i) => Some(system.stops[i].stiffness()),
                    Part::Branch(i) => {
                        // The force must return, whatever the elongation and the inner state do.
                        let own = &system.branches[i];
                        // On residual flexibility the force depends on other contacts: its stretch
                        // must return.
                        let force = match system.is_residual(part) {
                            true => &own.whole - &own.inner,
                            false => own.force.clone(),
                        };
                        let factor = if system.is_residual(part) { 1.0 } else { own.stiffness };
                        push(&(&*force / factor), rotates, None);
                        push(&e.rate, 2 + rotates, Some((e, own.stiffness)));
                        continue;
                    }
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
        // The states of blocks must return, each relative to its own size.
        for block in &system.blocks {
            for place in block.first..block.first + block.kept() {
                let mut unit = StateRow::zeros(system.signals.size);
                unit[place] = 1.0;
                all.push(unit);
                kinds.push(COMMON + all.len());
                stiff.push(None);
            }
        }
        let phases = frequencies(d).filter(|f| !section.holds(*f)).collect();
        Self { rows: all, kinds, stiff, phases }
    }

    /// Values of the functionals, with cosines and sines of the phases last, and the sums of the
    /// absolute values of their terms.
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

    /// Changes of the functionals, without phases, for a change of the state (q, q').
    fn changes(&self, change: &[f64]) -> Vec<f64> {
        let along = |row: &StateRow| row.iter().zip(change).map(|(r, x)| r * x).sum();
        self.rows.iter().map(along).collect()
    }
}

/// Return: the values of the functionals.
#[derive(Clone, Debug)]
pub struct Return {
    pub state: Vec<f64>,
    /// Contacts since the last return. `pattern` identifies their number on each stop.
    pub contacts: u32,
    pattern: u64,
    /// Time, s.
    pub time: f64,
}

/// Record of the returns of a motion.
#[derive(Clone, Debug)]
pub struct ReturnRecord {
    functionals: Functionals,
    pub returns: Vec<Return>,
    /// Smallest and largest value of each functional.
    extents: Vec<[f64; 2]>,
    /// Largest sum of each functional's terms.
    terms: Vec<f64>,
    fastest: f64,
    contacts: u32,
    pattern: u64,
    /// Times of contacts since the last return, s.
    struck: Vec<f64>,
    /// Whether a contact lies next to a return.
    pub is_beside: bool,
    /// Whether at some time a stop stays closed or a friction element sticks.
    pub rests: bool,
}

impl ReturnRecord {
    /// A record without returns.
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
                    // A sum, since rounding may swap two contacts at the same instant.
                    let own = (1 + stop as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                    self.pattern = self.pattern.wrapping_add(own ^ (own >> 29));
                    self.struck.push(event.time);
                }
            }
            EventKind::Close { .. } | EventKind::Stick { .. } => self.rests = true,
            _ => {}
        }
    }

    /// Includes a state in the sizes.
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

    /// Includes the motion to the next return in the sizes; it is simulated on a copy.
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

    /// Size of elongations or rates of a kind: their range, also between returns, and at least a
    /// small part of their values.
    fn size_of(&self, kind: usize) -> f64 {
        let kinds = self.functionals.kinds.iter().zip(&self.extents);
        let own = kinds
            .filter(|(own, _)| **own == kind)
            .map(|(_, [least, largest])| (largest - least).max(STANDING * largest.abs().max(least.abs())));
        own.fold(0.0, f64::max)
    }

    /// Sizes of lengths, angles, rates and spins. A length and its rate, and an angle and its spin,
    /// give each other a least size by the frequency of the returns.
    pub fn sizes(&self) -> [f64; 4] {
        let omega = TAU / self.interval();
        let [length, angle, rate, spin] = [0, 1, 2, 3].map(|kind| self.size_of(kind));
        [length.max(rate / omega), angle.max(spin / omega), rate.max(omega * length), spin.max(omega * angle)]
    }

    /// Sizes used to compare states, number by number. For a shaft that has turned far they are so
    /// large that rounding is a small part.
    pub fn scales(&self) -> Vec<f64> {
        let sizes = self.sizes();
        let own = |kind: &usize| if *kind < COMMON { sizes[*kind] } else { self.size_of(*kind) };
        let kinds = self.functionals.kinds.iter().map(own);
        let kinds = kinds.chain(std::iter::repeat(1.0)).zip(&self.terms);
        kinds.map(|(size, terms)| size.max(ROUNDINGS * f64::EPSILON * terms / ROUNDING_PART)).collect()
    }

    /// Sizes of the states of blocks, in the order of the state.
    pub fn sizes_of_blocks(&self) -> impl Iterator<Item = f64> {
        self.functionals.kinds.iter().filter(|kind| **kind >= COMMON).map(|kind| self.size_of(*kind))
    }

    /// Largest difference of two states relative to the sizes, beyond rounding.
    fn distance(&self, a: &[f64], b: &[f64], scales: &[f64]) -> f64 {
        let parts = a.iter().zip(b).zip(scales.iter().zip(&self.terms));
        let part = |((a, b), (scale, terms)): ((&f64, &f64), (&f64, &f64))| {
            let apart = (a - b).abs() - ROUNDINGS * f64::EPSILON * terms;
            if apart > 0.0 && *scale > 0.0 { apart / scale } else { 0.0 }
        };
        parts.map(part).fold(0.0, f64::max)
    }

    /// Change of the state (q, q') relative to the sizes, beyond rounding.
    pub fn size_of_change(&self, change: &[f64]) -> f64 {
        let changes = self.functionals.changes(change);
        self.distance(&changes, &vec![0.0; changes.len()], &self.scales())
    }

    /// Period after which states return, relative to their sizes: the smallest one, up to
    /// [`LONGEST`].
    pub fn period(&self, near: f64) -> Option<u32> {
        let scales = self.scales();
        least_period(&self.returns, |a, b| {
            a.pattern == b.pattern && self.distance(&a.state, &b.state, &scales) <= near
        })
    }

    /// Largest distance of the last returns from the returns one period before.
    pub fn return_distance(&self, period: u32) -> f64 {
        let (lag, scales) = (period as usize, self.scales());
        let last = &self.returns[self.returns.len().saturating_sub(2 * lag)..];
        let pairs = last.iter().zip(last.iter().skip(lag));
        pairs.map(|(a, b)| self.distance(&a.state, &b.state, &scales)).fold(0.0, f64::max)
    }

    /// Whether returns come closer from each eighth of the record to the next.
    pub fn is_approaching(&self) -> bool {
        let scales = self.scales();
        comes_nearer(&self.returns, |a, b| self.distance(&a.state, &b.state, &scales))
    }

    /// Whether a functional changes in one direction, return by return, over the later half of the
    /// record: the motion is braked or accelerated.
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

    /// Forgets early returns that are no longer needed.
    pub fn shorten(&mut self) {
        if self.returns.len() >= 8 * LONGEST as usize {
            self.returns.drain(..4 * LONGEST as usize);
        }
    }
}

#[cfg(test)]
mod tests;
