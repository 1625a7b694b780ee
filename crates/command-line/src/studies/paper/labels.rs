//! Names and units of the paper's parameters and measures in tables and pictures.

use super::lengths::LengthUnit;
use crate::studies::design_sweep::{Labelled, MeasureUnit};
use vibro_figures::canvas::palette::{BLACK, BLOCK, BLUE, BOX, GREY, RELATIVE, SECONDARY};
use vibro_figures::chart::{Axis, Colour};
use vibro_studies::paper::measures::{Coordinate, Measure};
use vibro_studies::paper::{Name, ParameterSet};

impl Labelled for ParameterSet {
    fn symbol(&self, name: &Name) -> String {
        self.symbol(*name)
    }

    fn axis(&self, name: &Name) -> Axis {
        crate::studies::parameter_axis(self, *name, (0.0, 1.0))
    }

    fn shown(&self, name: &Name) -> f64 {
        self.unit(*name).map_or(1.0, |unit| unit.number(1.0))
    }

    fn si_unit(&self, name: &Name) -> String {
        name.unit().into()
    }

    fn symbol_is(&self, name: &Name, value: f64) -> String {
        self.told(*name, value)
    }

    fn caption_but(&self, names: &[Name]) -> String {
        self.caption_but(names)
    }

    fn caption_of_all(&self, _: &[Name]) -> Option<String> {
        None
    }

    fn words(measure: &Measure) -> String {
        words(*measure)
    }

    fn measure_unit(&self, measure: &Measure) -> &'static str {
        measure.unit()
    }

    fn measure_shown(&self, measure: &Measure) -> MeasureUnit {
        unit_of(self, *measure)
    }

    fn is_class(measure: &Measure) -> bool {
        *measure == Measure::Class
    }

    fn is_closed_form(measure: &Measure) -> bool {
        *measure == Measure::AmplitudeWithoutBlock
    }

    /// Colour of the measure's body.
    fn colour(&self, measure: &Measure) -> Colour {
        use Coordinate::{Dw, V1, V2, V3, W, X1, X2, X3};
        match measure {
            Measure::Amplitude(c) | Measure::Rms(c) | Measure::PeakToPeak(c) | Measure::Maximum(c) => match c
            {
                X1 | V1 => BOX,
                X2 | V2 => BLOCK,
                X3 | V3 => SECONDARY,
                W | Dw => RELATIVE,
            },
            Measure::PowerBoxDamper => BOX,
            Measure::PowerSecondaryDamper => SECONDARY,
            Measure::PowerImpact | Measure::ImpactSpeed | Measure::ImpactImpulse => RELATIVE,
            Measure::ImpactsUpper => BLUE,
            Measure::ImpactsLower => BLOCK,
            Measure::AmplitudeWithoutBlock => GREY,
            _ => BLACK,
        }
    }

    fn periods() -> &'static str {
        "drive periods"
    }
}

/// A measure in words, for pictures.
fn words(measure: Measure) -> String {
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

/// The unit of the machine's lengths for a length, the unit of its speeds for a speed, and SI
/// for all other measures.
fn unit_of(set: &ParameterSet, measure: Measure) -> MeasureUnit {
    let (p, lengths) = (set.parameters(), LengthUnit::of(set));
    match measure.unit() {
        "m" => MeasureUnit { factor: lengths.per_metre, symbol: lengths.symbol },
        "m/s" => {
            let unit = lengths.of_rates(p.stop_gap * p.drive_frequency);
            MeasureUnit { factor: unit.per_metre, symbol: format!("{}/s", unit.symbol) }
        }
        "1" => MeasureUnit { factor: 1.0, symbol: String::new() },
        unit => MeasureUnit { factor: 1.0, symbol: unit.replace('.', "·") },
    }
}
