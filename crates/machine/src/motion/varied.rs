//! Variational equations of a motion: the derivative of its later state with respect to its
//! present state and inputs.
//!
//! Between events a variation δ of the augmented state follows z' = A z as the state does. At an
//! event with h·z = 0, the varied motion is later by δt = -h·δ / h·f⁻, with f = A z on either
//! side. Hence δ⁺ = J (δ + f⁻ δt) - f⁺ δt, the saltation matrix. J is the derivative of the impact
//! law, the identity if no velocity jumps (docs/assembly-law.md (A26)). A variation stays in the
//! space that closed stops and sticking friction leave free.

use super::projection::project;
use super::{Event, Impulse, Motion, Reached};
use crate::error::Error;
use crate::flow::FlowTable;
use crate::kernel::Sparse;
use crate::mode::Mode;
use crate::system::{SampleAction, SampledVariation, System};
use nalgebra::DVector;
use std::sync::Arc;

/// A passage slower than this fraction of the sizes of its terms is a touch, which has no
/// derivative.
const TOUCH: f64 = 1e-12;

fn dot(row: &[f64], z: &[f64]) -> f64 {
    row.iter().zip(z).map(|(a, b)| a * b).sum()
}

/// Projects a variation onto the constraints of a mode: e = 0 of closed stops, e' = 0 of closed
/// stops and sticking friction, the force of a slipping slider at its level.
pub fn keep(system: &System, mode: &Mode, variation: &mut [f64]) {
    let system = &*system.at_mode(mode);
    let basis = &mode.basis[..];
    if basis.is_empty() {
        return system.keep_levels(&mode.sliders, variation);
    }
    let r = system.triangle(basis);
    // A basis lists stops first; the stops' R is the leading block of the triangle.
    let stops = basis.iter().take_while(|contact| system.keeps_place(**contact)).count();
    project(system, &basis[..stops], &r, false, variation, &mut Vec::new());
    project(system, basis, &r, true, variation, &mut Vec::new());
    system.keep_levels(&mode.sliders, variation);
}

/// An event that a motion has passed, over which variations can be carried.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<'a> {
    /// Modes before and after the event.
    pub modes: [&'a Mode; 2],
    /// States before and after the event's law.
    pub states: [&'a [f64]; 2],
    /// z' before and after the law.
    pub rates: [&'a [f64]; 2],
    /// The event function that has passed zero; `None` at a signal's knot, whose time is fixed.
    pub row: Option<&'a [f64]>,
    /// The reported events.
    pub events: &'a [Event],
}

impl Crossing<'_> {
    /// Carries variations over the event by the derivative of the impacts that the motion has had.
    /// If several stops are hit at one instant, the motion may have no derivative. The result is
    /// then the derivative of the impacts in their actual order.
    pub fn carry<'v>(&self, system: &System, variations: impl IntoIterator<Item = &'v mut [f64]>) {
        let before = DVector::from_column_slice(self.states[0]);
        let (impacts, own) = (Impulse::all(system, self.events, &before), system.states());
        let [incoming, outgoing] = self.rates;
        let passage = self.row.map(|row| {
            let terms: f64 = row.iter().zip(incoming).map(|(a, b)| (a * b).abs()).sum();
            (row, dot(row, incoming), TOUCH * terms)
        });
        let sampled: Vec<SampleAction> = self.events.iter().filter_map(Event::sample).collect();
        for variation in variations {
            if !sampled.is_empty() {
                let varied = SampledVariation {
                    delta: &mut *variation,
                    blocks: &[],
                    excess: &|_| None,
                    rounds: false,
                };
                system.sample(&sampled, &mut before.clone(), &mut [varied]);
            }
            let later = match passage {
                Some((row, speed, touch)) if speed.abs() > touch => -dot(row, variation) / speed,
                _ => 0.0,
            };
            let mut met: Vec<f64> = variation.iter().zip(incoming).map(|(v, f)| v + f * later).collect();
            impacts.iter().for_each(|impact| impact.carry_state(system, &mut met));
            // Signals are functions of time, which events do not change.
            let (changed, _) = variation.split_at_mut(own);
            changed.iter_mut().zip(met.iter().zip(outgoing)).for_each(|(v, (m, f))| *v = m - f * later);
            keep(system, self.modes[1], variation);
            system.keep_moved(self.states, variation);
        }
    }
}

impl Motion {
    /// The flow of the present mode.
    pub(crate) fn flow_of_mode(&self) -> &FlowTable {
        self.table()
    }

    /// Returns unit variations of the augmented state for [`advance_with`](Self::advance_with):
    /// one for each given state (coordinates, rates, inner places, states of blocks), then one
    /// each for the value and derivatives 1 to 3 of each input. All are projected onto the
    /// contacts' constraints.
    pub fn unit_variations(&self) -> Vec<Vec<f64>> {
        let system = &self.assembly.system;
        let signals = &system.signals;
        let inputs = (0..signals.inputs).filter_map(|i| signals.place_of_input(i));
        let places = (0..system.states()).chain(inputs.flat_map(|first| first..first + 4));
        let unit = |place: usize| {
            let mut variation = vec![0.0; signals.size];
            variation[place] = 1.0;
            keep(system, &self.hybrid.mode, &mut variation);
            system.branches.iter().for_each(|own| variation[own.place] = f64::from(own.place == place));
            system.take_given(&mut variation);
            system.keep_levels(&self.hybrid.mode.sliders, &mut variation);
            variation
        };
        places.map(unit).collect()
    }

    /// Advances with variations to a time or, if it is earlier, to the next event, before its law.
    /// A pending event is applied first.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    ///
    /// # Examples
    ///
    /// A stop at 1 m with restitution ε sends a body back to s = 1 + ε (1 - s₀ - v₀ t). The
    /// variations by s₀ and v₀ are then (-ε, 0) and (-ε t, -ε):
    ///
    /// ```
    /// use vibro_machine::motion::Reached;
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// # let text = r#"
    /// #     name = "Wall"
    /// #     body.a = { mass = 1.0, start = { v = 2.0 } }
    /// #     stop.wall = { between = ["ground", "a"], gap = 1.0, restitution = 0.25 }
    /// # "#;
    /// let machine = file::parse(text, "wall.toml", &file::no_records)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// let mut variations = motion.unit_variations();
    /// while motion.advance_with(3.0, &mut variations)? == Reached::Event {}
    /// assert_eq!(variations[0][..2], [-0.25, 0.0]);
    /// assert_eq!(variations[1][..2], [-0.75, -0.25]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn advance_with(&mut self, end: f64, variations: &mut [Vec<f64>]) -> Result<Reached, Error> {
        self.pass_event_with(variations)?;
        let (table, from) = (self.tables.at(self.place).table.clone(), self.time());
        let mut start = if table.is_curved() { self.hybrid.z.as_slice().to_vec() } else { Vec::new() };
        let outcome = self.advance_before_event(end, &mut |_| ())?;
        let span = self.time() - from;
        if table.is_curved() && span > 0.0 {
            table.carry_along(&mut start, variations, span);
            variations.iter_mut().for_each(|own| keep(&self.assembly.system, &self.hybrid.mode, own));
            return Ok(outcome);
        }
        for variation in variations.iter_mut().filter(|_| span > 0.0) {
            table.carry(variation, span);
            keep(&self.assembly.system, &self.hybrid.mode, variation);
        }
        Ok(outcome)
    }

    /// Applies the law of the pending event, if there is one, and carries variations over it.
    ///
    /// # Errors
    /// As [`apply_event`](Self::apply_event).
    pub fn pass_event_with(&mut self, variations: &mut [Vec<f64>]) -> Result<(), Error> {
        if !self.is_event_due() {
            return Ok(());
        }
        let before = (self.hybrid.mode.clone(), self.hybrid.z.clone());
        let rate = |motion: &Self| {
            let mut z = motion.hybrid.z.clone();
            if motion.table().is_curved() {
                motion.table().derivative(1, z.as_mut_slice());
                return z;
            }
            motion.table().a.rows_times(0..z.len(), z.as_slice())
        };
        let incoming = rate(self);
        // An `ElastoGap` has two event functions with the same `watch`: take the one at zero.
        let due = self.due();
        let ended = self.table().watched.iter().filter(|w| Some(w.watch) == due);
        let off = |row: &Arc<Sparse>| row.dot(before.1.as_slice()).abs();
        let row = ended.map(|w| &w.row).min_by(|a, b| off(a).total_cmp(&off(b)));
        let row = row.map(|row| row.dense(before.1.len()));
        let mut events = Vec::new();
        self.pass_event(&mut Some(&mut |event| events.push(event.clone())))?;
        let outgoing = rate(self);
        let crossing = Crossing {
            modes: [&before.0, &self.hybrid.mode],
            states: [before.1.as_slice(), self.hybrid.z.as_slice()],
            rates: [incoming.as_slice(), outgoing.as_slice()],
            row: row.as_deref(),
            events: &events,
        };
        crossing.carry(&self.assembly.system, variations.iter_mut().map(Vec::as_mut_slice));
        let (system, z) = (&self.assembly.system, self.hybrid.z.as_slice());
        variations.iter_mut().for_each(|variation| system.vary_curved(z, variation));
        Ok(())
    }
}
