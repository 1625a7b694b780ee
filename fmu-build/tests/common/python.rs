//! What the tests that need Python share: the virtual environment and the packaged FMU.

use fmu_build::version::Version;
use fmu_build::{package, platforms};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use vibro_impact::numerics::digest::fnv1a;

/// Oldest Python that the pinned requirements can be installed in.
const OLDEST_PYTHON: (u32, u32) = (3, 9);

/// What to do about a missing or incomplete Python.
const REMEDY: &str = "install Python >= 3.9 with venv and pip (Debian and Ubuntu: `apt install python3 python3-venv`), \
                      or name one in the environment variable PYTHON";

/// Root of the workspace.
pub fn root() -> &'static Path {
    fmu_build::compile::workspace()
}

/// The packaged FMU, built on first use in this process; those of FMI 3.0 lie beside it.
pub fn fmu() -> PathBuf {
    let path = fmu_build::compile::target().join("fmu-test").join("VibroImpact3DOF.fmu");
    let versions = Version::ALL;
    let built = platforms::own().and_then(|binaries| package::write(&path, &versions, &binaries, None));
    built.unwrap_or_else(|error| panic!("{error}"));
    path
}

/// Python of the virtual environment with the pinned requirements; made on first use, then reused.
pub fn python() -> PathBuf {
    python_with(&["tests/fmpy/requirements.txt"])
}

/// Python of a virtual environment in which the package `vibro_impact` is installed from a wheel, with the packaged FMUs inside and
/// what its tests need beside. The wheel is built without the optimisations of a release, on which no bit depends, and once in a
/// process: no test's package is replaced while it runs.
pub fn python_with_wheel() -> PathBuf {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| install_wheel(&[])).clone()
}

/// The same with further requirements, in an environment of its own.
pub fn install_wheel(also: &[&str]) -> PathBuf {
    let usual = ["tests/fmpy/requirements.txt", "tests/python/requirements.txt"];
    let python = python_with(&[&usual[..], also].concat());
    let programs = python.parent().expect("a program is in a folder");
    let folder = programs.parent().expect("an environment is a folder");
    let lock = File::create(folder.with_extension("wheel-lock")).expect("target can be written");
    lock.lock().expect("files under target can be locked");
    // maturin is called by its name.
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let paths: Vec<PathBuf> =
        std::iter::once(programs.to_owned()).chain(std::env::split_paths(&usual)).collect();
    let archives = fmu().parent().expect("a file is in a folder").to_owned();
    let wheels = folder.join("wheels");
    let pip = |arguments: &[&OsStr]| {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "--quiet", "--disable-pip-version-check"]).args(arguments).current_dir(root());
        pip.env("PATH", std::env::join_paths(&paths).expect("no path holds the separator"));
        // In a folder of its own: what maturin tells the build of PyO3 differs from what cargo does, so that each would undo the other.
        pip.env("CARGO_TARGET_DIR", fmu_build::compile::target().join("wheel"));
        pip.env("VIBRO_IMPACT_ARCHIVES", &archives).env("MATURIN_PEP517_ARGS", "--profile dev");
        pip
    };
    let build = ["wheel", "--no-deps", "--no-build-isolation", "./python", "--wheel-dir"].map(OsStr::new);
    run("building the wheel", &mut pip(&[&build[..], &[wheels.as_os_str()]].concat()));
    let made = fs::read_dir(&wheels).expect("a folder").map(|entry| entry.expect("an entry").path());
    let wheel = made.max().expect("a wheel");
    let stamp = format!("{:016x}", fnv1a(&fs::read(&wheel).expect("it was made")));
    let installed = folder.join("wheel");
    if !fs::read_to_string(&installed).is_ok_and(|text| text == stamp) {
        let install = ["install", "--no-deps", "--force-reinstall"].map(OsStr::new);
        run("installing the wheel", &mut pip(&[&install[..], &[wheel.as_os_str()]].concat()));
        fs::write(installed, stamp).expect("target can be written");
    }
    python
}

/// The same for other requirements.
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

    // Several test processes may come here at once: one makes it, the others wait.
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
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
    pip.args(requirements.iter().flat_map(|path| ["--requirement", path])).current_dir(root());
    run(&format!("installing {}", requirements.join(" and ")), &mut pip);
    fs::write(complete, stamp).expect("target can be written");
    python
}

/// The first Python that is new enough: `$PYTHON`, else `python3`, else `python`.
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

/// Runs a command and returns what it printed; panics with all it said when it fails.
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
