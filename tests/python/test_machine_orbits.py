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
    return vi.Machine(ROOT / "examples/assembly" / name)


def test_the_block_of_the_page_prints_what_it_shows(tmp_path):
    assert run("docs/machine-studies.md", tmp_path) == 2


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
    # The body sticks over the distance 2 (Fs - Fk)/k, then slips from the belt's speed back to it.
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
    curves = vi.Machine(OSCILLATOR).response("load.shaker.frequency", "1.5 Hz", "6 Hz", of="amplitude.box.s", seeds=8)
    free = [curve for curve in curves if curve.word == ""]
    assert len(free) == 2 and len(curves) > 4
    for curve in free:
        omega = 2 * np.pi * curve.value
        np.testing.assert_allclose(curve.measure, 2 / np.hypot(400 - omega**2, 2 * omega), rtol=1e-11)
    assert {label for label, _, element in free[0].special if element == "stop.wall"} == {"GR"}


def test_starts_of_a_branch_lead_back_to_its_orbits():
    oscillator = vi.Machine(OSCILLATOR)
    curves = oscillator.response("load.shaker.frequency", "1.5 Hz", "6 Hz", of="amplitude.box.s", seeds=8)
    curve = next(curve for curve in curves if curve.word == "impact wall" and len(curve.value) > 20)
    assert len(curve.starts) == len(curve.value)
    for i in range(3, len(curve.value) - 3, 7):
        machine = oscillator.replace({curve.name: curve.value[i]})
        # An orbit with a given word is searched from the start on, also on unstable branches.
        orbit = machine.orbit(curve.word, period=f"{curve.periods}T", start=curve.starts[i])
        assert abs(orbit.measure(curve.of) / curve.measure[i] - 1) < 1e-9, i


def test_second_method_basins_are_where_single_motions_settle():
    bistable = vi.Machine(OSCILLATOR).replace({"load.shaker.frequency": "4.2 Hz"})
    found = bistable.basins(**{"box.s": ("-10 mm", "9.9 mm", 5), "box.v": (-0.5, 0.5, 4)})
    assert found.cells.shape == (4, 5) and found.ended is None
    assert sorted(attractor.word for attractor in found.attractors) == ["", "impact wall"]
    for j, v in enumerate(found.y):
        for i, s in enumerate(found.x):
            orbit = bistable.orbit(start={"box.s": s, "box.v": v})
            assert orbit.word == found.attractors[found.cells[j, i]].word
    # The start of an attractor lies on it.
    for attractor in found.attractors:
        assert bistable.orbit(start=attractor.start, settle=0).word == attractor.word


def test_closed_form_a_section_of_the_linear_oscillator_and_its_exponents():
    quiet = vi.Machine(OSCILLATOR).replace({"load.shaker.frequency": "1.5 Hz"})
    section, omega = quiet.poincare(phase=np.pi / 2, periods=5), 3 * np.pi
    re, im = 400 - omega**2, 2 * omega
    np.testing.assert_allclose(section["box.s"], 2 * re / (re**2 + im**2), rtol=1e-8)
    assert section.speed is None and section.values.shape == (5, len(quiet.columns))
    hits = vi.Machine(OSCILLATOR).poincare("wall", periods=7)
    assert (hits.speed > 0).all() and np.allclose(hits["box.v"], -0.8 * hits.speed)
    # The sum is -c/m plus 2 ln 0.8 per impact, with one impact in two periods of 1/3 s.
    exponents = vi.Machine(OSCILLATOR).spectrum(periods=30).exponents
    assert abs(exponents.sum() - (-2 + 2 * np.log(0.8) * 1.5)) < 1e-9
    with pytest.raises(KeyError, match="no such column; expected one of box.s"):
        section["boz.s"]


def test_second_method_a_gradient_is_the_slope_of_followed_branches():
    damper = example("damper_with_buffer.toml")
    orbit = damper.orbit()
    gradient = orbit.gradient("amplitude.box.s")
    assert not any(".start." in name for name in gradient) and len(gradient) > 20
    for name in ("stop.steel.gap", "body.box.mass", "load.shaker.frequency", "friction.guide.force"):
        value = damper.parameters[name]
        branch = orbit.follow(name, value * (1 - 1e-4), value * (1 + 1e-4), of="amplitude.box.s")
        slope = (branch.measure[-1] - branch.measure[0]) / (branch.value[-1] - branch.value[0])
        # Error: the curvature over a ten-thousandth, and the rounding of amplitudes divided by it.
        assert abs(gradient[name] - slope) < 1e-5 * abs(slope), name


def test_an_unstable_orbit_is_found_by_its_word_and_period():
    machine = vi.Machine(OSCILLATOR)
    assert machine.orbit().periods == 2
    for wanted in ({"word": "impact wall", "period": "1T"}, {"period": 1 / 3}):
        orbit = machine.orbit(**wanted)
        assert (orbit.word, orbit.periods, orbit.stability) == ("impact wall", 1, "unstable")
    # The branch of the stable orbit at a lower frequency leads to this orbit.
    slower = machine.replace({"load.shaker.frequency": 2.55}).orbit("impact wall", period="1T")
    branch = slower.follow("load.shaker.frequency", 2.5, 3.0, of="impact.speed.wall")
    assert abs(branch.measure[-1] - orbit.measure("impact.speed.wall")) < 1e-11


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: example("impact_pair.toml").orbit(settle=-1), "settle = -1"),
        (lambda: example("two_blocks.toml").orbit(), "it is chaotic"),
        (lambda: example("relay_bounce.toml").orbit(), "load.magnet has a step"),
        (lambda: example("impact_pair.toml").orbit().follow("stop.left.gap", 2, 3), "must lie in the range 2 m to 3 m"),
        (lambda: example("impact_pair.toml").orbit().measure("power.lost"), "is not a measure of an orbit"),
        (lambda: example("impact_pair.toml").orbit().gradient("class"), "is not a measure of an orbit"),
        (lambda: vi.Machine(OSCILLATOR).poincare("wall", phase=1.0), "cannot be combined with a section of an element's events"),
        (lambda: vi.Machine(OSCILLATOR).spectrum(periods=7), "periods = 7"),
        (lambda: vi.Machine(OSCILLATOR).orbit("open wall"), "the word cannot repeat"),
        (lambda: vi.Machine(OSCILLATOR).orbit(period="0T"), "expected '1T' to '32T'"),
        (lambda: vi.Machine(OSCILLATOR).orbit(period=0.1), "a multiple of the drive's period"),
        (lambda: vi.Machine(OSCILLATOR).basins(**{"box.s": (1, 0, 3), "box.v": (0, 1, 3)}), "expected from < to"),
        (lambda: vi.Machine(OSCILLATOR).basins(**{"box.s": (0, 1, 3), "boz.v": (0, 1, 3)}), "box.v"),
        (lambda: vi.Machine(OSCILLATOR).response("load.shaker.frequency", 3, 1), "the lower end must be less than the upper end"),
        (lambda: example("impact_pair.toml").branches("stop.left.gap", 3, 1), "the lower end must be less than the upper end"),
        (lambda: example("impact_pair.toml").branches("stop.left.gap", 1, 2, of="amplitude.bal.s"), "did you mean `"),
    ],
)
def test_what_is_refused_is_named(call, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        call()


def test_an_end_of_a_range_of_another_type_is_named():
    machine = example("impact_pair.toml")
    for ends, words in [((None, 2), "low = None"), ((1, [2]), "high = [2]"), ((1, True), "high = True")]:
        with pytest.raises(TypeError, match=re.escape(f"{words} is of type")):
            machine.branches("stop.left.gap", *ends)


def test_a_name_that_is_no_measure_of_an_orbit_is_told_the_measures():
    for of in ("power.lost", "exponent", "nothing"):
        with pytest.raises(ValueError, match=f"{of}: is not a measure of an orbit; expected amplitude.Q, .*impact.impulse.STOP"):
            vi.Machine(OSCILLATOR).response("load.shaker.frequency", 1, 3, of=of)
