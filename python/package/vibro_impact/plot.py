"""Pictures by matplotlib: each function draws one result into axes and returns the axes.

``axes`` are the axes to draw into; by default the current axes, as in matplotlib's own functions. Bodies have the same colours as in the
pictures of `vibro`: box blue, block orange, secondary oscillator green, the block in the box purple. Lengths of the paper's machine are drawn in mm
if the gap is under 0.1 m, else in m (maxima of diagrams and starts of basins in units of L); the numbers of the results stay in SI. Results of a
:class:`Machine` are drawn in SI, in matplotlib's colours. Every function except :func:`locus` accepts results of both kinds of machine.

>>> from vibro_impact import PaperMachine, plot
>>> axes = plot.portrait(PaperMachine().simulate(periods=20), of="x2")

Requires matplotlib: ``pip install vibro-impact[plot]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Optional, Union

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ._arguments import Floats, choice, displacement
from ._machine_description import MachineDescription
from ._machine_results import Diagram, Direction, Run
from ._machine_studies import Basins, Section
from ._paper_motion import PaperRun, PaperSection
from ._paper_parameters import PARAMETERS
from ._plot_axes import COLOURS, SYMBOLS, axes_of, length, require
from ._plot_orbits import branch, locus, response
from ._paper_studies import PaperBasins, PaperDiagram, PaperDirection

_BODIES = {"x1": "box", "x2": "block", "x3": "secondary oscillator", "w": "block in the box"}
#: Colours of areas (Okabe and Ito).
_AREAS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")

#: Largest number of drive periods that a history draws as a line; more would merge into a solid bar.
_DRAWN = 40

__all__ = ["COLOURS", "basins", "bifurcation", "branch", "forces", "history", "locus", "portrait", "response", "section"]


def _columns(result: Union[PaperRun, PaperSection], of: str) -> tuple[Floats, Floats]:
    """Displacement (m) and velocity (m/s) of x1, x2, x3 or w."""
    if of == "w":
        return result.s[:, 1] - result.s[:, 0], result.v[:, 1] - result.v[:, 0]
    index = int(choice("of", of, tuple(COLOURS))[1]) - 1
    return result.s[:, index], result.v[:, index]


def _windows(run: PaperRun) -> NDArray[np.intp]:
    """Returns the first samples of at most 400 windows of whole drive periods; none if a run is short enough to be drawn as a line."""
    # A machine without a drive has no period.
    periods = (run.t[-1] - run.t[0]) * run.machine.drive_frequency / (2 * np.pi) if len(run.t) else 0.0
    if periods <= _DRAWN * (1 + 1e-9):
        return np.empty(0, dtype=np.intp)
    period = 2 * np.pi / run.machine.drive_frequency
    width = period * np.ceil(periods / 400 - 1e-9)
    window = np.floor((run.t - run.t[0]) / width + 1e-9)
    return np.flatnonzero(np.diff(window, prepend=-1.0))


def _stops(axes: Axes, gap: float, horizontal: bool) -> None:
    """Draws the stops into a picture of the block's displacement in the box."""
    for stop in (-gap, gap):
        line = axes.axhline if horizontal else axes.axvline
        line(stop, color="black", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)


def _unit(machine: MachineDescription, column: str) -> str:
    """Returns the SI unit of a column of a machine of your own."""
    return machine.measures[f"maximum.{column}"].split(":")[0]


def history(run: Union[Run, PaperRun], axes: Optional[Axes] = None, *, of: Union[None, str, Sequence[str]] = None) -> Axes:
    """Draws displacements over time; over more than 40 drive periods, the minimum and maximum in each window of whole periods.

    Parameters
    ----------
    of
        Some of x1, x2, x3 (also box.s, block.s, secondary.s) and w = x2 - x1; by default the first three. The stops of w are dashed. For
        a machine of your own, some of its columns, by default the displacements of all bodies; every sample is drawn.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, or unknown names.
    """
    require("run", run, Run, PaperRun)
    axes = axes_of(axes)
    given = [of] if isinstance(of, str) else of
    if isinstance(run, Run):
        return _history_of_described(run, axes, _displacements(run) if given is None else list(given))
    scale, unit = length(run.machine)
    names = ["x1", "x2", "x3"] if given is None else list(map(displacement, given))
    windows = _windows(run)
    for name in names:
        place, label = scale * _columns(run, name)[0], f"{SYMBOLS[name]} {_BODIES[name]}"
        if len(windows):
            low, high = (extreme.reduceat(place, windows) for extreme in (np.minimum, np.maximum))
            t, low, high = (np.append(values, values[-1]) for values in (run.t[windows], low, high))
            t[-1] = run.t[-1]
            axes.fill_between(t, low, high, step="post", facecolor=COLOURS[name] + "55", edgecolor=COLOURS[name], linewidth=0.8, label=label)
        else:
            axes.plot(run.t, place, color=COLOURS[name], linewidth=1.2, label=label)
    if "w" in names:
        _stops(axes, scale * run.machine.stop_gap, horizontal=True)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(f"displacement ({unit})" if len(names) > 1 else f"{SYMBOLS[names[0]]} ({unit})")
    axes.margins(x=0)
    if len(names) > 1:
        # Above the axes, clear of the lines.
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(names), frameon=False)
    return axes


def _displacements(run: Run) -> list[str]:
    return [name for name in run.columns if name.endswith(".s")]


def _history_of_described(run: Run, axes: Axes, names: list[str]) -> Axes:
    for name in names:
        choice("of", name, run.columns)
        axes.plot(run.t, run[name], linewidth=1.2, label=name)
    units = list(dict.fromkeys(_unit(run.machine, name) for name in names))
    axes.set_xlabel("time (s)")
    axes.set_ylabel(f"{names[0]} ({units[0]})" if len(names) == 1 else ", ".join(units))
    axes.margins(x=0)
    if len(names) > 1:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=min(len(names), 4), frameon=False)
    return axes


def _portrait_of_described(run: Run, axes: Axes, of: str) -> Axes:
    pairs = _rates(run.columns)
    rate = pairs[choice("of", of, tuple(pairs))]
    jumps = np.unique(np.searchsorted(run.t, run.events["t"][run.events["kind"] == "impact"]))
    jumps = jumps[(jumps > 0) & (jumps < len(run.t))]
    axes.plot(np.insert(run[of], jumps, np.nan), np.insert(run[rate], jumps, np.nan), linewidth=0.9)
    axes.set_xlabel(f"{of} ({_unit(run.machine, of)})")
    axes.set_ylabel(f"{rate} ({_unit(run.machine, rate)})")
    return axes


def forces(run: Union[Run, PaperRun], axes: Optional[Axes] = None, *, of: Union[None, str, Sequence[str]] = None) -> Axes:
    """Draws forces over time: elements and loads of a described machine, or impulses (N.s) at the stops of the paper's machine as stems.

    Parameters
    ----------
    of
        For a described machine, some columns that end in ``.f``: by default of all stops with a force, or all if no stop has one. For the paper's
        machine ``upper`` or ``lower``, by default both.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, unknown names, or a described machine without such elements.
    """
    require("run", run, Run, PaperRun)
    axes = axes_of(axes)
    given = [of] if isinstance(of, str) else of
    if isinstance(run, Run):
        all_forces = [name for name in run.columns if name.endswith(".f")]
        stops = [name for name in all_forces if any(key.startswith(f"stop.{name[:-2]}.") for key in run.machine.parameters)]
        names = (stops or all_forces) if given is None else [choice("of", name, all_forces) for name in given]
        if not names:
            raise ValueError("run: its machine has no element with a force; expected a spring, compliant stop, friction or load")
        return _history_of_described(run, axes, names)
    for name in ("upper", "lower") if given is None else given:
        sign = 1 if choice("of", name, ("upper", "lower")) == "upper" else -1
        own = run.impacts[run.impacts["stop"] == sign]
        axes.vlines(own["t"], 0.0, own["impulse"], color="C0" if sign > 0 else "C1", linewidth=1.2, label=f"{name} stop")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("impulse on the box (N·s)")
    if len(run.t):
        axes.set_xlim(run.t[0], run.t[-1])
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    return axes


def portrait(run: Union[Run, PaperRun], axes: Optional[Axes] = None, *, of: Optional[str] = None) -> Axes:
    """Draws velocity (m/s) over displacement; the line is interrupted at impacts, where the velocity jumps.

    Parameters
    ----------
    of
        One of x1, x2, x3 and w = x2 - x1; default x2. The stops of w are dashed. For a machine of your own, the displacement of a body or the
        elongation of an element, ``box.s`` or ``upper.e``, by default of the first body; the line is interrupted at every impact.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, or unknown names.
    """
    require("run", run, Run, PaperRun)
    axes = axes_of(axes)
    if isinstance(run, Run):
        return _portrait_of_described(run, axes, _displacements(run)[0] if of is None else of)
    of = displacement(of)
    scale, unit = length(run.machine)
    place, rate = _columns(run, of)
    jumps = np.unique(np.searchsorted(run.t, run.impacts["t"]))
    if of == "x3":
        jumps = jumps[:0]  # its velocity does not jump
    jumps = jumps[(jumps > 0) & (jumps < len(run.t))]
    axes.plot(np.insert(scale * place, jumps, np.nan), np.insert(rate, jumps, np.nan), color=COLOURS[of], linewidth=0.9)
    if of == "w":
        _stops(axes, scale * run.machine.stop_gap, horizontal=False)
    axes.set_xlabel(f"{SYMBOLS[of]} ({unit})")
    axes.set_ylabel(f"rate of {SYMBOLS[of]} (m/s)")
    return axes


def section(section: Union[Section, PaperSection], axes: Optional[Axes] = None, *, of: Optional[str] = None) -> Axes:
    """Draws the points of a Poincaré section: velocity (m/s) over displacement at a phase, speed (m/s) over phase (rad) at a stop.

    Parameters
    ----------
    of
        One of x1, x2, x3 and w = x2 - x1; default x2. For a machine of your own, the displacement of a body or the elongation of an
        element; by default, at a stop of a driven machine, the closing speed over the phase.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, or unknown names.
    """
    require("section", section, Section, PaperSection)
    axes = axes_of(axes)
    if isinstance(section, Section):
        place, rate = _section_of_described(section, axes, of)
        return _points(axes, place, rate, "C0")
    of = displacement(of)
    if section.at == "phase":
        scale, unit = length(section.machine)
        place, rate = _columns(section, of)
        place = scale * place
        axes.set_xlabel(f"{SYMBOLS[of]} ({unit})")
        axes.set_ylabel(f"rate of {SYMBOLS[of]} (m/s)")
    else:
        place, rate = section.phase, section.speed
        _phases(axes)
        axes.set_ylabel(f"speed of impact at the {section.at} stop (m/s)")
    return _points(axes, place, rate, COLOURS[of])


def _phases(axes: Axes) -> None:
    axes.set_xlim(0, 2 * np.pi)
    axes.set_xticks(np.pi / 2 * np.arange(5), ["0", "π/2", "π", "3π/2", "2π"])
    axes.set_xlabel("phase of the drive (rad)")


def _points(axes: Axes, x: Floats, y: Floats, colour: str) -> Axes:
    axes.plot(x, y, linestyle="none", marker=".", markersize=2, markeredgewidth=0, color=colour, rasterized=True)
    return axes


def _section_of_described(section: Section, axes: Axes, of: Optional[str]) -> tuple[Floats, Floats]:
    """Returns the points of a section and labels the axes."""
    if of is None and section.phase is not None and section.speed is not None:
        _phases(axes)
        axes.set_ylabel(f"closing speed of {section.at}, SI")
        return section.phase, section.speed
    pairs = _rates(section.machine.columns)
    of = next(iter(pairs)) if of is None else choice("of", of, tuple(pairs))
    axes.set_xlabel(f"{of} ({_unit(section.machine, of)})")
    axes.set_ylabel(f"{pairs[of]} ({_unit(section.machine, pairs[of])})")
    return section[of], section[pairs[of]]


def _rates(columns: Sequence[str]) -> dict[str, str]:
    """Maps displacements and elongations to their rates."""
    rates = {".s": ".v", ".e": ".rate"}
    pairs = {name: name[:-2] + rates[name[-2:]] for name in columns if name[-2:] in rates}
    return {place: rate for place, rate in pairs.items() if rate in columns}


def bifurcation(diagram: Union[Diagram, PaperDiagram], axes: Optional[Axes] = None, *, direction: str = "up") -> Axes:
    """Draws the maxima of a bifurcation diagram over its parameter, in units of L; for a machine of your own in SI.

    Parameters
    ----------
    direction
        ``"up"``, ``"down"``, or ``"both"``, which draws the downward direction in grey behind the upward one.

    Raises
    ------
    TypeError, ValueError
        For another kind of result, or another direction.
    """
    require("diagram", diagram, Diagram, PaperDiagram)
    axes = axes_of(axes)
    choice("direction", direction, ("up", "down", "both"))
    if isinstance(diagram, Diagram):
        colour, unit = "C0", diagram.machine.units[diagram.name]
        across = diagram.name if unit == "1" else f"{diagram.name} ({unit})"
        what = "at the section" if diagram.at_section else "maxima"
        up = f"{diagram.of}, {what} ({_unit(diagram.machine, diagram.of)})"
    else:
        colour, across = COLOURS[diagram.of], PARAMETERS[diagram.name][0]
        up = f"maxima of {SYMBOLS[diagram.of]} (units of L)"
    if direction == "both":
        _dots(axes, diagram.down, "#8c8c8c", "falling")
    shown = diagram.down if direction == "down" else diagram.up
    _dots(axes, shown, colour, "falling" if direction == "down" else "rising")
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.margins(x=0.01)
    if direction == "both":
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, markerscale=5)
    return axes


def _dots(axes: Axes, shown: Union[Direction, PaperDirection], colour: str, label: str) -> None:
    axes.plot(
        shown.value[shown.at],
        shown.maxima,
        linestyle="none",
        marker=".",
        markersize=2,
        markeredgewidth=0,
        color=colour,
        label=label,
        rasterized=True,
    )


def basins(basins: Union[Basins, PaperBasins], axes: Optional[Axes] = None) -> Axes:
    """Draws basins of attraction: a colour for each attractor (repeated after six), lighter for its mirror image; cells without an attractor are
    white.

    For a machine of your own, cells whose start violates a rigid stop are white, undecided ones grey, and cells whose motion ends or comes to rest
    black.
    """
    require("basins", basins, Basins, PaperBasins)
    axes = axes_of(axes)
    if isinstance(basins, Basins):
        return _basins_of_described(basins, axes)
    colours, handles = ["white"], []
    for number, attractor in enumerate(basins.attractors):
        colour = _AREAS[number % len(_AREAS)]
        light = _lighter(colour)
        colours += [colour, light]
        upper, lower = attractor.impacts
        words = f"{attractor.kind}, {upper:.3g} upper + {lower:.3g} lower impacts a period"
        handles.append(Patch(facecolor=colour, label=words))
        if basins.mirror[basins.cells == number].any():
            handles.append(Patch(facecolor=light, label="its mirror image"))
    shown = np.where(basins.cells < 0, 0, 1 + 2 * basins.cells + basins.mirror)
    labels = [f"start of {_start(name)}" for name in basins.names]
    return _areas(axes, shown, colours, handles, (basins.edges, labels[0], labels[1]))


def _basins_of_described(basins: Basins, axes: Axes) -> Axes:
    colours, handles = ["black", "#8c8c8c", "white"], []
    for number, attractor in enumerate(basins.attractors):
        turn, index = divmod(number, len(_AREAS))
        colour = _AREAS[index] if turn % 2 == 0 else _lighter(_AREAS[index])
        colours.append(colour)
        word = attractor.word if len(attractor.word) <= 48 else f"{attractor.word.count(',') + 1} events"
        handles.append(Patch(facecolor=colour, label=f"{attractor.kind} {word}".strip()))

    def label(name: str) -> str:
        unit = "s" if name == "time" else _unit(basins.machine, name)
        return f"start of {name} ({unit})"

    return _areas(axes, basins.cells + 3, colours, handles, (basins.edges, label(basins.names[0]), label(basins.names[1])))


def _areas(
    axes: Axes,
    shown: NDArray[np.int32],
    colours: list[str],
    handles: list[Patch],
    place: tuple[tuple[float, float, float, float], str, str],
) -> Axes:
    """Draws a plane of coloured cells with its legend."""
    edges, across, up = place
    axes.imshow(
        shown,
        cmap=ListedColormap(colours),
        vmin=-0.5,
        vmax=len(colours) - 0.5,
        extent=edges,
        origin="lower",
        aspect="auto",
        interpolation="nearest",
    )
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, fontsize="small")
    return axes


def _start(name: str) -> str:
    """Returns the label of a coordinate of the start with its unit."""
    return f"$x_{name[1]}$ (units of L)" if name[0] == "x" else f"$\\dot x_{name[1]}$ (units of L$\\,\\omega_{{10}}$)"


def _lighter(colour: str) -> str:
    """Mixes a colour with white, half and half."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{(part + 255) // 2:02x}" for part in parts)
