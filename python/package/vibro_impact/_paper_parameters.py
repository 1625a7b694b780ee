"""The parameters of the paper's machine by name: their types, and their values from arguments."""

from __future__ import annotations

import sys
import warnings
from typing import TYPE_CHECKING, Any

from . import _native
from ._arguments import number, quantity

if TYPE_CHECKING:
    from typing_extensions import TypedDict

    class Groups(TypedDict, total=False):
        """The dimensionless groups."""

        epsilon: float
        kappa: float
        f10: float
        sigma1: float
        gamma1: float
        alpha23: float
        beta2: float
        sigma30: float
        gamma3: float
        mu13: float

    class Parameters(Groups, total=False):
        """All parameters by name."""

        box_m: float
        box_k: float
        box_c: float
        block_m: float
        secondary_m: float
        secondary_k: float
        secondary_c: float
        coupling_k: float
        stop_gap: float
        stop_restitution: float
        drive_amplitude: float
        drive_frequency: float
        drive_phase: float
        load_box: float
        load_block: float
        load_secondary: float


class MixedParametersWarning(UserWarning):
    """Warns that some physical parameters were given and that the others come from the default set, which belongs to another machine."""


class SimilarNameWarning(UserWarning):
    """Warns that a parameter was given by a symbol that differs only by case from another parameter's name: ``F10`` (N) and ``f10``."""


_COUNT, _ROWS = _native.parameters()
#: Every parameter by name: label of an axis, unit, meaning, accepted values.
PARAMETERS = {name: about for name, *about in _ROWS}
#: Names of the physical parameters and of the groups.
SI_NAMES = tuple(row[0] for row in _ROWS[:_COUNT])
GROUP_NAMES = tuple(row[0] for row in _ROWS[_COUNT:])


# The physical parameter that each group determines.
_MEANT = {
    "epsilon": "block_m",
    "kappa": "stop_restitution",
    "f10": "drive_amplitude",
    "sigma1": "drive_frequency",
    "gamma1": "box_c",
    "alpha23": "coupling_k",
    "beta2": "coupling_k",
    "sigma30": "secondary_k",
    "gamma3": "secondary_c",
    "mu13": "secondary_m",
}


def find(given: str) -> str:
    """Returns the canonical name of a parameter; warns if another parameter's name differs only by case."""
    name = _native.find(given)
    similar = [other for other in PARAMETERS if other.lower() == given.lower() and other != name]
    if similar and given != name:
        warnings.warn(
            f"`{given}` is {name}, {_unit(name)}; `{similar[0]}` is another parameter, {_unit(similar[0])}. If the first is meant, "
            f"write {name} to avoid this warning",
            SimilarNameWarning,
            stacklevel=outside(),
        )
    return name


def _unit(name: str) -> str:
    unit = PARAMETERS[name][1]
    return "without a unit" if unit in ("", "1") else f"in {unit}"


def outside() -> int:
    """Returns the number of frames from the caller to the first frame outside the package (`stacklevel` of a warning)."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(__package__):
        level, frame = level + 1, frame.f_back
    return level


def named(parameters: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Returns parameters under their canonical names: first the SI parameters, then the groups."""
    si: dict[str, float] = {}
    groups: dict[str, float] = {}
    for given, value in parameters.items():
        if not isinstance(given, str):
            raise TypeError(f"{given!r} is not a name: expected the name of a parameter, such as 'stop.gap'")
        name = find(given)
        part = si if name in SI_NAMES else groups
        if name in part:
            raise TypeError(f"{given} is given twice: {name} is another name of it")
        part[name] = value_of(name, given, value)
    return si, groups


def as_changes(parameters: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Like :func:`named`; raises if a group and the physical parameter that it determines are both given."""
    si, groups = named(parameters)
    for group, own in _MEANT.items():
        if group in groups and own in si:
            raise TypeError(f"{group} cannot be combined with {own}, which it determines: use one of them")
    return si, groups


def value_of(name: str, given: str, value: object) -> float:
    """Returns the value of a parameter in SI, from a number in SI or a text with a unit."""
    return quantity(given, PARAMETERS[name][1] or "1", value) if isinstance(value, str) else number(given, value)


def with_changes(values: dict[str, float], changes: dict[str, float]) -> dict[str, float]:
    """Returns the values with changes appended, because the later of two tied groups keeps its value."""
    return {**{name: value for name, value in values.items() if name not in changes}, **changes}


def in_order(si: dict[str, float]) -> dict[str, float]:
    """Returns physical parameters in canonical order, so that equal machines have the same representation."""
    return {name: si[name] for name in SI_NAMES if name in si}


def written(values: dict[str, float]) -> str:
    """Formats values as the arguments of a call."""
    return ", ".join(f"{name}={value!r}" for name, value in values.items())
