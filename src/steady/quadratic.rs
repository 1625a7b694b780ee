//! The quadratic whose roots are the steady states, its two roots and their names.

use nalgebra::Complex;

/// Two roots of a quadratic, or the steady states that belong to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roots<T> {
    /// The smaller root.
    pub lower: T,
    /// The larger root.
    pub upper: T,
}

impl<T> Roots<T> {
    /// Root of the given sheet.
    pub fn get(self, sheet: Sheet) -> T {
        match sheet {
            Sheet::Lower => self.lower,
            Sheet::Upper => self.upper,
        }
    }

    /// Both roots with their sheets' names, lower first.
    pub fn each(self) -> [(Sheet, T); 2] {
        [(Sheet::Lower, self.lower), (Sheet::Upper, self.upper)]
    }
}

/// Sheet of a branch: one of the two roots. The sheets join where the discriminant is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    /// The smaller root.
    Lower,
    /// The larger root.
    Upper,
}

/// Quadratic `|αC + α₀|² = f²` in the real amplitude C: docs/theory.md (43) and (44) for multiple
/// scales, (64) for strong coupling, and, with the impulse p in place of C, (73) and (74) for the
/// exact orbit. `αC + α₀ = f e^{iδ}` also gives the phase δ of the drive at the upper impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadratic {
    /// α, the force per amplitude.
    pub alpha: Complex<f64>,
    /// α₀, the force at amplitude zero.
    pub alpha0: Complex<f64>,
    /// f, the amplitude of the force. Its sign has no effect.
    pub force: f64,
    /// |α₀|² - f². The caller supplies this value, since it may know f² without squaring f.
    pub constant: f64,
}

impl Quadratic {
    /// Complex force αC + α₀ that maintains the motion at amplitude C.
    pub fn balance(&self, c: f64) -> Complex<f64> {
        self.alpha * c + self.alpha0
    }

    /// α times the conjugate of α₀.
    pub fn product(&self) -> Complex<f64> {
        self.alpha * self.alpha0.conj()
    }

    /// Coefficients (a, b, c) of a C² + b C + c = 0, docs/theory.md (44).
    pub fn coefficients(&self) -> (f64, f64, f64) {
        (self.alpha.norm_sqr(), 2.0 * self.product().re, self.constant)
    }

    /// b² - 4ac as the product of docs/theory.md (44), which is accurate near the fold, where it
    /// is zero.
    pub fn discriminant(&self) -> f64 {
        let reach = self.alpha.norm() * self.force.abs();
        let turn = self.product().im.abs();
        4.0 * (reach - turn) * (reach + turn)
    }

    /// Both roots; `None` if none is real or α is zero.
    ///
    /// The root of larger modulus is computed without cancellation and the other from their
    /// product. The discriminant is a product as in [`discriminant`](Self::discriminant).
    pub fn roots(&self) -> Option<Roots<f64>> {
        let (square, Complex { re: cross, im: turn }) = (self.alpha.norm_sqr(), self.product());
        let reach = square.sqrt() * self.force.abs();
        let quarter_discriminant = (reach - turn.abs()) * (reach + turn.abs());
        if !(quarter_discriminant >= 0.0 && square > 0.0) {
            return None;
        }
        let far = -(cross + quarter_discriminant.sqrt().copysign(cross));
        let first = far / square;
        let second = if far == 0.0 { 0.0 } else { self.constant / far };
        Some(Roots { lower: first.min(second), upper: first.max(second) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance, a few roundings: absolute for the root of order one, relative for the small one.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn closed_form_roots_of_very_different_size() {
        // The quadratic with α = 1 is (C - 1)(C - 1e-9). Its small root is accurate only if it is
        // computed from the large one.
        let (x, y) = (1.0_f64, 1e-9_f64);
        let (cross, constant) = (-0.5 * (x + y), x * y);
        let quadratic = Quadratic {
            alpha: Complex::new(1.0, 0.0),
            alpha0: Complex::new(cross, 0.0),
            force: (cross * cross - constant).sqrt(),
            constant,
        };
        let roots = quadratic.roots().unwrap();
        assert!((roots.upper - x).abs() < ROUNDING && (roots.lower / y - 1.0).abs() < ROUNDING);
    }
}
