//! Branches of orbits of described machines as plain data.

use super::conditions::Condition;
use super::orbit::{Orbit, Stability};
use super::place::Place;
use super::problem::Problem;
use super::violation::name_of_output;
use super::word::{Letter, Word};
use crate::label::Label;
use nalgebra::{Complex, DVector};
use vibro_machine::mode::Contact;

/// Kind of a special point of a described machine's branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One of those of the 3-DOF machine.
    As(Label),
    /// ST: a friction begins or ceases to stick, or slips once more.
    Stick,
    /// CC: two events of different elements change places.
    Crossing,
    /// SA: an output of a block comes to a limit or leaves it, at a sample or between.
    Saturation,
}

impl Kind {
    /// The two letters of the label.
    pub fn name(self) -> &'static str {
        match self {
            Self::As(label) => label.name(),
            Self::Stick => "ST",
            Self::Crossing => "CC",
            Self::Saturation => "SA",
        }
    }
}

/// A special point of a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Special {
    /// Its kind.
    pub kind: Kind,
    /// The element that is meant, as `stop.NAME`; empty where none is.
    pub element: String,
}

impl Special {
    pub(super) fn of(label: Label) -> Self {
        Self { kind: Kind::As(label), element: String::new() }
    }

    /// The special point at which a condition ceases to hold.
    pub(super) fn of_condition(condition: Condition, word: &Word, place: &Place) -> Self {
        let system = place.assembly.system();
        let of = |contact: Contact| {
            let limit = if let Contact::Stop(i) = contact { system.stops[i].limit } else { None };
            if let Some(limit) = limit {
                let element = name_of_output(place, (limit.block, limit.output));
                return Self { kind: Kind::Saturation, element };
            }
            let kind = match contact {
                Contact::Stop(_) => Kind::As(Label::Grazing),
                Contact::Friction(_) | Contact::Slider(_) => Kind::Stick,
            };
            Self { kind, element: place.assembly.name_of_contact(contact) }
        };
        let element_of = |letter: &Letter| match (letter.watch(), letter.timed()) {
            (Some(watch), _) => of(watch.contact()).element,
            (None, timed) => timed.map_or_else(String::new, |own| own.owners(&place.assembly).join(" ")),
        };
        let crossing = |element: String| Self { kind: Kind::Crossing, element };
        match condition {
            // A letter of a fixed time has no functional that rises.
            Condition::Rises { letter } => match word.letters[letter].watch() {
                Some(watch) => of(watch.contact()),
                None => crossing(element_of(&word.letters[letter])),
            },
            Condition::Stays { watch, .. } => of(watch.contact()),
            Condition::Changes { contact, .. } => of(contact),
            Condition::Limited { output, .. } => {
                Self { kind: Kind::Saturation, element: name_of_output(place, output) }
            }
            Condition::Corner { letter, ahead } => {
                let corner = word.corner(letter, ahead).map(|tick| tick.owner(&place.assembly));
                crossing(format!("{} {}", element_of(&word.letters[letter]), corner.unwrap_or_default()))
            }
            Condition::Together { letter, stop } => {
                let first = element_of(&word.letters[letter]);
                crossing(format!("{first} {}", place.assembly.name_of_stop(stop)))
            }
            Condition::Lasts { letter } if word.letters[letter].chatter.is_some() => {
                let element = element_of(&word.letters[letter]);
                Self { kind: Kind::As(Label::Chatter), element }
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

/// One orbit of a branch.
#[derive(Clone, Debug)]
pub struct OrbitPoint {
    /// The parameter, SI.
    pub value: f64,
    /// The orbit's period, s.
    pub period: f64,
    /// The multipliers that are not 1 by theory, largest first.
    pub multipliers: Vec<Complex<f64>>,
    /// Whether the orbit attracts its neighbourhood; at a special point what holds on the way to
    /// the next point.
    pub stability: Stability,
    /// The special point here, if it is one.
    pub special: Option<Special>,
    pub(super) u: DVector<f64>,
}

impl OrbitPoint {
    /// Whether it is a special point with a label.
    pub(super) fn is(&self, label: Label) -> bool {
        self.special.as_ref().is_some_and(|special| special.kind == Kind::As(label))
    }
}

/// A connected family of orbits along a parameter.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Index in the list of branches.
    pub id: usize,
    /// Index of the branch and of its point from which this branch begins; `None` for one that
    /// starts from a motion.
    pub parent: Option<(usize, usize)>,
    /// Number of switches, at doublings, crossings and touches of rigid stops, since a motion.
    pub depth: u32,
    /// Points in order.
    pub points: Vec<OrbitPoint>,
    /// Whether the branch ends where it begins.
    pub closed: bool,
    /// The point from which it was followed in both directions.
    pub(super) began_at: Option<usize>,
    pub(super) problem: Problem,
}

impl Branch {
    /// The events of all its orbits.
    pub fn word(&self) -> &Word {
        &self.problem.word
    }

    /// The orbit of one of its points; `None` where it cannot be computed again.
    pub fn orbit(&self, point: &OrbitPoint) -> Option<Orbit> {
        let place = self.problem.place(&point.u).ok()?;
        Orbit::at(self.problem.clone(), place, point.u.clone()).ok()
    }
}
