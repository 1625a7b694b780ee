//! The studies of the command line: each makes tables and a figure from a machine.

#[cfg(test)]
mod apart;
mod basin;
mod branches;
mod curves;
mod design_sweep;
mod designed;
mod diagram;
mod diagram_orbits;
pub(crate) mod fit;
mod gradient;
mod isoperiodic;
mod locus;
mod orbit;
mod orbits;
mod panels;
pub mod paper;
mod response;
mod section;
mod spectrum;

pub use basin::{ShownBasins, basins, check_basins};
pub use curves::{CurveStart, LocusCurve};
pub use design_sweep::{design_sweep, write_tables as write_design_tables};
pub use designed::{best_machine, designed};
pub use diagram::{ShownDiagram, diagram};
pub use diagram_orbits::{diagram_branches, diagram_family, diagram_orbits};
pub use fit::{fit, fit_json, fit_numbers};
pub use gradient::add_gradient;
pub use isoperiodic::{POINT_IN_TABLE, ShownPlane, check_isoperiodic, isoperiodic};
pub use locus::loci;
pub use orbit::orbit;
pub use orbits::orbits;
pub use response::response;
pub use section::{SectionAxes, section};
pub use spectrum::{exponent, spectrum};

use crate::Result;
use crate::table::TextTable;
use vibro_figures::canvas::palette::{HERE, WHITE};
use vibro_figures::chart::{Axis, Figure, Layer, MARK, Mark};
use vibro_studies::paper::{Name, ParameterSet};

/// The outcome of a study.
#[derive(Clone, Debug)]
pub struct Study {
    /// Stem of the files.
    pub name: String,
    /// Content of the picture, as a phrase for the first line and the report.
    pub what: String,
    /// The numbers: stems of files and their CSV text.
    pub tables: Vec<(String, Vec<u8>)>,
    /// Names of the files of tables too long for memory, which
    /// [`LongStudy::write_tables`](crate::long_study::LongStudy::write_tables) writes.
    pub files: Vec<String>,
    /// Table printed to the screen, if any.
    pub shown: Option<TextTable>,
    /// The picture. `None` if there is nothing to draw; `what` then gives the reason.
    pub figure: Option<Figure>,
    /// Lines printed below the first line and listed in the report.
    pub remarks: Vec<String>,
    /// The study's own parameters, if they differ from the command's.
    pub set: Option<Box<ParameterSet>>,
    /// One-line description of the machine, for a study that varies what the subject's caption
    /// states.
    pub subject: Option<String>,
    /// Reason why nothing could be computed: the program then exits with 1.
    pub failure: Option<String>,
}

impl Study {
    /// A study of one table and one figure, whose files have the study's name.
    fn of(name: &str, what: impl Into<String>, table: &TextTable, figure: Figure) -> Result<Self> {
        let tables = vec![(name.into(), table.csv()?)];
        Ok(Self { tables, figure: Some(figure), ..Self::without_figure(name, what) })
    }

    /// A study without table and figure; `what` gives the reason.
    pub(crate) fn without_figure(name: &str, what: impl Into<String>) -> Self {
        let (tables, files, remarks) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            name: name.into(),
            what: what.into(),
            tables,
            files,
            shown: None,
            figure: None,
            remarks,
            set: None,
            subject: None,
            failure: None,
        }
    }

    /// The study with its own parameters.
    pub(crate) fn with_set(self, set: &ParameterSet) -> Self {
        Self { set: Some(Box::new(set.clone())), ..self }
    }

    /// The study with these remarks.
    fn with_remarks(self, remarks: Vec<String>) -> Self {
        Self { remarks, ..self }
    }
}

/// Size of a panel in units of the drawing, unless a figure needs another.
const PANEL: (u32, u32) = (1700, 1150);

/// Axis over a range of a parameter. The range is in SI; the axis shows the parameter's written
/// unit.
fn parameter_axis(set: &ParameterSet, name: Name, (from, to): (f64, f64)) -> Axis {
    let axis = Axis::over(set.label(name), from, to);
    match set.unit(name) {
        Some(unit) => axis.times(unit.number(1.0)),
        None => axis,
    }
}

/// Mark at the set's own parameters, with a white edge so that it shows on any colour.
fn here(set: &ParameterSet, x: Name, y: Name) -> [Layer; 2] {
    let mark = |name, colour| Layer::marks(name, colour, Mark::Disc, vec![(x.value(set), y.value(set))]);
    [mark("", WHITE).stroke(MARK + 5), mark("this set of parameters", HERE)]
}
