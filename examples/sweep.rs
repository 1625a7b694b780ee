//! Impacts per drive period over the drive's amplitude: all motions of the sweep advance side by
//! side. `cargo run --release --example sweep`

use vibro_impact::simulator::advance_together;
use vibro_impact::{Groups, Result, Scales, Simulator, State};

/// Runs the example.
pub fn main() -> Result<()> {
    const PERIODS: f64 = 100.0;
    let start = State { x: [0.0; 3], v: [0.1, 0.0, 0.0] };
    let mut motions = Vec::new();
    for n in 1..=16 {
        let groups = Groups { f10: 0.25 * f64::from(n), ..Groups::basic() };
        let parameters = groups.to_parameters(Scales::default())?;
        // Without energy accounts, because motions with them cannot advance side by side.
        motions.push(Simulator::new(&parameters, &start, 0.0)?.without_energy_accounts());
    }
    // The transient, then the counted periods.
    for result in advance_together(&mut motions, |s| PERIODS * s.parameters().period()) {
        result?;
    }
    let before: Vec<u64> = motions.iter().map(|s| s.impacts().upper + s.impacts().lower).collect();
    for result in advance_together(&mut motions, |s| 2.0 * PERIODS * s.parameters().period()) {
        result?;
    }
    for (s, before) in motions.iter().zip(&before) {
        let rate = (s.impacts().upper + s.impacts().lower - before) as f64 / PERIODS;
        println!("drive {:.3} N: {rate:.2} impacts a period", s.parameters().drive_amplitude);
    }
    assert!(motions.iter().any(|s| s.impacts().upper > 150));
    Ok(())
}
