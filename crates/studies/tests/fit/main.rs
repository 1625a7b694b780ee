//! Fits of synthetic records with known noise.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;
mod emps;
mod filtered;
mod losses;
mod regular;
mod segments;
mod sure;
mod suspects;
mod together;
mod trusted;
mod verdicts;

use vibro_machine::file::no_records;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion, Start};
use vibro_studies::fit::{FitRequest, Fitted, Free, Loss, Measured, Segments, Verdict, fit};
use vibro_studies::{Machine, QuantityName};

/// Largest distance of an estimate from the true value, in standard errors. About one estimate in
/// ten thousand lies farther away by chance.
const FAR: f64 = 4.0;

/// Normal samples of standard deviation 1, from a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

fn example(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly");
    Machine::read(&Path::new(folder).join(name)).unwrap()
}

fn motion(machine: &Machine) -> Motion {
    Motion::new(Arc::new(Assembly::new(machine.description.clone()).unwrap())).unwrap()
}

/// Record of a machine at equidistant times, with the given noise for each column.
fn record(
    machine: &Machine,
    columns: &[(&str, f64)],
    until: f64,
    count: usize,
    noise: &mut Noise,
) -> Measured {
    let mut motion = motion(machine);
    let names: Vec<QuantityName> = columns.iter().map(|(name, _)| name.parse().unwrap()).collect();
    let places: Vec<_> = names.iter().map(|name| name.find(&machine.description).unwrap().quantity).collect();
    let (mut times, mut values) = (Vec::new(), vec![Vec::new(); columns.len()]);
    for i in 0..count {
        let time = until * i as f64 / (count - 1) as f64;
        motion.advance_to(time).unwrap();
        times.push(time);
        for ((place, (_, sigma)), values) in places.iter().zip(columns).zip(&mut values) {
            values.push(motion.value(*place) + sigma * noise.normal());
        }
    }
    Measured { times, columns: names.into_iter().zip(values).collect(), contacts: Vec::new() }
}

/// Times of impacts and first touches of stops, with noise.
fn contacts(machine: &Machine, stops: &[&str], until: f64, sigma: f64, noise: &mut Noise) -> Measured {
    let place = |name: &str| machine.description.stops.iter().position(|own| own.name == name).unwrap();
    let places: Vec<usize> = stops.iter().map(|name| place(name)).collect();
    let mut found: Vec<Vec<f64>> = vec![Vec::new(); stops.len()];
    let mut note = |event: &Event| {
        if let EventKind::Impact { stop, .. } | EventKind::Press { stop, .. } = event.kind
            && let Some(list) = places.iter().position(|own| *own == stop)
        {
            found[list].push(event.time + sigma * noise.normal());
        }
    };
    motion(machine).advance_observed(until, &mut note).unwrap();
    let contacts = stops.iter().map(|name| format!("stop.{name}")).zip(found).collect();
    Measured { contacts, ..Measured::default() }
}

fn request(machine: Machine, measured: Measured, free: &[&str]) -> FitRequest {
    let free =
        free.iter().map(|name| Free { name: (*name).to_owned(), within: None, is_own: false }).collect();
    let (start, loss, segments) = (Start::default(), Loss::Linear, Segments::Auto);
    let (name, filters) = (String::new(), Vec::new());
    FitRequest { name, machine, start, measured, free, sigma: None, filters, loss, segments, starts: 0 }
}

fn fitted(request: &FitRequest) -> Fitted {
    fit(request, &|_| true).unwrap()
}

/// Machine with some parameters multiplied by factors.
fn off(machine: &Machine, free: &[&str], factor: impl Fn(usize) -> f64) -> Machine {
    let value =
        |(i, name): (usize, &&'static str)| (*name, factor(i) * machine.description.get(name).unwrap());
    let free: Vec<&'static str> =
        free.iter().map(|name| &*Box::leak(name.to_string().into_boxed_str())).collect();
    machine.with(free.iter().enumerate().map(value).collect::<Vec<_>>()).unwrap()
}

#[test]
fn invariant_a_free_shift_moves_a_record_before_the_start_inside_it() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 2e-6)], 0.25, 100, &mut Noise(9));
    measured.times.iter_mut().for_each(|time| *time -= 2e-3);
    let found = fitted(&request(m.clone(), measured, &["friction.floor.force", "record.shift"]));
    // The tolerance is wide: the motion begins at rest, so a shift hardly changes the first
    // samples.
    assert!((found.values[1].1 - 2e-3).abs() < 2e-4, "{:?} {}", found.values, found.verdict);
}

#[test]
fn invariant_a_record_of_one_time_has_no_error() {
    let m = example("coulomb_oscillator.toml");
    let one = Measured {
        times: vec![0.0],
        columns: vec![("mass.s".parse().unwrap(), vec![1e-3])],
        ..Measured::default()
    };
    assert!(fitted(&request(m, one, &["friction.floor.force"])).uncertainty.errors == [None]);
}

#[test]
fn invariant_numbers_of_a_start_at_rest_begin_there() {
    // In equilibrium the block hangs 5 mm below the position of the unstressed spring. The record
    // starts at 6 mm; the fit's initial guess is the equilibrium.
    let text = "name = \"Hung\"\ngravity = 10.0\nstart = \"rest\"\nbody.a = { mass = 1.0, gravity = 1.0 }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 2000.0 }\n";
    let m = Machine::parse(text, "hung.toml", &no_records).unwrap();
    let mut start = Start::default();
    start.set(&m.description, "a.s", 6e-3).unwrap();
    let mut motion = start.motion(Arc::new(Assembly::new(m.description.clone()).unwrap())).unwrap();
    let place = "a.s".parse::<QuantityName>().unwrap();
    let quantity = place.find(&m.description).unwrap().quantity;
    let times: Vec<f64> = (0..100).map(|i| 1e-3 * f64::from(i)).collect();
    let value = |time: &f64| {
        motion.advance_to(*time).unwrap();
        motion.value(quantity)
    };
    let values = times.iter().map(value).collect();
    let measured = Measured { times, columns: vec![(place, values)], contacts: Vec::new() };
    let own = request(m, measured, &["start.a.s"]);
    let within = vec![Free { within: Some((4.9e-3, 7e-3)), ..own.free[0].clone() }];
    let found = fitted(&FitRequest { free: within, ..own });
    assert!((found.values[0].1 - 6e-3).abs() < 1e-12, "{:?}", found.values);
}

#[test]
fn made_shift_and_offset_of_a_record() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(5));
    // The record begins 10 ms later, and its sensor shows 20 µm more.
    measured.times.drain(..20);
    measured.columns[0].1.drain(..20);
    let first = measured.times[0];
    measured.times.iter_mut().for_each(|time| *time -= first);
    measured.columns[0].1.iter_mut().for_each(|value| *value += 2e-5);
    let free = ["spring.mount.stiffness", "record.shift", "record.offset.mass.s"];
    let found = fitted(&request(off(&m, &free[..1], |_| 1.05), measured, &free));
    let truths = [m.description.get("spring.mount.stiffness").unwrap(), first, 2e-5];
    for (((name, value), error), truth) in found.values.iter().zip(&found.uncertainty.errors).zip(truths) {
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
}

/// A change that makes a valid request invalid, and words of the message.
type Refused<'a> = (&'a dyn Fn(&mut FitRequest), &'a str);

#[test]
fn records_and_names_that_are_not_allowed_are_refused() {
    let m = example("coulomb_oscillator.toml");
    let sound = record(&m, &[("mass.s", 2e-6)], 0.25, 50, &mut Noise(6));
    let late = |own: &mut FitRequest| own.measured.times.iter_mut().for_each(|time| *time += 1.7e9);
    let twice = |own: &mut FitRequest| {
        let column = own.measured.columns[0].1.clone();
        own.measured.columns.push(("body.mass.s".parse().unwrap(), column));
    };
    let small = |own: &mut FitRequest| own.measured.columns[0].1.iter_mut().for_each(|x| *x *= 1e-200);
    let early = |own: &mut FitRequest| own.measured.times.iter_mut().for_each(|time| *time -= 0.1);
    let cases: [Refused; 17] = [
        (
            &|own| {
                own.free[0].name = "body.mass.start.s".into();
                own.start.set(&own.machine.description, "mass.s", 1e-3).unwrap();
            },
            "body.mass.start.s is free, but the given start sets mass.s = 0.001; use start.mass.s",
        ),
        (&early, "time: row 1 is -0.1 s, before the start of the motion at 0.0 s"),
        (&late, "time: row 1 is 1700000000.0 s, too long after the start of the motion"),
        (&twice, "mass.s has two columns"),
        (&small, "the largest number of the column; expected a number of at least 1e-60 in size"),
        (&|own| own.measured.columns[0].1[2] = 1e300, "mass.s: row 3 is 1e300; expected at most 1e60"),
        (&|own| own.sigma = Some(vec![1e-160]), "sigma of mass.s = 1e-160: expected a"),
        (&|own| own.segments = Segments::Length(1e-9), "segments of 1e-9 s: must be at least 0.005102041 s"),
        (&|own| own.measured.contacts = vec![("floor".into(), vec![1.0])], "no stop is named `floor`"),
        (&|own| own.measured.times[3] = 0.0, "row 4 has the time 0.0 s"),
        (&|own| own.measured.columns[0].1[2] = f64::NAN, "mass.s: row 3 is NaN"),
        (&|own| own.measured.columns[0].0 = "mas.s".parse().unwrap(), "the machine has no `mas.s`"),
        (&|own| own.free[0].name = "friction.floor.forc".into(), "friction.floor.force"),
        (&|own| own.free[0].within = Some((2.0, 3.0)), "outside its range, 2 N to 3 N"),
        (&|own| own.measured = Measured::default(), "no sample"),
        (&|own| own.starts = 3, "a range of friction.floor.force by --within"),
        (&|own| own.free.clear(), "0 free parameters"),
    ];
    for (change, words) in cases {
        let mut own = request(m.clone(), sound.clone(), &["friction.floor.force"]);
        change(&mut own);
        let error = fit(&own, &|_| true).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}
