"""The paper's machine: its motions, closed forms, orbits and measures."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _native
from ._arguments import (
    MOST_PERIODS,
    MOST_ROWS,
    SI_COORDINATES,
    StartOfMachine,
    choice,
    coordinates,
    number,
    seconds,
    state,
    whole,
)
from ._machine import Machine
from ._machine_fit import fit
from ._base import Value, merged
from ._instants import instants
from ._measures import MEASURES, Measures, PaperSpectrum, measure_names, measured, of_paper
from ._paper_motion import Load, PaperRun, PaperSection, load_list, run_of
from ._paper_orbits import PaperBranch, PaperOrbit, find_branches, find_orbit
from ._paper_parameters import SI_NAMES
from ._progress import Bar
from ._sketch import Sketch
from ._start import Start
from ._paper_steady import SteadyStates, steady_states
from ._paper_studies import basins_of, diagram_of
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import ArrayLike

    from ._base import RecordLike
    from ._paper_studies import PaperBasins, PaperDiagram
    from ._table import Table


class PaperMachine(ParameterValues):
    """The paper's vibro-impact machine: box, block between two stops in it, secondary oscillator, drive. An immutable value.

    Parameters are given by name, in SI (:data:`SI_NAMES`) or as dimensionless groups (:data:`GROUP_NAMES`), as in a parameter file of
    `vibro`; the paper's symbols (``m1``, ``kappa``) are accepted too. SI parameters are set first. Each group then changes neither the
    other groups nor the scales ``box_m``, ``box_k``, ``stop_gap``. The default set, a reconstruction of the paper's machine, supplies
    missing parameters. ``alpha23`` and ``beta2`` express the same coupling: the one set last keeps its value when ``epsilon``
    changes. ``secondary_m`` equals ``block_m`` until ``secondary_m`` or ``mu13`` is set.

    A machine without a spring between box and ground (``box_k=0``) has no groups; starts and studies in units of groups are refused.

    Constant forces ``load_box``, ``load_block``, ``load_secondary`` (N) are parameters too: gravity on a vertical machine is
    ``load_block=-9.81 * block_m``. Constant forces break the machine's symmetry, so the closed forms refuse them.

    Two machines are equal if their physical parameters are equal, including the loads.

    >>> from vibro_impact import PaperMachine
    >>> PaperMachine.from_groups(f10=2.5).replace(kappa=0.8)
    PaperMachine.from_groups(f10=2.5, kappa=0.8)
    >>> PaperMachine().replace(stop_gap=0.5, load_block=-0.02).drive_frequency
    1.04

    Warns
    -----
    MixedParametersWarning
        If some but not all physical parameters are given: the default set belongs to a machine of 1 kg with a gap of 1 m and
        supplies the others. ``PaperMachine().replace(...)`` states that this is intended, and does not warn.

    Raises
    ------
    TypeError
        For an unknown name (the message suggests the closest one), or a value that is not a number.
    ValueError
        If a value is out of its range.
    """

    def simulate(
        self,
        until: Union[None, float, str] = None,
        *,
        periods: Optional[int] = None,
        times: Optional[ArrayLike] = None,
        start: StartOfMachine = None,
        samples: int = 1000,
        per_period: int = 200,
        loads: Iterable[Load] = (),
        progress: bool = False,
    ) -> PaperRun:
        """Simulates the exact motion with all its impacts, reported at equal steps or at given times.

        Steps are for reporting only: they change the result by no more than round-off (docs/guarantees.md). The result is bit-identical to
        the FMU at the same communication points.

        Parameters
        ----------
        until, samples
            End time, in s or as a text with a unit, and number of equal parts; the start is reported too.
        periods, per_period
            Alternative to an end time: number of drive periods, and samples in each period; ``periods * per_period + 1`` times in all.
        times
            Alternative: times to report, shape (n,), s, ascending, not before the start.
        start
            Where the motion begins: numbers by name, ``x1, x2, x3`` (units of L), ``v1, v2, v3`` (L omega10) or ``box.s``, ``block.v``, ... in SI
            or as texts with units (default 0), and ``time`` (s), at which the phase of the drive is ``drive_frequency * time + drive_phase``;
            or six numbers, displacements (m), then velocities (m/s); or ``run.end`` of another motion. By default, at time 0, everything
            rests in the middle except the block, which moves up with L omega10.
        loads
            Force histories on the bodies.
        progress
            Whether to show a progress bar.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range; with `periods`, if the drive has no frequency.
        RuntimeError
            If the motion hardly progresses because the block bounces without end.
        """
        begun = coordinates("start", start)
        if periods is not None:
            self._needs_period("a run over periods")
        t = instants(begun.time, self.period, until, periods, times, samples, per_period)
        with Bar(progress, len(t), "instants") as bar:
            found = _native.paper_simulate(
                self._system, begun.state(self._system), begun.time, t, load_list(loads), bar.report
            )
        return run_of(self, t, found)

    def start(self, numbers: StartOfMachine = None) -> Start:
        """Returns a start of the machine with all its numbers in SI, from any start that :meth:`simulate` accepts.

        Raises
        ------
        ValueError, TypeError
            For an unknown name; the message suggests the closest one.
        """
        begun = coordinates("numbers", numbers)
        return Start({"time": begun.time, **dict(zip(SI_COORDINATES, begun.state(self._system)))})

    def _begun(self, start: StartOfMachine) -> tuple[_native.System, list[float], float]:
        """Returns the system with its drive phase shifted by the start's time, the state at the start, and the start's time."""
        begun = coordinates("start", start)
        shift = self.drive_frequency * begun.time
        own = self.replace(drive_phase=self.drive_phase + shift) if shift else self
        return own._system, begun.state(self._system), begun.time

    def measure(
        self,
        measures: Sequence[str],
        *,
        periods: int = 60,
        settle: int = 400,
        start: StartOfMachine = None,
        progress: bool = False,
    ) -> Measures:
        """Returns measures of the settled motion by name; :attr:`measures` lists all, with units.

        A measure is exact for the motion over these periods; it is not computed from samples. `spread` of the result gives, by name, how much
        a measure scatters between windows of the motion: the standard error of a mean, or rounding if the motion repeats. The measure
        ``class`` is a text; a measure that is undefined for the machine is None. `unsettled` of the result names a measure that was still drifting
        during the measurement, or is ``"the motion"``, or None.

        Parameters
        ----------
        measures
            Names such as ``"amplitude.x1"`` or ``"amplitude.box.s"``, ``"impacts"``, ``"power.input"``.
        periods, settle
            Measured drive periods, and earlier periods for the transient; the defaults are the same as for ``vibro paper sweep``.
        start
            As in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`; for an unknown name (the message suggests the closest one).
        """
        self._needs_period("a measure")
        names = measure_names(measures)
        system, begin, _ = self._begun(start)
        settle, periods = whole("settle", settle, 0, MOST_PERIODS), whole("periods", periods, 1, MOST_PERIODS)
        with Bar(progress, 1, "motions") as bar:
            row = _native.paper_measure(system, begin, of_paper(names), settle, periods, bar.report)
        return measured(names, row)

    @property
    def measures(self) -> dict[str, str]:
        """All measures by name, each with its SI unit (``1`` if dimensionless) and meaning."""
        return {name: f"{unit or '1'}: {what}" for name, (unit, what) in MEASURES.items()}

    def sweep(
        self,
        measures: Sequence[str],
        parameters: Optional[Mapping[str, ArrayLike]] = None,
        *,
        periods: int = 60,
        settle: int = 400,
        start: StartOfMachine = None,
        errors: str = "raise",
        executor: Any = None,
        checkpoint: Union[None, str, os.PathLike[str]] = None,
        progress: bool = False,
        **more: ArrayLike,
    ) -> Table:
        """Returns measures for all combinations of parameter values, computed on all cores.

        ``machine.sweep(["amplitude.x1"], f10=[1.0, 1.5], kappa=np.linspace(0.4, 0.8, 9))`` returns a table of shape (2, 9).

        Parameters
        ----------
        measures, periods, settle, start
            As in :meth:`measure`; the start must be at time 0.
        parameters, **more
            Each parameter by name with its values, in SI or as texts with units.
        errors, executor, checkpoint
            As in :func:`measure_many`.
        """
        from ._many import sweep_of

        options = {"periods": periods, "settle": settle, "starts": start, "errors": errors, "executor": executor, "checkpoint": checkpoint}
        return sweep_of(self, merged(parameters, more, "parameters"), measures, progress=progress, **options)

    def bifurcation(
        self,
        of: Optional[str] = None,
        parameter: Optional[Mapping[str, ArrayLike]] = None,
        *,
        periods: tuple[int, int] = (400, 800),
        exponents: Union[bool, int] = False,
        start: StartOfMachine = None,
        progress: bool = False,
        **more: ArrayLike,
    ) -> PaperDiagram:
        """Computes a bifurcation diagram: local maxima, classes and impacts of settled motions over a parameter, up and down.

        As in section 4 of the paper, the last state at a value is the start for the next value. Maxima are exact, not sampled. The study uses
        all cores; the result does not depend on their number.

        Parameters
        ----------
        of
            The displacement: ``"x1"``, ``"x2"``, ``"x3"`` or ``"w"``, also ``"box.s"``, ``"block.s"``, ``"secondary.s"``; default ``"x2"``.
        parameter, **more
            The parameter by name with its increasing, equally spaced values: ``f10=np.linspace(0.5, 5, 451)``.
        periods
            Drive periods discarded and kept at each value. All defaults are the same as on the command line.
        exponents
            Whether to compute Lyapunov exponents too, over 1500 drive periods; a number sets the number of periods.
        start
            Where the motion at the first value of either direction begins, as in :meth:`simulate`, at time 0.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.

        Warns
        -----
        SimilarNameWarning
            For a symbol such as ``F10`` (N) that differs only by case from the name of another parameter, ``f10``.
        """
        return diagram_of(self, merged(parameter, more, "parameter"), start, periods, of, exponents, progress)

    def orbit(
        self,
        word: Optional[str] = None,
        *,
        period: Union[None, float, str] = None,
        start: StartOfMachine = None,
        tries: int = 400,
        settle: int = 2000,
        symmetric: bool = False,
        progress: bool = False,
    ) -> PaperOrbit:
        """Finds a periodic orbit with given impacts, stable or unstable, or the orbit on which a motion has settled.

        Newton's method solves for the impact phases. The orbit is certified to have only the impacts of its word
        (docs/theory.md, section 14).

        Parameters
        ----------
        word
            The stops in order, letters U and L; by default, the orbit of the motion from `start` after `settle` drive periods.
        period
            Period of the orbit: ``"2T"`` for two drive periods, or a time, in s or as a text with a unit; default ``"1T"`` with a word.
            Without a word, the settled motion must have this period.
        tries
            Number of guesses of the phases for Newton's method. If several orbits have the word, the first stable one is returned, or the first if
            none is stable. If only an orbit of a shorter word, passed several times, or a symmetric orbit is found, it is returned, and its
            ``passages`` count its traversals.
        symmetric
            Whether the word is half of a symmetric orbit and closes with opposite sign, after an odd number of half drive periods.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        RuntimeError
            If no orbit is found.
        """
        self._needs_period("a periodic orbit")
        settle = whole("settle", settle, 0, MOST_PERIODS)
        tries = whole("tries", tries, 1, 1_000_000)
        if word is None:
            if symmetric:
                raise TypeError("symmetric = True: requires `word`, the events of half the orbit")
            wanted = None if period is None else self._turns(period)
            system, begin, _ = self._begun(start)
            found = find_orbit(self, None, (system, begin, settle), 1, False, tries, progress)
            if wanted not in (None, found.periods):
                raise ValueError(
                    f"period = {period!r}: the motion settles on an orbit of {found.periods} drive periods; use the word of the wanted orbit, "
                    "another start, or no period"
                )
            return found
        return find_orbit(self, word, None, self._turns(period), bool(symmetric), tries, progress)

    def _turns(self, period: Union[None, float, str]) -> int:
        """Returns a period as a number of drive periods."""
        allowed = f"expected '1T' to '1000T', or a multiple of the drive's period, {self.period:.9g} s"
        if period is None:
            return 1
        if isinstance(period, str) and period.strip().endswith("T"):
            turns = period.strip()[:-1].strip()
            if turns.isdecimal() and 1 <= int(turns) <= 1000:
                return int(turns)
            raise ValueError(f"period = {period!r}: {allowed}")
        time = number("period", seconds("period", period))
        count = round(time / self.period)
        if not 1 <= count <= 1000 or abs(time - count * self.period) > 1e-6 * time:
            raise ValueError(f"period = {period!r}: {allowed}")
        return count

    def branches(
        self,
        name: str,
        low: Value,
        high: Value,
        *,
        of: Optional[str] = None,
        seeds: int = 24,
        depth: int = 3,
        settle: int = 1000,
        progress: bool = False,
    ) -> list[PaperBranch]:
        """Finds branches of periodic orbits over a parameter, stable or unstable, with their bifurcations: ``vibro paper orbits --tree``.

        Parameters
        ----------
        name, low, high
            The parameter and its range, in SI or as texts with units.
        of
            The displacement whose maxima are kept, as in :meth:`bifurcation`.
        seeds
            Number of parameter values with settled motions, for an increasing and for a decreasing parameter. Branches begin
            at the orbits on which these motions settle.
        depth
            Largest number of branch switches in a row.
        settle
            Drive periods for transients.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        """
        self._needs_period("a branch of orbits")
        return find_branches(self, name, (low, high), of, (seeds, depth, settle), progress)

    def response(
        self,
        name: str,
        low: Value,
        high: Value,
        *,
        of: Optional[str] = None,
        seeds: int = 24,
        depth: int = 0,
        settle: int = 1000,
        progress: bool = False,
    ) -> list[PaperBranch]:
        """Finds the branches of orbits on which motions settle, for increasing and decreasing parameter.

        Parameters
        ----------
        name, low, high, of, seeds, depth, settle
            As in :meth:`branches`; the default depth is 0.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range, or if no motion settles on an orbit that can be followed.
        """
        found = self.branches(name, low, high, of=of, seeds=seeds, depth=depth, settle=settle, progress=progress)
        if not found:
            raise ValueError(
                f"{name} from {low} to {high}: no motion settles on a periodic orbit that can be followed; try more "
                "discarded periods (settle) or more values (seeds)"
            )
        return found

    def poincare(
        self,
        section: Optional[str] = None,
        *,
        phase: float = 0.0,
        periods: int = 2000,
        settle: int = 400,
        start: StartOfMachine = None,
        progress: bool = False,
    ) -> PaperSection:
        """Computes a Poincaré section: states at a phase of the drive, or just after the impacts at a stop.

        Parameters
        ----------
        section
            A stop, ``"upper"`` or ``"lower"``; by default the section is at a phase.
        phase
            Phase of the drive of the section, rad.
        periods, settle
            Drive periods of the section, and earlier periods for the transient.
        start
            As in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`.
        """
        self._needs_period("a section")
        at = "phase" if section is None else choice("section", section, ("upper", "lower"))
        stop = {"phase": 0, "upper": 1, "lower": -1}[at]
        periods = whole("periods", periods, 0, MOST_ROWS)
        settle = whole("settle", settle, 0, MOST_PERIODS)
        angle = number("phase", phase)
        if stop and angle:
            raise ValueError(f"phase = {phase!r}: must be 0 at a section of a stop's impacts")
        system, begin, time = self._begun(start)
        with Bar(progress, periods + settle, "periods") as bar:
            found = _native.paper_poincare(system, begin, stop, angle, settle, periods, bar.report)
        return PaperSection(self, at, **{**found, "t": found["t"] + time if time else found["t"]})

    def spectrum(
        self, *, periods: int = 1500, settle: int = 400, start: StartOfMachine = None, progress: bool = False
    ) -> PaperSpectrum:
        """Computes the seven Lyapunov exponents, for six state variables and the phase of the drive (docs/theory.md, section 11).

        Parameters
        ----------
        periods, settle
            Evaluated drive periods, and earlier periods for the transient.
        start
            As in :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As in :meth:`simulate`.
        """
        self._needs_period("a Lyapunov spectrum")
        periods = whole("periods", periods, 1, 10_000_000)
        settle = whole("settle", settle, 0, MOST_PERIODS)
        system, begin, _ = self._begun(start)
        with Bar(progress, periods + 50, "periods") as bar:
            found = _native.paper_lyapunov(system, begin, settle, periods, bar.report)
        return PaperSpectrum(self, **found)

    def basins(
        self,
        ranges: Optional[Mapping[str, tuple[float, float, int]]] = None,
        *,
        settle: int = 300,
        start: StartOfMachine = None,
        progress: bool = False,
        **more: tuple[float, float, int],
    ) -> PaperBasins:
        """Computes basins of attraction: the attractors to which motions from a plane of two initial values lead.

        Parameters
        ----------
        ranges, **more
            Two of x1, x2, x3 (units of L), v1, v2, v3 (L omega10), or ``box.s``, ``block.v``, ... in SI, each with (from, to, cells); the first
            is horizontal: ``v2=(-2, 2, 100), x1=(-1, 1, 100)``.
        settle
            Drive periods after which a motion is classified.
        start
            The other numbers, as in :meth:`simulate`, at time 0; default 0.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            If an argument is out of its range, or the simulator refuses a motion, except for starts outside the stops.
        """
        middle = [0.0] * 6 if start is None else state("start", start, self._system)
        return basins_of(self, merged(ranges, more, "ranges"), settle, middle, progress)

    def fit(self, record: RecordLike, **options: Any) -> Any:
        """Fits parameters of the machine to a record, with their errors; :func:`fit` has the options."""
        return fit(self, record, **options)

    def described(self) -> Machine:
        """Returns the equivalent described machine: the same bodies, springs, stops, loads and values, started in the middle.

        Its motions agree to round-off. It offers everything that requires no groups: a file, a sketch, an FMU, derivatives, and connections to other
        bodies.

        Raises
        ------
        ValueError
            If the machine's drive has no frequency.
        """
        self._needs_period("the described machine")
        value = {name: repr(getattr(self, name)) for name in SI_NAMES}
        stop = f"gap = {value['stop_gap']}, restitution = {value['stop_restitution']} }}"
        start = self.start()["block.v"] if self.box_k > 0.0 else 0.0
        text = f"""name = "{self.name}"
body.box = {{ mass = {value["box_m"]} }}
body.block = {{ mass = {value["block_m"]}, start = {{ v = {start!r} }} }}
body.secondary = {{ mass = {value["secondary_m"]} }}
stop.upper = {{ between = ["box", "block"], {stop}
stop.lower = {{ between = ["block", "box"], {stop}
load.drive = {{ on = "box", amplitude = {value["drive_amplitude"]}, frequency = "{value["drive_frequency"]} rad/s", phase = {value["drive_phase"]} }}
"""
        springs = (("mount", "ground", "box", "box"), ("secondary_mount", "ground", "secondary", "secondary"), ("coupling", "block", "secondary", ""))
        for spring, first, second, own in springs:
            stiffness = value[f"{own}_k"] if own else value["coupling_k"]
            damping = value[f"{own}_c"] if own else "0.0"
            if (float(stiffness), float(damping)) != (0.0, 0.0):
                text += f'spring.{spring} = {{ between = ["{first}", "{second}"], stiffness = {stiffness}, damping = {damping} }}\n'
        for body in ("box", "block", "secondary"):
            if getattr(self, f"load_{body}"):
                text += f'load.{body} = {{ on = "{body}", constant = {value[f"load_{body}"]} }}\n'
        return Machine(text)

    def _described_by(self, text: str) -> Machine:
        return Machine(text)

    @property
    def toml(self) -> str:
        """The text of the file of :meth:`described`."""
        return self.described().toml

    def sketch(self) -> Sketch:
        """Draws the machine as an engineering sketch, which a notebook shows."""
        return self.described().sketch()

    def fmu(self, path: Union[None, str, os.PathLike[str]] = None, version: int = 3) -> Path:
        """Writes the FMU of :meth:`described`, with these values. :func:`fmu_path` returns the FMU that serves all of the paper's machines.

        Parameters
        ----------
        path, version
            As in :meth:`Machine.fmu`.

        Raises
        ------
        ValueError, TypeError, FileNotFoundError, OSError
            As in :meth:`Machine.fmu`.
        """
        return self.described().fmu(path, version)

    def steady(self, *, sheet: str = "upper") -> SteadyStates:
        """Computes the symmetric motion with two impacts per drive period in closed form, by three theories (docs/theory.md, sections 6 to 9).

        Parameters
        ----------
        sheet
            Choice of the solution: ``"upper"``, with the larger amplitude, or ``"lower"``.

        Raises
        ------
        ValueError, TypeError
            For any other word.
        """
        return steady_states(self, choice("sheet", sheet, ("upper", "lower")))
