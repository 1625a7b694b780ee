//! Flights: derivatives of the state between two events (docs/assembly-law.md (A31)).

use super::columns::Columns;
use super::mode::VariedMode;
use super::series::{Rung, Sources, orders};
use crate::flow::{RADIUS, RUNGS};
use crate::kernel::Entries;
use pulp::{Arch, Simd, WithSimd};
use std::sync::atomic::Ordering;

/// Extra orders of the derivatives' series beyond the state's series: a term of a derivative is
/// the state's term times its order.
const MORE: usize = 2;
/// Shortest flight by a rung, as a fraction of the length of a series.
const PART: f64 = 0.125;
/// Work per coordinate for one order of a power series, for scaling and adding sums. The unit is
/// the work for one matrix entry.
const ORDER: usize = 3;

/// Buffers of a flight.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    term: Vec<f64>,
    next: Vec<f64>,
}

/// Computes `sums` += `factor` × `terms` by whole vectors.
#[inline(always)]
fn add_all<S: Simd>(simd: S, sums: &mut [f64], factor: f64, terms: &[f64]) {
    let (sums, terms, factor) =
        (S::as_mut_simd_f64s(sums).0, S::as_simd_f64s(terms).0, simd.splat_f64s(factor));
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum = simd.add_f64s(*sum, simd.mul_f64s(factor, *term));
    }
}

/// Multiplies a row of a matrix and of its variation. Computes `B` vectors, the first of index
/// `first`, of the `each` vectors of a coordinate.
#[inline(always)]
fn row_at<S: Simd, const B: usize>(
    simd: S,
    [entries, varied]: [Entries; 2],
    (by, from): (&[S::f64s], &[f64]),
    (each, first): (usize, usize),
) -> [S::f64s; B] {
    let mut sums = [simd.splat_f64s(0.0); B];
    let vectors = S::as_simd_f64s(from).0;
    for &(j, x) in entries {
        let (x, own) = (simd.splat_f64s(x), &vectors[j * each + first..][..B]);
        for (sum, own) in sums.iter_mut().zip(own) {
            *sum = simd.add_f64s(*sum, simd.mul_f64s(x, *own));
        }
    }
    for (&(j, _), by) in varied.iter().zip(by.chunks_exact(each)) {
        let state = simd.splat_f64s(from[j * each * S::F64_LANES]);
        for (sum, by) in sums.iter_mut().zip(&by[first..][..B]) {
            *sum = simd.add_f64s(*sum, simd.mul_f64s(state, *by));
        }
    }
    sums
}

/// Computes the flow over one part of the length of a series.
#[inline(always)]
fn first<S: Simd>(simd: S, mode: &VariedMode, width: usize) -> Rung {
    let size = mode.a.len();
    let (mut term, mut flow) = (vec![0.0; size * size], vec![0.0; size * size]);
    (0..size).for_each(|i| term[i * size + i] = 1.0);
    let (row, Sources(sources)) = (size * width, &mode.sources);
    let (mut own, mut by) = (vec![0.0; size * row], vec![0.0; size * row]);
    let (mut next, mut next_own) = (term.clone(), own.clone());
    for k in 1..=orders(PART * RADIUS) + MORE {
        let factor = PART * mode.length / k as f64;
        next.fill(0.0);
        next_own.fill(0.0);
        for i in 0..size {
            let (to, to_own) = (&mut next[i * size..][..size], &mut next_own[i * row..][..row]);
            for &(j, x) in mode.a.row(i) {
                add_all(simd, to_own, factor * x, &own[j * row..][..row]);
                to.iter_mut().zip(&term[j * size..]).for_each(|(to, t)| *to += factor * x * t);
            }
            for place in sources.row(i) {
                let (j, by) = (sources.entries[place].0, &sources.by[place * width..][..width]);
                let terms = &term[j * size..][..size];
                to_own
                    .chunks_exact_mut(width)
                    .zip(terms)
                    .for_each(|(to, t)| add_all(simd, to, factor * t, by));
            }
        }
        std::mem::swap(&mut term, &mut next);
        std::mem::swap(&mut own, &mut next_own);
        flow.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
        add_all(simd, &mut by, 1.0, &own);
    }
    let mut rung = Rung::default();
    flow.chunks_exact(size).zip(by.chunks_exact(row)).for_each(|(row, by)| rung.push(row, by));
    rung
}

/// Computes the flow over twice the length: D₂ = 2 D + D², E₂ = 2 E + D E + E D.
#[inline(always)]
fn doubled<S: Simd>(simd: S, rung: &Rung, width: usize) -> Rung {
    let size = rung.ends.len();
    let (mut twice, mut row, mut by) = (Rung::default(), vec![0.0; size], vec![0.0; size * width]);
    for i in 0..size {
        row.fill(0.0);
        by.fill(0.0);
        for place in rung.row(i) {
            let ((k, x), own) = (rung.entries[place], &rung.by[place * width..][..width]);
            row[k] += 2.0 * x;
            add_all(simd, &mut by[k * width..][..width], 2.0, own);
            for place in rung.row(k) {
                let ((j, y), other) = (rung.entries[place], &rung.by[place * width..][..width]);
                row[j] += x * y;
                let to = &mut by[j * width..][..width];
                add_all(simd, to, x, other);
                add_all(simd, to, y, own);
            }
        }
        twice.push(&row, &by);
    }
    twice
}

/// A flight over a time, by a rung or a power series; compiled for each vector instruction set.
struct Flight<'a> {
    mode: &'a VariedMode,
    z: &'a mut Columns,
    memory: &'a mut Memory,
    rung: Option<&'a Rung>,
    time: f64,
}

impl WithSimd for Flight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Each entry is read once for all vectors that are computed side by side.
        match self.z.width / S::F64_LANES {
            1 => self.in_blocks::<S, 1>(simd),
            each if each % 4 == 0 => self.in_blocks::<S, 4>(simd),
            each if each % 3 == 0 => self.in_blocks::<S, 3>(simd),
            each if each % 2 == 0 => self.in_blocks::<S, 2>(simd),
            _ => self.in_blocks::<S, 1>(simd),
        }
    }
}

impl Flight<'_> {
    /// Computes the flight with `B` vectors of each coordinate side by side. Their number is a
    /// multiple of `B`.
    #[inline(always)]
    fn in_blocks<S: Simd, const B: usize>(self, simd: S) {
        let Self { mode, z, memory: Memory { term, next }, rung, time } = self;
        let each = z.width / S::F64_LANES;
        term.clone_from(&z.numbers);
        if let Some(rung) = rung {
            let all = S::as_simd_f64s(&rung.by).0;
            for (i, to) in S::as_mut_simd_f64s(&mut z.numbers).0.chunks_exact_mut(each).enumerate() {
                let own = rung.row(i);
                let (entries, by) = (&rung.entries[own.clone()], &all[own.start * each..own.end * each]);
                for (block, to) in to.chunks_exact_mut(B).enumerate() {
                    let sums = row_at::<S, B>(simd, [entries, entries], (by, term), (each, block * B));
                    to.iter_mut().zip(sums).for_each(|(to, sum)| *to = simd.add_f64s(*to, sum));
                }
            }
            return;
        }
        next.resize(term.len(), 0.0);
        let Sources(sources) = &mode.sources;
        let all = S::as_simd_f64s(&sources.by).0;
        for k in 1..=orders(RADIUS * time / mode.length) + MORE {
            let factor = simd.splat_f64s(time / k as f64);
            let sums = S::as_mut_simd_f64s(&mut z.numbers).0.chunks_exact_mut(each);
            let nexts = S::as_mut_simd_f64s(next).0.chunks_exact_mut(each);
            for (i, (to, sums)) in nexts.zip(sums).enumerate() {
                let own = sources.row(i);
                let by = &all[own.start * each..own.end * each];
                let entries = [mode.a.row(i), &sources.entries[own]];
                let blocks = to.chunks_exact_mut(B).zip(sums.chunks_exact_mut(B));
                for (block, (to, sums)) in blocks.enumerate() {
                    let found = row_at::<S, B>(simd, entries, (by, term), (each, block * B));
                    for ((to, sum), found) in to.iter_mut().zip(sums).zip(found) {
                        *to = simd.mul_f64s(factor, found);
                        *sum = simd.add_f64s(*sum, *to);
                    }
                }
            }
            std::mem::swap(term, next);
        }
    }
}

/// Makes a rung, from the rung below it if there is one; compiled for each vector instruction set.
struct Make<'a> {
    mode: &'a VariedMode,
    below: Option<&'a Rung>,
    width: usize,
}

impl WithSimd for Make<'_> {
    type Output = Rung;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Rung {
        match self.below {
            Some(below) => doubled(simd, below, self.width),
            None => first(simd, self.mode, self.width),
        }
    }
}

impl VariedMode {
    /// Carries a state and its derivatives over a time without events.
    pub fn carry(&self, arch: Arch, z: &mut Columns, memory: &mut Memory, mut time: f64) {
        if !self.curves.is_empty() {
            return self.carry_curved(z, time);
        }
        if self.is_by_rungs(time) {
            let parts = time / (PART * self.length);
            let longest = (parts.log2() as usize).min(RUNGS - 1);
            for k in (0..=longest).rev() {
                let length = PART * self.length * 2f64.powi(k as i32);
                while time >= length {
                    let rung = Some(self.rung(arch, k, z.width));
                    arch.dispatch(Flight { mode: self, z, memory, rung, time });
                    time -= length;
                }
            }
        }
        let parts = (time / self.length).ceil();
        for _ in 0..parts as u64 {
            arch.dispatch(Flight { mode: self, z, memory, rung: None, time: time / parts });
        }
    }

    /// Whether flights use rungs. Rungs must take less work than series, and the total work that
    /// rungs would have saved must exceed the work of making them.
    fn is_by_rungs(&self, time: f64) -> bool {
        let (size, parts) = (self.a.len(), time / (PART * self.length));
        if parts < 1.0 {
            return false;
        }
        let series = |time: f64| {
            let parts = (time / self.length).ceil().max(1.0);
            let entries = self.a.entries() + self.sources.0.entries.len() + ORDER * size;
            let each = (orders(RADIUS * time / (parts * self.length)) + MORE) * entries;
            parts * each as f64
        };
        let longest = (parts.log2() as usize).min(RUNGS - 1);
        let count = (parts as u64).count_ones() as f64 + (parts / 2f64.powi(longest as i32) - 1.0).max(0.0);
        let work = count * (2 * size * size) as f64 + series(PART * self.length * parts.fract());
        let saved = series(time) - work;
        if saved <= 0.0 {
            return false;
        }
        let missing = (0..=longest).filter(|&k| self.flights.at(k).get().is_none()).count();
        let saved = self.saved.fetch_add(saved as u64, Ordering::Relaxed) as f64;
        saved >= (missing * size.pow(3)) as f64
    }

    /// Returns the flow over 2^`k` parts of the length of a series.
    fn rung(&self, arch: Arch, k: usize, width: usize) -> &Rung {
        self.flights.at(k).get_or_init(|| {
            let below = k.checked_sub(1).map(|below| self.rung(arch, below, width));
            arch.dispatch(Make { mode: self, below, width })
        })
    }
}
