//! Curves over a parameter: responses of the closed forms, branches of exact orbits.

use crate::set::Set;
use vibro_analysis::Name;
use vibro_analysis::maxima::Displacement;
use vibro_analysis::orbits::{ConstantLoads, Family, Span, TreeOptions, tree};
use vibro_analysis::plane::Method;
use vibro_analysis::response;
use wasm_bindgen::prelude::*;

/// Between two curves.
const GAP: f64 = f64::NAN;

/// The response of a theory (`exact`, `scales` or `strong`) along a parameter: rows of value, amplitudes of x1, x2, x3 in units of
/// L, and 1 where the motion is stable and admissible from here to the next row. A row of NaN lies between two curves.
///
/// # Errors
/// Names and ranges that are not allowed, and what the theory refuses.
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

/// The branches of exact periodic orbits along a parameter: rows of value, a local maximum of the displacement in units of L, and 1
/// where the orbit is stable. A row of NaN lies between two curves.
///
/// # Errors
/// Names and ranges that are not allowed, and what the search refuses.
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
    let family = Family::new(&set.0, ConstantLoads::default(), Span::new(Name::find(along)?, from, to)?)?;
    // What a picture of some hundred points shows; `vibro orbits` finds more.
    let options = TreeOptions {
        seeds: seeds as usize,
        settle: 300,
        depth: 3,
        longest_period: 4,
        most_letters: 12,
        most_points: 400,
        ..TreeOptions::default()
    };
    let found = tree(&family, &options, &|_, _| ())?;
    let mut rows = Vec::new();
    for branch in &found.branches {
        let maxima = branch.maxima(&family, of.weights());
        let most = maxima.iter().map(Vec::len).max().unwrap_or(0);
        for index in 0..most {
            for (place, tops) in maxima.iter().enumerate() {
                match tops.get(index) {
                    Some(&top) => {
                        let stable = branch.stability_around(place).1;
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
