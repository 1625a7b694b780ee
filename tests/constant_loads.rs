//! Constant loads: gravity and the off-centre gap compared with independent integrations and the
//! mirror image; closed forms refuse them.

use vibro_impact::parameters::{FIELDS, LOADS};
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::Loads;
use vibro_impact::steady::exact_orbit;
use vibro_impact::{Parameters, Simulator, State};

/// Impact damper of the tutorial, upright, without a spring on its block.
fn damper() -> Parameters {
    Parameters {
        box_mass: 12.0,
        box_stiffness: 48e3,
        box_damping: 30.0,
        block_mass: 0.6,
        secondary_mass: 1.2,
        secondary_stiffness: 4800.0,
        secondary_damping: 5.0,
        coupling_stiffness: 0.0,
        stop_gap: 0.05,
        stop_restitution: 0.6,
        drive_amplitude: 75.0,
        drive_frequency: 20.0 * std::f64::consts::PI,
        drive_phase: 0.3,
        constant_loads: [0.0, -9.81 * 0.6, 0.0],
    }
}

/// [`damper`] with a coupling spring that is relaxed 4 mm off the middle of the gap.
fn off_centre() -> Parameters {
    let (k, b) = (2000.0, 0.004);
    Parameters { coupling_stiffness: k, stop_gap: 0.015, constant_loads: [0.0, -k * b, k * b], ..damper() }
}

fn largest_difference(a: &State, b: &State) -> f64 {
    (0..3).map(|i| (a.x[i] - b.x[i]).abs()).fold(0.0, f64::max)
}

#[test]
fn second_method_gravity_by_the_papers_integrator() {
    /// Error of the reference integrator at its tightest tolerance, amplified by some tens of
    /// impacts, m.
    const REFERENCE: f64 = 1e-8;
    for p in [damper(), off_centre(), Parameters { constant_loads: [3.0, 0.0, -2.0], ..off_centre() }] {
        let start = State { x: [0.0, -0.5 * p.stop_gap, 0.0], v: [0.1, 0.3, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        let mut reference = Reference::new(&p, &start, 0.0, Tolerance::new(1e-13)).unwrap();
        for i in 1..=20 {
            let end = 0.05 * f64::from(i);
            simulator.advance_to(end).unwrap();
            reference.advance_to(end).unwrap();
            let d = largest_difference(&simulator.state(), &reference.state());
            assert!(d < REFERENCE, "{p:?} at {end}: {d:e}");
        }
        assert!(simulator.impacts().upper + simulator.impacts().lower > 8, "{:?}", simulator.impacts());
        // The accounts include the work of the loads.
        let e = simulator.energy_accounts();
        let first = Simulator::new(&p, &start, 0.0).unwrap().energy_accounts().mechanical;
        let balance = first + e.input - e.damped - e.impact - e.mechanical;
        assert!(balance.abs() < 1e-10 * e.input.abs().max(1.0), "{balance:e}");
    }
}

/// Integrator of the machine in other coordinates: the block's coordinate is zero where its spring
/// is relaxed, and its stops are at unequal distances. It makes classical Runge-Kutta steps and
/// finds an impact by bisection of the step.
struct UnequalStops {
    p: Parameters,
    offset: f64,
    time: f64,
    y: [f64; 6],
    impacts: u32,
}

impl UnequalStops {
    fn slope(&self, t: f64, y: &[f64; 6]) -> [f64; 6] {
        let p = &self.p;
        let drive = p.drive_amplitude * (p.drive_frequency * t + p.drive_phase).sin();
        let stretch = y[1] - y[2];
        let a1 = (drive - p.box_stiffness * y[0] - p.box_damping * y[3]) / p.box_mass;
        let a2 = -p.coupling_stiffness * stretch / p.block_mass;
        let a3 = (p.coupling_stiffness * stretch - p.secondary_stiffness * y[2] - p.secondary_damping * y[5])
            / p.secondary_mass;
        [y[3], y[4], y[5], a1, a2, a3]
    }

    fn stepped(&self, h: f64) -> [f64; 6] {
        let add =
            |y: &[f64; 6], k: &[f64; 6], s: f64| -> [f64; 6] { std::array::from_fn(|i| y[i] + s * k[i]) };
        let (t, y) = (self.time, &self.y);
        let k1 = self.slope(t, y);
        let k2 = self.slope(t + 0.5 * h, &add(y, &k1, 0.5 * h));
        let k3 = self.slope(t + 0.5 * h, &add(y, &k2, 0.5 * h));
        let k4 = self.slope(t + h, &add(y, &k3, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// Distance of the block from the nearer stop; the stops are L + b above and L - b below.
    fn room(&self, y: &[f64; 6]) -> f64 {
        let w = y[1] - y[0];
        (self.p.stop_gap + self.offset - w).min(self.p.stop_gap - self.offset + w)
    }

    fn advance(&mut self, end: f64, h: f64) {
        while self.time < end - 1e-12 {
            let h = h.min(end - self.time);
            let next = self.stepped(h);
            if self.room(&next) > 0.0 {
                (self.y, self.time) = (next, self.time + h);
                continue;
            }
            let (mut inside, mut outside) = (0.0, h);
            for _ in 0..80 {
                let middle = 0.5 * (inside + outside);
                *(if self.room(&self.stepped(middle)) > 0.0 { &mut inside } else { &mut outside }) = middle;
            }
            (self.y, self.time) = (self.stepped(inside), self.time + inside);
            let (m1, m2) = (self.p.box_mass, self.p.block_mass);
            let push = (1.0 + self.p.stop_restitution) * (self.y[4] - self.y[3]) / (m1 + m2);
            self.y[3] += m2 * push;
            self.y[4] -= m1 * push;
            self.impacts += 1;
        }
    }
}

#[test]
fn second_method_an_off_centre_gap_by_stops_at_unequal_distances() {
    /// Error of the Runge-Kutta steps over half a second, m.
    const STEPS: f64 = 1e-9;
    let p = off_centre();
    let b = 0.004;
    // The simulator's x2 is zero in the middle of the gap, the other method's is b higher.
    let start = State { x: [0.0, -0.005, 0.0], v: [0.0, 0.4, 0.0] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    let y = [0.0, -0.005 + b, 0.0, 0.0, 0.4, 0.0];
    let mut other = UnequalStops { p, offset: b, time: 0.0, y, impacts: 0 };
    for i in 1..=10 {
        let end = 0.05 * f64::from(i);
        simulator.advance_to(end).unwrap();
        other.advance(end, 1e-5);
        let State { x: [x1, x2, x3], .. } = simulator.state();
        let d = [x1 - other.y[0], x2 + b - other.y[1], x3 - other.y[2]].map(f64::abs);
        assert!(d.iter().all(|d| *d < STEPS), "at {end}: {d:?}");
    }
    assert!(other.impacts > 3, "{}", other.impacts);
    assert_eq!(u64::from(other.impacts), simulator.impacts().upper + simulator.impacts().lower);
}

#[test]
fn invariant_the_mirror_image_of_the_loads_mirrors_the_motion() {
    /// Rounding of the drive half a period later, amplified by the impacts, m.
    const ROUNDING: f64 = 1e-10;
    for p in [damper(), off_centre()] {
        let image = Parameters {
            constant_loads: p.constant_loads.map(|f| -f),
            drive_phase: p.drive_phase + std::f64::consts::PI,
            ..p
        };
        let start = State { x: [0.001, -0.3 * p.stop_gap, 0.0], v: [0.0, 0.3, 0.1] };
        let mirrored = State { x: start.x.map(|x| -x), v: start.v.map(|v| -v) };
        let mut own = Simulator::new(&p, &start, 0.0).unwrap();
        let mut other = Simulator::new(&image, &mirrored, 0.0).unwrap();
        for i in 1..=8 {
            own.advance_to(0.05 * f64::from(i)).unwrap();
            other.advance_to(0.05 * f64::from(i)).unwrap();
            let back = other.state();
            let d = largest_difference(&own.state(), &State { x: back.x.map(|x| -x), v: back.v.map(|v| -v) });
            assert!(d < ROUNDING, "{d:e}");
        }
        let (a, b) = (own.impacts(), other.impacts());
        assert!(a.upper + a.lower > 0 && (a.upper, a.lower) == (b.lower, b.upper));
    }
}

#[test]
fn invariant_constant_loads_have_the_bits_of_loads_that_were_set_and_add_to_them() {
    let p = damper();
    let free = Parameters { constant_loads: [0.0; 3], ..p };
    let half = Parameters { constant_loads: p.constant_loads.map(|f| 0.5 * f), ..p };
    let start = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };
    let loads = |share: f64| Loads { derivatives: p.constant_loads.map(|f| [share * f, 0.0, 0.0, 0.0]) };
    let run = |p: &Parameters, loads: &Loads| {
        let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
        simulator.set_loads(loads).unwrap();
        simulator.advance_to(1.0).unwrap();
        assert_eq!(simulator.loads().derivatives[1][0], -9.81 * 0.6);
        simulator.state()
    };
    let own = run(&p, &Loads::default());
    assert_eq!(own, run(&free, &loads(1.0)));
    assert_eq!(own, run(&half, &loads(0.5)));
    // A snapshot contains the loads.
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    simulator.advance_to(0.4).unwrap();
    let kept = simulator.snapshot();
    let mut other = Simulator::new(&free, &start, 0.0).unwrap();
    other.restore(&kept).unwrap();
    other.advance_to(1.0).unwrap();
    simulator.advance_to(1.0).unwrap();
    assert_eq!(other.state(), simulator.state());
    // A change of parameters changes the loads.
    let mut changed = Simulator::new(&free, &start, 0.0).unwrap();
    changed.set_parameters(&p).unwrap();
    changed.advance_to(1.0).unwrap();
    assert_eq!(changed.state(), own);
}

#[test]
fn closed_forms_refuse_constant_loads_by_name() {
    for (load, body) in LOADS.iter().zip(0..) {
        let mut p = Parameters::default();
        (load.set)(&mut p, -0.5);
        assert_eq!(p.constant_loads[body], -0.5);
        let error = exact_orbit::solve(&p).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{} = -0.5: expected 0", load.name)), "{error}");
        (load.set)(&mut p, f64::NAN);
        let error = Simulator::new(&p, &State::default(), 0.0).unwrap_err().to_string();
        assert!(error.contains(load.name), "{error}");
        (load.set)(&mut p, 1e30);
        let error = Simulator::new(&p, &State::default(), 0.0).unwrap_err().to_string();
        assert!(error.contains("load over its body's mass"), "{error}");
    }
}

#[test]
fn what_was_left_at_the_default_is_named() {
    let p = Parameters { box_mass: 12.0, box_stiffness: 48e3, ..Parameters::default() };
    let left: Vec<&str> = p.left_at_default().iter().map(|f| f.name).collect();
    assert_eq!(left.len(), FIELDS.len() - 3, "{left:?}"); // two were given, and the phase never counts
    assert!(["drive.amplitude", "stop.gap"].iter().all(|name| left.contains(name)));
    assert!(damper().left_at_default().is_empty());
    assert!(Parameters::default().left_at_default().is_empty());
}
