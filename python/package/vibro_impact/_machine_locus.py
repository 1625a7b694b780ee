"""Curves of special points of machines of your own over two parameters."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _native
from ._arguments import Floats, number
from ._progress import Bar
from ._result import Result
from ._show import Line, lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._machine_description import MachineDescription

#: Labels of points of a curve over two parameters: why the curve ends, or which two conditions hold there.
LOCUS_LABELS = {
    "EP": "end of a parameter's range",
    "GR": "grazing: the orbit touches another contact, and its events change",
    "CP": "cusp of a fold curve",
    "LPBP": "a fold curve meets the pitchfork curve of a symmetric orbit, and ends",
    "LPPD": "fold-flip: multipliers 1 and -1",
    "R1": "1:1 resonance: two multipliers 1",
    "R2": "1:2 resonance: two multipliers -1",
    "MX": "the curve could not be followed further",
    "closed": "the curve ends where it begins",
}

#: The two parameters of a curve, each with its range, SI; the first is the parameter of the branch.
Ranges = tuple[tuple[str, tuple[float, float]], tuple[str, tuple[float, float]]]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Locus(Result):
    """A curve of special points of periodic orbits over two parameters."""

    machine: MachineDescription
    "The machine; along the curve its two parameters `names` vary."
    names: tuple[str, str]
    "The two parameters; the first is the branch's parameter."
    label: str
    "Kind of special point along the whole curve: a key of :data:`LABELS`."
    element: str
    "Element concerned, or empty."
    word: str
    "Events of the orbits, as the shortest word."
    periods: Optional[int]
    "Period in common periods of the drive; None for a machine without a drive."
    values: Floats
    "Both parameters along the curve, shape (n, 2), SI."
    period: Floats
    "Period of each orbit, shape (n,), s."
    angle: Floats
    "Angle of the multipliers on the unit circle, shape (n,), rad; NaN unless `label` is NS."
    labels: NDArray[np.str_]
    "Kind of special point at each point of the curve, shape (n,): a key of :data:`LOCUS_LABELS`, or empty."

    @property
    def special(self) -> list[tuple[str, float, float]]:
        """Ends and special points as (label, first parameter, second parameter), in the curve's order."""
        marked = np.flatnonzero(self.labels != "")
        return [(str(self.labels[i]), float(self.values[i, 0]), float(self.values[i, 1])) for i in marked]

    def _picture(self) -> str:
        x, y = self.values.T
        marked = (self.labels != "") & (self.labels != "EP")
        drawn = [Line(x, y, f"{self.label} {self.element}".strip()), Line(x[marked], y[marked], dots=True, colour=1)]
        return lines(drawn, f"{self.names[0]}, SI", f"{self.names[1]}, SI")


def ranges_of(machine: MachineDescription, name: str, given: dict[str, Any]) -> Ranges:
    """Returns the ranges of a branch's parameter and of a second one, SI."""
    others = [other for other in given if other != name]
    if len(given) != 2 or len(others) != 1:
        raise TypeError(
            f"ranges {list(given)}: expected the branch's parameter and a second one, each with a range, such as "
            f"{{{name!r}: (from, to), 'stop.steel.gap': ('1 mm', '8 mm')}}"
        )
    return (name, _range(machine, name, given[name])), (others[0], _range(machine, others[0], given[others[0]]))


def _range(machine: MachineDescription, name: str, given: Any) -> tuple[float, float]:
    try:
        low, high = given
    except (TypeError, ValueError):
        raise TypeError(f"{name} = {given!r}: expected a range (from, to) such as ('1 mm', '8 mm')") from None
    return number(f"{name}[0]", machine._in_si(name, low)), number(f"{name}[1]", machine._in_si(name, high))


def locus_of(
    machine: MachineDescription,
    ranges: Ranges,
    point: tuple[str, str, float],
    beside: list[tuple[float, float, list[tuple[str, float]]]],
    progress: bool,
) -> Locus:
    """Returns the result of :meth:`Branch.locus` from a special point (label, element, value) and neighbouring orbits."""
    first, second = ranges
    with Bar(progress, 1, "curves") as bar:
        found = _native.locus(machine._described, first, second, point, beside, bar.report)
    labels = np.array(found.pop("labels"), dtype=np.str_)
    return Locus(machine, (first[0], second[0]), point[0], point[1], labels=labels, **found)
