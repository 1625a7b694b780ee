"""Runs the packaged FMUs in third-party hosts, and writes the results into the table of docs/fmu.md.

    python3 tests/hosts/run.py [--allow-missing] [--no-page] [--only HOST ...]

Each host is installed separately under target/hosts/ (a virtual environment, or a root of `cargo install`). Required in addition
to Rust and Python >= 3.11: libclang for fmi-sim (Debian: libclang-dev) and TBB for ecos (Debian: libtbb12). If a host cannot
be installed, the command names it and fails, unless --allow-missing is given.

Four hosts are in no registry: PyFMI and OMSimulator are used if the Python that runs this script can import them, fmusim and
fmuCheck (FMI Library) if they are on PATH. Otherwise they are listed as missing; they are never required.
"""

import argparse
import csv
import functools
import os
import re
import shutil
import stat
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "hosts"
STATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")

# The communication points: 1200 steps of 0.5 s are 99 drive periods with some 190 impacts, and k/2
# is exact in binary and in libcosim's nanoseconds.
STEP, STEPS = 0.5, 1200

# Co-Simulation: the specified bound. For exact points, only the build may differ.
SAME = 1e-10

# Model Exchange is driven over 20 s with a dozen impacts from the start.
ME_START = ("block.s=0.9", "block.v=0.5")
ME_END = 20.0

# CVode at 1e-10, times the growth of errors from impact to impact (tests/fmpy/test_exchange.py:
# 1e-6 after forty).
CVODE = 1e-6

# Euler's method is of first order: half the step gives half the error; at the smaller step the
# error is at most about h t / 2 times the accelerations, which are below 2.
EULER_STEPS = (1 / 2000, 1 / 4000)
EULER_RATIO = (1.6, 2.5)
EULER = 0.005

# Event handling of an FMI 3.0 host: name, flags of fmpy, flags of fmi-sim.
EVENTS = (
    ("", "", ()),
    (", Event Mode", "+event", ("--event-mode-used",)),
    (", early return", "+early", ("--early-return-allowed",)),
    (", Event Mode and early return", "+event+early", ("--event-mode-used", "--early-return-allowed")),
)

# Steps of the container, longer than most flights: announced events lie inside the next step.
CONTAINER_STEP, CONTAINER_STEPS = 4.0, 75

# Machines of text files, in addition to the 3-DOF machine: name, file, variables, communication
# step, number of steps, of steps made in Model Exchange, and of steps before the first event. Steps
# are powers of two, whose sums are exact.
ASSEMBLIES = (
    ("DamperWithBuffer", "damper_with_buffer", ("box.s", "box.v", "block.s", "block.v", "pump.s", "pump.v"), 2**-9, 1024, 100, 4),
    ("MslCoupledClutches", "msl_coupled_clutches", ("J1.s", "J1.v", "J2.s", "J2.v", "J3.s", "J3.v", "J4.s", "J4.v"), 2**-9, 768, 768, 192),
)

# Error relative to a variable's largest value: CVode at 1e-10, amplified from event to event.
ASSEMBLY_SAME = 1e-10
ASSEMBLY_CVODE = 1e-5

# casadi's differences are one-sided, with steps of 1e-6; the kinetic energy is off by half of that.
DIFFERENCES = 1e-6


class Missing(Exception):
    """A host that cannot be installed here."""


class NotFound(Exception):
    """A host that no registry offers and that is not installed on this machine."""


def run(command, timeout=3600, names=()):
    command = [str(word) for word in command]
    variables = {**os.environ, "NAMES": ",".join(names)}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, env=variables)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\nfailed with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def environment(name, *requirements):
    """Python of the host's virtual environment."""
    folder = TARGET / name
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = folder / "complete"
    wanted = " ".join(requirements)
    if stamp.exists() and stamp.read_text() == wanted:
        return python
    venv.create(folder, with_pip=True, clear=True)
    try:
        run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *requirements])
    except RuntimeError as error:
        raise Missing(str(error)) from error
    stamp.write_text(wanted)
    return python


def fmi_sim():
    root = TARGET / "fmi-sim"
    program = root / "bin" / ("fmi-sim.exe" if os.name == "nt" else "fmi-sim")
    if not program.exists():
        try:
            run(["cargo", "install", "fmi-sim", "--version", "0.7.0", "--locked", "--debug", "--root", root,
                 "--target-dir", TARGET / "fmi-sim-build"])
        except (RuntimeError, OSError) as error:
            raise Missing(f"{error}\nfmi-sim needs libclang (Debian: apt install libclang-dev)") from error
    return program


def table(text, names=STATES):
    rows = list(csv.DictReader(text.splitlines()))
    return [(float(row["time"]), *(float(row[name]) for name in names)) for row in rows]


def native(step, steps, start=()):
    """The library's own states at the communication points."""
    values = dict(item.split("=") for item in start)
    numbers = ",".join(values.get(name, "0") for name in STATES)
    return table(run(["cargo", "run", "--quiet", "--bin", "fmu-build", "--", "native", f"--step={step!r}",
                      f"--steps={steps}", f"--start={numbers}"]))


def difference(got, expected, states=slice(1, 7)):
    """Largest difference from these states at any communication point; all points except the start must exist."""
    times = {round(row[0] * 1e6): row[states] for row in got}
    missing = [row[0] for row in expected[1:] if round(row[0] * 1e6) not in times]
    assert not missing, f"the host has no values at {missing[:5]} s"
    return max(abs(a - b) for row in expected[1:]
               for a, b in zip(times[round(row[0] * 1e6)], row[states]))


@functools.cache
def native_assembly(file, names, step, steps):
    """The engine's values at the communication points of a machine of a file."""
    folder = TARGET / "native"
    run(["cargo", "run", "--quiet", "--bin", "vibro", "--", "run", ROOT / "examples/assembly" / f"{file}.toml",
         "--until", f"{step * steps!r}s", "--samples", steps, "--out", folder, "--replace"])
    return table((folder / "states.csv").read_text(), names)


def relative(got, expected):
    """Largest difference at any communication point, relative to each variable's largest value."""
    largest = [max(abs(row[k]) for row in expected) or 1.0 for k in range(1, len(expected[0]))]
    scale = lambda rows: [(row[0], *(x / most for x, most in zip(row[1:], largest))) for row in rows]
    return difference(scale(got), scale(expected), slice(1, None))


class Case:
    """A run: way, largest difference from the native library, verdict, and the host's version unless the name has it."""

    def __init__(self, what, value, good, note, version=""):
        self.what, self.value, self.good, self.note, self.version = what, value, good, note, version


def co_simulation(drive, how="FMI 2.0 Co-Simulation"):
    value = difference(drive(STEP, STEPS, ()), native(STEP, STEPS))
    return Case(f"{how}, {STEPS} steps", value, value <= SAME, f"at most {SAME:g}")


def euler(drive, version="2.0"):
    errors = []
    for step in EULER_STEPS:
        steps = round(ME_END / step)
        # Only displacements: the velocity is wrong for a step if an impact comes one step late.
        errors.append(difference(drive(step, steps, ME_START), native(step, steps, ME_START), slice(1, 4)))
    ratio = errors[0] / errors[1]
    good = errors[1] <= EULER and EULER_RATIO[0] <= ratio <= EULER_RATIO[1]
    return Case(f"FMI {version} Model Exchange, Euler, {ME_END / EULER_STEPS[1]:.0f} steps", errors[1], good,
                f"displacements at most {EULER:g}, of first order (half the step leaves 1/{ratio:.2f} of it)")


def libcosimpy():
    return environment("libcosimpy", "libcosimpy==0.0.6")


def run_libcosimpy(fmu, _fmu3):
    python = libcosimpy()
    return [co_simulation(by_script(python, "drive_libcosimpy.py", fmu))]


def ecospy():
    python = environment("ecospy", "ecospy==0.7.2")
    for program in TARGET.glob("ecospy/lib/python*/site-packages/ecospy/binaries/*"):
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    try:
        run([python, "-c", "import ecospy"])
    except RuntimeError as error:
        raise Missing(f"{error}\necos needs TBB (Debian: apt install libtbb12)") from error
    return python


def run_ecospy(fmu, fmu3):
    python = ecospy()
    return [co_simulation(by_script(python, "drive_ecospy.py", fmu)),
            co_simulation(by_script(python, "drive_ecospy.py", fmu3), "FMI 3.0 Co-Simulation")]


def casadi():
    return environment("casadi", "casadi==3.8.2", "numpy==2.4.6")


def run_casadi(_fmu, fmu3):
    python = casadi()
    adjoint, differences = map(float, run([python, HERE / "drive_casadi.py", fmu3]).split()[-2:])
    what = "FMI 3.0 Model Exchange, Jacobian in flight"
    return [Case(f"{what}: adjoint against directional derivatives", adjoint, adjoint == 0.0, "the same numbers"),
            Case(f"{what}: casadi's differences against them", differences, differences <= DIFFERENCES,
                 f"at most {DIFFERENCES:g}")]


def run_container(fmu, fmu3):
    python = environment("fmu-manipulation-toolbox", "fmu-manipulation-toolbox==2.0", "pythonfmu==0.7.0", *requirements())
    output = TARGET / "container.csv"
    printed = run([python, HERE / "drive_container.py", fmu, fmu3, CONTAINER_STEP, CONTAINER_STEPS, output])
    steps, met, impacts = map(int, printed.split()[-3:])
    expected = native(CONTAINER_STEP, CONTAINER_STEPS)
    lines = output.read_text().splitlines()
    cases = []
    for machine, version in (("two", "2.0"), ("three", "3.0")):
        rows = [line.split(",", 1)[1] for line in lines if line.startswith(("machine,", f"{machine},"))]
        value = difference(table("\n".join(rows)), expected)
        cases.append(Case(f"FMI {version} Co-Simulation in a container of both", value, value <= SAME, f"at most {SAME:g}"))
    honoured = steps - CONTAINER_STEPS == met > 0
    cases.append(Case(f"the container's steps: {steps}, of which {met} end at an impact (of {impacts})",
                      abs(steps - CONTAINER_STEPS - met), honoured, "each step beside the grid ends at an announced impact"))
    return cases


def run_fmpy(fmu, fmu3):
    python = environment("fmpy", *requirements())
    return [
        co_simulation(by_script(python, "drive_fmpy.py", fmu, "CoSimulation")),
        cvode(by_script(python, "drive_fmpy.py", fmu, "CVode"), "FMI 2.0 Model Exchange"),
        euler(by_script(python, "drive_fmpy.py", fmu, "Euler")),
        *(co_simulation(by_script(python, "drive_fmpy.py", fmu3, f"CoSimulation{flags}"), f"FMI 3.0 Co-Simulation{name}")
          for name, flags, _ in EVENTS),
        euler(by_script(python, "drive_fmpy.py", fmu3, "Euler"), "3.0"),
    ]


def by_fmi_sim(fmu, way, *flags, names=STATES):
    program = fmi_sim()

    def one(step, steps, start):
        output = TARGET / "fmi-sim.csv"
        output.unlink(missing_ok=True)
        values = [word for item in start for word in ("--init-values", item)]
        run([program, "--model", fmu, "-o", output, way, "--output-interval", repr(step), "-s", "0",
             "-f", repr(step * steps), *values, *flags])
        return table(output.read_text(), names)
    return one


def run_fmi_sim(fmu, fmu3):
    drive = by_fmi_sim
    return [
        co_simulation(drive(fmu, "co-simulation")),
        euler(drive(fmu, "model-exchange")),
        *(co_simulation(drive(fmu3, "co-simulation", *flags), f"FMI 3.0 Co-Simulation{name}") for name, _, flags in EVENTS),
        euler(drive(fmu3, "model-exchange"), "3.0"),
    ]


def program_on_path(name, source):
    program = shutil.which(name)
    if program is None:
        raise NotFound(f"{name} is not on PATH; its public source: {source}")
    return program


def importable(package, source, version):
    """The version of a package that the running Python can import."""
    try:
        return run([sys.executable, "-c", f"import {package}; print({version})"]).split()[-1]
    except RuntimeError as error:
        last = str(error).strip().splitlines()[-1]
        raise NotFound(f"{sys.executable} cannot import {package} ({last}); its public source: {source}") from error


def of_version(version, cases):
    for case in cases:
        case.version = version
    return cases


def cvode(drive, how):
    interval, steps = 0.5, round(ME_END / 0.5)
    value = difference(drive(interval, steps, ME_START), native(interval, steps, ME_START))
    return Case(f"{how}, CVode 1e-10", value, value <= CVODE, f"at most {CVODE:g}")


def run_pyfmi(fmu, fmu3):
    version = importable("pyfmi", "modelon-community/PyFMI, with Assimulo and FMI Library", "pyfmi.__version__")
    recorded = "everything recorded"
    cases = [co_simulation(by_script(sys.executable, "drive_pyfmi.py", fmu, "CoSimulation"),
                           f"FMI 2.0 Co-Simulation, {recorded}")]  # it has none of FMI 3.0
    for number, archive in (("2.0", fmu), ("3.0", fmu3)):
        cases.append(cvode(by_script(sys.executable, "drive_pyfmi.py", archive, "CVode"),
                           f"FMI {number} Model Exchange, {recorded}"))
    return of_version(version, cases)


def run_omsimulator(fmu, fmu3):
    version = importable("OMSimulator", "OpenModelica/OMSimulator", "OMSimulator.Capi.getVersion()")
    return of_version(version, [
        co_simulation(by_script(sys.executable, "drive_omsimulator.py", archive),
                      f"FMI {number} Co-Simulation, everything recorded")
        for number, archive in (("2.0", fmu), ("3.0", fmu3))
    ])


def fmusim():
    return program_on_path("fmusim", "modelica/Reference-FMUs up to 0.0.39, modelica/fmusim since")


# Ways of fmusim.
CS = ("--interface-type", "cs")
ME = ("--interface-type", "me", "--solver", "cvode", "--tolerance", "1e-10")


def by_fmusim(archive, *way, names=STATES):
    program = fmusim()

    def one(step, steps, start):
        output = TARGET / "fmusim.csv"
        output.unlink(missing_ok=True)
        values = [word for item in start for word in ("--start-value", *item.split("="))]
        wanted = [word for name in names for word in ("--output-variable", name)]
        run([program, *way, "--stop-time", repr(step * steps), "--output-interval", repr(step), *values, *wanted,
             "--output-file", output, archive])
        return table(output.read_text(), names)
    return one


def run_fmusim(fmu, fmu3):
    version = run([fmusim(), "--version"]).split()[1]
    cases = []
    for number, archive in (("2.0", fmu), ("3.0", fmu3)):
        cases.append(co_simulation(by_fmusim(archive, *CS), f"FMI {number} Co-Simulation"))
        cases.append(cvode(by_fmusim(archive, *ME), f"FMI {number} Model Exchange"))
    return of_version(version, cases)


def by_fmu_check(fmu, names=STATES):
    """A drive about which FMI Library must not complain."""
    program = program_on_path("fmuCheck", "modelica-tools/FMUComplianceChecker, with modelon-community/fmi-library")

    def one(step, steps, _start):
        log, output = TARGET / "fmuCheck.log", TARGET / "fmuCheck.csv"
        run([program, "-k", "cs", "-h", repr(step), "-s", repr(step * steps), "-n", "0", "-l", "4", "-e", log, "-o", output, fmu])
        complaints = [line for line in log.read_text().splitlines() if line.startswith(("[FATAL]", "[ERROR]", "[WARNING]"))]
        assert not complaints, complaints
        return table(output.read_text(), names)
    return one


def run_fmu_check(fmu, _fmu3):
    program = program_on_path("fmuCheck", "modelica-tools/FMUComplianceChecker, with modelon-community/fmi-library")
    log = TARGET / "fmuCheck.log"
    log.unlink(missing_ok=True)
    output = TARGET / "fmuCheck.csv"
    output.unlink(missing_ok=True)
    broken = ""
    try:
        run([program, "-k", "cs", "-h", repr(STEP), "-s", repr(STEP * STEPS), "-n", "0", "-l", "4", "-e", log, "-o", output, fmu])
    except RuntimeError as error:  # also where FMI Library complains
        broken = str(error)
    complaints = [line for line in log.read_text().splitlines() if line.startswith(("[FATAL]", "[ERROR]", "[WARNING]"))]
    print("\n".join(complaints), end="\n" if complaints else "", file=sys.stderr)
    cases = [Case("FMI 2.0: complaints of FMI Library", len(complaints), not complaints and not broken, "none")]
    if not broken:
        value = difference(table(output.read_text()), native(STEP, STEPS))
        cases.append(Case(f"FMI 2.0 Co-Simulation, {STEPS} steps", value, value <= SAME, f"at most {SAME:g}"))
    return cases


def by_script(python, script, fmu, *way, names=STATES):
    def one(step, steps, start):
        output = TARGET / f"{script}.csv"
        output.unlink(missing_ok=True)
        run([python, HERE / script, fmu, repr(step), steps, output, *way, *start], names=names)
        return table(output.read_text(), names)
    return one


def requirements():
    """Requirements of the tests, except the tools that only tests need."""
    lines = (ROOT / "tests/fmpy/requirements.txt").read_text().splitlines()
    return [line for line in lines if line and not line.startswith(("#", "pytest", "libcosimpy"))]


def assembly_ways(host, fmu, fmu3, names):
    """How a host runs a machine of a file: in words, whether by Model Exchange, and the drive."""
    both = (("2.0", fmu), ("3.0", fmu3))
    cs, me = "Co-Simulation", "Model Exchange"
    if host == "fmpy":
        python = environment("fmpy", *requirements())
        yield f"FMI 2.0 {cs}", False, by_script(python, "drive_fmpy.py", fmu, cs.replace("-", ""), names=names)
        for name, flags, _ in EVENTS:
            yield f"FMI 3.0 {cs}{name}", False, by_script(python, "drive_fmpy.py", fmu3, f"CoSimulation{flags}", names=names)
        for number, archive in both:
            yield f"FMI {number} {me}, CVode 1e-10", True, by_script(python, "drive_fmpy.py", archive, "CVode", names=names)
    elif host == "fmi-sim":
        for number, archive in both:
            yield f"FMI {number} {cs}", False, by_fmi_sim(archive, "co-simulation", names=names)
    elif host == "libcosimpy":
        yield f"FMI 2.0 {cs}", False, by_script(libcosimpy(), "drive_libcosimpy.py", fmu, names=names)
    elif host == "ecospy":
        for number, archive in both:
            yield f"FMI {number} {cs}", False, by_script(ecospy(), "drive_ecospy.py", archive, names=names)
    elif host == "fmusim":
        for number, archive in both:
            yield f"FMI {number} {cs}", False, by_fmusim(archive, *CS, names=names)
            yield f"FMI {number} {me}, CVode 1e-10", True, by_fmusim(archive, *ME, names=names)
    elif host == "fmuCheck":
        yield f"FMI 2.0 {cs}, no complaint of FMI Library", False, by_fmu_check(fmu, names)
    elif host == "PyFMI":
        importable("pyfmi", "modelon-community/PyFMI, with Assimulo and FMI Library", "pyfmi.__version__")
        yield f"FMI 2.0 {cs}", False, by_script(sys.executable, "drive_pyfmi.py", fmu, cs.replace("-", ""), names=names)
        for number, archive in both:
            yield f"FMI {number} {me}, CVode 1e-10", True, by_script(sys.executable, "drive_pyfmi.py", archive, "CVode", names=names)
    elif host == "OMSimulator":
        importable("OMSimulator", "OpenModelica/OMSimulator", "OMSimulator.Capi.getVersion()")
        for number, archive in both:
            yield f"FMI {number} {cs}", False, by_script(sys.executable, "drive_omsimulator.py", archive, names=names)


def casadi_cases(name, file, names, step, steps, archives):
    """A machine of a file from its start to before its first event: states, and accelerations as computed by casadi."""
    names = (*names, *(state.removesuffix(".v") + ".a" for state in names if state.endswith(".v")))
    expected = native_assembly(file, names, step, steps)
    for number, archive in zip(("2.0", "3.0"), archives):
        got = by_script(casadi(), "drive_casadi_machine.py", archive, names=names)(step, steps, map(repr, expected[0][1:]))
        value = relative(got, expected)
        yield Case(f"`{name}`, FMI {number} Model Exchange, CVode 1e-10 to before the first event, {steps} steps", value,
                   value <= ASSEMBLY_CVODE, f"states and accelerations at most {ASSEMBLY_CVODE:g}")


def assembly_archives():
    """The archives of the machines of files, by name."""
    archives = {}
    for name, file, *_ in ASSEMBLIES:
        fmu = TARGET / f"{name}.fmu"
        run(["cargo", "run", "--quiet", "--bin", "fmu-build", "--", "assembly", ROOT / "examples/assembly" / f"{file}.toml",
             "--output", fmu])
        archives[name] = (fmu, fmu.with_name(f"{name}-FMI3.fmu"))
    return archives


def run_assemblies(host, archives):
    """The machines of files in a host; an empty list if it runs none."""
    cases = []
    for name, file, names, step, steps, exchanged, smooth in ASSEMBLIES:
        if host == "casadi":
            cases.extend(casadi_cases(name, file, names, step, smooth, archives[name]))
        for what, exchange, drive in assembly_ways(host, *archives[name], names):
            count, bound = (exchanged, ASSEMBLY_CVODE) if exchange else (steps, ASSEMBLY_SAME)
            value = relative(drive(step, count, ()), native_assembly(file, names, step, count))
            cases.append(Case(f"`{name}`, {what}, {count} steps", value, value <= bound, f"at most {bound:g}"))
    return cases


HOSTS = (
    ("fmpy 0.3.32", run_fmpy),
    ("fmi-sim 0.7.0", run_fmi_sim),
    ("libcosimpy 0.0.6 (libcosim, FMI Library)", run_libcosimpy),
    ("ecospy 0.7.2 (ecos; ignores statuses)", run_ecospy),
    ("casadi 3.8.2", run_casadi),
    ("fmu-manipulation-toolbox 2.0", run_container),
    ("fmusim", run_fmusim),
    ("fmuCheck (FMI Library)", run_fmu_check),
    ("PyFMI", run_pyfmi),
    ("OMSimulator", run_omsimulator),
)


def rows_of(host, run_host):
    """The rows of a host's table, and its failed cases."""
    try:
        cases = run_host()
    except Missing as error:
        print(f"MISSING {host}: cannot be installed here\n{error}", file=sys.stderr)
        return [f"| {host} | could not be installed on the machine that wrote this table | | |"], ["missing"]
    except NotFound as error:
        print(f"NOT FOUND {host}: {error}", file=sys.stderr)
        return [f"| {host} | not found on the machine that wrote this table | | |"], []
    except (RuntimeError, AssertionError) as error:
        cases = [Case("broken off", float("nan"), False, str(error).splitlines()[0])]
        print(error, file=sys.stderr)
    rows, failed = [], []
    for case in cases:
        verdict = "agrees" if case.good else "DIFFERS"
        if not case.good:
            failed.append(f"{host}: {case.what}")
        rows.append(f"| {f'{host} {case.version}'.strip()} | {case.what} | {case.value:.1e} | {verdict}: {case.note} |")
        print(rows[-1], flush=True)
    return rows, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--allow-missing", action="store_true", help="continue without hosts that cannot be installed")
    parser.add_argument("--no-page", action="store_true", help="leave docs/fmu.md as it is")
    parser.add_argument("--only", action="append", help="run only this host, by the first word of its name; the page keeps the others' rows")
    parser.add_argument("--assemblies", action="store_true", help="run only the machines of files")
    arguments = parser.parse_args()
    TARGET.mkdir(parents=True, exist_ok=True)
    fmu = TARGET / "VibroImpact3DOF.fmu"
    if not arguments.assemblies:
        run(["cargo", "run", "--quiet", "--bin", "fmu-build", "--", "--portable", "--no-run", "--out", fmu])
    archives = assembly_archives()
    missing, failed = [], []
    for name, host in HOSTS:
        word = name.split()[0]
        if arguments.only and word not in arguments.only:
            continue
        tables = [("assemblies", lambda: run_assemblies(word, archives))]
        if not arguments.assemblies:
            tables.insert(0, ("hosts", lambda: host(fmu, fmu.with_name("VibroImpact3DOF-FMI3.fmu"))))
        for place, run_host in tables:
            rows, differ = rows_of(name, run_host)
            (missing if differ == ["missing"] else failed).extend([name] if differ == ["missing"] else differ)
            if not arguments.no_page:
                write(place, name, rows)
    for what, names in (("missing", missing), ("failed", failed)):
        if names:
            print(f"{what}: {', '.join(names)}", file=sys.stderr)
    return 1 if failed or (missing and not arguments.allow_missing) else 0


def write(place, host, rows):
    """Puts a host's rows into a table of docs/fmu.md, which keeps the rows of other hosts."""
    page = ROOT / "docs" / "fmu.md"
    text = page.read_text()
    found = re.search(rf"<!-- {place} -->\n(.*?)<!-- /{place} -->", text, flags=re.DOTALL)
    assert found, f"docs/fmu.md has no place for the table {place}"
    head, old = found[1].splitlines()[:2], found[1].splitlines()[2:]
    new = []
    for name, _ in HOSTS:
        new += rows if name == host else [row for row in old if row.startswith(f"| {name} ")]
    table = "".join(f"{row}\n" for row in [*head, *new])
    page.write_text(text[:found.start(1)] + table + text[found.end(1):])


if __name__ == "__main__":
    sys.exit(main())
