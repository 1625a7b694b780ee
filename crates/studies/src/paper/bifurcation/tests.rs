use super::*;
use crate::diagram::diagram;
use crate::paper::find_group;
use crate::paper::plane::ParameterAxis;
use crate::parts::{PartStore, Task};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Store that asks to stop after a number of values of the chains.
struct Impatient {
    asked: AtomicUsize,
    most: usize,
}

impl PartStore for Impatient {
    fn load(&self, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: usize, _: &[u8]) -> Result<()> {
        panic!("a part was computed after the store had ended the study")
    }

    fn go_on(&self) -> Result<()> {
        match self.asked.fetch_add(1, Ordering::Relaxed) {
            asked if asked < self.most => Ok(()),
            _ => Err(Error::store(std::io::Error::other("nobody waits"))),
        }
    }
}

#[test]
fn a_store_ends_the_chains_of_both_directions_between_two_values() {
    let axis = ParameterAxis::new(find_group("f10").unwrap(), (1.0, 2.0), 500).unwrap();
    let sweep = Sweep::new(axis, Displacement::X2, (5, 5));
    let store = Impatient { asked: AtomicUsize::new(0), most: 20 };
    let found = diagram(&ParameterSet::basic(), &sweep, &Task { store: &store, ..Task::ALL });
    assert!(matches!(found, Err(Error::Store(_))), "{found:?}");
    // Each direction asks once more and is refused.
    assert_eq!(store.asked.into_inner(), store.most + 2);
}

#[test]
fn second_method_rows_next_to_a_doubling_have_the_class_of_their_orbit() {
    // The stable orbit there has one drive period and a multiplier -0.9973: after these periods
    // two in a row differ by 4e-4.
    let axis = ParameterAxis::new(find_group("f10").unwrap(), (2.8, 2.81), 2).unwrap();
    let sweep = Sweep::new(axis, Displacement::X2, (1500, 10));
    let found = diagram(&ParameterSet::basic(), &sweep, &Task::ALL).unwrap().unwrap();
    let first = found.up[0].as_ref().unwrap();
    assert_eq!(first.class, MotionClass::Periodic(1), "{:?}", first.attractor.period);
}

#[test]
fn second_method_next_to_a_doubling_there_is_one_orbit_in_both_directions() {
    // The orbit of one drive period loses its stability at 2.8022; motions leave or approach it
    // over thousands of periods.
    let axis = ParameterAxis::new(find_group("f10").unwrap(), (2.8, 2.805), 51).unwrap();
    let sweep = Sweep::new(axis, Displacement::X2, (400, 800));
    let found = diagram(&ParameterSet::basic(), &sweep, &Task::ALL).unwrap().unwrap();
    for point in found.up.iter().chain(&found.down).flatten() {
        let allowed = [MotionClass::Periodic(1), MotionClass::Periodic(2), MotionClass::Settling];
        assert!(allowed.contains(&point.class), "{}: {:?}", point.value, point.class);
    }
    // A motion that is still settling is not on an attractor that could be another one.
    assert!(found.hysteresis().iter().all(|apart| !apart), "{:?}", found.hysteresis());
}

#[test]
fn diagrams_that_do_not_fit_are_refused_before_the_work_with_the_number_that_fits() {
    let group = find_group("f10").unwrap();
    let refused = |count, discard, keep| {
        let axis = ParameterAxis::new(group, (1.0, 2.0), count).unwrap();
        let sweep = Sweep::new(axis, Displacement::X2, (discard, keep));
        match diagram(&ParameterSet::basic(), &sweep, &Task::ALL).unwrap_err() {
            error @ Error::TooMany { most, .. } => {
                assert!(error.to_string().contains(&format!("at most {most}")), "{error}");
                (sweep, most)
            }
            other => panic!("{other}"),
        }
    };
    let (sweep, most) = refused(usize::MAX, 400, 800);
    assert!(most > 2000);
    let set = ParameterSet::basic();
    let with = |count| Sweep { axis: ParameterAxis { count, ..sweep.axis }, ..sweep.clone() };
    assert!(with(most).check(&set).is_ok() && with(most + 1).check(&set).is_err());
    // A record too long for its values, and more periods than can be counted.
    assert!(refused(2000, 400, u32::MAX - 400).1 < 2000);
    assert_eq!(refused(2, 1, u32::MAX).1, u32::MAX as usize);
}
