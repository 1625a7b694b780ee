//! The platforms of `--all-platforms`: what each is compiled for, and what to install where it cannot be.

use crate::compile::{self, Compiler, PLATFORM, PLATFORM_TUPLE, Product, SHARED_LIBRARY};
use crate::error::{Error, Result};
use crate::version::Version;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use vibro_fmi::fmi2::description::MODEL_IDENTIFIER;

/// A platform of the archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder under `binaries/`: the names of FMI 2.0 for x86, and for other processors, as FMI 2.0.4 (2.3) has it,
    /// the platform tuples of FMI 3.0.
    pub folder: &'static str,
    /// The same in FMI 3.0 (2.5.1.4.1): the platform tuple.
    pub tuple: &'static str,
    /// Targets of the Rust compiler; several are joined into one universal file.
    pub targets: &'static [&'static str],
    /// glibc to link against, the oldest the Rust standard library runs with.
    pub glibc: Option<&'static str>,
    /// Ending of the library's name.
    pub ending: &'static str,
}

const fn platform(
    (folder, tuple): (&'static str, &'static str),
    targets: &'static [&'static str],
    glibc: Option<&'static str>,
    ending: &'static str,
) -> Platform {
    Platform { folder, tuple, targets, glibc, ending }
}

const GLIBC: Option<&str> = Some("2.17");

/// Every platform that is packed, where it can be built.
pub const PLATFORMS: [Platform; 7] = [
    platform(("linux64", "x86_64-linux"), &["x86_64-unknown-linux-gnu"], GLIBC, ".so"),
    platform(("win64", "x86_64-windows"), &["x86_64-pc-windows-gnu"], None, ".dll"),
    // Hosts on Apple's own processors look here too.
    platform(("darwin64", "x86_64-darwin"), &["x86_64-apple-darwin", "aarch64-apple-darwin"], None, ".dylib"),
    platform(("aarch64-darwin", "aarch64-darwin"), &["aarch64-apple-darwin"], None, ".dylib"),
    platform(("aarch64-linux", "aarch64-linux"), &["aarch64-unknown-linux-gnu"], GLIBC, ".so"),
    platform(("linux32", "x86-linux"), &["i686-unknown-linux-gnu"], GLIBC, ".so"),
    platform(("win32", "x86-windows"), &["i686-pc-windows-gnu"], None, ".dll"),
];

/// A compiled library and the folders in which it lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binary {
    folder: &'static str,
    tuple: &'static str,
    ending: &'static str,
    bytes: Vec<u8>,
}

impl Binary {
    /// A library of this machine.
    fn own(bytes: Vec<u8>) -> Self {
        Self { folder: PLATFORM, tuple: PLATFORM_TUPLE, ending: SHARED_LIBRARY, bytes }
    }
}

/// The compiled libraries of all archives: the same in each, in other folders.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Binaries(Vec<Binary>);

impl Binaries {
    /// One library for this machine.
    pub fn own(bytes: Vec<u8>) -> Self {
        Self(vec![Binary::own(bytes)])
    }

    /// Those of some platforms alone, by their folders in FMI 3.0.
    #[must_use]
    pub fn only(&self, tuples: &[&str]) -> Self {
        Self(self.0.iter().filter(|binary| tuples.contains(&binary.tuple)).cloned().collect())
    }

    /// The libraries by their folders in FMI 3.0.
    pub fn folders(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        self.0.iter().map(|binary| (binary.tuple, &*binary.bytes))
    }

    /// Those that [`folders`](Self::folders) gave; none where a folder is of no platform.
    pub fn from_folders(libraries: BTreeMap<String, Vec<u8>>) -> Option<Self> {
        let binary = |(name, bytes): (String, Vec<u8>)| {
            if name == PLATFORM_TUPLE {
                return Some(Binary::own(bytes));
            }
            let Platform { folder, tuple, ending, .. } = PLATFORMS.into_iter().find(|p| p.tuple == name)?;
            Some(Binary { folder, tuple, ending, bytes })
        };
        libraries.into_iter().map(binary).collect::<Option<_>>().map(Self)
    }

    /// Path inside the archive of a version → bytes.
    pub fn of(&self, version: Version) -> BTreeMap<String, Vec<u8>> {
        self.named(version, MODEL_IDENTIFIER)
    }

    /// The same of another model.
    pub fn named(&self, version: Version, model_identifier: &str) -> BTreeMap<String, Vec<u8>> {
        let place = |b: &Binary| version.binary_named(model_identifier, (b.folder, b.tuple), b.ending);
        self.0.iter().map(|b| (place(b), b.bytes.clone())).collect()
    }

    /// Names of the folders in the archive of a version, this machine's own first.
    pub fn names(&self, version: Version) -> Vec<&'static str> {
        let (own, others): (Vec<&Binary>, _) = self.0.iter().partition(|b| b.folder == PLATFORM);
        own.into_iter().chain(others).map(|b| version.folder((b.folder, b.tuple))).collect()
    }
}

/// A part of the archive, a platform or the live page, that could not be built as it should, and why.
#[derive(Debug)]
pub struct LeftOut {
    /// Its folder, or its path.
    pub folder: &'static str,
    /// What was in the way, and what to do.
    pub reason: String,
    /// Whether the machine's own compiler built it instead.
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

/// What one needs beside the Rust toolchain.
pub const TOOLS: &str = "install cargo-zigbuild, zig and, for wheels, maturin (`pip install -r fmu-build/requirements.txt` in a virtual environment) \
     and put them on the PATH";

fn read(library: &PathBuf) -> Result<Vec<u8>> {
    fs::read(library).map_err(Error::file("reading", library))
}

/// The binary of this machine that was compiled with the packager.
///
/// # Errors
/// [`Error::Cargo`], [`Error::File`].
pub fn at_hand() -> Result<Binaries> {
    Ok(Binaries::own(read(&compile::at_hand()?)?))
}

/// The binary of this machine alone, by its own compiler, to be handed on.
///
/// # Errors
/// [`Error::Cargo`], [`Error::File`].
pub fn own(product: Product) -> Result<Binaries> {
    Ok(Binaries::own(read(&Compiler::from(product).library()?)?))
}

/// The binaries of the platforms that can be built here, and a list of those that cannot. This machine's own is always among them; of the
/// others those that are asked for, by their names in FMI 3.0, or all where none is.
///
/// # Errors
/// Where not even this machine's own can be built.
pub fn all(only: &[String]) -> Result<(Binaries, Vec<LeftOut>)> {
    all_of(Product::Vibro, only)
}

/// The same of another product.
///
/// # Errors
/// As [`all`].
pub fn all_of(product: Product, only: &[String]) -> Result<(Binaries, Vec<LeftOut>)> {
    let mut binaries = Vec::new();
    let mut left_out = Vec::new();
    let wanted = |p: &Platform| p.folder == PLATFORM || is_asked_for(p.tuple, only);
    for platform in PLATFORMS.into_iter().filter(wanted) {
        let Platform { folder, tuple, ending, .. } = platform;
        match platform.build(product) {
            Ok(bytes) => binaries.push(Binary { folder, tuple, ending, bytes }),
            Err(reason) => {
                let replaced = platform.folder == PLATFORM;
                left_out.push(LeftOut { folder: platform.folder, reason, replaced });
            }
        }
    }
    if !binaries.iter().any(|binary| binary.folder == PLATFORM) {
        binaries.extend(own(product)?.0);
    }
    Ok((Binaries(binaries), left_out))
}

/// Whether a platform is asked for by its name in FMI 3.0; where no name is given, all are.
pub fn is_asked_for(tuple: &str, only: &[String]) -> bool {
    only.is_empty() || only.iter().any(|name| name == tuple)
}

impl Platform {
    /// Where its binary is in the archive of a version.
    pub fn path(&self, version: Version) -> String {
        version.binary((self.folder, self.tuple), self.ending)
    }

    /// Compiles its binary; the error says what to install.
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
        eprintln!("{}: {target}", self.folder);
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

/// Pages of Apple's processors, as a power of two: where the slices of a universal file begin.
const PAGE: u32 = 14;

/// A universal Mach-O file: a table of (processor, its subtype, offset, size, alignment) in big-endian words, then the
/// files themselves.
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

/// Whether a program can be run.
pub(crate) fn runs(program: &str, arguments: &[&str]) -> bool {
    let quiet = Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet.is_ok_and(|status| status.success())
}
