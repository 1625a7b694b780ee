//! Checks of bodies with many coordinates and of the nodes on them.

use super::refused;
use crate::description::{BodyKind, Description, Modal};
use crate::elements::Element;
use crate::refusal::Problem;

/// Largest number of coordinates of all bodies with many coordinates.
pub(crate) const MOST_COORDINATES: usize = 500;

/// Problems of lengths and indices; in a file only the count can be wrong.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let inner = machine.bodies.iter().filter(|body| body.is_inner()).count();
    if inner > MOST_COORDINATES {
        let text = format!("there are {inner} coordinates in all; expected at most {MOST_COORDINATES}");
        problems.push(Problem::new("modal", None, text));
    }
    for modal in &machine.modals {
        check_modal(machine, modal, problems);
        super::residual::structure(machine, modal, problems);
    }
    for matrix in &machine.matrices {
        let coordinates = Element::Matrix(matrix).coordinates();
        for (i, body) in coordinates.clone().enumerate() {
            let name = Description::name_of_coordinate(&matrix.name, i);
            let own = machine.bodies.get(body).filter(|own| own.name == name);
            if !matches!(own.map(|own| &own.kind), Some(BodyKind::Free(free)) if free.inertia == 1.0) {
                problems.push(Problem::new(
                    name,
                    None,
                    "expected the body that Description::add_matrix makes",
                ));
            }
        }
    }
    let owned: usize = machine.elements().map(|element| element.coordinates().len()).sum();
    if problems.is_empty() && owned != inner {
        let text =
            format!("{inner} bodies are named as coordinates; expected {owned}, one for each coordinate");
        problems.push(Problem::new("modal", None, text));
    }
    for body in &machine.bodies {
        let BodyKind::Node(row) = &body.kind else { continue };
        let rises = row.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let is_inner = |i: usize| machine.bodies.get(i).is_some_and(|own| own.is_inner());
        let sound = |&(i, factor): &(usize, f64)| is_inner(i) && factor.is_finite() && factor != 0.0;
        if row.is_empty() || !rises || !row.iter().all(sound) {
            let text = "expected coordinates in increasing order, with finite factors other than 0";
            problems.push(Problem::new(format!("body.{}", body.name), None, text));
        }
    }
}

fn check_modal(machine: &Description, modal: &Modal, problems: &mut Vec<Problem>) {
    let (of, count) = (format!("modal.{}", modal.name), modal.frequencies.len());
    if count == 0 {
        problems.push(Problem::new(format!("{of}.frequencies"), None, "expected at least one frequency"));
    }
    if ![1, count].contains(&modal.damping_ratios.len()) {
        let text = format!(
            "has {} values; expected one, or one for each of {count} modes",
            modal.damping_ratios.len()
        );
        problems.push(Problem::new(format!("{of}.damping_ratio"), None, text));
    }
    for i in 0..count {
        let name = Description::name_of_coordinate(&modal.name, i);
        let body = machine.bodies.get(modal.first + i).filter(|own| own.name == name);
        match body.map(|own| &own.kind) {
            Some(BodyKind::Free(free)) if modal.has_masses || free.inertia == 1.0 => {}
            Some(BodyKind::Free(free)) => {
                problems.push(refused(
                    format!("{of}.masses[{i}]"),
                    free.inertia,
                    "must be 1 if the modes have no masses",
                ));
            }
            _ => problems.push(Problem::new(name, None, "expected a free body of this name for each mode")),
        }
    }
}
