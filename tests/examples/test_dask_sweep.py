"""The sweep on dask: equal to a sweep without dask, for any number of workers, and if a worker is killed midway."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import fmpy
import pytest
from pyarrow import parquet

EXAMPLES = Path(__file__).parents[2] / "examples"
sys.path.insert(0, str(EXAMPLES))
os.environ["PYTHONPATH"] = os.pathsep.join([str(EXAMPLES), *filter(None, [os.environ.get("PYTHONPATH")])])  # the workers unpickle the module's functions

import dask_sweep  # noqa: E402
from dask.distributed import Client, LocalCluster  # noqa: E402

MEASURE = dask_sweep.FmuMeasure(discard=50, periods=10)
AXES = {"drive.frequency": [0.9 + 0.01 * i for i in range(12)], "stop.restitution": [0.5, 0.6, 0.75]}


@pytest.fixture(scope="module")
def fmu():
    path = os.environ.get("VIBRO_IMPACT_FMU")
    assert path, "VIBRO_IMPACT_FMU names no file: run this through `cargo test --test examples -- --ignored`"
    return Path(path)


@pytest.fixture(scope="module")
def alone(fmu, tmp_path_factory):
    """The rows, computed sequentially without dask."""
    folder = fmpy.extract(str(fmu), unzipdir=str(tmp_path_factory.mktemp("fmu")))
    measure = replace(MEASURE, model=(folder, fmpy.read_model_description(folder)))
    points = dask_sweep.grid(AXES, {})
    return [{"index": i, **measure.row(p)} for i, p in enumerate(points)]


def test_rows_are_sensible(alone):
    assert len(alone) == 36
    assert all(row["amplitude.x1"] > 0.0 for row in alone)
    assert len({row["amplitude.x2"] for row in alone}) > 10, "the points differ"
    assert all(row["impacts.upper"] > 0 and row["power.impact"] > 0 for row in alone), "the block starts moving"
    assert all(row["reason"] is None and row["block.v"] == 1.0 for row in alone), "in units of L ω10, both 1"


@pytest.fixture(scope="module", params=["package", "fmu"])
def measure(request, fmu, tmp_path_factory):
    """Measures by the package and by the FMU."""
    if request.param == "package":
        return dask_sweep.Measure(discard=50, periods=10)
    folder = fmpy.extract(str(fmu), unzipdir=str(tmp_path_factory.mktemp("unpacked")))
    return replace(MEASURE, model=(folder, fmpy.read_model_description(folder)))


# Error of the largest of 64 samples per period, which may miss a corner at an impact.
SAMPLES = 0.02
# Error of counts and sums that the FMU accumulates between its communication points, which are
# whole periods up to rounding.
COUNTED = 1e-6


def test_package_and_fmu_measure_the_same(alone):
    machines = dask_sweep.Measure(discard=50, periods=10)
    for row in alone:
        exact = machines.row({name: row[name] for name in AXES})
        assert exact.keys() == row.keys() - {"index"} and exact["reason"] is None
        for name in dask_sweep.AMPLITUDES:
            assert row[name] == pytest.approx(exact[name], rel=SAMPLES) and row[name] <= exact[name] * (1.0 + COUNTED)
        for name in ("impacts.upper", "impacts.lower", "power.impact", *dask_sweep.START):
            assert row[name] == pytest.approx(exact[name], rel=COUNTED), name


def test_the_start_is_that_of_the_command_line_in_the_scales_of_the_point(measure):
    """12 kg and 48 kN/m with a gap of 1 cm: L ω10 = 0.01 m · sqrt(4000) rad/s."""
    scales = {"box.m": 12.0, "box.k": 48e3, "stop.gap": 0.01}
    assert dask_sweep.moving_block(scales) == {"block.v": pytest.approx(0.01 * 4000.0**0.5, rel=1e-15)}
    row = measure.row({**scales, "drive.frequency": 63.0, "drive.amplitude": 50.0})
    assert row["block.v"] == pytest.approx(0.01 * 4000.0**0.5, rel=1e-15)
    assert [row[name] for name in dask_sweep.START if name != "block.v"] == [0.0] * 5
    # A different start is used as given.
    assert measure.row({"block.v": 0.25, "box.s": 0.1})["block.v"] == 0.25


@pytest.mark.parametrize("way", ["package", "fmu"])
def test_a_failed_point_is_a_row_with_its_reason(fmu, tmp_path, way):
    output = tmp_path / "sweep.parquet"
    arguments = ["--vary", "stop.restitution=0.5:1.5:3", "--workers", "1", "--discard", "50", "--periods", "10"]
    arguments += ["--output", str(output), *(["--fmu", str(fmu)] if way == "fmu" else [])]
    command = [sys.executable, str(EXAMPLES / "dask_sweep.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    assert "1 points failed" in done.stdout
    table = parquet.read_table(output)
    assert table.column("stop.restitution").to_pylist() == [0.5, 1.0, 1.5]
    errors = table.column("reason").to_pylist()
    assert errors[:2] == [None, None] and "restitution" in errors[2] and "1.5" in errors[2], errors
    amplitudes = table.column("amplitude.x2").to_pylist()
    assert amplitudes[0] > 0.0 and amplitudes[1] > 0.0 and amplitudes[2] is None


class Slowly(dask_sweep.FmuMeasure):
    """Leaves a mark for each point that has begun, and gives the test time to kill its worker."""

    def run(self, point):
        with open(os.environ["SWEEP_MARKS"], "a") as marks:
            print(os.getpid(), point["drive.frequency"], point["stop.restitution"], file=marks)
        time.sleep(0.1)
        return super().run(point)


def test_points_of_a_killed_worker_are_computed_again(fmu, alone, tmp_path, monkeypatch):
    marks = tmp_path / "marks"
    monkeypatch.setenv("SWEEP_MARKS", str(marks))
    monkeypatch.setenv("PYTHONPATH", f"{EXAMPLES}{os.pathsep}{Path(__file__).parent}")
    points = dask_sweep.grid(AXES, {})
    slowly = Slowly(discard=MEASURE.discard, periods=MEASURE.periods)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        processes = set(client.run(os.getpid).values())
        assert len(processes) == 2
        rows, victim = [], None
        for done in dask_sweep.sweep(client, points, slowly, fmu, size=3):
            rows += done
            if victim is None:
                victim = int(marks.read_text().splitlines()[-1].split()[0])  # is amid a chunk or begins one
                assert victim in processes
                os.kill(victim, signal.SIGKILL)
    assert sorted(rows, key=lambda row: row["index"]) == alone
    begun = [line.split() for line in marks.read_text().splitlines()]
    again = {tuple(b[1:]) for b in begun if b[0] == str(victim)} & {tuple(b[1:]) for b in begun if b[0] != str(victim)}
    assert again, "no point of the killed worker was started again by another"


@pytest.mark.parametrize("workers", [1, 2])
def test_the_script_writes_the_same_table_for_any_number_of_workers(fmu, alone, tmp_path, workers):
    output = tmp_path / "sweep.parquet"
    arguments = ["--vary", "drive.frequency=0.9:1.01:12", "--set", "stop.restitution=0.6", "--workers", str(workers)]
    arguments += ["--discard", "50", "--periods", "10", "--fmu", str(fmu), "--output", str(output)]
    subprocess.run([sys.executable, str(EXAMPLES / "dask_sweep.py"), *arguments], check=True, timeout=200)
    table = parquet.read_table(output)
    assert table.schema.metadata[b"periods"] == b"10"
    expected = [row for row in alone if row["stop.restitution"] == 0.6]
    for name in ("drive.frequency", "stop.restitution", "amplitude.x2", "impacts.upper", "power.impact"):
        assert table.column(name).to_pylist() == pytest.approx([row[name] for row in expected], rel=1e-6), name
    assert list(tmp_path.iterdir()) == [output], "nothing unfinished is left"


def test_the_script_joins_a_scheduler(fmu, tmp_path):
    output = tmp_path / "sweep.parquet"
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        arguments = ["--vary", "stop.restitution=0.5:0.8:3", "--discard", "50", "--periods", "10", "--fmu", str(fmu)]
        arguments += ["--scheduler", cluster.scheduler_address, "--output", str(output)]
        subprocess.run([sys.executable, str(EXAMPLES / "dask_sweep.py"), *arguments], check=True, timeout=200)
    assert parquet.read_table(output).num_rows == 3


@pytest.mark.parametrize("way", ["package", "fmu"])
@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--vary", "drive.speed=0:1:2"], "drive.speed: no such name; expected one of"),
        (["--vary", "drive.frequency=0:1"], "expected NAME=FROM:TO:COUNT"),
        (["--vary", "drive.frequency=0.9:1:2", "--periods", "0"], "--periods 0: expected at least 0 and at least 1"),
    ],
)
def test_wrong_arguments_are_named(fmu, arguments, word, way):
    by = ["--fmu", str(fmu)] if way == "fmu" else []
    done = subprocess.run([sys.executable, str(EXAMPLES / "dask_sweep.py"), *by, *arguments], capture_output=True, text=True)
    assert done.returncode != 0 and word in done.stderr, done.stderr


DAMPER = EXAMPLES / "assembly" / "damper_with_buffer.toml"
STEEL = "stop.steel.gap"


def test_a_machine_s_file_has_the_rows_of_one_process(tmp_path):
    import vibro_impact as vi

    out = tmp_path / "gaps.parquet"
    command = [sys.executable, str(EXAMPLES / "dask_sweep.py"), "--machine", str(DAMPER), "--vary", f"{STEEL}=0.004:0.009:20"]
    command += ["--set", "body.box.mass=13", "--measure", "amplitude.box.s", "--measure", "class", "--discard", "6", "--periods", "4"]
    done = subprocess.run([*command, "--workers", "2", "--out", str(out)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and "20 points, 0 failed" in done.stdout, done.stdout + done.stderr
    machine = vi.Machine(DAMPER).replace({"body.box.mass": 13.0})
    alone = machine.sweep(["amplitude.box.s", "class"], {STEEL: [float(x) for x in dask_sweep.axis(f"{STEEL}=0.004:0.009:20")[1]]}, settle=6, periods=4)
    read = parquet.read_table(out)
    assert all(read.column(name).to_pylist() == alone[name].tolist() for name in (STEEL, "amplitude.box.s", "class"))


def test_parts_of_a_killed_worker_are_computed_again(tmp_path):
    """For a study with `executor=`: a worker is killed during the computation, and the rows equal those of one process."""
    import threading

    import numpy as np
    import vibro_impact as vi

    gaps = np.linspace(4e-3, 9e-3, 400)
    alone = vi.measure_many(vi.Machine(DAMPER), {STEEL: gaps}, ["amplitude.box.s"], settle=100, periods=20)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        first = client.run(os.getpid)
        killer = threading.Timer(0.5, lambda: os.kill(next(iter(first.values())), signal.SIGKILL))
        killer.start()
        found = vi.measure_many(
            vi.Machine(DAMPER), {STEEL: gaps}, ["amplitude.box.s"], settle=100, periods=20, executor=client, checkpoint=tmp_path / "parts"
        )
        killer.join()
        assert set(client.run(os.getpid).values()) != set(first.values()), "a worker was replaced"
    assert (found["amplitude.box.s"] == alone["amplitude.box.s"]).all()
    assert len(list((tmp_path / "parts").glob("*.part"))) == 50
