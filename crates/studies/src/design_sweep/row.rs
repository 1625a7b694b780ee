//! Row of a design: the summary of each measure over its motions.

use super::{DesignMachine, MotionMeasures, SweepRequest};
use crate::class::MotionClass;
use serde::{Deserialize, Serialize};

/// Tolerance for rounding: a spread up to this fraction of the value counts as zero.
const REGULAR: f64 = 1e-6;

/// Summary of a measure over the motions of a design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Smallest value.
    pub least: f64,
    /// Mean over all motions of the request, without the motions added by a choice.
    pub mean: f64,
    /// Largest value.
    pub largest: f64,
    /// First motion with the largest value (index of [`SweepRequest::motion`]).
    pub at: usize,
    /// Half the distance from the largest value to the largest upper end of the error bars. A bar
    /// reaches `BARS` [spreads](crate::measured::Measured::spreads) up and down.
    pub spread: f64,
    /// Largest lower end of these error bars.
    pub lower: f64,
    /// Whether all motions repeat, so that a longer window changes a value only by rounding.
    pub is_exact: bool,
}

/// Half the length of an error bar, in spreads.
pub const BARS: f64 = 2.0;

/// Whether a value with this spread is exact up to rounding because its motion repeats.
pub(super) fn is_exact(value: f64, spread: f64) -> bool {
    spread <= REGULAR * value.abs()
}

/// Upper end of an error bar.
pub(super) fn upper((value, spread): (f64, f64)) -> f64 {
    value + BARS * spread
}

/// Repeated measurement of a design that may be the best.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Again {
    /// Periods over which motions were measured, except motions that repeat.
    pub periods: u32,
    /// Further combinations of values of [`SweepRequest::over`], between its values.
    pub between: Vec<Vec<f64>>,
}

/// Result of one design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignRow {
    /// Values of the parameters that vary, in their order, SI.
    pub values: Vec<f64>,
    /// Summary of each measure over the motions. `None` for the class, and if a motion has no
    /// value.
    pub outputs: Vec<Option<Summary>>,
    /// Different classes in order of appearance, if the class was requested and every motion has
    /// one.
    pub classes: Vec<MotionClass>,
    /// Reason for missing values, or a caveat: a motion may have been measured before it had
    /// settled.
    pub reason: Option<String>,
    /// Last repeated measurement, if there was one.
    pub again: Option<Again>,
}

impl DesignRow {
    /// Values and start that distinguish a motion of this row, as [`SweepRequest::motion`], also
    /// for the motions between the requested values.
    pub fn motion<M: DesignMachine>(&self, request: &SweepRequest<M>, index: usize) -> (Vec<f64>, M::Start) {
        let (asked, starts) = (request.motions(), request.starts.len().max(1));
        let further = index.checked_sub(asked).and_then(|i| self.again.as_ref()?.between.get(i / starts));
        let (values, start) = request.motion(index % asked.max(1));
        (further.cloned().unwrap_or(values), start)
    }
}

/// The row of a design from its motions: first the motions of the request, then of `again`.
pub(super) fn summary<M: DesignMachine>(
    set: &M,
    values: Vec<f64>,
    request: &SweepRequest<M>,
    motions: &[MotionMeasures],
    again: Option<Again>,
) -> DesignRow {
    let outputs = (0..request.measures.len())
        .map(|m| {
            let one = |(found, _): &MotionMeasures| {
                Some((found.numbers.get(m).copied().flatten()?, found.spreads.get(m).copied().unwrap_or(0.0)))
            };
            together(motions.iter().map(one), request.motions())
        })
        .collect();
    let mut classes: Vec<MotionClass> = Vec::new();
    if motions.iter().all(|(found, _)| found.class.is_some()) {
        for class in motions.iter().filter_map(|(found, _)| found.class) {
            if !classes.contains(&class) {
                classes.push(class);
            }
        }
    }
    let mut row = DesignRow { values, outputs, classes, reason: None, again };
    let bad: Vec<(usize, &String)> =
        motions.iter().enumerate().filter_map(|(i, (_, reason))| Some((i, reason.as_ref()?))).collect();
    row.reason = bad.first().map(|(index, reason)| match motions.len() {
        1 => (*reason).clone(),
        all => {
            let words = request.place_in_words(set, row.motion(request, *index));
            format!("{} of {all} motions, the first at {words}: {reason}", bad.len())
        }
    });
    row
}

/// Summary of numbers with their spreads; `None` if any is missing. The mean is over the first
/// `asked` numbers.
fn together(numbers: impl Iterator<Item = Option<(f64, f64)>>, asked: usize) -> Option<Summary> {
    let (numbers, spreads): (Vec<f64>, Vec<f64>) =
        numbers.collect::<Option<Vec<(f64, f64)>>>()?.into_iter().unzip();
    let at = (1..numbers.len()).fold(0, |best, i| if numbers[i] > numbers[best] { i } else { best });
    let largest = *numbers.get(at)?;
    let least = numbers.iter().copied().fold(largest, f64::min);
    let first = &numbers[..asked.clamp(1, numbers.len())];
    let mean = if least == largest { largest } else { first.iter().sum::<f64>() / first.len() as f64 };
    // In another window another motion may have the largest value.
    let bars = || numbers.iter().copied().zip(spreads.iter().copied());
    let spread = bars().map(|bar| (upper(bar) - largest) / BARS).fold(spreads[at], f64::max);
    let lower = bars().map(|(number, spread)| number - BARS * spread).fold(f64::NEG_INFINITY, f64::max);
    let is_exact = bars().all(|(number, spread)| is_exact(number, spread));
    Some(Summary { least, mean, largest, at, spread, lower, is_exact })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_error_bar_of_the_largest_reaches_to_the_largest_ends() {
        // Bars from 9.8 to 10.2, from 7 to 11, and 9.
        let found = together([(10.0, 0.1), (9.0, 1.0), (9.0, 0.0)].map(Some).into_iter(), 3).unwrap();
        assert_eq!((found.largest, found.at, found.is_exact), (10.0, 0, false));
        assert_eq!((upper((found.largest, found.spread)), found.lower), (11.0, 10.0 - BARS * 0.1));
        let exact = together([(10.0, 1e-9), (9.0, 0.0)].map(Some).into_iter(), 2).unwrap();
        assert!(exact.is_exact && is_exact(exact.largest, exact.spread));
    }
}
