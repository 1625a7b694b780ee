//! Multipliers and doublings from the equations of an orbit, against closed forms and the
//! monodromy matrix.

use super::*;
use std::f64::consts::PI;
use vibro_machine::Start;

/// Tolerance between multipliers found in two ways: rounding of stiff contacts over a period.
const AGREEMENT: f64 = 1e-8;

#[test]
fn second_method_multipliers_by_the_equations_are_those_of_the_monodromy_matrix() {
    // Driven, with stiffness steps, autonomous, with compliant stops, with a neutral direction.
    for name in ["impact_pair", "gear_mesh", "belt_friction", "damper_with_buffer", "vibratory_conveyor"] {
        let orbit = Orbit::settled(&example(&format!("{name}.toml")), &Start::default(), 800).unwrap();
        let residual = orbit.problem.residual(&orbit.place, &orbit.u, true).unwrap();
        let own = orbit.multipliers();
        let place = (&*orbit.place, &residual.cycle);
        let by = orbit.problem.multipliers_by_equations(place, &residual.matrix.unwrap(), own.len()).unwrap();
        assert_eq!(by.len(), own.len(), "{name}");
        for (own, by) in own.iter().zip(&by) {
            assert!((own - by).norm() < AGREEMENT, "{name}: {own} {by}");
        }
    }
}

/// The branch of one bounce per period of a ball on a table over the table's amplitude, with the
/// amplitude of its flip. The return map has the determinant ε² and the trace 1 + ε² + (1 + ε)²
/// h''/g, with h'' the table's acceleration at the bounce.
pub(super) fn ball() -> (Branch, f64) {
    let (g, e, w): (f64, f64, f64) = (10.0, 0.6, 20.0);
    let text = format!(
        "name = \"Ball\"\ngravity = {g}\nbody.ball = {{ mass = 1.0, gravity = -1.0 }}\n\
         body.table = {{ motion = {{ amplitude = 0.025, frequency = \"{w} rad/s\" }} }}\n\
         stop.floor = {{ between = [\"ball\", \"table\"], gap = 0.0, restitution = {e} }}\n",
    );
    let m = machine(&text);
    let mut start = Start { time: 0.06, ..Start::default() };
    start.set(&m.description, "ball.s", 0.025 * 0.95).unwrap();
    start.set(&m.description, "ball.v", PI * g / w).unwrap();
    let orbit = Orbit::settled(&m, &start, 400).unwrap();
    let family = Family::new(&m, "body.table.motion.amplitude", (0.018, 0.05)).unwrap();
    let fold = PI * g * (1.0 - e) / (1.0 + e);
    let flip = fold.hypot(2.0 * g * (1.0 + e * e) / (1.0 + e).powi(2));
    (branch(&family, &orbit, &Default::default()).unwrap(), flip / w / w)
}

/// Repeated n times, an orbit has the n-th powers of its multipliers. The product of the ball's
/// two is ε^(2 n), since an impact multiplies both its velocity and its distance by ε.
#[test]
fn closed_form_multipliers_and_doublings_of_an_orbit_passed_many_times() {
    /// Tolerance for the rounding of the largest multiplier over one pass; n times larger for the
    /// n-th power.
    const LARGEST: f64 = 1e-9;
    let (branch, _) = ball();
    let most = branch.points.iter().max_by(|a, b| a.value.total_cmp(&b.value)).unwrap();
    let once = branch.orbit(most).unwrap();
    let [large, small] = [0, 1].map(|k| once.multipliers()[k].re);
    assert!(large < -2.0 && (large * small - 0.36).abs() < 1e-12, "{large} {small}");
    for times in [8_u32, 25, 40] {
        let (problem, u) = once.problem.repeated(&once.place, &once.u, times).unwrap();
        let orbit = Orbit::at(problem.clone(), problem.place(&u).unwrap(), u.clone()).unwrap();
        let power = large.powi(times as i32);
        let own = orbit.multipliers();
        assert!((own[0].re / power - 1.0).abs() < LARGEST * f64::from(times), "{own:?} {power:e}");
        assert!((own[1] - small.powi(times as i32)).norm() < AGREEMENT, "{own:?}");
        // det A(μ) is a multiple of μ (μ - μ₁) (μ - μ₂); the factor μ comes from the time of the
        // bounce.
        let place = problem.place(&u).unwrap();
        let residual = problem.residual(&place, &u, true).unwrap();
        let matrix = residual.matrix.unwrap();
        let [minus, one] = [problem.antiperiodic(&place, &residual.cycle, &matrix), matrix]
            .map(crate::test_functions::determinant);
        let quotient = minus.relative_to(one) * one.sign;
        let weak = small.powi(times as i32);
        let exact = -(1.0 + power) * (1.0 + weak) / ((1.0 - power) * (1.0 - weak));
        assert!((quotient / exact - 1.0).abs() < LARGEST, "{times} times: {quotient} {exact}");
    }
}
