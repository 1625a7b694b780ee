"""A run with fmpy and its picture, with parameters in dimensionless form and arbitrary scales.

    python examples/run_and_plot.py --set f10=1.8 --mass 2 --stiffness 200 --length 0.01 --out run.png
"""

from __future__ import annotations

import argparse
import math
from dataclasses import fields, replace
from pathlib import Path

from vibro import FMU, Groups, Scales, plot, simulate


def main() -> None:
    """Simulates, prints the amplitudes over the last periods, and draws the run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    names = ", ".join(field.name for field in fields(Groups))
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=f"a group: {names}")
    parser.add_argument("--mass", default=1.0, type=float, help="m1, kg")
    parser.add_argument("--stiffness", default=1.0, type=float, help="k1, N/m")
    parser.add_argument("--length", default=1.0, type=float, help="gap L, m")
    parser.add_argument("--periods", default=100, type=int)
    parser.add_argument("--out", "--output", dest="output", default=Path("run.png"), type=Path)
    arguments = parser.parse_args()

    changes = dict(text.partition("=")[::2] for text in arguments.set)
    unknown = set(changes) - {field.name for field in fields(Groups)}
    if unknown:
        parser.error(f"--set {unknown.pop()}: expected one of {names}")
    groups = replace(Groups(), **{name: float(value) for name, value in changes.items()})
    parameters = groups.parameters(Scales(arguments.mass, arguments.stiffness, arguments.length))
    result = simulate(arguments.fmu, {**parameters, "block.v": 0.1 * arguments.length}, arguments.periods)

    period = 2.0 * math.pi / parameters["drive.frequency"]
    print(groups)
    print(f"period {period:.6g} s, impacts {result['impacts.upper'][-1] + result['impacts.lower'][-1]}")
    tail = result[result["time"] > 0.8 * result["time"][-1]]
    for body in ("box", "block", "secondary"):
        values = tail[f"{body}.s"]
        print(f"amplitude of {body:9} {(values.max() - values.min()) / 2.0:.6g} m")
    shown = result[result["time"] > result["time"][-1] - 4.0 * period]
    plot(shown, period, arguments.output)
    print(arguments.output)


if __name__ == "__main__":
    main()
