use super::*;
use crate::file::{no_records, parse};
use crate::mode::Mode;

/// Number of random states.
const STATES: usize = 1000;
/// Fractions of the proved span, beyond 1, over which the bound is compared with the error: near 1
/// the error is rounding.
const BEYOND: [f64; 4] = [1.5, 2.0, 2.5, 3.0];
/// Factors of the weights of velocities.
const FASTER: [f64; 3] = [1.0, 2.5, 20.0];
/// Rounding of the compared states, relative to the largest.
const ROUNDING: f64 = 1e-14;
/// Largest bound that is compared: far beyond, the bound of the growth has no meaning.
const LARGEST: f64 = 1e-2;

/// Largest ratio of the bound to the error that shows that the bound is not idle: for polynomials,
/// and for formulas, whose coefficients are bounded by Cauchy's estimates. The 28th root of it is the
/// loss of length of a series.
const SHARP: [f64; 2] = [1e4, 1e7];

/// Numbers between 0 and 1, by a linear congruence.
struct Chance(u64);

impl Chance {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// A chain of three bodies with curves of all powers.
const CURVES: &str = "name = \"C\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 2.0 }\nbody.c = { mass = 0.5 }\n\
        spring.a = { between = [\"ground\", \"a\"], stiffness = 3.0, cubic = 5.0, damping = 0.1 }\n\
        spring.b = { between = [\"a\", \"b\"], stiffness = -1.0, quadratic = 2.0, cubic = 4.0, quintic = 3.0 }\n\
        spring.c = { between = [\"b\", \"c\"], quartic = 2.0, cubic = 6.0 }\n\
        damper.d = { between = [\"ground\", \"c\"], damping = 0.1, cubic = 0.3 }\n\
        load.l = { on = \"a\", amplitude = 2.0, frequency = 0.4 }\n";
/// A chain of three bodies with all operations of formulas.
const FORMULAS: &str = "name = \"F\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 2.0 }\nbody.c = { mass = 0.5 }\n\
    spring.a = { between = [\"ground\", \"a\"], force = \"= 3 * sin(2 * e) + exp(-e) * rate + cos(e + rate)\" }\n\
    spring.b = { between = [\"a\", \"b\"], stiffness = 2.0, force = \"= ln(1 + e^2 + rate^2) - 4 / (7 - e)^2\" }\n\
    spring.c = { between = [\"b\", \"c\"], stiffness = 8.0, offset = 0.7, free_length = 1.1, damping = 0.4 }\n\
    spring.d = { between = [\"ground\", \"c\"], force = \"= tanh(2 * e) * (5 + e)^1.7 + atan(sin(e) * rate)\" }\n\
    load.l = { on = \"a\", amplitude = 2.0, frequency = 0.4 }\n";

fn table(text: &str) -> (System, FlowTable) {
    let system = System::new(&parse(text, "c.toml", &no_records).expect("a machine")).expect("a system");
    let mode = Mode { stops: Vec::new(), frictions: Vec::new(), sliders: Vec::new(), basis: Vec::new() };
    let table = FlowTable::of_mode(&system, &mode);
    (system, table)
}

fn state(system: &System, chance: &mut Chance) -> Vec<f64> {
    let mut z = vec![0.0; system.signals.size];
    (0..6).for_each(|k| z[k] = chance.between(-2.0, 2.0));
    let turn: f64 = chance.between(0.0, 6.0);
    (z[6], z[7], z[8]) = (1.0, turn.cos(), turn.sin());
    system.fill_curved(&mut z);
    z
}

/// The terms of a series and the remainder's bound over a fraction of its span.
fn bound(table: &FlowTable, series: &Series, (span, faster): (f64, f64), part: f64) -> (f64, f64) {
    let (norms, sizes): (Vec<f64>, Vec<f64>) =
        (0..=LAST_CURVE_ORDER).map(|k| series.norms(table, k)).map(|(g, s)| joint(g, s, faster)).unzip();
    let pairs = table.curves.iter().zip(&series.curves);
    let mut curves: Vec<CurveTerms> = pairs.map(|(own, series)| own.with(series, faster)).collect();
    let mut remainder =
        Remainder { span, rate: faster * table.rate, norms: &norms, sizes: &sizes, curves: &mut curves };
    let size = sizes.iter().enumerate().map(|(k, size)| size * part.powi(k as i32)).fold(0.0, f64::max);
    // The radius of the search, and the margin that the bound itself may take.
    let mut found = |k: i32| {
        let radius = part * (1.05 + 0.1 * f64::from(k));
        remainder.prepare(part, radius);
        remainder.bound(part, radius, LARGEST * size)
    };
    ((1..40).map(&mut found).fold(f64::INFINITY, f64::min), size)
}

#[test]
fn second_method_the_remainder_is_below_its_bound() {
    compare(CURVES, SHARP[0]);
}

#[test]
fn second_method_the_remainder_of_formulas_is_below_its_bound() {
    compare(FORMULAS, SHARP[1]);
}

/// Compares the bound with the error in random states.
fn compare(text: &str, sharp: f64) {
    let (system, table) = table(text);
    let (mut chance, mut compared, mut sharpest) = (Chance(7), 0, f64::INFINITY);
    for _ in 0..STATES {
        let z = state(&system, &mut chance);
        let mut ahead = Ahead::default();
        ahead.find_curved(&table, &z, 100.0);
        let (span, part) = (ahead.expanded, ahead.span / ahead.expanded);
        let mut series = Series::default();
        series.set_sides(&edges::sides(&table.curves, &z), false);
        series.expand(&table, &z, span, LAST_CURVE_ORDER);
        for (beyond, faster) in BEYOND.into_iter().flat_map(|beyond| FASTER.map(|faster| (beyond, faster))) {
            let (limit, size) = bound(&table, &series, (span, faster), part * beyond);
            if !(limit.is_finite() && limit < LARGEST * size) {
                continue;
            }
            let mut by_series = vec![0.0; z.len()];
            series.at(part * beyond, &mut by_series);
            let mut true_end = z.clone();
            table.carry_along(&mut true_end, &mut [], span * part * beyond);
            let n = table.coordinates;
            let weight = |i: usize| table.weights[i] / if (n..2 * n).contains(&i) { faster } else { 1.0 };
            let off = (0..table.one).map(|i| (by_series[i] - true_end[i]).abs() * weight(i));
            let off = off.fold(0.0, f64::max);
            assert!(off <= limit + ROUNDING * size, "{off:e} above {limit:e} at {beyond} of {z:?}");
            compared += 1;
            if off > ROUNDING * size {
                sharpest = sharpest.min(limit / off);
            }
        }
    }
    // The bound is compared where it is far above rounding, and is not idle.
    assert!(compared > STATES && sharpest < sharp, "{compared} {sharpest:e}");
    println!("{compared} compared, the bound is {sharpest:e} times the error at least");
}
