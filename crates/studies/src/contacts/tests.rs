use super::*;
use crate::flight::{Flows, follow};
use crate::followed::Followed;
use crate::tests::{example, text};
use crate::watch::Watcher;
use crate::{Extremes, Start};

/// Tolerance for the rounding of a few impacts.
const ROUNDING: f64 = 1e-11;

/// Balls of 0.5 kg and 2 kg fall by 0.2 m at 10 m/s² onto separate floors at the same instant.
fn two_balls() -> Motion {
    let ball = |name: &str, mass: f64, e: f64| {
        format!(
            "[body.{name}]\nmass = {mass:?}\ngravity = 1.0\n[stop.{name}]\nbetween = [\"ground\", \"{name}\"]\ngap = 0.2\n\
             restitution = {e:?}\n"
        )
    };
    text(&format!("name = \"B\"\ngravity = 10.0\n{}{}", ball("a", 0.5, 0.5), ball("b", 2.0, 0.8)))
        .motion(&Start::default())
        .unwrap()
        .0
}

fn followed(motion: &mut Motion, end: f64) -> ContactRecorder {
    let contacts = ContactRecorder::new(motion, &[]);
    let mut followed = Followed::new(contacts, Extremes::new(&[], (0.0, end)));
    followed.advance(motion, end, &mut |_| (), &mut |_| ()).unwrap();
    followed.contacts
}

#[test]
fn closed_form_impacts_at_one_instant_lose_each_its_own() {
    let contacts = followed(&mut two_balls(), 0.3).all();
    assert_eq!(contacts.len(), 2);
    for contact in contacts {
        let (mass, e) = [(0.5, 0.5), (2.0, 0.8)][contact.stop];
        // 2 m/s; ½ m u² (1 - e²).
        assert!((contact.speed - 2.0).abs() < ROUNDING && contact.peak.is_none());
        assert!((contact.impulse.unwrap() - mass * 2.0 * (1.0 + e)).abs() < ROUNDING, "{contact:?}");
        assert!((contact.lost.unwrap() - 2.0 * mass * (1.0 - e * e)).abs() < ROUNDING, "{contact:?}");
        assert_eq!(contact.end, Some(contact.begin));
    }
}

/// Each impact of an instant loses ½ (1 - ε) u P. If the account has a larger loss, the impacts
/// share the rest in proportion to their work u P.
#[test]
fn closed_form_what_the_account_has_more_is_shared_by_work() {
    let motion = two_balls();
    let system = motion.assembly().system();
    let impact = |stop: usize, speed: f64, impulse: f64| {
        let kind = EventKind::Impact { stop, speed, impulse, stops: 2 };
        Event { time: 1.0, kind }
    };
    // ½ · ½ · 3 · 4 = 3 and ½ · 0.2 · 5 · 2 = 1 J; works of 12 and 10.
    let events = [impact(0, 3.0, 4.0), impact(1, 5.0, 2.0)];
    let close = Event { time: 1.0, kind: EventKind::Close { stop: 0 } };
    let of = |events: &[Event], lost: Option<f64>| {
        let mut contacts = ContactRecorder::new(&motion, &[]);
        contacts.meet(system, events, lost);
        contacts.all.iter().map(|c| c.lost.unwrap()).collect::<Vec<f64>>()
    };
    let near = |found: Vec<f64>, expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < ROUNDING), "{found:?} {expected:?}");
    };
    near(of(&events, None), &[3.0, 1.0]);
    near(of(&events, Some(4.0)), &[3.0, 1.0]);
    near(of(&events, Some(6.2)), &[3.0 + 1.2, 1.0 + 1.0]);
    // The last impact before a stop stays closed loses all its energy: ½ · 3 · 4.
    near(of(&[events[0].clone(), close.clone()], None), &[6.0, 0.0]);
    near(of(&[events[1].clone(), close], None), &[1.0, 0.0]);
    // Impacts reported before a contact's beginning are not shared again.
    let mut contacts = ContactRecorder::new(&motion, &events[..1]);
    contacts.meet(system, &events[1..], Some(2.0));
    assert!((contacts.all[1].lost.unwrap() - 2.0).abs() < ROUNDING);
}

#[test]
fn zero_speeds_have_no_sign_and_ends_come_once_and_not_before_the_begin() {
    let motion = two_balls();
    let mut contacts = ContactRecorder::new(&motion, &[]);
    contacts.begin(1, 0.5, -0.0);
    assert!(contacts.all[0].speed.is_sign_positive());
    contacts.end(0, 0.6);
    assert_eq!(contacts.all[0].end, None, "another stop's");
    contacts.end(1, 0.4);
    assert_eq!(contacts.all[0].end, Some(0.5));
    contacts.end(1, 0.9);
    assert_eq!(contacts.all[0].end, Some(0.5));
    contacts.begin(0, 0.2, 1.0);
    let begins: Vec<f64> = contacts.all().iter().map(|c| c.begin).collect();
    assert_eq!(begins, [0.2, 0.5]);
}

#[test]
fn what_is_cut_off_is_forgotten_and_what_lasts_beyond_it_is_open() {
    let mut contacts = ContactRecorder::new(&two_balls(), &[]);
    for (begin, end) in [(0.1, Some(0.2)), (0.3, Some(0.6)), (0.4, None), (0.5, Some(0.5)), (0.7, Some(0.8))]
    {
        contacts.begin(0, begin, 1.0);
        contacts.all.last_mut().unwrap().end = end;
    }
    contacts.cut(0.5);
    let left: Vec<(f64, Option<f64>, bool)> =
        contacts.all.iter().map(|c| (c.begin, c.end, c.lost.is_some())).collect();
    assert_eq!(
        left,
        [(0.1, Some(0.2), true), (0.3, None, false), (0.4, None, false), (0.5, Some(0.5), true)]
    );
    assert!(contacts.all[1].peak.is_none() && contacts.all[1].impulse.is_none());
    assert!(contacts.current.iter().all(Option::is_none));
}

/// A buffer that holds a body from the start, and one that is left out.
#[test]
fn closed_form_a_body_on_its_buffer_from_the_start() {
    let machine = text(
        "name = \"M\"\n[body.a]\nmass = 2.0\nstart = { s = 0.01, v = 0.3 }\n[stop.b]\nbetween = [\"ground\", \"a\"]\n\
         gap = 0.0\nstiffness = 1800.0\n[load.f]\non = \"a\"\namplitude = 0.0\nfrequency = 1.0\n",
    );
    let (mut motion, _) = machine.motion(&Start::default()).unwrap();
    let mut contacts = ContactRecorder::new(&motion, &[]);
    let [first] = contacts.all()[..] else { panic!() };
    assert_eq!((first.begin, first.speed, first.end), (0.0, 0.3, None));
    // √(s² + (v/ω)²) with ω = 30/s.
    let [one] = followed(&mut motion, 1.0).all()[..] else { panic!() };
    assert!((one.peak.unwrap() - 1800.0 * 0.01f64.hypot(0.01)).abs() < 36.0 * ROUNDING, "{one:?}");
    let after = motion.body(0)[1];
    assert!((one.impulse.unwrap() - 2.0 * (0.3 - after)).abs() < ROUNDING, "{one:?}");
    // Unobserved contacts have no force. The loss of a contact that lasts through them is unknown.
    contacts.leave_out();
    assert_eq!(contacts.all()[0].peak, Some(0.0), "no stop acts so far");
    contacts.acting.push(Acting { stop: 0, force: Sparse::default(), losses: Vec::new() });
    contacts.leave_out();
    let [one] = contacts.all()[..] else { panic!() };
    assert_eq!((one.peak, one.impulse, one.lost), (None, None, None));
}

/// Second method: a watcher's counts, and the accounts.
#[test]
fn second_method_contacts_one_by_one_are_what_a_watcher_sees() {
    for name in ["damper_with_buffer.toml", "impact_pair.toml", "pipe_supports.toml", "gear_backlash.toml"] {
        let (mut motion, _) = example(name).motion(&Start::default()).unwrap();
        let mut watched = motion.clone();
        let stops = motion.assembly().description.stops.len();
        let contacts = followed(&mut motion, 3.0);
        // In two halves, which are joined.
        let mut whole = Watcher::of(&[], stops);
        for end in [1.3, 3.0] {
            let mut watcher = Watcher::of(&[], stops);
            follow(&mut watched, &mut Flows::default(), end, &mut [&mut watcher], &mut |_| false).unwrap();
            whole.join(&watcher);
        }
        assert!(whole.contacts.iter().any(|seen| seen.count > 0), "{name}");
        let rigid = |stop: usize| motion.assembly().system().stops[stop].restitution().is_some();
        for (stop, seen) in whole.contacts.iter().enumerate() {
            // Contacts that exist at the start have no event.
            let own: Vec<StopContact> =
                contacts.all.iter().filter(|c| c.stop == stop && c.begin > 0.0).copied().collect();
            let own: Vec<StopContact> =
                own.into_iter().filter(|c| !rigid(stop) || c.peak.is_none()).collect();
            let most = |of: &dyn Fn(&StopContact) -> f64| own.iter().map(of).fold(0.0, f64::max);
            assert_eq!(own.len() as u32, seen.count, "{name} {stop}");
            let near = |a: f64, b: f64| assert!((a - b).abs() <= ROUNDING * b, "{name} {stop}: {a} {b}");
            near(most(&|c| c.speed), seen.speed);
            if rigid(stop) {
                near(most(&|c| c.impulse.unwrap()), seen.impulse);
                let lost: f64 = own.iter().map(|c| c.lost.unwrap()).sum();
                near(lost, seen.lost);
            } else {
                assert_eq!((seen.impulse, seen.lost), (0.0, 0.0));
            }
        }
    }
}

/// A step of a stop's stiffness ends no contact: the force jumps within it.
#[test]
fn closed_form_a_contact_goes_on_where_the_stiffness_steps() {
    let machine = text(
        "name = \"B\"\n[body.ball]\nmass = 1.0\nstart = { v = 2.0 }\n[stop.pad]\nbetween = [\"ground\", \"ball\"]\ngap = 0.1\n\
         stiffness = { constant = 100.0, steps = [[0.1, 300.0]] }\n",
    );
    let contacts = followed(&mut machine.motion(&Start::default()).unwrap().0, 1.0).all();
    let [one] = contacts[..] else { panic!("{contacts:?}") };
    // From 0.05 s on 0.2 sin 10 t; then ½ v² + ½ · 400 x² stays.
    let (sine, cosine) = 0.5f64.sin_cos();
    let (x, v) = (0.2 * sine, 2.0 * cosine);
    let away = (v * v + 400.0 * x * x).sqrt();
    assert!((one.begin - 0.05).abs() < ROUNDING && (one.impulse.unwrap() - 2.0 - away).abs() < ROUNDING);
    assert!((one.peak.unwrap() - 20.0 * away).abs() < 1e-9 && one.lost.unwrap().abs() < ROUNDING, "{one:?}");
}
