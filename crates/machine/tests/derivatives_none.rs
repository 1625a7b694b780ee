//! Instants at which a motion has no derivative with respect to some of its numbers. One-sided
//! differences disagree for each lost column, and agree for each other column.

use std::sync::Arc;
use vibro_machine::derivative::{By, Cause, Extremes, Gradient};
use vibro_machine::{Assembly, Description, Differentiated, Motion, Quantity, file};

/// Step of one-sided differences, far above rounding, far below the lengths in the machines.
const STEP: f64 = 1e-7;
/// Largest error of a one-sided difference with [`STEP`]: the second derivative times the step,
/// and a rounding of 1e-15 divided by the step, amplified a hundredfold by the motion.
const NEAR: f64 = 1e-5;
/// Smallest difference between the one-sided derivatives if no derivative exists.
const APART: f64 = 1e-2;

/// A column and the reason why it is lost: element, time and cause.
type Column<'a> = (&'a str, Option<(&'a str, f64, Cause)>);

struct Case<'a> {
    text: &'a str,
    /// The state at the start, if it is given.
    state: Option<&'a [f64]>,
    end: f64,
    /// Step of the differences.
    step: f64,
}

impl Case<'_> {
    fn machine(&self) -> Description {
        file::parse(&format!("name = \"M\"\n{}", self.text), "machine.toml", &file::no_records).unwrap()
    }

    /// Coordinates and rates of all bodies after a column's number has changed; `None` if refused.
    fn changed(&self, by: &By, step: f64) -> Option<Vec<f64>> {
        let (mut machine, mut state) = (self.machine(), self.state.map(<[f64]>::to_vec));
        match by {
            By::Parameter(name) => {
                machine = machine.with([(name.as_str(), machine.get(name).unwrap() + step)]).ok()?;
            }
            By::Start(place) => state.as_mut().unwrap()[*place] += step,
            By::Time => unreachable!(),
        }
        let assembly = Arc::new(Assembly::new(machine).ok()?);
        let mut motion = match state {
            Some(state) => Motion::from_state(assembly, 0.0, &state).ok()?,
            None => Motion::new(assembly).ok()?,
        };
        motion.advance_to(self.end).ok()?;
        Some(motion.state().as_slice()[..2 * motion.assembly().system().coordinates].to_vec())
    }

    /// Compares each column with the one-sided differences.
    #[track_caller]
    fn check(&self, columns: &[Column]) {
        let by = |column: &Column| match column.0.strip_prefix("start.") {
            Some(place) => By::Start(place.parse().unwrap()),
            None => By::Parameter(column.0.into()),
        };
        let all: Vec<By> = columns.iter().map(by).collect();
        let assembly = Arc::new(Assembly::new(self.machine()).unwrap());
        let mut motion = match self.state {
            Some(state) => Differentiated::from_state(assembly, 0.0, state, &all).unwrap(),
            None => Differentiated::new(assembly, &all).unwrap(),
        };
        motion.advance_to(self.end).unwrap();
        let size = 2 * motion.motion().assembly().system().coordinates;
        let own = motion.motion().state().as_slice()[..size].to_vec();
        for (p, (name, expected)) in columns.iter().enumerate() {
            let side = |step: f64| {
                let slope = |(changed, own): (&f64, &f64)| (changed - own) / step;
                self.changed(&all[p], step).map(|state| state.iter().zip(&own).map(slope).collect::<Vec<_>>())
            };
            let sides = [side(-self.step), side(self.step)];
            let Some((element, time, cause)) = expected else {
                let found = motion.state_derivative(p).unwrap_or_else(|| panic!("{:?}", motion.lost(p)));
                for side in sides {
                    let alike =
                        side.unwrap().iter().zip(&found).all(|(a, b)| (a - b).abs() < NEAR * (1.0 + b.abs()));
                    assert!(alike, "{name}: {found:?}");
                }
                continue;
            };
            let lost = motion.lost(p).unwrap_or_else(|| panic!("{name}: {:?}", motion.state_derivative(p)));
            assert!((lost.time - time).abs() < 1e-12, "{name}: {lost}");
            assert_eq!((lost.element.as_str(), lost.cause), (*element, *cause), "{name}: {lost}");
            if let [Some(before), Some(after)] = sides {
                let apart = before.iter().zip(&after).any(|(a, b)| (a - b).abs() > APART * (1.0 + b.abs()));
                assert!(apart, "{name} has a derivative: {before:?} {after:?}");
            }
        }
    }
}

fn own(text: &str, end: f64) -> Case<'_> {
    Case { text, state: None, end, step: STEP }
}

const fn limit(element: &str) -> Option<(&str, f64, Cause)> {
    Some((element, 0.0, Cause::Limit))
}

#[test]
fn two_stops_in_parallel_are_met_at_one_instant() {
    let text = "[body.a]\nmass = 1.0\nstart = { v = 1.0 }\n\
        [stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.125\nrestitution = 0.5\n\
        [stop.y]\nbetween = [\"ground\", \"a\"]\ngap = 0.125\nrestitution = 0.5\n";
    let at = |element, cause| Some((element, 0.125, cause));
    own(text, 0.5).check(&[
        ("stop.x.gap", at("stop.y", Cause::Together)),
        ("stop.y.gap", at("stop.y", Cause::Together)),
        ("stop.x.restitution", at("stop.y", Cause::Limit)),
        ("stop.y.restitution", at("stop.y", Cause::Limit)),
        ("body.a.start.v", None),
        ("body.a.start.s", None),
        ("body.a.mass", None),
    ]);
    // If one stop has the restitution 0.75, the other one affects only the time of the impact.
    let text = text.replacen("0.5", "0.75", 1);
    own(&text, 0.5).check(&[
        ("stop.x.restitution", None),
        ("stop.y.restitution", None),
        ("stop.y.gap", at("stop.y", Cause::Together)),
    ]);
}

#[test]
fn a_start_at_a_stop_without_force_is_hit_on_one_side() {
    let text = "[body.b]\nmass = 1.0\n[body.c]\nmass = 1.0\n[body.d]\nmass = 1.0\n\
        [spring.d]\nbetween = [\"ground\", \"d\"]\nstiffness = 1.0\n[stop.y]\nbetween = [\"c\", \"b\"]\ngap = 0.0\nrestitution = 0.5\n";
    own(text, 1.0).check(&[
        ("body.b.start.v", limit("stop.y")),
        ("body.c.start.v", limit("stop.y")),
        ("body.b.start.s", limit("stop.y")),
        ("body.d.start.v", None),
        ("body.b.mass", None),
    ]);
    // Pulled away from the stop by a force that does not vary.
    let text = "[body.a]\nmass = 1.0\n[load.l]\non = \"a\"\nconstant = -1.0\n\
        [stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nrestitution = 0.5\n";
    own(text, 1.0).check(&[("body.a.start.v", limit("stop.x")), ("load.l.constant", None)]);
    // A varying load pulls it away or presses it: it never has a derivative.
    let text = text.replace("constant = -1.0", "amplitude = 0.0\nfrequency = 1.0");
    let case = own(&text, 0.5);
    let mut motion =
        Differentiated::new(Arc::new(Assembly::new(case.machine()).unwrap()), &["load.l.amplitude"]).unwrap();
    motion.advance_to(0.25).unwrap();
    assert_eq!(motion.lost(0).unwrap().element, "stop.x");
}

#[test]
fn a_start_at_the_edge_of_a_compliant_stop_is_softer_on_one_side() {
    for damping in ["0.0", "3.0"] {
        let text = format!(
            "[body.a]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 10.0\n\
             [stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nstiffness = 1000.0\ndamping = {damping}\n"
        );
        own(&text, 0.3).check(&[
            ("body.a.start.s", limit("stop.x")),
            ("body.a.start.v", limit("stop.x")),
            ("stop.x.gap", limit("stop.x")),
            ("stop.x.stiffness", None),
            ("body.a.mass", None),
        ]);
    }
}

#[test]
fn a_start_at_rest_returns_only_below_the_level_at_which_friction_slips() {
    let text = |load: f64| {
        format!(
            "[body.a]\nmass = 1.0\n[body.b]\nmass = 1.0\n[load.l]\non = \"a\"\nconstant = {load:?}\n\
             [spring.b]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n\
             [friction.x]\nbetween = [\"ground\", \"a\"]\nforce = 2.0\nstatic = 4.0\n"
        )
    };
    // Between both levels, a slipping block continues one way and sticks the other way.
    own(&text(3.0), 1.0).check(&[
        ("body.a.start.v", limit("friction.x")),
        ("body.a.start.s", None),
        ("body.b.start.v", None),
        ("load.l.constant", None),
    ]);
    let state = [0.0; 4];
    let slips = limit("friction.x");
    Case { text: &text(3.0), state: Some(&state), end: 1.0, step: STEP }.check(&[
        ("start.2", slips),
        ("start.0", None),
        ("start.3", None),
    ]);
    // Below both levels it sticks again: s = ±v²/(2(F ± 1)).
    Case { text: &text(1.0), state: Some(&state), end: 1.0, step: STEP }
        .check(&[("start.2", None), ("start.0", None)]);
    // Exactly at its level.
    let text = text(2.0).replace("static = 4.0\n", "");
    own(&text, 1.0).check(&[
        ("body.a.start.v", limit("friction.x")),
        ("load.l.constant", limit("friction.x")),
        ("friction.x.force", limit("friction.x")),
        ("body.a.mass", None),
    ]);
}

#[test]
fn a_given_start_on_a_stop_that_holds_has_no_derivative_by_its_place() {
    let text = |friction: f64| {
        format!(
            "[body.a]\nmass = 1.0\n[load.l]\non = \"a\"\nconstant = 3.0\n\
             [stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nrestitution = 0.3\n\
             [friction.x]\nbetween = [\"ground\", \"a\"]\nforce = {friction:?}\n"
        )
    };
    let state = [0.0; 2];
    for friction in [2.0, 4.0] {
        // A start behind the stop is invalid. In front of it, friction alone holds the body.
        Case { text: &text(friction), state: Some(&state), end: 1.0, step: STEP }.check(&[
            ("start.0", limit("stop.s")),
            ("stop.s.gap", limit("stop.s")),
            ("start.1", None),
            ("load.l.constant", None),
        ]);
    }
    // A stop of restitution 1 that is left with a velocity bounces forever.
    let text = "[body.a]\nmass = 1.0\n[load.l]\non = \"a\"\nconstant = 3.0\n\
        [stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nrestitution = 1.0\n";
    let case = Case { text, state: Some(&state), end: 1.0, step: STEP };
    let assembly = Arc::new(Assembly::new(case.machine()).unwrap());
    let motion = Differentiated::from_state(assembly, 0.0, &state, &[By::Start(1)]).unwrap();
    assert_eq!(motion.lost(0).unwrap().element, "stop.s");
}

#[test]
fn a_step_brings_friction_to_its_level() {
    let text = "[body.a]\nmass = 1.0\n[load.l]\non = \"a\"\nsteps = [[0.2, 2.0]]\n\
        [friction.x]\nbetween = [\"ground\", \"a\"]\nforce = 2.0\n";
    let at = Some(("friction.x", 0.2, Cause::Limit));
    own(text, 1.0).check(&[
        ("load.l.steps[0].height", at),
        ("load.l.steps[0].time", None),
        ("body.a.start.s", None),
        ("body.a.mass", None),
        ("friction.x.force", at),
    ]);
}

#[test]
fn a_prescribed_body_steps_at_the_instant_of_an_impact() {
    let text = "[body.a]\nmass = 1.0\nstart = { v = 1.0 }\n[body.p]\nmotion = { steps = [[0.125, 0.1]] }\n\
        [stop.x]\nbetween = [\"p\", \"a\"]\ngap = 0.125\nrestitution = 0.5\n";
    let at = Some(("stop.x", 0.125, Cause::Together));
    own(text, 1.0).check(&[
        ("body.a.start.v", at),
        ("body.a.start.s", at),
        ("stop.x.gap", at),
        ("body.p.motion.steps[0].time", at),
        ("body.p.motion.steps[0].height", None),
        ("stop.x.restitution", None),
    ]);
}

#[test]
fn a_gap_that_is_only_touched_on_the_way() {
    // From -0.1 with ω = 10 to +0.1, where the stop is, after half a period.
    let text = "[body.a]\nmass = 1.0\nstart = { s = -0.1 }\n[body.b]\nmass = 1.0\n\
        [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n[spring.l]\nbetween = [\"ground\", \"b\"]\nstiffness = 10.0\n";
    let touch = Some(("stop.x", std::f64::consts::PI / 10.0, Cause::Touch));
    let rigid = format!("{text}[stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nrestitution = 0.5\n");
    own(&rigid, 0.5).check(&[
        ("stop.x.gap", touch),
        ("body.a.start.s", touch),
        ("spring.k.preload", touch),
        ("stop.x.restitution", None),
        ("body.b.start.s", None),
        ("spring.l.stiffness", None),
    ]);
    // If the amplitude exceeds the gap by δ², the body hits the stop with a velocity of order δ.
    Case { step: 1e-4, ..own(&rigid, 0.5) }.check(&[("body.a.start.v", touch)]);
    // Before the touch there is a derivative; extremes after the touch have none.
    let columns = ["body.a.start.s", "body.b.start.s"];
    let assembly = Arc::new(Assembly::new(own(&rigid, 0.5).machine()).unwrap());
    let mut motion = Differentiated::new(assembly.clone(), &columns).unwrap();
    let place =
        assembly.description.named_quantities().iter().find(|own| own.name == "a.v").unwrap().quantity;
    let mut extremes = [Extremes::new(place)];
    motion.advance_with_extremes(0.3, &mut extremes, &mut |_, _| ()).unwrap();
    assert!(motion.lost(0).is_none());
    assert!((motion.state_derivative(0).unwrap()[0] - 3.0_f64.cos()).abs() < 1e-13);
    motion.advance_with_extremes(0.5, &mut extremes, &mut |_, _| ()).unwrap();
    // The maximum of the rate comes before the touch, the minimum after it.
    let by = |extreme: Option<&vibro_machine::derivative::Extreme>| extreme.unwrap().by[0].is_ok();
    assert_eq!([by(extremes[0].lowest()), by(extremes[0].highest())], [false, true]);
    // A gradient then uses columns.
    let mut sum = Gradient::new(assembly, &columns).unwrap();
    sum.advance_to(0.5).unwrap();
    sum.add(place, 1.0);
    assert!(sum.is_by_columns());
    let found = sum.gradient().unwrap();
    assert_eq!(found[0].as_ref().unwrap_err().cause, Cause::Touch);
    assert_eq!(*found[1].as_ref().unwrap(), 0.0);
    // A damped buffer is entered with δ; a buffer without a dashpot exerts a force of δ for a time
    // of √δ.
    let damped = format!(
        "{text}[stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nstiffness = 500.0\ndamping = 3.0\n"
    );
    own(&damped, 0.5).check(&[("stop.x.gap", touch), ("body.a.start.s", touch), ("stop.x.stiffness", None)]);
    let smooth = format!("{text}[stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nstiffness = 5.0\n");
    let assembly = Arc::new(Assembly::new(own(&smooth, 0.5).machine()).unwrap());
    let mut motion = Differentiated::new(assembly, &["stop.x.gap"]).unwrap();
    motion.advance_to(0.5).unwrap();
    assert!(motion.lost(0).is_none());
}

/// A touch in a chain so long that its motion uses series without tables.
#[test]
fn a_gap_that_is_only_touched_in_a_large_machine() {
    use std::fmt::Write as _;
    let mut text = String::from(
        "[body.a]\nmass = 1.0\nstart = { s = -0.1 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n\
         [stop.x]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nrestitution = 0.5\n",
    );
    for i in 1..13 {
        let _ = write!(text, "[body.b{i}]\nmass = 1.0\nstart = {{ s = 0.01 }}\n");
        let _ = write!(text, "[spring.s{i}]\nbetween = [\"ground\", \"b{i}\"]\nstiffness = {i}9.0\n");
    }
    let touch = Some(("stop.x", std::f64::consts::PI / 10.0, Cause::Touch));
    own(&text, 0.5).check(&[("stop.x.gap", touch), ("body.a.start.s", touch), ("body.b3.start.s", None)]);
}

#[test]
fn friction_with_a_static_level_that_a_load_only_reaches() {
    let text = |force: f64| {
        format!(
            "[body.a]\nmass = 1.0\n[load.l]\non = \"a\"\namplitude = 2.0\nfrequency = 1.0\n\
             [friction.x]\nbetween = [\"ground\", \"a\"]\nforce = {force:?}\nstatic = 2.0\n"
        )
    };
    let touch = Some(("friction.x", 0.25, Cause::Touch));
    own(&text(1.0), 0.6).check(&[
        ("load.l.amplitude", touch),
        ("friction.x.static", touch),
        ("body.a.start.s", None),
        ("friction.x.force", None),
    ]);
    // If the level does not drop, it slips by δ√δ.
    let text = text(2.0).replace("static = 2.0\n", "");
    let assembly = Arc::new(Assembly::new(own(&text, 0.6).machine()).unwrap());
    let mut motion = Differentiated::new(assembly, &["load.l.amplitude"]).unwrap();
    motion.advance_to(0.6).unwrap();
    assert_eq!(motion.state_derivative(0).unwrap(), [0.0, 0.0]);
}

#[test]
fn shares_that_the_law_leaves_open_have_no_derivative() {
    let text = "name = \"L\"\n[body.a]\nmass = 2.0\n[body.b]\nmass = 0.4\n[link.x]\narms = { a = 1.6, b = -1.9 }\n\
        [friction.f]\nbetween = [\"ground\", \"a\"]\nforce = { constant = 4.7, amplitude = 4.4, frequency = 15.0 }\n\
        [friction.g]\nbetween = [\"a\", \"b\"]\nforce = 7.5\n\
        [load.l]\non = \"b\"\namplitude = 8.0\nfrequency = 4.0\nphase = 2.0\n";
    let assembly = Arc::new(Assembly::new(file::parse(text, "l.toml", &file::no_records).unwrap()).unwrap());
    let quantity = |name: &str| -> Quantity {
        assembly.description.named_quantities().iter().find(|own| own.name == name).unwrap().quantity
    };
    let (f, load) = (quantity("f.f"), quantity("l.f"));
    let mut motion = Differentiated::new(assembly.clone(), &["load.l.amplitude"]).unwrap();
    let mut sum = Gradient::new(assembly.clone(), &["load.l.amplitude"]).unwrap();
    let mut open = 0;
    for k in 1..=90 {
        let time = f64::from(k) * 1e-3;
        motion.advance_to(time).unwrap();
        let mode = motion.motion().mode();
        open += usize::from(!mode.is_independent());
        assert_eq!(motion.derivative(f, 0).is_none(), !mode.is_independent(), "{time}");
        assert_eq!(motion.derivative(f, 0).is_none(), motion.derivative(quantity("g.f"), 0).is_none());
        let exact = (std::f64::consts::TAU * 4.0 * time + 2.0).sin();
        assert!((motion.derivative(load, 0).unwrap() - exact).abs() < 1e-12);
        assert!(motion.lost(0).is_none());
        if open == 1 {
            sum.advance_to(time).unwrap();
            sum.add(f, 1.0);
        }
    }
    assert!(open > 20, "{open}");
    let lost = sum.gradient().unwrap().remove(0).unwrap_err();
    assert_eq!((lost.element.as_str(), lost.cause), ("f.f", Cause::Shared));
}

#[test]
fn a_lash_that_is_passed_within_a_piece_of_a_record_is_no_touch() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/valve_train.toml");
    let machine = file::read(std::path::Path::new(path)).unwrap();
    let (gap, end) = ("stop.lash.gap", 7e-3);
    let lift = |by: f64| {
        let changed = machine.with([(gap, machine.get(gap).unwrap() + by)]).unwrap();
        let mut motion = Motion::new(Arc::new(Assembly::new(changed).unwrap())).unwrap();
        motion.advance_to(end).unwrap();
        motion.state()[0]
    };
    let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
    let mut motion = Differentiated::new(assembly, &[By::Parameter(gap.into())]).unwrap();
    motion.advance_to(end).unwrap();
    let found = motion.state_derivative(0).unwrap_or_else(|| panic!("{:?}", motion.lost(0)))[0];
    // The lash is 0.15 mm, the lift 0.2 mm.
    let step = 1e-9;
    for side in [-step, step] {
        let slope = (lift(side) - lift(0.0)) / side;
        assert!((slope - found).abs() < NEAR, "{slope} {found}");
    }
}
