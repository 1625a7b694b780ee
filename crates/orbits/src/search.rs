//! Search for an orbit with a given word or period: stable orbits from settled motions, unstable
//! orbits from motions that pass near them.

use super::orbit::Orbit;
use super::place::{Family, Place, with_signals};
use super::seed::{extents, seed};
use super::wanted::WantedWord;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use vibro_machine::start::BodyStart;
use vibro_machine::{Motion, Start};
use vibro_numerics::sorting::sort_by_key;
use vibro_studies::{Error, Result, significant};
use vibro_studies::{Machine, Section};

/// Largest number of returns tried as a period if no period is given.
const MOST_RETURNS: u32 = 6;
/// Number of returns of each motion; a search for an orbit starts at each return.
const WINDOWS: u32 = 40;
/// Ratio of the box of random starts to the box of the motion from the given start.
const WIDER: f64 = 1.5;
/// Largest number of attempts at a random start between the stops.
const ATTEMPTS: u32 = 50;
/// Relative tolerance for the requested period.
const SAME_PERIOD: f64 = 1e-3;
/// Relative tolerance for a multiple of the drive period.
const WHOLE: f64 = 1e-6;
/// Largest number of other orbits in an error message.
const NAMED: usize = 5;

/// Requested period of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WantedPeriod {
    /// Number of common drive periods.
    Drive(u32),
    /// A time, s.
    Time(f64),
}

/// Request for a search.
#[derive(Clone, Debug)]
pub struct WordSearch {
    /// Start of the first motion.
    pub start: Start,
    /// The word, if one is requested.
    pub word: Option<WantedWord>,
    /// The period, if one is requested.
    pub period: Option<WantedPeriod>,
    /// Number of random starts.
    pub starts: u32,
    /// Returns discarded before the first motion counts as settled.
    pub discard: u32,
}

impl WordSearch {
    /// Cap on the returns of all motions. A search for an orbit starts at each return and first
    /// asks whether to continue.
    pub fn most_returns(&self) -> usize {
        WINDOWS as usize * (1 + self.starts as usize)
    }
}

/// Accepts or rejects the orbits found by a search.
struct Seeker<'a> {
    family: Arc<Family>,
    value: f64,
    place: Place,
    section: Section,
    /// Candidate numbers of returns in a period.
    returns: Vec<u32>,
    request: &'a WordSearch,
    /// Orbits found with another word or period.
    others: Mutex<BTreeSet<String>>,
}

impl Orbit {
    /// An orbit with a given word, a given period, or both. The settled motion is tried first,
    /// then orbits near which the motion from the start or from random starts passes. The search
    /// ends when `go_on` returns false.
    ///
    /// # Errors
    /// [`Error::Described`] for a period that the machine cannot have, and if no orbit is found,
    /// with the other orbits found; otherwise as [`settled`](Self::settled).
    ///
    /// # Examples
    /// At 12 mm a ball on a shaken table no longer settles on the motion with one impact in each
    /// period, but the motion still exists:
    ///
    /// ```
    /// use vibro_orbits::{Orbit, Stability, WantedPeriod, WantedWord, WordSearch};
    /// use vibro_studies::{Machine, Start};
    ///
    /// # let text = r#"
    /// #     name = "Juggler"
    /// #     gravity = 10.0
    /// #     body.table = { motion = { amplitude = "12 mm", frequency = "5 Hz" } }
    /// #     body.ball = { mass = "20 g", gravity = -1.0, start = { v = 1.0 } }
    /// #     stop.table = { between = ["ball", "table"], gap = 0.0, restitution = 0.8 }
    /// # "#;
    /// let machine = Machine::parse(text, "juggler.toml", &vibro_machine::file::no_records)?;
    /// let assembly = vibro_machine::Assembly::new(machine.description.clone())?;
    /// let request = WordSearch {
    ///     start: Start::default(),
    ///     word: Some(WantedWord::parse("impact table", &assembly)?),
    ///     period: Some(WantedPeriod::Drive(1)),
    ///     starts: 20,
    ///     discard: 100,
    /// };
    /// let orbit = Orbit::search(&machine, &request, &|| true)?;
    /// assert_eq!(orbit.stability(), Stability::Unstable);
    /// let speed = orbit.measure(&"impact.speed.table".parse()?)?;
    /// assert!((speed - 10.0 * 0.2 / 1.8).abs() < 1e-12);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn search(
        machine: &Machine,
        request: &WordSearch,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self> {
        let seeker = Seeker::new(machine, request)?;
        let settled = Self::settled(machine, &request.start, request.discard).ok();
        if let Some(found) = settled.filter(|orbit| seeker.accepts(orbit)) {
            return Ok(found);
        }
        let (motion, _) = machine.motion(&request.start)?;
        if let Some(found) = seeker.near(motion.clone(), go_on) {
            return Ok(found);
        }
        let bounds = extents(&mut motion.without_energy_accounts(), &seeker.section, WINDOWS);
        let from = |k: u32| seeker.near(seeker.random(machine, &bounds, k)?, go_on);
        match (0..request.starts).into_par_iter().find_map_first(from) {
            Some(found) => Ok(found),
            None => Err(seeker.failure()),
        }
    }
}

impl<'a> Seeker<'a> {
    fn new(machine: &Machine, request: &'a WordSearch) -> Result<Self> {
        let family = Arc::new(Family::of_one(machine)?);
        let place = Place::new(machine.description.clone())?;
        let refused = |what: String, allowed: &str| {
            Err(Error::Described { problem: format!("period = {what}: expected {allowed}") })
        };
        let (section, returns) = match (place.period, request.period) {
            (Some(period), None) => (Section::Period(period), (1..=MOST_RETURNS).collect()),
            (Some(period), Some(WantedPeriod::Drive(n))) => (Section::Period(period), vec![n]),
            (Some(period), Some(WantedPeriod::Time(time))) => {
                let turns = time / period;
                if turns < 0.5 || (turns - turns.round()).abs() > WHOLE * turns {
                    let allowed =
                        format!("a multiple of the drive's period, {} s, or 2T", significant(period));
                    return refused(format!("{time} s"), &allowed);
                }
                (Section::Period(period), vec![turns.round() as u32])
            }
            (None, Some(WantedPeriod::Drive(n))) => {
                return refused(format!("{n}T"), "a time, such as 0.1s, because nothing drives this machine");
            }
            (None, _) => {
                let section = Section::of(&machine.description, &machine.section)?;
                (section, (1..=MOST_RETURNS).collect())
            }
        };
        let value = family.present()?;
        Ok(Self { family, value, place, section, returns, request, others: Mutex::default() })
    }

    /// Whether an orbit has the requested word and period; an orbit that does not is recorded.
    fn accepts(&self, orbit: &Orbit) -> bool {
        if !orbit.is_certified() || orbit.check_by_motion().is_err() {
            return false;
        }
        let assembly = &orbit.place().assembly;
        let has_word = self.request.word.as_ref().is_none_or(|word| word.is(orbit.word(), assembly));
        let has_period = match (self.request.period, orbit.word().periods) {
            (None, _) => true,
            (Some(_), Some(periods)) => self.returns == [periods],
            (Some(WantedPeriod::Time(time)), None) => (orbit.period() / time - 1.0).abs() < SAME_PERIOD,
            (Some(WantedPeriod::Drive(_)), None) => false,
        };
        if !(has_word && has_period) {
            let period = orbit
                .word()
                .periods
                .map_or_else(|| format!("{} s", significant(orbit.period())), |n| format!("{n}T"));
            let mut others = self.others.lock().unwrap_or_else(PoisonError::into_inner);
            others.insert(format!("{period} [{}]", orbit.word().in_words(assembly)));
        }
        has_word && has_period
    }

    /// An accepted orbit near which a motion passes.
    fn near(&self, motion: Motion, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Orbit> {
        let mut motion = motion.without_energy_accounts();
        for _ in 0..WINDOWS {
            if !go_on() {
                return None;
            }
            self.section.advance(&mut motion, &mut |_| ()).ok()?;
            for returns in &self.returns {
                let mut ahead = motion.clone();
                let Ok(seed) = seed(&self.family, self.value, &mut ahead, &self.section, *returns) else {
                    continue;
                };
                let assembly = motion.assembly();
                let has_word =
                    self.request.word.as_ref().is_none_or(|word| word.is(&seed.problem.word, assembly));
                if !has_word {
                    continue;
                }
                if let Some(found) = Orbit::of_seed(seed).ok().filter(|orbit| self.accepts(orbit)) {
                    return Some(found);
                }
            }
        }
        None
    }

    /// The motion from random start number `k`: a state in the box around the first motion, at a
    /// random phase.
    fn random(&self, machine: &Machine, bounds: &[(f64, f64)], k: u32) -> Option<Motion> {
        let mut seed = u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1);
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        // The first random numbers of adjacent seeds are alike.
        for _ in 0..3 {
            uniform();
        }
        let d = &machine.description;
        let system = self.place.assembly.system();
        let of = &system.bodies_of;
        let in_series = d.springs.iter().filter(|spring| spring.series.is_some());
        let sliders: Vec<String> = in_series.map(|spring| spring.name.clone()).collect();
        for _ in 0..ATTEMPTS {
            let mut number = |i: usize| {
                let (least, largest) = bounds.get(i).copied()?;
                let (middle, half) = (0.5 * (least + largest), 0.5 * (largest - least));
                Some(middle + WIDER * half * (2.0 * uniform() - 1.0))
            };
            let mut body = |(k, body): (usize, &usize)| {
                let own = BodyStart { s: number(k), v: number(of.len() + k) };
                (d.bodies[*body].name.clone(), own)
            };
            let bodies: BTreeMap<String, BodyStart> = of.iter().enumerate().map(&mut body).collect();
            // The bounds are for elongations; a start has the inner displacements of springs
            // instead.
            let mut z = vec![0.0; system.signals.size];
            for (k, own) in of.iter().enumerate() {
                z[k] = bodies[&d.bodies[*own].name].s.unwrap_or(0.0);
            }
            let first = 2 * of.len();
            (first..first + sliders.len()).for_each(|k| z[k] = number(k).unwrap_or(0.0));
            let time = self.place.period.map_or(0.0, |period| period * uniform());
            with_signals(system, time, &mut z);
            let sliders = sliders.iter().cloned().zip(system.given(&z).split_off(first)).collect();
            if let Ok((motion, _)) = machine.motion(&Start { time, bodies, sliders, ..Start::default() }) {
                return Some(motion);
            }
        }
        None
    }

    fn failure(self) -> Error {
        let word =
            self.request.word.as_ref().map_or(String::new(), |word| format!(" with the events [{word}]"));
        let period = match self.request.period {
            Some(WantedPeriod::Drive(n)) => format!(" of period {n}T"),
            Some(WantedPeriod::Time(time)) => format!(" of period {} s", significant(time)),
            None => String::new(),
        };
        let others = self.others.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut found: Vec<String> = others.into_iter().collect();
        sort_by_key(&mut found, String::len);
        found.truncate(NAMED);
        let found = match found.is_empty() {
            true => "none".into(),
            false => found.join("; "),
        };
        let problem = format!(
            "no orbit{word}{period} was found near the motions from the start and from {} random \
             starts; orbits found: {found}; try another start (--start; start= in Python) or more \
             random starts (--starts; tries= in Python)",
            self.request.starts
        );
        Error::Described { problem }
    }
}
