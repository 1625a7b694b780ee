//! Conditions that an orbit violates, in words.

use super::conditions::Condition;
use super::orbit::Orbit;
use super::place::Place;
use super::word::Word;

impl Orbit {
    /// The reason why the orbit is not a motion of the machine, in words.
    pub fn violation(&self) -> Option<String> {
        self.broken().map(|(condition, _)| condition.in_words(self.word(), self.place()))
    }
}

impl Condition {
    /// The condition's failure in words.
    pub(super) fn in_words(&self, word: &Word, place: &Place) -> String {
        let assembly = &place.assembly;
        match *self {
            Self::Rises { letter } => format!("{} is not reached", word.letters[letter].in_words(assembly)),
            Self::Lasts { letter } => {
                format!("the flight after {} has no duration", word.letters[letter].in_words(assembly))
            }
            Self::Together { letter, stop } => {
                let words = word.letters[letter].in_words(assembly);
                format!("the elongation of {} is not its gap at {words}", assembly.name_of_stop(stop))
            }
            Self::Corner { letter, ahead } => {
                let corner = word.corner(letter, ahead).map(|tick| tick.owner(assembly)).unwrap_or_default();
                let words = word.letters[letter].in_words(assembly);
                format!("{words} is on the wrong side of a knot of {corner}")
            }
            Self::Changes { letter, contact } => {
                let words = word.letters[letter].in_words(assembly);
                format!("{} does not have to change its state at {words}", assembly.name_of_contact(contact))
            }
            Self::Limited { letter, output, .. } => {
                let words = word.letters[letter].in_words(assembly);
                format!("{} is on the wrong side of its limits at {words}", name_of_output(place, output))
            }
            Self::Stays { letter, watch, .. } => {
                let element = assembly.name_of_contact(watch.contact());
                match word.letters.get(letter) {
                    Some(letter) => {
                        format!("{element} has an additional event after {}", letter.in_words(assembly))
                    }
                    None => format!("{element} has an additional event"),
                }
            }
        }
    }
}

/// Dotted name of an output of a block.
pub(super) fn name_of_output(place: &Place, output: (usize, usize)) -> String {
    format!("block.{}", place.assembly.description.name_of_output(output))
}
