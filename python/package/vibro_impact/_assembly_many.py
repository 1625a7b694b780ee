"""Many motions of machines of your own at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, number, whole
from ._assembly_description import AssemblyDescription
from ._assembly_results import AssemblyEnds
from ._measures import keeping, rows
from ._progress import Bar

#: Section of a motion: a period in s, or the name of a stop or friction.
Section = Union[None, float, str]


def ends(machines: list[AssemblyDescription], until: object, progress: bool) -> AssemblyEnds:
    """The ends of assemblies' motions, for :func:`simulate_many`."""
    end = positive("until", until)
    columns = machines[0].columns if machines else []
    for index, machine in enumerate(machines):
        if machine.columns != columns:
            raise ValueError(f"machines[{index}] has the columns {machine.columns}: allowed are those of machines[0], {columns}")
    with Bar(progress, len(machines), "motions") as bar:
        with keeping(np.array):
            values = _native.simulate_assemblies([m._described for m in machines], end, bar.report)
    return AssemblyEnds(end, columns, values)


def measures_of(
    machines: list[AssemblyDescription], measures: Sequence[str], periods: int, settle: int, section: Section, errors: str, progress: bool
) -> list[dict[str, float | str | None]]:
    """Measures of assemblies' settled motions, for :func:`measure_many`."""
    if isinstance(measures, str):
        raise TypeError(f"measures = {measures!r}: allowed is a sequence of names")
    names = list(measures)
    periods = whole("periods", periods, 1, MOST_PERIODS)
    settle = whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, len(machines), "motions") as bar:
        described, at = [m._described for m in machines], section_of(section)
        return rows(names, errors, lambda told: _native.measure_assemblies(described, names, settle, periods, at, told, bar.report))


def section_of(section: Section) -> Union[None, float, str]:
    """The section as the library reads it."""
    return section if section is None or isinstance(section, str) else positive("section", section)


def positive(name: str, value: object) -> float:
    """A number above 0."""
    found = number(name, value)
    if not found > 0:
        raise ValueError(f"{name} = {value!r}: allowed is a finite number above 0")
    return found
