"""Speed of the Python package, as ratios within one run: against the Rust library, its own fixed costs, SciPy's DOP853 with events,
fmpy.

`pip install ./python scipy fmpy`, then `python benches/python_package.py`. The work: the default machine over 1000 forces from 0.5 to 4,
400 drive periods each, from the moving block; DOP853 and fmpy do a part of it, since they take longer. The Rust library does the same
work in a separate program (`crates/studies/examples/many_motions.rs`, compiled first), alternating with the package. The times are the
smallest of several rounds. `python benches/python_package.py assemblies` does the same for described machines: the gallery's impact
damper with a rubber buffer over 1000 gaps, 200 periods each (`crates/studies/examples/many_assemblies.rs`), and a bifurcation diagram of
200 values.
"""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import vibro_impact as vi

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "fmpy"))

PERIODS = 400
ROUNDS = 7
TURNS = 41


def least(work, rounds=ROUNDS):
    """The smallest time of several rounds, s."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def beside_rust(example, work):
    """Smallest times of the package and of the Rust library, s, in alternation; and the median of their ratios of processor time over all
    threads, which other work on the machine hardly affects."""
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "vibro-studies", "--example", example], cwd=ROOT, check=True)
    program = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / example
    with subprocess.Popen([program, "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1) as rust:

        def by_rust():
            begin = processor_time(rust.pid)
            rust.stdin.write("\n")
            return float(rust.stdout.readline()), processor_time(rust.pid) - begin

        def by_package():
            begin = processor_time(os.getpid())
            return least(work, 1), processor_time(os.getpid()) - begin

        by_rust(), by_package()  # threads and tables that are created once
        # The order alternates, so that neither is always the first.
        turns = [(by_package(), by_rust()) if i % 2 else (by_rust(), by_package())[::-1] for i in range(TURNS)]
        rust.stdin.close()
    times, processor = np.array(turns).transpose(2, 1, 0)
    return times.min(axis=1), np.median(processor[0] / processor[1])


def processor_time(process):
    """Processor time of all threads of a process, s, if available (Linux: clock_getcpuclockid); otherwise the wall time."""
    try:
        return time.clock_gettime((~process << 3) | 2)
    except (AttributeError, OSError):
        return time.perf_counter()


def assemblies():
    """The table for described machines."""
    damper = vi.Machine(ROOT / "examples" / "assembly" / "damper_with_buffer.toml")
    machines = [damper.replace({"stop.steel.gap": gap}) for gap in np.linspace(5e-3, 130e-3, 1000)]
    (package, library), ratio = beside_rust("many_assemblies", lambda: vi.simulate_many(machines, until=20.0))
    gaps = np.linspace(5e-3, 130e-3, 200)
    diagram = least(lambda: damper.bifurcation("box.s", **{"stop.steel.gap": gaps}), 3)
    print(f"{os.cpu_count()} cores; vibro_impact {vi.__version__}, numpy {np.__version__}")
    print("| way | s |\n|---|---|")
    rows = {
        "Rust, 1000 machines x 200 periods, all cores": library,
        "`simulate_many`, 1000 machines x 200 periods, all cores": package,
        "`bifurcation`, 200 values in both directions, all cores": diagram,
    }
    for way, seconds in rows.items():
        print(f"| {way} | {seconds:.3g} |")
    print(f"`simulate_many` against Rust in {TURNS} turns, median of their ratios of processor time: {ratio:.3f}")


def main():
    import fmpy
    import oracle

    machines = [vi.PaperMachine.from_groups(f10=f10) for f10 in np.linspace(0.5, 4.0, 1000)]
    (package, library), ratio = beside_rust("many_motions", lambda: vi.simulate_many(machines, periods=PERIODS))
    many, by_rust = package / (1000 * PERIODS), library / (1000 * PERIODS)
    # A call with zero periods: checks, conversions, threads and the machines' tables, which any
    # caller of the core needs too.
    fixed = least(lambda: vi.simulate_many(machines, periods=0)) / (1000 * PERIODS)
    machine = machines[285]
    one = least(lambda: machine.simulate(periods=PERIODS, per_period=1)) / PERIODS

    names = {name.replace("_", ".", 1): getattr(machine, name) for name in vi.SI_NAMES}
    times = machine.period * np.arange(401) / 40  # the oracle reports between impacts
    dop853 = least(lambda: oracle.simulate(names, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], times), 2) / 10

    folder = fmpy.extract(str(vi.fmu_path()))
    description = fmpy.read_model_description(folder)

    def step_by_step():
        fmpy.simulate_fmu(
            folder,
            model_description=description,
            fmi_type="CoSimulation",
            stop_time=PERIODS * machine.period,
            output_interval=machine.period,
            start_values={**names, "block.v": 1.0},
            output=["block.s"],
        )

    by_fmpy = least(step_by_step) / PERIODS
    shutil.rmtree(folder)

    print(f"{os.cpu_count()} cores; vibro_impact {vi.__version__}, numpy {np.__version__}")
    print("| way | us per drive period | times `simulate_many` |\n|---|---|---|")
    rows = {
        f"Rust, `propagate`, 1000 machines x {PERIODS} periods, all cores": by_rust,
        f"`simulate_many`, 1000 machines x {PERIODS} periods, all cores": many,
        "of which over no time (checks, tables of each machine)": fixed,
        "`simulate`, one machine, energy accounts, a state a period": one,
        "FMU in fmpy, one machine, one step a period": by_fmpy,
        "SciPy, DOP853 at 1e-12 with events, one machine": dop853,
    }
    for way, seconds in rows.items():
        print(f"| {way} | {1e6 * seconds:.4g} | {seconds / many:.4g} |")
    print(f"`simulate_many` against `propagate` in {TURNS} turns, median of their ratios of processor time: {ratio:.3f}")


if __name__ == "__main__":
    assemblies() if sys.argv[1:] == ["assemblies"] else main()
