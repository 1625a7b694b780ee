"""Many motions of machines of your own at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, Floats, array, number, whole
from ._assembly_description import AssemblyDescription
from ._assembly_results import AssemblyEnds, AssemblyRun, run_of
from ._assembly_start import starts_of, time_of
from ._measures import keeping, rows
from ._progress import Bar

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: Section of a motion: a period in s, or the name of a stop or friction.
Section = Union[None, float, str]


def runs(
    machines: list[AssemblyDescription], starts: Any, times: ArrayLike, derivatives: Iterable[str], progress: bool
) -> list[AssemblyRun]:
    """Assemblies' motions at instants, for :func:`simulate_many`."""
    machines, begins = starts_of(machines, starts)
    t, parameters = instants(times, max((time_of(begin) for begin in begins), default=0.0)), names_of(derivatives)

    def run(index: int, found: dict[str, Any]) -> AssemblyRun:
        return run_of(machines[index], t, found, parameters)

    described = [m._described for m in machines]
    with Bar(progress, len(machines), "motions") as bar, keeping(run):
        found = _native.follow_assemblies(described, begins, t, parameters, bar.report)
    return [run(index, one) for index, one in enumerate(found)]


def instants(times: ArrayLike, begin: float) -> Floats:
    """Ascending times from that of a start on."""
    t: Floats = array("times", times, "an array of shape (n,) of times in s").copy()
    if len(t) == 0 or not (np.diff(t) >= 0).all() or not t[0] >= begin or not np.isfinite(t).all():
        raise ValueError(f"times: allowed are ascending finite times from {begin:g} on")
    return t


def names_of(parameters: Iterable[str]) -> list[str]:
    """Names of parameters, each once."""
    if isinstance(parameters, str):
        raise TypeError(f"derivatives = {parameters!r}: allowed is a list of names of parameters")
    names = list(parameters)
    for i, name in enumerate(names):
        if not isinstance(name, str):
            raise TypeError(f"derivatives = {name!r}: allowed are names of parameters")
        if name in names[:i]:
            raise ValueError(f"derivatives: {name} stands there twice; allowed is each parameter once")
    return names


def ends(machines: list[AssemblyDescription], starts: Any, until: object, progress: bool) -> AssemblyEnds:
    """The ends of assemblies' motions, for :func:`simulate_many`."""
    machines, begins = starts_of(machines, starts)
    end = after("until", until, max((time_of(begin) for begin in begins), default=0.0))
    columns = machines[0].columns if machines else []
    for index, machine in enumerate(machines):
        if machine.columns != columns:
            raise ValueError(f"machines[{index}] has the columns {machine.columns}: allowed are those of machines[0], {columns}")
    with Bar(progress, len(machines), "motions") as bar:
        with keeping(lambda _, one: np.array(one)):
            values = _native.simulate_assemblies([m._described for m in machines], begins, end, bar.report)
    return AssemblyEnds(end, columns, values)


def measures_of(
    machines: list[AssemblyDescription],
    starts: Any,
    measures: Sequence[str],
    periods: int,
    settle: int,
    section: Section,
    errors: str,
    progress: bool,
) -> list[dict[str, float | str | None]]:
    """Measures of assemblies' settled motions, for :func:`measure_many`."""
    if isinstance(measures, str):
        raise TypeError(f"measures = {measures!r}: allowed is a sequence of names")
    names = list(measures)
    machines, begins = starts_of(machines, starts)
    periods = whole("periods", periods, 1, MOST_PERIODS)
    settle = whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, len(machines), "motions") as bar:
        described, at = [m._described for m in machines], section_of(section)
        return rows(names, errors, lambda told: _native.measure_assemblies(described, begins, names, settle, periods, at, told, bar.report))


def section_of(section: Section) -> Union[None, float, str]:
    """The section as the library reads it."""
    return section if section is None or isinstance(section, str) else positive("section", section)


def positive(name: str, value: object) -> float:
    """A number above 0."""
    return after(name, value, 0.0)


def after(name: str, value: object, begin: float) -> float:
    """A number above another."""
    found = number(name, value)
    if not found > begin:
        raise ValueError(f"{name} = {value!r}: allowed is a finite number above {begin:g}")
    return found
