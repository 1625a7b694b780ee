//! Upper bound of the rates of a machine: above it the motion would overflow, or take endless
//! sub-steps.

use crate::description::{Description, Series, SeriesLaw, StopLaw};
use crate::elements::NamedSignal;
use crate::error::Error;
use crate::system::{Elongation, Part, System};

/// The highest rate, rad/s, or frequency, Hz: its square times the largest coordinate, 1e100, is
/// finite.
const MOST_RATE: f64 = 1e100;
/// The highest frequency of a sweep, Hz: the derivatives of its polynomials are finite.
const MOST_SWEPT: f64 = 1e20;

/// Requires rates of at most [`MOST_RATE`] for springs and compliant stops (with the inertias that
/// they move), springs in series with a dashpot, states of continuous blocks, and harmonics; and
/// of at most [`MOST_SWEPT`] for sweeps.
///
/// # Errors
/// [`Error::TooFast`].
pub(crate) fn check(machine: &Description, system: &System) -> Result<(), Error> {
    for (element, parts) in machine.elements().zip(&system.parts) {
        for &part in parts {
            if let (Some(elongation), Some(factors)) =
                (system.elongation_of_part(part), factors(system, part))
            {
                check_force(&element.dotted(), elongation, factors)?;
            }
        }
    }
    for spring in &machine.springs {
        if let Some(Series { law: SeriesLaw::Dashpot { damping }, .. }) = spring.series
            && spring.stiffness / damping > MOST_RATE
        {
            return Err(Error::TooFast {
                name: format!("spring.{}.series_damping", spring.name),
                value: damping,
            });
        }
    }
    for block in machine.blocks.iter().filter(|block| block.sampling.is_none()) {
        if let Some(&value) = block.a.iter().flatten().find(|a| a.abs() > MOST_RATE) {
            return Err(Error::TooFast { name: format!("block.{}.a", block.name), value });
        }
    }
    machine.signals().try_for_each(|NamedSignal { name, signal, .. }| {
        let fast = signal.harmonics.iter().map(|h| h.frequency).find(|f| *f > MOST_RATE);
        let swept = signal.sweeps.iter().flat_map(|sweep| [sweep.from, sweep.to]);
        let fast = fast.or_else(|| swept.clone().find(|f| *f > MOST_SWEPT));
        fast.map_or(Ok(()), |value| Err(Error::TooFast { name: format!("{name}: frequency"), value }))
    })
}

/// Stiffness and damping of a part whose force is a function of its elongation.
fn factors(system: &System, part: Part) -> Option<[f64; 2]> {
    match part {
        Part::Spring(i) => Some([system.springs[i].stiffness, system.springs[i].damping]),
        Part::Stop(i) => match system.stops[i].law {
            StopLaw::Compliant { stiffness, damping, .. } => Some([stiffness, damping]),
            StopLaw::Rigid { .. } => None,
        },
        Part::Branch(i) => Some([system.branches[i].stiffness, 0.0]),
        Part::Friction(_) | Part::Load(_) => None,
    }
}

/// Checks the rates that a stiffness and a damping would each cause alone. The inertia of bodies
/// linked to a light body lowers its rates.
fn check_force(name: &str, elongation: &Elongation, [stiffness, damping]: [f64; 2]) -> Result<(), Error> {
    let compliance = elongation.column.norm_squared();
    let rate = |force: f64| if force != 0.0 { force.abs() * compliance } else { 0.0 };
    for (what, value, rate) in
        [("stiffness", stiffness, rate(stiffness).sqrt()), ("damping", damping, rate(damping))]
    {
        if rate.is_nan() || rate > MOST_RATE {
            return Err(Error::TooFast { name: format!("{name}.{what}"), value });
        }
    }
    Ok(())
}
