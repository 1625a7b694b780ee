//! Constructors of the table's rows. Each has a parameter for every column that its kind of
//! variable needs, so a row without such a column does not compile.

use super::bases::Edition;
use super::columns::DependencyKind::Dependent;
use super::columns::{
    Access, Causality, Dependencies, Initial, Initially, Kind, Knowns, Reading, Variability, Variable,
};
use super::sections::Section;
use crate::component::settings::{Derived, Settings};
use crate::component::units::{self, RealType};
use crate::component::values::OutputValues;
use vibro_impact::parameters::{FIELDS, Range};

/// An output's [`Reading`] from one expression: `reading!(|m| m.contact_force * m.v[1])`. The
/// expression may add, subtract and multiply.
macro_rules! reading {
    (|$m:ident| $value:expr) => {
        $crate::component::variables::columns::Reading {
            value: |$m: &$crate::component::values::OutputValues| $value,
            varied: Some(
                |$m: &$crate::component::values::OutputValues<$crate::component::values::Varied>| $value,
            ),
            jet: Some(|$m: &$crate::component::values::OutputValues<$crate::component::jets::Jet>| $value),
        }
    };
}
pub(super) use reading;

/// The parameters of a dimensionless group, by name.
macro_rules! of {
    ($($name:literal),*) => { &[$(($name, $crate::component::variables::columns::DependencyKind::Dependent)),*] };
}
pub(super) use of;

/// A Real with any finite value.
pub(super) const fn real(declared: RealType) -> Kind {
    Kind::Real { declared, range: Range::FINITE, nominal: None, derivative_of: None, reinit: false }
}

pub(super) const fn derivative_of(declared: RealType, of: &'static str) -> Kind {
    Kind::Real { declared, range: Range::FINITE, nominal: None, derivative_of: Some(of), reinit: false }
}

/// A continuous state, with the nominal value of all states.
const fn state(declared: RealType, derivative_of: Option<&'static str>, reinit: bool) -> Kind {
    Kind::Real { declared, range: Range::FINITE, nominal: Some(1.0), derivative_of, reinit }
}

/// The reference of a row before the table numbers it.
pub(super) const UNNUMBERED: u32 = u32::MAX;

/// A scalar that is read, changes at any time and is in every description.
pub(super) const fn row(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    access: Access,
    dependencies: Dependencies,
) -> Variable {
    Variable {
        reference: UNNUMBERED,
        name,
        description,
        section,
        edition: Edition::Every,
        dimensions: &[],
        symbol: None,
        causality: Causality::Output,
        variability: Variability::Continuous,
        initial: Some(Initial::Calculated),
        kind,
        access,
        dependencies,
        further: &[],
        initially: Initially::OnStartAnd(&[]),
        body: None,
    }
}

/// A variable that is set from outside; it has no dependencies.
const fn given(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    access: Access,
) -> Variable {
    let row = row(section, name, description, kind, access, Dependencies::NotUnknown);
    Variable { initial: None, initially: Initially::AsLater, ..row }
}

/// Time.
pub(super) const TIME: Variable = Variable {
    symbol: Some("t"),
    causality: Causality::Independent,
    ..given(Section::Time, "time", "Time", real(units::TIME), Access::Output(reading!(|m| m.time)))
};

fn get_field<const I: usize>(settings: &Settings) -> f64 {
    (FIELDS[I].get)(&settings.parameters)
}

/// Symbols of the physical parameters in docs/theory.md, in the order of [`FIELDS`].
const SYMBOLS: [&str; 13] =
    ["m1", "k1", "c1", "m2", "m3", "k3", "c3", "k23", "L", "kappa", "F10", "omega1", "phi"];

/// A physical parameter; name, meaning and range come from [`FIELDS`].
pub(super) const fn parameter<const I: usize>(variability: Variability, declared: RealType) -> Variable {
    let field = FIELDS[I];
    let kind = Kind::Real { declared, range: field.range, nominal: None, derivative_of: None, reinit: false };
    let get: fn(&Settings) -> f64 = get_field::<I>;
    let option = option(field.name, field.description, kind, get, |s, value| {
        (FIELDS[I].set)(&mut s.parameters, value);
    });
    Variable { section: Section::Parameters, variability, symbol: Some(SYMBOLS[I]), ..option }
}

/// A choice that is fixed after initialization.
pub(super) const fn option(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    get: fn(&Settings) -> f64,
    set: fn(&mut Settings, f64),
) -> Variable {
    Variable {
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        initial: Some(Initial::Exact),
        ..given(Section::Solution, name, description, kind, Access::Setting { get, set })
    }
}

/// An external force on a body.
pub(super) const fn load<const BODY: usize>(name: &'static str, description: &'static str) -> Variable {
    let access = Access::Setting {
        get: |s| s.loads.derivatives[BODY][0],
        // A new value without derivatives is held.
        set: |s, value| s.loads.derivatives[BODY] = [value, 0.0, 0.0, 0.0],
    };
    Variable {
        symbol: Some(["f1", "f2", "f3"][BODY]),
        causality: Causality::Input,
        body: Some(BODY),
        ..given(Section::Loads, name, description, real(units::FORCE), access)
    }
}

/// Displacement of a body; impacts may shift box and block by round-off to keep the gap exact.
/// Like every state, it depends only on itself.
pub(super) const fn position<const BODY: usize>(
    name: &'static str,
    description: &'static str,
    reinit: bool,
    itself: Knowns,
) -> Variable {
    let now = reading!(|m| m.x[BODY]);
    let access = Access::Start { get: |s| s.start.x[BODY], set: |s, value| s.start.x[BODY] = value, now };
    let kind = state(units::POSITION, None, reinit);
    let output = moving(name, description, kind, now, itself);
    Variable { initial: Some(Initial::Exact), access, symbol: Some(["x1", "x2", "x3"][BODY]), ..output }
}

/// Velocity of a body.
pub(super) const fn velocity<const BODY: usize>(
    name: &'static str,
    of: &'static str,
    description: &'static str,
    reinit: bool,
    itself: Knowns,
) -> Variable {
    let now = reading!(|m| m.v[BODY]);
    let access = Access::Start { get: |s| s.start.v[BODY], set: |s, value| s.start.v[BODY] = value, now };
    let kind = state(units::VELOCITY, Some(of), reinit);
    let output = moving(name, description, kind, now, itself);
    Variable { initial: Some(Initial::Exact), access, ..output }
}

/// Acceleration of a body.
pub(super) const fn acceleration<const BODY: usize>(
    name: &'static str,
    of: &'static str,
    description: &'static str,
    knowns: Knowns,
) -> Variable {
    let kind = derivative_of(units::ACCELERATION, of);
    moving(name, description, kind, reading!(|m| m.acceleration[BODY]), knowns)
}

/// An output of the motion.
const fn moving(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    reading: Reading,
    knowns: Knowns,
) -> Variable {
    output(Section::Motion, name, description, kind, reading, knowns)
}

/// An output that changes at any time. `knowns` are the inputs, continuous states and time on
/// which it depends. Its derivatives follow from its reading.
pub(super) const fn output(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    reading: Reading,
    knowns: Knowns,
) -> Variable {
    row(section, name, description, kind, Access::Output(reading), Dependencies::On(knowns))
}

/// An output that changes at events only. It keeps its value from the last event and has no
/// dependencies.
pub(super) const fn event_output(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    value: fn(&OutputValues) -> f64,
) -> Variable {
    let reading = Reading { value, varied: None, jet: None };
    let output = output(section, name, description, kind, reading, &[]);
    Variable { variability: Variability::Discrete, initially: Initially::On(&[]), ..output }
}

/// A variable that follows from the parameters.
const fn derived(
    section: Section,
    name: &'static str,
    description: &'static str,
    kind: Kind,
    get: fn(&Derived) -> f64,
    knowns: Knowns,
) -> Variable {
    let row = row(section, name, description, kind, Access::Derived(get), Dependencies::On(knowns));
    Variable {
        causality: Causality::CalculatedParameter,
        variability: Variability::Tunable,
        initially: Initially::AsLater,
        ..row
    }
}

/// A dimensionless group, made of the parameters in `knowns`.
pub(super) const fn group(
    name: &'static str,
    description: &'static str,
    get: fn(&Derived) -> f64,
    knowns: Knowns,
) -> Variable {
    let number = real(units::NUMBER);
    derived(Section::Groups, name, description, number, get, knowns)
}

/// A dimensionless group of fixed parameters.
pub(super) const fn fixed_group(
    name: &'static str,
    description: &'static str,
    get: fn(&Derived) -> f64,
    knowns: Knowns,
) -> Variable {
    Variable { variability: Variability::Fixed, ..group(name, description, get, knowns) }
}

/// A number of the steady state, 0 if none exists. It depends on the [`DECIDING`] parameters.
pub(super) const fn steady(
    name: &'static str,
    description: &'static str,
    declared: RealType,
    get: fn(&Derived) -> f64,
) -> Variable {
    derived(Section::Steady, name, description, real(declared), get, STEADY)
}

/// A test of the steady state.
pub(super) const fn flag(
    name: &'static str,
    description: &'static str,
    get: fn(&Derived) -> f64,
) -> Variable {
    derived(Section::Steady, name, description, Kind::Boolean, get, STEADY)
}

/// A row with further knowns.
pub(super) const fn by(further: &'static [&'static str], row: Variable) -> Variable {
    Variable { further, ..row }
}

/// A row with the dependencies in initialization of an [`Initially`].
pub(super) const fn at_start(initially: Initially, row: Variable) -> Variable {
    Variable { initially, ..row }
}

/// Parameters of box and block, secondary oscillator, coupling, stops, and drive.
pub(super) const OF_PAIR: [&str; 4] = ["box.m", "box.k", "box.c", "block.m"];
pub(super) const OF_SECONDARY: [&str; 3] = ["secondary.m", "secondary.k", "secondary.c"];
pub(super) const OF_COUPLING: [&str; 1] = ["coupling.k"];
pub(super) const OF_STOPS: [&str; 2] = ["stop.gap", "stop.restitution"];
pub(super) const OF_DRIVE: [&str; 3] = ["drive.amplitude", "drive.frequency", "drive.phase"];

/// Lists of names as one; `N` is the number of all names.
pub(super) const fn join<const N: usize>(lists: &[&[&'static str]]) -> [&'static str; N] {
    let mut all = [""; N];
    let (mut list, mut place) = (0, 0);
    while list < lists.len() {
        let mut i = 0;
        while i < lists[list].len() {
            all[place] = lists[list][i];
            (i, place) = (i + 1, place + 1);
        }
        list += 1;
    }
    assert!(place == N, "another number of names");
    all
}

/// The parameters that determine a steady state: all except the drive's phase, which only shifts
/// the motion in time.
const DECIDING: [&str; 12] =
    join(&[&OF_PAIR, &OF_SECONDARY, &OF_COUPLING, &OF_STOPS, &["drive.amplitude", "drive.frequency"]]);

/// [`DECIDING`] as knowns.
const STEADY: Knowns = &{
    let mut knowns = [("", Dependent); DECIDING.len()];
    let mut i = 0;
    while i < knowns.len() {
        knowns[i].0 = DECIDING[i];
        i += 1;
    }
    knowns
};

/// Variables that determine a closed form. In the closed-form modes and with `startOnOrbit` they
/// determine the start; the start values have no effect.
pub const START: &[&str] = &join::<16>(&[&DECIDING, &["time", "drive.phase", "mode", "startOnOrbit"]]);

/// All knowns, on which accumulated work and energies depend.
pub(super) const ALL: Knowns = &[
    ("time", Dependent),
    ("box.f", Dependent),
    ("block.f", Dependent),
    ("secondary.f", Dependent),
    ("box.s", Dependent),
    ("box.v", Dependent),
    ("block.s", Dependent),
    ("block.v", Dependent),
    ("secondary.s", Dependent),
    ("secondary.v", Dependent),
];

/// The bodies' displacements and velocities, the last six of [`ALL`].
pub(super) const STATES: Knowns = ALL.split_at(4).1;
