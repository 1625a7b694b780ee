//! The machine as matrices: minimal coordinates, inertia matrix, and every elongation, rate and
//! force as a row on the augmented state z = (q, v, states of first order, 1, signals)
//! (docs/assembly-law.md (A1) to (A4)).

mod blocks;
mod first_order;
mod freewheels;
mod further;
mod gyroscopic;
mod levels;
mod losses;
mod parts;
mod reduction;
mod rows;
mod split;
mod stiff;

pub(crate) use blocks::starts as starts_of_blocks;
pub use blocks::{
    BlockRows, Combination, CombinationTangent, LimitedValue, OutputLimit, SampleAction, SampleKind,
    SampledVariation, Sampler, SamplerTangent,
};
pub(crate) use first_order::in_series;
pub use first_order::{BranchRows, FirstOrder};
pub use gyroscopic::Gyroscopic;
pub use levels::StopLevel;
pub use losses::{Account, Losses, Power};
pub use parts::Part;
pub use rows::{BodyRows, Elongation, FrictionRows, Functional, LevelRows, SpringRows, StateRow, StopRows};
pub use split::{Split, Term};

use crate::description::{Arms, BodyKind, Description, Spring, StopLaw};
use crate::elements::Element;
use crate::error::Error;
use crate::flow::DENSE;
use crate::polyline::Polyline;
use crate::signals::{Builder, Layout, Signals};
use crate::stepped;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use reduction::{Reduction, reduce};
use std::sync::OnceLock;

/// The matrices of a machine, constant during a motion.
#[derive(Clone, Debug)]
pub struct System {
    /// Number of coordinates q, N.
    pub coordinates: usize,
    /// The index of the body whose coordinate each q is.
    pub bodies_of: Vec<usize>,
    /// Signals, which follow q, v and the states of first order in the augmented state.
    pub signals: Signals,
    /// Cholesky factor L of the inertia matrix.
    pub inertia: Cholesky<f64, Dyn>,
    /// The inertia matrix M.
    pub mass: DMatrix<f64>,
    /// Whether the inertia matrix is diagonal: no link couples the coordinates.
    pub(crate) is_diagonal: bool,
    /// Forces on the coordinates that act in every mode, without sliders: M a = forces · z + …
    pub forces: DMatrix<f64>,
    /// Indices of the stiff springs, whose forces are evaluated separately.
    pub(crate) stiff_springs: Vec<usize>,
    /// `forces` without those of stiff springs; `None` without such springs.
    soft: Option<DMatrix<f64>>,
    /// Bodies.
    pub bodies: Vec<BodyRows>,
    /// The parts of each element, by its index in [`Description::elements`].
    pub parts: Vec<Vec<Part>>,
    /// Springs.
    pub springs: Vec<SpringRows>,
    /// Stops, followed by the corners of springs whose force has several lines, and by the
    /// freewheels.
    pub stops: Vec<StopRows>,
    /// The number of stops without these corners.
    pub(crate) first_corner: usize,
    /// The number of stops and corners without the limits of outputs.
    pub(crate) first_limit: usize,
    /// The number of stops, corners and limits without the freewheels.
    pub(crate) first_freewheel: usize,
    /// What the stored energies of all lines are at e = 0, which the springs' own are not to have.
    pub(crate) stored_at_zero: f64,
    /// Frictions.
    pub frictions: Vec<FrictionRows>,
    /// Springs in series with a partner.
    pub branches: Vec<BranchRows>,
    /// Gyroscopic forces of bodies with matrices.
    pub gyroscopic: Vec<Gyroscopic>,
    /// States of first order.
    pub first_order: Vec<FirstOrder>,
    /// Signals that blocks read.
    pub sources: Vec<StateRow>,
    /// Linear blocks.
    pub blocks: Vec<BlockRows>,
    /// The outputs of sampled blocks, each after those that it depends on at the same instant.
    pub(crate) output_order: Vec<(usize, usize)>,
    /// By load: its force, of one that follows an output with limits where it is within them.
    pub loads: Vec<StateRow>,
    /// By load: the limits of the output that it follows, with factors.
    pub(crate) load_limits: Vec<Vec<(usize, f64)>>,
    /// By load: its body.
    pub load_bodies: Vec<usize>,
    /// Modes without held contacts, of machines that keep no tables.
    split: OnceLock<Split>,
    losses: OnceLock<Losses>,
    /// Whether any body's motion is prescribed.
    pub has_motions: bool,
    /// The momentum Bᵀ m D p' that prescribed bodies impart through links, as rows; `None` where it
    /// is zero.
    carried: Option<DMatrix<f64>>,
    /// By body: inertia; 0 for prescribed bodies.
    pub inertias: Vec<f64>,
    /// By body: inertia times the component of gravity along s.
    pub weights: Vec<f64>,
}

impl System {
    /// The matrices of a machine.
    ///
    /// # Errors
    /// [`Error::Redundant`] for a link that follows from others or moves nothing;
    /// [`Error::Inertia`] where the inertia is not positive in double precision.
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
        let (signals, rows) = builder.finish();
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
        let mut mass = DMatrix::zeros(n, n);
        for (body, &inertia) in bodies.iter().zip(&inertias) {
            mass.ger(inertia, &body.weights, &body.weights, 1.0);
        }
        let mut carried = DMatrix::zeros(n, signals.size);
        for (body, &inertia) in bodies.iter().zip(&inertias) {
            let mut prescribed = body.v.transpose();
            prescribed.columns_mut(0, signals.one).fill(0.0);
            carried += inertia * &body.weights * prescribed;
        }
        let Some(inertia) = Cholesky::new(mass.clone()) else { return Err(Error::Inertia) };
        let mut system = Self {
            coordinates: n,
            bodies_of: reduction.kept,
            forces: DMatrix::zeros(n, signals.size),
            stiff_springs: Vec::new(),
            soft: None,
            signals,
            inertia,
            is_diagonal: mass == DMatrix::from_diagonal(&mass.diagonal()),
            mass,
            bodies,
            parts: Vec::new(),
            springs: Vec::new(),
            stops: Vec::new(),
            first_corner: d.stops.len(),
            first_limit: d.stops.len(),
            first_freewheel: 0,
            stored_at_zero: 0.0,
            frictions: Vec::new(),
            branches: Vec::new(),
            gyroscopic: Gyroscopic::of(d),
            first_order: Vec::new(),
            sources: sources.iter().map(|&i| rows[i].clone()).collect(),
            blocks: Vec::new(),
            output_order: Vec::new(),
            loads: loads.iter().map(|&i| rows[i].clone()).collect(),
            load_limits: vec![Vec::new(); d.loads.len()],
            load_bodies: d.loads.iter().map(|l| l.body).collect(),
            split: OnceLock::new(),
            losses: OnceLock::new(),
            has_motions: motions.iter().any(Option::is_some),
            carried: (carried.amax() > 0.0).then_some(carried),
            inertias,
            weights,
        };
        let (counters, sources) =
            (&rows[rows.len() - counters.len() - sources.len()..], system.sources.clone());
        system.add_elements(d, &levels, (&rows, counters));
        system.add_blocks(d, &sources);
        system.add_freewheels(d);
        system.add_forces();
        Ok(system)
    }

    /// Whether modes store matrices of their sub-steps.
    pub(crate) fn keeps_matrices(&self) -> bool {
        self.signals.size <= DENSE
    }

    /// Works of loads and losses in all modes.
    pub fn losses(&self) -> &Losses {
        self.losses.get_or_init(|| Losses::new(self))
    }

    /// What is known of the modes without held contacts.
    pub fn split(&self) -> &Split {
        self.split.get_or_init(|| Split::new(self))
    }

    /// The momentum Bᵀ m D p' that prescribed bodies carry through links, where there is any: what
    /// changes a coordinate's rate by Δv takes the work Δv · Bᵀ m D p' from them
    /// (docs/assembly-law.md (A9)).
    pub(crate) fn carried(&self, z: &DVector<f64>) -> Option<DVector<f64>> {
        self.carried.as_ref().map(|carried| carried * z)
    }

    /// The row of a constant.
    pub(crate) fn constant(&self, value: f64) -> StateRow {
        let mut row = StateRow::zeros(self.signals.size);
        row[self.signals.one] = value;
        row
    }

    fn elongation(&self, arms: &Arms) -> Elongation {
        let [mut e, mut rate, mut drift] = [(); 3].map(|()| StateRow::zeros(self.signals.size));
        let mut w = DVector::zeros(self.coordinates);
        for &(body, arm) in &arms.terms {
            let rows = &self.bodies[body];
            e.axpy(arm, &rows.s, 1.0);
            rate.axpy(arm, &rows.v, 1.0);
            w.axpy(arm, &rows.weights, 1.0);
            drift.axpy(arm, &rows.drift, 1.0);
        }
        let mut column = w.clone();
        self.inertia.l_dirty().solve_lower_triangular_mut(&mut column);
        let mobility = self.inertia.solve(&w);
        let acts = |k: &usize| [&w, &column, &mobility].iter().any(|own| own[*k] != 0.0);
        let reach = (0..self.coordinates).filter(acts).collect();
        let [e, rate] = [e, rate].map(Functional::of);
        Elongation { e, rate, w, drift, column, mobility, reach }
    }

    /// Adds the parts of all elements but freewheels, with the rows of signals and those of
    /// counters of levels.
    fn add_elements(
        &mut self,
        d: &Description,
        levels: &[(usize, Option<usize>)],
        (rows, counters): (&[StateRow], &[StateRow]),
    ) {
        self.parts = vec![Vec::new(); d.elements().count()];
        for (i, element) in d.elements().enumerate() {
            self.parts[i] = match element {
                Element::Spring(Spring { arms, stiffness, damping, series: Some(series), .. }) => {
                    let mut parts = self.add_spring(arms, 0.0, *damping, 0.0);
                    parts.push(self.add_branch(arms, *stiffness, series.law));
                    parts
                }
                Element::Spring(spring) if spring.points.is_empty() => {
                    self.add_spring(&spring.arms, spring.stiffness, spring.damping, spring.preload)
                }
                Element::Spring(spring) => {
                    let Polyline { stiffness, preload, .. } = Polyline::new(&spring.points);
                    self.add_spring(&spring.arms, stiffness, spring.damping, preload)
                }
                Element::Damper(damper) => self.add_spring(&damper.arms, 0.0, damper.damping, 0.0),
                Element::Modal(modal) => {
                    let springs = modal.springs(d).into_iter();
                    springs.flat_map(|s| self.add_spring(&s.arms, s.stiffness, s.damping, 0.0)).collect()
                }
                Element::Matrix(matrix) => {
                    let springs = matrix.springs().into_iter();
                    springs.flat_map(|s| self.add_spring(&s.arms, s.stiffness, s.damping, 0.0)).collect()
                }
                Element::Stop(stop) => self.add_stop(&stop.arms, stop.gap, stop.law),
                _ => continue,
            };
        }
        self.add_levels(d, counters);
        let mut loads = 0..d.loads.len();
        for (i, element) in d.elements().enumerate() {
            match element {
                // Its levels may follow a stop whose levels are there by now.
                Element::Friction(friction) => {
                    let (level, static_level) = levels[self.frictions.len()];
                    self.parts[i] = match &friction.follows {
                        Some(follows) => self.add_following(&friction.arms, follows),
                        None => {
                            self.add_friction(&friction.arms, &rows[level], static_level.map(|i| &rows[i]))
                        }
                    };
                }
                Element::Load(_) => self.parts[i].extend(loads.next().map(Part::Load)),
                _ => {}
            }
        }
        self.add_corners(d);
    }

    fn add_spring(&mut self, arms: &Arms, stiffness: f64, damping: f64, preload: f64) -> Vec<Part> {
        let elongation = self.elongation(arms);
        let force = self.constant(preload) + stiffness * &*elongation.e + damping * &*elongation.rate;
        self.springs.push(SpringRows { elongation, stiffness, damping, preload, force });
        vec![Part::Spring(self.springs.len() - 1)]
    }

    fn add_stop(&mut self, arms: &Arms, gap: f64, law: StopLaw) -> Vec<Part> {
        let elongation = self.elongation(arms);
        let excess = &*elongation.e - self.constant(gap);
        let (stiffness, damping) = match law {
            StopLaw::Compliant { stiffness, damping, .. } => (stiffness, damping),
            StopLaw::Rigid { .. } => (0.0, 0.0),
        };
        let spring = stiffness * &excess;
        let force = &spring + damping * &*elongation.rate;
        let [excess, force, spring] = [excess, force, spring].map(Functional::of);
        self.stops.push(StopRows {
            elongation,
            excess,
            law,
            force,
            spring,
            is_followed: false,
            level: None,
            is_freewheel: false,
            limit: None,
            further: Vec::new(),
        });
        vec![Part::Stop(self.stops.len() - 1)]
    }

    fn add_friction(&mut self, arms: &Arms, level: &StateRow, static_level: Option<&StateRow>) -> Vec<Part> {
        let largest = Functional::of(static_level.unwrap_or(level).clone());
        self.frictions.push(FrictionRows {
            elongation: self.elongation(arms),
            levels: vec![LevelRows { level: level.clone(), static_level: largest }],
            follows: None,
            passes: true,
            has_static: static_level.is_some(),
        });
        vec![Part::Friction(self.frictions.len() - 1)]
    }

    /// The forces that always act, without those of stiff springs.
    pub(crate) fn soft_forces(&self) -> &DMatrix<f64> {
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

    /// Weight, loads, springs except `left_out`, springs in series with dashpots, and inertia forces
    /// of prescribed bodies through links.
    fn forces_without(&self, left_out: &[usize]) -> DMatrix<f64> {
        let mut forces = DMatrix::zeros(self.coordinates, self.signals.size);
        for ((body, &inertia), &weight) in self.bodies.iter().zip(&self.inertias).zip(&self.weights) {
            if inertia > 0.0 {
                forces.ger(1.0, &body.weights, &self.constant(weight), 1.0);
                forces.ger(-inertia, &body.weights, &body.drift, 1.0);
            }
        }
        for (&body, row) in self.load_bodies.iter().zip(&self.loads) {
            forces.ger(1.0, &self.bodies[body].weights, row, 1.0);
        }
        for (_, spring) in self.springs.iter().enumerate().filter(|(i, _)| left_out.binary_search(i).is_err())
        {
            forces.ger(-1.0, &spring.elongation.w, &spring.force, 1.0);
        }
        for (body, force) in self.gyroscopic_forces() {
            forces.ger(-1.0, &self.bodies[body].weights, &force, 1.0);
        }
        for branch in self.branches.iter().filter(|branch| !branch.is_slider()) {
            forces.ger(-1.0, &branch.elongation.w, &branch.force, 1.0);
        }
        forces
    }
}

/// The rows of all bodies.
fn bodies(
    d: &Description,
    reduction: &Reduction,
    signals: &Signals,
    motions: &[Option<usize>],
    rows: &[StateRow],
) -> Vec<BodyRows> {
    let n = reduction.kept.len();
    let prescribed = |i: usize, order: usize| {
        let mut sum = StateRow::zeros(signals.size);
        for (j, motion) in motions.iter().enumerate() {
            let weight = reduction.prescribed[i][j];
            if let Some(motion) = motion.filter(|_| weight != 0.0) {
                let mut row = rows[motion].clone();
                for _ in 0..order {
                    row = signals.derivative(&row);
                }
                sum.axpy(weight, &row, 1.0);
            }
        }
        sum
    };
    (0..d.bodies.len())
        .map(|i| {
            let (mut s, mut v) = (prescribed(i, 0), prescribed(i, 1));
            for k in 0..n {
                s[k] += reduction.q[i][k];
                v[n + k] += reduction.q[i][k];
            }
            BodyRows { s, v, weights: reduction.q[i].clone(), drift: prescribed(i, 2) }
        })
        .collect()
}
