use super::*;
use vibro_impact::parameters::{Groups, Scales};

#[test]
fn second_method_together_as_one_by_one() {
    // Several machines, one with another drive period, and some invalid starts.
    let mut starts = Vec::new();
    for (i, (f10, sigma1)) in [(0.6, 0.4), (2.48, 0.4), (3.6, 0.4), (1.5, 0.2)].into_iter().enumerate() {
        let groups = Groups { f10, sigma1, ..Groups::basic() };
        let parameters = groups.to_parameters(Scales::default()).unwrap();
        for k in 0..11 {
            let x2 = if k == 5 { 1.5 } else { 0.0 };
            let state = State { x: [0.0, x2, 0.0], v: [0.1 * i as f64, 0.2 * f64::from(k), 0.0] };
            starts.push(Start { parameters, state });
        }
    }
    /// Tolerance between the two ways: rounding, amplified by the impacts of ten periods, also in
    /// chaos.
    const ROUNDING: f64 = 1e-9;
    const PERIODS: u32 = 10;
    let ends = propagate(&starts, PERIODS, &|| ());
    assert_eq!(ends.len(), starts.len());
    for (start, end) in starts.iter().zip(ends) {
        // Without its neighbours the result is bit-identical.
        let single = propagate(std::slice::from_ref(start), PERIODS, &|| ()).remove(0);
        assert_eq!(end.as_ref().ok(), single.as_ref().ok());
        let one = Simulator::new(&start.parameters, &start.state, 0.0).and_then(|s| {
            let mut s = s.without_energy_accounts();
            s.advance_to(f64::from(PERIODS) * start.parameters.period())?;
            Ok(s.state())
        });
        match (one, end) {
            (Ok(one), Ok(end)) => {
                let pairs = one.x.iter().chain(&one.v).zip(end.x.iter().chain(&end.v));
                let d = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                assert!(d < ROUNDING, "{start:?}: {d:e}");
            }
            (Err(one), Err(end)) => assert_eq!(one.to_string(), end.to_string()),
            (one, end) => panic!("{one:?} {end:?}"),
        }
    }
}

/// Attractor and maxima of a motion.
type Settled = (Attractor, Vec<f64>);

/// Attractors and maxima of motions of one machine that start with different speeds.
fn settled(f10: f64, one_by_one: bool) -> Vec<Settled> {
    const MOTIONS: u32 = 40;
    let parameters = Groups { f10, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    let start = |k| State { x: [0.0; 3], v: [0.0, 0.1 + 0.03 * f64::from(k), 0.0] };
    let mut starts = (0..MOTIONS).map(|k| Start { parameters, state: start(k) });
    let program =
        Program { discard: 250, maxima: Some((Displacement::X2, 60)), observed: true, ..Program::default() };
    let mut found: Vec<Option<_>> = (0..MOTIONS).map(|_| None).collect();
    let way = if one_by_one { Way::OneByOne } else { Way::Together };
    let mut workspace = Workspace { way, ..Workspace::default() };
    workspace.run(&mut starts, &program, &mut |number, outcome| {
        let outcome = outcome.unwrap();
        found[number] = Some((outcome.attractor.unwrap(), outcome.maxima.to_vec()));
    });
    let used = workspace.used;
    assert!(!one_by_one || used.rounds == 0);
    assert!(used.rounds == 0 || used.utilisation() > 0.5, "{used:?}");
    found.into_iter().flatten().collect()
}

#[test]
fn second_method_a_stable_motion_is_settled_on_either_way() {
    /// Tolerance for the remainder of the transient.
    const SETTLED: f64 = 1e-9;
    for ((together, tops), (alone, others)) in settled(1.5, false).iter().zip(&settled(1.5, true)) {
        assert_eq!((together.period, together.impacts, together.rests), (Some(1), [1.0; 2], false));
        assert_eq!(together.relation(alone), crate::class::Relation::Same);
        assert_eq!(tops.len(), others.len());
        assert!(tops.iter().zip(others).all(|(a, b)| (a - b).abs() < SETTLED));
    }
}

/// Eight motions of a plane, some of which end sooner. Together they must be no slower than one by
/// one. The counts show this: a round with half of the lanes empty costs three to five sub-steps
/// of a single motion.
#[test]
fn invariant_eight_motions_keep_enough_lanes_at_work() {
    const ROUND: f64 = 5.0;
    let mut starts = (0..8).map(|k| {
        let groups = Groups { f10: 0.7 + 0.6 * f64::from(k), sigma1: 0.1 * f64::from(k), ..Groups::basic() };
        let parameters = groups.to_parameters(Scales::default()).unwrap();
        Start { parameters, state: crate::paper::stroboscopic::moving_block(&parameters) }
    });
    let program = Program { discard: 300, observed: true, ..Program::default() };
    let mut workspace = Workspace::default();
    workspace.run(&mut starts, &program, &mut |_, outcome| assert!(outcome.is_ok()));
    let used = workspace.used;
    assert!(used.rounds == 0 || used.substeps as f64 > ROUND * used.rounds as f64, "{used:?}");
    // Few sub-steps are left to the code for single motions.
    assert!(used.handed_over < used.substeps / 50, "{used:?}");
}

#[test]
fn second_method_in_chaos_the_statistics_agree() {
    /// Tolerance: scatter of a mean over 40 motions of 60 and 128 periods, whose impacts and
    /// maxima are correlated over a few periods.
    const STATISTICS: f64 = 0.03;
    for f10 in [3.6, 4.5] {
        let [together, alone] = [false, true].map(|one_by_one| {
            let all = settled(f10, one_by_one);
            let count = all.len() as f64;
            let mean = |of: &dyn Fn(&Settled) -> f64| all.iter().map(of).sum::<f64>() / count;
            let tops = mean(&|m| m.1.len() as f64);
            [
                mean(&|m| f64::from(u8::from(m.0.period.is_none()))),
                mean(&|m| m.0.impacts[0] + m.0.impacts[1]),
                mean(&|m| m.0.sizes[0]),
                mean(&|m| m.0.sizes[1]),
                tops,
                mean(&|m| m.1.iter().sum::<f64>()) / tops,
            ]
        });
        assert!(alone[0] > 0.5, "f10 = {f10}: {alone:?} is no chaos");
        for (a, b) in together.iter().zip(&alone) {
            assert!((a - b).abs() < STATISTICS * b.abs(), "f10 = {f10}: {together:?} {alone:?}");
        }
    }
}

#[test]
fn second_method_verdicts_are_those_of_whole_motions() {
    use crate::paper::plane::ParameterAxis;
    use crate::paper::{ParameterSet, find_group};
    const SIDE: usize = 14;
    let axis = |name| {
        let group = find_group(name).unwrap();
        ParameterAxis::new(group, group.shown, SIDE).unwrap()
    };
    let mut starts = Vec::new();
    for (x, y) in [(axis("sigma1"), axis("f10")), (axis("kappa"), axis("f10"))] {
        for k in 0..SIDE * SIDE {
            let set = ParameterSet::basic().with(x.name, x.value(k % SIDE)).unwrap();
            let parameters = *set.with(y.name, y.value(k / SIDE)).unwrap().parameters();
            starts.push(Start { parameters, state: crate::paper::stroboscopic::moving_block(&parameters) });
        }
    }
    let run = |until_settled, way| {
        let program = Program { discard: 300, until_settled, observed: true, ..Program::default() };
        let mut found: Vec<Option<(State, Attractor)>> = vec![None; starts.len()];
        let mut workspace = Workspace { way, ..Workspace::default() };
        workspace.run(&mut starts.iter().copied(), &program, &mut |number, outcome| {
            let outcome = outcome.unwrap();
            found[number] = Some((outcome.state, outcome.attractor.unwrap()));
        });
        found.into_iter().flatten().collect::<Vec<_>>()
    };
    let (mut early, mut free, mut periods) = (0, 0, std::collections::BTreeSet::new());
    for way in [Way::Together, Way::OneByOne] {
        let pairs = run(true, way).into_iter().zip(run(false, way));
        for (k, ((state, found), (end, expected))) in pairs.enumerate() {
            if state == end {
                assert_eq!(found, expected, "motion {k}: nothing has changed for what runs to its end");
            }
            early += usize::from(state != end);
            assert_eq!((found.period, found.is_free()), (expected.period, expected.is_free()), "motion {k}");
            assert_eq!(found.approaching, expected.approaching, "motion {k}");
            free += usize::from(state != end && found.is_free());
            if found.period.is_some() {
                assert_eq!((found.impacts, found.rests), (expected.impacts, expected.rests), "motion {k}");
                assert_eq!(found.is_symmetric(), expected.is_symmetric(), "motion {k}");
                assert_eq!(found.relation(&expected), crate::class::Relation::Same, "motion {k}");
                periods.insert(found.period);
            }
        }
    }
    assert!(early > starts.len() && periods.len() > 3, "{early} of {}: {periods:?}", 2 * starts.len());
    assert!(free > starts.len() / 10, "{free} without impacts");
}

/// A machine under constant loads: gravity on the block, and a coupling away from its centre.
fn loaded(kappa: f64) -> Parameters {
    let p = Groups { f10: 2.2, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    Parameters { constant_loads: [0.002, -0.004, 0.001], ..p }
}

#[test]
fn second_method_maxima_under_constant_loads_by_interpolated_samples() {
    /// Tolerance for cubic interpolation between 128 samples a period.
    const INTERPOLATION: f64 = 1e-7;
    const PERIODS: u32 = 6;
    let mut rests = false;
    for kappa in [0.75, 0.2, 0.0] {
        let p = loaded(kappa);
        let start = crate::paper::stroboscopic::moving_block(&p);
        let simulator = crate::paper::motion::settled_simulator(&p, &start, 50.0).unwrap();
        let flights = crate::paper::motion::record_flights(&mut simulator.clone(), PERIODS).unwrap();
        for of in [Displacement::X1, Displacement::X2, Displacement::X3] {
            let (mut own, mut exact) = (simulator.clone(), Vec::new());
            crate::paper::maxima::record_periods(&mut own, of, PERIODS, &mut |period| {
                exact.extend(period.maxima.clone());
                rests |= period.rests;
            })
            .unwrap();
            let sampled = crate::paper::motion::maxima(&flights, &p, of.weights());
            assert_eq!(exact.len(), sampled.len(), "{of}, {kappa}");
            for (top, sample) in exact.iter().zip(sampled) {
                assert!((top.value - sample).abs() < INTERPOLATION, "{of}, {kappa}: {top:?} {sample}");
            }
        }
    }
    assert!(rests);
}

#[test]
fn second_method_observed_side_by_side_under_constant_loads_as_one_alone() {
    // For loaded motions the queue reports states, events and the tangent from its code for single
    // motions.
    let p = loaded(0.75);
    let state = crate::paper::stroboscopic::moving_block(&p);
    let program = Program {
        discard: 300,
        until_settled: true,
        observed: true,
        exponent: Some(200),
        ..Program::default()
    };
    let mut found = None;
    let mut workspace = Workspace::default();
    workspace.run(&mut std::iter::once(Start { parameters: p, state }), &program, &mut |_, outcome| {
        found = outcome.unwrap().attractor;
    });
    let found = found.unwrap();
    let mut simulator = crate::paper::motion::settled_simulator(&p, &state, 300.0).unwrap();
    let alone = crate::paper::attractor::observe(&mut simulator).unwrap();
    assert_eq!(found.period, alone.period);
    assert!(found.period.is_some() && found.impacts == alone.impacts);
    assert!(alone.passes(&found.states[0]), "{:?} {:?}", found.states, alone.states);
    // Under loads there are no mirror images.
    assert!(found.mirror_states.is_empty() && !found.is_symmetric());
    let image = crate::paper::attractor::Attractor {
        states: alone.states.iter().map(|s| s.map(|x| -x)).collect(),
        ..alone.clone()
    };
    assert_eq!(alone.relation(&image), crate::class::Relation::Different);
}

#[test]
fn invariant_mirrored_loads_mirror_what_motions_settle_on() {
    let p = loaded(0.75);
    let image = Parameters {
        constant_loads: p.constant_loads.map(|f| -f),
        drive_phase: p.drive_phase + std::f64::consts::PI,
        ..p
    };
    let state = crate::paper::stroboscopic::moving_block(&p);
    let mirrored = State { x: state.x.map(|x| -x), v: state.v.map(|v| -v) };
    let program =
        Program { discard: 400, maxima: Some((Displacement::X2, 8)), observed: true, ..Program::default() };
    let mut found = Vec::new();
    let starts = [Start { parameters: p, state }, Start { parameters: image, state: mirrored }];
    Workspace::default().run(&mut starts.into_iter(), &program, &mut |_, outcome| {
        found.push(outcome.unwrap().attractor.unwrap());
    });
    let [own, other] = &found[..] else { panic!("{found:?}") };
    assert_eq!(own.period, other.period);
    assert!(own.period.is_some());
    assert_eq!(own.impacts, [other.impacts[1], other.impacts[0]]);
    for (a, b) in own.states[0].iter().zip(&other.states[0]) {
        assert!((a + b).abs() < 1e-7, "{:?} {:?}", own.states, other.states);
    }
}
