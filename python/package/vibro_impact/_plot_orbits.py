"""Pictures of branches of periodic orbits and of curves of special points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ._arguments import Floats
from ._machine_description import MachineDescription
from ._machine_locus import Locus
from ._machine_orbits import Branch
from ._paper_orbits import PaperBranch
from ._paper_parameters import PARAMETERS
from ._plot_axes import COLOURS, SYMBOLS, axes_of, length, require


def _parameter(machine: MachineDescription, name: str) -> str:
    """Returns the name of a parameter of a machine of your own with its unit."""
    unit = machine.units[name]
    return name if unit == "1" else f"{name} ({unit})"


def _mark(axes: Axes, labels: NDArray[np.str_], x: Floats, y: Floats) -> None:
    """Marks special points with their labels; ends of a range are not marked."""
    for index in np.flatnonzero((labels != "") & (labels != "EP")):
        place = (x[index], y[index])
        axes.plot(*place, "o", color="black", markersize=3.5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.3}
        axes.annotate(str(labels[index]), place, (7, -11), textcoords="offset points", bbox=box)


def branch(branch: Union[Branch, PaperBranch], axes: Optional[Axes] = None) -> Axes:
    """Draws the kept quantity along a branch of periodic orbits: solid if stable, dashed if unstable, special points with labels.

    The quantity is the largest maximum for the paper's machine, and the branch's measure in SI for a machine of your own.
    """
    if isinstance(branch, Sequence):
        raise TypeError(f"branch is of type {type(branch).__name__}: expected Branch or PaperBranch; plot.response draws several")
    require("branch", branch, Branch, PaperBranch)
    axes = axes_of(axes)
    if isinstance(branch, Branch):
        machine, colour, top = branch.machine, "C0", branch.measure
        unit = machine.measures[branch.of].split(":")[0] if branch.of in machine.measures else ""
        across = _parameter(machine, branch.name)
        up = branch.of if unit in ("", "1") else f"{branch.of} ({unit})"
    else:
        scale, symbol = length(branch.machine)
        top = scale * np.array([maxima[0] if len(maxima) else np.nan for maxima in branch.maxima])
        colour, across = COLOURS[branch.of], PARAMETERS[branch.name][0]
        up = f"largest maximum of {SYMBOLS[branch.of]} ({symbol})"
    # A piece connects a point with the next one and has the stability of its first point.
    for stable, style in ((True, "-"), (False, (0, (3, 2)))):
        begins = np.flatnonzero(branch.stable[:-1] == stable)
        label = "stable" if stable else "unstable"
        for run in np.split(begins, np.flatnonzero(np.diff(begins) > 1) + 1):
            points = np.append(run, run[-1:] + 1)
            axes.plot(branch.value[points], top[points], color=colour, linewidth=1.4, linestyle=style, label=label)
            label = "_"  # one entry of the legend for all pieces
    if len(top) == 1:  # an isolated orbit, from which no branch continues
        axes.plot(branch.value, top, "o", color=colour, markersize=3.5, label="stable" if branch.stable[0] else "unstable")
    _mark(axes, branch.labels, branch.value, top)
    axes.margins(y=0.1)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    handles, labels = axes.get_legend_handles_labels()
    own = dict(zip(reversed(labels), reversed(handles)))  # one legend entry each for several branches in one picture
    axes.legend([own[key] for key in sorted(own)], sorted(own), loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    return axes


def response(branches: Sequence[Union[Branch, PaperBranch]], axes: Optional[Axes] = None) -> Axes:
    """Draws a response curve, or all branches over a parameter: the result of `response` or `branches`, each branch as in :func:`branch`.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, or no result.
    """
    branches = _several("branches", branches, Branch, PaperBranch)
    axes = axes_of(axes)
    for one in branches:
        branch(one, axes)
    return axes


def _several(what: str, results: Any, *kinds: type) -> Sequence[Any]:
    """Returns at least one result as a sequence; raises for types that the picture does not draw."""
    if isinstance(results, kinds):
        return [results]
    if not isinstance(results, Sequence) or isinstance(results, str):
        allowed = " or ".join(kind.__name__ for kind in kinds)
        raise TypeError(f"{what} is of type {type(results).__name__}: expected a list of {allowed}")
    if not results:
        raise ValueError(f"{what} is empty: expected at least one")
    for index, one in enumerate(results):
        require(f"{what}[{index}]", one, *kinds)
    return results


def locus(curves: Union[Locus, Sequence[Locus]], axes: Optional[Axes] = None) -> Axes:
    """Draws one or several curves of special points over two parameters, with points at which two conditions hold.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, no result, or curves over different parameters.
    """
    several = _several("curves", curves, Locus)
    axes = axes_of(axes)
    for index, one in enumerate(several):
        if one.names != several[0].names:
            raise ValueError(f"curves[{index}] is over {one.names}: expected curves over {several[0].names}, as curves[0]")
    kinds = list(dict.fromkeys((one.label, one.element) for one in several))
    for kind in kinds:
        own = [one for one in several if (one.label, one.element) == kind]
        for k, one in enumerate(own):
            label = "_" if k else " ".join(kind).strip()  # one entry of the legend for all curves of a kind
            axes.plot(*one.values.T, color=f"C{kinds.index(kind)}", linewidth=1.4, label=label)
            _mark(axes, one.labels, *one.values.T)
    axes.set_xlabel(_parameter(several[0].machine, several[0].names[0]))
    axes.set_ylabel(_parameter(several[0].machine, several[0].names[1]))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False)
    return axes
