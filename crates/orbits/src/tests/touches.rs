//! Orbits whose impacts have almost zero speed, and the ends of branches where the speed vanishes.

use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use vibro_machine::Start;

/// Largest sum of a period's impulses on a free body, relative to the largest impulse: rounding.
const BALANCE: f64 = 1e-9;
/// Smallest impulse of an actual impact, relative to the largest of its branch.
const IMPULSE: f64 = 1e-9;
/// Distance between the ends of two branches at one touch, m; rounding of a depth is its square.
const ONE_TOUCH: f64 = 1e-11;
/// Largest multipliers of a touch in `path`.
const LIMITED: f64 = 1e8;

/// A ball without friction between the stops of a shaken machine.
pub(super) fn energy_sink(frequency: f64) -> Machine {
    machine(&format!(
        "name = \"Sink\"\nbody.base = {{ motion = {{ amplitude = 5e-4, frequency = {frequency} }} }}\n\
         body.machine = {{ mass = 3.807 }}\nbody.ball = {{ mass = 0.15, start = {{ v = 0.3 }} }}\n\
         spring.mount = {{ between = [\"base\", \"machine\"], stiffness = 11680.0, damping = 3.02 }}\n\
         stop.right = {{ between = [\"machine\", \"ball\"], gap = 0.015, restitution = 0.6 }}\n\
         stop.left = {{ between = [\"ball\", \"machine\"], gap = 0.015, restitution = 0.6 }}\n"
    ))
}

/// The impulses of a period on the ball, to the right.
fn impulses(orbit: &Orbit) -> Vec<f64> {
    let of = |event: &vibro_machine::motion::Event| match event.kind {
        vibro_machine::motion::EventKind::Impact { stop, impulse, .. } => {
            Some(if stop == 0 { -impulse.abs() } else { impulse.abs() })
        }
        _ => None,
    };
    orbit.events().iter().filter_map(of).collect()
}

/// Only the stops act on the ball: the impulses of a period balance, so both stops are hit. If the
/// speed of one impact vanishes, so does the other one, and the branch ends.
#[test]
fn invariant_impulses_of_every_orbit_next_to_a_double_touch_balance() {
    let family = Family::new(&energy_sink(8.8), "body.base.motion.frequency", (8.65, 8.72)).unwrap();
    let branches = grown(&family, 6, 2);
    let mut touches = 0;
    for branch in &branches {
        let plain = branch.points.iter().filter(|p| p.special.is_none());
        let all: Vec<Vec<f64>> = plain.map(|p| impulses(&branch.orbit(p).unwrap())).collect();
        let size = all.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        for own in &all {
            assert!(own.iter().sum::<f64>().abs() < BALANCE * size, "branch {}: {own:?}", branch.id);
            assert!(own.iter().all(|x| x.abs() > IMPULSE * size), "branch {}: {own:?}", branch.id);
        }
        for touch in
            branch.points.iter().filter(|p| p.special.as_ref().is_some_and(|s| s.label.name() == "GR"))
        {
            let largest = touch.multipliers[0].norm();
            assert!(largest < LIMITED, "{}: {largest:e}", touch.value);
            touches += 1;
        }
    }
    assert!(touches > 0 && branches.len() < 4, "{touches} touches on {} branches", branches.len());
}

#[test]
fn an_orbit_without_a_balance_of_impulses_is_not_found() {
    // Newton's method converges to a ball that stays where it just touches the stop.
    for frequency in [8.2, 8.6, 9.0, 9.6] {
        let m = energy_sink(frequency);
        let place = Place::new(m.description.clone()).unwrap();
        let word = Some(WantedWord::parse("impact left", &place.assembly).unwrap());
        let period = Some(WantedPeriod::Drive(1));
        let request = WordSearch { start: Start::default(), word, period, starts: 8, discard: 100 };
        let asked = AtomicUsize::new(0);
        let count = || asked.fetch_add(1, Ordering::Relaxed) < usize::MAX;
        let error = Orbit::search(&m, &request, &count).unwrap_err().to_string();
        assert!(error.contains("no orbit with the events [impact left]"), "{error}");
        // A search without a result examines every return that its progress counts.
        assert_eq!(asked.into_inner(), request.most_returns());
    }
}

/// If a block sticks where it just touches its buffer, there is no orbit with a press of zero
/// depth: the branch continues with the motion beyond.
#[test]
fn invariant_a_branch_continues_where_a_sticking_block_touches_its_buffer() {
    let m = example("damper_with_buffer.toml");
    let family = Family::new(&m, "stop.steel.gap", (1.635e-3, 1.66e-3)).unwrap();
    let branches = grown(&family, 1, 0);
    let first = &branches[0];
    let touch = first.points.iter().find(|p| p.special.as_ref().is_some_and(|s| s.element == "stop.buffer"));
    let touch = touch.unwrap().value;
    let further: Vec<&Branch> = branches.iter().filter(|b| b.word().len() > first.word().len()).collect();
    let ends = further.iter().flat_map(|b| [b.points.first(), b.points.last()]).flatten();
    let apart = ends.map(|p| (p.value - touch).abs()).fold(f64::INFINITY, f64::min);
    assert!(apart < ONE_TOUCH, "{apart:e} from {touch}");
}

/// The turn of an asymmetric branch is the crossing on the symmetric branch.
#[test]
fn second_method_a_crossing_is_the_turn_of_the_branch_that_crosses() {
    /// Distance between points refined by their own condition on both branches.
    const ONE_POINT: f64 = 1e-11;
    let family = Family::new(&energy_sink(8.8), "body.base.motion.frequency", (8.38, 8.42)).unwrap();
    let branches = grown(&family, 4, 1);
    let of = |branch: &Branch| {
        let own = branch.points.iter().filter(|p| p.special.as_ref().is_some_and(|s| s.label.name() == "BP"));
        own.map(|p| p.value).collect::<Vec<_>>()
    };
    let all: Vec<Vec<f64>> = branches.iter().map(of).filter(|own| !own.is_empty()).collect();
    assert!(all.len() > 1, "{all:?}");
    let turns = |branch: &Branch| {
        let least = branch.points.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
        branch.points.iter().find(|p| p.value == least).is_some_and(|p| p.special.is_some())
    };
    assert!(branches.iter().any(turns));
    let first = all[0][0];
    assert!(all.iter().flatten().all(|x| (x - first).abs() < ONE_POINT), "{all:?}");
}
