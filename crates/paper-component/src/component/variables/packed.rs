//! The table of variables in packed form for getters and setters, made at compile time.

use super::bases::{Base, Bases};
use super::columns::{Access, Causality, Initial, Kind, Variability, Variable};
use super::same;
use super::table::{COUNT, VARIABLES};
use crate::component::settings::{Derived, Settings};
use crate::component::values::{OutputValues, Prediction, StepMatrices, Tick};
use vibro_impact::parameters::FIELDS;

/// Source of a variable's value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Get {
    /// From the settings.
    Setting(fn(&Settings) -> f64),
    /// From the settings until initialization ends, then from the motion.
    Start(fn(&Settings) -> f64, fn(&OutputValues) -> f64),
    /// From the motion.
    Output(fn(&OutputValues) -> f64),
    /// From the values that follow from the parameters.
    Derived(fn(&Derived) -> f64),
    /// From the prediction of the next event.
    Prediction(fn(&Prediction) -> f64),
    /// The shown value of the clock of impacts.
    Tick(fn(&Tick) -> f64),
    /// An array with this number of elements, from the motion.
    Elements(usize, fn(&OutputValues, usize) -> f64),
    /// An array with this number of elements, from the derivatives over the last step.
    Step(usize, fn(&StepMatrices, usize) -> f64),
}

/// Destination to which a variable is written.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Set {
    /// A setting.
    Setting(fn(&mut Settings, f64)),
    /// A start value, or a continuous state once there is a motion.
    Start(fn(&mut Settings, f64)),
    /// Never written.
    Never,
}

/// The properties of a variable that a getter needs, packed: ten variables fit into a few cache
/// lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader {
    /// Base type.
    pub(crate) base: Base,
    /// The quantity that must be up to date before the variable is read: one of the bits below, or
    /// none.
    pub(crate) needs: u8,
    /// Source of its value.
    pub(crate) get: Get,
}

impl Reader {
    /// Needs the motion.
    pub(crate) const MOTION: u8 = 1;
    /// Needs the motion once there is one.
    pub(crate) const START: u8 = 2;
    /// Needs the values that follow from the parameters.
    pub(crate) const DERIVED: u8 = 4;
    /// Needs the prediction of the next event.
    pub(crate) const PREDICTION: u8 = 8;
    /// Needs the derivatives over the last step.
    pub(crate) const STEP: u8 = 16;

    const fn of(variable: &Variable) -> Self {
        let (needs, get) = match variable.access {
            Access::Output(reading) => (Self::MOTION, Get::Output(reading.value)),
            Access::Start { get, now, .. } => (Self::START, Get::Start(get, now.value)),
            Access::Derived(get) => (Self::DERIVED, Get::Derived(get)),
            Access::Setting { get, .. } => (0, Get::Setting(get)),
            Access::Prediction(get) => (Self::PREDICTION, Get::Prediction(get)),
            Access::Tick(get) => (Self::MOTION, Get::Tick(get)),
            Access::Elements(get) => (Self::MOTION, Get::Elements(variable.size(), get)),
            Access::Step(get) => (Self::STEP, Get::Step(variable.size(), get)),
        };
        Self { base: variable.base(), needs, get }
    }
}

/// The readers of all variables, by index.
pub(crate) static READERS: [Reader; COUNT] = {
    let mut readers = [Reader::of(&VARIABLES[0]); COUNT];
    let mut i = 0;
    while i < COUNT {
        readers[i] = Reader::of(&VARIABLES[i]);
        i += 1;
    }
    readers
};

/// The properties of a variable that a setter needs, packed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Writer {
    /// Base type.
    base: Base,
    /// Phases that allow setting the variable: the bits below.
    when: u8,
    /// Whether it is an input.
    pub(crate) input: bool,
    /// Range of values that need no further check. The smallest value is above the largest if
    /// every value needs a check.
    range: (f64, f64),
    /// Destination of its value.
    pub(crate) set: Set,
    /// Bit of a physical parameter in the order of `FIELDS`; 0 for other variables.
    pub(crate) given: u16,
}

impl Writer {
    /// Before and during initialization.
    pub(crate) const INITIAL: u8 = 1;
    /// Between events, while a host's solver integrates.
    pub(crate) const CONTINUOUS: u8 = 2;
    /// At communication points and events.
    pub(crate) const EVENT: u8 = 4;
    /// At events in Model Exchange, for states that events do not change, in protocols that allow
    /// it.
    pub(crate) const UNCHANGED_STATES: u8 = 8;

    /// The phases that allow setting a variable. Inputs are also accepted before initialization,
    /// although the standards keep their start values there: several hosts set them there.
    const fn of(variable: &Variable) -> Self {
        let input = matches!(variable.causality, Causality::Input);
        let parameter = matches!(variable.causality, Causality::Parameter);
        let tunable = parameter && matches!(variable.variability, Variability::Tunable);
        let mut when = 0;
        if input || matches!(variable.initial, Some(Initial::Exact)) {
            when |= Self::INITIAL;
        }
        if input || matches!(variable.access, Access::Start { .. }) {
            when |= Self::CONTINUOUS;
        }
        if input || tunable {
            when |= Self::EVENT;
        }
        if let (Access::Start { .. }, Kind::Real { reinit: false, .. }) = (variable.access, variable.kind) {
            when |= Self::UNCHANGED_STATES;
        }
        let range = match variable.kind {
            Kind::Real { range, .. } => (
                if range.open_min { range.min.next_up() } else { range.min.max(f64::MIN) },
                range.max.min(f64::MAX),
            ),
            _ => (1.0, 0.0),
        };
        let set = match variable.access {
            Access::Setting { set, .. } => Set::Setting(set),
            Access::Start { set, .. } => Set::Start(set),
            _ => Set::Never,
        };
        let (mut given, mut i) = (0, 0);
        while i < FIELDS.len() {
            if same(FIELDS[i].name, variable.name) {
                given = 1 << i;
            }
            i += 1;
        }
        Self { base: variable.base(), when, input, range, set, given }
    }

    /// Whether the variable may be set in the phase of the bit `when`.
    pub(crate) fn settable(&self, when: u8) -> bool {
        self.when & when != 0
    }

    /// Whether a value may be set in the phase of the bit `when` without a further check.
    #[inline]
    pub(crate) fn takes(&self, bases: Bases, when: u8, value: f64) -> bool {
        bases.contains(self.base) && self.settable(when) && self.range.0 <= value && value <= self.range.1
    }
}

/// The writers of all variables, by index.
pub(crate) static WRITERS: [Writer; COUNT] = {
    let mut writers = [Writer::of(&VARIABLES[0]); COUNT];
    let mut i = 0;
    while i < COUNT {
        writers[i] = Writer::of(&VARIABLES[i]);
        i += 1;
    }
    writers
};
