use super::*;

/// A response has no amplitude of a sum: nothing is drawn for it, and no other amplitude instead.
#[test]
fn an_amplitude_that_a_point_does_not_hold_is_not_shown() {
    let point = ResponsePoint {
        value: 1.0,
        sheet: vibro_impact::steady::Sheet::Upper,
        c: 2.0,
        b: 3.0,
        a: [4.0, 5.0, 6.0],
        w: 1.0,
        stable: true,
        clear: true,
        right: true,
        special: None,
    };
    let response = Response {
        method: Method::ExactOrbit,
        curves: vec![vec![point, ResponsePoint { value: 1.5, ..point }]],
    };
    let drawn = |shown: ShownAmplitude| pieces(&response, |p| shown.value(p));
    assert_eq!(drawn(ShownAmplitude::Of(Displacement::X3)), [vec![vec![(1.0, 6.0), (1.5, 6.0)]], vec![]]);
    assert_eq!(
        drawn(ShownAmplitude::Of(Displacement::Sum([1.0, 2.0, 0.0]))),
        [Vec::<Path>::new(), Vec::new()]
    );
}
