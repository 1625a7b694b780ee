//! Names and units of parameters and measures in tables and pictures of a sweep.

use crate::subject::Subject;
use crate::wording::{self, with_unit};
use vibro_figures::canvas::palette::CURVES;
use vibro_figures::chart::{Axis, Colour};
use vibro_studies::design_sweep::DesignMachine;
use vibro_studies::significant;

/// A machine with names, units and colours of its parameters and measures for tables and pictures.
pub trait Labelled: DesignMachine + Subject {
    /// A parameter's symbol in pictures.
    fn symbol(&self, name: &Self::Name) -> String;
    /// A parameter's axis, over the range of the data.
    fn axis(&self, name: &Self::Name) -> Axis;
    /// Factor from SI to a parameter's unit of display.
    fn shown(&self, name: &Self::Name) -> f64;
    /// A parameter's SI unit.
    fn si_unit(&self, name: &Self::Name) -> String;
    /// A value of a parameter with its symbol: `L = 4 mm`.
    fn symbol_is(&self, name: &Self::Name, value: f64) -> String;
    /// The machine's parameters in one line, except `names`.
    fn caption_but(&self, names: &[Self::Name]) -> String;
    /// One-line description of the machine with varying parameters `names`; `None` if the
    /// machine's own caption is right for it.
    fn caption_of_all(&self, names: &[Self::Name]) -> Option<String>;
    /// Description of a measure.
    fn words(measure: &Self::Measure) -> String;
    /// A measure in the words of pictures.
    fn measure_words(&self, measure: &Self::Measure) -> String {
        Self::words(measure)
    }
    /// Axis of a measure, with these words, for data in SI.
    fn measure_axis(&self, measure: &Self::Measure, words: &str) -> Axis {
        self.measure_shown(measure).axis(words)
    }
    /// A parameter in the words of titles.
    fn parameter_words(&self, name: &Self::Name) -> String {
        self.symbol(name)
    }
    /// The beginning of titles: the machine's name; empty for the paper's machine.
    fn title(&self) -> String {
        String::new()
    }
    /// A measure's SI unit; `1` if it has none.
    fn measure_unit(&self, measure: &Self::Measure) -> &'static str;
    /// A measure's unit of display in pictures.
    fn measure_shown(&self, measure: &Self::Measure) -> MeasureUnit;
    /// Whether a measure is a text, not a number.
    fn is_class(measure: &Self::Measure) -> bool;
    /// Whether a measure does not depend on the motion.
    fn is_closed_form(measure: &Self::Measure) -> bool;
    /// Colour of a measure.
    fn colour(&self, measure: &Self::Measure) -> Colour;
    /// Name of the counted periods.
    fn periods() -> &'static str;
}

/// Gaps below this, m, make all lengths of a sweep be shown in mm.
const SMALL: f64 = 0.1;
impl Labelled for vibro_studies::Machine {
    fn symbol(&self, name: &String) -> String {
        name.clone()
    }

    fn axis(&self, name: &String) -> Axis {
        let (factor, symbol) = self.unit(name);
        Axis::over(with_unit(&wording::parameter(name), &symbol), 0.0, 1.0).times(factor)
    }

    fn shown(&self, name: &String) -> f64 {
        self.unit(name).0
    }

    fn si_unit(&self, name: &String) -> String {
        self.si_unit(name).into()
    }

    fn symbol_is(&self, name: &String, value: f64) -> String {
        format!("{name} = {}", self.told(name, value))
    }

    fn caption_but(&self, names: &[String]) -> String {
        format!("as in the file of {}", self.caption_of_all(names).unwrap_or_else(|| self.caption()))
    }

    fn caption_of_all(&self, names: &[String]) -> Option<String> {
        let is_frequency = |name: &String| self.si_unit(name) == "Hz" || name.ends_with(".repeat");
        let section = vibro_studies::Section::of(&self.description, &self.section);
        let varies = self.section == vibro_studies::SectionRule::Auto
            && matches!(section, Ok(vibro_studies::Section::Period(_)))
            && names.iter().any(is_frequency);
        let name = self.name_with_changes();
        let what = crate::subject::periodic_parts(&self.description);
        varies.then(|| format!("{name}, sampled once per common period of its {what}, which varies"))
    }

    fn words(measure: &vibro_studies::Measure) -> String {
        match measure {
            vibro_studies::Measure::Power(name) => format!("mean power of {name}"),
            other => other.description(),
        }
    }

    fn measure_words(&self, measure: &vibro_studies::Measure) -> String {
        wording::measure(&self.description, measure)
    }

    fn measure_axis(&self, measure: &vibro_studies::Measure, words: &str) -> Axis {
        let unit = self.measure_shown(measure);
        Axis::new(with_unit(words, &unit.symbol)).times(unit.factor)
    }

    fn parameter_words(&self, name: &String) -> String {
        wording::parameter(name)
    }

    fn title(&self) -> String {
        format!("{}: ", wording::title(&self.description.name))
    }

    fn measure_unit(&self, measure: &vibro_studies::Measure) -> &'static str {
        measure.unit(&self.description)
    }

    fn measure_shown(&self, measure: &vibro_studies::Measure) -> MeasureUnit {
        let gaps = self.description.stops.iter().map(|s| s.gap.abs());
        let small = gaps.fold(0.0, f64::max) < SMALL;
        match self.measure_unit(measure) {
            "m" if small => MeasureUnit { factor: 1e3, symbol: "mm".into() },
            "1" => MeasureUnit { factor: 1.0, symbol: String::new() },
            unit => MeasureUnit { factor: 1.0, symbol: wording::symbol(unit) },
        }
    }

    fn is_class(measure: &vibro_studies::Measure) -> bool {
        *measure == vibro_studies::Measure::Class
    }

    fn is_closed_form(_: &vibro_studies::Measure) -> bool {
        false
    }

    fn colour(&self, measure: &vibro_studies::Measure) -> Colour {
        let all = vibro_studies::Measure::all(&self.description);
        let of = |m: &vibro_studies::Measure| m.to_string().rsplit('.').next().map(str::to_owned);
        let body = measure.quantity().map(|q| q.of.clone()).or_else(|| of(measure));
        let bodies = self.description.bodies.iter().map(|b| &b.name);
        let names: Vec<&String> = bodies.chain(self.description.stops.iter().map(|s| &s.name)).collect();
        let place = names.iter().position(|name| Some(*name) == body.as_ref());
        let place = place.or_else(|| all.iter().position(|m| m == measure)).unwrap_or(0);
        CURVES[place % CURVES.len()]
    }

    fn periods() -> &'static str {
        "periods"
    }
}

/// A measure's unit of display in pictures, with its factor from SI.
#[derive(Clone, Debug)]
pub struct MeasureUnit {
    /// Factor from SI.
    pub factor: f64,
    /// Symbol; empty for a plain number.
    pub symbol: String,
}

impl MeasureUnit {
    /// A value in this unit, from one in SI.
    pub fn number(&self, si: f64) -> f64 {
        si * self.factor
    }

    /// Symbol with a space before it, for legends.
    pub fn spaced(&self) -> String {
        if self.symbol.is_empty() { String::new() } else { format!(" {}", self.symbol) }
    }

    /// Text of a value, given in SI, with this unit.
    pub fn told(&self, si: f64) -> String {
        format!("{}{}", significant(self.number(si)), self.spaced())
    }

    /// Axis in this unit for data in SI.
    pub fn axis(&self, name: &str) -> Axis {
        match self.symbol.as_str() {
            "" => Axis::new(name),
            unit => Axis::new(format!("{name} ({unit})")).times(self.factor),
        }
    }
}
