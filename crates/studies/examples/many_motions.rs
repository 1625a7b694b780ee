//! Many machines side by side on all cores: the default machine over 1000 forces, 400 drive
//! periods each.
//!
//! The command `cargo run --release -p vibro-studies --example many_motions` measures once. If the
//! argument `serve` is given, it measures once per input line, so that `benches/python_package.py`
//! can alternate with it.

use std::error::Error;
use std::io::{BufRead, Write};
use std::time::Instant;
use vibro_impact::Parameters;
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::trajectories::{Start, propagate};
use vibro_studies::paper::{ParameterSet, find_group};

const PERIODS: u32 = 400;
const MACHINES: u32 = 1000;

/// Machines over the force f̂10 from 0.5 to 4, each starting from the moving block.
fn starts() -> Result<Vec<Start>, Box<dyn Error>> {
    let force = find_group("f10")?;
    let start = |i: u32| {
        let value = 0.5 + 3.5 * f64::from(i) / f64::from(MACHINES - 1);
        let parameters: Parameters = *ParameterSet::basic().with(force, value)?.parameters();
        Ok(Start { parameters, state: moving_block(&parameters) })
    };
    (0..MACHINES).map(start).collect()
}

/// Duration of one computation, s.
fn measure(starts: &[Start]) -> Result<f64, Box<dyn Error>> {
    let begin = Instant::now();
    let ends = propagate(starts, PERIODS, &|| ());
    let seconds = begin.elapsed().as_secs_f64();
    for end in ends {
        end?;
    }
    Ok(seconds)
}

fn main() -> Result<(), Box<dyn Error>> {
    let starts = starts()?;
    if std::env::args().nth(1).as_deref() != Some("serve") {
        println!("{MACHINES} machines over {PERIODS} drive periods: {:.4} s", measure(&starts)?);
        return Ok(());
    }
    for line in std::io::stdin().lock().lines() {
        line?;
        println!("{}", measure(&starts)?);
        std::io::stdout().flush()?;
    }
    Ok(())
}
