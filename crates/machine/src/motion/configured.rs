//! Machines with residual flexibility: the rows of the present mode, and the mode that follows an
//! instant. The forces on such nodes are known functions of the state in each of their
//! configurations, and only one configuration lasts (docs/assembly-law.md, section 25).

use super::contact::{DOUBTFUL, Flags};
use super::{Motion, Parted};
use crate::assembly::Assembly;
use crate::error::Error;
use crate::flow::{DepartureRows, FlowTable};
use crate::law::selection::Selection;
use crate::mode::{Mode, Watch};
use crate::system::{Acting, Part, Residual};
use std::collections::HashMap;
use std::sync::Arc;

/// A motion keeps up to this number of configurations.
const KEPT: usize = 64;

/// The machine with the rows of the configurations that a motion has met.
#[derive(Clone, Debug, Default)]
pub(super) struct Configured(HashMap<Vec<Acting>, Arc<Assembly>>);

/// A force that contradicts its state, with the order of the derivative and the required state.
type Wrong = (usize, usize, Acting);

impl Motion {
    /// Takes the rows of the present mode.
    pub(super) fn take_rows(&mut self) {
        if let Some(acting) = self.assembly.system.acting_in(&self.hybrid.mode) {
            self.configure(acting);
        }
    }

    /// Takes the rows of the present state if no mode is known: at a start and after a jump.
    pub(super) fn take_rows_of_state(&mut self, parted: &Parted) {
        if (parted.sliders || self.hybrid.mode.stops.is_empty())
            && let Some(acting) = self.assembly.system.acting_at(self.hybrid.z.as_slice())
        {
            self.configure(acting);
        }
    }

    fn configure(&mut self, acting: Vec<Acting>) {
        if self.assembly.system.configuration_of() == Some(&acting[..]) {
            return;
        }
        let Configured(met) = &mut self.configured;
        if let Some(known) = met.get(&acting) {
            self.assembly = known.clone();
            return;
        }
        let Some(system) = self.assembly.system.configured(acting.clone()) else { return };
        if met.len() >= KEPT {
            met.clear();
        }
        self.assembly = Arc::new(Assembly { system, ..Assembly::clone(&self.assembly) });
        met.insert(acting, self.assembly.clone());
    }

    /// Selects the mode that follows the present state of a machine with residual flexibility: the
    /// configuration whose event functions all have a negative first nonzero derivative.
    pub(super) fn select_configured(&self, residual: &Residual, flags: &Flags) -> Result<Mode, Error> {
        let mut found = None;
        let begin = self.guess(residual, flags);
        let consistent = residual.search(begin, |acting| {
            let (mode, wrong) = self.examine(residual, acting, flags)?;
            found = Some(mode);
            Ok::<_, Error>(wrong)
        })?;
        let mode = found.filter(|_| consistent.is_some());
        mode.ok_or_else(|| Error::Stuck {
            time: self.time(),
            cause: "no states of the contacts on residual flexibility are consistent; check the flexibility \
                    and the coefficients of friction"
                .into(),
        })
    }

    /// The present configuration, with the forces of the event in their next states.
    fn guess(&self, residual: &Residual, flags: &Flags) -> Vec<Acting> {
        let mut acting = self.assembly.system.configuration_of().unwrap_or_default().to_vec();
        for (place, component) in residual.components.iter().enumerate() {
            let to = match (component.part, acting[place]) {
                (Part::Stop(i), Acting::On) if flags.edge(i) => Acting::Off,
                (Part::Stop(i), Acting::Off) if flags.edge(i) => Acting::On,
                (Part::Branch(i), Acting::On) if flags.slider(i).level > 0.0 => Acting::Up,
                (Part::Branch(i), Acting::On) if flags.slider(i).level < 0.0 => Acting::Down,
                (Part::Branch(i), Acting::Up | Acting::Down) if flags.slider(i).turns => Acting::On,
                _ => continue,
            };
            acting = residual.flipped(&acting, place, to);
        }
        acting
    }

    /// Returns the mode that a configuration would have, and a force that contradicts its state
    /// there: one whose event function has a positive first derivative, of the lowest order.
    fn examine(
        &self,
        residual: &Residual,
        acting: &[Acting],
        flags: &Flags,
    ) -> Result<(Mode, Option<(usize, Acting)>), Error> {
        let own = self.assembly.system.configured(acting.to_vec());
        let (system, hybrid) = (own.as_ref().unwrap_or(&self.assembly.system), &self.hybrid);
        let mode = Selection::select(system, &hybrid.z, &hybrid.sizes, &flags.verdict(&[]))
            .map_err(|jam| self.jammed(&jam))?;
        let table = FlowTable::of_mode(system, &mode);
        let (z, sizes) = (hybrid.z.as_slice(), hybrid.sizes.0.as_slice());
        let curved = table.is_curved().then(|| table.curved_departures(z, sizes, DOUBTFUL));
        let mut rows = DepartureRows::default();
        let mut first: Option<Wrong> = None;
        for (k, w) in table.watched.iter().enumerate() {
            let (part, to, is_zero) = match w.watch {
                Watch::Presses(i) => (Part::Stop(i), Acting::On, flags.edge(i)),
                Watch::Leaves(i) => (Part::Stop(i), Acting::Off, flags.edge(i)),
                Watch::Yields(i, true) => (Part::Branch(i), Acting::Up, flags.slider(i).level > 0.0),
                Watch::Yields(i, false) => (Part::Branch(i), Acting::Down, flags.slider(i).level < 0.0),
                Watch::Reverses(i) => (Part::Branch(i), Acting::On, flags.slider(i).turns),
                _ => continue,
            };
            let Some(place) = residual.place(part) else { continue };
            let departure = match &curved {
                Some(all) => all[k],
                None => table.departure_from(usize::from(is_zero), w, z, sizes, DOUBTFUL, &mut rows),
            };
            if let Some((order, value)) = departure
                && value > 0.0
                && first.is_none_or(|known| (order, place) < (known.0, known.1))
            {
                first = Some((order, place, to));
            }
        }
        Ok((mode, first.map(|(_, place, to)| (place, to))))
    }
}
