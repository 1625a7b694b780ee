"""Many motions at once."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, overload

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, Coordinates, Floats, StartOfMachine, array, choice, coordinates, seconds, state, whole
from ._machine_description import MachineDescription
from ._machine_many import SectionLike, names_of, runs, section_of
from ._machine_results import Ends, Run
from ._machine_start import StartLike, listed_starts, numbers_of, starts_of, time_of
from ._base import AnyMachine, merged
from ._instants import after
from ._measures import MEASURES, keeping, measure_names, measured, of_paper
from ._paper_starts import pairs, several_of, states, states_of_rows
from ._result import Result
from ._table import Table, table_of
from ._paper_values import ParameterValues
from ._work import rows_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_Path = Union[None, str, os.PathLike[str]]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperEnds(Result):
    """Final states of the motions of many of the paper's machines; ``ends["box.s"]`` is an array."""

    t: Floats
    "Times of the end states, shape (n,), s."
    s: Floats
    "Displacements x1, x2, x3, shape (n, 3), m."
    v: Floats
    "Velocities, shape (n, 3), m/s."
    error: Optional[NDArray[Any]] = None
    "Reason why a motion has no end state and its values are masked, if ``errors='row'`` is given; otherwise None."

    @property
    def states(self) -> Floats:
        """Returns the states as starts of further motions, shape (n, 6)."""
        found: Floats = np.zeros((*self.s.shape[:-1], 6))
        if isinstance(self.s, np.ma.MaskedArray):
            found = np.ma.MaskedArray(found, np.repeat(np.ma.getmaskarray(self.s)[..., :1], 6, axis=-1))
        found[..., :3], found[..., 3:] = self.s, self.v
        return found

    def __getitem__(self, name: str) -> Floats:
        found: Floats = self.states[..., ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v").index(name)]
        return found


@dataclasses.dataclass(frozen=True)
class _Motions:
    """Machines and their starts: a pair for each motion, or one machine with rows of values, or one start for all."""

    machines: list[Any]
    starts: Any
    names: Optional[list[str]] = None
    table: Optional[Floats] = None

    def count(self) -> int:
        """Number of motions."""
        return len(self.machines) if self.table is None else len(self.table)

    def part(self, begin: int, end: int) -> _Motions:
        """Returns the motions from `begin` to `end`."""
        one = isinstance(self.starts, Coordinates) or (isinstance(self.starts, list) and len(self.starts) == 1)
        starts = self.starts if one else self.starts[begin:end]
        if self.table is None:
            return dataclasses.replace(self, machines=self.machines[begin:end], starts=starts)
        return dataclasses.replace(self, table=self.table[begin:end], starts=starts)

    def told(self) -> Iterator[bytes]:
        """Yields everything on which the motions depend, as bytes."""
        yield from (m.toml.encode() if isinstance(m, MachineDescription) else repr(m).encode() for m in self.machines)
        yield repr(self.names).encode()
        yield b"" if self.table is None else np.ascontiguousarray(self.table).tobytes()
        yield self.starts.tobytes() if isinstance(self.starts, np.ndarray) else repr(self.starts).encode()

    @property
    def is_described(self) -> bool:
        """Whether the machines are described machines."""
        return bool(self.machines) and isinstance(self.machines[0], MachineDescription)

    @property
    def given(self) -> tuple[Any, Any]:
        """Machines and starts in the form that the library reads."""
        # Copies: the library may not be able to read an array from another process in place.
        starts = (self.starts.scaled, self.starts.si) if isinstance(self.starts, Coordinates) else self.starts
        starts = np.array(starts, order="C") if isinstance(starts, np.ndarray) else starts
        if self.table is not None:
            return self.machines[0]._rows(self.names, np.array(self.table, order="C")), starts
        own = [m._described if isinstance(m, MachineDescription) else m._system for m in self.machines]
        return own, starts


@dataclasses.dataclass(frozen=True)
class _Work:
    """Motions with the results to compute."""

    motions: _Motions
    in_rows: bool

    def count(self) -> int:
        """Number of motions."""
        return self.motions.count()

    def part(self, begin: int, end: int) -> Any:
        """Returns the work of the motions from `begin` to `end`."""
        return dataclasses.replace(self, motions=self.motions.part(begin, end))

    def told(self) -> Iterator[bytes]:
        """Yields everything on which the rows depend, as bytes."""
        yield from self.motions.told()
        rest = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.name != "motions"}
        yield repr((type(self).__name__, rest)).encode()


@dataclasses.dataclass(frozen=True)
class _Measures(_Work):
    names: list[str]
    periods: int
    settle: int
    section: Union[None, float, str]

    def rows(self, report: Any) -> list[Any]:
        """Computes the row of each motion."""
        machines, starts = self.motions.given
        if not self.motions.is_described:
            return _native.paper_measure_many(machines, starts, of_paper(self.names), self.settle, self.periods, self.in_rows, report)
        return _native.measure_many(machines, starts, self.names, self.settle, self.periods, self.section, self.in_rows, report)


@dataclasses.dataclass(frozen=True)
class _EndsOf(_Work):
    until: float
    periods: int

    def rows(self, report: Any) -> list[Any]:
        """Computes the final numbers of each motion, or the reason why it has none."""
        machines, starts = self.motions.given
        if self.motions.is_described:
            values, reasons = _native.simulate_many(machines, starts, self.until, self.in_rows, report)
        else:
            with keeping(lambda _, one: (one, None)):
                s, v, reasons = _native.paper_simulate_many(machines, starts, self.periods, self.in_rows, report)
            values = np.concatenate([s, v], axis=1)
        return list(zip(values.tolist(), reasons))


@overload
def simulate_many(
    machines: Union[ParameterValues, Iterable[ParameterValues]],
    parameters: Optional[Mapping[str, ArrayLike]] = None,
    *,
    starts: Union[StartOfMachine, Sequence[StartOfMachine]] = None,
    periods: int = 400,
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
    **more: ArrayLike,
) -> PaperEnds: ...


@overload
def simulate_many(
    machines: Union[MachineDescription, Iterable[MachineDescription]],
    parameters: Optional[Mapping[str, ArrayLike]] = None,
    *,
    starts: Union[StartLike, Sequence[StartLike]] = None,
    until: float,
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
    **more: ArrayLike,
) -> Ends: ...


@overload
def simulate_many(
    machines: Union[MachineDescription, Iterable[MachineDescription]],
    parameters: None = None,
    *,
    starts: Union[StartLike, Sequence[StartLike]] = None,
    times: ArrayLike,
    derivatives: Iterable[str] = (),
    progress: bool = False,
) -> list[Run]: ...


def simulate_many(
    machines: Any,
    parameters: Optional[Mapping[str, ArrayLike]] = None,
    *,
    starts: Any = None,
    periods: Any = None,
    until: Any = None,
    times: Any = None,
    derivatives: Any = (),
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
    **more: ArrayLike,
) -> Any:
    """Simulates many motions on all cores: of :class:`PaperMachine` over drive periods from time 0, of :class:`Machine` until a time or at given times.

    ``simulate_many(damper, {"stop.steel.gap": gaps}, until=2.0)`` does not create a Python object for each machine.

    Motions of :class:`PaperMachine` are vectorised. Each is as accurate as :meth:`PaperMachine.simulate`, but not bit-identical to it. Their
    bits do not depend on the other motions or on the number of threads (docs/guarantees.md). Motions of :class:`Machine` are bit-identical
    to one :meth:`Machine.simulate` to the end; with `times`, each result is the :class:`Run` of :meth:`Machine.simulate`.

    Parameters
    ----------
    machines
        A machine, or machines of one class. Several described machines with `until` must have the same columns.
    parameters, **more
        Arrays of values of parameters of one machine, SI, broadcast against each other; the results have the broadcast shape.
    starts
        A start for all motions, as in `simulate`, or a sequence of starts; for :class:`PaperMachine` also an array of shape (n, 6).
    periods
        For :class:`PaperMachine`: number of drive periods of each motion's own machine; default 400.
    until
        For described machines: end time of the motions, in s or as a text with a unit.
    times, derivatives
        For described machines: as in :meth:`Machine.simulate`; returns a run for each motion.
    errors, executor, checkpoint
        As in :func:`measure_many`; cannot be combined with `times`.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As in :meth:`PaperMachine.simulate` and :meth:`Machine.simulate`, with the motion's index; if the numbers of machines and starts differ;
        if described machines have different columns.
    KeyboardInterrupt
        On Ctrl-C, with the final states found before it as its attribute ``partial``: a list with an array for each finished motion and None for each
        other. The array is the state, shape (6,), for :class:`PaperMachine`, and the values in the order of ``columns`` for described machines.
    """
    several, is_described = _listed(machines)
    given, shape = _arrays(several, merged(parameters, more, "parameters"))
    if until is not None or times is not None or is_described:
        if (until is None) == (times is None) or periods is not None:
            raise TypeError("a Machine requires `until` or `times`, and no `periods`; a PaperMachine takes only `periods`")
    if times is not None:
        if given or (errors, executor, checkpoint) != ("raise", None, None):
            raise TypeError("times: cannot be combined with arrays of parameters, errors, executor or checkpoint: use several machines, or until")
        return runs(_checked(several, MachineDescription), starts, times, derivatives, progress)
    if names_of(derivatives):
        raise TypeError("derivatives: requires described machines and `times`")
    in_rows = choice("errors", errors, ("raise", "row")) == "row"
    count = whole("periods", 400 if periods is None else periods, 0, MOST_PERIODS)
    motions = _motions(several, starts, given, is_described, "a motion over periods")
    end = after("until", seconds("until", until), max((time_of(begin) for begin in motions.starts), default=0.0)) if is_described else 0.0
    if is_described:
        _of_one_structure(motions.machines)
    work = _EndsOf(motions, in_rows, end, count)
    with keeping(lambda _, row: np.array(row[0])):
        rows = rows_of(work, executor, checkpoint, progress)
    width = len(several[0].columns) if several else 0
    values = np.array([numbers for numbers, _ in rows], dtype=np.float64).reshape(len(rows), width or 6)
    refused = np.array([reason is not None for _, reason in rows], dtype=bool)
    if refused.any():
        values = np.ma.MaskedArray(values, np.broadcast_to(refused[:, None], values.shape))
    shape = (len(rows),) if shape is None else shape
    values = values.reshape(*shape, values.shape[1])
    error = np.array([reason for _, reason in rows], dtype=object).reshape(shape) if in_rows else None
    if is_described:
        return Ends(end, several[0].columns, values, error)
    return PaperEnds(_times(motions, count).reshape(shape).copy(), values[..., :3].copy(), values[..., 3:].copy(), error)


def _times(motions: _Motions, periods: int) -> Floats:
    """Returns the end times of motions over periods, s."""
    if motions.table is None:
        return np.array([periods * m.period for m in motions.machines])
    base, names = motions.machines[0], motions.names or []
    if not any(base._changes_period(name) for name in names):
        return np.full(len(motions.table), periods * base.period)
    found = []
    for row in motions.table:
        try:
            found.append(periods * base.replace(dict(zip(names, row.tolist()))).period)
        except ValueError:
            found.append(0.0)  # the machine is invalid; its row reports why
    return np.array(found)


@overload
def measure_many(
    machines: Union[ParameterValues, Iterable[ParameterValues]],
    parameters: Union[Mapping[str, ArrayLike], Sequence[str]],
    measures: Optional[Sequence[str]] = None,
    *,
    starts: Union[StartOfMachine, Sequence[StartOfMachine]] = None,
    periods: int = 60,
    settle: int = 400,
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
) -> Table: ...


@overload
def measure_many(
    machines: Union[MachineDescription, Iterable[MachineDescription]],
    parameters: Union[Mapping[str, ArrayLike], Sequence[str]],
    measures: Optional[Sequence[str]] = None,
    *,
    starts: Union[StartLike, Sequence[StartLike]] = None,
    periods: int = 60,
    settle: int = 300,
    section: SectionLike = None,
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
) -> Table: ...


def measure_many(
    machines: Any,
    parameters: Union[Mapping[str, ArrayLike], Sequence[str]],
    measures: Optional[Sequence[str]] = None,
    *,
    starts: Any = None,
    periods: int = 60,
    settle: Optional[int] = None,
    section: SectionLike = None,
    errors: str = "raise",
    executor: Any = None,
    checkpoint: _Path = None,
    progress: bool = False,
) -> Table:
    """Returns measures of many settled motions, computed on all cores, bit-identical to :meth:`PaperMachine.measure` and :meth:`Machine.measure`.

    Each measure has its spread in :attr:`Table.spreads`, and in columns such as ``amplitude.box.s.spread``: two values of irregular motions
    differ if their difference exceeds twice their spreads. :attr:`Table.unsettled` names measures that had not settled.

    ``measure_many(damper, {"stop.steel.gap": gaps}, ["amplitude.box.s"])`` takes one machine with arrays of values and creates no Python object
    for each value; ``measure_many(machines, ["amplitude.box.s"])`` takes several machines.

    Parameters
    ----------
    machines
        A machine, or machines of one class.
    parameters
        Arrays of values of parameters of one machine, SI, broadcast against each other; the table has the broadcast shape. Omit it to measure the
        machines unchanged.
    measures
        Names of measures; `measures` of the machine lists all, with units.
    starts
        As in :func:`simulate_many`.
    periods, settle
        Measured periods, and earlier periods for the transient; the defaults are the same as for ``vibro sweep``.
    section
        For described machines, as in :meth:`Machine.measure`.
    errors
        ``"raise"``: a motion that is refused or cannot continue raises its exception. ``"row"``: the measures of such a motion are masked and the
        table's ``error`` has the reason; errors in arguments common to all motions are still raised.
    executor
        An object with ``submit``, such as an executor of ``concurrent.futures``, loky or mpi4py, or a Client of dask. It computes parts of the
        work in other processes, which need only this package. By default this process computes on all its cores.
    checkpoint
        A folder for finished parts: the same call continues there after Ctrl-C or a crash, and returns at once if all parts
        exist. A folder serves one call only; delete it when you no longer need it.

    Raises
    ------
    ValueError, TypeError, RuntimeError
        As in :meth:`PaperMachine.measure` and :meth:`Machine.measure`, with the motion's index; if the numbers of machines and starts differ.
    KeyboardInterrupt
        On Ctrl-C, with the measures found before it as its attribute ``partial``: a list with a dictionary for each finished motion and None for each
        other.
    """
    if measures is None:
        measures, parameters = parameters, {}  # type: ignore[assignment]
    return _measured(machines, parameters, measures, starts, periods, settle, section, errors, executor, checkpoint, progress)


def _measured(
    machines: Any,
    parameters: Any,
    measures: Any,
    starts: Any,
    periods: int,
    settle: Optional[int],
    section: SectionLike,
    errors: str,
    executor: Any,
    checkpoint: _Path,
    progress: bool,
    axes: Optional[tuple[str, ...]] = None,
) -> Table:
    several, is_described = _listed(machines)
    names = measure_names(measures)
    given, shape = _arrays(several, merged(parameters, {}, "parameters"))
    if section is not None and not is_described:
        raise TypeError("section: requires described machines; the paper's machine is sampled once in each drive period")
    in_rows = choice("errors", errors, ("raise", "row")) == "row"
    periods = whole("periods", periods, 1, MOST_PERIODS)
    settle = whole("settle", (300 if is_described else 400) if settle is None else settle, 0, MOST_PERIODS)
    motions = _motions(several, starts, given, is_described, "a measure")
    work = _Measures(motions, in_rows, names, periods, settle, section_of(section))

    def row(_: int, found: Any) -> dict[str, Any]:
        told: dict[str, Any] = measured(names, found)
        return {**told, "error": found[4]} if in_rows else told

    with keeping(row):
        rows = rows_of(work, executor, checkpoint, progress)
    known: dict[str, str] = {}
    if several:
        own = several[0]
        by_measure = {name: about.split(":", 1)[0] for name, about in own.measures.items()} if is_described else {n: MEASURES.get(own, ("",))[0] or "1" for n, own in zip(names, of_paper(names))}
        known = {**own.units, **by_measure}
    return table_of(given, names, rows, in_rows, known, (len(rows),) if shape is None else shape, axes)


def sweep_of(machine: AnyMachine, parameters: dict[str, Any], measures: Sequence[str], *, section: SectionLike = None, **options: Any) -> Table:
    """Returns the table of :meth:`PaperMachine.sweep` and :meth:`Machine.sweep`."""
    allowed = "a list or an array of shape (n,) of values"
    for name, values in parameters.items():
        if isinstance(values, str) or np.ndim(values) != 1:
            raise TypeError(f"{name}: expected {allowed}")
    own: Any = machine
    found = [array(name, own._in_si(name, values), allowed) for name, values in parameters.items()]
    grid = np.meshgrid(*found, indexing="ij") if found else []
    return _measured(machine, dict(zip(parameters, grid)), measures, section=section, axes=tuple(parameters), **options)


def _listed(machines: Any) -> tuple[list[Any], bool]:
    """Returns the machines as a list, and whether they are described machines."""
    several = list(machines) if isinstance(machines, Iterable) else [machines]
    is_described = bool(several) and isinstance(several[0], MachineDescription)
    return _checked(several, MachineDescription if is_described else ParameterValues), is_described


def _checked(several: list[Any], kind: type[AnyMachine]) -> list[Any]:
    for index, machine in enumerate(several):
        if not isinstance(machine, kind):
            allowed = "Machine" if kind is MachineDescription else "PaperMachine" if index else "Machine or PaperMachine"
            raise TypeError(f"machines[{index}] is of type {type(machine).__name__}: expected {allowed}")
    return several


def _arrays(several: list[Any], parameters: dict[str, Any]) -> tuple[dict[str, Floats], Optional[tuple[int, ...]]]:
    """Returns flattened arrays of values of one shape, and that shape."""
    if not parameters:
        return {}, None
    if len(several) != 1:
        raise TypeError(f"arrays of parameters with {len(several)} machines: expected one machine, or several without arrays")
    found = []
    for name, given in parameters.items():
        values = several[0]._in_si(name, given)
        found.append(array(name, values, "an array of values in SI, or a list of texts with units", None))
    try:
        same = np.broadcast_arrays(*found)
    except ValueError:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in zip(parameters, found))
        raise ValueError(f"{shapes}: expected arrays that can be broadcast together") from None
    return {name: values.reshape(-1).copy() for name, values in zip(parameters, same)}, same[0].shape


def _of_one_structure(machines: list[MachineDescription]) -> None:
    columns = machines[0].columns
    for index, machine in enumerate(machines):
        if machine.columns != columns:
            raise ValueError(f"machines[{index}] has the columns {machine.columns}: expected the columns of machines[0], {columns}")


def _motions(several: list[Any], starts: Any, given: dict[str, Floats], is_described: bool, what: str) -> _Motions:
    """Pairs each machine with its start, or all machines with one start."""
    if not given:
        if is_described:
            return _Motions(*starts_of(several, starts))
        return _Motions(*pairs(several, starts, what))
    names, table = list(given), np.stack(list(given.values()), axis=1)
    several[0]._rows(names, table[:1])  # raises for unknown names
    if is_described:
        one = starts is None or isinstance(starts, (Mapping, str, os.PathLike))
        begins: Any = [numbers_of(several[0], start, "starts") for start in ([starts] if one else listed_starts(starts))]
    elif isinstance(starts, np.ndarray) and starts.ndim == 2:
        begins = states(starts)
    elif (own := several_of(starts)) is not None:
        begins = states_of_rows(several[0], names, table, own)
    else:
        begins = coordinates("starts", starts)
        state("starts", starts, several[0]._system)  # raises if a start has a time
    if not isinstance(begins, Coordinates) and len(begins) not in (len(table), 1 if is_described else len(table)):
        raise ValueError(f"starts has {len(begins)} rows: expected one start, or one for each of {len(table)} motions")
    return _Motions(several, begins, names, table)
