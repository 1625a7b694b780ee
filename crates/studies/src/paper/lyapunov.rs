//! Spectrum of seven Lyapunov exponents: six for the coordinates, and the exactly zero exponent of
//! the drive's phase.
//!
//! Between events the variations are propagated by exact transition matrices, and at impacts they
//! jump (docs/theory.md (84)). The variations are orthonormalized once per drive period, and
//! before dampers and impacts make some of them too small relative to others (docs/theory.md (85);
//! paper, section 4). When the block comes to rest, its relative motion is lost: two directions
//! become zero, and their exponents stay at -∞. An impact with κ = 0 makes one direction zero.
//!
//! ```
//! use vibro_studies::paper::lyapunov::{SpectrumOptions, spectrum};
//! use vibro_impact::{Parameters, Simulator, State};
//!
//! let start = State { x: [0.0; 3], v: [0.0, 1.0, 0.0] };
//! let p = Parameters::default();
//! let mut simulator = Simulator::new(&p, &start, 0.0)?.without_energy_accounts();
//! simulator.advance_to(400.0 * p.period())?; // onto the stable two-impact motion
//! let found = spectrum(&mut simulator, &SpectrumOptions::default())?;
//! assert!(found.exponents[0].abs() < 1e-9 && found.exponents[1] < 0.0);
//! # Ok::<(), vibro_studies::Error>(())
//! ```

use super::smooth_pieces::{PieceEnd, SmoothPiece, smooth_pieces};
use super::variation::{DIMENSION, Frame, Rank, Variation, generic_frame, on_circle, orthonormalize};
use crate::error::Result;
use serde::{Deserialize, Serialize};
use vibro_impact::error::Error;
use vibro_impact::model::{DRIVE_COS, DRIVE_SIN, Model};
use vibro_impact::simulator::Simulator;

/// Drive periods between two checks of the running deviation.
const CHECK: u32 = 10;

/// Options of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectrumOptions {
    /// Periods for the alignment of the variations with their directions, before growth counts.
    pub align: u32,
    /// Largest number of counted periods (1500 in the paper).
    pub periods: u32,
    /// Number of periods, the last ones, for the deviation of the running exponents. The
    /// computation ends when the deviation is below `threshold` for every exponent.
    pub window: u32,
    /// Standard deviation of running exponents at which the computation ends, 1/s. If it is 0, all
    /// periods are counted.
    pub threshold: f64,
}

impl Default for SpectrumOptions {
    /// Counts all 1500 periods after an alignment of 50.
    fn default() -> Self {
        Self { align: 50, periods: 1500, window: 200, threshold: 0.0 }
    }
}

/// A Lyapunov spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// The exponents, largest first, 1/s; -∞ for directions lost in rest.
    pub exponents: [f64; DIMENSION],
    /// Largest standard deviation of the running exponents over the last window, 1/s; exponents of
    /// -∞ are left out.
    pub deviation: f64,
    /// Counted periods.
    pub periods: u32,
    /// Whether the threshold ended the computation.
    pub settled: bool,
    /// Impacts in the counted periods.
    pub impacts: u64,
    /// Whether the block rested.
    pub rests: bool,
}

impl Spectrum {
    /// Largest exponent besides the zero of the drive's phase, 1/s: the exponent closest to zero
    /// is left out. On a torus, where two exponents are zero, it may be either of them.
    pub fn largest_beside_phase(&self) -> f64 {
        let phase =
            (0..DIMENSION).min_by(|&i, &j| self.exponents[i].abs().total_cmp(&self.exponents[j].abs()));
        let others = (0..DIMENSION).filter(|i| Some(*i) != phase).map(|i| self.exponents[i]);
        others.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Logarithm of the length ratio of variations at which they are orthonormalized. Rounding then
/// costs at most ten digits of the smaller one.
const SMALLER: f64 = 12.0;

/// A spectrum with its convergence.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The final spectrum.
    pub spectrum: Spectrum,
    /// Running exponents after each counted period, in the order of the directions, 1/s.
    pub running: Vec<[f64; DIMENSION]>,
}

/// The spectrum of a motion after the transient, which the caller has discarded.
///
/// # Errors
/// As [`Simulator::advance_until`]; [`Error::Undefined`] without a drive, which sets the period.
pub fn spectrum(simulator: &mut Simulator, options: &SpectrumOptions) -> Result<Spectrum> {
    Ok(convergence(simulator, options)?.spectrum)
}

/// The spectrum with its running values.
///
/// # Errors
/// As [`spectrum`].
pub fn convergence(simulator: &mut Simulator, options: &SpectrumOptions) -> Result<Convergence> {
    convergence_while(simulator, options, &mut || true)
}

/// [`convergence`] that counts while `go_on` returns true. `go_on` is called before each drive
/// period, for a progress display or an interruption by the user. Returns the counts up to then.
///
/// # Errors
/// As [`spectrum`].
pub fn convergence_while(
    simulator: &mut Simulator,
    options: &SpectrumOptions,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Convergence> {
    let p = *simulator.parameters();
    if p.drive_frequency == 0.0 {
        return Err(Error::Undefined {
            name: "drive.frequency",
            value: 0.0,
            needed_by: "Lyapunov spectrum, which is computed period by period,",
            allowed: "drive.frequency > 0",
        }
        .into());
    }
    let model = Model::new(&p)?;
    let mut tangent = Tangent {
        variation: Variation::new(&model),
        frame: generic_frame(&simulator.augmented()),
        rank: DIMENSION,
        logs: [0.0; DIMENSION],
        // Energy decreases at most as fast as if all of it were kinetic energy of the body with
        // the strongest damper. An impact multiplies w' by -κ.
        decay: (p.box_damping / p.box_mass).max(p.secondary_damping / p.secondary_mass),
        impact: if p.stop_restitution > 0.0 { -2.0 * p.stop_restitution.ln() } else { 0.0 },
        taken: 0.0,
        frequency: p.drive_frequency,
    };
    let (begin, length) = (simulator.time(), p.period());
    let (mut impacts, mut rests) = (0, false);
    let mut running = Vec::new();
    let mut settled = false;
    for i in 1..=options.align + options.periods {
        if !go_on() {
            break;
        }
        smooth_pieces(simulator, &model, begin + f64::from(i) * length, &mut |piece| {
            impacts += u64::from(matches!(piece.end, PieceEnd::Impact { .. }));
            rests |= piece.mode == vibro_impact::model::SmoothMode::Rest;
            tangent.carry(piece);
        })?;
        tangent.renormalize_at(simulator.drive_phase());
        if i <= options.align {
            // A direction that has become zero stays zero; all other directions start again.
            tangent.logs = tangent.logs.map(|l| if l == f64::NEG_INFINITY { l } else { 0.0 });
            (impacts, rests) = (0, false);
            continue;
        }
        let counted = i - options.align;
        running.push(tangent.logs.map(|l| l / (f64::from(counted) * length)));
        let check = options.threshold > 0.0 && counted >= options.window && counted.is_multiple_of(CHECK);
        if check && deviation(&running, options.window) < options.threshold {
            settled = true;
            break;
        }
    }
    let mut exponents = running.last().copied().unwrap_or([0.0; DIMENSION]);
    exponents.sort_by(|a, b| b.total_cmp(a));
    let deviation = deviation(&running, options.window);
    let periods = running.len() as u32;
    Ok(Convergence { spectrum: Spectrum { exponents, deviation, periods, settled, impacts, rests }, running })
}

/// The spectrum with its running values in units of ω10, per unit of the dimensionless time τ. The
/// threshold has the same unit.
///
/// # Errors
/// As [`spectrum`]; [`Error::Undefined`] without a spring between box and ground, since ω10 is
/// zero.
pub fn dimensionless(simulator: &mut Simulator, options: &SpectrumOptions) -> Result<Convergence> {
    let rate = simulator.parameters().box_frequency();
    if rate == 0.0 {
        let needed_by = "exponents in units of omega10";
        return Err(Error::Undefined { name: "box.k", value: 0.0, needed_by, allowed: "box.k > 0" }.into());
    }
    let options = SpectrumOptions { threshold: options.threshold * rate, ..*options };
    let mut found = convergence(simulator, &options)?;
    for exponents in found.running.iter_mut().chain([&mut found.spectrum.exponents]) {
        *exponents = exponents.map(|e| e / rate);
    }
    found.spectrum.deviation /= rate;
    Ok(found)
}

/// Variations of a motion, with the logarithms of their growth.
struct Tangent {
    variation: Variation,
    frame: Frame,
    /// Number of nonzero directions.
    rank: usize,
    /// Logarithms of the growth so far.
    logs: [f64; DIMENSION],
    /// Logarithm of the largest reduction of a variation relative to others: by dampers per
    /// second, and by an impact.
    decay: f64,
    impact: f64,
    /// Sum of these reductions since the last orthonormalization.
    taken: f64,
    /// Frequency of the drive, rad/s.
    frequency: f64,
}

impl Tangent {
    /// Carries the variations along a piece and through the event at its end.
    fn carry(&mut self, piece: &SmoothPiece) {
        let loss = self.decay * piece.span;
        let phase = piece.start[DRIVE_SIN].atan2(piece.start[DRIVE_COS]);
        if self.taken > 0.0 && self.taken + loss > SMALLER {
            self.renormalize_at(phase);
        }
        let parts = (loss / SMALLER).ceil().max(1.0);
        let span = piece.span / parts;
        for part in 1..parts as u64 {
            self.variation.propagate(&mut self.frame, &SmoothPiece { span, end: PieceEnd::End, ..*piece });
            self.renormalize_at(phase + self.frequency * span * part as f64);
        }
        let rank = self.variation.propagate(&mut self.frame, &SmoothPiece { span, ..*piece });
        self.taken += self.decay * span;
        if matches!(piece.end, PieceEnd::Impact { .. }) {
            self.taken += self.impact;
        }
        if let Rank::Limited(most) = rank {
            self.rank = self.rank.min(most);
            self.renormalize();
        } else if let PieceEnd::Impact { after, .. } = &piece.end
            && self.taken + 2.0 * self.growth() > SMALLER
        {
            // A slow impact makes one variation long, and another one shorter by the same factor.
            self.renormalize_at(after[DRIVE_SIN].atan2(after[DRIVE_COS]));
        }
    }

    /// Logarithm of the longest variation since the last orthonormalization.
    fn growth(&self) -> f64 {
        let squares = self.frame.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>());
        0.5 * squares.fold(1.0, f64::max).ln()
    }

    /// Orthonormalizes the variations at a phase of the drive. First it removes the rounding
    /// errors normal to the unit circle of the phase.
    fn renormalize_at(&mut self, phase: f64) {
        let (sine, cosine) = phase.sin_cos();
        on_circle(&mut self.frame, (cosine, sine));
        self.renormalize();
    }

    /// Orthonormalizes the variations and adds the logarithms of their lengths.
    fn renormalize(&mut self) {
        self.taken = 0.0;
        let (frame, rank) = (&mut self.frame, self.rank);
        let lengths = pulp::Arch::new().dispatch(
            #[inline(always)]
            || orthonormalize(frame, rank),
        );
        for (sum, length) in self.logs.iter_mut().zip(lengths) {
            *sum += length.ln(); // -∞ for a direction that has become zero
        }
    }
}

/// Largest standard deviation of a running exponent over the last `window` periods; exponents of
/// -∞ are left out.
fn deviation(running: &[[f64; DIMENSION]], window: u32) -> f64 {
    let last = &running[running.len().saturating_sub(window as usize)..];
    let count = last.len().max(1) as f64;
    (0..DIMENSION)
        .filter(|&j| last.iter().all(|r| r[j].is_finite()))
        .map(|j| {
            let mean = last.iter().map(|r| r[j]).sum::<f64>() / count;
            (last.iter().map(|r| (r[j] - mean) * (r[j] - mean)).sum::<f64>() / count).sqrt()
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
