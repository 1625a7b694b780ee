"""A sweep or a plane of the packaged FMU on dask: a cluster of this machine's cores, or any scheduler.

    python examples/dask_sweep.py --vary drive.frequency=0.9:1.2:200 --output sweep.parquet
    python examples/dask_sweep.py --vary drive.frequency=0.9:1.2:100 --vary drive.amplitude=0.05:0.25:50 \\
        --set stop.restitution=0.6 --scheduler tcp://node1:8786 --output plane.parquet

Every point is a run with fmpy; the last periods are measured, by samples. The table has the names of `vibro sweep`, which
needs no Python, measures exactly and shares its work by --shard: use this one where a cluster has fmpy, or the FMU is part of
a larger model. A run starts as there: all at rest in the middle but the block, which moves with the speed L ω10 of the point,
unless --set or --vary gives another start. (A machine that starts at rest may never come to its first impact.) The start is in
the table. A point that fails is a row with its reason and without measured values. Workers need fmpy and numpy; the FMU is
sent to them, also to those that join later. The points of a worker that is lost are computed again by the others. The table is
the same for any number of workers.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Iterator, Mapping, Union

import numpy as np
from dask.distributed import Client, WorkerPlugin, as_completed, get_worker

if TYPE_CHECKING:
    from numpy.typing import NDArray

FMU = Path(__file__).parents[1] / "target" / "VibroImpact3DOF.fmu"
PLUGIN = "vibro-impact-fmu"
RETRIES = 10  # of a chunk whose workers are lost
BODIES = ("box.s", "block.s", "secondary.s")
START = (*BODIES, "box.v", "block.v", "secondary.v")
AMPLITUDES = ("amplitude.x1", "amplitude.x2", "amplitude.x3")  # largest |x|, m, as `vibro sweep --list` has them
MEASURED = (*AMPLITUDES, "impacts.upper", "impacts.lower", "power.impact")

Row = dict[str, Union[float, str, None]]


class FmuPlugin(WorkerPlugin):  # type: ignore[misc] # distributed comes without types
    """Brings the FMU to a worker and unpacks it there once."""

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
    """What is run and measured at each point."""

    discard: int = 400  # drive periods before what is measured
    periods: int = 60  # measured
    per_period: int = 64  # samples

    def row(self, unzipped: str, description: Any, point: Mapping[str, float]) -> Row:
        """One point: what was given, the start, what was measured, and why it was not."""
        defaults = {v.name: float(v.start) for v in description.modelVariables if v.type == "Real" and v.start}
        given = {**moving_block({**defaults, **point}), **point}
        start = {name: given.get(name, defaults.get(name, 0.0)) for name in START}
        row: Row = {**point, **start, **dict.fromkeys(MEASURED), "reason": None}
        try:
            row.update(self.run(unzipped, description, given))
        except Exception as error:  # whatever it is, the other points are still wanted
            row["reason"] = str(error) or type(error).__name__
        return row

    def run(self, unzipped: str, description: Any, values: Mapping[str, float]) -> dict[str, float]:
        """With these values set: amplitudes (m), impacts per period, and power lost at the stops (W) over the last periods."""
        import fmpy
        from fmpy.fmi1 import FMICallException

        defaults = {v.name: v.start for v in description.modelVariables}
        period = 2.0 * math.pi / float(values.get("drive.frequency", defaults["drive.frequency"]))
        names = [*BODIES, "impacts.upper", "impacts.lower", "energy.impact"]
        skipped = self.discard * period
        said: list[str] = []  # the FMU's own words, which name what is wrong and what is allowed

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
            if skipped > 0.0:  # one step, whatever happens in it
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
        result = {name: float(np.abs(table[:, k]).max()) for k, name in enumerate(AMPLITUDES)}
        result["impacts.upper"] = (after[0] - before[0]) / self.periods
        result["impacts.lower"] = (after[1] - before[1]) / self.periods
        result["power.impact"] = float(table[-1, 3] - table[0, 3]) / (self.periods * period)
        return result


def moving_block(values: Mapping[str, float]) -> dict[str, float]:
    """The start of the command line's studies: all at rest in the middle but the block, with the speed L ω10."""
    try:
        speed = values["stop.gap"] * math.sqrt(values["box.k"] / values["box.m"])
    except (ValueError, ZeroDivisionError):
        return {}  # no box on a spring has these; the FMU says which value it does not allow
    return {"block.v": speed}


def chunk(measure: Measure, points: list[tuple[int, dict[str, float]]]) -> list[Row]:
    """Some points on a worker: their place, what was varied, what was measured."""
    plugin: Any = get_worker().plugins[PLUGIN]
    rows: list[Row] = []
    for index, point in points:
        rows.append({"index": index, **measure.row(plugin.unzipped, plugin.description, point)})
    return rows


def grid(axes: Mapping[str, Iterable[float]], fixed: Mapping[str, float]) -> list[dict[str, float]]:
    """All combinations of the axes, the last one fastest."""
    return [{**fixed, **dict(zip(axes, map(float, values)))} for values in product(*axes.values())]


def sweep(
    client: Client, fmu: Path, points: list[dict[str, float]], measure: Measure, size: int = 8
) -> Iterator[list[Row]]:
    """Yields the rows of each chunk as it is done, in any order."""
    client.register_plugin(FmuPlugin(Path(fmu).read_bytes()))
    numbered = list(enumerate(points))
    futures = [
        client.submit(chunk, measure, numbered[i : i + size], retries=RETRIES, pure=False)
        for i in range(0, len(numbered), size)
    ]
    for future in as_completed(futures):
        yield future.result()
        future.release()


def write(path: Path, rows: list[Row], measure: Measure) -> None:
    """The table as Parquet, in the order of the points; whole or not at all."""
    import pyarrow as pa
    from pyarrow import parquet

    ordered = sorted(rows, key=lambda row: float(row["index"] or 0))
    names = [name for name in ordered[0] if name != "index"]
    # With types, since a column may hold nothing: all points may fail, or none.
    columns = {
        name: pa.array([row[name] for row in ordered], pa.string() if name == "reason" else pa.float64()) for name in names
    }
    about = {"discard": measure.discard, "periods": measure.periods, "samples per period": measure.per_period}
    table = pa.table(columns).replace_schema_metadata({k: str(v) for k, v in about.items()})
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    parquet.write_table(table, unfinished, compression="zstd")
    unfinished.replace(path)


def axis(text: str) -> tuple[str, NDArray[np.float64]]:
    """NAME=FROM:TO:COUNT."""
    name, _, values = text.partition("=")
    try:
        low, high, count = values.split(":")
        return name, np.linspace(float(low), float(high), int(count))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: allowed is NAME=FROM:TO:COUNT") from None


def setting(text: str) -> tuple[str, float]:
    """NAME=VALUE."""
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: allowed is NAME=VALUE") from None


def known(fmu: Path, names: Iterable[str]) -> None:
    """Refuses names that are no Real parameter or start value of the FMU."""
    import fmpy

    variables = fmpy.read_model_description(str(fmu)).modelVariables
    allowed = {v.name for v in variables if v.type == "Real" and v.start is not None and v.causality != "input"}
    for name in names:
        if name not in allowed:
            raise SystemExit(f"{name}: allowed are {', '.join(sorted(allowed))}")


def main() -> None:
    """Makes or joins a cluster, sweeps, writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", default=FMU, type=Path)
    parser.add_argument("--vary", action="append", type=axis, required=True, metavar="NAME=FROM:TO:COUNT")
    parser.add_argument("--set", action="append", default=[], type=setting, metavar="NAME=VALUE")
    parser.add_argument("--discard", default=Measure.discard, type=int, help="drive periods before what is measured")
    parser.add_argument("--periods", default=Measure.periods, type=int, help="drive periods that are measured")
    parser.add_argument("--scheduler", help="address of a dask scheduler [default: a cluster of this machine's cores]")
    parser.add_argument("--workers", type=int, help="processes of the local cluster [default: one a core]")
    parser.add_argument("--output", default=Path("sweep.parquet"), type=Path)
    arguments = parser.parse_args()
    if arguments.periods < 1 or arguments.discard < 0:
        parser.error(f"--discard {arguments.discard} --periods {arguments.periods}: allowed are 0 and 1 or more")

    axes, fixed = dict(arguments.vary), dict(arguments.set)
    known(arguments.fmu, [*axes, *fixed])
    points = grid(axes, fixed)
    measure = Measure(discard=arguments.discard, periods=arguments.periods)
    if arguments.scheduler:
        client = Client(arguments.scheduler)
    else:
        workers = arguments.workers or os.cpu_count()
        client = Client(n_workers=workers, threads_per_worker=1, dashboard_address=None)
    rows: list[Row] = []
    with client:
        for done in sweep(client, arguments.fmu, points, measure):
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
