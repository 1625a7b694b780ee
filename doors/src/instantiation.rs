//! What a host asks for when it makes an instance, and what a door asks of a variable.

use crate::ffi::Fault;
use crate::life::{EventHandling, Interface, Life};
use crate::problem::Problem;
use std::borrow::Cow;

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

/// What a host asks for when it makes an instance (FMI 2.0, 2.1.5; FMI 3.0.2, 2.3.1).
#[derive(Clone, Copy, Debug)]
pub struct Instantiation<'a> {
    /// By which version it asks.
    pub version: Version,
    /// How the instance will be used.
    pub interface: Interface,
    /// What the host does about events.
    pub handling: EventHandling,
    /// Name of the instance: not blank.
    pub name: &'a str,
    /// What tells descriptions apart: `fmuGUID`, `instantiationToken`.
    pub token: &'a str,
    /// Where the files of the FMU's folder `resources` are, as the host says it: a URI in FMI 2.0, a path in FMI 3.0; none where
    /// it says nothing.
    pub resources: Option<&'a str>,
}

impl Instantiation<'_> {
    /// Refuses a token that is not `own`, by the name that the version has for it.
    ///
    /// # Errors
    /// [`Problem::Fault`].
    pub fn check_token(&self, own: &str) -> Result<(), Problem> {
        if self.token == own { Ok(()) } else { Err(self.wrong_token(own)) }
    }

    /// That the token is none of this library's.
    pub fn wrong_token(&self, allowed: &str) -> Problem {
        let argument = match self.version {
            Version::Fmi2 => "fmuGUID",
            Version::Fmi3 => "instantiationToken",
        };
        let (value, allowed) = (self.token.to_owned(), allowed.to_owned());
        Problem::Fault(Fault::Text { argument, value, allowed })
    }

    /// The life of the instance that is to be made.
    pub fn life(&self) -> Life {
        Life::new(self.interface, self.handling)
    }
}

/// What a door must know of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// Whether it is a continuous input, which may be set within a step.
    pub continuous_input: bool,
    /// Whether its description has `intermediateUpdate="true"` (FMI 3.0.2, 4.2.2).
    pub intermediate_update: bool,
}
