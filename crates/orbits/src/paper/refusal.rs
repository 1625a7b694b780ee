//! Errors for words and machines without orbits.

use super::system::System;
use crate::obstacle::Obstacle;
use crate::stop_word::OrbitWord;
use vibro_studies::Error;

impl Obstacle {
    /// Refuses a word for which a machine has no orbit, whatever the phases.
    ///
    /// # Errors
    /// [`Asymmetric`](Self::Asymmetric) if the word is half of a symmetric orbit and the machine
    /// has loads; [`Unbalanced`](Self::Unbalanced) if the impulses of the word cannot balance the
    /// load.
    pub fn check(system: &System, word: &OrbitWord) -> Result<(), Self> {
        if word.closing() < 0 && !system.is_symmetric() {
            return Err(Self::Asymmetric);
        }
        if system.balances(word) { Ok(()) } else { Err(Self::Unbalanced) }
    }

    /// Converts the reason for a failed search of an orbit to an error.
    pub fn error(self, system: &System, word: &OrbitWord) -> Error {
        let no_orbit = |reason: &str| word.no_orbit(reason);
        match self {
            Self::Order => no_orbit("the order of the impacts changes; try another guess of their phases"),
            Self::NoConvergence => {
                no_orbit("Newton's method does not converge; try a better guess of the phases")
            }
            Self::OtherMachine => no_orbit(
                "the phases do not belong to an orbit of this machine; use the machine of the \
                 point, with the same parameters and loads",
            ),
            Self::Asymmetric => no_orbit(
                "a word that closes with - is half of a symmetric orbit, but a machine under \
                 constant loads has no symmetric orbits; give the whole word, closing with +",
            ),
            Self::Unbalanced => {
                no_orbit(if !system.has_free_block() && system.parameters().box_stiffness == 0.0 {
                    "no spring balances impulses on the box (box.k = 0), so the word must contain \
                     both U and L"
                } else if !system.has_free_block() {
                    "no spring balances impulses on the block and the secondary oscillator \
                     (secondary.k = 0), so the word must contain both U and L"
                } else if system.pull() == 0.0 {
                    "a block without a spring (coupling.k = 0) is moved by impacts only, so the \
                     word must contain both U and L"
                } else if system.pull() < 0.0 {
                    "only the lower stop can hold a block without a spring (coupling.k = 0) \
                     against load.block < 0, so the word must contain an L"
                } else {
                    "only the upper stop can hold a block without a spring (coupling.k = 0) \
                     against load.block > 0, so the word must contain a U"
                })
            }
            Self::Singular => system.singular().into(),
            Self::Refused(error) => error,
        }
    }
}
