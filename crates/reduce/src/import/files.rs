//! The files of a model: their sizes, formats and roles.

use super::{Matrix, abaqus, calculix, harwell, market, punch};
use crate::dofs::Dof;
use crate::model::Model;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Size limit of a file in bytes: a larger one would not fit into memory with its matrix.
const MOST_BYTES: u64 = 10_000_000_000;

const EXPECTED: &str = "expected .mtx (Matrix Market or Abaqus), .sti, .mas, .dof (CalculiX), .pch (Nastran DMIG), \
                        .rsa, .hb or .matrix (Harwell-Boeing), .mapping (Ansys)";

/// The files of a model.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// Files whose roles are found by their names or contents.
    pub files: Vec<PathBuf>,
    /// The stiffness matrix.
    pub stiffness: Option<PathBuf>,
    /// The mass matrix.
    pub mass: Option<PathBuf>,
    /// The damping matrix.
    pub damping: Option<PathBuf>,
    /// The names of the dofs.
    pub dofs: Option<PathBuf>,
}

/// Content of a file.
enum Part {
    Stiffness(Matrix),
    Mass(Matrix),
    Dofs(String, Vec<Dof>),
    Nothing,
}

/// The text of a file. Its size is checked before the file is read.
///
/// # Errors
/// An error if it is too large, cannot be read, or is not a text.
pub fn text(path: &Path) -> Result<String> {
    let name = path.display().to_string();
    let unread = |e: std::io::Error| Error::new(&name, e.to_string());
    let size = std::fs::metadata(path).map_err(unread)?.len();
    if size > MOST_BYTES {
        let problem =
            format!("it has {:.1} GB; expected at most {} GB", size as f64 / 1e9, MOST_BYTES / 1_000_000_000);
        return Err(Error::new(&name, problem));
    }
    let bytes = std::fs::read(path).map_err(unread)?;
    String::from_utf8(bytes).map_err(|_| {
        Error::new(
            &name,
            format!(
                "it is not a text file; binary files (.op2, .op4, .full, .npz) are not supported. {EXPECTED}"
            ),
        )
    })
}

/// Reads the model of these files, in their units.
///
/// # Errors
/// An error of a file, and if stiffness or mass is missing or given twice.
pub fn read(sources: &Sources) -> Result<Model> {
    let (mut stiffness, mut mass, mut dofs) = (None, None, None);
    let mut put = |part: Part, path: &Path| {
        let (is_second, what) = match part {
            Part::Stiffness(own) => (stiffness.replace(own).is_some(), "stiffness matrix"),
            Part::Mass(own) => (mass.replace(own).is_some(), "mass matrix"),
            Part::Dofs(file, own) => (dofs.replace((file, own)).is_some(), "file of dofs"),
            Part::Nothing => (false, ""),
        };
        match is_second {
            true => {
                Err(Error::new(path.display().to_string(), format!("it is a second {what}; expected one")))
            }
            false => Ok(()),
        }
    };
    for path in &sources.files {
        for part in parts(path)? {
            put(part, path)?;
        }
    }
    if let Some(path) = &sources.stiffness {
        put(Part::Stiffness(one(path)?), path)?;
    }
    if let Some(path) = &sources.mass {
        put(Part::Mass(one(path)?), path)?;
    }
    if let Some(path) = &sources.dofs {
        put(named(path)?, path)?;
    }
    let missing = |what: &str| {
        Error::new("FILES", format!("they contain no {what} matrix; give it by --{what} FILE. {EXPECTED}"))
    };
    let stiffness = stiffness.ok_or_else(|| missing("stiffness"))?;
    let mass = mass.ok_or_else(|| missing("mass"))?;
    let damping = sources.damping.as_deref().map(one).transpose()?;
    super::model(stiffness, mass, damping, dofs)
}

/// A path's ending in small letters, and its name in capitals.
fn ending(path: &Path) -> (String, String) {
    let of = |part: Option<&std::ffi::OsStr>| {
        part.map(|own| own.to_string_lossy().into_owned()).unwrap_or_default()
    };
    (of(path.extension()).to_ascii_lowercase(), of(path.file_stem()).to_ascii_uppercase())
}

/// Content of a file, found by its ending and its text.
fn parts(path: &Path) -> Result<Vec<Part>> {
    let (ending, _) = ending(path);
    match ending.as_str() {
        "dof" | "mapping" | "map" => return Ok(vec![named(path)?]),
        "sti" | "mas" | "mtx" | "rsa" | "hb" | "rb" | "matrix" | "pch" | "dmig" => {}
        _ => return Err(Error::new(path.display().to_string(), EXPECTED)),
    }
    if ending == "pch" || ending == "dmig" {
        let file = path.display().to_string();
        let found = punch::matrices(&text(path)?, &file)?;
        let names: Vec<String> = found.iter().map(|own| own.0.clone()).collect();
        let parts: Vec<Part> = found.into_iter().map(|(name, matrix)| by_letter(&name, matrix)).collect();
        if parts.iter().all(|part| matches!(part, Part::Nothing)) {
            let problem =
                format!("its matrices are {}; expected names that begin with K or M", names.join(", "));
            return Err(Error::new(file, problem));
        }
        return Ok(parts);
    }
    let is_stiffness = role(path)?;
    let matrix = one(path)?;
    Ok(vec![if is_stiffness { Part::Stiffness(matrix) } else { Part::Mass(matrix) }])
}

/// A matrix of a punch file: K… is stiffness, but K4… structural damping; M… is mass.
fn by_letter(name: &str, matrix: Matrix) -> Part {
    match name.as_bytes() {
        [b'K', b'4', ..] => Part::Nothing,
        [b'K', ..] => Part::Stiffness(matrix),
        [b'M', ..] => Part::Mass(matrix),
        _ => Part::Nothing,
    }
}

/// Whether a file has the stiffness; else it has the mass.
fn role(path: &Path) -> Result<bool> {
    let (ending, name) = ending(path);
    let is = |long: &str, short: &str| {
        name.contains(long) || name == short || name.ends_with(&format!("_{short}"))
    };
    match (ending.as_str(), is("STIF", "K"), is("MASS", "M")) {
        ("sti", ..) | (_, true, false) => Ok(true),
        ("mas", ..) | (_, false, true) => Ok(false),
        _ => {
            let problem =
                "it may be a stiffness or a mass matrix; give it by --stiffness FILE or --mass FILE";
            Err(Error::new(path.display().to_string(), problem))
        }
    }
}

/// The one matrix of a file.
fn one(path: &Path) -> Result<Matrix> {
    let (file, (ending, _)) = (path.display().to_string(), ending(path));
    let text = text(path)?;
    let begins = |start: &str| text.get(..start.len()).is_some_and(|own| own.eq_ignore_ascii_case(start));
    match ending.as_str() {
        _ if begins("%%MatrixMarket") => market::matrix(&text, &file),
        "sti" | "mas" => calculix::matrix(&text, &file),
        "mtx" => abaqus::matrix(&text, &file),
        "rsa" | "hb" | "rb" | "matrix" => harwell::matrix(&text, &file),
        "pch" | "dmig" => match <[_; 1]>::try_from(punch::matrices(&text, &file)?) {
            Ok([(_, matrix)]) => Ok(matrix),
            Err(_) => Err(Error::new(file, "it has several matrices; give it among FILES")),
        },
        _ => Err(Error::new(file, EXPECTED)),
    }
}

/// The names of dofs of a file.
fn named(path: &Path) -> Result<Part> {
    let (file, text) = (path.display().to_string(), text(path)?);
    let list = match ending(path).0.as_str() {
        "mapping" | "map" => harwell::mapping(&text, &file)?,
        _ => calculix::dofs(&text, &file)?,
    };
    Ok(Part::Dofs(file, list))
}
