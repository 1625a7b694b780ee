//! Linear blocks and sampled controllers compared with closed forms and independent programs.

use crate::common::*;
use nalgebra::{DMatrix, DVector};
use vibro_machine::derivative::{By, Gradient};
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{EventKind, Reached};
use vibro_machine::{Assembly, Description, Differentiated, Motion, Quantity, Start};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// The value of a column.
pub fn column(m: &Motion, name: &str) -> f64 {
    let all = m.assembly().description.named_quantities();
    let own = all.into_iter().find(|own| own.name == name);
    m.value(own.unwrap_or_else(|| panic!("no column {name}")).quantity)
}

/// The quantity of a column.
fn quantity(m: &Motion, name: &str) -> Quantity {
    m.assembly().description.named_quantities().into_iter().find(|own| own.name == name).unwrap().quantity
}

/// exp(A t) z of a linear system with constant inputs, whose last state is 1.
fn after(a: &[&[f64]], z: &[f64], t: f64) -> DVector<f64> {
    let a = DMatrix::from_fn(z.len(), z.len(), |i, j| a[i][j]);
    (a * t).exp() * DVector::from_column_slice(z)
}

/// Series R, L, C with a step of 1 V: v'' + (R/L) v' + v/(L C) = 1/(L C).
#[test]
fn closed_form_a_filter_of_second_order_answers_a_step() {
    let (r, l, c) = (3.0, 0.2, 0.05);
    let mut m = moving(
        r#"
        name = "Filter"
        parameters = { R = 3.0, L = 0.2, C = 0.05 }
        body.idle = { mass = 1.0 }
        spring.k = { between = ["ground", "idle"], stiffness = 1.0 }
        signal.source = { steps = [["0 s", "1 V"]] }
        [block.filter]
        inputs = ["source"]
        states = 2
        a = [["= -R/L", "= -1/L"], ["= 1/C", 0.0]]
        b = [["= 1/L"], [0.0]]
        c = [[0.0, 1.0], [1.0, 0.0]]
        outputs = ["v", "i"]
    "#
        .replace("\"1 V\"", "1.0")
        .as_str(),
    );
    let (delta, omega): (f64, f64) = (r / (2.0 * l), 1.0 / (l * c));
    let omega = (omega - delta * delta).sqrt();
    for t in [0.02, 0.1, 0.35] {
        m.advance_to(t).unwrap();
        let v = 1.0 - (-delta * t).exp() * ((omega * t).cos() + delta / omega * (omega * t).sin());
        near(column(&m, "filter.v"), v, ROUNDING);
        let i = c * (-delta * t).exp() * (omega + delta * delta / omega) * (omega * t).sin();
        near(column(&m, "filter.i"), i, ROUNDING);
        assert_eq!(column(&m, "source"), 1.0);
    }
}

/// A speed loop: m v' = -c v + u, u = kp (r - v) + ki x, x' = r - v.
#[test]
fn second_method_a_pi_controller_on_a_plant_of_first_order() {
    let mut m = moving(
        r#"
        name = "Speed"
        body.rotor = { inertia = 2.0, start = { v = 0.3 } }
        damper.oil = { between = ["ground", "rotor"], damping = 0.7 }
        signal.wanted = { constant = 1.5 }
        load.torque = { on = "rotor", from = "pi.u", factor = "1 N m" }
        [block.pi]
        inputs = ["wanted", "rotor.v"]
        states = 1
        a = [[0.0]]
        b = [[1.0, -1.0]]
        c = [[5.0]]
        d = [[4.0, -4.0]]
        outputs = ["u"]
        start = [0.2]
    "#,
    );
    let a: [&[f64]; 4] = [
        &[0.0, 1.0, 0.0, 0.0],
        &[0.0, (-0.7 - 4.0) / 2.0, 2.5, 3.0],
        &[0.0, -1.0, 0.0, 1.5],
        &[0.0, 0.0, 0.0, 0.0],
    ];
    for t in [0.1, 0.9, 4.0] {
        m.advance_to(t).unwrap();
        let z = after(&a, &[0.0, 0.3, 0.2, 1.0], t);
        near(column(&m, "rotor.s"), z[0], 10.0 * ROUNDING);
        near(column(&m, "rotor.v"), z[1], 10.0 * ROUNDING);
        let u = 4.0 * (1.5 - z[1]) + 5.0 * z[2];
        near(column(&m, "pi.u"), u, 100.0 * ROUNDING);
        near(column(&m, "torque.f"), u, 100.0 * ROUNDING);
    }
    let kinetic = m.kinetic_and_stored().0 - 0.5 * 2.0 * 0.09;
    let (work, lost) = (m.energy().loads[0].value(), m.energy().dashpots[0].value());
    near(work - lost, kinetic, 10.0 * ROUNDING);
}

/// x⁺ = x + T with y = x + 1: the output from (k + 2.5) T on is k T + 1, and initially 0.
#[test]
fn closed_form_outputs_of_a_delayed_integrator() {
    let text = r#"
        name = "Delayed"
        body.cart = { mass = 1.0 }
        load.push = { on = "cart", from = "sum.y" }
        signal.one = { constant = 1.0 }
        [block.sum]
        inputs = ["one"]
        states = 1
        a = [[1.0]]
        b = [[0.125]]
        c = [[1.0]]
        d = [[1.0]]
        outputs = ["y"]
        sample = 0.125
        delay = 0.3125
    "#;
    let mut m = moving(text);
    let (mut s, mut v, mut time) = (0.0, 0.0, 0.0);
    for k in 0..12 {
        let end = (f64::from(k) + 2.5) * 0.125;
        m.advance_to(end - 0.03).unwrap();
        let y = if k == 0 { 0.0 } else { f64::from(k - 1) * 0.125 + 1.0 };
        assert_eq!(column(&m, "sum.y"), y);
        m.advance_to(end).unwrap();
        let t = end - time;
        (s, v, time) = (s + v * t + 0.5 * y * t * t, v + y * t, end);
        near(m.coordinate(0), s, ROUNDING);
        near(m.rate(0), v, ROUNDING);
    }
    assert!(unaccounted(&m) < ROUNDING);
    // An output with a delay of whole samples acts just before the next sample is read.
    let mut m = moving(&text.replace("0.3125", "0.25").replace("c = [[1.0]]", "c = [[2.0]]"));
    m.advance_to(0.25).unwrap();
    assert_eq!(column(&m, "sum.y"), 1.0);
    m.advance_to(0.375).unwrap();
    assert_eq!(column(&m, "sum.y"), 1.25);
}

/// An integrator with limits drives a body: s = t³/6 until x = 0.3, then a constant force; its
/// state continues beyond the limit, and comes back.
#[test]
fn closed_form_the_time_of_saturation() {
    let mut m = moving(
        r#"
        name = "Limited"
        body.cart = { mass = 1.0 }
        load.push = { on = "cart", from = "ramp.y" }
        signal.rate = { constant = 1.0, steps = [[0.8, -2.0]] }
        [block.ramp]
        inputs = ["rate"]
        states = 1
        a = [[0.0]]
        b = [[1.0]]
        c = [[1.0]]
        outputs = ["y"]
        limits = { y = [-inf, 0.3] }
    "#,
    );
    let all = events(&mut m, 2.0);
    let limits: Vec<(f64, f64)> = all
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::Limit { side, .. } => Some((event.time, side)),
            _ => None,
        })
        .collect();
    assert_eq!(limits.len(), 2, "{limits:?}");
    near(limits[0].0, 0.3, ROUNDING);
    near(limits[1].0, 1.3, ROUNDING);
    assert_eq!([limits[0].1, limits[1].1], [1.0, 0.0]);
    // x: up to 0.8, down through 0.3 at 1.3, then 0.3 - (t - 1.3).
    let (s, v) = (0.3f64.powi(3) / 6.0, 0.045);
    let (s, v) = (s + v + 0.15, v + 0.3);
    let t: f64 = 0.7;
    near(m.coordinate(0), s + v * t + 0.15 * t * t - t.powi(3) / 6.0, 10.0 * ROUNDING);
    near(m.rate(0), v + 0.3 * t - 0.5 * t * t, 10.0 * ROUNDING);
    near(column(&m, "ramp.y"), -0.4, ROUNDING);
    assert!(unaccounted(&m) < ROUNDING);
}

/// The drive's controller at two positions: u of the P–P control, within limits.
struct Drive {
    kp: f64,
    kv: f64,
    period: f64,
    before: f64,
}

const MASS: f64 = 95.1089;
const VISCOUS: f64 = 203.5034;
const COULOMB: f64 = 20.3935;
const OFFSET: f64 = -3.1648;
const GAIN: f64 = 35.150_651_882_485_47;

impl Drive {
    fn output(&mut self, s: f64, wanted: f64) -> f64 {
        let rate = (s - self.before) / self.period;
        self.before = s;
        (self.kv * (self.kp * (wanted - s) - rate)).clamp(-10.0, 10.0)
    }

    /// The drive under a constant force over a time, M v' = f - Fv v - Fc sign v, piece by piece.
    fn fly([mut s, mut v]: [f64; 2], push: f64, mut left: f64) -> [f64; 2] {
        while left > 0.0 {
            let direction = if v != 0.0 {
                v.signum()
            } else if push.abs() <= COULOMB {
                return [s, 0.0];
            } else {
                push.signum()
            };
            // v' = a - λ v
            let (a, rate) = ((push - COULOMB * direction) / MASS, VISCOUS / MASS);
            let end = a / rate;
            // It comes to rest when v = end (1 - exp(-λt)) + v exp(-λt) = 0.
            let rest = if v * a < 0.0 { (1.0 - v / end).ln() / rate } else { f64::INFINITY };
            let t = left.min(rest);
            let decay = -(-rate * t).exp_m1();
            s += end * t + (v - end) * decay / rate;
            v = if rest <= left { 0.0 } else { v + (end - v) * decay };
            left -= t;
        }
        [s, v]
    }
}

/// The electro-mechanical positioning system of A. Janot, M. Gautier, M. Brunot (2019) with its
/// numbers, under position and speed control at 1 kHz.
fn drive(wanted: &str) -> String {
    format!(
        r#"
        name = "Drive"
        [parameters]
        kp = 160.18
        kv = 243.45
        T = "1 ms"
        [body.cart]
        mass = 95.1089
        [damper.viscous]
        between = ["ground", "cart"]
        damping = 203.5034
        [friction.dry]
        between = ["ground", "cart"]
        force = 20.3935
        [load.offset]
        on = "cart"
        constant = 3.1648
        [signal.wanted]
        {wanted}
        [block.pp]
        inputs = ["cart.s", "wanted"]
        states = 1
        a = [[0.0]]
        b = [[1.0, 0.0]]
        c = [["= kv/T"]]
        d = [["= -kv*kp - kv/T", "= kv*kp"]]
        outputs = ["u"]
        limits = {{ u = [-10, 10] }}
        sample = "= T"
        [load.motor]
        on = "cart"
        from = "pp.u"
        factor = "35.150651882485469 N"
    "#
    )
}

/// Error of positions caused by a rounding of 1e-16 in a voltage of kv/T = 2e5 V/m.
const PLACES: f64 = 1e-11;

#[test]
fn second_method_a_friction_drive_under_sampled_control() {
    let text = drive("table = [[0.0, 0.0], [0.4, 0.12], [0.9, 0.12], [1.2, -0.05], [2.0, -0.05]]");
    let mut m = moving(&text);
    let mut own = Drive { kp: 160.18, kv: 243.45, period: 1e-3, before: 0.0 };
    let wanted = |t: f64| match t {
        _ if t <= 0.4 => 0.3 * t,
        _ if t <= 0.9 => 0.12,
        _ if t <= 1.2 => 0.12 - 0.17 * (t - 0.9) / 0.3,
        _ => -0.05,
    };
    let (mut state, mut limited) = ([0.0; 2], 0);
    for k in 0..2000 {
        let time = 1e-3 * f64::from(k);
        let u = own.output(state[0], wanted(time));
        limited += u32::from(u.abs() == 10.0);
        state = Drive::fly(state, GAIN * u - OFFSET, 1e-3 * f64::from(k + 1) - time);
        m.advance_to(1e-3 * f64::from(k + 1)).unwrap();
        assert!((m.coordinate(0) - state[0]).abs() < PLACES, "{k}: {} {}", m.coordinate(0), state[0]);
        assert!((m.rate(0) - state[1]).abs() < 1e3 * PLACES, "{k}: {} {}", m.rate(0), state[1]);
    }
    assert!(limited > 5, "{limited}");
    assert!(unaccounted(&m) < 1e-10, "{}", unaccounted(&m));
}

/// Events of the drive: limits are events in the log, samples are not; by both laws.
#[test]
fn second_method_the_general_law_and_split_steps_of_the_drive() {
    let text = drive("steps = [[0.05, 0.002], [0.2, -0.001]]");
    let mut one = moving(&text);
    let mut all = Vec::new();
    one.advance_observed(0.4, &mut |event| all.push(event.clone())).unwrap();
    let listed: Vec<_> = all.iter().filter(|event| event.is_listed()).collect();
    assert!(listed.iter().any(|event| matches!(event.kind, EventKind::Limit { .. })));
    assert_eq!(all.len() - listed.len(), 400);
    let mut general = moving(&text).by_general_law();
    general.advance_to(0.4).unwrap();
    near(general.coordinate(0), one.coordinate(0), PLACES);
    // A saved state continues bit for bit.
    let mut split = moving(&text);
    split.advance_to(0.1234).unwrap();
    let saved = split.save();
    let mut on = Motion::resumed(split.assembly().clone(), &saved).unwrap();
    split.advance_to(0.4).unwrap();
    on.advance_to(0.4).unwrap();
    assert_eq!(split.state(), on.state());
    near(split.coordinate(0), one.coordinate(0), PLACES);
}

/// A dashpot in series with a spring, and a block with the same force: b' = k e' - (k/c) b.
#[test]
fn second_method_a_spring_in_series_is_a_block() {
    let text = |mount: &str| {
        format!(
            r#"
            name = "Mount"
            body.foot = {{ motion = {{ amplitude = 0.5, frequency = 1.3, phase = 0.4 }} }}
            body.box = {{ mass = 2.0, start = {{ s = 0.1, v = -0.3 }} }}
            spring.soft = {{ between = ["foot", "box"], stiffness = 40.0 }}
            stop.wall = {{ between = ["ground", "box"], gap = 0.4, restitution = 0.6 }}
            friction.guide = {{ between = ["ground", "box"], force = 2.0 }}
            {mount}
        "#
        )
    };
    let series = r#"spring.mount = { between = ["foot", "box"], stiffness = 100.0, series_damping = 5.0 }"#;
    let block = r#"
        load.f = { on = "box", from = "mount.f", factor = -1.0 }
        damper.none = { between = ["foot", "box"], damping = 1e-300 }
        [block.mount]
        inputs = ["none.rate"]
        states = 1
        a = [[-20.0]]
        b = [[100.0]]
        c = [[1.0]]
        outputs = ["f"]
    "#;
    // The branch begins with the force of its elongation.
    let e = 0.1 - 0.5 * 0.4f64.sin();
    let block = format!("{block}start = [{:?}]\n", 100.0 * e);
    let (mut a, mut b) = (moving(&text(series)), moving(&text(&block)));
    let mut count = 0;
    for k in 1..=40 {
        count += events(&mut a, 0.05 * f64::from(k)).len();
        b.advance_to(0.05 * f64::from(k)).unwrap();
        near(b.coordinate(1), a.coordinate(1), 1e-11);
        near(b.rate(1), a.rate(1), 1e-10);
    }
    assert!(count > 4, "{count}");
}

/// A limited block in a machine that keeps tables, and in one that keeps none.
#[test]
fn second_method_a_larger_machine_has_the_same_limits() {
    let chain: String = (0..12)
        .map(|i| {
            format!(
                "body.b{i} = {{ mass = 1.0, start = {{ s = 0.1 }} }}\nspring.k{i} = {{ between = [\"ground\", \"b{i}\"], stiffness = 7.0 }}\n"
            )
        })
        .collect();
    let text = |more: &str| {
        format!(
            r#"
            name = "Limits"
            body.cart = {{ mass = 2.0, start = {{ s = 1.0 }} }}
            stop.wall = {{ between = ["ground", "cart"], gap = 1.05, restitution = 0.7 }}
            spring.k = {{ between = ["ground", "cart"], stiffness = 1.0 }}
            load.push = {{ on = "cart", from = "smooth.y" }}
            load.drag = {{ on = "cart", from = "pd.u", factor = 0.5 }}
            {more}
            [block.pd]
            inputs = ["cart.s", "cart.v"]
            d = [[-18.0, 1.0]]
            outputs = ["u"]
            limits = {{ u = [-3, 2] }}
            [block.smooth]
            inputs = ["pd.u"]
            states = 1
            a = [[-20.0]]
            b = [[20.0]]
            c = [[1.0]]
            outputs = ["y"]
        "#
        )
    };
    let (mut a, mut b) = (moving(&text("")), moving(&text(&chain)));
    let mut general = moving(&text("")).by_general_law();
    let (begun, mut limits) = ([unaccounted(&a), unaccounted(&b)], 0);
    for k in 1..=60 {
        let t = 0.1 * f64::from(k);
        limits += events(&mut a, t).iter().filter(|e| matches!(e.kind, EventKind::Limit { .. })).count();
        b.advance_to(t).unwrap();
        general.advance_to(t).unwrap();
        for m in [&b, &general] {
            near(m.coordinate(0), a.coordinate(0), 1e-10);
            near(column(m, "pd.u"), column(&a, "pd.u"), 1e-9);
        }
        for (m, begun) in [&a, &b].into_iter().zip(begun) {
            near(unaccounted(m), begun, 1e-12);
        }
    }
    assert!(limits > 4, "{limits}");
}

/// A written machine reads back to an equal machine.
#[test]
fn invariant_blocks_are_written_and_read_back() {
    for text in
        [drive("constant = 0.0\nharmonics = [{ amplitude = 0.1, frequency = 0.5 }]"), drive("input = true")]
    {
        let text = text
            .replace("sample = ", "delay = \"0.4 ms\"\nquantum = { cart = { s = \"50 nm\" } }\nsample = ");
        let text = text.replace("\"50 nm\"", "5e-8");
        let machine = machine(&text);
        let written = machine.to_toml();
        let read = parse(&written, "written.toml", &no_records).unwrap_or_else(|e| panic!("{e}\n{written}"));
        assert_eq!(read, machine, "{written}");
    }
}

/// Derivatives at the end of a motion by columns, compared with central differences of motions.
pub fn check_derivatives(text: &str, names: &[&str], end: f64, quantities: &[&str], step: f64, allowed: f64) {
    let d = machine(text);
    let of = |d: &Description| {
        let mut m = motion(d.clone());
        m.advance_to(end).unwrap();
        quantities.iter().map(|name| column(&m, name)).collect::<Vec<f64>>()
    };
    let assembly = std::sync::Arc::new(Assembly::new(d.clone()).unwrap());
    let columns: Vec<By> = names.iter().map(|name| (*name).into()).collect();
    let mut m = Differentiated::new(assembly.clone(), &columns).unwrap();
    m.advance_to(end).unwrap();
    let mut gradient = Gradient::new(assembly, &columns).unwrap();
    gradient.advance_to(end).unwrap();
    gradient.add(quantity(gradient.motion(), quantities[0]), 1.0);
    let gradient = gradient.gradient().unwrap();
    for (p, name) in names.iter().enumerate() {
        let value = d.get(name).unwrap();
        let h = step * value.abs().max(1.0);
        let with = |value: f64| of(&d.with([(*name, value)]).unwrap());
        let (above, below) = (with(value + h), with(value - h));
        for (k, quantity) in quantities.iter().enumerate() {
            let found = m.derivative(self::quantity(m.motion(), quantity), p);
            let found = found.unwrap_or_else(|| panic!("{name}: {:?}", m.lost(p)));
            let exact = (above[k] - below[k]) / (2.0 * h);
            let size = found.abs().max(exact.abs()).max(1e-3);
            assert!((found - exact).abs() < allowed * size, "{quantity} by {name}: {found} {exact}");
            if k == 0 {
                near(*gradient[p].as_ref().unwrap(), found, 1e-9 * size);
            }
        }
    }
}

#[test]
fn second_method_derivatives_through_samples_and_limits() {
    let text = drive("steps = [[0.0505, 0.03]]\nharmonics = [{ amplitude = 0.01, frequency = 1.3 }]");
    let text = text.replace("sample = \"= T\"", "sample = \"1 ms\"\ndelay = \"1.3 ms\"\nstart = [0.001]");
    let names = [
        "kp",
        "kv",
        "body.cart.mass",
        "load.motor.factor",
        "block.pp.limits.u[1]",
        "block.pp.start[0]",
        "block.pp.b[0,0]",
        "signal.wanted.amplitude",
        "signal.wanted.steps[0].height",
        "friction.dry.force",
        "body.cart.start.s",
    ];
    check_derivatives(&text, &names, 0.1234, &["cart.s", "cart.v", "pp.u", "motor.f"], 1e-6, 1e-4);
}

#[test]
fn second_method_derivatives_of_continuous_blocks_with_limits() {
    let text = r#"
        name = "Limits"
        body.cart = { mass = 2.0, start = { s = 1.0 } }
        stop.wall = { between = ["ground", "cart"], gap = 1.05, restitution = 0.7 }
        spring.k = { between = ["ground", "cart"], stiffness = 1.0 }
        load.push = { on = "cart", from = "smooth.y" }
        load.drag = { on = "cart", from = "pd.u", factor = 0.5 }
        signal.way = { amplitude = 0.3, frequency = 0.4 }
        [block.pd]
        inputs = ["k.e", "k.rate", "way"]
        d = [[-18.0, 1.0, 2.0]]
        outputs = ["u"]
        limits = { u = [-3, 2] }
        [block.smooth]
        inputs = ["pd.u", "way"]
        states = 1
        a = [[-20.0]]
        b = [[20.0, 0.5]]
        c = [[1.0]]
        outputs = ["y"]
        start = [0.3]
    "#;
    let names = [
        "body.cart.mass",
        "stop.wall.gap",
        "load.drag.factor",
        "block.pd.d[0,0]",
        "block.pd.d[0,2]",
        "block.pd.limits.u[0]",
        "block.pd.limits.u[1]",
        "block.smooth.a[0,0]",
        "block.smooth.b[0,0]",
        "block.smooth.c[0,0]",
        "block.smooth.start[0]",
        "signal.way.frequency",
        "body.cart.start.s",
    ];
    check_derivatives(text, &names, 5.3, &["cart.s", "cart.v", "pd.u", "smooth.y", "drag.f"], 1e-6, 1e-4);
}

/// Variations of the state compared with columns for the initial state.
#[test]
fn second_method_variations_through_samples() {
    let text = drive("steps = [[0.0105, 0.004]]\nharmonics = [{ amplitude = 0.002, frequency = 1.3 }]");
    let text = text.replace("sample = \"= T\"", "sample = \"1 ms\"\ndelay = \"1.3 ms\"");
    let mut m = moving(&text);
    m.advance_to(0.0031).unwrap();
    let state = m.states().to_vec();
    let columns: Vec<By> = (0..state.len()).map(By::Start).collect();
    let mut by_columns =
        Differentiated::from_state(m.assembly().clone(), m.time(), &state, &columns).unwrap();
    by_columns.advance_to(0.05).unwrap();
    let mut variations = m.unit_variations();
    while m.advance_with(0.05, &mut variations).unwrap() == Reached::Event {}
    for (p, variation) in variations.iter().take(state.len()).enumerate() {
        let column = by_columns.state_derivative(p).unwrap();
        for (found, exact) in variation.iter().zip(&column) {
            near(*found, *exact, 1e-8 * (1.0 + exact.abs()));
        }
    }
}

/// A start written during a motion continues it, with outputs that have not acted yet.
#[test]
fn invariant_a_start_of_a_motion_goes_on() {
    let text = drive("steps = [[0.0105, 0.004]]")
        .replace("sample = \"= T\"", "sample = \"1 ms\"\ndelay = \"3.3 ms\"");
    let mut m = moving(&text);
    for time in [0.0127, 0.014] {
        m.advance_to(time).unwrap();
        let start = Start::of(&m);
        let read = Start::parse(&start.to_toml(), "start.toml", &m.assembly().description).unwrap();
        assert_eq!(read, start);
        let (mut on, mut copy) = (read.motion(m.assembly().clone()).unwrap(), m.clone());
        on.advance_to(0.05).unwrap();
        copy.advance_to(0.05).unwrap();
        near(on.coordinate(0), copy.coordinate(0), PLACES);
        near(column(&on, "pp.u"), column(&copy, "pp.u"), 1e-6);
    }
}

#[test]
fn golden_refusals_of_blocks() {
    let text = drive("constant = 0.1");
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        refusal(&text.replace(from, to))
    };
    let cases = [
        (
            "\"cart.s\", \"wanted\"",
            "\"cart.a\", \"wanted\"",
            "block.pp.inputs[0] = \"cart.a\": is an acceleration",
        ),
        (
            "\"cart.s\", \"wanted\"",
            "\"dry.f\", \"wanted\"",
            "block.pp.inputs[0] = \"dry.f\": is a force; forces of contact",
        ),
        ("\"cart.s\", \"wanted\"", "\"cart.x\", \"wanted\"", "expected one of cart.s, cart.v"),
        ("\"cart.s\", \"wanted\"", "\"cart.s\", \"wantd\"", "did you mean `wanted`?"),
        ("sample = \"= T\"", "delay = \"1 ms\"", "block.pp.delay = \"1 ms\": requires `sample`"),
        ("sample = \"= T\"", "quantum = { wanted = 1e-3 }", "requires `sample`"),
        ("sample = \"= T\"", "sample = 0.0", "block.pp.sample = 0.0: must be greater than 0"),
        (
            "u = [-10, 10]",
            "u = [10, -10]",
            "block.pp.limits.u[1] = -10: must be greater than the lower limit, 10.0",
        ),
        (
            "from = \"pp.u\"",
            "from = \"pp.v\"",
            "load.motor.from = \"pp.v\": no block has this output; expected one of pp.u",
        ),
        ("from = \"pp.u\"", "from = \"pp.u\"\nconstant = 1.0", "cannot be combined with `from`"),
        ("a = [[0.0]]", "a = [[0.0, 1.0]]", "block.pp.a[0]"),
        ("constant = 0.1", "constant = \"2 g\"", "gram or 9.80665 m/s2"),
        ("name = \"Drive\"", "name = \"Drive\"\nstart = \"rest\"", "block.pp reads cart.s"),
        ("sample =", "smaple =", "did you mean `sample`?"),
    ];
    for (from, to, said) in cases {
        let text = refused(from, to);
        assert!(text.contains(said), "{said}\n{text}");
    }
    let named = refusal(&text.replace("[signal.wanted]", "[signal.cart]").replace("\"wanted\"", "\"cart\""));
    assert!(named.contains("signal.cart: a body has this name: body.cart"), "{named}");
    // A block without outputs is refused once, not again where a load names its output.
    let without = refused("outputs = [\"u\"]\n", "");
    assert!(without.contains("block.pp.outputs: missing") && !without.contains("load.motor"), "{without}");
    let looped = refused(
        "[load.motor]",
        "[block.p]\ninputs = [\"q.y\"]\nd = [[1.0]]\noutputs = [\"y\"]\n[block.q]\ninputs = [\"p.y\"]\nd = [[1.0]]\noutputs = [\"y\"]\n[load.motor]",
    );
    assert!(looped.contains("an algebraic loop through `d`: p.y reads q.y, which reads p.y"), "{looped}");
}
