"""Many motions at once."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, overload

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, Floats, Start, array, state, whole
from ._assembly_description import AssemblyDescription
from ._assembly_many import Section, ends, measures_of, names_of, runs
from ._assembly_results import AssemblyEnds, AssemblyRun
from ._assembly_start import Start as AssemblyStartLike
from ._measures import keeping, measure_names, rows
from ._progress import Bar
from ._result import Result
from ._values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


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


@overload
def simulate_many(
    machines: Union[ParameterValues, Iterable[ParameterValues]],
    starts: Union[Start, Sequence[Start]] = None,
    *,
    periods: int = 400,
    progress: bool = False,
) -> Ends: ...


@overload
def simulate_many(
    machines: Union[AssemblyDescription, Iterable[AssemblyDescription]],
    starts: Union[AssemblyStartLike, Sequence[AssemblyStartLike]] = None,
    *,
    until: float,
    progress: bool = False,
) -> AssemblyEnds: ...


@overload
def simulate_many(
    machines: Union[AssemblyDescription, Iterable[AssemblyDescription]],
    starts: Union[AssemblyStartLike, Sequence[AssemblyStartLike]] = None,
    *,
    times: ArrayLike,
    derivatives: Iterable[str] = (),
    progress: bool = False,
) -> list[AssemblyRun]: ...


def simulate_many(
    machines: Any,
    starts: Any = None,
    *,
    periods: Optional[int] = None,
    until: Optional[float] = None,
    times: Optional[ArrayLike] = None,
    derivatives: Iterable[str] = (),
    progress: bool = False,
) -> Union[Ends, AssemblyEnds, list[AssemblyRun]]:
    """Many motions on all cores: of :class:`Machine` over whole drive periods from time 0, of :class:`Assembly` until a time or at instants.

    Those of :class:`Machine` run side by side in the processor's vectors. Each ends as accurately as by :meth:`Machine.simulate`, but not on
    the same bits; they do not depend on the other motions, nor on the number of threads (docs/guarantees.md). Those of :class:`Assembly`
    are bit-identical to one :meth:`Assembly.simulate` to the end; with `times` each is what that returns.

    Parameters
    ----------
    machines
        Machines of one kind, or one for all starts. Neighbours that are equal share their tables. Of assemblies with `until` all have one
        structure: :meth:`Assembly.replace` makes them.
    starts
        Of machines: a start as of :meth:`Machine.simulate` for all, a sequence of starts, or an array of shape (n, 6). Of assemblies: a start
        as of :meth:`Assembly.simulate` for all, or a sequence of starts.
    periods
        Of machines: drive periods, each machine's own; 400 unless given.
    until
        Of assemblies: end of the motions, s.
    times, derivatives
        Of assemblies: as of :meth:`Assembly.simulate`; a run for each.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As :meth:`Machine.simulate` and :meth:`Assembly.simulate`, with the motion's index; for numbers of machines and starts that differ;
        for assemblies of different columns.
    KeyboardInterrupt
        On Ctrl-C, with the ends found until then as its attribute ``partial``: a list with an array for each motion, None where it was not
        at its end; of machines the state, shape (6,), of assemblies the values in the order of ``columns``.
    """
    machines = _listed(machines)
    if until is not None or times is not None or _are_assemblies(machines):
        if (until is None) == (times is None) or periods is not None:
            raise TypeError("of assemblies allowed is `until` or `times`, and no `periods`; of machines the other way round")
        if times is not None:
            return runs(_several(machines), starts, times, derivatives, progress)
        if names_of(derivatives):
            raise TypeError("derivatives: allowed with `times`")
        return ends(_several(machines), starts, until, progress)
    if names_of(derivatives):
        raise TypeError("derivatives: allowed for assemblies, with `times`")
    periods = whole("periods", 400 if periods is None else periods, 0, MOST_PERIODS)
    several, begins = _motions(machines, starts, "a motion over periods")
    with Bar(progress, len(several), "motions") as bar, keeping(lambda _, one: np.array(one)):
        s, v = _native.simulate_many([m._system for m in several], begins, periods, bar.report)
    return Ends(np.array([periods * m.period for m in several]), s, v)


@overload
def measure_many(
    machines: Union[ParameterValues, Iterable[ParameterValues]],
    measures: Sequence[str],
    starts: Union[Start, Sequence[Start]] = None,
    *,
    periods: int = 60,
    settle: int = 400,
    errors: str = "raise",
    progress: bool = False,
) -> list[dict[str, float | str | None]]: ...


@overload
def measure_many(
    machines: Union[AssemblyDescription, Iterable[AssemblyDescription]],
    measures: Sequence[str],
    starts: Union[AssemblyStartLike, Sequence[AssemblyStartLike]] = None,
    *,
    periods: int = 60,
    settle: int = 300,
    section: Section = None,
    errors: str = "raise",
    progress: bool = False,
) -> list[dict[str, float | str | None]]: ...


def measure_many(
    machines: Any,
    measures: Sequence[str],
    starts: Any = None,
    *,
    periods: int = 60,
    settle: Optional[int] = None,
    section: Section = None,
    errors: str = "raise",
    progress: bool = False,
) -> list[dict[str, float | str | None]]:
    """Measures of many settled motions on all cores: a dictionary for each, with the bits of :meth:`Machine.measure` and
    :meth:`Assembly.measure`.

    ``pandas.DataFrame(measure_many(...))`` makes a table of them.

    Parameters
    ----------
    machines
        Machines or assemblies, or one for all starts.
    measures
        Names: :data:`MEASURES` has those of machines, :attr:`Assembly.measures` those of an assembly, with units.
    starts
        As of :func:`simulate_many`.
    periods, settle
        Periods that are measured, and those before in which the transient dies out; the defaults are those of ``vibro sweep`` and ``vibro
        assembly sweep``.
    section
        Of assemblies, as of :meth:`Assembly.measure`.
    errors
        ``"raise"``: a motion that is refused or cannot go on raises its exception. ``"row"``: its dictionary has None for every measure and
        the reason under ``"error"``, which is None in all others; what is asked wrongly of all motions is raised all the same.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As :meth:`Machine.measure` and :meth:`Assembly.measure`, with the motion's index; for numbers of machines and starts that differ.
    KeyboardInterrupt
        On Ctrl-C, with the dictionaries found until then as its attribute ``partial``: a list with None for each motion that was not at its
        end.
    """
    machines = _listed(machines)
    if _are_assemblies(machines):
        settle = 300 if settle is None else settle
        return measures_of(_several(machines), starts, measures, periods, settle, section, errors, progress)
    if section is not None:
        raise TypeError("section: allowed for assemblies; a machine is looked at once a drive period")
    names = measure_names(measures)
    periods = whole("periods", periods, 1, MOST_PERIODS)
    settle = whole("settle", 400 if settle is None else settle, 0, MOST_PERIODS)
    several, begins = _motions(machines, starts, "a measure")
    systems = [m._system for m in several]
    with Bar(progress, len(several), "motions") as bar:
        return rows(names, errors, lambda told: _native.measure_many(systems, begins, names, settle, periods, told, bar.report))


def sweep_of(
    machine: Union[ParameterValues, AssemblyDescription], parameters: dict[str, Any], measures: Sequence[str], starts: Any = None, **options: Any
) -> list[dict[str, Any]]:
    """What :meth:`Machine.sweep` and :meth:`Assembly.sweep` return."""
    for name, values in parameters.items():
        if isinstance(values, str) or np.ndim(values) != 1:
            raise TypeError(f"{name}: allowed is a list or an array of shape (n,) of values")
    designs = [dict(zip(parameters, values)) for values in itertools.product(*parameters.values())]
    machines: list[Any] = [machine.replace(**design) for design in designs]
    found = measure_many(machines, measures, starts, **options)
    return [{**design, **row} for design, row in zip(designs, found)]


def _listed(machines: Any) -> Any:
    """A collection that can be iterated over more than once."""
    return list(machines) if isinstance(machines, Iterable) else machines


def _are_assemblies(machines: Any) -> bool:
    """Whether the machines are assemblies, by the first; a single :class:`Assembly` counts."""
    first = machines[0] if isinstance(machines, list) and machines else machines
    return isinstance(first, AssemblyDescription)


def _several(machines: Any) -> list[AssemblyDescription]:
    several = list(machines) if isinstance(machines, Iterable) else [machines]
    for index, machine in enumerate(several):
        if not isinstance(machine, AssemblyDescription):
            raise TypeError(f"machines[{index}] is of type {type(machine).__name__}: allowed is Assembly")
    return several


def _motions(
    machines: Union[ParameterValues, Iterable[ParameterValues]], starts: Union[Start, Sequence[Start]], what: str
) -> tuple[list[ParameterValues], Floats]:
    """A machine and a start for each motion."""
    several = list(machines) if isinstance(machines, Iterable) else [machines]
    for index, machine in enumerate(several):
        if not isinstance(machine, ParameterValues):
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


def _rows(machines: list[ParameterValues], starts: Any) -> Floats:
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
