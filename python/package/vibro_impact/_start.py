"""Starts: a time and a state."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Union

import numpy as np


class Start(Mapping[str, float]):
    """Time and state at the start of a motion; an immutable mapping of names to numbers in SI: ``time``, ``box.s``, ``box.v``.

    ``run.end`` is a start, and so is ``{**run.end, "box.v": 0.0}`` with another velocity. :meth:`save` writes a file that reads back to an
    equal start; :meth:`Machine.start` and ``vibro run FILE --start`` read it. ``np.array(start)`` has all numbers except the time.
    """

    __slots__ = ("_numbers",)

    def __init__(self, numbers: Mapping[str, float]) -> None:
        self._numbers = dict(numbers)

    @property
    def time(self) -> float:
        """The initial time of the drives and other signals, s."""
        return self._numbers["time"]

    @property
    def toml(self) -> str:
        """The text of its file, in SI with every digit."""
        bodies: dict[str, str] = {}
        for name, value in self._numbers.items():
            body, _, key = name.rpartition(".")
            if body:
                bodies[body] = bodies.get(body, f"\n[body.{body}]\n") + f"{key} = {value!r}\n"
        return f"time = {self.time!r}\n" + "".join(bodies.values())

    def save(self, path: Union[str, os.PathLike[str]]) -> Path:
        """Writes the start to a file; returns the path.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        to = Path(path)
        to.write_text(self.toml, encoding="utf-8")
        return to

    def __getitem__(self, name: str) -> float:
        try:
            return self._numbers[name]
        except KeyError:
            raise KeyError(f"{name}: no such name; expected one of {', '.join(self._numbers)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __hash__(self) -> int:
        return hash(frozenset(self._numbers.items()))

    def __repr__(self) -> str:
        return f"Start({self._numbers!r})"

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        numbers = [value for name, value in self._numbers.items() if name != "time"]
        return np.array(numbers, dtype=np.float64 if dtype is None else dtype)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Start, (self._numbers,))
