//! Files of an earlier fit in a folder whose results a fit replaces.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use vibro::manifest::Manifest;
use vibro::{Error, Result};

/// Manifest of a fit of several records.
const NUMBERS: &str = "numbers.manifest.toml";
/// Files of a fit. Copies of a load's records are not among them: they may be the user's tables.
const FILES: [&str; 13] = [
    "fit.json",
    "fit.svg",
    "fit.png",
    "fit.caption.txt",
    "fit.manifest.toml",
    "fitted.toml",
    "start.toml",
    "report.html",
    "report.manifest.toml",
    "residuals.csv",
    "residuals-contacts.csv",
    "numbers.csv",
    NUMBERS,
];

/// Removes the files of an earlier fit from a folder and from the folders of its records. Other
/// files and the `inputs` of the present fit stay.
///
/// # Errors
/// [`Error::File`]; [`Error::Config`] for a damaged manifest.
pub fn remove(out: &Path, inputs: &[&Path]) -> Result<()> {
    let manifest = out.join(NUMBERS);
    if manifest.exists() {
        for name in records(&Manifest::read(&manifest)?) {
            let folder = out.join(name);
            remove_files(&folder, inputs)?;
            // A folder with other files stays.
            let _ = std::fs::remove_dir(&folder);
        }
    }
    remove_files(out, inputs)
}

/// Names of the records of a fit: the names of its tables without extension.
fn records(manifest: &Manifest) -> Vec<String> {
    let tables = ["data", "events"].map(|option| manifest.invocation.options.get(option));
    let paths = tables.into_iter().flatten().flat_map(|paths| paths.split(','));
    paths.filter_map(|path| Some(Path::new(path).file_stem()?.to_str()?.to_owned())).collect()
}

fn remove_files(folder: &Path, inputs: &[&Path]) -> Result<()> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let is_input = |path: &PathBuf| path.canonicalize().is_ok_and(|path| inputs.contains(&path));
    for path in FILES.map(|name| folder.join(name)).into_iter().filter(|path| !is_input(path)) {
        match std::fs::remove_file(&path) {
            Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                return Err(Error::file("removing", &path)(error));
            }
            _ => {}
        }
    }
    Ok(())
}
