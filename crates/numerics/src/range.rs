//! Range of values that a quantity may take.

/// Range of finite numbers, with a description for error messages.
///
/// ```
/// use vibro_numerics::Range;
///
/// let share = Range { min: 0.0, max: 1.0, open_min: true, allowed: "0 < share <= 1" };
/// assert!(share.contains(1.0) && !share.contains(0.0));
/// let message = share.check("share", 2.0).unwrap_err().to_string();
/// assert_eq!(message, "share = 2: expected 0 < share <= 1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower bound; minus infinity if there is none.
    pub min: f64,
    /// Largest permitted value; infinity if there is none.
    pub max: f64,
    /// Whether `min` itself is excluded.
    pub open_min: bool,
    /// Description of the range, for messages and documentation.
    pub allowed: &'static str,
}

/// Error for a value outside its range (also NaN and infinities).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: expected {allowed}")]
pub struct OutOfRange {
    /// Name of the quantity.
    pub name: &'static str,
    /// The refused value.
    pub value: f64,
    /// Description of the range.
    pub allowed: &'static str,
}

impl Range {
    /// All finite numbers.
    pub const FINITE: Self = Self::any("a finite number");
    /// Zero and the positive finite numbers.
    pub const NOT_NEGATIVE: Self =
        Self { min: 0.0, max: f64::INFINITY, open_min: false, allowed: "a finite number >= 0" };
    /// The positive finite numbers.
    pub const POSITIVE: Self =
        Self { min: 0.0, max: f64::INFINITY, open_min: true, allowed: "a finite number > 0" };

    /// All finite numbers, with a description of a bound that depends on other quantities and is
    /// checked elsewhere.
    pub const fn any(allowed: &'static str) -> Self {
        Self { min: f64::NEG_INFINITY, max: f64::INFINITY, open_min: false, allowed }
    }

    /// Whether `value` lies in the range. False for NaN and the infinities.
    pub fn contains(&self, value: f64) -> bool {
        let above = if self.open_min { value > self.min } else { value >= self.min };
        value.is_finite() && above && value <= self.max
    }

    /// Checks the value of the quantity `name`.
    ///
    /// # Errors
    /// [`OutOfRange`] if [`contains`](Self::contains) is false for the value.
    pub fn check(&self, name: &'static str, value: f64) -> Result<(), OutOfRange> {
        if self.contains(value) {
            return Ok(());
        }
        Err(OutOfRange { name, value, allowed: self.allowed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_ends_of_the_ranges() {
        let share = Range { min: 0.0, max: 1.0, open_min: false, allowed: "0 <= share <= 1" };
        let tiny = f64::from_bits(1); // the smallest positive number
        for (range, inside, outside) in [
            (Range::FINITE, [-f64::MAX, 0.0, f64::MAX], vec![]),
            (Range::NOT_NEGATIVE, [0.0, tiny, f64::MAX], vec![-tiny]),
            (Range::POSITIVE, [tiny, 1.0, f64::MAX], vec![0.0, -tiny]),
            (share, [0.0, 0.5, 1.0], vec![-tiny, 1.0f64.next_up()]),
        ] {
            for value in inside {
                assert!(range.contains(value) && range.check("x", value).is_ok(), "{value} in {range:?}");
            }
            for value in outside.into_iter().chain([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
                assert!(!range.contains(value), "{value} in {range:?}");
                let refused = range.check("x", value);
                assert!(matches!(refused, Err(OutOfRange { name: "x", .. })), "{value} in {range:?}");
            }
        }
    }
}
