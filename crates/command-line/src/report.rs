//! All figures at once, and a report of the paper's statements with the results.

mod analytical;
mod document;
mod fit;
mod page;
mod statement;
mod statements;

pub use fit::fit_page;
pub use statement::{Statement, Verdict};

use super::long_study::{LongStudy, OverSweep, StudyKind};
use super::studies::paper::DiagramOrbits;
use super::studies::{self, Study};
use crate::part_folder::PartFolder;
use crate::table::TextTable;
use crate::{Error, Result};
use std::path::Path;
use vibro_orbits::paper::TreeOptions;
use vibro_studies::basin::BasinRequest;
use vibro_studies::paper::basin::{InitialValueRange, in_the_middle};
use vibro_studies::paper::bifurcation::{Diagram, Sweep};
use vibro_studies::paper::lyapunov::SpectrumOptions;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::{Method, PAIRS, ParameterAxis};
use vibro_studies::paper::{Name, ParameterSet, find_group};
use vibro_studies::parts::{NoStore, Task};

/// Values of f10 in table 2: one in each periodic window and each chaotic band of the diagrams.
const TABLE: [f64; 14] = [0.6, 0.9, 1.0, 1.5, 2.1, 2.3, 2.44, 2.5, 2.7, 2.82, 2.88, 3.1, 3.6, 3.9];
/// Values of f10 in figure 15, all above 2 as in the paper.
const PORTRAITS: [f64; 9] = [2.2, 2.44, 2.5, 2.7, 2.82, 2.88, 3.1, 3.6, 3.9];
/// f10 of the modulated motion of figure 13.
const MODULATED: f64 = 0.6;
/// Value of f10 for which basins are shown: there, two pairs of attractors coexist in the default
/// set.
const COEXISTING: f64 = 2.5;
/// Values of f10 in figure 9.
const FORCES: [f64; 4] = [0.6, 1.2, 1.5, 2.5];
/// Values of f10 at which running exponents are shown.
const RUNNING: [f64; 4] = [0.6, 1.5, 2.44, 3.6];
/// Mass ratios of figure 17.
const EPSILONS: [f64; 5] = [0.1, 0.05, 0.02, 0.01, 0.005];
/// Names of the report's studies with the given parameters.
const NAMES: [&str; 20] = [
    "manifold-2",
    "manifold-7",
    "manifold-9",
    "stability-5",
    "stability-6",
    "steady",
    "compare-8",
    "response-frequency",
    "response-force",
    "plane",
    "figure-13",
    "figure-14",
    "figure-14-fine",
    "figure-14-orbits",
    "table-2",
    "exponents-running",
    "figure-15",
    "figure-16",
    "compare-17",
    "report",
];
/// The study of branches.
const ORBITS: &str = "figure-14-orbits";
/// Steps of the progress bar besides the parts of long studies: one for each group of figures.
const SHORT: usize = 9;

/// The studies of a report.
#[derive(Clone, Debug)]
pub struct Plan {
    set: ParameterSet,
    quick: bool,
    coarse: LongStudy,
    fine: LongStudy,
    basin: LongStudy,
    basin_set: ParameterSet,
    orbits: TreeOptions,
}

/// A finished report.
#[derive(Clone, Debug)]
pub struct Report {
    /// All studies, in the order of the paper.
    pub studies: Vec<Study>,
    /// The paper's statements with the results.
    pub statements: Vec<Statement>,
    /// The page.
    pub html: String,
}

impl Plan {
    /// A plan with the paper's numbers of values and periods; with `quick`, with fewer values and
    /// periods.
    ///
    /// # Errors
    /// None for the ranges used.
    pub fn new(set: &ParameterSet, quick: bool) -> Result<Self> {
        let (discard, keep, periods) = if quick { (200, 200, 300) } else { (400, 800, 1500) };
        let options = SpectrumOptions { periods, ..SpectrumOptions::default() };
        let sweep = |name: &str, range, count| -> Result<LongStudy> {
            let axis = ParameterAxis::new(find_group("f10")?, range, count)?;
            let sweep =
                Sweep { exponents: Some(options), ..Sweep::new(axis, Displacement::X2, (discard, keep)) };
            Ok(LongStudy::new(name, StudyKind::Diagram { request: sweep, over: OverSweep::default() }, set))
        };
        let cells = if quick { 40 } else { 200 };
        let initial = |range: &str| Ok::<_, Error>(range.parse::<InitialValueRange>()?.cells(cells));
        let (x, y) = (initial("x1=-1:1")?, initial("v2=-2:2")?);
        let there = set.with(find_group("f10")?, COEXISTING)?;
        Ok(Self {
            set: set.clone(),
            quick,
            coarse: sweep("figure-14", (0.5, 5.0), if quick { 91 } else { 451 })?,
            fine: sweep("figure-14-fine", (1.9, 4.0), if quick { 106 } else { 1051 })?,
            basin: LongStudy::new(
                "basin",
                StudyKind::Basin(BasinRequest { x, y, discard, start: in_the_middle() }),
                &there,
            ),
            basin_set: there,
            orbits: if quick { quick_orbits() } else { TreeOptions::default() },
        })
    }

    /// Steps of work, for a progress bar.
    pub fn steps(&self) -> usize {
        self.coarse.count() + self.fine.count() + self.basin.count() + SHORT
    }

    /// The studies that are computed in parts, in the order of the folders of [`Self::run`].
    pub fn long_studies(&self) -> [&LongStudy; 3] {
        [&self.coarse, &self.fine, &self.basin]
    }

    /// Names of all results, each with its parameters.
    ///
    /// # Errors
    /// None: the strong set is allowed.
    pub fn results(&self) -> Result<Vec<(&'static str, ParameterSet)>> {
        let mut all: Vec<_> = NAMES.iter().map(|name| (*name, self.set.clone())).collect();
        all.push(("compare-19", ParameterSet::strong()?));
        all.push(("basin", self.basin_set.clone()));
        Ok(all)
    }

    /// Computes all studies; the parts of long studies are kept in `folders` and read from there.
    ///
    /// # Errors
    /// The errors of the studies, and of reading and writing the parts.
    pub fn run(&self, folders: &[PartFolder; 3], done: &(dyn Fn(bool) + Sync)) -> Result<Report> {
        let (set, [coarse, fine, basin]) = (&self.set, folders);
        let mut all = self.theory(done)?;
        let (thirteen, modulation) = studies::paper::histories_of(set, find_group("f10")?.into(), MODULATED)?;
        all.push(thirteen);
        done(false);
        let (coarse, fine) = (diagram(&self.coarse, coarse, done)?, diagram(&self.fine, fine, done)?);
        let orbits = DiagramOrbits::new(set, &coarse.0, &coarse.1, &self.orbits, (&NoStore, &|_, _| ()));
        done(false);
        let (table, sweeps) = self.sweeps(&coarse, &fine, &orbits)?;
        all.extend(sweeps);
        let accuracy = studies::paper::accuracy(set, &EPSILONS)?;
        let errors = accuracy.tables.first().map(|t| t.1.clone()).unwrap_or_default();
        all.push(accuracy);
        done(false);
        all.push(studies::paper::strong_case(&ParameterSet::strong()?)?);
        done(false);
        let basins = self.basin.run(&Task { store: basin, done, ..Task::ALL })?;
        all.extend(basins.into_iter().flatten().map(|study| study.with_set(&self.basin_set)));
        let statements = statements::all(&statement::Findings {
            set,
            coarse: &coarse.1,
            fine: &fine.1,
            orbits: orbits.as_ref().ok(),
            modulation,
            errors: &errors,
        })?;
        let html = page::page(set, self.quick, &statements, &table, &all)?;
        Ok(Report { studies: all, statements, html })
    }

    /// The figures that need no simulation over a parameter: 2 and 5 to 12.
    fn theory(&self, done: &(dyn Fn(bool) + Sync)) -> Result<Vec<Study>> {
        let set = &self.set;
        let mut all = Vec::new();
        let mut add = |studies: Vec<Study>| {
            all.extend(studies);
            done(false);
        };
        add(vec![
            studies::paper::shapes(set)?,
            studies::paper::branches(set)?,
            studies::paper::families(set, Name::find("f10")?, &FORCES)?,
        ]);
        add(vec![studies::paper::regions(set)?, studies::paper::masri(set)?]);
        add(vec![studies::paper::steady(set)?, studies::paper::histories(set)?]);
        let shown = |name: &str| -> Result<(f64, f64)> { Ok(find_group(name)?.shown) };
        add(vec![
            studies::paper::frequency(
                set,
                shown("sigma1")?,
                (&[1.0, 1.5, 2.0, 2.5], &[0.2, 0.5, 1.0, 1.5]),
                None,
            )?,
            studies::paper::force(
                set,
                shown("f10")?,
                (&[0.2, 0.4, 0.8, 1.2], &[-0.2, -0.5, -0.8, -1.2]),
                None,
            )?,
        ]);
        let cells = if self.quick { 60 } else { 300 };
        let axis = |name: &str| -> Result<ParameterAxis> {
            let group = find_group(name)?;
            Ok(ParameterAxis::new(group, group.shown, cells)?)
        };
        let pairs = PAIRS.iter().map(|(x, y)| Ok((axis(x)?, axis(y)?))).collect::<Result<Vec<_>>>()?;
        add(vec![studies::paper::planes(set, &pairs, Method::MultipleScales, &|| ())?]);
        Ok(all)
    }

    /// The table of spectra, and the studies made from the sweeps: figures 14, 15, 16 and table 2.
    fn sweeps(
        &self,
        (sweep, coarse): &(Sweep, Diagram),
        (fine_sweep, fine): &(Sweep, Diagram),
        orbits: &Result<DiagramOrbits>,
    ) -> Result<(TextTable, Vec<Study>)> {
        let (set, force) = (&self.set, Name::Group(find_group("f10")?));
        let (table, spectra) =
            studies::paper::spectra(set, sweep, coarse, &TABLE, orbits.as_ref().ok(), "table-2")?;
        let options = sweep.exponents.unwrap_or_default();
        let running =
            studies::paper::running(set, force, &RUNNING, sweep.discard, &options, "exponents-running")?;
        let mut overlay = studies::paper::overlay(set, sweep, coarse, "figure-16")?;
        overlay.remarks.push("the maxima are from figure-14.csv".into());
        let all = vec![
            studies::diagram(set, sweep, coarse, "figure-14")?,
            studies::diagram(set, fine_sweep, fine, "figure-14-fine")?,
            match orbits {
                Ok(orbits) => orbits.study(set, sweep, coarse, ORBITS)?,
                // A machine whose orbits are not determined by phases, such as one with a free
                // block, has all other figures.
                Err(e) => Study::without_figure(ORBITS, format!("no branches of periodic orbits: {e}")),
            },
            spectra,
            running,
            studies::paper::portraits(set, force, fine, &PORTRAITS)?,
            overlay,
        ];
        Ok((table, all))
    }
}

/// Options of branches for the quick report, without long words.
fn quick_orbits() -> TreeOptions {
    TreeOptions {
        seeds: 46,
        settle: 600,
        starts: 0,
        depth: 4,
        longest_period: 4,
        most_letters: 16,
        ..TreeOptions::default()
    }
}

/// A sweep with its diagram.
fn diagram(study: &LongStudy, store: &PartFolder, done: &(dyn Fn(bool) + Sync)) -> Result<(Sweep, Diagram)> {
    // `None` is returned for shards only; here all parts are computed.
    let missing = || Error::Output { what: "the report", problem: "a part is missing".into() };
    study.diagram(&Task { store, done, ..Task::ALL })?.ok_or_else(missing)
}

impl Report {
    /// Summary for the screen.
    pub fn summary(&self, path: &Path) -> String {
        let count = |v: Verdict| self.statements.iter().filter(|s| s.verdict == v).count();
        let mut text = format!(
            "drew {} studies; the report is {}\nof {} statements of the paper {} agree, {} agree in part, {} do not",
            self.studies.len(),
            path.display(),
            self.statements.len(),
            count(Verdict::Agrees),
            count(Verdict::Partly),
            count(Verdict::Differs)
        );
        for remark in self.studies.iter().filter(|s| s.name == ORBITS).flat_map(|s| &s.remarks) {
            text.push_str(&format!("\n  {remark}"));
        }
        for s in &self.statements {
            text.push_str(&format!("\n  [{}] {}: {}", s.verdict.name(), s.place, s.found));
        }
        text
    }
}
