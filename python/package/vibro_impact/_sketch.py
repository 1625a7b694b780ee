"""Sketches of machines."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Union

from . import _native


class Sketch:
    """The sketch of a machine; a notebook shows it as a picture."""

    __slots__ = ("_described", "svg")
    svg: str
    "The picture as SVG."

    def __init__(self, described: _native.Described) -> None:
        self._described = described
        self.svg = described.sketch()

    def save(self, path: Union[str, os.PathLike[str]]) -> Path:
        """Writes the picture to a file that ends in ``.svg`` or ``.png``; returns its path.

        Raises
        ------
        ValueError
            If the file has another extension.
        OSError
            If the file cannot be written.
        """
        to = Path(path)
        if to.suffix == ".svg":
            to.write_text(self.svg, encoding="utf-8")
        elif to.suffix == ".png":
            to.write_bytes(self._described.sketch_as_png())
        else:
            raise ValueError(f"path = {to}: expected a file that ends in .svg or .png")
        return to

    def _repr_svg_(self) -> str:
        """The SVG that a notebook shows."""
        return self.svg

    def __reduce__(self) -> tuple[Any, ...]:
        return (_of_text, (self._described.text(),))

    def __repr__(self) -> str:
        return f"Sketch({self._described.name()!r})"


def _of_text(text: str) -> Sketch:
    """Returns the sketch of the machine that a text describes."""
    return Sketch(_native.Described(text, None))
