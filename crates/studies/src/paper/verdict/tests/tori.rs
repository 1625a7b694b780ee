//! Verdicts on tori and on motions that seem to be on a torus.

use super::*;

/// A torus whose states nearly return after twelve periods, for thousands of periods: the returns
/// fall slightly in most windows.
#[test]
fn second_method_a_torus_beside_a_resonance_is_no_approach() {
    let parameters = Parameters {
        stop_gap: 0.020_028_981_056_857_395,
        stop_restitution: 0.793_933_792_856_921,
        drive_amplitude: 0.018_960_562_957_478_48,
        drive_frequency: 0.398_639_298_115_319_95,
        ..Parameters::default()
    };
    let state = State {
        x: [0.0, -0.013_295_214_062_370_985, 0.009_342_199_018_438_838],
        v: [-0.003_355_224_913_181_934_6, -0.017_867_093_660_175_828, 0.017_261_310_442_916_976],
    };
    assert_eq!(verdict(&Start { parameters, state }, 300).unwrap().class, MotionClass::QuasiPeriodic);
    // Far beyond the limit, returns after up to 32 periods are no closer than 1e-3.
    let mut simulator = settled_simulator(&parameters, &state, 40_000.0).unwrap();
    let period = parameters.period();
    let states: Vec<_> = (0..64)
        .map(|k| {
            simulator.advance_to((40_000.0 + f64::from(k)) * period).unwrap();
            dimensionless(&parameters, &simulator.state())
        })
        .collect();
    let nearest = |lag: usize| {
        let returns = states.iter().zip(&states[lag..]).map(|(a, b)| crate::paper::attractor::distance(a, b));
        returns.fold(0.0, f64::max)
    };
    assert!((1..=32).all(|lag| nearest(lag) > 1e-3), "{:?}", nearest(12));
}

/// Next to a bifurcation into a torus a motion spirals onto a stable orbit by 10⁻³ per period. Its
/// returns oscillate many times on the way; for the second machine also while the exponent is
/// counted.
#[test]
fn second_method_a_slow_spiral_is_no_torus() {
    /// Tolerance for the remaining distance after 40,000 periods.
    const ARRIVED: f64 = 1e-9;
    let first = Parameters {
        box_damping: 0.073_269_385_037_753_2,
        block_mass: 0.082_893_284_223_003_61,
        secondary_mass: 0.148_459_377_188_506_96,
        secondary_stiffness: 0.055_484_201_039_766_42,
        secondary_damping: 0.002_515_114_937_993_421,
        coupling_stiffness: 0.004_725_931_564_775_593_5,
        stop_gap: 1.571_008_771_647_759_6,
        stop_restitution: 0.661_791_176_153_598_3,
        drive_amplitude: 0.162_685_183_738_439_07,
        drive_frequency: 0.680_169_251_653_422_9,
        ..Parameters::default()
    };
    let second = Parameters {
        box_damping: 0.011_341_052_352_740_025,
        block_mass: 0.079_059_065_511_920_39,
        secondary_mass: 0.070_180_666_871_059_85,
        secondary_stiffness: 0.009_212_760_028_100_859,
        secondary_damping: 2.833_213_718_773_845e-5,
        coupling_stiffness: 0.000_390_157_233_607_211_56,
        stop_gap: 0.137_503_053_010_446,
        stop_restitution: 0.810_367_605_942_132_3,
        drive_amplitude: 0.049_581_083_946_975_79,
        drive_frequency: 1.240_269_725_315_924,
        ..Parameters::default()
    };
    for (parameters, x, v) in [
        (
            first,
            [-0.110_689_371_231_082_19, -1.272_300_242_259_898_1, 0.619_905_234_674_09],
            [0.221_080_710_893_789_58, 0.774_040_050_130_937, -0.336_812_260_925_643_76],
        ),
        (
            second,
            [0.0, -0.058_379_594_109_733_09, -0.096_393_177_689_752_2],
            [-0.014_871_538_060_728_13, -0.007_448_875_723_662_182, 0.045_890_032_190_456_6],
        ),
    ] {
        let start = Start { parameters, state: State { x, v } };
        assert_eq!(verdict(&start, 300).unwrap().class, MotionClass::Periodic(1));
        let mut simulator = settled_simulator(&parameters, &start.state, 40_000.0).unwrap();
        let before = dimensionless(&parameters, &simulator.state());
        simulator.advance_to(40_001.0 * parameters.period()).unwrap();
        let way = distance(&before, &dimensionless(&parameters, &simulator.state()));
        assert!(way < ARRIVED, "{way}");
    }
}
