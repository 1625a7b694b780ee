//! Measures of a settled motion: amplitudes, root mean squares, impacts, powers, class, exponent.
//!
//! All come from one pass over the smooth pieces of the motion, along which the flow's series are
//! known. Extrema lie at the ends of a piece or at zeros of a rate, which
//! [`turns`](vibro_numerics::events::turns) finds with proof. Squares are integrated by a Gauss
//! rule whose error is below round-off. Losses at impacts and the work of the drive come from the
//! simulator's accounts. The loss in a damper is its coefficient times the mean square of its
//! rate.
//!
//! ```
//! use vibro_studies::paper::measures::{Measure, measure};
//! use vibro_studies::paper::motion::settled_simulator;
//! use vibro_studies::paper::stroboscopic::moving_block;
//! use vibro_impact::Parameters;
//!
//! let p = Parameters::default();
//! let measures = ["amplitude.x1".parse::<Measure>()?, "impacts".parse()?];
//! let found = measure(&mut settled_simulator(&p, &moving_block(&p), 400.0)?, &measures, 60)?;
//! assert!((found.numbers[0].unwrap() - 0.3574).abs() < 1e-4 && found.numbers[1] == Some(2.0));
//! # Ok::<(), vibro_studies::Error>(())
//! ```

mod extent;
mod name;

pub use name::{Coordinate, Measure};

use crate::error::Result;
use crate::measured::{Measured, is_drifting, spread_of};
use crate::paper::lyapunov::{self, Spectrum, SpectrumOptions};
use crate::paper::smooth_pieces::{PieceEnd, smooth_pieces};
use crate::paper::trajectories::Start;
use crate::paper::verdict::verdict;
use crate::windows::{Observation, Parts, whole};
use extent::Extent;
use vibro_impact::error::Error;
use vibro_impact::flow::expand_along;
use vibro_impact::model::Model;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Simulator;

/// Impacts in a window.
#[derive(Clone, Copy, Debug, Default)]
struct Impacts {
    /// Numbers at the upper and at the lower stop.
    counts: [u32; 2],
    /// Largest |w'| before an impact, m/s.
    speed: f64,
    /// Largest impulse, N·s.
    impulse: f64,
}

/// A window of whole drive periods.
#[derive(Clone, Debug)]
struct Window {
    /// Extents of the coordinates that the measures need.
    extents: Vec<Extent>,
    impacts: Impacts,
    /// Length, s.
    duration: f64,
    /// Work of the drive and energy lost at impacts, J.
    energy: [f64; 2],
    periods: f64,
}

/// Measures a motion, with constant loads only, over the next `periods` drive periods, and class
/// and exponent over the periods after these. The caller has discarded the transient.
/// [`Measure::PowerInput`] needs a simulator with energy accounts.
///
/// # Errors
/// As [`Simulator::advance_until`]; [`Error::Undefined`] without a drive, which sets the period.
pub fn measure(simulator: &mut Simulator, measures: &[Measure], periods: u32) -> Result<Measured> {
    let p = *simulator.parameters();
    if p.drive_frequency == 0.0 {
        return Err(
            undefined("drive.frequency", "measure of a motion, which is taken over drive periods,").into()
        );
    }
    let parts = windows(simulator, measures, periods.max(1))?;
    let window = whole(&parts);
    let wants = |sought: Measure| measures.contains(&sought);
    let (mut class, mut exponent) = (None, None);
    if wants(Measure::Class) {
        // Time 0 of the new motion has the present phase of the drive.
        let parameters = Parameters { drive_phase: simulator.drive_phase(), ..p };
        let start = Start { parameters, state: simulator.state() };
        class = Some(verdict(&start, 0)?.class);
    }
    if wants(Measure::Exponent) {
        // The unit is 1/s throughout: without a spring between box and ground, ω10 is zero.
        let options = SpectrumOptions::default();
        let options = SpectrumOptions { threshold: options.threshold * p.box_frequency(), ..options };
        exponent = Some(lyapunov::spectrum(simulator, &options)?);
    }
    let number = |measure: &Measure| match measure {
        Measure::Class => None,
        Measure::Exponent => exponent.as_ref().map(Spectrum::largest_beside_phase),
        Measure::AmplitudeWithoutBlock => amplitude_without_block(&p).ok(),
        other => Some(window.number(*other, &p)),
    };
    let numbers = measures.iter().map(number).collect();
    let spread = |measure: &Measure| match (measure, &exponent) {
        (Measure::Exponent, Some(exponent)) => exponent.deviation,
        _ => spread(&parts, *measure, &p),
    };
    let spreads = measures.iter().map(spread).collect();
    let goes = |measure: &Measure| is_of_window(measure) && is_drifting(&of_parts(&parts, *measure, &p));
    Ok(Measured { numbers, class, spreads, unsettled: measures.iter().position(goes) })
}

fn undefined(name: &'static str, needed_by: &'static str) -> Error {
    let allowed = if name == "box.c" { "box.c > 0 there" } else { "drive.frequency > 0" };
    Error::Undefined { name, value: 0.0, needed_by, allowed }
}

/// Amplitude of the box alone on its spring and damper under the drive, m:
/// F10/|k1 - m1 ω1² + i c1 ω1|, the periodic solution of docs/theory.md (3) without block and
/// coupling. Under a constant load on the box, which shifts its middle, it is the largest |x1|.
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

/// Whether a measure is taken from the window: not the class, the exponent, or the closed form.
pub(crate) fn is_of_window(measure: &Measure) -> bool {
    !matches!(measure, Measure::Class | Measure::Exponent | Measure::AmplitudeWithoutBlock)
}

/// Value of a measure in each part.
fn of_parts(parts: &[Window], measure: Measure, p: &Parameters) -> Vec<f64> {
    parts.iter().map(|part| part.number(measure, p)).collect()
}

/// Spread of a measure over windows of the joint length of these parts.
fn spread(parts: &[Window], measure: Measure, p: &Parameters) -> f64 {
    let numbers = of_parts(parts, measure, p);
    match measure {
        Measure::Class | Measure::Exponent | Measure::AmplitudeWithoutBlock => 0.0,
        Measure::Amplitude(_) | Measure::PeakToPeak(_) | Measure::Maximum(_) => spread_of(&numbers, true),
        Measure::ImpactSpeed | Measure::ImpactImpulse => spread_of(&numbers, true),
        _ => spread_of(&numbers, false),
    }
}

/// Advances over the next drive periods in parts. If the motion repeats, only the periods that
/// show this are computed.
fn windows(simulator: &mut Simulator, measures: &[Measure], periods: u32) -> Result<Vec<Window>> {
    let p = *simulator.parameters();
    let model = Model::new(&p)?;
    let forces = model.constant_forces();
    let extent = |c: Coordinate| {
        let mut of = measures.iter().filter(|m| m.coordinate() == Some(c)).peekable();
        of.peek().is_some().then(|| Extent::new(c, of.any(|m| m.needs_square())))
    };
    let fresh: Vec<_> = Coordinate::ALL.into_iter().filter_map(extent).collect();
    let (begin, length) = (simulator.time(), p.period());
    let arch = pulp::Arch::new();
    let mut parts = Parts::new();
    for i in 1..=periods {
        let (mut extents, mut impacts) = (fresh.clone(), Impacts::default());
        let (before, from) = (simulator.energy_accounts(), simulator.state());
        smooth_pieces(simulator, &model, begin + f64::from(i) * length, &mut |piece| {
            if !extents.is_empty() {
                // No operation is fused, so that all instruction sets give the same bits.
                arch.dispatch(
                    #[inline(always)]
                    || {
                        let from = (&piece.start, forces.as_ref());
                        expand_along(&model, piece.mode, from, piece.span, |series, radius| {
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
        let after = simulator.energy_accounts();
        // The input account includes the drive and the constant loads.
        let way = simulator.state().x.into_iter().zip(from.x).map(|(to, from)| to - from);
        let of_loads: f64 = p.constant_loads.into_iter().zip(way).map(|(load, way)| load * way).sum();
        let energy = [after.input - before.input - of_loads, after.impact - before.impact];
        if parts.push(Window { extents, impacts, duration: length, energy, periods: 1.0 }) {
            break;
        }
    }
    Ok(parts.finish())
}

impl Observation for Window {
    fn numbers(&self) -> [Vec<f64>; 3] {
        let ends = self.extents.iter().flat_map(|e| [e.within(f64::INFINITY).0, e.within(f64::INFINITY).1]);
        [ends.collect(), vec![self.impacts.speed], self.energy.to_vec()]
    }

    fn join(&mut self, later: &Self) {
        self.extents.iter_mut().zip(&later.extents).for_each(|(own, other)| own.join(other));
        for side in 0..2 {
            self.impacts.counts[side] += later.impacts.counts[side];
            self.energy[side] += later.energy[side];
        }
        self.impacts.speed = self.impacts.speed.max(later.impacts.speed);
        self.impacts.impulse = self.impacts.impulse.max(later.impacts.impulse);
        self.duration += later.duration;
        self.periods += later.periods;
    }
}

impl Window {
    fn extent(&self, coordinate: Coordinate) -> &Extent {
        const NONE: &Extent = &Extent::new(Coordinate::X1, false);
        // The extents of all needed coordinates are present.
        self.extents.iter().find(|e| e.coordinate == coordinate).unwrap_or(NONE)
    }

    /// Value of a measure of the window.
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
            // Not measures of the window.
            Measure::Class | Measure::Exponent | Measure::AmplitudeWithoutBlock => 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
