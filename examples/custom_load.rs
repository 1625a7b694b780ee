//! A load on the block computed by the caller, here a weak magnet at the upper stop, passed step by
//! step as a value and a slope. `cargo run --release --example custom_load`

use vibro_impact::simulator::Loads;
use vibro_impact::{Parameters, Result, Simulator, State};

/// Index of the block among the bodies: box, block, secondary oscillator.
const BLOCK: usize = 1;

/// Runs the example.
pub fn main() -> Result<()> {
    let parameters = Parameters::default();
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let mut simulator = Simulator::new(&parameters, &start, 0.0)?;
    let (steps, h) = (2000, parameters.period() / 100.0);
    let mut greatest: f64 = 0.0;
    for n in 1..=steps {
        let (w, rate) = simulator.relative_motion(); // m, m/s
        let distance = 1.2 * parameters.stop_gap - w;
        let force = 1e-3 / (distance * distance); // N
        let slope = 2e-3 * rate / distance.powi(3); // N/s
        let mut loads = Loads::default();
        loads.derivatives[BLOCK] = [force, slope, 0.0, 0.0];
        simulator.set_loads(&loads)?;
        simulator.advance_to(f64::from(n) * h)?;
        greatest = greatest.max(force);
    }
    println!("{:?}, greatest pull {greatest:.4} N", simulator.impacts());
    assert!(simulator.impacts().upper > 0 && greatest > 0.02);
    Ok(())
}
