//! Sets of designs of a sweep.

use crate::sobol::coordinate;
use serde::{Deserialize, Serialize};

/// Parameter with its values, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampledAxis<N> {
    /// The parameter.
    pub name: N,
    /// Values, at least one.
    pub values: Vec<f64>,
}

/// Parameter with an interval, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterInterval<N> {
    /// The parameter.
    pub name: N,
    /// Lower end, included.
    pub from: f64,
    /// Upper end, excluded.
    pub to: f64,
}

/// The designs of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Designs<N> {
    /// All combinations of the values, the last axis varying fastest.
    Grid(Vec<SampledAxis<N>>),
    /// A list.
    Rows {
        /// Parameters.
        names: Vec<N>,
        /// Values, design by design.
        rows: Vec<Vec<f64>>,
    },
    /// The first points of the [Sobol sequence](crate::sobol) in at most
    /// [`DIMENSIONS`](crate::sobol::DIMENSIONS) intervals.
    Sobol {
        /// The intervals.
        intervals: Vec<ParameterInterval<N>>,
        /// Number of points.
        count: u32,
    },
}

impl<N: Clone> Designs<N> {
    /// Parameters that vary.
    pub fn names(&self) -> Vec<N> {
        match self {
            Self::Grid(axes) => axes.iter().map(|a| a.name.clone()).collect(),
            Self::Rows { names, .. } => names.clone(),
            Self::Sobol { intervals, .. } => intervals.iter().map(|i| i.name.clone()).collect(),
        }
    }

    /// Number of designs; saturates at the largest `usize`.
    pub fn count(&self) -> usize {
        match self {
            Self::Grid(axes) => axes.iter().map(|a| a.values.len()).fold(1, usize::saturating_mul),
            Self::Rows { rows, .. } => rows.len(),
            Self::Sobol { count, .. } => *count as usize,
        }
    }

    /// The values of a design, SI, in the order of [`names`](Self::names).
    ///
    /// # Panics
    /// If `index` is [`count`](Self::count) or more.
    pub fn values(&self, index: usize) -> Vec<f64> {
        match self {
            Self::Grid(axes) => combination(axes, index),
            Self::Rows { rows, .. } => rows[index].clone(),
            Self::Sobol { intervals, .. } => {
                let value = |(dimension, i): (usize, &ParameterInterval<N>)| {
                    let part = coordinate(index as u32, dimension);
                    i.from * (1.0 - part) + i.to * part
                };
                intervals.iter().enumerate().map(value).collect()
            }
        }
    }
}

/// A combination of the axes' values, the last axis varying fastest.
pub(super) fn combination<N>(axes: &[SampledAxis<N>], index: usize) -> Vec<f64> {
    let mut rest = index;
    let value = |axis: &SampledAxis<N>| {
        let count = axis.values.len();
        let own = rest % count;
        rest /= count;
        axis.values[own]
    };
    let mut values: Vec<f64> = axes.iter().rev().map(value).collect();
    values.reverse();
    values
}
