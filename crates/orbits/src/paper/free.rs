//! The branch of the motion without impacts, in closed form. It ends where the block touches a
//! stop.

use super::branch::Branch;
use super::family::Family;
use super::orbit::Orbit;
use super::path::stability;
use super::switching::{FlightTouch, free_word};
use crate::branch::{OrbitPoint, Special};
use crate::label::Label;
use nalgebra::DVector;
use std::f64::consts::{FRAC_PI_2, TAU};
use vibro_numerics::roots::brent;
use vibro_studies::Result;

/// Number of equal parts of the range. The ends of the parts, together with touches and marks, are
/// the points of a branch, with the clearance at each.
const NODES: usize = 200;

/// Accuracy of a touch's position, as a fraction of the range.
const LOCATION: f64 = 1e-14;

/// Step, as a fraction of the range, of the difference that determines the side of a touch on
/// which the block is clear.
const SIDE: f64 = 1e-6;

/// Clearance of the block from the nearer stop, units of L; NaN if a motion without impacts does
/// not exist.
fn clearance(family: &Family, value: f64) -> f64 {
    family.system(&[value]).ok().and_then(|s| s.clearance()).unwrap_or(f64::NAN)
}

/// Direction of the parameter, as a sign, away from a touch of the motion without impacts.
pub(super) fn towards_clear(family: &Family, u: &DVector<f64>) -> Option<f64> {
    let span = family.span();
    let value = family.values(u)[0];
    let h = SIDE * (span.to - span.from);
    let [below, above] = [value - h, value + h].map(|v| clearance(family, v.clamp(span.from, span.to)));
    let rise = above - below;
    (rise != 0.0 && rise.is_finite()).then_some(rise.signum())
}

/// A branch, and the touches with the indices of their points.
pub(super) type FreeBranch = (Branch, Vec<(usize, FlightTouch)>);

/// The branches without impacts over the range, with the touches at which they end. Points at the
/// values `marks` are labelled UZ.
pub(super) fn branches(family: &Family, marks: &[f64]) -> Result<Vec<FreeBranch>> {
    let span = *family.span();
    let value = |i: usize| span.from + (span.to - span.from) * i as f64 / NODES as f64;
    let clear: Vec<bool> = (0..=NODES).map(|i| clearance(family, value(i)) >= 0.0).collect();
    let touch = |i: usize| {
        let tolerance = LOCATION * (span.to - span.from);
        brent(|v| clearance(family, v), value(i), value(i + 1), tolerance)
    };
    let mut found: Vec<FreeBranch> = Vec::new();
    let mut i = 0;
    while i <= NODES {
        if !clear[i] {
            i += 1;
            continue;
        }
        let last = (i..=NODES).take_while(|j| clear[*j]).last().unwrap_or(i);
        let before = if i > 0 { touch(i - 1) } else { None };
        let after = if last < NODES { touch(last) } else { None };
        let mut values: Vec<f64> = before.into_iter().chain((i..=last).map(value)).chain(after).collect();
        let (first, end) = (values[0], values[values.len() - 1]);
        let marked: Vec<f64> = marks.iter().copied().filter(|mark| (first..=end).contains(mark)).collect();
        values.extend(&marked);
        values.sort_by(f64::total_cmp);
        values.dedup();
        let mut points = values.iter().map(|v| point(family, *v)).collect::<Result<Vec<_>>>()?;
        for point in points.iter_mut().filter(|p| marked.contains(&p.value)) {
            point.special = Some(Special::of(Label::UserValue));
        }
        let end = points.len() - 1;
        let mut contacts = Vec::new();
        for (at, touches) in [(0, before.is_some()), (end, after.is_some())] {
            let label = if touches { Label::Grazing } else { Label::EndPoint };
            let mut special = Special::of(label);
            if touches {
                let contact = contact(family, &[points[at].value])?;
                special.longer = contact.longer(family, 1).into_iter().next().map(|t| t.longer);
                contacts.push((at, contact));
            }
            points[at].special = Some(special);
        }
        let id = found.len();
        if points.len() > 1 {
            let branch = Branch { id, ..Branch::new(free_word(family), points, false) };
            found.push((branch, contacts));
        }
        i = last + 1;
    }
    Ok(found)
}

fn point(family: &Family, value: f64) -> Result<OrbitPoint> {
    let system = family.system(&[value])?;
    let orbit = Orbit::find(&system, &free_word(family), &[])?;
    Ok(OrbitPoint {
        value,
        period: system.period(orbit.word()),
        multipliers: orbit.multipliers().to_vec(),
        stability: stability(orbit.is_stable()),
        special: None,
        u: family.point(&[], &[value]),
    })
}

/// The touch of the motion without impacts at parameters where its clearance is zero.
pub(super) fn contact(family: &Family, values: &[f64]) -> Result<FlightTouch> {
    let system = family.system(values)?;
    let (_, angle) = system.wave();
    let side: i8 = if system.offset() < 0.0 { -1 } else { 1 };
    let phase = (f64::from(side) * FRAC_PI_2 - angle).rem_euclid(TAU);
    Ok(FlightTouch { shorter: free_word(family), u: family.point(&[], values), flight: 0, phase, side })
}
