//! The flights between impacts as Taylor pieces: proof that no stop is touched, and extrema.

use super::system::System;
pub(super) use vibro_impact::steady::PENETRATION_ROUNDING;
use vibro_impact::steady::exact_orbit::{Clearance, Flight, Vector6};
use vibro_numerics::bernstein::{Polynomial, add_sine, evaluate};
use vibro_numerics::roots::brent;

/// Number of parts of a piece in the search for extrema. Over a piece the fastest mode turns by at
/// most 0.75 rad, so the slope changes sign at most once in a part, except near an inflection,
/// which is therefore examined too.
const PARTS: usize = 8;

/// Accuracy of an extremum's position in a piece; its value is then exact to round-off.
const PLACE: f64 = 1e-12;

/// One Taylor piece of a flight: x1, x2, x3 in units of L over `[phase, phase + length]`.
pub(super) struct TaylorPiece {
    pub phase: f64,
    pub length: f64,
    pub x: [Polynomial; 3],
}

impl TaylorPiece {
    /// The polynomial of a sum of displacements.
    pub fn sum(&self, weights: [f64; 3]) -> Polynomial {
        std::array::from_fn(|k| (0..3).map(|i| weights[i] * self.x[i][k]).sum())
    }
}

/// The pieces of a flight that starts at a phase with the free part z of the state.
pub(super) fn pieces(
    system: &System,
    z: &Vector6,
    phase: f64,
    span: f64,
) -> impl Iterator<Item = TaylorPiece> {
    let count = system.flight.least_pieces(span);
    let length = span / f64::from(count);
    let (amplitude, angle) = system.wave();
    let (rest, fallen) = (system.rest_positions(), system.fall_piece(length));
    let mut z = *z;
    (0..count).map(move |i| {
        let phase = phase + f64::from(i) * length;
        let mut x = system.flight.piece(&z, 0.0, length, 0.0);
        for (x, fallen) in x.iter_mut().zip(&fallen) {
            x.iter_mut().zip(fallen).for_each(|(x, fallen)| *x += fallen);
        }
        z = Flight::state(&x, 1.0, length);
        // Without impacts only the box moves: by minus the oscillation of x2 - x1 (`wave`).
        add_sine(&mut x[0], -amplitude, length, phase + angle);
        x.iter_mut().zip(rest).for_each(|(x, rest)| x[0] += rest);
        TaylorPiece { phase, length, x }
    })
}

/// Whether it is proved that the block stays within the stops during a flight, up to the contact
/// error `contact` at the ends of the flight and the rounding that [`Clearance`] allows.
pub(super) fn is_clear(system: &System, z: &Vector6, phase: f64, span: f64, contact: f64) -> bool {
    let mut clearance = Clearance::new(contact, system.flight.least_pieces(span), system.amplitude());
    pieces(system, z, phase, span).all(|piece| clearance.holds(&piece.sum([-1.0, 1.0, 0.0]), piece.x[0][0]))
}

/// Positions t in [0, 1] of the local maxima of a polynomial, with their values.
fn maxima_of(polynomial: &Polynomial) -> impl Iterator<Item = (f64, f64)> {
    let rate: Polynomial =
        std::array::from_fn(|k| polynomial.get(k + 1).map_or(0.0, |next| (k + 1) as f64 * next));
    let slope = |t: f64| evaluate(polynomial, t).1;
    let curvature = move |t: f64| evaluate(&rate, t).1;
    let t = |i: usize| i as f64 / PARTS as f64;
    (0..PARTS).filter_map(move |i| {
        let (mut from, mut to) = (t(i), t(i + 1));
        let rises = slope(from) > 0.0;
        if rises == (slope(to) > 0.0) && curvature(from) * curvature(to) < 0.0 {
            // Shortly after a slow impact a minimum and a maximum lie in one part. The slope at
            // its ends shows neither, so it is examined in between too.
            let turn = brent(curvature, from, to, PLACE)?;
            if rises { to = turn } else { from = turn }
        }
        let falls = slope(from) > 0.0 && slope(to) <= 0.0;
        let place = falls.then(|| brent(slope, from, to, PLACE)).flatten()?;
        Some((place, evaluate(polynomial, place).0))
    })
}

/// The local maxima of a sum of displacements during a flight: phases and values.
pub(super) fn maxima(
    system: &System,
    z: &Vector6,
    phase: f64,
    span: f64,
    weights: [f64; 3],
) -> Vec<(f64, f64)> {
    let in_piece = |piece: TaylorPiece| {
        let sum = piece.sum(weights);
        let found: Vec<_> =
            maxima_of(&sum).map(|(t, value)| (piece.phase + t * piece.length, value)).collect();
        found
    };
    pieces(system, z, phase, span).flat_map(in_piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part with a minimum and a maximum, in either order: the slope changes sign twice.
    #[test]
    fn closed_form_a_maximum_is_found_next_to_a_minimum() {
        for (low, high) in [(0.02, 0.05), (0.05, 0.02), (0.9, 0.97), (0.97, 0.9)] {
            // The integral of s (t - low) (t - high), whose maximum is at `high`.
            let s: f64 = if low < high { -1.0 } else { 1.0 };
            let mut polynomial: Polynomial = Default::default();
            polynomial[1..4].copy_from_slice(&[s * low * high, -0.5 * s * (low + high), s / 3.0]);
            let found: Vec<_> = maxima_of(&polynomial).collect();
            assert_eq!(found.len(), 1, "{low} {high}");
            assert!((found[0].0 - high).abs() < PLACE, "{low} {high} {found:?}");
        }
    }
}
