//! Existence and stability of the two-impact motion over a plane of two parameters (figure 12).

use super::parameter_set::{Name, ParameterSet};
use crate::axis::{AxisName, check_cells};
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
    /// The exact orbit of docs/theory.md section 9, without a small parameter; not in the paper.
    ExactOrbit,
}

/// Class of a point of the plane. A motion exists if its impacts lead into the stop (C > 0; p > 0)
/// and the block does not pass a stop in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SteadyStateClass {
    /// No symmetric motion with two impacts exists.
    None,
    /// One or two such motions exist, all unstable.
    Unstable,
    /// A stable one exists.
    Stable,
    /// The theory has no answer: a resonance without damping, an excitation without frequency, or
    /// values that do not make a machine.
    Undefined,
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

/// Axis of a parameter of the paper's machine.
pub type ParameterAxis<N = Name> = crate::axis::ParameterAxis<N>;

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

/// The class of a parameter set with one parameter changed. Undefined if the values do not make a
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

/// The class from the exact orbit, and the orbit if it is stable.
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
/// [`Error::Form`] if the axes are two names of one quantity: α̂23, β² and k23, κ and the stops'
/// restitution coefficient, or a group and the physical parameter that sets it.
pub fn check_pair(x: &ParameterAxis, y: &ParameterAxis) -> Result<()> {
    if x.name.is_same_quantity(y.name) {
        let text = format!("{},{}", x.name.name(), y.name.name());
        return Err(Error::Form { text, expected: "two independent parameters, e.g. sigma1,f10" });
    }
    Ok(())
}

/// Classifies a plane on all threads; `done` is called after each row. The result does not depend
/// on the number of threads.
///
/// # Errors
/// As [`check_pair`]; error under constant loads.
pub fn plane(
    set: &ParameterSet,
    x: ParameterAxis,
    y: ParameterAxis,
    method: Method,
    done: &(dyn Fn() + Sync),
) -> Result<Plane> {
    check_pair(&x, &y)?;
    set.check_symmetric([x.name, y.name])?;
    // The rows and the whole plane are in memory at the same time.
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
