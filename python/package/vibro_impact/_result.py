"""Base class of results, and their record arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._arguments import Floats


class Result:
    """A result: a value with named parts, shown by their shapes."""

    def __repr__(self) -> str:
        parts = []
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            if not field.repr:
                continue
            value = getattr(self, field.name)
            shown = f"array{value.shape}" if isinstance(value, np.ndarray) and value.size > 8 else repr(value)
            parts.append(f"{field.name}={shown}")
        return f"{type(self).__name__}({', '.join(parts)})"


Part = TypeVar("Part")


def direction(kind: Callable[..., Part], found: dict[str, Any]) -> Part:
    """One direction of a diagram from what the computation returns, with the classes as an array."""
    return kind(**{**found, "kind": np.array(found["kind"], dtype=np.str_)})


def records(kind: np.dtype[np.void], parts: dict[str, Any]) -> NDArray[np.void]:
    """A record of each entry of some columns of one length."""
    found = np.empty(len(parts["t"]), kind)
    for name in kind.names or ():
        found[name] = parts[name]
    return found


def fields_of(kind: np.dtype[np.void], table: Floats) -> NDArray[np.void]:
    """A record of each row of a table."""
    found = np.empty(len(table), kind)
    for index, name in enumerate(kind.names or ()):
        found[name] = table[:, index]
    return found
