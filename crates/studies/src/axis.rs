//! Axes of studies over parameters, and the memory that results over them may take.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Axis of a study: `count` values from `from` to `to`, both included. Serialized with the
/// parameter's name, and checked on reading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written", bound = "N: AxisName")]
pub struct ParameterAxis<N> {
    /// Parameter that varies, of either form.
    pub name: N,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values.
    pub count: usize,
}

/// Serialized form of an axis, with the parameter by its name.
#[derive(Serialize, Deserialize)]
struct Written {
    name: String,
    from: f64,
    to: f64,
    count: usize,
}

/// Name of the parameter of an axis.
pub trait AxisName: Clone + Sized {
    /// The parameter with a name.
    ///
    /// # Errors
    /// If no parameter has this name.
    fn named(name: String) -> Result<Self>;
    /// The name as text.
    fn text(&self) -> String;
    /// Checks a value without knowledge of the machine.
    ///
    /// # Errors
    /// For a value that is not allowed.
    fn check_value(&self, value: f64) -> Result<()>;
}

/// Parameter of a described machine, which checks its values itself.
impl AxisName for String {
    fn named(name: String) -> Result<Self> {
        Ok(name)
    }

    fn text(&self) -> String {
        self.clone()
    }

    fn check_value(&self, _: f64) -> Result<()> {
        Ok(())
    }
}

impl<N: AxisName> From<ParameterAxis<N>> for Written {
    fn from(axis: ParameterAxis<N>) -> Self {
        Self { name: axis.name.text(), from: axis.from, to: axis.to, count: axis.count }
    }
}

impl<N: AxisName> TryFrom<Written> for ParameterAxis<N> {
    type Error = Error;

    fn try_from(axis: Written) -> Result<Self> {
        Self::of(N::named(axis.name)?, (axis.from, axis.to), axis.count)
    }
}

impl<N: AxisName> ParameterAxis<N> {
    /// A checked axis.
    ///
    /// # Errors
    /// [`Error::Form`] for a range that is empty or not finite, or for fewer than two values; the
    /// parameter's own range.
    ///
    /// # Examples
    ///
    /// ```
    /// use vibro_studies::ParameterAxis;
    ///
    /// let axis = ParameterAxis::of("load.f.frequency".to_owned(), (9.0, 11.0), 5)?;
    /// assert_eq!([0, 1, 4].map(|i| axis.value(i)), [9.0, 9.5, 11.0]);
    /// assert_eq!(axis.edges(), (8.75, 11.25));
    /// assert!(ParameterAxis::of("load.f.frequency".to_owned(), (11.0, 9.0), 5).is_err());
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn of(name: N, (from, to): (f64, f64), count: usize) -> Result<Self> {
        if !(from < to && (to - from).is_finite() && count >= 2) {
            let text = format!("{}={from}:{to} in {count} values", name.text());
            return Err(Error::Form { text, expected: "from < to, both finite, and at least 2 values" });
        }
        // A value such as ε = 0 may end a default range, but is not a valid value itself.
        name.check_value(from)?;
        name.check_value(to)?;
        Ok(Self { name, from, to, count })
    }

    /// Outer ends of the cells that are centred on the values.
    pub fn edges(&self) -> (f64, f64) {
        let half = 0.5 * (self.to - self.from) / (self.count - 1) as f64;
        (self.from - half, self.to + half)
    }

    /// The value of an index.
    pub fn value(&self, i: usize) -> f64 {
        let part = i as f64 / (self.count - 1) as f64;
        self.from * (1.0 - part) + self.to * part
    }
}

/// Memory that a study's results may take, bytes.
const MOST_MEMORY: usize = 1 << 30;

/// Checks that a plane of columns and rows fits into memory, where at most `held` bytes at a time
/// are held for each cell.
///
/// # Errors
/// [`Error::TooMany`], with the number that would fit.
pub fn check_cells(what: &'static str, (columns, rows): (usize, usize), held: usize) -> Result<()> {
    let most = MOST_MEMORY / held.max(1);
    match columns.checked_mul(rows) {
        Some(count) if count <= most => Ok(()),
        _ => {
            let (count, side) = (columns as f64 * rows as f64, Some(most.isqrt()));
            Err(Error::TooMany { what, count, most, side })
        }
    }
}

/// Checks that the results of a study along a line fit into memory: at most `held` bytes at a time
/// for each.
///
/// # Errors
/// [`Error::TooMany`], with the number that would fit.
pub fn check_count(what: &'static str, count: usize, held: usize) -> Result<()> {
    let most = MOST_MEMORY / held.max(1);
    if count <= most { Ok(()) } else { Err(Error::TooMany { what, count: count as f64, most, side: None }) }
}

/// Rows of a plane in one of its parts, each of whole rows with at least `motions` motions.
pub(crate) fn rows_of_part((columns, rows): (usize, usize), motions: usize, part: usize) -> Range<usize> {
    let size = motions.div_ceil(columns.max(1));
    part * size..((part + 1) * size).min(rows)
}

/// Number of parts of a plane, each of whole rows with at least `motions` motions.
pub(crate) fn parts_of_plane((columns, rows): (usize, usize), motions: usize) -> usize {
    rows.div_ceil(motions.div_ceil(columns.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_that_do_not_fit_into_memory_are_refused_with_the_number_that_fits() {
        assert!(check_cells("points", (1000, 1000), 200).is_ok());
        for side in [30_000, 1 << 40, usize::MAX] {
            let error = check_cells("points", (side, side), 200).unwrap_err();
            let Error::TooMany { most, side: Some(fits), .. } = error else { panic!("{error}") };
            assert!(
                check_cells("points", (most, 1), 200).is_ok()
                    && check_cells("points", (most + 1, 1), 200).is_err()
            );
            assert!(check_cells("points", (fits, fits), 200).is_ok() && fits > 2000);
            assert!(error.to_string().contains(&format!("{fits} × {fits}")), "{error}");
        }
    }
}
