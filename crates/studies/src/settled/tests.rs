use super::*;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, SectionRule, Start};
use vibro_machine::file;

/// Two coupled oscillators with random numbers. In every second machine the second oscillator hits
/// a stop.
fn machine(draw: &mut impl FnMut(f64, f64) -> f64, hits: bool) -> Machine {
    let stop =
        if hits { "[stop.s]\nbetween = [\"ground\", \"b\"]\ngap = 0.002\nrestitution = 0.6\n" } else { "" };
    let text = format!(
        "name = \"M\"\n[body.a]\nmass = {}\n[body.b]\nmass = {}\n[spring.a]\nbetween = [\"ground\", \"a\"]\nstiffness = {}\n\
         damping = {}\n[spring.b]\nbetween = [\"a\", \"b\"]\nstiffness = {}\ndamping = {}\n{stop}[load.f]\non = \"b\"\n\
         amplitude = {}\nfrequency = {}\n",
        draw(0.5, 2.0),
        draw(0.5, 2.0),
        draw(100.0, 1000.0),
        draw(0.5, 3.0),
        draw(100.0, 1000.0),
        draw(0.5, 3.0),
        draw(1.0, 5.0),
        draw(1.0, 5.0)
    );
    Machine::new(file::parse(&text, "m.toml", &file::no_records).unwrap())
}

/// The multipliers of 200 periodic machines give their exponents. The growth of a variation must
/// mostly give the same exponents within two of its stated errors.
#[test]
fn second_method_errors_of_growth_cover_the_exponents_by_multipliers() {
    /// 95 % of normal errors are within two standard errors; the errors of a periodic growth are
    /// smaller.
    const COVERED: usize = 190;
    let mut seed = 44u64;
    let mut draw = |from: f64, to: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from * (to / from).powf((seed >> 11) as f64 / (1u64 << 53) as f64)
    };
    let (mut machines, mut covered, mut tight) = (0, 0, 0);
    while machines < 200 {
        let machine = machine(&mut draw, machines % 2 == 1);
        let (motion, section) = machine.motion(&Start::default()).unwrap();
        let mut motion = motion.without_energy_accounts();
        discard(&mut motion, &section, 400).unwrap();
        let mut follower = Follower::new(&mut motion, &section);
        let Some(found) = follower.observe().unwrap() else { continue };
        let exact = periodic_exponent(&mut follower, found, 64).unwrap().value;
        let grown = growth(&mut follower, 128, f64::INFINITY).unwrap().exponent();
        machines += 1;
        covered += usize::from((grown.value - exact).abs() <= 2.0 * grown.error);
        tight += usize::from(grown.error < 0.5 * exact.abs());
    }
    assert!(covered >= COVERED, "{covered}");
    assert!(tight > 150, "too few errors below half of the exponent: {tight}");
}

/// States with a class and a period.
fn seen(class: MotionClass, states: &[[f64; 2]]) -> Settled {
    let period = if let MotionClass::Periodic(n) = class { Some(n) } else { None };
    let states = states.iter().map(|state| state.to_vec()).collect();
    let scales = vec![2.0, 10.0];
    Settled {
        period,
        class,
        exponent: None,
        contacts: 0.0,
        rests: false,
        interval: 1.0,
        states,
        scales,
        shift: 0.0,
    }
}

#[test]
fn two_attractors_differ_by_class_period_or_states_beside_their_sizes() {
    use MotionClass::{Chaotic, Periodic, QuasiPeriodic, Settling};
    let one = seen(Periodic(1), &[[1.0, 5.0]]);
    // 1e-3 of the sizes.
    for (state, differs) in
        [([1.0019, 5.0], false), ([1.0021, 5.0], true), ([1.0, 4.9901], false), ([1.0, 4.9899], true)]
    {
        let other = seen(Periodic(1), &[state]);
        assert_eq!((one.differs(&other), other.differs(&one)), (Some(differs), Some(differs)), "{state:?}");
    }
    // The larger of the two motions' sizes counts.
    let mut coarse = seen(Periodic(1), &[[1.01, 5.0]]);
    coarse.scales = vec![20.0, 1.0];
    assert_eq!((one.differs(&coarse), coarse.differs(&one)), (Some(false), Some(false)));
    // A cycle may begin with any of its states, and all states must occur.
    let two = seen(Periodic(2), &[[1.0, 5.0], [3.0, 5.0]]);
    assert_eq!(two.differs(&seen(Periodic(2), &[[3.0, 5.0], [1.0, 5.0]])), Some(false));
    assert_eq!(two.differs(&seen(Periodic(2), &[[3.0, 5.0], [2.0, 5.0]])), Some(true));
    assert_eq!(one.differs(&two), Some(true));
    assert_eq!(one.differs(&seen(Chaotic, &[[1.0, 5.0]])), Some(true));
    assert_eq!(seen(Chaotic, &[]).differs(&seen(Chaotic, &[])), None);
    assert_eq!(seen(QuasiPeriodic, &[]).differs(&seen(Chaotic, &[])), Some(true));
    assert_eq!((one.differs(&seen(Settling, &[])), seen(Settling, &[]).differs(&one)), (None, None));
    let shifted = Settled { shift: 0.1, ..one.clone() };
    assert_eq!(one.differs(&shifted), None);
}

#[test]
fn closed_form_what_is_said_of_the_impact_pair() {
    let (mut motion, section) = example("impact_pair.toml").motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 60).unwrap();
    let found = settled(&mut motion, &section, None).unwrap();
    assert_eq!((found.period, found.class, found.exponent), (Some(1), MotionClass::Periodic(1), None));
    assert!((found.contacts, found.rests, found.shift) == (2.0, false, 0.0), "{found:?}");
    assert!((found.interval - TAU).abs() < 1e-9);
    // Elongations and rates of two stops, at the section: the start.
    let expected = [0.7915487657, 1.5055739531 - 1.0];
    let [state] = &found.states[..] else { panic!("{found:?}") };
    assert_eq!((state.len(), found.scales.len()), (4, 4));
    for (found, expected) in state.iter().zip([-expected[0], expected[1], expected[0], -expected[1]]) {
        assert!((found.abs() - f64::abs(expected)).abs() < 1e-8, "{state:?}");
    }
}

/// An oscillator whose distance from its orbit shrinks by the factor e^(-0.4) per return.
#[test]
fn closed_form_a_motion_is_followed_until_it_has_settled_and_no_longer_than_asked() {
    let of = |returns: u32| {
        let (mut motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
        discard(&mut motion, &section, returns).unwrap();
        (motion.time() / 0.2).round() as u32
    };
    assert_eq!((of(0), of(1), of(10), of(30)), (0, 1, 10, 30));
    // A settled motion is followed only as long as needed to recognize it: four returns, the
    // returns between two checks, and a period.
    let (mut motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 100).unwrap();
    let from = motion.time();
    assert_eq!(settled(&mut motion, &section, None).unwrap().period, Some(1));
    assert!((0.8..2.0).contains(&(motion.time() - from)), "{}", motion.time() - from);
    // It returns to 1e-9 of its size after about 50 returns. Four such returns are needed, and
    // checks are four apart.
    assert!((48..80).contains(&of(400)), "{}", of(400));
}

#[test]
fn closed_form_exponents_by_multipliers_say_their_period_and_error() {
    let (mut motion, section) = text(OSCILLATOR).motion(&Start::default()).unwrap();
    let found = settled(&mut motion, &section, Some(16)).unwrap();
    let exponent = found.exponent.unwrap();
    assert!((exponent.value + 2.0).abs() < 1e-9 && exponent.error < 1e-9, "{exponent:?}");
    assert_eq!((exponent.periods, found.states.len()), (1, 1));
    // The same motion observed three times per period: one of the states agrees.
    let machine = Machine { section: SectionRule::Period(0.2 / 3.0), ..text(OSCILLATOR) };
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    let thirds = settled(&mut motion, &section, Some(16)).unwrap();
    assert_eq!((thirds.class, thirds.states.len()), (MotionClass::Periodic(3), 3));
    assert!((thirds.interval - 0.2 / 3.0).abs() < 1e-12);
    let exponent = thirds.exponent.unwrap();
    assert!((exponent.value + 2.0).abs() < 1e-9 && exponent.periods == 3, "{exponent:?}");
    // One of the three states is the state at whole periods; the cosines and sines of phases come
    // after it.
    let whole = &found.states[0];
    let is_whole = |state: &Vec<f64>| whole.iter().zip(state).all(|(a, b)| (a - b).abs() < 1e-8);
    assert!(thirds.states.iter().any(is_whole), "{whole:?} {:?}", thirds.states);
}

/// Next to its doubling a ball approaches its 1T motion from alternating sides: an apparent 2T
/// motion is still on its way.
#[test]
fn closed_form_what_comes_nearer_from_two_sides_is_no_doubled_period() {
    let (mut motion, section) = crate::tests::verdicts::ball(0.605e-3).motion(&Start::default()).unwrap();
    let mut follower = Follower::new(&mut motion, &section);
    follower.begin();
    let (mut seemed, mut found) = (0, None);
    for _ in 0..3000 {
        follower.advance().unwrap();
        follower.next_look = 0;
        seemed += u32::from(follower.record.period(RETURN) == Some(2));
        found = follower.period(RETURN).unwrap();
        if found.is_some() {
            break;
        }
    }
    assert!(seemed > 0, "it never seemed 2T");
    assert_eq!(found.map(|found| found.0), Some(1));
}
