use super::*;
use crate::StopContact;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use vibro_machine::{Assembly, Quantity, What, file};

/// Tolerance for the rounding of a motion of a few dozen events.
const ROUNDING: f64 = 1e-11;
/// Tolerance for the error from the bounces that are cut off: they are below 1e-9 of the first
/// one, and so is their contribution.
const CUT: f64 = 1e-8;

fn text(text: &str) -> Motion {
    let description = file::parse(text, "m.toml", &file::no_records).unwrap();
    Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap()
}

fn example(name: &str) -> Motion {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly")).join(name);
    Motion::new(Arc::new(Assembly::new(file::read(&path).unwrap()).unwrap())).unwrap()
}

/// Follows a motion in equal steps, with the extremes of each body's coordinate.
fn followed(motion: &mut Motion, end: f64, steps: u32) -> Followed {
    let d = motion.assembly().description.clone();
    let places: Vec<_> = (0..d.bodies.len()).map(|i| Quantity::of_body(i, What::S)).collect();
    let contacts = ContactRecorder::new(motion, &[]);
    let mut followed = Followed::new(contacts, Extremes::new(&places, (0.0, end)));
    for k in 1..=steps {
        let time = end * f64::from(k) / f64::from(steps);
        followed.advance(motion, time, &mut |_| (), &mut |_| ()).unwrap();
    }
    followed
}

fn sum(contacts: &[StopContact], stop: usize, of: fn(&StopContact) -> Option<f64>) -> f64 {
    contacts.iter().filter(|c| c.stop == stop).filter_map(of).sum()
}

#[track_caller]
fn near(a: f64, b: f64, size: f64, part: f64) {
    assert!((a - b).abs() <= part * size, "{a} {b}");
}

/// A block of 2 kg that meets a spring of 1800 N/m with 0.6 m/s: half a period of ω = 30/s.
#[test]
fn closed_form_of_a_contact_with_a_spring() {
    let text_of = |damping: &str| {
        format!(
            "name = \"M\"\n[body.a]\nmass = 2.0\nstart = {{ v = 0.6 }}\n[stop.b]\nbetween = [\"ground\", \"a\"]\n\
             gap = 0.06\nstiffness = 1800.0\n{damping}"
        )
    };
    let contacts = followed(&mut text(&text_of("")), 1.0, 7).contacts.all();
    let [one] = contacts[..] else { panic!("{contacts:?}") };
    near(one.begin, 0.1, 0.1, ROUNDING);
    near(one.end.unwrap(), 0.1 + PI / 30.0, 0.1, ROUNDING);
    near(one.peak.unwrap(), 0.6 * (2.0f64 * 1800.0).sqrt(), 36.0, ROUNDING);
    near(one.impulse.unwrap(), 2.0 * 2.0 * 0.6, 2.4, ROUNDING);
    near(one.speed, 0.6, 0.6, ROUNDING);
    near(one.lost.unwrap(), 0.0, 0.36, ROUNDING);
    // Critical damping, c = 2 m ω: the force is largest at first touch, and zero from 2/ω on.
    let mut motion = text(&text_of("damping = 120.0"));
    let contacts = followed(&mut motion, 1.0, 7).contacts.all();
    let [one] = contacts[..] else { panic!("{contacts:?}") };
    near(one.peak.unwrap(), 120.0 * 0.6, 72.0, ROUNDING);
    near(one.end.unwrap(), 0.1 + 2.0 / 30.0, 0.1, ROUNDING);
    let after = motion.body(0)[1];
    near(one.impulse.unwrap(), 2.0 * (0.6 - after), 2.4, ROUNDING);
    // The spring loses the rest of its energy without force.
    near(one.lost.unwrap(), 0.36 - after * after, 0.36, ROUNDING);
}

/// A ball that bounces, comes to rest and is lifted off at 2 s by a load.
#[test]
fn invariants_momentum_and_energy_of_bounces_and_rest() {
    let mut motion = text(
        "name = \"Ball\"\ngravity = 10.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n[stop.floor]\n\
         between = [\"ground\", \"ball\"]\ngap = 0.2\nrestitution = 0.5\n[load.lift]\non = \"ball\"\nsteps = [[2.0, -7.5]]\n",
    );
    let contacts = followed(&mut motion, 2.5, 11).contacts.all();
    let impulse = sum(&contacts, 0, |c| c.impulse);
    near(impulse, 5.0 * 2.5 - 7.5 * 0.5 - 0.5 * motion.body(0)[1], 12.5, CUT);
    // From 0.2 m: all energy is lost before the ball is lifted.
    near(sum(&contacts, 0, |c| c.lost), 1.0, 1.0, CUT);
    near(sum(&contacts, 0, |c| c.lost), motion.energy().impacts.value(), 1.0, ROUNDING);
    let rest = contacts.last().unwrap();
    near(rest.peak.unwrap(), 5.0, 5.0, ROUNDING);
    near(rest.end.unwrap(), 2.0, 2.0, ROUNDING);
    // (1 + e)/(1 - e) falls of 0.2 s.
    near(rest.begin, 0.6, 0.6, CUT);
    assert!(contacts.len() > 10 && contacts[..contacts.len() - 1].iter().all(|c| c.peak.is_none()));
    assert!(contacts.iter().all(|c| c.end.is_some_and(|end| end >= c.begin)));
    // While the ball rests, the contact has no end.
    let mut resting = text(
        "name = \"Ball\"\ngravity = 10.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n[stop.floor]\n\
         between = [\"ground\", \"ball\"]\ngap = 0.0\nrestitution = 0.5\n",
    );
    let contacts = followed(&mut resting, 1.0, 3).contacts.all();
    let [one] = contacts[..] else { panic!("{contacts:?}") };
    assert_eq!((one.begin, one.end), (0.0, None));
    near(one.impulse.unwrap(), 5.0, 5.0, ROUNDING);
}

#[test]
fn invariant_losses_of_contacts_are_the_accounts() {
    for (name, end) in [
        ("damper_with_buffer.toml", 1.0),
        ("msl_elastogap.toml", 2.0),
        ("three_balls.toml", 1.0),
        ("pipe_supports.toml", 1.0),
    ] {
        let mut motion = example(name);
        let contacts = followed(&mut motion, end, 40).contacts.all();
        assert!(!contacts.is_empty(), "{name}");
        let energy = motion.energy();
        let mut impacts = 0.0;
        for i in 0..motion.assembly().description.stops.len() {
            let lost = sum(&contacts, i, |c| c.lost);
            if motion.assembly().system().stops[i].restitution().is_some() {
                impacts += lost;
            } else {
                let through: f64 = contacts.iter().map(|c| c.speed * c.impulse.unwrap_or(0.0)).sum();
                near(lost, energy.stops[i].value(), through, ROUNDING);
            }
        }
        near(impacts, energy.impacts.value(), energy.impacts.value(), ROUNDING);
    }
}

#[test]
fn second_method_the_motion_is_the_engines_and_samples_change_nothing() {
    let (mut by_engine, mut one, mut many) = (
        example("damper_with_buffer.toml"),
        example("damper_with_buffer.toml"),
        example("damper_with_buffer.toml"),
    );
    for k in 1..=40 {
        by_engine.advance_to(f64::from(k) / 40.0).unwrap();
    }
    let (few, fine) = (followed(&mut one, 1.0, 1), followed(&mut many, 1.0, 40));
    assert_eq!(many.save(), by_engine.save());
    let (few_contacts, fine_contacts) = (few.contacts.all(), fine.contacts.all());
    assert_eq!(few_contacts.len(), fine_contacts.len());
    for (a, b) in few_contacts.iter().zip(&fine_contacts) {
        near(a.begin, b.begin, 1.0, CUT);
        near(a.peak.unwrap_or(0.0), b.peak.unwrap_or(0.0), 1e3, CUT);
    }
    for (a, b) in few.extremes.all.iter().zip(&fine.extremes.all) {
        near(a.largest, b.largest, b.largest, CUT);
        assert!(a.points().iter().any(|p| p.1.abs() == a.largest));
    }
}

/// A spring swings by 3 mm from the start; samples are taken at whole periods.
#[test]
fn closed_form_extremes_lie_between_samples() {
    let mut motion = text(
        "name = \"O\"\n[body.a]\nmass = 1.0\nstart = { v = 0.03 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n",
    );
    let found = followed(&mut motion, 10.0 * PI / 5.0, 10);
    assert!(motion.body(0)[0].abs() < 1e-9);
    near(found.extremes.all[0].largest, 3e-3, 3e-3, ROUNDING);
    assert_eq!(found.left_out, 0.0);
    // The extreme begins at the coordinate's start, not at zero.
    let mut motion = text(
        "name = \"O\"\n[body.a]\nmass = 1.0\nstart = { s = 0.02 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n",
    );
    let points = followed(&mut motion, 0.1, 1).extremes.all[0].points();
    assert!(points.iter().all(|p| p.1 > 0.01), "{points:?}");
}

/// A ball of 100 m/s between walls 2 mm apart meets one every 20 µs and loses nothing. A body lies
/// on a buffer next to it.
#[test]
fn closed_form_what_is_beyond_the_work_of_one_advance_is_counted_and_left_out() {
    let machine = "name = \"W\"\n[body.ball]\nmass = 1.0\nstart = { v = 100.0 }\n[stop.right]\nbetween = [\"ground\", \"ball\"]\n\
        gap = 1e-3\nrestitution = 1.0\n[stop.left]\nbetween = [\"ball\", \"ground\"]\ngap = 1e-3\nrestitution = 1.0\n\
        [body.a]\nmass = 1.0\nstart = { s = 0.5 }\n[stop.buffer]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nstiffness = 1.0\n";
    let impacts = |contacts: &[StopContact]| contacts.iter().filter(|c| c.stop < 2).count();
    let resting = |contacts: &[StopContact]| *contacts.iter().find(|c| c.stop == 2).unwrap();
    let end = 0.5 + 5e-6;
    let whole = followed(&mut text(machine), end, 1);
    let all = whole.contacts.all();
    assert_eq!(impacts(&all), 25_000);
    // 20,000 flights in 0.4 s are observed.
    near(whole.left_out, 0.1, 0.1, 1e-2);
    let one = resting(&all);
    assert_eq!((one.peak, one.impulse, one.lost, one.end), (None, None, None, None));
    let parts = followed(&mut text(machine), end, 10);
    let all = parts.contacts.all();
    assert_eq!((impacts(&all), parts.left_out), (25_000, 0.0));
    // 0.5 cos t.
    let one = resting(&all);
    near(one.peak.unwrap(), 0.5, 0.5, CUT);
    near(one.impulse.unwrap(), 0.5 * end.sin(), 0.5, CUT);
}

/// Long flights use up the number of further stretches, and are then left out. Short flights are
/// always observed.
#[test]
fn closed_form_flights_of_many_stretches_are_looked_at_up_to_a_limit() {
    let mut motion = text(
        "name = \"O\"\n[body.a]\nmass = 1.0\nstart = { s = 0.02 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 400.0\n",
    );
    let mut follower = followed(&mut motion, 0.1, 1);
    assert_eq!(follower.left, MOST, "a short flight uses up nothing");
    let mut advance = |follower: &mut Followed, span: f64| {
        let end = motion.time() + span;
        follower.advance(&mut motion, end, &mut |_| (), &mut |_| ()).unwrap();
    };
    advance(&mut follower, 10.0);
    let used = MOST - follower.left;
    // The rate is 20/s at least, and a stretch two of its inverse.
    assert!((36.0..1000.0).contains(&used), "{used}");
    follower.left = 2.5 * used;
    for (left, left_out) in [(1.5, 0.0), (0.5, 0.0), (0.5, 10.0), (0.5, 20.0)] {
        advance(&mut follower, 10.0);
        // Rounding of the time may make a stretch more or less.
        near(follower.left, left * used, 1.0, 4.0);
        near(follower.left_out, left_out, 10.0, ROUNDING);
    }
    advance(&mut follower, 0.1);
    near(follower.left_out, 20.0, 10.0, ROUNDING);
}
