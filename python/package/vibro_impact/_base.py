"""The common interface of all machines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike
    from typing_extensions import Self

    from ._sketch import Sketch

    #: A record: times and values of each column, or the path of a table.
    RecordLike = Union[Mapping[str, tuple[ArrayLike, ArrayLike]], str, os.PathLike[str]]

#: A new value of a parameter: a number in SI, or a text with a unit.
Value = Union[float, str]


class AnyMachine:
    """Common base of :class:`PaperMachine`, the paper's machine of three bodies, and :class:`Machine`, a machine of your own.

    Both are immutable values with the members below. Parameters are given by name, as keywords or in a dictionary, ``{"stop.steel.gap":
    4e-3}``; numbers are in SI, texts have units. Columns have names such as ``box.s`` and ``box.v``. A period is the period of the drive; for
    a described machine, the common period of all its drives. docs/python.md lists the few members that only one of the classes has.
    """

    __slots__ = ()

    @property
    def name(self) -> str:
        """The machine's name."""
        raise NotImplementedError

    @property
    def toml(self) -> str:
        """The text of its file, in SI with every digit."""
        raise NotImplementedError

    @property
    def parameters(self) -> dict[str, float]:
        """All parameters with their values, in SI."""
        raise NotImplementedError

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each parameter; ``1`` for a dimensionless parameter."""
        raise NotImplementedError

    @property
    def columns(self) -> list[str]:
        """Names of the columns of a motion."""
        raise NotImplementedError

    @property
    def measures(self) -> dict[str, str]:
        """All measures by name, each with its SI unit (``1`` if dimensionless) and meaning."""
        raise NotImplementedError

    @property
    def period(self) -> float:
        """Period of the drive, s; infinite if nothing drives the machine periodically."""
        raise NotImplementedError

    def replace(self, changes: Optional[Mapping[str, Value]] = None, /, **parameters: Any) -> Self:
        """Returns the machine with some parameters changed."""
        raise NotImplementedError

    def start(self, numbers: Any = None) -> Mapping[str, float]:
        """Returns a start of the machine: its initial time and state."""
        raise NotImplementedError

    def simulate(
        self,
        until: Union[None, float, str] = None,
        *,
        periods: Optional[int] = None,
        times: Optional[ArrayLike] = None,
        start: Any = None,
        samples: int = 1000,
        per_period: int = 200,
        progress: bool = False,
    ) -> Any:
        """Simulates the motion until a time, over periods, or at given times."""
        raise NotImplementedError

    def measure(
        self, measures: Sequence[str], *, periods: int = 60, settle: int = 300, start: Any = None, progress: bool = False
    ) -> dict[str, float | str | None]:
        """Returns measures of the settled motion."""
        raise NotImplementedError

    def sweep(
        self,
        measures: Sequence[str],
        parameters: Optional[Mapping[str, ArrayLike]] = None,
        *,
        periods: int = 60,
        settle: int = 300,
        start: Any = None,
        errors: str = "raise",
        executor: Any = None,
        checkpoint: Union[None, str, os.PathLike[str]] = None,
        progress: bool = False,
        **more: Any,
    ) -> Any:
        """Returns measures for all combinations of parameter values."""
        raise NotImplementedError

    def bifurcation(
        self,
        of: Optional[str] = None,
        parameter: Optional[Mapping[str, ArrayLike]] = None,
        *,
        periods: tuple[int, int] = (300, 100),
        exponents: Union[bool, int] = False,
        start: Any = None,
        progress: bool = False,
        **more: Any,
    ) -> Any:
        """Computes a bifurcation diagram over a parameter, in both directions."""
        raise NotImplementedError

    def orbit(
        self,
        word: Optional[str] = None,
        *,
        period: Union[None, float, str] = None,
        start: Any = None,
        tries: int = 32,
        settle: int = 400,
        progress: bool = False,
    ) -> Any:
        """Finds a periodic orbit, stable or unstable."""
        raise NotImplementedError

    def branches(
        self,
        name: str,
        low: Value,
        high: Value,
        *,
        of: Optional[str] = None,
        seeds: int = 24,
        depth: int = 3,
        settle: int = 400,
        progress: bool = False,
    ) -> Any:
        """Finds branches of periodic orbits over a parameter, with their bifurcations."""
        raise NotImplementedError

    def response(
        self,
        name: str,
        low: Value,
        high: Value,
        *,
        of: Optional[str] = None,
        seeds: int = 24,
        depth: int = 0,
        settle: int = 400,
        progress: bool = False,
    ) -> Any:
        """Finds the branches of orbits on which motions settle, over a parameter."""
        raise NotImplementedError

    def poincare(
        self,
        section: Any = None,
        *,
        phase: float = 0.0,
        periods: int = 1000,
        settle: int = 300,
        start: Any = None,
        progress: bool = False,
    ) -> Any:
        """Computes a Poincaré section at a phase or at a stop."""
        raise NotImplementedError

    def spectrum(self, *, periods: int = 400, settle: int = 300, start: Any = None, progress: bool = False) -> Any:
        """Computes all Lyapunov exponents."""
        raise NotImplementedError

    def basins(
        self,
        ranges: Optional[Mapping[str, Any]] = None,
        *,
        settle: int = 300,
        start: Any = None,
        progress: bool = False,
        **more: Any,
    ) -> Any:
        """Computes basins of attraction over two numbers of the start."""
        raise NotImplementedError

    def fit(self, record: RecordLike, **options: Any) -> Any:
        """Fits parameters of the machine to a record."""
        raise NotImplementedError

    def sketch(self) -> Sketch:
        """Draws the machine as an engineering sketch."""
        raise NotImplementedError

    def fmu(self, path: Union[None, str, os.PathLike[str]] = None, version: int = 3) -> Path:
        """Writes the machine's FMU and returns its path."""
        raise NotImplementedError

    def _repr_svg_(self) -> Optional[str]:
        """The sketch that a notebook shows; None for a :class:`PaperMachine` that has no file, because its drive has no frequency."""
        try:
            return self.sketch().svg
        except ValueError:
            return None


def merged(first: Optional[Mapping[str, Any]], more: Mapping[str, Any], what: str) -> dict[str, Any]:
    """Merges values by name from a dictionary and from keywords; each name may occur once."""
    if first is not None and not isinstance(first, Mapping):
        raise TypeError(f"{what} is of type {type(first).__name__}: expected a dictionary such as {{'stop.steel.gap': ...}}, or keywords")
    twice = [name for name in first or {} if name in more]
    if twice:
        raise TypeError(f"{twice[0]} is given twice: expected each name once")
    return {**(first or {}), **more}
