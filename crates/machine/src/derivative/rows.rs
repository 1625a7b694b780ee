//! What a parameter changes in the rows of a machine's parts (docs/assembly-law.md (A32)), which is
//! also the place of the weights of these rows in a gradient (A40).

use crate::description::StopLaw;
use crate::functional::StateRow;
use crate::system::{CombinationTangent, SamplerTangent, StopRows, forces};
use nalgebra::DVector;

/// Derivatives of a body's rows, as those of [`BodyRows`](crate::system::BodyRows).
#[derive(Clone, Debug)]
pub(super) struct BodyTangent {
    pub s: StateRow,
    pub v: StateRow,
    pub weights: DVector<f64>,
    pub drift: StateRow,
}

/// Derivatives of an elongation's rows, as those of [`Elongation`](crate::system::Elongation).
#[derive(Clone, Debug)]
pub(super) struct ElongationTangent {
    pub e: StateRow,
    pub rate: StateRow,
    pub w: DVector<f64>,
    pub drift: StateRow,
}

/// Derivatives of a stop's rows.
#[derive(Clone, Debug)]
pub(super) struct StopTangent {
    pub elongation: ElongationTangent,
    pub excess: StateRow,
    pub force: StateRow,
    pub spring: StateRow,
    pub restitution: f64,
}

impl StopTangent {
    /// The derivatives of the rows of a stop whose excess has the derivative `excess`, and the
    /// numbers of its law the derivatives `law`.
    pub fn new(rows: &StopRows, elongation: ElongationTangent, excess: StateRow, law: StopLaw) -> Self {
        let by_law = forces::<StateRow>(law, &rows.excess, &rows.elongation.rate);
        let by_rows = forces(rows.law, &excess, &elongation.rate);
        let [spring, force] = std::array::from_fn(|k| &by_law[k] + &by_rows[k]);
        let restitution = if let StopLaw::Rigid { restitution } = law { restitution } else { 0.0 };
        Self { elongation, excess, force, spring, restitution }
    }
}

/// Derivatives of a friction's rows.
#[derive(Clone, Debug)]
pub(super) struct FrictionTangent {
    pub elongation: ElongationTangent,
    /// By the friction's levels.
    pub levels: Vec<LevelTangent>,
}

/// Derivatives of a friction's levels.
#[derive(Clone, Debug)]
pub(super) struct LevelTangent {
    pub level: StateRow,
    pub static_level: StateRow,
}

/// Derivatives of the rows of a spring in series.
#[derive(Clone, Debug)]
pub(super) struct BranchTangent {
    pub elongation: ElongationTangent,
    pub force: StateRow,
    /// The derivative of the row of the stretch's rate, where it varies.
    pub rate: StateRow,
    /// Of the level of a slider.
    pub level: StateRow,
}

/// Place of a state, derivative of the row of its rate, and the factors of limits in it.
pub(super) type RateTangent = (usize, StateRow, Vec<(usize, f64)>);

/// What a parameter changes in the rows of blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockTangents {
    pub outputs: Vec<Vec<CombinationTangent>>,
    /// Of sampled blocks.
    pub samplers: Vec<Option<SamplerTangent>>,
    /// By state of first order of a continuous block: its place, the row of its rate, and the
    /// factors of the limits of what it reads.
    pub rates: Vec<RateTangent>,
    /// By load: the factors of the limits of the output that it follows.
    pub loads: Vec<Vec<f64>>,
    /// By limit: the derivative of its excess, and of the direction of its force.
    pub limits: Vec<(StateRow, DVector<f64>)>,
}
