"""Motions and loads of the paper's machine."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._arguments import SI_COORDINATES, Floats, array, choice
from ._show import Line, lines
from ._result import EVENT, Result, column_of, fields_of, records
from ._tables import dataset, frame
from ._start import Start
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    import pandas
    import xarray
    from numpy.typing import ArrayLike, NDArray

#: Impacts: time (s), stop (+1 upper, -1 lower), |w'| before (m/s), impulse on the box in the direction of the stop (N.s).
IMPACT = np.dtype([("t", "f8"), ("stop", "i1"), ("speed", "f8"), ("impulse", "f8")])
#: Beginnings or ends of resting contact: time (s), stop (+1 upper, -1 lower).
CONTACT = np.dtype([("t", "f8"), ("stop", "i1")])
#: Energy accounts since the start, J: mechanical = its first value + input - damped - impact.
ENERGY = np.dtype([("mechanical", "f8"), ("input", "f8"), ("damped", "f8"), ("impact", "f8")])


class Load:
    """A measured force on one body, interpolated by straight lines or monotone cubics; zero before the first sample and after the last one.

    The motion is exact for the interpolant. An immutable value.

    Parameters
    ----------
    body
        ``"box"``, ``"block"`` or ``"secondary"``.
    t
        Times of the samples, shape (n,), s, strictly ascending, at least two.
    force
        Forces, shape (n,), N.
    interpolation
        ``"linear"``, or ``"cubic"`` for PCHIP, whose values stay between neighbouring samples.

    Raises
    ------
    ValueError, TypeError
        If an argument has another shape; for the first invalid sample.
    """

    __slots__ = ("_native", "body", "force", "interpolation", "t")
    body: str
    t: Floats
    force: Floats
    interpolation: str
    _native: _native.Load

    def __init__(self, body: str, t: ArrayLike, force: ArrayLike, interpolation: str = "linear") -> None:
        choice("body", body, ("box", "block", "secondary"))
        choice("interpolation", interpolation, ("linear", "cubic"))
        times, forces = (
            array(name, given, f"an array of shape (n,) of {what}").copy()
            for name, given, what in (("t", t, "times in s"), ("force", force, "forces in N"))
        )
        if times.shape != forces.shape:
            raise ValueError(f"force has the shape {forces.shape}: expected the shape of t, {times.shape}")
        times.flags.writeable = forces.flags.writeable = False
        load = _native.Load(body, times, forces, interpolation == "cubic")
        values = {"body": body, "t": times, "force": forces, "interpolation": interpolation, "_native": load}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __call__(self, t: ArrayLike) -> Floats:
        """Returns the force (N) at times (s), shape (n,)."""
        return self._native.at(array("t", t, "an array of shape (n,) of times in s"))

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a load is immutable")

    def __repr__(self) -> str:
        return f"Load({self.body!r}, t={self.t.tolist()}, force={self.force.tolist()}, interpolation={self.interpolation!r})"

    def _key(self) -> tuple[Any, ...]:
        return (self.body, self.interpolation, tuple(self.t.tolist()), tuple(self.force.tolist()))

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Load) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        return (Load, (self.body, self.t, self.force, self.interpolation))


def load_list(loads: Iterable[Load]) -> list[_native.Load]:
    """Returns the loads as native objects."""
    if isinstance(loads, Load):
        return [loads._native]
    try:
        found = list(loads)
    except TypeError:
        raise TypeError(f"loads = {loads!r}: expected a sequence of Load") from None
    for index, load in enumerate(found):
        if not isinstance(load, Load):
            raise TypeError(f"loads[{index}] = {load!r} is of type {type(load).__name__}: expected Load")
    return [load._native for load in found]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperRun(Result):
    """A motion of the paper's machine."""

    machine: ParameterValues
    "Machine of the motion."
    t: Floats
    "Times, shape (n,), s."
    s: Floats
    "Displacements x1, x2, x3 of box, block and secondary oscillator, shape (n, 3), m."
    v: Floats
    "Velocities, shape (n, 3), m/s; at the time of an impact, just after it."
    energy: NDArray[np.void]
    "Energy accounts since the start, shape (n,), fields mechanical, input, damped, impact, J."
    impacts: NDArray[np.void]
    "All impacts from the first to the last time, fields t (s), stop (+1, -1), speed (m/s), impulse (N.s)."
    rests: NDArray[np.void]
    "Beginnings of resting contact, fields t (s), stop."
    releases: NDArray[np.void]
    "Releases of the block from a stop, fields t (s), stop."

    @property
    def w(self) -> Floats:
        """Displacement of the block relative to the box, x2 - x1, shape (n,), m: within +-stop_gap."""
        found: Floats = self.s[:, 1] - self.s[:, 0]
        return found

    @property
    def end(self) -> Start:
        """Time and state at the last sample, as a start of a further motion."""
        numbers = np.concatenate([self.s[-1], self.v[-1]]).tolist()
        return Start({"time": float(self.t[-1]), **dict(zip(SI_COORDINATES, numbers))})

    @property
    def columns(self) -> list[str]:
        """Names of the columns of :attr:`values`."""
        return list(SI_COORDINATES)

    @property
    def values(self) -> Floats:
        """All columns, shape (n, 6), m and m/s."""
        return np.concatenate([self.s, self.v], axis=1)

    @property
    def events(self) -> NDArray[np.void]:
        """All events in order of time, in the form of a described machine: fields t (s), kind (impact, rest, release), element (stop.upper,
        stop.lower), value (the speed of an impact, m/s), stops."""
        found = np.empty(len(self.impacts) + len(self.rests) + len(self.releases), EVENT)
        at = 0
        for kind, some in (("impact", self.impacts), ("rest", self.rests), ("release", self.releases)):
            part = found[at : at + len(some)]
            part["t"], part["kind"], part["stops"] = some["t"], kind, 1
            part["element"] = np.where(some["stop"] > 0, "stop.upper", "stop.lower")
            part["value"] = some["speed"] if kind == "impact" else 0.0
            at += len(some)
        return found[np.argsort(found["t"], kind="stable")]

    def __getitem__(self, name: str) -> Floats:
        return column_of(self.columns, self.values, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the samples as a pandas DataFrame: columns named like the FMU's variables, energies, times as index. Requires pandas."""
        energy = {f"energy.{name}": self.energy[name] for name in ENERGY.names or ()}
        return frame({**dict(zip(self.columns, self.values.T)), **energy}, self.t)

    def to_xarray(self) -> xarray.Dataset:
        """Returns the samples as an xarray Dataset over the dimension ``time``; requires xarray."""
        return dataset(self.machine, self.columns, self.values, self.t)

    def _picture(self) -> str:
        names = [name for name in self.columns if name.endswith(".s")][:4]
        return lines([Line(self.t, self[name], name, colour=k) for k, name in enumerate(names)], "time (s)", "displacements, SI")


def run_of(machine: ParameterValues, t: Floats, found: dict[str, Any]) -> PaperRun:
    """Returns a run from the result of the computation."""
    impacts, rests, releases = (
        records(kind, found[name]) for name, kind in (("impacts", IMPACT), ("rests", CONTACT), ("releases", CONTACT))
    )
    return PaperRun(machine, t, found["s"], found["v"], fields_of(ENERGY, found["energy"]), impacts, rests, releases)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperSection(Result):
    """A Poincaré section of the paper's machine."""

    machine: ParameterValues
    "Machine of the motion."
    at: str
    "Kind of the section: phase, upper or lower."
    t: Floats
    "Times, shape (n,), s."
    s: Floats
    "Displacements x1, x2, x3, shape (n, 3), m."
    v: Floats
    "Velocities, shape (n, 3), m/s; just after the impact at a stop."
    phase: Floats
    "Phase of the drive, shape (n,), rad in [0, 2 pi)."
    speed: Floats
    "Approach speed |w'| before the impact, shape (n,), m/s; zero for a section at a phase."

    def _picture(self) -> str:
        if self.at == "phase":
            return lines([Line(self.s[:, 1], self.v[:, 1], dots=True)], "block.s (m)", "block.v (m/s)")
        return lines([Line(self.phase, self.speed, dots=True)], "phase (rad)", f"speed at stop.{self.at} (m/s)")
