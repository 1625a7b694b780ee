//! Operations of curved forces, with their values and derivatives.

use super::Polynomial;

/// An operation on one or two functionals of the state. Its value is a coordinate of the augmented
/// state; a formula is a chain of operations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation {
    /// A polynomial of the first argument.
    Polynomial(Polynomial),
    /// The product of both arguments.
    Product,
    /// A constant power of the first argument. The base is positive; for an exponent that is a
    /// negative integer it is not zero.
    Power(f64),
    /// The power of the first argument where it is positive, otherwise 0; the exponent is greater
    /// than 1.
    OneSided(f64),
    /// sign(a) |a|ᵖ of the first argument a, with an exponent p greater than 1.
    TwoSided(f64),
    /// exp a.
    Exponential,
    /// exp(-|a|). In a mode it is exp a or exp(-a).
    Decay,
    /// ln a, for a > 0.
    Logarithm,
    /// sin a.
    Sine,
    /// cos a.
    Cosine,
    /// tanh a.
    HyperbolicTangent,
    /// atan a.
    Arctangent,
}

/// aᵖ; the powers with an operation of their own in hardware are rounded once or twice.
fn power(a: f64, p: f64) -> f64 {
    match p {
        -2.0 => 1.0 / (a * a),
        -1.0 => 1.0 / a,
        -0.5 => 1.0 / a.sqrt(),
        0.5 => a.sqrt(),
        1.5 => a * a.sqrt(),
        _ => a.powf(p),
    }
}

impl Operation {
    /// Whether the operation depends on the second argument.
    pub fn is_of_two(&self) -> bool {
        *self == Self::Product
    }

    /// Whether the first argument must not pass 0: the base of a power or of a logarithm.
    pub fn has_domain(&self) -> bool {
        match self {
            Self::Power(p) => *p < 0.0 || p.fract() != 0.0,
            Self::Logarithm => true,
            _ => false,
        }
    }

    /// Whether the operation is defined at a value of its first argument.
    pub fn is_defined(&self, a: f64) -> bool {
        match self {
            Self::Power(p) if p.fract() == 0.0 => *p >= 0.0 || a != 0.0,
            _ => !self.has_domain() || a > 0.0,
        }
    }

    /// The first argument of an operation with a domain, in words.
    pub(crate) fn argument(&self) -> String {
        match self {
            Self::Power(p) if p.fract() == 0.0 => "the divisor".into(),
            Self::Power(0.5) => "the argument of sqrt".into(),
            Self::Power(p) => format!("the base of the power {p:?}"),
            Self::Logarithm => "the argument of ln".into(),
            _ => String::new(),
        }
    }

    /// The operation of an argument outside its domain, and the requirement, in words.
    pub(crate) fn undefined(&self, a: f64) -> String {
        let (found, least) = match self {
            Self::Power(p) if p.fract() == 0.0 => (format!("a division by {a:?}"), "must not be 0"),
            Self::Power(0.5) => (format!("sqrt({a:?})"), "must be greater than 0"),
            Self::Power(p) => (format!("({a:?})^{p:?}"), "must be greater than 0"),
            _ => (format!("ln({a:?})"), "must be greater than 0"),
        };
        format!("{found}; {} {least}", self.argument())
    }

    /// Value at the arguments.
    #[inline(always)]
    pub fn value(&self, [a, b]: [f64; 2]) -> f64 {
        match self {
            Self::Polynomial(force) => force.value(a),
            Self::Product => a * b,
            Self::Power(p) => power(a, *p),
            Self::OneSided(p) => power(a.max(0.0), *p),
            Self::TwoSided(p) => power(a.abs(), *p).copysign(a),
            Self::Exponential => a.exp(),
            Self::Decay => (-a.abs()).exp(),
            Self::Logarithm => a.ln(),
            Self::Sine => a.sin(),
            Self::Cosine => a.cos(),
            Self::HyperbolicTangent => a.tanh(),
            Self::Arctangent => a.atan(),
        }
    }

    /// The integral from 0 to a, of a polynomial or of a power with two sides.
    pub fn integral(&self, a: f64) -> f64 {
        match self {
            Self::Polynomial(force) => force.integral(a),
            Self::TwoSided(p) => a.abs().powf(p + 1.0) / (p + 1.0),
            _ => 0.0,
        }
    }

    /// The exponent of a power with an edge at 0.
    pub fn edge(&self) -> Option<f64> {
        match self {
            Self::OneSided(p) | Self::TwoSided(p) => Some(*p),
            _ => None,
        }
    }

    /// Derivatives by both arguments.
    #[inline(always)]
    pub fn slopes(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let slope = match self {
            Self::Polynomial(force) => force.derivative(a),
            Self::Product => return [b, a],
            Self::Power(p) => p * power(a, p - 1.0),
            Self::OneSided(p) => p * power(a.max(0.0), p - 1.0),
            Self::TwoSided(p) => p * power(a.abs(), p - 1.0),
            Self::Exponential => a.exp(),
            Self::Decay if a == 0.0 => 0.0,
            Self::Decay => (-a.abs()).exp().copysign(-a),
            Self::Logarithm => 1.0 / a,
            Self::Sine => a.cos(),
            Self::Cosine => -a.sin(),
            Self::HyperbolicTangent => a.cosh().powi(-2),
            Self::Arctangent => 1.0 / (1.0 + a * a),
        };
        [slope, 0.0]
    }

    /// Second derivatives: by the first argument twice, and by both arguments. The second
    /// derivative by the second argument is 0 for all operations.
    pub fn second_derivatives(&self, [a, _]: [f64; 2]) -> [f64; 2] {
        let by_first = match self {
            Self::Polynomial(force) => force.second_derivative(a),
            Self::Product => return [0.0, 1.0],
            Self::Power(p) => p * (p - 1.0) * power(a, p - 2.0),
            // At the edge the slope is 0, and its derivative may have no limit.
            Self::OneSided(_) if a <= 0.0 => 0.0,
            Self::TwoSided(_) if a == 0.0 => 0.0,
            Self::OneSided(p) | Self::TwoSided(p) => (p * (p - 1.0) * power(a.abs(), p - 2.0)).copysign(a),
            Self::Exponential => a.exp(),
            Self::Decay => (-a.abs()).exp(),
            Self::Logarithm => -1.0 / (a * a),
            Self::Sine => -a.sin(),
            Self::Cosine => -a.cos(),
            Self::HyperbolicTangent => -2.0 * a.tanh() * a.cosh().powi(-2),
            Self::Arctangent => -2.0 * a / (1.0 + a * a).powi(2),
        };
        [by_first, 0.0]
    }

    /// Sizes of the value and of the derivatives, for their relative rounding errors.
    #[inline(always)]
    pub fn sizes(&self, arguments: [f64; 2]) -> (f64, [f64; 2]) {
        if let Self::Polynomial(force) = self {
            let (x, majorant) = (arguments[0].abs(), force.majorant());
            return (majorant.value(x), [majorant.derivative(x), 0.0]);
        }
        (self.value(arguments).abs(), self.slopes(arguments).map(f64::abs))
    }

    /// Largest sizes of the derivatives over real arguments within `radii` of `centres`. Infinite
    /// if the operation is not defined throughout.
    #[inline(always)]
    pub(super) fn steepest(&self, centres: [f64; 2], radii: [f64; 2]) -> [f64; 2] {
        let (a, r) = (centres[0].abs(), radii[0]);
        let (least, most) = ((a - r).max(0.0), a + r);
        if self.has_domain() && least == 0.0 {
            return [f64::INFINITY, 0.0];
        }
        let steepest = match self {
            Self::Polynomial(force) => force.majorant().derivative(most),
            Self::Product => return [centres[1].abs() + radii[1], most],
            Self::OneSided(p) => p * power((centres[0] + r).max(0.0), p - 1.0),
            Self::TwoSided(p) => p * power(most, p - 1.0),
            Self::Power(p) => p.abs() * power(if *p < 1.0 { least } else { most }, p - 1.0),
            Self::Exponential => (centres[0] + r).exp(),
            Self::Decay => (-least).exp(),
            Self::Logarithm => 1.0 / least,
            Self::Sine | Self::Cosine => 1.0,
            Self::HyperbolicTangent => least.cosh().powi(-2),
            Self::Arctangent => 1.0 / (1.0 + least * least),
        };
        [steepest, 0.0]
    }
}
