"""A sweep or a plane of machines on dask: a cluster of this machine's cores, or any scheduler.

    python examples/dask_sweep.py --machine damper.toml --vary stop.steel.gap=0.01:0.13:200 --measure amplitude.box.s --out sweep.parquet
    python examples/dask_sweep.py --vary drive.frequency=0.9:1.2:200 --out sweep.parquet
    python examples/dask_sweep.py --vary drive.frequency=0.9:1.2:100 --vary drive.amplitude=0.05:0.25:50 \\
        --set stop.restitution=0.6 --scheduler tcp://node1:8786 --out plane.parquet
    python examples/dask_sweep.py --fmu target/VibroImpact3DOF.fmu --vary drive.frequency=0.9:1.2:200

Every point is a motion whose last periods are measured. Workers need only the Python package, which measures exactly. With --machine, the
machine is one of your own, from its file with its own start, with parameters in SI and any of its measures (--measure); it is sent to the
workers with the points. Without --machine, the machine is the paper's, and the following applies. With --fmu, workers need
fmpy and numpy instead, and measure from samples; use it for an FMU that is part of a larger model. The FMU is sent to all workers,
including those that join later. The table has the same names as `vibro sweep`, which needs no Python and splits its work with --shard. A motion
starts as in `vibro sweep`: at rest in the middle, except that the block moves with the speed L ω10 of the point, unless --set or --vary
gives another start. (A machine that starts at rest may never reach its first impact.) The table contains the start. A point that fails has
a row with its reason and without measured values. If a worker is lost, the others compute its points again. The table is the same for any
number of workers.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import tempfile
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Iterator, Mapping, Union

import numpy as np
from dask.distributed import Client, WorkerPlugin, as_completed, get_worker

if TYPE_CHECKING:
    from numpy.typing import NDArray

PLUGIN = "vibro-impact-fmu"
RETRIES = 10  # of a chunk after its worker is lost
BODIES = ("box.s", "block.s", "secondary.s")
START = (*BODIES, "box.v", "block.v", "secondary.v")
AMPLITUDES = ("amplitude.x1", "amplitude.x2", "amplitude.x3")  # largest |x|, m, with the names of `vibro paper sweep --list`
MEASURED = (*AMPLITUDES, "impacts.upper", "impacts.lower", "power.impact")

Row = dict[str, Union[float, str, None]]


class FmuPlugin(WorkerPlugin):  # type: ignore[misc] # distributed comes without types
    """Copies the FMU to a worker and unpacks it there once."""

    name = PLUGIN

    def __init__(self, archive: bytes) -> None:
        self.archive = archive

    def setup(self, worker: Any) -> None:
        """Called by dask on every worker, present and future."""
        import fmpy

        self.folder = tempfile.mkdtemp(prefix="vibro-impact-")
        path = Path(self.folder) / "model.fmu"
        path.write_bytes(self.archive)
        self.unzipped = fmpy.extract(str(path), unzipdir=str(Path(self.folder) / "model"))
        self.description = fmpy.read_model_description(self.unzipped)

    def teardown(self, worker: Any) -> None:
        """Called when a worker leaves."""
        shutil.rmtree(self.folder, ignore_errors=True)


@dataclass(frozen=True)
class Measure:
    """Simulation and measurement of a point by the Python package."""

    discard: int = 400  # drive periods before the measurement
    periods: int = 60  # drive periods measured

    def row(self, point: Mapping[str, float]) -> Row:
        """Returns the row of a point: given values, start, measures, and the reason if there are none."""
        defaults = self.defaults()
        given = {**moving_block({**defaults, **point}), **point}
        start = {name: given.get(name, defaults.get(name, 0.0)) for name in START}
        row: Row = {**point, **start, **dict.fromkeys(MEASURED), "reason": None}
        try:
            row.update(self.run(given))
        except Exception as error:  # any failure: the other points are still wanted
            row["reason"] = str(error) or type(error).__name__
        return row

    def defaults(self) -> dict[str, float]:
        """Returns names and values of all settings."""
        import vibro_impact as vi

        machine = vi.PaperMachine()
        parameters = {name.replace("_", ".", 1): getattr(machine, name) for name in vi.SI_NAMES}
        return {**parameters, **dict.fromkeys(START, 0.0)}

    def run(self, values: Mapping[str, float]) -> Mapping[str, Union[float, str, None]]:
        """Returns amplitudes (m), impacts per period, and power lost at the stops (W) over the last periods, for the given values."""
        import vibro_impact as vi

        parameters = {name.replace(".", "_"): value for name, value in values.items() if name not in START}
        start = [values.get(name, 0.0) for name in START]
        # All other parameters keep their defaults, as intended.
        return vi.PaperMachine().replace(**parameters).measure(MEASURED, start=start, settle=self.discard, periods=self.periods)


@dataclass(frozen=True)
class FmuMeasure(Measure):
    """Simulation and measurement of a point by the packaged FMU, with fmpy."""

    per_period: int = 64  # samples
    model: Any = None  # folder and description of the FMU; if None, the FMU that the worker has unpacked

    def opened(self) -> tuple[str, Any]:
        """Returns the folder and description of the FMU."""
        if self.model is not None:
            folder, description = self.model
            return folder, description
        plugin: Any = get_worker().plugins[PLUGIN]
        return plugin.unzipped, plugin.description

    def defaults(self) -> dict[str, float]:
        """Returns names and values of all settings."""
        variables = self.opened()[1].modelVariables
        settable = (v for v in variables if v.type == "Real" and v.start and v.causality != "input")
        return {v.name: float(v.start) for v in settable}

    def run(self, values: Mapping[str, float]) -> Mapping[str, Union[float, str, None]]:
        """Returns the same measures as the Python package, from samples."""
        import fmpy
        from fmpy.fmi1 import FMICallException

        unzipped, description = self.opened()
        period = 2.0 * math.pi / float(values.get("drive.frequency", self.defaults()["drive.frequency"]))
        names = [*BODIES, "impacts.upper", "impacts.lower", "energy.impact"]
        skipped = self.discard * period
        said: list[str] = []  # messages of the FMU, which name the invalid value and the accepted ones

        def listen(_environment: Any, _instance: Any, status: int, _category: Any, message: bytes) -> None:
            if status > 0:
                said.append(message.decode(errors="replace"))

        slave = fmpy.instantiate_fmu(unzipped, description, fmi_type="CoSimulation", logger=listen)
        references = {v.name: v.valueReference for v in description.modelVariables}
        try:
            slave.setupExperiment(startTime=0.0)
            for name, value in values.items():
                slave.setReal([references[name]], [value])
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            if skipped > 0.0:  # a single step, whatever happens in it
                slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=skipped)
            count = self.periods * self.per_period
            size = period / self.per_period
            reals = [references[name] for name in (*BODIES, "energy.impact")]
            counts = [references[name] for name in names[3:5]]
            rows = [slave.getReal(reals)]
            before = slave.getInteger(counts)
            for i in range(count):
                slave.doStep(currentCommunicationPoint=skipped + i * size, communicationStepSize=size)
                rows.append(slave.getReal(reals))
            after = slave.getInteger(counts)
            slave.terminate()
        except FMICallException as error:
            raise RuntimeError("; ".join(said) or str(error)) from error
        finally:
            slave.freeInstance()
        table: NDArray[np.float64] = np.array(rows)
        result: dict[str, Union[float, str, None]]
        result = {name: float(np.abs(table[:, k]).max()) for k, name in enumerate(AMPLITUDES)}
        result["impacts.upper"] = (after[0] - before[0]) / self.periods
        result["impacts.lower"] = (after[1] - before[1]) / self.periods
        result["power.impact"] = float(table[-1, 3] - table[0, 3]) / (self.periods * period)
        return result


def by_file(client: Client, arguments: argparse.Namespace) -> Any:
    """Returns the table of a machine's file; if a worker is lost, others compute its parts again."""
    import vibro_impact as vi

    machine = vi.Machine(arguments.machine).replace(dict(arguments.set))
    measures = arguments.measure or [next(iter(machine.measures)), "class"]
    return machine.sweep(
        measures,
        dict(arguments.vary),
        settle=arguments.discard,
        periods=arguments.periods,
        errors="row",
        executor=client,
        checkpoint=arguments.checkpoint,
    )


def moving_block(values: Mapping[str, float]) -> dict[str, float]:
    """Returns the start of the command line's studies: at rest in the middle, except that the block has the speed L ω10."""
    try:
        speed = values["stop.gap"] * math.sqrt(values["box.k"] / values["box.m"])
    except (ValueError, ZeroDivisionError):
        return {}  # the values are invalid for a box on a spring; the FMU reports which one
    return {"block.v": speed}


def chunk(measure: Measure, points: list[tuple[int, dict[str, float]]]) -> list[Row]:
    """Returns the rows of some points on a worker: index, varied values, measures."""
    return [{"index": index, **measure.row(point)} for index, point in points]


def grid(axes: Mapping[str, Iterable[float]], fixed: Mapping[str, float]) -> list[dict[str, float]]:
    """Returns all combinations of the axes; the last axis varies fastest."""
    return [{**fixed, **dict(zip(axes, map(float, values)))} for values in product(*axes.values())]


def sweep(
    client: Client, points: list[dict[str, float]], measure: Measure, fmu: Union[Path, None] = None, size: int = 8
) -> Iterator[list[Row]]:
    """Yields the rows of each finished chunk, in any order."""
    if fmu is not None:
        client.register_plugin(FmuPlugin(fmu.read_bytes()))
    numbered = list(enumerate(points))
    futures = [
        client.submit(chunk, measure, numbered[i : i + size], retries=RETRIES, pure=False)
        for i in range(0, len(numbered), size)
    ]
    for future in as_completed(futures):
        yield future.result()
        future.release()


def write(path: Path, rows: list[Row], measure: Measure) -> None:
    """Writes the table as Parquet, in the order of the points, completely or not at all."""
    import pyarrow as pa
    from pyarrow import parquet

    ordered = sorted(rows, key=lambda row: float(row["index"] or 0))
    names = [name for name in ordered[0] if name != "index"]
    # Explicit types, because a column may be empty: all points may fail, or none.
    columns = {
        name: pa.array([row[name] for row in ordered], pa.string() if name == "reason" else pa.float64()) for name in names
    }
    about = {"discard": measure.discard, "periods": measure.periods}
    if isinstance(measure, FmuMeasure):
        about["samples per period"] = measure.per_period
    table = pa.table(columns).replace_schema_metadata({k: str(v) for k, v in about.items()})
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    parquet.write_table(table, unfinished, compression="zstd")
    unfinished.replace(path)


def axis(text: str) -> tuple[str, NDArray[np.float64]]:
    """Parses NAME=FROM:TO:COUNT."""
    name, _, values = text.partition("=")
    try:
        low, high, count = values.split(":")
        return name, np.linspace(float(low), float(high), int(count))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: expected NAME=FROM:TO:COUNT") from None


def setting(text: str) -> tuple[str, float]:
    """Parses NAME=VALUE."""
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: expected NAME=VALUE") from None


def known(measure: Measure, names: Iterable[str]) -> None:
    """Raises for names that are neither a parameter nor a start value."""
    allowed = measure.defaults()
    for name in names:
        if name not in allowed:
            raise SystemExit(f"{name}: no such name; expected one of {', '.join(sorted(allowed))}")


def by_fmu(fmu: Path, discard: int, periods: int) -> FmuMeasure:
    """Returns the measurement by an FMU, whose names are read here."""
    import fmpy

    return FmuMeasure(discard, periods, model=("", fmpy.read_model_description(str(fmu))))


def connected(arguments: argparse.Namespace) -> Client:
    """Returns a client of the given scheduler, or of a cluster of this machine's cores."""
    if arguments.scheduler:
        return Client(arguments.scheduler)
    workers = arguments.workers or os.cpu_count()
    return Client(n_workers=workers, threads_per_worker=1, dashboard_address=None)


def main() -> None:
    """Makes or joins a cluster, sweeps, writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", type=Path, help="simulate with this FMU, in fmpy [default: the Python package]")
    parser.add_argument("--machine", type=Path, metavar="FILE", help="file of the machine [default: the paper's machine]")
    parser.add_argument("--measure", action="append", metavar="NAME", help="with --machine: a measure; may be repeated")
    parser.add_argument("--checkpoint", type=Path, help="with --machine: folder for the finished parts")
    parser.add_argument("--vary", action="append", type=axis, required=True, metavar="NAME=FROM:TO:COUNT")
    parser.add_argument("--set", action="append", default=[], type=setting, metavar="NAME=VALUE")
    parser.add_argument("--discard", default=Measure.discard, type=int, help="drive periods before the measurement")
    parser.add_argument("--periods", default=Measure.periods, type=int, help="drive periods of the measurement")
    parser.add_argument("--scheduler", help="address of a dask scheduler [default: a cluster of this machine's cores]")
    parser.add_argument("--workers", type=int, help="processes of the local cluster [default: one a core]")
    parser.add_argument("--out", "--output", dest="output", default=Path("sweep.parquet"), type=Path)
    arguments = parser.parse_args()
    if arguments.periods < 1 or arguments.discard < 0:
        parser.error(f"--discard {arguments.discard} --periods {arguments.periods}: expected at least 0 and at least 1")

    if arguments.machine:
        if arguments.fmu:
            parser.error("--machine cannot be combined with --fmu: use one of them")
        with connected(arguments) as client:
            table = by_file(client, arguments)
        table.to_parquet(arguments.output)
        failed = [reason for reason in table.error.reshape(-1) if reason is not None]
        print(f"{len(table)} points, {len(failed)} failed" + (f", the first with {failed[0]}" if failed else ""))
        print(arguments.output)
        return
    axes, fixed = dict(arguments.vary), dict(arguments.set)
    measure = Measure(arguments.discard, arguments.periods)
    if arguments.fmu:
        measure = by_fmu(arguments.fmu, arguments.discard, arguments.periods)
    known(measure, [*axes, *fixed])
    if isinstance(measure, FmuMeasure):
        measure = replace(measure, model=None)
    points = grid(axes, fixed)
    rows: list[Row] = []
    with connected(arguments) as client:
        for done in sweep(client, points, measure, arguments.fmu):
            rows += done
            print(f"\r{len(rows)} of {len(points)} points", end="", flush=True)
    print()
    write(arguments.output, rows, measure)
    failed = [row for row in rows if row["reason"] is not None]
    if failed:
        print(f"{len(failed)} points failed, the first with {failed[0]['reason']}")
    print(arguments.output)


if __name__ == "__main__":
    main()
