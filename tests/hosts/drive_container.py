"""A container of both FMUs by fmu-manipulation-toolbox, run by fmpy: drive_container.py FMU2 FMU3 STEP STEPS OUTPUT.

The container steps the FMI 3.0 FMU, the FMI 2.0 FMU and a watch (an FMU by pythonfmu) in parallel. It enters Event Mode
after a step that reports an event, and shortens the next step to the announced event. The watch counts the steps, and the
impacts at which a step ended. Writes the states of both machines as CSV, one below the other, and prints the number of steps,
of impacts at which a step ended, and of impacts.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import fmpy
from fmu_manipulation_toolbox.container import FMUContainer
from pythonfmu.builder import FmuBuilder

STATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")
COUNTS = ("impacts.upper", "impacts.lower")

fmu2, fmu3, step, steps, output = sys.argv[1:]
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    FmuBuilder.build_FMU(Path(__file__).with_name("watch.py"), dest=folder)
    machines = {"two": fmu2, "three": fmu3}
    container = FMUContainer("container", folder, fmi_version=2)
    for machine, path in machines.items():
        shutil.copy(path, folder / f"{machine}.fmu")
        container.get_fmu(f"{machine}.fmu")
        for state in (*STATES, *COUNTS):
            container.add_output(f"{machine}.fmu", state, f"{machine}.{state}")
    container.get_fmu("Watch.fmu")
    container.add_link("three.fmu", "impacts.lastTime", "Watch.fmu", "impact")
    for count in ("steps", "met"):
        container.add_output("Watch.fmu", count, count)
    container.make_fmu(folder / "container.fmu", step_size=float(step))
    result = fmpy.simulate_fmu(
        str(folder / "container.fmu"),
        stop_time=float(step) * int(steps),
        output_interval=float(step),
        step_size=float(step),
    )
with open(output, "w") as file:
    print("machine", "time", *STATES, sep=",", file=file)
    for machine in machines:
        for row in result:
            print(machine, row["time"], *(row[f"{machine}.{state}"] for state in STATES), sep=",", file=file)
end = result[-1]
print(int(end["steps"]), int(end["met"]), int(sum(end[f"three.{count}"] for count in COUNTS)))
