//! Long studies as plain data. The manifest of a folder of parts holds one, so that parts of
//! different studies are never mixed and several computers can share a study.
//!
//! A study is written to disk and may be read by another build. [`FORMAT`] is incremented with any
//! change of how a study is written or divided, or of a part's content; `part_folder` then refuses
//! older parts by name. Tests with `second_method_shards_…` compare the bytes of a study in one
//! run, in shards, and after an interruption.
//!
//! A new kind of study is a variant of [`StudyKind`] for every machine, with its arms in
//! [`LongStudy::count`], [`LongStudy::check`] and [`LongStudy::run`], and a line in
//! `tests/studies.rs`.

mod over_diagram;

pub use over_diagram::OverSweep;

use super::kept_branches::Behind;
use super::studies::{self, ShownBasins, ShownDiagram, ShownPlane, Study};
use super::subject::Subject;
use crate::Result;
use serde::{Deserialize, Serialize};
use std::path::Path;
use vibro_orbits::paper::{Family, Span, TreeOptions, tree_in_parts};
use vibro_studies::basin::{BasinRequest, basins};
use vibro_studies::design_sweep::{self, Plain, SweepRequest};
use vibro_studies::diagram::{DiagramMachine, DiagramRequest, diagram};
use vibro_studies::isoperiodic::{self, IsoperiodicRequest};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::bifurcation::{self, Sweep};
use vibro_studies::parts::Task;
use vibro_studies::{Diagram, Machine};

/// The form of the parts on disk: how a study is divided and the content of a part. It is
/// incremented whenever either changes, so that parts of different forms are never combined.
/// Manifests without a form have form 1.
pub const FORMAT: u32 = 7;

/// One long study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LongStudy {
    /// Stem of its files.
    pub name: String,
    /// The version of the program: parts of different versions are not mixed.
    pub version: String,
    /// The [form of its parts](FORMAT): parts of different forms are not mixed.
    #[serde(default = "unwritten_format")]
    pub format: u32,
    /// The computation and its machine.
    pub work: StudyOfMachine,
}

/// A study of either machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StudyOfMachine {
    /// A study of the paper's machine.
    Paper(Work<ParameterSet>),
    /// A study of a described machine.
    Described(Work<Machine>),
    /// All branches of periodic orbits of the paper's machine over a parameter.
    Branches {
        /// The parameters.
        set: ParameterSet,
        /// The parameter and its range.
        span: Span,
        /// Options of the search for branches.
        options: TreeOptions,
    },
}

/// A kind of study and its machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Work<M: StudiedMachine> {
    /// The study.
    pub kind: StudyKind<M>,
    /// The machine.
    pub machine: M,
}

/// Kinds of long studies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum StudyKind<M: StudiedMachine> {
    /// Maxima, classes and, if requested, exponents over a parameter, with derived studies.
    Diagram {
        /// The diagram.
        request: DiagramRequest<M>,
        /// Studies made from the diagram.
        over: M::OverDiagram,
    },
    /// Basins over two numbers of the starts.
    Basin(BasinRequest<M>),
    /// Simulated motion over two parameters.
    Isoperiodic(IsoperiodicRequest<M>),
    /// Measures of motions over any number of parameters.
    DesignSweep(SweepRequest<M>),
}

/// Diagram of a machine.
type DiagramOf<M> = Diagram<<M as DiagramMachine>::Point>;

/// Machine whose studies are computed in parts.
pub trait StudiedMachine: ShownBasins + ShownDiagram + ShownPlane + Plain {
    /// Studies made from a diagram: branches of periodic orbits over it, spectra at some values.
    type OverDiagram: Plain + Default;

    /// Name endings of the studies made from a diagram.
    fn names_over(request: &DiagramRequest<Self>, over: &Self::OverDiagram) -> Vec<&'static str>;

    /// The studies made from a diagram. `parts` are after the diagram's; `told` receives the
    /// number of branches found, and this number plus the known remaining starts.
    ///
    /// # Errors
    /// Error if orbits cannot vary the parameter; [`Error::Output`](crate::Error::Output).
    fn over_diagram(
        &self,
        found: (&DiagramRequest<Self>, &DiagramOf<Self>),
        over: &Self::OverDiagram,
        kept: (Behind<'_>, &(dyn Fn(usize, usize) + Sync)),
        name: &str,
    ) -> Result<Vec<Study>>;
}

impl From<Work<ParameterSet>> for StudyOfMachine {
    fn from(work: Work<ParameterSet>) -> Self {
        Self::Paper(work)
    }
}

impl From<Work<Machine>> for StudyOfMachine {
    fn from(work: Work<Machine>) -> Self {
        Self::Described(work)
    }
}

impl StudyOfMachine {
    /// The machine.
    pub fn subject(&self) -> &dyn Subject {
        match self {
            Self::Paper(work) => &work.machine,
            Self::Described(work) => &work.machine,
            Self::Branches { set, .. } => set,
        }
    }
}

/// Function that receives the number of finished parts and the total known so far.
type Tell<'a> = &'a (dyn Fn(usize, usize) + Sync);

impl<M: StudiedMachine> Work<M> {
    fn count(&self) -> usize {
        match &self.kind {
            StudyKind::Diagram { request, .. } => request.count(),
            StudyKind::Basin(request) => request.count(),
            StudyKind::Isoperiodic(request) => isoperiodic::count(request),
            StudyKind::DesignSweep(request) => request.count(),
        }
    }

    fn check(&self) -> Result<()> {
        match &self.kind {
            StudyKind::Isoperiodic(request) => {
                isoperiodic::check(&self.machine, request)?;
                studies::check_isoperiodic(request)
            }
            StudyKind::Basin(request) => {
                request.check(&self.machine)?;
                studies::check_basins(request)
            }
            StudyKind::Diagram { .. } | StudyKind::DesignSweep(_) => Ok(()),
        }
    }

    fn run(&self, task: &Task, tell: Tell<'_>, name: &str) -> Result<Option<Vec<Study>>> {
        let Self { kind, machine } = self;
        let study = match kind {
            StudyKind::Diagram { request, over } => {
                let Some(found) = diagram(machine, request, task)? else { return Ok(None) };
                let own = studies::diagram(machine, request, &found, name)?;
                let first = request.count();
                let told = |done, all| tell(first + done, first + all);
                let kept = (Behind { store: task.store, first }, &told as &(dyn Fn(usize, usize) + Sync));
                let further = machine.over_diagram((request, &found), over, kept, name)?;
                return Ok(Some([vec![own], further].concat()));
            }
            StudyKind::Basin(request) => {
                let found = basins(machine, request, task)?;
                found.map(|b| studies::basins(machine, request, &b, name)).transpose()
            }
            StudyKind::Isoperiodic(request) => {
                let found = isoperiodic::isoperiodic(machine, request, task)?;
                found.map(|plane| studies::isoperiodic(machine, request, &plane, name)).transpose()
            }
            StudyKind::DesignSweep(request) => {
                let is_complete = design_sweep::fill(machine, request, task)?;
                is_complete.then(|| studies::design_sweep(machine, request, task, name)).transpose()
            }
        };
        Ok(study?.map(|study| vec![study]))
    }

    fn write_tables(&self, task: &Task, stem: &Path) -> Result<()> {
        match &self.kind {
            StudyKind::DesignSweep(request) => {
                studies::write_design_tables(&self.machine, request, task, stem)
            }
            _ => Ok(()),
        }
    }

    fn names(&self) -> Vec<&'static str> {
        match &self.kind {
            StudyKind::Diagram { request, over } => M::names_over(request, over),
            _ => Vec::new(),
        }
    }
}

/// The form of parts whose manifest has none.
fn unwritten_format() -> u32 {
    1
}

impl LongStudy {
    /// A study by this version of the program.
    pub fn new<M: StudiedMachine>(name: &str, kind: StudyKind<M>, machine: &M) -> Self
    where
        StudyOfMachine: From<Work<M>>,
    {
        Self::of(name, Work { kind, machine: machine.clone() }.into())
    }

    /// A study of any machine by this version of the program.
    pub fn of(name: &str, work: StudyOfMachine) -> Self {
        let version = env!("CARGO_PKG_VERSION").into();
        Self { name: name.into(), version, format: FORMAT, work }
    }

    /// Stems of the files of its results.
    pub fn results(&self) -> Vec<String> {
        let further = match &self.work {
            StudyOfMachine::Paper(work) => work.names(),
            StudyOfMachine::Described(work) => work.names(),
            StudyOfMachine::Branches { .. } => Vec::new(),
        };
        let further = further.into_iter().map(|ending| format!("{}-{ending}", self.name));
        std::iter::once(self.name.clone()).chain(further).collect()
    }

    /// Number of parts; 0 if it is not known in advance.
    pub fn count(&self) -> usize {
        match &self.work {
            StudyOfMachine::Paper(work) => work.count(),
            StudyOfMachine::Described(work) => work.count(),
            StudyOfMachine::Branches { .. } => 0,
        }
    }

    /// Checks that results and tables of a plane fit into memory, before anything is computed or
    /// written.
    ///
    /// # Errors
    /// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
    pub fn check(&self) -> Result<()> {
        match &self.work {
            StudyOfMachine::Paper(work) => work.check(),
            StudyOfMachine::Described(work) => work.check(),
            StudyOfMachine::Branches { .. } => Ok(()),
        }
    }

    /// The diagram of the paper's machine; `None` for another study, or if some parts belong to
    /// other shards.
    ///
    /// # Errors
    /// As [`diagram`].
    pub fn diagram(&self, task: &Task) -> Result<Option<(Sweep, bifurcation::Diagram)>> {
        let StudyOfMachine::Paper(Work { kind: StudyKind::Diagram { request: sweep, .. }, machine }) =
            &self.work
        else {
            return Ok(None);
        };
        Ok(diagram(machine, sweep, task)?.map(|found| (sweep.clone(), found)))
    }

    /// Computes the parts of the shard. If all parts are finished, also makes the tables and
    /// pictures.
    ///
    /// # Errors
    /// As [`check`](Self::check), [`diagram`], [`basins`], [`isoperiodic::isoperiodic`],
    /// [`design_sweep::fill`] and [`tree_in_parts`].
    pub fn run(&self, task: &Task) -> Result<Option<Vec<Study>>> {
        self.run_telling(task, &|_, _| ())
    }

    /// Does the work of [`run`](Self::run). If the number of parts is not known in advance, as for
    /// branches, `tell` receives the number of finished parts and the total known so far.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_telling(&self, task: &Task, tell: Tell<'_>) -> Result<Option<Vec<Study>>> {
        self.check()?;
        match &self.work {
            StudyOfMachine::Paper(work) => work.run(task, tell, &self.name),
            StudyOfMachine::Described(work) => work.run(task, tell, &self.name),
            StudyOfMachine::Branches { set, span, options } => {
                let family = Family::new(set, *span)?;
                let told = |done, waiting| tell(done, done + waiting);
                let found = tree_in_parts(&family, options, task.store, &told)?;
                Ok(Some(vec![studies::paper::orbits(set, &family, &found.branches, Some(&found.searched))?]))
            }
        }
    }

    /// Writes the tables that are too long for memory, the [`files`](Study::files) of a [`Study`],
    /// from the parts of a finished study.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File), [`Error::Output`](crate::Error::Output).
    pub fn write_tables(&self, task: &Task, out: &Path) -> Result<()> {
        let stem = out.join(&self.name);
        match &self.work {
            StudyOfMachine::Paper(work) => work.write_tables(task, &stem),
            StudyOfMachine::Described(work) => work.write_tables(task, &stem),
            StudyOfMachine::Branches { .. } => Ok(()),
        }
    }
}
