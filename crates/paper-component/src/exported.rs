//! The component for the doors: its protocol for each version of FMI, and the errors that concern
//! a value.

use crate::component::settings::Settings;
use crate::component::variables::Edition;
use crate::component::{ComponentProblem, Protocol};
use crate::fmi2::description::{NUMBERING, guid};
use crate::fmi3::description as fmi3;
use fmi_doors::{Instantiation, Refusal, Version};

impl Refusal for ComponentProblem {
    fn is_of_a_value(&self) -> bool {
        match self {
            Self::Model(_) | Self::ClosedForm { .. } | Self::Overflow { .. } | Self::Derivative { .. } => {
                true
            }
            Self::Door(problem) => problem.is_of_a_value(),
            _ => false,
        }
    }
}

impl Protocol {
    /// The protocol for the version and the description of the requested instance.
    ///
    /// # Errors
    /// If the token does not belong to a description of this build.
    pub(crate) fn of(request: &Instantiation<'_>) -> Result<Self, ComponentProblem> {
        let handling = request.handling;
        match request.version {
            Version::Fmi2 => {
                request.check_token(&guid())?;
                let (numbering, start, edition) = (NUMBERING, Settings::default(), Edition::Every);
                Ok(Self { numbering, handling, start, edition })
            }
            Version::Fmi3 => {
                let main = || request.wrong_token(&fmi3::instantiation_token(fmi3::MAIN));
                let edition = fmi3::edition_of(request.token).ok_or_else(main)?;
                let (numbering, start) = (fmi3::numbering(edition), fmi3::start_settings());
                Ok(Self { numbering, handling, start, edition })
            }
        }
    }
}
