"""Machines with curved laws: springs with powers, contacts of Hertz, formulas, Stribeck friction."""

import numpy as np
import pytest
import vibro_impact as vi

# Shift of a number for central differences, and their tolerance: truncation, and rounding divided by the shift.
SHIFT = 1e-5
OF_DIFFERENCE = 1e-7
# Distance of an estimate, in standard errors; about one in ten thousand is beyond it.
FAR = 4.0
# Noise of the records, m, whose motions have some centimetres.
NOISE = 2e-5

MOUNT = {"between": ["ground", "a"], "stiffness": 60.0, "damping": 0.3}
BODY = {"mass": 1.2, "start": {"s": "30 mm", "v": 0.4}}
# For each law: the machine, and one of its numbers.
LAWS = {
    "cubic": ({"spring": {"k": {**MOUNT, "cubic": "3e4 N/m3"}}}, "spring.k.cubic"),
    "power": ({"spring": {"k": {**MOUNT, "coefficient": "900 N/m^2.5", "exponent": 2.5}}}, "spring.k.coefficient"),
    "drag": ({"spring": {"k": MOUNT}, "damper": {"d": {"between": ["ground", "a"], "quadratic": 0.8}}}, "damper.d.quadratic"),
    "across": ({"spring": {"k": {"between": ["ground", "a"], "stiffness": 900.0, "offset": "80 mm", "free_length": "70 mm"}}}, "spring.k.free_length"),
    "hertz": (
        {"spring": {"k": MOUNT}, "stop": {"h": {"between": ["ground", "a"], "gap": "35 mm", "stiffness": "4e4 N/m^1.5", "exponent": 1.5, "dissipation": 0.1}}},
        "stop.h.stiffness",
    ),
    "formula": ({"spring": {"k": {**MOUNT, "force": "= depth * sin(20 * e)"}}, "parameters": {"depth": 3.0}}, "depth"),
    "stribeck": (
        {"spring": {"k": MOUNT}, "friction": {"f": {"between": ["ground", "a"], "force": 0.2, "static": 0.5, "stribeck": 0.15, "stribeck_exponent": 1, "viscous": 0.1}}},
        "friction.f.stribeck",
    ),
}


def machine(law: str) -> "tuple[vi.Machine, str]":
    own, number = LAWS[law]
    return vi.Machine({"name": "Curved", "body": {"a": BODY}, **own}), number


@pytest.mark.parametrize("law", LAWS)
def test_derivative_columns_are_differences(law: str) -> None:
    own, number = machine(law)
    run = own.simulate(until=1.0, samples=50, derivatives=[number])
    value = own.parameters[number]
    ends = [own.replace({number: value * (1 + sign * SHIFT)}).simulate(until=1.0, samples=50) for sign in (1, -1)]
    for column in ("a.s", "a.v"):
        difference = (ends[0][column] - ends[1][column]) / (2 * SHIFT * value)
        exact = run.derivative(column, number)
        assert np.abs(exact).max() > 0
        assert np.allclose(exact, difference, rtol=0, atol=OF_DIFFERENCE * max(1 / abs(value), np.abs(exact).max())), column


@pytest.mark.parametrize("law", LAWS)
def test_a_record_gives_the_number_back(law: str) -> None:
    own, number = machine(law)
    run = own.simulate(until=1.5, samples=150)
    record = run["a.s"] + NOISE * np.random.default_rng(3).standard_normal(len(run.t))
    truth = own.parameters[number]
    found = vi.fit(own.replace({number: 0.8 * truth}), {"a.s": (run.t, record)}, free=[number])
    error = found.errors[number]
    assert error is not None and abs(found.values[number] - truth) < FAR * error < 0.1 * abs(truth), (found.values, found.errors)
    assert found.verdict == "fits"


def test_the_file_is_kept() -> None:
    for law in LAWS:
        own, number = machine(law)
        assert vi.Machine(own.toml).parameters == own.parameters, law
        assert number in own.parameters
