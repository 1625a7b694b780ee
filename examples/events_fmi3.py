"""A master that follows every event of the FMI 3.0 FMU, and checks the laws of impact on both sides of it.

The master uses Event Mode and accepts early returns. A step then ends before the first event in it: in Step Mode the variables
show the limit before the event, in Event Mode the limit after it. `fmi3UpdateDiscreteStates` carries out the event and returns
the time of the next event, which holds if the loads stay unchanged.

    python examples/events_fmi3.py --periods 10
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, Mapping

from vibro import FMU3, EventSlave, PathLike, Value, start_values

#: Rounding of the law of impact between both limits of an event, relative to the velocities.
ROUNDING = 1e-12

COUNTS = ("impacts.upper", "impacts.lower")
FLIGHT = 1.0  # of stop.state


@dataclass(frozen=True)
class Limit:
    """State on one side of an event."""

    box: float  # velocity, m/s
    block: float  # velocity, m/s
    counts: tuple[float, ...]
    state: float  # stop.state

    @classmethod
    def of(cls, slave: EventSlave) -> Limit:
        """Returns the current state of an instance."""
        box, block = slave.reals(["box.v", "block.v"])
        return cls(float(box), float(block), tuple(slave.get(name) for name in COUNTS), slave.get("stop.state"))

    @property
    def relative(self) -> float:
        """Velocity of the block relative to the box, m/s."""
        return self.block - self.box


@dataclass(frozen=True)
class Event:
    """An event with both of its limits."""

    time: float  # s
    before: Limit
    after: Limit
    next_event: float  # announced time of the next event, s
    announced: bool  # whether this event had been announced, for this time

    @property
    def kind(self) -> str:
        """Kind of the event."""
        for side, before, after in zip(("upper", "lower"), self.before.counts, self.after.counts):
            if after > before:
                return f"impact, {side} stop" + (", then rest" if self.after.state != FLIGHT else "")
        return "release" if self.after.state == FLIGHT else "rest"

    def errors(self, p: Mapping[str, float]) -> tuple[float, float]:
        """Residuals of Newton's restitution law and of the momentum balance, relative to the velocities at the event."""
        kappa = p["stop.restitution"] if self.kind.startswith("impact") and self.after.state == FLIGHT else 0.0
        if self.kind == "release":
            kappa = -1.0  # nothing jumps
        speed = max(abs(self.before.box), abs(self.before.block), abs(self.before.relative)) or 1.0
        restitution = abs(self.after.relative + kappa * self.before.relative)
        momentum = [p["box.m"] * limit.box + p["block.m"] * limit.block for limit in (self.before, self.after)]
        return restitution / speed, abs(momentum[1] - momentum[0]) / (p["box.m"] + p["block.m"]) / speed


def events(fmu: PathLike, start: Mapping[str, Value], stop: float, step: float) -> Iterator[Event]:
    """Yields every event up to a time, with communication steps of given size (both in s) that end early at the events."""
    with EventSlave(fmu, {"stopAtImpact": True, **start}) as slave:
        coming = slave.update_discrete_states()
        slave.enter_step_mode()
        time = 0.0
        while time < stop:
            time, event = slave.step(time, min(step, stop - time))
            if event:
                before = Limit.of(slave)
                slave.enter_event_mode()
                after = Limit.of(slave)
                announced, coming = math.isclose(coming, time, rel_tol=ROUNDING), slave.update_discrete_states()
                slave.enter_step_mode()
                yield Event(time, before, after, coming, announced)


def main() -> int:
    """Prints a list of events; returns 1 if a law is violated."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU3, type=Path)
    parser.add_argument("--periods", default=10.0, type=float)
    arguments = parser.parse_args()
    parameters = start_values(arguments.fmu)
    period = 2.0 * math.pi / parameters["drive.frequency"]
    print("time (s)            event               dw/dt before  after (m/s)  error: restitution  momentum  announced  next (s)")
    worst = (0.0, 0.0)
    unannounced = count = 0
    start = {"block.s": 0.9, "block.v": 0.5}
    for event in events(arguments.fmu, start, arguments.periods * period, period / 10.0):
        errors = event.errors(parameters)
        worst = max(worst[0], errors[0]), max(worst[1], errors[1])
        count, unannounced = count + 1, unannounced + (not event.announced)
        print(
            f"{event.time:<18.15g}  {event.kind:<18}  {event.before.relative:<12.8f}  {event.after.relative:<11.8f}  "
            f"{errors[0]:<18.1e}  {errors[1]:<8.1e}  {'yes' if event.announced else 'no':<9}  {event.next_event:.9g}"
        )
    holds = max(worst) <= ROUNDING and not unannounced
    print(
        f"{count} events, {unannounced} of them not announced to the last digits; largest errors: restitution {worst[0]:.1e}, "
        f"momentum {worst[1]:.1e}: the laws {'hold' if holds else 'DO NOT HOLD'}"
    )
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
