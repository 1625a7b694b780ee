//! Branches against closed forms of their special points, and families with known branches.

use crate::error::{Error, Result};
use crate::parameters::{FIELDS, Groups, Parameters, Scales};
use crate::steady::continuation::{self, Branch, Family, LOCATION, Special};
use crate::steady::multiple_scales::{Manifold, MultipleScales};
use crate::steady::{Bifurcation, Sheet, exact_orbit};

/// Tolerance: half a unit of the last digit of the golden lower end of the stable range.
const GOLDEN_LOW: f64 = 5e-4;
/// Tolerance: half a unit of the last digit of the golden upper end of the stable range.
const GOLDEN_HIGH: f64 = 5e-3;
/// Tolerance for a multiplier at a located special point; a multiplier moves at most a hundred
/// times as fast as the parameter.
const MULTIPLIER: f64 = 1e-9;
/// Tolerance for multipliers at a fold, where they move with the square root of the parameter.
const AT_FOLD: f64 = 1e-4;

/// Tolerance for an impulse between a fold and its neighbour, where the impulse moves with the
/// square root of the parameter.
const IMPULSE_ROUNDING: f64 = 1e-7;
/// Largest step of the impulse between the nodes of a curve without jumps.
const IMPULSE_STEP: f64 = 0.02;
/// Tolerance for a located complex pair of multipliers that is nearly double and moves with the
/// square root of the parameter.
const LOCATED_PAIR: f64 = 1e-7;
/// Tolerance for a located multiplier -1 that is nearly double.
const LOCATED_BREAKING: f64 = 1e-6;

fn force(f10: f64) -> Result<Parameters> {
    Groups { f10, ..Groups::basic() }.to_parameters(Scales::default())
}

fn values<P>(branch: &Branch<P>, kind: Special) -> Vec<f64> {
    branch.specials().filter(|p| p.special == Some(kind)).map(|p| p.value).collect()
}

const BREAKING: Special = Special::Bifurcation(Bifurcation::SymmetryBreaking);

#[test]
fn golden_stable_range_of_the_exact_orbit() {
    let branch = continuation::exact_orbit(force, (0.3, 3.0), 300).unwrap();
    let stable: Vec<_> = branch.curves.iter().flat_map(|c| &c.points).filter(|p| p.stable).collect();
    let low = stable.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
    assert!((low - 0.915).abs() < GOLDEN_LOW, "{low}");
    let breaking = values(&branch, BREAKING);
    assert!(breaking.len() == 1 && (breaking[0] - 2.04).abs() < GOLDEN_HIGH, "{breaking:?}");
    let at = branch.specials().find(|p| p.special == Some(BREAKING)).unwrap();
    assert!((at.solution.spectral_radius() - 1.0).abs() < MULTIPLIER);
    assert_eq!(at.solution.bifurcation(), Bifurcation::SymmetryBreaking);
    // Below this range a complex pair is outside the unit circle.
    let torus = values(&branch, Special::Bifurcation(Bifurcation::NeimarkSacker));
    assert!(torus.len() == 1 && (torus[0] - low).abs() < MULTIPLIER, "{torus:?}");
}

#[test]
fn closed_form_of_the_fold() {
    let branch = continuation::exact_orbit(force, (0.3, 3.0), 50).unwrap();
    let folds = values(&branch, Special::Fold);
    assert_eq!(folds.len(), 1);
    // |Hw| is proportional to f̂10, and the fold is where |Hw| = R/√(Gw²+R²): both follow from the
    // quadratic at any f̂10.
    let (square, twice, constant) = exact_orbit::OrbitFamily::new(&force(1.0).unwrap()).unwrap().quadratic();
    let per_force = 1.0 - constant;
    let fold = ((1.0 - 0.25 * twice * twice / square) / per_force).sqrt();
    assert!((folds[0] - fold).abs() < LOCATION, "{} {fold}", folds[0]);
    let at = branch.specials().find(|p| p.special == Some(Special::Fold)).unwrap();
    assert!(at.solution.multipliers().iter().any(|m| (m - 1.0).norm() < AT_FOLD));
}

#[test]
fn invariant_one_curve_runs_over_both_sheets_through_the_fold() {
    let branch = continuation::exact_orbit(force, (0.3, 3.0), 80).unwrap();
    assert_eq!(
        branch.curves.len(),
        1,
        "{:?}",
        branch.curves.iter().map(|c| c.points.len()).collect::<Vec<_>>()
    );
    let points = &branch.curves[0].points;
    let fold = points.iter().position(|p| p.special == Some(Special::Fold)).unwrap();
    assert!(points[..fold].iter().all(|p| p.sheet == Sheet::Lower));
    assert!(points[fold + 1..].iter().all(|p| p.sheet == Sheet::Upper));
    // Impulses rise along the whole curve, without a jump.
    for w in points.windows(2) {
        assert!(w[1].solution.impulse() >= w[0].solution.impulse() - IMPULSE_ROUNDING);
        assert!(w[1].solution.impulse() - w[0].solution.impulse() < IMPULSE_STEP);
    }
    assert_eq!(points[0].special, Some(Special::Vanishing));
    assert_eq!(points[points.len() - 1].special, Some(Special::RangeEnd));
}

#[test]
fn closed_form_of_the_special_points_of_multiple_scales() {
    let path = |f10| Ok(Groups { f10, ..Groups::basic() });
    let branch = continuation::multiple_scales(path, (0.2, 12.0), 300).unwrap();
    let flow = MultipleScales::new(&Groups::basic()).unwrap();
    let manifold = Manifold::new(0.75).unwrap();
    let range = flow.force_range().unwrap();
    let (low, high) = range.admissible.unwrap();
    let near = |kind, expected: f64| {
        let found = values(&branch, kind);
        assert!(
            found.iter().any(|v| (v - expected).abs() < 10.0 * LOCATION),
            "{kind:?} {expected}: {found:?}"
        );
    };
    near(Special::Fold, range.real_from);
    near(Special::Bifurcation(Bifurcation::SaddleNode), flow.force(manifold.c_smin()));
    near(BREAKING, high);
    near(BREAKING, flow.force(manifold.c_smax()));
    near(Special::Grazing, flow.force(manifold.c_gmax()));
    near(Special::Vanishing, range.two_until);
    for point in branch.curves.iter().flat_map(|c| &c.points).filter(|p| p.special.is_none()) {
        let inside = point.sheet == Sheet::Upper && point.value > low && point.value < high;
        assert_eq!(point.stable, inside, "{}", point.value);
    }
}

#[test]
fn invariant_every_change_of_stability_has_its_special_point() {
    let field = |name: &str| FIELDS.iter().find(|f| f.name == name).unwrap();
    for (name, range) in [
        ("drive.frequency", (0.85, 1.3)),
        ("stop.restitution", (0.0, 1.0)),
        ("box.c", (0.01, 0.4)),
        ("block.m", (0.02, 0.6)),
        ("coupling.k", (0.0, 0.2)),
        ("drive.amplitude", (-0.4, 0.4)),
    ] {
        let path = continuation::along_field(Parameters::default(), field(name));
        let branch = continuation::exact_orbit(path, range, 200).unwrap();
        assert!(!branch.curves.is_empty(), "{name}");
        for curve in &branch.curves {
            for w in curve.points.windows(2) {
                let silent = w[0].special.is_none() && w[1].special.is_none();
                assert!(
                    !silent || w[0].stable == w[1].stable,
                    "{name} between {} and {}",
                    w[0].value,
                    w[1].value
                );
            }
        }
    }
}

#[test]
fn invariant_located_multipliers_are_on_the_circle() {
    let mut seen = 0;
    for kappa in [0.4, 0.6, 0.75, 0.9] {
        for alpha23 in [0.1, 0.6, 2.0] {
            let path = |sigma1| {
                Groups::weak(0.1, kappa, 1.5, sigma1, 0.3, alpha23, 0.2, 0.1).to_parameters(Scales::default())
            };
            let branch = continuation::exact_orbit(path, (-1.5, 1.5), 300).unwrap();
            for p in branch.specials() {
                let multipliers = p.solution.multipliers();
                let on_circle = |m: &nalgebra::Complex<f64>| (m.norm() - 1.0).abs() < LOCATED_PAIR;
                match p.special {
                    Some(Special::Bifurcation(Bifurcation::SymmetryBreaking)) => {
                        assert!(multipliers.iter().any(|m| (m + 1.0).norm() < LOCATED_BREAKING));
                        seen += 1;
                    }
                    Some(Special::Bifurcation(_)) => {
                        assert!(multipliers.iter().any(|m| m.im != 0.0 && on_circle(m)));
                        seen += 1;
                    }
                    _ => {}
                }
            }
        }
    }
    assert!(seen > 5, "{seen}");
}

#[test]
fn second_method_branches_without_coupling() {
    let a = continuation::strong_coupling(
        |f10| Ok(Groups { f10, beta2: 0.0, ..Groups::basic() }),
        (0.3, 4.0),
        100,
    );
    let b = continuation::multiple_scales(
        |f10| Ok(Groups { f10, beta2: 0.0, ..Groups::basic() }),
        (0.3, 4.0),
        100,
    );
    let (a, b) = (a.unwrap(), b.unwrap());
    let a: Vec<_> = a.specials().map(|p| (p.value, p.special)).collect();
    let b: Vec<_> = b.specials().map(|p| (p.value, p.special)).collect();
    assert_eq!(a.len(), b.len(), "{a:?}\n{b:?}");
    for (x, y) in a.iter().zip(&b) {
        assert!((x.0 - y.0).abs() < 10.0 * LOCATION && x.1 == y.1, "{x:?} {y:?}");
    }
}

#[test]
fn wrong_ranges_are_errors() {
    for range in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(matches!(continuation::exact_orbit(force, range, 10), Err(Error::Range { .. })));
    }
    let path = continuation::along_field(Parameters::default(), &FIELDS[0]);
    assert!(matches!(
        continuation::exact_orbit(path, (-1.0, 1.0), 10),
        Err(Error::OutOfRange { name: "box.m", .. })
    ));
}
/// Quadratic with a known branch: root = shift ± √(size - (v - 1/3)²), a circle about (1/3,
/// shift).
#[derive(Clone, Copy)]
struct Circle {
    v: f64,
    size: f64,
    shift: f64,
}

impl Circle {
    fn branch(size: f64, shift: f64, range: (f64, f64), nodes: usize) -> Branch<f64> {
        continuation::branch(|v| Ok(Circle { v, size, shift }), range, nodes).unwrap()
    }
}

impl Family for Circle {
    type Solution = f64;
    fn discriminant(&self) -> f64 {
        self.size - (self.v - 1.0 / 3.0).powi(2)
    }
    fn root(&self, sheet: Sheet) -> Option<f64> {
        let root = self.discriminant().sqrt();
        let root = if sheet == Sheet::Upper { self.shift + root } else { self.shift - root };
        Some(root).filter(|r| !r.is_nan())
    }
    fn solution(&self, sheet: Sheet) -> Result<Option<f64>> {
        Ok(self.root(sheet).filter(|&r| r > 0.0))
    }
    fn is_stable(state: &f64) -> bool {
        *state > 2.0
    }
    fn is_clear(_: &f64) -> bool {
        true
    }
    fn tests(state: &f64) -> [f64; 3] {
        [1.0, state - 2.0, 1.0]
    }
    fn confirm(_: &f64, _: usize) -> Option<Bifurcation> {
        Some(Bifurcation::SaddleNode)
    }
}

#[test]
fn closed_form_of_an_isola_as_one_closed_curve() {
    let branch = Circle::branch(1.0, 2.5, (-3.0, 3.0), 60);
    assert_eq!(branch.curves.len(), 1);
    let curve = &branch.curves[0];
    assert!(curve.closed);
    let folds = values(&branch, Special::Fold);
    assert_eq!(folds.len(), 3); // the first again as the last
    assert!((folds[0] + 2.0 / 3.0).abs() < LOCATION && (folds[1] - 4.0 / 3.0).abs() < LOCATION);
    // Crossings of the level 2 on the lower half of the circle.
    let zeros = values(&branch, Special::Bifurcation(Bifurcation::SaddleNode));
    let half = 0.75f64.sqrt();
    assert!(
        zeros.len() == 2
            && (zeros[0] - 1.0 / 3.0 - half).abs() < LOCATION
            && (zeros[1] - 1.0 / 3.0 + half).abs() < LOCATION
    );
    for w in curve.points.windows(2) {
        let step = (w[1].value - w[0].value).hypot(w[1].solution - w[0].solution);
        assert!(step < 0.06, "the curve jumps by {step}");
        let middle = 0.5 * (w[0].solution + w[1].solution);
        assert_eq!(w[0].stable, middle > 2.0, "{} {}", w[0].value, w[0].solution);
    }
}

#[test]
fn closed_form_of_a_branch_narrower_than_the_nodes() {
    let branch = Circle::branch(1e-8, 2.5, (0.0, 1.0), 20);
    assert_eq!(branch.curves.len(), 1);
    let folds = values(&branch, Special::Fold);
    assert!((folds[0] - 1.0 / 3.0 + 1e-4).abs() < LOCATION && (folds[1] - 1.0 / 3.0 - 1e-4).abs() < LOCATION);
}

#[test]
fn closed_form_of_a_broken_isola_as_one_open_curve() {
    // The lower half dips under zero: the curve starts and ends where the root vanishes, over both
    // folds.
    let branch = Circle::branch(1.0, 0.5, (-3.0, 3.0), 60);
    assert_eq!(branch.curves.len(), 1);
    let curve = &branch.curves[0];
    assert!(!curve.closed);
    let half = 0.75f64.sqrt();
    let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
    for (end, expected) in [(first, 1.0 / 3.0 - half), (last, 1.0 / 3.0 + half)] {
        assert_eq!(end.special, Some(Special::Vanishing));
        assert!((end.value - expected).abs() < LOCATION, "{}", end.value);
    }
    assert_eq!(values(&branch, Special::Fold).len(), 2);
    // Ends of the range cut the curve, too.
    let cut = Circle::branch(1.0, 0.5, (0.0, 3.0), 60);
    assert_eq!(cut.curves.len(), 1);
    assert_eq!(cut.curves[0].points[0].special, Some(Special::RangeEnd));
}
