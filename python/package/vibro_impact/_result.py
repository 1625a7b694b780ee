"""Base class of results, and their record arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Optional, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._arguments import Floats
from ._show import page


#: Events: time (s), kind, element as ``stop.NAME`` or ``friction.NAME``, value (0 for a kind without a value), and
#: number of stops that took part in an impact.
EVENT = np.dtype([("t", "f8"), ("kind", "U7"), ("element", "U112"), ("value", "f8"), ("stops", "i4")])


class Result:
    """A result: a value with named parts, shown by their shapes; a notebook shows a small picture and the main numbers."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={shown}' for name, shown in self._parts())})"

    def _parts(self) -> list[tuple[str, str]]:
        """Returns the names of the parts with short texts."""
        shown = [field.name for field in dataclasses.fields(self) if field.repr]  # type: ignore[arg-type]
        return [(name, _short(getattr(self, name))) for name in shown]

    def _picture(self) -> str:
        """Returns a small SVG, or an empty text."""
        return ""

    def _repr_svg_(self) -> Optional[str]:
        """The picture, if the result has one."""
        return self._picture() or None

    def _repr_html_(self) -> str:
        """The picture and main numbers that a notebook shows."""
        return page(type(self).__name__, self._parts(), self._picture())


def _short(value: object) -> str:
    """Returns a value as a short text."""
    if isinstance(value, np.ndarray) and value.size > 8:
        return f"array{value.shape}"
    if isinstance(value, (list, tuple, dict)) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key!r}: {_short(part)}" for key, part in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        inside = ", ".join(map(_short, value))
        return f"[{inside}]" if isinstance(value, list) else f"({inside}{',' * (len(value) == 1)})"
    text = repr(value)
    return text if len(text) <= 200 else f"{type(value).__name__} of {len(text)} letters"


Part = TypeVar("Part")


def direction(kind: Callable[..., Part], found: dict[str, Any]) -> Part:
    """Returns one direction of a diagram from the result of the computation, with the classes as an array."""
    return kind(**{**found, "kind": np.array(found["kind"], dtype=np.str_)})


def place_of(names: list[str], name: str) -> int:
    """Returns the index of a name."""
    try:
        return names.index(name)
    except ValueError:
        if name.endswith((".impacts", ".class")) or name == "class":
            raise KeyError(f"{name}: has no derivative; expected one of {', '.join(names)}") from None
        expected = f"expected one of {', '.join(names)}" if names else "no derivatives were requested"
        raise KeyError(f"{name}: no such name; {expected}") from None


def column_of(columns: list[str], values: Floats, name: str) -> Floats:
    """Returns the column with a name."""
    found: Floats = values[..., place_of(columns, name)]
    return found


def records(kind: np.dtype[np.void], parts: dict[str, Any]) -> NDArray[np.void]:
    """Returns a record array from columns of equal length."""
    found = np.empty(len(parts["t"]), kind)
    for name in kind.names or ():
        found[name] = parts[name]
    return found


def fields_of(kind: np.dtype[np.void], table: Floats) -> NDArray[np.void]:
    """Returns a record array from the rows of a table."""
    found = np.empty(len(table), kind)
    for index, name in enumerate(kind.names or ()):
        found[name] = table[:, index]
    return found
