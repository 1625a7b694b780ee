"""Starts of machines of your own."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Union

from ._arguments import number
from ._machine_description import is_number

if TYPE_CHECKING:
    from ._machine_description import MachineDescription


#: A start: numbers by name, in SI or as texts with units, or the path of a start's file; None for the machine's own start.
StartLike = Union[None, Mapping[str, Union[float, str]], str, os.PathLike[str]]

#: Names and numbers of a start, SI; empty for the machine's own start.
Numbers = list[tuple[str, float]]


def numbers_of(machine: MachineDescription, start: StartLike, name: str = "start") -> Numbers:
    """Returns the names and numbers of a start of a machine."""
    if start is None:
        return []
    if isinstance(start, Mapping):
        return machine._described.start([], [(of, _value(of, value)) for of, value in start.items()])
    if isinstance(start, (str, os.PathLike)):
        return machine._described.read_start(os.fspath(start))
    raise TypeError(f"{name} is of type {type(start).__name__}: expected numbers by name, or the path of a start file")


def _value(name: str, value: Union[float, str]) -> Union[float, str]:
    if not isinstance(name, str):
        raise TypeError(f"start: {name!r} is not a name; expected a name such as time, box.s, box.v")
    if not isinstance(value, str):
        return number(name, value)
    if is_number(value):
        raise ValueError(f"{name} = {value!r}: expected a number in SI, or a text with a unit")
    return value


def time_of(numbers: Numbers) -> float:
    """Returns the time of a start, s."""
    return dict(numbers).get("time", 0.0)


def listed_starts(starts: Any) -> list[Any]:
    """Returns the starts of a nonempty sequence."""
    if isinstance(starts, (str, os.PathLike)) or not isinstance(starts, Iterable):
        raise TypeError(f"starts is of type {type(starts).__name__}: expected a start, or a sequence with one start for each motion")
    several = list(starts)
    if not several:
        raise ValueError("starts is empty: expected a start, or a sequence with one start for each motion")
    return several


def starts_of(machines: list[MachineDescription], starts: Any) -> tuple[list[MachineDescription], list[Numbers]]:
    """Returns a machine and a start for each motion; one start serves all machines, one machine serves any number of starts."""
    if starts is None or isinstance(starts, (Mapping, str, os.PathLike)):
        return machines, [numbers_of(machine, starts, "starts") for machine in machines]
    several = listed_starts(starts)
    if len(machines) == 1:
        machines = machines * len(several)
    if len(machines) != len(several):
        raise ValueError(f"starts has {len(several)} starts: expected one start, or one for each of {len(machines)} machines")
    return machines, [numbers_of(machine, start, f"starts[{i}]") for i, (machine, start) in enumerate(zip(machines, several))]
