//! The library in the archive. Cargo compiles it together with this packager; for distribution, a
//! nested cargo compiles it with link-time optimization.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub use vibro_pack::{PLATFORM, PLATFORM_TUPLE, SHARED_LIBRARY};

/// Every function of FMI 2.0 (2.1, 3.2, 4.2), each with the prefix `fmi2`. Hosts load all of them
/// by name, including functions of capabilities that are not claimed.
pub const FUNCTIONS: &str = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment \
    EnterInitializationMode ExitInitializationMode Terminate Reset \
    GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString \
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate \
    GetDirectionalDerivative \
    EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates \
    GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates \
    SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep \
    GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus";

/// Every function of FMI 3.0 (headers/fmi3Functions.h), each with the prefix `fmi3`.
pub const FUNCTIONS3: &str = "GetVersion SetDebugLogging InstantiateModelExchange InstantiateCoSimulation \
    InstantiateScheduledExecution FreeInstance EnterInitializationMode ExitInitializationMode EnterEventMode Terminate Reset \
    GetFloat32 GetFloat64 GetInt8 GetUInt8 GetInt16 GetUInt16 GetInt32 GetUInt32 GetInt64 GetUInt64 GetBoolean GetString \
    GetBinary GetClock SetFloat32 SetFloat64 SetInt8 SetUInt8 SetInt16 SetUInt16 SetInt32 SetUInt32 SetInt64 SetUInt64 \
    SetBoolean SetString SetBinary SetClock GetNumberOfVariableDependencies GetVariableDependencies \
    GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize SerializeFMUState DeserializeFMUState \
    GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode ExitConfigurationMode \
    GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction \
    SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates \
    EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetContinuousStateDerivatives \
    GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators \
    GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives DoStep ActivateModelPartition";

/// Names of the functions of both versions: everything that the library exports.
pub fn exported() -> impl Iterator<Item = String> {
    let of = |prefix: &'static str, list: &'static str| {
        list.split_whitespace().map(move |name| format!("{prefix}{name}"))
    };
    of("fmi2", FUNCTIONS).chain(of("fmi3", FUNCTIONS3))
}

/// Folder of the workspace that contains this packager's sources.
pub fn workspace() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// Folder for all build results.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from)
}

/// Path of a prebuilt library: cargo compiled it together with this packager, which depends on its
/// crate. No compiler runs; the library may contain paths of this machine and needs its compiler's
/// unwinder (libgcc_s).
///
/// # Errors
/// [`Error::Cargo`] if the file is missing, for example because the packager was moved out of the
/// target folder.
pub fn at_hand(library: Product) -> Result<PathBuf> {
    let missing = |problem: String| Error::Cargo { command: "cargo build --bin fmu-build".into(), problem };
    let program = std::env::current_exe().map_err(|e| missing(format!("cannot name this program: {e}")))?;
    let name = format!("{}{}{SHARED_LIBRARY}", std::env::consts::DLL_PREFIX, library.name());
    // Test executables are in the same folder, programs one folder above.
    let folder = program.parent().unwrap_or(Path::new(""));
    let places = [folder.join("deps").join(&name), folder.join(&name)];
    let found = places.iter().find(|path| path.is_file()).cloned();
    found.ok_or_else(|| {
        missing(format!("left no {}; with --portable it is compiled again", places[0].display()))
    })
}

/// Folders of the sources and of the compiled files.
#[derive(Clone, Debug)]
pub struct Compiler {
    workspace: PathBuf,
    target: PathBuf,
    product: Product,
}

/// A product that is compiled for distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// The library of the 3-DOF machine, which hosts load.
    Vibro,
    /// The library of any machine that a text file describes.
    Machine,
    /// The same as a component of the layered standard for WebAssembly.
    Component,
    /// The command line.
    CommandLine,
}

pub use vibro_pack::archive::PROGRAM;

/// The target of components, whose linker makes them.
pub(crate) const COMPONENT_TARGET: &str = "wasm32-wasip2";

/// Linker stub (`.tbd`) of the functions of Apple's CoreFoundation that the crate iana-time-zone
/// calls.
const CORE_FOUNDATION: &[u8] = b"--- !tapi-tbd
tbd-version: 4
targets: [ x86_64-macos, arm64-macos ]
install-name: '/System/Library/Frameworks/CoreFoundation.framework/Versions/A/CoreFoundation'
current-version: 1
compatibility-version: 150
exports:
  - targets: [ x86_64-macos, arm64-macos ]
    symbols: [ _CFRelease, _CFStringGetBytes, _CFStringGetCStringPtr, _CFStringGetLength, _CFTimeZoneCopySystem,
               _CFTimeZoneGetName, _CFTimeZoneResetSystem ]
...
";

impl Product {
    /// The package that is compiled.
    pub fn package(self) -> &'static str {
        match self {
            Self::Vibro => "vibro-paper-component",
            Self::Machine => "vibro-machine-fmu",
            Self::Component => "vibro-machine-wasm",
            Self::CommandLine => PROGRAM,
        }
    }

    /// File name without the platform's prefix and extension.
    fn name(self) -> &'static str {
        match self {
            Self::Vibro => "vibro_paper_component",
            Self::Machine => "vibro_machine_fmu",
            Self::Component => "vibro_machine_wasm",
            Self::CommandLine => PROGRAM,
        }
    }

    /// Arguments that tell cargo what to compile.
    fn made_by(self) -> &'static [&'static str] {
        match self {
            // `rustc` with a single crate type, since cargo leaves out link-time optimization if
            // an rlib is made as well.
            Self::Vibro | Self::Machine | Self::Component => &["rustc", "--lib", "--crate-type", "cdylib"],
            Self::CommandLine => &["rustc", "--bin", PROGRAM],
        }
    }
}

impl Default for Compiler {
    /// The nested cargo has its own target folder, so that it never waits for the lock of a cargo
    /// that runs this program.
    fn default() -> Self {
        Self { workspace: workspace().into(), target: target().join("fmu"), product: Product::Vibro }
    }
}

impl From<Product> for Compiler {
    /// The default compiler for another product.
    fn from(product: Product) -> Self {
        Self { product, ..Self::default() }
    }
}

impl Compiler {
    /// A compiler that reads the sources from a workspace folder and writes into a target folder.
    /// The compiled files must not depend on either folder.
    pub fn in_folders(workspace: &Path, target: &Path) -> Self {
        Self { workspace: workspace.into(), target: target.into(), product: Product::Vibro }
    }

    /// Compiles the product for this platform for distribution: with link-time optimization and
    /// without paths of this machine. The result needs only libc and libm.
    ///
    /// # Errors
    /// [`Error::Cargo`] if cargo cannot be run or fails.
    pub fn library(&self) -> Result<PathBuf> {
        let mut cargo = cargo();
        self.arguments(&mut cargo);
        if let Some(folder) = self.static_unwinder()? {
            cargo.args(["--", "-C"]).arg(format!("link-arg=-L{}", folder.display()));
        }
        made(&mut cargo, self.product)
    }

    /// Compiles the product as a component for WebAssembly and returns its path.
    ///
    /// # Errors
    /// [`Error::Cargo`] if cargo fails.
    pub(crate) fn component(&self) -> Result<PathBuf> {
        let mut cargo = cargo();
        self.arguments(&mut cargo);
        cargo.args(["--target", COMPONENT_TARGET]);
        made(&mut cargo, self.product)
    }

    /// Compiles the product for another target, linked by zig, and returns its path.
    ///
    /// # Errors
    /// [`Error::Cargo`] if cargo-zigbuild cannot be run or fails.
    pub(crate) fn library_for(&self, target: &str) -> Result<PathBuf> {
        let mut zigbuild = Command::new("cargo-zigbuild");
        self.arguments(&mut zigbuild);
        zigbuild.args(["--target", target]);
        if target.contains("windows") && self.product != Product::CommandLine {
            zigbuild.args(["--", "-C"]).arg(format!("link-arg={}", self.definitions()?.display()));
        }
        if target.contains("apple") && self.product == Product::CommandLine {
            zigbuild.args(["--", "-C"]).arg(format!("link-arg=-F{}", self.frameworks()?.display()));
        }
        made(&mut zigbuild, self.product)
    }

    /// Arguments of the nested cargo.
    fn arguments(&self, cargo: &mut Command) {
        cargo.current_dir(&self.workspace).args(self.product.made_by());
        cargo.args(["--package", self.product.package(), "--profile", "fmu", "--locked"]);
        cargo.args(["--message-format", "json-render-diagnostics", "--target-dir"]);
        cargo.arg(&self.target).env("CARGO_ENCODED_RUSTFLAGS", self.flags());
        // Incremental builds of a cdylib have left undefined symbols, which show only when a host
        // loads it.
        cargo.env("CARGO_INCREMENTAL", "0");
        // Windows libraries carry a time stamp.
        cargo.env("SOURCE_DATE_EPOCH", EPOCH);
    }

    /// Compiler flags: paths of this machine are remapped, so that builds in two folders are
    /// bit-identical. The flags replace the user's own flags, which must not affect distributed
    /// files.
    fn flags(&self) -> String {
        let mut flags = vec![remap(&self.workspace, "/vibro-impact")];
        flags.extend(cargo_home().map(|home| remap(&home, "/cargo")));
        // Last: of several matching prefixes the last one applies, and the workspace may lie
        // inside cargo's home.
        flags.push(remap(&self.target, "/target"));
        flags.join("\u{1f}")
    }

    /// Export list of a Windows library: cargo-zigbuild drops the compiler's own list, and then
    /// every symbol would be exported.
    fn definitions(&self) -> Result<PathBuf> {
        let file = self.target.join("fmi.def");
        let names = exported().map(|name| format!("    {name}\n"));
        let text = std::iter::once("EXPORTS\n".to_owned()).chain(names).collect::<String>();
        crate::archive::write_file(&file, text.as_bytes())?;
        Ok(file)
    }

    /// A folder for the linker with stubs of Apple's frameworks. For time stamps of tables, chrono
    /// calls a framework for the time zone. Zig only has stubs of the system's libraries, and
    /// Apple's own kit is for Macs.
    fn frameworks(&self) -> Result<PathBuf> {
        let folder = self.target.join("frameworks");
        crate::archive::write_file(
            &folder.join("CoreFoundation.framework/CoreFoundation.tbd"),
            CORE_FOUNDATION,
        )?;
        Ok(folder)
    }

    /// A folder for the linker that maps the name of GCC's shared run-time library to the static
    /// library. Unwinding then needs no library that a host's machine may lack. `None` if GCC's
    /// libraries are not used.
    fn static_unwinder(&self) -> Result<Option<PathBuf>> {
        if !cfg!(all(target_os = "linux", target_env = "gnu")) {
            return Ok(None);
        }
        let asked = Command::new("cc").arg("-print-file-name=libgcc_eh.a").stderr(Stdio::null()).output();
        // If the file does not exist, the compiler prints only the name.
        let found = asked.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_absolute());
        if !found {
            return Ok(None);
        }
        let folder = self.target.join("static-unwinder");
        crate::archive::write_file(&folder.join("libgcc_s.so"), b"GROUP(libgcc_eh.a libgcc.a)\n")?;
        Ok(Some(folder))
    }
}

/// Compiler flag that replaces a path of this machine by another in the binary.
pub(crate) fn remap(from: &Path, to: &str) -> String {
    format!("--remap-path-prefix={}={to}", from.to_string_lossy())
}

/// Cargo's folder with the sources of other crates.
pub(crate) fn cargo_home() -> Option<PathBuf> {
    let given = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    given.or_else(|| Some(std::env::home_dir()?.join(".cargo")))
}

/// 1980-01-01 in seconds since 1970, the time of all entries of archives.
pub(crate) const EPOCH: &str = "315532800";

/// The file of a product made by a cargo.
fn made(cargo: &mut Command, product: Product) -> Result<PathBuf> {
    let messages = output(cargo)?;
    let file = messages.lines().find_map(|message| file_of(message, product));
    file.ok_or_else(|| Error::Cargo { command: line(cargo), problem: "produced no file".into() })
}

/// Command for the cargo that runs this program, otherwise the cargo on PATH, in the workspace.
pub(crate) fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(workspace());
    cargo
}

/// Runs cargo, showing its messages; returns its standard output (JSON messages).
pub(crate) fn output(cargo: &mut Command) -> Result<String> {
    let command = line(cargo);
    let failed = |problem: String| Error::Cargo { command: command.clone(), problem };
    cargo.stdin(Stdio::null()).stderr(Stdio::inherit());
    let output = cargo.output().map_err(|e| {
        failed(format!("cannot be run: {e}; install the Rust toolchain or the program named"))
    })?;
    if !output.status.success() {
        return Err(failed(format!("failed ({}); its messages are above", output.status)));
    }
    String::from_utf8(output.stdout).map_err(|e| failed(format!("did not print UTF-8: {e}")))
}

fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Path of the shared library or program in one of cargo's JSON messages.
fn file_of(message: &str, product: Product) -> Option<PathBuf> {
    let message: serde_json::Value = serde_json::from_str(message).ok()?;
    let ours = message["reason"] == "compiler-artifact" && message["target"]["name"] == product.name();
    if product == Product::CommandLine {
        return message["executable"].as_str().filter(|_| ours).map(PathBuf::from);
    }
    let files = message["filenames"].as_array().filter(|_| ours)?;
    let shared = |name: &&str| [".so", ".dll", ".dylib", ".wasm"].iter().any(|ending| name.ends_with(ending));
    files.iter().filter_map(|f| f.as_str()).find(shared).map(PathBuf::from)
}
