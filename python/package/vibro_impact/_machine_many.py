"""Many motions of machines of your own at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Union

from . import _native
from ._arguments import MOST_PERIODS, whole
from ._machine_description import MachineDescription
from ._machine_results import Run, run_of
from ._machine_start import StartLike, numbers_of, starts_of, time_of
from ._instants import after, listed
from ._measures import Measures, keeping, measure_names, measured
from ._progress import Bar

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: Section of a motion: a period in s, or the name of a stop or friction element.
SectionLike = Union[None, float, str]


def runs(
    machines: list[MachineDescription], starts: Any, times: ArrayLike, derivatives: Iterable[str], progress: bool
) -> list[Run]:
    """Returns the motions of described machines at given times, for :func:`simulate_many`."""
    machines, begins = starts_of(machines, starts)
    t, parameters = listed(times, max((time_of(begin) for begin in begins), default=0.0)), names_of(derivatives)

    def run(index: int, found: dict[str, Any]) -> Run:
        return run_of(machines[index], t, found, parameters)

    described = [m._described for m in machines]
    with Bar(progress, len(machines), "motions") as bar, keeping(run):
        found = _native.follow_many(described, begins, t, parameters, bar.report)
    return [run(index, one) for index, one in enumerate(found)]


def names_of(parameters: Iterable[str]) -> list[str]:
    """Returns names of parameters; raises for duplicates."""
    if isinstance(parameters, str):
        raise TypeError(f"derivatives = {parameters!r}: expected a list of parameter names")
    names = list(parameters)
    for i, name in enumerate(names):
        if not isinstance(name, str):
            raise TypeError(f"derivatives = {name!r}: expected the name of a parameter")
        if name in names[:i]:
            raise ValueError(f"derivatives: {name} is given twice; expected each parameter once")
    return names


def measures_of(
    machine: MachineDescription,
    measures: Sequence[str],
    start: StartLike,
    periods: int,
    settle: int,
    section: SectionLike,
    progress: bool,
) -> Measures:
    """Returns measures of a described machine's settled motion."""
    names = measure_names(measures)
    periods, settle = whole("periods", periods, 1, MOST_PERIODS), whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, 1, "motions") as bar:
        begin, at = [numbers_of(machine, start)], section_of(section)
        (row,) = _native.measure_many([machine._described], begin, names, settle, periods, at, False, bar.report)
    return measured(names, row)


def section_of(section: SectionLike) -> Union[None, float, str]:
    """Returns the section in the form that the library reads."""
    return section if section is None or isinstance(section, str) else positive("section", section)


def positive(name: str, value: object) -> float:
    """Returns `value` as a number greater than 0."""
    return after(name, value, 0.0)
