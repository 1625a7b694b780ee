//! Records in the format of the EMPS benchmark, made by the machines of `examples/emps.toml`
//! (voltage held between samples at 1 kHz) and `examples/emps_closed_loop.toml` (voltage from
//! sampled control). The public file is not in the repository.

use super::*;

/// The public record has 24,841 samples; two periods of the voltage determine the numbers as well.
const SAMPLES: u32 = 10_001;
const NOISE: f64 = 5e-5;

/// Machine of the folder `examples`, with the given text as its record.
fn example(name: &str, record: &str) -> Machine {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples"));
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    Machine::parse(&text, name, &|_| Ok(record.to_owned())).unwrap()
}

/// A record of samples at 1 kHz.
fn table(name: &str, count: u32, value: impl Fn(f64) -> f64) -> String {
    let row = |i: u32| {
        let t = 1e-3 * f64::from(i);
        format!("{t:?},{:?}\n", value(t))
    };
    format!("time,{name}\n") + &(0..count).map(row).collect::<String>()
}

/// Drive in open loop with given parameters; the voltage is held between samples at 1 kHz.
pub fn driven(voltage: impl Fn(f64) -> f64, count: u32) -> Machine {
    let truths = [
        ("body.carriage.mass", 95.1),
        ("damper.viscous.damping", 203.5),
        ("friction.guide.force", 20.4),
        ("load.offset.constant", 3.2),
        ("body.carriage.start.s", 1e-3),
        ("body.carriage.start.v", 7e-3),
    ];
    example("emps.toml", &table("voltage", count, voltage)).with(truths).unwrap()
}

/// Asserts that the true values are within the errors, and that the residuals are the noise.
fn assert_found(found: &Fitted, truths: &[(&str, f64)]) {
    let errors = &found.uncertainty.errors;
    for (((name, value), error), (_, truth)) in found.values.iter().zip(errors).zip(truths) {
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
    assert!((found.rms[0].1 / NOISE - 1.0).abs() < 0.03, "{:?} in {}", found.rms, found.simulations);
    assert_eq!(found.verdict, Verdict::Fits);
}

#[test]
fn made_record_of_a_drive_with_held_voltage_and_six_free_numbers() {
    let voltage = |t: f64| 1.6 * (0.2 * TAU * t).sin() + 0.6 * (0.7 * TAU * t).sin();
    let begin = example("emps.toml", &table("voltage", SAMPLES, voltage));
    let truths = [
        ("body.carriage.mass", 95.1),
        ("damper.viscous.damping", 203.5),
        ("friction.guide.force", 20.4),
        ("load.offset.constant", 3.2),
        ("body.carriage.start.s", 1e-3),
        ("body.carriage.start.v", 7e-3),
    ];
    let m = begin.with(truths).unwrap();
    let until = 1e-3 * f64::from(SAMPLES - 1);
    let measured = record(&m, &[("carriage.s", NOISE)], until, SAMPLES as usize, &mut Noise(31));
    let found = fitted(&request(begin, measured, &truths.map(|own| own.0)));
    assert_found(&found, &truths);
}

/// In closed loop the controller compensates friction; reversals and voltage limits determine it.
#[test]
fn made_record_of_a_drive_under_sampled_control_and_four_free_numbers() {
    let reference = |t: f64| 0.12 * (0.5 * TAU * t).sin().powi(3) + 0.02 * (0.25 * TAU * t).sin();
    let begin = example("emps_closed_loop.toml", &table("reference", 4_000, reference));
    let truths = [
        ("body.carriage.mass", 95.1),
        ("damper.viscous.damping", 203.5),
        ("friction.guide.force", 20.4),
        ("load.offset.constant", 3.2),
    ];
    let m = begin.with(truths).unwrap();
    let measured = record(&m, &[("carriage.s", NOISE)], 3.999, 4_000, &mut Noise(37));
    let found = fitted(&request(begin, measured, &truths.map(|own| own.0)));
    assert_found(&found, &truths);
}
