//! Cache of the modes that a motion has met: their tables, and the transitions between modes that
//! differ in one element.

use crate::energy::Powers;
use crate::flow::Table;
use crate::mode::{ElementState, Mode};
use crate::system::System;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// Default limit of the tables' size, bytes; beyond it all are dropped and rebuilt as needed.
const KEPT: usize = 128 << 20;

/// A mode that was met.
#[derive(Clone, Debug)]
pub(super) struct Met {
    pub(super) mode: Mode,
    pub(super) table: Arc<Table>,
    /// Powers of the energy accounts, built on first use.
    powers: OnceLock<Arc<Powers>>,
    /// Indices of the modes that differ in the state of one element.
    changes: Vec<(ElementState, usize)>,
}

impl Met {
    /// The powers of its energy accounts.
    pub(super) fn powers(&self, system: &System) -> &Powers {
        self.powers.get_or_init(|| Arc::new(Powers::new(system, &self.mode, &self.table)))
    }

    /// Size, bytes.
    fn bytes(&self) -> usize {
        let powers = self.powers.get().map_or(0, |powers| powers.numbers());
        (self.table.numbers() + powers) * size_of::<f64>()
    }
}

/// Modes by index, in the order in which they were met.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    met: Vec<Met>,
    places: HashMap<Mode, usize>,
    /// Limit of the size, bytes.
    pub(super) most: usize,
    /// Number of modes at which bytes are counted next: counting visits all modes, too slow for
    /// every new one.
    recount: usize,
}

impl Default for Tables {
    fn default() -> Self {
        Self { met: Vec::new(), places: HashMap::new(), most: KEPT, recount: 0 }
    }
}

impl Tables {
    /// Size of all tables, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.met.iter().map(Met::bytes).sum()
    }

    /// The mode with index `place`.
    pub(super) fn at(&self, place: usize) -> &Met {
        &self.met[place]
    }

    /// Drops all tables if they exceed the limit, which invalidates every index; returns whether it
    /// did. Call it before putting a mode in force, so that only the tables of one event can exceed
    /// the limit.
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

    /// Index of the mode that differs from that at `place` in `element`, if it was met before.
    pub(super) fn known_after(&self, place: usize, element: ElementState) -> Option<usize> {
        self.met[place].changes.iter().find(|(known, _)| *known == element).map(|&(_, next)| next)
    }

    /// Index of a mode; builds its table if it is new.
    pub(super) fn place_of(&mut self, mode: &Mode, system: &System) -> usize {
        if let Some(&place) = self.places.get(mode) {
            return place;
        }
        let table = Arc::new(Table::new(system.linear(mode), system.signals.one));
        self.met.push(Met { mode: mode.clone(), table, powers: OnceLock::new(), changes: Vec::new() });
        self.places.insert(mode.clone(), self.met.len() - 1);
        self.met.len() - 1
    }

    /// Index of the mode that differs from that at `place` in `element`; builds its table if new.
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
