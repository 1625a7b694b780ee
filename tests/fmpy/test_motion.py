"""The motion of the packaged FMU compared with the native library and with an independent integration."""

import fmpy
import numpy as np
import oracle
import pytest
from conftest import STATES

PERIODS = 200

# The specified bound. The default motion is stable, so that the rounding of communication
# points (1e-13 at t = 1200 s) is not amplified; measured differences are below 1e-12.
SAME = 1e-10

# DOP853 at 1e-12 with impacts by event has an error of about 1e-9 after ten periods with impacts.
ORACLE = 1e-8

STEPS = {"tenth": 1.0 / 10.0, "odd": 1.0 / 7.3, "long": 13.0}


def run(fmu, period, step, **options):
    return fmpy.simulate_fmu(
        fmu,
        stop_time=PERIODS * period,
        output_interval=step * period,
        output=[*STATES, "impacts.upper", "impacts.lower"],
        fmi_type="CoSimulation",
        **options,
    )


def table(result):
    return np.column_stack([result[name] for name in STATES])


@pytest.mark.parametrize("name", STEPS)
def test_equals_the_native_run(fmu, native, period, name):
    result, expected = run(fmu, period, STEPS[name]), native(name)
    # fmpy before 0.3.22 may end with a step as short as a rounding error; the native run has no
    # point for it.
    result = result[np.append(np.diff(result["time"]) > 1e-9, True)]
    assert len(result) == len(expected)
    np.testing.assert_allclose(result["time"], expected["time"], rtol=1e-13, atol=0)
    np.testing.assert_allclose(table(result), table(expected), rtol=0, atol=SAME)
    np.testing.assert_array_equal(result["impacts.upper"] + result["impacts.lower"], expected["impacts"])


def test_does_not_depend_on_the_communication_step(fmu, period):
    ends = np.array([table(run(fmu, period, step))[-1] for step in STEPS.values()])
    assert np.abs(ends[0]).max() > 0.1, "a motion at rest proves nothing"
    np.testing.assert_allclose(ends[1:], ends[:1].repeat(2, axis=0), rtol=0, atol=SAME)


def test_equals_dop853(new, description, period):
    """Ten periods from a start that reaches both stops, with loads."""
    start = dict(zip(STATES, (0.1, -0.3, 0.2, -0.4, 0.9, 0.3)))
    loads = {"box.f": 0.02, "block.f": -0.01, "secondary.f": 0.015}
    instance = new()
    for name, value in start.items():
        instance.set(name, value)
    instance.initialize()
    for name, value in loads.items():
        instance.set(name, value)
    times = np.linspace(0.0, 10.0 * period, 101)
    got = [instance.get(*STATES)]
    for begin, end in zip(times, times[1:]):
        instance.step(begin, end - begin)
        got.append(instance.get(*STATES))
    parameters = {v.name: float(v.start) for v in description.modelVariables
                  if v.causality == "parameter" and v.type == "Real"}
    expected, impacts = oracle.simulate(parameters, list(start.values()), times, tuple(loads.values()))
    assert len(impacts) >= 10
    np.testing.assert_allclose(got, expected, rtol=0, atol=ORACLE)
    assert sum(instance.count("impacts.upper", "impacts.lower")) == len(impacts)
    assert instance.get("impacts.lastTime")[0] == pytest.approx(impacts[-1], abs=ORACLE)


def test_input_derivatives_equal_dop853(new, description, period):
    """Loads that are cubic in time, given by value and three derivatives at each communication point (not through
    `simulate_fmu`, whose `set_input_derivatives` is broken in fmpy 0.3.32)."""
    cubics = {"box.f": (0.02, -0.01, 0.004, -0.0005), "secondary.f": (-0.01, 0.02, -0.003, 0.0002)}

    def derivatives(c, t):
        return (c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[1] + t * (2 * c[2] + t * 3 * c[3]), 2 * c[2] + 6 * c[3] * t,
                6 * c[3])

    def loads(t):
        return derivatives(cubics["box.f"], t)[0], 0.0, derivatives(cubics["secondary.f"], t)[0]

    start = dict(zip(STATES, (0.1, -0.3, 0.2, -0.4, 0.9, 0.3)))
    instance = new()
    for name, value in start.items():
        instance.set(name, value)
    instance.initialize()
    times = np.linspace(0.0, 2.0 * period, 8)
    got = [instance.get(*STATES)]
    for begin, end in zip(times, times[1:]):
        for name, cubic in cubics.items():
            value, *slopes = derivatives(cubic, begin)
            reference = instance.references[name]
            instance.set(name, value)
            instance.slave.setRealInputDerivatives([reference] * 3, [1, 2, 3], slopes)
        instance.step(begin, end - begin)
        got.append(instance.get(*STATES))
    parameters = {v.name: float(v.start) for v in description.modelVariables
                  if v.causality == "parameter" and v.type == "Real"}
    expected, impacts = oracle.simulate(parameters, list(start.values()), times, loads)
    assert len(impacts) >= 2
    np.testing.assert_allclose(got, expected, rtol=0, atol=ORACLE)
    held, _ = oracle.simulate(parameters, list(start.values()), times, loads(0.0))
    assert np.abs(held - expected).max() > 0.1, "the loads must matter"


def test_loads_of_an_off_centre_gap_equal_dop853_with_shifted_stops(new, description, period):
    """docs/theory.md (97): the pair of loads compared with a model with stops at unequal distances."""
    b = 0.2
    parameters = {v.name: float(v.start) for v in description.modelVariables
                  if v.causality == "parameter" and v.type == "Real"}
    start = np.array((0.1, -0.3, 0.2, -0.4, 0.9, 0.3))
    middle = np.array((0.0, b, 0.0, 0.0, 0.0, 0.0))
    instance = new()
    for name, value in zip(STATES, start - middle):
        instance.set(name, value)
    instance.initialize()
    instance.set("block.f", -parameters["coupling.k"] * b)
    instance.set("secondary.f", parameters["coupling.k"] * b)
    times = np.linspace(0.0, 10.0 * period, 101)
    got = [instance.get(*STATES)]
    for begin, end in zip(times, times[1:]):
        instance.step(begin, end - begin)
        got.append(instance.get(*STATES))
    expected, impacts = oracle.simulate(parameters, list(start), times, offset=b)
    assert len(impacts) >= 8
    np.testing.assert_allclose(np.array(got) + middle, expected, rtol=0, atol=ORACLE)


def test_energy_balances(new, period):
    """mechanical = initial + input - damped - impact, at every communication point."""
    names = [f"energy.{name}" for name in ("mechanical", "input", "damped", "impact")]
    instance = new()
    instance.set("block.v", 0.9)
    instance.initialize()
    mechanical, work, damped, impact = instance.get(*names)
    initial = mechanical - work + damped + impact
    assert initial == pytest.approx(0.5 * 0.1 * 0.9**2)
    for i in range(200):
        instance.step(i * period / 10.0, period / 10.0)
        mechanical, work, damped, impact = instance.get(*names)
        # Rounding of accounts of about 1 J.
        assert mechanical == pytest.approx(initial + work - damped - impact, abs=1e-11)
    assert impact > 0.01 and damped > 0.01


def test_two_instances_do_not_disturb_each_other(new, period):
    """Interleaved instances with different parameters and steps each move as they do alone."""
    step = period / 10.0

    def one(name, kappa):
        instance = new(name)
        instance.set("stop.restitution", kappa)
        return instance.initialize()

    def alone(kappa, per_turn):
        instance = one("alone", kappa)
        path = []
        for i in range(300 * per_turn):
            instance.step(i * step / per_turn, step / per_turn)
            path.append(instance.get(*STATES))
        return np.array(path)

    a, b = one("a", 0.75), one("b", 0.6)
    paths = [], []
    for i in range(300):
        a.step(i * step, step)
        paths[0].append(a.get(*STATES))
        for j in range(2):
            b.step((2 * i + j) * step / 2, step / 2)
            paths[1].append(b.get(*STATES))
    assert np.abs(paths[0][-1] - paths[1][-1]).max() > 1e-3, "the two must move differently"
    np.testing.assert_array_equal(paths[0], alone(0.75, 1))
    np.testing.assert_array_equal(paths[1], alone(0.6, 2))


def test_restored_state_continues_with_the_same_bits(new, period):
    """Also in an instance that was never initialized, because some hosts resume that way."""
    first = new("first").initialize()
    for i in range(80):
        first.step(i * period / 7, period / 7)
    state = first.slave.getFMUstate()
    plain = first.slave.serializeFMUstate(state)
    first.slave.freeFMUstate(state)
    second = new("second")
    state = second.slave.deSerializeFMUstate(plain)
    second.slave.setFMUstate(state)
    second.slave.freeFMUstate(state)
    for i in range(80, 160):
        for instance in (first, second):
            instance.step(i * period / 7, period / 7)
        np.testing.assert_array_equal(first.get(*STATES), second.get(*STATES))
