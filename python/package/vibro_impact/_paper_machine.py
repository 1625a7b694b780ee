"""The paper's machine with its motions, closed forms, orbits and measures."""

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

    >>> from vibro_impact import PaperMachine
    >>> PaperMachine.from_groups(f10=2.5).replace(kappa=0.8)
    PaperMachine.from_groups(f10=2.5, kappa=0.8)
    >>> PaperMachine().replace(stop_gap=0.5, load_block=-0.02).drive_frequency
    1.04

    Warns
    -----
    MixedParametersWarning
        Where some physical parameters are given and others are left to the default set, whose values belong to a machine of 1 kg and a
        gap of 1 m. ``PaperMachine().replace(...)`` says that this is meant, and does not warn.

    Raises
    ------
    TypeError
        For a name that is none, with the nearest one, and for what is no number.
    ValueError
        For a value out of its range.
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
        """The exact motion with all its impacts, reported at equal steps or at given times.

        Steps are for reporting only: the result does not depend on them but for round-off (docs/guarantees.md). The bits are those of the
        FMU that is asked for the same times.

        Parameters
        ----------
        until, samples
            End of the motion, in s or as a text with a unit, and number of equal parts; there is a sample at the start too.
        periods, per_period
            Instead of a time: drive periods from the start on, and reports in each; ``periods * per_period + 1`` instants in all.
        times
            Instants instead, shape (n,), s, ascending from the start on.
        start
            Where the motion begins: numbers by name, ``x1, x2, x3`` (units of L), ``v1, v2, v3`` (L omega10) or ``box.s``, ``block.v``, ... in SI
            or as texts with units, all others zero, and ``time`` (s), at which the phase of the drive is ``drive_frequency * time +
            drive_phase``; or six numbers, displacements (m), then velocities (m/s); or ``run.end`` of another motion. Without it everything
            rests in the middle at time 0 but the block, which moves up with L omega10.
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
        """A start of the machine with all its numbers in SI: from what :meth:`simulate` takes.

        Raises
        ------
        ValueError, TypeError
            For unknown names, with the nearest one.
        """
        begun = coordinates("numbers", numbers)
        return Start({"time": begun.time, **dict(zip(SI_COORDINATES, begun.state(self._system)))})

    def _begun(self, start: StartOfMachine) -> tuple[_native.System, list[float], float]:
        """A machine whose drive has at time 0 the phase that this one has at the start, with the state and the time there."""
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
        """Measures of the settled motion by name: :attr:`measures` has all, with units.

        A number is exact for the motion over these periods, not for samples of it. `spread` of the result has by name how much it
        would scatter from one window of the motion to the next: its standard error if it is a mean, rounding where the motion repeats. The
        measure ``class`` is a text, and a measure that is not defined for the machine is None. `unsettled` of the result names a measure that
        still went one way while it was measured, or is None.

        Parameters
        ----------
        measures
            Names such as ``"amplitude.x1"`` or ``"amplitude.box.s"``, ``"impacts"``, ``"power.input"``.
        periods, settle
            Drive periods that are measured, and those before in which the transient dies out; the defaults are those of ``vibro paper sweep``.
        start
            As of :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`; for a name that is none, with the nearest one.
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
        """All measures by name: SI unit (``1`` for none) and meaning."""
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
        """Measures of all combinations of parameters, on all cores.

        ``machine.sweep(["amplitude.x1"], f10=[1.0, 1.5], kappa=np.linspace(0.4, 0.8, 9))`` is a table of shape (2, 9).

        Parameters
        ----------
        measures, periods, settle, start
            As of :meth:`measure`; the start at time 0.
        parameters, **more
            Each parameter by name with its values, in SI or as texts with units.
        errors, executor, checkpoint
            As of :func:`measure_many`.
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
        """A bifurcation diagram: local maxima, classes and impacts of settled motions over a parameter, upwards and downwards.

        As in the paper, section 4: the last state at a value is the start of the next one. Maxima are exact, not samples. All cores are used;
        the result does not depend on their number.

        Parameters
        ----------
        of
            The displacement: ``"x1"``, ``"x2"``, ``"x3"`` or ``"w"``, also ``"box.s"``, ``"block.s"``, ``"secondary.s"``; ``"x2"`` without it.
        parameter, **more
            The parameter by name with its values, equally spaced and rising: ``f10=np.linspace(0.5, 5, 451)``.
        periods
            Drive periods discarded and kept at each value; the defaults of this and of the others are those of the command line.
        exponents
            Whether Lyapunov exponents are computed as well, over 1500 drive periods or so many.
        start
            Where the motion at the first value of either direction starts, as of :meth:`simulate`, at time 0.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.

        Warns
        -----
        SimilarNameWarning
            For a symbol such as ``F10`` (N), from which the name of another parameter, ``f10``, differs by case alone.
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
        """A periodic orbit by the order of its impacts, stable or not; or the one on which a motion has settled.

        It is solved for its impact phases by Newton's method and certified: no impact that the word does not list
        (docs/theory.md, section 14).

        Parameters
        ----------
        word
            The stops in order, letters U and L; without it the orbit of the motion from `start` after `settle` drive periods.
        period
            Its period: ``"2T"`` for two drive periods, or a time, in s or as a text with a unit; of a word ``"1T"`` without it. Without a
            word that which the settled motion must have.
        tries
            Guesses of the phases from which it is sought. Of several orbits with the word the stable one is returned, else the first.
            Where all that is found is an orbit of a shorter word, passed several times, or a symmetric one, that is returned with
            ``passages``.
        symmetric
            Whether the word is half of a symmetric orbit and closes with the opposite sign, after half of an odd number of drive periods.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.
        RuntimeError
            Where none is found.
        """
        self._needs_period("a periodic orbit")
        settle = whole("settle", settle, 0, MOST_PERIODS)
        tries = whole("tries", tries, 1, 1_000_000)
        if word is None:
            if symmetric:
                raise TypeError("symmetric = True: allowed with a word, half of a symmetric orbit")
            wanted = None if period is None else self._turns(period)
            system, begin, _ = self._begun(start)
            found = find_orbit(self, None, (system, begin, settle), 1, False, tries, progress)
            if wanted not in (None, found.periods):
                raise ValueError(
                    f"period = {period!r}: the motion settles on an orbit of {found.periods} drive periods; allowed is the word of the orbit "
                    "that is sought, another start, or no period"
                )
            return found
        return find_orbit(self, word, None, self._turns(period), bool(symmetric), tries, progress)

    def _turns(self, period: Union[None, float, str]) -> int:
        """A period in drive periods."""
        allowed = f"allowed are '1T' to '1000T', or a multiple of the drive's period, {self.period:.9g} s"
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
        """Branches of periodic orbits over a parameter, stable or not, with their bifurcations: ``vibro paper orbits --tree``.

        Parameters
        ----------
        name, low, high
            The parameter and its range, in SI or as texts with units.
        of
            The displacement whose maxima are kept, as of :meth:`bifurcation`.
        seeds
            Values of the parameter at which motions are followed until they settle, rising and falling.
        depth
            Most changes from one branch to another in a row.
        settle
            Drive periods in which transients die out.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.
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
        """The response over a parameter: the branches of the orbits on which motions settle, rising and falling.

        Parameters
        ----------
        name, low, high, of, seeds, depth, settle
            As of :meth:`branches`, of which it is the case of depth 0.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range, and where no motion settles on an orbit that can be followed.
        """
        found = self.branches(name, low, high, of=of, seeds=seeds, depth=depth, settle=settle, progress=progress)
        if not found:
            raise ValueError(
                f"{name} from {low} to {high}: no motion settles on a periodic orbit that can be followed; allowed are more "
                "discarded periods (settle), more values (seeds)"
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
        """A Poincaré section: states at a phase of the drive, or just after the impacts at a stop.

        Parameters
        ----------
        section
            A stop, ``"upper"`` or ``"lower"``; without it the section is at a phase.
        phase
            That phase of the drive, rad.
        periods, settle
            Drive periods of the section, and those before it in which the transient dies out.
        start
            As of :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`.
        """
        self._needs_period("a section")
        at = "phase" if section is None else choice("section", section, ("upper", "lower"))
        stop = {"phase": 0, "upper": 1, "lower": -1}[at]
        periods = whole("periods", periods, 0, MOST_ROWS)
        settle = whole("settle", settle, 0, MOST_PERIODS)
        angle = number("phase", phase)
        if stop and angle:
            raise ValueError(f"phase = {phase!r}: allowed is 0 at a section of a stop's impacts")
        system, begin, time = self._begun(start)
        with Bar(progress, periods + settle, "periods") as bar:
            found = _native.paper_poincare(system, begin, stop, angle, settle, periods, bar.report)
        return PaperSection(self, at, **{**found, "t": found["t"] + time if time else found["t"]})

    def spectrum(
        self, *, periods: int = 1500, settle: int = 400, start: StartOfMachine = None, progress: bool = False
    ) -> PaperSpectrum:
        """The seven Lyapunov exponents: six coordinates and the phase of the drive (docs/theory.md, section 11).

        Parameters
        ----------
        periods, settle
            Drive periods counted, and those before in which the transient dies out.
        start
            As of :meth:`simulate`.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            As :meth:`simulate`.
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
        """Basins of attraction: where motions from a plane of two initial values end, with the attractors that coexist.

        Parameters
        ----------
        ranges, **more
            Two of x1, x2, x3 (units of L), v1, v2, v3 (L omega10), or in SI of ``box.s``, ``block.v``, ..., the first across, each as (from, to,
            cells): ``v2=(-2, 2, 100), x1=(-1, 1, 100)``.
        settle
            Drive periods before a motion is recognized.
        start
            The other numbers, as of :meth:`simulate`, at time 0; zero without it.

        Raises
        ------
        ValueError, TypeError, RuntimeError
            For arguments out of their range; what the simulator refuses, starts outside the stops apart.
        """
        middle = [0.0] * 6 if start is None else state("start", start, self._system)
        return basins_of(self, merged(ranges, more, "ranges"), settle, middle, progress)

    def fit(self, record: RecordLike, **options: Any) -> Any:
        """Numbers of the machine fitted to a record, with their errors: :func:`fit`, which has the options."""
        return fit(self, record, **options)

    def described(self) -> Machine:
        """The machine as a described one: the same bodies, springs, stops and loads with these numbers, started in the middle.

        Its motions are the same but for round-off; it has what needs no groups: a file, a sketch, an FMU, derivatives, joining to other parts.

        Raises
        ------
        ValueError
            For a machine whose drive has no frequency.
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
        """The machine as an engineer draws it; a notebook shows the picture."""
        return self.described().sketch()

    def fmu(self, path: Union[None, str, os.PathLike[str]] = None, version: int = 3) -> Path:
        """Writes an FMU of the machine with these numbers: that of :meth:`described`. :func:`fmu_path` has the one of all paper's machines.

        Parameters
        ----------
        path, version
            As of :meth:`Machine.fmu`.

        Raises
        ------
        ValueError, TypeError, FileNotFoundError, OSError
            As :meth:`Machine.fmu`.
        """
        return self.described().fmu(path, version)

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
