//! Branches of steady states in one parameter, with their special points.
//!
//! Every steady state of [`steady`](super) is a root of a quadratic, so a branch needs no
//! predictor and no corrector: it consists of two sheets over the parameter, joined where the
//! discriminant is zero. Each interval with real roots is sampled at nodes spaced as a cosine;
//! both sheets then pass smoothly through their folds. Between neighbouring nodes every change of
//! a test function's sign (docs/theory.md (81)) is located to [`LOCATION`]. Two changes of sign
//! between two neighbouring nodes are found for the discriminant but not for the other test
//! functions; more nodes resolve them.
//!
//! ```
//! use vibro_impact::steady::{Bifurcation, continuation::{self, Special}};
//! use vibro_impact::{Groups, Scales};
//!
//! // The force-response curve of the exact orbit.
//! let path = |f10| Groups { f10, ..Groups::basic() }.to_parameters(Scales::default());
//! let branch = continuation::exact_orbit(path, (0.5, 3.0), 200)?;
//! let breaking = Some(Special::Bifurcation(Bifurcation::SymmetryBreaking));
//! let point = branch.specials().find(|p| p.special == breaking).expect("one");
//! assert!((point.value - 2.04).abs() < 0.01);
//! # Ok::<(), vibro_impact::Error>(())
//! ```

mod families;
mod scan;

use super::{Bifurcation, Sheet};
use crate::error::{Error, Result};
use crate::parameters::{Field, Groups, Parameters};
use scan::Scan;

/// Accuracy of the parameter at special points: absolute for values below 1, relative above.
pub const LOCATION: f64 = 1e-11;

/// Smallest number of nodes of a scan.
const FEWEST_NODES: usize = 3;

/// Kind of a point that ends, joins or divides a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Special {
    /// The discriminant is zero: the two sheets join (a saddle-node of orbits).
    Fold,
    /// A multiplier crosses the unit circle, or a pair of eigenvalues of the slow flow crosses the
    /// imaginary axis. The latter is called [`Bifurcation::NeimarkSacker`], the corresponding
    /// bifurcation of the motion.
    Bifurcation(Bifurcation),
    /// The block touches a stop between its impacts. Beyond this point the motion is not of this
    /// kind.
    Grazing,
    /// The impact vanishes: p = 0 (or C = 0). The branch ends.
    Vanishing,
    /// The end of the parameter's range.
    RangeEnd,
}

impl std::fmt::Display for Special {
    /// Name of the kind, for tables and messages.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fold => "fold",
            Self::Bifurcation(Bifurcation::SaddleNode) => "saddle-node",
            Self::Bifurcation(Bifurcation::SymmetryBreaking) => "symmetry breaking",
            Self::Bifurcation(Bifurcation::PeriodDoubling) => "period doubling",
            Self::Bifurcation(Bifurcation::NeimarkSacker) => "Neimark-Sacker",
            Self::Grazing => "grazing",
            Self::Vanishing => "vanishing",
            Self::RangeEnd => "end of range",
        })
    }
}

/// One point of a branch.
#[derive(Clone, Copy, Debug)]
pub struct BranchPoint<P> {
    /// Value of the parameter.
    pub value: f64,
    /// Root of the quadratic.
    pub sheet: Sheet,
    /// Steady state.
    pub solution: P,
    /// Whether the piece of the branch from this point to the next is stable and admissible. At
    /// the last point of a curve, whether the piece before it is.
    pub stable: bool,
    /// Kind of a special point.
    pub special: Option<Special>,
}

/// A connected curve. A curve that turns at folds runs over both sheets.
#[derive(Clone, Debug)]
pub struct Curve<P> {
    /// Points in order along the curve.
    pub points: Vec<BranchPoint<P>>,
    /// Whether the last point joins the first: an isola.
    pub closed: bool,
}

/// All curves in the range of the parameter.
#[derive(Clone, Debug)]
pub struct Branch<P> {
    /// Curves, by increasing parameter of their intervals.
    pub curves: Vec<Curve<P>>,
}

impl<P> Branch<P> {
    /// All special points except ends of the range.
    pub fn specials(&self) -> impl Iterator<Item = &BranchPoint<P>> {
        let special = |p: &&BranchPoint<P>| p.special.is_some_and(|s| s != Special::RangeEnd);
        self.curves.iter().flat_map(|c| &c.points).filter(special)
    }
}

/// Family of steady states at one value of the parameter, on both sheets; [`branch`] follows it
/// over a range.
pub trait Family: Sized {
    /// Steady state.
    type Solution: Copy;

    /// Discriminant of the quadratic: negative without a solution, zero at a fold.
    fn discriminant(&self) -> f64;

    /// Root of a sheet, with the sign chosen so that a steady state exists if the root is
    /// positive. `None` without a real root.
    fn root(&self, sheet: Sheet) -> Option<f64>;

    /// Steady state of a sheet; `None` if its root is not positive.
    ///
    /// # Errors
    /// An error if the steady state cannot be computed.
    fn solution(&self, sheet: Sheet) -> Result<Option<Self::Solution>>;

    /// Whether the steady state is stable and admissible.
    fn is_stable(solution: &Self::Solution) -> bool;

    /// Whether the block keeps clear of the stops between its impacts.
    fn is_clear(solution: &Self::Solution) -> bool;

    /// Test functions, which are zero at bifurcations and smooth along a sheet, docs/theory.md
    /// (81).
    fn tests(solution: &Self::Solution) -> [f64; 3];

    /// Bifurcation at a change of sign of test `index`. `None` if the sign changes without a
    /// bifurcation, as at a pole or if two real multipliers have the product 1.
    fn confirm(solution: &Self::Solution, index: usize) -> Option<Bifurcation>;
}

/// Path of parameters that varies one physical parameter.
pub fn along_field(base: Parameters, field: &'static Field) -> impl Fn(f64) -> Result<Parameters> {
    move |value| {
        let mut parameters = base;
        field.check(value)?;
        (field.set)(&mut parameters, value);
        Ok(parameters)
    }
}

/// Branch of exact orbits along a path of parameters, e.g. [`along_field`], over `range` with
/// `nodes` per sheet and interval (200 show a curve).
///
/// # Errors
/// [`Error::Range`] if the range is empty or unbounded; the errors of the path and of
/// [`OrbitFamily::new`](super::exact_orbit::OrbitFamily::new).
pub fn exact_orbit(
    path: impl Fn(f64) -> Result<Parameters>,
    range: (f64, f64),
    nodes: usize,
) -> Result<Branch<super::exact_orbit::ExactOrbit>> {
    branch(|value| super::exact_orbit::OrbitFamily::new(&path(value)?), range, nodes)
}

/// Branch of multiple-scales fixed points (C > 0) along a path of groups; see [`exact_orbit`].
///
/// # Errors
/// As [`exact_orbit`], with [`MultipleScales::new`](super::multiple_scales::MultipleScales::new).
pub fn multiple_scales(
    path: impl Fn(f64) -> Result<Groups>,
    range: (f64, f64),
    nodes: usize,
) -> Result<Branch<super::multiple_scales::FixedPoint>> {
    branch(|value| super::multiple_scales::MultipleScales::new(&path(value)?), range, nodes)
}

/// Branch of strongly coupled steady states (νC > 0) along a path of groups; see
/// [`exact_orbit`].
///
/// # Errors
/// As [`exact_orbit`], with [`StrongCoupling::new`](super::strong_coupling::StrongCoupling::new).
pub fn strong_coupling(
    path: impl Fn(f64) -> Result<Groups>,
    range: (f64, f64),
    nodes: usize,
) -> Result<Branch<super::strong_coupling::StrongPoint>> {
    branch(|value| super::strong_coupling::StrongCoupling::new(&path(value)?), range, nodes)
}

/// Branch of any family over a range of its parameter.
///
/// # Errors
/// [`Error::Range`] if the range is empty or unbounded; the errors of `family`.
pub fn branch<F: Family>(
    family: impl Fn(f64) -> Result<F>,
    range: (f64, f64),
    nodes: usize,
) -> Result<Branch<F::Solution>> {
    let (from, to) = range;
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Err(Error::Range { name: "continuation parameter", from, to });
    }
    let scan = Scan::new(family, nodes.max(FEWEST_NODES));
    let mut curves = Vec::new();
    for interval in scan.intervals(from, to)? {
        let mut runs = scan.sheet(&interval, Sheet::Upper)?;
        for mut run in scan.sheet(&interval, Sheet::Lower)?.into_iter().rev() {
            run.reverse();
            runs.push(run);
        }
        curves.extend(scan.join(runs)?);
    }
    Ok(Branch { curves })
}
