//! Power series of curved forces, order by order.

use super::recurrence::{self, Coefficients, TERMS};
use super::{LOWEST, Operation, POWERS, Piece, Polynomial};

/// Order of the last term of a series with curved forces. High orders are cheap with vector
/// instructions. The number is fixed, so that every span takes the same operations.
pub const LAST_ORDER: usize = 28;
/// Distance from its edge, relative to the size of its argument, within which a power counts as 0
/// in the choice of a mode: some thousand roundings.
pub const NEAR: f64 = 1e-12;
/// A polynomial with all powers: a coefficient may be 0 and still vary.
const ALL: Polynomial = Polynomial { coefficients: [1.0; POWERS] };

/// Coefficients of the arguments of an operation and of its value, by order.
#[derive(Clone, Copy, Debug)]
pub struct CurveSeries {
    /// First argument.
    x: [f64; TERMS],
    /// Coefficients of x in reverse order, followed by zeros. They let the sum for a product of
    /// two series read both factors in ascending order of memory.
    back: [f64; 2 * TERMS],
    /// For a polynomial: x², …, x⁵. For another operation: second argument, value, slope by the
    /// first argument, and a helper of the recurrence.
    powers: [[f64; TERMS]; POWERS],
    /// The side of the edge, for a power with an edge.
    pub piece: Piece,
    /// Whether the series is used back in time.
    pub backwards: bool,
}

impl Default for CurveSeries {
    fn default() -> Self {
        Self {
            piece: Piece::default(),
            backwards: false,
            x: [0.0; TERMS],
            back: [0.0; 2 * TERMS],
            powers: [[0.0; TERMS]; POWERS],
        }
    }
}

impl CurveSeries {
    /// A series that begins on a side of an edge.
    pub fn beginning(piece: Piece) -> Self {
        Self { piece, ..Self::default() }
    }

    /// Sets the coefficients of order `k` of the arguments, and returns the coefficient of order
    /// `k` of the operation's value. Requires that all lower orders are set.
    #[inline(always)]
    pub fn next(&mut self, operation: &Operation, k: usize, arguments: [f64; 2]) -> f64 {
        match operation {
            Operation::Polynomial(force) => self.next_of_polynomial(force, k, arguments[0]),
            Operation::OneSided(_) | Operation::TwoSided(_) => self.next_of_side(operation, k, arguments[0]),
            Operation::Decay => self.next_of_decay(k, arguments[0]),
            _ => self.next_of_operation((operation, false), k, arguments),
        }
    }

    /// [`next`](Self::next) for a power with an edge, on one side of it.
    #[inline(never)]
    fn next_of_side(&mut self, operation: &Operation, k: usize, x: f64) -> f64 {
        if self.piece == Piece::Whole {
            self.piece = Piece::of(operation, x, 0.0);
        }
        let sign = self.piece.sign();
        match operation.on(self.piece) {
            Operation::Polynomial(force) => sign * self.next_of_polynomial(&force, k, sign * x),
            Operation::Power(p) => {
                sign * self.next_of_operation((&Operation::Power(p), false), k, [sign * x, 0.0])
            }
            _ => {
                self.x[k] = x;
                let [b, w, g, _] = &mut self.powers;
                (b[k], w[k], g[k]) = (0.0, 0.0, 0.0);
                0.0
            }
        }
    }

    /// [`next`](Self::next) for exp(-|x|). If x begins at 0, its first nonzero coefficient has the
    /// side.
    fn next_of_decay(&mut self, k: usize, x: f64) -> f64 {
        if k > 0 && self.piece == Piece::Still && x != 0.0 {
            self.piece = Piece::of(&Operation::Decay, x, 0.0);
        }
        self.next_of_operation((&Operation::Exponential, false), k, [-self.piece.sign() * x, 0.0])
    }

    /// [`next`](Self::next) for an operation other than a polynomial; with `is_majorant`, for the
    /// sizes of its terms.
    #[inline(never)]
    fn next_of_operation(&mut self, of: (&Operation, bool), k: usize, [x, y]: [f64; 2]) -> f64 {
        let [b, w, g, q] = &mut self.powers;
        (self.x[k], b[k]) = (x, y);
        recurrence::next(of, Coefficients { a: &self.x, b }, [w, g, q], k);
        w[k]
    }

    /// [`next`](Self::next) for a polynomial.
    #[inline(always)]
    fn next_of_polynomial(&mut self, force: &Polynomial, k: usize, x: f64) -> f64 {
        self.x[k] = x;
        self.back[TERMS - 1 - k] = x;
        let Some(highest) = force.coefficients.iter().rposition(|c| *c != 0.0) else { return 0.0 };
        let mut sum = 0.0;
        for m in 0..=highest {
            let (known, later) = self.powers.split_at_mut(m);
            let factor = known.last().unwrap_or(&self.x);
            let power = product(factor, &self.back, k);
            later[0][k] = power;
            sum += force.coefficients[m] * power;
        }
        sum
    }

    /// Coefficient of order `k` of another polynomial of x, up to the highest power of the force.
    pub fn at_order(&self, force: &Polynomial, k: usize) -> f64 {
        force.coefficients.iter().zip(&self.powers).map(|(c, power)| c * power[k]).sum()
    }

    /// Sets all powers of the argument of a polynomial at order `k`, also powers whose
    /// coefficients are 0. Other operations are set as by [`next`](Self::next).
    pub fn next_of_all(&mut self, operation: &Operation, k: usize, arguments: [f64; 2]) -> f64 {
        match operation {
            Operation::Polynomial(force) => {
                self.next_of_polynomial(&ALL, k, arguments[0]);
                self.at_order(force, k)
            }
            _ => self.next(operation, k, arguments),
        }
    }

    /// Coefficients of order `k` of the operation's derivatives by both arguments.
    #[inline(always)]
    pub fn slopes(&self, operation: &Operation, k: usize) -> [f64; 2] {
        if self.piece == Piece::Still {
            return [0.0; 2];
        }
        match &operation.on(self.piece) {
            Operation::Polynomial(force) => [self.slope_of_polynomial(force, k), 0.0],
            Operation::Product => [self.powers[0][k], self.x[k]],
            _ => [self.powers[2][k], 0.0],
        }
    }

    /// Coefficients of the first argument, of the second argument, of the value, and of the slope
    /// of an operation other than a polynomial.
    pub(super) fn of_operation(&self) -> [&[f64; TERMS]; 4] {
        let [b, w, g, _] = &self.powers;
        [&self.x, b, w, g]
    }

    /// Coefficient of order `k` of φ'(x).
    fn slope_of_polynomial(&self, force: &Polynomial, k: usize) -> f64 {
        let [c2, c3, c4, c5] = force.coefficients;
        let [square, cube, fourth, _] = &self.powers;
        2.0 * c2 * self.x[k] + 3.0 * c3 * square[k] + 4.0 * c4 * cube[k] + 5.0 * c5 * fourth[k]
    }

    /// The sum Σ |xₖ| partᵏ over the orders from 0 to `last`.
    #[inline(always)]
    pub fn sum_of_sizes(&self, part: f64, last: usize) -> f64 {
        self.x[..=last].iter().rev().fold(0.0, |sum, x| sum * part + x.abs())
    }

    /// The first coefficient of the argument.
    pub fn first(&self) -> f64 {
        self.x[0]
    }

    /// Coefficients of the first argument, of a power with an edge times the sign of its side.
    pub(crate) fn argument(&self) -> [f64; TERMS] {
        self.x
    }

    /// Bound of the largest argument of a power at its edge: of x for a power of one side, of |x|
    /// for others.
    pub(crate) fn highest(&self, operation: &Operation, part: f64) -> f64 {
        if !matches!(operation, Operation::OneSided(_)) {
            return self.x[0].abs() + self.sum_of_sizes_beyond(part);
        }
        // Negative terms only lower the argument: the force of an ending contact is 0 after its
        // edge.
        let mut power = 1.0;
        let terms = self.x[1..=LAST_ORDER].iter().map(|x| {
            power *= if self.backwards { -part } else { part };
            (x * power).max(0.0)
        });
        self.x[0] + terms.sum::<f64>()
    }

    /// Bound of the part of a span, at most `part`, whose argument of a power of one side is
    /// positive.
    pub(crate) fn inside(&self, operation: &Operation, part: f64) -> f64 {
        if !matches!(operation, Operation::OneSided(_)) {
            return part;
        }
        let slope = if self.backwards { -self.x[1] } else { self.x[1] };
        let mut power = 1.0;
        let steeper: f64 = self.x[2..=LAST_ORDER]
            .iter()
            .map(|x| {
                power *= part;
                x.abs() * power
            })
            .sum();
        let falls = -(slope + steeper);
        if falls > 0.0 { part.min(self.x[0].max(0.0) / falls) } else { part }
    }

    /// The sum Σ |xₖ| partᵏ over the orders from 1 to the last one of curved forces.
    pub(crate) fn sum_of_sizes_beyond(&self, part: f64) -> f64 {
        self.sum_of_sizes(part, LAST_ORDER) - self.x[0].abs()
    }

    /// The least C with |xₖ| ≤ C ratio⁻ᵏ for the orders up to `last`.
    #[inline(always)]
    pub fn scale(&self, ratio: f64, last: usize) -> f64 {
        let (mut most, mut power) = (0.0f64, 1.0);
        for x in &self.x[..=last] {
            most = most.max(x.abs() * power);
            power *= ratio;
        }
        most
    }
}

/// Sizes of the terms of an operation's series, for judging their rounding errors. The size is the
/// majorant's series at the sizes of the arguments' terms, plus the series of the majorant's
/// derivatives times the shifts.
#[derive(Clone, Debug)]
pub enum CurveSizes {
    /// The sizes for a power at its edge, which counts as 0.
    Still,
    /// The sizes for a polynomial.
    Polynomial(Box<PolynomialSizes>),
    /// The sizes for another operation.
    Operation {
        /// The operation.
        operation: Operation,
        /// Sizes to which the rounding errors of the arguments at the start are relative.
        shifts: [f64; 2],
        /// The majorant's series.
        series: Box<CurveSeries>,
    },
}

impl CurveSizes {
    /// The sizes for the arguments at the start and for the sizes to which their rounding errors
    /// are relative.
    pub fn of(operation: &Operation, arguments: [f64; 2], shifts: [f64; 2]) -> Self {
        if let Operation::Decay = operation {
            return Self::of(&Operation::Exponential, [-arguments[0].abs(), 0.0], shifts);
        }
        let piece = Piece::of(operation, arguments[0], NEAR * shifts[0]);
        if piece == Piece::Still {
            return Self::Still;
        }
        let operation = &operation.on(piece);
        if let Operation::Polynomial(force) = operation {
            let own = PolynomialSizes::of(force, arguments[0].abs(), shifts[0]);
            return Self::Polynomial(Box::new(own));
        }
        let arguments = if piece == Piece::Whole { arguments } else { arguments.map(f64::abs) };
        let mut series = Box::<CurveSeries>::default();
        let arguments = if operation.is_of_two() { arguments.map(f64::abs) } else { arguments };
        series.next_of_operation((operation, true), 0, arguments);
        Self::Operation { operation: *operation, shifts, series }
    }

    /// Size of the term of order `k`, given the sizes of the terms of the arguments.
    pub fn next(&mut self, k: usize, arguments: [f64; 2]) -> f64 {
        match self {
            Self::Still => 0.0,
            Self::Polynomial(own) => own.next(k, arguments[0]),
            Self::Operation { operation, shifts, series } => {
                let value = series.next_of_operation((operation, true), k, arguments);
                let slopes = series.slopes(operation, k);
                value + shifts[0] * slopes[0] + shifts[1] * slopes[1]
            }
        }
    }
}

/// [`CurveSizes`] of a polynomial.
#[derive(Clone, Debug)]
pub struct PolynomialSizes {
    majorant: Polynomial,
    /// Derivative of the majorant without its linear term.
    slope: Polynomial,
    /// Coefficient of the linear term of the majorant's derivative.
    linear: f64,
    /// Size for the relative rounding error of the argument at the start.
    shift: f64,
    value: CurveSeries,
    change: CurveSeries,
}

impl PolynomialSizes {
    fn of(force: &Polynomial, x: f64, shift: f64) -> Self {
        let majorant = force.majorant();
        let [c2, c3, c4, c5] = majorant.coefficients;
        let mut own = Self {
            majorant,
            slope: Polynomial { coefficients: [3.0 * c3, 4.0 * c4, 5.0 * c5, 0.0] },
            linear: 2.0 * c2,
            shift,
            value: CurveSeries::default(),
            change: CurveSeries::default(),
        };
        own.next(0, x);
        own
    }

    fn next(&mut self, k: usize, x: f64) -> f64 {
        let value = self.value.next_of_polynomial(&self.majorant, k, x);
        value + self.shift * (self.linear * x + self.change.next_of_polynomial(&self.slope, k, x))
    }
}

/// Coefficient of order `k` of the product of two series; `back` has the coefficients of the
/// second series in reverse order.
#[inline(always)]
fn product(a: &[f64; TERMS], back: &[f64; 2 * TERMS], k: usize) -> f64 {
    let back = &back[TERMS - 1 - k..];
    let mut sums = [0.0; 4];
    // Beyond order `k` the second factor is zero.
    let fours = a.as_chunks::<4>().0.iter().zip(back.as_chunks::<4>().0).take(k / 4 + 1);
    for (a, b) in fours {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Bound T of (A59): sum of the sizes of all coefficients of φ(x) of order `first` or higher, if
/// |xₖ| ≤ `scale` ratio⁻ᵏ. The coefficient of order k of xᵐ is then at most
/// scaleᵐ C(k + m - 1, m - 1) ratio⁻ᵏ, with the binomial coefficient C.
/// `power` is ratio⁻ᵏ for the order `first`.
#[inline(always)]
pub(super) fn tail(force: &Polynomial, scale: f64, (ratio, power): (f64, f64), first: usize) -> f64 {
    let (mut sum, mut scales, mut binomial) = (0.0, scale, 1.0);
    for (i, c) in force.coefficients.iter().enumerate() {
        let m = (i + LOWEST) as f64;
        scales *= scale;
        binomial *= (first as f64 + m - 1.0) / (m - 1.0);
        // The ratio of one term to the one before falls with the order.
        let next = (first as f64 + m) / (first as f64 + 1.0) / ratio;
        let begin = c.abs() * scales * binomial * power;
        if *c != 0.0 {
            sum += if next < 1.0 { begin / (1.0 - next) } else { f64::INFINITY };
        }
    }
    sum
}
