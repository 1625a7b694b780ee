"""Runs the FMU in ecos: drive_ecospy.py FMU STEP STEPS OUTPUT; writes a CSV of the variables in
the environment's NAMES.

A smoke test only: ecos ignores the statuses an FMU returns.
"""

import os
import sys

from ecospy import EcosSimulation, EcosSimulationStructure

NAMES = tuple(os.environ["NAMES"].split(","))

fmu, step, steps, output = sys.argv[1:]
structure = EcosSimulationStructure()
structure.add_model("box", fmu)
simulation = EcosSimulation(structure=structure, step_size=float(step))
simulation.init()
with open(output, "w") as file:
    print("time", *NAMES, sep=",", file=file)
    for _ in range(int(steps)):
        simulation.step()
        print(simulation.get_time(), *(simulation.get_real(f"box::{n}") for n in NAMES), sep=",", file=file)
simulation.terminate()
