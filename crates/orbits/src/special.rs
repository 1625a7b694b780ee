//! Special points of described machines, from the condition that ceases to hold.

use super::branch::Special;
use super::conditions::Condition;
use super::place::Place;
use super::violation::name_of_output;
use super::word::{Letter, Word};
use crate::label::Label;
use vibro_machine::mode::Contact;

impl Special {
    /// The special point at which a condition ceases to hold.
    pub(super) fn of_condition(condition: Condition, word: &Word, place: &Place) -> Self {
        let system = place.assembly.system();
        let of = |contact: Contact| {
            let limit = if let Contact::Stop(i) = contact { system.stops[i].limit } else { None };
            if let Some(limit) = limit {
                let element = name_of_output(place, (limit.block, limit.output));
                return Self::new(Label::Saturation, element);
            }
            let label = match contact {
                Contact::Stop(_) => Label::Grazing,
                Contact::Friction(_) | Contact::Slider(_) => Label::Stick,
            };
            Self::new(label, place.assembly.name_of_contact(contact))
        };
        let element_of = |letter: &Letter| match (letter.watch(), letter.timed()) {
            (Some(watch), _) => of(watch.contact()).element,
            (None, timed) => timed.map_or_else(String::new, |own| own.owners(&place.assembly).join(" ")),
        };
        let crossing = |element: String| Self::new(Label::Crossing, element);
        match condition {
            // An event at a fixed time has no event function that rises.
            Condition::Rises { letter } => match word.letters[letter].watch() {
                Some(watch) => of(watch.contact()),
                None => crossing(element_of(&word.letters[letter])),
            },
            Condition::Stays { watch, .. } => of(watch.contact()),
            Condition::Changes { contact, .. } => of(contact),
            Condition::Limited { output, .. } => Self::new(Label::Saturation, name_of_output(place, output)),
            Condition::Corner { letter, ahead } => {
                let corner = word.corner(letter, ahead).map(|tick| tick.owner(&place.assembly));
                crossing(format!("{} {}", element_of(&word.letters[letter]), corner.unwrap_or_default()))
            }
            Condition::Together { letter, stop } => {
                let first = element_of(&word.letters[letter]);
                crossing(format!("{first} {}", place.assembly.name_of_stop(stop)))
            }
            Condition::Lasts { letter } if word.letters[letter].chatter.is_some() => {
                Self::new(Label::Chatter, element_of(&word.letters[letter]))
            }
            Condition::Lasts { letter } => {
                let [first, next] = [letter, (letter + 1) % word.len()].map(|k| &word.letters[k]);
                let contacts = [first, next].map(|own| own.watch().map(|watch| watch.contact()));
                match contacts {
                    [Some(first), Some(next)] if first == next => of(next),
                    _ => crossing(format!("{} {}", element_of(first), element_of(next))),
                }
            }
        }
    }
}
