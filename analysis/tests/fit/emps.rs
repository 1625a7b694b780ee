//! A record in the format of the EMPS benchmark, made by the machine of `examples/emps.toml`: the
//! voltage is held between samples at 1 kHz. The public file is not in the repository.

use super::*;

const SAMPLES: u32 = 24_841;
const NOISE: f64 = 5e-5;

#[test]
fn made_record_of_a_drive_with_held_voltage_and_six_free_numbers() {
    let mut voltage = String::from("time,voltage\n");
    for i in 0..SAMPLES {
        let t = 1e-3 * f64::from(i);
        let u = 1.6 * (0.2 * TAU * t).sin() + 0.6 * (0.7 * TAU * t).sin();
        voltage += &format!("{t:?},{u:?}\n");
    }
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/emps.toml")).unwrap();
    let begin = Machine::parse(&text, "emps.toml", &|_| Ok(voltage.clone())).unwrap();
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
    for (((name, value), error), (_, truth)) in found.values.iter().zip(&found.uncertainty.errors).zip(truths)
    {
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
    assert!((found.rms[0].1 / NOISE - 1.0).abs() < 0.03, "{:?} in {}", found.rms, found.simulations);
}
