//! Branches and their special points against the closed form, the other side of a point, half
//! steps, and the simulator.

use crate::paper::{
    Branch, Family, Label, Orbit, OrbitPoint, OrbitWord, PathOptions, Span, Tree, TreeOptions, branch,
    orbit_of, settle, tree,
};
use vibro_impact::parameters::{Groups, Parameters, Scales};
use vibro_impact::steady::continuation::{self, Special};
use vibro_impact::{Simulator, State};
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{ParameterSet, find_field, find_group};

/// Tolerance between two locations of a point, each exact to about 1e-13.
const LOCATION: f64 = 1e-11;

pub(super) fn family(from: f64, to: f64) -> Family {
    let span = Span::new(find_group("f10").unwrap(), from, to).unwrap();
    Family::new(&ParameterSet::basic(), span).unwrap()
}

pub(super) fn symmetric() -> OrbitWord {
    OrbitWord::new("U", -1, 1).unwrap()
}

fn grow(family: &Family, options: TreeOptions) -> Tree {
    tree(family, &options, &|_, _| ()).unwrap()
}

pub(super) fn labelled(branch: &Branch, label: Label) -> impl Iterator<Item = &OrbitPoint> {
    branch.points.iter().filter(move |p| p.label() == Some(label))
}

/// The whole word UL of a symmetric orbit: its branch continues where the symmetry breaks.
#[test]
fn invariant_a_whole_word_of_a_symmetric_orbit_gives_its_branch() {
    let family = family(0.5, 3.0);
    let half = branch(&family, &symmetric(), &[5.5], 1.5, &PathOptions::default(), &[]).unwrap();
    let system = family.system(&[1.5]).unwrap();
    let orbit = Orbit::find(&system, &OrbitWord::new("UL", 1, 2).unwrap(), &[5.5, 8.6]).unwrap();
    let whole = branch(&family, orbit.word(), orbit.phases(), 1.5, &PathOptions::default(), &[]).unwrap();
    assert_eq!(whole.word(), half.word());
    assert!(whole.holds(&family, &orbit, 1.5) && half.holds(&family, &orbit, 1.5));
    let values =
        |b: &Branch| b.points.iter().filter(|p| p.label().is_some()).map(|p| p.value).collect::<Vec<_>>();
    assert_eq!(values(&whole).len(), values(&half).len());
    for (a, b) in values(&whole).into_iter().zip(values(&half)) {
        assert!((a - b).abs() < LOCATION, "{a} {b}");
    }
}

#[test]
fn closed_form_of_the_branch_of_symmetric_orbits() {
    let family = family(0.5, 3.0);
    let found = branch(&family, &symmetric(), &[5.5], 1.5, &PathOptions::default(), &[1.7]).unwrap();
    let path = |f10| Groups { f10, ..Groups::basic() }.to_parameters(Scales::default());
    let exact = continuation::exact_orbit(path, (0.5, 3.0), 400).unwrap();
    for (special, label) in [
        (Special::Fold, Label::Fold),
        (Special::Bifurcation(vibro_impact::steady::Bifurcation::NeimarkSacker), Label::NeimarkSacker),
        (Special::Bifurcation(vibro_impact::steady::Bifurcation::SymmetryBreaking), Label::BranchPoint),
    ] {
        let closed: Vec<f64> =
            exact.specials().filter(|p| p.special == Some(special)).map(|p| p.value).collect();
        let own: Vec<f64> = labelled(&found, label).map(|p| p.value).collect();
        assert_eq!(closed.len(), own.len(), "{label}: {closed:?} {own:?}");
        assert!(
            closed.iter().zip(&own).all(|(a, b)| (a - b).abs() < LOCATION),
            "{label}: {closed:?} {own:?}"
        );
    }
    // The branch begins at the touch of the motion without impacts, where |H| = 1.
    let touch = labelled(&found, Label::Grazing).next().unwrap();
    assert!((family.system(&[touch.value]).unwrap().amplitude() - 1.0).abs() < LOCATION);
    assert_eq!(labelled(&found, Label::UserValue).next().unwrap().value, 1.7);
}

#[test]
fn invariant_points_of_a_tree_are_orbits_and_stability_changes_at_special_points() {
    let family = family(2.0, 3.0);
    let found =
        grow(&family, TreeOptions { seeds: 5, depth: 2, settle: 600, starts: 0, ..TreeOptions::default() });
    assert!(found.branches.len() > 5, "{}", found.branches.len());
    for branch in &found.branches {
        for pair in branch.points.windows(2) {
            let stable = |p: &OrbitPoint| p.multipliers[0].norm() < 1.0;
            let plain = pair.iter().all(|p| p.special.is_none());
            assert!(
                !plain || stable(&pair[0]) == stable(&pair[1]),
                "branch {} at {}",
                branch.id,
                pair[0].value
            );
        }
        for point in branch.points.iter().step_by(7).filter(|p| p.special.is_none()) {
            let system = family.system(&[point.value]).unwrap();
            let orbit = Orbit::find(&system, branch.word(), point.phases()).unwrap();
            assert!(orbit.is_certified(), "{} at {}", branch.word(), point.value);
            assert_eq!(found.passing(&family, branch.word(), point.phases(), point.value), Some(branch.id));
        }
    }
}

/// Special points of a tree except for the ends of its range, by word and label.
fn special_points(tree: &Tree) -> Vec<(String, u32, &'static str, f64)> {
    let mut found: Vec<_> = tree
        .branches
        .iter()
        .flat_map(|b| b.points.iter().filter_map(move |p| Some((b, p.label()?, p.value))))
        .filter(|(_, label, _)| *label != Label::EndPoint)
        .map(|(b, label, value)| (b.word().to_string(), b.word().half_periods(), label.name(), value))
        .collect();
    found.sort_by(|a, b| (&a.0, a.1, a.2).cmp(&(&b.0, b.1, b.2)).then(a.3.total_cmp(&b.3)));
    found
}

#[test]
fn second_method_special_points_by_half_the_step() {
    let options = TreeOptions { seeds: 5, depth: 1, settle: 600, starts: 0, ..TreeOptions::default() };
    let half = TreeOptions { longest_step: 0.5 * options.longest_step, ..options.clone() };
    let family = family(2.0, 3.0);
    let [whole, half] = [options, half].map(|o| grow(&family, o));
    let [whole, half] = [&whole, &half].map(special_points);
    assert_eq!(whole.len(), half.len());
    for (a, b) in whole.iter().zip(&half) {
        assert_eq!((&a.0, a.1, a.2), (&b.0, b.1, b.2));
        assert!((a.3 - b.3).abs() < LOCATION, "{a:?} {b:?}");
    }
}

#[test]
fn invariant_a_tree_does_not_depend_on_the_number_of_threads() {
    let family = family(2.2, 2.6);
    let options = TreeOptions { seeds: 4, depth: 2, settle: 400, starts: 0, ..TreeOptions::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| grow(&family, options.clone())).branches
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn second_method_touches_located_from_both_words_agree() {
    // The touch at which the asymmetric motion UL gains a third impact, followed from either side.
    let family = family(2.0, 3.0);
    let find = |value: f64, state: Option<State>| {
        let system = family.system(&[value]).unwrap();
        let start = state.unwrap_or_else(|| moving_block(system.parameters()));
        orbit_of(&system, &settle(&system, &start, 1500).unwrap()).unwrap()
    };
    let three = find(2.7, None);
    assert_eq!(three.word().canonical().to_string(), "UUL");
    let longer = branch(&family, three.word(), three.phases(), 2.7, &PathOptions::default(), &[]).unwrap();
    let two = find(2.2, None);
    assert_eq!(two.word().canonical().to_string(), "UL");
    let shorter = branch(&family, two.word(), two.phases(), 2.2, &PathOptions::default(), &[]).unwrap();
    let [a, b] =
        [&longer, &shorter].map(|b| labelled(b, Label::Grazing).map(|p| p.value).collect::<Vec<_>>());
    assert!(a.iter().any(|a| b.iter().any(|b| (a - b).abs() < LOCATION)), "{a:?} {b:?}");
}

#[test]
fn invariant_a_doubled_branch_leaves_as_a_parabola() {
    // λ - λ* over the square of the amplitude settles on a constant.
    let family = family(2.0, 2.6);
    let found = grow(
        &family,
        TreeOptions {
            seeds: 3,
            depth: 1,
            settle: 600,
            starts: 0,
            longest_step: 0.01,
            ..TreeOptions::default()
        },
    );
    let born = |b: &&Branch| b.points[0].label() == Some(Label::PeriodDoubling);
    let doubled = found.branches.iter().find(born).unwrap();
    let h = doubled.word().len() / 2;
    let ratio = |point: &OrbitPoint| {
        let amplitude = (0..h).map(|i| {
            let half = 0.5 * doubled.word().span();
            (point.phases()[h + i] - point.phases()[i] - half).powi(2)
        });
        (point.value - doubled.points[0].value) / amplitude.sum::<f64>()
    };
    let [near, far] = [&doubled.points[2], &doubled.points[4]].map(ratio);
    assert!((near / far - 1.0).abs() < 0.02, "{near} {far}");
}

#[test]
fn second_method_the_simulator_on_both_sides_of_a_period_doubling() {
    // UL doubles its period at 2.373075: below it a small deviation decays, above it the period is
    // two.
    let doubling = 2.373_075_370_806;
    for (value, period) in [(doubling - 2e-3, 1), (doubling + 2e-3, 2)] {
        let p = Groups { f10: value, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
        let system = crate::paper::System::new(&p).unwrap();
        let orbit = orbit_of(&system, &settle(&system, &moving_block(&p), 20_000).unwrap()).unwrap();
        assert_eq!(orbit.word().period(), period, "{value}");
        assert!(orbit.is_stable());
        // The motion still returns after thousands of periods.
        let start = orbit.start_state();
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.advance_to(6000.0 * p.period()).unwrap();
        let apart = simulator.state().x.iter().zip(&start.x).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-11, "{value}: {apart:e}");
    }
}

#[test]
fn settled_motions_that_are_no_orbits_are_refused_by_what_they_do() {
    let chaos = Groups { f10: 3.6, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    let system = crate::paper::System::new(&chaos).unwrap();
    // Chaos may pass near an unstable orbit, so an orbit and an error are both correct; an orbit
    // must be certified.
    match orbit_of(&system, &settle(&system, &moving_block(&chaos), 600).unwrap()) {
        Ok(orbit) => assert!(orbit.is_certified() && !orbit.is_stable()),
        Err(error) => assert!(error.to_string().contains("does not return"), "{error}"),
    }
    let resting = Parameters { stop_restitution: 0.05, drive_amplitude: 0.45, ..chaos };
    let system = crate::paper::System::new(&resting).unwrap();
    let error = orbit_of(&system, &settle(&system, &moving_block(&resting), 600).unwrap()).unwrap_err();
    assert!(error.to_string().contains("rests at a stop"), "{error}");
    // A block that its load holds at a stop from the start has no events.
    let held = Parameters { drive_amplitude: 0.01, constant_loads: [0.0, -100.0, 0.0], ..chaos };
    let system = crate::paper::System::new(&held).unwrap();
    let at_stop = State { x: [0.0, -held.stop_gap, 0.0], v: [0.0; 3] };
    let error = orbit_of(&system, &settle(&system, &at_stop, 2000).unwrap()).unwrap_err();
    assert!(error.to_string().contains("rests at a stop"), "{error}");
}

/// The branch of the motion from the standard start, along a parameter of the machine.
pub(super) fn settled_branch(set: &ParameterSet, name: &str, (from, to): (f64, f64), value: f64) -> Branch {
    let field = find_field(name).unwrap();
    let family = Family::new(set, Span::new(field, from, to).unwrap()).unwrap();
    let system = family.system(&[value]).unwrap();
    let settled = settle(&system, &State { x: [0.0; 3], v: [0.0, 0.5, 0.0] }, 1200).unwrap();
    let orbit = orbit_of(&system, &settled).unwrap();
    branch(&family, orbit.word(), orbit.phases(), value, &PathOptions::default(), &[]).unwrap()
}

pub(super) fn machine(values: &[(&str, f64)]) -> ParameterSet {
    values.iter().fold(ParameterSet::basic(), |set, (name, value)| {
        set.with(find_field(name).unwrap(), *value).unwrap()
    })
}

/// A fold just before a touch is labelled: the parameter turns there.
#[test]
fn invariant_where_the_parameter_turns_before_a_touch_is_a_fold() {
    let set = machine(&[
        ("drive.amplitude", 0.2890365406359685),
        ("drive.frequency", 0.8419615584575438),
        ("stop.restitution", 0.47258588839990295),
        ("box.c", 0.1),
    ]);
    let branch = settled_branch(&set, "box.c", (0.01, 0.4), 0.1);
    let turns = |w: &[OrbitPoint]| (w[1].value - w[0].value) * (w[2].value - w[1].value) < 0.0;
    let turning: Vec<_> = branch.points.windows(3).filter(|w| turns(w)).map(|w| w[1].label()).collect();
    assert!(turning.contains(&Some(Label::Fold)), "{turning:?}");
    assert!(!turning.contains(&Some(Label::BranchPoint)), "{turning:?}");
}

/// Between adjacent points without a special point, the number of multipliers outside the unit
/// circle is constant, even if two doublings lie within one longest step.
#[test]
fn invariant_stability_changes_at_special_points_alone() {
    let set = machine(&[
        ("load.block", 0.002),
        ("drive.amplitude", 0.7628006163840688),
        ("stop.restitution", 0.908136294857699),
        ("drive.frequency", 1.4213961423350312),
    ]);
    let branch = settled_branch(&set, "drive.frequency", (0.4, 2.2), 1.4213961423350312);
    assert!(labelled(&branch, Label::PeriodDoubling).count() >= 4, "{}", branch.points.len());
    for pair in branch.points.windows(2).filter(|pair| pair.iter().all(|p| p.special.is_none())) {
        let [a, b] = [0, 1].map(|i| pair[i].multipliers.iter().filter(|m| m.norm() > 1.0).count());
        assert_eq!(a, b, "between {} and {}", pair[0].value, pair[1].value);
    }
}

/// A step past the birth of a branch may end on the branch where it was born. Both halves of the
/// orbit are then equal within rounding of either sign.
#[test]
fn invariant_a_step_that_ends_on_the_other_branch_has_passed_the_birth() {
    const BREAKING: f64 = 2.039_588_865_238;
    let family = family(0.5, 3.0);
    let found =
        branch(&family, &symmetric(), &[5.5], 1.5, &PathOptions::default(), &[BREAKING - 0.01]).unwrap();
    let on_other = labelled(&found, Label::UserValue).next().unwrap();
    let word = symmetric().unfolded();
    let doubled = crate::paper::orbit::unfolded_phases(&symmetric(), on_other.phases());
    for rounding in [1e-12, 0.0, -1e-12] {
        let point =
            |apart: f64, value: f64| family.point(&[doubled[0] + apart, doubled[1] - apart], &[value]);
        let [last, next] = [point(1e-2, BREAKING + 1e-3), point(rounding, BREAKING - 0.01)];
        let (born, u) = crate::paper::special::primary(&family, &word, &last, &next).unwrap().unwrap();
        assert_eq!(born, symmetric());
        assert!((family.values(&u)[0] - BREAKING).abs() < LOCATION, "{rounding}");
    }
}

/// A branch ends at its birth, although its equations are nearly singular there, so that no step
/// leads across.
#[test]
fn invariant_branches_end_at_their_births() {
    for (damping, restitution, amplitude, frequency, name, range, value, births) in [
        (
            0.083_766_743_354_828_38,
            0.354_106_626_101_500_34,
            0.316_732_038_960_708_4,
            0.746_947_110_965_762,
            "box.c",
            (0.044_537_097_141_873_795, 0.148_998_967_514_180_5),
            0.111_089_335_202_335_6,
            vec![0.132_993_248_656],
        ),
        (
            0.458_336_218_690_165_3,
            0.865_561_565_832_636_5,
            0.371_690_757_636_872_54,
            1.04,
            "block.m",
            (0.083_726_049_571_087_23, 0.145_837_100_725_366_85),
            0.119_339_673_930_329_95,
            vec![0.104_185_178_229, 0.143_957_408_470],
        ),
    ] {
        let set = machine(&[
            ("box.c", damping),
            ("stop.restitution", restitution),
            ("drive.amplitude", amplitude),
            ("drive.frequency", frequency),
        ]);
        let branch = settled_branch(&set, name, range, value);
        let mut found: Vec<f64> = labelled(&branch, Label::BranchPoint).map(|p| p.value).collect();
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), births.len(), "{name}: {found:?}");
        assert!(found.iter().zip(&births).all(|(a, b)| (a - b).abs() < 1e-10), "{name}: {found:?}");
        assert_eq!(labelled(&branch, Label::NoConvergence).count(), 0, "{name}");
    }
}

/// A soft spring holds its load far away, so phases have fewer digits. A branch still turns at its
/// fold.
#[test]
fn invariant_a_branch_under_a_softly_held_load_passes_its_fold() {
    let set = machine(&[
        ("drive.amplitude", 0.722_526_073_124_224_6),
        ("stop.restitution", 0.529_129_750_182_727_7),
        ("secondary.c", 0.056_737_922_355_150_724),
        ("load.block", 0.033_893_384_758_543_574),
    ]);
    let branch = settled_branch(&set, "secondary.k", (1e-14, 0.001_180_102_643_632_359_8), 0.000_588_096);
    let folds: Vec<f64> = labelled(&branch, Label::Fold).map(|p| p.value).collect();
    assert!(folds.iter().any(|fold| (fold - 7.533_352_870_088e-4).abs() < 1e-13), "{folds:?}");
    assert_eq!(labelled(&branch, Label::NoConvergence).count(), 0, "{folds:?}");
}
