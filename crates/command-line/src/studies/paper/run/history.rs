//! The record of a run: the motion sampled and cut at its events, impacts, extents and energies.

use crate::Result;
use vibro_impact::load::Load;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{AdvanceOutcome, Contact, EnergyAccounts, Event, Pause, Simulator};

/// Gauss-Legendre nodes on [0, 1] and their weights: exact up to degree 7; the square of a cubic
/// has degree 6.
const NODES: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// One instant of a run, SI units; the four displacements are x1, x2, x3 and w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunInstant {
    /// Time since the run began, s.
    pub time: f64,
    /// Displacements, m.
    pub x: [f64; 4],
    /// Their rates, m/s.
    pub v: [f64; 4],
    /// The smooth mode.
    pub contact: Contact,
    /// Whether it is a row of the table; other instants lie between rows or on either side of an
    /// event.
    pub row: bool,
}

/// One impact of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunImpact {
    /// Time since the run began, s.
    pub time: f64,
    /// +1 upper, -1 lower.
    pub side: i8,
    /// |w'| before the impact, m/s.
    pub speed: f64,
    /// Impulse on the box in direction `side`, N·s.
    pub impulse: f64,
}

/// Motion, impacts and energies of a run.
#[derive(Clone, Debug)]
pub struct History {
    /// The motion between events (impacts and releases), each with its first and last instant.
    pub pieces: Vec<Vec<RunInstant>>,
    /// The impacts in order.
    pub impacts: Vec<RunImpact>,
    /// How often the block came to rest at a stop.
    pub rests: usize,
    /// Energy accounts over the run.
    pub energy: EnergyAccounts,
    /// Mechanical energy at the beginning, J.
    pub initial_energy: f64,
    /// Duration, s.
    pub duration: f64,
}

/// Amplitude and root mean square of one displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Largest |x|, m.
    pub amplitude: f64,
    /// √(mean of x²), m.
    pub rms: f64,
}

/// Resolution of the record of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Steps over the whole run.
    pub steps: u32,
    /// Steps between two rows of the table.
    pub every: u32,
}

fn instant(simulator: &Simulator, row: bool) -> RunInstant {
    let (state, (w, rate)) = (simulator.state(), simulator.relative_motion());
    let ([x1, x2, x3], [v1, v2, v3]) = (state.x, state.v);
    let contact = simulator.contact();
    RunInstant { time: simulator.time(), x: [x1, x2, x3, w], v: [v1, v2, v3, rate], contact, row }
}

/// Records the motion of a simulator that is at time 0, over a duration (s) under loads.
///
/// # Errors
/// As [`Simulator::advance_under`].
pub fn record(simulator: &mut Simulator, loads: &[Load], duration: f64, grid: Grid) -> Result<History> {
    let initial_energy = simulator.energy_accounts().mechanical;
    let (mut pieces, mut impacts, mut rests) = (vec![vec![instant(simulator, true)]], Vec::new(), 0);
    for i in 1..=grid.steps {
        let end = duration * (f64::from(i) / f64::from(grid.steps));
        while simulator.advance_under(loads, end, Pause::BeforeEvent, None)? == AdvanceOutcome::EventDue {
            pieces
                .last_mut()
                .into_iter()
                .for_each(|p: &mut Vec<RunInstant>| p.push(instant(simulator, false)));
            simulator.apply_due_event(Some(&mut |event: &Event| match *event {
                Event::Impact { time, side, speed, impulse } => {
                    impacts.push(RunImpact { time, side, speed, impulse });
                }
                Event::Rest { .. } => rests += 1,
                Event::Release { .. } => {}
            }));
            pieces.push(vec![instant(simulator, false)]);
        }
        let now = instant(simulator, i % grid.every == 0);
        pieces.last_mut().into_iter().for_each(|p| p.push(now));
    }
    Ok(History { pieces, impacts, rests, energy: simulator.energy_accounts(), initial_energy, duration })
}

/// The cubic on [0, 1] with these values and slopes at its ends; slopes are multiplied by the
/// interval's length.
fn hermite(x0: f64, v0: f64, x1: f64, v1: f64) -> [f64; 4] {
    [x0, v0, 3.0 * (x1 - x0) - 2.0 * v0 - v1, v0 + v1 - 2.0 * (x1 - x0)]
}

fn at([c0, c1, c2, c3]: [f64; 4], u: f64) -> f64 {
    c0 + u * (c1 + u * (c2 + u * c3))
}

/// The largest |x| of a cubic on [0, 1]. It is at an end or at a point with slope zero.
fn largest(c: [f64; 4]) -> f64 {
    let ends = c[0].abs().max(at(c, 1.0).abs());
    let (a, b) = (3.0 * c[3], c[2]);
    let discriminant = b * b - a * c[1];
    if discriminant < 0.0 {
        return ends;
    }
    // Both roots of a u² + 2 b u + c1 without cancellation.
    let q = -(b + discriminant.sqrt().copysign(b));
    let inside = |u: f64| if u > 0.0 && u < 1.0 { at(c, u).abs() } else { 0.0 };
    ends.max(inside(q / a)).max(inside(c[1] / q))
}

impl History {
    /// All instants in order.
    pub fn instants(&self) -> impl Iterator<Item = &RunInstant> {
        self.pieces.iter().flatten()
    }

    /// Extent of the displacement of an index (x1, x2, x3, w), by cubic interpolation between the
    /// instants.
    pub fn extent(&self, index: usize) -> Extent {
        let (mut amplitude, mut square) = (0.0f64, 0.0);
        for pair in self.pieces.iter().flat_map(|piece| piece.windows(2)) {
            let h = pair[1].time - pair[0].time;
            let [(x0, v0), (x1, v1)] = [0, 1].map(|i: usize| (pair[i].x[index], pair[i].v[index] * h));
            let cubic = hermite(x0, v0, x1, v1);
            amplitude = amplitude.max(largest(cubic));
            square += h * NODES.iter().map(|(u, weight)| weight * at(cubic, *u).powi(2)).sum::<f64>();
        }
        Extent { amplitude, rms: (square / self.duration).sqrt() }
    }

    /// Impacts at the upper and at the lower stop.
    pub fn impacts_by_side(&self) -> [usize; 2] {
        let upper = self.impacts.iter().filter(|i| i.side > 0).count();
        [upper, self.impacts.len() - upper]
    }

    /// Error of the energy balance, docs/theory.md (90), J.
    pub fn balance_error(&self) -> f64 {
        let e = &self.energy;
        e.mechanical - (self.initial_energy + e.input - e.damped - e.impact)
    }
}

/// The grid with `samples` rows and at least `least` steps in a drive period.
///
/// # Errors
/// [`Error::Refused`](crate::Error::Refused) if there are more than `most` steps.
pub fn grid(p: &Parameters, duration: f64, samples: u32, least: u32, most: u32) -> Result<Grid> {
    let every = least.div_ceil(samples);
    let rows = (duration / p.period() * f64::from(samples) - 1e-6).ceil().max(1.0);
    let steps = rows * f64::from(every);
    if steps > f64::from(most) {
        let periods = f64::from(most) / f64::from(every) / f64::from(samples);
        let text = format!("a run of {} drive periods with {samples} rows in each", duration / p.period());
        return Err(crate::Error::Refused {
            what: text,
            problem: format!("expected at most {periods:.0} drive periods with {samples} rows in each"),
        });
    }
    Ok(Grid { steps: steps as u32, every })
}
