"""Periodic orbits of machines of your own: the page's block, closed forms, refusals."""

import re

import numpy as np
import pytest
from conftest import ROOT
from test_guide import run

import vibro_impact as vi

# Rounding of an orbit's numbers.
ROUNDING = 1e-12


def example(name):
    return vi.Assembly(ROOT / "examples/assembly" / name)


def test_the_block_of_the_page_prints_what_it_shows(tmp_path):
    assert run("docs/orbits-of-your-machine.md", tmp_path) == 1


def test_closed_form_of_both_orbits_of_the_impact_pair():
    pair = example("impact_pair.toml")
    branches = pair.branches("body.base.motion.amplitude", 0.2, 2.0, of="impact.speed.right", depth=0, seeds=10)
    own = next(branch for branch in branches if "LP" in branch.labels)
    # V²/9 + (pi V - 3)²/4 = A² at the smallest A.
    fold = np.sqrt(2.25 - (1.5 * np.pi) ** 2 / (4 / 9 + np.pi**2))
    assert abs(next(value for label, value, _ in own.special if label == "LP") - fold) < 1e-10
    # The impact's speed is V (1 + 1/3).
    at = np.flatnonzero(np.diff(np.sign(own.value - 1.0)) != 0)
    assert len(at) == 2
    speeds = sorted(np.interp(1.0, *zip(*sorted(zip(own.value[k : k + 2], own.measure[k : k + 2])))) for k in at)
    np.testing.assert_allclose(speeds, [0.321987289207181 * 4 / 3, 1.50557395311726 * 4 / 3], atol=5e-3)
    assert own.stable[np.argmax(own.measure)] == (own.stability[np.argmax(own.measure)] == "stable")


def test_an_orbit_has_its_numbers_and_a_motion_stays_on_it():
    belt = example("belt_friction.toml").orbit()
    # Held over 2 (Fs - Fk)/k, then slipping from the belt's speed back to it.
    period = (np.pi + 2 * np.arctan(2.0)) / 10 + 2 * 0.005 / 0.1
    assert abs(belt.period - period) < ROUNDING and belt.periods is None and belt.stable
    assert [kind for _, kind, _ in belt.events] == ["slip", "stick"]
    damper = example("damper_with_buffer.toml")
    orbit = damper.orbit()
    run = damper.simulate(orbit.start.time + 2 * orbit.period, start=orbit.start)
    assert abs(run["box.s"][-1] - orbit.start["box.s"]) < ROUNDING
    assert abs(orbit.measure("amplitude.box.s") - np.abs(run["box.s"]).max()) < 1e-6
    energies = orbit.energies()
    assert abs(energies.pop("load.shaker") - sum(energies.values())) < ROUNDING


OSCILLATOR = {
    "name": "Oscillator",
    "body": {"box": {"mass": 1.0}},
    "spring": {"mount": {"between": ["ground", "box"], "stiffness": 400.0, "damping": 2.0}},
    "stop": {"wall": {"between": ["ground", "box"], "gap": "1 cm", "restitution": 0.8}},
    "load": {"shaker": {"on": "box", "amplitude": "2 N", "frequency": "3 Hz"}},
}


def test_closed_form_a_response_without_impacts_is_that_of_the_linear_oscillator():
    curves = vi.Assembly(OSCILLATOR).response("load.shaker.frequency", "1.5 Hz", "6 Hz", of="amplitude.box.s", seeds=8)
    free = [curve for curve in curves if curve.word == ""]
    assert len(free) == 2 and len(curves) > 4
    for curve in free:
        omega = 2 * np.pi * curve.value
        np.testing.assert_allclose(curve.measure, 2 / np.hypot(400 - omega**2, 2 * omega), rtol=1e-11)
    assert {label for label, _, element in free[0].special if element == "stop.wall"} == {"GR"}


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: example("impact_pair.toml").orbit(settle=-1), "settle = -1"),
        (lambda: example("two_blocks.toml").orbit(), "it is chaotic"),
        (lambda: example("relay_bounce.toml").orbit(), "load.magnet has a step"),
        (lambda: example("impact_pair.toml").orbit().follow("stop.left.gap", 2, 3), "must lie in the range 2 to 3"),
        (lambda: example("impact_pair.toml").orbit().measure("power.lost"), "no measure of an orbit"),
        (lambda: example("impact_pair.toml").branches("stop.left.gap", 3, 1), "allowed is a range with length"),
        (lambda: example("impact_pair.toml").branches("stop.left.gap", 1, 2, of="amplitude.bal.s"), "the nearest is"),
    ],
)
def test_what_is_refused_is_named(call, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        call()
