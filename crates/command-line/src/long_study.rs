//! Long studies as plain data. The manifest of a folder of parts holds one, so that parts of
//! different studies are never mixed and several computers can share a study.
//!
//! A study is written to disk and may be read by another build. Two rules follow:
//!
//! * Variants and fields keep their names and meaning. A new field has a default and is not written
//!   if it has that value, so that older manifests can be read.
//! * [`FORMAT`] is incremented with any change of how a study is divided or of what a part holds;
//!   `part_folder` then refuses older parts by name. Tests with `second_method_shards_…` compare
//!   the bytes of a study in one run, in shards, and after an interruption.
//!
//! A new kind of study is a variant of [`StudyKind`] or [`AssemblyStudy`], with its arms in
//! [`LongStudy::count`], [`LongStudy::check`] and [`LongStudy::run`], and a line in
//! `tests/studies.rs`.

use super::kept_branches::{Behind, PathsInParts};
use super::studies::{self, Study};
use super::subject::Subject;
use crate::Result;
use serde::{Deserialize, Serialize};
use std::path::Path;
use vibro_orbits::paper::{Family, Span, TreeOptions, tree_in_parts};
use vibro_studies::design_sweep;
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::basin;
use vibro_studies::paper::bifurcation::{self, Sweep};
use vibro_studies::paper::isoperiodic;
use vibro_studies::parts::Task;

/// The form of the parts on disk: how a study is divided and what a part holds. It is incremented
/// whenever one of them changes, so that parts of different forms are never combined. Manifests
/// without a form have form 1.
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
    /// What is computed, and of which machine.
    pub work: StudyOfMachine,
}

/// A study of either machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StudyOfMachine {
    /// A study of the 3-DOF machine.
    ThreeDof {
        /// The study.
        kind: StudyKind,
        /// The parameters.
        set: ParameterSet,
    },
    /// A study of a described machine.
    Assembly {
        /// The study.
        kind: AssemblyStudy,
        /// The machine.
        machine: vibro_studies::Machine,
    },
}

/// Kinds of long studies of a described machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum AssemblyStudy {
    /// A quantity's maxima over a parameter, classes and, if asked for, exponents.
    Diagram(vibro_studies::diagram::DiagramRequest),
    /// Measures of motions over any number of parameters.
    DesignSweep(design_sweep::SweepRequest<vibro_studies::Machine>),
    /// Simulated motion over two parameters.
    Isoperiodic(isoperiodic::IsoperiodicRequest<vibro_studies::Machine>),
    /// A diagram with the branches of periodic orbits over it.
    DiagramWithOrbits(vibro_studies::diagram::DiagramRequest),
    /// Basins over two numbers of the starts.
    Basin(vibro_studies::basin::BasinRequest),
}

impl StudyOfMachine {
    /// The machine.
    pub fn subject(&self) -> &dyn Subject {
        match self {
            Self::ThreeDof { set, .. } => set,
            Self::Assembly { machine, .. } => machine,
        }
    }
}

/// Kinds of long studies of the 3-DOF machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StudyKind {
    /// Maxima, periods and, if asked for, exponents over a parameter.
    Sweep {
        /// The sweep.
        sweep: Sweep,
        /// Values at which spectra are listed and running exponents shown.
        at: Vec<f64>,
        /// Options for following the branches of periodic orbits over the diagram; `None` if they
        /// are not followed.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        orbits: Option<TreeOptions>,
    },
    /// Basins over two initial values.
    Basin(basin::BasinRequest),
    /// Simulated motion over two parameters.
    Isoperiodic(isoperiodic::IsoperiodicRequest),
    /// Measures of motions over any number of parameters.
    DesignSweep(design_sweep::SweepRequest),
    /// All branches of periodic orbits over a parameter.
    Orbits {
        /// The parameter and its range.
        span: Span,
        /// Options of the search for branches.
        options: TreeOptions,
    },
}

/// The form of parts whose manifest has none.
fn unwritten_format() -> u32 {
    1
}

impl LongStudy {
    /// A study by this version of the program.
    pub fn new(name: &str, kind: StudyKind, set: &ParameterSet) -> Self {
        Self::of(name, StudyOfMachine::ThreeDof { kind, set: set.clone() })
    }

    /// A study of any machine by this version of the program.
    pub fn of(name: &str, work: StudyOfMachine) -> Self {
        let version = env!("CARGO_PKG_VERSION").into();
        Self { name: name.into(), version, format: FORMAT, work }
    }

    /// Stems of the files of its results.
    pub fn results(&self) -> Vec<String> {
        let mut names = vec![self.name.clone()];
        if let StudyOfMachine::Assembly { kind: AssemblyStudy::DiagramWithOrbits(_), .. } = &self.work {
            names.push(format!("{}-orbits", self.name));
        }
        let StudyOfMachine::ThreeDof { kind, .. } = &self.work else { return names };
        if let StudyKind::Sweep { orbits: Some(_), .. } = kind {
            names.push(format!("{}-orbits", self.name));
        }
        if let StudyKind::Sweep { sweep: Sweep { exponents: Some(_), .. }, at, .. } = kind
            && !at.is_empty()
        {
            names.extend(["spectra", "running"].map(|what| format!("{}-{what}", self.name)));
        }
        names
    }

    /// Number of parts; 0 if it is not known beforehand.
    pub fn count(&self) -> usize {
        let kind = match &self.work {
            StudyOfMachine::ThreeDof { kind, .. } => kind,
            StudyOfMachine::Assembly {
                kind: AssemblyStudy::Diagram(request) | AssemblyStudy::DiagramWithOrbits(request),
                ..
            } => return request.count(),
            StudyOfMachine::Assembly { kind: AssemblyStudy::DesignSweep(request), .. } => {
                return request.count();
            }
            StudyOfMachine::Assembly { kind: AssemblyStudy::Isoperiodic(request), .. } => {
                return isoperiodic::count(request);
            }
            StudyOfMachine::Assembly { kind: AssemblyStudy::Basin(request), .. } => return request.count(),
        };
        match kind {
            StudyKind::Sweep { sweep, .. } => bifurcation::count(sweep),
            StudyKind::Basin(request) => basin::count(request),
            StudyKind::Isoperiodic(request) => isoperiodic::count(request),
            StudyKind::DesignSweep(request) => request.count(),
            StudyKind::Orbits { .. } => 0,
        }
    }

    /// Checks that results and tables of a plane fit into memory, before anything is computed or
    /// written.
    ///
    /// # Errors
    /// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
    pub fn check(&self) -> Result<()> {
        match &self.work {
            StudyOfMachine::ThreeDof { kind: StudyKind::Basin(request), .. } => {
                studies::check_basins(request)
            }
            StudyOfMachine::ThreeDof { kind: StudyKind::Isoperiodic(request), .. } => {
                studies::check_isoperiodic(request)
            }
            StudyOfMachine::Assembly { kind: AssemblyStudy::Isoperiodic(request), machine } => {
                isoperiodic::check(machine, request)?;
                studies::check_isoperiodic(request)
            }
            StudyOfMachine::Assembly { kind: AssemblyStudy::Basin(request), machine } => {
                request.check(machine)?;
                studies::check_assembly_basins(request)
            }
            _ => Ok(()),
        }
    }

    /// The diagram of a sweep; `None` for another kind of study, or if some parts belong to other
    /// shards.
    ///
    /// # Errors
    /// As [`bifurcation::diagram`].
    pub fn diagram(&self, task: &Task) -> Result<Option<(Sweep, bifurcation::Diagram)>> {
        let StudyOfMachine::ThreeDof { kind: StudyKind::Sweep { sweep, .. }, set } = &self.work else {
            return Ok(None);
        };
        Ok(bifurcation::diagram(set, sweep, task)?.map(|d| (*sweep, d)))
    }

    /// Computes the parts of the shard; if all parts are finished, makes the tables and pictures
    /// too.
    ///
    /// # Errors
    /// As [`check`](Self::check), [`bifurcation::diagram`], [`basin::basin`],
    /// [`isoperiodic::isoperiodic`], [`design_sweep::fill`] and [`tree_in_parts`].
    pub fn run(&self, task: &Task) -> Result<Option<Vec<Study>>> {
        self.run_telling(task, &|_, _| ())
    }

    /// Does the work of [`run`](Self::run). Where the number of parts is not known beforehand, as of
    /// branches, `tell` receives the number of finished parts and the total known so far.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_telling(
        &self,
        task: &Task,
        tell: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Option<Vec<Study>>> {
        self.check()?;
        let (kind, set) = match &self.work {
            StudyOfMachine::ThreeDof { kind, set } => (kind, set),
            StudyOfMachine::Assembly { kind, machine } => {
                return self.run_assembly(kind, machine, task, tell);
            }
        };
        match kind {
            StudyKind::Sweep { at, orbits, .. } => {
                let Some((sweep, diagram)) = self.diagram(task)? else { return Ok(None) };
                let mut found = vec![studies::sweep(set, &sweep, &diagram, &self.name)?];
                let (parts, told) = self.behind(task, tell);
                let told = |done, waiting| told(done, done + waiting);
                let follow =
                    |options| studies::DiagramOrbits::new(set, &sweep, &diagram, options, (&parts, &told));
                let orbits = orbits.as_ref().map(follow).transpose()?;
                if let Some(orbits) = &orbits {
                    let name = format!("{}-orbits", self.name);
                    found.push(orbits.study(set, &sweep, &diagram, &name)?);
                }
                if let (Some(options), false) = (&sweep.exponents, at.is_empty()) {
                    let (along, stem) = (sweep.axis.name, &self.name);
                    let name = format!("{stem}-spectra");
                    found.push(studies::spectra(set, &sweep, &diagram, at, orbits.as_ref(), &name)?.1);
                    let name = format!("{stem}-running");
                    found.push(studies::running(set, along, at, sweep.discard, options, &name)?);
                }
                Ok(Some(found))
            }
            StudyKind::Basin(request) => {
                let found = basin::basin(set.parameters(), request, task)?;
                let study = |b| studies::basins(set, request, &b, &self.name).map(|s| vec![s]);
                found.map(study).transpose()
            }
            StudyKind::Isoperiodic(request) => {
                let found = isoperiodic::isoperiodic(set, request, task)?;
                let study = |p| studies::isoperiodic(set, request, &p, &self.name).map(|s| vec![s]);
                found.map(study).transpose()
            }
            StudyKind::DesignSweep(request) => {
                let is_complete = design_sweep::fill(set, request, task)?;
                let study = || studies::design_sweep(set, request, task, &self.name).map(|s| vec![s]);
                is_complete.then(study).transpose()
            }
            StudyKind::Orbits { span, options } => {
                let family = Family::new(set, *span)?;
                let told = |done, waiting| tell(done, done + waiting);
                let found = tree_in_parts(&family, options, task.store, &told)?;
                Ok(Some(vec![studies::orbits(set, &family, &found.branches, Some(&found.searched))?]))
            }
        }
    }

    /// The parts behind those that are counted, for branches over a diagram, and what tells of them
    /// with the counted ones.
    fn behind<'a>(
        &self,
        task: &Task<'a>,
        tell: &'a (dyn Fn(usize, usize) + Sync),
    ) -> (Behind<'a>, impl Fn(usize, usize) + Sync + 'a) {
        let first = self.count();
        (Behind { store: task.store, first }, move |done, all| tell(first + done, first + all))
    }

    /// Does the work of [`run`](Self::run) for a described machine.
    fn run_assembly(
        &self,
        kind: &AssemblyStudy,
        machine: &vibro_studies::Machine,
        task: &Task,
        tell: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Option<Vec<Study>>> {
        let study = match kind {
            AssemblyStudy::Diagram(request) => {
                let found = vibro_studies::diagram::diagram(machine, request, task)?;
                found.map(|d| studies::assembly_diagram(machine, request, &d, &self.name)).transpose()
            }
            AssemblyStudy::DiagramWithOrbits(request) => {
                let Some(diagram) = vibro_studies::diagram::diagram(machine, request, task)? else {
                    return Ok(None);
                };
                let own = studies::assembly_diagram(machine, request, &diagram, &self.name)?;
                let name = format!("{}-orbits", self.name);
                let (parts, told) = self.behind(task, tell);
                let paths = PathsInParts::new(parts);
                let (family, branches) = studies::diagram_branches(machine, request, &paths, &told)?;
                let found = (&family, &branches[..]);
                let orbits = studies::assembly_diagram_orbits(machine, request, &diagram, found, &name)?;
                return Ok(Some(vec![own, orbits]));
            }
            AssemblyStudy::DesignSweep(request) => {
                let is_complete = design_sweep::fill(machine, request, task)?;
                is_complete.then(|| studies::design_sweep(machine, request, task, &self.name)).transpose()
            }
            AssemblyStudy::Isoperiodic(request) => {
                let found = isoperiodic::isoperiodic(machine, request, task)?;
                found.map(|plane| studies::isoperiodic(machine, request, &plane, &self.name)).transpose()
            }
            AssemblyStudy::Basin(request) => {
                let found = vibro_studies::basin::basins(machine, request, task)?;
                found.map(|b| studies::assembly_basins(machine, request, &b, &self.name)).transpose()
            }
        };
        Ok(study?.map(|study| vec![study]))
    }

    /// Writes the tables that are too long for memory, the [`files`](Study::files) of a [`Study`],
    /// from the parts of a finished study.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File), [`Error::Output`](crate::Error::Output).
    pub fn write_tables(&self, task: &Task, out: &Path) -> Result<()> {
        let stem = out.join(&self.name);
        match &self.work {
            StudyOfMachine::ThreeDof { kind: StudyKind::DesignSweep(request), set } => {
                studies::write_design_tables(set, request, task, &stem)
            }
            StudyOfMachine::Assembly { kind: AssemblyStudy::DesignSweep(request), machine } => {
                studies::write_design_tables(machine, request, task, &stem)
            }
            _ => Ok(()),
        }
    }
}
