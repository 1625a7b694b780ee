//! Whole trees: certificates, interruption, repeated words, marks, a cascade of doublings, mirror
//! images under loads.

use crate::paper::{
    Branch, Family, Label, Orbit, OrbitWord, PathOptions, Span, Tree, TreeOptions, branch, orbit_of, settle,
    tree, tree_in_parts,
};
use std::collections::BTreeMap;
use std::sync::Mutex;
use vibro_impact::Simulator;
use vibro_impact::parameters::Parameters;
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{Name, ParameterSet, find_group};
use vibro_studies::parts::PartStore;
use vibro_studies::{Error, Result};

/// A family under a constant load.
fn loaded(from: f64, to: f64, load: &str, force: f64) -> Family {
    let span = Span::new(find_group("f10").unwrap(), from, to).unwrap();
    let set = ParameterSet::basic().with(Name::find(load).unwrap(), force).unwrap();
    Family::new(&set, span).unwrap()
}

fn family(from: f64, to: f64) -> Family {
    loaded(from, to, "load.block", 0.0)
}

/// Options of a tree of a few dozen branches.
fn options() -> TreeOptions {
    TreeOptions { seeds: 5, depth: 2, settle: 600, starts: 0, ..TreeOptions::default() }
}

fn grow(family: &Family, options: &TreeOptions) -> Tree {
    tree(family, options, &|_, _| ()).unwrap()
}

fn labelled(branch: &Branch, label: Label) -> Vec<f64> {
    branch.points.iter().filter(|p| p.label() == Some(label)).map(|p| p.value).collect()
}

#[test]
fn invariant_every_point_of_a_tree_is_certified() {
    let family = family(2.0, 3.0);
    let found = grow(&family, &options());
    let mut specials = 0;
    for branch in &found.branches {
        // At a touch an impact has zero speed, or the block just reaches a stop.
        let touch = |l| matches!(l, Some(Label::Grazing | Label::Chatter));
        for point in branch.points.iter().filter(|p| !touch(p.label())) {
            let orbit = branch.orbit(&family, point).unwrap();
            assert!(orbit.is_certified(), "branch {} ({}) at {}", branch.id, branch.word(), point.value);
            specials += usize::from(point.special.is_some());
        }
    }
    assert!(specials > 30, "{specials}");
}

#[test]
fn second_method_stable_orbits_of_a_tree_return_in_the_simulator_after_thousands_of_periods() {
    /// Tolerance for rounding over 6,000 periods of an orbit with decaying deviations.
    const RETURN: f64 = 1e-11;
    /// Modulus of multipliers below which deviations decay within this time and rounding does not
    /// accumulate.
    const DECAYING: f64 = 0.98;
    let family = family(2.0, 3.0);
    let found = grow(&family, &options());
    let mut count = 0;
    for value in [2.02, 2.3, 2.43, 2.7, 2.95] {
        let orbits = found.orbits_at(&family, value).unwrap();
        for orbit in orbits.iter().map(|o| &o.orbit).filter(|o| o.spectral_radius() < DECAYING) {
            let (p, start) = (orbit.system().parameters(), orbit.start_state());
            let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
            let periods = 6000 / orbit.word().period() * orbit.word().period();
            simulator.advance_to(f64::from(periods) * p.period()).unwrap();
            let end = simulator.state();
            let apart = start.x.iter().zip(&end.x).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(apart < RETURN, "{} at {value}: {apart:e}", orbit.word());
            count += 1;
        }
    }
    assert!(count >= 5, "{count}");
}

/// Keeps parts in memory; refuses to keep more than `most`, like an interruption.
struct MemoryStore {
    parts: Mutex<BTreeMap<usize, Vec<u8>>>,
    most: usize,
}

impl PartStore for MemoryStore {
    fn load(&self, index: usize) -> Option<Vec<u8>> {
        self.parts.lock().unwrap().get(&index).cloned()
    }

    fn save(&self, index: usize, bytes: &[u8]) -> Result<()> {
        let mut parts = self.parts.lock().unwrap();
        if parts.len() == self.most {
            return Err(Error::Form { text: index.to_string(), expected: "fewer parts" });
        }
        parts.insert(index, bytes.to_vec());
        Ok(())
    }
}

#[test]
fn invariant_an_interrupted_tree_goes_on_to_the_same_bits() {
    let (family, options) = (family(2.2, 2.6), options());
    let mut store = MemoryStore { parts: Mutex::default(), most: 3 };
    assert!(tree_in_parts(&family, &options, &store, &|_, _| ()).is_err());
    assert_eq!(store.parts.lock().unwrap().len(), 3);
    store.most = usize::MAX;
    let told = Mutex::new(Vec::new());
    let resumed =
        tree_in_parts(&family, &options, &store, &|done, waiting| told.lock().unwrap().push((done, waiting)));
    let whole = grow(&family, &options);
    let resumed = resumed.unwrap();
    assert_eq!((&resumed.branches, resumed.failures), (&whole.branches, whole.failures));
    // The number of traced starts increases, and at the end no starts are waiting.
    let told = told.into_inner().unwrap();
    assert!(told.windows(2).all(|pair| pair[0].0 <= pair[1].0) && told.last().unwrap().1 == 0, "{told:?}");
}

#[test]
fn invariant_marked_values_are_points_of_every_branch_that_passes_them() {
    // Between the values at which motions are settled.
    let marks = vec![2.2, 2.41, 2.51];
    let with = TreeOptions { marks: marks.clone(), ..options() };
    let family = family(2.0, 3.0);
    let (marked, plain) = (grow(&family, &with), grow(&family, &options()));
    assert_eq!(marked.branches.len(), plain.branches.len());
    let mut count = 0;
    for (a, b) in marked.branches.iter().zip(&plain.branches) {
        let passes = |mark: f64| {
            b.points.windows(2).filter(|p| (p[0].value - mark) * (p[1].value - mark) < 0.0).count()
        };
        let own = labelled(a, Label::UserValue);
        assert_eq!(own.len(), marks.iter().map(|mark| passes(*mark)).sum::<usize>(), "branch {}", a.id);
        assert!(own.iter().all(|value| marks.contains(value)));
        count += own.len();
        // Nothing else changes.
        let others = |b: &Branch| {
            let special = b.points.iter().filter_map(|p| Some((p.label()?, p.value)));
            special.filter(|p| p.0 != Label::UserValue).collect::<Vec<_>>()
        };
        assert_eq!(others(a).len(), others(b).len());
    }
    assert!(count > 10, "{count}");
}

#[test]
fn invariant_the_value_at_which_a_branch_is_entered_can_be_marked() {
    let family = family(0.5, 5.0);
    let word = OrbitWord::new("U", -1, 1).unwrap();
    // 1.7 divided by the curve unit and multiplied again is another number.
    for value in [1.5, 1.7, 1.9] {
        let found = branch(&family, &word, &[5.5], value, &PathOptions::default(), &[value]).unwrap();
        let upper = found.points.iter().filter(|p| p.label() == Some(Label::UserValue));
        assert!(upper.clone().count() >= 1 && upper.clone().all(|p| p.value == value), "{value}");
    }
}

#[test]
fn invariant_repeated_words_with_one_touch_leave_the_touch_too() {
    let family = family(2.0, 3.0);
    let once = grow(&family, &TreeOptions { depth: 1, ..options() });
    let twice = grow(&family, &TreeOptions { depth: 1, repetitions: 2, ..options() });
    let words = |tree: &Tree| tree.branches.iter().map(|b| b.word().to_string()).collect::<Vec<_>>();
    let (known, all) = (words(&once), words(&twice));
    assert!(known.iter().all(|word| all.contains(word)));
    // At a touch of a word of n letters, the repeated words have 2 n + 1 letters.
    let new: Vec<&Branch> =
        twice.branches.iter().filter(|b| !known.contains(&b.word().to_string())).collect();
    assert!(!new.is_empty());
    for branch in new {
        let (id, point) = branch.parent.unwrap();
        let parent = &twice.branches[id];
        if parent.points[point].label() != Some(Label::Grazing) {
            continue;
        }
        // The repeated branches begin at the parameter of the touch.
        assert!((branch.points[0].value - parent.points[point].value).abs() < 1e-11);
        assert!(branch.word().len() > parent.word().len());
    }
}

#[test]
fn closed_form_ratios_of_a_cascade_of_doublings_alternate_about_feigenbaums_constant() {
    const FEIGENBAUM: f64 = 4.669_201_609;
    // Midpoints of the ranges in which motions of 1, 2, 4, … drive periods are stable. Each range
    // is entered from the previous one, since other stable motions exist.
    let cascade = [2.3, 2.44, 2.504, 2.515, 2.5179];
    let mut last = None;
    let doubling = |(i, value): (usize, f64)| {
        let narrow = family(value - 0.1 / f64::from(4_u32.pow(i as u32)), 2.53_f64.min(value + 0.1));
        let system = narrow.system(&[value]).unwrap();
        let start = last.unwrap_or_else(|| moving_block(system.parameters()));
        let state = settle(&system, &start, 4000).unwrap();
        last = Some(state);
        let orbit = orbit_of(&system, &state).unwrap();
        assert_eq!((orbit.word().period(), orbit.is_stable()), (1 << i, true), "{value}");
        let found =
            branch(&narrow, orbit.word(), orbit.phases(), value, &PathOptions::default(), &[]).unwrap();
        // The first doubling above the value, where the branch loses its stability.
        let lost = |i: &usize| {
            let changes = found.stability_around(*i);
            found.points[*i].label() == Some(Label::PeriodDoubling)
                && changes[0] != changes[1]
                && found.points[*i].value > value
        };
        let all = (0..found.points.len()).filter(lost).map(|i| found.points[i].value);
        all.fold(f64::INFINITY, f64::min)
    };
    let doublings: Vec<f64> = cascade.into_iter().enumerate().map(doubling).collect();
    let ratios: Vec<f64> = doublings.windows(3).map(|d| (d[1] - d[0]) / (d[2] - d[1])).collect();
    let apart: Vec<f64> = ratios.iter().map(|r| r - FEIGENBAUM).collect();
    assert!(
        apart.windows(2).all(|a| a[0] * a[1] < 0.0 && a[1].abs() < a[0].abs()),
        "{doublings:?} {ratios:?}"
    );
    assert!(apart[2].abs() < 0.7, "{ratios:?}");
}

/// Special points of a tree with their labels; `mirrored` mirrors the words.
fn specials(tree: &Tree, mirrored: bool) -> Vec<(String, u32, &'static str, f64)> {
    let word = |b: &Branch| {
        let sign = if mirrored { -1 } else { 1 };
        let turned = (0..b.word().len()).map(|by| {
            let letter = |i: usize| sign * b.word().letters()[(i + by) % b.word().len()];
            (0..b.word().len()).map(|i| if letter(i) > 0 { 'U' } else { 'L' }).collect::<String>()
        });
        turned.max().unwrap_or_default()
    };
    let all = tree.branches.iter().flat_map(|b| b.points.iter().map(move |p| (b, p)));
    let mut found: Vec<_> = all
        .filter_map(|(b, p)| Some((word(b), b.word().half_periods(), p.label()?.name(), p.value)))
        .collect();
    found.sort_by(|a, b| (&a.0, a.1, a.2).cmp(&(&b.0, b.1, b.2)).then(a.3.total_cmp(&b.3)));
    found
}

#[test]
fn invariant_opposite_loads_have_mirrored_branches() {
    /// Tolerance for a point reached on two paths.
    const LOCATION: f64 = 1e-10;
    let of = |force: f64| {
        let family = loaded(1.4, 2.6, "load.block", force);
        // Only settled motions: transients are not mirror images.
        grow(&family, &TreeOptions { seeds: 7, depth: 1, settle: 1000, starts: 0, ..TreeOptions::default() })
    };
    let p = *ParameterSet::basic().parameters();
    let force = 0.05 * p.coupling_stiffness * p.stop_gap;
    let (one, other) = (specials(&of(force), false), specials(&of(-force), true));
    assert!(one.len() > 5, "{one:?}");
    // Points found under both loads agree, at least on branches with two impacts per period.
    let mut common = 0;
    for a in &one {
        let near = other.iter().filter(|b| (&a.0, a.1, a.2) == (&b.0, b.1, b.2));
        common += usize::from(near.clone().any(|b| (a.3 - b.3).abs() < LOCATION));
    }
    assert!(common * 10 >= one.len() * 8, "{common} of {}: {one:?} {other:?}", one.len());
}

#[test]
#[ignore = "minutes: the whole range with half the step; run when paths, tests or touches change"]
fn second_method_the_whole_tree_by_half_the_step() {
    /// Length of the longest compared words. A longer word passes near a shorter orbit many times,
    /// so that its special points are closer together than half a step.
    const LETTERS: usize = 24;
    /// Tolerance for a point reached on two paths.
    const LOCATION: f64 = 1e-9;
    /// Smallest fraction of the points whose words both trees have.
    const COMMON: f64 = 0.98;
    let family = family(0.5, 5.0);
    let whole = grow(&family, &TreeOptions::default());
    let half =
        TreeOptions { longest_step: 0.5 * TreeOptions::default().longest_step, ..TreeOptions::default() };
    let short = |tree: &Tree| -> Vec<_> {
        specials(tree, false).into_iter().filter(|own| own.0.len() <= LETTERS).collect()
    };
    let [whole, half] = [whole, grow(&family, &half)].map(|tree| short(&tree));
    assert!(whole.len() > 500, "{}", whole.len());
    for (own, other) in [(&whole, &half), (&half, &whole)] {
        // A word that only one tree reaches begins at points of words that both trees have.
        let is_common = |a: &&(String, u32, &str, f64)| other.iter().any(|b| (&a.0, a.1) == (&b.0, b.1));
        let common: Vec<_> = own.iter().filter(is_common).collect();
        assert!(common.len() as f64 > COMMON * own.len() as f64, "{} of {}", common.len(), own.len());
        let is_there = |a: &&&(String, u32, &str, f64)| {
            let same = other.iter().filter(|b| (&a.0, a.1, a.2) == (&b.0, b.1, b.2));
            same.into_iter().any(|b| (a.3 - b.3).abs() < LOCATION)
        };
        let missing: Vec<_> = common.iter().filter(|a| !is_there(a)).collect();
        assert!(missing.is_empty(), "{} of {}: {missing:?}", missing.len(), own.len());
    }
}

#[test]
fn branches_of_settled_and_passed_orbits_keep_the_limits_of_a_tree_too() {
    let family = family(2.0, 3.0);
    let options =
        TreeOptions { seeds: 11, starts: 16, longest_period: 2, most_letters: 4, depth: 0, ..options() };
    let found = grow(&family, &options);
    assert!(found.branches.len() > 3, "{}", found.branches.len());
    for branch in &found.branches {
        assert!(branch.word().len() <= 4 && branch.word().period() <= 2, "{}", branch.word().signed());
    }
    let periods = found.searched.values.iter().flat_map(|v| [v.rising, v.falling]).flatten();
    assert!(periods.max() <= Some(2));
}

/// A motion that settles without a load is on a symmetric orbit with a half word. As the load
/// varies, its branch continues with the whole word.
#[test]
fn second_method_branches_along_a_load_from_a_symmetric_orbit_return_in_the_simulator() {
    /// Tolerance for the rounding of a period of flights and of the phases on the branch.
    const RETURN: f64 = 1e-9;
    for (load, coupling) in [("load.block", 0.0), ("load.block", 0.006), ("load.box", 0.006)] {
        let set = ParameterSet::basic().with(Name::find("coupling.k").unwrap(), coupling).unwrap();
        let family = Family::new(&set, Span::new(Name::find(load).unwrap(), -0.02, 0.02).unwrap()).unwrap();
        let system = family.system(&[0.0]).unwrap();
        let settled = settle(&system, &moving_block(system.parameters()), 2000).unwrap();
        let orbit = orbit_of(&system, &settled).unwrap();
        assert_eq!(orbit.word().closing(), -1);
        let options = TreeOptions { seeds: 3, depth: 0, ..options() };
        let mut branches = grow(&family, &options).branches;
        branches.retain(|branch| !branch.word().is_empty());
        let path = PathOptions::default();
        branches.push(branch(&family, orbit.word(), orbit.phases(), 0.0, &path, &[]).unwrap());
        for branch in branches {
            assert!(
                branch.word().closing() > 0 && branch.points.len() > 10,
                "{load} {}",
                branch.word().signed()
            );
            for point in branch.points.iter().filter(|p| p.special.is_none()).step_by(10) {
                let orbit = branch.orbit(&family, point).unwrap();
                let (system, start) = (orbit.system(), orbit.start_state());
                let p = Parameters { constant_loads: system.loads().forces, ..*system.parameters() };
                let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
                simulator.advance_to(f64::from(orbit.word().period()) * p.period()).unwrap();
                let end = simulator.state();
                let moved = start.x.iter().zip(end.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(moved < RETURN, "{load} {} {}: {moved:e}", branch.word(), point.value);
            }
        }
    }
}

#[test]
fn what_cannot_be_followed_is_refused_before_work_begins() {
    let family = family(1.0, 2.0);
    let word = OrbitWord::new("U", -1, 1).unwrap();
    for longest_step in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 0.5] {
        let error = tree(&family, &TreeOptions { longest_step, ..options() }, &|_, _| ()).unwrap_err();
        assert!(error.to_string().contains("1e-5 to 0.2"), "{error}");
        let path = PathOptions { longest_step, ..PathOptions::default() };
        assert!(matches!(branch(&family, &word, &[5.5], 1.5, &path, &[]), Err(Error::Form { .. })));
    }
    for options in [
        TreeOptions { repetitions: 0, ..options() },
        TreeOptions { repetitions: u32::MAX, ..options() },
        TreeOptions { longest_period: u32::MAX, ..options() },
        TreeOptions { most_letters: usize::MAX, ..options() },
    ] {
        assert!(matches!(tree(&family, &options, &|_, _| ()), Err(Error::Form { .. })), "{options:?}");
    }
    let path = PathOptions::default();
    assert!(matches!(branch(&family, &word, &[5.5], 2.5, &path, &[]), Err(Error::Form { .. })));
    for phases in [&[][..], &[5.5, 6.0], &[f64::NAN], &[f64::INFINITY]] {
        assert!(matches!(branch(&family, &word, phases, 1.5, &path, &[]), Err(Error::NoOrbit { .. })));
        let nothing = Tree::default();
        assert_eq!(nothing.passing(&family, &word, phases, 1.5), None);
    }
    // A span with exchanged ends, made without its constructor.
    let span = Span { from: 2.0, to: 1.0, ..*family.span() };
    assert!(Family::new(&ParameterSet::basic(), span).is_err());
    assert!(OrbitWord::new("U", -1, u32::MAX).is_err() && OrbitWord::new(&"U".repeat(2000), 1, 2).is_err());
}

#[test]
fn closed_form_a_load_that_varies_takes_the_place_of_the_sets_own() {
    let load = Name::find("load.block").unwrap();
    let set = ParameterSet::basic().with(load, 0.5).unwrap();
    let family = Family::new(&set, Span::new(load, 0.0, 1.0).unwrap()).unwrap();
    assert_eq!(family.system(&[0.2]).unwrap().loads().forces, [0.0, 0.2, 0.0]);
    assert!(!family.is_symmetric());
}

#[test]
fn symmetric_orbits_of_a_machine_under_loads_are_refused() {
    // The load shifts only the box. Whatever w_s is, the mirror image is not a motion of the
    // machine.
    let family = loaded(1.0, 2.0, "load.box", 0.01);
    let system = family.system(&[1.5]).unwrap();
    for letters in ["U", ""] {
        let word = OrbitWord::new(letters, -1, 1).unwrap();
        let guess = vec![5.5; word.len()];
        let error = Orbit::find(&system, &word, &guess).unwrap_err().to_string();
        assert!(error.contains("give the whole word"), "{error}");
        assert!(branch(&family, &word, &guess, 1.5, &PathOptions::default(), &[]).is_err());
    }
    let settled = settle(&system, &moving_block(system.parameters()), 1000).unwrap();
    assert_eq!(orbit_of(&system, &settled).unwrap().word().closing(), 1);
}

/// Number of orbits computed for a tree: twice as many mean that steps are needlessly short.
#[test]
fn invariant_a_tree_takes_no_more_steps_than_it_needs() {
    const ORBITS: usize = 3000;
    let options = TreeOptions { seeds: 21, starts: 0, ..TreeOptions::default() };
    let tree = grow(&family(2.0, 3.0), &options);
    let orbits: usize = tree.branches.iter().map(|branch| branch.points.len()).sum();
    println!("{orbits} of {} branches", tree.branches.len());
    assert!(orbits > ORBITS / 3 && orbits < ORBITS, "{orbits}");
}
