"""Search for the best design of machines of your own."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arguments import MOST_PERIODS, Floats, number, whole
from ._base import AnyMachine
from ._machine_description import MachineDescription
from ._machine_many import SectionLike, section_of
from ._machine_start import StartLike, numbers_of
from ._progress import Bar, partial
from ._result import Result
from ._show import Line, lines
from ._start import Start

#: End of a range: a number in SI, or a text with a unit.
_End = Union[float, str]

#: Number of values of an interval without a count.
_VALUES = 11


@dataclasses.dataclass(frozen=True)
class DesignMotion:
    """A motion of the best design, at the values of the parameters in `over` with the worst output."""

    kind: str
    "Class: 1T, 2T, ..., quasi-periodic, chaotic."
    contacts: float
    "Number of impacts and first touches per return."
    goal: float
    "Value of the output, SI."
    bar: tuple[float, float]
    "Ends of the error bar."
    starts: int
    "Number of starts of this motion."
    start: Start
    "A start that leads to this motion; empty for the machine's own start."
    requested: bool
    "Whether a start of the search leads to this motion."
    worse: bool
    "Whether the motion is worse than the design's value beyond the error bars."


@dataclasses.dataclass(frozen=True)
class Rival:
    """Another design, far from the best one."""

    values: dict[str, float]
    "Values of the varied parameters by name, SI."
    goal: float
    "Value of the output, SI."
    bar: tuple[float, float]
    "Ends of the error bar."
    told_apart: bool
    "Whether the design is worse than the best one beyond the error bars."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """The best design of a machine of your own; all numbers in SI."""

    verdict: str
    "``decided``; or ``undecided: …`` or ``none found: …`` with the reason."
    machine: AnyMachine
    "The machine with the best design's parameters; unchanged if none was found."
    values: dict[str, float]
    "Parameters of the best design by name; empty if no design has a value."
    goal: float
    "Output of the best design's worst motion; NaN if no design has a value."
    bar: tuple[float, float]
    "Ends of the error bar of `goal`."
    exact: bool
    "Whether every motion repeats, so that the error bar is only rounding."
    place: str
    "Description of the worst motion; empty if there is a single motion."
    at_ends: list[str]
    "Parameters at an end of their range."
    limits: dict[str, tuple[Optional[float], str]]
    "For each constraint in `subject_to`: the worst value of its output over the motions, and ``met``, ``not met`` or ``undecided``."
    motions: list[DesignMotion]
    "Coexisting motions where the worst value occurs."
    rivals: list[Rival]
    "Other designs that were compared with the best one."
    gradients: bool
    "Whether the best design was found with exact derivatives of orbits."
    names: tuple[str, ...]
    "Names of the varied parameters."
    designs: Floats
    "Parameters of all evaluated designs, shape (m, n), in order."
    goals: Floats
    "Output of each design, shape (m,); NaN if a motion has no value."
    within_limits: NDArray[np.bool_]
    "Whether each design satisfies the constraints, shape (m,)."
    stages: list[str]
    "Stage of the search that requested each design: own, sobol, evolution, gradient, nearby."

    def _picture(self) -> str:
        count = np.arange(1.0, len(self.goals) + 1)
        is_known = np.isfinite(self.goals)
        return lines([Line(count[is_known], self.goals[is_known], dots=True)], "evaluation", "output of the worst motion, SI")


def design(
    machine: MachineDescription,
    *,
    vary: Mapping[str, tuple[_End, _End]],
    minimize: Optional[str] = None,
    maximize: Optional[str] = None,
    over: Optional[Mapping[str, Any]] = None,
    subject_to: Iterable[str] = (),
    robust: float = 0.0,
    evaluations: int = 200,
    periods: int = 60,
    settle: int = 300,
    again: int = 300_000,
    section: SectionLike = None,
    start: Union[StartLike, list[StartLike]] = None,
    progress: bool = False,
) -> Design:
    """Finds the design whose worst motion has the smallest or largest output: ``vibro design FILE``.

    >>> import vibro_impact as vi
    >>> slide = vi.Machine({
    ...     "name": "Slide", "body": {"a": {"mass": 1.0}},
    ...     "spring": {"k": {"between": ["ground", "a"], "stiffness": 1e4, "damping": 2.0}},
    ...     "load": {"f": {"on": "a", "amplitude": 1.0, "frequency": 10.0}},
    ... })
    >>> found = vi.design(slide, maximize="amplitude.a.s", vary={"spring.k.stiffness": (2e3, 6e3)}, evaluations=20)
    >>> found.verdict, round(found.values["spring.k.stiffness"], 3)
    ('decided', 3947.842)

    Parameters
    ----------
    machine
        The machine; its own parameter values are evaluated first if they lie in the ranges.
    vary
        The parameters to vary, each with the ends of its range, in SI or as texts with units.
    minimize, maximize
        The output to minimise or maximise for the worst motion, such as ``amplitude.box.s``; :attr:`Machine.measures` lists all.
    over
        Parameters for the worst value of a design. A tuple ``(from, to)`` or ``(from, to, count)`` is an interval, where
        peaks between the values are searched too; a list gives separate values.
    subject_to
        Constraints that every motion of a design must satisfy, such as ``"impact.speed.steel <= 0.5 m/s"``.
    robust
        Relative tolerance of the varied parameters. The worst value at the corners of the tolerance box counts (at 16 corners for more than
        four parameters); for the best design, at 32 interior points too.
    evaluations
        Number of designs to evaluate; local searches in three basins may add about ten each.
    periods, settle, section
        As in :meth:`Machine.measure`.
    again
        Cap on the simulated periods for measuring the best designs again, over longer times.
    start
        As in :meth:`Machine.simulate`, or a list of starts: every design is run from each of them.
    progress
        Whether to show a progress bar, with the stage, the number of designs and the best output so far.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C, with the best design found as its attribute ``partial``: a :class:`Design` whose verdict is ``undecided: ended by hand``;
        None if the running simulations do not end within 10 s, or at a second Ctrl-C.
    ValueError, TypeError
        If an argument is out of its range, or a name is unknown.
    """
    if not isinstance(machine, MachineDescription):
        raise TypeError(f"machine is of type {type(machine).__name__}: expected a Machine; a PaperMachine has `described()`")
    if (minimize is None) == (maximize is None):
        raise TypeError(f"minimize = {minimize!r} and maximize = {maximize!r}: expected one of them, e.g. minimize='amplitude.box.s'")
    limits = [subject_to] if isinstance(subject_to, str) else list(subject_to)
    ranges = [(name, *_ends(machine, f"vary: {name}", name, ends)) for name, ends in vary.items()]
    axes = [_axis(machine, name, given) for name, given in (over or {}).items()]
    starts = start if isinstance(start, list) else [start]
    windows = (whole("settle", settle, 0, MOST_PERIODS), whole("periods", periods, 1, MOST_PERIODS), whole("again", again, 0, 2**63))
    names = tuple(name for name, _, _ in ranges)

    def made(found: dict[str, Any]) -> Design:
        return _designed(machine, names, limits, found)

    with Bar(progress, 1000, "‰") as bar, partial(made):
        found = _native.design(
            machine._described,
            str(minimize if maximize is None else maximize),
            maximize is not None,
            ranges,
            axes,
            limits,
            number("robust", robust),
            whole("evaluations", evaluations, 10, 1_000_000),
            windows,
            [numbers_of(machine, own) for own in starts],
            section_of(section),
            bar.report,
        )
    return made(found)


def _ends(machine: MachineDescription, what: str, name: str, ends: Any) -> tuple[float, float]:
    """Returns the ends of a range, SI."""
    if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
        raise TypeError(f"{what} = {ends!r}: expected a pair of its smallest and largest value, in SI or as texts with units")
    low, high = (_value(machine, name, end) for end in ends)
    if not low < high:
        raise ValueError(f"{what} = {ends!r}: the first value must be less than the second")
    return low, high


def _value(machine: MachineDescription, name: str, value: _End) -> float:
    return number(name, machine._in_si(name, value) if isinstance(value, str) else value)


def _axis(machine: MachineDescription, name: str, given: Any) -> tuple[str, list[float], bool]:
    """Returns the name and values of a parameter of a band, and whether the values sample an interval."""
    if isinstance(given, tuple):
        count = whole(f"over: {name}[2]", given[2], 2, 1000) if len(given) == 3 else _VALUES
        low, high = _ends(machine, f"over: {name}", name, given[:2])
        return name, np.linspace(low, high, count).tolist(), True
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise TypeError(f"over: {name} = {given!r}: expected a tuple (from, to) or (from, to, count), or a list of values")
    return name, [_value(machine, name, value) for value in given], False


def _designed(machine: MachineDescription, names: tuple[str, ...], limits: list[str], found: dict[str, Any]) -> Design:
    def named(values: list[float]) -> dict[str, float]:
        return dict(zip(names, values))

    best: dict[str, Any] = found["best"] or {
        "values": [], "goal": (np.nan, np.nan, np.nan), "exact": False, "place": "", "at_ends": [], "limits": [], "attractors": [],
    }
    values = named(best["values"])
    motions = [
        DesignMotion(
            own["kind"], own["contacts"], own["goal"][0], own["goal"][1:], own["starts"], Start(dict(own["start"])), own["requested"],
            own["worse"],
        )
        for own in best["attractors"]
    ]
    is_found = values and not found["verdict"].startswith("none found")
    return Design(
        verdict=found["verdict"],
        machine=machine.replace(values) if is_found else machine,
        values=values,
        goal=best["goal"][0],
        bar=best["goal"][1:],
        exact=best["exact"],
        place=best["place"],
        at_ends=best["at_ends"],
        limits={text: (own and own[0], check) for text, (own, check) in zip(limits, best["limits"])},
        motions=motions,
        rivals=[Rival(named(values), goal[0], goal[1:], apart) for values, goal, apart in found["rivals"]],
        gradients=found["gradients"],
        names=names,
        designs=found["values"],
        goals=found["goals"],
        within_limits=found["within_limits"],
        stages=found["stages"],
    )
