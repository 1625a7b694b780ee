"""Types of the native part."""

from collections.abc import Callable, Sequence
from typing import TypedDict, final

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Complex = NDArray[np.complex128]
_Progress = Callable[[int], object] | None

__version__: str

@final
class System:
    def __new__(cls, si: Sequence[tuple[str, float]], groups: Sequence[tuple[str, float]]) -> System: ...
    def values(self) -> list[float]: ...
    def period(self) -> float: ...
    def dimensional(self, coordinates: Sequence[float]) -> list[float]: ...

@final
class Load:
    def __new__(cls, body: str, t: _Floats, force: _Floats, cubic: bool) -> Load: ...
    def at(self, t: _Floats) -> _Floats: ...

class Impacts(TypedDict):
    t: _Floats
    stop: NDArray[np.int8]
    speed: _Floats
    impulse: _Floats

class Contacts(TypedDict):
    t: _Floats
    stop: NDArray[np.int8]

class Run(TypedDict):
    s: _Floats
    v: _Floats
    energy: _Floats
    impacts: Impacts
    rests: Contacts
    releases: Contacts

class Section(TypedDict):
    t: _Floats
    s: _Floats
    v: _Floats
    phase: _Floats
    speed: _Floats

class Direction(TypedDict):
    value: _Floats
    classes: list[str]
    period: NDArray[np.int32]
    impacts: _Floats
    rests: NDArray[np.bool_]
    maxima: _Floats
    maxima_at: NDArray[np.int64]
    maxima_met: NDArray[np.uint32]
    exponents: _Floats | None

class BothDirections(TypedDict):
    up: Direction
    down: Direction
    hysteresis: NDArray[np.bool_]

class Spectrum(TypedDict):
    exponents: _Floats
    deviation: float
    periods: int
    impacts: int
    rests: bool
    running: _Floats

class Settled(TypedDict):
    class_name: str
    period: int | None
    impacts: _Floats
    rests: bool
    symmetric: bool
    states: _Floats
    mirror_states: _Floats
    sizes: _Floats

class Basins(TypedDict):
    attractors: list[Settled]
    cells: NDArray[np.int32]
    mirror: NDArray[np.bool_]

class Closed(TypedDict):
    amplitudes: _Floats
    drive_phase: float
    geometric: bool
    fixed_point: bool
    periodic_motion: bool
    eigenvalues: _Complex
    multipliers: _Complex
    bifurcation: str

class Branch(TypedDict):
    word: str
    closing: int
    period: int
    closed: bool
    value: _Floats
    phases: list[_Floats]
    multipliers: _Complex
    stable: NDArray[np.bool_]
    labels: list[str]
    maxima: list[_Floats]

@final
class Orbit:
    def __new__(cls, system: System, word: str, closing: int, half_periods: int, phases: _Floats) -> Orbit: ...
    @property
    def word(self) -> str: ...
    @property
    def closing(self) -> int: ...
    @property
    def half_periods(self) -> int: ...
    @property
    def period(self) -> int: ...
    @property
    def phases(self) -> _Floats: ...
    @property
    def speeds(self) -> _Floats: ...
    @property
    def multipliers(self) -> _Complex: ...
    @property
    def stable(self) -> bool: ...
    def motion(self, theta: _Floats) -> tuple[_Floats, _Floats]: ...
    def maxima(self, weights: Sequence[float]) -> _Floats: ...

def find(name: str) -> str: ...
def parameters() -> tuple[int, list[tuple[str, str, str, str]]]: ...
def simulate(
    system: System, start: Sequence[float], begin: float, t: _Floats, loads: Sequence[Load], progress: _Progress = None
) -> Run: ...
def simulate_many(
    systems: Sequence[System], starts: _Floats, periods: int, progress: _Progress = None
) -> tuple[_Floats, _Floats]: ...
def poincare(
    system: System,
    start: Sequence[float],
    stop: int,
    phase: float,
    discard: int,
    periods: int,
    progress: _Progress = None,
) -> Section: ...
def bifurcation(
    system: System,
    name: str,
    ends: tuple[float, float],
    count: int,
    discard: int,
    keep: int,
    of: str,
    exponents: int | None,
    progress: _Progress = None,
) -> BothDirections: ...
def lyapunov(
    system: System, start: Sequence[float], discard: int, periods: int, progress: _Progress = None
) -> Spectrum: ...
def basins(
    system: System,
    x: tuple[int, float, float, int],
    y: tuple[int, float, float, int],
    discard: int,
    progress: _Progress = None,
) -> Basins: ...
def measures() -> list[tuple[str, str, str]]: ...
def measure(
    system: System, start: Sequence[float], names: Sequence[str], discard: int, periods: int, progress: _Progress = None
) -> tuple[list[float | None], str | None]: ...
def steady(system: System, theory: str, upper: bool) -> tuple[Closed | None, str | None]: ...
def steady_motion(system: System, theory: str, upper: bool, theta: _Floats) -> tuple[_Floats, _Floats]: ...
def orbit(
    system: System, word: str, closing: int, half_periods: int, tries: int, progress: _Progress = None
) -> list[Orbit]: ...
def settled_orbit(
    system: System, start: Sequence[float], discard: int, progress: _Progress = None
) -> Orbit: ...
def follow(
    orbit: Orbit, name: str, ends: tuple[float, float], weights: tuple[float, float, float], progress: _Progress = None
) -> Branch: ...
