//! Derivative of the return map over a period. It gives the distance of a motion from the orbit
//! that it approaches, and the growth of variations over a period.
//!
//! If the return map moves a state by r and has the derivative M, the state's distance from the
//! fixed point is (1 - M)⁻¹ r. The distance reveals a slow approach: successive returns may be
//! arbitrarily close to each other while the orbit is far away. Neutral directions are left out.
//! For an autonomous machine the shift in time is left out, too.

use super::flight::Flows;
use super::returns::ReturnRecord;
use super::section::{Section, is_steady};
use super::variation::{Frame, Metric};
use crate::error::Result;
use nalgebra::{DMatrix, DVector, Schur};
use vibro_machine::Motion;
use vibro_machine::description::Dimension;
use vibro_machine::functional::StateRow;
use vibro_machine::neutral::Neutral;
use vibro_machine::system::{Elongation, System};
use vibro_numerics::sorting::sort_by;

/// Tolerance for the rounding of a state, in units of `f64::EPSILON`.
const ROUNDINGS: f64 = 64.0;
/// Cap on the rounding of a state, as a fraction of its size.
const MOST_ROUNDING: f64 = 1e-7;
/// Singular value below which there is a family of orbits.
const SINGULAR: f64 = 1e-12;
/// Tolerance for a zero exponent: the size of the multiplier's logarithm. It exceeds the rounding
/// errors of a defective multiplier 1.
pub const MARGINAL: f64 = 1e-6;
/// A multiplier below this fraction of the derivative's largest entry is rounding.
const LEAST_MULTIPLIER: f64 = 1e-10;
/// Largest number of sweeps of the Schur decomposition per multiplier.
const SWEEPS: usize = 200;
/// Relative tolerance for a zero rate and for a zero change of a signal.
const EXACT: f64 = 1e-9;

/// Metric of changes of a motion's state. Its units are the sizes of the recorded elongations and
/// rates of each dimension, and the sizes of the states of blocks.
pub fn metric(motion: &Motion, record: &ReturnRecord) -> Metric {
    let assembly = motion.assembly();
    let (d, system) = (&assembly.description, assembly.system());
    let sizes = record.sizes();
    let unit = |body: usize, first: usize| {
        let rotates = usize::from(d.bodies[body].dimension == Dimension::Rotation);
        Some(sizes[first + rotates]).filter(|size| *size > 0.0).unwrap_or(1.0)
    };
    let of = |first: usize| system.bodies_of.iter().map(move |body| unit(*body, first));
    let inner = d.elements().flat_map(|element| {
        let rotates = usize::from(element.dimension(d) == Dimension::Rotation);
        let size = Some(sizes[rotates]).filter(|size| *size > 0.0).unwrap_or(1.0);
        element.branches().map(move |_| size)
    });
    let kept = record.sizes_of_blocks().map(|size| if size > 0.0 { size } else { 1.0 });
    Metric(of(0).chain(of(2)).chain(inner).chain(kept).collect())
}

/// Change of the state (q, q') by a shift in time: z' minus the uniform motion with which
/// prescribed bodies carry other bodies along. `None` if the machine is not autonomous.
pub fn shift(motion: &Motion) -> Option<Vec<f64>> {
    let assembly = motion.assembly();
    let (d, system, z) = (&assembly.description, assembly.system(), motion.state());
    if !is_steady(d) {
        return None;
    }
    let along = carried(system, z.as_slice(), true)?;
    let later = motion.time_derivative(1);
    let mut shift: Vec<f64> = later.state().iter().take(system.states()).copied().collect();
    shift.iter_mut().zip(along.iter()).for_each(|(x, u)| *x -= u);
    Some(shift)
}

/// Change of the coordinates, and of the states of first order, that keeps the elongations of
/// springs and stops constant while the signals change as in `change`, a change of the augmented
/// state. If `rates` is true, `change` is the state itself, and the result is the velocities at
/// which the elongations' rates are zero. A uniformly moving prescribed body carries other bodies
/// along in this way. `None` if no such change exists.
pub fn carried(system: &System, change: &[f64], rates: bool) -> Option<DVector<f64>> {
    let n = system.coordinates;
    let springs = system.springs.iter().filter(|s| s.stiffness != 0.0).map(|s| &s.elongation);
    let held: Vec<_> =
        springs.chain(system.stops.iter().filter(|s| !s.is_freewheel).map(|s| &s.elongation)).collect();
    let own = system.states();
    let by_time = |row: &StateRow| row.iter().zip(change).skip(own).map(|(r, x)| r * x).sum::<f64>();
    let row = |e: &Elongation| if rates { -by_time(&e.rate) } else { -by_time(&e.e) };
    // Springs in series keep their stretches, and so their forces. Blocks keep their states.
    let with_inner = |along: DVector<f64>| match system.branches.is_empty() {
        true => along,
        false => along.resize_vertically(own, 0.0),
    };
    let changes = DVector::from_iterator(held.len(), held.iter().map(|e| row(e)));
    if changes.iter().all(|change| *change == 0.0) {
        return Some(with_inner(DVector::zeros(n)));
    }
    let rows = DMatrix::from_fn(held.len(), n, |i, j| held[i].w[j]);
    let along = rows.clone().svd(true, true).solve(&changes, EXACT).ok()?;
    ((rows * &along - &changes).amax() <= EXACT * changes.amax()).then(|| with_inner(along))
}

/// Distance from the orbit and growth, from the derivative over a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// Distance of the state from the orbit, relative to the motion's sizes.
    pub distance: f64,
    /// Modulus of the largest multiplier. `None` if it is hidden by rounding or all directions are
    /// lost.
    pub multiplier: Option<f64>,
    /// Duration, s.
    pub time: f64,
}

impl Period {
    /// Follows the motion over a period of `returns` returns.
    ///
    /// # Errors
    /// As [`Section::advance`].
    pub fn follow(
        motion: &mut Motion,
        section: &Section,
        record: &ReturnRecord,
        returns: u32,
    ) -> Result<Self> {
        let assembly = motion.assembly().clone();
        let system = assembly.system();
        let metric = metric(motion, record);
        let neutral = Neutral::of(system);
        let given = |mut state: Vec<f64>| {
            state.resize(system.signals.size, 0.0);
            system.given(&state)
        };
        let basis = metric.basis(neutral.states().into_iter().chain(shift(motion)).map(given));
        let mut frame = Frame::new(system, motion.mode(), &metric);
        let (from, start) = (motion.time(), motion.state().clone());
        let mut flows = Flows::default();
        for _ in 0..returns {
            section.follow(motion, &mut flows, &mut [&mut frame])?;
        }
        let size = system.states();
        if size == 0 {
            // All bodies move as prescribed, and the signals repeat.
            return Ok(Self { distance: 0.0, multiplier: None, time: motion.time() - from });
        }
        let mut change = motion.state() - &start;
        // Periodic signals return to their values up to rounding. This rounding is not a uniform
        // motion.
        let terms = motion.state().abs() + start.abs();
        // Inner states of held sliders do not change, whatever the rounding of signals.
        let given = system.given(change.as_slice());
        change.as_mut_slice()[..size].copy_from_slice(&given);
        let signals = change.iter_mut().zip(terms.iter()).skip(size);
        signals.for_each(|(x, terms)| {
            if x.abs() <= EXACT * terms.max(1.0) {
                *x = 0.0;
            }
        });
        let Some(along) = carried(system, change.as_slice(), false) else {
            return Ok(Self { distance: f64::INFINITY, multiplier: None, time: motion.time() - from });
        };
        let mut moved = change.clone();
        moved.rows_mut(0, size).fill(0.0);
        moved.iter_mut().zip(along.iter()).for_each(|(x, u)| *x = *u);
        let along = system.given(moved.as_slice());
        change.iter_mut().zip(&along).for_each(|(x, u)| *x -= u);
        let scale = |i: usize| start[i].abs().max(motion.state()[i].abs()) / metric.0[i];
        let rounding = (0..size).map(scale).fold(1.0, f64::max) * ROUNDINGS * f64::EPSILON;
        let without = |v: DVector<f64>| basis.iter().fold(v, |v, b| &v - b * b.dot(&v));
        let mut m = DMatrix::zeros(size, size);
        for (j, column) in frame.columns.iter().enumerate() {
            m.set_column(j, &(without(metric.scaled(&system.given(column))) * metric.0[j]));
        }
        // The basis is removed from the right side of M, too.
        let mut m = m.transpose();
        for mut column in m.column_iter_mut() {
            let own = without(column.clone_owned());
            column.copy_from(&own);
        }
        let m = m.transpose();
        let residual = without(metric.scaled(&change.as_slice()[..size]));
        let off = offset(&m, &basis, &residual, rounding.min(MOST_ROUNDING));
        let off: Option<Vec<f64>> =
            off.map(|off| off.iter().zip(&metric.0).map(|(x, unit)| x * unit).collect());
        let distance = off.map_or(f64::INFINITY, |mut off| {
            off.resize(system.signals.size, 0.0);
            system.take_given(&mut off);
            record.size_of_change(&off)
        });
        Ok(Self { distance, multiplier: largest_multiplier(m), time: motion.time() - from })
    }

    /// Largest exponent, 1/s, if the multiplier is known.
    pub fn exponent(&self) -> Option<f64> {
        self.multiplier.map(|multiplier| exponent(multiplier, self.time))
    }
}

/// Exponent, 1/s, of a multiplier's modulus over a time, s.
fn exponent(modulus: f64, time: f64) -> f64 {
    let logarithm = modulus.ln();
    if logarithm.abs() < MARGINAL { 0.0 } else { logarithm / time }
}

/// All multipliers of a period, including the multipliers of neutral directions.
#[derive(Clone, Debug)]
pub struct Multipliers {
    /// Number of returns in the period.
    pub returns: u32,
    /// Duration of the period, s.
    time: f64,
    /// Moduli, largest first.
    moduli: Vec<f64>,
    /// Modulus below which a multiplier is rounding.
    least: f64,
}

impl Multipliers {
    /// Follows the motion over a period of `returns` returns. `None` if the decomposition does not
    /// converge.
    ///
    /// # Errors
    /// As [`Section::advance`].
    pub fn follow(
        motion: &mut Motion,
        section: &Section,
        record: &ReturnRecord,
        returns: u32,
    ) -> Result<Option<Self>> {
        let assembly = motion.assembly().clone();
        let system = assembly.system();
        let metric = metric(motion, record);
        let mut frame = Frame::new(system, motion.mode(), &metric);
        let (from, mut flows) = (motion.time(), Flows::default());
        for _ in 0..returns {
            section.follow(motion, &mut flows, &mut [&mut frame])?;
        }
        let mut m = DMatrix::zeros(system.states(), system.states());
        for (j, column) in frame.columns.iter().enumerate() {
            m.set_column(j, &(metric.scaled(&system.given(column)) * metric.0[j]));
        }
        let (time, least) = (motion.time() - from, least_multiplier(&m));
        let Some(mut moduli) = moduli(m) else { return Ok(None) };
        sort_by(&mut moduli, |a, b| b.total_cmp(a));
        Ok(Some(Self { returns, time, moduli, least }))
    }

    /// Exponents, 1/s, largest first, except where the multipliers are rounding. `lost` is the
    /// number of directions that contacts remove; their multipliers are zero.
    pub fn exponents(&self, lost: usize) -> Vec<f64> {
        let kept = self.moduli.len().saturating_sub(lost);
        let found = self.moduli.iter().take(kept).take_while(|modulus| **modulus > self.least);
        found.map(|modulus| exponent(*modulus, self.time)).collect()
    }
}

/// (1 - M)⁻¹ r outside the neutral directions. `None` if r has a part beyond rounding along a
/// direction that M does not change.
fn offset(m: &DMatrix<f64>, basis: &[DVector<f64>], r: &DVector<f64>, rounding: f64) -> Option<DVector<f64>> {
    let mut a = DMatrix::identity(m.nrows(), m.ncols()) - m;
    basis.iter().for_each(|b| a += b * b.transpose());
    let svd = a.try_svd(true, true, f64::EPSILON, 0)?;
    let (u, v) = (svd.u?, svd.v_t?);
    let mut off = DVector::zeros(r.len());
    for (k, sigma) in svd.singular_values.iter().enumerate() {
        let share = u.column(k).dot(r);
        if share.abs() <= rounding {
            continue;
        }
        if *sigma <= SINGULAR {
            return None;
        }
        off += v.row(k).transpose() * (share / sigma);
    }
    Some(off)
}

/// Largest modulus of the eigenvalues; `None` if it is rounding or unknown.
fn largest_multiplier(m: DMatrix<f64>) -> Option<f64> {
    let least = least_multiplier(&m);
    let largest = moduli(m)?.into_iter().fold(0.0, f64::max);
    (largest > least).then_some(largest)
}

/// Modulus below which an eigenvalue is rounding.
fn least_multiplier(m: &DMatrix<f64>) -> f64 {
    LEAST_MULTIPLIER * m.amax().max(1.0)
}

/// Moduli of the eigenvalues of a finite matrix.
fn moduli(m: DMatrix<f64>) -> Option<Vec<f64>> {
    if !m.amax().is_finite() {
        return None;
    }
    let sweeps = SWEEPS * m.nrows().max(1);
    let values = Schur::try_new(m, f64::EPSILON, sweeps)?.complex_eigenvalues();
    Some(values.iter().map(|value| value.re.hypot(value.im)).collect())
}

#[cfg(test)]
mod tests;
