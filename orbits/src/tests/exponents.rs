//! Multipliers of orbits against the Lyapunov exponents of simulated motions.

use crate::{System, orbit_of, settle};
use vibro_analysis::lyapunov::{SpectrumOptions, spectrum};
use vibro_analysis::stroboscopic::moving_block;
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::{Parameters, Simulator};

#[test]
fn second_method_exponents_under_constant_loads_by_the_multipliers_of_the_orbit() {
    /// Remainder of the transient, 1/s, in a mean over the counted periods and in the orbit's
    /// phases.
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
