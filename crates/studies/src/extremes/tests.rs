use super::*;
use crate::contacts::ContactRecorder;
use crate::followed::Followed;
use crate::tests::text;
use crate::{QuantityName, Start};
use vibro_machine::Motion;

/// Tolerance for the rounding of some hundred stretches.
const ROUNDING: f64 = 1e-11;

fn followed(motion: &mut Motion, names: &[&str], end: f64, times: (f64, f64)) -> Vec<Extreme> {
    let d = motion.assembly().description.clone();
    let places: Vec<Quantity> =
        names.iter().map(|n| n.parse::<QuantityName>().unwrap().find(&d).unwrap().quantity).collect();
    let mut followed = Followed::new(ContactRecorder::new(motion, &[]), Extremes::new(&places, times));
    followed.advance(motion, end, &mut |_| (), &mut |_| ()).unwrap();
    followed.extremes.all
}

/// An undamped oscillation of 0.1 m at 20/s: 0.1 sin(20 t - φ) with tan φ = 3/4.
fn swinging() -> Motion {
    text(
        "name = \"S\"\n[body.a]\nmass = 2.0\nstart = { s = -0.06, v = 1.6 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
         [load.f]\non = \"a\"\namplitude = 0.0\nfrequency = 5.0\n",
    )
    .motion(&Start::default())
    .unwrap()
    .0
}

#[test]
fn closed_form_a_curve_goes_through_its_extremes_in_time() {
    let phase = 0.75f64.atan();
    let all = followed(&mut swinging(), &["a.s", "a.v"], 3.0, (0.0, 3.0));
    for (extreme, of) in
        all.iter().zip([&(|t: f64| 0.1 * (20.0 * t - phase).sin()) as &dyn Fn(f64) -> f64, &|t: f64| {
            2.0 * (20.0 * t - phase).cos()
        }])
    {
        let points = extreme.points();
        assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        for (time, value) in &points {
            assert!((value - of(*time)).abs() < 20.0 * ROUNDING, "{time} {value}");
        }
        let largest = points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
        assert_eq!(largest, extreme.largest);
        // The curve includes both ends of every one of the 9.5 periods.
        let least = extreme.largest * (1.0 - ROUNDING);
        let turns = |sign: f64| points.iter().filter(|p| sign * p.1 > least).count();
        assert!(turns(1.0) >= 9 && turns(-1.0) >= 9, "{} {}", turns(1.0), turns(-1.0));
        assert_eq!((points[0].0, points[points.len() - 1].0), (0.0, 3.0));
    }
}

#[test]
fn closed_form_columns_keep_the_least_and_the_largest_of_their_part_of_the_time() {
    let place =
        "a.s".parse::<QuantityName>().unwrap().find(&swinging().assembly().description).unwrap().quantity;
    let mut extreme = Extremes::new(&[place], (0.0, 1.0)).all.pop().unwrap();
    let times = (10.0, 12.0);
    // Columns last 1 ms.
    for (time, value) in
        [(10.0, 1.0), (10.0002, -3.0), (10.0004, 2.0), (10.0008, 0.5), (10.0012, 7.0), (12.0, -9.0)]
    {
        extreme.meet(time, value, times, true);
    }
    let expected =
        [(10.0002, -3.0), (10.0004, 2.0), (10.0012, 7.0), (10.0012, 7.0), (12.0, -9.0), (12.0, -9.0)];
    assert_eq!(extreme.points(), expected);
    assert_eq!(extreme.largest, 9.0);
    // A quantity that begins with zero has a curve only from its first other value.
    let mut from_zero = Extreme { largest: 0.0, curve: Vec::new(), was_zero: false, ..extreme.clone() };
    from_zero.meet(10.0, 0.0, times, true);
    assert!(from_zero.curve.is_empty());
    from_zero.meet(10.5, 2.0, times, true);
    assert_eq!(from_zero.points(), [(10.5, 0.0), (10.5, 2.0)]);
    from_zero.meet(10.6, 3.0, times, true);
    assert_eq!(from_zero.points()[2..], [(10.6, 3.0), (10.6, 3.0)]);
    // A later zero is a value without a sign.
    from_zero.meet(10.7, -0.0, times, true);
    let last = from_zero.points()[4];
    assert!(last == (10.7, 0.0) && last.1.is_sign_positive());
    // Without a time to show, or without room for a curve, only the largest value is known.
    for (times, keeps) in [((12.0, 12.0), true), ((12.0, 10.0), true), ((10.0, 12.0), false)] {
        let mut bare = Extreme { largest: 0.0, curve: Vec::new(), was_zero: false, ..extreme.clone() };
        bare.meet(11.0, -4.0, times, keeps);
        assert!(bare.largest == 4.0 && bare.points().is_empty());
    }
}

#[test]
fn curves_of_sixty_four_quantities_are_kept_and_the_largest_of_all() {
    let all = followed(&mut swinging(), &["a.s"; 66], 0.5, (0.0, 0.5));
    assert!(all.iter().all(|e| (e.largest - 0.1).abs() < ROUNDING));
    let kept: Vec<bool> = all.iter().map(|e| !e.points().is_empty()).collect();
    assert_eq!(kept.iter().filter(|kept| **kept).count(), 64);
    assert!(kept[63] && !kept[64]);
    // The same from states alone, as after an event.
    let mut states = Extremes { all, times: (0.0, 0.5) };
    states.all.iter_mut().for_each(|e| e.curve.clear());
    states.state(&[0.3, 0.0, 0.0, 0.0, 0.0], 0.1);
    assert!(states.all.iter().all(|e| e.largest == 0.3));
    assert_eq!(states.all.iter().filter(|e| !e.points().is_empty()).count(), 64);
}
