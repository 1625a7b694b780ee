//! The default machine over 200 drive periods: events as they occur, energies at the end, and the
//! event that comes next. `cargo run --release --example run`

use vibro_impact::simulator::Event;
use vibro_impact::{Parameters, Result, Simulator, State};

/// Runs the example.
pub fn main() -> Result<()> {
    let parameters = Parameters::default();
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] }; // m, m/s: box, block, secondary oscillator
    let mut simulator = Simulator::new(&parameters, &start, 0.0)?;
    let initial = simulator.energy_accounts().mechanical;
    let mut fastest: f64 = 0.0;
    simulator.advance_observed(200.0 * parameters.period(), &mut |event| {
        if let Event::Impact { speed, .. } = event {
            fastest = fastest.max(*speed);
        }
    })?;
    let (impacts, energy) = (simulator.impacts(), simulator.energy_accounts());
    println!("{} impacts above, {} below, the fastest at {fastest:.3} m/s", impacts.upper, impacts.lower);
    let balance = energy.mechanical - initial - energy.input + energy.damped + energy.impact;
    println!("{energy:.3?}, balance {balance:.1e} J");
    assert!(impacts.upper > 100 && balance.abs() < 1e-9);

    let horizon = simulator.time() + parameters.period();
    println!("next: {:?}", simulator.next_event(horizon)?);
    Ok(())
}
