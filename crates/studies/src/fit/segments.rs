//! Multiple shooting: fits over segments with their own initial states (H. G. Bock, Recent
//! advances in parameter identification techniques for ODE, 1983). A chaotic motion depends
//! smoothly on its parameters over a few periods only.
//!
//! A segment begins in mid-flight, at the fitted motion's state. Its permitted distance from the
//! end of the previous segment decreases step by step to rounding.

use super::beside::Followed;
use super::bounds::Bounds;
use super::evaluated::{Point, Reach, Solved};
use super::horizons::LEAST_ROWS;
use super::model::Model;
use super::solver::{Convergence, solve};
use super::{WAYS, Way};
use crate::error::{Error, Result};
use vibro_machine::derivative::By;
use vibro_machine::{Differentiated, Motion};

/// Growth of a small change, relative to the sizes of the states, at which a segment ends.
const GROWTH: f64 = 20.0;
/// Growth at which rounding, 1e-16, exceeds a thousandth of the motion.
const CHAOTIC: f64 = 1e13;
/// The next segment begins in the last part of a segment, with this fraction of its length.
const PLACE: f64 = 0.5;
/// Cap on the intervals between contact events that are searched for a node, the longest first. A
/// motion that chatters has many intervals.
const GAPS: usize = 20;
/// Smallest mean number of contacts in a segment.
const CONTACTS: f64 = 3.0;
/// The fit ends if the horizons whose fitted motion leaves the record exceed the other horizons by
/// this number. At the smallest growth, ten horizons have the length of a segment.
const LOST: u32 = 10;
/// Number of sampling times for growth and range.
const LOOKS: usize = 400;
/// Criterion for growing a horizon.
const WAY: Way = WAYS[2];
/// Smallest and largest growth of a horizon, in segments.
const LONGER: (f64, f64) = (0.1, 0.6);
/// Smallest noise of a column while horizons grow, relative to its size.
const NOISE: f64 = 1e-3;
/// Standard deviations of the defects in successive steps, relative to the sizes of the states.
pub(super) const DEFECTS: [f64; 6] = [3e-2, 3e-3, 3e-4, 1e-5, 1e-7, 1e-9];

/// Defect, relative to the sizes of the states, up to which segments are a single motion.
pub(super) const CONTINUOUS: f64 = 1e-6;

/// Length of segments, s; `None` if they end where small changes have grown.
pub(super) type Length = Option<f64>;

/// Result of fitting segments from an initial point. `model` weights residuals by their noise.
pub(super) fn over_segments(
    model: &Model,
    bounds: &Bounds,
    start: &[f64],
    length: Length,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let (first, end) = (model.first(), model.end());
    let sizes = model.sizes_of_states(start)?;
    let weights = |defect: f64| sizes.iter().map(|size| 1.0 / (defect * size)).collect();
    let mut point = Point::from(start.to_vec());
    let mut reach = Reach { weights: weights(DEFECTS[0]), ..Reach::whole(end) };
    let least = model.least_horizon(LEAST_ROWS * start.len());
    reach.end = model.near_until(&point, &[], WAY).max(least).min(end);
    let mut span = length.unwrap_or(reach.end - first);
    let spacing = model.spacing(&point)?;
    let mut lost = 0u32;
    loop {
        point = solve(model, bounds, &point, (&reach, Convergence::Rough), go_on)?.point;
        while let Some((node, state)) = next_node(model, &point, &reach, (length, spacing), &sizes)? {
            span = node - reach.nodes.last().copied().unwrap_or(first);
            reach.nodes.push(node);
            point.states.push(state);
        }
        if reach.end >= end || !go_on() {
            break;
        }
        let near = model.near_until(&point, &reach.nodes, WAY);
        lost = if near < reach.end { lost + 1 } else { lost.saturating_sub(1) };
        if lost >= LOST && length.is_none() {
            let problem = format!("segments leave the record at {near:?} s");
            return Err(Error::Described { problem });
        }
        let span = span.max(length.unwrap_or(spacing));
        reach.end = near.clamp(reach.end + LONGER.0 * span, reach.end + LONGER.1 * span).min(end);
    }
    reach.end = end;
    for (k, defect) in DEFECTS.iter().enumerate() {
        reach.weights = weights(*defect);
        let is_last = k + 1 == DEFECTS.len();
        let convergence = if is_last { Convergence::Whole } else { Convergence::Rough };
        point = solve(model, bounds, &point, (&reach, convergence), go_on)?.point;
    }
    let is_continuous = misses(model, (&point, &reach), &sizes)?.iter().all(|miss| *miss < CONTINUOUS);
    Ok(Solved { point, reach, cost: f64::INFINITY, is_continuous })
}

/// The motion of given values in segments, which are loosely tied. Each begins in flight, in the
/// motion's state.
pub(super) fn divided(model: &Model, values: &[f64]) -> Result<Solved> {
    let sizes = model.sizes_of_states(values)?;
    let mut point = Point::from(values.to_vec());
    let weights = sizes.iter().map(|size| 1.0 / (DEFECTS[0] * size)).collect();
    let mut reach = Reach { weights, ..Reach::whole(model.end()) };
    let spacing = model.spacing(&point)?;
    while let Some((node, state)) = next_node(model, &point, &reach, (None, spacing), &sizes)? {
        reach.nodes.push(node);
        point.states.push(state);
    }
    Ok(Solved { point, reach, cost: f64::INFINITY, is_continuous: false })
}

/// Next node and the state there: the middle of the longest interval without an event or a closed
/// contact; `None` without one before the horizon.
fn next_node(
    model: &Model,
    point: &Point,
    reach: &Reach,
    (length, spacing): (Length, f64),
    sizes: &[f64],
) -> Result<Option<(f64, Vec<f64>)>> {
    let (mut motion, shift) = model.last_segment(point, &reach.nodes, length.is_none())?;
    let from = motion.motion().time();
    let horizon = reach.end + shift;
    let end = match length {
        Some(length) => from + length,
        None => match grown(&mut motion.clone(), horizon, sizes)? {
            Some(time) => time.max(from + spacing),
            None => return Ok(None),
        },
    };
    // A short last segment hardly determines its initial state.
    if end >= horizon {
        return Ok(None);
    }
    let begin = end - PLACE * (end - from);
    motion.advance_to(begin)?;
    let begun: &Motion = motion.motion();
    let mut times = vec![begin];
    let mut note = |event: &vibro_machine::motion::Event| {
        if event.contact().is_some() {
            times.push(event.time);
        }
    };
    begun.clone().advance_observed(end, &mut note)?;
    times.push(end);
    let mut gaps: Vec<(f64, f64)> = times.windows(2).map(|pair| (pair[0], pair[1])).collect();
    gaps.sort_by(|a, b| (b.1 - b.0).total_cmp(&(a.1 - a.0)));
    for (a, b) in gaps.into_iter().take(GAPS).filter(|(a, b)| a < b) {
        let mut own = begun.clone();
        own.advance_to(0.5 * (a + b))?;
        if own.mode().contacts().next().is_none() {
            return Ok(Some((own.time() - shift, own.states())));
        }
    }
    Ok(None)
}

/// Growth of a change in component `p` of the initial state; `None` without a derivative.
fn growth(motion: &Differentiated, sizes: &[f64], p: usize) -> Option<f64> {
    let by = motion.state_derivative(p)?;
    Some(by.iter().zip(sizes).map(|(x, size)| (x / size * sizes[p]).abs()).fold(0.0, f64::max))
}

/// Time needed for the growth of a change of the initial state, up to a horizon.
fn grown(motion: &mut Differentiated, horizon: f64, sizes: &[f64]) -> Result<Option<f64>> {
    let from = motion.motion().time();
    for i in 1..=LOOKS {
        motion.advance_to(from + (horizon - from) * i as f64 / LOOKS as f64)?;
        // Without a derivative, a change leads to another motion.
        if (0..sizes.len()).any(|p| growth(motion, sizes, p).is_none_or(|growth| growth > GROWTH)) {
            return Ok(Some(motion.motion().time()));
        }
    }
    Ok(None)
}

impl Model<'_> {
    /// Whether rounding grows until the motion leaves the record. No single motion is then the
    /// record's, whatever the parameters.
    pub(super) fn is_chaotic(&self, values: &[f64]) -> bool {
        let most = || {
            let sizes = self.sizes_of_states(values)?;
            let (mut motion, shift) = self.last_segment(&Point::from(values.to_vec()), &[], true)?;
            motion.advance_to(self.end() + shift)?;
            // Lost derivatives give no growth.
            let all = (0..sizes.len()).filter_map(|p| growth(&motion, &sizes, p));
            Ok::<_, Error>(all.fold(0.0, f64::max))
        };
        most().is_ok_and(|most| most > CHAOTIC)
    }

    /// Smallest mean length of segments, s. A stiff buffer makes changes grow within one touch.
    fn spacing(&self, point: &Point) -> Result<f64> {
        let contacts = self.beside(point, &Reach::whole(self.end()))?.contacts_of_motion();
        Ok(CONTACTS * (self.end() - self.first()) / contacts.max(1) as f64)
    }

    /// Motion at the begin of the last segment, with derivatives by its state on request, and the
    /// record's shift.
    fn last_segment(&self, point: &Point, nodes: &[f64], varied: bool) -> Result<(Differentiated, f64)> {
        let made = self.unknowns.with(&point.values)?;
        let assembly = made.assembly.clone();
        let columns: Vec<By> =
            if varied { (0..assembly.system().states()).map(By::Start).collect() } else { Vec::new() };
        let motion = match (nodes.last(), point.states.last()) {
            (Some(node), Some(state)) => {
                Differentiated::from_state(assembly, node + made.shift, state, &columns)?
            }
            _ => made.start.differentiated_by(assembly, &columns, &mut |_, _| ())?,
        };
        Ok((motion, made.shift))
    }

    /// Half the range of each state component over the record, up to the end of the motion.
    pub(super) fn sizes_of_states(&self, values: &[f64]) -> Result<Vec<f64>> {
        let (motion, shift) = self.last_segment(&Point::from(values.to_vec()), &[], false)?;
        let mut motion = motion.motion().clone();
        let states = motion.assembly().system().states();
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); states];
        for i in 0..=LOOKS {
            let time = self.first() + (self.end() - self.first()) * i as f64 / LOOKS as f64 + shift;
            if motion.advance_to(time.max(motion.time())).is_err() {
                break;
            }
            for (range, x) in ranges.iter_mut().zip(&motion.states()) {
                *range = (range.0.min(*x), range.1.max(*x));
            }
        }
        let size = |(low, high): &(f64, f64)| Some(0.5 * (high - low)).filter(|s| *s > 0.0 && s.is_finite());
        Ok(ranges.iter().map(|range| size(range).unwrap_or(1.0)).collect())
    }

    /// The model with residuals weighted by noise, for fits over segments.
    pub(super) fn for_segments(&self) -> Self {
        self.by_noise(NOISE)
    }
}

/// Defects at the nodes, relative to the sizes of the states.
pub(super) fn misses(model: &Model, (point, reach): (&Point, &Reach), sizes: &[f64]) -> Result<Vec<f64>> {
    let beside = model.beside(point, reach)?;
    let one = |(before, state): (&Followed, &Vec<f64>)| {
        let missed = before.end.iter().zip(state).zip(sizes);
        missed.fold(0.0, |most: f64, (((end, _), next), size)| most.max(((end - next) / size).abs()))
    };
    Ok(beside.0.iter().zip(&point.states).map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{FitRequest, Free, Loss, Measured, Segments};
    use super::*;
    use crate::Machine;
    use vibro_machine::Start;
    use vibro_machine::file::no_records;

    /// A mass on a spring with a stiffness of -1 N/m: changes grow exponentially in time.
    #[test]
    fn closed_form_a_motion_is_chaotic_where_changes_grow_beyond_a_thousandth_over_rounding() {
        let text = "name = \"Tilting\"\nbody.a = { mass = 1.0, start = { s = 1e-9 } }\n\
                    spring.k = { between = [\"ground\", \"a\"], points = [[-1.0, 1.0], [1.0, -1.0]] }\n";
        let is_chaotic = |until: f64| {
            let request = FitRequest {
                name: String::new(),
                machine: Machine::parse(text, "tilting.toml", &no_records).unwrap(),
                start: Start::default(),
                measured: Measured {
                    times: vec![0.0, until],
                    columns: vec![("a.s".parse().unwrap(), vec![0.0, 1.0])],
                    ..Measured::default()
                },
                free: vec![Free { name: "body.a.start.s".into(), within: None, is_own: false }],
                sigma: None,
                filters: Vec::new(),
                loss: Loss::Linear,
                segments: Segments::Auto,
                starts: 0,
            };
            Model::new(&request).unwrap().is_chaotic(&[1e-9])
        };
        // ln 1e13 is 29.9; the growth of one state is half the exponential.
        assert!(!is_chaotic(29.0) && is_chaotic(32.0));
    }
}
