//! Proofs of the lanes against the proofs for a single motion, on random polynomials; flights of
//! the lanes against the series of a single motion.

use super::*;
use crate::flow::Series;
use crate::model::{Model, SmoothMode};
use crate::parameters::Parameters;
use crate::simulator::{Simulator, State};
use proptest::prelude::*;
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::events::first_crossing;
use vibro_numerics::simd::value;

/// Coefficients of a path towards a stop: from nearly straight to strongly bent, starting just
/// below zero or far below.
fn path() -> impl Strategy<Value = [f64; CENTRED]> {
    let rest = prop::array::uniform10(-1.0..1.0f64);
    (rest, -4.0..0.0f64, -1.0..1.0f64, -4.0..0.5f64).prop_map(|(rest, start, slope, decay)| {
        let mut c = rest;
        for (k, c) in c.iter_mut().enumerate().skip(2) {
            *c *= 10f64.powf(decay * (k - 1) as f64 * 0.5);
        }
        c[0] = -(10f64.powf(start));
        c[1] = slope;
        c
    })
}

/// Results of the lanes on the paths: the zero, whether it is proved, and whether its absence is
/// proved.
struct Find<'a> {
    paths: &'a [[f64; CENTRED]; 8],
    from: f64,
    divide: bool,
}

impl pulp::WithSimd for Find<'_> {
    type Output = [(f64, bool, bool); 8];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut found = [(0.0, false, false); 8];
        for v in 0..8 / S::F64_LANES {
            let zero = Wide::splat(simd, 0.0);
            let mut excess = Excess { c: [zero; CENTRED], d: [zero; CENTRED - 1] };
            for k in 0..CENTRED {
                let mut row = LaneRow::ZERO;
                for lane in 0..8 {
                    row.0[lane] = self.paths[lane][k];
                }
                excess.c[k] = Wide::load(simd, &row, v);
                if k > 0 {
                    excess.d[k - 1] = excess.c[k] * Wide::splat(simd, k as f64);
                }
            }
            if self.divide {
                excess.divide_by_u(Mask::from_bits(simd, u64::MAX));
            }
            // With the other stop far away.
            let (from, gap) = (Wide::splat(simd, self.from), Wide::splat(simd, 1e3));
            let crossing = excess.upward_crossing(from, gap);
            let stay = excess.stays_negative(from, gap).bits();
            let mut u = LaneRow::ZERO;
            crossing.u.store(&mut u, 0);
            for lane in 0..S::F64_LANES {
                let holds = |bits: u64| bits >> lane & 1 != 0;
                found[v * S::F64_LANES + lane] = (u.0[lane], holds(crossing.found.bits()), holds(stay));
            }
        }
        found
    }
}

/// The path in u / [`REACH`], on which the scalar proofs hold from -1 to 1.
fn scaled(c: &[f64; CENTRED], divide: bool) -> [f64; CENTRED] {
    let mut r = [0.0; CENTRED];
    let shift = usize::from(divide);
    for k in 0..CENTRED - shift {
        r[k] = c[k + shift] * POWERS[k];
    }
    r
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn second_method_crossings_and_their_absence(
        paths in prop::array::uniform8(path()),
        close in any::<bool>(),
        divide in any::<bool>(),
    ) {
        /// Tolerance: rounding of a zero where the slope may be a hundredth of the coefficients.
        const ROOT: f64 = 1e-12;
        let divide = close && divide;
        let from = if close { 0.0 } else { -1.0 };
        let found = pulp::Arch::new().dispatch(Find { paths: &paths, from, divide });
        for (path, (u, proved, stays)) in paths.iter().zip(found) {
            let c = scaled(path, divide);
            let lo = from / REACH;
            // Paths in lanes start inside; random ones that do not are passed over.
            if value(&c, lo) >= 0.0 {
                continue;
            }
            let first = first_crossing(&c, lo, 1.0, &mut 0);
            prop_assert!(!(proved && stays));
            if proved {
                let exact = first.map(|u| u * REACH);
                prop_assert!(exact.is_some_and(|exact| (exact - u).abs() < ROOT), "{u} {exact:?} {path:?}");
            }
            prop_assert!(!stays || first.is_none(), "{first:?} {path:?}");
        }
    }
}

/// Path u - z + c (u⁴ - z⁴) with the zero z, from straight to the strongest bend with which lanes
/// seek a zero. The starting value, from three orders, ignores the fourth, so that depending on c
/// one, two or three Newton steps are just enough, or even three are too few.
#[test]
fn closed_form_zeros_that_count_as_found_are_exact() {
    /// Tolerance: rounding of the polynomial over its slope, and half a unit in the last place of
    /// u.
    const EXACT: f64 = 8.0 * f64::EPSILON;
    let (mut proved, mut given_up) = (0, 0);
    for z in [-0.9f64, -0.3, 0.4, 0.8, 1.0, 1.15] {
        for step in 0..800 {
            let size = 0.03 * 10f64.powf(-f64::from(step) / 60.0);
            let paths = std::array::from_fn(|lane| {
                let c = size * (1.0 - 0.015 * lane as f64) * if lane % 2 == 0 { 1.0 } else { -1.0 };
                let mut path = [0.0; CENTRED];
                (path[0], path[1], path[4]) = (-(z + c * z.powi(4)), 1.0, c);
                path
            });
            for (u, found, _) in pulp::Arch::new().dispatch(Find { paths: &paths, from: -1.0, divide: false })
            {
                assert!(!found || (u - z).abs() <= EXACT, "{z} {size:e}: {u} is off by {:e}", u - z);
                *(if found { &mut proved } else { &mut given_up }) += 1;
            }
        }
    }
    assert!(proved > 10 * given_up && given_up > 100, "{proved} found, {given_up} not");
}

/// Path without a zero in reach whose iterates go far out, where nothing is bounded, and come back
/// into reach, so that the steps' lengths alone would pass for a proof. It is straight within
/// 1e-11 in reach and bends at 2e5, for which its ninth order is tuned.
#[test]
fn invariant_no_zero_is_found_by_way_of_iterates_out_of_reach() {
    const FAR: f64 = 2e5;
    let mut path = [0.0; CENTRED];
    (path[0], path[1], path[3]) = (-FAR, 1.0, 1.0 / (FAR * FAR));
    path[9] = -0.624_054_315_260_280_3 / FAR.powi(8);
    assert!(value(&path, REACH) < 0.0);
    let found = pulp::Arch::new().dispatch(Find { paths: &[path; 8], from: -1.0, divide: false });
    assert!(found.iter().all(|(_, proved, _)| !proved), "{found:?}");
}

/// Path u - b (u² - z²) - z, which rises up to [`REACH`] for b < 5/12 with the least slope
/// 1 - 2.4 b. A zero counts as found only if this is more than twice the curvature 2 b, so that
/// the sums of sizes do not cancel (docs/numerics.md, section 7).
#[test]
fn closed_form_no_zero_is_found_where_the_slope_nearly_cancels() {
    for (bend, straight) in [(0.1, true), (0.15, true), (0.16, false), (0.3, false), (0.41, false)] {
        let z = 0.4;
        let mut path = [0.0; CENTRED];
        (path[0], path[1], path[2]) = (bend * z * z - z, 1.0, -bend);
        let found = pulp::Arch::new().dispatch(Find { paths: &[path; 8], from: -1.0, divide: false });
        assert!(found.iter().all(|(_, proved, _)| *proved == straight), "{bend}: {found:?}");
    }
}

/// State at u of the flight with z at the centre.
struct States<'a> {
    systems: &'a LaneSystems,
    z: [f64; 8],
    u: f64,
}

impl pulp::WithSimd for States<'_> {
    type Output = [f64; 8];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 8] {
        let mut z = [Wide::splat(simd, 0.0); 8];
        for (wide, z) in z.iter_mut().zip(self.z) {
            *wide = Wide::splat(simd, z);
        }
        let there = CentredFlights::expand(simd, self.systems, 0, &z).state_at(
            self.systems,
            simd,
            0,
            Wide::splat(simd, self.u),
        );
        there.map(|wide| {
            let mut row = LaneRow::ZERO;
            wide.store(&mut row, 0);
            row.0[0]
        })
    }
}

#[test]
fn second_method_flights_are_the_series() {
    /// Tolerance: rounding of coordinates of order one.
    const ROUNDING: f64 = 1e-15;
    let p = Parameters::default();
    let simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    let mut systems = LaneSystems::zero();
    for lane in 0..8 {
        systems.load_system(lane, &simulator, DoubleDouble::new(1.0));
    }
    let model = Model::new(&p).unwrap();
    let z = [0.3, -0.4, 0.7, -0.2, 0.5, 0.9, 0.6, 0.8];
    for u in [-1.0, -0.3, 0.0, 0.8, REACH] {
        let series = Series::<16>::expand(&model, SmoothMode::Flight, &z, None, 0.5 * simulator.interval());
        let there = pulp::Arch::new().dispatch(States { systems: &systems, z, u });
        for (a, b) in series.at(u).iter().zip(there) {
            assert!((a - b).abs() < ROUNDING, "{u}: {:?} {there:?}", series.at(u));
        }
    }
}

/// The remainder of a series at [`REACH`] is under the rounding of the motion's size, even for a
/// box driven at resonance: r bounds the box alone, and the drive adds up from order to order.
#[test]
fn closed_form_remainder_at_the_reach_of_a_series() {
    let p = Parameters {
        box_damping: 0.0,
        secondary_damping: 0.0,
        secondary_stiffness: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 1.0,
        drive_frequency: 1.0,
        stop_gap: 1e-6,
        ..Parameters::default()
    };
    let (model, simulator) = (Model::new(&p).unwrap(), Simulator::new(&p, &State::default(), 0.0).unwrap());
    let radius = REACH * 0.5 * simulator.interval();
    for (cos, sin) in [(0.0, 1.0), (1.0, 0.0), (0.5f64.sqrt(), 0.5f64.sqrt())] {
        let z = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, cos, sin];
        let series = Series::<30>::expand(&model, SmoothMode::Flight, &z, None, radius);
        let size = p.stop_gap + 1.0; // of the drive's acceleration over r²
        for coordinate in [BOX, BOX_RATE, RELATIVE, RELATIVE_RATE] {
            let rest: f64 = series.states[CENTRED..].iter().map(|state| state[coordinate]).sum();
            assert!(rest.abs() < 0.5 * f64::EPSILON * size, "{coordinate}: {rest:e}");
        }
    }
}
