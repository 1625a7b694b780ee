//! Many motions at a time against one at a time (second method: the same bits), and simulators made from one another.

use vibro_impact::simulator::{Loads, advance_together};
use vibro_impact::{Error, Groups, Parameters, Scales, Simulator, State};

fn weak(kappa: f64, drive: f64) -> Parameters {
    Groups::weak(0.1, kappa, drive, 0.0, 0.4, 0.2, 0.0, 0.4).to_parameters(Scales::default()).expect("valid")
}

fn start(place: f64) -> State {
    State { x: [0.0, place, 0.0], v: [0.0, 0.5, 0.0] }
}

/// Motions of all kinds: impacts, rest, no impacts at all, accounts kept, loads.
fn motions() -> Vec<Simulator> {
    let mut all = Vec::new();
    for (i, (kappa, drive)) in
        [(0.75, 1.5), (0.0, 3.0), (0.6, 0.1), (0.9, 4.0), (0.3, 2.0), (1.0, 1.0)].into_iter().enumerate()
    {
        for place in [0.9, -0.4, 1.0] {
            let s = Simulator::new(&weak(kappa, drive), &start(place), 0.1 * i as f64).expect("valid");
            all.push(if i % 3 == 2 { s } else { s.without_ledger() });
        }
    }
    let mut derivatives = [[0.0; 4]; 3];
    derivatives[1] = [0.02, 0.001, 0.0, 0.0];
    all[4].set_loads(&Loads { derivatives }).expect("valid");
    all
}

#[test]
fn second_method_together_gives_the_bits_of_one_by_one() {
    let (mut together, mut alone) = (motions(), motions());
    for end in [0.7, 40.0, 400.0] {
        for (s, result) in alone.iter_mut().zip(advance_together(&mut together, |_| end)) {
            assert_eq!(result, s.advance_to(end));
        }
        for (i, (s, t)) in alone.iter().zip(&together).enumerate() {
            assert_eq!(s.snapshot(), t.snapshot(), "motion {i} at {end}");
        }
    }
}

#[test]
fn one_that_fails_leaves_the_others_alone() {
    let mut late = Simulator::new(&weak(0.75, 1.5), &start(0.9), 50.0).expect("valid");
    let before = late.snapshot();
    let mut all = vec![late.clone().without_ledger(), motions().remove(0)];
    let results = advance_together(&mut all, |_| 20.0);
    assert_eq!(results[0], Err(Error::Step { time: 50.0, end: 20.0 }));
    assert_eq!(results[1], Ok(()));
    assert_eq!(all[0].snapshot(), before);
    assert_eq!(all[1].time(), 20.0);
    assert!(
        late.advance_to(f64::NAN).is_err()
            && advance_together(&mut all, |_| f64::NAN).iter().all(Result::is_err)
    );
}

#[test]
fn second_method_another_of_the_same_system_is_a_new_one() {
    let p = weak(0.75, 1.5);
    let mut first = Simulator::new(&p, &start(0.9), 0.0).expect("valid");
    first.advance_to(30.0).expect("it arrives");
    first.set_loads(&Loads { derivatives: [[0.1; 4]; 3] }).expect("valid");
    let mut other = first.another(&start(-0.2), 3.0).expect("valid");
    let mut new = Simulator::new(&p, &start(-0.2), 3.0).expect("valid");
    assert_eq!(other.snapshot(), new.snapshot());
    other.advance_to(60.0).expect("it arrives");
    new.advance_to(60.0).expect("it arrives");
    assert_eq!(other.snapshot(), new.snapshot());
    assert_eq!(*other.work(), *new.work());
    // What the other does to its tables is its own affair.
    let before = first.clone();
    other.set_parameters(&weak(0.5, 2.0)).expect("valid");
    first.advance_to(60.0).expect("it arrives");
    let mut again = before;
    again.advance_to(60.0).expect("it arrives");
    assert_eq!(first.snapshot(), again.snapshot());
    assert!(matches!(first.another(&start(1.5), 0.0), Err(Error::Penetration { .. })));
    assert!(matches!(first.another(&start(0.5), f64::INFINITY), Err(Error::OutOfRange { name: "time", .. })));
}
