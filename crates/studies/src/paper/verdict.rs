//! Verdict on a motion, which is followed until it is decided or a given limit is reached.
//!
//! A motion with a period is decided at once. A motion whose largest exponent is certainly
//! positive or zero is chaotic or quasi-periodic up to its present end; the caller decides whether
//! its window is long enough. All other motions are prolonged, twice as far each time, since a
//! transient or a slow approach comes to an end. A motion that is undecided at the limit is *not
//! settled*, not an attractor. See docs/theory.md, "When a verdict is decided".

use super::attractor::{Attractor, StroboscopicRecord};
use super::free_limit::is_damped;
use super::free_motion::{self, keeps_clear};
use super::settling::LEAST_APPROACH;
use super::statistics::{Blocks, Likeness};
use super::trajectories::{MotionEnd, Program, Start, Workspace};
use crate::class::{MotionClass, OBSERVED, SAME};
use crate::error::Result;
use crate::exponent::LargestExponent;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, Way};

/// Cap on the drive periods of a motion after the discarded ones. The last of the growing steps
/// may exceed it.
pub const PROLONGED: u32 = 8192;
/// Cap on the drive periods of one computation of the largest exponent.
pub const EXPONENT_PERIODS: u32 = 4000;
/// Required duration of chaos, in drive periods, without another condition.
pub(crate) const LASTS: u32 = 4 * OBSERVED;

/// Shortest window, in drive periods, whose means may describe an attractor: 8 blocks of 128.
const WINDOW: u32 = 1024;

/// Upper limit for the return (units of L and L ω10) of a motion that has arrived. At a thousandth
/// of its way per period it has a thousand such returns left, less than the distance of two
/// attractors.
const ARRIVED: f64 = 1e-7;
/// A motion that seems quasi-periodic is a spiral onto an orbit if its nearest return falls below
/// the first fraction while the exponent is counted (thousands of drive periods), and below the
/// second one in each later window. Next to a resonance returns on a torus fall too, for half of
/// its slow time. The fractions were chosen on 221 tori: both conditions were met at none of
/// 20,553 places on them, and on none of 190 other tori.
const FALLS: [f64; 2] = [0.1, 0.97];
/// Number of windows with a falling nearest return, after the exponent.
const FALLEN: u32 = 3;
/// Drive periods after which a damped motion without impacts has reached its limit.
const FAR: u32 = 1 << 22;

/// Options for following motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Following {
    /// Drive periods discarded first.
    pub(crate) discard: u32,
    /// Cap on the drive periods for the largest exponent; `None` without the exponent.
    pub(crate) exponent: Option<u32>,
    /// Largest number of drive periods after the discarded ones; 0 for a single observation.
    pub(crate) limit: u32,
}

impl Default for Following {
    fn default() -> Self {
        Self { discard: 0, exponent: Some(EXPONENT_PERIODS), limit: PROLONGED }
    }
}

/// Motion up to its present end.
#[derive(Clone, Debug)]
pub struct Followed {
    /// Class of the motion.
    pub class: MotionClass,
    /// The attractor, with means over the whole window if it has no period.
    pub attractor: Attractor,
    /// Largest exponent besides the zero of the drive's phase, if there are impacts and no period.
    pub exponent: Option<LargestExponent>,
    /// Drive periods over which it has been followed since its class last changed.
    pub periods: u32,
    /// Whether the window since the means last changed is long enough to compare other motions
    /// with them.
    pub stationary: bool,
}

impl Followed {
    /// Whether the motion has no period: chaotic or on a torus.
    pub(crate) fn wanders(&self) -> bool {
        matches!(self.class, MotionClass::Chaotic | MotionClass::QuasiPeriodic)
    }
}

/// Motion whose verdict is open.
struct Open {
    number: usize,
    start: Start,
    found: Followed,
    /// Window of a motion without a period since its class last changed, and its impacts.
    blocks: Blocks,
    impacts: [f64; 2],
    rests: bool,
    arrived: bool,
    nearest: Option<f64>,
    /// Number of windows since the exponent, if the nearest return [fell](FALLS) in each of them;
    /// otherwise `None`.
    falls: Option<u32>,
    /// Total number of drive periods followed.
    followed: u32,
}

/// Follows motions on this thread until all are decided. `judge` is called, with the index among
/// the starts, for each motion that has a period, that reached the limit, or that wanders and has
/// doubled its window. It returns whether that suffices. In the last call (`true`) its answer is
/// ignored. The order of the calls does not depend on other work of the thread.
pub(crate) fn follow(
    workspace: &mut Workspace,
    starts: &[Start],
    following: &Following,
    judge: &mut dyn FnMut(usize, Result<&Followed>, bool) -> bool,
) {
    let program = Program {
        discard: following.discard,
        until_settled: true,
        observed: true,
        exponent: following.exponent,
        maxima: None,
    };
    let mut open: Vec<Open> = Vec::new();
    for (number, outcome) in outcomes(workspace, starts, &program).into_iter().enumerate() {
        match outcome {
            Ok(seen) => {
                let start = Start { state: seen.state, ..starts[number] };
                let mut motion = Open::new(number, start, seen);
                if !motion.is_decided(following, judge) {
                    open.push(motion);
                }
            }
            Err(refused) => {
                judge(number, Err(refused), true);
            }
        }
    }
    while !open.is_empty() {
        for mut motions in alike(std::mem::take(&mut open)) {
            let wanders = motions[0].found.wanders();
            let length = motions[0].followed.max(OBSERVED);
            let program = if wanders {
                Program { observed: true, ..Program::default() }
            } else {
                Program { discard: length, ..program }
            };
            let starts: Vec<Start> = motions.iter().map(|motion| motion.start).collect();
            for (motion, outcome) in motions.iter_mut().zip(outcomes(workspace, &starts, &program)) {
                match outcome {
                    Ok(seen) => motion.take(seen, program.discard),
                    Err(refused) => {
                        judge(motion.number, Err(refused), true);
                        motion.followed = u32::MAX;
                    }
                }
            }
            open.extend(motions);
        }
        open.retain(|motion| motion.followed < u32::MAX);
        open.sort_by_key(|motion| motion.number);
        open.retain_mut(|motion| !motion.is_decided(following, judge));
    }
}

/// Groups motions that are prolonged in the same way: wandering motions, and other motions by the
/// number of periods followed.
fn alike(motions: Vec<Open>) -> Vec<Vec<Open>> {
    let kind = |m: &Open| (m.found.wanders(), if m.found.wanders() { 0 } else { m.followed });
    let mut groups: Vec<Vec<Open>> = Vec::new();
    for motion in motions {
        match groups.iter_mut().find(|group| kind(&group[0]) == kind(&motion)) {
            Some(group) => group.push(motion),
            None => groups.push(vec![motion]),
        }
    }
    groups
}

/// Result of a program run for one motion.
struct ProgramResult {
    state: vibro_impact::State,
    attractor: Attractor,
    exponent: Option<LargestExponent>,
    /// Whether a periodic motion returns so exactly that no slow approach is left, or stays clear
    /// of the stops.
    arrived: bool,
    /// Whether it is proved that no impact will follow.
    clear: bool,
    /// Nearest return of a motion without a period that has impacts until the end.
    nearest: Option<f64>,
    blocks: Blocks,
}

/// Whether returns after a period are so exact that no slow approach is left.
pub(crate) fn has_arrived(record: &StroboscopicRecord, period: u32, p: &Parameters) -> bool {
    record.return_distance(period) < ARRIVED && has_no_part(record, period, p)
}

/// Whether a period is not caused by an approach from alternating sides. On such an approach
/// states nearly return after twice the orbit's period. For a symmetric orbit they nearly return
/// after its period, but not after half of it (an odd period) with the mirror image.
fn has_no_part(record: &StroboscopicRecord, period: u32, p: &Parameters) -> bool {
    let own = record.return_distance(period);
    let half = record.mirror_distance(period);
    let mirrored = p.is_symmetric() && !period.is_multiple_of(2) && half >= SAME;
    let mut parts = (1..period).filter(|part| period.is_multiple_of(*part));
    parts.all(|part| own < LEAST_APPROACH * record.return_distance(part))
        && (!mirrored || own < LEAST_APPROACH * half)
}

/// Results in the order of the starts.
fn outcomes(workspace: &mut Workspace, starts: &[Start], program: &Program) -> Vec<Result<ProgramResult>> {
    let mut found: Vec<Option<Result<ProgramResult>>> = starts.iter().map(|_| None).collect();
    workspace.run(&mut starts.iter().copied(), program, &mut |number, outcome| {
        found[number] = Some(outcome.map(|MotionEnd { state, attractor, exponent, record, .. }| {
            let mut blocks = Blocks::default();
            // Every motion of such a program is observed.
            let p = &starts[number].parameters;
            let mut attractor = attractor.unwrap_or_else(|| record.attractor(p));
            let clear = attractor.is_free() && keeps_clear(p, &state);
            if attractor.period.is_none() && clear {
                // No impact will follow. If the linear motion is damped, it has one limit;
                // otherwise it still moves at that time.
                let mut far = StroboscopicRecord::default();
                if free_motion::observe(p, &state, FAR, &mut far).is_some() {
                    attractor = far.attractor(p);
                }
            }
            let arrived = clear || attractor.period.is_some_and(|n| has_arrived(record, n, p));
            let mut nearest = None;
            if attractor.period.is_none() {
                record.add_to(&mut blocks);
                nearest = record.nearest_return();
            }
            ProgramResult { state, attractor, exponent, arrived, clear, nearest, blocks }
        }));
    });
    // Each motion has a result.
    found.into_iter().flatten().collect()
}

impl Open {
    fn new(number: usize, start: Start, seen: ProgramResult) -> Self {
        let class = MotionClass::by_largest(&seen.attractor, seen.exponent.as_ref(), &start.parameters);
        let (impacts, rests) = (seen.attractor.impacts, seen.attractor.rests);
        let periods = seen.blocks.periods();
        let found = Followed {
            class,
            attractor: seen.attractor,
            exponent: seen.exponent,
            periods,
            stationary: false,
        };
        let ProgramResult { arrived, blocks, nearest, .. } = seen;
        let falls = (class == MotionClass::QuasiPeriodic).then_some(0);
        let mut motion = Self {
            number,
            start,
            found,
            impacts,
            rests,
            blocks,
            arrived,
            nearest,
            falls,
            followed: OBSERVED,
        };
        motion.impacts = motion.impacts.map(|rate| rate * f64::from(periods));
        motion
    }

    /// Takes the result of a run over `discarded` more drive periods and an observation.
    fn take(&mut self, mut seen: ProgramResult, discarded: u32) {
        let followed = self.followed.saturating_add(discarded).saturating_add(OBSERVED);
        self.start.state = seen.state;
        let ended = seen.clear && is_damped(&self.start.parameters);
        if !self.found.wanders() || seen.attractor.period.is_some() || ended {
            // On a torus next to a resonance returns fall within most windows, but not from each
            // window to the next.
            seen.attractor.approaching &=
                seen.nearest.zip(self.nearest).is_none_or(|(now, before)| now < before);
            // The motion so far was a transient.
            *self = Self { followed, ..Self::new(self.number, self.start, seen) };
            return;
        }
        let periods = f64::from(seen.blocks.periods());
        for (sum, rate) in self.impacts.iter_mut().zip(seen.attractor.impacts) {
            *sum += rate * periods;
        }
        self.rests |= seen.attractor.rests;
        self.blocks.append(seen.blocks);
        self.found.periods = self.blocks.periods();
        self.found.attractor = seen.attractor;
        self.followed = followed;
        let fallen = |falls: &u32| {
            let part = FALLS[usize::from(*falls > 0)];
            seen.nearest.zip(self.nearest).is_some_and(|(now, before)| now < part * before)
        };
        self.falls = self.falls.filter(fallen).map(|falls| falls + 1);
        self.nearest = seen.nearest;
        if self.falls == Some(FALLEN) {
            self.found.class = MotionClass::Settling;
        }
    }

    /// Shows the motion to the judge if its verdict may have changed. Returns whether it is
    /// finished.
    fn is_decided(
        &mut self,
        following: &Following,
        judge: &mut dyn FnMut(usize, Result<&Followed>, bool) -> bool,
    ) -> bool {
        // A possible spiral must be excluded first.
        let asked = self.found.class == MotionClass::QuasiPeriodic && self.falls.is_some();
        let last = self.followed >= following.limit && !asked;
        let has_period = self.found.attractor.period.is_some();
        let periodic = has_period && self.arrived;
        // Windows are compared each time their length has doubled.
        let due = self.found.wanders() && !asked && (self.followed / OBSERVED).is_power_of_two();
        if !(last || periodic || due) {
            return false;
        }
        if has_period && !self.arrived && following.limit > 0 {
            // The motion approaches an orbit of this period or of a part of it, or passes the
            // remnant of a vanished orbit.
            self.found.class = MotionClass::Settling;
        }
        if !has_period {
            let [first, second] = self.blocks.halves();
            if first.likeness(&second) == Likeness::Different {
                // The earlier half was a transient.
                self.blocks.forget_half();
                // Its impacts are estimated from the last periods.
                let periods = f64::from(self.blocks.periods());
                self.impacts = self.found.attractor.impacts.map(|rate| rate * periods);
            }
            self.found.periods = self.blocks.periods();
            let statistics = self.blocks.statistics();
            let count = f64::from(self.blocks.periods().max(1));
            let enough = if last {
                statistics.likeness(&statistics) == Likeness::Same
            } else {
                statistics.is_precise()
            };
            self.found.stationary = enough && self.found.periods >= WINDOW;
            let attractor = &mut self.found.attractor;
            attractor.impacts = self.impacts.map(|sum| sum / count);
            attractor.rests = self.rests;
            attractor.sizes = statistics.sizes();
            attractor.statistics = Some(statistics);
        }
        judge(self.number, Ok(&self.found), last || periodic) || last || periodic
    }
}

/// The verdict on one motion from its start. Chaos and quasi-periodic motion must last for 512
/// drive periods.
///
/// # Errors
/// Error if the simulator refuses the start.
pub fn verdict(start: &Start, discard: u32) -> Result<Followed> {
    let mut workspace = Workspace::default();
    workspace.way = Way::OneByOne;
    let following = Following { discard, ..Following::default() };
    let mut found = None;
    follow(&mut workspace, std::slice::from_ref(start), &following, &mut |_, motion, _| {
        let enough = motion.as_ref().is_ok_and(|motion| motion.periods >= LASTS);
        found = Some(motion.cloned());
        enough
    });
    match found {
        Some(found) => found,
        // A single start has a result unless the simulator refuses it.
        None => Err(match Simulator::new(&start.parameters, &start.state, 0.0) {
            Err(refused) => refused.into(),
            Ok(_) => crate::error::Error::Form { text: "a motion".into(), expected: "an outcome" },
        }),
    }
}

#[cfg(test)]
mod tests;
