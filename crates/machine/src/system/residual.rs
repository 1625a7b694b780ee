//! Residual flexibility of bodies: static displacements of nodes by the forces on them. The forces
//! of elements there depend on one another, so that their rows differ between the states of these
//! elements (docs/assembly-law.md (A68), (A69)).
//!
//! A [`System`] has the rows of one configuration, the states of all elements on such nodes.
//! [`System::at_mode`] returns the machine with the rows of a mode.

mod rows;
mod settle;

pub(crate) use rows::Configuration;

use super::{BranchLaw, Part, System};
use crate::description::{Description, ResidualForces, ResidualMaker};
use crate::functional::Functional;
use crate::mode::{Mode, SliderState, StopState};
use nalgebra::DMatrix;
use std::borrow::Cow;
use std::sync::Arc;

/// The state of a force on nodes with residual flexibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Acting {
    /// The force is zero: the stop is open.
    Off,
    /// The force follows from the elongations: a spring, a pressed stop, a held slider.
    On,
    /// A slider slips upwards: the force is its limit.
    Up,
    /// A slider slips downwards.
    Down,
}

impl Acting {
    /// The direction of slip; 0 without a slip.
    pub fn direction(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
            Self::Off | Self::On => 0.0,
        }
    }

    fn slider(self) -> SliderState {
        match self {
            Self::Off => SliderState::Off,
            Self::On => SliderState::Held,
            Self::Up => SliderState::Up,
            Self::Down => SliderState::Down,
        }
    }
}

/// A force of an element on nodes with residual flexibility.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Its part of the law.
    pub part: Part,
    /// Reciprocal stiffness of the element, m/N.
    pub compliance: f64,
    /// For a slider, the index of the force along its normal, and the coefficient of friction.
    pub limit: Option<(usize, f64)>,
    /// The elongation without forces of elements on residual flexibility.
    pub e: Functional,
    /// Rate of `e`.
    pub rate: Functional,
    /// The displacement that the flexibilities take up, x of (A68).
    pub x: Functional,
    /// Force of a spring at zero elongation, N.
    pub preload: f64,
}

/// A node with residual flexibility.
#[derive(Clone, Debug)]
pub(crate) struct ResidualNode {
    /// Its index among the bodies.
    pub body: usize,
    /// Coordinate and rate without forces of elements, but with loads.
    pub own: [Functional; 2],
    /// Displacement by a unit of each force.
    pub by: Vec<f64>,
}

/// The residual flexibility of a machine; the same in all configurations.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// The forces of elements.
    pub components: Vec<Component>,
    /// Their elongations by units of the forces, G of (A68).
    pub between: DMatrix<f64>,
    /// The nodes.
    pub nodes: Vec<ResidualNode>,
    /// Loads on the nodes, each with the index of its node.
    pub loads: Vec<(usize, usize)>,
    /// Displacements at the loads by units of the loads.
    pub between_loads: DMatrix<f64>,
    /// Length of the augmented state.
    size: usize,
}

impl Residual {
    /// The index of the force of a part; `None` for a part that acts on no such node.
    pub fn place(&self, part: Part) -> Option<usize> {
        self.components.iter().position(|own| own.part == part)
    }

    /// The configuration without pressed stops.
    fn apart(&self) -> Vec<Acting> {
        let acts =
            |own: &Component| if matches!(own.part, Part::Spring(_)) { Acting::On } else { Acting::Off };
        self.components.iter().map(acts).collect()
    }

    /// The states of the forces in a mode.
    fn of_mode(&self, mode: &Mode) -> Vec<Acting> {
        let acts = |own: &Component| match own.part {
            Part::Stop(i) if mode.stops.get(i).is_some_and(|state| state.has_force()) => Acting::On,
            Part::Branch(i) => match mode.sliders.get(i) {
                Some(SliderState::Held) => Acting::On,
                Some(SliderState::Up) => Acting::Up,
                Some(SliderState::Down) => Acting::Down,
                _ => Acting::Off,
            },
            Part::Stop(_) => Acting::Off,
            _ => Acting::On,
        };
        self.components.iter().map(acts).collect()
    }
}

impl System {
    /// Adds residual flexibility and takes the rows of the configuration without pressed stops.
    pub(super) fn add_residual(&mut self, d: &Description) {
        let Some(all) = ResidualForces::of(d) else { return };
        let size = self.signals.size;
        let own_loads: Vec<[Functional; 2]> = all.loads.iter().map(|own| self.driving(own.0)).collect();
        // Displacement of a direction of the nodes by the loads.
        let driven = |factors: &dyn Fn(usize) -> f64, which: usize| {
            let terms =
                all.loads.iter().zip(&own_loads).map(|(&(_, node), rows)| (factors(node), &rows[which]));
            Functional::sum(size, terms.filter(|term| term.0 != 0.0))
        };
        let mut components = Vec::new();
        for (place, force) in all.forces.iter().enumerate() {
            let moved = all.moved(force);
            let [e_driven, rate_driven] = [0, 1].map(|which| driven(&|node| moved[node], which));
            let (part, preload) = match force.by {
                ResidualMaker::Spring(i) => (Part::Spring(i), self.springs[i].preload),
                ResidualMaker::Stop(i) => (Part::Stop(i), 0.0),
                ResidualMaker::Normal(i) => (Part::Stop(self.first_contact + i), 0.0),
                ResidualMaker::Tangent(i) => {
                    let stop = self.first_contact + i;
                    let own = self.branches.iter().position(|branch| branch.stop() == Some(stop));
                    (Part::Branch(own.unwrap_or_default()), 0.0)
                }
            };
            let Some(own) = self.elongation_of_part(part) else { continue };
            let (e, rate) = (&own.e + &e_driven, &own.rate + &rate_driven);
            let x = match part {
                Part::Stop(i) => &self.stops[i].excess + &e_driven,
                Part::Branch(i) => Functional::unit(size, self.branches[i].place, 1.0),
                _ => &e + &self.constant(force.compliance * preload),
            };
            let limit = all.normal_of(place).map(|normal| {
                let friction = match part {
                    Part::Branch(i) => match self.branches[i].law {
                        BranchLaw::Contact { friction, .. } => friction,
                        _ => 0.0,
                    },
                    _ => 0.0,
                };
                (normal, friction)
            });
            components.push(Component { part, compliance: force.compliance, limit, e, rate, x, preload });
        }
        let nodes = all.nodes.iter().enumerate().map(|(k, &body)| {
            let rows = &self.bodies[body];
            let own = [(0, &rows.s), (1, &rows.v)]
                .map(|(which, row)| row + &driven(&|node| all.flexibility[(k, node)], which));
            let by = all.forces.iter().map(|force| all.moved(force)[k]).collect();
            ResidualNode { body, own, by }
        });
        let nodes = nodes.collect();
        let count = all.loads.len();
        let between_loads =
            DMatrix::from_fn(count, count, |i, j| all.flexibility[(all.loads[i].1, all.loads[j].1)]);
        let residual = Residual {
            components,
            between: all.between(),
            nodes,
            loads: all.loads.clone(),
            between_loads,
            size,
        };
        let acting = residual.apart();
        self.residual = Some(Arc::new(residual));
        self.configure(acting);
    }

    /// The rows of a load and of its rate.
    pub(crate) fn driving(&self, load: usize) -> [Functional; 2] {
        let row = self.loads[load].clone();
        [row.clone(), Functional::of(self.signals.derivative(&row))]
    }

    /// The machine with the rows of a mode.
    pub fn at_mode(&self, mode: &Mode) -> Cow<'_, Self> {
        let Some(residual) = &self.residual else { return Cow::Borrowed(self) };
        match self.configured(residual.of_mode(mode)) {
            Some(other) => Cow::Owned(other),
            None => Cow::Borrowed(self),
        }
    }

    /// The machine in another configuration; `None` if it is in this configuration.
    pub(crate) fn configured(&self, acting: Vec<Acting>) -> Option<Self> {
        if self.configuration.as_ref().is_none_or(|own| own.acting == acting) {
            return None;
        }
        let mut other = self.clone();
        other.configure(acting);
        Some(other)
    }

    /// The states of the forces on residual flexibility; `None` without such forces.
    pub(crate) fn configuration_of(&self) -> Option<&[Acting]> {
        self.configuration.as_ref().map(|own| &own.acting[..])
    }

    /// The states of the forces on residual flexibility in a mode.
    pub(crate) fn acting_in(&self, mode: &Mode) -> Option<Vec<Acting>> {
        self.residual.as_ref().map(|own| own.of_mode(mode))
    }

    /// The state of a stop on residual flexibility in the present configuration.
    pub(crate) fn configured_stop(&self, i: usize) -> Option<StopState> {
        let place = self.residual.as_ref()?.place(Part::Stop(i))?;
        let acts = self.configuration_of()?[place] == Acting::On;
        Some(if acts { StopState::Pressed } else { StopState::Below })
    }

    /// The state of a slider on residual flexibility in the present configuration.
    pub(crate) fn configured_slider(&self, i: usize) -> Option<SliderState> {
        let place = self.residual.as_ref()?.place(Part::Branch(i))?;
        Some(self.configuration_of()?[place].slider())
    }

    /// Whether a stop acts on residual flexibility.
    pub fn is_residual(&self, part: Part) -> bool {
        self.residual.as_ref().is_some_and(|own| own.place(part).is_some())
    }

    /// Coordinate and rate of a body as users see them: with residual flexibility.
    pub fn seen(&self, body: usize) -> [&Functional; 2] {
        let own = self.residual.iter().flat_map(|own| &own.nodes).position(|node| node.body == body);
        match (own, &self.configuration) {
            (Some(node), Some(configuration)) => {
                let [s, v] = &configuration.nodes[node];
                [s, v]
            }
            _ => [&self.bodies[body].s, &self.bodies[body].v],
        }
    }

    /// Whether a body is a node with residual flexibility.
    pub fn is_residual_node(&self, body: usize) -> bool {
        self.residual.as_ref().is_some_and(|own| own.nodes.iter().any(|node| node.body == body))
    }

    /// Elongation and rate of a part as users see them; `None` for a load.
    pub fn seen_elongation(&self, part: Part) -> Option<[&Functional; 2]> {
        let place = self.residual.as_ref().and_then(|own| own.place(part));
        if let (Some(place), Some(configuration)) = (place, &self.configuration) {
            let [e, rate] = &configuration.elongations[place];
            return Some([e, rate]);
        }
        self.elongation_of_part(part).map(|own| [&own.e, &own.rate])
    }
}

impl System {
    /// The energy stored in residual flexibility and in the elements that act on it, J
    /// (docs/assembly-law.md (A70)).
    pub(crate) fn stored_in_residual(&self, z: &[f64]) -> f64 {
        let (Some(own), Some(rows)) = (&self.residual, &self.configuration) else { return 0.0 };
        let forces: Vec<f64> = rows.forces.iter().map(|force| force.at(z)).collect();
        let loads: Vec<f64> = own.loads.iter().map(|load| self.loads[load.0].at(z)).collect();
        let mut stored = 0.0;
        for (c, component) in own.components.iter().enumerate() {
            // A spring has e = C (p - preload) and the energy k e²/2 + preload e.
            let (p, preload) = (forces[c], component.preload);
            stored += 0.5 * component.compliance * (p - preload) * (p + preload);
            stored += (0..forces.len()).map(|j| 0.5 * p * own.between[(c, j)] * forces[j]).sum::<f64>();
            let by_loads = own.loads.iter().zip(&loads).map(|(load, f)| own.nodes[load.1].by[c] * f);
            stored -= p * by_loads.sum::<f64>();
        }
        let pairs = |(i, f): (usize, &f64)| {
            let row = loads.iter().enumerate().map(|(j, other)| own.between_loads[(i, j)] * other);
            0.5 * f * row.sum::<f64>()
        };
        stored + loads.iter().enumerate().map(pairs).sum::<f64>()
    }
}
