"""A 3-DOF vibro-impact system on NumPy arrays: exact motions, studies, closed forms, periodic orbits.

A box on a spring is driven near resonance, a block flies in it between two stops, a secondary oscillator hangs on the block.
Between impacts the motion is propagated exactly, and every impact is located to round-off.

>>> import vibro_impact as vi
>>> machine = vi.Machine.from_groups(f10=1.5, kappa=0.75)
>>> run = machine.simulate(periods=200)
>>> run.s.shape
(40001, 3)

Lengths are in m, times in s, masses in kg, forces in N unless said otherwise. Long calls let other threads of Python run, end on
Ctrl-C, and show a bar with ``progress=True``. The model is that of P. Fritzkowski and J. Awrejcewicz, Nonlinear Dynamics 106 (2021)
81-103; the default data set is a reconstruction, not the paper's own.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._assembly import Assembly
from ._assembly_fit import AssemblyFit, MachineFit, Segment, fit
from ._assembly_locus import LOCUS_LABELS, AssemblyLocus
from ._assembly_orbits import ASSEMBLY_LABELS, AssemblyBranch, AssemblyOrbit
from ._assembly_results import AssemblyDiagram, AssemblyDirection, AssemblyEnds, AssemblyRun, AssemblyTransition
from ._assembly_studies import AssemblyAttractor, AssemblyBasins, AssemblySection, AssemblySpectrum
from ._base import AnyMachine
from ._fmu import fmu_path
from ._machine import Machine
from ._many import Ends, measure_many, simulate_many
from ._measures import MEASURES, Spectrum
from ._motion import Load, Run, Section
from ._native import __version__
from ._orbits import LABELS, Branch, Orbit
from ._parameters import GROUP_NAMES, PARAMETERS, SI_NAMES, MixedParametersWarning, SimilarNameWarning
from ._sketch import Sketch
from ._start import Start
from ._steady import SteadyState, SteadyStates
from ._studies import Attractor, Basins, Diagram, Direction
from ._table import Table

if TYPE_CHECKING:
    from . import plot as plot

__all__ = [
    "ASSEMBLY_LABELS",
    "GROUP_NAMES",
    "LABELS",
    "LOCUS_LABELS",
    "MEASURES",
    "PARAMETERS",
    "SI_NAMES",
    "AnyMachine",
    "Assembly",
    "AssemblyAttractor",
    "AssemblyBasins",
    "AssemblyBranch",
    "AssemblyDiagram",
    "AssemblyDirection",
    "AssemblyEnds",
    "AssemblyFit",
    "AssemblyLocus",
    "AssemblyOrbit",
    "AssemblyRun",
    "AssemblySection",
    "AssemblySpectrum",
    "AssemblyTransition",
    "Attractor",
    "Basins",
    "Branch",
    "Diagram",
    "Direction",
    "Ends",
    "Load",
    "Machine",
    "MachineFit",
    "MixedParametersWarning",
    "Orbit",
    "Run",
    "Section",
    "Segment",
    "SimilarNameWarning",
    "Sketch",
    "Spectrum",
    "Start",
    "SteadyState",
    "SteadyStates",
    "Table",
    "__version__",
    "fit",
    "fmu_path",
    "measure_many",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    """`plot`, which needs matplotlib and is imported where it is asked for."""
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
