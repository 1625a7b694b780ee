//! Orbits of a word without a guess of their phases.

use super::orbit::Orbit;
use super::system::System;
use crate::obstacle::Obstacle;
use crate::stop_word::OrbitWord;
use vibro_studies::{Error, Result};

/// Tolerance for equal orbits, as a difference of phases, rad.
const SAME: f64 = 1e-6;

/// The certified orbits of a word found by Newton's method from `tries` guesses, which fill the
/// space of phases evenly (additive recurrence of the generalized golden ratio). The word may have
/// further orbits. Orbits that also have a shorter word come last: repeated orbits, and symmetric
/// orbits ([`Orbit::shortest`]).
///
/// # Errors
/// [`Error::NoOrbit`] if none is found; the error of [`Orbit::find`] if phases do not determine
/// the machine's orbits.
pub fn search(system: &System, word: &OrbitWord, tries: u32) -> Result<Vec<Orbit>> {
    let none = || {
        word.no_orbit(format!(
            "none was found from {tries} guesses of its phases; try another value of a parameter \
             or another period"
        ))
    };
    let n = word.len();
    Obstacle::check(system, word).map_err(|obstacle| obstacle.error(system, word))?;
    if n == 0 {
        let orbit = Orbit::find(system, word, &[])?;
        return if orbit.is_certified() { Ok(vec![orbit]) } else { Err(none()) };
    }
    let ratio = golden(n);
    let mut found: Vec<Orbit> = Vec::new();
    for k in 1..=tries {
        let part = |i: usize| (f64::from(k) * ratio.powi(-(i as i32) - 1)).fract();
        // The first phase is anywhere in a drive period; the other phases follow in order.
        let mut rest: Vec<f64> = (1..n).map(part).collect();
        rest.sort_by(f64::total_cmp);
        let first = std::f64::consts::TAU * part(0);
        let guess: Vec<f64> =
            std::iter::once(first).chain(rest.iter().map(|p| first + p * word.span())).collect();
        match Orbit::find(system, word, &guess) {
            Ok(orbit) => {
                if orbit.is_certified() && !found.iter().any(|known| known.is_same(&orbit, SAME)) {
                    found.push(orbit);
                }
            }
            Err(Error::NoOrbit { .. }) => {}
            Err(other) => return Err(other),
        }
    }
    found.sort_by_key(|orbit| !orbit.is_shortest());
    if found.is_empty() { Err(none()) } else { Ok(found) }
}

/// The root of x^(n+1) = x + 1 above one, by fixed-point iteration.
fn golden(n: usize) -> f64 {
    (0..100).fold(1.5_f64, |x, _| (1.0 + x).powf(1.0 / (n as f64 + 1.0)))
}
