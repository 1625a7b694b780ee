"""Machines of your own: bodies, springs, stops, friction, loads, from a file, a text or a dictionary."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, discarded_and_kept, evenly_spaced, seconds, whole
from ._base import merged
from ._instants import after, instants
from ._machine_description import MachineDescription
from ._machine_design import Design, design
from ._machine_fit import fit
from ._measures import Measures
from ._machine_many import SectionLike, measures_of, names_of, section_of
from ._machine_orbits import Branch, Orbit, find_branches, find_orbit
from ._machine_results import (
    Diagram,
    Direction,
    Ends,
    Run,
    Transition,
    run_of,
    transition_of,
)
from ._machine_start import StartLike, numbers_of, time_of
from ._sketch import Sketch
from ._start import Start
from ._machine_studies import Basins, Section, Spectrum, basins_of, poincare_of, spectrum_of
from ._fmu import kit_path
from ._progress import Bar
from ._result import direction

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._base import RecordLike
    from ._table import Table

_MOST_VALUES = 20_000


class Machine(MachineDescription):
    """A machine of your own; an immutable value.

    >>> import vibro_impact as vi
    >>> ball = vi.Machine({
    ...     "name": "Ball", "gravity": "9.81 m/s2",
    ...     "body": {"ball": {"mass": "20 g", "gravity": 1.0}},
    ...     "stop": {"floor": {"between": ["ground", "ball"], "gap": "1 m", "restitution": 0.9}},
    ... })
    >>> run = ball.simulate(until=2.0)
    >>> run["ball.s"].shape
    (1001,)

    Parameters
    ----------
    machine
        The path of a file, its text (with at least one line break), or a dictionary of the same form; docs/machine-file.md describes the
        form. Paths of records are relative to the folder of the file; in a text or a dictionary, records are lists of numbers. In a dictionary, a
        list may be a NumPy array, and a matrix may be a NumPy array or a sparse matrix of SciPy.

    Raises
    ------
    ValueError, TypeError
        If the description is invalid; the message names every problem.
    """

    __slots__ = ()

    def simulate(
        self,
        until: Union[None, float, str] = None,
        *,
        periods: Optional[int] = None,
        times: Optional[ArrayLike] = None,
        start: StartLike = None,
        samples: int = 1000,
        per_period: int = 200,
        derivatives: Iterable[str] = (),
        progress: bool = False,
    ) -> Run:
        """Simulates the motion exactly from event to event: bit-identical to ``vibro run FILE``.

        Parameters
        ----------
        until, samples
            End time, in s or as a text with a unit, and number of equal parts; the start is reported too.
        periods, per_period
            Alternative to an end time: number of common periods of the drives (:attr:`period`), and samples in each period.
        times
            Alternative: times to report, shape (n,), s, ascending.
        start
            Where the motion begins: numbers by name, ``{"time": 0.02, "box.s": "5 mm", "box.v": 0.1}``, in SI or as texts with units; ``run.end``
            of another motion; or the path of a start's file. Numbers that are not given have the machine's own values, at time 0.
        derivatives
            Parameters for which the run has exact derivatives of its columns, ``run.derivative("box.s", "stop.steel.gap")``, and of event
            times, through impacts, contacts and sticking; or numbers of the start: ``start.box.s``, ``start.box.v``, ``start.time``.
            If `start` is given, its state does not depend on any parameter of the machine.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        RuntimeError
            If a motion cannot continue; the message names the elements and the time.
        """
        numbers = numbers_of(self, start)
        t = instants(time_of(numbers), self.period, until, periods, times, samples, per_period)
        parameters = names_of(derivatives)
        with Bar(progress, len(t), "samples") as bar:
            found = _native.simulate(self._described, numbers, t, parameters, bar.report)
        return run_of(self, t, found, parameters)

    def start(self, numbers: StartLike = None) -> Start:
        """Returns a start of the machine; numbers that are not given have the machine's own values.

        Accepts numbers by name, in SI or as texts with units, or a start's file such as the ``end.toml`` of ``vibro run``.

        Raises
        ------
        ValueError, TypeError
            For unknown names (the message suggests the closest one), bodies with a ``motion``, and coordinates determined by links.
        """
        return Start({"time": 0.0, **dict(numbers_of(self, numbers, "numbers"))})

    def transition(self, until: Union[float, str], *, start: StartLike = None, progress: bool = False) -> Transition:
        """Returns the exact derivatives of the state at a time with respect to the state at the start, through impacts, contacts and sticking.

        The transition matrix of a motion is the product of the matrices of its parts. Over one period of a periodic motion, its eigenvalues
        are the multipliers.

        Parameters
        ----------
        until
            End time, in s or as a text with a unit.
        start
            As in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`.
        """
        numbers = numbers_of(self, start)
        end = after("until", seconds("until", until), time_of(numbers))
        with Bar(progress, 0, "parts") as bar:
            found = _native.transition(self._described, numbers, end, bar.report)
        return transition_of(self, found)

    def measure(
        self,
        measures: Sequence[str],
        *,
        periods: int = 60,
        settle: int = 300,
        section: SectionLike = None,
        start: StartLike = None,
        progress: bool = False,
    ) -> Measures:
        """Returns measures of the settled motion by name, like ``vibro sweep FILE``; :attr:`measures` lists all.

        `spread` of the result gives, by name, how much a measure scatters between windows of the motion: the standard error of a mean,
        or rounding if the motion repeats. `unsettled` names a measure that was still drifting during the measurement, or is ``"the motion"``, or None
        if all had settled.

        Parameters
        ----------
        periods, settle
            Measured returns to the section, and earlier returns for the transient; each is extended to at least
            four periods of the slowest oscillation with open stops (docs/machine-studies.md).
        section
            A period in s, or the name of a stop or friction whose events are the section; by default the common period of all harmonics.
        start
            As in :meth:`simulate`.
        """
        return measures_of(self, measures, start, periods, settle, section, progress)

    def sweep(
        self,
        measures: Sequence[str],
        parameters: Optional[Mapping[str, ArrayLike]] = None,
        *,
        periods: int = 60,
        settle: int = 300,
        section: SectionLike = None,
        start: StartLike = None,
        errors: str = "raise",
        executor: Any = None,
        checkpoint: Union[None, str, os.PathLike[str]] = None,
        progress: bool = False,
        **more: ArrayLike,
    ) -> Table:
        """Returns measures for all combinations of parameter values, computed on all cores.

        ``damper.sweep(["amplitude.box.s"], {"stop.steel.gap": ["3 mm", "4 mm"], "body.box.mass": [12.0, 13.0]})`` returns a table of shape (2, 2).

        Parameters
        ----------
        measures, periods, settle, section, start
            As in :meth:`measure`.
        parameters, **more
            Each parameter by name with its values, in the form that :meth:`replace` accepts.
        errors, executor, checkpoint
            As in :func:`measure_many`.
        """
        from ._many import sweep_of

        options = {"periods": periods, "settle": settle, "starts": start, "errors": errors, "executor": executor, "checkpoint": checkpoint}
        return sweep_of(self, merged(parameters, more, "parameters"), measures, progress=progress, section=section, **options)

    def spectrum(
        self, *, periods: int = 400, settle: int = 300, section: SectionLike = None, start: StartLike = None, progress: bool = False
    ) -> Spectrum:
        """Computes all Lyapunov exponents of the settled motion, exact through impacts, sticking and sliding: ``vibro lyapunov FILE --spectrum``.

        Parameters
        ----------
        periods, settle
            Evaluated returns to the section, and earlier returns for the transient.
        section, start
            As in :meth:`measure`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`.
        """
        return spectrum_of(self, periods, settle, section, start, progress)

    def poincare(
        self,
        section: SectionLike = None,
        *,
        phase: float = 0.0,
        periods: int = 1000,
        settle: int = 300,
        start: StartLike = None,
        progress: bool = False,
    ) -> Section:
        """Computes a Poincaré section of the settled motion: ``vibro section FILE``.

        Parameters
        ----------
        section
            As in :meth:`measure`; at an element's events, the columns have the values just after the event.
        phase
            Phase of the drive at the points of a section with a period, rad.
        periods, settle
            Number of points of the section, and earlier returns for the transient.
        start
            As in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`.
        """
        return poincare_of(self, section, phase, (start, periods, settle), progress)

    def basins(
        self,
        ranges: Optional[Mapping[str, Any]] = None,
        *,
        settle: int = 300,
        section: SectionLike = None,
        start: StartLike = None,
        progress: bool = False,
        **more: Any,
    ) -> Basins:
        """Computes basins of attraction over two numbers of the start, on all cores: bit-identical to ``vibro basin FILE``.

        ``damper.basins({"block.s": ("-4 mm", "4 mm", 60), "block.v": (-1.0, 1.0, 60)})``

        Parameters
        ----------
        ranges, **more
            Two of ``time`` and the bodies' coordinates and rates, each with (from, to, cells), in SI or as texts with units; the first is horizontal.
        settle, section
            As in :meth:`measure`.
        start
            The other numbers of the start, as in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        """
        return basins_of(self, merged(ranges, more, "ranges"), start, settle, section, progress)

    def bifurcation(
        self,
        of: Optional[str] = None,
        parameter: Optional[Mapping[str, ArrayLike]] = None,
        *,
        at_section: bool = False,
        periods: tuple[int, int] = (300, 100),
        exponents: Union[bool, int] = False,
        section: SectionLike = None,
        anew: bool = False,
        start: StartLike = None,
        progress: bool = False,
        **more: ArrayLike,
    ) -> Diagram:
        """Computes local maxima of a column over a parameter in both directions, with classes: bit-identical to ``vibro bifurcation FILE``.

        ``damper.bifurcation("box.s", {"stop.steel.gap": np.linspace(1e-3, 8e-3, 200)})``

        Parameters
        ----------
        of
            One of :attr:`columns`; by default the first.
        parameter, **more
            The parameter by name with its increasing, equally spaced values: numbers in SI, whatever unit the file uses, or texts with
            units, in the form that :meth:`replace` accepts: ``["3 mm", "4 mm", "5 mm"]``.
        at_section
            Whether to return the column's values at the section instead of its maxima.
        periods
            Returns to the section that are discarded and kept at each value.
        exponents
            Whether to compute the largest exponent, over 400 returns; a number sets the number of returns.
        section
            As in :meth:`measure`.
        anew
            Whether each value begins at the start; ``down`` then has no motions. Required for machines with a step or a record that continues
            after the first value's transient.
        start
            As in :meth:`simulate`: where the motion begins at the first value of either direction.
        """
        of = self.columns[0] if of is None else of
        given_by_name = merged(parameter, more, "parameter")
        if len(given_by_name) != 1:
            raise TypeError(f"parameters {list(given_by_name)}: expected exactly one parameter, with increasing, equally spaced values")
        ((name, given),) = given_by_name.items()
        ends, count = evenly_spaced(name, self._in_si(name, given), _MOST_VALUES)
        discard, keep = discarded_and_kept(periods)
        counted = None if exponents is False else 400 if exponents is True else whole("exponents", exponents, 8, MOST_PERIODS)
        start_numbers = numbers_of(self, start)
        with Bar(progress, 0, "parts") as bar:
            found = _native.diagram(
                self._described, name, ends, count, of, bool(at_section), (discard, keep), counted, section_of(section), bool(anew), start_numbers, bar.report
            )
        up, down = (direction(Direction, found[way]) for way in ("up", "down"))
        return Diagram(self, name, of, up, down, found["hysteresis"], bool(at_section))

    def orbit(
        self,
        word: Optional[str] = None,
        *,
        period: Union[None, float, str] = None,
        start: StartLike = None,
        tries: int = 32,
        settle: int = 400,
        section: SectionLike = None,
        progress: bool = False,
    ) -> Orbit:
        """Finds the periodic orbit on which a motion settles, or an orbit with a given word or period, stable or unstable: ``vibro orbit FILE``.

        Parameters
        ----------
        word
            The orbit's events in order, ``"impact steel, press buffer"``, beginning with any of them. Impacts, chatter and press events always count;
            other kinds of events count only if the word mentions them.
        period
            Period of the orbit: ``"2T"`` for two common periods of the drive, or a time, in s or as a text with a unit.
        start
            As in :meth:`simulate`: where the motion begins.
        tries
            Number of random starts for an orbit with a word or period; used if the first motion does not pass near such an orbit.
        settle
            Returns to the section after which the motion counts as settled, unless it settles earlier.
        section
            As in :meth:`bifurcation`.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range; if the word cannot repeat; if the motion settles on no periodic orbit (the message gives its class);
            or if no orbit is found (the message lists the orbits that were).
        """
        return find_orbit(self, (word, period, tries), start, settle, section, progress)

    def branches(
        self,
        name: str,
        low: Union[float, str],
        high: Union[float, str],
        *,
        of: Optional[str] = None,
        start: StartLike = None,
        seeds: int = 24,
        depth: int = 3,
        settle: int = 400,
        section: SectionLike = None,
        progress: bool = False,
    ) -> list[Branch]:
        """Finds branches of periodic orbits over a parameter, stable or unstable: response curves and their bifurcations, ``vibro orbits FILE --tree``.

        Parameters
        ----------
        name, low, high
            The parameter and its range, in SI or as texts with units.
        of
            The measure that is kept for each orbit, such as ``amplitude.box.s``; by default the amplitude of the first free body.
        seeds
            Number of parameter values with settled motions: with the parameter increasing, with it decreasing, and, if
            `depth` is positive, from `start`. Branches begin at the orbits on which these motions settle.
        depth
            Cap on the branch switches in a row, at bifurcations and at touches of rigid stops. A branch that continues another one with
            different events, e.g. after the touch of a compliant stop, does not count as a switch.
        start, settle, section
            As in :meth:`orbit`.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        """
        return find_branches(self, name, (low, high), of, (start, seeds, depth, settle, section), progress)

    def response(
        self,
        name: str,
        low: Union[float, str],
        high: Union[float, str],
        *,
        of: Optional[str] = None,
        start: StartLike = None,
        seeds: int = 24,
        depth: int = 0,
        settle: int = 400,
        section: SectionLike = None,
        progress: bool = False,
    ) -> list[Branch]:
        """Finds the branches of orbits on which motions settle, for increasing and decreasing parameter: ``vibro response FILE``.

        Parameters
        ----------
        name, low, high, of, start, seeds, depth, settle, section
            As in :meth:`branches`; the default depth is 0.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range, or if no motion settles on an orbit that can be followed.
        """
        found = self.branches(
            name, low, high, of=of, start=start, seeds=seeds, depth=depth, settle=settle, section=section, progress=progress
        )
        if not found:
            raise ValueError(
                f"{name} from {low} to {high}: no motion settles on a periodic orbit that can be followed; try other starts, more "
                "discarded returns (settle) or more values (seeds)"
            )
        return found

    def fit(self, record: RecordLike, **options: Any) -> Any:
        """Fits parameters of the machine to a record, with their errors; :func:`fit` has the options."""
        return fit(self, record, **options)

    def design(self, **options: Any) -> Design:
        """Searches for the design with the best output; :func:`design` has the options."""
        return design(self, **options)

    def sketch(self) -> Sketch:
        """Draws the machine as an engineering sketch, which a notebook shows: byte-identical to ``vibro draw FILE``."""
        return Sketch(self._described)

    def fmu(self, path: Union[None, str, os.PathLike[str]] = None, version: int = 3) -> Path:
        """Writes the machine's FMU, for Co-Simulation and Model Exchange, and returns its path. Needs no compiler.

        Parameters
        ----------
        path
            The file, or a folder; by default the current folder. In a folder the file is called ``NAME.fmu`` for FMI 2.0 and ``NAME-FMI3.fmu`` for
            FMI 3.0, where NAME is the name of the machine.
        version
            2 for FMI 2.0, 3 for FMI 3.0.

        Raises
        ------
        ValueError, TypeError
            For another version.
        FileNotFoundError
            If the package was built without the library.
        OSError
            If the file cannot be written.
        """
        version = whole("version", version, 2, 3)
        to = Path(path) if path is not None else Path()
        if to.is_dir():
            to /= self._described.fmu_name(version)
        self._described.fmu(version, os.fspath(kit_path()), os.fspath(to))
        return to

    def __reduce__(self) -> tuple[Any, ...]:
        return (_from_text, (self.toml,))


def _from_text(text: str) -> Machine:
    return Machine._of(_native.Described(text, None))
