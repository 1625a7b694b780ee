//! Motion of a block that never meets a stop again: proved by energy, and computed in closed form.
//!
//! In free flight box and block do not act on each other (docs/theory.md (6)). The drive acts on
//! the box alone, which tends to its forced vibration. Block and secondary oscillator come to rest
//! in the middle, where constant loads hold them.

use super::attractor::StroboscopicRecord;
use super::free_limit::{dynamic_stiffness, forced, middle};
use super::stroboscopic::Units;
use crate::class::OBSERVED;
use nalgebra::{Complex, SMatrix, SVector};
use vibro_impact::flow::{Series, UnitColumn, WHOLE, substep};
use vibro_impact::model::{COORDINATES, Model, SmoothMode};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;

/// Rounding allowance in the bound on |w|, as a fraction of the gap and of the positions at which
/// loads hold the bodies.
const MARGIN: f64 = 1e-9;
/// Tolerance for the difference between a spring's stiffness and the box's inertia, in units of
/// `f64::EPSILON` times their sum.
const ROUNDINGS: f64 = 8.0;

/// Whether a block in flight with this state at a whole drive period never meets a stop again.
///
/// The box is away from the middle by at most its forced amplitude plus its transient, the block
/// by its displacement from its rest position. Springs and dampers add no energy to the
/// transients, so each body stays where its springs store at most the present energy: a transient
/// of the box with energy E within √(2 E/k1), and the block, on its springs k23 and k3 in series,
/// within √(2 E (1/k23 + 1/k3)). Under constant loads both count from the positions where the
/// loads hold them, and the distance of these positions is added. A block at a stop is never found
/// clear of it, since the bound also holds for the present w.
pub(crate) fn keeps_clear(p: &Parameters, state: &State) -> bool {
    let ([v1, v2, v3], middle) = (state.v, middle(p));
    let [x1, x2, x3] = from_middle(state.x, &middle);
    let (forced, omega) = (forced(p), p.drive_frequency);
    let now = forced * Complex::from_polar(1.0, p.drive_phase);
    let (x, v) = (x1 - now.im, v1 - omega * now.re);
    let twice_box = p.box_mass * v * v + p.box_stiffness * x * x;
    let twice_block = p.block_mass * v2 * v2
        + p.secondary_mass * v3 * v3
        + p.coupling_stiffness * (x2 - x3) * (x2 - x3)
        + p.secondary_stiffness * x3 * x3;
    let block = twice_block * (1.0 / p.coupling_stiffness + 1.0 / p.secondary_stiffness);
    let apart = (middle[1] - middle[0]).abs();
    // If a spring is missing the bound is infinite or NaN, and nothing is proved.
    let bound = forced.norm() + (twice_box / p.box_stiffness).sqrt() + block.sqrt() + apart;
    let largest = middle.iter().fold(p.stop_gap, |largest, x| largest.max(x.abs()));
    // Next to the resonance of a box with hardly any damping the difference is mostly rounding.
    let parts = p.box_stiffness + p.box_mass * omega * omega;
    let off = ROUNDINGS * f64::EPSILON * parts / dynamic_stiffness(p).norm() * forced.norm();
    bound < p.stop_gap - MARGIN * largest - off
}

/// Positions of the bodies relative to the middle.
fn from_middle(x: [f64; 3], middle: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| x[i] - middle[i])
}

/// States of a free flight at every half drive period.
#[derive(Clone, Debug)]
struct FreeFlight {
    /// Transition matrix over half a drive period.
    half: SMatrix<f64, COORDINATES, COORDINATES>,
    /// State relative to the middle, about which the flow is linear.
    z: SVector<f64, COORDINATES>,
    middle: [f64; 3],
}

impl FreeFlight {
    /// The flight from a state at a whole drive period.
    fn new(model: &Model, p: &Parameters, state: &State) -> Self {
        let pieces = (0.5 * p.period() / substep(model)).ceil().max(1.0);
        let length = 0.5 * p.period() / pieces;
        let mut piece = SMatrix::<f64, COORDINATES, COORDINATES>::zeros();
        for j in 0..COORDINATES {
            let unit = UnitColumn::unit(j).z;
            let series = Series::<WHOLE>::expand(model, SmoothMode::Flight, &unit, None, length);
            piece.set_column(j, &SVector::from(series.at(1.0)));
        }
        let middle = middle(p);
        let deviation = State { x: from_middle(state.x, &middle), v: state.v };
        let [x1, w, x3, v1, dw, v3] = deviation.to_relative();
        let (sin, cos) = p.drive_phase.sin_cos();
        let z = SVector::from([x1, w, x3, v1, dw, v3, cos, sin]);
        Self { half: piece.pow(pieces as u32), z, middle }
    }

    /// Advances by a number of half periods.
    fn advance(&mut self, halves: u32) {
        self.z = self.half.pow(halves) * self.z;
    }

    fn state(&self) -> State {
        let z = &self.z;
        let State { x, v } = State::from_relative(&[z[0], z[1], z[2], z[3], z[4], z[5]]);
        State { x: std::array::from_fn(|i| x[i] + self.middle[i]), v }
    }
}

/// Records the observation, `later` whole periods ahead, of a motion [without further
/// impacts](keeps_clear) with this state at a whole drive period. Returns the state after the
/// observation, or `None` if the parameters do not make a model.
pub(crate) fn observe(
    p: &Parameters,
    state: &State,
    later: u32,
    record: &mut StroboscopicRecord,
) -> Option<State> {
    let units = Units::of(p);
    let mut flight = FreeFlight::new(&Model::new(p).ok()?, p, state);
    flight.advance(2 * later);
    record.clear();
    for number in 1..=2 * OBSERVED {
        flight.z = flight.half * flight.z;
        record.sample(number, units.dimensionless(&flight.state()));
    }
    Some(flight.state())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::stroboscopic::dimensional;
    use vibro_impact::Simulator;

    /// Tolerance between matrix powers and the simulator's sub-steps, in units of L and L ω10.
    const ROUNDING: f64 = 1e-11;

    /// Machines whose forced vibration keeps the box clear of the block in the middle.
    fn systems() -> [Parameters; 5] {
        let weak = Parameters { drive_amplitude: 0.02, ..Parameters::default() };
        let slow = Parameters { drive_frequency: 0.4, drive_phase: 1.1, ..weak };
        let wide = Parameters { secondary_damping: 0.0, stop_gap: 0.37, drive_frequency: 2.3, ..weak };
        // The block hangs away from the centre: with box and block at different positions, or by
        // the secondary oscillator's load alone.
        let hung = Parameters { constant_loads: [0.02, -3e-4, 1e-3], ..weak };
        [weak, slow, wide, hung, Parameters { constant_loads: [0.0, 0.0, -1e-3], ..slow }]
    }

    #[test]
    fn second_method_states_are_those_of_the_simulator() {
        for p in systems() {
            let state = dimensional(&p, &[0.05, -0.08, 0.02, 0.03, 0.04, -0.05]);
            assert!(keeps_clear(&p, &state));
            let mut record = StroboscopicRecord::default();
            observe(&p, &state, 30, &mut record).unwrap();
            let mut simulator = Simulator::new(&p, &state, 0.0).unwrap();
            for (k, observed) in record.periods.iter().enumerate() {
                simulator.advance_to((31 + k) as f64 * p.period()).unwrap();
                let simulated = Units::of(&p).dimensionless(&simulator.state());
                for (a, b) in observed.state.iter().zip(simulated) {
                    assert!((a - b).abs() < ROUNDING, "{k}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn invariant_what_keeps_clear_has_no_impact_and_the_bound_is_not_far_off() {
        let mut clear_of = [0, 0];
        for p in systems() {
            for k in 1..=60 {
                let size = 0.02 * f64::from(k);
                let direction = [0.1, -0.9, 0.3, 0.2, 0.1, -0.2].map(|x| size * x);
                let state = dimensional(&p, &direction);
                if state.x[1] - state.x[0] <= -p.stop_gap {
                    continue;
                }
                let clear = keeps_clear(&p, &state);
                let mut simulator = Simulator::new(&p, &state, 0.0).unwrap();
                simulator.advance_to(60.0 * p.period()).unwrap();
                let impacts = simulator.impacts().upper + simulator.impacts().lower;
                assert!(!clear || impacts == 0, "{size} {impacts}");
                clear_of[0] += usize::from(clear);
                clear_of[1] += usize::from(impacts == 0);
            }
        }
        assert!(clear_of[0] > 10 && 3 * clear_of[0] > clear_of[1], "{clear_of:?}");
    }

    #[test]
    fn closed_form_at_places_of_many_gaps_nothing_is_proved_within_their_rounding() {
        let [weak, ..] = systems();
        // The block hangs at rest, clear of the reach of the box's forced vibration by this
        // fraction of the gap.
        const CLEAR: f64 = 5e-9;
        for (place, is_proved) in [(0.0, true), (300.0, false)] {
            let block_place = place + weak.stop_gap * (1.0 - CLEAR) - forced(&weak).norm();
            let block_load = weak.coupling_stiffness * block_place;
            let p =
                Parameters { constant_loads: [weak.box_stiffness * place, block_load, -block_load], ..weak };
            let now = forced(&p) * Complex::from_polar(1.0, p.drive_phase);
            let state =
                State { x: [place + now.im, block_place, 0.0], v: [p.drive_frequency * now.re, 0.0, 0.0] };
            assert_eq!(keeps_clear(&p, &state), is_proved, "{place}");
        }
    }

    #[test]
    fn closed_form_nothing_is_proved_by_the_rounding_of_a_resonance() {
        /// Relative distance of the drive from the resonance of the undamped box.
        const BESIDE: f64 = 2e-9;
        /// The box's beat exceeds the gap by this fraction.
        const FARTHER: f64 = 1e-10;
        let at_rest = State { x: [0.0; 3], v: [0.0; 3] };
        for k in 0..1000 {
            let (stiffness, mass) = (1.0, 0.3 + 1e-3 * f64::from(k));
            let omega = (stiffness / mass).sqrt() * (1.0 - BESIDE);
            // The difference k1 - m1 ω² with the rounding of its two products.
            let product: f64 = mass * omega;
            let square = product * omega;
            let rounded = product.mul_add(omega, -square) + mass.mul_add(omega, -product) * omega;
            let force = 0.5 * ((stiffness - square) - rounded);
            // From rest a transient of equal size is superposed on the forced vibration of half a
            // metre.
            let reach = 0.5 * (1.0 + omega * (mass / stiffness).sqrt());
            let p = Parameters {
                box_mass: mass,
                box_stiffness: stiffness,
                box_damping: 0.0,
                stop_gap: reach * (1.0 - FARTHER),
                drive_amplitude: force,
                drive_frequency: omega,
                ..Parameters::default()
            };
            assert!(!keeps_clear(&p, &at_rest), "{mass}");
            assert!(keeps_clear(&Parameters { stop_gap: 1.01 * reach, ..p }, &at_rest), "{mass}");
        }
    }

    #[test]
    fn without_a_spring_nothing_is_proved() {
        let [weak, ..] = systems();
        let middle = State { x: [0.0; 3], v: [0.0; 3] };
        assert!(keeps_clear(&weak, &dimensional(&weak, &[0.0; 6])));
        for p in [
            Parameters { box_stiffness: 0.0, ..weak },
            Parameters { coupling_stiffness: 0.0, ..weak },
            Parameters { secondary_stiffness: 0.0, ..weak },
            Parameters { box_damping: 0.0, drive_frequency: 1.0, ..weak },
        ] {
            assert!(!keeps_clear(&p, &middle), "{p:?}");
        }
    }
}
