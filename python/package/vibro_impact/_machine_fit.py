"""Fits of machines of your own to records."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import Floats, array, number, quantity, seconds, whole
from ._machine_description import MachineDescription
from ._machine_start import StartLike, numbers_of
from ._base import AnyMachine
from ._paper_parameters import SI_NAMES, outside
from ._progress import Bar, partial
from ._start import Start
from ._show import Line, lines
from ._result import Result
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._base import RecordLike

_LOSSES = ("linear", "soft_l1", "huber")


@dataclasses.dataclass(frozen=True)
class Segment:
    """Initial state of a segment of a fitted motion."""

    time: float
    "Time of the record, s."
    state: dict[str, float]
    "State by name, SI."
    defect: dict[str, float]
    "End of the previous segment minus this state, by name, SI."


@dataclasses.dataclass(frozen=True)
class Suspect:
    """A parameter that is not free, and that would reduce the residuals of a fit with another value."""

    name: str
    "Name of the parameter, or a description of friction that the machine does not have."
    value: float
    "Value in the machine, SI."
    better: float
    "Value that fits best together with the free parameters, SI."
    left: float
    "Ratio of the root mean square residuals with this value and without it."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """A machine of your own fitted to a record; all numbers in SI."""

    verdict: str
    "``fits``; or ``does not fit: …`` or ``undecided: …`` with the reason. Errors are valid only with ``fits``."
    machine: AnyMachine
    "The machine with the fitted parameters."
    start: Start
    "Start of the motion; empty for the machine's own start."
    values: dict[str, float]
    "Fitted parameters by name."
    errors: dict[str, Optional[float]]
    "Standard error of each parameter; None if the record does not determine it."
    white_errors: dict[str, Optional[float]]
    "Standard error of each parameter for white residuals."
    correlation: Floats
    "Correlations of the parameters, shape (n, n); 0 for an undetermined parameter."
    undetermined: list[dict[str, float]]
    "Undetermined combinations of relative parameter changes, by name."
    rms: dict[str, float]
    "Root mean square residual of each column, and of each stop's contact times."
    t: Floats
    "Times of the record, shape (m,), s."
    residuals: dict[str, Floats]
    "Fitted motion minus record for each column, shape (m,)."
    contacts: dict[str, Floats]
    "Contact times of the fitted motion minus the recorded ones for each stop, s; NaN if the motion does not have the contact."
    simulations: int
    "Number of simulations."
    near_until: float
    "End of the agreement between the fitted motion and the record, s; the last time if they always agree."
    persistence: float
    "Correlation of successive residuals within a column, over all columns."
    segments: list[Segment]
    "Segments after the first, each with its own initial state; empty for a single motion."
    lost: list[str]
    "Reasons why derivatives cease to exist at some time; finite differences replace them."
    at_bounds: dict[str, float]
    "Parameters at an end of their range, with that end; their errors are one-sided."
    places: list[str]
    "Concentrations of residuals: in time, in the phase of the period, after contacts. Empty if residuals are noise."
    suspects: list[Suspect]
    "Parameters that are not free and would reduce the residuals, the best first. Empty if residuals are noise."

    def _picture(self) -> str:
        some = [Line(self.t, found, name, colour=k) for k, (name, found) in enumerate(list(self.residuals.items())[:4])]
        return lines(some, "time (s)", "fitted motion minus record, SI")


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperFit(Fit):
    """A :class:`PaperMachine` fitted to a record."""

    machine: AnyMachine
    "The machine with the fitted parameters."
    twin: AnyMachine
    "The fitted machine as a :class:`Machine`; columns and starts of this result use its names."


def _table(path: Union[str, os.PathLike[str]], machine: MachineDescription, names: Mapping[str, str]) -> dict[str, tuple[Floats, Floats]]:
    """The columns of a table in SI, with its times; `names` maps other names to the machine's columns."""
    with open(path, newline="", encoding="utf-8") as file:
        text = file.read()
    try:
        found = _native.columns_of_table(machine._described, text, dict(names))
    except ValueError as problem:
        raise ValueError(f"{path}: {problem}") from None
    columns = {name: np.array(values) for name, values in found}
    if "time" not in columns or len(columns) < len(found):
        first = ",".join(name for name, _ in found)
        raise ValueError(f"{path}: its first line names {first[:200]!r}; expected 'time' and columns such as 'box.s', each once")
    t = columns.pop("time")
    return {name: (t, values) for name, values in columns.items()}


def _record(record: RecordLike, machine: MachineDescription) -> tuple[Floats, list[tuple[str, Floats]]]:
    """The times and the columns of a record of a machine."""
    if isinstance(record, (str, os.PathLike)):
        record = _table(record, machine, {})
    if not isinstance(record, Mapping):
        allowed = "a dictionary such as {'box.s': (t, s)}, or the path of a table"
        raise TypeError(f"record is of type {type(record).__name__}: expected {allowed}")
    t: Optional[Floats] = None
    columns = []
    for name, pair in record.items():
        if not isinstance(name, str) or not isinstance(pair, tuple) or len(pair) != 2:
            raise TypeError(f"record[{name!r}]: expected a name such as 'box.s' with a pair of times and values")
        times, values = (array(f"record[{name!r}][{k}]", part, "an array of shape (n,)") for k, part in enumerate(pair))
        if times.shape != values.shape:
            raise ValueError(f"record[{name!r}] has shapes {times.shape} and {values.shape}: expected two arrays of the same length")
        if t is not None and not np.array_equal(t, times):
            raise ValueError(f"record[{name!r}] has other times than the previous column: expected the same times in all columns")
        t = times
        columns.append((name, values))
    return np.empty(0) if t is None else t, columns


# File of the same machine, in terms of the parameters of `PaperMachine`.
_TWIN = """
name = "Machine"
body.box = {{ mass = "= box_m" }}
body.block = {{ mass = "= block_m" }}
body.secondary = {{ mass = "= secondary_m" }}
spring.mount = {{ between = ["ground", "box"], stiffness = "= box_k", damping = "= box_c" }}
spring.secondary_mount = {{ between = ["ground", "secondary"], stiffness = "= secondary_k", damping = "= secondary_c" }}
spring.coupling = {{ between = ["block", "secondary"], stiffness = "= coupling_k" }}
stop.upper = {{ between = ["box", "block"], gap = "= stop_gap", restitution = "= stop_restitution" }}
stop.lower = {{ between = ["block", "box"], gap = "= stop_gap", restitution = "= stop_restitution" }}
load.drive = {{ on = "box", amplitude = "= drive_amplitude", frequency = "= drive_frequency / (2*pi)", phase = "= drive_phase" }}
load.box = {{ on = "box", constant = "= load_box" }}
load.block = {{ on = "block", constant = "= load_block" }}
load.secondary = {{ on = "secondary", constant = "= load_secondary" }}
[parameters]
{parameters}
"""


def _twin(machine: ParameterValues) -> MachineDescription:
    """The machine of the 3-DOF core as a machine of bodies and elements, with its parameter values."""
    text = _TWIN.format(parameters="\n".join(f"{name} = {getattr(machine, name)!r}" for name in SI_NAMES))
    found: MachineDescription = machine._described_by(text)
    return found


def _fit_machine(machine: ParameterValues, record: RecordLike, free: Iterable[str], start: Any, arguments: dict[str, Any]) -> PaperFit:
    """Fit the twin, with the parameter names of the paper's machine."""
    from ._arguments import state

    names = [free] if isinstance(free, str) else list(free)
    unknown = [name for name in names if name not in SI_NAMES and not name.startswith(("start.", "record."))]
    if unknown:
        allowed = "expected one of its physical parameters (SI_NAMES), start.BODY.s, start.BODY.v, record.shift or record.offset.COLUMN"
        raise ValueError(f"free: {unknown[0]!r} of a PaperMachine cannot be fitted: {allowed}")
    if start is None or isinstance(start, Mapping) and not any(str(name).endswith((".s", ".v")) for name in start):
        values = np.asarray(state("start", start, machine._system), dtype=np.float64)
        bodies = ("box", "block", "secondary")
        start = {f"{body}.{what}": float(values[3 * k + i]) for k, what in enumerate("sv") for i, body in enumerate(bodies)}
    dotted = {f"{body}_{what}": f"{body}.{what}" for body in ("box", "block", "secondary") for what in "sv"}
    twin = _twin(machine)
    record = _table(record, twin, dotted) if isinstance(record, (str, os.PathLike)) else record
    columns = {dotted.get(name, name): pair for name, pair in record.items()}

    def made(found: Fit) -> PaperFit:
        fitted = {name: value for name, value in found.values.items() if name in SI_NAMES}
        parts = {field.name: getattr(found, field.name) for field in dataclasses.fields(found)}
        return PaperFit(**{**parts, "machine": machine.replace(**fitted), "twin": found.machine})

    with partial(made):
        return made(fit(twin, columns, free=names, start=start, **arguments))


def fit(
    machine: AnyMachine,
    record: RecordLike,
    *,
    free: Iterable[str],
    within: Optional[Mapping[str, tuple[Union[float, str], Union[float, str]]]] = None,
    events: Optional[Mapping[str, ArrayLike]] = None,
    sigma: Optional[Mapping[str, Union[float, str]]] = None,
    filter: Optional[Mapping[str, tuple[int, Union[float, str]]]] = None,
    loss: str = "linear",
    segments: Union[str, float] = "auto",
    starts: int = 0,
    start: StartLike = None,
    progress: bool = False,
) -> Fit:
    """Fit parameters of a machine to a record, with their standard errors: ``vibro fit FILE``.

    A :class:`PaperMachine` is fitted as the same machine of bodies and elements. `free` names its physical parameters. Columns are called ``box.s``
    or ``box_s`` and so on, stops ``upper`` and ``lower``; `start` is as in :meth:`PaperMachine.simulate`. The result is a :class:`PaperFit`.

    >>> import vibro_impact as vi
    >>> slide = vi.Machine({
    ...     "name": "Slide", "body": {"a": {"mass": 1.0, "start": {"s": 0.001}}},
    ...     "spring": {"k": {"between": ["ground", "a"], "stiffness": 1e4}},
    ... })
    >>> run = slide.simulate(until=0.2)
    >>> found = vi.fit(slide.replace({"spring.k.stiffness": 9e3}), {"a.s": (run.t, run["a.s"])}, free=["spring.k.stiffness"])
    >>> abs(found.values["spring.k.stiffness"] - 1e4) < 1e-3
    True

    Parameters
    ----------
    machine
        Machine with the initial parameter values.
    record
        Times (s) and values (SI) for each column, for example ``box.s``; all columns have the same times. Or the path of a table (CSV) whose
        first line names ``time`` and columns, like ``--data`` of the command line; it may name units, for example ``box.s [mm]``.
    free
        Names of the free parameters: parameters of the machine or the start, ``record.shift``, ``record.offset.COLUMN``.
    within
        Smallest and largest value of a free parameter, in SI or as texts with units.
    events
        Times of the impacts or first touches of each stop, s.
    sigma
        Standard deviation of the noise of each column, in SI or as a text with a unit, and of the times of ``events`` as ``"contacts"``.
        Without it, the residuals determine the standard deviation.
    filter
        Order and corner frequency (Hz, or a text with a unit) of the Butterworth low-pass filter of a column's sensor: ``{"box.a": (2, 400.0)}``.
        A column of accelerations requires one.
    loss
        Loss function of the residuals: ``linear``, ``soft_l1`` or ``huber``.
    segments
        Division of the motion into segments with their own initial states: ``"auto"``, ``"none"``, or a length in s. ``"auto"`` divides the motion if
        it cannot be fitted as a whole, for example if it is chaotic.
    starts
        Number of further initial guesses, spread over ``within``.
    start
        Start of the motion, as in :meth:`Machine.simulate`; by default the machine's own start. The default start of a :class:`PaperMachine` is
        in units of its initial gap.
    progress
        Whether to show a progress bar, with the stage, the least cost so far, and the number of simulations.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C. Its attribute ``partial`` has the best values so far: a :class:`Fit` with the verdict ``undecided: ended by hand …``, or
        None if running simulations do not end within 10 s, or at a second Ctrl-C.
    ValueError, TypeError
        For arguments out of their range, unknown names, and records that are empty or not finite.
    RuntimeError
        If no motion of the machine covers the record.
    """
    if isinstance(machine, ParameterValues):
        arguments = {"within": within, "events": events, "sigma": sigma, "filter": filter, "loss": loss, "segments": segments, "starts": starts}
        return _fit_machine(machine, record, free, start, {**arguments, "progress": progress})
    with partial(lambda found: found[0]):
        return fit_records(
            [machine],  # type: ignore[list-item]  # its type is checked there
            [record],
            free=free,
            within=within,
            events=[events],
            sigma=[sigma],
            filter=filter,
            loss=loss,
            segments=segments,
            starts=starts,
            start=[start],
            progress=progress,
        )[0]


def fit_records(
    machines: Sequence[MachineDescription],
    records: Sequence[RecordLike],
    *,
    free: Iterable[str] = (),
    own: Iterable[str] = (),
    within: Optional[Mapping[str, tuple[Union[float, str], Union[float, str]]]] = None,
    events: Optional[Sequence[Optional[Mapping[str, ArrayLike]]]] = None,
    sigma: Optional[Sequence[Optional[Mapping[str, Union[float, str]]]]] = None,
    filter: Optional[Mapping[str, tuple[int, Union[float, str]]]] = None,
    loss: str = "linear",
    segments: Union[str, float] = "auto",
    starts: int = 0,
    start: Optional[Sequence[StartLike]] = None,
    progress: bool = False,
) -> list[Fit]:
    """Fit parameters of a machine to several records together: ``vibro fit FILE --data a.csv,b.csv``.

    Returns a :class:`Fit` for each record, with its free parameters. Values, errors and verdicts are from all records together.

    >>> import vibro_impact as vi
    >>> slide = vi.Machine({
    ...     "name": "Slide", "body": {"a": {"mass": 1.0, "start": {"s": 0.001}}},
    ...     "spring": {"k": {"between": ["ground", "a"], "stiffness": 1e4}},
    ... })
    >>> heavy = slide.replace({"body.a.mass": 4.0})
    >>> runs = [machine.simulate(until=0.2) for machine in (slide, heavy)]
    >>> off = [machine.replace({"spring.k.stiffness": 9e3}) for machine in (slide, heavy)]
    >>> found = vi.fit_records(off, [{"a.s": (run.t, run["a.s"])} for run in runs], free=["spring.k.stiffness"], own=["body.a.start.s"])
    >>> [abs(one.values["spring.k.stiffness"] - 1e4) < 1e-3 for one in found]
    [True, True]

    Parameters
    ----------
    machines
        Machine of each record, with the initial parameter values. The machines may differ in all parameters except those in `free`.
    records
        Records, each as in :func:`fit`.
    free
        Free parameters that all records share.
    own
        Free parameters that have a separate value for each record, for example ``body.a.start.v``. ``record.shift`` and ``record.offset.COLUMN``
        always belong to one record.
    events, sigma, start
        As in :func:`fit`, one for each record.
    within, filter, loss, segments, starts, progress
        As in :func:`fit`.

    Raises
    ------
    KeyboardInterrupt, ValueError, TypeError, RuntimeError
        As :func:`fit`, with a list as `partial`. Also ValueError for a shared parameter with different initial values.
    """
    shared, single = ([names] if isinstance(names, str) else list(names) for names in (free, own))
    names = shared + single
    for one in machines:
        if not isinstance(one, MachineDescription):
            raise TypeError(f"machine is of type {type(one).__name__}: expected Machine or PaperMachine")
    count = len(records)
    for what, each in (("machines", machines), ("events", events), ("sigma", sigma), ("start", start)):
        if each is not None and len(each) != count:
            raise ValueError(f"{what} has {len(each)} entries for {count} records; expected one for each record")
    if not count:
        raise ValueError("records is empty; expected at least one record")
    unknown = [name for name in within or {} if name not in names]
    if unknown:
        raise ValueError(f"within: {unknown[0]!r} is not free: expected one of {', '.join(names)}")
    ranges = {name: _range(machines[0], name, ends) for name, ends in (within or {}).items()}
    if loss not in _LOSSES:
        raise ValueError(f"loss = {loss!r}: expected one of {', '.join(_LOSSES)}")
    given = []
    for k, (machine, record) in enumerate(zip(machines, records)):
        t, columns = _record(record, machine)
        contacts = _contacts(events[k] if events else None)
        deviations = _sigma(machine, sigma[k] if sigma else None, [name for name, _ in columns] + (["contacts"] if contacts else []))
        begin = numbers_of(machine, start[k] if start else None)
        given.append((machine._described, begin, t, columns, contacts, deviations))

    def made(found: list[dict[str, Any]]) -> list[Fit]:
        of = zip(machines, given, found)
        return [_fitted(type(machine), names, t, [name for name, _ in columns], one) for machine, (_, _, t, columns, _, _), one in of]

    with Bar(progress, 1000, "‰") as bar, partial(made):
        found = _native.fit(
            given,
            [(name, ranges.get(name), name in single) for name in names],
            [_filter(column, one) for column, one in (filter or {}).items()],
            loss,
            _length(segments),
            whole("starts", starts, 0, 10_000),
            bar.report,
        )
    return made(found)


def _contacts(events: Optional[Mapping[str, ArrayLike]]) -> list[tuple[str, list[float]]]:
    """Contact times of each stop, s."""
    if events is not None and not isinstance(events, Mapping):
        raise TypeError(f"events is of type {type(events).__name__}: expected a dictionary of times by stop, such as {{'wall': [0.12, 0.31]}}")
    return [(stop, array(f"events[{stop!r}]", times, "an array of shape (n,) of times in s").tolist()) for stop, times in (events or {}).items()]


def _range(machine: MachineDescription, name: str, ends: Any) -> tuple[float, float]:
    """Range of a free parameter, SI."""
    if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
        raise TypeError(f"within: {name} = {ends!r}: expected a pair of its smallest and largest value, in SI or as texts with units")
    return _bound(machine, name, ends[0]), _bound(machine, name, ends[1])


def _bound(machine: MachineDescription, name: str, value: Union[float, str]) -> float:
    """End of the range of a free parameter, SI."""
    if not isinstance(value, str):
        return number("within", value)
    if name == "record.shift":
        return float(seconds(f"within: {name}", value))
    if name.startswith("start."):
        own = name.removeprefix("start.")
        return dict(numbers_of(machine, {own: value}))[own]
    if name.startswith("record."):
        raise TypeError(f"within: {name} = {value!r}: expected a number in the unit of the record's column")
    return number("within", machine._in_si(name, value))


def _filter(column: str, own: Any) -> tuple[str, int, float]:
    """Column, order and corner frequency (Hz) of a sensor's filter."""
    if isinstance(own, str) or not isinstance(own, Sequence) or len(own) != 2:
        raise TypeError(f"filter: {column} = {own!r}: expected a pair of order and corner frequency, such as (2, 400.0)")
    name = f"filter: {column}"
    frequency = quantity(name, "Hz", own[1]) if isinstance(own[1], str) else number(name, own[1])
    return column, whole(name, own[0], 1, 8), frequency


def _length(segments: Union[str, float]) -> Optional[float]:
    """Length of segments, s: None for ``auto``, 0 for ``none``."""
    if isinstance(segments, str):
        if segments not in ("auto", "none"):
            raise ValueError(f"segments = {segments!r}: expected 'auto', 'none' or a length in s")
        return None if segments == "auto" else 0.0
    length = number("segments", segments)
    if not length > 0:
        raise ValueError(f"segments = {segments!r}: must be greater than 0 s")
    return length


def _sigma(machine: MachineDescription, sigma: Optional[Mapping[str, Union[float, str]]], names: list[str]) -> Optional[list[float]]:
    if sigma is None:
        return None
    missing: Union[set[str], Any] = set(names) ^ set(sigma)
    if missing:
        raise ValueError(f"sigma: {sorted(missing)[0]!r} is missing or is not a column: expected exactly {', '.join(names)}")
    found = []
    for name in names:
        value, unit = sigma[name], "s" if name == "contacts" else machine.measures.get(f"maximum.{name}", "1").split(":")[0]
        own = quantity(f"sigma[{name!r}]", unit, value) if isinstance(value, str) else number(f"sigma[{name!r}]", value)
        if not own > 0.0:
            raise ValueError(f"sigma[{name!r}] = {value!r}: expected a finite number > 0")
        found.append(own)
    return found


def _fitted(kind: type[MachineDescription], names: list[str], t: Floats, columns: list[str], found: dict[str, Any]) -> Fit:
    if found["unexplained"]:
        warnings.warn(f"no explanation of the residuals: {found['unexplained']}", RuntimeWarning, stacklevel=outside())
    return Fit(
        verdict=found["verdict"],
        machine=kind(found["machine"]),
        start=Start(dict(found["start"])),
        values=dict(zip(names, found["values"])),
        errors=dict(zip(names, found["errors"])),
        white_errors=dict(zip(names, found["white_errors"])),
        correlation=np.array(found["correlation"]),
        undetermined=[dict(parts) for parts, _ in found["undetermined"]],
        rms=dict(found["rms"]),
        t=t,
        residuals=dict(zip(columns, found["residuals"])),
        contacts={stop: np.array(times) for stop, times in found["contacts"]},
        simulations=found["simulations"],
        near_until=found["near_until"],
        persistence=found["persistence"],
        segments=[Segment(time, dict(state), dict(zip([name for name, _ in state], defect))) for time, state, defect in found["segments"]],
        lost=found["lost"],
        at_bounds=dict(found["at_bounds"]),
        places=found["places"],
        suspects=[Suspect(*own) for own in found["suspects"]],
    )
