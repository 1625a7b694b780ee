"""The description of a machine of your own as an immutable value."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn, Optional, Union

from . import _native
from ._arguments import Floats, converted, number
from ._base import AnyMachine, Value, merged
from ._toml import toml

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Self


class _Names(type):
    """Metaclass whose error for a constructor of the paper's machine names the right class."""

    if not TYPE_CHECKING:

        def __getattr__(cls, name: str) -> Any:
            if name == "from_groups":
                raise AttributeError(f"{name} is a constructor of the paper's machine: write vi.PaperMachine.{name}(...)")
            raise AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")


class MachineDescription(AnyMachine, metaclass=_Names):
    """A described machine: its parameters, columns and measures. Base of :class:`Machine`; results import this base."""

    __slots__ = ("_described",)
    _described: _native.Described

    def __init__(
        self, machine: Union[None, str, os.PathLike[str], Mapping[str, Any]] = None, *more: NoReturn, **parameters: NoReturn
    ) -> None:
        if more:
            given = ", ".join(map(repr, (machine, *more)))
            raise TypeError(f"vi.Machine({given}): expected one argument; change numbers of the file with replace({{name: value}})")
        if machine is None or parameters:
            raise TypeError(_papers(parameters))
        if isinstance(machine, Mapping):
            described = _native.Described(toml(machine), None)
        elif isinstance(machine, str) and "\n" in machine:
            described = _native.Described(machine, None)
        elif isinstance(machine, (str, os.PathLike)):
            described = _native.Described(None, os.fspath(machine))
        else:
            raise TypeError(
                f"machine is of type {type(machine).__name__}: expected the path of a file, its text, or a dictionary of the same form"
            )
        object.__setattr__(self, "_described", described)

    @property
    def name(self) -> str:
        """The machine's name."""
        return self._described.name()

    @property
    def toml(self) -> str:
        """The text of its file, in SI with every digit."""
        return self._described.text()

    @property
    def parameters(self) -> dict[str, float]:
        """All parameters with their values, in SI whatever units the file uses; :attr:`units` has the SI units."""
        return {name: value for name, _, value, _ in self._described.parameters()}

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each parameter."""
        return {name: unit for name, unit, _, _ in self._described.parameters()}

    @property
    def columns(self) -> list[str]:
        """Names of the columns of a motion: ``box.s``, ``box.v``, ``box.a``; ``upper.e``, ``upper.rate``, ``upper.f``; ``shaker.f``."""
        return self._described.columns()

    @property
    def measures(self) -> dict[str, str]:
        """All measures by name, each with its SI unit (``1`` if dimensionless) and meaning."""
        return {name: f"{unit}: {what}" for name, unit, what in self._described.measures()}

    def replace(self, changes: Optional[Mapping[str, Value]] = None, /, **parameters: Value) -> Self:
        """Returns the machine with some parameters changed: ``replace({"stop.steel.gap": 4e-3, "body.box.mass": "12 kg"})``, or as keywords.

        A number is in SI, whatever units the file uses: 4e-3 is 4 mm. A text has its unit: ``"4 mm"``; ``"4"`` is
        refused if the parameter has a unit.

        Raises
        ------
        ValueError, TypeError
            For an unknown name (the message suggests the closest one), or a value that would be invalid in a file.
        """
        parameters = merged(changes, parameters, "changes")
        units = self.units if any(isinstance(value, str) for value in parameters.values()) else {}
        for name, value in parameters.items():
            if not isinstance(value, str):
                number(name, value)
            elif is_number(value) and units.get(name, "1") != "1":
                raise ValueError(f"{name} = {value!r}: expected a number in {units[name]}, or a text with a unit")
        new = [(name, v if isinstance(v, str) else float(v)) for name, v in parameters.items()]
        return self._of(self._described.replace(new))

    @property
    def period(self) -> float:
        """Common period of all drives of the machine, s; infinite if nothing drives it or no common period exists."""
        found = self._described.period()
        return float("inf") if found is None else found

    def _rows(self, names: list[str], table: Floats) -> tuple[Any, ...]:
        """Returns the machine, names and rows of parameter values, in the form that the library reads."""
        own = self.parameters
        for name in names:
            if name not in own:
                self.replace({name: 0.0})  # the error suggests the closest name
        return self._described, names, table

    def _in_si(self, name: str, given: ArrayLike) -> ArrayLike:
        """Converts texts with units to SI; returns numbers unchanged."""
        # The machine may be invalid with only one of several new values: only the machine with all
        # of them is checked.
        found: ArrayLike = converted(given, lambda value: self._value(name, value))
        return found

    def _value(self, name: str, value: Any) -> float:
        """Returns a value of a parameter in SI, from a number in SI or a text with a unit."""
        if not isinstance(value, str):
            return number(name, value)
        units = self.units
        if is_number(value) and units.get(name, "1") != "1":
            raise ValueError(f"{name} = {value!r}: expected a number in {units[name]}, or a text with a unit")
        return self._described.value(name, value)

    @classmethod
    def _of(cls, described: _native.Described) -> Self:
        found = cls.__new__(cls)
        object.__setattr__(found, "_described", described)
        return found

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a machine is immutable; replace() returns a machine with other values")

    def __repr__(self) -> str:
        return f"Machine({self.name!r}, {len(self.parameters)} parameters)"

    def __eq__(self, other: object) -> bool:
        return self.toml == other.toml if isinstance(other, MachineDescription) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.toml)


def _papers(parameters: Mapping[str, Any]) -> str:
    """Returns the message that shows how to write the paper's machine, whose parameters are keywords."""
    given = ", ".join(f"{name}={value!r}" for name, value in parameters.items())
    return (
        f"vi.Machine({given}): expected the path of a machine file, its text, or a dictionary of the same form; "
        f"for the paper's machine write vi.PaperMachine({given})"
    )


def is_number(text: str) -> bool:
    """Whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True
