//! Curves over a parameter: responses of the closed forms, branches of exact orbits.

use crate::set::Set;
use vibro_impact::parameters::Groups;
use vibro_impact::steady::multiple_scales::MultipleScales;
use vibro_orbits::paper::{Family, Span, TreeOptions, tree};
use vibro_studies::paper::Name;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::Method;
use vibro_studies::paper::response;
use wasm_bindgen::prelude::*;

/// Value that separates two curves in the rows.
const GAP: f64 = f64::NAN;

/// The response of a theory (`exact`, `scales` or `strong`) along a parameter. A row contains the
/// parameter's value, the amplitudes of x1, x2, x3 in units of L, and 1 if the motion is stable
/// and admissible up to the next row, otherwise 0. A row of NaN separates two curves.
///
/// # Errors
/// An error if a name or range is not allowed, or if the theory refuses the parameters.
#[wasm_bindgen]
pub fn response(
    set: &Set,
    along: &str,
    from: f64,
    to: f64,
    theory: &str,
    nodes: u32,
) -> Result<Vec<f64>, JsError> {
    let method = match theory {
        "scales" => Method::MultipleScales,
        "strong" => Method::StrongCoupling,
        _ => Method::ExactOrbit,
    };
    let found = response::response(&set.0, Name::find(along)?, (from, to), method, nodes as usize)?;
    let mut rows = Vec::new();
    for curve in &found.curves {
        for point in curve {
            rows.extend([point.value, point.a[0], point.a[1], point.a[2], f64::from(u8::from(point.stable))]);
        }
        rows.extend([GAP; 5]);
    }
    Ok(rows)
}

/// The slow invariant manifold of multiple scales, docs/theory.md (35), with the fixed points of
/// the slow flow on it. A row contains C and B in units of L, then 1 if a fixed point there passes
/// all three tests of admissibility (otherwise 0), then the kind of the row: 0 for a point of the
/// curve, 1 and 2 for the fixed points P₁ and P₂ under the set's force.
///
/// # Errors
/// An error if multiple scales refuses the groups.
#[wasm_bindgen]
pub fn manifold(set: &Set, nodes: u32) -> Result<Vec<f64>, JsError> {
    let groups = *set.0.groups();
    let system = MultipleScales::new(&groups)?;
    let points = system.fixed_points().map_or_else(Vec::new, |roots| vec![roots.lower, roots.upper]);
    // The range of C covers all stable motions and the fixed points.
    let to = points.iter().map(|p| p.c).fold(1.2 * system.manifold().c_smax(), f64::max).max(2.2) + 0.2;
    let from = points.iter().map(|p| p.c).fold(-0.8, f64::min) - 0.2;
    let mut rows = Vec::new();
    for i in 0..=nodes {
        let c = from + (to - from) * f64::from(i) / f64::from(nodes);
        // The force for which C is a fixed point.
        let at = MultipleScales::new(&Groups { f10: system.force(c), ..groups })?.fixed_points();
        let nearest =
            at.map(|r| if (r.lower.c - c).abs() < (r.upper.c - c).abs() { r.lower } else { r.upper });
        let admissible = nearest.is_some_and(|p| p.admissibility.all());
        rows.extend([c, system.manifold().b(c), f64::from(u8::from(admissible)), 0.0]);
    }
    for (kind, p) in (1u8..).zip(&points) {
        rows.extend([p.c, p.b, f64::from(u8::from(p.admissibility.all())), f64::from(kind)]);
    }
    Ok(rows)
}

#[wasm_bindgen]
extern "C" {
    /// Receives the numbers of branches traced and of branches known so far; the latter may
    /// increase. The page's worker defines this function.
    #[wasm_bindgen(js_name = orbitsProgress)]
    fn orbits_progress(traced: usize, known: usize);
}

/// The branches of exact periodic orbits along a parameter. A row contains the parameter's value,
/// a local maximum of the displacement in units of L, and 1 if the orbit is stable, otherwise 0. A
/// row of NaN separates two curves.
///
/// # Errors
/// An error if a name or range is not allowed, or if the search refuses the parameters.
#[wasm_bindgen]
pub fn branches(
    set: &Set,
    along: &str,
    from: f64,
    to: f64,
    of: &str,
    seeds: u32,
) -> Result<Vec<f64>, JsError> {
    let of: Displacement = of.parse()?;
    let family = Family::new(&set.0, Span::new(Name::find(along)?, from, to)?)?;
    // Enough branches for a picture of a few hundred points; `vibro orbits` finds more.
    let options = TreeOptions {
        seeds: seeds as usize,
        settle: 300,
        starts: 0,
        depth: 3,
        longest_period: 4,
        most_letters: 12,
        most_points: 400,
        ..TreeOptions::default()
    };
    let found = tree(&family, &options, &|traced, waiting| orbits_progress(traced, traced + waiting))?;
    let mut rows = Vec::new();
    for branch in &found.branches {
        let maxima = branch.maxima(&family, of.weights());
        let most = maxima.iter().map(Vec::len).max().unwrap_or(0);
        for index in 0..most {
            for (place, tops) in maxima.iter().enumerate() {
                match tops.get(index) {
                    Some(&top) => {
                        let stable = branch.points[place].is_stable();
                        rows.extend([branch.points[place].value, top, f64::from(u8::from(stable))]);
                    }
                    None => rows.extend([GAP; 3]),
                }
            }
            rows.extend([GAP; 3]);
        }
    }
    Ok(rows)
}
