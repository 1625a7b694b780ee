//! Parameters by name: both forms, ties, files and errors.

use super::*;

/// A group through SI and back: a few roundings.
const ROUNDING: f64 = 1e-14;

fn with(assignments: &[&str]) -> ParameterSet {
    let mut set = ParameterSet::basic();
    set.apply(assignments).unwrap();
    set
}

fn error(assignments: &[&str]) -> String {
    ParameterSet::basic().apply(assignments).unwrap_err().to_string()
}

#[test]
fn every_name_can_be_set_and_read() {
    for group in &GROUPS {
        let set = with(&[&format!("{}=0.5", group.name)]);
        assert_eq!((group.get)(set.groups()), 0.5, "{}", group.name);
    }
    for field in &FIELDS {
        let set = with(&[&format!("{}=0.5", field.name)]);
        assert_eq!((field.get)(set.parameters()), 0.5, "{}", field.name);
        let groups = set.parameters().groups().unwrap();
        assert_eq!(*set.groups(), groups, "{}", field.name);
    }
}

#[test]
fn groups_and_si_stay_in_step() {
    for group in &GROUPS {
        let set = with(&[&format!("{}=0.5", group.name), "box.m=2", "stop.gap=0.01", "kappa=0.6"]);
        let back = set.parameters().groups().unwrap();
        for g in &GROUPS {
            let (a, b) = ((g.get)(set.groups()), (g.get)(&back));
            assert!((a - b).abs() <= ROUNDING * (1.0 + a.abs()), "{} after {}: {a} {b}", g.name, group.name);
        }
        assert_eq!(set.parameters().stop_gap, 0.01);
    }
}

#[test]
fn tied_groups_follow_in_any_order() {
    for order in [["alpha23=0.5", "epsilon=0.05"], ["epsilon=0.05", "alpha23=0.5"]] {
        let g = *with(&order).groups();
        assert_eq!((g.alpha23, g.beta2, g.mu13), (0.5, 0.05 * 0.5, 20.0));
    }
    for order in [["beta2=0.3", "epsilon=0.05"], ["epsilon=0.05", "beta2=0.3"]] {
        let g = *with(&order).groups();
        assert_eq!((g.alpha23, g.beta2), (0.3 / 0.05, 0.3));
    }
    for order in [["mu13=1", "epsilon=0.05"], ["epsilon=0.05", "mu13=1"]] {
        assert_eq!(with(&order).groups().mu13, 1.0);
    }
    // What is valid together may be given in any order: 1 + ε σ̂1 > 0.
    assert_eq!(with(&["sigma1=-12", "epsilon=0.05"]).groups().sigma1, -12.0);
    assert_eq!(error(&["sigma1=-12"]), "sigma1 = -12: allowed is a finite number > -1/epsilon");
}

#[test]
fn the_drive_phase_survives_groups() {
    assert_eq!(with(&["drive.phase=0.3", "f10=2"]).parameters().drive_phase, 0.3);
}

#[test]
fn errors_name_the_nearest_and_the_range() {
    assert_eq!(
        error(&["box.mass=1"]),
        "no parameter is named `box.mass`; the nearest is `box.m`: Mass of the box (m1), a finite number > 0"
    );
    for (wrong, right) in [
        ("kapa", "kappa"),
        ("sigma_1", "sigma1"),
        ("Epsilon", "epsilon"),
        ("stop.restitusion", "stop.restitution"),
    ] {
        assert!(error(&[&format!("{wrong}=1")]).contains(&format!("the nearest is `{right}`")), "{wrong}");
    }
    assert_eq!(error(&["kappa=1.5"]), "kappa = 1.5: allowed is 0 <= kappa <= 1");
    assert_eq!(error(&["box.c=-1"]), "box.c = -1: allowed is a finite number >= 0");
    assert_eq!(error(&["kappa=NaN"]), "kappa = NaN: allowed is 0 <= kappa <= 1");
    assert_eq!(error(&["kappa=x"]), "kappa = `x` is not a number: allowed is 0 <= kappa <= 1");
    assert_eq!(error(&["kappa"]), "`kappa`: expected name=value, e.g. kappa=0.75");
    assert!(error(&["box.k=0"]).contains("box.k > 0"));
}

#[test]
fn nothing_changes_on_an_error() {
    let mut set = ParameterSet::basic();
    assert!(set.apply(&["kappa=0.5", "f10=inf"]).is_err());
    assert_eq!(set, ParameterSet::basic());
}
