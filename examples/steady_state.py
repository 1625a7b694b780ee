"""The steady state in three ways: simulated until it has settled, and by the FMU's two closed forms.

    python examples/steady_state.py --out steady.png
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from vibro import COLOURS, FMU, Slave, start_values

#: Items of the FMU's parameter `mode`, each with the number of drive periods until it settles.
MODES = {"EventDriven": (1, 400), "MultipleScales": (2, 0), "ExactOrbit": (3, 0)}
STYLES = {"EventDriven": "-", "MultipleScales": ":", "ExactOrbit": "--"}
SAMPLES = 400  # in a period


def main() -> None:
    """Prints the FMU's closed forms of the steady state, and draws a period of each mode."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--out", "--output", dest="output", default=Path("steady.png"), type=Path)
    arguments = parser.parse_args()
    period = 2.0 * math.pi / start_values(arguments.fmu)["drive.frequency"]
    orbits = {}
    for name, (number, settle) in MODES.items():
        with Slave(arguments.fmu, {"mode": number, "block.v": 0.3} if settle else {"mode": number}) as slave:
            if settle:
                slave.step(0.0, settle * period)
            rows = []
            for i in range(SAMPLES + 1):
                rows.append([value for body in COLOURS for value in slave.reals([f"{body}.s", f"{body}.v"])])
                slave.step((settle + i / SAMPLES) * period, period / SAMPLES)
            orbits[name] = np.array(rows)
            if number == 1:
                for output in ("steady.stable", "steady.A1", "steady.A2", "steady.A3", "steady.spectralRadius"):
                    print(f"{output:22} {slave.get(output):.6g}")
        amplitudes = np.ptp(orbits[name][:, ::2], axis=0) / 2.0
        print(f"{name:15} amplitudes (m) " + " ".join(f"{a:.5f}" for a in amplitudes))

    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 3, figsize=(12, 4.2), layout="constrained")
    for index, (panel, (body, colour)) in enumerate(zip(axes, COLOURS.items())):
        for name, orbit in orbits.items():
            shade = "black" if name == "ExactOrbit" else colour
            panel.plot(orbit[:, 2 * index], orbit[:, 2 * index + 1], STYLES[name], color=shade, label=name)
        panel.set(title=body, xlabel="displacement (m)", ylabel="velocity (m/s)")
    axes[1].legend(loc="center", fontsize="small")
    figure.savefig(arguments.output, dpi=150)
    print(arguments.output)


if __name__ == "__main__":
    main()
