//! Pauses before events, application of the event laws after a pause, prediction of the next
//! event.

use vibro_impact::simulator::{AdvanceOutcome, Contact, DueEvent, Event, Loads, Pause, advance_together};
use vibro_impact::{Groups, Parameters, Scales, Simulator, State};

/// Rounding of a few hundred additions: the input energy of a motion with pauses is summed in a
/// different order.
const SUM_ROUNDING: f64 = 1e-12;
/// Tolerance for rounding of the drive's phase: each pause recomputes it, and some tens of impacts
/// of a stable motion amplify the error.
const PHASE_ROUNDING: f64 = 1e-11;

fn start() -> State {
    State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] }
}

fn system(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

fn simulator(p: &Parameters) -> Simulator {
    Simulator::new(p, &start(), 0.0).unwrap()
}

/// Bits of state, record and accounts except the input energy.
fn bits(s: &Simulator) -> Vec<u64> {
    let (state, (w, rate), record) = (s.state(), s.relative_motion(), s.impacts());
    let energy = s.energy_accounts();
    let counts = [record.upper as f64, record.lower as f64];
    let numbers = [s.time(), w, rate, record.last_time, record.last_speed, record.total_impulse];
    let all = [&state.x[..], &state.v, &counts, &numbers, &[energy.damped, energy.impact, energy.mechanical]];
    all.concat().into_iter().map(f64::to_bits).collect()
}

#[test]
fn invariant_pause_and_law_give_the_bits_of_a_stop_after_the_impact() {
    // With small κ the block also comes to rest. The comparison ends at its first release, which
    // is a pause, too.
    for (f10, kappa) in [(1.5, 0.7), (3.5, 0.75), (1.5, 0.0), (1.5, 0.3), (3.0, 1.0)] {
        let p = system(f10, kappa);
        let end = 30.0 * p.period();
        let (mut after, mut before) = (simulator(&p), simulator(&p));
        let (mut impacts, mut releases) = (0, false);
        loop {
            let seen = after.advance_to_impact(end).unwrap();
            let reason = before.advance_until(end, Pause::BeforeEvent, None).unwrap();
            if let Some(DueEvent::Release { side }) = before.due_event() {
                assert_eq!(before.contact().side(), f64::from(side));
                releases = true;
                break; // from here on the two recompute the phase at different times
            }
            assert_eq!(reason == AdvanceOutcome::EventDue, seen == AdvanceOutcome::Impact, "{kappa}");
            if reason == AdvanceOutcome::End {
                break;
            }
            let mut shown = 0;
            let due = before.apply_due_event(Some(&mut |_| shown += 1));
            assert!(matches!(due, Some(DueEvent::Impact { .. })) && shown >= 1);
            assert_eq!(bits(&before), bits(&after), "kappa {kappa} at {}", after.time());
            let input = [&before, &after].map(|s| s.energy_accounts().input);
            assert!((input[0] - input[1]).abs() < SUM_ROUNDING * (1.0 + input[0].abs()), "{input:?}");
            impacts += 1;
        }
        assert!(impacts > 10 || releases, "kappa {kappa}: {impacts}");
    }
}

#[test]
fn invariant_a_pause_changes_nothing_but_round_off() {
    for kappa in [0.0, 0.3, 0.7] {
        let p = system(1.5, kappa);
        let end = 20.0 * p.period();
        let (mut whole, mut paused) = (simulator(&p), simulator(&p));
        let mut events = [0, 0];
        whole.advance_observed(end, &mut |_| events[0] += 1).unwrap();
        while paused.advance_until(end, Pause::BeforeEvent, Some(&mut |_| events[1] += 1)).unwrap()
            == AdvanceOutcome::EventDue
        {
            let (w, rate) = paused.relative_motion();
            let side = f64::from(paused.due_event().unwrap().side());
            assert!(w == side * p.stop_gap && side * rate >= 0.0, "the left limit: {w} {rate}");
        }
        assert_eq!(events[0], events[1]);
        let (a, b) = (whole.state(), paused.state());
        for i in 0..3 {
            let off = (a.x[i] - b.x[i]).abs().max((a.v[i] - b.v[i]).abs());
            assert!(off < PHASE_ROUNDING, "kappa {kappa}: {off:e}");
        }
    }
}

#[test]
fn closed_form_the_left_limit_and_the_law() {
    let p = system(1.5, 0.7);
    let mut s = simulator(&p);
    assert_eq!(s.advance_until(100.0, Pause::BeforeEvent, None).unwrap(), AdvanceOutcome::EventDue);
    let (time, before, (w, rate)) = (s.time(), s.state(), s.relative_motion());
    let mut event = None;
    s.apply_due_event(Some(&mut |e| event = Some(*e)));
    assert_eq!((s.time(), s.due_event()), (time, None));
    let Some(Event::Impact { time: told, side, speed, impulse }) = event else { panic!("{event:?}") };
    let side = f64::from(side);
    assert_eq!((told, w, speed), (time, side * p.stop_gap, side * rate));
    assert_eq!(s.relative_motion().1, -p.stop_restitution * rate);
    let push = [impulse, -impulse].map(|i| side * i);
    for (body, mass) in [p.box_mass, p.block_mass].into_iter().enumerate() {
        let gained = mass * (s.state().v[body] - before.v[body]);
        assert!((gained - push[body]).abs() < 1e-14, "body {body}: {gained} {}", push[body]);
    }
    assert_eq!(s.apply_due_event(None), None);
}

#[test]
fn invariant_a_snapshot_of_a_pause_goes_on_with_the_same_bits() {
    for (kappa, end) in [(0.7, 100.0), (0.0, 300.0)] {
        let p = system(1.5, kappa);
        let mut one = simulator(&p);
        let mut kinds = [false; 2];
        while one.advance_until(end, Pause::BeforeEvent, None).unwrap() == AdvanceOutcome::EventDue {
            kinds[usize::from(one.contact() != Contact::Flight)] = true;
            let mut two = Simulator::new(&system(0.5, 0.9), &State::default(), 0.0).unwrap();
            two.restore(&one.snapshot()).unwrap();
            assert_eq!(two.due_event(), one.due_event());
            let mut three = one.clone();
            two.advance_to(end + 1.0).unwrap();
            three.advance_to(end + 1.0).unwrap();
            assert_eq!(two.snapshot(), three.snapshot());
        }
        assert!(kinds[0] && (kinds[1] || kappa > 0.0));
    }
}

#[test]
fn invariant_a_look_ahead_tells_what_comes_and_changes_nothing() {
    let p = system(1.5, 0.3);
    let mut s = simulator(&p);
    for _ in 0..40 {
        let before = s.snapshot();
        let work = *s.work_counters();
        let ahead = s.next_event(1e3).unwrap().expect("events without end");
        assert!(s.snapshot() == before && *s.work_counters() == work);
        assert_eq!(s.next_event(s.time()).unwrap(), None);
        assert_eq!(s.advance_until(1e3, Pause::BeforeEvent, None).unwrap(), AdvanceOutcome::EventDue);
        assert_eq!(s.next_event(s.time()).unwrap(), Some(ahead), "what is due is next");
        let mut first = None;
        s.apply_due_event(Some(&mut |e| first = first.or(Some(*e))));
        assert_eq!(first, Some(ahead));
    }
}

#[test]
fn invariant_a_pause_in_an_advance_counts_as_its_first_impact() {
    let p = system(1.5, 0.7);
    let mut s = simulator(&p);
    s.advance_until(100.0, Pause::BeforeEvent, None).unwrap();
    let time = s.time();
    assert!(s.advance_to(time - 0.1).is_err() && s.due_event().is_some(), "an error applies nothing");
    assert_eq!(s.advance_to_impact(100.0).unwrap(), AdvanceOutcome::Impact);
    assert_eq!((s.time(), s.due_event()), (time, None));
    // An advance of zero length also applies the due event.
    s.advance_until(100.0, Pause::BeforeEvent, None).unwrap();
    let count = s.impacts().upper + s.impacts().lower;
    s.advance_to(s.time()).unwrap();
    assert_eq!((s.due_event(), s.impacts().upper + s.impacts().lower), (None, count + 1));
}

#[test]
fn closed_form_changes_while_an_event_is_due() {
    let p = system(1.5, 0.7);
    let mut s = simulator(&p);
    s.advance_until(100.0, Pause::BeforeEvent, None).unwrap();
    let (due, rate) = (s.due_event(), s.relative_motion().1);
    // The law uses the new restitution.
    s.set_parameters(&Parameters { stop_restitution: 0.25, ..p }).unwrap();
    s.set_loads(&Loads { derivatives: [[0.1, 0.0, 0.0, 0.0]; 3] }).unwrap();
    assert_eq!(s.due_event(), due);
    s.apply_due_event(None);
    assert_eq!(s.relative_motion().1, -0.25 * rate);
    // A wider gap: the block no longer touches the stop.
    s.set_parameters(&p).unwrap();
    s.advance_until(200.0, Pause::BeforeEvent, None).unwrap();
    assert!(s.due_event().is_some());
    s.set_parameters(&Parameters { stop_gap: 1.5 * p.stop_gap, ..p }).unwrap();
    assert_eq!((s.due_event(), s.contact()), (None, Contact::Flight));
    // A release is cancelled by a load that presses the block.
    let mut s = simulator(&system(1.5, 0.0));
    while !matches!(s.due_event(), Some(DueEvent::Release { .. })) {
        s.advance_until(1e3, Pause::BeforeEvent, None).unwrap();
    }
    let side = s.contact().side();
    let mut loads = Loads::default();
    loads.derivatives[1][0] = side;
    s.set_loads(&loads).unwrap();
    assert_eq!((s.due_event(), s.contact().side()), (None, side));
}

#[test]
fn invariant_energies_balance_and_each_pause_has_its_event_over_a_thousand_pauses() {
    /// Rounding of a thousand sums, relative to the largest energy.
    const BALANCE: f64 = 1e-11;
    /// Largest number of pauses at one instant, e.g. an impact that ends in rest, and the release.
    const AT_ONE_TIME: u32 = 3;
    for (f10, kappa) in [(3.0, 0.0), (3.0, 0.1), (1.5, 0.75), (1.5, 1.0)] {
        for force in [[0.0; 4], [-0.02, 1e-5, 0.0, 0.0]] {
            let p = system(f10, kappa);
            let mut s = simulator(&p);
            s.set_loads(&Loads { derivatives: [[0.0; 4], force, [0.0; 4]] }).unwrap();
            let first = s.energy_accounts().mechanical;
            let (mut largest, mut last, mut same, mut shown) = (first, -1.0, 0, 0);
            for pause in 0..1000 {
                let mut laws = 0;
                let mut count = |event: &Event| laws += u32::from(!matches!(event, Event::Rest { .. }));
                let reason = s.advance_until(2000.0, Pause::BeforeEvent, Some(&mut count)).unwrap();
                assert_eq!(laws, u32::from(pause > 0), "each return has one law to apply");
                shown += 1;
                if reason == AdvanceOutcome::End {
                    break;
                }
                same = if s.time() == last { same + 1 } else { 0 };
                last = s.time();
                assert!(same < AT_ONE_TIME, "kappa {kappa}: no way on from t = {last}");
                let e = s.energy_accounts();
                largest = e.mechanical.max(e.input.abs()).max(largest);
                let error = e.mechanical - first - e.input + e.damped + e.impact;
                assert!(error.abs() < BALANCE * largest, "kappa {kappa}, pause {pause}: {error:e}");
            }
            assert!(shown > 200, "kappa {kappa}: {shown}");
        }
    }
}

#[test]
fn invariant_the_time_told_is_the_events_but_for_its_rounding() {
    // The predicted time is a double, so an advance to it may end just before the event. An
    // advance to a later end then pauses at the event.
    for kappa in [0.0, 0.3, 0.75] {
        let mut s = simulator(&system(1.5, kappa));
        for _ in 0..100 {
            let told = s.next_event(1e4).unwrap().expect("events without end");
            let (Event::Impact { time, .. } | Event::Release { time, .. } | Event::Rest { time, .. }) = told;
            if s.advance_until(time, Pause::BeforeEvent, None).unwrap() == AdvanceOutcome::End {
                assert_eq!(s.advance_until(1e4, Pause::BeforeEvent, None).unwrap(), AdvanceOutcome::EventDue);
            }
            assert_eq!(s.time(), time);
            let mut first = None;
            s.apply_due_event(Some(&mut |event| first = first.or(Some(*event))));
            assert!(first.is_some());
        }
    }
}

#[test]
fn second_method_the_lanes_take_the_ends_that_one_by_one_takes() {
    // `time()` is the double-double time of the simulator, rounded to a double in either
    // direction. The next double below it is accepted as an end, too.
    let mut s = simulator(&system(1.5, 0.75)).without_energy_accounts();
    for _ in 0..50 {
        s.advance_until(1e4, Pause::BeforeEvent, None).unwrap();
        for due in [true, false] {
            if !due {
                s.apply_due_event(None);
            }
            for end in [s.time().next_down(), s.time(), s.time().next_up(), 0.5 * s.time()] {
                let (mut alone, mut together) = (s.clone(), [s.clone()]);
                let result = alone.advance_to(end);
                assert_eq!(advance_together(&mut together, |_| end), [result]);
                assert_eq!(together[0].snapshot(), alone.snapshot(), "{end}");
            }
        }
    }
}
