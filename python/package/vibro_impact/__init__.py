"""Exact simulation of vibro-impact machines on NumPy arrays: motions, studies, periodic orbits, FMUs.

A :class:`Machine` is described by a file, a text or a dictionary of bodies, springs, stops, friction and loads.

>>> import vibro_impact as vi
>>> ball = vi.Machine({
...     "name": "Ball", "gravity": "9.81 m/s2",
...     "body": {"ball": {"mass": "20 g", "gravity": 1.0}},
...     "stop": {"floor": {"between": ["ground", "ball"], "gap": "1 m", "restitution": 0.9}},
... })
>>> ball.simulate(until=2.0).events["kind"].tolist()
['impact', 'impact', 'impact']

A :class:`PaperMachine` is the machine of one paper: a box on a spring is driven near resonance, a block flies between two stops in
the box, and a secondary oscillator hangs on the block. It has closed forms and dimensionless groups.

>>> machine = vi.PaperMachine.from_groups(f10=1.5, kappa=0.75)
>>> machine.simulate(periods=200).s.shape
(40001, 3)

A page for coding assistants, ``AGENTS.md``, and all keys of a machine's file, ``docs/machine-file.md``, are in the folder of this
package.

Lengths are in m, times in s, masses in kg and forces in N unless stated otherwise. Long calls let other Python threads run, end on
Ctrl-C, and show a progress bar with ``progress=True``. The paper is P. Fritzkowski and J. Awrejcewicz, Nonlinear Dynamics 106 (2021)
81-103; the default data set is a reconstruction, not the paper's own.
"""

from __future__ import annotations

import importlib
import warnings
from typing import TYPE_CHECKING, Any

from ._base import AnyMachine
from ._fmu import fmu_path
from ._machine import Machine
from ._machine_design import Design, DesignMotion, Rival, design
from ._machine_fit import Fit, PaperFit, Segment, Suspect, fit, fit_records
from ._machine_locus import LOCUS_LABELS, Locus
from ._machine_orbits import LABELS, Branch, Orbit
from ._machine_results import Diagram, Direction, Ends, Run, Transition
from ._machine_studies import Attractor, Basins, Section, Spectrum
from ._many import PaperEnds, measure_many, simulate_many
from ._measures import MEASURES, PaperSpectrum
from ._native import __version__
from ._paper_machine import PaperMachine
from ._paper_motion import Load, PaperRun, PaperSection
from ._paper_orbits import PAPER_LABELS, PaperBranch, PaperOrbit
from ._paper_parameters import GROUP_NAMES, PARAMETERS, SI_NAMES, MixedParametersWarning, SimilarNameWarning
from ._paper_steady import SteadyState, SteadyStates
from ._paper_studies import PaperAttractor, PaperBasins, PaperDiagram, PaperDirection
from ._reduce import Reduced, reduce
from ._sketch import Sketch
from ._start import Start
from ._table import Table

if TYPE_CHECKING:
    from . import plot as plot

__all__ = [
    "GROUP_NAMES",
    "LABELS",
    "LOCUS_LABELS",
    "MEASURES",
    "PAPER_LABELS",
    "PARAMETERS",
    "SI_NAMES",
    "AnyMachine",
    "Attractor",
    "Basins",
    "Branch",
    "Design",
    "DesignMotion",
    "Diagram",
    "Direction",
    "Ends",
    "Fit",
    "Load",
    "Locus",
    "Machine",
    "MixedParametersWarning",
    "Orbit",
    "PaperAttractor",
    "PaperBasins",
    "PaperBranch",
    "PaperDiagram",
    "PaperDirection",
    "PaperEnds",
    "PaperFit",
    "PaperMachine",
    "PaperOrbit",
    "PaperRun",
    "PaperSection",
    "PaperSpectrum",
    "Reduced",
    "Rival",
    "Run",
    "Section",
    "Segment",
    "SimilarNameWarning",
    "Sketch",
    "Spectrum",
    "Start",
    "SteadyState",
    "SteadyStates",
    "Suspect",
    "Table",
    "Transition",
    "__version__",
    "design",
    "fit",
    "fit_records",
    "fmu_path",
    "measure_many",
    "reduce",
    "simulate_many",
]

#: Names of version 0.3 that this version still accepts, with their new names.
_OLD_NAMES = {
    "ASSEMBLY_LABELS": "LABELS",
    "Assembly": "Machine",
    "AssemblyAttractor": "Attractor",
    "AssemblyBasins": "Basins",
    "AssemblyBranch": "Branch",
    "AssemblyDiagram": "Diagram",
    "AssemblyDirection": "Direction",
    "AssemblyEnds": "Ends",
    "AssemblyFit": "Fit",
    "AssemblyLocus": "Locus",
    "AssemblyOrbit": "Orbit",
    "AssemblyRun": "Run",
    "AssemblySection": "Section",
    "AssemblySpectrum": "Spectrum",
    "AssemblyTransition": "Transition",
    "MachineFit": "PaperFit",
}


def __getattr__(name: str) -> Any:
    """Imports `plot` on first use, because it requires matplotlib; resolves names of version 0.3, with a warning."""
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    if name in _OLD_NAMES:
        new = _OLD_NAMES[name]
        warnings.warn(f"vi.{name} is now vi.{new}; the old name works until 0.5", DeprecationWarning, stacklevel=2)
        return globals()[new]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
