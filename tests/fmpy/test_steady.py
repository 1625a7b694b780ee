"""The analytical modes compared with the library, and with the simulation after its transient."""

import numpy as np
import pytest
from conftest import STATES

EVENT_DRIVEN, MULTIPLE_SCALES, EXACT_ORBIT = 1, 2, 3

# Rounding difference between the FMU's time and the table's; both use the same formulas.
SAME = 1e-12

# Issue 4: the simulation forgets its start with the orbit's multipliers (0.9124 per half period).
SETTLED = 1e-9

# Deviation of the slopes of the errors of multiple scales over the mass ratio from one, because of
# the next order.
SLOPE = (0.9, 1.1)

RATIOS = (0.1, 0.05, 0.02, 0.01, 0.005)


def in_mode(new, mode, settings=(), orbit=False):
    instance = new()
    instance.slave.setInteger([instance.references["mode"]], [mode])
    if orbit:
        instance.slave.setBoolean([instance.references["startOnOrbit"]], [True])
    for name, value in dict(settings).items():
        instance.set(name, value)
    return instance.initialize()


def basic(ratio):
    """The default set at another mass ratio, in unit scales (docs/theory.md, section 4)."""
    return {
        "block.m": ratio,
        "secondary.m": ratio,
        "secondary.k": ratio,
        "secondary.c": 0.6 * ratio * ratio,
        "box.c": 1.0 * ratio,
        "coupling.k": 0.6 * ratio * ratio,
        "drive.amplitude": 1.5 * ratio,
        "drive.frequency": 1.0 + 0.4 * ratio,
    }


def sizes(instance, period, begin=0.0):
    """Root mean squares of the three displacements over a period (a maximum would depend on the sampling of the corners)."""
    rows = []
    for i in range(400):
        instance.step(begin + i * period / 400.0, period / 400.0)
        rows.append(instance.get("box.s", "block.s", "secondary.s"))
    return np.sqrt(np.mean(np.square(rows), axis=0))


@pytest.mark.parametrize("mode, table", [(MULTIPLE_SCALES, "scales"), (EXACT_ORBIT, "orbit")])
def test_plays_the_closed_form_of_the_library(new, native, mode, table):
    expected = native(table)
    instance = in_mode(new, mode)
    for before, row in zip(expected, expected[1:]):
        instance.step(before["time"], row["time"] - before["time"])
        got = instance.get(*STATES)
        np.testing.assert_allclose(got, [row[name] for name in STATES], rtol=0, atol=SAME)


def test_simulation_settles_on_the_exact_orbit(new, period):
    simulated, orbit = in_mode(new, EVENT_DRIVEN), in_mode(new, EXACT_ORBIT)
    simulated.step(0.0, 400.0 * period)
    orbit.step(0.0, 400.0 * period)
    for i in range(20):
        begin, size = (400.0 + i / 20.0) * period, period / 20.0
        simulated.step(begin, size)
        orbit.step(begin, size)
        np.testing.assert_allclose(simulated.get(*STATES), orbit.get(*STATES), rtol=0, atol=SETTLED)


def test_start_on_orbit_stays_on_it(new, period):
    """Without any transient: the simulation begins and remains on the exact orbit."""
    simulated, orbit = in_mode(new, EVENT_DRIVEN, orbit=True), in_mode(new, EXACT_ORBIT)
    np.testing.assert_allclose(simulated.get(*STATES), orbit.get(*STATES), rtol=0, atol=SAME)
    for i in range(300):
        simulated.step(i * 0.3 * period, 0.3 * period)
        orbit.step(i * 0.3 * period, 0.3 * period)
        np.testing.assert_allclose(simulated.get(*STATES), orbit.get(*STATES), rtol=0, atol=SETTLED)


def test_multiple_scales_are_off_by_the_order_of_the_mass_ratio(new):
    """Compared with the simulation on its periodic motion."""
    errors = []
    for ratio in RATIOS:
        settings = basic(ratio)
        period = 2.0 * np.pi / settings["drive.frequency"]
        scales = sizes(in_mode(new, MULTIPLE_SCALES, settings), period)
        # The slow flow's time is 1/ratio; starting on the orbit avoids the transient,
        # and ten periods of the simulation would leave an orbit that is not one.
        simulated = in_mode(new, EVENT_DRIVEN, settings, orbit=True)
        simulated.step(0.0, 10.0 * period)
        exact = sizes(simulated, period, 10.0 * period)
        errors.append(np.abs(scales / exact - 1.0))
    slopes = np.diff(np.log(errors), axis=0) / np.diff(np.log(RATIOS))[:, None]
    assert (slopes[-2:] > SLOPE[0]).all() and (slopes[-2:] < SLOPE[1]).all(), slopes
    assert (errors[0] < 0.25).all() and (errors[-1] < 0.02).all(), errors


def test_reports_the_steady_state(new):
    """Values of an independent prototype, as golden values."""
    instance = in_mode(new, EVENT_DRIVEN)
    assert instance.get("steady.A3")[0] == pytest.approx(1.030523031, abs=1e-9)
    impulse, radius = instance.get("steady.impulse", "steady.spectralRadius")
    assert radius == pytest.approx(0.912416827, abs=1e-9)
    assert impulse == pytest.approx(0.1 * 1.597276346, abs=1e-9)


@pytest.mark.parametrize("mode", [MULTIPLE_SCALES, EXACT_ORBIT])
def test_refuses_a_mode_that_does_not_exist_and_loads_in_one_that_does(new, mode):
    weak = new()
    weak.slave.setInteger([weak.references["mode"]], [mode])
    weak.set("drive.amplitude", 0.001)
    weak.enter()
    with pytest.raises(Exception):
        weak.slave.exitInitializationMode()
    assert any("drive.amplitude" in message or "f10" in message for _, _, message in weak.log), weak.log
    loaded = in_mode(new, mode)
    with pytest.raises(Exception):
        loaded.set("box.f", 0.1)
        loaded.step(0.0, 0.1)


@pytest.mark.parametrize("force, test", [(0.25, "stable"), (0.085, "stable")])
def test_warns_of_an_inadmissible_motion_and_plays_it(new, force, test):
    """Above 2.136 and below 0.891 the periodic motion is not stable (values of an independent prototype)."""
    instance = in_mode(new, MULTIPLE_SCALES, {"drive.amplitude": force})
    warnings = [message for status, _, message in instance.log if status == 1]
    assert any(test in message for message in warnings), instance.log
    instance.step(0.0, 1.0)
    assert np.isfinite(instance.get(*STATES)).all()
