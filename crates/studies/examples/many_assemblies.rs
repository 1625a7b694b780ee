//! Many described machines on all cores: the impact damper with a rubber buffer over 1000 gaps,
//! 200 drive periods each.
//!
//! The command `cargo run --release -p vibro-studies --example many_assemblies` measures once. If
//! the argument `serve` is given, it measures once per input line, so that
//! `benches/python_package.py` can alternate with it.

use rayon::prelude::*;
use std::error::Error;
use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use vibro_machine::{Assembly, Description, Motion, file};
use vibro_studies::values;

/// End of the motions, s: 200 periods of 0.1 s.
const UNTIL: f64 = 20.0;
const MACHINES: u32 = 1000;

/// Machines over the gap of the steel stop from 5 to 130 mm.
fn machines() -> Result<Vec<Description>, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly/damper_with_buffer.toml");
    let damper = file::read(&path)?;
    let gap = |i: u32| 5e-3 + 125e-3 * f64::from(i) / f64::from(MACHINES - 1);
    Ok((0..MACHINES).map(|i| damper.with([("stop.steel.gap", gap(i))])).collect::<Result<_, _>>()?)
}

/// All columns of the motion at its end.
fn end(machine: &Description) -> Result<Vec<f64>, vibro_machine::Error> {
    let mut motion = Motion::new(Arc::new(Assembly::new(machine.clone())?))?.without_energy_accounts();
    motion.advance_to(UNTIL)?;
    Ok(values(&motion))
}

/// Duration of one computation, s.
fn measure(machines: &[Description]) -> Result<f64, Box<dyn Error>> {
    let begin = Instant::now();
    let ends: Result<Vec<Vec<f64>>, _> = machines.par_iter().map(end).collect();
    let seconds = begin.elapsed().as_secs_f64();
    ends?;
    Ok(seconds)
}

fn main() -> Result<(), Box<dyn Error>> {
    let machines = machines()?;
    if std::env::args().nth(1).as_deref() != Some("serve") {
        println!("{MACHINES} machines over {UNTIL} s: {:.4} s", measure(&machines)?);
        return Ok(());
    }
    for line in std::io::stdin().lock().lines() {
        line?;
        println!("{}", measure(&machines)?);
        std::io::stdout().flush()?;
    }
    Ok(())
}
