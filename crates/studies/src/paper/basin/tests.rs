use super::*;
use crate::basin::basins;
use crate::paper::find_group;
use crate::parts::Task;

fn axis(coordinate: usize, from: f64, to: f64, count: usize) -> StartAxis {
    StartAxis { name: COORDINATES[coordinate].into(), from, to, count }
}

#[test]
fn axes_without_width_or_cells_are_refused() {
    let good = axis(0, -1.0, 1.0, 4);
    let bad = [
        axis(4, 1.0, 1.0, 4),
        axis(4, 1.0, -1.0, 4),
        axis(4, f64::NAN, 1.0, 4),
        axis(4, 0.0, f64::INFINITY, 4),
        axis(4, 0.0, 1.0, 0),
    ];
    for y in bad {
        for (x, y) in [(good.clone(), y.clone()), (y, good.clone())] {
            let request = BasinRequest { x, y, discard: 1, start: in_the_middle() };
            let error = basins(&ParameterSet::basic(), &request, &Task::ALL).unwrap_err();
            assert!(error.to_string().contains("v2="), "{error}");
        }
    }
}

/// A motion of period one through a state.
fn motion(x: f64) -> Followed {
    Followed {
        class: MotionClass::Periodic(1),
        attractor: Attractor {
            period: Some(1),
            approaching: false,
            impacts: [1.0; 2],
            rests: false,
            states: vec![[x; 6]],
            mirror_states: vec![[-x; 6]],
            sizes: [1.0; 3],
            statistics: None,
        },
        exponent: None,
        periods: 0,
        stationary: false,
    }
}

#[test]
fn more_attractors_than_numbers_are_refused() {
    let found = |x: f64| ClassedAttractor { attractor: motion(x).attractor, class: MotionClass::Periodic(1) };
    let mut full = Basins::default();
    for k in 0..=u16::MAX {
        assert_eq!(full.add(found(f64::from(k))).unwrap(), BasinCell::Attractor(k));
    }
    assert_eq!(full.destination(&motion(-7.0)).unwrap(), Some(BasinCell::Mirror(7)));
    let another = motion(0.5);
    let mut one = Basins::default();
    one.add(found(0.5)).unwrap();
    for refused in [full.destination(&another).unwrap_err(), full.append(one).unwrap_err()] {
        assert!(refused.to_string().contains("65536 attractors"), "{refused}");
    }
}

#[test]
fn a_motion_whose_period_is_not_decided_is_no_attractor() {
    let open = Followed { class: MotionClass::Settling, ..motion(0.5) };
    let mut found = Basins::default();
    assert!(found.destination(&open).unwrap().is_none() && found.attractors.is_empty());
}

#[test]
fn invariant_rows_put_together_are_the_whole() {
    let cells = [0.1, 0.2, -0.1, 0.3, -0.2, 0.1, -0.3, 0.3];
    let whole = |cells: &[f64]| {
        let mut found = Basins::default();
        for x in cells {
            let cell = found.destination(&motion(*x)).unwrap().unwrap();
            found.cells.push(cell);
        }
        found
    };
    for cut in 0..=cells.len() {
        let mut found = whole(&cells[..cut]);
        found.append(whole(&cells[cut..])).unwrap();
        assert_eq!(found, whole(&cells), "cut at {cut}");
    }
}

/// The plane of starts of `vibro basin`.
fn plane(f10: f64, count: usize) -> Basins<ClassedAttractor> {
    let set = ParameterSet::basic().with(find_group("f10").unwrap(), f10).unwrap();
    let (x, y) = (axis(0, -1.0, 1.0, count), axis(4, -2.0, 2.0, count));
    let request = BasinRequest { x, y, discard: 300, start: in_the_middle() };
    basins(&set, &request, &Task::ALL).unwrap().unwrap()
}

/// Two chaotic attractors, mirror images of each other, without a path between them.
#[test]
fn invariant_two_mirror_images_of_chaos_are_an_attractor_and_its_image() {
    let found = plane(2.86, 5);
    let [attractor] = &found.attractors[..] else { panic!("{:?}", found.attractors) };
    assert_eq!(attractor.class, MotionClass::Chaotic);
    let [own, mirror] = found.shares(0);
    assert!(own > 0.2 && mirror > 0.2 && (own + mirror - 1.0).abs() < 1e-12, "{own} {mirror}");
    // One more impact at one of the stops.
    let [upper, lower] = attractor.attractor.impacts;
    assert!(((upper - lower).abs() - 1.0).abs() < 0.05, "{upper} {lower}");
}

/// Some of these motions are chaotic for a thousand drive periods or more before they become
/// periodic.
#[test]
fn second_method_a_long_transient_is_no_attractor() {
    let found = plane(2.85, 5);
    assert!(!found.attractors.is_empty());
    for attractor in &found.attractors {
        assert!(matches!(attractor.class, MotionClass::Periodic(_)), "{attractor:?}");
    }
    let settled: f64 = (0..found.attractors.len() as u16).flat_map(|k| found.shares(k)).sum();
    assert!((settled - 1.0).abs() < 1e-12, "{settled}");
}
