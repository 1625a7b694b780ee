//! What is read off a settled motion: amplitudes, root mean squares, impacts, powers, class, exponent.
//!
//! All of it comes from one pass over the smooth pieces of the motion, along which the flow's series are known: extrema lie at
//! the ends of a piece or where a rate passes zero, which [`first_crossing`](vibro_impact::events::first_crossing) proves; squares are integrated by a Gauss rule
//! whose error is under round-off. Losses at impacts and the work of the drive are the simulator's accounts, the losses in a
//! damper its coefficient times the mean square of its rate.
//!
//! ```
//! use vibro_analysis::measures::{Measure, measure};
//! use vibro_analysis::motion::settled_simulator;
//! use vibro_analysis::stroboscopic::moving_block;
//! use vibro_impact::Parameters;
//!
//! let p = Parameters::default();
//! let measures = ["amplitude.x1".parse::<Measure>()?, "impacts".parse()?];
//! let found = measure(&mut settled_simulator(&p, &moving_block(&p), 400.0)?, &measures, 60)?;
//! assert!((found.numbers[0].unwrap() - 0.3574).abs() < 1e-4 && found.numbers[1] == Some(2.0));
//! # Ok::<(), vibro_analysis::Error>(())
//! ```

mod extent;
mod name;

pub use name::{Coordinate, Measure};

use crate::attractor::{MotionClass, observe};
use crate::error::Result;
use crate::lyapunov::{self, SpectrumOptions};
use crate::smooth_pieces::{PieceEnd, expand_along, smooth_pieces};
use extent::Extent;
use serde::{Deserialize, Serialize};
use vibro_impact::error::Error;
use vibro_impact::model::Model;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Simulator;

/// What was read off one motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// A number for each measure, in their order and units; `None` for the class, and for a closed form that has no value.
    pub numbers: Vec<Option<f64>>,
    /// The class, where it was asked for.
    pub class: Option<MotionClass>,
}

/// Impacts of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Impacts {
    /// At the upper and at the lower stop.
    counts: [u32; 2],
    /// Largest |w'| before one, m/s.
    speed: f64,
    /// Largest impulse, N·s.
    impulse: f64,
}

/// A window of whole drive periods.
struct Window {
    /// Of the coordinates that the measures need.
    extents: Vec<Extent>,
    impacts: Impacts,
    /// Its length, s.
    duration: f64,
    /// Work of the drive and energy lost at impacts, J.
    energy: [f64; 2],
    periods: f64,
}

/// Measures a motion without loads, other than the constant ones of its parameters, over the next `periods` drive periods; class and exponent over those that follow. The
/// transient is the caller's to discard. [`Measure::PowerInput`] needs a simulator with energy accounts.
///
/// # Errors
/// As [`Simulator::advance_until`]; [`Error::Undefined`] without a drive, which sets the period.
pub fn measure(simulator: &mut Simulator, measures: &[Measure], periods: u32) -> Result<Measured> {
    let p = *simulator.parameters();
    if p.drive_frequency == 0.0 {
        return Err(
            undefined("drive.frequency", "measure of a motion, which is one over drive periods,").into()
        );
    }
    let window = window(simulator, measures, periods.max(1))?;
    let wants = |sought: Measure| measures.contains(&sought);
    let (mut class, mut exponent) = (None, None);
    if wants(Measure::Class) || wants(Measure::Exponent) {
        let attractor = observe(simulator)?;
        let has_no_period = attractor.period.is_none() && !attractor.is_free();
        let needs = wants(Measure::Exponent) || has_no_period;
        let dimensionless = |s: &mut Simulator| lyapunov::dimensionless(s, &SpectrumOptions::default());
        let spectrum = needs.then(|| dimensionless(simulator)).transpose()?.map(|found| found.spectrum);
        exponent = spectrum.as_ref().map(|s| s.exponents[0] * p.box_frequency());
        class = Some(match MotionClass::of(&attractor, spectrum.as_ref()) {
            // Without impacts the flow is linear and has one limit, of the drive's period.
            MotionClass::Aperiodic if attractor.is_free() => MotionClass::Settling,
            other => other,
        });
    }
    let number = |measure: &Measure| match measure {
        Measure::Class => None,
        Measure::Exponent => exponent,
        Measure::AmplitudeWithoutBlock => amplitude_without_block(&p).ok(),
        other => Some(window.number(*other, &p)),
    };
    let numbers = measures.iter().map(number).collect();
    Ok(Measured { numbers, class: class.filter(|_| wants(Measure::Class)) })
}

fn undefined(name: &'static str, needed_by: &'static str) -> Error {
    let allowed = if name == "box.c" { "box.c > 0 there" } else { "drive.frequency > 0" };
    Error::Undefined { name, value: 0.0, needed_by, allowed }
}

/// The amplitude of the box alone on its spring and damper under the drive, m: F10/|k1 - m1 ω1² + i c1 ω1|, the
/// periodic solution of docs/theory.md (3) without block and coupling; under a constant load on the box, which shifts its middle,
/// the largest |x1|.
///
/// # Errors
/// [`Error::Undefined`] at the resonance of a box without damping.
pub fn amplitude_without_block(p: &Parameters) -> std::result::Result<f64, Error> {
    let w = p.drive_frequency;
    let swing = p.drive_amplitude.abs() / (p.box_stiffness - p.box_mass * w * w).hypot(p.box_damping * w);
    let [load, ..] = p.constant_loads;
    let found = if load == 0.0 { swing } else { swing + load.abs() / p.box_stiffness };
    if found.is_finite() {
        Ok(found)
    } else {
        Err(undefined("box.c", "amplitude without the block at the box's resonance"))
    }
}

/// Passes over the next drive periods.
fn window(simulator: &mut Simulator, measures: &[Measure], periods: u32) -> Result<Window> {
    let p = *simulator.parameters();
    let model = Model::new(&p)?;
    let extent = |c: Coordinate| {
        let mut of = measures.iter().filter(|m| m.coordinate() == Some(c)).peekable();
        of.peek().is_some().then(|| Extent::new(c, of.any(|m| m.needs_square())))
    };
    let mut extents: Vec<_> = Coordinate::ALL.into_iter().filter_map(extent).collect();
    let mut impacts = Impacts::default();
    let (begin, length, before) = (simulator.time(), p.period(), simulator.energy_accounts());
    let arch = pulp::Arch::new();
    for i in 1..=periods {
        smooth_pieces(simulator, &model, begin + f64::from(i) * length, &mut |piece| {
            if !extents.is_empty() {
                // No operation is fused, so that all instruction sets give the same bits.
                arch.dispatch(
                    #[inline(always)]
                    || {
                        expand_along(&model, piece.mode, &piece.start, piece.span, |series, radius| {
                            extents.iter_mut().for_each(|extent| extent.take(series, radius));
                        })
                    },
                );
            }
            if let PieceEnd::Impact { side, rate, impulse, .. } = piece.end {
                impacts.counts[usize::from(side < 0.0)] += 1;
                impacts.speed = impacts.speed.max(rate.abs());
                impacts.impulse = impacts.impulse.max(impulse.abs());
            }
        })?;
    }
    let after = simulator.energy_accounts();
    let energy = [after.input - before.input, after.impact - before.impact];
    let periods = f64::from(periods);
    Ok(Window { extents, impacts, duration: periods * length, energy, periods })
}

impl Window {
    fn extent(&self, coordinate: Coordinate) -> &Extent {
        const NONE: &Extent = &Extent::new(Coordinate::X1, false);
        // Those that the measures need are there.
        self.extents.iter().find(|e| e.coordinate == coordinate).unwrap_or(NONE)
    }

    /// The number of a measure of the window.
    fn number(&self, measure: Measure, p: &Parameters) -> f64 {
        let per_period = |count: u32| f64::from(count) / self.periods;
        let [upper, lower] = self.impacts.counts;
        let of = |c: Coordinate| {
            let gap = if c == Coordinate::W { p.stop_gap } else { f64::INFINITY };
            self.extent(c).within(gap)
        };
        let mean_square = |c: Coordinate| self.extent(c).square / self.duration;
        match measure {
            Measure::Amplitude(c) => of(c).1.max(-of(c).0),
            Measure::Rms(c) => mean_square(c).sqrt(),
            Measure::PeakToPeak(c) => of(c).1 - of(c).0,
            Measure::Maximum(c) => of(c).1,
            Measure::ImpactSpeed => self.impacts.speed,
            Measure::ImpactImpulse => self.impacts.impulse,
            Measure::Impacts => per_period(upper + lower),
            Measure::ImpactsUpper => per_period(upper),
            Measure::ImpactsLower => per_period(lower),
            Measure::PowerInput => self.energy[0] / self.duration,
            Measure::PowerImpact => self.energy[1] / self.duration,
            Measure::PowerBoxDamper => p.box_damping * mean_square(Coordinate::V1),
            Measure::PowerSecondaryDamper => p.secondary_damping * mean_square(Coordinate::V3),
            // Not of the window.
            Measure::Class | Measure::Exponent | Measure::AmplitudeWithoutBlock => 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
