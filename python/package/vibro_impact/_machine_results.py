"""Results of machines of your own, and their sketch."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._arguments import Floats
from ._machine_description import MachineDescription
from ._start import Start
from ._show import Line, lines
from ._result import EVENT, Result, column_of, fields_of, place_of, records
from ._tables import dataset, frame

if TYPE_CHECKING:
    import pandas
    import xarray
    from numpy.typing import NDArray

#: Kinetic energy, stored energy and balance, J. The balance is the work since the start, plus the energy added by steps of
#: stiffness, minus losses. The sum kinetic + stored - balance is constant.
ENERGY = np.dtype([("kinetic", "f8"), ("stored", "f8"), ("balance", "f8")])


def _masked(
    varied: Optional[tuple[Floats, NDArray[np.bool_]]], place: int
) -> np.ma.MaskedArray[Any, np.dtype[np.float64]]:
    """Returns the derivatives of a column, masked where none exists."""
    numbers, known = varied if varied is not None else (np.zeros((0, 1)), np.zeros((0, 1), bool))
    return np.ma.MaskedArray(numbers[:, place], ~known[:, place])


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """A motion of a machine of your own; ``run["box.s"]`` is an array."""

    machine: MachineDescription
    "Machine of the motion."
    t: Floats
    "Times, shape (n,), s."
    columns: list[str]
    "Names of the columns of `values`."
    values: Floats
    "Values, shape (n, k), SI; at the time of an event, just after it."
    events: NDArray[np.void]
    "All events, fields t (s), kind, element, value, stops."
    energy: NDArray[np.void]
    "Energies, shape (n,), fields kinetic, stored, balance, J."
    end: Start
    "Time and state at the end, as a start for another motion."
    parameters: list[str] = dataclasses.field(default_factory=list)
    "Parameters with respect to which derivatives are available."
    lost: dict[str, str] = dataclasses.field(default_factory=dict)
    "Parameters whose derivatives cease to exist at some time, with time, element and reason."
    _derivatives: Optional[tuple[Floats, NDArray[np.bool_]]] = dataclasses.field(default=None, repr=False)
    _event_derivatives: Optional[tuple[Floats, NDArray[np.bool_]]] = dataclasses.field(default=None, repr=False)

    def derivative(self, column: str, parameter: str) -> np.ma.MaskedArray[Any, np.dtype[np.float64]]:
        """Returns the exact derivative of a column with respect to a parameter of :meth:`Machine.simulate`, shape (n,), SI.

        It is masked from the time after which no derivative exists; :attr:`lost` gives the reason.

        Raises
        ------
        KeyError
            For an unknown column or parameter.
        """
        place = place_of(self.columns, column) * len(self.parameters) + place_of(self.parameters, parameter)
        return _masked(self._derivatives, place)

    def event_derivative(self, parameter: str) -> np.ma.MaskedArray[Any, np.dtype[np.float64]]:
        """Returns the derivative of the time of each of :attr:`events` with respect to a parameter, masked where none exists.

        Raises
        ------
        KeyError
            For an unknown parameter.
        """
        return _masked(self._event_derivatives, place_of(self.parameters, parameter))

    def __getitem__(self, name: str) -> Floats:
        return column_of(self.columns, self.values, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the samples as a pandas DataFrame with times as index; requires pandas."""
        return frame(dict(zip(self.columns, self.values.T)), self.t)

    def to_xarray(self) -> xarray.Dataset:
        """Returns the samples as an xarray Dataset over the dimension ``time``; requires xarray."""
        return dataset(self.machine, self.columns, self.values, self.t)

    def _picture(self) -> str:
        names = [name for name in self.columns if name.endswith(".s")][:4]
        return lines([Line(self.t, self[name], name, colour=k) for k, name in enumerate(names)], "time (s)", "displacements, SI")


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Ends(Result):
    """Final states of the motions of many machines; ``ends["box.s"]`` is an array."""

    t: float
    "Time of the end states, s."
    columns: list[str]
    "Names of the columns of `values`."
    values: Floats
    "Values, shape (n, k), SI."
    error: Optional[NDArray[Any]] = None
    "Reason why a motion has no end state and its values are masked, if ``errors='row'`` is given; otherwise None."

    def __getitem__(self, name: str) -> Floats:
        return column_of(self.columns, self.values, name)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Transition(Result):
    """Derivatives of the final state of a motion with respect to its initial state, through impacts, contacts and sticking."""

    machine: MachineDescription
    "Machine of the motion."
    start: Start
    "Start, with all its values."
    end: Start
    "End of the motion."
    states: list[str]
    "Names of rows and columns: free coordinates, ``box.s``, then their rates, ``box.v``."
    matrix: np.ma.MaskedArray[Any, np.dtype[np.float64]]
    "Shape (k, k), SI: `matrix[i, j]` is the derivative of end value i with respect to start value j; masked if it does not exist."
    lost: dict[str, str]
    "Start values without derivatives at the end, by name, with time, element and reason."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Direction(Result):
    """Settled motions of one direction of a diagram."""

    value: Floats
    "Parameter, shape (n,), SI, ascending."
    kind: NDArray[np.str_]
    "Class, shape (n,): 1T, 2T, ..., quasi-periodic, chaotic; periodic, settling; not settled; refused."
    period: NDArray[np.int32]
    "Period in returns to the section, shape (n,); 0 if there is none up to 32."
    contacts: Floats
    "Number of impacts and first touches per return, shape (n,)."
    rests: NDArray[np.bool_]
    "Whether a stop stays closed or a friction element sticks at some time, shape (n,)."
    maxima: Floats
    "Distinct maxima, or values at the section, shape (k,), SI, to seven digits."
    at: NDArray[np.int64]
    "Index in `value` of each maximum, shape (k,)."
    met: NDArray[np.uint32]
    "Number of occurrences of each maximum, shape (k,)."
    exponent: Floats
    "Largest Lyapunov exponent, shape (n,), 1/s; 0 if it was neither requested nor needed, or if :attr:`kind` is not decided."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Diagram(Result):
    """A bifurcation diagram in both directions."""

    machine: MachineDescription
    "The machine whose parameter varies."
    name: str
    "Name of the parameter."
    of: str
    "Name of the quantity."
    up: Direction
    "Motions with the parameter increasing."
    down: Direction
    "Motions with the parameter decreasing, in ascending order of values."
    hysteresis: NDArray[np.bool_]
    "Whether the two directions certainly end on different motions, shape (n,)."
    at_section: bool
    "Whether `maxima` has values at the section instead of maxima."

    def _picture(self) -> str:
        down, up = (Line(way.value[way.at], way.maxima, label, dots=True, colour=k) for k, (way, label) in enumerate(((self.down, "falling"), (self.up, "rising"))))
        return lines([down, up], self.name, f"{self.of}, SI")


def run_of(machine: MachineDescription, t: Floats, found: dict[str, Any], parameters: list[str]) -> Run:
    energy = fields_of(ENERGY, found["energy"])
    lost = {name: why for name, why in zip(parameters, found["lost"]) if why}
    varied = (found["derivatives"], found["event_derivatives"]) if parameters else (None, None)
    values, events = found["values"], records(EVENT, found)
    end = Start(dict(found["end"]))
    return Run(machine, t, machine.columns, values, events, energy, end, parameters, lost, *varied)


def transition_of(machine: MachineDescription, found: dict[str, Any]) -> Transition:
    numbers, known = found["matrix"]
    lost = {name: why for name, why in zip(found["names"], found["lost"]) if why}
    start, end = (Start(dict(found[of])) for of in ("start", "end"))
    return Transition(machine, start, end, found["names"], np.ma.MaskedArray(numbers, ~known), lost)
