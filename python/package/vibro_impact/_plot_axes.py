"""Shared parts of all matplotlib pictures: axes, units, colours."""

from __future__ import annotations

from typing import Optional

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from ._paper_values import ParameterValues

#: Colours of x1, x2, x3 and w = x2 - x1.
COLOURS = {"x1": "#004696", "x2": "#c84b00", "x3": "#14a073", "w": "#a52882"}
#: Names of the displacements in legends and on axes.
SYMBOLS = {"x1": "$x_1$", "x2": "$x_2$", "x3": "$x_3$", "w": "$w$"}

#: Lengths are drawn in mm if the gap (m) is smaller than this.
_SMALL_GAP = 0.1


def length(machine: ParameterValues) -> tuple[float, str]:
    """Returns the number of units of length per metre, and the symbol of the unit."""
    return (1e3, "mm") if machine.stop_gap < _SMALL_GAP else (1.0, "m")


def require(what: str, result: object, *kinds: type) -> None:
    """Raises for results of types that the picture does not draw."""
    if not isinstance(result, kinds):
        allowed = " or ".join(kind.__name__ for kind in kinds)
        raise TypeError(f"{what} is of type {type(result).__name__}: expected {allowed}")


def axes_of(axes: Optional[Axes]) -> Axes:
    """Returns the axes to draw into; by default the current axes."""
    if axes is None:
        return plt.gca()
    require("axes", axes, Axes)
    return axes
