"""Runs the FMU in fmpy: drive_fmpy.py FMU STEP STEPS OUTPUT WAY [NAME=VALUE ...]; writes a CSV of the variables in
the environment's NAMES.

WAY is CoSimulation, CVode or Euler; for Euler, STEP is also the solver's step. With FMI 3.0, CoSimulation may be followed by
+event (Event Mode) and +early (early return).
"""

import os
import sys

import fmpy

NAMES = tuple(os.environ["NAMES"].split(","))

fmu, step, steps, output, way, *starts = sys.argv[1:]
interval = float(step)
way, *flags = way.split("+")
options = {"fmi_type": "CoSimulation", "use_event_mode": "event" in flags, "early_return_allowed": "early" in flags}
if way != "CoSimulation":
    options = {"fmi_type": "ModelExchange", "solver": way, "relative_tolerance": 1e-10}
if way == "Euler":
    options["step_size"] = interval
result = fmpy.simulate_fmu(
    fmu,
    stop_time=interval * int(steps),
    output_interval=interval,
    output=list(NAMES),
    start_values={name: float(value) for name, value in (start.split("=") for start in starts)},
    **options,
)
with open(output, "w") as file:
    print("time", *NAMES, sep=",", file=file)
    for row in result:
        print(row["time"], *(row[name] for name in NAMES), sep=",", file=file)
