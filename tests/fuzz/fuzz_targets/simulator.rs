//! Any parameters, loads, steps and changes: no panic, no hang, no block outside the box, no lost
//! energy, and only documented errors.
//!
//! `cargo install cargo-fuzz`, then `cargo fuzz run --fuzz-dir tests/fuzz -s none simulator --
//! -max_total_time=1200` (without a sanitizer it runs on the stable toolchain; the library has no
//! unsafe code outside the C interface).

#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use vibro_numerics::double_double::DoubleDouble;
use vibro_impact::parameters::FIELDS;
use vibro_impact::simulator::{Contact, Loads, Pause};
use vibro_impact::{Error, Parameters, Simulator, State};

/// A number: a few bits choose a plain value, a value over many decades, or raw bits.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Number {
    Small(i8),
    Decade(i8, u8),
    Unit(u16),
    Raw(f64),
}

impl Number {
    fn value(self) -> f64 {
        match self {
            Self::Small(n) => f64::from(n) / 16.0,
            Self::Decade(mantissa, exponent) => f64::from(mantissa) * 10f64.powi(i32::from(exponent % 24) - 12),
            Self::Unit(n) => f64::from(n) / f64::from(u16::MAX),
            Self::Raw(x) => x,
        }
    }
}

#[derive(Arbitrary, Debug)]
enum Action {
    Step(Number),
    Load([[Number; 4]; 3]),
    Change(u8, Number),
    Restore,
}

#[derive(Arbitrary, Debug)]
struct Input {
    /// Which fields differ from the default set, and how.
    fields: Vec<(u8, Number)>,
    place: [Number; 3],
    /// Start exactly on a stop (+, -) or at `place`.
    stop: Option<bool>,
    speed: [Number; 3],
    actions: Vec<Action>,
}

/// Largest number of sub-steps of a step; longer steps are cut to keep iterations fast.
const WORK: f64 = 200.0;
/// Largest number of sub-steps of a step with nearly elastic stops, where up to 10⁶ impacts per
/// sub-step length take a tenth of a second.
const ELASTIC_WORK: f64 = 5.0;
/// Imbalance relative to the energy that passed through, or that is stored at the scale of the
/// springs.
const BALANCE: f64 = 1e-6;

fn set(p: &mut Parameters, field: u8, value: f64) {
    (FIELDS[usize::from(field) % FIELDS.len()].set)(p, value);
}

/// The fastest rate of the system, to cut steps to a bounded number of sub-steps.
fn rate(p: &Parameters) -> f64 {
    let k = p.box_stiffness / p.box_mass
        + p.coupling_stiffness * (1.0 / p.block_mass + 4.0 / p.secondary_mass)
        + p.secondary_stiffness / p.secondary_mass;
    (2.0 * k).sqrt() + p.box_damping / p.box_mass + p.secondary_damping / p.secondary_mass + p.drive_frequency
}

fn run(input: &Input) -> Option<()> {
    let mut p = Parameters::default();
    for &(field, value) in input.fields.iter().take(16) {
        set(&mut p, field, value.value());
    }
    let mut x = input.place.map(Number::value);
    if let Some(upper) = input.stop {
        x[0] = 0.0;
        x[1] = if upper { p.stop_gap } else { -p.stop_gap };
    }
    let state = State { x, v: input.speed.map(Number::value) };
    let mut simulator = Simulator::new(&p, &state, 0.0).ok()?;
    // Beyond these limits the energies differ so much in size that their balance is meaningless.
    let plain = |x: f64| x.abs() < 1e4;
    let mut comparable = state.x.iter().chain(&state.v).all(|&x| plain(x))
        && FIELDS.iter().all(|f| plain((f.get)(&p))) && p.block_mass > 1e-4 && p.box_mass > 1e-4 && p.secondary_mass > 1e-4;
    let first = simulator.energy_accounts().mechanical;
    let mut passed = first;
    let mut saved = simulator.snapshot();
    for action in input.actions.iter().take(12) {
        match action {
            Action::Step(size) => {
                let elastic = simulator.parameters().stop_restitution > 0.99;
                let work = if elastic { ELASTIC_WORK } else { WORK };
                let size = size.value().abs().min(work / rate(simulator.parameters()));
                if !size.is_finite() {
                    continue;
                }
                let time = simulator.time();
                match simulator.advance_until(DoubleDouble::sum(time, size), Pause::Never, None) {
                    Ok(_) => {}
                    Err(Error::WorkLimit { restitution, .. }) => {
                        assert!(restitution > 0.99, "only nearly elastic stops may be refused: {restitution}");
                        return None;
                    }
                    Err(error) => panic!("{error}"),
                }
            }
            Action::Load(numbers) => {
                let derivatives = numbers.map(|d| d.map(Number::value));
                comparable &= derivatives.iter().flatten().all(|&f| plain(f));
                let _ = simulator.set_loads(&Loads { derivatives });
            }
            Action::Change(field, value) => {
                let mut changed = *simulator.parameters();
                set(&mut changed, *field, value.value());
                if simulator.set_parameters(&changed).is_ok() {
                    comparable = false; // the energies' scale may have changed
                }
            }
            Action::Restore => {
                let now = simulator.snapshot();
                simulator.restore(&saved).expect("its own snapshot");
                saved = now;
            }
        }
        let gap = simulator.parameters().stop_gap;
        let (w, speed) = simulator.relative_motion();
        assert!(w.abs() <= gap, "{w} outside {gap}");
        if simulator.contact() != Contact::Flight {
            assert_eq!(speed, 0.0);
        }
        let l = simulator.energy_accounts();
        passed = passed.max(l.mechanical).max(l.input.abs()).max(l.damped).max(l.impact);
        let error = l.mechanical - first - l.input + l.damped + l.impact;
        if comparable && passed < 1e12 {
            assert!(error.abs() <= BALANCE * passed + 1e-12, "{error:e} of {passed:e}: {l:?}");
        }
    }
    Some(())
}

fuzz_target!(|input: Input| {
    run(&input);
});
