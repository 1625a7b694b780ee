//! Regular motions: fits from initial guesses that are 5 to 20 % off converge to parameters close
//! to the true ones.

use super::*;

/// Relative tolerance between fits of one record from different initial guesses.
const SAME: f64 = 1e-6;

/// Checks that fits from ten initial guesses, 10 or 20 % off, converge to the same parameters,
/// close to the true ones.
fn check_ten_starts(machine: &Machine, measured: &Measured, free: &[&str]) {
    let mut first: Option<Fitted> = None;
    let mut wrong = Vec::new();
    for k in 0..10u32 {
        let sign = |i: usize| if (k >> (i % 3)) & 1 == 0 { 1.2 } else { 0.8 };
        let begin = off(machine, free, |i| if k < 8 { sign(i) } else { 1.0 + 0.2 * (f64::from(k) - 8.5) });
        let found = fitted(&request(begin, measured.clone(), free));
        let truths = free.iter().map(|name| machine.description.get(name).unwrap());
        let errors = found.uncertainty.errors.iter().map(|error| error.unwrap_or(0.0));
        let off =
            found.values.iter().zip(truths).zip(errors).map(|(((_, x), truth), error)| (x - truth) / error);
        let off: Vec<f64> = off.collect();
        if found.verdict != Verdict::Fits {
            wrong.push(format!("start {k}: {}", found.verdict));
        }
        let first = first.get_or_insert_with(|| found.clone());
        let mut pairs = first.values.iter().zip(&found.values);
        if off.iter().any(|off| off.is_nan() || off.abs() >= FAR)
            || pairs.any(|((_, a), (_, b))| (a / b - 1.0).abs() > SAME)
        {
            wrong.push(format!("start {k}: {:?} rms {:?}, off by {off:?} errors", found.values, found.rms));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn made_record_of_an_oscillator_with_friction_from_ten_starts() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(1));
    check_ten_starts(&m, &measured, &["spring.mount.stiffness", "friction.floor.force"]);
}

#[test]
fn made_record_of_a_damper_with_a_buffer_from_ten_starts() {
    let m = example("damper_with_buffer.toml");
    let measured = record(&m, &[("box.s", 1e-5), ("block.s", 2e-5)], 0.5, 200, &mut Noise(2));
    check_ten_starts(&m, &measured, &["stop.steel.gap", "stop.steel.restitution", "friction.guide.force"]);
}

#[test]
fn made_impact_times_alone_of_a_ball_from_ten_starts() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.ball = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"ball\"], gap = 1.0, restitution = 0.8 }\n";
    let m = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let measured = contacts(&m, &["floor"], 3.0, 1e-4, &mut Noise(3));
    check_ten_starts(&m, &measured, &["stop.floor.gap", "stop.floor.restitution"]);
}

#[test]
fn made_record_of_a_block_on_a_belt_from_ten_starts() {
    let m = example("belt_friction.toml").with([("friction.belt_contact.static", 3.0)]).unwrap();
    let measured = record(&m, &[("block.s", 1e-4)], 3.0, 400, &mut Noise(11));
    let free = ["spring.holder.stiffness", "friction.belt_contact.force", "friction.belt_contact.static"];
    check_ten_starts(&m, &measured, &free);
}

#[test]
fn made_record_of_gears_with_backlash_from_ten_starts() {
    let m = example("gear_backlash.toml");
    let measured = record(&m, &[("wheel.v", 0.02), ("drive_flank.e", 1e-6)], 0.05, 250, &mut Noise(12));
    let free = ["spring.clutch.stiffness", "friction.bearing.force", "spring.clutch.damping"];
    check_ten_starts(&m, &measured, &free);
}

#[test]
fn made_contact_times_alone_of_a_damper_from_ten_starts() {
    let m = example("damper_with_buffer.toml");
    let measured = contacts(&m, &["steel", "buffer"], 0.6, 1e-5, &mut Noise(13));
    check_ten_starts(&m, &measured, &["stop.steel.gap", "stop.steel.restitution", "friction.guide.force"]);
}

#[test]
fn made_contact_times_alone_of_gears_from_ten_starts() {
    let m = example("gear_backlash.toml");
    let measured = contacts(&m, &["drive_flank"], 0.05, 1e-6, &mut Noise(17));
    check_ten_starts(&m, &measured, &["spring.clutch.stiffness", "friction.bearing.force"]);
}

/// A mass on a spring with a stop, driven by a force table that is held between its points.
pub fn driven_by_a_record() -> Machine {
    let mut noise = Noise(14);
    let rows: Vec<String> =
        (0..200).map(|i| format!("[{:?}, {:?}]", 0.01 * f64::from(i), 40.0 * noise.normal())).collect();
    let text = format!(
        "name = \"Driven\"\nbody.a = {{ mass = 1.0 }}\n\
         spring.k = {{ between = [\"ground\", \"a\"], stiffness = 900.0, damping = 4.0 }}\n\
         stop.wall = {{ between = [\"ground\", \"a\"], gap = 0.01, restitution = 0.6 }}\n\
         load.shaker = {{ on = \"a\", table = [{}], interpolation = \"hold\" }}\n",
        rows.join(", ")
    );
    Machine::parse(&text, "driven.toml", &no_records).unwrap()
}

#[test]
fn made_record_of_a_machine_that_a_record_drives_from_ten_starts() {
    let m = driven_by_a_record();
    let measured = record(&m, &[("a.s", 1e-4)], 1.0, 200, &mut Noise(15));
    let free = ["spring.k.stiffness", "spring.k.damping", "stop.wall.restitution", "stop.wall.gap"];
    check_ten_starts(&m, &measured, &free);
}

#[test]
fn made_record_of_a_hardening_spring_and_a_stop_from_ten_starts() {
    let text = "name = \"Duffing\"\nbody.a = { mass = 1.0 }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 60.0, cubic = 3e4, damping = 0.8 }\n\
                damper.d = { between = [\"ground\", \"a\"], cubic = 2.0 }\n\
                stop.wall = { between = [\"ground\", \"a\"], gap = 0.07, restitution = 0.6 }\n\
                load.shaker = { on = \"a\", amplitude = 9.0, frequency = 2.1 }\n";
    let m = Machine::parse(text, "duffing.toml", &no_records).unwrap();
    let measured = record(&m, &[("a.s", 1e-4)], 2.0, 100, &mut Noise(21));
    let free = ["spring.k.stiffness", "spring.k.cubic", "spring.k.damping", "stop.wall.restitution"];
    check_ten_starts(&m, &measured, &free);
}

#[test]
fn made_record_of_the_papers_machine_from_5_and_20_percent_off() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/paper_machine.toml");
    let text = std::fs::read_to_string(folder).unwrap();
    let text =
        text.replace("gap = 1.0", "gap = \"= gap\"").replace("restitution = 0.75", "restitution = \"= r\"");
    let m =
        Machine::parse(&(text + "\n[parameters]\ngap = 1.0\nr = 0.75\n"), "paper.toml", &no_records).unwrap();
    let measured = record(&m, &[("box.s", 1e-4), ("block.s", 1e-4)], 40.0, 400, &mut Noise(42));
    // The block starts at 0.9, outside a gap of 0.8: no guess has a gap 20 % below the true one.
    for factors in [[1.05, 1.05], [1.05, 0.95], [0.95, 1.05], [0.95, 0.95], [1.2, 1.2], [1.2, 0.8]] {
        let begin = off(&m, &["gap", "r"], |i| factors[i]);
        let found = fitted(&request(begin, measured.clone(), &["gap", "r"]));
        for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
            let truth = m.description.get(name).unwrap();
            let error = error.unwrap();
            assert!(
                (value - truth).abs() < FAR * error && error < 1e-4,
                "{factors:?}: {name} {value} ± {error}"
            );
        }
        assert_eq!(found.verdict, Verdict::Fits, "{factors:?}");
    }
}
