//! The default system for 200 drive periods: events as they come, energies at the end.
//! `cargo run --release --example count_impacts`

use vibro_impact::simulator::Event;
use vibro_impact::{Parameters, Simulator, State};

fn main() -> vibro_impact::Result<()> {
    let parameters = Parameters::default();
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
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
    Ok(())
}
