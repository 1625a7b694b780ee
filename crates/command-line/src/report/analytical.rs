//! Statements that theory alone decides, and the accuracy of multiple scales.

use super::statement::{Findings, Statement, Verdict};
use crate::{Error, Result};
use vibro_impact::steady::multiple_scales::{FixedPoint, Manifold, fixed_points};
use vibro_studies::paper::{ParameterSet, find_group};

pub(super) fn limits(found: &Findings) -> Result<Vec<Statement>> {
    let m = Manifold::new(found.set.groups().kappa)?;
    let b = m.c_gmax().is_finite().then(|| {
        let (c, rho) = (m.c_gmax(), m.rho());
        ((c - 1.0) * (c - 1.0) + rho * rho * c * c).sqrt()
    });
    let b = b.unwrap_or(f64::INFINITY);
    let near = |x: f64, y: f64| (x - y).abs() < 0.006;
    Ok(vec![
        Statement {
            place: "section 3.2, figure 3",
            paper: "For κ = 0.75 the geometric limit is C_Gmax ≈ 6.07, where B ≈ 5.1.",
            found: format!("C_Gmax = {:.3}, B = {b:.3}", m.c_gmax()),
            verdict: Verdict::of(near(m.c_gmax(), 6.07) && (b - 5.1).abs() < 0.05, false),
        },
        Statement {
            place: "section 3.3, figure 5",
            paper: "For κ = 0.75, ε = 0.1 the critical values are C_Smin ≈ 0.99 and C_Smax ≈ 1.68.",
            found: format!("C_Smin = {:.4}, C_Smax = {:.4}", m.c_smin(), m.c_smax()),
            verdict: Verdict::of(near(m.c_smin(), 0.99) && near(m.c_smax(), 1.68), false),
        },
    ])
}

pub(super) fn upper(set: &ParameterSet, f10: f64) -> Result<Option<FixedPoint>> {
    let set = set.with(find_group("f10")?, f10)?;
    Ok(fixed_points(set.groups())?.map(|r| r.upper).filter(|p| p.c > 0.0))
}

pub(super) fn figure_nine(found: &Findings) -> Result<Statement> {
    let expected = [(0.6, false), (1.2, true), (1.5, true), (2.5, false)];
    let mut words = Vec::new();
    let mut right = 0;
    for (f10, stable) in expected {
        let is = upper(found.set, f10)?.is_some_and(|p| p.admissibility.all());
        right += usize::from(is == stable);
        words.push(format!("{f10}: {}", if is { "stable" } else { "not stable" }));
    }
    Ok(Statement {
        place: "section 4, figure 9",
        paper: "P₂ is stable for f̂₁₀ = 1.2 and 1.5, unstable for 0.6 and 2.5.",
        found: words.join(", "),
        verdict: Verdict::of(right == 4, right > 1),
    })
}

/// Relative errors of multiple scales at ε = 0.1, of B, A1, A2 and A3, and their slopes between the
/// two smallest ε. `None` if one is missing, for example because theory and simulation give
/// different motions.
pub(super) fn errors(csv: &[u8]) -> Result<Option<([f64; 4], [f64; 4])>> {
    let mut rows: Vec<(f64, String, f64)> = Vec::new();
    for row in csv::Reader::from_reader(csv).records() {
        let row = row.map_err(Error::output("figure 17's table"))?;
        let number = |i: usize| row.get(i).and_then(|t| t.parse().ok()).unwrap_or(f64::NAN);
        rows.push((number(0), row.get(1).unwrap_or_default().into(), number(4)));
    }
    let of = |epsilon: f64, name: &str| {
        rows.iter()
            .find(|r| r.1 == name && (r.0 - epsilon).abs() < 1e-9)
            .map(|r| r.2)
            .filter(|e| e.is_finite())
    };
    let four = |epsilon: f64| -> Option<[f64; 4]> {
        Some([of(epsilon, "B")?, of(epsilon, "A1")?, of(epsilon, "A2")?, of(epsilon, "A3")?])
    };
    let (Some(large), Some(a), Some(b)) = (four(0.1), four(0.01), four(0.005)) else { return Ok(None) };
    let slopes = std::array::from_fn(|i| (a[i] / b[i]).abs().log2());
    Ok(Some((large, slopes)))
}

pub(super) fn accuracy(found: &Findings) -> Result<Vec<Statement>> {
    let Some((large, slopes)) = errors(found.errors)? else { return Ok(Vec::new()) };
    let percent = large.map(|e| 100.0 * e.abs());
    Ok(vec![
        Statement {
            place: "section 5, figure 17",
            paper: "At ε = 0.1 the errors of B and A₁ are about 20 %, those of A₂ and A₃ at most 8 %.",
            found: format!(
                "B {:.1} %, A₁ {:.1} %, A₂ {:.1} %, A₃ {:.1} %",
                percent[0], percent[1], percent[2], percent[3]
            ),
            verdict: Verdict::of(
                percent[..2].iter().all(|p| (15.0..26.0).contains(p))
                    && percent[2..].iter().all(|p| *p <= 8.0),
                percent[2..].iter().all(|p| *p <= 10.0),
            ),
        },
        Statement {
            place: "section 5, figure 17",
            paper: "The errors grow linearly with ε.",
            found: format!(
                "slopes in the logarithms between ε = 0.005 and 0.01: {}",
                slopes.map(|s| format!("{s:.3}")).join(", ")
            ),
            verdict: Verdict::of(slopes.iter().all(|s| (s - 1.0).abs() < 0.05), false),
        },
    ])
}
