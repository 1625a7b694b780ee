"""Jacobians of the FMI 3.0 FMU by casadi: drive_casadi.py FMU; prints the errors of adjoint derivatives and differences.

casadi builds a Jacobian from directional derivatives, from adjoint derivatives, or by differences. All three refer to the same state
derivatives and outputs, in flight: casadi passes no start states, and handles no events.
"""

import sys
import tempfile
import zipfile

import casadi
import numpy as np

# The state derivatives, and outputs that are not state derivatives: casadi accepts no variable
# twice, and only Float64.
OUTPUTS = ["stop.s", "stop.v", "stop.force", "coupling.f", "energy.mechanical"]
WAYS = {
    "directional": {"uses_adjoint_derivatives": False},
    "adjoint": {"enable_forward_jacobian": False, "enable_adjoint_jacobian": True},
    "differences": {"uses_directional_derivatives": False, "uses_adjoint_derivatives": False},
}
STATES = {"box.s": 0.1, "block.s": 0.3, "secondary.s": 0.2, "box.v": 0.4, "block.v": -0.2, "secondary.v": 0.5}
LOADS = [0.1, 0.05, 0.02]

with tempfile.TemporaryDirectory() as folder:
    zipfile.ZipFile(sys.argv[1]).extractall(folder)
    builder = casadi.DaeBuilder("vibro", folder)
    builder.set_y(OUTPUTS)
    off = {"adjoint": 0.0, "differences": 0.0}
    for part, rows in (("ode", len(STATES)), ("y", len(OUTPUTS))):
        found = {}
        for way, options in WAYS.items():
            function = builder.create("jacobian", ["x", "u"], [f"jac_{part}_x", f"jac_{part}_u"], options)
            blocks = function([STATES[name] for name in builder.x()], LOADS)
            found[way] = np.hstack([block.full() for block in blocks])
        assert found["directional"].shape == (rows, len(STATES) + len(LOADS)) and np.any(found["directional"])
        for way in off:
            off[way] = max(off[way], float(np.abs(found[way] - found["directional"]).max()))
print(off["adjoint"], off["differences"])
