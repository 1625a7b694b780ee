"""Model Exchange in fmpy's solvers compared with Co-Simulation."""

import fmpy
import numpy as np
import pytest
from conftest import STATES

OUTPUTS = (
    *("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v", "stop.s"),
    *("energy.mechanical", "energy.input", "energy.damped", "energy.impact"),
)
COUNTS = ("impacts.upper", "impacts.lower", "stop.state")
BOUNCING = {"block.s": 0.9, "block.v": 0.5}
PRESSED = {"block.v": 0.3, "stop.restitution": 0.3, "drive.amplitude": 0.4}


def run(fmu, fmi_type, stop, start, **options):
    signal = np.array([(0.0, start.get("block.f", 0.0))], dtype=[("time", float), ("block.f", float)])
    result = fmpy.simulate_fmu(
        fmu,
        fmi_type=fmi_type,
        stop_time=stop,
        start_values={k: v for k, v in start.items() if k != "block.f"},
        input=signal,
        output=[*OUTPUTS, *COUNTS],
        **options,
    )
    return result


def end(result, names=OUTPUTS):
    return np.array([float(result[name][-1]) for name in names])


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-7, 3e-4), (1e-10, 1e-6)])
def test_cvode_equals_co_simulation(fmu, period, tolerance, bound):
    """Twenty periods with some forty impacts; errors grow in the transient, so the bound exceeds the tolerance."""
    stop, interval = 20 * period, period / 10
    expected = run(fmu, "CoSimulation", stop, BOUNCING, output_interval=interval)
    result = run(
        fmu, "ModelExchange", stop, BOUNCING, output_interval=interval, relative_tolerance=tolerance
    )
    np.testing.assert_allclose(end(result), end(expected), rtol=0, atol=bound)
    np.testing.assert_array_equal(end(result, COUNTS), end(expected, COUNTS))
    assert end(expected, COUNTS)[0] > 10


def test_cvode_through_chatter_rest_and_release(fmu, period):
    start = {**PRESSED, "block.f": 0.02}
    stop, interval = 10 * period, period / 10
    expected = run(fmu, "CoSimulation", stop, start, output_interval=interval)
    result = run(fmu, "ModelExchange", stop, start, output_interval=interval, relative_tolerance=1e-10)
    np.testing.assert_allclose(end(result), end(expected), rtol=0, atol=1e-5)
    assert set(expected["stop.state"]) == {1, 2}, "rest and flight"
    assert set(result["stop.state"]) == {1, 2}


def test_euler_keeps_the_block_in_the_box_and_converges(fmu, period):
    """First order: a tenth of the step leaves about a tenth of the error."""
    stop = 2 * period
    expected = end(run(fmu, "CoSimulation", stop, BOUNCING, output_interval=stop))
    errors = []
    for step in (period / 1000, period / 10000):
        result = run(fmu, "ModelExchange", stop, BOUNCING, solver="Euler", step_size=step, output_interval=step)
        assert np.abs(result["stop.s"]).max() < 1.0 + 3.0 * step
        errors.append(np.abs(end(result) - expected).max())
    assert errors[1] < 0.3 * errors[0], errors
    assert errors[1] < 0.01, errors


def test_euler_does_not_fall_through_a_stop_in_chatter(fmu, period):
    """Euler cannot resolve the last bounces: the block bounces at every step, but stays at the stop."""
    start = {**PRESSED, "block.f": 0.02}
    stop, step = 10 * period, period / 5000
    expected = run(fmu, "CoSimulation", stop, start, output_interval=stop)
    result = run(fmu, "ModelExchange", stop, start, solver="Euler", step_size=step, output_interval=step)
    assert np.abs(result["stop.s"]).max() < 1.0 + 3.0 * step
    np.testing.assert_allclose(end(result, STATES), end(expected, STATES), rtol=0, atol=0.1)
