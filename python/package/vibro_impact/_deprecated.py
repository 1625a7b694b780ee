"""Functions that are methods now; they go with the next version."""

from __future__ import annotations

import warnings
from typing import Any

from ._assembly import Assembly
from ._machine import Machine
from ._studies import Basins, Diagram


def bifurcation(machine: Machine, **options: Any) -> Diagram:
    """Deprecated name of :meth:`Machine.bifurcation`."""
    _require_machine(machine, "an Assembly has its own method bifurcation")
    _deprecated("bifurcation")
    return machine.bifurcation(**options)


def basins(machine: Machine, **options: Any) -> Basins:
    """Deprecated name of :meth:`Machine.basins`."""
    _require_machine(machine)
    _deprecated("basins")
    return machine.basins(**options)


def _require_machine(machine: object, of_assembly: str = "") -> None:
    if not isinstance(machine, Machine):
        own = f"; {of_assembly}" if of_assembly and isinstance(machine, Assembly) else ""
        raise TypeError(f"machine is of type {type(machine).__name__}: allowed is Machine{own}")


def _deprecated(name: str) -> None:
    text = f"vi.{name}(machine, ...) is deprecated and goes with the next version: machine.{name}(...) is the same"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
