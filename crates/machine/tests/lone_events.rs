//! Events of a single element, which are handled directly, against the general law.

use crate::common::both_laws::{BothLaws, on_machines};
use crate::common::machines::assembly;
use std::cell::Cell;

/// Difference of the two solutions relative to the largest coordinate: rounding of an impulse,
/// magnified by the ratio of the heaviest mass to the lightest, 1e4.
const ROUNDING: f64 = 1e-12;
const BOTH: BothLaws = BothLaws { events: 300, end: 4.0, rounding: ROUNDING };

#[test]
fn second_method_events_of_one_element_by_the_general_law() {
    let [events, same] = [Cell::new(0), Cell::new(0)];
    on_machines(&assembly(), 300, |start| {
        BOTH.follow(start, |handled| {
            events.set(events.get() + 1);
            same.set(same.get() + usize::from(handled.direct.save() == handled.general.save()));
            Ok(())
        })
    });
    println!("{} of {} events without a bit of difference", same.get(), events.get());
    assert!(events.get() > 3000, "{}", events.get());
}
