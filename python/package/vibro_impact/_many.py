"""Many motions at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, Floats, Start, array, state, whole
from ._machine import Machine
from ._measures import measure_names, measured
from ._progress import Bar
from ._result import Result


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Ends(Result):
    """The ends of many motions."""

    t: Floats
    "Times of the ends, shape (n,), s."
    s: Floats
    "Displacements x1, x2, x3, shape (n, 3), m."
    v: Floats
    "Velocities, shape (n, 3), m/s."

    @property
    def states(self) -> Floats:
        """The states as starts of further motions, shape (n, 6)."""
        return np.concatenate([self.s, self.v], axis=1)


def simulate_many(
    machines: Union[Machine, Iterable[Machine]],
    starts: Union[Start, Sequence[Start]] = None,
    *,
    periods: int = 400,
    progress: bool = False,
) -> Ends:
    """Many motions over whole drive periods from time 0, side by side in the processor's vectors and on all cores.

    Each ends as accurately as by :meth:`Machine.simulate`, but not on the same bits; they do not depend on the other motions, nor on the
    number of threads (docs/guarantees.md).

    Parameters
    ----------
    machines
        Machines, or one for all starts. Neighbours that are equal share their tables.
    starts
        A start as of :meth:`Machine.simulate` for all machines, a sequence of starts, or an array of shape (n, 6).
    periods
        Drive periods, each machine's own.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As :meth:`Machine.simulate`, with the motion's index; for numbers of machines and starts that differ.
    """
    periods = whole("periods", periods, 0, MOST_PERIODS)
    several, rows = _motions(machines, starts, "a motion over periods")
    with Bar(progress, len(several), "motions") as bar:
        s, v = _native.simulate_many([m._system for m in several], rows, periods, bar.report)
    return Ends(np.array([periods * m.period for m in several]), s, v)


def measure_many(
    machines: Union[Machine, Iterable[Machine]],
    measures: Sequence[str],
    starts: Union[Start, Sequence[Start]] = None,
    *,
    periods: int = 60,
    settle: int = 400,
    progress: bool = False,
) -> list[dict[str, float | str | None]]:
    """Measures of many settled motions on all cores: a dictionary for each, with the bits of :meth:`Machine.measure`.

    ``pandas.DataFrame(measure_many(...))`` makes a table of them.

    Parameters
    ----------
    machines
        Machines, or one for all starts.
    measures
        Names as of :meth:`Machine.measure`; :data:`MEASURES` has all, with units.
    starts
        As of :func:`simulate_many`.
    periods, settle
        Drive periods that are measured, and those before in which the transient dies out; the defaults are those of ``vibro sweep``.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As :meth:`Machine.measure`, with the motion's index; for numbers of machines and starts that differ.
    """
    names = measure_names(measures)
    periods = whole("periods", periods, 1, MOST_PERIODS)
    settle = whole("settle", settle, 0, MOST_PERIODS)
    several, rows = _motions(machines, starts, "a measure")
    with Bar(progress, len(several), "motions") as bar:
        found = _native.measure_many([m._system for m in several], rows, names, settle, periods, bar.report)
    return [measured(names, numbers, kind) for numbers, kind in found]


def _motions(
    machines: Union[Machine, Iterable[Machine]], starts: Union[Start, Sequence[Start]], what: str
) -> tuple[list[Machine], Floats]:
    """A machine and a start for each motion."""
    several = list(machines) if isinstance(machines, Iterable) else [machines]
    for index, machine in enumerate(several):
        if not isinstance(machine, Machine):
            raise TypeError(f"machines[{index}] is of type {type(machine).__name__}: allowed is Machine")
    rows = _rows(several, starts)
    if len(several) == 1:
        several *= len(rows)
    if len(rows) != len(several):
        raise ValueError(f"starts has {len(rows)} rows: allowed is one start, or one for each of {len(several)} machines")
    for index, machine in enumerate(several):
        try:
            machine._needs_period(what)
        except ValueError as error:
            raise ValueError(f"machines[{index}]: {error}") from None
    return several, rows


def _rows(machines: list[Machine], starts: Any) -> Floats:
    """Starts as an array of shape (n, 6): one for each machine, or one for each of several starts of a machine."""
    if isinstance(starts, np.ndarray) and starts.ndim == 2:
        found = array("starts", starts, "an array of shape (n, 6)", 2)
        if found.shape[1] != 6:
            raise ValueError(f"starts has the shape {found.shape}: allowed is (n, 6)")
        return found
    one = starts is None or isinstance(starts, dict) or np.ndim(starts) == 1 and np.asarray(starts).dtype.kind in "iuf"
    if one:
        return np.array([state("starts", starts, m._system) for m in machines]).reshape(-1, 6)
    several = list(starts)
    if len(machines) not in (1, len(several)):
        raise ValueError(f"starts has {len(several)} rows: allowed is one start, or one for each of {len(machines)} machines")
    own = machines if len(machines) == len(several) else machines * len(several)
    return np.array([state(f"starts[{i}]", s, m._system) for i, (s, m) in enumerate(zip(several, own))]).reshape(-1, 6)
