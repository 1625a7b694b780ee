//! Builds the pages. Each is one HTML file around a library compiled to WebAssembly; it opens from
//! disk and loads nothing.
//!
//! ```text
//! web/explorer/ (Rust) ─▶ cargo, wasm32 ─▶ wasm-bindgen ─▶ core_bg.wasm, core.js ─┐
//! web/explorer/page/ (JavaScript) ──────────────────────▶ esbuild (node) ─────────┴─▶
//! explorer.html
//! ```
//!
//! The page of described machines is built from `web/workbench/` in the same way, and may contain
//! a kit of compiled libraries for FMUs.
//!
//! The program needs the Rust target wasm32-unknown-unknown, node and npm. It installs the npm
//! packages of `web/explorer/page/package-lock.json` under the target folder.

use clap::Parser;
use lzma_rust2::{LzmaOptions, LzmaWriter};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

/// A page.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Page {
    /// The live page of the 3-DOF machine
    Explorer,
    /// The workbench for described machines
    Workbench,
}

impl Page {
    /// The page's name, used for its folder, the profile of its core, and its package.
    fn name(self) -> &'static str {
        match self {
            Self::Explorer => "explorer",
            Self::Workbench => "workbench",
        }
    }
}

/// Builds the live page of the vibro-impact machine, or the workbench for machine files.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Page to build
    #[arg(value_enum, default_value = "explorer")]
    page: Page,
    /// Kit (machine-kit.zip) with the libraries for FMUs, included in the workbench
    #[arg(long)]
    kit: Option<PathBuf>,
    /// File of the page [default: target/PAGE/PAGE.html]
    #[arg(long, short, alias = "output")]
    out: Option<PathBuf>,
    /// Compile the core faster, without link-time optimization
    #[arg(long)]
    quick: bool,
    /// Compile the core without 128-bit vectors of WebAssembly, to measure their benefit
    #[arg(long)]
    scalar: bool,
}

/// Build errors; each message includes the remedy.
#[derive(Debug, thiserror::Error)]
enum Error {
    /// A required tool is not installed.
    #[error("{what} is missing: {advice}")]
    Missing {
        /// The tool.
        what: &'static str,
        /// The command or page that installs it.
        advice: &'static str,
    },
    /// A program failed.
    #[error("`{command}` failed; its messages are above")]
    Failed {
        /// The command line.
        command: String,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// wasm-bindgen failed.
    #[error("wasm-bindgen: {0}")]
    Bindings(String),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match build(&arguments) {
        Ok(page) => {
            println!("{}", page.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("web-build: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace of this program's sources.
fn workspace() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here)
}

fn build(arguments: &Arguments) -> Result<PathBuf, Error> {
    check_tools()?;
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from);
    let name = arguments.page.name();
    let folder = target.join(name);
    let page = arguments.out.clone().unwrap_or_else(|| folder.join(name).with_extension("html"));
    let doors = folder.join(if arguments.scalar { "core-scalar" } else { "core" });
    bindings(&core(&folder, arguments)?, &doors)?;
    if arguments.page == Page::Workbench {
        let apart = doors.join("core.apart");
        let script = workspace().join("web/workbench/page/apart.mjs");
        run(Command::new("node").arg(script).arg(doors.join("core_bg.wasm")).arg(&apart))?;
        compress(&apart, &doors.join("core.lzma"))?;
    }
    let npm = packages(&target.join("explorer"))?;
    let mut bundle = Command::new("node");
    bundle
        .arg(workspace().join("web/explorer/page/bundle.mjs"))
        .arg(workspace().join("web").join(name).join("page"));
    bundle.arg(&doors).arg(&npm).arg(&page).args(&arguments.kit);
    run(&mut bundle)?;
    Ok(page)
}

/// Checks that all tools are installed.
fn check_tools() -> Result<(), Error> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let asked = Command::new(rustc)
        .args(["--print", "target-libdir", "--target", TARGET])
        .stderr(Stdio::null())
        .output();
    let found = asked.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir());
    if !found {
        let advice = "run `rustup target add wasm32-unknown-unknown`";
        return Err(Error::Missing { what: "the Rust target wasm32-unknown-unknown", advice });
    }
    for what in ["node", "npm"] {
        let there = Command::new(what).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !there.is_ok_and(|status| status.success()) {
            return Err(Error::Missing {
                what,
                advice: "install Node.js 18 or later with npm (Debian: apt install nodejs npm)",
            });
        }
    }
    Ok(())
}

fn run(command: &mut Command) -> Result<String, Error> {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let line = words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ");
    let failed = || Error::Failed { command: line.clone() };
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().map_err(|_| failed())?;
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stdout));
        return Err(failed());
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Compiles the core; returns its path.
fn core(folder: &Path, arguments: &Arguments) -> Result<PathBuf, Error> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let name = arguments.page.name();
    cargo.current_dir(workspace()).args(["build", "--locked", "--profile", name]);
    cargo.args(["--package", &format!("vibro-{name}")]);
    // A separate target folder, so that this cargo never waits for the lock of a cargo that runs
    // this program.
    let folder = folder.join(if arguments.scalar { "cargo-scalar" } else { "cargo" });
    cargo.args(["--target", TARGET, "--target-dir"]).arg(&folder);
    // The page must not contain paths of the build machine.
    let remap = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.to_string_lossy());
    let mut flags = vec![remap(workspace(), "/vibro-impact")];
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    flags.extend(
        home.or_else(|| Some(std::env::home_dir()?.join(".cargo"))).map(|home| remap(&home, "/cargo")),
    );
    // Both pages use (de)compression streams. Every browser that has them (since 2023) also has
    // these vectors.
    flags.extend((!arguments.scalar).then(|| "-Ctarget-feature=+simd128".to_owned()));
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}"));
    if arguments.quick {
        for setting in ["lto=false", "codegen-units=16"] {
            cargo.args(["--config", &format!("profile.{name}.{setting}")]);
        }
    }
    run(&mut cargo)?;
    Ok(folder.join(TARGET).join(name).join(format!("vibro_{name}.wasm")))
}

/// Writes the wasm-bindgen bindings: `core.js`, `core.d.ts` and `core_bg.wasm`.
fn bindings(core: &Path, folder: &Path) -> Result<(), Error> {
    let problem = |e: &dyn std::fmt::Display| Error::Bindings(e.to_string());
    let mut bindgen = Bindgen::new();
    bindgen.input_path(core).out_name("core").typescript(true);
    bindgen.remove_name_section(true).remove_producers_section(true);
    bindgen.web(true).map_err(|e| problem(&e))?.generate(folder).map_err(|e| problem(&e))
}

/// Compresses the core for `lzma.js`, as `.lzma` with its size in the header.
fn compress(core: &Path, packed: &Path) -> Result<(), Error> {
    let file = |path: &Path| {
        let path = path.to_owned();
        move |source| Error::File { path, source }
    };
    let bytes = std::fs::read(core).map_err(file(core))?;
    // Settings for data with many literals and without alignment.
    let options =
        LzmaOptions { lc: 3, pb: 0, nice_len: 273, dict_size: 1 << 22, ..LzmaOptions::with_preset(9) };
    let out = std::fs::File::create(packed).map_err(file(packed))?;
    let mut writer =
        LzmaWriter::new_use_header(out, &options, Some(bytes.len() as u64)).map_err(file(packed))?;
    writer.write_all(&bytes).map_err(file(packed))?;
    writer.finish().map_err(file(packed)).map(drop)
}

/// Installs the npm packages of the lock file and returns their folder.
fn packages(folder: &Path) -> Result<PathBuf, Error> {
    let npm = folder.join("npm");
    let file = |path: &Path| {
        let path = path.to_owned();
        move |source| Error::File { path, source }
    };
    std::fs::create_dir_all(&npm).map_err(file(&npm))?;
    let mut changed = !npm.join("node_modules").is_dir();
    for name in ["package.json", "package-lock.json"] {
        let (from, to) = (workspace().join("web/explorer/page").join(name), npm.join(name));
        let text = std::fs::read(&from).map_err(file(&from))?;
        if std::fs::read(&to).ok().as_ref() != Some(&text) {
            std::fs::write(&to, text).map_err(file(&to))?;
            changed = true;
        }
    }
    if changed {
        run(Command::new("npm")
            .args(["ci", "--no-audit", "--no-fund", "--loglevel=error"])
            .current_dir(&npm))?;
    }
    Ok(npm)
}
