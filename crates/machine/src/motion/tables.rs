//! Cache of the modes that a motion has met, with their flows, powers and neighbouring modes.

use crate::energy::Powers;
use crate::flow::FlowTable;
use crate::mode::{ElementState, Mode};
use crate::system::System;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// Default size of the cache, bytes; beyond it all entries are dropped, and those in use are made
/// again. Modes without stored matrices are made in some microseconds a body and seldom recur.
const KEPT: usize = 128 << 20;
const KEPT_WITHOUT_MATRICES: usize = 16 << 20;

/// A mode in the cache.
#[derive(Clone, Debug)]
pub(super) struct Met {
    pub(super) mode: Mode,
    pub(super) table: Arc<FlowTable>,
    /// Powers of its energy accounts, made on first use.
    powers: OnceLock<Arc<Powers>>,
    /// Places of modes that differ by the state of one element.
    changes: Vec<(ElementState, usize)>,
}

impl Met {
    /// The powers of its energy accounts.
    pub(super) fn powers(&self, system: &System) -> &Powers {
        self.powers.get_or_init(|| Arc::new(Powers::new(system, &self.mode, &self.table)))
    }

    /// Size in memory, bytes.
    fn bytes(&self) -> usize {
        let powers = self.powers.get().map_or(0, |powers| powers.numbers());
        (self.table.numbers() + powers) * size_of::<f64>()
    }
}

/// The modes by place, in the order in which they were met.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    met: Vec<Met>,
    places: HashMap<Mode, usize>,
    /// Most bytes.
    pub(super) most: usize,
    /// Number of modes at which bytes are counted again, which takes time in proportion to all
    /// modes.
    recount: usize,
}

impl Tables {
    /// The empty cache of a machine.
    pub(super) fn new(system: &System) -> Self {
        let most = if system.keeps_matrices() { KEPT } else { KEPT_WITHOUT_MATRICES };
        Self { met: Vec::new(), places: HashMap::new(), most, recount: 0 }
    }

    /// Size of all modes in memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.met.iter().map(Met::bytes).sum()
    }

    /// The mode with index `place`.
    pub(super) fn at(&self, place: usize) -> &Met {
        &self.met[place]
    }

    /// Empties the cache where it exceeds its size, which invalidates all places; returns whether
    /// it did. It is called before a mode is entered, so that the excess is at most the tables of
    /// one event.
    pub(super) fn make_room(&mut self) -> bool {
        let count = self.met.len();
        if count < self.recount {
            return false;
        }
        self.recount = count + count / 32 + 1;
        let full = self.bytes() > self.most;
        if full {
            self.met.clear();
            self.places.clear();
            self.recount = 0;
        }
        full
    }

    /// The place of the mode that differs from the one at `place` by the state of an element, if it
    /// is known.
    pub(super) fn known_after(&self, place: usize, element: ElementState) -> Option<usize> {
        self.met[place].changes.iter().find(|(known, _)| *known == element).map(|&(_, next)| next)
    }

    /// The place of a mode, which is added where it is new.
    pub(super) fn place_of(&mut self, mode: &Mode, system: &System) -> usize {
        if let Some(&place) = self.places.get(mode) {
            return place;
        }
        let table = Arc::new(FlowTable::of_mode(system, mode));
        self.met.push(Met { mode: mode.clone(), table, powers: OnceLock::new(), changes: Vec::new() });
        self.places.insert(mode.clone(), self.met.len() - 1);
        self.met.len() - 1
    }

    /// The place of the mode that differs from the one at `place` by the state of an element, which
    /// is added where it is new.
    pub(super) fn place_after(&mut self, place: usize, element: ElementState, system: &System) -> usize {
        if let Some(next) = self.known_after(place, element) {
            return next;
        }
        let mode = system.with_element(&self.met[place].mode, element);
        let next = self.place_of(&mode, system);
        self.met[place].changes.push((element, next));
        next
    }
}

#[cfg(test)]
mod tests {
    use super::KEPT;

    #[test]
    fn golden_the_default_memory_of_tables_is_that_of_the_guarantees() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guarantees.md");
        let page = std::fs::read_to_string(path).unwrap();
        assert!(page.contains(&format!("by default {} MB", KEPT >> 20)), "{KEPT}");
    }
}
