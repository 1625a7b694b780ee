//! Random inputs: every answer is finite or a typed error, and nothing hangs.

use crate::parameters::{FIELDS, Groups, Parameters};
use crate::steady::{exact_orbit, multiple_scales, strong_coupling};

/// Tolerance: rounding of the gap between large coordinates.
const GAP_ROUNDING: f64 = 1e-12;

/// Linear congruential generator, random enough to pick parameters.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Log-uniform over 10^±decades, now and then zero.
    fn size(&mut self, decades: f64) -> f64 {
        if self.next() < 0.05 { 0.0 } else { 10f64.powf(decades * (2.0 * self.next() - 1.0)) }
    }
}

#[test]
fn invariant_exact_orbits_of_random_parameters_are_finite_or_refused() {
    let mut random = Random(1);
    let (mut found, mut refused) = (0, 0);
    for i in 0..4000 {
        let mut p = Parameters::default();
        for field in &FIELDS {
            let decades = if i % 10 == 0 { 12.0 } else { 1.0 };
            let value = if field.range.max == 1.0 { random.next() } else { random.size(decades) };
            (field.set)(&mut p, value);
        }
        let Ok(roots) = exact_orbit::solve(&p) else {
            refused += 1;
            continue;
        };
        for orbit in roots.lower.into_iter().chain(roots.upper) {
            found += 1;
            let state = orbit.initial_state();
            let scalars = [orbit.impulse(), orbit.drive_phase()];
            let numbers = state.x.iter().chain(&state.v).chain(&scalars);
            assert!(numbers.copied().all(f64::is_finite), "{p:?}");
            assert!(orbit.multipliers().iter().all(|m| m.re.is_finite() && m.im.is_finite()), "{p:?}");
            let amplitudes = orbit.amplitudes();
            let gap = (state.x[1] - state.x[0]).abs();
            let rounding = GAP_ROUNDING * (p.stop_gap + amplitudes[0] + amplitudes[1]);
            assert!(!orbit.is_clear() || gap <= p.stop_gap + rounding, "{p:?}");
        }
    }
    assert!(found > 500 && refused > 50 && refused < 2000, "{found} {refused}");
}

#[test]
fn invariant_approximations_of_random_groups_are_finite_or_refused() {
    let mut random = Random(2);
    let mut found = 0;
    for _ in 0..20_000 {
        let signed = |r: &mut Random| if r.next() < 0.5 { r.size(2.0) } else { -r.size(2.0) };
        let g = Groups {
            epsilon: random.next(),
            kappa: random.next(),
            f10: signed(&mut random),
            sigma1: signed(&mut random),
            gamma1: random.size(2.0),
            alpha23: 0.0,
            beta2: random.size(2.0),
            sigma30: signed(&mut random),
            gamma3: random.size(2.0),
            mu13: 0.01 + random.size(1.0),
        };
        let weak = multiple_scales::fixed_points(&g).ok().flatten();
        for p in weak.into_iter().flat_map(|r| [r.lower, r.upper]) {
            found += 1;
            let m = p.motion(1.0);
            assert!(
                [p.c, p.b, p.a3, p.a1(), p.a2(), p.psi, p.psi3, m.w].iter().all(|x| x.is_finite()),
                "{g:?}"
            );
        }
        let strong = strong_coupling::solve(&g).ok().flatten();
        for p in strong.into_iter().flat_map(|r| [r.lower, r.upper]) {
            found += 1;
            let m = p.motion(1.0);
            assert!(
                [p.c, p.b, p.a3, p.a1(), p.a2(), p.drive_phase, m.w].iter().all(|x| x.is_finite()),
                "{g:?}"
            );
        }
    }
    assert!(found > 10_000, "{found}");
}
