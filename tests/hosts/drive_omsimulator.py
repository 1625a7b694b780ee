"""Runs the FMU in OMSimulator: drive_omsimulator.py FMU STEP STEPS OUTPUT [NAME=VALUE ...]; writes a CSV of the variables in
the environment's NAMES.

Every variable is recorded, including locals, as OMSimulator does by default: it reads each as a scalar.
"""

import csv
import os
import sys
import tempfile
from pathlib import Path

from OMSimulator import SSP, CRef, Settings

NAMES = tuple(os.environ["NAMES"].split(","))

fmu, step, steps, output, *starts = sys.argv[1:]
fmu, output = Path(fmu).resolve(), Path(output).resolve()
Settings.suppressPath = True
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    model = SSP()
    model.addResource(str(fmu), new_name="resources/machine.fmu")
    model.addComponent(CRef("default", "machine"), "resources/machine.fmu")
    running = model.instantiate()
    running.setResultFile("result.csv")
    running.setStopTime(float(step) * int(steps))
    running.setFixedStepSize(float(step))
    for start in starts:
        name, value = start.split("=")
        running.setValue(CRef("default", "machine", name), float(value))
    running.initialize()
    running.simulate()
    running.terminate()
    running.delete()
    with open("result.csv", newline="") as recorded, open(output, "w") as file:
        print("time", *NAMES, sep=",", file=file)
        for row in csv.DictReader(recorded):
            columns = {name.rsplit("machine.", 1)[-1].strip('"'): value for name, value in row.items()}
            print(columns["time"], *(columns[name] for name in NAMES), sep=",", file=file)
    os.chdir(output.parent)
