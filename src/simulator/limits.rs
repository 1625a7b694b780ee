//! Limits on starts, drive and loads within which double precision resolves the motion.

use super::{Contact, DueEvent, HybridState, State};
use crate::error::{Error, Result};
use crate::model::{Forces, Model};
use crate::parameters::Parameters;

/// Distance from a stop, in roundings of the displacements, within which a start counts as on the
/// stop.
const ON_STOP_ULPS: f64 = 4.0;
/// Largest displacement in gaps. The relative displacement is a difference of displacements; for
/// larger ones it has fewer than 6 digits.
const MAX_DRIFT: f64 = 1e10;
/// Largest speed, in units of the gap times the fastest rate, and largest acceleration by drive
/// and loads, in units of the gap times the square of the fastest rate. Above it the block's
/// flights are shorter than the resolution of the motion. Also the largest displacement of the
/// secondary oscillator at a start, in gaps.
const MAX_VIOLENCE: f64 = 1e12;

/// Quantity named in the error for a load that is too large for the system.
const VIOLENT_LOAD: &str = "load over its body's mass, stop.gap and the square of the fastest rate";

/// Highest possible order of the first derivative of w that leads away from a stop.
const MAX_DEPARTING: u8 = 8;

/// Largest product of time and fastest rate. Above it a double does not distinguish two moments of
/// the motion.
const MAX_TIME: f64 = 1e15;

/// Checks that a double resolves the motion at `time`, s, with the fastest `rate`, 1/s.
#[inline]
pub fn check_time(rate: f64, time: f64) -> Result<()> {
    let value = (rate * time).abs();
    if value <= MAX_TIME {
        return Ok(());
    }
    Err(Error::PrecisionLost { what: "time times the fastest rate", value, limit: MAX_TIME })
}

fn check_limit(what: &'static str, value: f64) -> Result<()> {
    if value.abs() <= MAX_VIOLENCE {
        return Ok(());
    }
    Err(Error::PrecisionLost { what, value: value.abs(), limit: MAX_VIOLENCE })
}

/// Checks drive and constant loads against [`MAX_VIOLENCE`].
pub(super) fn check_constant_forces(model: &Model) -> Result<()> {
    let unit = model.gap * model.rate * model.rate;
    check_limit(
        "drive.amplitude over box.m, stop.gap and the square of the fastest rate",
        model.drive / unit,
    )?;
    check_loads(model, &model.constant_loads.map(|load| [load, 0.0, 0.0, 0.0]))
}

/// Checks loads and their derivatives against [`MAX_VIOLENCE`].
pub(super) fn check_loads(model: &Model, loads: &Forces) -> Result<()> {
    for (derivatives, inverse_mass) in loads.iter().zip(&model.inverse_mass) {
        let mut unit = model.gap * model.rate * model.rate;
        for derivative in derivatives {
            check_limit(VIOLENT_LOAD, derivative * inverse_mass / unit)?;
            unit *= model.rate;
        }
    }
    Ok(())
}

/// Checks speeds, and the displacement of the secondary oscillator, against [`MAX_VIOLENCE`].
pub(super) fn check_speeds(model: &Model, state: &State) -> Result<()> {
    let (gap, rate) = (model.gap, model.rate);
    check_limit("secondary.s over stop.gap", state.x[2] / gap)?;
    let speeds = [state.v[0], state.v[2], state.v[1] - state.v[0]];
    speeds
        .into_iter()
        .try_for_each(|v| check_limit("start speed over stop.gap and the fastest rate", v / (gap * rate)))
}

/// x1, w, x3 and rates of a state, checked against the stops.
pub(super) fn coordinates(parameters: &Parameters, state: &State) -> Result<[f64; 6]> {
    const NAMES: [[&str; 3]; 2] = [["box.s", "block.s", "secondary.s"], ["box.v", "block.v", "secondary.v"]];
    for (names, values) in NAMES.iter().zip([&state.x, &state.v]) {
        for (name, &value) in names.iter().zip(values) {
            // Squares must not overflow in the energies.
            if value.is_nan() || value.abs() > 1e100 {
                return Err(Error::OutOfRange { name, value, allowed: "a finite number up to 1e100" });
            }
        }
    }
    let (x, gap) = (&state.x, parameters.stop_gap);
    let largest = x[0].abs().max(x[1].abs());
    if largest > MAX_DRIFT * gap {
        return Err(Error::PrecisionLost {
            what: "start displacement of box or block over stop.gap",
            value: largest / gap,
            limit: MAX_DRIFT,
        });
    }
    let mut y = state.to_relative();
    let w = &mut y[1];
    let rounding = ON_STOP_ULPS * f64::EPSILON * (largest + gap);
    if (w.abs() - gap).abs() <= rounding {
        *w = gap.copysign(*w);
    }
    if w.abs() > gap {
        return Err(Error::Penetration { value: *w, gap });
    }
    Ok(y)
}

/// Checks that contact, departure and due event of a snapshot agree with its w and w'.
pub(super) fn check_contact(hybrid: &HybridState, gap: f64) -> Result<()> {
    let refuse = |name, value, allowed| Err(Error::OutOfRange { name, value, allowed });
    let (w, rate, side) = (hybrid.y[1], hybrid.y[4], hybrid.contact.side());
    if side != 0.0 && !(w == side * gap && rate == 0.0) {
        return refuse(
            "snapshot: block.s - box.s in rest",
            w,
            "the stop at which the block rests, without relative speed",
        );
    }
    let departing = f64::from(hybrid.departing);
    if hybrid.departing != 0 && (hybrid.departing > MAX_DEPARTING || side != 0.0 || w.abs() != gap) {
        return refuse("snapshot: order of departure", departing, "0, or 1 to 8 in flight from a stop");
    }
    let Some(due) = hybrid.due else { return Ok(()) };
    let stop = f64::from(due.side());
    let touches = stop.abs() == 1.0 && w == stop * gap;
    let fits = match due {
        DueEvent::Impact { .. } => hybrid.contact == Contact::Flight && stop * rate >= 0.0,
        DueEvent::Release { .. } => side == stop,
    };
    if !(touches && fits) {
        return refuse(
            "snapshot: stop of the event that is due",
            stop,
            "the stop, +1 or -1, that the block touches",
        );
    }
    Ok(())
}
