"""The parameters of the paper's machine as an immutable value."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn, Optional, TypeVar

import numpy as np

from . import _native
from ._arguments import SI_COORDINATES, Floats, converted
from ._base import AnyMachine, Value, merged
from ._paper_parameters import GROUP_NAMES, PARAMETERS, SI_NAMES, MixedParametersWarning, as_changes, find, in_order, named, value_of, with_changes, written

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Self, Unpack

    from ._paper_parameters import Groups, Parameters


class ParameterValues(AnyMachine):
    """Thirteen physical parameters, three constant loads and, if defined, the dimensionless groups. Base of :class:`PaperMachine`; results import this base."""

    box_m: float
    "Mass of the box m1, kg."
    box_k: float
    "Stiffness between box and ground k1, N/m."
    box_c: float
    "Viscous damping between box and ground c1, N.s/m."
    block_m: float
    "Mass of the block m2, kg."
    secondary_m: float
    "Mass of the secondary oscillator m3, kg."
    secondary_k: float
    "Stiffness between secondary oscillator and ground k3, N/m."
    secondary_c: float
    "Viscous damping between secondary oscillator and ground c3, N.s/m."
    coupling_k: float
    "Stiffness between block and secondary oscillator k23, N/m."
    stop_gap: float
    "Gap L on either side of the centred block, m."
    stop_restitution: float
    "Restitution coefficient of the stops, 1."
    drive_amplitude: float
    "Amplitude F10 of the harmonic force on the box, N."
    drive_frequency: float
    "Angular frequency omega1 of the harmonic force, rad/s."
    drive_phase: float
    "Phase of the harmonic force at time 0, rad."
    load_box: float
    "Constant force on the box, N; 0 unless given."
    load_block: float
    "Constant force on the block, N: gravity on a vertical machine; 0 unless given."
    load_secondary: float
    "Constant force on the secondary oscillator, N; 0 unless given."
    epsilon: float
    "Mass ratio m2/m1."
    kappa: float
    "Restitution coefficient."
    f10: float
    "F10/(k1 L epsilon)."
    sigma1: float
    "Detuning of the drive: omega1/omega10 = 1 + epsilon sigma1 with omega10 = sqrt(k1/m1)."
    gamma1: float
    "c1/(m1 omega10 epsilon)."
    alpha23: float
    "Weak coupling k23/(k1 epsilon^2)."
    beta2: float
    "Coupling k23/(m2 omega10^2) = epsilon alpha23."
    sigma30: float
    "Detuning of the secondary oscillator: k3/(m3 omega10^2) = 1 + epsilon sigma30."
    gamma3: float
    "c3/(m3 omega10 epsilon)."
    mu13: float
    "Mass ratio m1/m3."

    _system: _native.System
    _si: dict[str, float]
    _groups: dict[str, float]

    def __init__(self, *given: NoReturn, **parameters: Unpack[Parameters]) -> None:
        if given:
            raise TypeError(_unnamed("vi.PaperMachine", given, "parameters as keywords, such as stop_gap=4e-3"))
        si, groups = named(parameters)
        self._fill(in_order(si), groups)
        missing = self._system.not_given()
        if missing:
            values = ", ".join(f"{name} = {value:.6g}" for name, value in missing)
            warnings.warn(
                f"the machine is given in SI without {values}: these are values of the default set, a machine of 1 kg, 1 N/m and a "
                "gap of 1 m. Give them too, or use vi.PaperMachine().replace(...) if the default values are meant",
                MixedParametersWarning,
                stacklevel=2,
            )

    @classmethod
    def from_groups(cls, *given: NoReturn, **groups: Unpack[Groups]) -> Self:
        """Returns the machine with these dimensionless groups, in the scales of the default set (m1 = 1 kg, k1 = 1 N/m, L = 1 m).

        Raises
        ------
        TypeError, ValueError
            As for the class; also for a physical parameter, which is not a group.
        """
        if given:
            raise TypeError(_unnamed("vi.PaperMachine.from_groups", given, "groups as keywords, such as f10=1.5"))
        si, found = named(groups)
        if si:
            raise TypeError(f"{next(iter(si))} is a physical parameter: expected one of {', '.join(GROUP_NAMES)}")
        return cls(**found)

    def replace(  # type: ignore[override] # names of keywords are checked
        self, changes: Optional[Mapping[str, Value]] = None, /, **parameters: Unpack[Parameters]
    ) -> Self:
        """Returns the machine with some parameters changed: ``replace({"stop.gap": "4 mm"})``, or ``replace(stop_gap=4e-3)``.

        A number is in SI, a text has its unit.

        Setting a group keeps the other groups; setting a physical parameter keeps the other physical parameters. If a physical parameter
        of a machine given by groups is set, the result is a machine in SI with all physical parameters given.

        Raises
        ------
        TypeError, ValueError
            As for the class.
        """
        made = type(self).__new__(type(self))
        made._fill(*self._changed(*as_changes(merged(changes, parameters, "changes"))))
        return made

    def _changed(self, si: dict[str, float], groups: dict[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Returns the SI values and the groups after changes."""
        before = {name: getattr(self, name) for name in SI_NAMES} if si and self._groups else self._si
        return in_order(with_changes(before, si)), with_changes({} if si else self._groups, groups)

    def _rows(self, names: list[str], table: Floats) -> tuple[Any, ...]:
        """Returns the machine with rows of parameter values for the library; each row has the machine that :meth:`replace` returns."""
        own = [find(name) for name in names]
        si, groups = self._changed(*as_changes({name: 0.0 for name in names}))
        order = [*si, *groups]
        return list(si.items()), list(groups.items()), [order.index(name) for name in own], table

    def _described_by(self, text: str) -> Any:
        """Returns the :class:`Machine` of a text."""
        raise NotImplementedError

    def _changes_period(self, name: str) -> bool:
        """Whether a parameter may change the period of the drive."""
        return find(name) in ("drive_frequency", "sigma1", "epsilon", "box_k", "box_m")

    def _in_si(self, given: str, values: ArrayLike) -> ArrayLike:
        """Converts texts with units to SI; returns numbers unchanged."""
        name = find(given)
        found: ArrayLike = converted(values, lambda value: value_of(name, given, value))
        return found

    @property
    def name(self) -> str:
        """The machine's name."""
        return "PaperMachine"

    @property
    def parameters(self) -> dict[str, float]:
        """All parameters with their values: SI parameters first, then the groups if they are defined."""
        return {name: vars(self)[name] for name in SI_NAMES + GROUP_NAMES if name in vars(self)}

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each parameter; ``1`` for a dimensionless parameter."""
        return {name: PARAMETERS[name][1] or "1" for name in self.parameters}

    @property
    def columns(self) -> list[str]:
        """Names of the columns of a motion: ``box.s``, ``block.s``, ``secondary.s`` (m), ``box.v``, ``block.v``, ``secondary.v`` (m/s)."""
        return list(SI_COORDINATES)

    def _fill(self, si: dict[str, float], groups: dict[str, float]) -> None:
        system = _native.System(list(si.items()), list(groups.items()))
        vars(self).update(zip(SI_NAMES + GROUP_NAMES, system.values()))
        vars(self).update(_system=system, _si=si, _groups=groups)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a machine is immutable: use replace({name}=...), which returns another machine")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a machine is immutable")

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            if name == "assembly":
                warnings.warn("assembly() is now described(); the old name works until 0.5", DeprecationWarning, stacklevel=2)
                return self.described
            try:
                found = _native.find(name)
            except TypeError as error:
                raise AttributeError(str(error)) from None
            if found == name:
                raise AttributeError(f"{name} is not defined: box_k = {self.box_k}, and the dimensionless form requires box_k > 0")
            return getattr(self, found)

    def __repr__(self) -> str:
        if self._si:
            return f"PaperMachine({written({**self._si, **self._groups})})"
        return f"PaperMachine.from_groups({written(self._groups)})" if self._groups else "PaperMachine()"

    def _physical(self) -> tuple[float, ...]:
        return tuple(getattr(self, name) for name in SI_NAMES)

    def __eq__(self, other: object) -> bool:
        return self._physical() == other._physical() if isinstance(other, ParameterValues) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._physical())

    def __reduce__(self) -> tuple[Any, ...]:
        return (_unpickled, (type(self), self._si, self._groups))

    @property
    def period(self) -> float:
        """Period of the drive 2 pi/omega1, s; infinite for a constant force."""
        return self._system.period()

    def _needs_period(self, what: str) -> None:
        if not np.isfinite(self.period):
            raise ValueError(f"drive_frequency = {self.drive_frequency}: {what} requires drive_frequency > 0 with a finite period")


def _unnamed(call: str, given: tuple[Any, ...], expected: str) -> str:
    """Returns the error message for values without a name; it names the class that takes a machine's file."""
    values = ", ".join(map(repr, given))
    return f"{call}({values}): expected {expected}; for a machine of your own write vi.Machine({given[0]!r})"


Values = TypeVar("Values", bound=ParameterValues)


def _unpickled(cls: type[Values], si: dict[str, float], groups: dict[str, float]) -> Values:
    made = cls.__new__(cls)
    made._fill(si, groups)
    return made
