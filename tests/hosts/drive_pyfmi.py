"""Runs the FMU in PyFMI: drive_pyfmi.py FMU STEP STEPS OUTPUT WAY [NAME=VALUE ...]; writes a CSV of the variables in
the environment's NAMES.

WAY is CoSimulation, or CVode for Model Exchange. Everything is recorded, as PyFMI does by default: a variable that it
cannot record ends the run.
"""

import os
import sys
import tempfile
from pathlib import Path

from pyfmi import load_fmu

NAMES = tuple(os.environ["NAMES"].split(","))

fmu, step, steps, output, way, *starts = sys.argv[1:]
output = Path(output).resolve()
with tempfile.TemporaryDirectory() as folder:
    model = load_fmu(fmu, kind="CS" if way == "CoSimulation" else "ME", log_file_name=f"{folder}/log.txt")
    for start in starts:
        name, value = start.split("=")
        model.set(name, float(value))
    options = model.simulate_options()
    options["ncp"] = int(steps)
    options["result_file_name"] = f"{folder}/result.mat"
    if way == "CVode":
        options["solver"] = "CVode"
        options["CVode_options"]["rtol"] = 1e-10
        options["CVode_options"]["atol"] = 1e-10 * model.nominal_continuous_states
        options["CVode_options"]["verbosity"] = 50
    result = model.simulate(final_time=float(step) * int(steps), options=options)
    with open(output, "w") as file:
        print("time", *NAMES, sep=",", file=file)
        # Two rows at one time are the two sides of an event; the later row counts, as in the other
        # hosts.
        for row in zip(result["time"], *(result[name] for name in NAMES)):
            print(*(repr(float(value)) for value in row), sep=",", file=file)
