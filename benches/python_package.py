"""How fast the Python package is, as ratios within one run: against its own fixed costs, SciPy's DOP853 with events, fmpy.

`pip install ./python scipy fmpy`, then `python benches/python_package.py`. The work: the default machine over 1000 forces from 0.5 to 4,
400 drive periods each, from the moving block on; the other ways do a part of it, since they take longer. Least times of some rounds.
"""

import os
import shutil
import sys
import time
from pathlib import Path

import numpy as np
import vibro_impact as vi

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fmpy"))

PERIODS = 400
ROUNDS = 7


def least(work, rounds=ROUNDS):
    """The least time of some rounds, s."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def main():
    import fmpy
    import oracle

    machines = [vi.Machine.from_groups(f10=f10) for f10 in np.linspace(0.5, 4.0, 1000)]
    many = least(lambda: vi.simulate_many(machines, periods=PERIODS)) / (1000 * PERIODS)
    # The same call over no time: checks, conversions, threads and the machines' tables, which any caller of the core needs too.
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
        f"`simulate_many`, 1000 machines x {PERIODS} periods, all cores": many,
        "of which over no time (checks, tables of each machine)": fixed,
        "`simulate`, one machine, energy accounts, a state a period": one,
        "FMU in fmpy, one machine, one step a period": by_fmpy,
        "SciPy, DOP853 at 1e-12 with events, one machine": dop853,
    }
    for way, seconds in rows.items():
        print(f"| {way} | {1e6 * seconds:.4g} | {seconds / many:.4g} |")


if __name__ == "__main__":
    main()
