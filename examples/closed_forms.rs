//! The symmetric motion with two impacts a period: multiple scales, the exact orbit, and the
//! simulation started on it. `cargo run --release --example closed_forms`

use vibro_impact::{Groups, Parameters, Result, Simulator, steady};

/// Runs the example.
pub fn main() -> Result<()> {
    let parameters = Parameters::default();
    let point =
        steady::multiple_scales::fixed_points(&Groups::basic())?.expect("the drive is strong enough").upper;
    let orbit = steady::exact_orbit::solve(&parameters)?.upper.expect("the orbit exists");
    println!("multiple scales: C = {:.4}, A3 = {:.4}", point.c, point.a3);
    println!(
        "exact orbit: amplitudes {:.4?} m, spectral radius {:.4}",
        orbit.amplitudes(),
        orbit.spectral_radius()
    );

    let theta = 0.3; // rad: any phase of the drive between two impacts
    let time = theta / parameters.drive_frequency;
    let mut simulator = Simulator::new(&parameters, &orbit.state(theta), time)?;
    simulator.advance_to(time + 10.0 * parameters.period())?;
    let (now, then) = (simulator.state(), orbit.state(theta));
    let off = now.x.iter().zip(&then.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("after ten periods the simulation is off by {off:.1e} m");
    assert!(off < 1e-10);
    Ok(())
}
