//! Points of codimension two on curves over two parameters, against closed forms.

use super::*;
use crate::LocusEnd;
use std::f64::consts::PI;
use vibro_machine::Start;

/// Tolerance for a point with two conditions: rounding of a bracket's end.
const LOCATED: f64 = 1e-9;
/// Tolerance for a curve.
const ROUNDING: f64 = 1e-10;

/// The curve from the first special point of a kind on a branch.
fn curve(branch: &Branch, kind: &str, second: &Family) -> Vec<LocusPoint> {
    let is_own = |p: &OrbitPoint| p.special.as_ref().is_some_and(|s| s.label.name() == kind);
    let point = branch.points.iter().position(is_own);
    let kinds =
        || branch.points.iter().filter_map(|p| Some((p.special.clone()?, p.value))).collect::<Vec<_>>();
    let start = branch.locus_start(point.unwrap_or_else(|| panic!("{kind}: {:?}", kinds())));
    locus(&start.unwrap(), second).unwrap()
}

/// Kinds and parameters of the marked points of a curve: its ends and its points with two
/// conditions, except the ends of ranges.
fn marked(points: &[LocusPoint]) -> Vec<(LocusEnd, [f64; 2])> {
    let own = points.iter().filter_map(|p| Some((p.end?, p.values)));
    own.filter(|(end, _)| *end != LocusEnd::Range).collect()
}

/// Checks the marks of a curve, in either order.
fn check(points: &[LocusPoint], exact: &[(LocusEnd, [f64; 2])]) {
    let own = marked(points);
    let is_there = |(end, [a, b]): &(LocusEnd, [f64; 2])| {
        own.iter().any(|(kind, [c, d])| kind == end && (a - c).abs() < LOCATED && (b - d).abs() < LOCATED)
    };
    assert!(own.len() == exact.len() && exact.iter().all(is_there), "{own:?} {exact:?}");
}

/// A mass of 1 whose displacement and velocity are sampled once per load period of 1; the force
/// -kp s - kd v acts until the next sample. The load leaves both at zero at the samples.
///
/// A period's map [[1 - kp/2, 1 - kd/2], [-kp, 1 - kd]] has the trace 2 - kp/2 - kd and the
/// determinant 1 + kp/2 - kd: a multiplier -1 for kd = 2, a pair on the unit circle for kp = 2 kd
/// between its resonances 1:1 at kp = 0 and 1:2 at kp = 4, and a multiplier 1 for kp = 0.
fn sampled() -> Machine {
    machine(&format!(
        "name = \"Sampled\"\n[parameters]\nkp = 1.0\nkd = 1.0\n[body.a]\nmass = 1.0\n\
         [block.control]\ninputs = [\"a.s\", \"a.v\"]\nd = [[\"= -kp\", \"= -kd\"]]\noutputs = [\"u\"]\nsample = 1.0\n\
         [load.motor]\non = \"a\"\nfrom = \"control.u\"\n\
         [load.shaker]\non = \"a\"\namplitude = 1.0\nfrequency = 1.0\nphase = {}\n",
        0.5 * PI
    ))
}

#[test]
fn closed_form_resonances_and_fold_flip_of_a_sampled_controller() {
    let m = sampled();
    let orbit = Orbit::settled(&m, &Start::default(), 400).unwrap();
    let over = Family::new(&m, "kd", (0.2, 2.6)).unwrap();
    let second = Family::new(&m, "kp", (-1.0, 6.0)).unwrap();
    let branch = branch(&over, &orbit, &Default::default()).unwrap();
    let flips = curve(&branch, "PD", &second);
    assert!(flips.iter().all(|p| (p.values[0] - 2.0).abs() < ROUNDING), "{flips:?}");
    let (two, both) = ((LocusEnd::Resonance(-1), [2.0, 4.0]), (LocusEnd::FoldFlip, [2.0, 0.0]));
    check(&flips, &[two, both]);
}

#[test]
fn closed_form_both_ends_of_the_curve_of_a_pair_of_a_sampled_controller() {
    let m = sampled();
    let orbit = Orbit::settled(&m, &Start::default(), 400).unwrap();
    let over = Family::new(&m, "kd", (-0.5, 2.6)).unwrap();
    let second = Family::new(&m, "kp", (-1.0, 6.0)).unwrap();
    let branch = branch(&over, &orbit, &Default::default()).unwrap();
    let pairs = curve(&branch, "NS", &second);
    for LocusPoint { values: [kd, kp], angle, .. } in &pairs {
        // The trace is 2 cos of the angle.
        let cosine = 1.0 - 0.25 * kp - 0.5 * kd;
        assert!((kp - 2.0 * kd).abs() < ROUNDING, "{kd} {kp}");
        assert!(angle.is_none_or(|angle| (angle.cos() - cosine).abs() < ROUNDING), "{angle:?} {cosine}");
    }
    check(&pairs, &[(LocusEnd::Resonance(1), [0.0, 0.0]), (LocusEnd::Resonance(-1), [2.0, 4.0])]);
}

/// Two balls on a table A sin ωt, each with one bounce per period: a fold at A ω² = π g r, r = (1
/// - ε)/(1 + ε), and a flip at the hypotenuse of this and 2 g (1 + ε²)/(1 + ε)².
#[test]
fn closed_form_a_fold_of_one_ball_meets_the_flip_of_another() {
    let (g, w, e): (f64, f64, f64) = (10.0, 20.0, 0.6);
    let ball = |name: &str, restitution: f64| {
        format!(
            "body.{name} = {{ mass = 1.0, gravity = -1.0 }}\n\
             stop.{name} = {{ between = [\"{name}\", \"table\"], gap = 0.0, restitution = {restitution} }}\n"
        )
    };
    let m = machine(&format!(
        "name = \"Balls\"\ngravity = {g}\nbody.table = {{ motion = {{ amplitude = 0.03, frequency = \"{w} rad/s\" }} }}\n{}{}",
        ball("a", e),
        ball("b", 0.5)
    ));
    let fold = |e: f64| PI * g * (1.0 - e) / (1.0 + e) / (w * w);
    let flip = fold(e).hypot(2.0 * g * (1.0 + e * e) / (1.0 + e).powi(2) / (w * w));
    // Each ball leaves the table when A cos ωt is the amplitude of its fold, with the speed π g/ω.
    let mut start = Start { time: 0.05, ..Start::default() };
    for (name, e) in [("a", e), ("b", 0.5)] {
        let phase = (fold(e) / 0.03).acos();
        let flown = start.time - phase / w;
        let place = 0.03 * phase.sin() + PI * g / w * flown - 0.5 * g * flown * flown;
        start.set(&m.description, &format!("{name}.s"), place).unwrap();
        start.set(&m.description, &format!("{name}.v"), PI * g / w - g * flown).unwrap();
    }
    let orbit = Orbit::near(&m, &start, 2.0 * PI / w).unwrap();
    assert_eq!(orbit.word().len(), 2, "{}", orbit.word().in_words(&orbit.place().assembly));
    let rest = flip / (PI * g / (w * w));
    let meeting = [(LocusEnd::FoldFlip, [flip, (1.0 - rest) / (1.0 + rest)])];
    let over = Family::new(&m, "body.table.motion.amplitude", (0.024, 0.036)).unwrap();
    let second = Family::new(&m, "stop.b.restitution", (0.35, 0.55)).unwrap();
    let branch = branch(&over, &orbit, &Default::default()).unwrap();
    let folds = curve(&branch, "LP", &second);
    assert!(folds.iter().all(|p| (p.values[0] - fold(p.values[1])).abs() < ROUNDING), "{folds:?}");
    check(&folds, &meeting);
    let flips = curve(&branch, "PD", &second);
    assert!(flips.iter().all(|p| (p.values[0] - flip).abs() < ROUNDING), "{flips:?}");
    check(&flips, &meeting);
}
