//! The machine as matrices: minimal coordinates, inertia matrix, and every elongation, rate and
//! force as a row on the augmented state z = (q, v, states of first order, 1, signals)
//! (docs/assembly-law.md (A1) to (A4)).

mod blocks;
mod bodies;
mod curved;
mod first_order;
mod forces;
mod formula;
mod freewheels;
mod further;
mod gyroscopic;
mod inertia;
mod levels;
mod losses;
mod matrix;
mod parts;
mod reduction;
mod residual;
mod row_matrix;
mod rows;
mod split;
mod stiff;
mod stops;
mod watched;

pub(crate) use blocks::starts as starts_of_blocks;
pub use blocks::{
    BlockRows, Combination, CombinationTangent, LimitedValue, SampleAction, SampleKind, SampledVariation,
    Sampler, SamplerTangent,
};
pub(crate) use curved::compiled;
pub use curved::first as first_curved;
pub use first_order::{BranchLaw, BranchRows};
pub(crate) use first_order::{InSeries, in_series};
pub use gyroscopic::Gyroscopic;
pub use inertia::Inertia;
pub use losses::{Account, Losses, Power};
pub use parts::Part;
pub(crate) use residual::{Acting, Configuration, Residual};
pub use row_matrix::RowMatrix;
pub use rows::{
    BodyRows, ContactRows, Elongation, FirstOrder, FrictionRows, LevelRows, OutputLimit, SpringRows,
    StopLevel, StopRows,
};
pub use split::{Split, Term};
pub(crate) use stiff::STIFF;
pub(crate) use stops::{MadeStop, StopMaker, contact_forces, excess, forces, made_stops};

use crate::curved::Curved;
use crate::description::{Arms, BodyKind, Description, Spring, start_of};
use crate::elements::Element;
use crate::error::Error;
use crate::functional::{Functional, StateRow};
use crate::polyline::Polyline;
use crate::signals::{Builder, Layout, Signals};
use crate::stepped;
use bodies::bodies;
use nalgebra::DVector;
use reduction::reduce;
use row_matrix::RowSums;
use std::sync::{Arc, OnceLock};

/// Limit of the augmented state's size for dense matrices of a mode's sub-step; above, a power
/// series of the actual state replaces them. Measured on chains: the series takes less time if
/// modes are new. If the same modes recur, it takes up to half as much again, above a size of 30
/// hardly more.
pub(crate) const DENSE: usize = 20;

/// The matrices of a machine, constant during a motion.
#[derive(Clone, Debug)]
pub struct System {
    /// Number of coordinates q, N.
    pub coordinates: usize,
    /// Index of the body of each coordinate q.
    pub bodies_of: Vec<usize>,
    /// Signals, which follow q, v and the states of first order in the augmented state.
    pub signals: Signals,
    /// Cholesky factor L of the inertia matrix.
    pub inertia: Inertia,
    /// The inertia matrix M.
    pub mass: RowMatrix,
    /// Whether the inertia matrix is diagonal: no link couples the coordinates.
    pub(crate) is_diagonal: bool,
    /// Forces on the coordinates that act in every mode, without sliders: M a = forces · z + …
    pub forces: RowMatrix,
    /// Indices of the stiff springs, whose forces are evaluated separately.
    pub(crate) stiff_springs: Vec<usize>,
    /// `forces` without the forces of stiff springs; `None` without such springs.
    soft: Option<RowMatrix>,
    /// Bodies.
    pub bodies: Vec<BodyRows>,
    /// The parts of each element, by its index in [`Description::elements`].
    pub parts: Vec<Vec<Part>>,
    /// Springs.
    pub springs: Vec<SpringRows>,
    /// Curved forces, which are the last coordinates of the augmented state.
    pub curved: Vec<Curved>,
    /// Stops and contacts, followed by further levels of stepped stiffnesses and corners of
    /// springs, by limits of outputs, and by freewheels.
    pub stops: Vec<StopRows>,
    /// Index in `stops` of the first contact.
    pub(crate) first_contact: usize,
    /// Index in `stops` of the first further level or corner.
    pub(crate) first_corner: usize,
    /// Index in `stops` of the first limit of an output.
    pub(crate) first_limit: usize,
    /// Index in `stops` of the first freewheel.
    pub(crate) first_freewheel: usize,
    /// Stored energy of all lines at e = 0, which is subtracted from the stored energy.
    pub(crate) stored_at_zero: f64,
    /// Frictions.
    pub frictions: Vec<FrictionRows>,
    /// Springs in series with a dashpot or slider.
    pub branches: Vec<BranchRows>,
    /// Residual flexibility of bodies.
    pub(crate) residual: Option<Arc<Residual>>,
    /// The rows of the forces on residual flexibility.
    pub(crate) configuration: Option<Configuration>,
    /// Gyroscopic forces of bodies with matrices.
    pub gyroscopic: Vec<Gyroscopic>,
    /// States of first order.
    pub first_order: Vec<FirstOrder>,
    /// Signals that blocks read.
    pub sources: Vec<StateRow>,
    /// Linear blocks.
    pub blocks: Vec<BlockRows>,
    /// Outputs of sampled blocks, each after the outputs that it depends on at the same instant.
    pub(crate) output_order: Vec<(usize, usize)>,
    /// Force of each load. If it follows an output with limits: the row that applies within them.
    pub loads: Vec<Functional>,
    /// For each load: the limits of the output that it follows, with factors.
    pub(crate) load_limits: Vec<Vec<(usize, f64)>>,
    /// Body of each load.
    pub load_bodies: Vec<usize>,
    /// Modes without held contacts, for machines that keep no tables.
    split: OnceLock<Split>,
    losses: OnceLock<Losses>,
    /// Whether any body's motion is prescribed.
    pub has_motions: bool,
    /// The momentum Bᵀ m D p' that prescribed bodies impart through links, as rows; `None` if it
    /// is zero.
    carried: Option<RowMatrix>,
    /// Inertia of each body; 0 for prescribed bodies.
    pub inertias: Vec<f64>,
    /// Inertia of each body times the component of gravity along s.
    pub weights: Vec<f64>,
}

impl System {
    /// The matrices of a machine.
    ///
    /// # Errors
    /// [`Error::Redundant`] for a link that follows from others or moves nothing;
    /// [`Error::Inertia`] if the inertia is not positive in double precision.
    pub fn new(d: &Description) -> Result<Self, Error> {
        Self::laid_out(d, Layout::default())
    }

    /// The matrices of a machine, with its signals laid out in a given way.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub(crate) fn laid_out(d: &Description, layout: Layout) -> Result<Self, Error> {
        let reduction = reduce(d)?;
        let n = reduction.kept.len();
        let mut builder = Builder::new(2 * n + first_order::count(d), layout);
        let motions: Vec<Option<usize>> =
            d.bodies.iter().map(|b| b.kind.course().map(|course| builder.add_motion(&course))).collect();
        let loads: Vec<usize> = d.loads.iter().map(|l| builder.add(&l.force)).collect();
        let levels: Vec<(usize, Option<usize>)> = d
            .frictions
            .iter()
            .map(|f| (builder.add(&f.force), f.static_force.as_ref().map(|s| builder.add(s))))
            .collect();
        let counters: Vec<usize> = stepped::all(d).map(|own| builder.add(&stepped::counter(own))).collect();
        let sources: Vec<usize> = d.sources.iter().map(|own| builder.add(&own.signal)).collect();
        let (signals, rows) = builder.finish(curved::count(d));
        let bodies = bodies(d, &reduction, &signals, &motions, &rows);
        let inertias: Vec<f64> = d
            .bodies
            .iter()
            .map(|b| if let BodyKind::Free(free) = b.kind { free.inertia } else { 0.0 })
            .collect();
        let weights: Vec<f64> = d
            .bodies
            .iter()
            .map(|b| {
                if let BodyKind::Free(free) = b.kind { free.inertia * free.gravity * d.gravity } else { 0.0 }
            })
            .collect();
        let mut mass = RowSums::zeros(n, n);
        let mut carried = RowSums::zeros(n, signals.size);
        for (body, &inertia) in bodies.iter().zip(&inertias) {
            mass.add_outer(inertia, &body.weights, &body.weights);
            let prescribed = body.v.terms().iter().copied().filter(|term| term.0 >= signals.one);
            carried.add_outer(inertia, &body.weights, &Functional::from_terms(signals.size, prescribed));
        }
        let (mass, carried) = (mass.finish(), carried.finish());
        let Some(inertia) = Inertia::new(&mass) else { return Err(Error::Inertia) };
        let mut system = Self {
            coordinates: n,
            bodies_of: reduction.kept,
            forces: RowSums::zeros(n, signals.size).finish(),
            stiff_springs: Vec::new(),
            soft: None,
            signals,
            inertia,
            is_diagonal: mass.is_diagonal(),
            mass,
            bodies,
            parts: Vec::new(),
            springs: Vec::new(),
            curved: Vec::new(),
            stops: Vec::new(),
            first_contact: d.stops.len(),
            first_corner: d.stops.len() + d.contacts.len(),
            first_limit: 0,
            first_freewheel: 0,
            stored_at_zero: 0.0,
            frictions: Vec::new(),
            branches: Vec::new(),
            residual: None,
            configuration: None,
            gyroscopic: Gyroscopic::of(d),
            first_order: Vec::new(),
            sources: sources.iter().map(|&i| (*rows[i]).clone()).collect(),
            blocks: Vec::new(),
            output_order: Vec::new(),
            loads: loads.iter().map(|&i| rows[i].clone()).collect(),
            load_limits: vec![Vec::new(); d.loads.len()],
            load_bodies: d.loads.iter().map(|l| l.body).collect(),
            split: OnceLock::new(),
            losses: OnceLock::new(),
            has_motions: motions.iter().any(Option::is_some),
            carried: (!carried.is_zero()).then_some(carried),
            inertias,
            weights,
        };
        let (counters, sources) =
            (&rows[rows.len() - counters.len() - sources.len()..], system.sources.clone());
        system.add_elements(d, &levels, (&rows, counters));
        system.add_blocks(d, &sources);
        system.add_freewheels(d);
        system.add_forces();
        system.add_residual(d);
        Ok(system)
    }

    /// Whether modes store matrices of their sub-steps.
    pub(crate) fn keeps_matrices(&self) -> bool {
        self.signals.size <= DENSE && self.curved.is_empty()
    }

    /// Powers of loads and losses, for all modes.
    pub fn losses(&self) -> &Losses {
        self.losses.get_or_init(|| Losses::new(self))
    }

    /// Common data of the modes without held contacts.
    pub fn split(&self) -> &Split {
        self.split.get_or_init(|| Split::new(self))
    }

    /// The momentum Bᵀ m D p' that prescribed bodies carry through links, if there is any. A
    /// change of the coordinates' rates by Δv takes the work Δv · Bᵀ m D p' from these bodies
    /// (docs/assembly-law.md (A9)).
    pub(crate) fn carried(&self, z: &DVector<f64>) -> Option<DVector<f64>> {
        self.carried.as_ref().map(|carried| carried.times(z))
    }

    /// The row of a constant.
    pub(crate) fn constant(&self, value: f64) -> Functional {
        Functional::unit(self.signals.size, self.signals.one, value)
    }

    fn elongation(&self, arms: &Arms) -> Elongation {
        let sum = |length: usize, of: for<'b> fn(&'b BodyRows) -> &'b Functional| {
            Functional::sum(length, arms.terms.iter().map(|&(body, arm)| (arm, of(&self.bodies[body]))))
        };
        let size = self.signals.size;
        let (e, rate, drift) =
            (sum(size, |own| &own.s), sum(size, |own| &own.v), sum(size, |own| &own.drift));
        let w = sum(self.coordinates, |own| &own.weights);
        self.reaching(e, rate, drift, w)
    }

    /// The elongation with these rows.
    fn reaching(&self, e: Functional, rate: Functional, drift: Functional, w: Functional) -> Elongation {
        let [column, mobility] = self.inertia.column_and_mobility(&w);
        let acts = [&w, &column, &mobility].into_iter().flat_map(|own| own.terms());
        let mut reach: Vec<usize> = acts.map(|term| term.0).collect();
        reach.sort_unstable();
        reach.dedup();
        Elongation { e, rate, w, drift, column, mobility, reach }
    }

    /// Adds the parts of all elements except freewheels, given the rows of signals and the rows of
    /// counters of levels.
    fn add_elements(
        &mut self,
        d: &Description,
        levels: &[(usize, Option<usize>)],
        (rows, counters): (&[Functional], &[Functional]),
    ) {
        self.parts = vec![Vec::new(); d.elements().count()];
        for (i, element) in d.elements().enumerate() {
            self.parts[i] = match element {
                // Its branch follows below.
                Element::Spring(Spring { arms, damping, series: Some(_), .. }) => {
                    self.add_spring(arms, 0.0, *damping, 0.0)
                }
                Element::Spring(spring) if spring.points.is_empty() => {
                    let [stiffness, damping] = spring.along();
                    let parts = self.add_spring(&spring.arms, stiffness, damping, spring.preload);
                    if spring.has_polynomial() {
                        self.add_curve(false, spring.curve.map(Option::unwrap_or_default));
                    }
                    self.add_odd_powers(false, spring.power);
                    self.add_formula(element, || start_of(d, &spring.arms)[0]);
                    parts
                }
                Element::Spring(spring) => {
                    let Polyline { stiffness, preload, .. } = Polyline::new(&spring.points);
                    self.add_spring(&spring.arms, stiffness, spring.damping, preload)
                }
                Element::Damper(damper) => {
                    let parts = self.add_spring(&damper.arms, 0.0, damper.along(), 0.0);
                    if let Some(cubic) = damper.cubic {
                        self.add_curve(true, [0.0, cubic, 0.0, 0.0]);
                    }
                    self.add_odd_powers(true, damper.odd_powers());
                    self.add_formula(element, || 0.0);
                    parts
                }
                Element::Modal(modal) => {
                    let springs = modal.springs(d).into_iter();
                    springs.flat_map(|s| self.add_spring(&s.arms, s.stiffness, s.damping, 0.0)).collect()
                }
                Element::Matrix(matrix) => {
                    let springs = matrix.springs().into_iter();
                    springs.flat_map(|s| self.add_spring(&s.arms, s.stiffness, s.damping, 0.0)).collect()
                }
                _ => continue,
            };
        }
        self.add_stops(d, counters);
        self.add_branches(d);
        let mut loads = 0..d.loads.len();
        for (i, element) in d.elements().enumerate() {
            match element {
                // The levels may follow a stop, whose own levels exist by now.
                Element::Friction(friction) => {
                    let (level, static_level) = levels[self.frictions.len()];
                    self.parts[i] = match &friction.follows {
                        Some(follows) => self.add_following(&friction.arms, follows),
                        None => {
                            self.add_friction(&friction.arms, &rows[level], static_level.map(|i| &rows[i]))
                        }
                    };
                    friction.stribeck.iter().for_each(|own| self.add_stribeck(*own));
                    if let Some(viscous) = friction.viscous {
                        let dashpot = self.add_spring(&friction.arms, 0.0, viscous, 0.0);
                        self.parts[i].extend(dashpot);
                    }
                }
                Element::Load(_) => self.parts[i].extend(loads.next().map(Part::Load)),
                _ => {}
            }
        }
    }

    fn add_spring(&mut self, arms: &Arms, stiffness: f64, damping: f64, preload: f64) -> Vec<Part> {
        let elongation = self.elongation(arms);
        let terms = [(1.0, &self.constant(preload)), (stiffness, &elongation.e), (damping, &elongation.rate)];
        let force = Functional::sum(self.signals.size, terms);
        self.springs.push(SpringRows {
            elongation,
            stiffness,
            damping,
            preload,
            force,
            curves: Vec::new(),
            formula: None,
        });
        vec![Part::Spring(self.springs.len() - 1)]
    }

    fn add_friction(
        &mut self,
        arms: &Arms,
        level: &Functional,
        static_level: Option<&Functional>,
    ) -> Vec<Part> {
        let largest = static_level.unwrap_or(level).clone();
        self.frictions.push(FrictionRows {
            elongation: self.elongation(arms),
            levels: vec![LevelRows { level: level.clone(), static_level: largest }],
            follows: None,
            passes: true,
            has_static: static_level.is_some(),
        });
        vec![Part::Friction(self.frictions.len() - 1)]
    }

    /// The forces that always act, without the forces of stiff springs.
    pub(crate) fn soft_forces(&self) -> &RowMatrix {
        self.soft.as_ref().unwrap_or(&self.forces)
    }

    /// Sets the forces that always act, and selects the stiff springs.
    fn add_forces(&mut self) {
        self.forces = self.forces_without(&[]);
        self.stiff_springs = self.stiff_ties(&[]);
        if !self.stiff_springs.is_empty() {
            self.soft = Some(self.forces_without(&self.stiff_springs));
        }
    }

    /// Weight, loads, springs except `left_out`, gyroscopic forces, springs in series with
    /// dashpots, and inertia forces of prescribed bodies through links.
    fn forces_without(&self, left_out: &[usize]) -> RowMatrix {
        let mut forces = RowSums::zeros(self.coordinates, self.signals.size);
        for ((body, &inertia), &weight) in self.bodies.iter().zip(&self.inertias).zip(&self.weights) {
            if inertia > 0.0 {
                forces.add_outer(1.0, &body.weights, &self.constant(weight));
                forces.add_outer(-inertia, &body.weights, &body.drift);
            }
        }
        for (&body, row) in self.load_bodies.iter().zip(&self.loads) {
            forces.add_outer(1.0, &self.bodies[body].weights, row);
        }
        for (_, spring) in self.springs.iter().enumerate().filter(|(i, _)| left_out.binary_search(i).is_err())
        {
            forces.add_outer(-1.0, &spring.elongation.w, &spring.force);
        }
        for (body, force) in self.gyroscopic_forces() {
            forces.add_outer(-1.0, &self.bodies[body].weights, &Functional::of(force));
        }
        for branch in self.branches.iter().filter(|branch| !branch.is_slider()) {
            forces.add_outer(-1.0, &branch.elongation.w, &branch.force);
        }
        forces.finish()
    }
}
