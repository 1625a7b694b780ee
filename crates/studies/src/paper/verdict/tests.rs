use super::*;
use crate::basin::{BasinRequest, Basins, basins};
use crate::class::Relation;
use crate::paper::ParameterSet;
use crate::paper::attractor::distance;
use crate::paper::basin::{ClassedAttractor, InitialValueRange, in_the_middle};
use crate::paper::motion::settled_simulator;
use crate::paper::stroboscopic::{dimensional, dimensionless, moving_block};
use crate::parts::Task;
use vibro_impact::{Parameters, State};

mod tori;

fn set(assignments: &[&str]) -> ParameterSet {
    let mut set = ParameterSet::basic();
    set.apply(&assignments.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap();
    set
}

/// A box of 12 kg with a heavy block, coupled to it only by the stops: flights over tens of drive
/// periods.
fn damper() -> ParameterSet {
    let parts =
        ["box.m=12kg", "box.k=48kN/m", "box.c=30", "block.m=0.6kg", "stop.gap=50mm", "stop.restitution=0.6"];
    let rest = [
        "drive.amplitude=75N",
        "drive.frequency=10.65Hz",
        "coupling.k=0",
        "secondary.m=1kg",
        "secondary.k=1kN/m",
        "secondary.c=1",
    ];
    set(&[&parts[..], &rest[..]].concat())
}

fn found(set: &ParameterSet, side: usize, discard: u32) -> Basins<ClassedAttractor> {
    let axis = |text: &str| text.parse::<InitialValueRange>().unwrap().cells(side);
    let request = BasinRequest { x: axis("x1=-1:1"), y: axis("v2=-2:2"), discard, start: in_the_middle() };
    basins(set, &request, &Task::ALL).unwrap().unwrap()
}

/// A short window of long flights looks like many attractors. There is one, for any number of
/// discarded periods.
#[test]
fn second_method_chaos_from_many_starts_is_one_attractor_whatever_is_discarded() {
    let one = |basin: &Basins<ClassedAttractor>, most_open: f64| {
        assert_eq!(basin.attractors.len(), 1, "{:?}", basin.attractors);
        assert_eq!(basin.attractors[0].class, MotionClass::Chaotic);
        let share: f64 = basin.shares(0).iter().sum();
        assert!(share >= 1.0 - most_open, "{share}");
    };
    // 64 starts each, none with the block at rest; one of them may be left open.
    for discard in [30, 300, 2000] {
        one(&found(&damper(), 8, discard), 0.03);
    }
    one(&found(&set(&["f10=3.6"]), 8, 300), 0.0);
}

/// A very soft spring between box and ground changes neither the motion nor the verdict, although
/// its ω10 turns the speeds of the motion into 10⁷ to 10¹⁵ units of L ω10.
#[test]
fn invariant_a_spring_of_next_to_no_stiffness_leaves_the_class() {
    for (amplitude, restitution, periods) in [(0.5, 0.75, 1), (2.0, 0.75, 2), (0.2, 0.2, 3)] {
        for stiffness in [1e-12, 1e-16, 1e-20, 1e-30] {
            let parameters = Parameters {
                box_stiffness: stiffness,
                drive_amplitude: amplitude,
                stop_restitution: restitution,
                ..Parameters::default()
            };
            let state = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };
            let class = verdict(&Start { parameters, state }, 2000).unwrap().class;
            assert_eq!(class, MotionClass::Periodic(periods), "{amplitude} {restitution} {stiffness}");
        }
    }
}

/// Next to a period doubling a motion approaches its orbit from alternating sides, and nearly
/// returns after two periods. The two stable orbits of one drive period here have multipliers
/// -0.9973 and -0.9963 (`second_method_orbits_next_to_a_doubling` in the tests of `vibro-orbits`).
#[test]
fn second_method_the_way_to_an_orbit_next_to_a_doubling_is_not_its_double() {
    for amplitude in [0.28, 1.078] {
        let parameters = Parameters { drive_amplitude: amplitude, ..Parameters::default() };
        let state = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };
        let class = verdict(&Start { parameters, state }, 1000).unwrap().class;
        assert_eq!(class, MotionClass::Periodic(1), "{amplitude}");
    }
}

/// An approach that takes 20,000 drive periods (multiplier -0.99973): until then the period is not
/// decided.
#[test]
fn second_method_an_alternating_approach_has_no_period_before_it_arrives() {
    let parameters = Parameters {
        box_stiffness: 1.8064991404472441,
        box_damping: 0.20396372155855474,
        block_mass: 0.0835207114470891,
        secondary_mass: 0.05968986226172716,
        secondary_stiffness: 0.1277933263210025,
        secondary_damping: 0.005752383143478628,
        coupling_stiffness: 0.03366124874328635,
        drive_amplitude: 3.577190335233949,
        drive_frequency: 0.3385084871765463,
        drive_phase: 8.607799103771834,
        constant_loads: [-0.29691782502816255, -0.02687982036095258, -0.024040988247657904],
        ..Parameters::default()
    };
    let state = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };
    let class = |discard| verdict(&Start { parameters, state }, discard).unwrap().class;
    // With 40,000 periods the motion is followed far enough to arrive.
    assert_eq!([300, 4000].map(class), [MotionClass::Settling; 2]);
    assert_eq!(class(40_000), MotionClass::Periodic(1));
}

/// Just below its symmetry breaking at f10 = 2.039588865238 the symmetric orbit of the closed form
/// is stable. Here its multipliers over half a period with the mirror image are -0.99991 and
/// -0.99997: on its way there a motion differs from its mirror image for 10,000 returns and more.
#[test]
fn second_method_an_alternating_approach_to_a_symmetric_orbit_is_not_asymmetric() {
    for (f10, class) in [(2.039558865238, MotionClass::Periodic(1)), (2.039578865238, MotionClass::Settling)]
    {
        let p =
            *ParameterSet::basic().with(crate::paper::find_group("f10").unwrap(), f10).unwrap().parameters();
        let orbit = vibro_impact::steady::exact_orbit::solve(&p).unwrap().upper.unwrap();
        assert!(orbit.is_stable() && orbit.spectral_radius() > 0.9999);
        let found = verdict(&Start { parameters: p, state: moving_block(&p) }, 400).unwrap();
        assert_eq!((found.class, found.attractor.period), (class, Some(1)), "{f10}");
        if class.is_decided() {
            let start = orbit.initial_state();
            assert!(found.attractor.is_symmetric());
            assert!(found.attractor.passes(&dimensionless(&p, &State { x: start.x, v: start.v })));
        }
    }
}

/// The orbit of two drive periods with four impacts at the upper stop and two at the lower stop
/// has its fold at f10 = 2.914356570079 (`vibro-orbits`). Below it there is no such orbit, and
/// motions pass its remnant in thousands of returns, none of them as exact as 1e-7.
#[test]
fn second_method_the_place_of_an_orbit_that_has_vanished_is_no_period() {
    for below in [1e-6, 4e-6, 1e-5] {
        let set =
            ParameterSet::basic().with(crate::paper::find_group("f10").unwrap(), 2.914356570079 - below);
        let p = *set.unwrap().parameters();
        let found = verdict(&Start { parameters: p, state: moving_block(&p) }, 400).unwrap();
        assert!(!matches!(found.class, MotionClass::Periodic(_)), "{below}: {:?}", found.class);
    }
}

/// A box on a very soft spring that a load drives away by two gaps per period is not periodic.
#[test]
fn invariant_a_box_that_drifts_is_not_periodic() {
    for stiffness in [1e-20, 1e-30] {
        let parameters = Parameters {
            box_stiffness: stiffness,
            coupling_stiffness: 0.0,
            constant_loads: [0.02, 0.0, 0.0],
            drive_amplitude: 0.5,
            ..Parameters::default()
        };
        let state = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };
        let class = verdict(&Start { parameters, state }, 500).unwrap().class;
        assert!(!class.is_periodic(), "{stiffness}: {class:?}");
    }
}

/// The default machine at f10 = 2.9 has a chaotic attractor with two impacts at one stop and one
/// at the other. Its mirror image is another attractor.
#[test]
fn second_method_mirror_images_of_an_asymmetric_chaotic_attractor_are_two() {
    let p = *set(&["f10=2.9"]).parameters();
    // A motion and its mirror image -x(t + T/2), from the negative state half a period later under
    // the same drive.
    let state = dimensional(&p, &[0.1, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let mut ahead = Simulator::new(&p, &state, 0.0).unwrap();
    ahead.advance_to(0.5 * p.period()).unwrap();
    let half = ahead.state();
    let reversed = vibro_impact::State { x: half.x.map(|x| -x), v: half.v.map(|v| -v) };
    let mut motions: Vec<Followed> = Vec::new();
    let starts = [state, reversed].map(|state| Start { parameters: p, state });
    let following = Following { discard: 2000, ..Following::default() };
    for start in starts {
        let mut workspace = Workspace::default();
        follow(&mut workspace, &[start], &following, &mut |_, motion, last| {
            let motion = motion.unwrap();
            if motion.stationary || last {
                motions.push(motion.clone());
            }
            motion.stationary
        });
    }
    assert!(motions.iter().all(|m| m.class == MotionClass::Chaotic), "{motions:?}");
    let [a, b] = [&motions[0].attractor, &motions[1].attractor];
    assert!(!a.is_symmetric() && (a.impacts[0] - a.impacts[1]).abs() > 0.5, "{:?}", a.impacts);
    let (own, of) = (a.statistics.unwrap(), b.statistics.unwrap());
    assert_eq!(own.likeness(&own.mirrored()), Likeness::Different);
    assert_eq!(own.likeness(&own), Likeness::Same);
    // Whichever of the two each motion ends on, the two ends are equal or mirror images.
    let relation = a.relation(b);
    assert!([Relation::Same, Relation::Mirror].contains(&relation), "{relation:?}");
    assert_eq!(relation == Relation::Same, (a.impacts[0] > a.impacts[1]) == (b.impacts[0] > b.impacts[1]));
    assert_eq!(own.likeness(&of) == Likeness::Same, relation == Relation::Same);
}

#[test]
fn closed_form_a_motion_without_impacts_comes_to_its_one_limit() {
    // The slow oscillation of block and secondary oscillator loses about a thousandth per period:
    // it nearly returns long before it has decayed.
    for f10 in ["f10=0.1", "f10=0.3"] {
        let basin = found(&set(&[f10]), 5, 100);
        let free: Vec<_> = basin.attractors.iter().filter(|a| a.attractor.is_free()).collect();
        assert!(free.len() == 1 && free[0].class == MotionClass::Periodic(1), "{f10}: {free:?}");
    }
}

#[test]
fn second_method_verdicts_of_single_motions() {
    for (f10, class) in [("f10=1.5", MotionClass::Periodic(1)), ("f10=3.6", MotionClass::Chaotic)] {
        let p = *set(&[f10]).parameters();
        let found = verdict(&Start { parameters: p, state: moving_block(&p) }, 300).unwrap();
        assert_eq!(found.class, class, "{f10}");
        assert_eq!(found.exponent.is_some(), class == MotionClass::Chaotic);
    }
    // A refusal is reported.
    let p = *set(&[]).parameters();
    let outside = vibro_impact::State { x: [0.0, 2.0 * p.stop_gap, 0.0], v: [0.0; 3] };
    assert!(verdict(&Start { parameters: p, state: outside }, 0).is_err());
}

/// Box and drive are in resonance with so little damping that the box comes back to the block only
/// tens or hundreds of periods after each burst of impacts. Alone it would swing farther than the
/// gap, so a time without impacts never proves that they have ended.
#[test]
fn second_method_impacts_that_come_in_bursts_have_not_ended() {
    let machine = |mass: f64, force: f64, damping: f64, kappa: f64, ratio: f64| Parameters {
        box_damping: damping,
        block_mass: mass,
        secondary_mass: mass,
        secondary_stiffness: mass,
        secondary_damping: ratio * mass,
        coupling_stiffness: 0.06 * mass,
        drive_amplitude: force,
        drive_frequency: 1.0,
        stop_restitution: kappa,
        ..Parameters::default()
    };
    for (p, longest, class) in [
        (machine(1.0, 1.05e-3, 1e-3, 0.75, 0.06), 64.0, MotionClass::Chaotic),
        (machine(0.3, 1.2e-3, 1e-3, 0.0, 0.6), 400.0, MotionClass::NotSettled),
        (machine(3.0, 1.2e-3, 1e-3, 0.5, 3.0), 400.0, MotionClass::NotSettled),
        // States return to within 1e-5 after one period from the start on.
        (machine(0.3, 2e-6, 1e-6, 0.75, 0.6), 0.0, MotionClass::NotSettled),
    ] {
        let start = Start { parameters: p, state: vibro_impact::State::default() };
        let mut simulator = settled_simulator(&p, &start.state, 2000.0).unwrap();
        let (mut before, mut most, mut late) = (f64::INFINITY, 0.0f64, 0);
        let end = simulator.time() + 1e4 * p.period();
        simulator
            .advance_observed(end, &mut |event| {
                if let vibro_impact::simulator::Event::Impact { time, .. } = *event {
                    most = most.max((time - before) / p.period());
                    (before, late) = (time, late + u32::from(time > 0.9 * end));
                }
            })
            .unwrap();
        assert!(
            longest == 0.0 || (most > longest && late > 0),
            "{most} periods without an impact, {late} late"
        );
        assert_eq!(verdict(&start, 2000).unwrap().class, class, "{p:?}");
    }
}

/// A machine whose box mass, box stiffness and stop gap are one.
fn unit_box() -> Parameters {
    Parameters {
        box_mass: 1.0,
        box_stiffness: 1.0,
        secondary_mass: 0.1,
        stop_gap: 1.0,
        ..Parameters::default()
    }
}

/// Machines under constant loads whose impacts end: apparent chaos, or an apparent torus, was a
/// transient.
#[test]
fn second_method_under_constant_loads_too_impacts_have_ended_where_none_will_come() {
    /// Tolerance for the remaining distance after 40,000 periods.
    const ARRIVED: f64 = 1e-9;
    let chaotic_first = Parameters {
        box_damping: 0.214_642_047_578_846_86,
        block_mass: 0.165_535_783_734_051_17,
        secondary_stiffness: 0.105_073_264_705_529_5,
        secondary_damping: 0.008_619_130_507_069_625,
        coupling_stiffness: 0.009_932_147_024_043_07,
        stop_restitution: 0.814_595_529_143_206_2,
        drive_amplitude: 0.067_710_270_320_887_51,
        drive_frequency: 1.165_137_444_135_167_8,
        constant_loads: [0.0, -0.005_240_601_619_846_177, -0.001_735_356_382_398_416_5],
        ..unit_box()
    };
    let slowly_first = Parameters {
        box_damping: 0.014_718_458_781_339_967,
        block_mass: 0.396_922_256_277_962_35,
        secondary_stiffness: 0.131_615_639_472_882_8,
        secondary_damping: 0.002_605_137_684_003_961,
        coupling_stiffness: 0.023_815_335_376_677_74,
        stop_restitution: 0.234_221_257_511_131_1,
        drive_amplitude: 0.144_583_062_519_916_5,
        drive_frequency: 0.717_006_431_637_371_4,
        constant_loads: [0.0, 0.008_293_560_289_217_556, -0.005_248_205_540_272_634_5],
        ..unit_box()
    };
    for (p, x, v) in [
        (
            chaotic_first,
            [-0.296_972_842_714_085_2, 0.172_435_826_818_641_22, 0.231_881_005_102_594_13],
            [0.281_044_196_192_279_5, -1.250_351_269_939_159_7, -0.142_995_113_726_815_73],
        ),
        (
            slowly_first,
            [0.467_308_826_964_678_7, 0.232_454_496_219_475_67, -0.370_650_866_050_606_7],
            [0.326_068_828_712_098_4, -1.148_121_272_901_127_6, -0.360_715_526_334_195_1],
        ),
    ] {
        let start = Start { parameters: p, state: State { x, v } };
        let found = verdict(&start, 300).unwrap();
        assert_eq!((found.class, found.attractor.impacts), (MotionClass::Periodic(1), [0.0; 2]), "{p:?}");
        let mut simulator = settled_simulator(&p, &start.state, 40_000.0).unwrap();
        let (before, from) = (simulator.state(), *simulator.impacts());
        simulator.advance_to(40_100.0 * p.period()).unwrap();
        let way = distance(&dimensionless(&p, &before), &dimensionless(&p, &simulator.state()));
        assert!(way < ARRIVED && *simulator.impacts() == from, "{way}");
    }
}

/// A box on a stiff spring follows the drive. Its frequency is 300 times the drive's, and chaos of
/// the block in it has exponents below a thousandth of this frequency.
#[test]
fn invariant_chaos_is_chaos_in_a_box_far_faster_than_the_drive() {
    let basic = Parameters::default();
    let fast = 300.0 * basic.drive_frequency;
    let p = Parameters {
        box_stiffness: fast * fast,
        box_damping: 0.2 * fast,
        drive_amplitude: 1.8 * fast * fast,
        ..basic
    };
    let start = Start { parameters: p, state: dimensional(&p, &[0.0, 0.5, 0.0, 0.0, 0.6 / fast, 0.0]) };
    let found = verdict(&start, 50).unwrap();
    assert_eq!(found.class, MotionClass::Chaotic);
    let exponent = found.exponent.unwrap();
    assert!(exponent.value < 1e-3 * fast && exponent.value > 6.0 * exponent.error, "{exponent:?}");
}
