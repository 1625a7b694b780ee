//! Existence and stability of the two-impact motion over a plane of two parameters (figure 12).

use super::parameter_set::{Name, ParameterSet};
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::{Groups, Parameters};
use vibro_impact::steady::Sheet;
use vibro_impact::steady::exact_orbit::{ExactOrbit, OrbitFamily};
use vibro_impact::steady::multiple_scales::MultipleScales;
use vibro_impact::steady::strong_coupling::StrongCoupling;

/// Theory of the steady state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Multiple scales: paper, section 3; docs/theory.md section 6.
    MultipleScales,
    /// Strong coupling: paper, section 5; docs/theory.md section 8.
    StrongCoupling,
    /// The exact orbit of docs/theory.md section 9, which needs no small parameter; not in the
    /// paper.
    ExactOrbit,
}

/// Class of a point of the plane. A motion exists when its impacts lead into the stop (C > 0;
/// p > 0) and the block passes neither stop in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SteadyStateClass {
    /// No symmetric motion with two impacts.
    None,
    /// One or two, all unstable.
    Unstable,
    /// One is stable.
    Stable,
    /// The theory has no answer: a resonance without damping, an excitation without frequency.
    Undefined,
}

/// Axis of a plane: `count` values from `from` to `to`, both included. Serialized with the
/// parameter's name, and checked on reading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written", bound = "N: AxisName")]
pub struct ParameterAxis<N = Name> {
    /// Parameter that varies, of either form.
    pub name: N,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values.
    pub count: usize,
}

/// Serialized form of an axis, with the parameter by its name.
#[derive(Serialize, Deserialize)]
struct Written {
    name: String,
    from: f64,
    to: f64,
    count: usize,
}

/// Name of the parameter of an axis.
pub trait AxisName: Clone + Sized {
    /// The parameter with a name.
    ///
    /// # Errors
    /// If there is no such parameter.
    fn named(name: String) -> Result<Self>;
    /// The name as text.
    fn text(&self) -> String;
    /// Checks a value as far as the name alone allows.
    ///
    /// # Errors
    /// For a value that is not allowed.
    fn check_value(&self, value: f64) -> Result<()>;
}

impl AxisName for Name {
    fn named(name: String) -> Result<Self> {
        Self::find(&name)
    }

    fn text(&self) -> String {
        self.name().into()
    }

    fn check_value(&self, value: f64) -> Result<()> {
        Ok(self.check(value)?)
    }
}

/// Parameter of a described machine, which checks its values itself.
impl AxisName for String {
    fn named(name: String) -> Result<Self> {
        Ok(name)
    }

    fn text(&self) -> String {
        self.clone()
    }

    fn check_value(&self, _: f64) -> Result<()> {
        Ok(())
    }
}

impl<N: AxisName> From<ParameterAxis<N>> for Written {
    fn from(axis: ParameterAxis<N>) -> Self {
        Self { name: axis.name.text(), from: axis.from, to: axis.to, count: axis.count }
    }
}

impl<N: AxisName> TryFrom<Written> for ParameterAxis<N> {
    type Error = Error;

    fn try_from(axis: Written) -> Result<Self> {
        Self::of(N::named(axis.name)?, (axis.from, axis.to), axis.count)
    }
}

/// Classes over a plane.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Horizontal axis.
    pub x: ParameterAxis,
    /// Vertical axis.
    pub y: ParameterAxis,
    /// The theory.
    pub method: Method,
    /// Classes, row by row of constant y from the lowest.
    pub classes: Vec<SteadyStateClass>,
}

/// The pairs of figure 12: the six pairs among σ̂1, f̂10, γ̂1 and κ, horizontal first.
pub const PAIRS: [(&str, &str); 6] = [
    ("sigma1", "f10"),
    ("gamma1", "f10"),
    ("kappa", "f10"),
    ("sigma1", "gamma1"),
    ("sigma1", "kappa"),
    ("kappa", "gamma1"),
];

impl Method {
    /// Name in tables and captions.
    pub fn name(self) -> &'static str {
        match self {
            Self::MultipleScales => "multiple scales",
            Self::StrongCoupling => "strong coupling",
            Self::ExactOrbit => "exact orbit",
        }
    }
}

impl SteadyStateClass {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Unstable => "unstable",
            Self::Stable => "stable",
            Self::Undefined => "undefined",
        }
    }

    fn of(motions: impl IntoIterator<Item = (bool, bool)>) -> Self {
        motions.into_iter().fold(Self::None, |class, (exists, stable)| match class {
            Self::Stable => class,
            _ if exists && stable => Self::Stable,
            _ if exists => Self::Unstable,
            _ => class,
        })
    }
}

impl ParameterAxis {
    /// A checked axis.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn new(name: impl Into<Name>, ends: (f64, f64), count: usize) -> Result<Self> {
        Self::of(name.into(), ends, count)
    }
}

impl<N: AxisName> ParameterAxis<N> {
    /// A checked axis.
    ///
    /// # Errors
    /// [`Error::Form`] for a range that is empty or not finite, or for fewer than two values; the
    /// parameter's own range.
    pub fn of(name: N, (from, to): (f64, f64), count: usize) -> Result<Self> {
        if !(from < to && (to - from).is_finite() && count >= 2) {
            let text = format!("{}={from}:{to} in {count} values", name.text());
            return Err(Error::Form { text, expected: "from < to, both finite, and at least 2 values" });
        }
        // Values such as ε = 0 are left out where they end the range that pictures show.
        name.check_value(from)?;
        name.check_value(to)?;
        Ok(Self { name, from, to, count })
    }

    /// Outer ends of the cells that are centred on the values.
    pub fn edges(&self) -> (f64, f64) {
        let half = 0.5 * (self.to - self.from) / (self.count - 1) as f64;
        (self.from - half, self.to + half)
    }

    /// The value of an index.
    pub fn value(&self, i: usize) -> f64 {
        let part = i as f64 / (self.count - 1) as f64;
        self.from * (1.0 - part) + self.to * part
    }
}

/// The class of a parameter set with one parameter changed; undefined where the values make no
/// machine.
fn classify_with(set: &ParameterSet, name: Name, value: f64, method: Method) -> SteadyStateClass {
    match method {
        Method::MultipleScales => set.groups_with(name, value).and_then(|g| by_multiple_scales(&g)),
        Method::StrongCoupling => set.groups_with(name, value).and_then(|g| by_strong_coupling(&g)),
        Method::ExactOrbit => set.with(name, value).and_then(|set| Ok(exact(set.parameters())?.0)),
    }
    .unwrap_or(SteadyStateClass::Undefined)
}

fn by_multiple_scales(groups: &Groups) -> vibro_impact::Result<SteadyStateClass> {
    let roots = MultipleScales::new(groups)?.fixed_points().into_iter().flat_map(|r| [r.upper, r.lower]);
    Ok(SteadyStateClass::of(roots.map(|p| (p.admissibility.geometric, p.admissibility.all()))))
}

fn by_strong_coupling(groups: &Groups) -> vibro_impact::Result<SteadyStateClass> {
    let roots = StrongCoupling::new(groups)?.solutions()?.into_iter().flat_map(|r| [r.upper, r.lower]);
    Ok(SteadyStateClass::of(roots.map(|p| (p.admissibility.geometric, p.admissibility.all()))))
}

/// The class by the exact orbit, and the orbit where it is stable.
///
/// # Errors
/// As [`OrbitFamily::new`] and [`OrbitFamily::orbit`].
pub fn exact(p: &Parameters) -> vibro_impact::Result<(SteadyStateClass, Option<ExactOrbit>)> {
    let family = OrbitFamily::new(p)?;
    for sheet in [Sheet::Upper, Sheet::Lower] {
        match family.orbit(sheet)? {
            Some(orbit) if orbit.is_stable() => return Ok((SteadyStateClass::Stable, Some(orbit))),
            // The lower orbit is never stable, docs/theory.md (80), and does not change the class.
            Some(orbit) if orbit.is_clear() => return Ok((SteadyStateClass::Unstable, None)),
            _ => {}
        }
    }
    Ok((SteadyStateClass::None, None))
}

/// Checks that two axes are different quantities.
///
/// # Errors
/// [`Error::Form`] when one is the other by another name: α̂23, β² and k23, κ and the stops'
/// restitution coefficient, or a group and the physical parameter that it is set by.
pub fn check_pair(x: &ParameterAxis, y: &ParameterAxis) -> Result<()> {
    if x.name.is_same_quantity(y.name) {
        let text = format!("{},{}", x.name.name(), y.name.name());
        return Err(Error::Form { text, expected: "two independent parameters, e.g. sigma1,f10" });
    }
    Ok(())
}

/// Memory that a study's results may take, bytes.
const MOST_MEMORY: usize = 1 << 30;

/// Checks that a plane of columns and rows fits into memory, where at most `held` bytes at a time
/// are held for each cell.
///
/// # Errors
/// [`Error::TooMany`], with the number that would fit.
pub fn check_cells(what: &'static str, (columns, rows): (usize, usize), held: usize) -> Result<()> {
    let most = MOST_MEMORY / held.max(1);
    match columns.checked_mul(rows) {
        Some(count) if count <= most => Ok(()),
        _ => {
            let (count, side) = (columns as f64 * rows as f64, Some(most.isqrt()));
            Err(Error::TooMany { what, count, most, side })
        }
    }
}

/// Checks that the results of a study along a line fit into memory, where at most `held` bytes at a
/// time are held for each.
///
/// # Errors
/// [`Error::TooMany`], with the number that would fit.
pub fn check_count(what: &'static str, count: usize, held: usize) -> Result<()> {
    let most = MOST_MEMORY / held.max(1);
    if count <= most { Ok(()) } else { Err(Error::TooMany { what, count: count as f64, most, side: None }) }
}

/// Classifies a plane on all threads; `done` is called for each finished row. The result does not
/// depend on the number of threads.
///
/// # Errors
/// As [`check_pair`]; constant loads.
pub fn plane(
    set: &ParameterSet,
    x: ParameterAxis,
    y: ParameterAxis,
    method: Method,
    done: &(dyn Fn() + Sync),
) -> Result<Plane> {
    check_pair(&x, &y)?;
    set.check_symmetric([x.name, y.name])?;
    // The rows are put together beside the whole plane.
    check_cells("points of the plane", (x.count, y.count), 2 * size_of::<SteadyStateClass>())?;
    let rows: Vec<Vec<SteadyStateClass>> = (0..y.count)
        .into_par_iter()
        .map(|j| {
            let row = set.with(y.name, y.value(j));
            let class = |i| {
                row.as_ref()
                    .map_or(SteadyStateClass::Undefined, |row| classify_with(row, x.name, x.value(i), method))
            };
            let classes = (0..x.count).map(class).collect();
            done();
            classes
        })
        .collect();
    Ok(Plane { x, y, method, classes: rows.concat() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_that_do_not_fit_into_memory_are_refused_with_the_number_that_fits() {
        assert!(check_cells("points", (1000, 1000), 200).is_ok());
        for side in [30_000, 1 << 40, usize::MAX] {
            let error = check_cells("points", (side, side), 200).unwrap_err();
            let Error::TooMany { most, side: Some(fits), .. } = error else { panic!("{error}") };
            assert!(
                check_cells("points", (most, 1), 200).is_ok()
                    && check_cells("points", (most + 1, 1), 200).is_err()
            );
            assert!(check_cells("points", (fits, fits), 200).is_ok() && fits > 2000);
            assert!(error.to_string().contains(&format!("{fits} × {fits}")), "{error}");
        }
    }
}
