"""The package is bit-identical to the library and the FMU."""

import os

import fmpy
import numpy as np
import pytest
import vibro_impact as vi

STATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")

# Rounding of 1e-13 at t = 600 s: the two add communication points and steps in different order.
# Binary fractions avoid it. The stable default motion does not amplify it.
SAME = 1e-11


def same(run, expected):
    np.testing.assert_array_equal(run.t, expected["t"])
    np.testing.assert_array_equal(np.hstack([run.s, run.v]), expected["states"])
    np.testing.assert_array_equal(np.stack([run.energy[n] for n in run.energy.dtype.names], axis=1), expected["energy"])
    for name in ("impacts", "rests", "releases"):
        assert [list(row) for row in getattr(run, name).tolist()] == expected[name], name


def test_library_motion_with_impacts(native):
    run = vi.PaperMachine.from_groups(f10=1.5, kappa=0.75).simulate(periods=50, per_period=20)
    same(run, native["standard"])
    assert len(run.impacts) > 90


def test_library_motion_with_rest_and_release(native):
    run = vi.PaperMachine.from_groups(f10=4.5, kappa=0.1).simulate(periods=30, per_period=7)
    same(run, native["resting"])
    assert len(run.rests) > 5 and len(run.releases) > 5


def test_library_motion_under_loads(native):
    loads = [
        vi.Load("box", [1.0, 2.0, 4.5, 9.0], [0.0, 0.5, -0.25, 0.0]),
        vi.Load("block", [3.0, 5.0, 6.0], [0.1, -0.2, 0.05], "cubic"),
    ]
    same(vi.PaperMachine.from_groups(f10=1.5, kappa=0.75).simulate(periods=3, per_period=40, loads=loads), native["loaded"])


def test_library_batch(native):
    machines = [vi.PaperMachine.from_groups(f10=f10) for f10 in native["many"]["f10"]]
    ends = vi.simulate_many(machines, periods=100)
    np.testing.assert_array_equal(ends.states, native["many"]["ends"])
    # A motion's bits depend only on the motion itself.
    np.testing.assert_array_equal(vi.simulate_many(machines[7], periods=100).states, native["many"]["ends"][7:8])


def test_library_bifurcation_diagram(native):
    expected = native["bifurcation"]
    diagram = vi.PaperMachine().bifurcation(f10=np.linspace(0.5, 4, 41), periods=(60, 40), exponents=100, of="x1")
    for direction, rows in ((diagram.up, expected["up"]), (diagram.down, expected["down"])):
        np.testing.assert_array_equal(direction.value, [row["value"] for row in rows])
        assert direction.kind.tolist() == [row["kind"] for row in rows]
        np.testing.assert_array_equal(direction.impacts, [row["impacts"] for row in rows])
        # JSON has no infinities; exponents of directions lost at rest are null.
        exponents = [[-np.inf if x is None else x for x in row["exponents"]] for row in rows]
        np.testing.assert_array_equal(direction.exponents, exponents)
        maxima = [[i, *top] for i, row in enumerate(rows) for top in row["maxima"]]
        np.testing.assert_array_equal(np.stack([direction.at, direction.maxima, direction.met], axis=1), maxima)
    assert diagram.hysteresis.tolist() == expected["hysteresis"]


def test_library_basins(native):
    found = vi.PaperMachine.from_groups(f10=2.5).basins(v2=(-1.5, 1.25, 8), x2=(-1.5, 1.25, 6), settle=200)

    def word(number, mirror):
        return "Outside" if number < 0 else f"{'Mirror' if mirror else 'Attractor'}({number})"

    cells = [word(n, m) for n, m in zip(found.cells.ravel(), found.mirror.ravel())]
    assert cells == native["basins"]["cells"] and "Outside" in cells
    assert [a.period for a in found.attractors] == native["basins"]["periods"]
    assert found.cells.shape == (6, 8) and found.y[0] == -1.5 + 2.75 / 12


def test_library_exponents(native):
    found = vi.PaperMachine.from_groups(f10=3.6).spectrum(periods=120, settle=50)
    np.testing.assert_array_equal(found.exponents, native["exponents"])
    assert found.exponents[0] > 0.01 and found.running.shape == (120, 7)


@pytest.mark.parametrize("version", [2, 3])
def test_the_fmu_inside_is_the_packaged_one(version):
    packaged = os.environ["VIBRO_IMPACT_FMU"]
    packaged = packaged if version == 2 else packaged.replace(".fmu", "-FMI3.fmu")
    with open(packaged, "rb") as file:
        assert file.read() == vi.fmu_path(version).read_bytes()


@pytest.mark.parametrize("version", [2, 3])
def test_fmu_at_steps_that_are_binary_fractions(version):
    start = {"drive.amplitude": 0.15, "stop.restitution": 0.6, "block.v": 0.3}
    rows = fmpy.simulate_fmu(
        str(vi.fmu_path(version)),
        stop_time=600.0,
        output_interval=0.5,
        start_values=start,
        output=[*STATES, "impacts.upper", "impacts.lower"],
        fmi_type="CoSimulation",
    )
    run = vi.PaperMachine(drive_amplitude=0.15, stop_restitution=0.6).simulate(start={"block_v": 0.3}, times=rows["time"])
    np.testing.assert_array_equal(np.hstack([run.s, run.v]), np.stack([rows[name] for name in STATES], axis=1))
    assert len(run.impacts) == rows["impacts.upper"][-1] + rows["impacts.lower"][-1] > 100


def test_fmu_at_other_steps():
    rows = fmpy.simulate_fmu(str(vi.fmu_path()), stop_time=600.0, output_interval=0.3, output=STATES, fmi_type="CoSimulation")
    run = vi.PaperMachine().simulate(start=[0.0] * 6, times=rows["time"])
    found = np.stack([rows[name] for name in STATES], axis=1)
    np.testing.assert_allclose(np.hstack([run.s, run.v]), found, rtol=0, atol=SAME)


def test_arrays_own_their_memory(native):
    run = vi.PaperMachine().simulate(periods=2)
    section = vi.PaperMachine().poincare(periods=2)
    ends = vi.simulate_many(vi.PaperMachine(), periods=2)
    for array in [run.t, run.s, run.v, run.energy, run.impacts, section.s, section.phase, ends.t, ends.s]:
        assert array.flags.owndata and array.flags.c_contiguous and array.flags.writeable
