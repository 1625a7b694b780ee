//! Long studies as plain data. The manifest of a folder of parts holds one, so that parts of different studies are never
//! mixed and several machines work on the same one.

use super::studies::{self, Study};
use crate::Result;
use serde::{Deserialize, Serialize};
use std::path::Path;
use vibro_analysis::ParameterSet;
use vibro_analysis::basin;
use vibro_analysis::bifurcation::{self, Sweep};
use vibro_analysis::design_sweep;
use vibro_analysis::isoperiodic;
use vibro_analysis::parts::Task;
use vibro_orbits::{ConstantLoads, Family, Span, TreeOptions, tree_in_parts};

/// The form of the parts on disk: how a study is divided and what a part holds. It is counted up whenever one of them changes, so that
/// parts of another form are never put together. Before it was written down it was 1.
pub const FORMAT: u32 = 4;

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
    /// What is computed.
    pub kind: StudyKind,
    /// The parameters.
    pub set: ParameterSet,
}

/// Kinds of long studies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StudyKind {
    /// Maxima, periods and, if asked for, exponents over a parameter.
    Sweep {
        /// The sweep.
        sweep: Sweep,
        /// Values at which spectra are listed and running exponents shown.
        at: Vec<f64>,
        /// How the branches of periodic orbits over it are followed, if they are.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        orbits: Option<TreeOptions>,
    },
    /// Basins over two initial values.
    Basin(basin::Request),
    /// Simulated motion over two parameters.
    Isoperiodic(isoperiodic::Request),
    /// Measures of motions over any number of parameters.
    DesignSweep(design_sweep::Request),
    /// All branches of periodic orbits over a parameter.
    Orbits {
        /// The parameter and its range.
        span: Span,
        /// Constant loads on the bodies.
        loads: ConstantLoads,
        /// What is traced.
        options: TreeOptions,
    },
}

/// The form of parts whose manifest does not tell it.
fn unwritten_format() -> u32 {
    1
}

impl LongStudy {
    /// A study by this version of the program.
    pub fn new(name: &str, kind: StudyKind, set: &ParameterSet) -> Self {
        let version = env!("CARGO_PKG_VERSION").into();
        Self { name: name.into(), version, format: FORMAT, kind, set: set.clone() }
    }

    /// Stems of the files of its results.
    pub fn results(&self) -> Vec<String> {
        let mut names = vec![self.name.clone()];
        if let StudyKind::Sweep { orbits: Some(_), .. } = &self.kind {
            names.push(format!("{}-orbits", self.name));
        }
        if let StudyKind::Sweep { sweep: Sweep { exponents: Some(_), .. }, at, .. } = &self.kind
            && !at.is_empty()
        {
            names.extend(["spectra", "running"].map(|what| format!("{}-{what}", self.name)));
        }
        names
    }

    /// Number of parts; 0 where it shows in the course of the work alone.
    pub fn count(&self) -> usize {
        match &self.kind {
            StudyKind::Sweep { sweep, .. } => bifurcation::count(sweep),
            StudyKind::Basin(request) => basin::count(request),
            StudyKind::Isoperiodic(request) => isoperiodic::count(request),
            StudyKind::DesignSweep(request) => request.count(),
            StudyKind::Orbits { .. } => 0,
        }
    }

    /// Checks that results and tables of a plane fit into memory, before anything is computed or written.
    ///
    /// # Errors
    /// [`TooMany`](vibro_analysis::Error::TooMany), with the number that would fit.
    pub fn check(&self) -> Result<()> {
        match &self.kind {
            StudyKind::Basin(request) => studies::check_basins(request),
            StudyKind::Isoperiodic(request) => studies::check_isoperiodic(request),
            _ => Ok(()),
        }
    }

    /// The diagram of a sweep; `None` for another kind, or where parts belong to other shards.
    ///
    /// # Errors
    /// As [`bifurcation::diagram`].
    pub fn diagram(&self, task: &Task) -> Result<Option<(Sweep, bifurcation::Diagram)>> {
        let StudyKind::Sweep { sweep, .. } = self.kind else { return Ok(None) };
        Ok(bifurcation::diagram(&self.set, &sweep, task)?.map(|d| (sweep, d)))
    }

    /// Computes the parts of the shard; the tables and pictures too where all parts are there.
    ///
    /// # Errors
    /// As [`check`](Self::check), [`bifurcation::diagram`], [`basin::basin`], [`isoperiodic::isoperiodic`], [`design_sweep::fill`] and
    /// [`tree_in_parts`].
    pub fn run(&self, task: &Task) -> Result<Option<Vec<Study>>> {
        self.run_telling(task, &|_, _| ())
    }

    /// The same; where the number of parts is not known beforehand, `tell` hears of what is done, and of what is known to be in all.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_telling(
        &self,
        task: &Task,
        tell: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Option<Vec<Study>>> {
        self.check()?;
        match &self.kind {
            StudyKind::Sweep { at, orbits, .. } => {
                let Some((sweep, diagram)) = self.diagram(task)? else { return Ok(None) };
                let mut found = vec![studies::sweep(&self.set, &sweep, &diagram, &self.name)?];
                let follow = |options| studies::DiagramOrbits::new(&self.set, &sweep, &diagram, options);
                let orbits = orbits.as_ref().map(follow).transpose()?;
                if let Some(orbits) = &orbits {
                    let name = format!("{}-orbits", self.name);
                    found.push(orbits.study(&self.set, &sweep, &diagram, &name)?);
                }
                if let (Some(options), false) = (&sweep.exponents, at.is_empty()) {
                    let (along, stem) = (sweep.axis.name, &self.name);
                    let name = format!("{stem}-spectra");
                    found.push(studies::spectra(&self.set, &sweep, &diagram, at, orbits.as_ref(), &name)?.1);
                    let name = format!("{stem}-running");
                    found.push(studies::running(&self.set, along, at, sweep.discard, options, &name)?);
                }
                Ok(Some(found))
            }
            StudyKind::Basin(request) => {
                let found = basin::basin(self.set.parameters(), request, task)?;
                let study = |b| studies::basins(&self.set, request, &b, &self.name).map(|s| vec![s]);
                found.map(study).transpose()
            }
            StudyKind::Isoperiodic(request) => {
                let found = isoperiodic::isoperiodic(&self.set, request, task)?;
                let study = |p| studies::isoperiodic(&self.set, request, &p, &self.name).map(|s| vec![s]);
                found.map(study).transpose()
            }
            StudyKind::DesignSweep(request) => {
                let is_complete = design_sweep::fill(&self.set, request, task)?;
                let study = || studies::design_sweep(&self.set, request, task, &self.name).map(|s| vec![s]);
                is_complete.then(study).transpose()
            }
            StudyKind::Orbits { span, loads, options } => {
                let family = Family::new(&self.set, *loads, *span)?;
                let told = |done, waiting| tell(done, done + waiting);
                let found = tree_in_parts(&family, options, task.store, &told)?;
                Ok(Some(vec![studies::orbits(&self.set, &family, &found.branches, Some(&found.searched))?]))
            }
        }
    }

    /// Writes the tables that are too long for memory from the parts of a finished study, which a [`Study`] names as its
    /// [`files`](Study::files).
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File), [`Error::Output`](crate::Error::Output).
    pub fn write_tables(&self, task: &Task, out: &Path) -> Result<()> {
        match &self.kind {
            StudyKind::DesignSweep(request) => {
                studies::write_design_tables(&self.set, request, task, &out.join(&self.name))
            }
            _ => Ok(()),
        }
    }
}
