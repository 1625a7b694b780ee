//! `vibro reduce`, which reduces the matrices of a finite-element program to a body.
//!
//! The package `vibro-reduce` is part of the program with the feature `reduce` only, since its
//! factorisations take minutes to compile.

use crate::common_arguments::Common;
use crate::reduce_arguments::ReduceArguments;
use vibro::Result;

/// Refuses the command, and explains how to get a program with it.
///
/// # Errors
/// Always.
#[cfg(not(feature = "reduce"))]
pub fn reduce(_: &ReduceArguments, _: &Common) -> Result<()> {
    Err(vibro::Error::Refused {
        what: "reduce".into(),
        problem:
            "this program was built without it, since its factorisations take minutes to compile; in the \
                  repository: cargo run --release -p vibro --features reduce -- reduce …"
                .into(),
    })
}

#[cfg(feature = "reduce")]
pub use with_feature::reduce;

#[cfg(feature = "reduce")]
mod with_feature {
    use super::{Common, ReduceArguments, Result};
    use crate::common_arguments::DEFAULT_OUT;
    use crate::output;
    use crate::verifying::verify;
    use std::fs;
    use std::path::{Path, PathBuf};
    use vibro::Error;
    use vibro_reduce::damping::Damping;
    use vibro_reduce::import::files::{Sources, text};
    use vibro_reduce::job::Job;
    use vibro_reduce::reduction::Method;
    use vibro_reduce::statement::Given;

    /// Begins every written machine's file.
    const MADE: &str = "# Made by vibro reduce";

    /// Reduces the model and writes OUT.toml, OUT.npz, OUT.txt.
    ///
    /// # Errors
    /// [`Error::Refused`] for files, options and matrices; [`Error::File`].
    pub fn reduce(arguments: &ReduceArguments, common: &Common) -> Result<()> {
        let out = out(arguments, common)?;
        let path = |ending: &str| PathBuf::from(format!("{}.{ending}", out.display()));
        if !common.replace
            && let Ok(before) = fs::read_to_string(path("toml"))
            && !before.starts_with(MADE)
        {
            let what = format!("--out {}", out.display());
            let problem = format!(
                "{} exists and was not made by `vibro reduce`; choose another name, or --replace",
                path("toml").display()
            );
            return Err(Error::Refused { what, problem });
        }
        let job = job(arguments, &out)?;
        let made = job.run().map_err(refused)?;
        if let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(Error::file("making folder", folder))?;
        }
        let files = [
            (path("toml"), made.toml.as_bytes()),
            (path("npz"), &made.npz),
            (path("txt"), made.report.as_bytes()),
        ];
        for (path, bytes) in &files {
            fs::write(path, bytes).map_err(Error::file("writing", path))?;
        }
        let names: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
        output::say(&format!("{}\nwrote {}", made.said.join("\n"), names.join(", ")))?;
        if let (Some(file), Some(end)) = (&arguments.verify, arguments.until) {
            output::say(&verify(&job, &made, file, end)?.join("\n"))?;
        }
        Ok(())
    }

    fn refused(error: vibro_reduce::Error) -> Error {
        Error::Refused { what: error.what, problem: error.problem }
    }

    /// Path of the written files without their ending.
    fn out(arguments: &ReduceArguments, common: &Common) -> Result<PathBuf> {
        if common.out != Path::new(DEFAULT_OUT) {
            let is_ending = common.out.extension().is_some_and(|e| e == "toml" || e == "txt" || e == "npz");
            return Ok(if is_ending { common.out.with_extension("") } else { common.out.clone() });
        }
        let first = arguments.files.first().or(arguments.stiffness.as_ref());
        let stem = first.and_then(|path| path.file_stem());
        stem.map(PathBuf::from).ok_or_else(|| Error::Refused {
            what: "FILES".into(),
            problem: "expected the files of a model, such as blade.sti blade.mas blade.dof".into(),
        })
    }

    fn job(a: &ReduceArguments, out: &Path) -> Result<Job> {
        let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let method = match a.method.as_str() {
            "rubin" => Method::Rubin,
            "craig-bampton" => Method::CraigBampton,
            _ => Method::MacNeal,
        };
        Ok(Job {
            sources: Sources {
                files: a.files.clone(),
                stiffness: a.stiffness.clone(),
                mass: a.mass.clone(),
                damping: a.damping.clone(),
                dofs: a.dofs.clone(),
            },
            units: a.units.clone(),
            clamp: a.clamp.clone(),
            interfaces: a.interface.clone(),
            method,
            modes: a.modes,
            damping: damping(a)?,
            gravity: a.gravity.clone(),
            given: Given { contact_stiffness: a.contact_stiffness, load_frequency: a.load_frequency },
            name: a.name.clone().unwrap_or(name),
        })
    }

    fn damping(a: &ReduceArguments) -> Result<Damping> {
        if let Some(path) = &a.damping_table {
            let name = path.display().to_string();
            return text(path).and_then(|text| Damping::of_table(&text, &name)).map_err(refused);
        }
        match a.rayleigh[..] {
            [] => Ok(Damping::Ratio(a.damping_ratio.unwrap_or(0.0))),
            [alpha, beta] => Ok(Damping::Rayleigh(alpha, beta)),
            _ => Err(Error::Refused {
                what: "--rayleigh".into(),
                problem: "expected two numbers, α in 1/s and β in s, such as 0.1,1e-6".into(),
            }),
        }
    }
}
