"""Lyapunov spectra and other measures of a motion."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Callable, Optional, Union

import numpy as np

from . import _native
from ._arguments import COORDINATES, SI_COORDINATES, Floats
from ._show import Line, lines
from ._result import Result
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

# The paper's symbol for each column.
_OWN = dict(zip(SI_COORDINATES, COORDINATES))
#: Unit and meaning of every measure of :meth:`PaperMachine.measure`, by name.
MEASURES = {name: (unit, meaning) for name, unit, meaning in _native.paper_measures()}


def measure_names(measures: Sequence[str]) -> list[str]:
    """Returns names of measures as a list; raises for anything else."""
    names = [] if isinstance(measures, str) or not isinstance(measures, Iterable) else list(measures)
    if not isinstance(measures, Iterable) or isinstance(measures, str) or not all(isinstance(name, str) for name in names):
        raise TypeError(f"measures = {measures!r}: expected a sequence of names, e.g. ['amplitude.x1']")
    return names


def of_paper(names: list[str]) -> list[str]:
    """Translates names of measures to the paper's symbols: ``amplitude.box.s`` is ``amplitude.x1``."""
    parts = [name.partition(".") for name in names]
    return [f"{word}.{_OWN[column]}" if column in _OWN else f"{word}{point}{column}" for word, point, column in parts]


#: Measures of one motion: numbers, their spreads, class, index of the measure that had not settled, reason for missing measures.
Row = tuple[list[Optional[float]], list[float], Optional[str], Optional[int], Optional[str]]


class Measures(dict[str, Union[float, str, None]]):
    """Measures of a motion by name: a dictionary, with the spread of each measure."""

    def __init__(self, values: Mapping[str, Union[float, str, None]], spread: dict[str, Optional[float]], unsettled: Optional[str]) -> None:
        super().__init__(values)
        self.spread = spread
        """For each measure, the scatter of its number from one window of the motion to the next: the standard error for a mean, rounding if the
        motion repeats. None if the measure has no number."""
        self.unsettled = unsettled
        "Name of a measure that was still drifting while it was measured, or ``the motion``; None if all had settled."


def measured(names: list[str], row: Row) -> Measures:
    """Returns the measures of a motion by name."""
    numbers, spreads, kind, _, error = row
    if error is not None:
        numbers = [None] * len(names)
    values: dict[str, Union[float, str, None]] = {name: kind if name == "class" else value for name, value in zip(names, numbers)}
    spread = {name: None if numbers[k] is None else spreads[k] for k, name in enumerate(names) if name != "class"}
    return Measures(values, spread, unsettled(names, row))


def spread_of(name: str) -> str:
    """Returns the name of the spread of a measure, as in the tables of ``vibro sweep``."""
    return f"{name}.spread"


def unsettled(names: list[str], row: Row) -> Optional[str]:
    """Returns the name of the measure that had not settled, or "the motion", or None if all had settled."""
    index = row[3]
    return None if index is None else names[index] if index < len(names) else "the motion"


@contextlib.contextmanager
def keeping(made: Callable[[int, Any], Any]) -> Iterator[None]:
    """Attaches the results so far to a KeyboardInterrupt as `partial`: a list with an entry for each motion, None for an unfinished one."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        found = getattr(interrupt, "partial", None)
        if found is not None:
            setattr(interrupt, "partial", [None if one is None else made(i, one) for i, one in enumerate(found)])  # noqa: B010 (not in its type)
        raise


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperSpectrum(Result):
    """Lyapunov spectrum of a motion of the paper's machine."""

    machine: ParameterValues
    "Machine of the motion."
    exponents: Floats
    "Exponents, largest first, shape (7,), 1/s; -inf for directions lost in rest or at plastic impacts."
    deviation: float
    "Largest standard deviation of the running exponents over the last 200 periods, 1/s."
    running: Floats
    "Running exponents after each drive period, in the order of the directions, shape (periods, 7), 1/s."
    impacts: int
    "Number of impacts in the periods of ``running``."
    rests: bool
    "Whether the block rested."

    @property
    def dimensionless(self) -> Floats:
        """The exponents per unit of dimensionless time, i.e. in units of omega10, shape (7,)."""
        found: Floats = self.exponents / np.sqrt(self.machine.box_k / self.machine.box_m)
        return found

    def _picture(self) -> str:
        periods = np.arange(1.0, len(self.running) + 1.0)
        return lines([Line(periods, self.running[:, k], colour=k) for k in range(self.running.shape[1])], "drive periods", "running exponents (1/s)")
