//! The derivative of a start at rest, by the implicit function theorem on the contacts that bear
//! force (docs/assembly-law.md (A37)).

use super::lost::{Cause, Lost};
use super::machine::{Instant, Machine, STILL, Varied};
use crate::mode::{Contact, SliderState};
use crate::system::{BranchLaw, System};
use nalgebra::{DMatrix, DVector};

/// Singular values below this fraction of the largest entry count as zero: no force in this
/// direction.
const LOOSE: f64 = 1e-12;

/// Computes the derivative of the coordinates q in equilibrium by parameter `p`. It solves, for
/// the stiffness K of the mode and the closed stops' directions W,
///
/// ```text
/// K dq + W dλ = dF z + F dz - dW λ,    Wᵀ dq = -(dh z + h dz),
/// ```
///
/// where `delta` contains dz, the signals' derivatives. Along directions without forces, dq is
/// zero.
pub(super) fn equilibrium(
    machine: &Machine,
    p: usize,
    delta: &mut DVector<f64>,
    at: &Instant,
) -> Result<(), Lost> {
    let (system, tangent, mode) = (&machine.system, &machine.tangents[p], &at.mode.mode);
    let n = system.coordinates;
    let mut forces = (*system.forces).clone();
    for (i, &state) in mode.stops.iter().enumerate() {
        if let Some(force) = system.stop_force(i, state) {
            forces.ger(-1.0, &system.stops[i].elongation.w, &force, 1.0);
        }
    }
    for (i, &state) in mode.frictions.iter().enumerate() {
        if let Some(force) = system.friction_force(i, state, &mode.stops) {
            forces.ger(-1.0, &system.frictions[i].elongation.w, &force, 1.0);
        }
    }
    let mut right = tangent.forces_in(system, mode) * at.z;
    put_borne(machine, p, at, (&mut forces, &mut right));
    machine.vary_curved(p, at.z, delta);
    right += &forces * &*delta;
    if right.amax() == 0.0 && mode.contacts().all(|contact| is_unmoved(machine, p, contact, (delta, at))) {
        follow(machine, p, delta, at);
        return Ok(());
    }
    let held = held(machine, p, at)?;
    for &(k, contact) in &held {
        right.axpy(-at.mode.lambda[k].dot(at.z), &machine.contact(contact, p).1.w, 1.0);
    }
    let size = n + held.len();
    let mut matrix = DMatrix::zeros(size, size);
    let root = system.inertia.l();
    let stiffness = stiffness(system, &forces, at.z);
    // Use the inertia's metric: there, directions without force are orthogonal to all others.
    let half = root.solve_lower_triangular(&stiffness).unwrap_or_else(|| DMatrix::zeros(n, n));
    let whole = root.solve_lower_triangular(&half.transpose()).unwrap_or_else(|| DMatrix::zeros(n, n));
    // Friction that follows a normal force makes the stiffness unsymmetric.
    matrix.view_mut((0, 0), (n, n)).copy_from(&whole.transpose());
    let scale = whole.amax().max(f64::MIN_POSITIVE);
    let mut known = DVector::zeros(size);
    known.rows_mut(0, n).copy_from(&root.solve_lower_triangular(&right).unwrap_or_else(|| DVector::zeros(n)));
    for (place, &(_, contact)) in held.iter().enumerate() {
        let (own, by) = machine.contact(contact, p);
        let column = &*own.column;
        let norm = column.norm().max(f64::MIN_POSITIVE);
        matrix.view_mut((0, n + place), (n, 1)).copy_from(&(column * (scale / norm)));
        matrix.view_mut((n + place, 0), (1, n)).copy_from(&(column.transpose() * (scale / norm)));
        let off = match contact {
            Contact::Stop(i) if system.keeps_place(contact) => {
                let column = Varied { p, delta, scale: delta };
                machine.point(column, at).of(&system.stops[i].excess, &tangent.stops[i].excess)
            }
            _ => by.w.dot(&at.z.rows(0, n)),
        };
        known[n + place] = -off * scale / norm;
    }
    let limit = LOOSE * matrix.amax();
    let solved = matrix.svd(true, true).solve(&known, limit).unwrap_or_else(|_| DVector::zeros(size));
    let found = root.tr_solve_lower_triangular(&solved.rows(0, n)).unwrap_or_else(|| DVector::zeros(n));
    delta.rows_mut(0, n).copy_from(&found);
    follow(machine, p, delta, at);
    Ok(())
}

/// The stiffness: the derivative of the forces by the coordinates, negative, with the slopes of
/// curved forces.
fn stiffness(system: &System, forces: &DMatrix<f64>, z: &DVector<f64>) -> DMatrix<f64> {
    let n = system.coordinates;
    let mut stiffness = -forces.columns(0, n).into_owned();
    if system.curved.is_empty() {
        return stiffness;
    }
    let mut variation = DVector::zeros(z.len());
    for k in 0..n {
        variation.fill(0.0);
        variation[k] = 1.0;
        system.vary_curved(z.as_slice(), variation.as_mut_slice());
        for own in &system.curved {
            stiffness.column_mut(k).axpy(-variation[own.place], &forces.column(own.place), 1.0);
        }
    }
    stiffness
}

/// Replaces the forces of springs in series in the mode after the start by their forces at rest,
/// including the column's changes. A relaxed spring bears no force; a spring whose slider is at
/// its level bears this level.
fn put_borne(
    machine: &Machine,
    p: usize,
    at: &Instant,
    (forces, right): (&mut DMatrix<f64>, &mut DVector<f64>),
) {
    let (system, tangent) = (&machine.system, &machine.tangents[p]);
    for (i, (branch, by)) in system.branches.iter().zip(&tangent.branches).enumerate() {
        let w = &branch.elongation.w;
        let borne = match level_at_rest(machine, i, at) {
            // The inner place is 0, so the stretch is e.
            Rest::Elastic => {
                forces.ger(-branch.stiffness, w, &branch.elongation.e, 1.0);
                by.force.dot(at.z) + branch.stiffness * by.elongation.e.dot(at.z)
            }
            Rest::Relaxed => {
                forces.ger(1.0, w, &branch.force, 1.0);
                0.0
            }
            Rest::AtLevel(direction) => {
                if let Some(level) = branch.followed_level() {
                    forces.ger(-direction, w, level, 1.0);
                }
                direction * by.level.dot(at.z)
            }
            Rest::Open => 0.0,
        };
        let in_mode = tangent.branch_force(i, at.mode.mode.sliders[i]);
        right.axpy(in_mode.dot(at.z) - borne, w, 1.0);
    }
}

/// State of a branch at rest: a branch with a dashpot has relaxed; a slider has not moved from
/// zero, or is at its level; a contact is open.
enum Rest {
    Relaxed,
    Open,
    Elastic,
    AtLevel(f64),
}

fn level_at_rest(machine: &Machine, i: usize, at: &Instant) -> Rest {
    let branch = &machine.system.branches[i];
    match branch.law {
        BranchLaw::Dashpot(_) => Rest::Relaxed,
        _ if at.mode.mode.sliders[i] == SliderState::Off => Rest::Open,
        _ if machine.assembly.inner[branch.place - 2 * machine.system.coordinates] == 0.0 => Rest::Elastic,
        _ => Rest::AtLevel(branch.force.dot(at.z).signum()),
    }
}

/// Makes the inner places of relaxed springs and of sliders at their level follow the elongations.
fn follow(machine: &Machine, p: usize, delta: &mut DVector<f64>, at: &Instant) {
    for (i, (branch, by)) in machine.system.branches.iter().zip(&machine.tangents[p].branches).enumerate() {
        let direction = match level_at_rest(machine, i, at) {
            Rest::Elastic => continue,
            Rest::Relaxed | Rest::Open => 0.0,
            Rest::AtLevel(direction) => direction,
        };
        let rows = branch.followed_level().map_or(0.0, |level| level.dot(delta));
        let stretch = (direction * (rows + by.level.dot(at.z)) - by.force.dot(at.z)) / branch.stiffness;
        let e = &branch.elongation.e;
        delta[branch.place] = e.dot(delta) + by.elongation.e.dot(at.z) - stretch;
    }
}

/// Whether a column leaves the direction, place and level of a contact at rest unchanged.
fn is_unmoved(machine: &Machine, p: usize, contact: Contact, (delta, at): (&DVector<f64>, &Instant)) -> bool {
    let (system, tangent, by) = (&machine.system, &machine.tangents[p], machine.contact(contact, p).1);
    let (row, own) = match contact {
        // At rest a freewheel keeps the angle that it has at zero displacement, whatever its rate.
        Contact::Stop(_) if !system.keeps_place(contact) => return by.w.amax() == 0.0,
        Contact::Stop(i) => (&*system.stops[i].excess, &tangent.stops[i].excess),
        Contact::Friction(i) => {
            let friction = &system.frictions[i];
            let Some(place) = friction.place(&at.mode.mode.stops) else { return true };
            (&*friction.levels[place].static_level, &tangent.frictions[i].levels[place].static_level)
        }
        Contact::Slider(i) => (&*system.branches[i].force, &tangent.branches[i].force),
    };
    by.w.amax() == 0.0 && row.dot(delta) + own.dot(at.z) == 0.0
}

/// Returns the contacts that keep their place at rest, with their index in the basis: closed
/// stops, which must press, and, if one of them bears a force, sticking friction and engaged
/// freewheels. For friction and freewheels w·q stays 0, its value at zero displacement, and their
/// forces must stay inside the limits.
fn held(machine: &Machine, p: usize, at: &Instant) -> Result<Vec<(usize, Contact)>, Lost> {
    let (mode, n) = (&at.mode.mode, machine.system.coordinates);
    let force = |k: usize| {
        let row = &at.mode.lambda[k];
        let size: f64 = row.iter().zip(at.z.iter()).map(|(a, b)| (a * b).abs()).sum();
        (row.dot(at.z), STILL * size)
    };
    let bears = |k: usize| force(k).0.abs() > force(k).1;
    let basis = mode.basis.iter().copied().enumerate();
    let holds = |contact: Contact| machine.system.keeps_place(contact);
    let rubs = basis.clone().any(|(k, contact)| !holds(contact) && bears(k));
    let keeps = |&(_, contact): &(usize, Contact)| rubs || holds(contact);
    let way = |contact: Contact| {
        let w = &machine.contact(contact, p).0.w;
        let (way, size) = (w.dot(&at.z.rows(0, n)), w.abs().dot(&at.z.rows(0, n).abs()));
        way.abs() <= STILL * size
    };
    let stands = |(k, contact): (usize, Contact)| match contact {
        Contact::Stop(_) => force(k).0 > force(k).1 && (holds(contact) || way(contact)),
        Contact::Friction(i) => {
            let level = machine.system.frictions[i].at(&mode.stops).map_or(0.0, |own| own.level.dot(at.z));
            way(contact) && force(k).0.abs() < (1.0 - STILL) * level
        }
        Contact::Slider(_) => true,
    };
    let contacts = mode.contacts().filter(|c| keeps(&(0, *c)));
    let limit = |contact| Lost { time: at.time, element: machine.name_of(contact), cause: Cause::Limit };
    for contact in contacts {
        let place = mode.basis.iter().position(|&c| c == contact);
        if !place.is_some_and(|k| stands((k, contact))) {
            return Err(limit(contact));
        }
    }
    Ok(basis.filter(keeps).collect())
}
