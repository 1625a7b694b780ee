//! The factor of K - σ M: definiteness of K and M, the shift σ, rigid-body modes.

use crate::eigen::{self, Modes};
use crate::factor::Analysis;
use crate::problem::Problem;
use crate::sparse::Symmetric;
use crate::{Error, Result};

/// Ratio of a pivot to its diagonal entry above which K is positive definite beyond rounding.
const DEFINITE: f64 = 1e-9;
/// Ratio of a pivot to its diagonal entry below which a matrix counts as indefinite: rounding is
/// smaller.
const NEGATIVE: f64 = -1e-9;
/// Increase of a diagonal that keeps pivots of a semidefinite matrix above 0.
const MORE: f64 = 1e-11;
/// Strain energy of a rigid-body mode over the sum of its absolute terms: rounding of the entries
/// of K, which programs print with 13 digits or more.
const RIGID: f64 = 1e-12;
/// Largest eigenvalue of a rigid-body mode over the first elastic one: modes of long beams with
/// many elements have little strain energy among their terms, too.
const RIGID_GAP: f64 = 1e-4;
/// Fraction of the first elastic eigenvalue below which only rigid-body modes are counted.
const BELOW_ELASTIC: f64 = 1e-2;
/// First shift of a body that may be free, as a part of the median of K's over M's diagonal.
const FIRST_SHIFT: f64 = 1e-7;
/// Shift of a free body over its first elastic eigenvalue: a third of its frequency.
const SHIFT: f64 = 0.1;

/// Factorises K - σ M. `name` names a row in messages.
///
/// # Errors
/// An error with the dof if K or M has a negative eigenvalue.
pub fn factorise<'m>(
    stiffness: &'m Symmetric,
    mass: &'m Symmetric,
    name: &dyn Fn(usize) -> String,
) -> Result<Problem<'m>> {
    let analysis = Analysis::new(&stiffness.plus(0.0, mass))?;
    check_mass(mass, name)?;
    // Both have the pattern of the sum.
    let padded = stiffness.plus(0.0, mass);
    if let Ok(factor) = analysis.cholesky(&padded)?
        && factor.least_pivot(&padded).1 > DEFINITE
    {
        return Ok(Problem { stiffness, mass, analysis, factor, shift: 0.0, rigid: 0 });
    }
    let (dof, ratio) = analysis.least_pivot(&padded, MORE)?;
    if ratio < NEGATIVE {
        return Err(negative("stiffness", name(dof), ratio));
    }
    shifted(stiffness, mass, analysis, name)
}

/// The problem of a body that may be free: K - σ M with σ < 0.
fn shifted<'m>(
    stiffness: &'m Symmetric,
    mass: &'m Symmetric,
    analysis: Analysis,
    name: &dyn Fn(usize) -> String,
) -> Result<Problem<'m>> {
    let made = |shift: f64, rigid: usize| -> Result<Problem<'m>> {
        let factor = analysis.cholesky(&stiffness.plus(-shift, mass))?;
        let factor = factor.map_err(|dof| Error::new(
            format!("dof {}", name(dof)),
            "K + s M is singular for s > 0: a motion of this dof has neither stiffness nor mass, or K has a negative eigenvalue",
        ))?;
        Ok(Problem { stiffness, mass, analysis: analysis.clone(), factor, shift, rigid })
    };
    let mut shift = -FIRST_SHIFT * scale(stiffness, mass);
    // The first shift is a guess; a better one is a tenth of the first elastic eigenvalue.
    for _ in 0..4 {
        let problem = made(shift, 0)?;
        let (rigid, elastic) = first_elastic(&problem)?;
        let Some(elastic) = elastic else { return Ok(Problem { rigid, ..problem }) };
        let better = -SHIFT * elastic;
        if (better / shift).ln().abs() < 0.5 {
            let rigid = if rigid > 0 { problem.below(BELOW_ELASTIC * elastic)? } else { 0 };
            return Ok(Problem { rigid, ..problem });
        }
        shift = better;
    }
    Err(Error::new(
        "stiffness",
        "the first elastic eigenvalue was not found: K or M is singular beyond rigid-body modes",
    ))
}

/// Number of rigid-body modes and the first elastic eigenvalue, if there is one.
fn first_elastic(problem: &Problem) -> Result<(usize, Option<f64>)> {
    let mut wanted = 8.min(problem.stiffness.count());
    loop {
        let found = eigen::lowest(problem, wanted, eigen::Check::None)?;
        let count = found.values.len();
        let most = (0..count).take_while(|&i| is_rigid(problem.stiffness, &found, i)).count();
        let is_apart =
            |r: &usize| *r == 0 || *r == count || found.values[*r - 1].abs() <= RIGID_GAP * found.values[*r];
        let rigid = (0..=most).rev().find(is_apart).unwrap_or(0);
        if rigid < count {
            return Ok((rigid, Some(found.values[rigid])));
        }
        if found.exhausted || wanted > 100 {
            return Ok((rigid, None));
        }
        wanted = 2 * wanted + 8;
    }
}

/// Whether a mode has no strain energy beyond rounding.
fn is_rigid(stiffness: &Symmetric, modes: &Modes, i: usize) -> bool {
    let x = modes.vectors.column(i);
    let (mut energy, mut terms) = (0.0, 0.0);
    for j in 0..stiffness.count() {
        for (k, a) in stiffness.column(j) {
            let term = a * x[k] * x[j];
            energy += term;
            terms += term.abs();
        }
    }
    energy.abs() <= RIGID * terms
}

/// Median of K's over M's diagonal.
fn scale(stiffness: &Symmetric, mass: &Symmetric) -> f64 {
    let both = stiffness.diagonal().into_iter().zip(mass.diagonal());
    let mut ratios: Vec<f64> = both.filter(|(k, m)| *k > 0.0 && *m > 0.0).map(|(k, m)| k / m).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0)
}

/// Refuses a mass matrix with a negative eigenvalue.
fn check_mass(mass: &Symmetric, name: &dyn Fn(usize) -> String) -> Result<()> {
    let diagonal = mass.diagonal();
    if let Some(dof) = diagonal.iter().position(|m| *m < 0.0) {
        return Err(negative("mass", name(dof), -1.0));
    }
    for (j, own) in diagonal.iter().enumerate() {
        if let Some((i, _)) = mass.column(j).find(|(_, x)| *own == 0.0 && *x != 0.0) {
            let problem = format!(
                "its mass is 0, but it is coupled to {} by mass; expected a positive semidefinite mass matrix",
                name(i)
            );
            return Err(Error::new(format!("dof {}", name(j)), problem));
        }
    }
    let with: Vec<usize> = (0..mass.count()).filter(|&i| diagonal[i] > 0.0).collect();
    if with.is_empty() {
        return Err(Error::new("mass", "no dof has mass; expected a positive entry on the diagonal"));
    }
    if mass.is_diagonal() {
        return Ok(());
    }
    let own = mass.kept(&with);
    let (dof, ratio) = Analysis::new(&own)?.least_pivot(&own, MORE)?;
    if ratio < NEGATIVE { Err(negative("mass", name(with[dof]), ratio)) } else { Ok(()) }
}

fn negative(matrix: &str, dof: String, ratio: f64) -> Error {
    let problem = format!(
        "the {matrix} matrix has a negative eigenvalue: the pivot of this dof is {ratio:.3e} of its diagonal entry; \
         expected a positive semidefinite matrix"
    );
    Error::new(format!("dof {dof}"), problem)
}
