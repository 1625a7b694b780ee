"""Checks of arguments; an error names the argument, its value and the accepted values."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: An array of doubles.
Floats = NDArray[np.float64]

SI_COORDINATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")
COORDINATES = ("x1", "x2", "x3", "v1", "v2", "v3")

MOST_PERIODS = 1_000_000_000
MOST_ROWS = 100_000_000


def number(name: str, value: object) -> float:
    """Returns `value` as a finite float."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: expected a finite number")
    try:
        found = float(value)
    except OverflowError:
        found = np.inf
    if not np.isfinite(found):
        raise ValueError(f"{name} = {value!r}: expected a finite number")
    return found


def whole(name: str, value: object, least: int, most: int) -> int:
    """Returns `value` as an integer from `least` to `most`."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: expected a whole number")
    found = int(value)
    if not least <= found <= most:
        raise ValueError(f"{name} = {value!r}: expected a whole number from {least} to {most}")
    return found


def discarded_and_kept(periods: object) -> tuple[int, int]:
    """Returns a pair of numbers of periods: discarded and kept."""
    if not isinstance(periods, Sequence) or len(periods) != 2:
        raise TypeError(f"periods = {periods!r}: expected a pair of whole numbers (discarded, kept)")
    return whole("periods[0]", periods[0], 0, MOST_PERIODS), whole("periods[1]", periods[1], 1, MOST_PERIODS)


def choice(name: str, value: object, allowed: Sequence[str]) -> str:
    """Returns `value` if it is one of the `allowed` words; the error suggests the closest one."""
    if isinstance(value, str) and value in allowed:
        return value
    if not isinstance(value, str):
        raise TypeError(f"{name} = {value!r} is of type {type(value).__name__}: expected one of {listed(allowed)}")
    near = get_close_matches(value, allowed, 1)
    advice = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"{name} = {value!r}: expected one of {listed(allowed)}{advice}")


def listed(words: Sequence[str]) -> str:
    """Joins quoted words with commas."""
    return ", ".join(map(repr, words))


def array(name: str, value: ArrayLike, allowed: str, dimensions: Optional[int] = 1) -> Floats:
    """Returns a contiguous array of finite, unmasked doubles; with ``dimensions=None``, of any number of dimensions."""
    try:
        raw = np.asanyarray(value)
    except ValueError as error:
        raise ValueError(f"{name} is not an array ({error}): expected {allowed}") from None
    if raw.dtype.kind not in "iuf":
        raise TypeError(f"{name} has the dtype {raw.dtype}: expected {allowed}")
    found: Floats = np.ascontiguousarray(raw, dtype=np.float64)
    if dimensions not in (None, raw.ndim):
        raise ValueError(f"{name} has the shape {raw.shape}: expected {allowed}")
    masked = np.ma.getmaskarray(raw) if isinstance(raw, np.ma.MaskedArray) else np.zeros((), dtype=bool)
    for wrong, told in ((masked, "is masked"), (~np.isfinite(found), "= {}")):
        if wrong.any():
            where = np.argwhere(wrong)[0]
            place = f"[{', '.join(map(str, where))}]" if len(where) else ""
            raise ValueError(f"{name}{place} {told.format(found[tuple(where)])}: expected {allowed}, all finite")
    return found


def converted(given: Any, in_si: Callable[[str], float]) -> Any:
    """Converts a text, or a list that contains a text, to SI with `in_si`; returns numbers unchanged."""
    if isinstance(given, str):
        return in_si(given)
    kind = getattr(getattr(given, "dtype", None), "kind", "")
    values = given.tolist() if kind in tuple("OSTU") else given
    if isinstance(values, (list, tuple)) and any(isinstance(value, str) for value in values):
        return [in_si(value) for value in values]
    return given


def evenly_spaced(name: str, given: ArrayLike, most: int) -> tuple[tuple[float, float], int]:
    """Returns the ends and the number of increasing, equally spaced values; the error names the first misplaced value."""
    allowed = "an array of shape (n,), n >= 2, of increasing, equally spaced values, e.g. np.linspace(0.5, 5, 451)"
    values = array(name, given, allowed)
    whole(f"len({name})", len(values), 2, most)
    first, last = float(values[0]), float(values[-1])
    if not first < last:
        raise ValueError(f"{name} does not increase, {name}[0] = {first:.12g} and {name}[{len(values) - 1}] = {last:.12g}: expected {allowed}")
    even = np.linspace(first, last, len(values))
    off = np.flatnonzero(np.abs(values - even) > 1e-9 * (last - first))
    if len(off):
        i = off[0]
        raise ValueError(f"{name} is not equally spaced, {name}[{i}] = {values[i]:.12g} instead of {even[i]:.12g}: expected {allowed}")
    return (first, last), len(values)


def displacement(of: Optional[str]) -> str:
    """Returns the symbol of a displacement of the paper's machine, x2 by default; names of columns are accepted too."""
    names = {"box.s": "x1", "block.s": "x2", "secondary.s": "x3"}
    return "x2" if of is None else choice("of", names.get(of, of) if isinstance(of, str) else of, ("x1", "x2", "x3", "w"))


#: Start of the paper's machine: numbers by name, or six numbers.
StartOfMachine = Union[Mapping[str, Union[float, str]], Sequence[float], Floats, None]


class Coordinates(NamedTuple):
    """Start of the paper's machine: each of six coordinates in units of L or L omega10, or in SI."""

    time: float
    scaled: list[float]
    si: list[Optional[float]]

    def state(self, system: _native.System) -> list[float]:
        """Returns the displacements (m) and velocities (m/s) for a system."""
        return [a if b is None else b for a, b in zip(system.dimensional(self.scaled), self.si)]


def coordinates(name: str, value: StartOfMachine) -> Coordinates:
    """Returns the start that `value` describes; by default the block moves up from the middle with L omega10."""
    if value is None:
        return Coordinates(0.0, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], [None] * 6)
    if not isinstance(value, Mapping):
        found = array(name, value, "six numbers, or a mapping such as {'x2': 0.5, 'block.v': 0.2}")
        if found.shape != (6,):
            raise ValueError(f"{name} has the shape {found.shape}: expected (6,): {', '.join(SI_COORDINATES)}")
        return Coordinates(0.0, [0.0] * 6, [float(x) for x in found])
    start = Coordinates(_coordinate(name, "time", value.get("time", 0.0)), [0.0] * 6, [None] * 6)
    named: dict[int, str] = {}
    for key, given in value.items():
        if key == "time":
            continue
        own = key.replace("_", ".") if isinstance(key, str) else key
        coordinate = choice(f"a name in {name}", own, (*COORDINATES, *SI_COORDINATES))
        plain = _coordinate(name, key, given)
        index = (*COORDINATES, *SI_COORDINATES).index(coordinate) % 6
        first = named.setdefault(index, coordinate)
        if first != coordinate:
            raise ValueError(
                f"{name} = {dict(value)!r}: {first} and {coordinate} are the same coordinate, in units of L or L omega10 and in SI: "
                "use one of them"
            )
        if coordinate in COORDINATES:
            start.scaled[index] = plain
        else:
            start.si[index] = plain
    return start


def _coordinate(name: str, key: str, given: object) -> float:
    """Returns a number of a start: in SI, in units of L or L omega10, or from a text with a unit."""
    if not isinstance(given, str):
        return number(f"{name}[{key!r}]", given)
    unit = "1" if key in COORDINATES else "s" if key == "time" else "m" if key[-1:] == "s" else "m/s"
    return quantity(f"{name}[{key!r}]", unit, given)


def quantity(name: str, unit: str, text: str) -> float:
    """Returns the value in SI of a text with a unit."""
    found = _native.in_si("" if unit == "1" else unit, text)
    if found is None:
        expected = f"a number in {unit}, or a text with a unit that converts to {unit}" if unit not in ("", "1") else "a number"
        raise ValueError(f"{name} = {text!r}: expected {expected}")
    value, has_unit = found
    if not has_unit and unit not in ("", "1"):
        raise ValueError(f"{name} = {text!r}: expected a number in {unit}, or a text with a unit")
    return number(name, value)


def seconds(name: str, time: Any) -> Any:
    """Converts a time given as text to s; returns any other value unchanged."""
    return quantity(name, "s", time) if isinstance(time, str) else time


def state(name: str, value: StartOfMachine, system: _native.System) -> list[float]:
    """Returns the displacements (m) and velocities (m/s) of a start at time 0."""
    start = coordinates(name, value)
    if start.time != 0.0:
        raise ValueError(f"{name}: time = {start.time}: must be 0, where this study begins; `simulate` can begin at another time")
    return start.state(system)
