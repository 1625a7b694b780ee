//! The short table of a run.

use crate::run::{Run, STEPS_PER_PERIOD};
use std::fmt::{self, Display, Formatter};

/// Periods at the end of a run over which impacts are counted and amplitudes taken.
pub const TAIL: u32 = 50;

/// The table of a run.
pub struct Table<'a>(pub &'a Run);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let run = self.0;
        let tail = TAIL.min(run.periods);
        let steps = run.samples.len() - 1;
        let total = run.samples.last().map_or(0, |s| s.impacts[0] + s.impacts[1]);
        let [upper, lower] = run.impacts_per_period(TAIL);
        let measured = run.amplitudes(TAIL);
        writeln!(f, "{} drive periods, {STEPS_PER_PERIOD} communication steps each", run.periods)?;
        writeln!(f, "  packaged binary = native run   bit for bit, at all {steps} communication points")?;
        writeln!(f, "  impacts                        {total}")?;
        writeln!(
            f,
            "  impacts per period             {upper:.2} upper + {lower:.2} lower (last {tail} periods)"
        )?;
        writeln!(f, "  amplitudes (m)                 x1        x2        x3")?;
        row(f, &format!("simulated (last {tail} periods)"), measured)?;
        for (name, amplitudes) in predictions(run) {
            row(f, name, amplitudes)?;
        }
        let (whole, stepping) = (run.whole.as_secs_f64(), run.stepping.as_secs_f64());
        writeln!(f, "  wall time                      {:.1} ms, reading the outputs included", whole * 1e3)?;
        write!(f, "  per communication step         {:.2} µs", stepping * 1e6 / steps as f64)
    }
}

fn row(f: &mut Formatter<'_>, name: &str, [x1, x2, x3]: [f64; 3]) -> fmt::Result {
    writeln!(f, "    {name:<28} {x1:<9.5} {x2:<9.5} {x3:<9.5}")
}

/// Amplitudes known in closed form, where they exist.
fn predictions(_run: &Run) -> Vec<(&'static str, [f64; 3])> {
    Vec::new()
}
