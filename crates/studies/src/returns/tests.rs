use super::*;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, Start};

/// Tolerance for the rounding of a few operations.
const ROUNDING: f64 = 1e-13;

/// A body and a shaft with an element of each kind; the section fixes the phase of 5 Hz only.
fn mixed() -> (Motion, Section) {
    let file = "name = \"M\"\n[body.a]\nmass = 2.0\nstart = { s = 0.1, v = 0.5 }\n[body.r]\ninertia = 0.5\n\
        start = { s = 0.3, v = -0.7 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\ndamping = 8.0\n\
        [spring.d]\nbetween = [\"ground\", \"a\"]\nstiffness = 0.0\ndamping = 3.0\n[spring.t]\nbetween = [\"ground\", \"r\"]\n\
        stiffness = 50.0\n[stop.hard]\nbetween = [\"ground\", \"a\"]\ngap = 1.0\nrestitution = 0.5\n[stop.soft]\n\
        between = [\"ground\", \"r\"]\ngap = 1.0\nstiffness = 200.0\n[friction.f]\nbetween = [\"ground\", \"r\"]\nforce = 0.1\n\
        [load.l]\non = \"a\"\nharmonics = [{amplitude = 1.0, frequency = 5.0}, {amplitude = 1.0, frequency = 7.07}]\n";
    let mut machine = text(file);
    machine.section = crate::SectionRule::Period(0.2);
    machine.motion(&Start::default()).unwrap()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= ROUNDING * b.abs().max(1.0), "{found:?} {expected:?}");
    }
}

#[test]
fn closed_form_what_must_return_of_elements_of_each_kind() {
    let (mut motion, section) = mixed();
    let assembly = motion.assembly().clone();
    let of = Functionals::of(&assembly.description, assembly.system(), &section);
    // Spring, dashpot, torsion spring, rigid stop, compliant stop, friction.
    assert_eq!(of.kinds, [0, 2, 2, 1, 3, 0, 2, 1, 3, 3]);
    assert_eq!(of.phases, [7.07]);
    let places: Vec<Option<usize>> = of.stiff.iter().map(|s| s.map(|s| s.0)).collect();
    assert_eq!(places, [None, Some(0), None, None, Some(3), None, Some(5), None, Some(7), None]);
    // √(k/m) of each element with an elongation; zero for the rigid stop.
    let frequencies: Vec<f64> = of.stiff.iter().flatten().map(|s| s.1).collect();
    near(&frequencies, &[20.0, 10.0, 0.0, 20.0]);
    let (values, sizes) = of.at(&motion);
    near(&values, &[0.1, 0.5, 0.5, 0.3, -0.7, 0.1, 0.5, 0.3, -0.7, -0.7, 1.0, 0.0]);
    near(&sizes, &[0.1, 2.5, 0.5, 0.3, 3.7, 0.1, 0.5, 0.3, 6.7, 0.7, 1.0, 1.0]);
    motion.advance_to(1.3).unwrap();
    let (values, sizes) = of.at(&motion);
    let (sine, cosine) = (TAU * 7.07 * 1.3).sin_cos();
    near(&values[10..], &[cosine, sine]);
    near(&sizes[10..], &[7.07 * 1.3; 2]);
    // q and q' of the body and the shaft.
    near(
        &of.changes(&[1.0, 10.0, 100.0, 1000.0]),
        &[1.0, 100.0, 100.0, 10.0, 1e3, 1.0, 100.0, 10.0, 1e3, 1e3],
    );
}

/// A record of an elongation and its rate with these returns, one every half second.
fn record(states: &[[f64; 2]]) -> ReturnRecord {
    let (motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    let mut record = ReturnRecord::new(&motion, &section);
    for (k, state) in states.iter().enumerate() {
        for (extent, x) in record.extents.iter_mut().zip(state) {
            *extent = [extent[0].min(*x), extent[1].max(*x)];
        }
        let time = 7.0 + 0.5 * k as f64;
        record.returns.push(Return { state: state.to_vec(), contacts: 0, pattern: 0, time });
    }
    record
}

#[test]
fn closed_form_sizes_are_extents_and_what_the_other_of_a_pair_makes() {
    let omega = TAU / 0.5;
    let found = record(&[[-1.0, 2.0], [2.0, 2.5], [0.5, 2.0]]);
    near(&[found.interval()], &[0.5]);
    near(&found.sizes(), &[3.0, 0.0, 3.0 * omega, 0.0]);
    near(&found.scales(), &[3.0, 3.0 * omega]);
    let found = record(&[[0.0, -40.0], [0.1, 60.0]]);
    near(&found.sizes(), &[100.0 / omega, 0.0, 100.0, 0.0]);
    // A value that stays near -10⁶ has 10⁻⁵ of it as its size.
    near(&record(&[[-1e6, 0.0], [1.0 - 1e6, 0.0]]).sizes()[..1], &[10.0]);
    near(&[record(&[[0.0; 2]]).interval()], &[1.0]);
    // Angles and spins likewise.
    let (motion, section) = mixed();
    let mut turning = ReturnRecord::new(&motion, &section);
    turning.extents = vec![[0.0; 2]; 10];
    (turning.extents[3], turning.extents[9]) = ([0.0, 2.0], [0.0, 1.0]);
    near(&turning.sizes(), &[0.0, 2.0, 0.0, 2.0 * TAU]);
    turning.extents[9] = [0.0, 100.0];
    near(&turning.sizes(), &[0.0, 100.0 / TAU, 0.0, 100.0]);
    // Rounding of the terms is at most 1e-4 of a scale.
    turning.terms = vec![0.0; 12];
    turning.terms[3] = 1e15;
    near(&turning.scales()[2..5], &[0.0, 1e15 * 64.0 * f64::EPSILON / 1e-4, 100.0]);
    assert_eq!(turning.scales()[10..], [1.0, 1.0]);
}

#[test]
fn closed_form_a_distance_is_the_largest_part_beyond_rounding() {
    let mut record = record(&[[0.0; 2]]);
    record.terms = vec![1.0, 1e12];
    let rounding = 64.0 * f64::EPSILON * 1e12;
    let of = |record: &ReturnRecord, change: [f64; 2]| record.distance(&change, &[0.0; 2], &[2.0, 10.0]);
    near(&[of(&record, [1.0, 1.0]), of(&record, [-1.0, 1.0])], &[0.5, 0.5]);
    near(&[of(&record, [1.0, 10.0])], &[(10.0 - rounding) / 10.0]);
    assert_eq!(of(&record, [0.0, 0.9 * rounding]), 0.0);
    assert_eq!(record.distance(&[1.0, 0.0], &[0.0; 2], &[0.0, 1.0]), 0.0, "what has no size");
    // An elongation of size 4; its rate has this size times the returns' angular frequency.
    let record = super::tests::record(&[[0.0; 2], [4.0, 0.0]]);
    near(&[record.size_of_change(&[1.0, 0.0])], &[0.25]);
    near(&[record.size_of_change(&[0.0, 4.0 * TAU])], &[0.5]);
}

#[test]
fn closed_form_periods_and_their_distances() {
    let cycle = |k: usize| [[0.0, 1.0], [1.0, 0.5], [3.0, 0.0]][k % 3];
    let mut repeating = record(&(0..24).map(cycle).collect::<Vec<_>>());
    assert_eq!(repeating.period(1e-9), Some(3));
    // The last return is off by 0.3 at a size of 3.
    repeating.returns[23].state[0] += 0.3;
    assert_eq!((repeating.period(0.09), repeating.period(0.11)), (None, Some(3)));
    near(&[repeating.return_distance(3)], &[0.1]);
    // With a lag of one, the difference of the last two returns: from 1 to 3.3.
    near(&[repeating.return_distance(1)], &[2.3 / 3.0]);
    // Returns before the last two periods do not count.
    repeating.returns[17].state[0] = 50.0;
    near(&[repeating.return_distance(3)], &[0.1]);
    // Other contacts make another return.
    let mut other = record(&(0..24).map(cycle).collect::<Vec<_>>());
    other.returns[22].pattern = 1;
    assert_eq!(other.period(1e-9), None);
}

#[test]
fn closed_form_what_goes_one_way_drifts_and_what_approaches_nears() {
    let of = |count: u32, state: &dyn Fn(f64) -> f64| {
        let states: Vec<[f64; 2]> = (0..count).map(|k| [state(f64::from(k)), 0.0]).collect();
        record(&states)
    };
    for sign in [1.0, -1.0] {
        assert!(of(40, &|k| sign * k).drifts());
        // The later half has 16 of 32 returns, and 15 of 30.
        assert!(of(32, &|k| sign * k).drifts() && !of(30, &|k| sign * k).drifts());
        // Returns before the later half do not count.
        assert!(of(60, &|k| if k < 25.0 { (3.0 * k).sin() } else { sign * k }).drifts());
        assert!(!of(60, &|k| sign * k + if k == 50.0 { -2.0 * sign } else { 0.0 }).drifts());
        // Changes below 1e-5 of the earlier size do not count.
        assert!(!of(60, &|k| if k == 0.0 { 1.0 } else { sign * 1e-7 * k }).drifts());
        assert!(of(60, &|k| if k == 0.0 { 1.0 } else { sign * 1e-6 * k }).drifts());
    }
    assert!(!of(40, &|_| 1.0).drifts() && !of(0, &|_| 1.0).drifts());
    assert!(of(128, &|k| 0.9f64.powf(k)).is_approaching());
    assert!(!of(128, &|k| (1.618 * k).sin()).is_approaching());
}

#[test]
fn early_returns_are_forgotten_from_eight_longest_periods_on() {
    let longest = LONGEST as usize;
    let counted = |k: usize| [k as f64, 0.0];
    let mut few = record(&(0..8 * longest - 1).map(counted).collect::<Vec<_>>());
    few.shorten();
    assert_eq!(few.returns.len(), 8 * longest - 1);
    let mut many = record(&(0..8 * longest).map(counted).collect::<Vec<_>>());
    many.shorten();
    assert_eq!(many.returns.len(), 4 * longest);
    assert_eq!(many.returns[0].state[0], (4 * longest) as f64);
}

fn hit(stop: usize, speed: f64, time: f64) -> Event {
    let kind = EventKind::Press { stop, speed };
    Event { time, kind }
}

#[test]
fn a_pattern_is_of_how_many_contacts_of_each_stop_that_are_no_chatter() {
    let pattern = |hits: &[(usize, f64)]| {
        let mut record = record(&[]);
        hits.iter().for_each(|(stop, speed)| record.event(&hit(*stop, *speed, 0.0)));
        (record.contacts, record.pattern)
    };
    assert_eq!(pattern(&[(0, 1.0), (1, 1.0), (1, 0.5)]), pattern(&[(1, 0.5), (1, 1.0), (0, 1.0)]));
    let other = [&[(0, 1.0)][..], &[(1, 1.0)], &[(0, 1.0), (0, 1.0)], &[(0, 1.0), (1, 1.0)], &[]]
        .map(|h| pattern(h).1);
    (0..5).for_each(|i| (0..i).for_each(|j| assert_ne!(other[i], other[j], "{i} {j}")));
    // A contact at 5e-7 of the fastest speed counts, but only one at 5e-6 changes the pattern.
    assert_eq!(pattern(&[(0, 2.0), (0, 1e-6)]), (2, pattern(&[(0, 2.0)]).1));
    assert_eq!(pattern(&[(0, 2.0), (0, 1e-5)]), pattern(&[(0, 2.0), (0, 2.0)]));
}

#[test]
fn contacts_are_counted_from_return_to_return_and_rests_are_noted() {
    let (motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    let mut record = ReturnRecord::new(&motion, &section);
    record.event(&hit(0, 1.0, 0.0));
    record.event(&hit(0, 1.0, 0.0));
    record.arrive(&motion, true);
    record.event(&hit(0, 1.0, 0.0));
    record.arrive(&motion, true);
    let contacts: Vec<u32> = record.returns.iter().map(|r| r.contacts).collect();
    assert_eq!(contacts, [2, 1]);
    assert_ne!(record.returns[0].pattern, record.returns[1].pattern);
    assert!(!record.rests && !record.is_beside);
    for kind in [EventKind::Close { stop: 0 }, EventKind::Stick { friction: 0 }] {
        let mut resting = record.clone();
        resting.event(&Event { time: 0.0, kind });
        assert!(resting.rests);
    }
    // A ball that lies on its floor from the start.
    let ball = example("bouncing_ball.toml");
    let still = Machine::new(ball.description.with([("stop.floor.gap", 0.0)]).unwrap());
    let (lying, section) = still.motion(&Start::default()).unwrap();
    assert!(ReturnRecord::new(&lying, &section).rests);
    // The smallest value does not exceed the largest.
    assert!(record.extents[0][0] <= record.extents[0][1]);
}

#[test]
fn a_contact_beside_a_return_is_told_by_the_interval() {
    let (motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    // The return comes at 0.2 s after one at 0.
    let beside = |time: f64, at_event: bool| {
        let mut motion = motion.clone();
        let mut record = ReturnRecord::new(&motion, &section);
        record.arrive(&motion, at_event);
        motion.advance_to(0.2).unwrap();
        record.event(&hit(0, 1.0, time));
        record.arrive(&motion, at_event);
        record.is_beside
    };
    for time in [0.0, 1e-7, 0.2, 0.2 - 1e-7, 0.2 + 1e-7] {
        assert!(beside(time, false), "{time}");
        assert!(!beside(time, true), "events are the section: {time}");
    }
    assert!(!beside(0.1, false) && !beside(1e-6, false) && !beside(0.2 - 1e-6, false));
}

/// An undamped oscillator that is observed when it passes zero, once per period of 0.5 s.
#[test]
fn closed_form_sizes_are_taken_between_returns() {
    let stiffness = (TAU / 0.5).powi(2);
    let file = format!(
        "name = \"S\"\n[body.a]\nmass = 1.0\nstart = {{ v = 1.0 }}\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = {stiffness:?}\n"
    );
    let mut machine = text(&file);
    machine.section = crate::SectionRule::Period(0.5);
    let (motion, section) = machine.motion(&Start::default()).unwrap();
    let mut record = ReturnRecord::new(&motion, &section);
    record.arrive(&motion, false);
    assert!(record.extents[0][1] < ROUNDING);
    record.look_between(&motion, 0.5);
    // Of nine parts the second is at 80° and the seventh at 280°. For the rate the fourth is at
    // 160°.
    let omega = TAU / 0.5;
    let top = (80f64).to_radians().sin() / omega;
    near(&record.extents[0], &[-top, top]);
    near(&record.extents[1], &[(160f64).to_radians().cos(), 1.0]);
    // The terms of the rate include the elongation's terms at the spring's frequency.
    let most = (0..9).map(|k| (TAU / 9.0 * f64::from(k)).sin_cos()).map(|(s, c)| s.abs() + c.abs());
    near(&record.terms, &[top, most.fold(0.0, f64::max)]);
}
