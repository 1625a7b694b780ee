//! Derivatives of the state at the end of a step with respect to the state at its beginning and
//! the loads during the step. In each smooth piece the derivatives satisfy the variational
//! equations, which are the equations of motion without the drive. At each impact they jump by the
//! saltation matrix (docs/theory.md (84)).
//!
//! The step is replayed when its derivatives are requested, so that the step itself does no extra
//! work. In resting contact box and block are one body: variations of their relative motion are
//! projected out at constant momentum, as by an impact without rebound. A release changes nothing
//! to first order, since the accelerations on both sides of it are equal.

use super::values::StepMatrices;
use vibro_impact::Error;
use vibro_impact::flow::{Series, WHOLE, remainder, shifted};
use vibro_impact::model::{
    Augmented, BOX, BOX_RATE, COORDINATES, Forces, Model, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE,
    Saltation, SmoothMode,
};
use vibro_impact::simulator::{DueEvent, Pause, Simulator};

/// Columns: six states, then value and derivatives 1 to 3 of three loads.
const COLUMNS: usize = 6 + 12;
/// Length limit of one series, times the model's rate; a longer piece is divided. The remainder is
/// below 2e-31 of the variation's size (docs/numerics.md, section 1).
const REACH: f64 = 1.0;
const _: () = assert!(remainder(WHOLE, REACH) < 2e-31);

/// A variation of the state, and of the loads as polynomials from the beginning of the step.
#[derive(Clone, Copy)]
struct Column {
    z: Augmented,
    loads: Forces,
}

/// The derivatives over the step from the state of `replay` to the time of `reached`, with the
/// number of impacts that `reached` has counted.
///
/// # Errors
/// Errors of the replay.
pub(crate) fn matrices(mut replay: Simulator, reached: &Simulator) -> Result<StepMatrices, Error> {
    let model = Model::new(replay.parameters())?;
    let begin = replay.time();
    let end = reached.time();
    // An event at the end may differ from it by rounding.
    let limit = end + 4.0 * f64::EPSILON * end.abs();
    let counted = |s: &Simulator| s.impacts().upper + s.impacts().lower;
    let mut columns: [Column; COLUMNS] = std::array::from_fn(unit);
    loop {
        let (from, mode) = (replay.time(), replay.contact().mode());
        if mode == SmoothMode::Rest {
            columns.iter_mut().for_each(|column| merge(&mut column.z, model.block_share));
        }
        replay.advance_until(limit.max(from), Pause::BeforeEvent, None)?;
        let to = replay.time().min(end.max(from));
        propagate(&mut columns, &model, mode, (from - begin, to - begin));
        match replay.due_event() {
            Some(DueEvent::Impact { .. }) if counted(&replay) < counted(reached) => {
                // The law uses the parameters with which it was applied in the step.
                let law = Model::new(reached.parameters())?;
                if replay.parameters() != reached.parameters() {
                    replay.set_parameters(reached.parameters())?;
                }
                jump(&mut columns, &law, &mut replay);
            }
            Some(DueEvent::Release { .. }) => {
                replay.apply_due_event(None);
            }
            _ => break,
        }
    }
    if replay.contact().mode() == SmoothMode::Rest {
        columns.iter_mut().for_each(|column| merge(&mut column.z, model.block_share));
    }
    Ok(collected(&columns))
}

/// The unit variation of one state or of one coefficient of a load.
fn unit(i: usize) -> Column {
    let mut column = Column { z: [0.0; COORDINATES], loads: [[0.0; 4]; 3] };
    match i {
        // x2 = x1 + w: the box alone moves against the block.
        0 => (column.z[BOX], column.z[RELATIVE]) = (1.0, -1.0),
        1 => column.z[RELATIVE] = 1.0,
        2 => column.z[SECONDARY] = 1.0,
        3 => (column.z[BOX_RATE], column.z[RELATIVE_RATE]) = (1.0, -1.0),
        4 => column.z[RELATIVE_RATE] = 1.0,
        5 => column.z[SECONDARY_RATE] = 1.0,
        load => column.loads[(load - 6) / 4][(load - 6) % 4] = 1.0,
    }
    column
}

/// Projects out the relative motion; the momentum of box and block is kept.
fn merge(z: &mut Augmented, block_share: f64) {
    add_relative(z, block_share);
    (z[RELATIVE], z[RELATIVE_RATE]) = (0.0, 0.0);
}

/// Propagates variations over a piece with times relative to the beginning of the step.
fn propagate(columns: &mut [Column; COLUMNS], model: &Model, mode: SmoothMode, (from, to): (f64, f64)) {
    let parts = ((to - from) * model.rate / REACH).ceil().max(1.0);
    let part = (to - from) / parts;
    if part == 0.0 {
        return;
    }
    for column in columns {
        for i in 0..parts as usize {
            let loads = shifted(&column.loads, from + i as f64 * part);
            column.z = Series::<WHOLE>::expand(model, mode, &column.z, Some(&loads), part).at(1.0);
        }
    }
}

/// Applies the law of the impact that is due to the motion and to its variations.
fn jump(columns: &mut [Column; COLUMNS], model: &Model, replay: &mut Simulator) {
    let rate = replay.augmented()[RELATIVE_RATE];
    replay.apply_due_event(None);
    let loads = replay.loads().derivatives.map(|load| load[0]);
    let jump = Saltation::new(model, rate, &replay.augmented(), loads, 1.0);
    let rests = replay.contact().mode() == SmoothMode::Rest;
    for Column { z, .. } in columns {
        add_relative(z, model.block_share);
        jump.apply(z);
        if rests {
            Saltation::merge(model, z, 1.0);
        }
        add_relative(z, -model.block_share);
    }
}

/// Adds a fraction of the relative motion to the motion of the box. If the fraction is the block's
/// share of the mass, the box's position then holds their centre of mass, docs/theory.md (83).
fn add_relative(z: &mut Augmented, part: f64) {
    z[BOX] += part * z[RELATIVE];
    z[BOX_RATE] += part * z[RELATIVE_RATE];
}

fn collected(columns: &[Column; COLUMNS]) -> StepMatrices {
    let mut matrices = StepMatrices::default();
    for (i, Column { z, .. }) in columns.iter().enumerate() {
        let state = [
            z[BOX],
            z[BOX] + z[RELATIVE],
            z[SECONDARY],
            z[BOX_RATE],
            z[BOX_RATE] + z[RELATIVE_RATE],
            z[SECONDARY_RATE],
        ];
        for (row, value) in state.into_iter().enumerate() {
            // A grazing impact may throw a variation out of range.
            let value = if value.is_nan() { 0.0 } else { value.clamp(f64::MIN, f64::MAX) };
            match i.checked_sub(6) {
                None => matrices.transition[row][i] = value,
                Some(load) => matrices.response[row][load] = value,
            }
        }
    }
    matrices
}
