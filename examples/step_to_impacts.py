"""A master that steps from impact to impact: with `stopAtImpact` a step ends, discarded, at the first impact in it.

FMI 2.0 (4.2.4) does not allow a step after a discarded one. So the master saves the state before each step. If the step is
discarded, the master restores that state and steps again, to the time that the FMU reached (fmi2LastSuccessfulTime). The FMU is
then just after the impact, and the master can pass the impact on to other models.

    python examples/step_to_impacts.py --periods 10
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Iterator, Mapping, NamedTuple

from vibro import FMU, PathLike, Slave, Value, start_values


class Impact(NamedTuple):
    """An impact as the FMU reports it just after the impact."""

    time: float  # s
    stop: str  # upper or lower
    speed: float  # relative speed of approach, m/s
    impulse: float  # N.s


def impacts(fmu: PathLike, start: Mapping[str, Value], stop: float, step: float) -> Iterator[Impact]:
    """Yields every impact up to a time, with communication steps of given size (both in s) that are cut at the impacts."""
    with Slave(fmu, {**start, "stopAtImpact": True}) as slave:
        time, upper = 0.0, 0.0
        while time < stop:
            size = min(step, stop - time)
            state = slave.save()
            reached = slave.step(time, size)
            if reached < time + size:
                slave.restore(state)
                slave.step(time, reached - time)
                count = slave.get("impacts.upper")
                side = "upper" if count > upper else "lower"
                upper = count
                yield Impact(reached, side, slave.get("impacts.lastSpeed"), slave.get("impacts.lastImpulse"))
            slave.free(state)
            time = reached


def main() -> None:
    """Prints a list of impacts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--periods", default=10.0, type=float)
    arguments = parser.parse_args()
    period = 2.0 * math.pi / start_values(arguments.fmu)["drive.frequency"]
    print("time (s)             stop   speed (m/s)  impulse (N.s)")
    start = {"block.s": 0.9, "block.v": 0.5}
    for impact in impacts(arguments.fmu, start, arguments.periods * period, period / 10.0):
        print(f"{impact.time:<20.15g} {impact.stop}  {impact.speed:<11.6f}  {impact.impulse:.6f}")


if __name__ == "__main__":
    main()
