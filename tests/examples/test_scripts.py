"""Every script in examples/ does what its first lines describe, and its types are correct."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
sys.path.insert(0, str(EXAMPLES))

import vibro  # noqa: E402


def run(script, *arguments):
    command = [sys.executable, str(EXAMPLES / script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def drawn(path):
    return path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 20_000


@pytest.fixture(scope="session")
def fmu():
    path = os.environ.get("VIBRO_IMPACT_FMU")
    assert path, "VIBRO_IMPACT_FMU names no file: run this through `cargo test --test examples -- --ignored`"
    return path


def test_types_are_strict():
    command = [sys.executable, "-m", "mypy", "--config-file", "examples/mypy.ini", "--cache-dir", os.devnull]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_groups_are_those_of_the_fmu(fmu):
    """Groups in both directions, in arbitrary scales; three of them compared with the FMU's calculated parameters."""
    scales = vibro.Scales(mass=2.0, stiffness=450.0, length=0.004)
    groups = vibro.Groups(0.12, 0.6, 1.3, -0.7, 0.9, 0.05, 0.3, 0.8, 9.0)
    parameters = groups.parameters(scales)
    back = vibro.Groups.of(parameters)
    with vibro.Slave(fmu, parameters) as slave:
        for name in ("epsilon", "f10", "sigma1"):
            assert slave.get(f"groups.{name}") == pytest.approx(getattr(groups, name), rel=1e-12), name
        for name, value in vars(groups).items():
            assert getattr(back, name) == pytest.approx(value, rel=1e-12), name
    assert scales.time * scales.frequency == pytest.approx(1.0)
    default = vibro.Groups().parameters()
    assert {**vibro.start_values(fmu), **default} == pytest.approx(vibro.start_values(fmu))


def test_scales_change_units_alone(fmu):
    """In other scales, the groups give the same motion in units of the gap, and the same number of impacts."""
    runs = []
    for scales in (vibro.Scales(), vibro.Scales(2.0, 200.0, 0.01)):
        start = {**vibro.Groups(f10=1.8).parameters(scales), "block.v": 0.3 * scales.length * scales.frequency}
        result = vibro.simulate(fmu, start, 20, 10)
        runs.append((result["block.s"] / scales.length, result["impacts.upper"][-1]))
    assert runs[0][0] == pytest.approx(runs[1][0], abs=1e-9)
    assert runs[0][1] == runs[1][1] > 5


def test_run_and_plot(fmu, tmp_path):
    picture = tmp_path / "run.png"
    out = run("run_and_plot.py", "--fmu", fmu, "--set", "f10=1.8", "--length", 0.01, "--output", picture)
    assert "f10 = 1.8" in out and "amplitude of block" in out
    assert drawn(picture)


def test_steady_state(fmu, tmp_path):
    picture = tmp_path / "steady.png"
    lines = run("steady_state.py", "--fmu", fmu, "--output", picture).splitlines()
    amplitudes = {line.split()[0]: [float(word) for word in line.split()[3:]] for line in lines if "amplitudes" in line}
    assert amplitudes["EventDriven"] == pytest.approx(amplitudes["ExactOrbit"], abs=2e-5)
    assert amplitudes["MultipleScales"] == pytest.approx(amplitudes["ExactOrbit"], rel=0.25)
    assert drawn(picture)


def test_step_to_impacts(fmu):
    lines = run("step_to_impacts.py", "--fmu", fmu, "--periods", 4).splitlines()
    assert len(lines) > 5 and {line.split()[1] for line in lines[1:]} == {"upper", "lower"}


def test_unstable_orbit(fmu, tmp_path):
    """Compared with the largest multiplier, which `vibro orbit` computes from the exact flow, independently of the FMU."""
    orbit, picture = Path(os.environ["VIBRO_ORBIT"]), tmp_path / "unstable.png"
    out = run("unstable_orbit.py", "--fmu", fmu, "--orbit", orbit, "--output", picture)
    growth = [float(line.split()[-1]) for line in out.splitlines() if line.startswith("growth per period")]
    assert growth[1] == pytest.approx(growth[0], rel=1e-3) and growth[0] > 2.0
    stays, expected = (float(line.split()[-3]) for line in out.splitlines() if line.endswith(" drive periods"))
    assert 0.5 * expected < stays < 1.5 * expected
    assert drawn(picture)


def test_a_stable_orbit_is_not_left(fmu, tmp_path):
    for name in ("orbit-start.csv", "orbit-multipliers.csv"):
        text = (Path(os.environ["VIBRO_ORBIT"]) / name).read_text()
        (tmp_path / name).write_text(text.replace("1.49163", "0.49163"))
    command = [sys.executable, str(EXAMPLES / "unstable_orbit.py"), "--fmu", fmu, "--orbit", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2 and "is stable (largest multiplier 0.49163" in done.stderr


def test_events_fmi3(fmu):
    *lines, sum_up = run("events_fmi3.py", "--fmu", vibro.fmi3_beside(fmu), "--periods", 6).splitlines()
    assert len(lines) > 8 and all("impact, " in line and " yes " in line for line in lines[1:]), lines
    assert sum_up.endswith("the laws hold") and " 0 of them not announced" in sum_up


def test_partitioned(fmu, tmp_path):
    picture = tmp_path / "coupling.png"
    out = run("coupling/partitioned.py", "--fmu", fmu, "--output", picture)
    assert "iterated, steps to the impacts" in out and "steps to the events (FMI 3.0)" in out
    assert drawn(picture)


@pytest.mark.parametrize("host", ["fmpy", "libcosimpy"])
def test_ssp(fmu, tmp_path, host):
    pytest.importorskip(host, reason=f"there is no {host} for this Python or platform")
    out = run("coupling/ssp.py", "--fmu", fmu, "--output", tmp_path / "motor.ssp", "--host", host, "--stop", 20)
    assert "speed of the motor" in out and "amplitude of block.s" in out
