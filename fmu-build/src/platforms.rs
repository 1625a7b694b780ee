//! The platforms of `--all-platforms`: compiler targets, and advice on what to install if a
//! platform cannot be built.

use crate::compile::{self, COMPONENT_TARGET, Compiler, PLATFORM_TUPLE, Product};
use crate::error::{Error, Result};
use crate::version::Version;
use std::fmt::{self, Display, Formatter};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use vibro_pack::{PACKED_PLATFORMS, PackedPlatform};

pub use vibro_pack::Binaries;

/// A platform of the archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Its names in archives.
    pub place: PackedPlatform,
    /// Targets of the Rust compiler; several are joined into one universal file.
    pub targets: &'static [&'static str],
    /// Version of glibc to link against: the oldest that Rust's standard library supports.
    pub glibc: Option<&'static str>,
}

const fn platform(
    place: PackedPlatform,
    targets: &'static [&'static str],
    glibc: Option<&'static str>,
) -> Platform {
    Platform { place, targets, glibc }
}

const GLIBC: Option<&str> = Some("2.17");

/// All platforms of a release. An archive leaves out platforms that cannot be built on this
/// machine.
pub const PLATFORMS: [Platform; 7] = [
    platform(PACKED_PLATFORMS[0], &["x86_64-unknown-linux-gnu"], GLIBC),
    platform(PACKED_PLATFORMS[1], &["x86_64-pc-windows-gnu"], None),
    platform(PACKED_PLATFORMS[2], &["x86_64-apple-darwin", "aarch64-apple-darwin"], None),
    platform(PACKED_PLATFORMS[3], &["aarch64-apple-darwin"], None),
    platform(PACKED_PLATFORMS[4], &["aarch64-unknown-linux-gnu"], GLIBC),
    platform(PACKED_PLATFORMS[5], &["i686-unknown-linux-gnu"], GLIBC),
    platform(PACKED_PLATFORMS[6], &["i686-pc-windows-gnu"], None),
];

/// A part of the archive (a platform's binary or the live page) that could not be built, and the
/// reason.
#[derive(Debug)]
pub struct LeftOut {
    /// Its folder, or its path.
    pub folder: &'static str,
    /// Reason, and what to install.
    pub reason: String,
    /// Whether this computer's own compiler built it instead of cargo-zigbuild.
    pub replaced: bool,
}

impl Display for LeftOut {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { folder, reason, .. } = self;
        match self.replaced {
            true => {
                write!(f, "{folder} is built by this machine's linker and may need its C library: {reason}")
            }
            false => write!(f, "{folder} is left out: {reason}"),
        }
    }
}

/// Advice: tools needed in addition to the Rust toolchain.
pub const TOOLS: &str = "install cargo-zigbuild, zig and, for wheels, maturin (`pip install -r fmu-build/requirements.txt` in a virtual environment) \
     and put them on the PATH";

fn read(library: &PathBuf) -> Result<Vec<u8>> {
    fs::read(library).map_err(Error::file("reading", library))
}

/// The 3-DOF library for this platform, as compiled together with the packager.
///
/// # Errors
/// [`Error::Cargo`], [`Error::File`].
pub fn at_hand() -> Result<Binaries> {
    at_hand_of(Product::Vibro)
}

/// A library for this platform, as compiled together with the packager.
///
/// # Errors
/// As [`at_hand`].
pub fn at_hand_of(library: Product) -> Result<Binaries> {
    Ok(Binaries::own(read(&compile::at_hand(library)?)?))
}

/// The product for this platform only, built by its own compiler for distribution.
///
/// # Errors
/// [`Error::Cargo`], [`Error::File`].
pub fn own(product: Product) -> Result<Binaries> {
    Ok(Binaries::own(read(&Compiler::from(product).library()?)?))
}

/// The component of described machines for WebAssembly.
///
/// # Errors
/// [`Error::Cargo`] without the compiler's target, [`Error::File`].
pub fn component() -> Result<Vec<u8>> {
    if !has_standard_library(COMPONENT_TARGET) {
        let problem = format!("is missing; run `rustup target add {COMPONENT_TARGET}`");
        return Err(Error::Cargo { command: format!("the compiler's target {COMPONENT_TARGET}"), problem });
    }
    read(&Compiler::from(Product::Component).component()?)
}

/// Binaries of the 3-DOF library for the platforms that can be built here, and a list of the
/// others. `only` selects platforms by their FMI 3.0 tuples; empty selects all. This machine's own
/// platform is always included.
///
/// # Errors
/// An error if not even the binary for this machine can be built.
pub fn all(only: &[String]) -> Result<(Binaries, Vec<LeftOut>)> {
    all_of(Product::Vibro, only)
}

/// Binaries of a product for the platforms that can be built here, and a list of the others;
/// `only` as in [`all`].
///
/// # Errors
/// As [`all`].
pub fn all_of(product: Product, only: &[String]) -> Result<(Binaries, Vec<LeftOut>)> {
    let mut binaries = Vec::new();
    let mut left_out = Vec::new();
    let wanted = |p: &Platform| p.place.tuple == PLATFORM_TUPLE || is_asked_for(p.place.tuple, only);
    for platform in PLATFORMS.into_iter().filter(wanted) {
        match platform.build(product) {
            Ok(bytes) => binaries.push((platform.place, bytes)),
            Err(reason) => {
                let replaced = platform.place.tuple == PLATFORM_TUPLE;
                left_out.push(LeftOut { folder: platform.place.folder, reason, replaced });
            }
        }
    }
    if !binaries.iter().any(|(place, _)| place.tuple == PLATFORM_TUPLE) {
        binaries.push((PackedPlatform::OWN, read(&Compiler::from(product).library()?)?));
    }
    Ok((binaries.into_iter().collect(), left_out))
}

/// Whether the selection includes a platform, by its FMI 3.0 tuple; an empty selection includes
/// all.
pub fn is_asked_for(tuple: &str, only: &[String]) -> bool {
    only.is_empty() || only.iter().any(|name| name == tuple)
}

impl Platform {
    /// Path of its binary in the archive of a version.
    pub fn path(&self, version: Version) -> String {
        version.binary(self.place)
    }

    /// Compiles its binary; the error states what to install.
    fn build(&self, product: Product) -> std::result::Result<Vec<u8>, String> {
        if !runs("cargo-zigbuild", &["--version"]) {
            return Err(TOOLS.into());
        }
        let missing: Vec<&str> = self.targets.iter().copied().filter(|t| !has_standard_library(t)).collect();
        if !missing.is_empty() {
            return Err(format!("run `rustup target add {}`", missing.join(" ")));
        }
        let slices: Result<Vec<Vec<u8>>> =
            self.targets.iter().map(|target| self.compile(product, target)).collect();
        let mut slices = slices.map_err(|e| format!("{e}; {TOOLS}"))?;
        Ok(if slices.len() == 1 { slices.remove(0) } else { universal(&slices) })
    }

    fn compile(&self, product: Product, target: &str) -> Result<Vec<u8>> {
        eprintln!("{}: {target}", self.place.folder);
        let target = self.glibc.map_or_else(|| target.to_owned(), |version| format!("{target}.{version}"));
        read(&Compiler::from(product).library_for(&target)?)
    }
}

/// Whether the Rust standard library of a target is installed.
pub(crate) fn has_standard_library(target: &str) -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let asked = Command::new(rustc)
        .args(["--print", "target-libdir", "--target", target])
        .stderr(Stdio::null())
        .output();
    asked.is_ok_and(|o| PathBuf::from(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
}

/// Alignment of the slices of a universal file, as a power of two: the page size of Apple's
/// processors.
const PAGE: u32 = 14;

/// A universal Mach-O file: a table of (processor, its subtype, offset, size, alignment) in
/// big-endian words, then the files themselves.
fn universal(slices: &[Vec<u8>]) -> Vec<u8> {
    const MAGIC: u32 = 0xcafe_babe;
    let aligned = |n: usize| n.next_multiple_of(1 << PAGE);
    let mut table: Vec<u32> = vec![MAGIC, slices.len() as u32];
    let mut offset = aligned(8 + 20 * slices.len());
    for slice in slices {
        let word = |at: usize| u32::from_le_bytes([slice[at], slice[at + 1], slice[at + 2], slice[at + 3]]);
        table.extend([word(4), word(8), offset as u32, slice.len() as u32, PAGE]);
        offset = aligned(offset + slice.len());
    }
    let mut file: Vec<u8> = table.into_iter().flat_map(u32::to_be_bytes).collect();
    for slice in slices {
        file.resize(aligned(file.len()), 0);
        file.extend(slice);
    }
    file
}

/// Whether a program can be started with these arguments and succeeds.
pub(crate) fn runs(program: &str, arguments: &[&str]) -> bool {
    let quiet = Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet.is_ok_and(|status| status.success())
}
