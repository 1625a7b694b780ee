//! Multipliers of orbits against the Lyapunov exponents of simulated motions, and their product.

use crate::paper::{Orbit, OrbitWord, System, orbit_of, settle};
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::{Parameters, Simulator};
use vibro_studies::paper::lyapunov::{SpectrumOptions, spectrum};
use vibro_studies::paper::stroboscopic::moving_block;

#[test]
fn second_method_exponents_under_constant_loads_by_the_multipliers_of_the_orbit() {
    /// Tolerance for the remaining transient, 1/s, in a mean over the counted periods and in the
    /// orbit's phases.
    const SETTLED: f64 = 1e-5;
    let p = Groups { f10: 2.2, kappa: 0.75, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    let p = Parameters { constant_loads: [0.002, -0.004, 0.001], ..p };
    let system = System::new(&p).unwrap();
    assert_eq!(system.loads().forces, p.constant_loads);
    let settled = settle(&system, &moving_block(&p), 1000).unwrap();
    let orbit = orbit_of(&system, &settled).unwrap();
    let periods = 0.5 * f64::from(orbit.word().half_periods());
    let largest = orbit.multipliers()[0].norm().ln() / (periods * p.period());
    let mut simulator = Simulator::new(&p, &settled, 0.0).unwrap().without_energy_accounts();
    let options = SpectrumOptions { align: 100, periods: 4000, ..Default::default() };
    let found = spectrum(&mut simulator, &options).unwrap();
    assert!(!orbit.word().is_empty() && found.impacts > 0);
    // The exponent of the drive's phase is zero.
    assert!(found.exponents[0].abs() < SETTLED, "{:?}", found.exponents);
    assert!((found.exponents[1] - largest).abs() < 1e-3 * largest.abs(), "{:?} {largest}", found.exponents);
}

/// The multipliers are found for any order of the coordinates, which may make the QR algorithm's
/// sweeps cycle. Their product is the contraction of phase space by an impact (κ²) and by the
/// dampers over a period.
#[test]
fn closed_form_product_of_the_multipliers_where_sweeps_of_the_qr_algorithm_cycle() {
    for i in 0..=20 {
        let p = Parameters {
            box_stiffness: 0.193 + 5e-5 * f64::from(i),
            box_damping: 0.010_756_525_040_185_866,
            secondary_damping: 0.058_812_892_475_845_27,
            stop_restitution: 0.618_880_186_012_838_5,
            drive_amplitude: 0.265_022_273_670_722_6,
            constant_loads: [0.0, -0.000_971_238_660_101_535_2, 0.0],
            ..Parameters::default()
        };
        let system = System::new(&p).unwrap();
        let orbit = Orbit::find(&system, &OrbitWord::new("UL", 1, 2).unwrap(), &[5.367, 8.484]).unwrap();
        assert!(orbit.is_certified() && orbit.is_stable());
        let product: f64 = orbit.multipliers().iter().map(|m| m.norm()).product();
        let damped = p.box_damping / p.box_mass + p.secondary_damping / p.secondary_mass;
        let exact = p.stop_restitution.powi(4) * (-damped * p.period()).exp();
        assert!((product / exact - 1.0).abs() < 1e-10, "{} {product} {exact}", p.box_stiffness);
    }
}
