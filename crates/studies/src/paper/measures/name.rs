//! Measures by name.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// A coordinate or its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// x1, the box, m.
    X1,
    /// x2, the block, m.
    X2,
    /// x3, the secondary oscillator, m.
    X3,
    /// w = x2 - x1, the block in the box, m.
    W,
    /// The rate of x1, m/s.
    V1,
    /// The rate of x2, m/s.
    V2,
    /// The rate of x3, m/s.
    V3,
    /// The rate of w, m/s.
    Dw,
}

impl Coordinate {
    /// All coordinates, displacements first.
    pub const ALL: [Self; 8] =
        [Self::X1, Self::X2, Self::X3, Self::W, Self::V1, Self::V2, Self::V3, Self::Dw];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        ["x1", "x2", "x3", "w", "v1", "v2", "v3", "dw"][self as usize]
    }

    /// Symbol in pictures.
    pub fn symbol(self) -> &'static str {
        ["x₁", "x₂", "x₃", "w", "x₁′", "x₂′", "x₃′", "w′"][self as usize]
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        if self as usize >= Self::V1 as usize { "m/s" } else { "m" }
    }

    /// Weights of the coordinate at three neighbouring indices of the augmented state, and the
    /// first of these indices: x2 = x1 + w, docs/theory.md (5).
    #[inline(always)]
    pub(super) fn weights(self) -> ([f64; 3], usize) {
        const WEIGHTS: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
        let index = self as usize;
        (WEIGHTS[index % 4], 3 * (index / 4))
    }
}

/// Measure of a settled motion, by name: `"amplitude.x1".parse()`. Serialized as its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Measure {
    /// Largest |q|.
    Amplitude(Coordinate),
    /// √(mean of q²).
    Rms(Coordinate),
    /// Largest minus smallest q.
    PeakToPeak(Coordinate),
    /// Largest q.
    Maximum(Coordinate),
    /// Largest |w'| before an impact, m/s; 0 without impacts.
    ImpactSpeed,
    /// Largest impulse, N·s; 0 without impacts.
    ImpactImpulse,
    /// Impacts per drive period.
    Impacts,
    /// Impacts at the upper stop per drive period.
    ImpactsUpper,
    /// Impacts at the lower stop per drive period.
    ImpactsLower,
    /// Mean power of the drive, W.
    PowerInput,
    /// Mean power lost at impacts, W.
    PowerImpact,
    /// Mean power lost in the box's damper c1, W.
    PowerBoxDamper,
    /// Mean power lost in the secondary oscillator's damper c3, W.
    PowerSecondaryDamper,
    /// The [class](crate::class::MotionClass), a text.
    Class,
    /// Largest Lyapunov exponent besides the zero of the drive's phase, 1/s.
    Exponent,
    /// Amplitude of the box alone, m: [`amplitude_without_block`](super::amplitude_without_block).
    AmplitudeWithoutBlock,
}

/// Measures that exist for each coordinate.
const OF_COORDINATES: [fn(Coordinate) -> Measure; 4] =
    [Measure::Amplitude, Measure::Rms, Measure::PeakToPeak, Measure::Maximum];

/// Measures without a coordinate.
const OTHERS: [Measure; 12] = [
    Measure::ImpactSpeed,
    Measure::ImpactImpulse,
    Measure::Impacts,
    Measure::ImpactsUpper,
    Measure::ImpactsLower,
    Measure::PowerInput,
    Measure::PowerImpact,
    Measure::PowerBoxDamper,
    Measure::PowerSecondaryDamper,
    Measure::Class,
    Measure::Exponent,
    Measure::AmplitudeWithoutBlock,
];

impl Measure {
    /// All measures.
    pub fn all() -> impl Iterator<Item = Self> {
        let of_coordinates =
            OF_COORDINATES.into_iter().flat_map(|kind| Coordinate::ALL.into_iter().map(kind));
        of_coordinates.chain(OTHERS)
    }

    /// Name in tables and on the command line.
    pub fn name(self) -> String {
        let of = |kind: &str, c: Coordinate| format!("{kind}.{}", c.name());
        match self {
            Self::Amplitude(c) => of("amplitude", c),
            Self::Rms(c) => of("rms", c),
            Self::PeakToPeak(c) => of("peak_to_peak", c),
            Self::Maximum(c) => of("maximum", c),
            Self::ImpactSpeed => "impact.speed".into(),
            Self::ImpactImpulse => "impact.impulse".into(),
            Self::Impacts => "impacts".into(),
            Self::ImpactsUpper => "impacts.upper".into(),
            Self::ImpactsLower => "impacts.lower".into(),
            Self::PowerInput => "power.input".into(),
            Self::PowerImpact => "power.impact".into(),
            Self::PowerBoxDamper => "power.box.c".into(),
            Self::PowerSecondaryDamper => "power.secondary.c".into(),
            Self::Class => "class".into(),
            Self::Exponent => "exponent".into(),
            Self::AmplitudeWithoutBlock => "amplitude.without_block".into(),
        }
    }

    /// SI unit; `1` if it has none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Amplitude(c) | Self::Rms(c) | Self::PeakToPeak(c) | Self::Maximum(c) => c.unit(),
            Self::ImpactSpeed => "m/s",
            Self::ImpactImpulse => "N.s",
            Self::Impacts | Self::ImpactsUpper | Self::ImpactsLower | Self::Class => "1",
            Self::PowerInput | Self::PowerImpact | Self::PowerBoxDamper | Self::PowerSecondaryDamper => "W",
            Self::Exponent => "1/s",
            Self::AmplitudeWithoutBlock => "m",
        }
    }

    /// Description in a few words.
    pub fn description(self) -> String {
        let of = |what: &str, c: Coordinate| what.replace('q', c.name());
        match self {
            Self::Amplitude(c) => of("largest |q|", c),
            Self::Rms(c) => of("rms of q", c),
            Self::PeakToPeak(c) => of("peak-to-peak q", c),
            Self::Maximum(c) => of("largest q", c),
            Self::ImpactSpeed => "largest speed of the block relative to the box before an impact".into(),
            Self::ImpactImpulse => "largest impulse of an impact".into(),
            Self::Impacts => "impacts per drive period, at both stops".into(),
            Self::ImpactsUpper => "impacts per drive period at the upper stop".into(),
            Self::ImpactsLower => "impacts per drive period at the lower stop".into(),
            Self::PowerInput => "mean power of the drive".into(),
            Self::PowerImpact => "mean power lost at impacts".into(),
            Self::PowerBoxDamper => "mean power lost in the box's damper".into(),
            Self::PowerSecondaryDamper => "mean power lost in the secondary oscillator's damper".into(),
            Self::Class => "1T, 2T, … (period in drive periods), quasi-periodic, chaotic".into(),
            Self::Exponent => "largest Lyapunov exponent, without the zero exponent of the drive \
                               phase"
                .into(),
            Self::AmplitudeWithoutBlock => "amplitude of the box alone, closed form".into(),
        }
    }

    /// Coordinate needed for the measure, if any.
    pub(super) fn coordinate(self) -> Option<Coordinate> {
        match self {
            Self::Amplitude(c) | Self::Rms(c) | Self::PeakToPeak(c) | Self::Maximum(c) => Some(c),
            Self::PowerBoxDamper => Some(Coordinate::V1),
            Self::PowerSecondaryDamper => Some(Coordinate::V3),
            _ => None,
        }
    }

    /// Whether the measure needs the mean square of its coordinate.
    pub(super) fn needs_square(self) -> bool {
        matches!(self, Self::Rms(_) | Self::PowerBoxDamper | Self::PowerSecondaryDamper)
    }
}

impl std::fmt::Display for Measure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name())
    }
}

impl std::str::FromStr for Measure {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        if let Some(found) = Self::all().find(|m| m.name() == text) {
            return Ok(found);
        }
        let distance = |m: &Self| strsim::damerau_levenshtein(&text.to_lowercase(), &m.name());
        // A name that differs in more than half of its letters is another word.
        let far = (text.chars().count() / 2).max(1);
        let nearest = Self::all().min_by_key(distance).filter(|m| distance(m) <= far);
        let advice = match nearest {
            Some(m) => format!("did you mean `{m}`? `{m}`: {}", m.description()),
            None => format!("expected one of {}", Self::all().map(Self::name).collect::<Vec<_>>().join(", ")),
        };
        Err(Error::UnknownMeasure { name: text.into(), advice })
    }
}

crate::text::written_as_text!(Measure);
