//! Derivatives of the rows of a machine's parts (docs/assembly-law.md (A32)). A gradient stores
//! its weights of these rows in the same types (A40).

use crate::curved::HUNT_CROSSLEY;
use crate::description::StopLaw;
use crate::functional::StateRow;
use crate::system::{CombinationTangent, ContactRows, SamplerTangent, StopRows, contact_forces, forces};
use nalgebra::DVector;

/// Derivatives of the rows in [`BodyRows`](crate::system::BodyRows).
#[derive(Clone, Debug)]
pub(super) struct BodyTangent {
    pub s: StateRow,
    pub v: StateRow,
    pub weights: DVector<f64>,
    pub drift: StateRow,
}

/// Derivatives of the rows in [`Elongation`](crate::system::Elongation).
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
    /// Derivative of 1 + 3/2 dissipation e'; `None` without a dissipation.
    pub release: Option<StateRow>,
}

impl StopTangent {
    /// Returns the derivatives of a stop's rows, given the derivative `excess` of its excess and
    /// the derivatives `law` of its law's numbers.
    pub fn new(rows: &StopRows, elongation: ElongationTangent, excess: StateRow, law: StopLaw) -> Self {
        let by_law = forces::<StateRow>(law, &rows.excess, &rows.elongation.rate);
        let by_rows = forces(rows.law, &excess, &elongation.rate);
        let [spring, force] = std::array::from_fn(|k| &by_law[k] + &by_rows[k]);
        let restitution = if let StopLaw::Rigid { restitution } = law { restitution } else { 0.0 };
        Self { elongation, excess, force, spring, restitution, release: None }
    }

    /// The derivatives of the rows of a curved contact, with the derivatives of the numbers of its
    /// law and of its dissipation.
    pub fn contact(rows: &StopRows, own: &ContactRows, by: Self, (law, dissipation): (StopLaw, f64)) -> Self {
        let zero = StateRow::zeros(by.excess.len());
        let rate = &rows.elongation.rate;
        // xᵖ and xᵖ x' are coordinates; their derivatives are not part of the rows. If the
        // exponent is 1, x is a row.
        let power = if own.exponent == 1.0 { &by.excess } else { &zero };
        let places: [&StateRow; 3] = [&own.power, &own.product, rate];
        let parts = [
            contact_forces::<StateRow>(law, own.dissipation, places),
            contact_forces(rows.law, dissipation, [&zero, &own.product, &zero]),
            contact_forces(rows.law, own.dissipation, [power, &zero, &by.elongation.rate]),
        ];
        let spring = &parts[0][0] + &parts[2][0];
        let force = &parts[0][1] + &parts[1][1] + &parts[2][1];
        let release = own
            .release
            .as_ref()
            .map(|_| HUNT_CROSSLEY * (dissipation * &**rate + own.dissipation * &by.elongation.rate));
        Self { spring, force, release, ..by }
    }
}

/// Derivatives of a friction's rows.
#[derive(Clone, Debug)]
pub(super) struct FrictionTangent {
    pub elongation: ElongationTangent,
    /// Derivatives of each of the friction's levels.
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
    /// The derivative of the row of the stretch's rate, used where the stretch varies.
    pub rate: StateRow,
    /// The derivative of a slider's level.
    pub level: StateRow,
    /// The derivative of the row of the stretch's rate while the slider of a contact slips
    /// upwards.
    pub sliding: StateRow,
    /// On residual flexibility: the derivatives of the rows of the stretch and of its rate while
    /// the slider does not hold.
    pub slaved: Option<[StateRow; 2]>,
}

/// Place of a state, derivative of the row of its rate, and the limits' factors in that row.
pub(super) type RateTangent = (usize, StateRow, Vec<(usize, f64)>);

/// The derivatives of the rows of blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockTangents {
    pub outputs: Vec<Vec<CombinationTangent>>,
    /// Derivatives of sampled blocks.
    pub samplers: Vec<Option<SamplerTangent>>,
    /// Place and row of the rate of each state of first order of a continuous block, and the
    /// factors of the limits of its inputs.
    pub rates: Vec<RateTangent>,
    /// For each load: the factors of the limits of the output that it follows.
    pub loads: Vec<Vec<f64>>,
    /// Derivatives of each limit's excess and of its force's direction.
    pub limits: Vec<(StateRow, DVector<f64>)>,
}
