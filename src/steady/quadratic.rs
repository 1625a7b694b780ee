//! The quadratic behind every steady state of this module, its two roots and their names.

/// The two roots of the quadratic behind every steady state of this module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roots<T> {
    /// The smaller root.
    pub lower: T,
    /// The larger root.
    pub upper: T,
}

impl<T> Roots<T> {
    /// The root of the given sheet.
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

/// Which root of the quadratic: the two sheets of a branch, joined where the discriminant is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    /// The smaller root.
    Lower,
    /// The larger root.
    Upper,
}

/// Roots of `|αC + α₀|² = f²` in C, from `square = |α|²`, `cross = Re(α ᾱ₀)`, `turn = Im(α ᾱ₀)` and
/// `constant = |α₀|² - f²`. The discriminant is formed as (|α|f - |turn|)(|α|f + |turn|), which keeps its
/// digits near the fold. `None` without real roots.
pub fn circle_roots(square: f64, cross: f64, turn: f64, constant: f64, f: f64) -> Option<Roots<f64>> {
    let reach = square.sqrt() * f.abs();
    let discriminant = (reach - turn.abs()) * (reach + turn.abs());
    if !(discriminant >= 0.0 && square > 0.0) {
        return None;
    }
    let far = -(cross + discriminant.sqrt().copysign(cross));
    let first = far / square;
    let second = if far == 0.0 { 0.0 } else { constant / far };
    Some(Roots { lower: first.min(second), upper: first.max(second) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_against_its_product_form() {
        // |αC + α₀|² with α = 1: (C - 1)(C - 1e-9) needs the far root first.
        let (x, y) = (1.0_f64, 1e-9_f64);
        let (cross, constant) = (-0.5 * (x + y), x * y);
        // α = 1, α₀ = cross + i·turn with turn = 0: f² = cross² - constant.
        let f = (cross * cross - constant).sqrt();
        let roots = circle_roots(1.0, cross, 0.0, constant, f).unwrap();
        assert!((roots.upper - x).abs() < 1e-15 && (roots.lower / y - 1.0).abs() < 1e-15);
    }
}
