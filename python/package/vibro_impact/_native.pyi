"""Types of the native part."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Complex = NDArray[np.complex128]
_Progress = Callable[[int, int], object] | None
#: Parts of a result by field name.
_Parts = dict[str, Any]
#: Names and numbers of a start.
_Numbers = list[tuple[str, float]]
_Row = tuple[list[float | None], list[float], str | None, int | None, str | None]
#: Machines of many motions: one for each motion, or one with names and rows of parameter values.
_Machines = Sequence[Described] | tuple[Described, Sequence[str], _Floats]
_Systems = Sequence[System] | tuple[_Numbers, _Numbers, Sequence[int], _Floats]
#: Starts of many motions: states, or one start whose numbers are in units of L and L omega10 unless given in SI.
_Starts = _Floats | tuple[Sequence[float], Sequence[float | None]]

__all__ = [
    "Orbit",
    "Described",
    "Load",
    "PaperOrbit",
    "System",
    "__version__",
    "basins",
    "branches",
    "diagram",
    "locus",
    "orbit",
    "section",
    "spectrum",
    "transition",
    "paper_basins",
    "paper_bifurcation",
    "paper_branches",
    "columns_of_table",
    "design",
    "find",
    "fit",
    "paper_follow",
    "follow_many",
    "follow",
    "in_si",
    "paper_lyapunov",
    "paper_measure",
    "measure_many",
    "paper_measure_many",
    "paper_measures",
    "paper_orbit",
    "parameters",
    "paper_poincare",
    "paper_settled_orbit",
    "paper_simulate",
    "simulate_many",
    "simulate",
    "paper_simulate_many",
    "paper_steady",
    "paper_steady_motion",
]

__version__: str

@final
class System:
    def __new__(cls, si: Sequence[tuple[str, float]], groups: Sequence[tuple[str, float]]) -> System: ...
    def values(self) -> list[float]: ...
    def not_given(self) -> list[tuple[str, float]]: ...
    def period(self) -> float: ...
    def dimensional(self, coordinates: Sequence[float]) -> list[float]: ...

@final
class Described:
    def __new__(cls, text: str | None, path: str | None) -> Described: ...
    def name(self) -> str: ...
    def period(self) -> float | None: ...
    def text(self) -> str: ...
    def parameters(self) -> list[tuple[str, str, float, str]]: ...
    def columns(self) -> list[str]: ...
    def measures(self) -> list[tuple[str, str, str]]: ...
    def value(self, name: str, text: str) -> float: ...
    def replace(self, changes: Sequence[tuple[str, float | str]]) -> Described: ...
    def start(self, numbers: _Numbers, changes: Sequence[tuple[str, float | str]]) -> _Numbers: ...
    def read_start(self, path: str) -> _Numbers: ...
    def sketch(self) -> str: ...
    def sketch_as_png(self) -> bytes: ...
    def fmu(self, version: int, kit: str, path: str) -> None: ...
    def fmu_name(self, version: int) -> str: ...

@final
class Load:
    def __new__(cls, body: str, t: _Floats, force: _Floats, cubic: bool) -> Load: ...
    def at(self, t: _Floats) -> _Floats: ...

@final
class PaperOrbit:
    def __new__(cls, system: System, word: str, closing: int, half_periods: int, phases: _Floats) -> PaperOrbit: ...
    @property
    def word(self) -> str: ...
    @property
    def closing(self) -> int: ...
    @property
    def half_periods(self) -> int: ...
    @property
    def period(self) -> int: ...
    @property
    def passages(self) -> int: ...
    @property
    def multiplier_periods(self) -> float: ...
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
def in_si(si: str, text: str) -> tuple[float, bool] | None: ...
def parameters() -> tuple[int, list[tuple[str, str, str, str, str]]]: ...
def paper_simulate(
    system: System, start: Sequence[float], begin: float, t: _Floats, loads: Sequence[Load], progress: _Progress = None
) -> _Parts: ...
def paper_simulate_many(
    systems: _Systems, starts: _Starts, periods: int, in_rows: bool, progress: _Progress = None
) -> tuple[_Floats, _Floats, list[str | None]]: ...
def simulate(
    machine: Described, start: _Numbers, t: _Floats, parameters: Sequence[str], progress: _Progress = None
) -> _Parts: ...
def follow_many(
    machines: _Machines, starts: Sequence[_Numbers], t: _Floats, parameters: Sequence[str], progress: _Progress = None
) -> list[_Parts]: ...
def simulate_many(
    machines: _Machines, starts: Sequence[_Numbers], until: float, in_rows: bool, progress: _Progress = None
) -> tuple[_Floats, list[str | None]]: ...
def columns_of_table(machine: Described, text: str, names: dict[str, str]) -> list[tuple[str, list[float]]]: ...
def design(
    machine: Described,
    output: str,
    maximize: bool,
    vary: Sequence[tuple[str, float, float]],
    over: Sequence[tuple[str, Sequence[float], bool]],
    subject_to: Sequence[str],
    robust: float,
    evaluations: int,
    windows: tuple[int, int, int],
    starts: Sequence[_Numbers],
    section: float | str | None,
    progress: _Progress = None,
) -> _Parts: ...
def fit(
    records: Sequence[
        tuple[
            Described,
            _Numbers,
            _Floats,
            Sequence[tuple[str, _Floats]],
            Sequence[tuple[str, Sequence[float]]],
            Sequence[float] | None,
        ]
    ],
    free: Sequence[tuple[str, tuple[float, float] | None, bool]],
    filters: Sequence[tuple[str, int, float]],
    loss: str,
    segments: float | None,
    starts: int,
    progress: _Progress = None,
) -> list[_Parts]: ...
@final
class Orbit:
    @property
    def word(self) -> str: ...
    @property
    def period(self) -> float: ...
    @property
    def periods(self) -> int | None: ...
    @property
    def events(self) -> list[tuple[float, str, str]]: ...
    @property
    def multipliers(self) -> NDArray[np.complex128]: ...
    @property
    def stability(self) -> str: ...
    @property
    def violation(self) -> str | None: ...
    @property
    def start(self) -> _Numbers: ...
    def measure(self, name: str) -> float: ...
    def gradient(self, name: str) -> list[tuple[str, float | None, str]]: ...
    def energies(self) -> list[tuple[str, float]] | None: ...

def orbit(
    machine: Described,
    start: _Numbers,
    settle: int,
    section: float | str | None,
    word: str | None,
    periods: int | None,
    time: float | None,
    starts: int,
    progress: _Progress = None,
) -> Orbit: ...
def follow(
    orbit: Orbit, name: str, ends: tuple[float, float], of: str, progress: _Progress = None
) -> _Parts: ...
def branches(
    machine: Described,
    name: str,
    ends: tuple[float, float],
    of: str,
    start: _Numbers,
    seeds: int,
    depth: int,
    settle: int,
    section: float | str | None,
    progress: _Progress = None,
) -> list[_Parts]: ...
def locus(
    machine: Described,
    first: tuple[str, tuple[float, float]],
    second: tuple[str, tuple[float, float]],
    point: tuple[str, str, float],
    beside: list[tuple[float, float, _Numbers]],
    progress: _Progress = None,
) -> _Parts: ...
def basins(
    machine: Described,
    x: tuple[str, float, float, int],
    y: tuple[str, float, float, int],
    start: _Numbers,
    discard: int,
    section: float | str | None,
    progress: _Progress = None,
) -> _Parts: ...
def section(
    machine: Described,
    start: _Numbers,
    phase: float,
    settle: int,
    keep: int,
    section: float | str | None,
    progress: _Progress = None,
) -> _Parts: ...
def spectrum(
    machine: Described,
    start: _Numbers,
    settle: int,
    periods: int,
    section: float | str | None,
    progress: _Progress = None,
) -> _Parts: ...
def transition(machine: Described, start: _Numbers, until: float, progress: _Progress = None) -> _Parts: ...
def measure_many(
    machines: _Machines,
    starts: Sequence[_Numbers],
    names: Sequence[str],
    settle: int,
    periods: int,
    section: float | str | None,
    in_rows: bool,
    progress: _Progress = None,
) -> list[_Row]: ...
def diagram(
    machine: Described,
    name: str,
    ends: tuple[float, float],
    count: int,
    of: str,
    at_section: bool,
    periods: tuple[int, int],
    exponents: int | None,
    section: float | str | None,
    anew: bool,
    start: _Numbers,
    progress: _Progress = None,
) -> _Parts: ...
def paper_poincare(
    system: System,
    start: Sequence[float],
    stop: int,
    phase: float,
    discard: int,
    periods: int,
    progress: _Progress = None,
) -> _Parts: ...
def paper_bifurcation(
    system: System,
    start: Sequence[float] | None,
    name: str,
    ends: tuple[float, float],
    count: int,
    discard: int,
    keep: int,
    of: str,
    exponents: int | None,
    progress: _Progress = None,
) -> _Parts: ...
def paper_lyapunov(
    system: System, start: Sequence[float], discard: int, periods: int, progress: _Progress = None
) -> _Parts: ...
def paper_basins(
    system: System,
    x: tuple[int, float, float, int],
    y: tuple[int, float, float, int],
    start: Sequence[float],
    discard: int,
    progress: _Progress = None,
) -> _Parts: ...
def paper_measures() -> list[tuple[str, str, str]]: ...
def paper_measure(
    system: System, start: Sequence[float], names: Sequence[str], discard: int, periods: int, progress: _Progress = None
) -> _Row: ...
def paper_measure_many(
    systems: _Systems,
    starts: _Starts,
    names: Sequence[str],
    discard: int,
    periods: int,
    in_rows: bool,
    progress: _Progress = None,
) -> list[_Row]: ...
def paper_steady(system: System, theory: str, upper: bool) -> tuple[_Parts | None, str | None]: ...
def paper_steady_motion(system: System, theory: str, upper: bool, theta: _Floats) -> tuple[_Floats, _Floats]: ...
def paper_orbit(
    system: System, word: str, closing: int, half_periods: int, tries: int, progress: _Progress = None
) -> list[PaperOrbit]: ...
def paper_settled_orbit(
    system: System, start: Sequence[float], discard: int, progress: _Progress = None
) -> PaperOrbit: ...
def paper_follow(
    orbit: PaperOrbit, name: str, ends: tuple[float, float], weights: tuple[float, float, float], progress: _Progress = None
) -> _Parts: ...
def paper_branches(
    system: System,
    name: str,
    ends: tuple[float, float],
    weights: tuple[float, float, float],
    seeds: int,
    depth: int,
    settle: int,
    starts: int,
    progress: _Progress = None,
) -> list[_Parts]: ...
