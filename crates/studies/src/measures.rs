//! Measures of a described machine's settled motion, by the names of its bodies and elements.
//!
//! Extrema and mean squares come from the flow's series, not from samples, as in
//! [`crate::paper::measures`]. Losses in dashpots, compliant stops and friction, and the work of
//! loads, are the engine's accounts; an impact on a rigid stop loses ½ (1 - ε) u P.

use super::flight::Flows;
use super::quantity::QuantityName;
use super::returns::ReturnRecord;
use super::section::Section;
use super::settled::settled;
use super::timescales::{Passed, needed, runs_on};
use super::watch::Watcher;
use crate::error::{Error, Result};
use crate::measured::{Measured, is_drifting, spread_of};
use crate::windows::{Observation, Parts, whole};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use vibro_machine::description::{Description, Dimension, StopLaw};
use vibro_machine::elements::Action;
use vibro_machine::refusal::advice;
use vibro_machine::system::Part;
use vibro_machine::{Assembly, Element, Motion, Quantity};

/// Number of counted returns for the exponent.
const EXPONENT_RETURNS: u32 = 400;

/// Measure by name. Serialized as its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Measure {
    /// Largest |q|: `amplitude.box.s`.
    Amplitude(QuantityName),
    /// √(mean of q²): `rms.box.a`.
    Rms(QuantityName),
    /// Largest minus smallest q: `peak_to_peak.box.s`.
    PeakToPeak(QuantityName),
    /// Largest q: `maximum.buffer.f`.
    Maximum(QuantityName),
    /// Impacts and first touches of a stop, or of all stops, from one return to the next:
    /// `impacts.steel`, `impacts`.
    Impacts(Option<String>),
    /// Impacts and first touches per second: `impact.rate.steel`, `impact.rate`.
    ImpactRate(Option<String>),
    /// Largest closing speed of a stop: `impact.speed.steel`.
    ImpactSpeed(String),
    /// Largest impulse of a rigid stop: `impact.impulse.steel`.
    ImpactImpulse(String),
    /// Mean power that a spring's dashpot, a stop or a friction element loses, or that a load
    /// supplies: `power.mount`.
    Power(String),
    /// Mean power lost in all elements: `power.lost`.
    PowerLost,
    /// The [class](crate::class::MotionClass), a text.
    Class,
    /// The largest Lyapunov exponent, 1/s.
    Exponent,
}

/// A kind of measure of a quantity: its word and its constructor.
type OfQuantity = (&'static str, fn(QuantityName) -> Measure);

const OF_QUANTITIES: [OfQuantity; 4] = [
    ("amplitude", Measure::Amplitude),
    ("rms", Measure::Rms),
    ("peak_to_peak", Measure::PeakToPeak),
    ("maximum", Measure::Maximum),
];

impl FromStr for Measure {
    type Err = Error;

    /// Parses a name; [`Measure::check`] checks that a machine has the body or element.
    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        for (word, kind) in OF_QUANTITIES {
            if let Some(rest) = text.strip_prefix(word).and_then(|rest| rest.strip_prefix('.')) {
                return Ok(kind(rest.parse()?));
            }
        }
        let plain = |name: &str| name.rsplit('.').next().unwrap_or(name).to_owned();
        let after = |word: &str| text.strip_prefix(word).and_then(|rest| rest.strip_prefix('.')).map(plain);
        match text {
            "impacts" => return Ok(Self::Impacts(None)),
            "impact.rate" => return Ok(Self::ImpactRate(None)),
            "power.lost" => return Ok(Self::PowerLost),
            "class" => return Ok(Self::Class),
            "exponent" => return Ok(Self::Exponent),
            _ => {}
        }
        let of = |word: &str, kind: fn(String) -> Self| after(word).map(kind);
        of("impacts", |name| Self::Impacts(Some(name)))
            .or_else(|| of("impact.rate", |name| Self::ImpactRate(Some(name))))
            .or_else(|| of("impact.speed", Self::ImpactSpeed))
            .or_else(|| of("impact.impulse", Self::ImpactImpulse))
            .or_else(|| of("power", Self::Power))
            .ok_or_else(|| Error::Described {
                problem: format!(
                    "no output is named `{text}`; expected amplitude.Q, rms.Q, peak_to_peak.Q or \
                     maximum.Q of a quantity Q such as box.s or buffer.f; impacts, impact.rate, \
                     each alone or with .STOP; impact.speed.STOP, impact.impulse.STOP; \
                     power.ELEMENT, power.LOAD, power.lost; class; exponent"
                ),
            })
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Amplitude(q) => write!(f, "amplitude.{q}"),
            Self::Rms(q) => write!(f, "rms.{q}"),
            Self::PeakToPeak(q) => write!(f, "peak_to_peak.{q}"),
            Self::Maximum(q) => write!(f, "maximum.{q}"),
            Self::Impacts(None) => f.write_str("impacts"),
            Self::Impacts(Some(stop)) => write!(f, "impacts.{stop}"),
            Self::ImpactRate(None) => f.write_str("impact.rate"),
            Self::ImpactRate(Some(stop)) => write!(f, "impact.rate.{stop}"),
            Self::ImpactSpeed(stop) => write!(f, "impact.speed.{stop}"),
            Self::ImpactImpulse(stop) => write!(f, "impact.impulse.{stop}"),
            Self::Power(name) => write!(f, "power.{name}"),
            Self::PowerLost => f.write_str("power.lost"),
            Self::Class => f.write_str("class"),
            Self::Exponent => f.write_str("exponent"),
        }
    }
}

crate::text::written_as_text!(Measure);

/// The elements that take or give energy.
fn with_power(d: &Description) -> impl Iterator<Item = Element<'_>> {
    d.elements().filter(|element| element.action() != Action::Tying)
}

/// Index of a stop by its name.
fn stop(d: &Description, name: &str) -> Option<usize> {
    d.stops.iter().position(|s| s.name == name)
}

impl Measure {
    /// The quantity behind the measure, if there is one.
    pub fn quantity(&self) -> Option<&QuantityName> {
        match self {
            Self::Amplitude(q) | Self::Rms(q) | Self::PeakToPeak(q) | Self::Maximum(q) => Some(q),
            _ => None,
        }
    }

    /// Checks that a machine has the bodies and elements of the name.
    ///
    /// # Errors
    /// [`Error::Described`] with the nearest name.
    pub fn check(&self, d: &Description) -> Result<()> {
        if let Some(quantity) = self.quantity() {
            return quantity.find(d).map(drop);
        }
        let (what, name, known): (_, &str, Vec<String>) = match self {
            Self::Impacts(Some(name)) | Self::ImpactRate(Some(name)) | Self::ImpactSpeed(name) => {
                ("stop", name, d.stops.iter().map(|s| s.name.clone()).collect())
            }
            Self::ImpactImpulse(name) => {
                let rigid = d.stops.iter().filter(|s| matches!(s.law, StopLaw::Rigid { .. }));
                ("rigid stop", name, rigid.map(|s| s.name.clone()).collect())
            }
            Self::Power(name) => {
                let all = with_power(d).map(|element| element.name().to_owned());
                ("element with a power", name, all.collect())
            }
            _ => return Ok(()),
        };
        if known.iter().any(|k| k == name) {
            return Ok(());
        }
        let advice = advice(name, known.iter().map(String::as_str));
        Err(Error::Described { problem: format!("{self}: no {what} is called `{name}`; {advice}") })
    }

    /// SI unit; `1` where there is none.
    pub fn unit(&self, d: &Description) -> &'static str {
        let of_stop = |name: &str, units: [&'static str; 2]| {
            let rotates = stop(d, name).is_some_and(|i| d.stops[i].arms.dimension == Dimension::Rotation);
            units[usize::from(rotates)]
        };
        match self {
            Self::ImpactSpeed(name) => of_stop(name, ["m/s", "rad/s"]),
            Self::ImpactImpulse(name) => of_stop(name, ["N.s", "N.m.s"]),
            Self::ImpactRate(_) | Self::Exponent => "1/s",
            Self::Power(_) | Self::PowerLost => "W",
            Self::Impacts(_) | Self::Class => "1",
            other => other.quantity().and_then(|q| q.find(d).ok()).map_or("1", |found| found.unit),
        }
    }

    /// Default measures of a machine: amplitudes of free bodies, impacts and closing speeds, power
    /// lost, class.
    pub fn usual(d: &Description) -> Vec<Self> {
        use vibro_machine::description::BodyKind;
        let free = d
            .bodies
            .iter()
            .filter(|b| !b.is_inner() && matches!(b.kind, BodyKind::Free(_) | BodyKind::Node(_)));
        let amplitude = |name: &str| format!("amplitude.{name}.s").parse();
        let mut all: Vec<Self> = free.filter_map(|b| amplitude(&b.name).ok()).collect();
        if !d.stops.is_empty() {
            all.push(Self::Impacts(None));
        }
        all.extend(d.stops.iter().map(|s| Self::ImpactSpeed(s.name.clone())));
        all.extend([Self::PowerLost, Self::Class]);
        all
    }

    /// All measures of a machine.
    pub fn all(d: &Description) -> Vec<Self> {
        let quantities: Vec<QuantityName> =
            d.named_quantities().iter().filter_map(|q| q.name.parse().ok()).collect();
        let mut all: Vec<Self> =
            OF_QUANTITIES.iter().flat_map(|(_, kind)| quantities.iter().cloned().map(kind)).collect();
        all.extend([Self::Impacts(None), Self::ImpactRate(None)]);
        for s in &d.stops {
            let name = || s.name.clone();
            all.extend([
                Self::Impacts(Some(name())),
                Self::ImpactRate(Some(name())),
                Self::ImpactSpeed(name()),
            ]);
            if matches!(s.law, StopLaw::Rigid { .. }) {
                all.push(Self::ImpactImpulse(name()));
            }
        }
        all.extend(with_power(d).map(|element| Self::Power(element.name().to_owned())));
        all.extend([Self::PowerLost, Self::Class, Self::Exponent]);
        all
    }

    /// Description in a few words.
    pub fn description(&self) -> String {
        match self {
            Self::Amplitude(q) => format!("largest |{q}|"),
            Self::Rms(q) => format!("root mean square of {q}"),
            Self::PeakToPeak(q) => format!("peak-to-peak {q}"),
            Self::Maximum(q) => format!("largest {q}"),
            Self::Impacts(None) => "impacts and first touches of all stops per period".into(),
            Self::Impacts(Some(stop)) => format!("impacts or first touches of {stop} per period"),
            Self::ImpactRate(None) => "impacts and first touches of all stops per second".into(),
            Self::ImpactRate(Some(stop)) => format!("impacts or first touches of {stop} per second"),
            Self::ImpactSpeed(stop) => format!("largest closing speed of {stop}"),
            Self::ImpactImpulse(stop) => format!("largest impulse of {stop}"),
            Self::Power(name) => format!("mean power that {name} dissipates, or supplies if it is a load"),
            Self::PowerLost => "mean power dissipated in all elements".into(),
            Self::Class => "1T, 2T, … (period in returns to the section), quasi-periodic, chaotic".into(),
            Self::Exponent => "largest Lyapunov exponent".into(),
        }
    }

    /// Whether the measure is computed from the window; false for the class and the exponent.
    pub(super) fn is_of_window(&self) -> bool {
        !matches!(self, Self::Class | Self::Exponent)
    }

    fn needs_power(&self) -> bool {
        matches!(self, Self::Power(_) | Self::PowerLost)
    }

    /// Whether the measure is an extreme of its window instead of a mean.
    fn is_extreme(&self) -> bool {
        matches!(
            self,
            Self::Amplitude(_)
                | Self::PeakToPeak(_)
                | Self::Maximum(_)
                | Self::ImpactSpeed(_)
                | Self::ImpactImpulse(_)
        )
    }
}

/// Observation of a part of the window.
#[derive(Clone, Debug)]
struct Window {
    watcher: Watcher,
    returns: f64,
    duration: f64,
    /// Work of loads; losses in dashpots, compliant stops, friction elements, and in the dashpots
    /// and sliders in series with springs, J.
    energies: [Vec<f64>; 5],
}

/// The engine's accounts now.
fn energies(motion: &Motion) -> [Vec<f64>; 5] {
    let e = motion.energy();
    let all = [&e.loads, &e.dashpots, &e.stops, &e.frictions, &e.branches];
    all.map(|all| all.iter().map(|x| x.value()).collect())
}

impl Observation for Window {
    fn numbers(&self) -> [Vec<f64>; 3] {
        let ends = self.watcher.extents.iter().flat_map(|e| [e.least, e.largest]);
        let speeds = self.watcher.contacts.iter().map(|c| c.speed);
        [ends.collect(), speeds.collect(), self.energies.iter().flatten().copied().collect()]
    }

    fn join(&mut self, later: &Self) {
        self.watcher.join(&later.watcher);
        for (own, of) in self.energies.iter_mut().flatten().zip(later.energies.iter().flatten()) {
            *own += of;
        }
        self.returns += later.returns;
        self.duration += later.duration;
    }
}

impl Window {
    fn number(&self, measure: &Measure, assembly: &Assembly, quantities: &[&QuantityName]) -> f64 {
        let (d, system) = (&assembly.description, assembly.system());
        let [loads, dashpots, stops, frictions, branches] = &self.energies;
        let number = match measure {
            Measure::Power(name) => {
                let parts = d.elements().position(|element| element.name() == name).map(|i| &system.parts[i]);
                let energy = |part: &Part| match *part {
                    Part::Spring(i) => dashpots[i],
                    Part::Stop(i) => stops[i] + self.watcher.contacts[i].lost,
                    Part::Friction(i) => frictions[i],
                    Part::Branch(i) => branches[i],
                    Part::Load(i) => loads[i],
                };
                parts.into_iter().flatten().map(energy).sum::<f64>() / self.duration
            }
            Measure::PowerLost => {
                let smooth: f64 = [dashpots, stops, frictions, branches].into_iter().flatten().sum();
                let impacts: f64 = self.watcher.contacts.iter().map(|c| c.lost).sum();
                (smooth + impacts) / self.duration
            }
            other => {
                let times = (self.returns, self.duration);
                self.watcher.number(other, d, quantities, times).unwrap_or(0.0)
            }
        };
        // An empty sum is -0; adding 0 makes it +0.
        number + 0.0
    }
}

impl Watcher {
    /// Value of a measure over a number of returns and a duration, s. The extents belong to
    /// `quantities`. `None` for powers, the class and the exponent, which are not observed here.
    pub fn number(
        &self,
        measure: &Measure,
        d: &Description,
        quantities: &[&QuantityName],
        (returns, duration): (f64, f64),
    ) -> Option<f64> {
        let extent = |q: &QuantityName| {
            let place = quantities.iter().position(|own| *own == q);
            place.map(|k| &self.extents[k])
        };
        let of =
            |q: &QuantityName, value: &dyn Fn(&super::watch::Extent) -> f64| extent(q).map_or(0.0, value);
        let contacts = |name: &String| stop(d, name).map(|i| self.contacts[i]).unwrap_or_default();
        let count = |name: &Option<String>| match name {
            Some(name) => f64::from(contacts(name).count),
            None => self.contacts.iter().map(|c| f64::from(c.count)).sum(),
        };
        let number = match measure {
            Measure::Amplitude(q) => of(q, &|e| e.largest.max(-e.least)),
            Measure::Rms(q) => of(q, &|e| (e.square / duration).sqrt()),
            Measure::PeakToPeak(q) => of(q, &|e| e.largest - e.least),
            Measure::Maximum(q) => of(q, &|e| e.largest),
            Measure::Impacts(name) => count(name) / returns,
            Measure::ImpactRate(name) => count(name) / duration,
            Measure::ImpactSpeed(name) => contacts(name).speed,
            Measure::ImpactImpulse(name) => contacts(name).impulse,
            Measure::Power(_) | Measure::PowerLost | Measure::Class | Measure::Exponent => return None,
        };
        // An empty sum is -0; adding 0 makes it +0.
        Some(number + 0.0)
    }
}

/// Measures a motion over the next `periods` returns, or over more if the machine's slowest own
/// oscillation needs them. Class and exponent are measured over the returns after these. A motion
/// that repeats is followed only until the returns show this. The caller has discarded the
/// transient.
///
/// # Errors
/// As [`Section::advance`]; [`Error::Described`] for names that the machine does not have, for
/// returns so short that the window would need a hundred times as many, and for the class of a
/// motion whose drive does not repeat.
pub fn measure(
    motion: &mut Motion,
    section: &Section,
    measures: &[Measure],
    periods: u32,
) -> Result<Measured> {
    let assembly = motion.assembly().clone();
    let d = &assembly.description;
    measures.iter().try_for_each(|m| m.check(d))?;
    let mut quantities: Vec<&QuantityName> = Vec::new();
    for quantity in measures.iter().filter_map(Measure::quantity) {
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
    }
    let places = quantities.iter().map(|q| Ok(q.find(d)?.quantity)).collect::<Result<Vec<_>>>()?;
    let wants = |sought: &Measure| measures.contains(sought);
    let verdict = [Measure::Class, Measure::Exponent].into_iter().find(wants);
    if let (Some(verdict), Some(why)) = (&verdict, runs_on(d, motion.time())) {
        return Err(Error::Described {
            problem: format!(
                "{verdict}: {why}, but `{verdict}` requires loads that repeat; use other outputs"
            ),
        });
    }
    let (parts, drifts) = windows(motion, section, &places, periods.max(1))?;
    let window = whole(&parts);
    let (mut class, mut exponent) = (None, None);
    if verdict.is_some() {
        let found = settled(motion, section, wants(&Measure::Exponent).then_some(EXPONENT_RETURNS))?;
        class = wants(&Measure::Class).then_some(found.class);
        exponent = found.exponent;
    }
    let number = |m: &Measure| match m {
        Measure::Class => None,
        Measure::Exponent => exponent.map(|e| e.value),
        other => Some(window.number(other, &assembly, &quantities)),
    };
    let of_parts = |m: &Measure| -> Vec<f64> {
        parts.iter().map(|part| part.number(m, &assembly, &quantities)).collect()
    };
    let spread = |m: &Measure| match m {
        Measure::Class => 0.0,
        Measure::Exponent => exponent.map_or(0.0, |e| e.error),
        _ => spread_of(&of_parts(m), m.is_extreme()),
    };
    let is_unsettled = |m: &Measure| m.is_of_window() && is_drifting(&of_parts(m));
    Ok(Measured {
        numbers: measures.iter().map(number).collect(),
        class,
        spreads: measures.iter().map(spread).collect(),
        unsettled: measures.iter().position(is_unsettled).or(drifts.then_some(measures.len())),
    })
}

/// Observes the next returns in parts. Also returns whether the motion drifts.
fn windows(
    motion: &mut Motion,
    section: &Section,
    quantities: &[Quantity],
    periods: u32,
) -> Result<(Vec<Window>, bool)> {
    let stops = motion.mode().stops.len();
    let mut watcher = Watcher::of(quantities, stops);
    let (mut flows, mut parts) = (Flows::default(), Parts::new());
    let mut passed = Passed::new(motion, needed(motion, section, periods)?, periods);
    let mut record = ReturnRecord::new(motion, section);
    record.arrive(motion, true);
    loop {
        let (from, before) = (motion.time(), energies(motion));
        watcher.clear();
        section.follow(motion, &mut flows, &mut [&mut watcher])?;
        record.arrive(motion, true);
        let mut energies = energies(motion);
        for (after, before) in energies.iter_mut().flatten().zip(before.iter().flatten()) {
            *after -= before;
        }
        let duration = motion.time() - from;
        let repeats = parts.push(Window { watcher: watcher.clone(), returns: 1.0, duration, energies });
        if passed.is_enough(motion, (watcher.events, repeats))? {
            return Ok((parts.finish(), record.drifts()));
        }
    }
}

/// Whether any of some measures needs the engine's energy accounts.
pub(super) fn need_accounts(measures: &[Measure]) -> bool {
    measures.iter().any(Measure::needs_power)
}
