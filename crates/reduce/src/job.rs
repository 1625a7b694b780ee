//! A reduction from files to texts: what `vibro reduce` does apart from arguments and writing.

use crate::damping::{Damping, projected};
use crate::dofs::Direction;
use crate::import::files::{self, Sources};
use crate::interface::{self, Interface};
use crate::model::Model;
use crate::output::{body, npz};
use crate::reduction::{Method, Reduced, reduce};
use crate::statement::{self, Given};
use crate::units::Units;
use crate::{Error, Result, clamp};
use std::path::Path;

/// A model to be reduced, with all options.
#[derive(Clone, Debug)]
pub struct Job {
    /// The files of the model.
    pub sources: Sources,
    /// Units of the files.
    pub units: String,
    /// Clamped nodes: lists, or files.
    pub clamp: Vec<String>,
    /// Interface nodes: `tip=428.xz`.
    pub interfaces: Vec<String>,
    /// The method.
    pub method: Method,
    /// Number of modes.
    pub modes: usize,
    /// Damping.
    pub damping: Damping,
    /// Direction of the weight, such as `-z`.
    pub gravity: Option<String>,
    /// Numbers for the error statement.
    pub given: Given,
    /// Name of the body.
    pub name: String,
}

/// The files of a reduced body.
#[derive(Clone, Debug)]
pub struct Made {
    /// The machine's file with the body.
    pub toml: String,
    /// The basis.
    pub npz: Vec<u8>,
    /// The report.
    pub report: String,
    /// Lines of the report about mass, first frequency and sag, which show a wrong unit.
    pub said: Vec<String>,
    /// The reduced body.
    pub reduced: Reduced,
}

impl Job {
    /// Reads, checks and reduces the model.
    ///
    /// # Errors
    /// An error of a file, an option, a dof or the computation.
    pub fn run(&self) -> Result<Made> {
        body::check_name(&self.name)?;
        let units = Units::read(&self.units)?;
        let model = self.clamped(files::read(&self.sources)?.in_units(&units))?;
        let read = |text: &String| Interface::read(text, &model.dofs, &model.clamped);
        let interfaces: Vec<Interface> = self.interfaces.iter().map(read).collect::<Result<_>>()?;
        interface::check(&interfaces, &model.dofs)?;
        let gravity = self.gravity.as_deref().map(|text| weight_of(text, &model)).transpose()?;
        let reduced = reduce(&model, &interfaces, self.method, self.modes)?;
        let gravity = gravity.map(|(direction, sign)| {
            let weight = model.mass.times(&model.translation(direction));
            (reduced.basis.tr_mul(&weight) * sign).as_slice().to_vec()
        });
        let matrix = model.damping.as_ref().map(|own| projected(own, &reduced.basis, &reduced.values));
        let matrix = matrix.transpose()?;
        let damping_ratios = match &matrix {
            Some(matrix) => matrix.ratios.clone(),
            None => self.damping.ratios(&reduced.frequencies())?,
        };
        let heading = self.heading(&model, &reduced);
        let section = body::Section { name: &self.name, heading: heading.clone(), damping_ratios, gravity };
        let toml = body::text(&reduced, &interfaces, &section);
        let mut said = statement::sizes(&model, &reduced);
        let mut report =
            heading.join("\n") + "\n\n" + &statement::text(&model, &reduced, &interfaces, &self.given);
        if let Some(matrix) = &matrix {
            let damped = statement::damping(matrix);
            report.push_str(&format!("\n{damped}\n"));
            said.push(damped);
        }
        let npz = archive(&model, &reduced, &interfaces)?;
        Ok(Made { toml, npz, report, said, reduced })
    }

    fn clamped(&self, model: Model) -> Result<Model> {
        let mut rows = Vec::new();
        for text in &self.clamp {
            let path = Path::new(text);
            let is_file = path.is_file() || path.extension().is_some_and(|e| e == "csv" || e == "txt");
            rows.extend(match is_file {
                true => clamp::of_file(&files::text(path)?, text, &model.dofs)?,
                false => clamp::of_list(text, &model.dofs)?,
            });
        }
        model.clamp(&rows)
    }

    /// Lines at the top of the files.
    fn heading(&self, model: &Model, reduced: &Reduced) -> Vec<String> {
        let all = (self.sources.files.iter()).chain(&self.sources.stiffness).chain(&self.sources.mass);
        let names: Vec<String> = all
            .chain(&self.sources.dofs)
            .map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned())
            .collect();
        vec![
            format!("Made by vibro reduce {} from {}", env!("CARGO_PKG_VERSION"), names.join(", ")),
            format!(
                "Units of the files: {}; here SI. {} dofs, {} of them clamped; {}, {} coordinates of mass 1",
                self.units,
                model.dofs.len() + model.clamped.len(),
                model.clamped.len(),
                self.method.name(),
                reduced.values.len()
            ),
        ]
    }
}

/// The direction and sign of weight.
fn weight_of(text: &str, model: &Model) -> Result<(Direction, f64)> {
    let (axis, sign) = match text.strip_prefix('-') {
        Some(axis) => (axis, -1.0),
        None => (text.strip_prefix('+').unwrap_or(text), 1.0),
    };
    let found = Direction::of_name(axis).filter(|direction| model.directions().contains(direction));
    found.map(|direction| (direction, sign)).ok_or_else(|| {
        let names: Vec<&str> =
            model.directions().iter().map(|d| d.name()).filter(|d| !d.is_empty()).collect();
        let problem = match names.is_empty() {
            true => "the model has no directions; give the names of its dofs by --dofs".into(),
            false => format!("expected one of {}, also with a minus sign, such as -z", names.join(", ")),
        };
        Error::new(format!("--gravity {text}"), problem)
    })
}

/// The basis and what belongs to it.
fn archive(model: &Model, reduced: &Reduced, interfaces: &[Interface]) -> Result<Vec<u8>> {
    use npz::Array::{List, Matrix, Texts};
    let names: Vec<String> = model.dofs.list().iter().map(ToString::to_string).collect();
    let labels = statement::labels(interfaces);
    let frequencies = reduced.frequencies();
    npz::archive(&[
        ("basis", Matrix(&reduced.basis)),
        ("dofs", Texts(&names)),
        ("frequencies", List(&frequencies)),
        ("interface", Texts(&labels)),
        ("residual", Matrix(&reduced.residual)),
    ])
}
