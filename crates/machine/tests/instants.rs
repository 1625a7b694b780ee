//! Rows, starts and solver points within rounding of a time event are treated as after the event.

use crate::blocks::column;
use crate::common::*;
use std::sync::Arc;
use vibro_machine::{Assembly, Motion, Start};

/// Counts samples: y of sample k = 0, 1, … is k; a load steps at a separate time.
fn counting(period: f64, delay: f64, step: f64) -> String {
    format!(
        r#"
        name = "Counter"
        body.cart = {{ mass = 1.0 }}
        spring.k = {{ between = ["ground", "cart"], stiffness = 10.0 }}
        load.push = {{ on = "cart", steps = [[{step:?}, 5.0]] }}
        signal.one = {{ constant = 1.0 }}
        [block.count]
        inputs = ["one"]
        states = 1
        a = [[1.0]]
        b = [[1.0]]
        c = [[1.0]]
        outputs = ["y"]
        sample = {period:?}
        delay = {delay:?}
    "#
    )
}

/// A time in the forms that programs compute: products, sums, fractions of the end, decimal text.
fn spellings(k: u32, period: f64, sums: &mut f64) -> [f64; 4] {
    let share = 0.8 * (f64::from(k) * period / 0.8);
    *sums += if k == 0 { 0.0 } else { period };
    let text = format!("{:.9}", f64::from(k) * period).parse().unwrap();
    [f64::from(k) * period, *sums, share, text]
}

#[test]
fn closed_form_a_row_at_a_sample_shows_it_however_its_time_is_rounded() {
    let (mut below, mut all) = (0, 0);
    for period in [1e-3, 3e-3, 0.7e-3, 1.0 / 3.0 * 1e-2] {
        let assembly = assembled(&counting(period, 0.0, 9.0));
        let (mut motions, mut sums) = ([(); 4].map(|()| Motion::new(assembly.clone()).unwrap()), 0.0);
        for k in 0..300 {
            for (m, time) in motions.iter_mut().zip(spellings(k, period, &mut sums)) {
                let exact = f64::from(k) * period;
                // Sums of many rounded terms are off by more than one rounding.
                if (time - exact).abs() > 4.0 * f64::EPSILON * exact {
                    continue;
                }
                below += u32::from(time < exact);
                all += 1;
                m.advance_to(time).unwrap();
                assert_eq!(column(m, "count.y"), f64::from(k), "{time:?} of {exact:?}");
                // Advancing to the same time again is not an error.
                m.advance_to(time).unwrap();
            }
        }
    }
    assert!(below > 100 && all > 3000, "{below} of {all}");
}

/// Delayed outputs and steps of signals are on the later side too, both at starts and at rows.
#[test]
fn closed_form_delays_knots_and_starts_are_on_the_same_side() {
    let down = |x: f64| f64::from_bits(x.to_bits() - 1);
    for k in 1..200u32 {
        let time = f64::from(k) * 0.01 + 0.003;
        let assembly = assembled(&counting(0.01, 0.003, time));
        let acts = assembly.system().blocks[0].sampler.as_ref().unwrap().time_of_acting(i64::from(k));
        for row in [down(time.min(acts)), time, acts] {
            let mut m = Motion::new(assembly.clone()).unwrap();
            m.advance_to(row).unwrap();
            assert_eq!(column(&m, "count.y"), f64::from(k), "{row:?}");
            assert_eq!(column(&m, "push.f"), 5.0, "{row:?}");
        }
        // Further before the time they have not acted yet.
        let mut m = Motion::new(assembly.clone()).unwrap();
        m.advance_to(time * (1.0 - 1e-14)).unwrap();
        assert_eq!([column(&m, "count.y"), column(&m, "push.f")], [f64::from(k - 1), 0.0]);
        let mut start = Start::default();
        start.set(&assembly.description, "time", down(time)).unwrap();
        assert_eq!(column(&start.motion(assembly.clone()).unwrap(), "push.f"), 5.0);
    }
}

/// A solver that stops at multiples of 3 ms is never asked for a step as short as rounding. It
/// learns of the samples at multiples of 2 ms, and of outputs 0.7 ms later, at its own points.
#[test]
fn invariant_no_time_event_is_within_rounding_behind_a_point_of_a_solver() {
    let assembly: Arc<Assembly> = assembled(&counting(2e-3, 0.7e-3, 0.3));
    for interval in [0.5e-3, 1e-3, 2e-3, 3e-3] {
        let mut m = Motion::new(assembly.clone()).unwrap();
        let mut course = m.begin_course().unwrap();
        let (mut k, mut handled) = (1u32, 0);
        while k < 300 {
            let output = f64::from(k) * interval;
            let next = m.next_knot_on(&course).unwrap();
            let to = output.min(next);
            assert!(to - m.time() > 1e-9, "{to:?} after {:?}", m.time());
            m.place_at(&course, to);
            if m.accept(&mut course) {
                assert!(m.handle_on(&mut course, &mut |_| ()).unwrap());
                handled += 1;
            }
            k += u32::from(to >= output);
            let acted = ((m.time() - 0.7e-3) / 2e-3 + 1e-9).floor().max(0.0);
            assert_eq!(column(&m, "count.y"), acted, "{:?}", m.time());
        }
        assert!(handled > 100, "{handled}");
    }
}

/// With a delay, nothing of the first sample acts at time 0: a start at rest ignores it, and moves
/// once it acts.
#[test]
fn closed_form_a_start_at_rest_bears_what_acts_at_time_0() {
    let text = r#"
        name = "Rest"
        start = "rest"
        body.cart = { mass = 1.0 }
        spring.k = { between = ["ground", "cart"], stiffness = 100.0 }
        signal.one = { constant = 1.0 }
        load.push = { on = "cart", from = "hold.y", factor = "1 N" }
        [block.hold]
        inputs = ["one"]
        d = [[5.0]]
        outputs = ["y"]
        sample = 1.0
    "#;
    let mut at_once = moving(text);
    let mut later = moving(&format!("{text}\n        delay = 0.25\n"));
    for m in [&mut at_once, &mut later] {
        m.advance_to(0.2).unwrap();
    }
    near(column(&at_once, "cart.s"), 0.05, 1e-16);
    assert_eq!([column(&later, "cart.s"), column(&later, "hold.y")], [0.0, 0.0]);
    later.advance_to(0.45).unwrap();
    near(column(&later, "cart.s"), 0.05 * (1.0 - 2.0f64.cos()), 1e-14);
}
