//! Memory of a large plane, as counted by the operating system. The test has its own program, so
//! that nothing else is counted.
#![cfg(target_os = "linux")]

use vibro::studies;
use vibro_studies::MotionClass;
use vibro_studies::isoperiodic::isoperiodic;
use vibro_studies::paper::isoperiodic::{IsoperiodicRequest, PlanePoint, SettledMotion};
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::{ParameterSet, find_group};
use vibro_studies::parts::Task;

/// Peak memory of this program, bytes.
fn most_held() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("the high-water mark");
    1024 * line.trim().trim_end_matches(" kB").parse::<usize>().expect("kilobytes")
}

#[test]
fn a_plane_takes_the_memory_per_point_that_is_reckoned_with() {
    const SIDE: usize = 400;
    const POINTS: usize = SIDE * SIDE;
    /// Memory of threads, tables of systems and the allocator, independent of the number of
    /// points, bytes.
    const FIXED: usize = 6 << 20;
    let axis = |name, range| ParameterAxis::new(find_group(name).unwrap(), range, SIDE).unwrap();
    // If 1 + ε σ1 < 0, the system does not exist, so nothing is simulated.
    let (x, y) = (axis("sigma1", (-12.0, -11.0)), axis("f10", (0.5, 4.0)));
    let request = IsoperiodicRequest { x, y, start: StartRule::default(), discard: 0, exponents: None };
    let set = ParameterSet::basic();
    let before = most_held();
    let mut plane = isoperiodic(&set, &request, &Task::ALL).unwrap().unwrap();
    // Parts and whole together, as `check_cells` counts.
    let parts = most_held() - before;
    let reckoned = 2 * size_of::<PlanePoint>() * POINTS;
    assert!(parts < reckoned + FIXED, "{parts} of {reckoned}");
    assert!(parts > reckoned / 2, "{parts} of {reckoned}: not counted");
    // The longest possible rows. A second copy of the table would exceed the counted memory.
    for point in &mut plane.points {
        let exponent = Some([0.123_456_789_012_345_67, 0.001_234_567_890_123_456_7]);
        let impacts = [1.0 / 3.0, 2.0 / 3.0];
        let class = MotionClass::Settling;
        point.motion =
            Some(SettledMotion { class, impacts, rests: false, symmetric: false, exponent, on_orbit: false });
    }
    let study = studies::isoperiodic(&set, &request, &plane, "plane").unwrap();
    assert!(study.tables[0].1.len() > 100 * POINTS);
    let all = most_held() - before;
    let reckoned = (size_of::<PlanePoint>() + studies::POINT_IN_TABLE) * POINTS;
    assert!(all < reckoned.max(parts) + FIXED, "{all} of {reckoned}");
}
