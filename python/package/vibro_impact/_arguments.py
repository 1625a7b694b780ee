"""Checks of arguments: an error names the argument, its value and what is allowed."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from . import _native

#: An array of doubles.
Floats = NDArray[np.float64]

#: A state by names, or as six numbers: displacements (m), then velocities (m/s) of box, block and secondary oscillator.
Start = Union[Mapping[str, float], Sequence[float], Floats, None]

SI_COORDINATES = ("box_s", "block_s", "secondary_s", "box_v", "block_v", "secondary_v")
COORDINATES = ("x1", "x2", "x3", "v1", "v2", "v3")

MOST_PERIODS = 1_000_000_000
MOST_ROWS = 100_000_000


def number(name: str, value: object) -> float:
    """A finite number."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: allowed is a finite number")
    try:
        found = float(value)
    except OverflowError:
        found = np.inf
    if not np.isfinite(found):
        raise ValueError(f"{name} = {value!r}: allowed is a finite number")
    return found


def whole(name: str, value: object, least: int, most: int) -> int:
    """A whole number of a range."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: allowed is a whole number")
    found = int(value)
    if not least <= found <= most:
        raise ValueError(f"{name} = {value!r}: allowed is a whole number from {least} to {most}")
    return found


def discarded_and_kept(periods: object) -> tuple[int, int]:
    """A pair of numbers of periods."""
    if not isinstance(periods, Sequence) or len(periods) != 2:
        raise TypeError(f"periods = {periods!r}: allowed is a pair of whole numbers: discarded, kept")
    return whole("periods[0]", periods[0], 0, MOST_PERIODS), whole("periods[1]", periods[1], 1, MOST_PERIODS)


def choice(name: str, value: object, allowed: Sequence[str]) -> str:
    """One of some words; the nearest is named."""
    if isinstance(value, str) and value in allowed:
        return value
    if not isinstance(value, str):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: allowed is one of {listed(allowed)}")
    near = get_close_matches(value, allowed, 1)
    advice = f"; the nearest is {near[0]!r}" if near else ""
    raise ValueError(f"{name} = {value!r}: allowed is one of {listed(allowed)}{advice}")


def listed(words: Sequence[str]) -> str:
    """Quoted words, separated by commas."""
    return ", ".join(map(repr, words))


def array(name: str, value: ArrayLike, allowed: str, dimensions: int = 1) -> Floats:
    """A contiguous array of finite doubles."""
    try:
        raw = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} makes no array ({error}): allowed is {allowed}") from None
    if raw.dtype.kind not in "iuf":
        raise TypeError(f"{name} has the dtype {raw.dtype}: allowed is {allowed}")
    found: Floats = np.ascontiguousarray(raw, dtype=np.float64)
    if raw.ndim != dimensions:
        raise ValueError(f"{name} has the shape {raw.shape}: allowed is {allowed}")
    if not np.isfinite(found).all():
        where = np.argwhere(~np.isfinite(found))[0]
        place = ", ".join(map(str, where))
        raise ValueError(f"{name}[{place}] = {found[tuple(where)]}: allowed is {allowed} of finite numbers")
    return found


def state(name: str, value: Start, system: _native.System) -> list[float]:
    """A start as displacements (m) and velocities (m/s); without one, the block moves up from the middle with L omega10."""
    if value is None:
        return system.dimensional([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    if not isinstance(value, Mapping):
        found = array(name, value, "six numbers, or a mapping such as {'x2': 0.5, 'block_v': 0.2}")
        if found.shape != (6,):
            raise ValueError(f"{name} has the shape {found.shape}: allowed is (6,): {', '.join(SI_COORDINATES)}")
        return [float(x) for x in found]
    scaled = [0.0] * 6
    si = [None] * 6  # type: list[Any]
    named: dict[int, str] = {}
    for key, given in value.items():
        coordinate = choice(f"a name in {name}", key, (*COORDINATES, *SI_COORDINATES))
        plain = number(f"{name}[{key!r}]", given)
        first = named.setdefault((*COORDINATES, *SI_COORDINATES).index(coordinate) % 6, coordinate)
        if first != coordinate:
            raise ValueError(
                f"{name} = {dict(value)!r}: {first} and {coordinate} are one coordinate, in units of L or L omega10 and in SI: allowed "
                "is each coordinate once"
            )
        if coordinate in COORDINATES:
            scaled[COORDINATES.index(coordinate)] = plain
        else:
            si[SI_COORDINATES.index(coordinate)] = plain
    return [a if b is None else b for a, b in zip(system.dimensional(scaled), si)]
