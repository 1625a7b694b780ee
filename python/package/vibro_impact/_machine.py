"""The machine with its motions, closed forms, orbits and measures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, MOST_ROWS, Start, array, choice, number, state, whole
from ._measures import Spectrum, measure_names, measured
from ._motion import Load, Run, Section, load_list, run_of
from ._orbits import Orbit, find_orbit
from ._progress import Bar
from ._steady import SteadyStates, steady_states
from ._values import ParameterValues

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import ArrayLike

    from ._studies import Basins, Diagram


class Machine(ParameterValues):
    """A vibro-impact machine: box, block between two stops in it, secondary oscillator, drive. An immutable value.

    Parameters are given by name, in SI (:data:`SI_NAMES`) or as dimensionless groups (:data:`GROUP_NAMES`), as in a parameter file of
    `vibro`; the symbols of the paper (``m1``, ``kappa``) are understood too. First those in SI are set, then the groups, which leave
    the other groups and the scales ``box_m``, ``box_k``, ``stop_gap`` as they are. What is not given comes from the default set, a
    reconstruction of the paper's machine. Of ``alpha23`` and ``beta2``, two names of one coupling, the one set last is held when
    ``epsilon`` changes, and ``secondary_m`` equals ``block_m`` until it or ``mu13`` is set.

    A machine without a spring between box and ground (``box_k=0``) has no groups, and starts and studies in their units are refused.

    Constant forces ``load_box``, ``load_block``, ``load_secondary`` (N) are parameters too: gravity on a vertical machine is
    ``load_block=-9.81 * block_m``. They take the machine its symmetry; closed forms refuse them.

    Two machines are equal when their physical parameters are, loads included.

    >>> Machine.from_groups(f10=2.5).replace(kappa=0.8)
    Machine.from_groups(f10=2.5, kappa=0.8)
    >>> Machine().replace(stop_gap=0.5, load_block=-0.02).drive_frequency
    1.04

    Warns
    -----
    MixedParametersWarning
        Where some physical parameters are given and others are left to the default set, whose values belong to a machine of 1 kg and a
        gap of 1 m. ``Machine().replace(...)`` says that this is meant, and does not warn.

    Raises
    ------
    TypeError
        For a name that is none, with the nearest one, and for what is no number.
    ValueError
        For a value out of its range.
    """

    def simulate(
        self,
        start: Start = None,
        *,
        periods: int = 200,
        per_period: int = 200,
        t: Optional[ArrayLike] = None,
        begin: float = 0.0,
        loads: Iterable[Load] = (),
        progress: bool = False,
    ) -> Run:
        """The exact motion with all its impacts, reported at equal steps of the drive's period or at given times.

        Steps are for reporting only: the result does not depend on them but for round-off (docs/guarantees.md). The bits are those of the
        FMU that is asked for the same times.

        Parameters
        ----------
        start
            The state at `begin`: a mapping of coordinates, ``x1, x2, x3`` (units of L), ``v1, v2, v3`` (L omega10) or ``box_s,
            block_s, secondary_s`` (m), ``box_v, block_v, secondary_v`` (m/s), all others zero; or the six last ones as numbers.
            Without it everything rests in the middle but the block, which moves up with L omega10.
        periods, per_period
            Drive periods from `begin` on and reports in each; ``periods * per_period + 1`` instants in all.
        t
            Instants instead, shape (n,), s, ascending from `begin` on.
        begin
            The time of the start, s. The phase of the drive is ``drive_frequency * time + drive_phase``.
        loads
            Force histories on the bodies.
        progress
            Whether a bar shows how far it is.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range; with `periods` for a machine whose drive has no frequency.
        RuntimeError
            For a motion that hardly progresses: a block that bounces without end.
        """
        begin = number("begin", begin)
        if t is None:
            self._needs_period("a run over periods")
            whole("periods", periods, 0, MOST_PERIODS)
            rows = whole("per_period", per_period, 1, MOST_ROWS) * periods + 1
            whole("periods * per_period + 1", rows, 1, MOST_ROWS)
            if not np.isfinite(begin + self.period * rows):
                raise ValueError(f"periods = {periods}: allowed is an end of the run that a double can hold")
            times = begin + self.period * np.arange(rows) / per_period
        else:
            times = array("t", t, "an array of shape (n,) of times in s, ascending")
            if len(times) and (times[0] < begin or (np.diff(times) < 0).any()):
                raise ValueError("t does not ascend from begin on: allowed are times in s, ascending from begin on")
        with Bar(progress, len(times), "instants") as bar:
            found = _native.simulate(
                self._system, state("start", start, self._system), begin, times, load_list(loads), bar.report
            )
        return run_of(self, times, found)

    def poincare(
        self,
        start: Start = None,
        *,
        at: str = "phase",
        phase: float = 0.0,
        periods: int = 2000,
        settle: int = 400,
        progress: bool = False,
    ) -> Section:
        """A Poincaré section: states at a phase of the drive, or just after the impacts at a stop.

        Parameters
        ----------
        start
            As of :meth:`simulate`, at time 0.
        at
            ``"phase"``, ``"upper"`` or ``"lower"``.
        phase
            The phase of the drive (rad) for ``at="phase"``.
        periods, settle
            Drive periods of the section, and those before it in which the transient dies out.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`.
        """
        self._needs_period("a section")
        stop = {"phase": 0, "upper": 1, "lower": -1}[choice("at", at, ("phase", "upper", "lower"))]
        periods = whole("periods", periods, 0, MOST_ROWS)
        settle = whole("settle", settle, 0, MOST_PERIODS)
        with Bar(progress, periods + settle, "periods") as bar:
            found = _native.poincare(
                self._system,
                state("start", start, self._system),
                stop,
                number("phase", phase),
                settle,
                periods,
                bar.report,
            )
        return Section(self, at, **found)

    def bifurcation(
        self,
        *,
        start: Start = None,
        periods: tuple[int, int] = (400, 800),
        of: str = "x2",
        exponents: Union[bool, int] = False,
        progress: bool = False,
        **parameter: ArrayLike,
    ) -> Diagram:
        """A bifurcation diagram: local maxima, classes and impacts of settled motions over a parameter, upwards and downwards.

        As in the paper, section 4: the last state at a value is the start of the next one. Maxima are exact, not samples. All cores are used;
        the result does not depend on their number.

        Parameters
        ----------
        **parameter
            The parameter by name with its values, equally spaced and rising: ``f10=np.linspace(0.5, 5, 451)``.
        start
            Where the motion at the first value of either direction starts, as of :meth:`simulate`: of the machine itself.
        periods
            Drive periods discarded and kept at each value; the defaults of this and of the others are those of the command line.
        of
            The displacement: ``"x1"``, ``"x2"``, ``"x3"`` or ``"w"``.
        exponents
            Whether Lyapunov exponents are computed as well, over 1500 drive periods or so many.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.

        Warns
        -----
        SimilarNameWarning
            For a symbol such as ``F10`` (N), from which the name of another parameter, ``f10``, differs by case alone.
        """
        from ._studies import diagram_of

        return diagram_of(self, parameter, start, periods, of, exponents, progress)

    def lyapunov(
        self, start: Start = None, *, periods: int = 1500, settle: int = 400, progress: bool = False
    ) -> Spectrum:
        """The seven Lyapunov exponents: six coordinates and the phase of the drive (docs/theory.md, section 11).

        Parameters
        ----------
        start
            As of :meth:`simulate`, at time 0.
        periods, settle
            Drive periods counted, and those before in which the transient dies out.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`.
        """
        self._needs_period("a Lyapunov spectrum")
        periods = whole("periods", periods, 1, 10_000_000)
        settle = whole("settle", settle, 0, MOST_PERIODS)
        with Bar(progress, periods + 50, "periods") as bar:
            found = _native.lyapunov(
                self._system, state("start", start, self._system), settle, periods, bar.report
            )
        return Spectrum(self, **found)

    def measure(
        self,
        measures: Sequence[str],
        start: Start = None,
        *,
        periods: int = 60,
        settle: int = 400,
        progress: bool = False,
    ) -> dict[str, float | str | None]:
        """Measures of the settled motion by name: :data:`MEASURES` has all, with units.

        A number is exact for the motion, not for samples of it; the measure ``class`` is a text, and one that is not defined for the
        machine is None.

        Parameters
        ----------
        measures
            Names such as ``"amplitude.x1"``, ``"impacts"``, ``"power.input"``.
        start
            As of :meth:`simulate`, at time 0.
        periods, settle
            Drive periods that are measured, and those before in which the transient dies out; the defaults are those of ``vibro sweep``.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`; for a name that is none, with the nearest one.
        """
        self._needs_period("a measure")
        names = measure_names(measures)
        with Bar(progress, 1, "motions") as bar:
            numbers, kind = _native.measure(
                self._system,
                state("start", start, self._system),
                names,
                whole("settle", settle, 0, MOST_PERIODS),
                whole("periods", periods, 1, MOST_PERIODS),
                bar.report,
            )
        return measured(names, numbers, kind)

    def sweep(
        self,
        measures: Sequence[str],
        start: Start = None,
        *,
        periods: int = 60,
        settle: int = 400,
        errors: str = "raise",
        progress: bool = False,
        **parameters: ArrayLike,
    ) -> list[dict[str, Any]]:
        """Measures of all combinations of parameters, on all cores: a dictionary for each, of its parameters and its measures.

        ``machine.sweep(["amplitude.x1"], f10=[1.0, 1.5], kappa=np.linspace(0.4, 0.8, 9))`` has 18 rows; the last parameter varies fastest.

        Parameters
        ----------
        measures, start, periods, settle
            As of :meth:`measure`.
        errors
            As of :func:`measure_many`.
        **parameters
            Each parameter by name with its values.
        """
        from ._many import sweep_of

        return sweep_of(self, parameters, measures, start, periods=periods, settle=settle, errors=errors, progress=progress)

    def basins(self, *, periods: int = 300, progress: bool = False, **ranges: tuple[float, float, int]) -> Basins:
        """Basins of attraction: where motions from a plane of two initial values end, with the attractors that coexist.

        Parameters
        ----------
        **ranges
            Two of x1, x2, x3 (units of L), v1, v2, v3 (L omega10), or in SI of box_s, block_s, secondary_s (m), box_v, block_v,
            secondary_v (m/s), the first across, each as (from, to, cells); the others are zero: ``v2=(-2, 2, 100), x1=(-1, 1, 100)``.
        periods
            Drive periods before a motion is recognized.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            For arguments out of their range; what the simulator refuses, starts outside the stops apart.
        """
        from ._studies import basins_of

        return basins_of(self, ranges, periods, progress)

    def steady(self, *, sheet: str = "upper") -> SteadyStates:
        """The symmetric motion with two impacts a drive period in closed form, by three theories (docs/theory.md, sections 6 to 9).

        Parameters
        ----------
        sheet
            Which of the two solutions: ``"upper"``, of the larger amplitude, or ``"lower"``.

        Raises
        ------
        ValueError, TypeError
            For another word.
        """
        return steady_states(self, choice("sheet", sheet, ("upper", "lower")))

    def orbit(
        self,
        word: Optional[str] = None,
        *,
        start: Start = None,
        period: int = 1,
        symmetric: bool = False,
        settle: int = 2000,
        tries: int = 400,
        progress: bool = False,
    ) -> Orbit:
        """A periodic orbit by the order of its impacts, stable or not; or the one on which a motion has settled.

        It is solved for its impact phases by Newton's method and certified: no impact that the word does not list
        (docs/theory.md, section 14).

        Parameters
        ----------
        word
            The stops in order over `period` drive periods, letters U and L; without it the orbit of the motion from `start` after
            `settle` drive periods.
        period
            Drive periods until the word repeats itself.
        symmetric
            Whether the word is half of a symmetric orbit and closes with the opposite sign; it then takes ``period`` half drive
            periods, an odd number.
        tries
            Guesses of the phases from which it is sought. Of several orbits with the word the stable one is returned, else the first.
            Where all that is found is an orbit of a shorter word, passed several times, or a symmetric one, that is returned with
            ``passages``.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.
        RuntimeError
            Where none is found.
        """
        self._needs_period("a periodic orbit")
        settle = whole("settle", settle, 0, MOST_PERIODS)
        period = whole("period", period, 1, 1000)
        tries = whole("tries", tries, 1, 1_000_000)
        return find_orbit(self, word, start, period, bool(symmetric), settle, tries, progress)
