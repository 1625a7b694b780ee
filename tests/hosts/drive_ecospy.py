"""Runs the FMU in ecos: drive_ecospy.py FMU STEP STEPS OUTPUT; writes a CSV of the states.

A smoke test only: ecos ignores the statuses an FMU returns.
"""

import sys

from ecospy import EcosSimulation, EcosSimulationStructure

NAMES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")

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
