"""A machine of a file in casadi: drive_casadi_machine.py FMU STEP STEPS OUTPUT START…; states and accelerations as a table.

casadi computes derivatives from states that it sets one by one, and passes them to CVode. It handles no events and passes no start states,
so that the starts are given as arguments and the run ends before the first event.
"""

import csv
import os
import sys
import tempfile
import zipfile

import casadi

RELATIVE, ABSOLUTE = 1e-10, 1e-14  # the absolute tolerance is relevant for displacements of a micrometre
fmu, step, steps, output, *starts = sys.argv[1:]
states = [name for name in os.environ["NAMES"].split(",") if not name.endswith(".a")]
values = dict(zip(states, map(float, starts)))
grid = [float(step) * k for k in range(int(steps) + 1)]

with tempfile.TemporaryDirectory() as folder:
    zipfile.ZipFile(fmu).extractall(folder)
    builder = casadi.DaeBuilder("machine", folder)
    order = builder.x()
    time, x = casadi.MX.sym("t"), casadi.MX.sym("x", len(order))
    rates = builder.create("rates", ["t", "x"], ["ode"])
    options = {"abstol": ABSOLUTE, "reltol": RELATIVE}
    solver = casadi.integrator("solver", "cvodes", {"t": time, "x": x, "ode": rates(time, x)}, grid[0], grid[1:], options)
    begin = [values[name] for name in order]
    columns = [begin, *solver(x0=begin)["xf"].full().T.tolist()]
    accelerations = [name.removesuffix(".v") + ".a" for name in order if name.endswith(".v")]
    with open(output, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time", *order, *accelerations])
        for at, now in zip(grid, columns):
            found = rates(at, now).full().ravel().tolist()
            table.writerow([at, *now, *(rate for name, rate in zip(order, found) if name.endswith(".v"))])
