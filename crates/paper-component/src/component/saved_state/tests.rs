use super::*;
use crate::component::Instance;
use crate::component::log::Silence;
use crate::component::variables::{Base, Bases, reference};
use fmi_doors::{Component as _, Model as _};
use std::path::PathBuf;

fn set(instance: &mut Instance, name: &str, value: f64) {
    let any = Bases::new("any", &[Base::Real, Base::Integer, Base::Boolean, Base::Enumeration]);
    instance.set(any, &[reference(name)], |_| value).unwrap();
}

/// A saved state for an interface type and start values, before or after initialization. No field
/// has its default, and few fields are equal.
fn state(interface: Interface, start: &[(&str, f64)], initialized: bool) -> SavedState {
    let mut instance = Instance::new(interface);
    for (name, value) in [("box.k", 1.5), ("block.m", 0.125), ("drive.phase", 0.25)].iter().chain(start) {
        set(&mut instance, name, *value);
    }
    instance.set_experiment(None, 2.0, Some(900.0)).unwrap();
    instance.enter_initialization();
    if initialized {
        instance.exit_initialization(&mut Silence).unwrap();
        set(&mut instance, "drive.amplitude", 0.175);
    }
    instance.save()
}

/// One state of each kind.
fn states() -> [(&'static str, SavedState); 4] {
    let place = &[("block.s", 0.5), ("secondary.v", -0.25), ("box.f", 0.75)];
    [
        ("none", state(Interface::CoSimulation, place, false)),
        ("simulation", state(Interface::CoSimulation, place, true)),
        ("closed", state(Interface::CoSimulation, &[("mode", 3.0)], true)),
        ("continuous", state(Interface::ModelExchange, place, true)),
    ]
}

/// The golden file: bytes of one state of each kind, and below them their text. Bytes of a version
/// never change.
fn golden() -> PathBuf {
    let name = format!("tests/data/saved_state.v{VERSION}.txt");
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes_of(text: &str) -> Vec<u8> {
    let pairs = text.as_bytes().chunks(2);
    pairs.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
}

/// If a field is added, removed, renamed, moved or changes its type, the old bytes are read
/// differently. Arithmetic does not matter: states are not stepped, only read.
#[test]
fn golden_file_of_the_layout() {
    let file = golden();
    if !file.exists() && std::env::var_os("UPDATE").is_some() {
        let line = |(name, state): &(&str, SavedState)| {
            let payload = postcard::to_stdvec(state).unwrap();
            let read = SavedState::from_payload(&payload).unwrap();
            format!("{name}\n{}\n{read:?}\n", hexadecimal(&payload))
        };
        std::fs::write(&file, states().iter().map(line).collect::<String>()).unwrap();
    }
    let text = std::fs::read_to_string(&file).unwrap_or_else(|_| {
        panic!(
            "no golden file for VERSION {VERSION}: make it with UPDATE=1 and commit it beside the older ones"
        )
    });
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3 * states().len());
    for part in lines.chunks(3) {
        let [name, bytes, meaning] = part else { panic!("{part:?}") };
        let bytes = bytes_of(bytes);
        let read = SavedState::from_payload(&bytes).map(|state| format!("{state:?}"));
        assert_eq!(
            read.as_deref().unwrap_or("refused"),
            *meaning,
            "the layout of a saved state ({name}) has changed: raise VERSION in saved_state.rs, then UPDATE=1"
        );
        let again = postcard::to_stdvec(&SavedState::from_payload(&bytes).unwrap()).unwrap();
        assert_eq!(again, bytes, "{name}");
    }
}

#[test]
fn invariant_every_state_comes_back_from_its_bytes() {
    for (name, state) in states() {
        let bytes = state.serialize().unwrap();
        assert_eq!(SavedState::deserialize(&bytes).unwrap(), state, "{name}");
    }
}

/// Bits of every kind of double: -0, a subnormal number, infinity, NaN with sign and payload.
#[test]
fn invariant_every_bit_of_a_double_comes_back() {
    let (_, mut state) = states().into_iter().next().unwrap();
    for bits in
        [1 << 63, 1, 0x7ff0 << 48, 0xfff8_dead_beef_0001, 0x7ff0_0000_0000_0001, 0x3ff5_5555_5555_5555]
    {
        state.settings.start.x[1] = f64::from_bits(bits);
        let bytes = state.serialize().unwrap();
        let back = SavedState::deserialize(&bytes).unwrap();
        assert_eq!(back.settings.start.x[1].to_bits(), bits);
        assert_eq!(back.serialize().unwrap(), bytes);
    }
}

/// `bytes` with the correct checksum at the end.
fn mended(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = bytes.len() - 8;
    let sum = fnv1a(&bytes[..length]);
    bytes[length..].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn bytes_of_others_are_refused_with_the_reason() {
    let (_, state) = states().into_iter().nth(1).unwrap();
    let bytes = state.serialize().unwrap();
    let refusal = |place: usize| {
        let mut foreign = bytes.clone();
        foreign[place] ^= 1;
        SavedState::deserialize(&mended(foreign)).unwrap_err().to_string()
    };
    assert!(refusal(0).contains("not from this FMU"), "{}", refusal(0));
    let versions = format!("version {}: expected {VERSION}", VERSION ^ 1);
    assert!(refusal(8).contains(&versions), "{}", refusal(8));
    assert!(refusal(12).contains("another build"), "{}", refusal(12));
    assert!(refusal(28).contains("bytes of payload"), "{}", refusal(28));
    let mut longer = bytes[..bytes.len() - 8].to_vec();
    longer.extend_from_slice(&[0; 9]);
    assert!(SavedState::deserialize(&mended(longer)).unwrap_err().to_string().contains("bytes of payload"));
    assert!(SavedState::deserialize(b"short").unwrap_err().to_string().contains("too few"));
}

/// A state with one altered bit is refused or continued, in bounded time and without a panic. In
/// each byte the lowest bit, which flips Booleans and enumerations, and one other bit are altered.
#[test]
fn invariant_no_bit_of_a_saved_state_makes_a_panic() {
    /// Limit, s: a step ends within a second or two, also on a busy machine.
    const LONGEST: f64 = 10.0;
    let mut found = Vec::new();
    for (name, state) in states() {
        let payload = postcard::to_stdvec(&state).unwrap();
        for bit in (0..payload.len()).flat_map(|byte| [8 * byte, 8 * byte + 1 + byte % 7]) {
            let mut altered = payload.clone();
            altered[bit / 8] ^= 1 << (bit % 8);
            let Ok(read) = SavedState::from_payload(&altered) else { continue };
            let begin = std::time::Instant::now();
            let outcome = std::panic::catch_unwind(|| {
                let mut instance = Instance::new(state.interface);
                if instance.restore(&read).is_err() {
                    return;
                }
                if name == "closed" {
                    // With extreme parameters, which a user may also set, the orbit takes minutes.
                    return;
                }
                let time = instance.time();
                for reference in crate::component::variables::VARIABLES.iter().map(|v| v.reference) {
                    let any =
                        Bases::new("any", &[Base::Real, Base::Integer, Base::Boolean, Base::Enumeration]);
                    let _ = instance.get(any, &[reference], |_, _| ());
                }
                let _ = instance.step_without_event_mode(time, 0.5, &mut Silence);
                let _ = instance.complete_integrator_step();
                let _ = instance.handle_events(&mut Silence);
                let (outputs, forces) = ([reference("box.a")], [reference("box.f")]);
                let _ = instance.directional_derivative(&outputs, &forces, &[1.0], |_, _| ());
            });
            let seconds = begin.elapsed().as_secs_f64();
            if outcome.is_err() || seconds > LONGEST {
                found.push((name, bit / 8, bit % 8, seconds, format!("{read:?}")));
            }
        }
    }
    assert!(found.is_empty(), "{} found: {:#?}", found.len(), &found[..found.len().min(12)]);
}

/// Of all combinations of phase, interface type and engine, only the ones that an instance can
/// write are accepted.
#[test]
fn states_whose_phase_does_not_go_with_what_moves_are_refused() {
    use Phase::*;
    let all = [Instantiated, Initialization, Event, Continuous, Step, StoppedEarly, Terminated, Broken];
    for (name, state) in states() {
        for phase in all {
            let possible: &[Phase] = match name {
                "none" => &[Instantiated, Initialization, Terminated],
                "continuous" => &[Event, Continuous, Terminated],
                _ => &[Event, Step, StoppedEarly, Terminated],
            };
            let mut instance = Instance::new(state.interface);
            let before = instance.save();
            let outcome = instance.restore(&SavedState { phase, ..state.clone() });
            assert_eq!(outcome.is_ok(), possible.contains(&phase), "{name} {phase:?}: {outcome:?}");
            assert_eq!(outcome.is_err(), instance.save() == before, "{name} {phase:?}");
        }
    }
}

/// The engine must belong to the interface type, in all phases.
#[test]
fn states_in_which_the_other_interface_types_motion_moves_are_refused() {
    let [_, (_, stepped), _, (_, integrated)] = states();
    for (state, engine) in [(&stepped, &integrated.engine), (&integrated, &stepped.engine)] {
        let mut instance = Instance::new(state.interface);
        for phase in [state.phase, Phase::Event, Phase::Terminated] {
            let foreign = SavedState { phase, engine: engine.clone(), ..state.clone() };
            let refusal = instance.restore(&foreign).unwrap_err().to_string();
            assert!(refusal.contains("does not match its motion"), "{phase:?}: {refusal}");
        }
    }
}

/// The order of departure is the order of the first derivative of w that is not zero; an order
/// that no motion has is refused.
#[test]
fn a_snapshot_with_an_impossible_departure_is_refused() {
    use vibro_impact::{Parameters, Simulator, State};
    // After the parameters come the time (16 bytes), six coordinates (48) and the contact (1).
    const DEPARTING: usize = size_of::<Parameters>() + 65;
    let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
    let before = simulator.snapshot();
    for order in [1, 9, 100] {
        let mut bytes = postcard::to_stdvec(&before).unwrap();
        bytes[DEPARTING] = order;
        let damaged: Snapshot = postcard::from_bytes(&bytes).unwrap();
        let error = simulator.restore(&damaged).unwrap_err().to_string();
        assert!(error.contains(&format!("order of departure = {order}: expected 0")), "{error}");
        assert_eq!(simulator.snapshot(), before);
    }
}
