//! The exact branches of periodic orbits over a bifurcation diagram, and the rows of the diagram
//! that lie on them.

mod drawn;

use super::lengths::Lengths;
use super::orbits::{search_in_words, special_table};
use crate::Result;
use crate::studies::Study;
use crate::studies::branches::{MAX_LISTED, listed};
use crate::studies::diagram::method;
use crate::studies::panels::DIRECTIONS;
use crate::table::{CsvRows, exact};
use drawn::{Drawn, NEVER_STABLE, UNSTABLE};
use rayon::prelude::*;
use vibro_figures::chart::Figure;
use vibro_impact::simulator::Simulator;
use vibro_orbits::paper::{
    Branch, Doubling, Family, Orbit, OrbitWord, PathOptions, RangeEnd, Span, StableRange, Tree, TreeOptions,
    branch, doubling_ratios, doubling_sequences, orbit_of, search, settle, tree_in_parts,
};
use vibro_studies::MotionClass;
use vibro_studies::diagram::Window;
use vibro_studies::paper::attractor::observe;
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};
use vibro_studies::paper::stroboscopic::dimensional;
use vibro_studies::paper::{Name, ParameterSet};
use vibro_studies::parts::PartStore;

/// Limit on the diagram's values among the seeds of the tree. A diagram with more values gets
/// seeds on a grid of at least this size instead.
const MOST_SEEDS: usize = 1001;
/// Drive periods after which a row that no branch covers is examined again. By then, the transient
/// of a row next to a bifurcation has decayed.
const LATER: u32 = 20_000;
/// Number of decimals of a printed located value; ten are reliable.
const DECIMALS: usize = 10;

/// The branch on which a periodic row of a diagram lies, or the reason why the row has none.
#[derive(Clone, Debug)]
pub enum Covering {
    /// The motion lies on a stable branch.
    Branch {
        /// The stable range of the branch that contains the row.
        range: StableRange,
        /// The branch's word, with its closing sign.
        word: String,
        /// Largest difference between the stroboscopic states of motion and orbit, in units of L
        /// and L ω10.
        distance: f64,
    },
    /// The block rests at a stop during the motion. Branches describe only orbits without rest.
    Rests,
    /// The motion had not settled yet. After further periods it lies on a stable branch.
    Transient,
    /// No followed branch contains it.
    Missing,
}

/// A periodic row of a diagram.
#[derive(Clone, Debug)]
pub struct CoveredRow {
    /// 0 with the value rising, 1 with the value falling.
    pub direction: usize,
    /// The value of the parameter.
    pub value: f64,
    /// The motion's class.
    pub class: MotionClass,
    /// The row's branch, or the reason why it has none.
    pub covering: Covering,
}

/// The branches over a diagram.
#[derive(Clone, Debug)]
pub struct DiagramOrbits {
    /// The family of machines over the parameter.
    pub family: Family,
    /// All branches.
    pub tree: Tree,
    /// The periodic rows of both directions.
    pub rows: Vec<CoveredRow>,
}

/// The family of a sweep.
///
/// # Errors
/// An error with the parameter's name if orbits cannot be followed over it.
pub fn sweep_family(set: &ParameterSet, sweep: &Sweep) -> Result<Family> {
    let span = Span::new(sweep.axis.name, sweep.axis.from, sweep.axis.to)?;
    let family = Family::new(set, span)?;
    // The search also reports errors of the machine that do not depend on the word, e.g. an
    // undamped mode in resonance. It does not matter here whether the word UL has an orbit.
    let middle = family.system(&[0.5 * (span.from + span.to)])?;
    match search(&middle, &OrbitWord::new("UL", 1, 2)?, 1) {
        Ok(_) | Err(vibro_studies::Error::NoOrbit { .. }) => Ok(family),
        Err(other) => Err(other.into()),
    }
}

impl DiagramOrbits {
    /// Follows all branches in the range of a sweep and assigns each periodic row of its diagram
    /// to a branch. Finished branches are kept in `store`. `told` reports the progress: numbers of
    /// starting orbits already followed and still queued.
    ///
    /// # Errors
    /// The errors of the machines and of the store.
    pub fn new(
        set: &ParameterSet,
        sweep: &Sweep,
        diagram: &Diagram,
        options: &TreeOptions,
        (store, told): (&dyn PartStore, &(dyn Fn(usize, usize) + Sync)),
    ) -> Result<Self> {
        let family = sweep_family(set, sweep)?;
        // Branches also start at up to `MOST_SEEDS` values of the diagram. Otherwise a window that
        // contains only one of these values could be missed.
        let steps = sweep.axis.count.min(MOST_SEEDS) - 1;
        let seeds = steps * (options.seeds.saturating_sub(1)).div_ceil(steps).max(1) + 1;
        let options = TreeOptions { seeds, ..options.clone() };
        let mut tree = tree_in_parts(&family, &options, store, told)?;
        let all = [&diagram.up, &diagram.down].into_iter().enumerate();
        let points: Vec<(usize, &SweepPoint)> = all
            .flat_map(|(direction, points)| points.iter().flatten().map(move |point| (direction, point)))
            .filter(|(_, point)| point.class.is_periodic())
            .collect();
        let row = |(direction, point): &(usize, &SweepPoint)| -> Result<CoveredRow> {
            let covering = covering(&family, &tree, point)?;
            Ok(CoveredRow { direction: *direction, value: point.value, class: point.class, covering })
        };
        let mut rows: Vec<CoveredRow> = points.par_iter().map(row).collect::<Result<_>>()?;
        for (row, (_, point)) in rows.iter_mut().zip(&points) {
            if matches!(row.covering, Covering::Missing) && follow_own(&family, &mut tree, point)? {
                row.covering = covering(&family, &tree, point)?;
            }
        }
        Ok(Self { family, tree, rows })
    }

    /// Stable range of the branch on which the motion at a value lies; `None` if the motion is not
    /// periodic or not covered.
    pub fn range_at(&self, direction: usize, value: f64) -> Option<&StableRange> {
        let row = self.rows.iter().find(|row| row.direction == direction && row.value == value)?;
        match &row.covering {
            Covering::Branch { range, .. } => Some(range),
            _ => None,
        }
    }

    /// Beginning of the stable range of the first covered row between two values, and end of the
    /// stable range of the last covered row between them.
    pub fn bounds(&self, direction: usize, (from, to): (f64, f64)) -> Option<(RangeEnd, RangeEnd)> {
        let inside = |row: &&CoveredRow| row.direction == direction && (from..=to).contains(&row.value);
        let range = |row: &CoveredRow| match &row.covering {
            Covering::Branch { range, .. } => Some(range.clone()),
            _ => None,
        };
        let mut ranges = self.rows.iter().filter(inside).filter_map(range);
        let first = ranges.next()?;
        let last = ranges.next_back().unwrap_or_else(|| first.clone());
        Some((first.from, last.to))
    }

    /// Number of periodic rows on a stable branch, and number of all settled periodic rows.
    pub fn share(&self) -> (usize, usize) {
        let count =
            |holds: &dyn Fn(&Covering) -> bool| self.rows.iter().filter(|row| holds(&row.covering)).count();
        let ended = count(&|c| !matches!(c, Covering::Transient));
        (count(&|c| matches!(c, Covering::Branch { .. })), ended)
    }

    /// Description of the coverage: the share, and the number of rows without a branch by reason.
    pub fn coverage_in_words(&self, set: &ParameterSet, sweep: &Sweep) -> Vec<String> {
        let (covered, ended) = self.share();
        let mut words = vec![format!(
            "{covered} of {ended} periodic rows of both directions whose transient has ended lie on a stable branch"
        )];
        let told = |what: &str, holds: &dyn Fn(&Covering) -> bool| {
            let rows: Vec<&CoveredRow> = self.rows.iter().filter(|row| holds(&row.covering)).collect();
            let row = |row: &&CoveredRow| {
                let (value, way) = (set.with_unit(sweep.axis.name, row.value), DIRECTIONS[row.direction]);
                format!("{value} {way} ({})", row.class.name())
            };
            listed(what, rows.iter().map(row))
        };
        words.extend(told("rest at a stop, which words do not describe", &|c| matches!(c, Covering::Rests)));
        words.extend(told(
            &format!("had not settled and lie on a stable branch {LATER} periods later"),
            &|c| matches!(c, Covering::Transient),
        ));
        words.extend(told("do not lie on a branch that was followed", &|c| matches!(c, Covering::Missing)));
        words
    }

    /// Text about each sequence of at least two doublings, with the ratios of successive
    /// distances.
    pub fn doublings_in_words(&self, set: &ParameterSet) -> Vec<String> {
        let sequences = doubling_sequences(&self.tree.branches).into_iter().filter(|s| s.len() > 1);
        let name = self.family.span().name;
        sequences.map(|sequence| doublings_in_words(set, name, &sequence)).collect()
    }

    /// The study: a picture of the branches over the diagram, with tables of the drawn curves,
    /// special points, stable ranges, windows and rows.
    ///
    /// # Errors
    /// [`Error::Output`](crate::Error::Output).
    pub fn study(&self, set: &ParameterSet, sweep: &Sweep, diagram: &Diagram, name: &str) -> Result<Study> {
        let (branches, along) = (&self.tree.branches, set.symbol(sweep.axis.name));
        let lengths = Lengths::of(set);
        let symbol = lengths.displacement(sweep.of.symbol());
        let drawn = Drawn::new(&self.family, branches, sweep, &lengths);
        let figure = Figure {
            title: format!("Periodic orbits over the bifurcation diagram of {symbol} over {along}"),
            caption: vec![
                method(sweep),
                format!(
                    "Orbits: exact, full where stable, dashed where unstable (up to {UNSTABLE}T, of branches stable nowhere \
                     {NEVER_STABLE}T). Marks: where stability changes."
                ),
                format!("Elsewhere {}", set.caption_but(&[sweep.axis.name])),
            ],
            panels: vec![drawn.panel(set, sweep, diagram, branches)],
            columns: 1,
            panel: (2900, 1700),
            shared_legend: false,
        };
        let mut remarks = self.coverage_in_words(set, sweep);
        remarks.push(search_in_words(&self.tree.searched));
        remarks.extend(self.doublings_in_words(set).into_iter().take(MAX_LISTED));
        let what = format!(
            "{} branches of periodic orbits over the local maxima of {symbol} over {along}",
            branches.len()
        );
        Ok(Study {
            tables: vec![
                (name.into(), drawn.table(sweep, branches)?),
                (format!("{name}-special-points"), special_table(self.family.span(), branches)?),
                (format!("{name}-stable-ranges"), range_table(sweep, branches)?),
                (format!("{name}-windows"), self.window_table(sweep, diagram)?),
                (format!("{name}-rows"), self.row_table(sweep)?),
            ],
            figure: Some(figure),
            ..Study::without_figure(name, what).with_remarks(remarks)
        })
    }

    /// Table of the diagram's periodic windows, with the stable ranges that contain their first
    /// and last rows.
    fn window_table(&self, sweep: &Sweep, diagram: &Diagram) -> Result<Vec<u8>> {
        let name = sweep.axis.name.name();
        let (from, to) = (format!("{name}_from"), format!("{name}_to"));
        let mut table = CsvRows::new([
            "direction",
            &from,
            &to,
            "class",
            "stable_from",
            "label_from",
            "stable_to",
            "label_to",
        ])?;
        for (direction, points) in [&diagram.up, &diagram.down].into_iter().enumerate() {
            let windows = Diagram::windows(points);
            for Window { from, to, class } in windows.into_iter().filter(|w| w.class.is_periodic()) {
                let lower = end_cells(self.range_at(direction, from).map(|range| range.from));
                let upper = end_cells(self.range_at(direction, to).map(|range| range.to));
                let row = vec![DIRECTIONS[direction].into(), exact(from), exact(to), class.name()];
                table.push([row, lower.to_vec(), upper.to_vec()].concat())?;
            }
        }
        table.text()
    }

    /// Table of the periodic rows with their branches.
    fn row_table(&self, sweep: &Sweep) -> Result<Vec<u8>> {
        let mut table = CsvRows::new([
            sweep.axis.name.name(),
            "direction",
            "class",
            "branch",
            "word",
            "distance",
            "not_covered",
        ])?;
        for row in &self.rows {
            let found = match &row.covering {
                Covering::Branch { range, word, distance } => {
                    [range.branch.to_string(), word.clone(), exact(*distance), String::new()]
                }
                Covering::Rests => not_covered("rests"),
                Covering::Transient => not_covered("transient"),
                Covering::Missing => not_covered("no branch"),
            };
            let own = vec![exact(row.value), DIRECTIONS[row.direction].into(), row.class.name()];
            table.push([own, found.to_vec()].concat())?;
        }
        table.text()
    }
}

fn not_covered(reason: &str) -> [String; 4] {
    [String::new(), String::new(), String::new(), reason.into()]
}

/// Text about a sequence of doublings, with the ratios of successive distances.
pub(crate) fn doublings_in_words(set: &ParameterSet, name: Name, sequence: &[Doubling]) -> String {
    let place = |d: &Doubling| format!("{} of {}T at {}", d.label, d.period, located(set, name, d.value));
    let places: Vec<String> = sequence.iter().map(place).collect();
    let ratios: Vec<String> = doubling_ratios(sequence).iter().map(|r| format!("{r:.3}")).collect();
    let told = if ratios.is_empty() { "" } else { "; ratios of the distances of the PD " };
    format!("{}{told}{}", places.join(", "), ratios.join(", "))
}

/// An end of a range as two cells.
pub(super) fn end_cells(end: Option<RangeEnd>) -> [String; 2] {
    end.map_or_else(Default::default, |e| {
        [format!("{:.15}", e.value), e.label.map_or(String::new(), |label| label.name().into())]
    })
}

/// An end of a range in words.
pub(crate) fn end_in_words(set: &ParameterSet, name: Name, end: RangeEnd) -> String {
    let label = end.label.map_or(String::new(), |label| format!("{label} "));
    format!("{label}{}", located(set, name, end.value))
}

/// A located value in the parameter's written unit.
fn located(set: &ParameterSet, name: Name, value: f64) -> String {
    match set.unit(name) {
        Some(unit) => format!("{:.DECIMALS$} {}", unit.number(value), unit.symbol()),
        None => format!("{value:.DECIMALS$}"),
    }
}

/// Adds the branch of the stable orbit on which a motion of the diagram lies; returns false if
/// there is none. The tree finds narrow windows only by chance, so a row may have settled on an
/// orbit that no start of the tree has reached.
fn follow_own(family: &Family, tree: &mut Tree, point: &SweepPoint) -> Result<bool> {
    let system = family.system(&[point.value])?;
    let Some(state) = point.attractor.states.first() else { return Ok(false) };
    let state = dimensional(system.parameters(), state);
    let Some(orbit) = orbit_of(&system, &state).ok().filter(Orbit::is_stable) else { return Ok(false) };
    let options = PathOptions::default();
    let Ok(mut found) = branch(family, orbit.word(), orbit.phases(), point.value, &options, &[]) else {
        return Ok(false);
    };
    found.id = tree.branches.len();
    tree.branches.push(found);
    Ok(true)
}

/// The branch on which a periodic motion lies, or the reason why it has none.
fn covering(family: &Family, tree: &Tree, point: &SweepPoint) -> Result<Covering> {
    let value = point.value;
    if point.attractor.rests {
        return Ok(Covering::Rests);
    }
    if let Some(found) = tree.covering(family, value, &point.attractor)? {
        let branch = &tree.branches[found.branch];
        if let Some(range) = branch.stable_range_of(&found.orbit, value) {
            let word = branch.word().signed();
            return Ok(Covering::Branch { range, word, distance: found.distance });
        }
    }
    let system = family.system(&[value])?;
    let Some(state) = point.attractor.states.first() else { return Ok(Covering::Missing) };
    let later = settle(&system, &dimensional(system.parameters(), state), LATER)?;
    let mut simulator = Simulator::new(system.parameters(), &later, 0.0)?;
    simulator.set_loads(&system.loads().loads())?;
    let motion = observe(&mut simulator)?;
    let covered = tree.covering(family, value, &motion)?.is_some();
    Ok(if covered { Covering::Transient } else { Covering::Missing })
}

/// Table of the stable ranges of branches.
fn range_table(sweep: &Sweep, branches: &[Branch]) -> Result<Vec<u8>> {
    let name = sweep.axis.name.name();
    let (from, to) = (format!("{name}_from"), format!("{name}_to"));
    let mut table =
        CsvRows::new(["branch", "word", "closing", "period", &from, "label_from", &to, "label_to"])?;
    for branch in branches {
        for range in branch.stable_ranges() {
            let word = branch.word();
            let own =
                vec![branch.id.to_string(), word.to_string(), word.sign().into(), range.period.to_string()];
            table.push(
                [own, end_cells(Some(range.from)).to_vec(), end_cells(Some(range.to)).to_vec()].concat(),
            )?;
        }
    }
    table.text()
}
