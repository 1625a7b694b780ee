//! Trees list every orbit once, and contain the orbits on which motions from the start settle.

use super::*;
use vibro_machine::Start;
use vibro_studies::Measure;

/// Relative tolerance between the measures of one motion described by two words.
const ROUNDING: f64 = 1e-9;

/// Smallest length of a branch, Hz: a thousand times the accuracy of its ends.
const LEAST: f64 = 1e-7;

/// Checks that no orbit in the middle of a branch belongs to another branch: some measures differ.
/// Returns the number of pairs.
fn check_each_once(branches: &[Branch], measures: &[&str]) -> usize {
    let measures: Vec<Measure> = measures.iter().map(|name| name.parse().unwrap()).collect();
    let of = |orbit: &Orbit| -> Vec<f64> { measures.iter().map(|own| orbit.measure(own).unwrap()).collect() };
    let mut compared = 0;
    for branch in branches {
        let plain: Vec<&OrbitPoint> = branch.points.iter().filter(|p| p.special.is_none()).collect();
        let orbit = branch.orbit(plain[plain.len() / 2]).unwrap();
        let own = of(&orbit);
        let others = branches.iter().filter(|other| other.id != branch.id);
        let others = others.filter(|other| other.word().periods == branch.word().periods);
        for (other, same) in
            others.flat_map(|other| other.orbits_at(orbit.value()).into_iter().map(move |o| (other, o)))
        {
            let apart = own.iter().zip(of(&same)).map(|(a, b)| (a - b).abs() / a.abs()).fold(0.0, f64::max);
            assert!(apart > ROUNDING, "{} and {} at {}", branch.id, other.id, orbit.value());
            compared += 1;
        }
    }
    compared
}

#[test]
fn invariant_a_broken_symmetry_is_one_branch() {
    // A motion settles on an asymmetric orbit, whose branch crosses the symmetric one twice.
    let family = Family::new(&touches::energy_sink(8.5), "body.base.motion.frequency", (8.35, 8.66)).unwrap();
    let branches = grown(&family, 6, 1);
    let crossings =
        branches.iter().filter(|b| b.points.iter().any(|p| p.label() == Some(crate::Label::BranchPoint)));
    assert!(crossings.count() == 2, "{}", branches.len());
    assert!(check_each_once(&branches, &["maximum.ball.s", "impact.speed.left"]) > 1);
}

#[test]
fn invariant_a_valve_has_each_orbit_in_one_word() {
    // The impact at the seat begins a run, whether it releases the lash at once or slightly later:
    // the words of both settled motions describe the same orbits.
    let family =
        Family::new(&example("valve_train.toml"), "spring.valve_spring.preload", (57.1, 105.0)).unwrap();
    let branches = grown(&family, 2, 0);
    let all: Vec<(usize, usize)> = branches.iter().map(|b| (b.id, b.points.len())).collect();
    assert_eq!(all.len(), 1, "{all:?}");
}

#[test]
fn invariant_a_branch_without_length_is_not_listed() {
    // A slider between the impacts of a damper: near a touch the events of one word change order
    // at once.
    let m = machine(
        "name = \"Damper\"\nbody.main = { mass = 1.0 }\nbody.ball = { mass = 0.1, start = { v = 0.3 } }\n\
         spring.k = { between = [\"ground\", \"main\"], stiffness = 100.0, damping = 0.4 }\n\
         spring.j = { between = [\"main\", \"ball\"], stiffness = 20.0, slip = 0.05 }\n\
         stop.r = { between = [\"main\", \"ball\"], gap = 0.03, restitution = 0.7 }\n\
         stop.l = { between = [\"ball\", \"main\"], gap = 0.03, restitution = 0.7 }\n\
         load.f = { on = \"main\", amplitude = 1.0, frequency = 1.6 }\n",
    );
    let family = Family::new(&m, "load.f.frequency", (1.7, 1.8)).unwrap();
    let branches = grown(&family, 1, 1);
    for branch in &branches {
        let all = branch.points.iter().map(|p| p.value);
        let ends = all.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        assert!(ends.1 - ends.0 > LEAST, "branch {} from {:?}: {ends:?}", branch.id, branch.parent);
    }
    assert!(branches.len() > 2, "{}", branches.len());
}

#[test]
fn invariant_a_tree_has_the_orbits_on_which_motions_from_its_start_settle() {
    let m = machine(
        "name = \"Oscillator\"\nbody.box = { mass = 1.0, start = { v = -0.325 } }\n\
         spring.mount = { between = [\"ground\", \"box\"], stiffness = 400.0, damping = 2.0 }\n\
         stop.wall = { between = [\"ground\", \"box\"], gap = 0.01, restitution = 0.8 }\n\
         load.shaker = { on = \"box\", amplitude = 2.0, frequency = 4.2 }\n",
    );
    let family = Family::new(&m, "stop.wall.gap", (8.125e-3, 10.375e-3)).unwrap();
    let branches = grown(&family, 3, 1);
    // An orbit with impacts and one without: a motion stays on one of them while the gap changes.
    for (gap, events) in [(8.5e-3, 0), (9.25e-3, 1), (10e-3, 0)] {
        let orbit = Orbit::settled_at(&family, gap, &Start::default(), 400).unwrap();
        assert_eq!(orbit.word().len(), events, "{gap}");
        assert!(branches.iter().any(|branch| branch.passes(&orbit)), "{gap}: {}", branches.len());
    }
}
