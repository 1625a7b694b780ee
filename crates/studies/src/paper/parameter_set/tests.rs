//! Parameters by name: both forms, ties, files and errors.

use super::*;

/// Tolerance for the rounding of a group converted to SI and back.
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
    // Values that are valid together may be given in any order: 1 + ε σ̂1 > 0.
    assert_eq!(with(&["sigma1=-12", "epsilon=0.05"]).groups().sigma1, -12.0);
    assert_eq!(error(&["sigma1=-12"]), "sigma1 = -12: expected a finite number > -1/epsilon");
}

#[test]
fn the_drive_phase_survives_groups() {
    assert_eq!(with(&["drive.phase=0.3", "f10=2"]).parameters().drive_phase, 0.3);
}

#[test]
fn errors_name_the_nearest_and_the_range() {
    assert_eq!(
        error(&["box.mass=1"]),
        "no parameter is named `box.mass`; did you mean `box.m`? `box.m`: Mass of the box (m1), a finite number > 0"
    );
    for (wrong, right) in [
        ("kapa", "kappa"),
        ("sigma_1", "sigma1"),
        ("Epsilon", "epsilon"),
        ("stop.restitusion", "stop.restitution"),
    ] {
        assert!(error(&[&format!("{wrong}=1")]).contains(&format!("did you mean `{right}`?")), "{wrong}");
    }
    assert_eq!(error(&["kappa=1.5"]), "kappa = 1.5: expected 0 <= kappa <= 1");
    assert_eq!(error(&["box.c=-1"]), "box.c = -1: expected a finite number >= 0");
    assert_eq!(error(&["kappa=NaN"]), "kappa = NaN: expected 0 <= kappa <= 1");
    assert_eq!(error(&["kappa=x"]), "kappa = `x` is not a number: expected 0 <= kappa <= 1");
    assert_eq!(error(&["kappa"]), "`kappa`: expected name=value, e.g. kappa=0.75");
    assert!(error(&["box.k=0"]).contains("box.k > 0"));
    // If no name is near, none is suggested.
    assert!(
        error(&["speed=1"]).starts_with("no parameter is named `speed`; expected one of epsilon, kappa, f10")
    );
}

#[test]
fn symbols_of_the_paper_are_names() {
    for (symbol, name) in [
        ("m1", "box.m"),
        ("m2", "block.m"),
        ("k23", "coupling.k"),
        ("L", "stop.gap"),
        ("F10", "drive.amplitude"),
        ("f10", "f10"),
        ("omega1", "drive.frequency"),
        ("ω₁", "drive.frequency"),
        ("κ", "kappa"),
        ("σ̂₁", "sigma1"),
        ("f̂₁₀", "f10"),
        ("β²", "beta2"),
    ] {
        assert_eq!(Name::find(symbol).unwrap().name(), name, "{symbol}");
    }
    // The symbol of each label can be typed.
    for name in GROUPS.iter().map(Name::Group).chain(FIELDS.iter().map(Name::Si)) {
        let found = Name::find(name.symbol());
        assert!(found.is_ok_and(|n| n.is_same_quantity(name)) || name.symbol() == "drive phase", "{name:?}");
    }
}

#[test]
fn units_are_those_of_the_dimension() {
    for (text, value) in [
        ("box.m=12 kg", 12.0),
        ("box.m=350g", 0.35),
        ("box.m=1.5 t", 1500.0),
        ("box.k=48 kN/m", 48_000.0),
        ("box.k=48N/mm", 48_000.0),
        ("box.c=2 kN·s/m", 2000.0),
        ("stop.gap=2.1 mm", 0.0021),
        ("stop.gap=3 µm", 3e-6),
        ("stop.gap=1e-3", 0.001),
        ("drive.frequency=10 Hz", 20.0 * std::f64::consts::PI),
        ("drive.frequency=600rpm", 20.0 * std::f64::consts::PI),
        ("drive.phase=90 deg", std::f64::consts::FRAC_PI_2),
        ("stop.restitution=75 %", 0.75),
    ] {
        let name = Name::find(text.split('=').next().unwrap()).unwrap();
        let found = name.value(&with(&[text]));
        assert!((found / value - 1.0).abs() < ROUNDING, "{text}: {found}");
    }
    assert_eq!(
        error(&["stop.gap=2 kg"]),
        "stop.gap: `kg` is not one of its units; expected one of m, cm, mm, um, in, or a number without a unit, which is read in the first of these"
    );
    assert!(error(&["f10=2 N"]).starts_with("f10: `N` is not one of its units; expected one of 1, %"));
    assert!(error(&["box.m=nanogram"]).contains("is not a number"));
    for (si, text, value) in
        [("s", "2", 2.0), ("s", "1.5min", 90.0), ("m/s", "-3 mm/s", -0.003), ("m", "2 mm", 0.002)]
    {
        assert_eq!(quantity_in(si, text).map(|q| q.value), Some(value), "{text}");
    }
    let gap = Name::find("stop.gap").unwrap();
    assert!(numbers(gap, &["1", "2mm"]).unwrap_err().to_string().contains("a unit on every number"));
}

#[test]
fn a_group_is_set_by_what_it_is_made_of() {
    // Reference: a group depends on a physical parameter if it changes with it.
    for field in &FIELDS {
        // Detuned, since at σ̂30 = 0 its scale does not show.
        let one = ParameterSet { given: Given::default(), ..with(&["sigma30=0.3"]) };
        let set = one.with(field, 0.7 * (field.get)(one.parameters()) + 0.01).unwrap();
        for group in &GROUPS {
            let changes = ((group.get)(set.groups()) - (group.get)(one.groups())).abs() > 1e-9;
            assert_eq!(set.is_set(Name::Group(group)), changes, "{} by {}", group.name, field.name);
        }
    }
    assert!(with(&["f10=1.5"]).is_set(Name::find("drive.amplitude").unwrap()));
    assert!(!with(&["f10=1.5"]).is_si());
}

#[test]
fn a_machine_in_si_tells_what_was_not_given() {
    let set = with(&["box.m=12", "box.k=48 kN/m", "kappa=0.8"]);
    assert_eq!(
        set.not_given_values(),
        "box.c = 0.1 N·s/m, block.m = 0.1 kg, secondary.m = 0.1 kg, secondary.k = 0.1 N/m, \
         secondary.c = 0.006 N·s/m, coupling.k = 0.006 N/m, stop.gap = 1 m, drive.amplitude = 0.15 N, \
         drive.frequency = 1.04 rad/s"
    );
    assert!(set.caption().contains("k₁ = 48 kN/m") && set.caption().contains("stop.gap = 1 m"));
    assert_eq!(with(&["kappa=0.8"]).not_given(), []);
}

#[test]
fn a_caption_leaves_out_what_varies() {
    let name = |n| Name::find(n).unwrap();
    let caption = ParameterSet::basic().caption_but(&[name("f10")]);
    assert!(!caption.contains("f̂₁₀") && caption.contains("κ = 0.75"), "{caption}");
    // β² = ε α̂23, ε and all that changes with the box's mass are not listed here.
    let caption = ParameterSet::basic().caption_but(&[name("box.m")]);
    assert!(!caption.contains("ε =") && !caption.contains("σ̂₁ =") && caption.contains("κ"), "{caption}");
}

#[test]
fn tied_groups_keep_their_own_value_when_both_vary() {
    // μ13 follows ε only until it is set, and then keeps the value of the plane's row.
    let group = |n: &str| find_group(n).unwrap();
    let row = ParameterSet::basic().with(group("mu13"), 3.0).unwrap();
    assert_eq!(row.with(group("epsilon"), 0.2).unwrap().groups().mu13, 3.0);
    let row = ParameterSet::basic().with(group("beta2"), 0.3).unwrap();
    assert_eq!(row.with(group("epsilon"), 0.2).unwrap().groups().beta2, 0.3);
}

#[test]
fn second_method_groups_with_one_changed() {
    for base in [&["kappa=0.6"][..], &["beta2=0.2"], &["mu13=3", "box.m=12"]] {
        let set = with(base);
        for name in GROUPS.iter().map(Name::Group).chain(FIELDS.iter().map(Name::Si)) {
            for value in [-11.0, 0.0, 0.3, 2.0, f64::NAN] {
                let (found, whole) = (set.groups_with(name, value), set.with(name, value));
                assert_eq!(
                    found.map_err(|e| e.to_string()),
                    whole.map(|s| *s.groups()).map_err(|e| e.to_string())
                );
            }
        }
    }
}

#[test]
fn nothing_changes_on_an_error() {
    let mut set = ParameterSet::basic();
    assert!(set.apply(&["kappa=0.5", "f10=inf"]).is_err());
    assert_eq!(set, ParameterSet::basic());
}
