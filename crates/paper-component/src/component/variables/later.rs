//! Constructors of rows added after the first version: variables that are not outputs, and
//! variables of later descriptions only.

use super::bases::Edition;
use super::columns::{Access, Causality, Dependencies, Kind, Knowns, Reading, Variability, Variable};
use super::rows::{derivative_of, event_output, reading, real, row};
use super::sections::Section;
use crate::component::units::{self, RealType};
use crate::component::values::{OutputValues, Prediction, StepMatrices, Tick};

/// A variable that is read but is not an output.
const fn local(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    access: Access,
    dependencies: Dependencies,
) -> Variable {
    Variable { causality: Causality::Local, ..row(section, name, description, kind, access, dependencies) }
}

/// A variable about the next event. It is computed when it is read.
pub(super) const fn prediction(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    variability: Variability,
    get: fn(&Prediction) -> f64,
) -> Variable {
    let access = Access::Prediction(get);
    let row = local(Section::Contact, name, description, kind, access, Dependencies::NotUnknown);
    Variable { variability, ..row }
}

/// A variable for descriptions that list derivatives of states and event indicators.
const fn structural(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    reading: Reading,
    knowns: Knowns,
) -> Variable {
    let row = local(section, name, description, kind, Access::Output(reading), Dependencies::On(knowns));
    Variable { edition: Edition::Extended, ..row }
}

/// The derivative of a body's displacement, a variable separate from the velocity state with the
/// same value.
pub(super) const fn rate<const BODY: usize>(
    name: &'static str,
    of: &'static str,
    description: &'static str,
    velocity: Knowns,
) -> Variable {
    let kind = derivative_of(units::VELOCITY, of);
    structural(Section::Motion, name, description, kind, reading!(|m| m.v[BODY]), velocity)
}

/// An event indicator, without a dimension.
pub(super) const fn indicator<const I: usize>(
    name: &'static str,
    description: &'static str,
    knowns: Knowns,
) -> Variable {
    let reading = reading!(|m| m.indicators[I]);
    structural(Section::Contact, name, description, real(units::NUMBER), reading, knowns)
}

/// An array of the motion: one value for each body.
pub(super) const fn bodies(
    name: &'static str,
    description: &'static str,
    declared: RealType,
    get: fn(&OutputValues, usize) -> f64,
    knowns: Knowns,
) -> Variable {
    let access = Access::Elements(get);
    let row = local(Section::Motion, name, description, real(declared), access, Dependencies::On(knowns));
    Variable { edition: Edition::Arrays, dimensions: &[3], ..row }
}

/// A matrix of derivatives over the last step. It is continuous, since discrete variables change
/// at events only.
pub(super) const fn step_matrix(
    name: &'static str,
    description: &'static str,
    dimensions: &'static [usize],
    get: fn(&StepMatrices, usize) -> f64,
) -> Variable {
    let (kind, access) = (real(units::SENSITIVITY), Access::Step(get));
    let row = local(Section::Sensitivity, name, description, kind, access, Dependencies::NotUnknown);
    Variable { edition: Edition::Arrays, dimensions, ..row }
}

/// The clock of impacts, or a variable of this clock.
pub(super) const fn tick(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    get: fn(&Tick) -> f64,
) -> Variable {
    let row = event_output(Section::Clock, name, description, kind, |_| 0.0);
    Variable { edition: Edition::Clocked, access: Access::Tick(get), ..row }
}
