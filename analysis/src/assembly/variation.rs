//! The largest Lyapunov exponent of a described machine's motion: one variation, carried exactly through flights and events.
//! How a variation passes flights and events is docs/assembly-law.md (A21).

use super::flight::{Flight, Observer, Passage, dot};
use crate::largest_exponent::{Growth, LargestExponent};
use vibro_assembly::mode::Mode;
use vibro_assembly::motion::{Crossing, keep};
use vibro_assembly::system::System;

/// Stretches after which a variation's length is looked at: it changes by e¹⁰⁰ in them at most.
const STRETCHES: f64 = 50.0;
/// Lengths between which a variation is not scaled on the way: its squares stay numbers for as many stretches more.
const SCALED: std::ops::Range<f64> = 1e-100..1e100;

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
        keep(system, &mode.basis, &mut variation.v);
        variation.scale();
        variation.growth = Growth::default();
        variation
    }

    /// Its length, in which coordinates count by ω.
    fn length(&self) -> f64 {
        let weight = |k: usize| if k < self.coordinates { self.omega } else { 1.0 };
        (0..self.v.len()).map(|k| (weight(k) * self.v[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// Makes its length one, and notes by how much it has grown.
    pub fn scale(&mut self) {
        let length = self.length();
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

impl Observer for Variation {
    fn flight(&mut self, _: &System, flight: Flight<'_>) {
        let parts = (flight.flow.stretches_of(flight.span) / STRETCHES).ceil();
        for _ in 0..parts as u64 {
            self.v = flight.flow.stretches(&self.v, flight.span / parts, &mut |_, _| ());
            // Beside a slow drive dampers may take all of it within one return.
            if !SCALED.contains(&self.length()) {
                self.scale();
            }
        }
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        let Passage { watch, flows, states, events, .. } = passage;
        let rates = [0, 1].map(|k| flows[k].derivative(states[k]));
        // Of two functionals with one name the one that is zero here.
        let ended = flows[0].watched.iter().filter(|ended| Some(ended.0) == watch);
        let off = |row: &[f64]| dot(row, states[0]).abs();
        let row = ended.map(|(_, row)| row.as_slice()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let (modes, rates) = (flows.map(|flow| &flow.mode), [&rates[0][..], &rates[1][..]]);
        Crossing { modes, states, rates, row, events }.carry(system, [&mut self.v[..]]);
    }
}
