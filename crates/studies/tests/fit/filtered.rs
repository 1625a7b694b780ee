//! Columns that a sensor records through its low-pass filter.

use super::*;
use vibro_studies::fit::Filter;

const GRAVITY: f64 = 9.81;
/// Corner frequency of the sensor, Hz.
const CORNER: f64 = 40.0;

fn dropped(gap: f64, restitution: f64, speed: f64) -> Machine {
    let text = format!(
        "name = \"Ball\"\ngravity = {GRAVITY}\nbody.b = {{ mass = 1.0, gravity = 1.0, start = {{ v = {speed:?} }} }}\n\
         stop.floor = {{ between = [\"ground\", \"b\"], gap = {gap:?}, restitution = {restitution:?} }}\n"
    );
    Machine::parse(&text, "ball.toml", &no_records).unwrap()
}

/// Filter responses to an acceleration of 1 from time 0 on, and to a velocity jump of 1.
fn answers(order: u32, time: f64) -> (f64, f64) {
    let corner = TAU * CORNER;
    if time < 0.0 {
        return (0.0, 0.0);
    }
    if order == 1 {
        let left = (-corner * time).exp();
        return (1.0 - left, corner * left);
    }
    let rate = corner / 2f64.sqrt();
    let (left, angle) = ((-rate * time).exp(), rate * time);
    (1.0 - left * (angle.cos() + angle.sin()), 2f64.sqrt() * corner * left * angle.sin())
}

/// Accelerometer record of a ball that falls through a gap and bounces.
fn accelerometer(order: u32, (gap, restitution, speed): (f64, f64, f64), time: f64) -> f64 {
    let mut hit = ((speed * speed + 2.0 * GRAVITY * gap).sqrt() - speed) / GRAVITY;
    let mut closing = speed + GRAVITY * hit;
    let mut shown = GRAVITY * answers(order, time).0;
    while hit < time {
        shown -= (1.0 + restitution) * closing * answers(order, time - hit).1;
        closing *= restitution;
        hit += 2.0 * closing / GRAVITY;
    }
    shown
}

fn request_of(
    machine: Machine,
    order: u32,
    until: f64,
    shown: impl Fn(f64) -> f64,
    free: &[&str],
) -> FitRequest {
    let times: Vec<f64> = (0..600).map(|k| until * f64::from(k) / 599.0).collect();
    let values = times.iter().map(|time| shown(*time)).collect();
    let column: QuantityName = "b.a".parse().unwrap();
    let measured = Measured { times, columns: vec![(column.clone(), values)], contacts: Vec::new() };
    let filters = vec![Filter { column, order, frequency: CORNER }];
    FitRequest { filters, ..request(machine, measured, free) }
}

/// Residual for samples of up to 2000 m/s². The solver ends at relative steps of 1e-10, which move
/// an impact by as many seconds, and samples by up to 5e5 m/s² a second.
const SHOWN: f64 = 1e-4;
/// Free parameters of the fits.
const FREE: [&str; 3] = ["stop.floor.gap", "stop.floor.restitution", "body.b.start.v"];

/// Relative error of standard errors from finite differences of width 2e-6.
const DIFFERENCES: f64 = 1e-4;

/// Standard errors of gap, restitution and velocity for noise of 1 m/s², from finite differences
/// of the closed form.
fn errors(order: u32, truth: (f64, f64, f64), until: f64) -> [f64; 3] {
    let moved = |j: usize, by: f64| {
        let mut own = [truth.0, truth.1, truth.2];
        own[j] += by;
        (own[0], own[1], own[2])
    };
    let entry = |i: usize, j: usize| {
        let time = until * i as f64 / 599.0;
        (accelerometer(order, moved(j, 1e-6), time) - accelerometer(order, moved(j, -1e-6), time)) / 2e-6
    };
    let jacobian = nalgebra::OMatrix::<f64, nalgebra::Dyn, nalgebra::U3>::from_fn(600, entry);
    let covariance = (jacobian.transpose() * jacobian).try_inverse().unwrap();
    [0, 1, 2].map(|j| covariance[(j, j)].sqrt())
}

#[test]
fn closed_form_an_accelerometer_sees_an_impact_by_its_momentum() {
    // A first-order filter gives one value for each impact: its momentum times an exponential of
    // its time. Three impacts determine three parameters. Its jumps match only if no sample comes
    // between them and the record's.
    for (order, off) in [(1, 1e-4), (2, 3e-3)] {
        let truth = (1.0, 0.8, 0.5);
        let begin = dropped(1.0 + off, 0.8 - off, 0.5 - off);
        let shown = |time| accelerometer(order, truth, time);
        let own = request_of(begin, order, 1.9, shown, &FREE);
        let found = fitted(&FitRequest { sigma: Some(vec![1.0]), ..own });
        assert!(found.rms[0].1 < SHOWN, "{order}: {:?}", found.rms);
        for ((name, value), truth) in found.values.iter().zip([truth.0, truth.1, truth.2]) {
            assert!((value - truth).abs() < 1e-9, "{order}: {name} {value}");
        }
        let wanted = errors(order, truth, 1.9);
        for (own, wanted) in found.uncertainty.white.iter().zip(wanted) {
            assert!((own.unwrap() / wanted - 1.0).abs() < DIFFERENCES, "{order}: {own:?} {wanted}");
        }
        // The machine is the given one, without a filter.
        assert_eq!(found.machine.description.blocks, []);
    }
}

#[test]
fn made_record_of_an_accelerometer_through_three_impacts_alone_and_with_their_times() {
    let (truth, sigma) = ((1.0, 0.7, 0.0), 5.0);
    let noise = std::cell::RefCell::new(Noise(91));
    let shown = |time| accelerometer(2, truth, time) + sigma * noise.borrow_mut().normal();
    let own = request_of(dropped(1.003, 0.69, 0.0), 2, 1.7, shown, &FREE[..2]);
    let alone = fitted(&FitRequest { sigma: Some(vec![sigma]), ..own.clone() });
    // Times of the three impacts, as from a contact switch.
    let (fall, jitter) = ((2.0 / GRAVITY).sqrt(), 1e-5);
    let times =
        [1.0, 1.0 + 1.4, 1.0 + 1.4 + 0.98].map(|own| own * fall + jitter * noise.borrow_mut().normal());
    let mut both = FitRequest { sigma: Some(vec![sigma, jitter]), ..own.clone() };
    both.measured.contacts = vec![("floor".into(), times.to_vec())];
    let both = fitted(&both);
    assert!(both.uncertainty.errors[0] < alone.uncertainty.errors[0].map(|error| 0.5 * error));
    for found in [alone, both] {
        meets(&found, truth);
    }
}

fn meets(found: &Fitted, truth: (f64, f64, f64)) {
    assert_eq!(found.verdict, Verdict::Fits);
    for (k, truth) in [truth.0, truth.1].into_iter().enumerate() {
        let error = found.uncertainty.errors[k].unwrap();
        assert!(
            (found.values[k].1 - truth).abs() < FAR * error && error < 1e-2,
            "{:?} ± {error}",
            found.values[k]
        );
    }
}

#[test]
fn refused_filters_and_accelerations_are_named() {
    let own = request_of(dropped(1.0, 0.8, 0.0), 2, 1.0, |_| 1.0, &FREE[..1]);
    let filter =
        |column: &str, order, frequency| Filter { column: column.parse().unwrap(), order, frequency };
    let cases = [
        (vec![], "b.a has no filter"),
        (vec![filter("b.v", 2, 1.0)], "the record has no such column; expected one of b.a"),
        (vec![filter("b.a", 2, 1.0), filter("b.a", 2, 1.0)], "b.a has two filters"),
        (vec![filter("b.a", 0, 1.0)], "order 0, 1.0 Hz; expected an order from 1 to 8"),
        (vec![filter("b.a", 2, 0.0)], "order 2, 0.0 Hz; expected"),
    ];
    for (filters, words) in cases {
        let error = fit(&FitRequest { filters, ..own.clone() }, &|_| true).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn second_method_a_wide_filter_of_a_machine_at_rest_shows_its_acceleration() {
    const TEXT: &str = "name = \"Hung\"\nstart = \"rest\"\ngravity = 9.81\n\
                        body.b = { mass = 1.0, gravity = 1.0 }\n\
                        spring.k = { between = [\"ground\", \"b\"], stiffness = 400.0, damping = 1.0 }\n\
                        load.push = { on = \"b\", amplitude = 2.0, frequency = 2.0, phase = \"90 deg\" }\n";
    let m = Machine::parse(TEXT, "hung.toml", &no_records).unwrap();
    let measured = record(&m, &[("b.a", 0.0)], 0.25, 60, &mut Noise(1));
    let filters = vec![Filter { column: "b.a".parse().unwrap(), order: 2, frequency: 1e4 }];
    let begin = off(&m, &["spring.k.stiffness"], |_| 1.1);
    let found = fitted(&FitRequest { filters, ..request(begin, measured, &["spring.k.stiffness"]) });
    // The filter's delay is √2/(2π 1e4 Hz): 5e-4 of the phase of motions of some 20 rad/s.
    assert!((found.values[0].1 / 400.0 - 1.0).abs() < 1e-3, "{:?}", found.values);
}
