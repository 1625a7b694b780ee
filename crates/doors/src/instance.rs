//! The part of an instance that both versions share: the component, its saved states, and the log
//! categories that the host has enabled.

use crate::component::Component;
use crate::ffi::Fault;
use crate::ffi::handles::Handles;
use crate::instantiation::Instantiation;
use crate::life::Phase;
use crate::log::Categories;
use crate::messages::{Logger, Sink, with_category};
use crate::problem::Refused;

/// An instance of the component `C`, with the common behaviour of FMI 2.0 and 3.0. The doors add
/// the permitted calls of each state, and the differences between the versions.
#[derive(Debug)]
pub struct CommonInstance<C: Component> {
    /// The component.
    pub component: C,
    enabled: Categories,
    states: Handles<C::State>,
}

impl<C: Component> CommonInstance<C> {
    /// A new instance, for `fmi2Instantiate` and `fmi3Instantiate…` (FMI 2.0, 2.1.5; FMI 3.0.2,
    /// 2.3.1).
    ///
    /// # Errors
    /// If the name is blank, or the component refuses.
    pub fn new(request: &Instantiation<'_>, enabled: Categories) -> Result<Self, Refused<C::Problem>> {
        if request.name.trim().is_empty() {
            return Err(Fault::Text {
                argument: "instanceName",
                value: request.name.to_owned(),
                allowed: "text with at least one character that is not white space".to_owned(),
            }
            .into());
        }
        Ok(Self { component: C::instantiate(request)?, enabled, states: Handles::default() })
    }

    /// Lets the component log how `function` made it.
    pub fn tell(&self, function: &'static str, sink: &mut dyn Sink) {
        self.component.tell_at_instantiation(&mut self.log(sink, function));
    }

    /// Marks the component unusable after a panic.
    pub fn break_down(&mut self) {
        self.component.life_mut().phase = Phase::Broken;
    }

    /// Largest number of elements of one call.
    #[inline]
    pub fn max_count(&self) -> usize {
        C::MAX_COUNT
    }

    /// Number of continuous states.
    #[inline]
    pub fn number_of_states(&self) -> usize {
        self.component.nominals().as_ref().len()
    }

    /// The enabled log categories.
    pub fn enabled(&self) -> Categories {
        self.enabled
    }

    /// The log of one call of the function of that C name.
    #[inline]
    pub fn log<'a>(&self, sink: &'a mut dyn Sink, function: &'static str) -> Logger<'a> {
        Logger { sink, enabled: self.enabled, function }
    }

    /// `fmi2SetDebugLogging` and `fmi3SetDebugLogging` (FMI 2.0, 2.1.5; FMI 3.0.2, 2.3.1). No
    /// names mean all categories.
    ///
    /// # Errors
    /// [`Fault::Text`] if a category is unknown; the error of reading a name. Then nothing has
    /// changed.
    pub fn set_debug_logging<S: AsRef<str>>(
        &mut self,
        on: bool,
        categories: impl IntoIterator<Item = Result<S, Fault>>,
    ) -> Result<(), Fault> {
        let (mut enabled, mut any) = (self.enabled, false);
        for name in categories {
            any = true;
            enabled = with_category(enabled, name?.as_ref(), on)?;
        }
        let all = if on { Categories::ALL } else { Categories::NONE };
        self.enabled = if any { enabled } else { all };
        Ok(())
    }

    /// `fmi2GetFMUstate` and `fmi3GetFMUState` (FMI 2.0, 2.1.8; FMI 3.0.2, 2.2.7.4): saves into
    /// the state of `handle`, or into a new state if `handle` is zero.
    ///
    /// # Errors
    /// If the handle is neither zero nor a handle of this instance.
    pub fn save(&mut self, handle: usize) -> Result<usize, Refused<C::Problem>> {
        if handle == 0 {
            return Ok(self.states.keep(self.component.save()?, 0)?);
        }
        *self.states.get_mut(handle)? = self.component.save()?;
        Ok(handle)
    }

    /// `fmi2SetFMUstate` and `fmi3SetFMUState`.
    ///
    /// # Errors
    /// If the handle is not a handle of this instance, and as [`restore`](crate::Model::restore).
    pub fn restore(&mut self, handle: usize) -> Result<(), Refused<C::Problem>> {
        Ok(self.component.restore(self.states.get(handle)?)?)
    }

    /// `fmi2FreeFMUstate` and `fmi3FreeFMUState`.
    ///
    /// # Errors
    /// For a handle of another instance.
    pub fn free(&mut self, handle: usize) -> Result<(), Fault> {
        self.states.free(handle)
    }

    /// `fmi2SerializeFMUstate` and `fmi3SerializeFMUState`.
    ///
    /// # Errors
    /// For a handle of another instance.
    pub fn serialized(&self, handle: usize) -> Result<Vec<u8>, Refused<C::Problem>> {
        Ok(self.component.serialize(self.states.get(handle)?)?)
    }

    /// `fmi2DeSerializeFMUstate` and `fmi3DeserializeFMUState`: reads into the state of `handle`
    /// if this instance has it, otherwise into a new state.
    ///
    /// # Errors
    /// As [`deserialize`](crate::Model::deserialize).
    pub fn deserialize(&mut self, serialized: &[u8], handle: usize) -> Result<usize, Refused<C::Problem>> {
        Ok(self.states.keep_new(self.component.deserialize(serialized)?, handle)?)
    }
}
