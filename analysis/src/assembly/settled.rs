//! What a motion of a described machine settles on: its period in returns to the section, its class, its largest exponent.

use super::flight::Flows;
use super::section::Section;
use super::variation::Variation;
use crate::attractor::{LONGEST, MotionClass, OBSERVED, RETURN, SAME, ZERO_EXPONENT, least_period, nears};
use crate::error::Result;
use crate::largest_exponent::{BLOCK, ExponentSign, LargestExponent};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use vibro_assembly::Motion;
use vibro_assembly::description::Dimension;
use vibro_assembly::motion::{Event, EventKind};

/// A motion has settled when its states return to this part of their sizes, over four times its period: it is then not followed
/// further.
const STEADY: f64 = 1e-9;
/// Returns between two looks at whether a motion has settled.
const LOOK: u32 = 4;
/// Most returns over which an exponent is counted before its sign is left open.
const MOST_RETURNS: u32 = 512;
/// Contacts slower than this part of the fastest are chatter, of which the number does not make a period.
const CHATTER: f64 = 1e-6;

/// A state at the section: rates of the coordinates, elongations of springs and stops. What is not among them, such as the angle of a
/// wheel that nothing holds, does not act.
#[derive(Clone, Debug)]
struct Return {
    state: Vec<f64>,
    /// The contacts since the last one: how many, and their order as a number.
    contacts: u32,
    pattern: u64,
    /// s.
    time: f64,
}

/// Returns of a motion.
#[derive(Debug, Default)]
struct Record {
    returns: Vec<Return>,
    /// The kind of each number of a state: rate or elongation, of translation or rotation.
    kinds: Vec<usize>,
    /// The largest size of each kind.
    sizes: [f64; 4],
    fastest: f64,
    contacts: u32,
    pattern: u64,
    rests: bool,
}

impl Record {
    fn event(&mut self, event: &Event) {
        match event.kind {
            EventKind::Impact { stop, speed, .. } | EventKind::Press { stop, speed } => {
                self.contacts += 1;
                self.fastest = self.fastest.max(speed);
                if speed > CHATTER * self.fastest {
                    self.pattern = self.pattern.wrapping_mul(31).wrapping_add(1 + stop as u64);
                }
            }
            EventKind::Close { .. } | EventKind::Stick { .. } => self.rests = true,
            _ => {}
        }
    }

    fn arrive(&mut self, motion: &Motion) {
        let assembly = motion.assembly();
        let (d, system, z) = (&assembly.description, assembly.system(), motion.state());
        let n = system.coordinates;
        let rotates = |dimension: Dimension| usize::from(dimension == Dimension::Rotation);
        if self.kinds.is_empty() {
            self.kinds.extend(system.bodies_of.iter().map(|&b| rotates(d.bodies[b].dimension)));
            let elements = d.springs.iter().map(|s| &s.arms).chain(d.stops.iter().map(|s| &s.arms));
            self.kinds.extend(elements.map(|arms| 2 + rotates(arms.dimension)));
        }
        let mut state: Vec<f64> = z.as_slice()[n..2 * n].to_vec();
        state.extend(system.springs.iter().map(|s| s.elongation.e.dot(z)));
        state.extend(system.stops.iter().map(|s| s.elongation.e.dot(z)));
        for (kind, x) in self.kinds.iter().zip(&state) {
            self.sizes[*kind] = self.sizes[*kind].max(x.abs());
        }
        let (contacts, pattern) = (std::mem::take(&mut self.contacts), std::mem::take(&mut self.pattern));
        self.returns.push(Return { state, contacts, pattern, time: motion.time() });
    }

    /// Mean time between returns, s.
    fn interval(&self) -> f64 {
        match &self.returns[..] {
            [first, .., last] => (last.time - first.time) / (self.returns.len() - 1) as f64,
            _ => 1.0,
        }
    }

    /// The sizes by which states are compared, number by number.
    fn scales(&self) -> Vec<f64> {
        let omega = TAU / self.interval();
        let [rate, spin, length, angle] = self.sizes;
        // A rate that happens to be small at the section is compared with what its coordinate does.
        let sizes = [rate.max(omega * length), spin.max(omega * angle), length, angle];
        self.kinds.iter().map(|kind| sizes[*kind]).collect()
    }

    fn period(&self, near: f64) -> Option<u32> {
        let scales = self.scales();
        least_period(&self.returns, |a, b| {
            a.pattern == b.pattern && is_near(&a.state, &b.state, &scales, near)
        })
    }
}

fn is_near(a: &[f64], b: &[f64], scales: &[f64], near: f64) -> bool {
    a.iter().zip(b).zip(scales).all(|((a, b), scale)| (a - b).abs() <= near * scale)
}

/// What a motion has settled on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// Its period in returns, where it has one up to [`LONGEST`].
    pub period: Option<u32>,
    /// Its class.
    pub class: MotionClass,
    /// Its largest exponent, where it was computed.
    pub exponent: Option<LargestExponent>,
    /// Impacts and first touches a return.
    pub contacts: f64,
    /// Whether a stop stays closed or a friction sticks in the course of it.
    pub rests: bool,
    /// Mean time between returns, s.
    pub interval: f64,
    /// The states of one period, in parts of [`scales`](Self::scales).
    pub states: Vec<Vec<f64>>,
    /// The sizes of the states' numbers, SI.
    pub scales: Vec<f64>,
}

impl Settled {
    /// Whether both are for certain not one attractor: two periods, or states that differ.
    pub fn differs(&self, other: &Self) -> bool {
        if !(self.class.is_decided() && other.class.is_decided()) {
            return false;
        }
        if self.period != other.period {
            return true;
        }
        let ones = vec![1.0; self.scales.len()];
        let inverse: Vec<f64> = self.scales.iter().zip(&other.scales).map(|(a, b)| b / a).collect();
        let own = |theirs: &[f64]| -> Vec<f64> {
            theirs.iter().zip(&inverse).map(|(x, r)| if r.is_finite() { x * r } else { 0.0 }).collect()
        };
        self.period.is_some()
            && !other.states.iter().all(|theirs| {
                let theirs = own(theirs);
                self.states.iter().any(|mine| is_near(mine, &theirs, &ones, SAME))
            })
    }
}

/// Advances a motion over `discard` returns, or until it has settled.
///
/// # Errors
/// As [`Section::advance`].
pub fn discard(motion: &mut Motion, section: &Section, discard: u32) -> Result<()> {
    let mut record = Record::default();
    for k in 1..=discard {
        section.advance(motion, &mut |event| record.event(event))?;
        record.arrive(motion);
        if k % LOOK == 0 && record.period(STEADY).is_some() {
            return Ok(());
        }
        // Four times the longest period is looked at.
        if record.returns.len() >= 8 * LONGEST as usize {
            record.returns.drain(..4 * LONGEST as usize);
        }
    }
    Ok(())
}

/// Follows a motion until its returns have settled, or over [`OBSERVED`] of them.
fn observe(motion: &mut Motion, section: &Section) -> Result<Record> {
    let mut record = Record::default();
    record.arrive(motion);
    for k in 1..=OBSERVED {
        section.advance(motion, &mut |event| record.event(event))?;
        record.arrive(motion);
        if k % LOOK == 0 && record.period(STEADY).is_some() {
            break;
        }
    }
    Ok(record)
}

/// The largest exponent of a motion from the present on: until its sign is decided or, where `most` is given, over as many returns.
///
/// # Errors
/// As [`Section::advance`].
pub fn exponent(
    motion: &mut Motion,
    section: &Section,
    interval: f64,
    most: Option<u32>,
) -> Result<LargestExponent> {
    let assembly = motion.assembly().clone();
    let (mut flows, omega) = (Flows::default(), TAU / interval);
    let mut variation = Variation::new(assembly.system(), motion.mode(), omega);
    let begin = motion.time();
    let (limit, threshold) = (most.unwrap_or(MOST_RETURNS), ZERO_EXPONENT * omega);
    let mut blocks = 0;
    loop {
        for _ in 0..BLOCK {
            section.follow(motion, &mut flows, &mut [&mut variation])?;
            variation.scale();
        }
        variation.end_block();
        blocks += 1;
        let block = (motion.time() - begin) / f64::from(blocks);
        let found = variation.exponent(block);
        let threshold = if most.is_some() { f64::INFINITY } else { threshold };
        if variation.is_decided(block, threshold, limit) || found.value == f64::NEG_INFINITY {
            return Ok(found);
        }
    }
}

/// What a motion settles on, from the present on. The exponent of a motion with a period is computed where `exponents` gives the
/// number of returns; of one without, its sign decides on the class.
///
/// # Errors
/// As [`Section::advance`].
pub fn settled(motion: &mut Motion, section: &Section, exponents: Option<u32>) -> Result<Settled> {
    let mut record = observe(motion, section)?;
    let mut period = record.period(RETURN);
    let mut found = None;
    if period.is_none() {
        found = Some(exponent(motion, section, record.interval(), None)?);
        let threshold = ZERO_EXPONENT * TAU / record.interval();
        let sign = found.map(|e| e.sign_beyond(threshold, record.interval()));
        if sign == Some(ExponentSign::Negative) {
            // It was still on its way.
            discard(motion, section, MOST_RETURNS)?;
            record = observe(motion, section)?;
            period = record.period(RETURN);
        }
    }
    let interval = record.interval();
    let sign = found.map(|e| e.sign_beyond(ZERO_EXPONENT * TAU / interval, interval));
    let scales = record.scales();
    let approaching = period.is_none()
        && nears(&record.returns, |a, b| {
            let parts = a.state.iter().zip(&b.state).zip(&scales);
            parts.map(|((a, b), s)| if *s > 0.0 { (a - b).abs() / s } else { 0.0 }).fold(0.0, f64::max)
        });
    let class = MotionClass::by_sign(period, sign, approaching);
    if let Some(returns) = exponents {
        found = Some(exponent(motion, section, interval, Some(returns))?);
    }
    let count = period.map_or(record.returns.len().saturating_sub(1), |n| n as usize).max(1);
    let last = &record.returns[record.returns.len().saturating_sub(count)..];
    let contacts = last.iter().map(|r| f64::from(r.contacts)).sum::<f64>() / last.len() as f64;
    let part = |(x, s): (&f64, &f64)| if *s > 0.0 { x / s } else { 0.0 };
    let shown = if period.is_some() { last } else { &last[last.len() - 1..] };
    let states = shown.iter().map(|r| r.state.iter().zip(&scales).map(part).collect()).collect();
    Ok(Settled { period, class, exponent: found, contacts, rests: record.rests, interval, states, scales })
}
