//! The largest Lyapunov exponent of a described machine's motion: one variation, carried exactly through flights and events.
//!
//! In a flight a variation δ follows z' = A z like the state. At an event that ends where h·z = 0, the perturbed motion meets it by
//! δt = -h·δ / h·f⁻ later, with f = A z on either side, so that δ⁺ = J(δ + f⁻ δt) - f⁺ δt: the saltation matrix, with J the derivative of
//! the impact law, and the identity where no velocity jumps. What a closed stop or a sticking friction takes away is gone: the
//! variation lies in what is left.

use super::flight::{Flight, Observer, Passage, dot};
use crate::largest_exponent::{Growth, LargestExponent};
use nalgebra::DVector;
use vibro_assembly::law::Sizes;
use vibro_assembly::law::impact::Instant;
use vibro_assembly::mode::{Contact, Mode, StopState};
use vibro_assembly::motion::EventKind;
use vibro_assembly::system::System;

/// The impact law is linear as long as the same stops take part: its derivative is a difference over this part of the velocities.
const STEP: f64 = 1e-6;
/// A passage slower than this part of the sizes of its terms is a touch, at which no derivative exists.
const TOUCH: f64 = 1e-12;
/// Sweeps in which a variation is brought into what contacts leave free.
const SWEEPS: usize = 50;

/// One variation of a motion, and how it has grown.
#[derive(Debug)]
pub struct Variation {
    v: Vec<f64>,
    /// Number of coordinates q.
    coordinates: usize,
    /// Weight of coordinates beside rates in the length, 1/s.
    omega: f64,
    growth: Growth,
}

impl Variation {
    /// In general position, for a motion that is in this mode; `omega` is a frequency of the motion, 1/s.
    pub fn new(system: &System, mode: &Mode, omega: f64) -> Self {
        let n = system.coordinates;
        let mut v = vec![0.0; system.signals.size];
        for (k, x) in v[..2 * n].iter_mut().enumerate() {
            // No two alike, none zero.
            *x = (1.0 + 0.7 * k as f64).sin() / if k < n { omega } else { 1.0 };
        }
        let mut variation = Self { v, coordinates: n, omega, growth: Growth::default() };
        variation.keep(system, &mode.basis);
        variation.scale();
        variation.growth = Growth::default();
        variation
    }

    /// What contacts hold does not vary.
    fn keep(&mut self, system: &System, basis: &[Contact]) {
        let n = system.coordinates;
        for _ in 0..if basis.len() > 1 { SWEEPS } else { basis.len() } {
            for &contact in basis {
                let w = &system.elongation_of(contact).w;
                let mobility = system.inertia.solve(w);
                let share = w.dot(&mobility);
                let firsts: &[usize] = if matches!(contact, Contact::Stop(_)) { &[0, n] } else { &[n] };
                for &first in firsts {
                    let off = dot(w.as_slice(), &self.v[first..first + n]) / share;
                    (0..n).for_each(|k| self.v[first + k] -= off * mobility[k]);
                }
            }
        }
    }

    /// Makes its length one, and notes by how much it has grown.
    pub fn scale(&mut self) {
        let n = self.v.len();
        let weight = |k: usize| if k < self.coordinates { self.omega } else { 1.0 };
        let length = (0..n).map(|k| (weight(k) * self.v[k]).powi(2)).sum::<f64>().sqrt();
        self.growth.add(length.ln());
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        self.v.iter_mut().for_each(|x| *x *= scale);
    }

    /// Ends a block of so many returns.
    pub fn end_block(&mut self) {
        self.growth.end_block();
    }

    /// The exponent so far, of blocks of this many seconds.
    pub fn exponent(&self, block: f64) -> LargestExponent {
        self.growth.exponent(block)
    }

    /// Whether its sign is decided.
    pub fn is_decided(&self, block: f64, threshold: f64, most: u32) -> bool {
        self.growth.is_decided(block, threshold, most)
    }
}

/// What impacts make of a small change `d` of the state before them; the same where there are none.
fn through_impacts(system: &System, passage: &Passage<'_>, d: &[f64]) -> Vec<f64> {
    let mut hit: Vec<usize> = Vec::new();
    let mut restitution: Vec<f64> = system.stops.iter().map(|s| s.restitution().unwrap_or(0.0)).collect();
    for event in passage.events {
        match event.kind {
            EventKind::Impact { stop, .. } => hit.push(stop),
            // What closes has lost its last bounces.
            EventKind::Close { stop } => restitution[stop] = 0.0,
            _ => {}
        }
    }
    if hit.is_empty() {
        return d.to_vec();
    }
    let closed = passage.flows[0].mode.stops.iter().enumerate().filter(|(_, s)| **s == StopState::Closed);
    hit.extend(closed.map(|(i, _)| i));
    hit.sort_unstable();
    hit.dedup();
    let n = system.coordinates;
    let before = DVector::from_column_slice(passage.states[0]);
    let size = |z: &[f64]| z[n..2 * n].iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let change = size(d);
    if change == 0.0 {
        return d.to_vec();
    }
    let step = STEP * size(passage.states[0]).max(f64::MIN_POSITIVE) / change;
    let sizes = Sizes(before.abs());
    let instant = Instant { system, sizes: &sizes, touching: &hit, restitution: &restitution };
    let mut moved = before.clone();
    (0..moved.len()).for_each(|k| moved[k] += step * d[k]);
    let (mut plain, mut changed) = (before, moved);
    let both = instant.collide(&mut plain).and(instant.collide(&mut changed));
    let mut after = d.to_vec();
    // A jam has ended the motion before.
    if both.is_ok() {
        (n..2 * n).for_each(|k| after[k] = (changed[k] - plain[k]) / step);
    }
    after
}

impl Observer for Variation {
    fn flight(&mut self, _: &System, flight: Flight<'_>) {
        self.v = flight.flow.stretches(&self.v, flight.span, &mut |_, _| ());
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        let before = passage.states[0];
        let [incoming, outgoing] = [0, 1].map(|k| passage.flows[k].derivative(passage.states[k]));
        // Of two functionals with one name the one that is zero here.
        let ended = passage.flows[0].watched.iter().filter(|(watch, _)| Some(*watch) == passage.watch);
        let row = ended.map(|(_, row)| row.as_slice()).min_by(|a, b| {
            let value = |row: &[f64]| dot(row, before).abs();
            value(a).total_cmp(&value(b))
        });
        let later = row.map_or(0.0, |row| {
            let speed = dot(row, &incoming);
            let terms: f64 = row.iter().zip(&incoming).map(|(a, b)| (a * b).abs()).sum();
            if speed.abs() <= TOUCH * terms { 0.0 } else { -dot(row, &self.v) / speed }
        });
        let met: Vec<f64> = self.v.iter().zip(&incoming).map(|(v, f)| v + f * later).collect();
        let jumped = through_impacts(system, &passage, &met);
        let n = system.coordinates;
        self.v.iter_mut().enumerate().for_each(|(k, v)| {
            // Signals are functions of time and do not vary.
            *v = if k < 2 * n { jumped[k] - outgoing[k] * later } else { 0.0 };
        });
        self.keep(system, &passage.flows[1].mode.basis);
    }
}
