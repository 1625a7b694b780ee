//! Problems of residual flexibility: its matrix, the elements on its nodes, and the uniqueness of
//! their forces (docs/assembly-law.md (A71)).

mod unique;

use super::refused;
use crate::description::{
    Arms, BlockInput, BodyKind, Description, Interpolation, Modal, Residual, ResidualForces, ResidualMaker,
    Signal, Stop, StopLaw,
};
use crate::elements::Element;
use crate::refusal::Problem;

/// Tolerance of symmetry, and of negative eigenvalues, relative to the largest entry or eigenvalue.
const SYMMETRIC: f64 = 1e-9;

/// Fault of a contact without a stiffness.
pub(crate) const RIGID: &str = "requires `stiffness`, the normal stiffness; it may be left out only where every node of `normal` has residual \
     flexibility; use [stop.NAME] for a rigid stop";

/// Advice for an element that cannot act on residual flexibility.
const REDUCE: &str = "reduce the body with `--method rubin` or `craig-bampton`, which keep the flexibility as modes, or take the node \
     out of `residual`";

/// Adds the problems of the indices of nodes, which no file has.
pub(super) fn structure(machine: &Description, modal: &Modal, problems: &mut Vec<Problem>) {
    let Some(Residual { nodes, flexibility }) = &modal.residual else { return };
    let own = modal.first..modal.first + modal.frequencies.len();
    let is_node = |node: &usize| match machine.bodies.get(*node).map(|body| &body.kind) {
        Some(BodyKind::Node(row)) => row.iter().all(|term| own.contains(&term.0)),
        _ => false,
    };
    let mut seen = nodes.clone();
    seen.sort_unstable();
    seen.dedup();
    if !nodes.iter().all(is_node) || seen.len() != nodes.len() {
        let text = "expected nodes of this body, each once";
        problems.push(Problem::new(format!("modal.{}.residual.nodes", modal.name), None, text));
    }
    if flexibility.shape() != (nodes.len(), nodes.len()) || nodes.is_empty() {
        let text = "expected a row and a column for each node";
        problems.push(Problem::new(format!("modal.{}.residual.flexibility", modal.name), None, text));
    }
}

/// Adds the problems of residual flexibility.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let before = problems.len();
    for modal in &machine.modals {
        if let Some(residual) = &modal.residual {
            check_matrix(modal, residual, problems);
        }
    }
    rigid(machine, problems);
    if problems.len() > before {
        return;
    }
    let Some(forces) = ResidualForces::of(machine) else { return };
    let on_nodes = |arms: &Arms| arms.terms.iter().find(|own| forces.nodes.contains(&own.0)).map(|own| own.0);
    elements(machine, &on_nodes, problems);
    loads(machine, &forces, problems);
    blocks(machine, &on_nodes, problems);
    jumps(machine, &forces, problems);
    if problems.is_empty() {
        rest(machine, &forces, problems);
    }
    if problems.len() == before {
        unique::check(machine, &forces, problems);
    }
}

fn check_matrix(modal: &Modal, residual: &Residual, problems: &mut Vec<Problem>) {
    let name = format!("modal.{}.residual.flexibility", modal.name);
    let g = &residual.flexibility;
    if g.iter().any(|x| !x.is_finite()) {
        return problems.push(Problem::new(name, None, "expected finite numbers"));
    }
    for i in 0..g.nrows() {
        for j in 0..i {
            if (g[(i, j)] - g[(j, i)]).abs() > SYMMETRIC * g.amax() {
                let text = format!(
                    "expected a symmetric matrix; the entry [{i}][{j}] is {:?}, the entry [{j}][{i}] is {:?}",
                    g[(i, j)],
                    g[(j, i)]
                );
                return problems.push(Problem::new(name, None, text));
            }
        }
    }
    let eigenvalues = (0.5 * (g + g.transpose())).symmetric_eigenvalues();
    let (least, most) = (eigenvalues.min(), eigenvalues.amax());
    if least < -SYMMETRIC * most {
        let text = format!(
            "has the eigenvalue {least:.3e}; expected no negative eigenvalue: a force would move its node against \
             itself"
        );
        problems.push(Problem::new(name, None, text));
    }
}

/// Refuses stops and contacts without a stiffness where nothing else is flexible.
fn rigid(machine: &Description, problems: &mut Vec<Problem>) {
    let is_flexible = |arms: &Arms| {
        let ends = arms.terms.iter().map(|own| own.0);
        let mut nodes = ends.filter(|&i| matches!(machine.bodies[i].kind, BodyKind::Node(_))).peekable();
        nodes.peek().is_some() && nodes.all(|node| machine.has_residual(node))
    };
    for Stop { name, arms, law, .. } in &machine.stops {
        if matches!(law, StopLaw::Compliant { stiffness, .. } if stiffness.is_infinite())
            && !is_flexible(arms)
        {
            let text = "requires `restitution` (rigid stop) or `stiffness` (compliant stop); neither is needed \
                        only where every node of the stop has residual flexibility";
            problems.push(Problem::new(format!("stop.{name}"), None, text));
        }
    }
    for contact in machine.contacts.iter().filter(|own| own.stiffness.is_infinite()) {
        if !is_flexible(&contact.normal) {
            problems.push(Problem::new(format!("contact.{}", contact.name), None, RIGID));
        }
    }
}

/// Refuses elements whose rate or impulse would act on a node without mass, and curved forces.
fn elements(machine: &Description, on_nodes: &dyn Fn(&Arms) -> Option<usize>, problems: &mut Vec<Problem>) {
    let mut refuse = |(name, value): (String, Option<f64>), node: usize, what: &str| {
        let node = &machine.bodies[node].name;
        let text = format!("{what} cannot act on `{node}`, which has residual flexibility; {REDUCE}");
        problems.push(Problem::new(name, value.map(|value| format!("{value:?}")), text));
    };
    for element in machine.elements() {
        let Some(node) = element.all_arms().find_map(on_nodes) else { continue };
        let of = (element.dotted(), None);
        let key = |key: &str, value: f64| (format!("{}.{key}", element.dotted()), Some(value));
        match element {
            Element::Spring(own) if own.damping != 0.0 => {
                refuse(key("damping", own.damping), node, "a dashpot")
            }
            Element::Spring(own) if own.series.is_some() => refuse(of, node, "a dashpot or slider in series"),
            Element::Spring(own) if own.stepped.is_some() => {
                refuse(of, node, "a stiffness that steps in time")
            }
            Element::Spring(own) if own.is_curved() || !own.points.is_empty() => {
                refuse(of, node, "a curved force")
            }
            Element::Spring(own) if own.stiffness <= 0.0 => {
                refuse(key("stiffness", own.stiffness), node, "a spring without stiffness")
            }
            Element::Damper(_) => refuse(of, node, "a dashpot"),
            Element::Stop(own) => match own.law {
                StopLaw::Rigid { restitution } => {
                    let what = "an impulse with a restitution coefficient (leave out `restitution` for a rigid stop \
                                that the waves in the body rebound from)";
                    refuse(key("restitution", restitution), node, what);
                }
                StopLaw::Compliant { damping, .. } if damping != 0.0 => {
                    refuse(key("damping", damping), node, "a dashpot");
                }
                StopLaw::Compliant { .. } if own.contact.is_some() => refuse(of, node, "a curved force"),
                StopLaw::Compliant { .. } if own.stepped.is_some() => {
                    refuse(of, node, "a stiffness that steps in time");
                }
                StopLaw::Compliant { stiffness, .. } if stiffness <= 0.0 => {
                    refuse(key("stiffness", stiffness), node, "a stop without stiffness");
                }
                StopLaw::Compliant { .. } => {}
            },
            Element::Contact(own) if own.damping != 0.0 => {
                refuse(key("damping", own.damping), node, "a dashpot")
            }
            Element::Contact(own) => {
                let missing = !own.tangents.is_empty() && on_nodes(&own.normal).is_none();
                if missing {
                    let name = format!("{}.tangent", element.dotted());
                    refuse((name, None), node, "the tangent without the normal of a contact");
                }
            }
            Element::Friction(_) => refuse(of, node, "a friction element"),
            Element::Freewheel(_) => refuse(of, node, "a freewheel"),
            Element::Link(_) => refuse(of, node, "a rigid link"),
            _ => {}
        }
    }
    for friction in &machine.frictions {
        let stop = friction.follows.as_ref().and_then(|own| machine.stops.get(own.stop));
        if let Some(node) = stop.and_then(|stop| on_nodes(&stop.arms)) {
            refuse(
                (format!("friction.{}.follows", friction.name), None),
                node,
                "a stop with a friction element",
            );
        }
    }
}

/// Whether the value of a signal jumps.
fn jumps_in(signal: &Signal) -> bool {
    let holds = signal.table.as_ref().is_some_and(|own| own.interpolation == Interpolation::Hold);
    signal.input || holds || !signal.steps.is_empty()
}

/// Refuses loads on nodes whose force jumps: the node would jump with it.
fn loads(machine: &Description, forces: &ResidualForces, problems: &mut Vec<Problem>) {
    for &(i, node) in &forces.loads {
        let (load, node) = (&machine.loads[i], &machine.bodies[forces.nodes[node]].name);
        let follows = machine.feeds.iter().any(|feed| feed.load == i);
        if follows || jumps_in(&load.force) {
            let what = if follows { "follows a block" } else { "may jump (input, steps or a held table)" };
            let text = format!(
                "the force {what}, and with it `{node}`, which has residual flexibility; expected a continuous \
                 signal of time, such as a straight table; otherwise {REDUCE}"
            );
            problems.push(Problem::new(format!("load.{}", load.name), None, text));
        }
    }
}

/// Refuses blocks that read nodes with residual flexibility.
fn blocks(machine: &Description, on_nodes: &dyn Fn(&Arms) -> Option<usize>, problems: &mut Vec<Problem>) {
    let elements: Vec<Element> = machine.elements().collect();
    for block in &machine.blocks {
        for input in &block.inputs {
            let node = match *input {
                BlockInput::Place(body) | BlockInput::Rate(body) => {
                    machine.has_residual(body).then_some(body)
                }
                BlockInput::Elongation(i) | BlockInput::ElongationRate(i) => {
                    elements.get(i).and_then(|own| own.all_arms().find_map(on_nodes))
                }
                _ => None,
            };
            if let Some(node) = node {
                let node = &machine.bodies[node].name;
                let text = format!(
                    "a block cannot read `{node}`, which has residual flexibility: its place depends on the \
                     contacts; {REDUCE}"
                );
                problems.push(Problem::new(format!("block.{}.inputs", block.name), None, text));
            }
        }
    }
}

/// Refuses contacts with friction in a machine with prescribed bodies that jump: the slider's way
/// would depend on the order of the coupled contacts.
fn jumps(machine: &Description, forces: &ResidualForces, problems: &mut Vec<Problem>) {
    let jumps = |kind: &BodyKind| matches!(kind, BodyKind::Prescribed { motion, .. } if jumps_in(motion));
    let Some(body) = machine.bodies.iter().find(|body| jumps(&body.kind)) else { return };
    let slides = |own: &ResidualMaker| if let ResidualMaker::Tangent(i) = *own { Some(i) } else { None };
    if let Some(i) = forces.forces.iter().find_map(|own| slides(&own.by)) {
        let contact = &machine.contacts[i];
        let text = format!(
            "friction on residual flexibility is not supported in a machine whose body.{} jumps (input, steps or \
             a held table); expected a continuous motion",
            body.name
        );
        problems.push(refused(format!("contact.{}.friction", contact.name), friction_of(machine, i), text));
    }
}

fn friction_of(machine: &Description, contact: usize) -> f64 {
    machine.contacts[contact].friction
}

/// Refuses the start at rest of forces that depend on one another.
fn rest(machine: &Description, forces: &ResidualForces, problems: &mut Vec<Problem>) {
    let between = forces.between();
    let is_coupled = (0..between.nrows()).any(|i| (0..i).any(|j| between[(i, j)] != 0.0));
    if machine.starts_at_rest && is_coupled {
        let text = "is not supported with several elements that share residual flexibility; give the start of each \
                    body";
        problems.push(Problem::new("start", Some("\"rest\"".into()), text));
    }
}
