"""A system of two FMUs in one SSP 1.0 archive: VibroImpact3DOF shaken by an unbalanced motor (drive_train.py, pythonfmu).

    python examples/coupling/ssp.py --out motor.ssp          # writes the archive and runs it in fmpy
    python examples/coupling/ssp.py --out motor.ssp --host libcosimpy

The archive contains both FMUs, the structure with its units, and a parameter set for each FMU (SystemStructure.ssd). Two signals go
from the machine to the motor: the box's acceleration, which excludes impacts, and the impulse of the stops on the box since
the start, which contains only impacts. Both are required; one alone describes another machine (drive_train.py).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from vibro import FMU, PathLike  # noqa: E402

#: Parameters by component and name; other parameters of VibroImpact3DOF keep their start values.
PARAMETERS: dict[str, dict[str, tuple[float, str]]] = {
    "machine": {"drive.amplitude": (0.0, "N"), "stop.gap": (0.2, "m"), "stop.restitution": (0.6, "1")},
    "motor": {
        "inertia": (0.5, "kg.m2"),
        "eccentricity": (0.14, "kg.m"),
        "torque": (0.4, "N.m"),
        "idle": (1.3, "rad/s"),
        "mass": (1.0, "kg"),
    },
}

#: Connectors by component: name, kind, unit.
CONNECTORS = {
    "machine": [
        ("box.f", "input", "N"),
        ("box.a", "output", "m/s2"),
        ("box.impulse", "output", "N.s"),
        ("box.s", "output", "m"),
        ("block.s", "output", "m"),
        ("stop.s", "output", "m"),
    ],
    "motor": [
        ("acceleration", "input", "m/s2"),
        ("impulse", "input", "N.s"),
        ("force", "output", "N"),
        ("speed", "output", "rad/s"),
    ],
}

SOURCES = {"machine": "VibroImpact3DOF.fmu", "motor": "DriveTrain.fmu"}

CONNECTIONS = [
    ("motor", "force", "machine", "box.f"),
    ("machine", "box.a", "motor", "acceleration"),
    ("machine", "box.impulse", "motor", "impulse"),
]

#: Units by name: exponents of the base units.
UNITS = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.s": {"kg": 1, "m": 1, "s": -1},
    "kg": {"kg": 1},
    "kg.m": {"kg": 1, "m": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "m": {"m": 1},
    "m/s2": {"m": 1, "s": -2},
    "rad/s": {"rad": 1, "s": -1},
    "1": {},
}

NAMESPACE = "http://ssp-standard.org/SSP1/"


def attributes(**values: object) -> str:
    """Formats XML attributes."""
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in values.items())


def units(prefix: str) -> str:
    """Returns the unit list of a file; `prefix` is the namespace of the list."""
    lines = [
        f"<ssc:Unit{attributes(name=name)}><ssc:BaseUnit{attributes(**base)}/></ssc:Unit>" for name, base in UNITS.items()
    ]
    return f"<{prefix}:Units>{''.join(lines)}</{prefix}:Units>"


def structure() -> str:
    """Returns the text of SystemStructure.ssd."""
    elements = []
    for component, source in SOURCES.items():
        connectors = "".join(
            f"<ssd:Connector{attributes(name=name, kind=kind)}><ssc:Real{attributes(unit=unit)}/></ssd:Connector>"
            for name, kind, unit in CONNECTORS[component]
        )
        elements.append(
            f"<ssd:Component{attributes(name=component, type='application/x-fmu-sharedlibrary', source=f'resources/{source}')}>"
            f"<ssd:Connectors>{connectors}</ssd:Connectors>{binding(component)}</ssd:Component>"
        )
    connections = "".join(
        f"<ssd:Connection{attributes(startElement=a, startConnector=b, endElement=c, endConnector=d)}/>"
        for a, b, c, d in CONNECTIONS
    )
    spaces = "".join(
        f' xmlns:{prefix}="{NAMESPACE}{name}"'
        for prefix, name in (
            ("ssd", "SystemStructureDescription"),
            ("ssc", "SystemStructureCommon"),
            ("ssv", "SystemStructureParameterValues"),
        )
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<ssd:SystemStructureDescription{spaces} name="ShakenMachine" version="1.0">'
        f'<ssd:System name="system"><ssd:Elements>{"".join(elements)}</ssd:Elements>'
        f"<ssd:Connections>{connections}</ssd:Connections></ssd:System>"
        f"{units('ssd')}"
        '<ssd:DefaultExperiment startTime="0" stopTime="300"/>'
        "</ssd:SystemStructureDescription>\n"
    )


def binding(component: str) -> str:
    """Returns the parameters of a component as XML."""
    values = "".join(
        f"<ssv:Parameter{attributes(name=name)}><ssv:Real{attributes(value=value, unit=unit)}/></ssv:Parameter>"
        for name, (value, unit) in PARAMETERS[component].items()
    )
    return (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>"
        f'<ssv:ParameterSet version="1.0" name="{component}"><ssv:Parameters>{values}</ssv:Parameters>'
        f"{units('ssv')}</ssv:ParameterSet>"
        "</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def build(fmu: PathLike, path: PathLike) -> Path:
    """Writes the archive."""
    from pythonfmu.builder import FmuBuilder

    with tempfile.TemporaryDirectory() as folder:
        FmuBuilder.build_FMU(Path(__file__).with_name("drive_train.py"), dest=folder)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("SystemStructure.ssd", structure())
            archive.write(fmu, f"resources/{SOURCES['machine']}")
            archive.write(Path(folder) / SOURCES["motor"], f"resources/{SOURCES['motor']}")
    return Path(path)


def run_fmpy(path: PathLike, stop: float, step: float) -> dict[str, Any]:
    """Returns time histories by connector, from fmpy. Without help, fmpy passes only one parameter set for the whole system."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import Parameter, ParameterSet, find_components, read_ssd

    given = ParameterSet(name="all")
    for component in find_components(read_ssd(str(path)).system):
        for bound in component.parameterBindings:
            for values in bound.parameterValues:
                given.parameters += [
                    Parameter(name=f"{component.name}.{p.name}", type=p.type, value=p.value) for p in values.parameters
                ]
    result = simulate_ssp(str(path), stop_time=stop, step_size=step, parameter_set=given)
    result = result[: round(stop / step)]  # fmpy adds up steps, and rounding may give one too many
    # A row holds the outputs at the end of the step that begins at its time.
    return {"time": result["time"] + step, **{name: result[name] for name in result.dtype.names if name != "time"}}


def run_libcosimpy(path: PathLike, stop: float, step: float) -> dict[str, Any]:
    """Returns the same from libcosimpy, which requires the archive as a folder and time in whole nanoseconds."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.WARNING)
    nanoseconds = round(step * 1e9)
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        execution = CosimExecution.from_ssp_file(ssp_path=folder, step_size=nanoseconds)
        observer = CosimObserver.create_last_value()
        if not execution.add_observer(observer=observer):
            raise RuntimeError("libcosimpy did not accept the observer")
        columns: dict[str, tuple[int, int]] = {}
        for component, connectors in CONNECTORS.items():
            index = execution.slave_index_from_instance_name(component)
            variables = {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=index)}
            columns.update({f"{component}.{name}": (index, variables[name]) for name, _, _ in connectors})
        rows = []
        for _ in range(round(stop / step)):
            if not execution.step():
                raise RuntimeError("libcosimpy: a step failed")
            rows.append([observer.last_real_values(i, [reference])[0] for i, reference in columns.values()])
    table = np.array(rows)
    history = {name: table[:, k] for k, name in enumerate(columns)}
    return {"time": nanoseconds * 1e-9 * np.arange(1, len(rows) + 1), **history}


HOSTS = {"fmpy": run_fmpy, "libcosimpy": run_libcosimpy}


def main() -> None:
    """Writes the archive, runs it, and prints the result."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--out", "--output", dest="output", default=Path("motor.ssp"), type=Path)
    parser.add_argument("--host", default="fmpy", choices=sorted(HOSTS))
    parser.add_argument("--stop", default=300.0, type=float, help="s")
    parser.add_argument("--step", default=0.01, type=float, help="communication step, s")
    arguments = parser.parse_args()
    path = build(arguments.fmu, arguments.output)
    result = HOSTS[arguments.host](path, arguments.stop, arguments.step)
    last = result["time"] > 0.8 * arguments.stop
    print(f"{path} in {arguments.host}, {arguments.stop:g} s in steps of {arguments.step:g} s; its last fifth:")
    print(f"  speed of the motor  {result['motor.speed'][last].mean():.4f} rad/s (idle {PARAMETERS['motor']['idle'][0]})")
    for name in ("box.s", "block.s", "stop.s"):
        values = result[f"machine.{name}"][last]
        print(f"  amplitude of {name:8} {(values.max() - values.min()) / 2.0:.4f} m")


if __name__ == "__main__":
    main()
