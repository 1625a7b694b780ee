//! Mean speeds of bodies whose acceleration is prescribed, if they do not stay in place.

use super::{short, units};
use vibro_machine::Assembly;
use vibro_machine::description::{Body, BodyKind, Description, Integrated, Level};
use vibro_machine::functional::StateRow;
use vibro_machine::system::BodyRows;
use vibro_numerics::double_double::DoubleDouble;
use vibro_studies::common_period;

/// Mean speed, relative to the largest speed of the span, below which a body stays in place.
const STAYS: f64 = 1e-6;
/// Number of samples of the speeds in a span, to find their size.
const SPEEDS: u32 = 16;

/// The span of a motion that repeats.
const PERIOD: &str = "the first period";

/// Lines of a summary, one for each such body.
pub(super) fn drifts(assembly: &Assembly) -> Vec<String> {
    let (d, system) = (&assembly.description, assembly.system());
    let at = |time: f64, row: &StateRow| {
        let mut z = StateRow::zeros(system.signals.size);
        system.signals.fill(DoubleDouble::new(time), &system.signals.no_inputs(), z.as_mut_slice());
        row.dot(&z)
    };
    let line = |(body, rows): (&Body, &BodyRows)| {
        let BodyKind::Integrated(own) = &body.kind else { return None };
        let (span, what) = span(own, d)?;
        let way = at(span, &rows.s) - at(0.0, &rows.s);
        let mean = way / span;
        let speeds = (0..SPEEDS).map(|k| at(span * f64::from(k) / f64::from(SPEEDS), &rows.v));
        let most = speeds.map(|v| (v - mean).abs()).fold(0.0, f64::max);
        let [length, unit, _] = units(body.dimension);
        (mean.abs() > STAYS * most).then(|| {
            let (v, name) = (at(0.0, &rows.v) - mean, &body.name);
            let by = match what {
                PERIOD => String::new(),
                _ => format!(" and it moves by {} {length}", short(way)),
            };
            format!(
                "  {name} drifts: its mean speed over {what} of {} s is {} {unit}{by}; start with \
                 v = {} {unit} for a mean speed of 0",
                short(span),
                short(mean),
                short(v)
            )
        })
    };
    d.bodies.iter().zip(&system.bodies).filter_map(line).collect()
}

/// Time for the mean speed of a body, s, and the name of this time: the body's record or sweep,
/// which does not repeat, otherwise the machine's common period.
fn span(own: &Integrated, d: &Description) -> Option<(f64, &'static str)> {
    if own.level != Level::Acceleration {
        return None;
    }
    let signal = &own.signal;
    let record =
        signal.table.as_ref().filter(|_| signal.repeat.is_none()).and_then(|table| table.knots.last());
    let record = record.map(|knot| (knot.0, "its record"));
    let sweeps = signal.sweeps.iter().map(|sweep| (sweep.duration, "its sweep"));
    let longest =
        sweeps.chain(record).filter(|(time, _)| *time > 0.0).reduce(|a, b| if b.0 > a.0 { b } else { a });
    longest.or_else(|| Some((common_period(d)?, PERIOD)))
}
