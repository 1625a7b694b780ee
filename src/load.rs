//! Loads from samples: a force history on one body, and the simulator under it.
//!
//! A record of samples (time, force) becomes a polynomial of degree one or three between
//! neighbouring samples. The simulator propagates such polynomials exactly (docs/theory.md (8)),
//! so the motion is exact for the interpolant: only the force between samples is uncertain.
//!
//! ```
//! use vibro_impact::load::{Body, Interpolation, Load};
//! use vibro_impact::simulator::Pause;
//! use vibro_impact::{Parameters, Simulator, State};
//!
//! // A push on the box that rises within a second and is gone a second later.
//! let push = Load::new(Body::Box, &[(0.0, 0.0), (1.0, 0.5), (2.0, 0.0)], Interpolation::Linear)?;
//! let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0)?;
//! simulator.advance_under(&[push], 60.0, Pause::Never, None)?;
//! println!("{} impacts", simulator.impacts().upper + simulator.impacts().lower);
//! # Ok::<(), vibro_impact::Error>(())
//! ```

use crate::error::{Error, Result};
use crate::simulator::{AdvanceOutcome, EventObserver, Loads, Pause, Simulator};
use vibro_numerics::monotone::monotone_slopes;

/// Body on which a load acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// The box.
    Box,
    /// The block.
    Block,
    /// The secondary oscillator.
    Secondary,
}

impl Body {
    /// All bodies, in the order of [`Loads::derivatives`].
    pub const ALL: [Self; 3] = [Self::Box, Self::Block, Self::Secondary];

    /// Name of the body: `box`, `block` or `secondary`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Block => "block",
            Self::Secondary => "secondary",
        }
    }
}

/// Interpolation of the force between two samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// A straight line: continuous, with a corner at each sample.
    #[default]
    Linear,
    /// A cubic with the slopes of Fritsch and Butland at the samples (the scheme known as PCHIP):
    /// smooth, and monotone wherever the samples are. It stays within the range of its two
    /// samples, unlike a spline, which overshoots at a step. A sample changes the force only in
    /// the two intervals on either side of it.
    Cubic,
}

/// Force history on one body: an interpolant of samples, zero before the first sample and constant
/// after the last one.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    body: Body,
    times: Vec<f64>,
    /// Value and derivatives 1…3 just after each sample except the last.
    pieces: Vec<[f64; 4]>,
}

impl Load {
    /// Load from samples (time in s, force in N). The times are simulator times.
    ///
    /// Outside the samples the force is zero, as nothing was measured there: a record that does
    /// not begin and end at zero begins and ends with a jump.
    ///
    /// # Errors
    /// [`Error::Sample`] with the index, counted from 0, of the first sample that is not finite,
    /// is not later than the one before it, or is followed by a slope too steep for a double;
    /// [`Error::Samples`] for fewer than two.
    pub fn new(body: Body, samples: &[(f64, f64)], interpolation: Interpolation) -> Result<Self> {
        if samples.len() < 2 {
            return Err(Error::Samples { count: samples.len() });
        }
        let refuse = |index: usize, allowed: &'static str| {
            let (time, force) = samples[index];
            Err(Error::Sample { index, time, force, allowed })
        };
        if let Some(index) = samples.iter().position(|(t, f)| !(t.is_finite() && f.is_finite())) {
            return refuse(index, "a finite time and a finite force");
        }
        if let Some(index) = samples.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
            return refuse(index + 1, "a time later than the time of the previous sample");
        }
        const STEEP: &str = "a finite slope to the next sample";
        let chord = |pair: &[(f64, f64)]| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
        if let Some(index) = samples.windows(2).position(|pair| !chord(pair).is_finite()) {
            return refuse(index, STEEP);
        }
        let slopes = match interpolation {
            Interpolation::Linear => None,
            Interpolation::Cubic => Some(monotone_slopes(samples)),
        };
        let piece = |(i, pair): (usize, &[(f64, f64)])| {
            let (h, f0, chord) = (pair[1].0 - pair[0].0, pair[0].1, chord(pair));
            let Some(slopes) = &slopes else { return [f0, chord, 0.0, 0.0] };
            // Hermite's cubic, by its derivatives at the earlier sample.
            let (d0, d1) = (slopes[i], slopes[i + 1]);
            [f0, d0, 2.0 * (3.0 * chord - 2.0 * d0 - d1) / h, 6.0 * (d0 + d1 - 2.0 * chord) / (h * h)]
        };
        let pieces: Vec<[f64; 4]> = samples.windows(2).enumerate().map(piece).collect();
        if let Some(index) = pieces.iter().position(|p| !p.iter().all(|d| d.is_finite())) {
            return refuse(index, STEEP);
        }
        Ok(Self { body, times: samples.iter().map(|s| s.0).collect(), pieces })
    }

    /// The body.
    pub fn body(&self) -> Body {
        self.body
    }

    /// Times of the first and the last sample, s.
    pub fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.pieces.len()])
    }

    /// The force at a time (s) and its derivatives 1…3, just after it: N, N/s, N/s², N/s³.
    pub fn derivatives(&self, time: f64) -> [f64; 4] {
        let later = self.times.partition_point(|t| *t <= time);
        if later == 0 || later > self.pieces.len() {
            return [0.0; 4];
        }
        let ([f, d1, d2, d3], u) = (self.pieces[later - 1], time - self.times[later - 1]);
        [f + u * (d1 + u * (d2 / 2.0 + u * (d3 / 6.0))), d1 + u * (d2 + u * (d3 / 2.0)), d2 + u * d3, d3]
    }

    /// The force at a time (s), N.
    pub fn force(&self, time: f64) -> f64 {
        self.derivatives(time)[0]
    }

    /// The first sample after a time, s.
    fn next_sample(&self, time: f64) -> Option<f64> {
        self.times.get(self.times.partition_point(|t| *t <= time)).copied()
    }
}

/// The sum of loads just after a time (s).
pub fn loads_at(loads: &[Load], time: f64) -> Loads {
    let mut sum = Loads::default();
    for load in loads {
        for (total, own) in sum.derivatives[load.body as usize].iter_mut().zip(load.derivatives(time)) {
            *total += own;
        }
    }
    sum
}

/// The first sample of any of the loads after a time, s.
pub fn next_sample(loads: &[Load], time: f64) -> Option<f64> {
    loads.iter().filter_map(|load| load.next_sample(time)).min_by(f64::total_cmp)
}

impl Simulator {
    /// Advances under loads, as [`advance_until`](Self::advance_until), and sets the loads again
    /// at each of their samples. Several loads may act on one body. At the end, the loads just
    /// after that time are in force. A further call with these loads continues the motion under
    /// them; [`advance_to`](Self::advance_to) continues it under the last polynomials.
    ///
    /// # Errors
    /// As [`advance_until`](Self::advance_until) and [`set_loads`](Self::set_loads); the state
    /// then belongs to the time reached.
    pub fn advance_under(
        &mut self,
        loads: &[Load],
        end: f64,
        pause: Pause,
        mut observer: EventObserver<'_, '_>,
    ) -> Result<AdvanceOutcome> {
        // No loads are set if the end is refused, or is before the present by rounding only.
        if !(end.is_finite() && end >= self.time()) {
            return self.advance_until(end, pause, observer);
        }
        loop {
            let now = self.time();
            if self.due_event().is_none() {
                self.set_loads(&loads_at(loads, now))?;
            }
            let next = next_sample(loads, now).map_or(end, |t| t.min(end));
            let reason = self.advance_until(next, pause, observer.as_deref_mut())?;
            if reason != AdvanceOutcome::End {
                return Ok(reason);
            }
            if next >= end {
                self.set_loads(&loads_at(loads, end))?;
                return Ok(reason);
            }
        }
    }
}
