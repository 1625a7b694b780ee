"""Starts of many motions of the paper's machine."""

from __future__ import annotations

import numbers
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np

from ._arguments import Floats, array, state
from ._machine_start import listed_starts
from ._paper_values import ParameterValues


def pairs(several: list[ParameterValues], starts: Any, what: str) -> tuple[list[ParameterValues], Floats]:
    """Returns a machine and a start for each motion."""
    rows = _rows(several, starts)
    if len(several) == 1:
        several = several * len(rows)
    if len(rows) != len(several):
        raise ValueError(f"starts has {len(rows)} rows: expected one start, or one for each of {len(several)} machines")
    for index, machine in enumerate(several):
        try:
            machine._needs_period(what)
        except ValueError as error:
            raise ValueError(f"machines[{index}]: {error}") from None
    return several, rows


def states(starts: Any) -> Floats:
    """Returns starts given as an array of shape (n, 6)."""
    found = array("starts", starts, "an array of shape (n, 6)", 2)
    if found.shape[1] != 6:
        raise ValueError(f"starts has the shape {found.shape}: expected (n, 6)")
    return found


def several_of(starts: Any) -> Optional[list[Any]]:
    """Returns the starts of a sequence; None if `starts` is a single start: None, numbers by name, or six numbers."""
    if starts is None or isinstance(starts, Mapping):
        return None
    found = listed_starts(starts)
    return None if all(isinstance(one, numbers.Real) for one in found) else found


def states_of_rows(machine: ParameterValues, names: list[str], table: Floats, several: list[Any]) -> Floats:
    """Returns starts as an array of shape (n, 6) for rows of parameter values; units of L are taken from the machine of each row."""
    if len(several) != len(table):
        raise ValueError(f"starts has {len(several)} rows: expected one start, or one for each of {len(table)} motions")
    found = np.zeros((len(table), 6))
    for i, (start, row) in enumerate(zip(several, table)):
        try:
            own = machine.replace(dict(zip(names, row.tolist())))._system
        except ValueError:
            continue  # the motion itself is refused
        found[i] = state(f"starts[{i}]", start, own)
    return found


def _rows(machines: list[ParameterValues], starts: Any) -> Floats:
    """Returns starts as an array of shape (n, 6): one for each machine, or several starts of one machine."""
    if isinstance(starts, np.ndarray) and starts.ndim == 2:
        return states(starts)
    several = several_of(starts)
    if several is None:
        return np.array([state("starts", starts, m._system) for m in machines]).reshape(-1, 6)
    if len(machines) not in (1, len(several)):
        raise ValueError(f"starts has {len(several)} rows: expected one start, or one for each of {len(machines)} machines")
    own = machines if len(machines) == len(several) else machines * len(several)
    return np.array([state(f"starts[{i}]", s, m._system) for i, (s, m) in enumerate(zip(several, own))]).reshape(-1, 6)
