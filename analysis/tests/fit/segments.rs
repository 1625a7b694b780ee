//! Chaotic records, fitted by segments.

use super::*;

/// An impact oscillator whose motion is chaotic: driven near twice its frequency, with a stop.
fn chaotic() -> Machine {
    let text = "name = \"Chaotic\"\n\
                body.a = { mass = 1.0, start = { s = -0.3, v = 0.2 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 1.0, damping = 0.02 }\n\
                stop.wall = { between = [\"ground\", \"a\"], gap = 0.1, restitution = 0.8 }\n\
                load.drive = { on = \"a\", amplitude = 1.0, frequency = \"2.8 rad/s\" }\n";
    Machine::parse(text, "chaotic.toml", &no_records).unwrap()
}

const PERIOD: f64 = TAU / 2.8;

#[test]
fn made_chaotic_record_of_sixty_periods() {
    let m = chaotic();
    let measured = record(&m, &[("a.s", 2e-3)], 60.0 * PERIOD, 60 * 40 + 1, &mut Noise(21));
    let free =
        ["stop.wall.gap", "stop.wall.restitution", "spring.k.stiffness", "body.a.start.s", "body.a.start.v"];
    let begin = off(&m, &free, |i| [1.1, 0.95, 1.03, 1.05, 0.9][i]);
    let clock = std::time::Instant::now();
    let found = fitted(&FitRequest { segments: Segments::Auto, ..request(begin, measured, &free) });
    println!("{:?} {} {:?} near {}", clock.elapsed(), found.simulations, found.rms, found.near_until);
    println!(
        "{} {:?}",
        found.segments.len(),
        found.segments.iter().map(|f| f.time / PERIOD).collect::<Vec<_>>()
    );
    for own in &found.segments {
        println!("{:?}", own.defect);
    }
    for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        println!("{name} {value} ± {error:?}, true {truth}");
    }
    for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
}
