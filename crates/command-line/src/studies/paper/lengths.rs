//! The display unit of lengths and speeds in pictures: units of L, or SI if the machine was given
//! in SI.

use vibro_figures::chart::Axis;
use vibro_studies::paper::{Name, ParameterSet};

/// Gap, in m, below which lengths are shown in mm unless the gap was written in another unit.
const SMALL_GAP: f64 = 0.1;
/// Numbers from this value on are shown in a larger unit of rate.
const LARGE_RATE: f64 = 500.0;

/// A unit of length: number of units per metre, and symbol.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::studies) struct LengthUnit {
    pub per_metre: f64,
    pub symbol: String,
}

impl LengthUnit {
    /// The written unit of the gap; mm for a gap below [`SMALL_GAP`] written in m or without a
    /// unit.
    pub fn of(set: &ParameterSet) -> Self {
        let written = Name::find("stop.gap").ok().and_then(|gap| set.unit(gap));
        match written.map(|unit| (unit.number(1.0), unit.symbol())) {
            Some((per_metre, symbol)) if symbol != "m" => Self { per_metre, symbol },
            _ if set.parameters().stop_gap < SMALL_GAP => Self { per_metre: 1e3, symbol: "mm".into() },
            _ => Self { per_metre: 1.0, symbol: "m".into() },
        }
    }

    /// The unit of length for rates up to `speed`, m/s: a larger unit if the numbers would be
    /// large.
    pub fn of_rates(&self, speed: f64) -> Self {
        let larger =
            [(1e3, "mm"), (1.0, "m")].map(|(per_metre, symbol)| Self { per_metre, symbol: symbol.into() });
        let mut units =
            std::iter::once(self.clone()).chain(larger.into_iter().filter(|u| u.per_metre < self.per_metre));
        let fits = |unit: &Self| unit.per_metre * speed < LARGE_RATE || unit.per_metre <= 1.0;
        units.find(fits).unwrap_or_else(|| self.clone())
    }
}

/// Display of lengths, whose data are in units of L, and of rates, whose data are in units of L
/// ω10.
#[derive(Clone, Debug)]
pub(in crate::studies) struct Lengths {
    /// Unit shown; `None` for units of L.
    unit: Option<LengthUnit>,
    /// L in m.
    gap: f64,
    /// L ω10 in m/s.
    speed: f64,
}

impl Lengths {
    /// Lengths in SI if the machine was given in SI, otherwise in units of L.
    pub fn of(set: &ParameterSet) -> Self {
        let p = set.parameters();
        let unit = set.is_si().then(|| LengthUnit::of(set));
        Self { unit, gap: p.stop_gap, speed: p.stop_gap * p.box_frequency() }
    }

    /// Axis of lengths over its data; [`Self::displacements`] and [`Self::amplitude`] give its
    /// name.
    pub fn axis(&self, name: &str) -> Axis {
        match &self.unit {
            None => Axis::new(format!("{name} (units of L)")),
            Some(u) => Axis::new(format!("{name} ({})", u.symbol)).times(u.per_metre * self.gap),
        }
    }

    /// Axis of lengths over a range of the data.
    pub fn axis_over(&self, name: &str, from: f64, to: f64) -> Axis {
        Axis { range: Some((from, to)), ..self.axis(name) }
    }

    /// Axis of the rates of displacements with the symbols U, W, X₁, ….
    pub fn rates(&self, symbols: &[&str]) -> Axis {
        let time = if self.unit.is_some() { "t" } else { "τ" };
        let rate = |s: &&str| format!("d{}/d{time}", self.displacement(s));
        let name = symbols.iter().map(rate).collect::<Vec<_>>().join(", ");
        match &self.unit {
            None => Axis::new(format!("{name} (units of L)")),
            Some(unit) => {
                let u = unit.of_rates(self.speed);
                Axis::new(format!("{name} ({}/s)", u.symbol)).times(u.per_metre * self.speed)
            }
        }
    }

    /// Name of the displacement with the symbol U, W, X₁, …; in SI u, w, x₁, ….
    pub fn displacement(&self, symbol: &str) -> String {
        if self.unit.is_some() { symbol.to_lowercase() } else { symbol.into() }
    }

    /// Names of displacements, joined.
    pub fn displacements(&self, symbols: &[&str]) -> String {
        symbols.iter().map(|s| self.displacement(s)).collect::<Vec<_>>().join(", ")
    }

    /// Name of the amplitude with the dimensionless symbol B, C, A₁, …; in SI times L.
    pub fn amplitude(&self, symbol: &str) -> String {
        if self.unit.is_some() { format!("{symbol}·L") } else { symbol.into() }
    }

    /// Factor of lengths in units of L for a machine whose parameter `name` is `value` instead of
    /// the set's value. In SI it converts units of that machine's gap to units of the set's gap.
    pub fn ratio(&self, name: Name, value: f64) -> f64 {
        if self.unit.is_some() && name.name() == "stop.gap" { value / self.gap } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_lengths_are_in_the_unit_of_the_gap() {
        let mut set = ParameterSet::basic();
        assert_eq!(Lengths::of(&set).axis("C").label, "C (units of L)");
        set.apply(&["box.k=4 kN/m", "box.m=1000 g", "stop.gap=5000 um"]).unwrap();
        let lengths = Lengths::of(&set);
        let (axis, rates) = (lengths.axis(&lengths.amplitude("C")), lengths.rates(&["W", "X₁"]));
        assert_eq!((axis.label.as_str(), rates.label.as_str()), ("C·L (µm)", "dw/dt, dx₁/dt (mm/s)"));
        // Factors of L = 5000 µm, and of L ω10 = 5 mm · sqrt(4000)/s.
        let close = |a: Option<f64>, b: f64| (a.unwrap() / b - 1.0).abs() < 1e-12;
        assert!(close(axis.factor, 5000.0) && close(rates.factor, 5.0 * 4000.0_f64.sqrt()));
        let gap = Name::find("L").unwrap();
        assert!(close(Some(lengths.ratio(gap, 0.01)), 2.0));
        assert_eq!(lengths.ratio(Name::find("f10").unwrap(), 0.01), 1.0);
        set.apply(&["L=0.02"]).unwrap();
        assert_eq!(LengthUnit::of(&set).symbol, "µm");
        let mut plain = ParameterSet::basic();
        plain.apply(&["L=0.02"]).unwrap();
        assert_eq!(LengthUnit::of(&plain).symbol, "mm");
        // A small gap written in m: lengths in mm, and speeds of about 1 m/s in m/s.
        plain.apply(&["stop.gap=0.015m"]).unwrap();
        let unit = LengthUnit::of(&plain);
        assert_eq!((unit.symbol.as_str(), unit.of_rates(0.2).symbol.as_str()), ("mm", "mm"));
        assert_eq!(unit.of_rates(1.01), LengthUnit { per_metre: 1.0, symbol: "m".into() });
        plain.apply(&["stop.gap=1.5 m"]).unwrap();
        assert_eq!(LengthUnit::of(&plain).of_rates(1e9).symbol, "m");
    }
}
