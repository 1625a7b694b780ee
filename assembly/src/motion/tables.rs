//! The modes that a motion has met, with their tables, and to which of them the change of one
//! element leads.

use crate::energy::Powers;
use crate::flow::FlowTable;
use crate::mode::{ElementState, Mode};
use crate::system::System;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// Bytes of the tables that are kept; beyond, all are dropped and those in use are made again.
const KEPT: usize = 128 << 20;

/// A mode that was met.
#[derive(Clone, Debug)]
pub(super) struct Met {
    pub(super) mode: Mode,
    pub(super) table: Arc<FlowTable>,
    /// Its powers, made when they are first needed.
    powers: OnceLock<Arc<Powers>>,
    /// The modes in which one element has another state, by their places.
    changes: Vec<(ElementState, usize)>,
}

impl Met {
    /// The powers of its energy accounts.
    pub(super) fn powers(&self, system: &System) -> &Powers {
        self.powers.get_or_init(|| Arc::new(Powers::new(system, &self.mode, &self.table)))
    }

    /// Bytes that it takes.
    fn bytes(&self) -> usize {
        let powers = self.powers.get().map_or(0, |powers| powers.numbers());
        (self.table.numbers() + powers) * size_of::<f64>()
    }
}

/// Modes by their places, in the order in which they were met.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    met: Vec<Met>,
    places: HashMap<Mode, usize>,
    /// Bytes that are kept.
    pub(super) most: usize,
    /// Number of modes from which on bytes are counted again: all are looked at, so that not each
    /// new mode is worth it.
    recount: usize,
}

impl Default for Tables {
    fn default() -> Self {
        Self { met: Vec::new(), places: HashMap::new(), most: KEPT, recount: 0 }
    }
}

impl Tables {
    /// Bytes that all take.
    pub(super) fn bytes(&self) -> usize {
        self.met.iter().map(Met::bytes).sum()
    }

    /// The mode at a place.
    pub(super) fn at(&self, place: usize) -> &Met {
        &self.met[place]
    }

    /// Forgets all where there are too many, so that places that were found before count no more;
    /// tells whether it did. Whoever puts a mode in force asks for it before, so that beyond what
    /// is kept there are only the tables of one event.
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

    /// The place of the mode to which the change of an element leads, where that is known.
    pub(super) fn known_after(&self, place: usize, element: ElementState) -> Option<usize> {
        self.met[place].changes.iter().find(|(known, _)| *known == element).map(|&(_, next)| next)
    }

    /// The place of a mode, whose table is made where it is new.
    pub(super) fn place_of(&mut self, mode: &Mode, system: &System) -> usize {
        if let Some(&place) = self.places.get(mode) {
            return place;
        }
        let table = Arc::new(FlowTable::new(system.linear(mode), system.signals.one));
        self.met.push(Met { mode: mode.clone(), table, powers: OnceLock::new(), changes: Vec::new() });
        self.places.insert(mode.clone(), self.met.len() - 1);
        self.met.len() - 1
    }

    /// The place of the mode that differs from the one at `place` by the state of an element.
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
