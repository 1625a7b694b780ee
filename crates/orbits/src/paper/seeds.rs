//! Seeds of a tree (docs/theory.md, section 14): orbits of settled motions with the parameter
//! rising and falling, and orbits that motions from spread starts pass.

use super::family::Family;
use super::orbit::{Orbit, canonical};
use super::settled::{self, from_drive_units, in_drive_units};
use super::system::System;
use super::tree_options::TreeOptions;
use crate::stop_word::OrbitWord;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::{Event, Simulator, State};
use vibro_studies::Error;
use vibro_studies::paper::attractor::distance;
use vibro_studies::paper::bifurcation::within_gap;
use vibro_studies::paper::stroboscopic::{StroboscopicState, moving_block};
use vibro_studies::sobol::coordinate;

/// Drive periods over which the states of a settled motion are recorded.
const VISITED: u32 = 64;
/// Number of neighbouring values in each direction whose visited states make up the box of starts
/// of a value. `WIDER` is the widening factor of this box.
const NEIGHBOURS: usize = 2;
const WIDER: f64 = 1.5;
/// Largest distance of the block's start from the centre, as a fraction of the gap.
const INSIDE: f64 = 0.999;
/// Length of the motion from each start, in drive periods.
pub(super) const PERIODS: u32 = 300;
/// Longest period of a near return, in drive periods.
pub(super) const LONGEST: usize = 4;
/// Largest change of a coordinate (units of L and L ω1) in a near return.
const RETURN: f64 = 0.04;
/// Largest correction of a phase by Newton's method from a near return to an orbit, rad.
const MOVE: f64 = 0.4;
/// Number of parts of the range. Only the first of several orbits with the same word and stability
/// within one part is kept, because the others mostly lie on its branch.
const RANGE_PARTS: f64 = 30.0;

/// An orbit found by simulation: word, phases and parameter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SeedOrbit {
    pub word: OrbitWord,
    pub phases: Vec<f64>,
    pub value: f64,
    pub stable: bool,
}

/// Search results at a value of the parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchedValue {
    /// The parameter.
    pub value: f64,
    /// Period, in drive periods, of the orbit on which the motion settled with the parameter
    /// rising; `None` without a stable orbit within the tree's limits.
    pub rising: Option<u32>,
    /// As `rising`, with the parameter falling.
    pub falling: Option<u32>,
    /// Number of starts between this value and the next.
    pub starts: u32,
    /// Number of kept orbits near motions from these starts; branches start from these orbits.
    pub found: u32,
}

/// Extent and result of the search for orbits by simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Searched {
    /// The values at which motions were settled, in order.
    pub values: Vec<SearchedValue>,
    /// Length of each motion from a start, in drive periods.
    pub periods: u32,
    /// Number of branches traced from orbits near such motions.
    pub followed: usize,
    /// Number of kept branches: stable somewhere and not known before.
    pub islands: usize,
}

/// All orbits found by simulation.
#[derive(Serialize, Deserialize)]
pub(super) struct Seeds {
    pub settled: Vec<SeedOrbit>,
    pub passed: Vec<SeedOrbit>,
    pub searched: Searched,
}

/// A box of states: the least and the greatest value of each coordinate.
type Hull = [(f64, f64); 6];

const NOTHING: Hull = [(f64::INFINITY, f64::NEG_INFINITY); 6];

fn hull(a: Hull, b: &Hull) -> Hull {
    std::array::from_fn(|i| (a[i].0.min(b[i].0), a[i].1.max(b[i].1)))
}

/// The orbits of a family at which branches start.
pub(super) fn seeds(family: &Family, options: &TreeOptions) -> Result<Seeds, Error> {
    let count = options.seeds;
    let span = *family.span();
    let value = |i: usize| {
        let part = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.5 };
        span.from * (1.0 - part) + span.to * part
    };
    let (rising, falling) =
        rayon::join(|| chain(family, options, &value, true), || chain(family, options, &value, false));
    let chains = [rising?, falling?];
    let boxes: Vec<Hull> = (0..count).map(|i| hull(chains[0][i].visited, &chains[1][i].visited)).collect();
    let period = |links: &[Link], i: usize| -> Option<u32> {
        links[i].orbit.as_ref().filter(|orbit| orbit.stable).map(|orbit| orbit.word.period())
    };
    let mut values: Vec<SearchedValue> = (0..count)
        .map(|i| SearchedValue {
            value: value(i),
            rising: period(&chains[0], i),
            falling: period(&chains[1], i),
            ..SearchedValue::default()
        })
        .collect();
    let passed = wide(family, options, &boxes, &mut values)?;
    let settled = chains.into_iter().flatten().filter_map(|link| link.orbit).collect();
    let searched = Searched { values, periods: PERIODS, followed: 0, islands: 0 };
    Ok(Seeds { settled, passed, searched })
}

/// Result of a settled motion at one value: its orbit and the box of its states.
#[derive(Clone)]
struct Link {
    orbit: Option<SeedOrbit>,
    visited: Hull,
}

/// The orbits on which motions settle from value to value, in the order of rising values. Each
/// motion starts where the previous one ended.
fn chain(
    family: &Family,
    options: &TreeOptions,
    value: &(impl Fn(usize) -> f64 + Sync),
    rising: bool,
) -> Result<Vec<Link>, Error> {
    let (count, limits) = (options.seeds, options.limits());
    let mut links = vec![Link { orbit: None, visited: NOTHING }; count];
    let mut last = None;
    for k in 0..count {
        let i = if rising { k } else { count - 1 - k };
        let value = value(i);
        let system = family.system(&[value])?;
        let p = system.parameters();
        let start = last.map_or_else(|| moving_block(p), |(state, gap)| within_gap(state, gap, p.stop_gap));
        // After a simulation error, the motion at the next value starts from the default state.
        let settled = settled::settle(&system, &start, options.settle).ok();
        last = settled.map(|state| (state, p.stop_gap));
        let Some(state) = settled else { continue };
        if options.starts > 0 {
            links[i].visited = visited(&system, &state).unwrap_or(NOTHING);
        }
        let orbit =
            settled::orbit_within(&system, &state, limits).ok().filter(|orbit| !orbit.word().is_empty());
        links[i].orbit = orbit.and_then(|orbit| {
            let (word, phases) = family.shortest(&orbit);
            let seed = SeedOrbit { word, phases, value, stable: orbit.is_stable() };
            options.admits(&seed.word).then_some(seed)
        });
    }
    Ok(links)
}

/// Box of the states of a motion at whole drive periods; without loads it includes the mirror
/// images.
fn visited(system: &System, state: &State) -> Result<Hull, Error> {
    let p = system.parameters();
    let mut simulator = settled::simulator(system, state)?;
    let mut found = NOTHING;
    for period in 1..=VISITED {
        simulator.advance_to(f64::from(period) * p.period())?;
        let point = in_drive_units(p, &simulator.state()).map(|x| (x, x));
        found = hull(found, &point);
        if system.is_symmetric() {
            found = hull(found, &point.map(|(x, _)| (-x, -x)));
        }
    }
    Ok(found)
}

/// The orbits near which motions from spread starts pass. Half of the starts lie over the whole
/// range; the other half lie between values where a motion did not settle on a stable orbit, since
/// a diagram has few rows there. States are spread over the widened box of neighbouring values.
fn wide(
    family: &Family,
    options: &TreeOptions,
    boxes: &[Hull],
    values: &mut [SearchedValue],
) -> Result<Vec<SeedOrbit>, Error> {
    let (starts, cells) = (options.starts, values.len().saturating_sub(1));
    if starts == 0 || cells == 0 {
        return Ok(Vec::new());
    }
    let settles = |v: &SearchedValue| v.rising.is_some() && v.falling.is_some();
    let poor: Vec<usize> =
        (0..cells).filter(|i| !(settles(&values[*i]) && settles(&values[i + 1]))).collect();
    // The cell of a number in [0, 1), and its position in the cell.
    let spread = |part: f64, among: usize| {
        let at = part * among as f64;
        (at as usize, at.fract())
    };
    let start = |k: usize| -> Option<(usize, f64, State)> {
        // The sequence's first point, the origin, is left out.
        let index = u32::try_from(k + 1).ok()?;
        let at = |dimension: usize| coordinate(index, dimension);
        let (cell, part) = if k % 2 == 1 && !poor.is_empty() {
            let (index, part) = spread(at(0), poor.len());
            (poor[index], part)
        } else {
            spread(at(0), cells)
        };
        let value = values[cell].value + part * (values[cell + 1].value - values[cell].value);
        let near = cell.saturating_sub(NEIGHBOURS)..(cell + 2 + NEIGHBOURS).min(boxes.len());
        let visited = boxes[near].iter().fold(NOTHING, hull);
        let within = |i: usize, dimension: usize| {
            let (from, to) = visited[i];
            0.5 * (from + to) + WIDER * (to - from) * (at(dimension) - 0.5)
        };
        let mut state: StroboscopicState = std::array::from_fn(|i| within(i, i + 1));
        state[1] = state[0] + INSIDE * (2.0 * at(2) - 1.0);
        let system = family.system(&[value]).ok()?;
        state
            .iter()
            .all(|x| x.is_finite())
            .then(|| (cell, value, from_drive_units(system.parameters(), &state)))
    };
    let all: Vec<(usize, f64, State)> = (0..starts).filter_map(start).collect();
    let found: Vec<Vec<SeedOrbit>> = all
        .par_iter()
        .map(|(_, value, state)| passes(family, *value, state, options))
        .collect::<Result<_, _>>()?;
    let unit = (values[cells].value - values[0].value) / RANGE_PARTS;
    let mut kept: Vec<SeedOrbit> = Vec::new();
    for ((cell, ..), orbits) in all.iter().zip(found) {
        values[*cell].starts += 1;
        for orbit in orbits {
            let alike = |k: &SeedOrbit| {
                k.word == orbit.word && k.stable == orbit.stable && (k.value - orbit.value).abs() < unit
            };
            if !kept.iter().any(alike) {
                values[*cell].found += 1;
                kept.push(orbit);
            }
        }
    }
    Ok(kept)
}

/// The orbits near which a motion passes, each once in its shortest canonical word: orbits that
/// Newton's method finds from near returns, and the orbit on which the motion has settled.
fn passes(
    family: &Family,
    value: f64,
    start: &State,
    options: &TreeOptions,
) -> Result<Vec<SeedOrbit>, Error> {
    let (system, limits) = (family.system(&[value])?, options.limits());
    let mut found: Vec<SeedOrbit> = Vec::new();
    let mut keep = |orbit: Orbit| {
        let (word, phases) = family.shortest(&orbit);
        let (word, phases) = canonical(&word, &phases, family.is_symmetric());
        if !word.is_empty() && options.admits(&word) && !found.iter().any(|orbit| orbit.word == word) {
            found.push(SeedOrbit { word, phases, value, stable: orbit.is_stable() });
        }
    };
    let Ok(mut simulator) = settled::simulator(&system, start) else { return Ok(Vec::new()) };
    let p = *system.parameters();
    let mut course = SampledMotion::default();
    let mut tried: Vec<(usize, Vec<i8>)> = Vec::new();
    course.states.push(in_drive_units(&p, &simulator.state()));
    for _ in 0..PERIODS {
        if course.advance(&mut simulator, &p).is_err() {
            return Ok(found);
        }
        for q in 1..=LONGEST.min(limits.periods as usize).min(course.ends.len()) {
            let Some((letters, phases)) = course.near_return(q).filter(|(l, _)| l.len() <= limits.impacts)
            else {
                continue;
            };
            let key = (q, letters.to_vec());
            if tried.contains(&key) {
                continue;
            }
            if let Ok(orbit) = settled::near(&system, letters, phases, q as u32, MOVE) {
                keep(orbit);
            }
            tried.push(key);
        }
    }
    let end = settled::orbit_within(&system, &simulator.state(), limits);
    if let Some(orbit) = end.ok().filter(Orbit::is_stable) {
        keep(orbit);
    }
    Ok(found)
}

/// States of a motion at whole drive periods, and its impacts.
#[derive(Default)]
struct SampledMotion {
    states: Vec<StroboscopicState>,
    letters: Vec<i8>,
    phases: Vec<f64>,
    /// For each period the number of impacts up to its end, and whether the block rested in it.
    ends: Vec<(usize, bool)>,
}

impl SampledMotion {
    /// Simulates the next drive period.
    fn advance(&mut self, simulator: &mut Simulator, p: &vibro_impact::Parameters) -> Result<(), Error> {
        let mut rests = false;
        let end = (self.ends.len() + 1) as f64 * p.period();
        simulator.advance_observed(end, &mut |event| match *event {
            Event::Impact { time, side, .. } => {
                self.phases.push(settled::first_phase(p) + p.drive_frequency * time);
                self.letters.push(side);
            }
            _ => rests = true,
        })?;
        self.ends.push((self.letters.len(), rests));
        self.states.push(in_drive_units(p, &simulator.state()));
        Ok(())
    }

    /// Impacts of the last q periods, if the motion nearly returned over these periods.
    fn near_return(&self, q: usize) -> Option<(&[i8], &[f64])> {
        let n = self.ends.len();
        let far = distance(&self.states[n], &self.states[n - q]) > RETURN;
        if far || self.ends[n - q..].iter().any(|end| end.1) {
            return None;
        }
        let first = if n > q { self.ends[n - q - 1].0 } else { 0 };
        (self.letters.len() > first).then(|| (&self.letters[first..], &self.phases[first..]))
    }
}
