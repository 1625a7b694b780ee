//! Destination of results. A run never destroys results of another run.
//!
//! Every result has a manifest next to it, and every folder of parts has a manifest. A run
//! overwrites only results of the same command with the same parameters. If a folder named by the
//! user holds other results or parts, the run is refused before work begins: a script either finds
//! the requested results there or gets an exit code. In the default folder, a run that finds
//! results or parts of another run gets a separate subfolder, named by a digest of its options and
//! parameters.

use crate::common_arguments::{Common, DEFAULT_OUT};
use std::fs::File;
use std::path::{Path, PathBuf};
use vibro::manifest::{Invocation, Manifest};
use vibro::part_folder::{Occupancy, PartFolder};
use vibro::studies::Study;
use vibro::subject::Subject;
use vibro::table::in_written_units;
use vibro::whole_file::write_whole;
use vibro::{Error, Result};
use vibro_figures::canvas::{self, About, Canvas, Drawing};
use vibro_figures::chart::Figure;

/// Endings of a result's files.
const ENDINGS: [&str; 6] = ["csv", "parquet", "svg", "png", "caption.txt", "html"];

/// Something that a run will write.
pub enum Claim {
    /// A finished result.
    Result(Manifest),
    /// A folder of parts, relative to the folder of results.
    Parts(PathBuf, Manifest),
}

/// Destination of a command's results.
pub struct Destination<'a> {
    common: &'a Common,
    invocation: &'a Invocation,
    subject: &'a dyn Subject,
}

impl<'a> Destination<'a> {
    /// The destination of an invocation's results for a machine.
    pub fn new(common: &'a Common, invocation: &'a Invocation, subject: &'a dyn Subject) -> Self {
        Self { common, invocation, subject }
    }

    /// The claim of a result by its name.
    pub fn result(&self, name: &str) -> Claim {
        Claim::Result(Manifest::of_result(name, self.invocation, self.subject))
    }

    /// The folder into which everything claimed can be written.
    ///
    /// # Errors
    /// [`Error::Config`] if a folder that the user named holds results or parts of another run, or
    /// if a manifest is damaged; [`Error::File`] if a file cannot be read.
    pub fn place(&self, claims: &[Claim]) -> Result<PathBuf> {
        let out = &self.common.out;
        let (own, foreign) = self.occupancy(out, claims)?;
        if *out == Path::new(DEFAULT_OUT) {
            let key = Manifest::of_result("", self.invocation, self.subject);
            let apart = out.join(format!("{}-{}", self.invocation.command, key.digest()));
            if foreign.is_some() || (!own && apart.exists()) {
                return match self.occupancy(&apart, claims)?.1 {
                    None => Ok(apart),
                    Some(error) => Err(error),
                };
            }
        }
        foreign.map_or(Ok(out.clone()), Err)
    }

    /// Whether a folder holds results or parts of this run, and the first refusal.
    fn occupancy(&self, out: &Path, claims: &[Claim]) -> Result<(bool, Option<Error>)> {
        let mut own = false;
        for claim in claims {
            let refusal = match claim {
                Claim::Result(_) if self.common.replace => None,
                Claim::Result(here) => {
                    own |= manifest_path(out, &here.study).exists();
                    other_result(out, here)?
                }
                Claim::Parts(folder, here) => {
                    let folder = out.join(folder);
                    let found = PartFolder::occupancy(&folder, here)?;
                    own |= found == Occupancy::Own;
                    match found {
                        Occupancy::Foreign(there) if !self.common.discard_unfinished => {
                            Some(vibro::part_folder::other_study(&folder, &there, here))
                        }
                        _ => None,
                    }
                }
            };
            if refusal.is_some() {
                return Ok((own, refusal));
            }
        }
        Ok((own, None))
    }

    /// Writes results into the folder that [`Self::place`] finds, and returns the folder.
    ///
    /// # Errors
    /// As [`Self::place`]; [`Error::File`], [`Error::Output`].
    pub fn write(&self, studies: &[Study]) -> Result<PathBuf> {
        let claims: Vec<_> = studies.iter().map(|s| Claim::Result(self.manifest(s))).collect();
        let out = self.place(&claims)?;
        self.write_into(studies, &out)?;
        Ok(out)
    }

    /// Writes results into a folder that [`Self::place`] has found.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Output`].
    pub fn write_into(&self, studies: &[Study], out: &Path) -> Result<()> {
        std::fs::create_dir_all(out).map_err(Error::file("making folder", out))?;
        for study in studies {
            let mut manifest = self.manifest(study);
            manifest.caption = study.figure.is_some().then(|| caption_file(&study.name));
            write_manifest(out, &manifest)?;
            // Tables are written while pictures are drawn.
            let (tables, pictures) = rayon::join(
                || self.write_tables(study, out),
                || {
                    let width = self.common.width;
                    let mut figure = study.figure.iter();
                    figure.try_for_each(|own| write_picture((own, width), &study.name, &manifest, out))
                },
            );
            tables.and(pictures)?;
        }
        Ok(())
    }

    /// Writes a page with its manifest into a folder that [`Self::place`] has found.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Output`].
    pub fn write_page(&self, name: &str, html: &str, out: &Path) -> Result<PathBuf> {
        write_manifest(out, &Manifest::of_result(name, self.invocation, self.subject))?;
        let path = out.join(format!("{name}.html"));
        write_whole(&path, html.as_bytes())?;
        Ok(path)
    }

    /// Writes the tables, in SI and, for a parameter written in another unit, in that unit too.
    fn write_tables(&self, study: &Study, out: &Path) -> Result<()> {
        let subject = self.subject_of(study);
        let write = |(name, csv): &(String, Vec<u8>)| {
            write_whole(&out.join(format!("{name}.csv")), &in_written_units(subject, csv)?)
        };
        study.tables.iter().try_for_each(write)
    }

    fn manifest(&self, study: &Study) -> Manifest {
        Manifest::of_result(&study.name, self.invocation, self.subject_of(study))
    }

    /// The machine of a study: its own if it has one, otherwise the machine of the command.
    fn subject_of<'s>(&'s self, study: &'s Study) -> &'s dyn Subject {
        study.set.as_deref().map_or(self.subject, |set| set)
    }
}

/// Name of the file with a picture's caption.
pub fn caption_file(name: &str) -> String {
    format!("{name}.caption.txt")
}

/// A drawing with the metadata of its files.
struct Told<D> {
    drawing: D,
    about: About,
}

impl<D: Drawing> Drawing for Told<D> {
    fn size(&self) -> (u32, u32) {
        self.drawing.size()
    }

    fn draw(&self, canvas: &mut Canvas) {
        self.drawing.draw(canvas);
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn millimetres(&self) -> Option<f64> {
        self.drawing.millimetres()
    }
}

/// Writes a picture as SVG and PNG, and its caption with settings, program and command. A width in
/// mm is the picture's width in print.
///
/// # Errors
/// [`Error::File`]; an error if the picture cannot be drawn.
pub fn write_picture(
    (figure, width): (&Figure, Option<f64>),
    name: &str,
    manifest: &Manifest,
    out: &Path,
) -> Result<()> {
    let mut about = figure.about();
    let command = &manifest.invocation.command_line;
    about.text += &format!("\nMade by {} {}: {command}", manifest.program, manifest.version);
    let caption = format!("{}\n\n{}\n", about.title, about.text.replace('\n', "\n\n"));
    let (svg, png) = match width {
        Some(millimetres) => canvas::svg_and_png(&Told { drawing: figure.printed(millimetres), about })?,
        None => canvas::svg_and_png(&Told { drawing: figure, about })?,
    };
    let path = |ending: &str| out.join(format!("{name}.{ending}"));
    write_whole(&path("svg"), svg.as_bytes())?;
    write_whole(&path("png"), &png)?;
    write_whole(&out.join(caption_file(name)), caption.as_bytes())
}

fn manifest_path(out: &Path, name: &str) -> PathBuf {
    out.join(format!("{name}.manifest.toml"))
}

/// Writes a manifest next to its result.
///
/// # Errors
/// [`Error::File`], [`Error::Output`].
pub fn write_manifest(out: &Path, manifest: &Manifest) -> Result<()> {
    write_whole(&manifest_path(out, &manifest.study), manifest.text()?.as_bytes())
}

/// Error against overwriting the result of another run; `None` if no such result exists.
fn other_result(out: &Path, here: &Manifest) -> Result<Option<Error>> {
    let (name, path) = (&here.study, manifest_path(out, &here.study));
    let allowed = "use another --out, or overwrite it with --replace";
    let problem = if path.exists() {
        let there = Manifest::read(&path)?;
        if there.describes_same(here) {
            return Ok(None);
        }
        let lines = there.differences_in_lines(here);
        format!("holds the result `{name}` of another run; they differ in\n{lines}\n  {allowed}")
    } else {
        let own = ENDINGS.iter().map(|ending| format!("{name}.{ending}"));
        // Version 0.3 kept the manifest of a motion of a machine's file under another name.
        let of_motion = (name == "run" && here.groups.is_empty()).then(|| "states.csv".into());
        let mut files = own.chain(of_motion);
        match files.find(|file| out.join(file).exists()) {
            None => return Ok(None),
            Some(file) => {
                format!(
                    "holds {file} without {name}.manifest.toml, so its parameters are unknown\n  {allowed}"
                )
            }
        }
    };
    Ok(Some(Error::Config { path: out.into(), problem }))
}

/// Locks the folder while it is examined and written; `None` if the system cannot lock a folder.
pub fn hold(out: &Path) -> Option<File> {
    std::fs::create_dir_all(out).ok()?;
    let folder = File::open(out).ok()?;
    folder.lock().ok()?;
    Some(folder)
}
