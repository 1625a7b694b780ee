//! Shared parts of the tests that need Python: the virtual environment and the packaged FMU.

use fmu_build::kit::{self, KIT_FILE};
use fmu_build::version::Version;
use fmu_build::{package, platforms};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use vibro_numerics::digest::fnv1a;

/// Oldest Python version for which the pinned requirements can be installed.
const OLDEST_PYTHON: (u32, u32) = (3, 9);

/// Advice for a missing or incomplete Python.
const REMEDY: &str = "install Python >= 3.9 with venv and pip (Debian and Ubuntu: `apt install python3 python3-venv`), \
                      or name one in the environment variable PYTHON";

/// Root of the workspace.
pub fn root() -> &'static Path {
    fmu_build::compile::workspace()
}

/// The packaged FMU, built on first use in this process; the FMI 3.0 FMU is next to it.
pub fn fmu() -> PathBuf {
    static FMU: OnceLock<PathBuf> = OnceLock::new();
    let pack = || {
        let path = fmu_build::compile::target().join("fmu-test").join("VibroImpact3DOF.fmu");
        let versions = Version::ALL;
        let built =
            platforms::at_hand().and_then(|binaries| package::write(&path, &versions, &binaries, None));
        built.unwrap_or_else(|error| panic!("{error}"));
        path
    };
    FMU.get_or_init(pack).clone()
}

/// The library of described machines that cargo compiled for this test, in the package's form;
/// made on first use in this process.
pub fn kit() -> PathBuf {
    static KIT: OnceLock<PathBuf> = OnceLock::new();
    let pack = || {
        let path = fmu().with_file_name(KIT_FILE);
        let written = kit::at_hand().and_then(|kit| Ok(kit.write(&path)?));
        written.unwrap_or_else(|error| panic!("{error}"));
        path
    };
    KIT.get_or_init(pack).clone()
}

/// Python of the virtual environment of the default tests; made on first use, then reused. It has
/// all requirements of fmpy, the package and the theory page.
pub fn python() -> PathBuf {
    python_with(&DEFAULT)
}

/// Requirement files of the default tests.
const DEFAULT: [&str; 3] =
    ["tests/fmpy/requirements.txt", "tests/python/requirements.txt", "tests/theory/requirements.txt"];

/// Python of the default tests, with the package `vibro_impact` of this tree copied into it: its
/// modules, the native part that cargo compiled for this test, and the packaged FMUs. Done once
/// per process, so that no package is replaced while a test uses it. `install_wheel` tests the
/// installation by pip.
pub fn python_with_package() -> PathBuf {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    let install = || {
        let python = python();
        let ask = "import sysconfig; print(sysconfig.get_path('platlib'))";
        let libraries = run("asking for site-packages", Command::new(&python).args(["-c", ask]));
        let installed = Path::new(libraries.trim()).join("vibro_impact");
        let lock = File::create(installed.with_extension("lock")).expect("target can be written");
        lock.lock().expect("files under target can be locked");
        copy_package(&installed);
        python
    };
    PYTHON.get_or_init(install).clone()
}

/// The compiled native part of the package. It is next to this test, because the packager's tests
/// depend on its crate.
fn native_part() -> PathBuf {
    let tests = std::env::current_exe().expect("a test is a file");
    let name = format!("{}_native{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    tests.parent().expect("a file is in a folder").join(name)
}

fn copy_package(installed: &Path) {
    let sources = root().join("python/package/vibro_impact");
    let ending = if cfg!(windows) { "pyd" } else { "abi3.so" };
    let modules = fs::read_dir(sources)
        .expect("it is part of the repository")
        .map(|entry| entry.expect("an entry").path());
    let mut files: Vec<(PathBuf, PathBuf)> = modules
        .filter(|path| path.is_file())
        .map(|path| (installed.join(path.file_name().expect("a file has a name")), path))
        .collect();
    files.push((installed.join(format!("_native.{ending}")), native_part()));
    let archives = Version::USUAL.map(|version| version.beside(&fmu()));
    for archive in archives.into_iter().chain([kit()]) {
        files.push((installed.join("fmu").join(archive.file_name().expect("a file has a name")), archive));
    }
    fs::create_dir_all(installed.join("fmu")).expect("target can be written");
    // A module that was removed from the package would still be importable.
    let is_old = |path: &PathBuf| path.is_file() && !files.iter().any(|(to, _)| to == path);
    let installed =
        fs::read_dir(installed).expect("it was made").map(|entry| entry.expect("an entry").path());
    installed.filter(is_old).for_each(|path| fs::remove_file(path).expect("target can be written"));
    for (to, from) in files {
        // A library in use is replaced, not overwritten.
        let _ = fs::remove_file(&to);
        fs::copy(&from, &to).unwrap_or_else(|error| panic!("copying {}: {error}", from.display()));
    }
}

/// Python of an environment with these requirements in which pip installed the package from a
/// wheel, built without release optimisations, which do not affect any bit.
pub fn install_wheel(also: &[&str]) -> PathBuf {
    let python = python_with(&[&DEFAULT[..], also].concat());
    let programs = python.parent().expect("a program is in a folder");
    let folder = programs.parent().expect("an environment is a folder");
    // maturin is found on the path.
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let paths: Vec<PathBuf> =
        std::iter::once(programs.to_owned()).chain(std::env::split_paths(&usual)).collect();
    let archives = kit().parent().expect("a file is in a folder").to_owned();
    let wheels = folder.join("wheels");
    let pip = |arguments: &[&OsStr]| {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "--quiet", "--disable-pip-version-check"]).args(arguments).current_dir(root());
        pip.env("PATH", std::env::join_paths(&paths).expect("no path holds the separator"));
        // In a separate folder: maturin configures the build of PyO3 differently from cargo, so
        // that each would undo the other's work.
        pip.env("CARGO_TARGET_DIR", fmu_build::compile::target().join("wheel"));
        pip.env("VIBRO_IMPACT_ARCHIVES", &archives).env("MATURIN_PEP517_ARGS", "--profile dev");
        pip
    };
    let build = ["wheel", "--no-deps", "--no-build-isolation", "./python", "--wheel-dir"].map(OsStr::new);
    run("building the wheel", &mut pip(&[&build[..], &[wheels.as_os_str()]].concat()));
    let made = fs::read_dir(&wheels).expect("a folder").map(|entry| entry.expect("an entry").path());
    let wheel = made.max().expect("a wheel");
    let install = ["install", "--no-deps", "--force-reinstall"].map(OsStr::new);
    run("installing the wheel", &mut pip(&[&install[..], &[wheel.as_os_str()]].concat()));
    python
}

/// A command for pytest over a folder of tests. Compiled modules go under `target/`, so that the
/// work tree stays clean.
pub fn pytest(python: PathBuf, folder: &str) -> Command {
    let mut pytest = command(python);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", folder]);
    pytest
}

/// A command for Python in the work tree. Only imported modules are compiled, once, under
/// `target/`, even if the user's environment forbids bytecode files: otherwise each of the many
/// processes would compile all modules.
pub fn command(python: PathBuf) -> Command {
    let mut command = Command::new(python);
    command.current_dir(root()).env("PYTHONPYCACHEPREFIX", fmu_build::compile::target().join("pycache"));
    command.env_remove("PYTHONDONTWRITEBYTECODE");
    command
}

/// Python of a virtual environment with the requirements of these files.
pub fn python_with(requirements: &[&str]) -> PathBuf {
    let read = |path: &&str| fs::read_to_string(root().join(path)).expect("it is part of the repository");
    let wanted: String = requirements.iter().map(read).collect();
    let system = system_python();
    let version = run("asking Python for its version", Command::new(&system).arg("--version"));
    let stamp = format!("{version}{wanted}");
    let folder = fmu_build::compile::target().join(format!("venv-{:016x}", fnv1a(stamp.as_bytes())));
    let python = match cfg!(windows) {
        true => folder.join("Scripts").join("python.exe"),
        false => folder.join("bin").join("python"),
    };
    let complete = folder.join("complete");

    // Several test processes may get here at the same time: one makes it, the others wait.
    fs::create_dir_all(folder.parent().expect("it lies under target")).expect("target can be written");
    let lock = File::create(folder.with_extension("lock")).expect("target can be written");
    lock.lock().expect("files under target can be locked");
    if fs::read_to_string(&complete).is_ok_and(|text| text == stamp) {
        return python;
    }
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("a half-made environment under target can be removed");
    }
    run(
        "making a virtual environment",
        Command::new(&system).args([OsStr::new("-m"), OsStr::new("venv"), folder.as_os_str()]),
    );
    let mut pip = Command::new(&python);
    // Most of the installed modules are never imported; the others are compiled at first use.
    pip.args(["-m", "pip", "install", "--no-compile", "--quiet", "--disable-pip-version-check"]);
    pip.args(requirements.iter().flat_map(|path| ["--requirement", path])).current_dir(root());
    run(&format!("installing {}", requirements.join(" and ")), &mut pip);
    fs::write(complete, stamp).expect("target can be written");
    python
}

/// `$PYTHON` if set, else the first of `python3` and `python` that is recent enough.
fn system_python() -> PathBuf {
    let chosen = std::env::var_os("PYTHON").map(PathBuf::from);
    let usual = ["python3", "python"].map(PathBuf::from);
    let candidates = chosen.map_or_else(|| usual.to_vec(), |python| vec![python]);
    let (major, minor) = OLDEST_PYTHON;
    let check = format!("import sys; sys.exit(sys.version_info < ({major}, {minor}))");
    let works = |python: &&PathBuf| {
        Command::new(python).args(["-c", &check]).output().is_ok_and(|output| output.status.success())
    };
    let found = candidates.iter().find(works).cloned();
    found.unwrap_or_else(|| panic!("none of {candidates:?} is a Python >= {major}.{minor}: {REMEDY}"))
}

/// Runs a command and returns its output; panics with all of its output if it fails.
pub fn run(what: &str, command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{what}: {error}: {REMEDY}"));
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(
        output.status.success(),
        "{what} failed ({}). If Python lacks something: {REMEDY}\n{stdout}\n{stderr}",
        output.status
    );
    stdout.into_owned()
}
