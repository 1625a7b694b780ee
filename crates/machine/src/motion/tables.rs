//! Cache of the modes that a motion has met, with their flows, powers and neighbouring modes.

use crate::energy::Powers;
use crate::flow::FlowTable;
use crate::mode::{ElementState, Mode};
use crate::system::System;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// Default limit of the cache's size, bytes. Beyond it all entries are dropped, and entries in use
/// are made again. Modes without stored matrices take some microseconds per body and seldom recur.
const KEPT: usize = 128 << 20;
const KEPT_WITHOUT_MATRICES: usize = 16 << 20;

/// A mode in the cache.
#[derive(Clone, Debug)]
pub(super) struct Met {
    pub(super) mode: Mode,
    pub(super) table: Arc<FlowTable>,
    /// Powers of the mode's energy accounts, made on first use.
    powers: OnceLock<Arc<Powers>>,
    /// Indices of modes that differ by the state of one element.
    changes: Vec<(ElementState, usize)>,
}

impl Met {
    /// Returns the powers of the mode's energy accounts.
    pub(super) fn powers(&self, system: &System) -> &Powers {
        self.powers.get_or_init(|| Arc::new(Powers::new(system, &self.mode, &self.table)))
    }

    /// Size in memory, bytes.
    fn bytes(&self) -> usize {
        let powers = self.powers.get().map_or(0, |powers| powers.numbers());
        (self.table.numbers() + powers) * size_of::<f64>()
    }
}

/// The modes by index, in the order of their first use.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    met: Vec<Met>,
    places: HashMap<Mode, usize>,
    /// Limit of the size, bytes.
    pub(super) most: usize,
    /// Bytes are counted again at this number of modes, as counting takes time.
    recount: usize,
}

impl Tables {
    /// Creates the empty cache of a machine.
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

    /// Empties the cache if it exceeds its size, which invalidates all indices; returns whether it
    /// did. It is called before a mode is entered, so that the excess is at most the tables of one
    /// event.
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

    /// Returns the index of the mode that differs from mode `place` by the state of an element, if
    /// it is known.
    pub(super) fn known_after(&self, place: usize, element: ElementState) -> Option<usize> {
        self.met[place].changes.iter().find(|(known, _)| *known == element).map(|&(_, next)| next)
    }

    /// Returns the index of a mode, and adds the mode if it is new.
    pub(super) fn place_of(&mut self, mode: &Mode, system: &System) -> usize {
        if let Some(&place) = self.places.get(mode) {
            return place;
        }
        let table = Arc::new(FlowTable::of_mode(system, mode));
        self.met.push(Met { mode: mode.clone(), table, powers: OnceLock::new(), changes: Vec::new() });
        self.places.insert(mode.clone(), self.met.len() - 1);
        self.met.len() - 1
    }

    /// Returns the index of the mode that differs from mode `place` by the state of an element,
    /// and adds it if it is new.
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
