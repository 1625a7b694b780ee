//! Numbers with units, as files and command lines write them: `48 kN/m`, `5 mm`, `600 rpm`.
//!
//! A dimension is named by its SI unit, with points for products and plain digits for powers:
//! `N.s/m`, `kg.m2`. On input `·`, `*` or a space may replace a point, `µ` a `u`, and `m²` or
//! `m^2` an `m2`.

use std::f64::consts::PI;

/// Unit of a dimension. A number in this unit, times `times` and divided by `over`, is the value
/// in the SI unit. There are two factors because a double cannot represent a thousandth exactly,
/// while division by 1000 rounds only once.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// SI unit of the dimension.
    pub si: &'static str,
    /// Symbol in files and on the command line.
    pub symbol: &'static str,
    times: f64,
    over: f64,
}

const fn unit(si: &'static str, symbol: &'static str, times: f64, over: f64) -> Unit {
    Unit { si, symbol, times, over }
}

impl Unit {
    /// Converts a number in this unit to the SI unit.
    pub fn si(&self, number: f64) -> f64 {
        number * self.times / self.over
    }

    /// Whether numbers in this unit equal numbers in the SI unit.
    pub fn is_si(&self) -> bool {
        self.times == self.over
    }

    /// Converts a value in the SI unit to a number in this unit.
    ///
    /// ```
    /// use vibro_numerics::quantities::quantity_in;
    ///
    /// let unit = quantity_in("m", "5 mm").and_then(|gap| gap.unit).expect("a length");
    /// assert_eq!((unit.number(0.005), unit.symbol()), (5.0, "mm".into()));
    /// ```
    pub fn number(&self, si: f64) -> f64 {
        si * self.over / self.times
    }

    /// Symbol in labels.
    pub fn symbol(&self) -> String {
        let symbol = self.symbol.replace('.', "·").replace("um", "µm");
        // Digits of a symbol are exponents, but for the 1 of 1/s.
        let raised = |c: char| match c {
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            c => c,
        };
        symbol.chars().map(raised).collect()
    }

    /// Symbol in files and on the command line.
    pub fn plain(&self) -> &'static str {
        self.symbol
    }

    /// Whether this unit counts revolutions, while the SI unit of angular frequency counts
    /// radians.
    pub fn counts_revolutions(&self) -> bool {
        ["Hz", "mHz", "kHz", "rpm", "1/min"].contains(&self.symbol)
    }
}

/// An inch in m, and a pound-force in N: 0.45359237 kg times the standard acceleration of gravity.
const INCH: f64 = 0.0254;
const POUND_FORCE: f64 = 0.453_592_37 * 9.806_65;

/// All known units, the SI unit of each dimension first. The dimension `rad/s` is for angular
/// frequencies and velocities, with a hertz as one revolution per second. The dimension `Hz` is
/// for frequencies that count cycles. Numbers without a dimension have the unit `1`.
#[rustfmt::skip]
pub static UNITS: [Unit; 158] = [
    unit("kg", "kg", 1.0, 1.0), unit("kg", "g", 1.0, 1e3), unit("kg", "mg", 1.0, 1e6), unit("kg", "t", 1e3, 1.0),
    unit("kg", "lb", 0.453_592_37, 1.0),
    unit("N/m", "N/m", 1.0, 1.0), unit("N/m", "N/mm", 1e3, 1.0), unit("N/m", "kN/m", 1e3, 1.0),
    unit("N/m", "kN/mm", 1e6, 1.0), unit("N/m", "MN/m", 1e6, 1.0), unit("N/m", "N/cm", 1e2, 1.0),
    unit("N/m", "N/um", 1e6, 1.0), unit("N/m", "GN/m", 1e9, 1.0), unit("N/m", "lbf/in", POUND_FORCE, INCH),
    unit("N.s/m", "N.s/m", 1.0, 1.0), unit("N.s/m", "kN.s/m", 1e3, 1.0), unit("N.s/m", "N.s/mm", 1e3, 1.0),
    unit("N.s/m", "kg/s", 1.0, 1.0), unit("N.s/m", "N/(m/s)", 1.0, 1.0),
    unit("m", "m", 1.0, 1.0), unit("m", "cm", 1.0, 1e2), unit("m", "mm", 1.0, 1e3), unit("m", "um", 1.0, 1e6),
    unit("m", "in", INCH, 1.0),
    unit("1", "1", 1.0, 1.0), unit("1", "%", 1.0, 1e2),
    unit("N", "N", 1.0, 1.0), unit("N", "mN", 1.0, 1e3), unit("N", "kN", 1e3, 1.0), unit("N", "MN", 1e6, 1.0),
    unit("N", "lbf", POUND_FORCE, 1.0),
    unit("rad/s", "rad/s", 1.0, 1.0), unit("rad/s", "1/s", 1.0, 1.0), unit("rad/s", "Hz", 2.0 * PI, 1.0),
    unit("rad/s", "mHz", 2.0 * PI, 1e3), unit("rad/s", "kHz", 2e3 * PI, 1.0), unit("rad/s", "rpm", PI, 30.0),
    unit("rad/s", "1/min", PI, 30.0), unit("rad/s", "deg/s", PI, 180.0),
    unit("rad", "rad", 1.0, 1.0), unit("rad", "mrad", 1.0, 1e3), unit("rad", "deg", PI, 180.0),
    unit("rad", "°", PI, 180.0),
    unit("s", "s", 1.0, 1.0), unit("s", "ms", 1.0, 1e3), unit("s", "us", 1.0, 1e6), unit("s", "min", 60.0, 1.0),
    unit("s", "h", 3600.0, 1.0),
    unit("m/s", "m/s", 1.0, 1.0), unit("m/s", "cm/s", 1.0, 1e2), unit("m/s", "mm/s", 1.0, 1e3),
    unit("m/s2", "m/s2", 1.0, 1.0), unit("m/s2", "mm/s2", 1.0, 1e3), unit("m/s2", "cm/s2", 1.0, 1e2),
    unit("m/s2", "g", 9.806_65, 1.0),
    unit("rad/s2", "rad/s2", 1.0, 1.0), unit("rad/s2", "1/s2", 1.0, 1.0), unit("rad/s2", "deg/s2", PI, 180.0),
    unit("Hz", "Hz", 1.0, 1.0), unit("Hz", "mHz", 1.0, 1e3), unit("Hz", "kHz", 1e3, 1.0), unit("Hz", "MHz", 1e6, 1.0),
    unit("Hz", "rpm", 1.0, 60.0), unit("Hz", "1/min", 1.0, 60.0), unit("Hz", "rad/s", 1.0, 2.0 * PI),
    unit("kg.m2", "kg.m2", 1.0, 1.0), unit("kg.m2", "kg.cm2", 1.0, 1e4), unit("kg.m2", "kg.mm2", 1.0, 1e6),
    unit("kg.m2", "g.m2", 1.0, 1e3), unit("kg.m2", "g.cm2", 1.0, 1e7), unit("kg.m2", "g.mm2", 1.0, 1e9),
    unit("kg.m2", "t.m2", 1e3, 1.0),
    unit("N.m", "N.m", 1.0, 1.0), unit("N.m", "mN.m", 1.0, 1e3), unit("N.m", "kN.m", 1e3, 1.0),
    unit("N.m", "MN.m", 1e6, 1.0), unit("N.m", "N.cm", 1.0, 1e2), unit("N.m", "N.mm", 1.0, 1e3),
    unit("N.m/rad", "N.m/rad", 1.0, 1.0), unit("N.m/rad", "mN.m/rad", 1.0, 1e3),
    unit("N.m/rad", "kN.m/rad", 1e3, 1.0), unit("N.m/rad", "MN.m/rad", 1e6, 1.0),
    unit("N.m/rad", "N.mm/rad", 1.0, 1e3), unit("N.m/rad", "N.m/deg", 180.0, PI),
    unit("N.m/rad", "kN.m/deg", 180e3, PI),
    unit("N.m.s/rad", "N.m.s/rad", 1.0, 1.0), unit("N.m.s/rad", "mN.m.s/rad", 1.0, 1e3),
    unit("N.m.s/rad", "kN.m.s/rad", 1e3, 1.0), unit("N.m.s/rad", "N.mm.s/rad", 1.0, 1e3),
    unit("N.m.s/rad", "N.m.s/deg", 180.0, PI),
    unit("1/m", "1/m", 1.0, 1.0), unit("1/m", "rad/m", 1.0, 1.0), unit("1/m", "1/mm", 1e3, 1.0),
    unit("1/m", "rad/mm", 1e3, 1.0),
    // Coefficients of curved springs and dashpots.
    unit("N/m2", "N/m2", 1.0, 1.0), unit("N/m2", "kN/m2", 1e3, 1.0),
    unit("N/m2", "MN/m2", 1e6, 1.0), unit("N/m2", "N/mm2", 1e6, 1.0),
    unit("N/m3", "N/m3", 1.0, 1.0), unit("N/m3", "kN/m3", 1e3, 1.0),
    unit("N/m3", "MN/m3", 1e6, 1.0), unit("N/m3", "N/mm3", 1e9, 1.0),
    unit("N/m4", "N/m4", 1.0, 1.0), unit("N/m4", "kN/m4", 1e3, 1.0),
    unit("N/m4", "MN/m4", 1e6, 1.0), unit("N/m4", "N/mm4", 1e12, 1.0),
    unit("N/m5", "N/m5", 1.0, 1.0), unit("N/m5", "kN/m5", 1e3, 1.0),
    unit("N/m5", "MN/m5", 1e6, 1.0), unit("N/m5", "N/mm5", 1e15, 1.0),
    unit("N.m/rad2", "N.m/rad2", 1.0, 1.0), unit("N.m/rad2", "kN.m/rad2", 1e3, 1.0),
    unit("N.m/rad2", "Nm/rad2", 1.0, 1.0),
    unit("N.m/rad3", "N.m/rad3", 1.0, 1.0), unit("N.m/rad3", "kN.m/rad3", 1e3, 1.0),
    unit("N.m/rad3", "Nm/rad3", 1.0, 1.0),
    unit("N.m/rad4", "N.m/rad4", 1.0, 1.0), unit("N.m/rad4", "kN.m/rad4", 1e3, 1.0),
    unit("N.m/rad4", "Nm/rad4", 1.0, 1.0),
    unit("N.m/rad5", "N.m/rad5", 1.0, 1.0), unit("N.m/rad5", "kN.m/rad5", 1e3, 1.0),
    unit("N.m/rad5", "Nm/rad5", 1.0, 1.0),
    unit("N.s3/m3", "N.s3/m3", 1.0, 1.0), unit("N.m.s3/rad3", "N.m.s3/rad3", 1.0, 1.0),
    // Coefficients of powers whose exponent need not be an integer: `N/mp` is for any exponent p.
    unit("N/m1.5", "N/m1.5", 1.0, 1.0), unit("N/m1.5", "kN/m1.5", 1e3, 1.0),
    unit("N/m1.5", "MN/m1.5", 1e6, 1.0), unit("N/m1.5", "GN/m1.5", 1e9, 1.0),
    unit("N/m2.5", "N/m2.5", 1.0, 1.0), unit("N/m2.5", "kN/m2.5", 1e3, 1.0),
    unit("N/m2.5", "MN/m2.5", 1e6, 1.0), unit("N/mp", "N/mp", 1.0, 1.0),
    unit("N.m/rad1.5", "N.m/rad1.5", 1.0, 1.0), unit("N.m/rad2.5", "N.m/rad2.5", 1.0, 1.0),
    unit("N.m/radp", "N.m/radp", 1.0, 1.0), unit("N.s2/m2", "N.s2/m2", 1.0, 1.0),
    unit("N.s2/m2", "kg/m", 1.0, 1.0), unit("N.m.s2/rad2", "N.m.s2/rad2", 1.0, 1.0),
    unit("N.sp/mp", "N.sp/mp", 1.0, 1.0), unit("N.m.sp/radp", "N.m.sp/radp", 1.0, 1.0),
    unit("s/m", "s/m", 1.0, 1.0), unit("s/m", "s/mm", 1e3, 1.0), unit("s/rad", "s/rad", 1.0, 1.0),
    // Symbols without the point of a product.
    unit("N.s/m", "Ns/m", 1.0, 1.0), unit("N.s/m", "kNs/m", 1e3, 1.0), unit("N.s/m", "Ns/mm", 1e3, 1.0),
    unit("N.m", "Nm", 1.0, 1.0), unit("N.m", "mNm", 1.0, 1e3), unit("N.m", "kNm", 1e3, 1.0),
    unit("N.m", "Ncm", 1.0, 1e2), unit("N.m", "Nmm", 1.0, 1e3),
    unit("N.m/rad", "Nm/rad", 1.0, 1.0), unit("N.m/rad", "kNm/rad", 1e3, 1.0), unit("N.m/rad", "Nm/deg", 180.0, PI),
    unit("N.m.s/rad", "Nm.s/rad", 1.0, 1.0), unit("N.m.s/rad", "Nms/rad", 1.0, 1.0),
    unit("N.m.s/rad", "kNm.s/rad", 1e3, 1.0), unit("kg.m2", "kgm2", 1.0, 1.0),
];

/// A number with its unit, as read from a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Value in the SI unit.
    pub value: f64,
    /// Unit in the text, if there was one.
    pub unit: Option<&'static Unit>,
}

/// Splits a text into the number at its beginning and the rest, which may be empty; `None` without
/// a number.
pub fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Some((value, ""));
    }
    // Without this check, the beginning of a word such as `nanometre` would be read as NaN.
    if !text.starts_with(|c: char| c.is_ascii_digit() || ['+', '-', '.'].contains(&c)) {
        return None;
    }
    let ends = (1..text.len()).rev().filter(|&end| text.is_char_boundary(end));
    let mut parts = ends.map(|end| text.split_at(end));
    parts.find_map(|(number, rest)| Some((number.trim_end().parse().ok()?, rest.trim())))
}

/// Quantity from a number and a unit's symbol, which may be empty. `None` if the symbol is not a
/// unit of the dimension of `si`.
pub fn in_si(si: &str, number: f64, symbol: &str) -> Option<Quantity> {
    if symbol.is_empty() {
        return Some(Quantity { value: number, unit: None });
    }
    let symbol = plain_symbol(symbol);
    let unit = UNITS.iter().find(|u| u.si == si && u.symbol == symbol)?;
    Some(Quantity { value: unit.si(number), unit: Some(unit) })
}

/// A unit's symbol as [`UNITS`] have it: with dots between factors, and digits as exponents.
///
/// ```
/// use vibro_numerics::quantities::plain_symbol;
///
/// assert_eq!(plain_symbol("kN m²/rad^1.5"), "kN.m2/rad1.5");
/// ```
pub fn plain_symbol(symbol: &str) -> String {
    let plain = |c: char| match c {
        '·' | '*' | ' ' | '⋅' => '.',
        'µ' | 'μ' => 'u',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        c => c,
    };
    symbol.chars().filter(|c| *c != '^').map(plain).collect()
}

/// Parses a number with or without a unit of the dimension of `si`, an SI unit of [`UNITS`].
/// `None` for any other text.
///
/// ```
/// use vibro_numerics::quantities::quantity_in;
///
/// let time = quantity_in("s", "20 ms").expect("a time");
/// assert!(time.value == 0.02 && time.unit.is_some());
/// assert_eq!(quantity_in("s", "20 mm"), None);
/// ```
pub fn quantity_in(si: &str, text: &str) -> Option<Quantity> {
    let (number, symbol) = split(text)?;
    in_si(si, number, symbol)
}

/// Symbols of all units of the dimension of `si`, as in files and on the command line; `si` itself
/// comes first.
///
/// ```
/// let mut masses = vibro_numerics::quantities::symbols("kg");
/// assert_eq!(masses.next(), Some("kg"));
/// assert!(masses.any(|symbol| symbol == "g"));
/// ```
pub fn symbols(si: &str) -> impl Iterator<Item = &'static str> {
    UNITS.iter().filter(move |u| u.si == si).map(|u| u.symbol)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from the definitions of the units, rounded once.
    #[test]
    fn closed_form_units_of_rotation_and_of_gravity() {
        let cases = [
            ("m", "2 in", 0.0508),
            ("kg", "1 lb", 0.45359237),
            ("N", "1 lbf", 4.4482216152605),
            ("N/m", "1 lbf/in", 175.12683524647636),
            ("N/m", "3 N/um", 3e6),
            ("N.s/m", "3 N/(m/s)", 3.0),
            ("m/s2", "2 g", 19.6133),
            ("kg.m2", "3 kg m2", 3.0),
            ("kg.m2", "3 kg m²", 3.0),
            ("kg.m2", "3 kg·m^2", 3.0),
            ("kg.m2", "250 g cm2", 2.5e-5),
            ("N.m", "20 N m", 20.0),
            ("N.m", "20 mNm", 0.02),
            ("N.m/rad", "1 kN m/rad", 1e3),
            ("N.m/rad", "1 N.m/deg", 180.0 / PI),
            ("N.m.s/rad", "5 N m s/rad", 5.0),
            ("m/s2", "9.81 m/s²", 9.81),
            ("Hz", "600 rpm", 10.0),
            ("Hz", "3 rad/s", 3.0 / (2.0 * PI)),
            ("rad/s", "10 Hz", 20.0 * PI),
            ("1/m", "20 rad/m", 20.0),
        ];
        for (si, text, value) in cases {
            assert_eq!(quantity_in(si, text).map(|q| q.value), Some(value), "{text}");
        }
        assert_eq!(quantity_in("N.m", "20 N"), None);
    }

    /// Each symbol has one meaning in a dimension and is not hidden by another spelling.
    #[test]
    fn invariant_every_symbol_reads_as_its_own_unit() {
        for unit in &UNITS {
            let found = quantity_in(unit.si, &format!("1 {}", unit.symbol)).and_then(|q| q.unit);
            assert_eq!(found, Some(unit), "{}", unit.symbol);
            assert_eq!(symbols(unit.si).next(), Some(unit.si), "the SI unit stands first");
        }
    }
}
