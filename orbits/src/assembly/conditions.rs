//! The conditions under which a cycle is a motion of the machine: each event is reached, and no
//! other one.

use super::cycle::{Cycle, Leg};
use super::place::Place;
use super::word::{Letter, Word};
use vibro_analysis::assembly::flight::{Series, coefficients, turning_points};
use vibro_assembly::mode::Watch;
use vibro_assembly::system::System;

/// Value of a functional, relative to its terms, that counts as zero at an event.
const TOUCHING: f64 = 1e-9;
/// Value of a condition, relative to its terms, below zero that is rounding.
const ROUNDING: f64 = 1e-12;

/// A condition of an orbit on one of its flights or events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// Event `letter` is reached with the functional rising.
    Rises {
        /// Its place in the word.
        letter: usize,
    },
    /// The flight after event `letter` has a duration.
    Lasts {
        /// Its place in the word.
        letter: usize,
    },
    /// A further stop that event `letter` hits is at its gap.
    Together {
        /// Its place in the word.
        letter: usize,
        /// The stop.
        stop: usize,
    },
    /// No other functional is reached in the flight after event `letter`.
    Stays {
        /// Its place in the word.
        letter: usize,
        /// The functional.
        watch: Watch,
        /// Its place among the functionals of the mode.
        place: usize,
    },
}

impl Condition {
    /// Whether a value shows that the condition does not hold; a functional that stays below zero
    /// may touch it but for rounding.
    pub(super) fn fails(&self, value: f64) -> bool {
        match self {
            Self::Stays { .. } => value < -ROUNDING,
            _ => value <= 0.0,
        }
    }

    /// Whether it ceases to hold where a rigid stop is touched with speed zero.
    pub(super) fn touches_rigid_stop(&self, word: &Word, system: &System) -> bool {
        let watch = match *self {
            Self::Rises { letter } => word.letters[letter].watch,
            Self::Stays { watch, .. } => watch,
            Self::Lasts { .. } | Self::Together { .. } => return false,
        };
        matches!(watch, Watch::Meets(stop) if system.stops[stop].keeps_gap())
    }
}

impl Cycle {
    /// All conditions under which the cycle is a motion of the machine, each with a value that is
    /// positive where it holds. Values of functionals are relative to their terms.
    pub(super) fn conditions(&self, place: &Place, word: &Word) -> Vec<(Condition, f64)> {
        let mut all = Vec::new();
        if word.is_empty() {
            self.add_peaks(0, word, &mut all);
            return all;
        }
        for (letter, leg) in self.legs.iter().enumerate() {
            self.add_event(letter, place, word, &mut all);
            if leg.span > 0.0 {
                self.add_peaks(letter, word, &mut all);
            }
        }
        all
    }

    /// The value of one condition; `None` where its flight does not have it.
    pub(super) fn value_of(&self, condition: Condition, place: &Place, word: &Word) -> Option<f64> {
        let mut all = Vec::new();
        match condition {
            Condition::Stays { letter, .. } => self.add_peaks(letter, word, &mut all),
            Condition::Rises { letter }
            | Condition::Lasts { letter }
            | Condition::Together { letter, .. } => self.add_event(letter, place, word, &mut all),
        }
        all.into_iter().find(|(own, _)| *own == condition).map(|(_, value)| value)
    }

    /// Adds the conditions of event `letter` and the duration of the flight after it.
    fn add_event(&self, letter: usize, place: &Place, word: &Word, all: &mut Vec<(Condition, f64)>) {
        let period: f64 = self.legs.iter().map(|leg| leg.span).sum();
        let before = self.before(letter);
        let row = before.ending.map(|place| before.flow.watched[place].1.as_slice()).unwrap_or(&[]);
        let size: f64 = row.iter().zip(&before.states[1]).map(|(a, x)| (a * x).abs()).sum();
        all.push((Condition::Rises { letter }, self.rise(letter) * period / size.max(f64::MIN_POSITIVE)));
        all.push((Condition::Lasts { letter }, self.legs[letter].span / period));
        let own = &word.letters[letter];
        let system = place.assembly.system();
        let is_met = |stop: &usize| own.watch != Watch::Meets(*stop) && !system.stops[*stop].is_freewheel;
        for stop in own.hits().filter(is_met) {
            let row = system.stops[stop].excess.terms();
            let end = &before.states[1];
            let (value, size) = row
                .iter()
                .fold((0.0, 0.0), |(value, size), &(i, a)| (value + a * end[i], size + (a * end[i]).abs()));
            let off = value.abs() / size.max(f64::MIN_POSITIVE);
            all.push((Condition::Together { letter, stop }, TOUCHING - off));
        }
    }

    /// Adds how far each functional of a flight stays below zero: minus its largest value within
    /// the flight, ends at which it is zero left out.
    fn add_peaks(&self, letter: usize, word: &Word, all: &mut Vec<(Condition, f64)>) {
        let leg = &self.legs[letter];
        let watched = &leg.flow.watched;
        let mut sizes: Vec<f64> = watched.iter().map(|(_, row)| size(row.as_slice(), leg)).collect();
        let mut peaks = vec![f64::NEG_INFINITY; watched.len()];
        let next = word.letters.get((letter + 1) % word.len().max(1));
        let is_ending = |place: usize| {
            let of = |letter: &Letter| {
                letter.events.iter().any(|e| e.contact() == Some(watched[place].0.contact()))
            };
            leg.ending == Some(place) || next.is_some_and(of)
        };
        let mut past = 0.0;
        let mut look = |series: &Series, length: f64| {
            for (place, (_, row)) in watched.iter().enumerate() {
                let q = coefficients(row.as_slice(), series);
                let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
                // A rate that is zero at both ends has its size from within.
                sizes[place] = sizes[place].max(spread);
                if q[0] + spread <= peaks[place] {
                    continue;
                }
                let zero = TOUCHING * sizes[place];
                turning_points(&q, &mut |u, value| {
                    let begins = past == 0.0 && u == 0.0;
                    let ends = past + length >= leg.span * (1.0 - 1e-12) && u == 1.0;
                    let left_out = (begins || (ends && is_ending(place))) && value.abs() <= zero;
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
    }
}

/// Size of a functional's terms in a flight.
fn size(row: &[f64], leg: &Leg) -> f64 {
    let of = |z: &[f64]| row.iter().zip(z).map(|(a, x)| (a * x).abs()).sum::<f64>();
    of(&leg.states[0]).max(of(&leg.states[1]))
}
