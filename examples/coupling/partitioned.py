"""One machine as one FMU, and cut in two: the secondary oscillator becomes an FMU of its own.

Whole: VibroImpact3DOF, unchanged. Cut: VibroImpact3DOF with coupling.k = 0 receives the spring's force as load `block.f`; the
oscillator (oscillator.py, an FMU made by pythonfmu) receives the block's displacement and returns that force. Four masters
couple them by FMI 2.0, and one by FMI 3.0, which steps to the announced events and never goes back. The script draws their
error over the communication step, and over the work:

    python examples/coupling/partitioned.py --out coupling.png
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from vibro import FMU, EventSlave, PathLike, Slave, Value, fmi3_beside, start_values  # noqa: E402

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: A stronger coupling than the FMU's start value: its errors are easier to see.
COUPLING = 0.05  # N/m
PERIODS = 5
BODIES = ("box.s", "block.s", "secondary.s")

#: An iteration ends when the force at the end of the step changes by less than this (N); forces are about 0.05 N.
TOLERANCE = 1e-14
MOST_ITERATIONS = 50

#: A step (s) so short that the effect of the block's own acceleration is below the rounding of its displacement.
SHORT = 1e-5


def build_oscillator(folder: PathLike) -> Path:
    """Builds the oscillator as an FMU with pythonfmu."""
    from pythonfmu.builder import FmuBuilder

    script = Path(__file__).with_name("oscillator.py")
    FmuBuilder.build_FMU(script, dest=folder, canGetAndSetFMUstate="true")
    return Path(folder) / "Oscillator.fmu"


@dataclass
class Run:
    """Displacements at the communication points common to all runs, and the work done."""

    states: list[NDArray[np.float64]] = field(default_factory=list)
    steps: int = 0
    iterations: int = 0
    #: Steps that the machine's FMU computed, including discarded ones.
    computed: int = 0


@dataclass
class Machine:
    """The cut machine: two instances, and the quantities they exchange at the current communication point."""

    box: Slave
    oscillator: Slave
    stiffness: float  # of the cut spring

    def flange(self) -> tuple[float, float, float, float]:
        """Makes both sides agree; returns displacement and velocity of the block, force on it and the rate of that force."""
        s, v = self.box.reals(["block.s", "block.v"])
        for name, value in (("s", s), ("v", v), ("a", 0.0)):
            self.oscillator.set(name, value)
        f, rate = self.oscillator.reals(["f", "df"])
        return float(s), float(v), float(f), float(rate)

    def displacements(self) -> NDArray[np.float64]:
        """Displacements of box, block and secondary oscillator, m."""
        return np.append(self.box.reals(["box.s", "block.s"]), self.oscillator.get("x"))


#: A master advances the machine from a time by at most a step size, and returns the time reached and its iterations.
Master = Callable[[Machine, float, float], "tuple[float, int]"]


def held(machine: Machine, time: float, size: float) -> tuple[float, int]:
    """Gauss–Seidel with held values, which every host supports. First order."""
    _, _, f, _ = machine.flange()
    machine.box.set("block.f", f)
    reached = machine.box.step(time, size)
    for name, value in (("s", machine.box.get("block.s")), ("v", 0.0), ("a", 0.0)):
        machine.oscillator.set(name, value)
    machine.oscillator.step(time, size)
    return reached, 1


def extrapolated(machine: Machine, time: float, size: float) -> tuple[float, int]:
    """Gauss–Seidel, the force extrapolated by its rate (fmi2SetRealInputDerivatives), the motion interpolated. Second order."""
    s, v, f, rate = machine.flange()
    machine.box.set("block.f", f)
    machine.box.set_derivatives("block.f", [rate])
    reached = machine.box.step(time, size)
    machine.oscillator.set("a", 2.0 * (machine.box.get("block.s") - s - v * size) / size**2)
    machine.oscillator.step(time, size)
    return reached, 1


def iterated(machine: Machine, time: float, size: float) -> tuple[float, int]:
    """Both sides repeat the step from the saved states until they agree on the force f + f' t + q t² and the motion
    s + v t + a t²/2. Third order between impacts; an impact inside a step lowers the order by one. If `stopAtImpact` is set, a step
    ends at the impact instead.

    Newton's method gives the next force. fmi2GetDirectionalDerivative gives the effect of the end force on the block's
    displacement at the end: an acceleration ∂a/∂f (t/h)² displaces the block by ∂a/∂f h²/12.
    """
    box, oscillator = machine.box, machine.oscillator
    s, v, f, rate = machine.flange()
    admittance = box.derivative("block.a", "block.f")
    states = box.save(), oscillator.save()
    end, bend = size, 0.0  # the step, and q h²
    try:
        for iteration in range(1, MOST_ITERATIONS + 1):
            box.restore(states[0])
            box.set("block.f", f)
            box.set_derivatives("block.f", [rate, 2.0 * bend / end**2])
            reached = box.step(time, size)
            h = reached - time
            if h < size:  # discarded at an impact, from where no further step is allowed: repeat it, up to the impact
                box.restore(states[0])
                box.set("block.f", f)
                box.set_derivatives("block.f", [rate, 2.0 * bend / end**2])
                reached = box.step(time, h)
            bend *= (h / end) ** 2
            oscillator.restore(states[1])
            oscillator.set("a", 2.0 * (box.get("block.s") - s - v * h) / h**2)
            oscillator.step(time, h)
            residual = oscillator.get("f") - (f + rate * h + bend)
            settled = abs(residual) < TOLERANCE and h == end
            if settled or (abs(residual) < TOLERANCE and abs(h - end) < 4e-16 * max(1.0, reached)):
                return reached, iteration
            bend += residual / (1.0 + machine.stiffness * admittance * h**2 / 12.0)
            end = h
    finally:
        box.free(states[0])
        oscillator.free(states[1])
    raise RuntimeError(f"the step at t = {time} s does not converge in {MOST_ITERATIONS} iterations: use a smaller step")


@dataclass
class EventMachine:
    """The cut machine with the FMI 3.0 FMU, whose events the master handles."""

    box: EventSlave
    oscillator: Slave
    next_event: float  # as announced, s

    def flange(self) -> tuple[float, float, float, float, float]:
        """Displacement and velocity of the block, force on it and that force's first two derivatives, just after the current time."""
        s, v, a = self.box.reals(["block.s", "block.v", "block.a"])
        for name, value in (("s", s), ("v", v), ("a", a)):
            self.oscillator.set(name, value)
        f, rate, curvature = self.oscillator.reals(["f", "df", "ddf"])
        return float(s), float(v), float(f), float(rate), float(curvature)

    def displacements(self) -> NDArray[np.float64]:
        """Displacements of box, block and secondary oscillator, m."""
        return np.append(self.box.reals(["box.s", "block.s"]), self.oscillator.get("x"))


def to_events(machine: EventMachine, time: float, size: float) -> float:
    """Gauss–Seidel by FMI 3.0, with the force extrapolated by two derivatives and the motion interpolated: third order, without
    iteration or saved states. A step ends at the announced next event at the latest. The force shifts the event slightly. If it
    comes early, the FMU returns early and the oscillator steps to the same time; if it comes late, a short step follows.
    """
    box, oscillator = machine.box, machine.oscillator
    s, v, f, rate, curvature = machine.flange()
    box.set("block.f", f)
    # Inputs inside the step (intermediate update): the FMU reproduces a parabola exactly, because
    # it interpolates by a cubic.
    box.courses["block.f"] = lambda t: f + (t - time) * (rate + (t - time) * curvature / 2.0)
    if time < machine.next_event < time + size:
        size = machine.next_event - time
    reached, event = box.step(time, size)
    h = reached - time
    if h > SHORT:
        oscillator.set("a", 2.0 * (box.get("block.s") - s - v * h) / h**2)
    if h > 0.0:
        oscillator.step(time, h)
    box.enter_event_mode()
    if not event:
        box.set("block.f", oscillator.get("f"))  # the FMU predicts the next event with this force
    machine.next_event = box.update_discrete_states()
    box.enter_step_mode()
    return reached


def parameters(fmu: PathLike) -> dict[str, float]:
    """Parameters of the whole machine, SI."""
    return {**start_values(fmu), "coupling.k": COUPLING}


START = {"block.s": 0.9, "block.v": 0.5}  # the block soon hits both stops


def whole(fmu: PathLike, points: int, periods: int = PERIODS) -> Run:
    """Runs the machine as one FMU, recorded at `points` points per period."""
    p, run = parameters(fmu), Run()
    size = 2.0 * math.pi / p["drive.frequency"] / points
    with Slave(fmu, {**p, **START}) as box:
        run.states.append(box.reals(BODIES))
        for i in range(points * periods):
            box.step(i * size, size)
            run.states.append(box.reals(BODIES))
    return run


def cut(
    fmu: PathLike,
    oscillator: PathLike,
    master: Master,
    per_period: int,
    points: int,
    periods: int = PERIODS,
    to_impacts: bool = False,
) -> Run:
    """Runs the machine cut in two, with a number of communication steps per period, of which `points` are recorded."""
    p, run = parameters(fmu), Run()
    size = 2.0 * math.pi / p["drive.frequency"] / per_period
    box_start = {**p, "coupling.k": 0.0, "stopAtImpact": to_impacts, **START}
    oscillator_start = {"m": p["secondary.m"], "k": p["secondary.k"], "c": p["secondary.c"], "kc": p["coupling.k"]}
    with Slave(fmu, box_start) as box, Slave(oscillator, oscillator_start, name="oscillator") as second:
        machine = Machine(box, second, p["coupling.k"])
        run.states.append(machine.displacements())
        time = 0.0
        for i in range(per_period * periods):
            end = (i + 1) * size
            while time < end:
                time, iterations = master(machine, time, end - time)
                run.steps += 1
                run.iterations += iterations
            if (i + 1) % (per_period // points) == 0:
                run.states.append(machine.displacements())
        run.computed = box.steps
    return run


def cut_by_events(
    fmu: PathLike, oscillator: PathLike, per_period: int, points: int, periods: int = PERIODS
) -> Run:
    """Runs the machine cut in two with the FMI 3.0 FMU and the master that steps to the announced events."""
    p, run = parameters(fmu), Run()
    size = 2.0 * math.pi / p["drive.frequency"] / per_period
    box_start: dict[str, Value] = {**p, "coupling.k": 0.0, "stopAtImpact": True, **START}
    oscillator_start = {"m": p["secondary.m"], "k": p["secondary.k"], "c": p["secondary.c"], "kc": p["coupling.k"]}
    instance = EventSlave(fmu, box_start, driven=["block.f"])
    with instance as box, Slave(oscillator, oscillator_start, name="oscillator") as second:
        machine = EventMachine(box, second, box.update_discrete_states())
        box.enter_step_mode()
        run.states.append(machine.displacements())
        time = 0.0
        for i in range(per_period * periods):
            end = (i + 1) * size
            while time < end:
                time = to_events(machine, time, end - time)
                run.steps += 1
                run.iterations += 1
            if (i + 1) % (per_period // points) == 0:
                run.states.append(machine.displacements())
        run.computed = box.steps
    return run


#: Name, master, whether it steps to the impacts.
MASTERS: list[tuple[str, Master, bool]] = [
    ("Gauss–Seidel, values held", held, False),
    ("Gauss–Seidel, extrapolated", extrapolated, False),
    ("iterated", iterated, False),
    ("iterated, steps to the impacts", iterated, True),
]

#: The master of FMI 3.0.
EVENTS = "extrapolated, steps to the events (FMI 3.0)"

#: Numbers of communication steps per period.
STEPS = (10, 20, 40, 80, 160, 320, 640)


@dataclass
class Curve:
    """Error and cost of a master for each number of steps per period."""

    #: Largest difference of any displacement from the whole machine, m.
    errors: list[float] = field(default_factory=list)
    #: Steps per period that the machine's FMU computed, including discarded ones.
    computed: list[float] = field(default_factory=list)


def curves(fmu: PathLike, oscillator: PathLike, steps: tuple[int, ...] = STEPS) -> dict[str, Curve]:
    """Results of every master, by its name; the FMI 3.0 archive must be next to the FMI 2.0 archive."""
    points = min(steps)
    expected = np.array(whole(fmu, points).states)
    table: dict[str, Curve] = {}

    def add(name: str, count: int, run: Run) -> None:
        curve = table.setdefault(name, Curve())
        curve.errors.append(float(np.abs(np.array(run.states) - expected).max()))
        curve.computed.append(run.computed / PERIODS)
        print(
            f"{name:43} {count:4d} a period: error {curve.errors[-1]:.1e} m, {run.iterations / run.steps:.1f} iterations "
            f"a step, {curve.computed[-1]:.0f} steps computed a period"
        )

    for name, master, to_impacts in MASTERS:
        for count in steps:
            add(name, count, cut(fmu, oscillator, master, count, points, to_impacts=to_impacts))
    for count in steps:
        add(EVENTS, count, cut_by_events(fmi3_beside(fmu), oscillator, count, points))
    return table


def draw(table: dict[str, Curve], motion: dict[str, NDArray[np.float64]], path: PathLike) -> None:
    """Draws the errors over the step and over the work, and motions at ten steps per period."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    colours = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7"]
    figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(15, 5.4), layout="constrained")
    for (name, curve), marker, colour in zip(table.items(), "osD^v", colours):
        left.loglog([1.0 / n for n in STEPS], curve.errors, marker=marker, color=colour, label=name)
        middle.loglog(curve.computed, curve.errors, marker=marker, color=colour)
    left.set(xlabel="communication step (drive periods)", ylabel="largest error of a displacement (m)")
    left.set_title("Cut machine against the whole one")
    middle.set(xlabel="steps computed by the machine's FMU (per drive period)")
    middle.set_title("The same against the work")
    for axes in (left, middle):
        axes.grid(alpha=0.3)
    figure.legend(loc="outside lower left", ncols=3, frameon=False)
    for (name, history), style in zip(motion.items(), ("-", "--", "o")):
        time = np.linspace(0.0, PERIODS, len(history))
        for body, index, colour in (("block", 1, "#d55e00"), ("secondary", 2, "#009e73")):
            size = 4 if style == "o" else 0
            right.plot(time, history[:, index], style, color=colour, markersize=size, label=f"{body}: {name}")
    right.set(xlabel="time t/T (–)", ylabel="displacement (m)")
    right.set_title("Ten communication steps a period")
    right.legend(fontsize="small", ncols=1, loc="upper left")
    right.set_ylim(top=right.get_ylim()[1] * 1.9)
    figure.savefig(str(path), dpi=150)
    pyplot.close(figure)


def main() -> None:
    """Runs everything and draws it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--out", "--output", dest="output", default=Path("coupling.png"), type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        oscillator = build_oscillator(folder)
        table = curves(arguments.fmu, oscillator)
        motion: dict[str, Any] = {"whole": whole(arguments.fmu, 200)}
        name, master, to_impacts = MASTERS[0]
        motion[name] = cut(arguments.fmu, oscillator, master, 10, 10, to_impacts=to_impacts)
        motion[EVENTS] = cut_by_events(fmi3_beside(arguments.fmu), oscillator, 10, 10)
        draw(table, {name: np.array(run.states) for name, run in motion.items()}, arguments.output)
    print(arguments.output)


if __name__ == "__main__":
    main()
