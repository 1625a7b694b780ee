//! Response curves: steady states along one parameter, with their stability (figures 10, 11).

use super::maxima::Displacement;
use super::parameter_set::{Name, ParameterSet};
use super::plane::Method;
use crate::error::Result;
use vibro_impact::parameters::Groups;
use vibro_impact::steady::Sheet;
use vibro_impact::steady::continuation::{self, Branch, Special};
use vibro_impact::steady::multiple_scales::Manifold;

/// Point of a response curve, with amplitudes in units of L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponsePoint {
    /// Value of the parameter that varies.
    pub value: f64,
    /// Sheet of the solution.
    pub sheet: Sheet,
    /// Amplitude C. For the exact orbit, its equivalent A2/(1-ε+ε²) in the multiple-scales theory.
    pub c: f64,
    /// Amplitude of U.
    pub b: f64,
    /// Amplitudes of X1, X2, X3.
    pub a: [f64; 3],
    /// Largest |W|: 1 if the block does not touch the stops between its impacts, greater than 1 if
    /// the solution penetrates a stop. For strong coupling: |W| at the impact.
    pub w: f64,
    /// Whether the curve from here to the next point is stable and admissible; at the last point
    /// of an open curve, from the previous point to here.
    pub stable: bool,
    /// Whether the block stays clear of the stops between its impacts.
    pub clear: bool,
    /// Whether C is on the right branch of the slow invariant manifold, C ≥ C_Smin (docs/theory.md
    /// (56)).
    pub right: bool,
    /// Special point here, if any.
    pub special: Option<Special>,
}

impl ResponsePoint {
    /// Amplitude of a coordinate; `None` for sums, because a curve has no phases.
    pub fn amplitude(&self, of: Displacement) -> Option<f64> {
        match of {
            Displacement::X1 => Some(self.a[0]),
            Displacement::X2 => Some(self.a[1]),
            Displacement::X3 => Some(self.a[2]),
            Displacement::W => Some(self.w),
            Displacement::Sum(_) => None,
        }
    }
}

/// Connected curves of one theory.
#[derive(Clone, Debug)]
pub struct Response {
    /// The theory.
    pub method: Method,
    /// Curves with points in order; a closed curve ends where it begins.
    pub curves: Vec<Vec<ResponsePoint>>,
}

/// The response by a theory along a parameter over a range, with `nodes` nodes per sheet and
/// interval, plus the special points.
///
/// # Errors
/// Error for values out of range, and errors of the theory.
pub fn response(
    set: &ParameterSet,
    along: impl Into<Name>,
    range: (f64, f64),
    method: Method,
    nodes: usize,
) -> Result<Response> {
    let along = along.into();
    set.check_symmetric([along])?;
    for value in [range.0, range.1] {
        set.with(along, value)?;
    }
    let groups = |value: f64| -> vibro_impact::Result<Groups> { Ok(*set.with(along, value)?.groups()) };
    // A branch has points only at values that give a valid machine, so the fallback is never used.
    let at = |value: f64| groups(value).unwrap_or(*set.groups());
    let curves = match method {
        Method::MultipleScales => {
            let branch = continuation::multiple_scales(groups, range, nodes)?;
            let point = |value: f64, p: &vibro_impact::steady::multiple_scales::FixedPoint| {
                let g = at(value);
                // `Manifold::new` succeeds for the κ of every solution, so NaN does not occur.
                let w = Manifold::new(g.kappa).map_or(f64::NAN, |m| m.w_max(p.c));
                Motion {
                    c: p.c,
                    b: p.b,
                    a: [p.a1(), p.a2(), p.a3],
                    w,
                    clear: p.admissibility.geometric,
                    groups: g,
                }
            };
            collect(&branch, point)
        }
        Method::StrongCoupling => {
            let branch = continuation::strong_coupling(groups, range, nodes)?;
            let point = |value: f64, p: &vibro_impact::steady::strong_coupling::StrongPoint| {
                let w = p.motion_at_drive(p.drive_phase).w.abs();
                Motion {
                    c: p.c,
                    b: p.b,
                    a: [p.a1(), p.a2(), p.a3],
                    w,
                    clear: p.admissibility.geometric,
                    groups: at(value),
                }
            };
            collect(&branch, point)
        }
        Method::ExactOrbit => {
            let path = |value| Ok(*set.with(along, value)?.parameters());
            let branch = continuation::exact_orbit(path, range, nodes)?;
            let point = |value: f64, o: &vibro_impact::steady::exact_orbit::ExactOrbit| {
                let g = at(value);
                let gap = o.parameters().stop_gap;
                let a = o.amplitudes().map(|a| a / gap);
                let b = o.amplitude_of([1.0, g.epsilon, 0.0]) / gap;
                let w = o.amplitude_of(Displacement::W.weights()) / gap;
                let c = a[1] / (1.0 - g.epsilon + g.epsilon * g.epsilon);
                Motion { c, b, a, w, clear: o.is_clear(), groups: g }
            };
            collect(&branch, point)
        }
    };
    Ok(Response { method, curves })
}

/// Amplitudes of one solution; the fields mean the same as in [`ResponsePoint`].
struct Motion {
    c: f64,
    b: f64,
    a: [f64; 3],
    w: f64,
    clear: bool,
    groups: Groups,
}

fn collect<P>(branch: &Branch<P>, motion: impl Fn(f64, &P) -> Motion) -> Vec<Vec<ResponsePoint>> {
    let convert = |p: &continuation::BranchPoint<P>| {
        let Motion { c, b, a, w, clear, groups } = motion(p.value, &p.solution);
        let right = Manifold::new(groups.kappa).is_ok_and(|manifold| c >= manifold.c_smin());
        ResponsePoint {
            value: p.value,
            sheet: p.sheet,
            c,
            b,
            a,
            w,
            stable: p.stable,
            clear,
            right,
            special: p.special,
        }
    };
    let curve = |curve: &continuation::Curve<P>| {
        let mut points: Vec<_> = curve.points.iter().map(convert).collect();
        if curve.closed {
            points.extend(points.first().copied());
        }
        points
    };
    branch.curves.iter().map(curve).collect()
}
