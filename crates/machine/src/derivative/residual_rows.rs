//! Derivatives of a machine's rows and quantities on residual flexibility, in the present
//! configuration (docs/assembly-law.md (A68), (A72)).

use super::mode::VariedMode;
use super::residual::{Moved, ResidualTangent, vary};
use super::rows::{BranchTangent, StopTangent};
use super::tangent::Tangent;
use super::values::Point;
use crate::description::{Description, ResidualForces, ResidualMaker, StopLaw};
use crate::functional::{Functional, StateRow};
use crate::quantity::{Owner, Quantity, What};
use crate::system::{Acting, Configuration, MadeStop, Part, Residual, System, excess, made_stops};
use std::sync::Arc;

/// The index of a force on residual flexibility, the rows of all forces and their derivatives.
type Component<'a> = (usize, &'a Residual, &'a Configuration, &'a ResidualTangent);

impl Tangent {
    /// The derivatives in the present configuration of a system; `None` without residual
    /// flexibility. Uses the derivatives of signals, bodies and loads.
    pub(super) fn on_residual(
        &self,
        system: &System,
        d: &Description,
        along: &Description,
    ) -> Option<ResidualTangent> {
        let (own, rows, all) =
            (system.residual.as_ref()?, system.configuration.as_ref()?, ResidualForces::of(d)?);
        let loads = all.loads.iter().map(|&(load, _)| (system.driving(load), self.driving(system, load)));
        let loads: Vec<([StateRow; 2], [StateRow; 2])> =
            loads.map(|(at, by)| (at.map(Functional::into_row), by)).collect();
        // The displacement by the loads. `factors` has the factor of each node and its derivative.
        let driven = |factors: &dyn Fn(usize) -> [f64; 2], which: usize| {
            let mut sum = StateRow::zeros(system.signals.size);
            for (&(_, node), (at, by)) in all.loads.iter().zip(&loads) {
                let [factor, varied] = factors(node);
                sum.axpy(factor, &by[which], 1.0);
                sum.axpy(varied, &at[which], 1.0);
            }
            sum
        };
        let stops = made_stops(d, Some(along));
        let (by_arms, between) = all.along(along);
        let moved = all.forces.iter().zip(&own.components).enumerate().map(|(c, (force, component))| {
            let factors = |node: usize| [own.nodes[node].by[c], by_arms[c][node]];
            let driven = [0, 1].map(|which| driven(&factors, which));
            self.moved(system, (d, along, &stops), (force.by, component.compliance), driven)
        });
        let moved: Vec<Moved> = moved.collect();
        let forces = vary(own, rows, &rows.forces, (&moved, &between), |own| &own.x);
        let rates = vary(own, rows, &rows.rates, (&moved, &between), |own| &own.whole[1]);
        let nodes = all.nodes.iter().enumerate().map(|(k, &body)| {
            let row = |which: usize| {
                let by = &self.bodies[body];
                let place = if which == 0 { &by.s } else { &by.v };
                let mut row = place + driven(&|node| [all.flexibility[(k, node)], 0.0], which);
                let (taken, at) = if which == 0 { (&forces, &rows.forces) } else { (&rates, &rows.rates) };
                own.nodes[k].by.iter().zip(taken).for_each(|(arm, force)| row.axpy(-arm, force, 1.0));
                by_arms.iter().zip(at).for_each(|(by, force)| row.axpy(-by[k], force, 1.0));
                row
            };
            [row(0), row(1)]
        });
        let nodes = nodes.collect();
        Some(ResidualTangent { moved, between, forces, rates, nodes })
    }

    /// The derivatives of the rows of a load and of its rate.
    fn driving(&self, system: &System, load: usize) -> [StateRow; 2] {
        let own = &self.loads[load];
        [own.clone(), system.signals.derivative(own) + self.signals.turned(&system.loads[load])]
    }

    /// The derivatives of an element's numbers and rows. `stops` has the derivatives of the stops'
    /// numbers; `e_driven` and `rate_driven` are the derivatives of what loads add to the elongation
    /// and its rate.
    fn moved(
        &self,
        system: &System,
        (d, along, stops): (&Description, &Description, &[MadeStop]),
        (maker, compliance): (ResidualMaker, f64),
        [e_driven, rate_driven]: [StateRow; 2],
    ) -> Moved {
        let one = system.constant(1.0).into_row();
        let own = self.elongation(system, maker.arms(d), maker.arms(along));
        let whole = [own.e + e_driven, own.rate + rate_driven];
        // A rigid stop has no stiffness that varies.
        let by_stiffness = |dk: f64| if compliance == 0.0 { 0.0 } else { -compliance * compliance * dk };
        let stop = |stop: usize, whole: [StateRow; 2]| {
            let (gap, dk) = stops.get(stop).map_or((0.0, 0.0), |made| match made.law {
                StopLaw::Compliant { stiffness, .. } => (made.gap, stiffness),
                StopLaw::Rigid { .. } => (made.gap, 0.0),
            });
            Moved { compliance: by_stiffness(dk), friction: 0.0, x: excess(&whole[0], gap, &one), whole }
        };
        match maker {
            ResidualMaker::Spring(i) => {
                let (own, by) = (&d.springs[i], &along.springs[i]);
                let dc = by_stiffness(by.along()[0]);
                let x = &whole[0] + (dc * own.preload + compliance * by.preload) * &one;
                Moved { compliance: dc, friction: 0.0, whole, x }
            }
            ResidualMaker::Stop(i) => stop(i, whole),
            ResidualMaker::Normal(i) => stop(system.first_contact + i, whole),
            ResidualMaker::Tangent(i) => {
                let by = &along.contacts[i];
                let dc = by_stiffness(by.tangents[0].stiffness);
                Moved { compliance: dc, friction: by.friction, x: 0.0 * &one, whole }
            }
        }
    }

    /// The derivative of the force of a part on residual flexibility.
    pub(super) fn residual_force(&self, system: &System, part: Part) -> Option<StateRow> {
        let (c, _, _, varied) = self.component(system, part)?;
        Some(varied.forces[c].clone())
    }

    /// The index of a part among the forces on residual flexibility, with the rows and their
    /// derivatives; `None` for a part that acts elsewhere.
    fn component<'a>(&'a self, system: &'a System, part: Part) -> Option<Component<'a>> {
        let own = system.residual.as_deref()?;
        Some((own.place(part)?, own, system.configuration.as_ref()?, self.residual.as_ref()?))
    }

    /// Replaces the derivatives of a stop's rows if it acts on residual flexibility.
    pub(super) fn residual_stop(&self, system: &System, i: usize, by: StopTangent) -> StopTangent {
        let Some((c, own, rows, varied)) = self.component(system, Part::Stop(i)) else { return by };
        let (alone, moved) = (own.components[c].compliance + own.between[(c, c)], &varied.moved[c]);
        let force = varied.forces[c].clone();
        if rows.acting[c] == Acting::On {
            let by_flexibility = moved.compliance + varied.between[(c, c)];
            let excess = by_flexibility * &*rows.forces[c] + alone * &force;
            return StopTangent { excess, spring: force.clone(), force, ..by };
        }
        let others = varied.taken(own, rows, c, false)
            - own.between[(c, c)] * &force
            - varied.between[(c, c)] * &*rows.forces[c];
        let excess = &moved.x - others;
        let by_flexibility = (moved.compliance + varied.between[(c, c)]) / (alone * alone);
        let force = (1.0 / alone) * &excess - by_flexibility * &*system.stops[i].excess;
        StopTangent { excess, spring: force.clone(), force, ..by }
    }

    /// Replaces the derivatives of a branch's rows if it acts on residual flexibility.
    pub(super) fn residual_branch(&self, system: &System, i: usize, mut by: BranchTangent) -> BranchTangent {
        let Some((c, own, rows, varied)) = self.component(system, Part::Branch(i)) else { return by };
        let (component, moved) = (&own.components[c], &varied.moved[c]);
        let Some((normal, friction)) = component.limit else { return by };
        let Part::Stop(stop) = own.components[normal].part else { return by };
        [by.elongation.e, by.elongation.rate] = moved.whole.clone();
        by.rate = moved.whole[1].clone();
        by.force = varied.forces[c].clone();
        by.level = moved.friction * &*system.stops[stop].force + friction * &self.stops[stop].force;
        let stretch = [(false, &rows.forces, &varied.forces), (true, &rows.rates, &varied.rates)];
        let stretch = stretch.map(|(of_rates, forces, moves)| {
            varied.taken(own, rows, c, of_rates)
                + component.compliance * &moves[c]
                + moved.compliance * &*forces[c]
        });
        by.sliding = rows.acting[c].direction() * &stretch[1];
        by.slaved = (rows.acting[c] != Acting::On).then_some(stretch);
        by
    }
}

impl Point<'_> {
    /// The derivative of a quantity of a node with residual flexibility; `None` for other bodies.
    pub(super) fn residual_body(&self, i: usize, what: What) -> Option<f64> {
        let own = self.system.residual.as_ref()?.nodes.iter().position(|node| node.body == i)?;
        let [s, v] = &self.tangent.residual.as_ref()?.nodes[own];
        let rows = self.system.seen(i);
        Some(match what {
            What::S => self.of(rows[0], s),
            What::V => self.of(rows[1], v),
            _ => {
                let changes = self.mode.rates_by(self.p, self.z, self.delta);
                rows[1].dot(&changes) + v.dot(&self.mode.rates(self.z))
            }
        })
    }

    /// The derivative of the elongation, or of its rate, of a part on residual flexibility; `None`
    /// for other parts.
    pub(super) fn residual_elongation(&self, part: Part, what: What) -> Option<f64> {
        let own = self.system.residual.as_ref()?;
        let (c, rows) = (own.place(part)?, self.system.configuration.as_ref()?);
        let [e, rate] = self.system.seen_elongation(part)?;
        let by = self.tangent.residual.as_ref()?.elongation(own, rows, c);
        let is_place = matches!(what, What::E | What::TangentE(_));
        Some(if is_place { self.of(e, &by[0]) } else { self.of(rate, &by[1]) })
    }
}

/// The row of a place or rate that residual flexibility changes; `None` for other quantities.
pub(super) fn residual_row(system: &System, mode: &Arc<VariedMode>, quantity: Quantity) -> Option<StateRow> {
    let row = |own: &Functional| Some(own.clone().into_row());
    match (quantity.owner, quantity.what) {
        (Owner::Body(i), what) if system.is_residual_node(i) => {
            let [s, v] = system.seen(i);
            match what {
                What::S => row(s),
                What::V => row(v),
                _ => {
                    let mut sum = StateRow::zeros(system.signals.size);
                    for (j, x) in v.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                        mode.a.row(j).iter().for_each(|&(k, a)| sum[k] += x * a);
                    }
                    Some(sum)
                }
            }
        }
        (Owner::Element(i), What::E | What::TangentE(_) | What::Rate) => {
            let part = *system.parts_of(i, quantity.what).first()?;
            system.residual.as_ref()?.place(part)?;
            let [e, rate] = system.seen_elongation(part)?;
            if matches!(quantity.what, What::E | What::TangentE(_)) { row(e) } else { row(rate) }
        }
        _ => None,
    }
}
