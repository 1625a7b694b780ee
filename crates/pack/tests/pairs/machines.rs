//! Machines in which every kind of element meets every kind of body and every other element, each
//! written in two ways.
//!
//! A machine has a hub, one body of each kind, and an element between the hub and each body. The
//! second form of a machine has the same motion but describes its bodies by other sections.

use std::fmt::Write;

/// A body: its sections, and its end as a sum of arm times coordinate.
pub struct Written {
    pub text: String,
    pub end: Vec<(String, f64)>,
}

/// Writes a body and its end.
fn written(text: String, end: &[(&str, f64)]) -> Written {
    Written { text, end: end.iter().map(|(name, arm)| ((*name).to_owned(), *arm)).collect() }
}

/// A body on a spring to ground.
fn mass(name: &str, mass: f64, stiffness: f64, damping: f64) -> String {
    format!(
        "[body.{name}]\nmass = {mass:?}\n[spring.{name}_ground]\nbetween = [\"ground\", \"{name}\"]\n\
         stiffness = {stiffness:?}\ndamping = {damping:?}\n"
    )
}

/// A body of one kind in both forms.
pub type Kind = fn() -> [Written; 2];

fn point() -> [Written; 2] {
    let matrix =
        "[matrix.point]\nmass = [[1.2]]\nstiffness = [[300.0]]\ndamping = [[0.8]]\nnodes = { x = 0 }\n";
    [written(mass("point", 1.2, 300.0, 0.8), &[("point", 1.0)]), written(matrix.into(), &[("point.x", 1.0)])]
}

fn wheel() -> [Written; 2] {
    let wheel = "[body.wheel]\ninertia = 0.045\n[spring.wheel_ground]\narms = { wheel = \"0.3 m\" }\n\
                 stiffness = 250.0\ndamping = 0.5\n";
    [written(wheel.into(), &[("wheel", 0.3)]), written(mass("wheel", 0.5, 250.0, 0.5), &[("wheel", 1.0)])]
}

/// 4 mm (1 - cos ωt), given by its rate and by its acceleration: the rate is exactly 0 at the
/// start, which a link requires.
fn driven() -> [Written; 2] {
    let omega = std::f64::consts::TAU * 3.0;
    let rate = format!(
        "[body.driven]\nmotion = {{ rate = {{ amplitude = {:?}, frequency = 3.0 }} }}\n",
        0.004 * omega
    );
    let acceleration = format!(
        "[body.driven]\nmotion = {{ acceleration = {{ amplitude = {:?}, frequency = 3.0, \
         phase = 1.5707963267948966 }} }}\n",
        0.004 * omega * omega
    );
    [written(rate, &[("driven", 1.0)]), written(acceleration, &[("driven", 1.0)])]
}

fn matrix() -> [Written; 2] {
    let matrix = "[matrix.chain]\nmass = [[1.0, 0.0], [0.0, 0.6]]\nstiffness = [[700.0, -400.0], [-400.0, 400.0]]\n\
                  rayleigh = [0.0, 0.002]\nnodes = { base = 0, tip = 1 }\n";
    let plain = mass("base", 1.0, 300.0, 0.6)
        + "[body.tip]\nmass = 0.6\n[spring.base_tip]\nbetween = [\"base\", \"tip\"]\nstiffness = 400.0\ndamping = 0.8\n";
    [written(matrix.into(), &[("chain.tip", 1.0)]), written(plain, &[("tip", 1.0)])]
}

fn modal() -> [Written; 2] {
    let modal = "[modal.beam]\nfrequencies = [2.5, 7.0]\nmasses = [1.0, 0.5]\ndamping_ratio = [0.02, 0.03]\n\
                 nodes = { tip = [0.9, -0.7] }\n";
    let [first, second] = [(2.5, 1.0, 0.02), (7.0, 0.5, 0.03)].map(|(f, m, ratio): (f64, f64, f64)| {
        let omega = std::f64::consts::TAU * f;
        (m, m * omega * omega, 2.0 * ratio * m * omega)
    });
    let plain = mass("first", first.0, first.1, first.2) + &mass("second", second.0, second.1, second.2);
    [written(modal.into(), &[("beam.tip", 1.0)]), written(plain, &[("first", 0.9), ("second", -0.7)])]
}

/// A body tied to another one by a link, which sees a quarter of the other inertia.
fn linked() -> [Written; 2] {
    let linked = mass("rack", 0.5, 350.0, 0.4)
        + "[body.pinion]\nmass = 1.2\n[link.teeth]\narms = { rack = 1.0, pinion = -2.0 }\n";
    [written(linked, &[("rack", 1.0)]), written(mass("rack", 0.8, 350.0, 0.4), &[("rack", 1.0)])]
}

/// The kinds of bodies.
pub const BODIES: [Kind; 6] = [point, wheel, driven, matrix, modal, linked];

/// Sections of an element called `e0` and so on. ELEMENT, ARMS and PLACE are replaced by its name,
/// its ends and its body's index; `on:` begins a load on the body itself.
pub const ELEMENTS: [&str; 31] = [
    "[spring.ELEMENT]\nARMS\nstiffness = 120.0\ndamping = 0.3\npreload = 0.5",
    "[spring.ELEMENT]\nARMS\npoints = [[-0.01, -2.0], [-0.002, -0.2], [0.001, 0.1], [0.01, 3.0]]",
    "[spring.ELEMENT]\nARMS\nstiffness = { constant = 60.0, steps = [[0.05, 50.0], [0.21, -30.0]], repeat = 0.33 }\ndamping = 0.2",
    "[spring.ELEMENT]\nARMS\nstiffness = 150.0\nseries_damping = 4.0",
    "[spring.ELEMENT]\nARMS\nstiffness = 200.0\nslip = 0.7",
    "[damper.ELEMENT]\nARMS\ndamping = 1.5",
    "[stop.ELEMENT]\nARMS\ngap = 0.004\nrestitution = 0.6",
    "[stop.ELEMENT]\nARMS\ngap = 0.003\nstiffness = 900.0\ndamping = 2.0",
    "[stop.ELEMENT]\nARMS\ngap = 0.003\nstiffness = 800.0\ndamping = 2.5\nlaw = \"elastogap\"",
    "[stop.ELEMENT]\nARMS\ngap = 0.002\nstiffness = 700.0\ndamping = 1.0\nlaw = \"pull\"",
    "[stop.ELEMENT]\nARMS\ngap = 0.0025\nstiffness = 750.0\ndamping = 1.4\nlaw = \"undamped-rebound\"",
    "[stop.ELEMENT]\nARMS\ngap = 0.001\nstiffness = { constant = 300.0, steps = [[0.11, 900.0], [0.37, -500.0]] }\ndamping = 0.7",
    "[stop.ELEMENT]\nARMS\ngap = -0.001\nstiffness = { table = [[0.0, 3.0], [0.13, 1.0], [0.29, 5.0]], interpolation = \"hold\", scale = 100.0, repeat = 0.47 }",
    "[friction.ELEMENT]\nARMS\nforce = 0.3",
    "[friction.ELEMENT]\nARMS\nforce = { constant = 0.25, amplitude = 0.1, frequency = 1.3 }\nstatic = 0.5",
    "[stop.ELEMENT_pad]\nARMS\ngap = 0.001\nstiffness = 500.0\n[friction.ELEMENT]\nARMS\nfollows = \"ELEMENT_pad\"\ncoefficient = 0.2\nstatic_coefficient = 0.3",
    "[stop.ELEMENT_pad]\nARMS\ngap = 0.0005\nstiffness = { constant = 200.0, steps = [[0.09, 500.0]] }\n[friction.ELEMENT]\nARMS\nfollows = \"ELEMENT_pad\"\ncoefficient = 0.15",
    "[freewheel.ELEMENT]\nARMS",
    "[link.ELEMENT]\nARMS",
    "on:constant = 0.3\namplitude = 1.1\nfrequency = 2.3",
    "on:sweep = { amplitude = 0.9, from = 1.0, to = 4.0, duration = 2.0 }",
    "on:table = [[0.0, 0.0], [0.2, 1.0], [0.6, -0.5]]\ninterpolation = \"cubic\"",
    "[block.ELEMENT]\ninputs = [\"hub.s\", \"hub.v\"]\nstates = 1\na = [[-3.0]]\nb = [[20.0, 1.0]]\nc = [[-1.0]]\nd = [[-30.0, -0.5]]\noutputs = [\"u\"]\nlimits = { u = [-0.25, 0.3] }\n[load.ELEMENT_force]\non = \"hub\"\nfrom = \"ELEMENT.u\"\nfactor = 1.5",
    "[damper.ELEMENT_sense]\nARMS\ndamping = 0.1\n[block.ELEMENT]\ninputs = [\"ELEMENT_sense.e\", \"ELEMENT_sense.rate\"]\nd = [[-40.0, -0.6]]\noutputs = [\"u\"]\nsample = 0.0113\ndelay = 0.004\n[load.ELEMENT_force]\non = \"hub\"\nfrom = \"ELEMENT.u\"\nfactor = 0.8",
    "[signal.ELEMENT]\namplitude = 0.5\nfrequency = 2.0\n[block.ELEMENT_gain]\ninputs = [\"ELEMENT\", \"hub.s\"]\nd = [[1.0, -20.0]]\noutputs = [\"y\"]\n[load.ELEMENT_force]\non = \"hub\"\nfrom = \"ELEMENT_gain.y\"\nfactor = 1.0",
    // A second element of each kind that appends parts at the end.
    "[stop.ELEMENT]\nARMS\ngap = 0.002\nstiffness = { constant = 400.0, steps = [[0.17, 300.0]], repeat = 0.41 }\ndamping = 1.1\nlaw = \"pull\"",
    "[spring.ELEMENT]\nARMS\nstiffness = { constant = 90.0, steps = [[0.15, -90.0], [0.4, 70.0]] }",
    "[spring.ELEMENT]\nARMS\npoints = [[-0.004, -0.5], [0.0, 0.0], [0.005, 1.5]]\ndamping = 0.2",
    "[freewheel.ELEMENT]\nARMS",
    "[spring.ELEMENT]\nARMS\nstiffness = 180.0\nslip = 0.5\ndamping = 0.1",
    "",
];

/// The differences of these numbers are every nonzero residue of 31 once: a plane of 31 lines.
pub const PLANE: [usize; 6] = [0, 1, 3, 8, 12, 18];

/// The element at a body of a machine.
pub fn element_at(machine: usize, body: usize) -> usize {
    (machine + PLANE[body]) % ELEMENTS.len()
}

/// Both forms of a machine. Element `e0` acts between the hub and the body of kind 0, and so on.
pub fn machine(number: usize) -> [String; 2] {
    [0, 1].map(|writing| {
        let mut text = format!("name = \"Pairs{number}\"\n") + &mass("hub", 0.9, 200.0, 0.6);
        text += "[load.shaker]\non = \"hub\"\namplitude = 3.0\nfrequency = 1.7\n";
        for (place, body) in BODIES.iter().enumerate() {
            let Written { text: own, end } = &body()[writing];
            text += own;
            let ends: String = end.iter().map(|(name, arm)| format!(", {}", arm_of(name, *arm))).collect();
            let arms = format!("arms = {{ hub = -1.0{ends} }}");
            let (element, name) = (ELEMENTS[element_at(number, place)], format!("e{place}"));
            // A load on a driven body acts on the hub instead.
            let Some(load) = element.strip_prefix("on:") else {
                text += &(element.replace("ARMS", &arms).replace("ELEMENT", &name) + "\n");
                continue;
            };
            for (i, (body, arm)) in end.iter().enumerate() {
                let on = if body == "driven" { "hub" } else { body };
                let _ = writeln!(text, "[load.{name}_{i}]\non = \"{on}\"\n{}", times(load, *arm));
            }
        }
        text
    })
}

/// A body's arm; the arm of a wheel is a length.
fn arm_of(name: &str, arm: f64) -> String {
    if arm == 0.3 { format!("\"{name}\" = \"{arm:?} m\"") } else { format!("\"{name}\" = {arm:?}") }
}

/// A load times a factor.
fn times(load: &str, factor: f64) -> String {
    let scaled = |line: &str| -> String {
        match line.split_once(" = ") {
            Some((key @ ("constant" | "amplitude"), value)) => {
                format!("{key} = {:?}", factor * value.parse::<f64>().expect("a number"))
            }
            _ if line.starts_with("sweep") => {
                line.replace("amplitude = 0.9", &format!("amplitude = {:?}", 0.9 * factor))
            }
            _ if line.starts_with("table") => format!("{line}\nscale = {factor:?}"),
            _ => line.to_owned(),
        }
    };
    load.lines().map(scaled).collect::<Vec<_>>().join("\n")
}
