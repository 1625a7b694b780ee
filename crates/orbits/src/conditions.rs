//! Conditions under which a cycle is a motion of the machine: it reaches each event, and no other.

use super::cycle::{Cycle, Leg};
use super::place::Place;
use super::timed::beyond;
use super::word::{Letter, Word};
use vibro_machine::mode::{Contact, ElementState, FrictionState, Mode, StopState, Watch};
use vibro_machine::system::System;
use vibro_studies::flight::{Series, coefficients, dot, turning_points};

/// Value of an event function, relative to its terms, that counts as zero at an event.
const TOUCHING: f64 = 1e-9;
/// Tolerance of a condition's value, relative to its terms: rounding.
const ROUNDING: f64 = 1e-12;

/// A condition on a flight or an event of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// Event `letter` is reached with a rising event function.
    Rises {
        /// Index of the event in the word.
        letter: usize,
    },
    /// The flight after event `letter` has a positive duration.
    Lasts {
        /// Index of the event in the word.
        letter: usize,
    },
    /// A further stop hit by event `letter` is at its gap.
    Together {
        /// Index of the event in the word.
        letter: usize,
        /// The stop.
        stop: usize,
    },
    /// A contact that changes with event `letter`, at a fixed time or with another contact, could
    /// not keep its state; a friction element that reverses could not stick.
    Changes {
        /// Index of the event in the word.
        letter: usize,
        /// The contact; at a fixed time the first one.
        contact: Contact,
    },
    /// A value limited by a sample stays on its side of the limits.
    Limited {
        /// Index of the sample in the word.
        letter: usize,
        /// Index among the sample's limited values.
        place: usize,
        /// The block and its output.
        output: (usize, usize),
    },
    /// Event `letter` stays on its side of a corner of a signal.
    Corner {
        /// Index of the event in the word.
        letter: usize,
        /// Whether the corner comes after it.
        ahead: bool,
    },
    /// No other event function reaches zero in the flight after event `letter`.
    Stays {
        /// Index of the event in the word.
        letter: usize,
        /// The event function.
        watch: Watch,
        /// Index among the event functions of the mode.
        place: usize,
    },
}

impl Condition {
    /// Whether a value shows that the condition does not hold. Within rounding, a zero value is a
    /// permitted touch during a flight. At an event it means zero speed, force or rate, so the
    /// event does not happen.
    pub(super) fn fails(&self, value: f64) -> bool {
        match self {
            Self::Stays { .. } => value < -ROUNDING,
            Self::Rises { .. } | Self::Changes { .. } => value <= ROUNDING,
            _ => value <= 0.0,
        }
    }

    /// Rank of the condition: the lowest rank names a point at which several conditions cease to
    /// hold. An impact at zero speed comes with further touches of its stop, and two events that
    /// change order come with further events.
    pub(super) fn rank(&self) -> usize {
        match self {
            Self::Rises { .. } => 0,
            Self::Stays { .. } => 2,
            _ => 1,
        }
    }

    /// Whether the condition ceases to hold where a rigid stop is touched at zero speed.
    pub(super) fn touches_rigid_stop(&self, word: &Word, system: &System) -> bool {
        let watch = match *self {
            Self::Rises { letter } => word.letters[letter].watch(),
            Self::Stays { watch, .. } => Some(watch),
            _ => None,
        };
        matches!(watch, Some(Watch::Meets(stop)) if system.stops[stop].keeps_gap())
    }
}

impl Cycle {
    /// All conditions under which the cycle is a motion of the machine, each with a value that is
    /// positive if it holds. Values of event functions are relative to their terms.
    pub(super) fn conditions(&self, place: &Place, word: &Word) -> Vec<(Condition, f64)> {
        let mut all = Vec::new();
        if word.is_empty() {
            self.add_peaks(0, word, TOUCHING, &mut all);
            return all;
        }
        let sizes: Vec<Vec<f64>> =
            (0..self.legs.len()).map(|k| self.add_peaks(k, word, TOUCHING, &mut all)).collect();
        for letter in 0..self.legs.len() {
            let before = (letter + sizes.len() - 1) % sizes.len();
            self.add_event(letter, (place, word), (&sizes[before], TOUCHING), &mut all);
        }
        all
    }

    /// The value of one condition; `None` if its flight does not have it. Also valid near an
    /// orbit, where the functions of events are not exactly zero.
    pub(super) fn value_of(&self, condition: Condition, place: &Place, word: &Word) -> Option<f64> {
        let mut all = Vec::new();
        match condition {
            Condition::Stays { letter, .. } => drop(self.add_peaks(letter, word, f64::INFINITY, &mut all)),
            Condition::Rises { letter }
            | Condition::Lasts { letter }
            | Condition::Changes { letter, .. }
            | Condition::Limited { letter, .. }
            | Condition::Corner { letter, .. }
            | Condition::Together { letter, .. } => {
                let before = (letter + self.legs.len() - 1) % self.legs.len();
                let sizes = self.add_peaks(before, word, f64::INFINITY, &mut all);
                self.add_event(letter, (place, word), (&sizes, f64::INFINITY), &mut all);
            }
        }
        all.into_iter().find(|(own, _)| *own == condition).map(|(_, value)| value)
    }

    /// Adds the conditions of event `letter` and the duration of the flight after it. `sizes` are
    /// the sizes of the event functions in the flight before it. Up to the rate `zero`, relative
    /// to its terms, a contact counts as held.
    fn add_event(
        &self,
        letter: usize,
        (place, word): (&Place, &Word),
        (sizes, zero): (&[f64], f64),
        all: &mut Vec<(Condition, f64)>,
    ) {
        let period = self.period();
        all.push((Condition::Lasts { letter }, self.legs[letter].span / period));
        if word.letters[letter].timed().is_some() {
            return self.add_fixed(letter, place, word, all);
        }
        let before = self.before(letter);
        let size = before.ending.map_or(0.0, |place| sizes[place]).max(f64::MIN_POSITIVE);
        all.push((Condition::Rises { letter }, self.rise(letter) * period / size));
        for ahead in [false, true] {
            let distance = word.distance((place.assembly.system(), before.time + before.span), letter, ahead);
            all.extend(distance.map(|own| (Condition::Corner { letter, ahead }, own / period)));
        }
        let own = &word.letters[letter];
        let system = place.assembly.system();
        let after = self.after(letter);
        let leaving: Vec<ElementState> = leaving(own).collect();
        for held in &leaving {
            let contact = held.contact();
            let rate = system.elongation_of(contact).rate.as_slice();
            // The contact's own bodies may be at rest at both ends of a flight: their
            // accelerations count too.
            let accelerated: f64 = rate.iter().zip(&before.rate).map(|(a, x)| (a * x).abs()).sum();
            let largest =
                size_of(rate, before).max(size_of(rate, &self.legs[letter])).max(accelerated * period);
            if zero == f64::INFINITY || dot(rate, after).abs() <= zero * largest {
                let value = beyond_level(place, own, (*held, &leaving), after);
                all.extend(value.map(|value| (Condition::Changes { letter, contact }, value)));
            }
        }
        let is_met =
            |stop: &usize| own.watch() != Some(Watch::Meets(*stop)) && !system.stops[*stop].is_freewheel;
        for stop in own.hits().filter(is_met) {
            let off = off_gap(system, stop, &before.states[1]);
            all.push((Condition::Together { letter, stop }, TOUCHING - off));
        }
    }

    /// The augmented state after event `letter`.
    fn after(&self, letter: usize) -> &[f64] {
        match self.legs.get(letter) {
            Some(next) if letter > 0 => next.entered(),
            _ => &self.back,
        }
    }

    /// Duration of the period, s.
    pub(super) fn period(&self) -> f64 {
        let [first, last] = [&self.legs[0], &self.legs[self.legs.len() - 1]];
        last.time + last.span - first.run.as_ref().map_or(first.time, |run| run.0)
    }

    /// Adds the conditions of an event at a fixed time.
    fn add_fixed(&self, letter: usize, place: &Place, word: &Word, all: &mut Vec<(Condition, f64)>) {
        let (own, system, leg) = (&word.letters[letter], place.assembly.system(), self.before(letter));
        let Some(timed) = own.timed() else { return };
        let arrived = own.arrived(system, leg.time + leg.span, &leg.states[1]);
        if !timed.sides.is_empty() {
            let mut struck = arrived.clone();
            own.strike(system, [&mut struck[..]]);
            let margins = timed.margins(system, &struck).into_iter().enumerate();
            all.extend(
                margins
                    .map(|(place, (output, margin))| (Condition::Limited { letter, place, output }, margin)),
            );
        }
        let kept = with_levels(system, own);
        let changed: Vec<Contact> = changes(&kept, &own.modes[1]).collect();
        let Some(&contact) = changed.first() else { return };
        let after = self.after(letter);
        let flow = place.flow(&kept);
        let functionals = flow.watched.iter().filter(|(watch, _)| changed.contains(&watch.contact()));
        let passed = functionals.map(|(_, row)| beyond(row.as_slice(), after));
        // A contact that keeps its rate at zero cannot stay if the rate jumps.
        let held = changed.iter().filter(|contact| kept.contacts().any(|own| own == **contact));
        let rates = held.map(|&own| beyond(system.elongation_of(own).rate.as_slice(), after).abs());
        let most = passed.chain(rates.filter(|rate| *rate > TOUCHING)).reduce(f64::max);
        all.extend(most.map(|value| (Condition::Changes { letter, contact }, value)));
    }

    /// Adds how far each event function stays below zero in a flight of positive duration: minus
    /// its largest value. An end is left out if the function belongs to the event there and is at
    /// most `zero` times its terms. Returns the sizes of the terms.
    fn add_peaks(&self, letter: usize, word: &Word, zero: f64, all: &mut Vec<(Condition, f64)>) -> Vec<f64> {
        let leg = &self.legs[letter];
        let watched = &leg.flow.watched;
        let mut sizes: Vec<f64> = watched.iter().map(|(_, row)| size_of(row.as_slice(), leg)).collect();
        if leg.span <= 0.0 && !word.is_empty() {
            return sizes;
        }
        let mut peaks = vec![f64::NEG_INFINITY; watched.len()];
        let next = word.letters.get((letter + 1) % word.len().max(1));
        let is_ending = |place: usize| {
            let of = |letter: &Letter| {
                letter.events.iter().any(|e| e.contact() == Some(watched[place].0.contact()))
            };
            leg.ending == Some(place)
                || next.is_some_and(|next| of(next) && is_zero_at(next, watched[place].0))
        };
        let begun = word.letters.get(letter);
        let is_begun = |place: usize| begun.is_some_and(|own| is_zero_after(own, watched[place].0));
        let mut past = 0.0;
        let mut look = |series: &Series, length: f64| {
            for (place, (_, row)) in watched.iter().enumerate() {
                let q = coefficients(row.as_slice(), series);
                let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
                // A rate that is zero at both ends takes its size from the interior.
                sizes[place] = sizes[place].max(spread);
                if q[0] + spread <= peaks[place] {
                    continue;
                }
                let zero = zero * sizes[place];
                turning_points(&q, &mut |u, value| {
                    let begins = past == 0.0 && u == 0.0;
                    let ends = past + length >= leg.span * (1.0 - 1e-12) && u == 1.0;
                    let is_event = (begins && is_begun(place)) || (ends && is_ending(place));
                    let left_out = is_event && value.abs() <= zero;
                    if !left_out {
                        peaks[place] = peaks[place].max(value);
                    }
                });
            }
            past += length;
        };
        for part in leg.parts() {
            leg.flow.stretches(part.start, part.span, &mut look);
        }
        for (place, peak) in peaks.into_iter().enumerate().filter(|(_, peak)| *peak > f64::NEG_INFINITY) {
            let value = -peak / sizes[place].max(f64::MIN_POSITIVE);
            all.push((Condition::Stays { letter, watch: watched[place].0, place }, value));
        }
        sizes
    }
}

/// Whether an event may make this event function zero after it: the function of a contact that
/// changes there.
fn is_zero_after(letter: &Letter, watch: Watch) -> bool {
    let contact = watch.contact();
    let [before, after] = &letter.modes;
    let is_own = letter.events.iter().any(|event| event.contact() == Some(contact))
        || letter.chatter.as_ref().is_some_and(|run| Contact::Stop(run.stop) == contact)
        || changes(before, after).any(|own| own == contact);
    is_own && is_zero_at(letter, watch)
}

/// Whether an event may make a function of one of its changing contacts zero there. The excess
/// force of a held contact is not zero there, unless it is the event's own function; nor is the
/// rate of a slip that an impact ends or begins by its jump. If one of these is zero, a condition
/// just ceases to hold.
fn is_zero_at(letter: &Letter, watch: Watch) -> bool {
    let is_rate = matches!(watch, Watch::Stops(_) | Watch::Reverses(_));
    let jumps = letter.chatter.is_none() && letter.hits().next().is_some();
    !(is_level(watch) || is_rate && jumps)
}

/// Whether an event function is the force of a held contact minus its limit. An event of another
/// contact does not make this function zero.
fn is_level(watch: Watch) -> bool {
    matches!(watch, Watch::Slips(..) | Watch::Opens(_))
}

/// Distance of a stop from its gap in a state, relative to its terms.
pub(super) fn off_gap(system: &System, stop: usize, z: &[f64]) -> f64 {
    let terms = system.stops[stop].excess.terms().iter().map(|&(i, a)| a * z[i]);
    let (value, size) = terms.fold((0.0, 0.0), |(value, size), x| (value + x, size + x.abs()));
    f64::abs(value) / f64::max(size, f64::MIN_POSITIVE)
}

/// The held states of contacts that an event of another contact releases, and of a friction
/// element that reverses: only a force beyond its limit ends these states.
fn leaving(letter: &Letter) -> impl Iterator<Item = ElementState> {
    let ([before, after], own) = (&letter.modes, letter.watch());
    let frictions = before.frictions.iter().zip(&after.frictions).enumerate();
    let frictions = frictions.filter(move |&(i, (a, b))| {
        let is_let_go = a.sticks() && !matches!(own, Some(Watch::Slips(at, _)) if at == i);
        let slips = matches!(b, FrictionState::Up | FrictionState::Down);
        slips && a != b && (is_let_go || own == Some(Watch::Stops(i)))
    });
    let stops = before.stops.iter().zip(&after.stops).enumerate();
    let stops = stops.filter(move |&(i, (a, b))| {
        *a == StopState::Closed && *b != StopState::Closed && own != Some(Watch::Opens(i))
    });
    let frictions = frictions.map(|(i, _)| ElementState::Friction(i, FrictionState::Stuck));
    frictions.chain(stops.map(|(i, _)| ElementState::Stop(i, StopState::Closed)))
}

/// How far the force that would hold a contact after an event exceeds its limit, relative to its
/// terms. The minimum with and without the other released contacts, since any contact may release
/// first. `None` if the contact would depend on others.
fn beyond_level(
    place: &Place,
    letter: &Letter,
    (held, all): (ElementState, &[ElementState]),
    z: &[f64],
) -> Option<f64> {
    let (system, own) = (place.assembly.system(), held.contact());
    let alone = system.with_element(&letter.modes[1], held);
    let together = all.iter().fold(letter.modes[1].clone(), |mode, own| system.with_element(&mode, *own));
    let of = |mode: Mode| {
        let flow = mode.basis.contains(&own).then(|| place.flow(&mode))?;
        let levels = flow.watched.iter().filter(|(watch, _)| watch.contact() == own && is_level(*watch));
        levels.map(|(_, row)| beyond(row.as_slice(), z)).reduce(f64::max)
    };
    [alone, together].into_iter().filter_map(of).reduce(f64::max)
}

/// The mode before an event with the stiffness levels after it: parts that begin to act take the
/// states of the parts that cease to act.
fn with_levels(system: &System, letter: &Letter) -> Mode {
    let [before, after] = &letter.modes;
    let mut mode = before.clone();
    for (i, state) in before.stops.iter().enumerate() {
        if (*state == StopState::Off) == (after.stops[i] == StopState::Off) {
            continue;
        }
        mode.stops[i] = match state {
            StopState::Off => before.stops[system.present(system.stop_of(i), &before.stops)],
            _ => StopState::Off,
        };
    }
    mode
}

/// The contacts whose states differ in two modes, apart from the kind of sticking.
fn changes<'a>(before: &'a Mode, after: &'a Mode) -> impl Iterator<Item = Contact> + 'a {
    let stops = before.stops.iter().zip(&after.stops).enumerate();
    let stops = stops.filter(|(_, (a, b))| a != b).map(|(i, _)| Contact::Stop(i));
    let frictions = before.frictions.iter().zip(&after.frictions).enumerate();
    let frictions = frictions.filter(|(_, (a, b))| a != b && !(a.sticks() && b.sticks()));
    let sliders = before.sliders.iter().zip(&after.sliders).enumerate();
    let sliders = sliders.filter(|(_, (a, b))| a != b).map(|(i, _)| Contact::Slider(i));
    stops.chain(frictions.map(|(i, _)| Contact::Friction(i))).chain(sliders)
}

/// Largest size of an event function's terms at both ends of a flight.
fn size_of(row: &[f64], leg: &Leg) -> f64 {
    let of = |z: &[f64]| row.iter().zip(z).map(|(a, x)| (a * x).abs()).sum::<f64>();
    of(&leg.states[0]).max(of(&leg.states[1]))
}
