"""What the native functions return: the parts of results by name, of which the modules beside make results."""

from __future__ import annotations

from typing import Optional, TypedDict

import numpy as np
from numpy.typing import NDArray

from ._arguments import Floats

_Complex = NDArray[np.complex128]


class Impacts(TypedDict):
    t: Floats
    stop: NDArray[np.int8]
    speed: Floats
    impulse: Floats


class Contacts(TypedDict):
    t: Floats
    stop: NDArray[np.int8]


class Run(TypedDict):
    s: Floats
    v: Floats
    energy: Floats
    impacts: Impacts
    rests: Contacts
    releases: Contacts


class Section(TypedDict):
    t: Floats
    s: Floats
    v: Floats
    phase: Floats
    speed: Floats


class Direction(TypedDict):
    value: Floats
    classes: list[str]
    period: NDArray[np.int32]
    impacts: Floats
    rests: NDArray[np.bool_]
    maxima: Floats
    maxima_at: NDArray[np.int64]
    maxima_met: NDArray[np.uint32]
    exponents: Optional[Floats]


class BothDirections(TypedDict):
    up: Direction
    down: Direction
    hysteresis: NDArray[np.bool_]


class Spectrum(TypedDict):
    exponents: Floats
    deviation: float
    periods: int
    impacts: int
    rests: bool
    running: Floats


class Settled(TypedDict):
    class_name: str
    period: Optional[int]
    impacts: Floats
    rests: bool
    symmetric: bool
    states: Floats
    mirror_states: Floats
    sizes: Floats


class Basins(TypedDict):
    attractors: list[Settled]
    cells: NDArray[np.int32]
    mirror: NDArray[np.bool_]


class AssemblyRun(TypedDict):
    values: Floats
    t: Floats
    kind: list[str]
    element: list[str]
    value: Floats
    stops: NDArray[np.int32]
    energy: Floats


class AssemblyDirection(TypedDict):
    value: Floats
    classes: list[str]
    period: NDArray[np.int32]
    contacts: Floats
    rests: NDArray[np.bool_]
    maxima: Floats
    maxima_at: NDArray[np.int64]
    maxima_met: NDArray[np.uint32]
    exponent: Floats


class AssemblyDiagram(TypedDict):
    up: AssemblyDirection
    down: AssemblyDirection
    hysteresis: NDArray[np.bool_]


class Closed(TypedDict):
    amplitudes: Floats
    drive_phase: float
    geometric: bool
    fixed_point: bool
    periodic_motion: bool
    eigenvalues: _Complex
    multipliers: _Complex
    bifurcation: str


class Branch(TypedDict):
    word: str
    closing: int
    period: int
    closed: bool
    value: Floats
    phases: list[Floats]
    multipliers: _Complex
    stable: NDArray[np.bool_]
    labels: list[str]
    maxima: list[Floats]
