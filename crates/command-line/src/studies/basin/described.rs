//! Basins of described machines in tables and pictures: attractors by the words of their orbits.

use super::{Listed, ShownBasins};
use crate::studies::design_sweep::Labelled;
use crate::table::exact;
use crate::wording;
use vibro_figures::chart::Axis;
use vibro_machine::description::{Body, Dimension};
use vibro_orbits::Orbit;
use vibro_studies::basin::{BasinCell, Basins, SettledAttractor, StartAxis};
use vibro_studies::{Machine, MotionClass, QuantityName, significant};

impl ShownBasins for Machine {
    const HAS_IMAGES: bool = false;

    fn headings(basins: &Basins<SettledAttractor>) -> Vec<String> {
        let own = ["contacts", "rests", "interval", "share", "word", "stability"].map(String::from);
        let names = basins.attractors.first().map_or(Vec::new(), |one| one.start.numbers());
        own.into_iter().chain(names.into_iter().map(|(name, _)| name)).collect()
    }

    /// Includes the orbit's events and stability, or the reason why it was not found.
    fn listed(&self, SettledAttractor { settled, start }: &SettledAttractor, [share, _]: [f64; 2]) -> Listed {
        /// Longest list of events in an entry of the legend.
        const LONGEST: usize = 48;
        let (word, stability) = match settled.class {
            MotionClass::Periodic(_) => match Orbit::settled(self, start, 0) {
                Ok(orbit) => (orbit.word().in_words(&orbit.place().assembly), orbit.stability().to_string()),
                Err(_) => (String::new(), "orbit not found".into()),
            },
            _ => (String::new(), String::new()),
        };
        let class = settled.class.name();
        let events = if word.is_empty() { String::new() } else { format!(" [{word}]") };
        let told = format!("{class}{events}, {:.1} % of the starts", 100.0 * share);
        let named = match word.len() {
            0 => class,
            length if length <= LONGEST => format!("{class} {word}"),
            _ => format!("{class} {} events", word.split(", ").count()),
        };
        let mut row =
            vec![exact(settled.contacts), settled.rests.to_string(), exact(settled.interval), exact(share)];
        row.extend([word, stability]);
        row.extend(start.numbers().into_iter().map(|(_, value)| exact(value)));
        Listed { row, words: [named, told] }
    }

    fn titles(&self) -> [String; 3] {
        let title = format!("{}: basins of attraction", wording::title(&self.description.name));
        [title, format!("Elsewhere {}", self.caption_but(&[])), String::new()]
    }

    fn start_axis(&self, axis: &StartAxis) -> Axis {
        let quantity = axis.name.parse::<QuantityName>().ok();
        let d = &self.description;
        let unit = quantity.as_ref().and_then(|q| q.find(d).ok()).map_or("s", |found| found.unit);
        let words = quantity.map_or_else(|| axis.name.clone(), |q| wording::quantity(d, &q));
        let largest = axis.from.abs().max(axis.to.abs());
        let shown = wording::axis(&format!("{words} at the start"), unit, largest);
        Axis { range: Some((axis.from, axis.to)), ..shown }
    }

    fn rest_in_words(&self, basins: &Basins<SettledAttractor>) -> Option<String> {
        rest_in_words(self, basins)
    }
}

/// Relative tolerance for one position of rest.
const ONE_PLACE: f64 = 1e-6;

/// The share of the motions that came to rest, and where; `None` if none did.
fn rest_in_words(machine: &Machine, basins: &Basins<SettledAttractor>) -> Option<String> {
    let d = &machine.description;
    let bodies = d.bodies.iter().zip(&basins.rest).filter(|(body, _)| !body.is_inner());
    let places: Vec<_> = bodies.filter(|(body, _)| !body.kind.is_prescribed()).collect();
    if places.is_empty() {
        return None;
    }
    let unit = |body: &Body| if body.dimension == Dimension::Rotation { "rad" } else { "m" };
    let is_one = |[least, largest]: &[f64; 2]| largest - least <= ONE_PLACE * least.abs().max(largest.abs());
    let place = |(body, [least, largest]): &(&Body, &[f64; 2])| match is_one(&[*least, *largest]) {
        true => format!("{}.s = {} {}", body.name, significant(*least), unit(body)),
        false => {
            let (from, to) = (significant(*least), significant(*largest));
            format!("{}.s from {from} to {to} {}", body.name, unit(body))
        }
    };
    let count = basins.cells.iter().filter(|cell| **cell == BasinCell::Rest).count();
    let which = match basins.cells.len() {
        all if all == count => format!("all {count} motions"),
        all => format!("{count} of {all} motions"),
    };
    let how = match places.iter().all(|(_, range)| is_one(range)) {
        true => "at one position",
        false if d.frictions.is_empty() => "at several positions",
        false => "at a range of positions, held by friction",
    };
    Some(format!("{which} came to rest ({how}): {}", places.iter().map(place).collect::<Vec<_>>().join(", ")))
}
