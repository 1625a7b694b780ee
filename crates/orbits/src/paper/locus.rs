//! Curves of bifurcations and of touches in two parameters (docs/theory.md, section 14).

mod equations;
pub(super) mod start;

pub use self::start::LocusStart;

use self::equations::Locus;
use self::start::{Normal, first_point};
use super::family::Family;
use crate::obstacle::Obstacle;
use crate::two_parameters::{LocusEnd, LocusPoint, both_ways};
use nalgebra::DVector;
use vibro_studies::{Error, Result as Outcome};

/// The curve in the two parameters of a family on which the orbit keeps the bifurcation of a
/// start, followed in both directions.
///
/// ```
/// use vibro_orbits::paper::{Family, Label, LocusStart, OrbitWord, Span, locus};
/// use vibro_studies::paper::{ParameterSet, find_group};
///
/// // Where the symmetric motion breaks its symmetry, over force and restitution coefficient.
/// let (force, kappa) = (find_group("f10")?, find_group("kappa")?);
/// let spans = (Span::new(force, 1.9, 2.2)?, Span::new(kappa, 0.7, 0.8)?);
/// let family = Family::over_two(&ParameterSet::basic(), spans.0, spans.1)?;
/// let word = OrbitWord::new("U", -1, 1)?;
/// let (phases, values) = (vec![4.49692], [2.03959, 0.75]); // as in special-points.csv
/// let start = LocusStart { label: Label::BranchPoint, word, phases, values };
/// let curve = locus(&family, &start)?;
/// let near = |a: f64, b: f64| (a - b).abs() < 1e-2;
/// assert!(curve.iter().any(|p| near(p.values[0], 2.04) && near(p.values[1], 0.75)));
/// # Ok::<(), vibro_studies::Error>(())
/// ```
///
/// # Errors
/// [`Error::Form`] if the label does not define a curve or the start is outside the ranges;
/// [`Error::NoOrbit`] if the start has no such point nearby.
pub fn locus(family: &Family, start: &LocusStart) -> Outcome<Vec<LocusPoint>> {
    let [first, second] = family.spans() else {
        let text = format!("{} parameters", family.spans().len());
        return Err(Error::Form { text, expected: "a family over two parameters" });
    };
    if !(first.contains(start.values[0]) && second.contains(start.values[1])) {
        let text =
            format!("{}={},{}={}", first.name.name(), start.values[0], second.name.name(), start.values[1]);
        return Err(Error::Form { text, expected: "a start within the ranges of both parameters" });
    }
    let system = family.system(&start.values)?;
    let failed = |obstacle: Obstacle| obstacle.error(&system, &start.word);
    if start.word.closing() < 0 && !family.is_symmetric() {
        return Err(failed(Obstacle::Asymmetric));
    }
    let normal = Normal::of(family, start)?;
    let (locus, u) = first_point(family, &normal).map_err(failed)?;
    let found = both_ways(&locus, &u).map_err(failed)?;
    found.into_iter().map(|(u, end)| point(&locus, &u, end)).collect()
}

fn point(locus: &Locus, u: &DVector<f64>, end: Option<LocusEnd>) -> Outcome<LocusPoint> {
    let values = locus.family.values(u);
    let period = locus.family.system(&values)?.period(locus.word);
    let phases = u.as_slice()[..locus.n()].to_vec();
    Ok(LocusPoint { values: [values[0], values[1]], period, phases, angle: locus.angle(u), end })
}
