//! Measures as pictures name them, and the units in which they show them.

use crate::studies::lengths::LengthUnit;
use vibro_analysis::measures::Measure;
use vibro_analysis::{ParameterSet, significant};
use vibro_figures::chart::Axis;

/// A measure in words; tables and commands have its name.
pub(super) fn words(measure: Measure) -> String {
    match measure {
        Measure::Amplitude(c) => format!("amplitude of {}", c.symbol()),
        Measure::Rms(c) => format!("rms of {}", c.symbol()),
        Measure::PeakToPeak(c) => format!("{} peak to peak", c.symbol()),
        Measure::Maximum(c) => format!("largest {}", c.symbol()),
        Measure::ImpactSpeed => "largest impact speed".into(),
        Measure::ImpactImpulse => "largest impulse of an impact".into(),
        Measure::Impacts => "impacts per drive period".into(),
        Measure::ImpactsUpper => "impacts per drive period, upper stop".into(),
        Measure::ImpactsLower => "impacts per drive period, lower stop".into(),
        Measure::PowerInput => "power of the drive".into(),
        Measure::PowerImpact => "power lost at impacts".into(),
        Measure::PowerBoxDamper => "power lost in c₁".into(),
        Measure::PowerSecondaryDamper => "power lost in c₃".into(),
        Measure::Exponent => "largest Lyapunov exponent".into(),
        Measure::AmplitudeWithoutBlock => "amplitude of x₁ without the block".into(),
        Measure::Class => measure.name(),
    }
}

/// The unit in which a picture shows a measure, of which one SI unit has so many.
pub(super) struct Unit {
    factor: f64,
    symbol: String,
}

impl Unit {
    /// Lengths in the unit of the machine's lengths, speeds in that of its speeds, all others in SI.
    pub fn of(set: &ParameterSet, measure: Measure) -> Self {
        let (p, lengths) = (set.parameters(), LengthUnit::of(set));
        match measure.unit() {
            "m" => Self { factor: lengths.per_metre, symbol: lengths.symbol },
            "m/s" => {
                let unit = lengths.of_rates(p.stop_gap * p.drive_frequency);
                Self { factor: unit.per_metre, symbol: format!("{}/s", unit.symbol) }
            }
            "1" => Self { factor: 1.0, symbol: String::new() },
            unit => Self { factor: 1.0, symbol: unit.replace('.', "·") },
        }
    }

    /// How many of this unit a value in the SI unit is.
    pub fn number(&self, si: f64) -> f64 {
        si * self.factor
    }

    /// Its symbol with a space before it, for legends.
    pub fn spaced(&self) -> String {
        if self.symbol.is_empty() { String::new() } else { format!(" {}", self.symbol) }
    }

    /// A value in the SI unit, in words.
    pub fn told(&self, si: f64) -> String {
        format!("{}{}", significant(self.number(si)), self.spaced())
    }

    /// The axis of values in the SI unit.
    pub fn axis(&self, name: &str) -> Axis {
        match self.symbol.as_str() {
            "" => Axis::new(name),
            unit => Axis::new(format!("{name} ({unit})")).times(self.factor),
        }
    }
}
