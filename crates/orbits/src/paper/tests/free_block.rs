//! Orbits of a block without a spring (docs/theory.md (111) to (113)). They are compared with two
//! closed forms (the symmetric motion; a block that bounces under gravity), with the balance of
//! impulses (113), and with the simulator.

use crate::paper::{
    Branch, Family, Label, Orbit, OrbitWord, PathOptions, Span, System, TreeOptions, branch, orbit_of,
    search, settle, tree,
};
use nalgebra::Complex;
use vibro_impact::Simulator;
use vibro_impact::parameters::{Groups, Parameters, Scales};
use vibro_impact::steady::exact_orbit;
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{Name, ParameterSet, find_group};

/// Tolerance between the results of two methods: rounding in a flight times the sensitivity of the
/// orbit.
const CLOSED_FORM: f64 = 1e-12;

fn free(f10: f64) -> Parameters {
    let p = Groups { f10, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    Parameters { coupling_stiffness: 0.0, ..p }
}

fn pulled(p: &Parameters, force: f64) -> System {
    super::single::under(p, [0.0, force, 0.0]).unwrap()
}

fn word(text: &str, closing: i8, half_periods: u32) -> OrbitWord {
    OrbitWord::new(text, closing, half_periods).unwrap()
}

/// The box and force of the tutorial docs/design-a-damper.md, with a block of 1.1 kg and a gap of
/// 18 mm.
fn damper() -> ParameterSet {
    let mut set = ParameterSet::basic();
    set.apply(&[
        "box.m=12kg",
        "box.k=48kN/m",
        "box.c=30N.s/m",
        "block.m=1.1kg",
        "secondary.m=1kg",
        "secondary.k=4kN/m",
        "secondary.c=5N.s/m",
        "coupling.k=0",
        "stop.gap=18mm",
        "stop.restitution=0.5",
        "drive.amplitude=75N",
        "drive.frequency=10.05Hz",
    ])
    .unwrap();
    set
}

/// Largest distance of a displacement from the orbit's start, in gaps, after a simulation of
/// `periods` drive periods (rounded down to whole periods of the orbit).
fn drift(orbit: &Orbit, periods: u32) -> f64 {
    let (p, start) = (orbit.system().parameters(), orbit.start_state());
    let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
    simulator.set_loads(&orbit.system().loads().loads()).unwrap();
    let whole = periods / orbit.word().period() * orbit.word().period();
    simulator.advance_to(f64::from(whole) * p.period()).unwrap();
    let end = simulator.state();
    start.x.iter().zip(&end.x).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs() / p.stop_gap))
}

#[test]
fn closed_form_of_the_symmetric_orbit_of_a_free_block() {
    for f10 in [1.0, 1.5, 2.5] {
        let p = free(f10);
        let exact = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let system = System::new(&p).unwrap();
        let first = exact.drive_phase();
        let half = Orbit::find(&system, &word("U", -1, 1), &[first + 0.03]).unwrap();
        let guess = [first + 0.02, first + 0.01 + std::f64::consts::PI];
        let whole = Orbit::find(&system, &word("UL", 1, 2), &guess).unwrap();
        for orbit in [&half, &whole] {
            assert!((orbit.phases()[0] - first).abs() < CLOSED_FORM, "{f10} {}", orbit.word());
            for theta in [0.0, 1.0, 2.5, 4.0] {
                let (own, closed) = (orbit.state(theta), exact.state(theta));
                let pairs = own.x.iter().chain(&own.v).zip(closed.x.iter().chain(&closed.v));
                assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < CLOSED_FORM);
            }
        }
        for (own, closed) in half.multipliers().iter().zip(exact.multipliers()) {
            assert!((own - closed).norm() < 10.0 * CLOSED_FORM, "{own} {closed}");
        }
        assert_eq!(whole.shortest().0.word(), half.word());
        assert_eq!(half.is_certified(), exact.is_clear());
    }
}

/// The two possible drive phases at the impact, and the approach speed (in gaps times the drive
/// frequency), for a block that hits the lower stop once per period under a constant load. The
/// impulse balances the load over a period, and the law of restitution gives the approach speed.
/// The block flies freely under its load. The box is a linear oscillator under drive and impulses.
fn bouncing(p: &Parameters, pull: f64) -> ([f64; 2], f64) {
    let (period, omega) = (p.period(), p.drive_frequency);
    let reduced = p.box_mass * p.block_mass / (p.box_mass + p.block_mass);
    let impulse = -pull * period;
    let approach = impulse / ((1.0 + p.stop_restitution) * reduced);
    let block = 0.5 * pull / p.block_mass * period;
    let box_speed = block + approach;
    // Part of the box's velocity just before an impact that previous impacts caused, each a kick
    // of -impulse/m1.
    let (decay, stiffness) = (0.5 * p.box_damping / p.box_mass, p.box_stiffness / p.box_mass);
    let root = Complex::new(-decay, (stiffness - decay * decay).sqrt());
    let kicked = root * (root * period).exp() / (1.0 - (root * period).exp());
    let by_kicks = -impulse / p.box_mass * kicked.im / root.im;
    let impedance = Complex::new(p.box_stiffness - p.box_mass * omega * omega, p.box_damping * omega);
    let response = p.drive_amplitude / impedance;
    let cosine = (box_speed - by_kicks) / (omega * response.norm());
    let phases = [cosine.acos(), -cosine.acos()].map(|turned| turned - response.arg());
    (phases, approach / (omega * p.stop_gap))
}

#[test]
fn closed_form_of_a_block_that_bounces_under_gravity() {
    let mut certified = 0;
    for (f10, pull) in [(0.5, -0.02), (0.5, -0.015), (0.4, -0.01), (0.6, -0.012)] {
        let p = free(f10);
        let system = pulled(&p, pull);
        let (phases, approach) = bouncing(&p, pull);
        assert!(phases[0].is_finite(), "{f10} {pull}");
        for phase in phases {
            let orbit = Orbit::find(&system, &word("L", 1, 2), &[phase + 0.01]).unwrap();
            assert!((orbit.phases()[0] - phase).abs() < CLOSED_FORM, "{f10}: {} {phase}", orbit.phases()[0]);
            assert!((orbit.speeds()[0] - approach).abs() < CLOSED_FORM);
            certified += usize::from(orbit.is_certified());
        }
    }
    // One of the eight closed-form orbits goes beyond a stop: it is not a motion of the machine.
    assert_eq!(certified, 7);
}

#[test]
fn invariant_impulses_balance_the_load_on_a_free_block() {
    for pull in [0.0, -0.004, 0.006] {
        let mut count = 0;
        let p = free(2.0);
        let system = pulled(&p, pull);
        for text in ["UL", "ULL", "UUL", "L", "U"] {
            let Ok(found) = search(&system, &word(text, 1, 2), 60) else { continue };
            for orbit in found {
                let reduced = p.box_mass * p.block_mass / (p.box_mass + p.block_mass);
                let unit = (1.0 + p.stop_restitution) * reduced * p.drive_frequency * p.stop_gap;
                let (word, speeds) = (orbit.word(), orbit.speeds());
                let sum: f64 = word.letters().iter().zip(speeds).map(|(s, v)| f64::from(*s) * v * unit).sum();
                assert_eq!(word.closing(), 1);
                let load = pull * f64::from(word.period()) * p.period();
                assert!((sum - load).abs() < CLOSED_FORM, "{word} under {pull}: {sum} {load}");
                count += 1;
            }
        }
        assert!(count > 0, "under {pull}");
    }
}

#[test]
fn words_that_cannot_balance_the_load_are_refused_with_the_reason() {
    let refused = |pull: f64, text: &str| {
        let system = pulled(&free(2.0), pull);
        let guess: Vec<f64> = (0..text.len()).map(|i| 5.0 + i as f64).collect();
        Orbit::find(&system, &word(text, 1, 2), &guess).unwrap_err().to_string()
    };
    assert!(refused(0.0, "U").contains("must contain both U and L"));
    assert!(refused(-0.01, "UU").contains("must contain an L"));
    assert!(refused(0.01, "L").contains("must contain a U"));
    assert!(
        refused(-0.01, "").contains("must contain an L"),
        "a block that falls has no motion without impacts"
    );
}

#[test]
fn second_method_multipliers_of_a_free_block_by_differences_of_the_simulator() {
    /// Tolerance for central differences with steps of 1e-5.
    const TOLERANCE: f64 = 1e-7;
    for (pull, text, f10) in [(0.0, "UL", 2.2), (-0.003, "UL", 2.2)] {
        let system = pulled(&free(f10), pull);
        let orbit = search(&system, &word(text, 1, 2), 100).unwrap().remove(0);
        let orbit = if orbit.word().closing() < 0 { orbit.unfolded().unwrap() } else { orbit };
        let phases = orbit.phases();
        let map = super::single::simulated_map(&orbit, 0.5 * (phases[0] + phases[1]));
        let mut found: Vec<f64> = map.complex_eigenvalues().iter().map(|m| m.norm()).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        for (simulated, own) in found.iter().zip(orbit.multipliers()) {
            assert!((simulated - own.norm()).abs() < TOLERANCE, "{pull}: {simulated} {own}");
        }
    }
}

#[test]
fn second_method_the_settled_motion_of_the_tutorials_damper_is_an_orbit() {
    /// Tolerance, in gaps, after 3000 periods on a stable orbit, where deviations decay.
    const RETURN: f64 = 1e-10;
    for force in [0.0, -1.0] {
        let system = pulled(damper().parameters(), force);
        let state = settle(&system, &moving_block(system.parameters()), 3000).unwrap();
        let orbit = orbit_of(&system, &state).unwrap();
        assert!(orbit.is_certified() && orbit.is_stable(), "{} {}", orbit.word(), orbit.spectral_radius());
        assert!(drift(&orbit, 3000) < RETURN, "{:e}", drift(&orbit, 3000));
    }
}

#[test]
fn second_method_the_tree_of_a_free_block_holds_what_settles() {
    let span = Span::new(Name::find("drive.frequency").unwrap(), 58.0, 66.0).unwrap();
    for force in [0.0, -1.0] {
        let set = damper().with(Name::find("load.block").unwrap(), force).unwrap();
        let family = Family::new(&set, span).unwrap();
        let options = TreeOptions { seeds: 5, settle: 400, starts: 0, depth: 1, ..TreeOptions::default() };
        let found = tree(&family, &options, &|_, _| ()).unwrap();
        let mut stable = 0;
        for value in [59.0, 61.0, 63.0] {
            for orbit in found.orbits_at(&family, value).unwrap() {
                assert!(orbit.orbit.is_certified());
                if orbit.orbit.spectral_radius() < 0.98 {
                    assert!(drift(&orbit.orbit, 4000) < 1e-9, "{}", orbit.orbit.word());
                    stable += 1;
                }
            }
        }
        assert!(stable > 0, "{force}");
    }
}

/// Special points except the ends of the range.
fn specials(branch: &Branch) -> Vec<(&'static str, f64)> {
    let all = branch.points.iter().filter_map(|p| Some((p.label()?, p.value)));
    let mut found: Vec<_> = all.filter(|p| p.0 != Label::EndPoint).map(|(l, v)| (l.name(), v)).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
}

/// A stiffness varies from zero to a finite value. The equations for a missing spring may be
/// singular once the spring holds the body, so each machine uses equations for its own stiffness.
#[test]
fn closed_form_the_branch_from_a_missing_spring_on_runs_through_the_range() {
    let mut set = ParameterSet::basic();
    let machine = [
        "drive.amplitude=0.1969705266193168",
        "drive.frequency=1.066793689779902",
        "stop.restitution=0.7536452108372163",
        "coupling.k=0.018702293272055373",
        "secondary.k=0.15",
    ];
    set.apply(&machine.map(String::from)).unwrap();
    let along = Name::find("secondary.k").unwrap();
    let family = Family::new(&set, Span::new(along, 0.0, 0.4).unwrap()).unwrap();
    let start = exact_orbit::solve(set.parameters()).unwrap().upper.unwrap().drive_phase();
    let found = branch(&family, &word("U", -1, 1), &[start], 0.15, &PathOptions::default(), &[]).unwrap();
    let ends = [&found.points[0], &found.points[found.points.len() - 1]];
    assert!(ends.iter().all(|p| p.label() == Some(Label::EndPoint)), "{ends:?}");
    let mut values = ends.map(|p| p.value);
    values.sort_by(f64::total_cmp);
    assert_eq!(values, [0.0, 0.4]);
    for point in &found.points {
        let exact = exact_orbit::solve(set.with(along, point.value).unwrap().parameters()).unwrap();
        let apart = (point.phases()[0] - exact.upper.unwrap().drive_phase()).rem_euclid(std::f64::consts::PI);
        assert!(apart.min(std::f64::consts::PI - apart) < CLOSED_FORM, "{} {apart}", point.value);
    }
}

#[test]
fn invariant_special_points_do_not_depend_on_which_equations_are_solved_for_the_state() {
    /// Tolerance between two locations of a special point, relative to the default coupling.
    const LOCATION: f64 = 1e-10;
    // The coupling varies from zero (free block). Equation (112) is used up to 0.18 of the default
    // stiffness, (103) beyond. At this force the symmetry breaks near the default coupling.
    let set = ParameterSet::basic().with(find_group("f10").unwrap(), 2.0396).unwrap();
    let along = Name::find("coupling.k").unwrap();
    let own = along.value(&set);
    let follow = |from: f64| {
        let family = Family::new(&set, Span::new(along, from, 10.0 * own).unwrap()).unwrap();
        let found = search(&family.system(&[own]).unwrap(), &word("U", -1, 1), 40).unwrap();
        let least = |a: &Orbit, b: &Orbit| a.spectral_radius().total_cmp(&b.spectral_radius());
        let orbit = found.into_iter().min_by(least).unwrap();
        branch(&family, orbit.word(), orbit.phases(), own, &PathOptions::default(), &[]).unwrap()
    };
    let (whole, part) = (follow(0.0), follow(0.1 * own));
    let reached = whole.points.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
    assert!(reached == 0.0, "{reached}");
    let beyond: Vec<_> = specials(&whole).into_iter().filter(|p| p.1 > 0.1 * own).collect();
    assert_eq!(beyond.len(), specials(&part).len(), "{beyond:?} {:?}", specials(&part));
    assert!(beyond.len() >= 2, "{beyond:?}");
    for (a, b) in beyond.iter().zip(specials(&part)) {
        assert!(a.0 == b.0 && (a.1 - b.1).abs() < LOCATION * own, "{a:?} {b:?}");
    }
    let free = whole.points.iter().find(|p| p.value == 0.0).unwrap();
    let p = Parameters { coupling_stiffness: 0.0, ..*set.parameters() };
    let exact = exact_orbit::solve(&p).unwrap().upper.unwrap();
    let apart = (free.phases()[0] - exact.drive_phase()).rem_euclid(std::f64::consts::PI);
    assert!(apart.min(std::f64::consts::PI - apart) < CLOSED_FORM, "{apart}");
}
