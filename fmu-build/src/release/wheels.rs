//! Source distribution and wheels of the Python package, built with maturin. The wheels are built
//! from the unpacked source distribution, so that a missing file is an error here and not at the
//! user's installation.

use crate::archive::{Content, write_file};
use crate::compile::{EPOCH, PLATFORM_TUPLE, cargo_home, output, remap, target, workspace};
use crate::error::{Error, Result};
use crate::kit::{KIT_FILE, Kit};
use crate::platforms::{TOOLS, has_standard_library, runs};
use flate2::read::GzDecoder;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A platform for which a wheel is built. One wheel serves all versions of Python from 3.9 on (its
/// stable interface, "abi3").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WheelPlatform {
    /// Name of the platform in FMI 3.0.
    pub tuple: &'static str,
    /// Target of the Rust compiler.
    pub target: &'static str,
    /// Platform in the wheel's name (the packaging specifications, "Platform compatibility tags").
    pub tag: &'static str,
    /// Description.
    pub words: &'static str,
    /// Path of the native module in the wheel.
    pub module: &'static str,
}

const SO: &str = "vibro_impact/_native.abi3.so";

/// Every platform for which a wheel is built if possible.
pub const WHEELS: [WheelPlatform; 5] = [
    WheelPlatform {
        tuple: "x86_64-linux",
        target: "x86_64-unknown-linux-gnu",
        tag: "manylinux2014_x86_64.manylinux_2_17_x86_64",
        words: "Linux on x86-64, glibc 2.17 or later",
        module: SO,
    },
    WheelPlatform {
        tuple: "aarch64-linux",
        target: "aarch64-unknown-linux-gnu",
        tag: "manylinux2014_aarch64.manylinux_2_17_aarch64",
        words: "Linux on 64-bit ARM, glibc 2.17 or later",
        module: SO,
    },
    WheelPlatform {
        tuple: "x86_64-windows",
        target: "x86_64-pc-windows-gnu",
        tag: "win_amd64",
        words: "Windows 10 or later on x86-64",
        module: "vibro_impact/_native.pyd",
    },
    WheelPlatform {
        tuple: "x86_64-darwin",
        target: "x86_64-apple-darwin",
        tag: "macosx_10_12_x86_64",
        words: "macOS 10.12 or later on Intel",
        module: SO,
    },
    WheelPlatform {
        tuple: "aarch64-darwin",
        target: "aarch64-apple-darwin",
        tag: "macosx_11_0_arm64",
        words: "macOS 11 or later on Apple silicon",
        module: SO,
    },
];

impl WheelPlatform {
    /// Name of the wheel's file.
    pub fn file(&self, version: &str) -> String {
        format!("vibro_impact-{}-cp39-abi3-{}.whl", python_version(version), self.tag)
    }

    /// Whether it is this machine's own platform.
    pub fn is_own(&self) -> bool {
        self.tuple == PLATFORM_TUPLE
    }
}

/// A version in Python's form (PEP 440): 0.2.0-rc.1 is 0.2.0rc1.
pub fn python_version(version: &str) -> String {
    [("-alpha.", "a"), ("-beta.", "b"), ("-rc.", "rc")]
        .into_iter()
        .fold(version.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Name of the source distribution's file.
pub fn sdist_file(version: &str) -> String {
    format!("vibro_impact-{}.tar.gz", python_version(version))
}

/// Sets the date of the archives' entries, which would otherwise be the date of the build.
fn dated(command: &mut Command) -> &mut Command {
    command.env("SOURCE_DATE_EPOCH", EPOCH)
}

/// Compiler flags that keep folders of this machine out of the module, as in the archives'
/// libraries.
fn flags(source: &Path) -> Vec<String> {
    let mut flags = vec![remap(source, "/vibro-impact")];
    flags.extend(cargo_home().map(|home| remap(&home, "/cargo")));
    flags.push(remap(&built(), "/target"));
    flags
}

/// Makes the linker of Windows libraries export the module's function. cargo-zigbuild leaves out
/// the compiler's list of exports. maturin 1.16 instead writes a list with the module's full name,
/// `PyInit_vibro_impact._native`, which is not the name of a function. A folder at the path of
/// that list prevents maturin from writing it, and the linker gets the correct list.
fn definitions() -> Result<String> {
    let place = built().join("maturin/vibro_impact._native.def");
    fs::create_dir_all(&place).map_err(Error::file("making the folder", &place))?;
    let list = place.join("exports.def");
    write_file(&list, format!("EXPORTS\n    {ENTRY}\n").as_bytes())?;
    Ok(format!("-Clink-arg={}", list.display()))
}

/// The function with which Python loads the native module.
pub const ENTRY: &str = "PyInit__native";

/// Build folder of wheels.
fn built() -> PathBuf {
    target().join("dist/cargo")
}

/// Advice on tools that are missing for building wheels; `None` if none is missing.
pub fn missing_tool() -> Option<String> {
    let there = ["maturin", "cargo-zigbuild"].into_iter().all(|tool| runs(tool, &["--version"]));
    (!there).then(|| TOOLS.to_owned())
}

/// Folder of the archives in the sources of the package.
pub const FMU_FOLDER: &str = "package/vibro_impact/fmu";

/// Makes the source distribution. It contains the archives of that folder, the kit for archives of
/// other machines, and these licences.
///
/// # Errors
/// [`Error::Cargo`] if Python or maturin fails; [`Error::File`] if a file cannot be read or
/// written.
pub fn sdist(archives: &Path, kit: &Kit, licences: &Content, version: &str, into: &Path) -> Result<PathBuf> {
    let package = workspace().join("python");
    for (name, text) in licences {
        write_file(&package.join(name), text)?;
    }
    // The kit is not a separate part of a release. The backend takes the kit from this folder if
    // the archives' folder has none.
    kit.write(&package.join(FMU_FOLDER).join(KIT_FILE))?;
    let mut python = Command::new("python3");
    // The package's own backend fetches the archives and calls maturin.
    python.args(["-c", "import backend, sys; backend.build_sdist(sys.argv[1])"]).arg(into);
    python.current_dir(&package).env("VIBRO_IMPACT_ARCHIVES", archives).env("PYTHONDONTWRITEBYTECODE", "1");
    output(dated(&mut python))?;
    Ok(into.join(sdist_file(version)))
}

/// Unpacks the source distribution, replaces a folder by it, and returns the path of its manifest.
///
/// # Errors
/// [`Error::File`].
pub fn unpack(sdist: &Path, version: &str, folder: &Path) -> Result<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(Error::file("removing", folder))?;
    }
    let file = fs::File::open(sdist).map_err(Error::file("opening", sdist))?;
    let mut tar = tar::Archive::new(GzDecoder::new(file));
    // All files have the same date. Cargo compares dates and would mistake an earlier build for a
    // build of these sources.
    tar.set_preserve_mtime(false);
    tar.unpack(folder).map_err(Error::file("unpacking into", folder))?;
    Ok(folder.join(format!("vibro_impact-{}", python_version(version))))
}

/// Builds the wheel of a platform from the unpacked source distribution.
///
/// # Errors
/// The reason of the failure, and the remedy.
pub fn wheel(platform: &WheelPlatform, source: &Path, into: &Path) -> std::result::Result<(), String> {
    if !has_standard_library(platform.target) {
        return Err(format!("run `rustup target add {}`", platform.target));
    }
    let mut maturin = Command::new("maturin");
    maturin.current_dir(source).args(["build", "--zig", "--target", platform.target]);
    if platform.tuple.ends_with("linux") {
        maturin.args(["--compatibility", "manylinux2014"]);
    }
    maturin.arg("--target-dir").arg(built()).arg("--out").arg(into);
    let mut flags = flags(source);
    if platform.target.contains("windows") {
        flags.push(definitions().map_err(|e| e.to_string())?);
    }
    maturin.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}")).env("CARGO_INCREMENTAL", "0");
    output(dated(&mut maturin)).map(drop).map_err(|e| format!("{e}; {TOOLS}"))
}
