//! Row of a design: the summary of each measure over its motions.

use super::{DesignMachine, MotionMeasures, SweepRequest};
use crate::attractor::MotionClass;
use serde::{Deserialize, Serialize};

/// Spread relative to a value up to which it is rounding.
const REGULAR: f64 = 1e-6;

/// Summary of a measure over the motions of a design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Least value.
    pub least: f64,
    /// Mean over all motions of the request, without those added by a choice.
    pub mean: f64,
    /// Largest value.
    pub largest: f64,
    /// First motion with the largest value, for [`SweepRequest::motion`] and [`DesignRow::motion`].
    pub at: usize,
    /// Scatter of the largest value between windows of the motions, from their
    /// [`Measured::spreads`](crate::measures::Measured::spreads).
    pub spread: f64,
}

impl Summary {
    /// Whether the largest value is exact up to rounding, since its motions repeat.
    pub fn is_exact(&self) -> bool {
        self.spread <= REGULAR * self.largest.abs()
    }
}

/// Second measurement of a design that may be the best.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Again {
    /// Periods over which motions were measured, except those that repeat.
    pub periods: u32,
    /// Further combinations of values of [`SweepRequest::over`], between its values.
    pub between: Vec<Vec<f64>>,
}

/// Result of one design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignRow {
    /// Values of the parameters that vary, in their order, SI.
    pub values: Vec<f64>,
    /// Summary of each measure over the motions; `None` for the class, and where a motion has no
    /// value.
    pub outputs: Vec<Option<Summary>>,
    /// Different classes in order of appearance, where the class was requested and every motion has
    /// one.
    pub classes: Vec<MotionClass>,
    /// Reason for missing values, or a caveat: a motion may have been measured before it had
    /// settled.
    pub reason: Option<String>,
    /// Second measurement, if there was one.
    pub again: Option<Again>,
}

impl DesignRow {
    /// Values and start that distinguish a motion of this row, as [`SweepRequest::motion`]; the
    /// motions between the requested values are included.
    pub fn motion<M: DesignMachine>(&self, request: &SweepRequest<M>, index: usize) -> (Vec<f64>, M::Start) {
        let (asked, starts) = (request.motions(), request.starts.len().max(1));
        let further = index.checked_sub(asked).and_then(|i| self.again.as_ref()?.between.get(i / starts));
        let (values, start) = request.motion(index % asked.max(1));
        (further.cloned().unwrap_or(values), start)
    }
}

/// The row of a design from its motions: those of the request and, after them, those of `again`.
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

/// Summary of numbers with their spreads, all of which must be there; the mean is over the first
/// `asked`.
fn together(numbers: impl Iterator<Item = Option<(f64, f64)>>, asked: usize) -> Option<Summary> {
    let (numbers, spreads): (Vec<f64>, Vec<f64>) =
        numbers.collect::<Option<Vec<(f64, f64)>>>()?.into_iter().unzip();
    let at = (1..numbers.len()).fold(0, |best, i| if numbers[i] > numbers[best] { i } else { best });
    let largest = *numbers.get(at)?;
    let least = numbers.iter().copied().fold(largest, f64::min);
    let first = &numbers[..asked.clamp(1, numbers.len())];
    let mean = if least == largest { largest } else { first.iter().sum::<f64>() / first.len() as f64 };
    // Another motion may come above this one in another window.
    let reach = numbers.iter().zip(&spreads).map(|(number, spread)| number + spread - largest);
    Some(Summary { least, mean, largest, at, spread: reach.fold(spreads[at], f64::max) })
}
