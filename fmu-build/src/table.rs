//! The table of a run that the packager prints.

use crate::run::{ComparedRun, STEPS_PER_PERIOD};
use std::fmt::{self, Display, Formatter};
use vibro_impact::steady::{exact_orbit, multiple_scales};

/// Periods at the end of a run over which impacts are counted and amplitudes taken.
pub const TAIL: u32 = 50;

/// Amplitudes in m, and whether the motion is stable and possible.
type Prediction = Option<([f64; 3], bool)>;

/// Prints amplitudes and impacts of a run together with closed forms.
pub struct RunTable<'a>(pub &'a ComparedRun);

impl Display for RunTable<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let run = self.0;
        let tail = TAIL.min(run.periods);
        let steps = run.samples.len() - 1;
        let total = run.samples.last().map_or(0, |s| s.impacts[0] + s.impacts[1]);
        let [upper, lower] = run.impacts_per_period(TAIL);
        let measured = run.amplitudes(TAIL);
        writeln!(f, "{} drive periods, {STEPS_PER_PERIOD} communication steps each", run.periods)?;
        writeln!(f, "  FMI 2.0 = FMI 3.0 = native     bit for bit, at all {steps} communication points")?;
        writeln!(f, "  impacts                        {total}")?;
        writeln!(
            f,
            "  impacts per period             {upper:.2} upper + {lower:.2} lower (last {tail} periods)"
        )?;
        writeln!(f, "  amplitudes (m)                 x1        x2        x3")?;
        row(f, &format!("simulated (last {tail} periods)"), measured)?;
        for (name, prediction) in predictions(run) {
            match prediction {
                Some((amplitudes, true)) => row(f, name, amplitudes)?,
                Some((amplitudes, false)) => row(f, &format!("{name} (not stable)"), amplitudes)?,
                None => writeln!(f, "    {name:<28} does not exist")?,
            }
        }
        let (whole, stepping) = (run.whole.as_secs_f64(), run.stepping.map(|time| time.as_secs_f64()));
        let [two, three] = stepping.map(|time| time * 1e6 / steps as f64);
        writeln!(f, "  wall time                      {:.1} ms, reading the outputs included", whole * 1e3)?;
        write!(f, "  per communication step         {two:.2} µs, FMI 3.0 {three:.2} µs")
    }
}

fn row(f: &mut Formatter<'_>, name: &str, [x1, x2, x3]: [f64; 3]) -> fmt::Result {
    writeln!(f, "    {name:<28} {x1:<9.5} {x2:<9.5} {x3:.5}")
}

/// Amplitudes from closed forms. If no such motion exists, the row states it.
fn predictions(run: &ComparedRun) -> [(&'static str, Prediction); 2] {
    let p = &run.parameters;
    let exact = exact_orbit::solve(p).ok().and_then(|roots| roots.upper);
    let scales = p.groups().and_then(|groups| multiple_scales::fixed_points(&groups)).ok().flatten();
    let length = p.stop_gap;
    [
        ("exact orbit", exact.map(|orbit| (orbit.amplitudes(), orbit.is_clear() && orbit.is_stable()))),
        (
            "multiple scales",
            scales.map(|roots| roots.upper).map(|point| {
                ([point.a1(), point.a2(), point.a3].map(|a| a * length), point.admissibility.all())
            }),
        ),
    ]
}
