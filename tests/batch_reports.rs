//! Reports of vectorised motions compared with single motions (second method), and with the same
//! motions among others (invariant).

mod common;

use common::golden::{distance, weak};
use std::ops::ControlFlow;
use vibro_impact::model::Augmented;
use vibro_impact::simulator::{
    DueEvent, Event, Loads, Maximum, MotionQueue, Pause, Plan, Reports, advance_queue, advance_together,
};
use vibro_impact::{Error, Parameters, Result, Simulator, State};

/// Motions with impacts, chatter, rest and without any of these, for several systems; three
/// motions share each system.
fn motions() -> Vec<Simulator> {
    let systems =
        [(0.75, 1.5), (0.0, 3.0), (0.6, 0.1), (0.9, 4.0), (0.3, 2.0), (1.0, 1.0), (0.2, 3.0), (0.0, 1.5)];
    let motion = |(kappa, drive), place| {
        let start = State { x: [0.0, place, 0.0], v: [0.0, 0.5, 0.0] };
        let p = Parameters { drive_phase: 0.3, ..weak(kappa, drive) };
        Simulator::new(&p, &start, 2.0).expect("valid").without_energy_accounts()
    };
    systems.into_iter().flat_map(|system| [0.9, -0.4, 1.0].map(|place| motion(system, place))).collect()
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Record {
    samples: Vec<(u32, State)>,
    events: Vec<Event>,
    after: Vec<Augmented>,
    maxima: Vec<Maximum>,
    ended: Option<Result<()>>,
}

/// Queue of motions in a given order, which records their reports.
struct Recorder {
    order: Vec<usize>,
    end: f64,
    reports: Reports,
    /// Index of the sample that ends a motion.
    last: u32,
    /// Difference between the numbers of two samples.
    stride: u32,
    /// Index of the event that requests samples.
    asking: usize,
    under_way: [usize; vibro_impact::simulator::TOGETHER],
    records: Vec<Record>,
}

impl MotionQueue for Recorder {
    fn next(&mut self, lane: usize, _: &mut [Simulator], ended: Option<Result<()>>) -> Option<Plan> {
        if ended.is_some() {
            self.records[self.under_way[lane]].ended = ended;
        }
        self.under_way[lane] = self.order.pop()?;
        Some(Plan { simulator: self.under_way[lane], end: self.end, reports: Some(self.reports) })
    }

    fn sample(&mut self, lane: usize, number: u32, state: &State) -> ControlFlow<(), u32> {
        let record = &mut self.records[self.under_way[lane]];
        record.samples.push((number, *state));
        if number >= self.last { ControlFlow::Break(()) } else { ControlFlow::Continue(number + self.stride) }
    }

    fn event(&mut self, lane: usize, event: &Event, after: &Augmented) -> Option<u32> {
        let record = &mut self.records[self.under_way[lane]];
        record.events.push(*event);
        record.after.push(*after);
        (record.events.len() == self.asking).then_some(1)
    }

    fn maximum(&mut self, lane: usize, maximum: &Maximum) {
        self.records[self.under_way[lane]].maxima.push(*maximum);
    }
}

/// Reports with an origin before the start, so that the first samples have passed.
const REPORTS: Reports = Reports { origin: 0.5, step: 0.7, first: 1, maxima_of: Some([0.0, 1.0, 0.0]) };

fn record(motions: &mut [Simulator], order: Vec<usize>, reports: Reports, end: f64) -> Vec<Record> {
    record_as(motions, order, |recorder| Recorder { end, reports, ..recorder })
}

/// Records the motions with a recorder changed by `settings`.
fn record_as(
    motions: &mut [Simulator],
    order: Vec<usize>,
    settings: impl Fn(Recorder) -> Recorder,
) -> Vec<Record> {
    let records = vec![Record::default(); motions.len()];
    let mut recorder = settings(Recorder {
        order,
        end: 0.0,
        reports: REPORTS,
        last: u32::MAX,
        stride: 1,
        asking: usize::MAX,
        under_way: [0; 16],
        records,
    });
    let used = advance_queue(motions, &mut recorder);
    assert!(
        used.substeps <= used.occupied && used.utilisation() <= used.occupation() && used.occupation() <= 1.0
    );
    recorder.records
}

#[test]
fn invariant_reports_depend_on_nothing_but_the_motion_and_leave_it_alone() {
    const END: f64 = 90.0;
    let mut plain = motions();
    let count = plain.len();
    advance_together(&mut plain, |_| END);
    let mut first = motions();
    let expected = record(&mut first, (0..count).collect(), REPORTS, END);
    for ((with, without), record) in first.iter().zip(&plain).zip(&expected) {
        assert_eq!(with.snapshot(), without.snapshot());
        assert_eq!(record.ended, Some(Ok(())));
        let impacts = record.events.iter().filter(|e| matches!(e, Event::Impact { .. })).count();
        assert_eq!(impacts as u64, with.impacts().upper + with.impacts().lower);
    }
    for step in [1, 5, 7] {
        // Alone, and in another order.
        let order: Vec<usize> = (0..count).map(|i| (i * step + 3) % count).collect();
        let found = if step == 1 {
            let mut found = Vec::new();
            for mut one in motions() {
                found.extend(record(std::slice::from_mut(&mut one), vec![0], REPORTS, END));
            }
            found
        } else {
            record(&mut motions(), order, REPORTS, END)
        };
        assert_eq!(found, expected);
    }
}

#[test]
fn invariant_reports_switch_the_accounts_off_and_have_the_bits_without_them() {
    const END: f64 = 90.0;
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let accounts = Simulator::new(&weak(0.75, 1.5), &start, 0.0).expect("valid");
    let mut plain = [accounts.clone().without_energy_accounts()];
    let mut reported = [accounts];
    advance_together(&mut plain, |_| END);
    record(&mut reported, vec![0], REPORTS, END);
    assert_eq!(reported[0].snapshot(), plain[0].snapshot());
    assert!(plain[0].impacts().upper > 10);
}

/// A single motion, with and without energy accounts.
#[test]
fn invariant_energy_accounts_leave_the_bits_of_the_motion_alone() {
    for (mut without, step) in motions().into_iter().zip([0.013, 0.37, 7.0].into_iter().cycle()) {
        let begin = without.time();
        let mut with = Simulator::new(without.parameters(), &without.state(), begin).expect("valid");
        for n in 1..=100 {
            let end = begin + f64::from(n) * step;
            with.advance_to(end).expect("it arrives");
            without.advance_to(end).expect("it arrives");
            assert_eq!((with.state(), with.contact()), (without.state(), without.contact()));
            assert_eq!(with.impacts(), without.impacts());
        }
        assert!(with.energy_accounts().damped > 0.0 && without.energy_accounts().damped == 0.0);
    }
}

/// If an impact or a release is pending, it is the first report of a motion.
#[test]
fn invariant_an_event_that_is_due_is_reported() {
    const END: f64 = 20.0;
    let mut releases = 0;
    for n in 0..motions().len() {
        for pauses in 1..8 {
            let mut one = motions().remove(n);
            for _ in 0..pauses {
                one.advance_until(END, Pause::BeforeEvent, None).expect("it arrives");
            }
            let Some(due) = one.due_event() else { continue };
            let mut expected = Vec::new();
            one.clone().apply_due_event(Some(&mut |event: &Event| expected.push(*event)));
            let time = one.time();
            let found = record(std::slice::from_mut(&mut one), vec![0], REPORTS, END).remove(0);
            assert_eq!(found.events[..expected.len()], expected, "{due:?}");
            assert!(
                found.events.iter().all(|event| !matches!(event, Event::Impact { time: t, .. } if *t < time))
            );
            releases += usize::from(matches!(due, DueEvent::Release { .. }));
        }
    }
    assert!(releases > 2, "{releases}");
}

#[test]
fn second_method_samples_and_events_as_one_by_one() {
    /// Rounding, amplified by some fifteen impacts, in motions whose differences grow little in
    /// that time.
    const DIFFERENCE: f64 = 1e-9;
    const END: f64 = 30.0;
    let records = record(&mut motions(), (0..motions().len()).collect(), REPORTS, END);
    let (mut resting, mut events) = (0, 0);
    for (mut alone, record) in motions().into_iter().zip(&records) {
        let mut expected = Vec::new();
        let numbers: Vec<u32> = record.samples.iter().map(|sample| sample.0).collect();
        assert_eq!(numbers, (3..=42).collect::<Vec<u32>>(), "times 2.6 to 29.9 s");
        for (number, state) in &record.samples {
            let time = REPORTS.origin + f64::from(*number) * REPORTS.step;
            alone.advance_observed(time, &mut |event| expected.push(*event)).expect("it arrives");
            let d = distance(&alone.state(), state, 1.0, 1.0);
            assert!(d < DIFFERENCE, "sample {number}: {d:e}");
            resting += usize::from(alone.contact().side() != 0.0);
        }
        alone.advance_observed(END, &mut |event| expected.push(*event)).expect("it arrives");
        events += expected.len();
        assert_eq!(expected.len(), record.events.len());
        for (expected, found) in expected.iter().zip(&record.events) {
            let numbers = |event: &Event| match *event {
                Event::Impact { time, side, speed, impulse } => (0, time, side, speed, impulse),
                Event::Rest { time, side } => (1, time, side, 0.0, 0.0),
                Event::Release { time, side } => (2, time, side, 0.0, 0.0),
            };
            let (a, b) = (numbers(expected), numbers(found));
            assert_eq!((a.0, a.2), (b.0, b.2));
            let d = (a.1 - b.1).abs().max((a.3 - b.3).abs()).max((a.4 - b.4).abs());
            // The error of an impact's time is the error of w over the speed.
            assert!(d < DIFFERENCE / a.3.clamp(1e-6, 1.0), "{expected:?} {found:?}");
        }
    }
    assert!(resting > 20 && events > 300, "{resting} {events}");
}

#[test]
fn what_cannot_be_reported_is_refused() {
    let loaded = || {
        let mut loaded = motions().remove(0);
        loaded.set_loads(&Loads { derivatives: [[0.1; 4]; 3] }).expect("valid");
        loaded
    };
    let refused = |record: &Record, what: &str| match &record.ended {
        Some(Err(Error::OutOfRange { name, .. })) => assert_eq!(*name, what),
        other => panic!("{other:?}"),
    };
    let mut motions = [loaded(), motions().remove(0)];
    let found = record(&mut motions, vec![1, 0], REPORTS, 20.0);
    refused(&found[0], "box.f");
    assert_eq!((&found[1].ended, motions[1].time(), motions[0].time()), (&Some(Ok(())), 20.0, 2.0));
    for step in [0.0, -1.0, f64::NAN, 1e-12] {
        let found = record(&mut motions[1..], vec![0], Reports { step, ..REPORTS }, 30.0);
        refused(&found[0], "time between samples");
    }
    // Without samples the step has no effect.
    let none = Reports { origin: f64::INFINITY, step: 0.0, first: 1, maxima_of: None };
    let found = record(&mut motions[1..], vec![0], none, 30.0);
    assert!(found[0].samples.is_empty() && found[0].maxima.is_empty() && !found[0].events.is_empty());
}

#[test]
fn invariant_samples_as_asked_for_are_some_of_all() {
    const END: f64 = 60.0;
    let all = || (0..motions().len()).collect::<Vec<usize>>();
    let every = record(&mut motions(), all(), REPORTS, END);
    // Every third sample from the fifth on, and the end of the motion with sample 29.
    let reports = Reports { first: 5, ..REPORTS };
    let settings = |r| Recorder { end: END, reports, stride: 3, last: 29, ..r };
    for (some, every) in record_as(&mut motions(), all(), settings).iter().zip(&every) {
        let expected: Vec<_> =
            every.samples.iter().filter(|s| s.0 >= 5 && s.0 % 3 == 2 && s.0 <= 29).collect();
        assert_eq!(some.samples.iter().collect::<Vec<_>>(), expected);
        assert_eq!(some.ended, Some(Ok(())));
        // No event is reported for the sub-step of the sample that ended the motion.
        let count = some.events.len();
        assert!(count < every.events.len() || count == 0);
        assert_eq!((&some.events[..], &some.after[..]), (&every.events[..count], &every.after[..count]));
    }
    // No samples before the second event.
    let reports = Reports { first: u32::MAX, ..REPORTS };
    let settings = |r| Recorder { end: END, reports, asking: 2, ..r };
    for (some, every) in record_as(&mut motions(), all(), settings).iter().zip(&every) {
        let Some(Event::Impact { time, .. } | Event::Rest { time, .. } | Event::Release { time, .. }) =
            every.events.get(1)
        else {
            assert!(some.samples.is_empty());
            continue;
        };
        let later = |s: &&(u32, State)| REPORTS.origin + f64::from(s.0) * REPORTS.step > *time;
        assert_eq!(
            some.samples.iter().collect::<Vec<_>>(),
            every.samples.iter().filter(later).collect::<Vec<_>>()
        );
        assert_eq!(some.events, every.events);
    }
}
