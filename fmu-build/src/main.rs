//! The packager's command line: arguments and printing only.

use clap::{Parser, Subcommand};
use fmu_build::archive::Content;
use fmu_build::assembly;
use fmu_build::compile::Product;
use fmu_build::kit::{self, KIT_FILE};
use fmu_build::picture::picture;
use fmu_build::release::agreement::Intent;
use fmu_build::release::{self, notes};
use fmu_build::table::RunTable;
use fmu_build::version::Version;
use fmu_build::{archive, compile, explorer, package, platforms, reference, run};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use vibro_figures::canvas;
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::fmi2::description::MODEL_IDENTIFIER;

/// Builds VibroImpact3DOF.fmu (FMI 2.0) and VibroImpact3DOF-FMI3.fmu, runs both, compares them with
/// the native library and draws the motion.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// File of the FMU of FMI 2.0, or a folder for it [default: VibroImpact3DOF.fmu here, in the
    /// repository in target/]. The FMU of FMI 3.0 and the pictures are written to the same folder
    #[arg(long, short, alias = "output")]
    out: Option<PathBuf>,
    /// Number of drive periods to run
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    periods: u32,
    /// Pack a binary for every platform that can be built here, and print what the other platforms
    /// require
    #[arg(long)]
    all_platforms: bool,
    /// Compile the library for this computer again, as for a release: with link-time optimization,
    /// without names of local folders, and depending on the C library only. Takes minutes; use it
    /// for FMUs that are passed on to others
    #[arg(long, conflicts_with = "all_platforms")]
    portable: bool,
    /// Also build an FMU of FMI 3.0 with arrays: displacements, velocities and accelerations as
    /// vectors, derivatives over a step as matrices. Several importers cannot read arrays
    #[arg(long)]
    arrays: bool,
    /// Also build an FMU of FMI 3.0 with these arrays and a clock that ticks at impacts. Several
    /// importers do not support clocks
    #[arg(long)]
    clocked: bool,
    /// Also pack a WebAssembly component (draft of FMI-LS-WASM) into the FMI 3.0 archives of machine
    /// files, and into the kit. Requires `rustup target add wasm32-wasip2`
    #[arg(long)]
    wasm: bool,
    /// Also pack the live page (documentation/explorer.html). If it cannot be built, print what it
    /// requires
    #[arg(long)]
    explorer: bool,
    /// Build the FMUs without running them
    #[arg(long)]
    no_run: bool,
    #[command(subcommand)]
    command: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Writes the generated files that are committed: modelDescription/, the pictures of README and
    /// documentation
    Refresh {
        /// Write only the files that follow from the table of variables. Takes a second instead of
        /// minutes: nothing is compiled for the archive, run or drawn
        #[arg(long)]
        description: bool,
    },
    /// Packs a machine file (docs/machine-file.md) as NAME.fmu (FMI 2.0) and NAME-FMI3.fmu. Only
    /// the library for all machines is compiled, once
    Assembly {
        /// Machine file (TOML)
        file: PathBuf,
        /// File of the FMU of FMI 2.0, or a folder for it [default: NAME.fmu here]. The FMU of FMI
        /// 3.0 is written to the same folder
        #[arg(long, short, alias = "output")]
        out: Option<PathBuf>,
        /// Pack a binary for every platform that can be built here, and print what the other
        /// platforms require
        #[arg(long)]
        all_platforms: bool,
        /// Also build an FMU of FMI 3.0 with derivatives over a step as matrices. Several importers
        /// cannot read arrays
        #[arg(long)]
        arrays: bool,
        /// Also pack a WebAssembly component (draft of FMI-LS-WASM) into the FMI 3.0 archive. Requires
        /// `rustup target add wasm32-wasip2`
        #[arg(long)]
        wasm: bool,
    },
    /// Prints the states of the native library at communication points as CSV, to compare with
    /// hosts
    Native {
        /// Communication step, s
        #[arg(long, default_value_t = 0.5)]
        step: f64,
        /// Number of steps
        #[arg(long, default_value_t = 1200)]
        steps: u32,
        /// Start values: box.s,block.s,secondary.s,box.v,block.v,secondary.v
        #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
        start: Vec<f64>,
    },
    /// Assembles a release: archives, wheels, source distribution, pages, notes, checksums
    Release {
        /// Tag that is released, e.g. v0.1.0. With a tag, no part may be left out
        #[arg(long)]
        tag: Option<String>,
        /// Assemble a preview with the changes under "Unreleased"; the work tree may have
        /// uncommitted changes
        #[arg(long, conflicts_with = "tag")]
        preview: bool,
        /// Assemble only for this platform, by its name in FMI 3.0, e.g. x86_64-linux. May be
        /// repeated
        #[arg(long, conflicts_with = "tag")]
        platform: Vec<String>,
        /// Folder of the release, which is replaced [default: dist/ of the repository]
        #[arg(long, alias = "output")]
        out: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match arguments.command {
        Some(Task::Refresh { description: true }) => package::described().and_then(write),
        Some(Task::Refresh { description: false }) => refresh(),
        Some(Task::Assembly { ref file, ref out, all_platforms, arrays, wasm }) => {
            let (all, arrays) = (arguments.all_platforms || all_platforms, arguments.arrays || arrays);
            pack(file, out.as_deref(), arrays, [all, arguments.wasm || wasm])
        }
        Some(Task::Native { step, steps, ref start }) => native(step, steps, start),
        Some(Task::Release { tag, preview, platform, out }) => {
            assemble(&Intent { tag, preview }, &platform, out)
        }
        None => build(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fmu-build: {error}");
            ExitCode::FAILURE
        }
    }
}

fn build(arguments: &Arguments) -> fmu_build::Result<()> {
    let in_repository = arguments.out.is_none() && package::is_here();
    let output = match in_repository {
        true => package::default_output(),
        false => package::placed(arguments.out.as_deref(), MODEL_IDENTIFIER),
    };
    let mut versions = Version::USUAL.to_vec();
    let asked = [(arguments.arrays, Version::Arrays), (arguments.clocked, Version::Clocked)];
    versions.extend(asked.into_iter().filter(|(asked, _)| *asked).map(|(_, version)| version));
    let (live, missing) = match arguments.explorer.then(explorer::page).transpose() {
        Ok(page) => (page, None),
        Err(left_out) => (None, Some(left_out)),
    };
    let mut left_out = match arguments.all_platforms {
        true => package::build_all(&output, &versions, live.as_deref())?,
        false => {
            let binaries =
                if arguments.portable { platforms::own(Product::Vibro)? } else { platforms::at_hand()? };
            package::write(&output, &versions, &binaries, live.as_deref()).map(|()| Vec::new())?
        }
    };
    left_out.extend(missing);
    for version in versions {
        println!("{}", version.beside(&output).display());
    }
    if in_repository {
        println!("{}", write_kit(&output, arguments)?.display());
    }
    if !arguments.no_run {
        show(&output, arguments.periods)?;
    }
    for part in left_out {
        println!("{part}");
    }
    Ok(())
}

/// Writes the kit for archives of described machines next to the archives; the Python package
/// takes both from there.
fn write_kit(output: &Path, arguments: &Arguments) -> fmu_build::Result<PathBuf> {
    let kit = match (arguments.all_platforms, arguments.portable) {
        (true, _) => kit::all()?.0,
        (false, true) => kit::own()?,
        (false, false) => kit::at_hand()?,
    };
    let kit = if arguments.wasm { kit::with_component(kit)? } else { kit };
    let file = output.with_file_name(KIT_FILE);
    kit.write(&file)?;
    Ok(file)
}

/// Packs a machine and names its archives.
fn pack(
    file: &Path,
    out: Option<&Path>,
    arrays: bool,
    [all_platforms, wasm]: [bool; 2],
) -> fmu_build::Result<()> {
    let (kit, left_out) = if all_platforms { kit::all()? } else { (kit::own()?, Vec::new()) };
    let kit = if wasm { kit::with_component(kit)? } else { kit };
    for path in assembly::write(file, out, arrays, &kit)? {
        println!("{}", path.display());
    }
    for part in left_out {
        println!("{part}");
    }
    Ok(())
}

/// Assembles a release and lists it.
fn assemble(intent: &Intent, platforms: &[String], out: Option<PathBuf>) -> fmu_build::Result<()> {
    let folder = out.unwrap_or_else(|| compile::workspace().join("dist"));
    let (parts, left_out) = release::assemble(compile::workspace(), intent, platforms, &folder)?;
    print!("{}", notes::table(&parts));
    for part in left_out {
        println!("{part}");
    }
    println!("{}", folder.display());
    Ok(())
}

/// Runs the FMU, prints the table and draws the pictures.
fn show(output: &Path, periods: u32) -> fmu_build::Result<()> {
    let run = run::run(output, periods)?;
    println!("{}", RunTable(&run));
    for path in pictures(&run, output)? {
        println!("{}", path.display());
    }
    Ok(())
}

fn native(step: f64, steps: u32, start: &[f64]) -> fmu_build::Result<()> {
    let start = match *start {
        [x1, x2, x3, v1, v2, v3] => State { x: [x1, x2, x3], v: [v1, v2, v3] },
        [] => State::default(),
        _ => {
            return Err(fmu_build::Error::Option {
                name: "--start",
                value: format!("{start:?}"),
                allowed: "six numbers".into(),
            });
        }
    };
    let mut simulator = Simulator::new(&Parameters::default(), &start, 0.0)?;
    println!("time,box.s,block.s,secondary.s,box.v,block.v,secondary.v");
    for i in 0..=steps {
        let time = f64::from(i) * step;
        simulator.advance_to(time)?;
        let State { x: [x1, x2, x3], v: [v1, v2, v3] } = simulator.state();
        println!("{time},{x1},{x2},{x3},{v1},{v2},{v3}");
    }
    Ok(())
}

fn pictures(run: &run::ComparedRun, beside: &Path) -> fmu_build::Result<[PathBuf; 2]> {
    let paths = [beside.with_extension("svg"), beside.with_extension("png")];
    archive::write_file(&paths[0], canvas::svg(&picture(run))?.as_bytes())?;
    archive::write_file(&paths[1], &canvas::png(&picture(run))?)?;
    Ok(paths)
}

fn refresh() -> fmu_build::Result<()> {
    let mut files = package::committed()?;
    files.extend(reference::results()?);
    let fmu = package::default_output();
    package::build(&fmu)?;
    let run = run::run(&fmu, 200)?;
    let folder = "modelDescription/documentation";
    files.insert(format!("{folder}/run.svg"), canvas::svg(&picture(&run))?.into_bytes());
    files.insert(format!("{folder}/run.png"), canvas::png(&picture(&run))?);
    write(files)
}

/// Writes files of the workspace and names them.
fn write(files: Content) -> fmu_build::Result<()> {
    for (name, bytes) in files {
        archive::write_file(&compile::workspace().join(&name), &bytes)?;
        println!("{name}");
    }
    Ok(())
}
