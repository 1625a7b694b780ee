"""The FMU started on an unstable periodic orbit: how long it stays there, compared with the prediction of the orbit's largest multiplier.

No simulation finds an unstable orbit, but the orbit exists: a motion that starts on it to the last digit stays on it until rounding, about
1e-16 of the gap, has grown visibly. Each passage multiplies the deviation by the largest multiplier. `vibro orbit`
writes the start values and the multipliers to the folder that this script reads:

    cargo run --release -p vibro -- paper orbit --word U- --set f10=2.3 --out orbit
    python examples/unstable_orbit.py --orbit orbit --out unstable_orbit.png
"""

from __future__ import annotations

import argparse
import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from vibro import COLOURS, FMU, STATES, PathLike, simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROUNDING = 1e-16  # of a state of the size of the gap
LEFT = 1e-3  # a deviation, in gaps, that counts as having left the orbit
MEASURED = (1e-12, 1e-4)  # deviations in this range exceed rounding and still grow in proportion
PER_PERIOD = 200  # reported points in a drive period


class Orbit(NamedTuple):
    """An orbit as `vibro orbit` writes it."""

    start: dict[str, float]  # start values of the FMU, SI
    multiplier: float  # the largest modulus of its multipliers
    passage: float  # drive periods that the multipliers span: half the period for a symmetric orbit
    period: int  # drive periods

    @property
    def rate(self) -> float:
        """Growth of a deviation per drive period, as the logarithm of its factor."""
        return math.log(self.multiplier) / self.passage


def read(folder: PathLike) -> Orbit:
    """Reads the orbit from a folder written by `vibro orbit`."""
    with open(Path(folder) / "orbit-start.csv", newline="") as file:
        start = {row["variable"]: float(row["start"]) for row in csv.DictReader(file)}
    with open(Path(folder) / "orbit-multipliers.csv", newline="") as file:
        largest = next(csv.DictReader(file))
    passage = float(largest["drive_periods"])
    return Orbit(start, float(largest["modulus"]), passage, round(passage if passage.is_integer() else 2.0 * passage))


def deviations(orbit: Orbit, result: Any) -> NDArray[np.float64]:
    """Returns the largest deviation of a coordinate from the orbit after each of its periods, in units of L and L ω1."""
    length = orbit.start["stop.gap"]
    units = np.array([length] * 3 + [length * orbit.start["drive.frequency"]] * 3)
    states = np.column_stack([result[name] for name in STATES])[:: PER_PERIOD * orbit.period] / units
    return np.asarray(np.abs(states - np.array([orbit.start[name] for name in STATES]) / units).max(axis=1))


def measured_rate(orbit: Orbit, deviation: NDArray[np.float64]) -> float:
    """Returns the measured growth per drive period; NaN if the deviation grows too fast to be measured."""
    before = np.flatnonzero(deviation > MEASURED[1])
    grown = np.flatnonzero(deviation[: before[0] if before.size else None] > MEASURED[0])
    if grown.size < 2:
        return math.nan
    return float(np.polyfit(grown * orbit.period, np.log(deviation[grown]), 1)[0])


def plot(orbit: Orbit, result: Any, deviation: NDArray[np.float64], path: PathLike) -> None:
    """Draws the deviation over time, and the orbit next to the motion on which the run settles."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (growth, portrait) = pyplot.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    periods = np.arange(deviation.size) * orbit.period
    growth.semilogy(periods[1:], deviation[1:], "o", markersize=3, color=COLOURS["block"], label="FMU")
    # Through the first measured deviation.
    seen = int(np.argmax(deviation > MEASURED[0]))
    predicted = np.exp(np.log(deviation[seen]) + orbit.rate * (periods - periods[seen]))
    shown = (predicted > ROUNDING) & (predicted < 10.0)
    growth.semilogy(periods[shown], predicted[shown], color="black", label=f"|µ| = {orbit.multiplier:.4g} in {orbit.passage:g} T")
    growth.set(xlabel="drive periods", ylabel="deviation from the orbit (L, Lω₁)")
    growth.legend(frameon=False)
    length = orbit.start["stop.gap"]
    w, rate = result["stop.s"] / length, result["stop.v"] / (length * orbit.start["drive.frequency"])
    first = orbit.period * PER_PERIOD
    portrait.plot(w[-20 * PER_PERIOD :], rate[-20 * PER_PERIOD :], ".", markersize=1, color=COLOURS["block"], label="at the end")
    portrait.plot(w[:first], rate[:first], ".", markersize=2, color="black", label="orbit")
    portrait.set(xlabel="block in the box w (L)", ylabel="dw/dt (Lω₁)")
    portrait.legend(frameon=False, markerscale=6)
    figure.savefig(str(path), dpi=150)
    pyplot.close(figure)


def main() -> None:
    """Prints how long the FMU stays on the orbit and how fast it leaves the orbit, and draws both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--orbit", default=Path("vibro-out"), type=Path, help="folder written by `vibro orbit`")
    parser.add_argument("--out", "--output", dest="output", default=Path("unstable_orbit.png"), type=Path)
    arguments = parser.parse_args()
    if not (arguments.orbit / "orbit-start.csv").exists():
        parser.error(f"{arguments.orbit} has no orbit-start.csv: write it with `vibro paper orbit --out {arguments.orbit}`")
    orbit = read(arguments.orbit)
    if orbit.multiplier <= 1.0:
        parser.error(f"the orbit in {arguments.orbit} is stable (largest multiplier {orbit.multiplier:.6g}): no motion leaves it")
    expected = math.log(LEFT / ROUNDING) / orbit.rate
    periods = orbit.period * math.ceil((1.5 * expected + 60.0) / orbit.period)
    result = simulate(arguments.fmu, orbit.start, periods, PER_PERIOD)
    deviation = deviations(orbit, result)
    left = np.flatnonzero(deviation > LEFT)
    stays = f"{left[0] * orbit.period}" if left.size else f"more than {periods}"
    print(f"largest multiplier          {orbit.multiplier:.9g} in {orbit.passage:g} T")
    print(f"growth per period predicted {math.exp(orbit.rate):.6f}")
    print(f"growth per period measured  {math.exp(measured_rate(orbit, deviation)):.6f}")
    print(f"stays within {LEFT:g} L        {stays} drive periods")
    print(f"expected from rounding      {expected:.0f} drive periods")
    plot(orbit, result, deviation, arguments.output)
    print(arguments.output)


if __name__ == "__main__":
    main()
