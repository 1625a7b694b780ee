"""The coupling examples: a machine cut in two, a master that steps to the impacts, an SSP archive."""

import math
import platform
import sys
from pathlib import Path

import numpy as np
import oracle
import pytest
from scipy.integrate import solve_ivp

EXAMPLES = Path(__file__).parents[2] / "examples"
sys.path[:0] = [str(EXAMPLES), str(EXAMPLES / "coupling")]

import events_fmi3  # noqa: E402
import partitioned  # noqa: E402
import ssp  # noqa: E402
import step_to_impacts  # noqa: E402
import vibro  # noqa: E402

# pythonfmu only has binaries for these.
pythonfmu_runs = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64") or sys.platform == "darwin",
    reason="pythonfmu has binaries for 64-bit Linux and Windows on x86 only",
)

# Error of the oscillator relative to its closed form: a few roundings.
ROUND_OFF = 1e-13

# Sums of 4000 steps of 0.01 s, which one host counts in nanoseconds: times differ by 1e-12 s, and
# so do impacts.
SAME_SYSTEM = 1e-9

# DOP853 at 1e-12 with impacts by event has an error of about 1e-9 after some periods.
ORACLE = 1e-8


@pytest.fixture(scope="module")
def oscillator(tmp_path_factory):
    return partitioned.build_oscillator(tmp_path_factory.mktemp("oscillator"))


def slope(steps, errors):
    """Order of the error, by least squares."""
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


@pythonfmu_runs
def test_oscillator_equals_dop853(oscillator):
    p = {"m": 0.2, "k": 0.5, "c": 0.03, "kc": 0.1}
    s, v, a = 0.3, -0.2, 0.15
    with vibro.Slave(oscillator, {**p, "s": s, "v": v, "a": a}) as slave:
        slave.step(0.0, 3.0)
        got = slave.reals(["x", "dx", "f"])

    def rate(t, y):
        pull = p["kc"] * (s + v * t + a * t * t / 2 - y[0])
        return [y[1], (pull - p["k"] * y[0] - p["c"] * y[1]) / p["m"]]

    x, dx = solve_ivp(rate, (0.0, 3.0), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    np.testing.assert_allclose(got, [x, dx, p["kc"] * (x - (s + 3 * v + 4.5 * a))], rtol=0, atol=1e-10)


@pythonfmu_runs
def test_oscillator_does_not_depend_on_the_step(oscillator):
    ends = []
    for count in (1, 7):
        with vibro.Slave(oscillator, {"s": 0.3, "v": -0.2, "a": 0.15}) as slave:
            for i in range(count):
                slave.step(i * 4.0 / count, 4.0 / count)
            ends.append(slave.reals(["x", "dx", "f", "df"]))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=ROUND_OFF)


@pythonfmu_runs
def test_coupling_errors_fall_with_the_order_of_each_master(fmu, oscillator):
    """First, second, second (impacts inside steps), third and third order; the last two reach the whole machine's motion."""
    steps = (80, 160, 320, 640)
    table = partitioned.curves(fmu, oscillator, steps)
    orders = {name: slope(steps, curve.errors) for name, curve in table.items()}
    assert len(orders) == 5
    for (name, order), expected in zip(orders.items(), (1.0, 1.7, 1.7, 2.9, 2.9)):
        assert expected - 0.3 < order < expected + 0.6, (name, order, table[name])
    *last, events = [curve.errors[-1] for curve in table.values()]
    assert last == sorted(last, reverse=True), table
    assert last[0] > 1e-3, "the plain coupling shows its error"
    assert last[-1] < 1e-7 and events < 2e-7, table


@pythonfmu_runs
def test_steps_to_the_announced_events_cost_one_step_each(fmu, oscillator):
    """No step is repeated: apart from the steps to the grid there are only steps that end at events, some of them in two parts."""
    run = partitioned.cut_by_events(vibro.fmi3_beside(fmu), oscillator, 40, 10)
    met = 15  # impacts: at most two a period, and the start
    assert run.computed == run.steps == run.iterations <= 40 * partitioned.PERIODS + 2 * met
    same = partitioned.cut_by_events(vibro.fmi3_beside(fmu), oscillator, 40, 10)
    assert np.array_equal(run.states, same.states)


@pythonfmu_runs
def test_iterations_are_those_of_newtons_method(fmu, oscillator, monkeypatch):
    """Without the directional derivative the same result takes more iterations."""
    name, master, to_impacts = partitioned.MASTERS[-1]
    newton = partitioned.cut(fmu, oscillator, master, 10, 10, to_impacts=to_impacts)
    monkeypatch.setattr(vibro.Slave, "derivative", lambda self, unknown, known: 0.0)
    plain = partitioned.cut(fmu, oscillator, master, 10, 10, to_impacts=to_impacts)
    np.testing.assert_allclose(np.array(newton.states), np.array(plain.states), rtol=0, atol=1e-9)
    assert newton.iterations < plain.iterations, (newton.iterations, plain.iterations)


def test_steps_to_the_impacts_of_dop853(fmu, period):
    start = {"block.s": 0.9, "block.v": 0.5}
    stop = 10 * period
    found = list(step_to_impacts.impacts(fmu, start, stop, period / 10))
    p = vibro.start_values(fmu)
    _, expected = oracle.simulate(p, [0.0, 0.9, 0.0, 0.0, 0.5, 0.0], np.linspace(0.0, stop, 201))
    assert len(found) == len(expected) > 10
    np.testing.assert_allclose([impact.time for impact in found], expected, rtol=0, atol=ORACLE)
    reduced = p["box.m"] * p["block.m"] / (p["box.m"] + p["block.m"])
    for impact in found:
        assert impact.impulse == pytest.approx((1 + p["stop.restitution"]) * reduced * impact.speed, rel=1e-12)
    assert {impact.stop for impact in found} == {"upper", "lower"}


def test_events_of_fmi3_are_those_of_dop853(fmu, period):
    """Both limits of each impact, compared with another solver; every impact is announced for its time."""
    stop = 10 * period
    start = {"block.s": 0.9, "block.v": 0.5}
    found = list(events_fmi3.events(vibro.fmi3_beside(fmu), start, stop, period / 10))
    p = vibro.start_values(fmu)
    _, expected = oracle.simulate(p, [0.0, 0.9, 0.0, 0.0, 0.5, 0.0], np.linspace(0.0, stop, 201))
    assert len(found) == len(expected) > 10
    np.testing.assert_allclose([event.time for event in found], expected, rtol=0, atol=ORACLE)
    for event, following in zip(found, found[1:]):
        assert max(event.errors(p)) < events_fmi3.ROUNDING, event
        assert event.kind.startswith("impact") and event.announced, event
        assert event.before.relative * event.after.relative < 0 and event.next_event == pytest.approx(following.time)
        assert sum(event.after.counts) == sum(event.before.counts) + 1


def test_events_of_fmi3_with_rest_and_release(fmu, period):
    """Chatter ends in rest, followed by a release; no law is violated at any event."""
    start = {"stop.restitution": 0.3, "drive.amplitude": 0.4, "block.v": 0.3, "block.f": 0.02}
    fmu3 = vibro.fmi3_beside(fmu)
    found = list(events_fmi3.events(fmu3, start, 40 * period, period / 10))
    kinds = {event.kind for event in found}
    assert "release" in kinds and any("rest" in kind for kind in kinds), kinds
    parameters = {**vibro.start_values(fmu3), **start}
    for event in found:
        assert max(event.errors(parameters)) < events_fmi3.ROUNDING, event


@pytest.fixture(scope="module")
def archive(fmu, tmp_path_factory):
    return ssp.build(fmu, tmp_path_factory.mktemp("ssp") / "motor.ssp")


@pythonfmu_runs
def test_ssp_archive_is_valid_and_says_units_and_parameters(archive):
    from fmpy.ssp.ssd import find_components, read_ssd

    structure = read_ssd(str(archive))  # checks it against the schema of SSP 1.0
    assert {unit.name for unit in structure.units} == set(ssp.UNITS)
    used = {unit for connectors in ssp.CONNECTORS.values() for _, _, unit in connectors}
    used |= {unit for values in ssp.PARAMETERS.values() for _, unit in values.values()}
    assert used <= set(ssp.UNITS)
    given = {
        (component.name, parameter.name): (float(parameter.value), parameter.unit)
        for component in find_components(structure.system)
        for binding in component.parameterBindings
        for values in binding.parameterValues
        for parameter in values.parameters
    }
    assert given == {(c, n): value for c, values in ssp.PARAMETERS.items() for n, value in values.items()}


@pythonfmu_runs
def test_ssp_in_fmpy_equals_a_master_written_out(archive, fmu, tmp_path):
    """fmpy couples by Jacobi's scheme: all step with the values of the previous step, zero at first."""
    from pythonfmu.builder import FmuBuilder

    stop, step = 40.0, 0.01
    result = ssp.run_fmpy(archive, stop, step)
    FmuBuilder.build_FMU(EXAMPLES / "coupling" / "drive_train.py", dest=tmp_path)
    start = {name: {n: value for n, (value, _) in values.items()} for name, values in ssp.PARAMETERS.items()}
    motor = vibro.Slave(tmp_path / "DriveTrain.fmu", start["motor"], name="motor")
    with vibro.Slave(fmu, start["machine"]) as machine, motor:
        force = acceleration = impulse = time = 0.0
        for i in range(round(stop / step)):
            machine.set("box.f", force)
            motor.set("acceleration", acceleration)
            motor.set("impulse", impulse)
            machine.step(time, step)
            motor.step(time, step)
            force, acceleration, impulse = motor.get("force"), machine.get("box.a"), machine.get("box.impulse")
            assert result["machine.box.s"][i] == machine.get("box.s")
            assert result["motor.speed"][i] == motor.get("speed")
            time += step
        assert machine.get("impacts.upper") > 0, "the shaken box meets the block"
    assert math.isclose(result["time"][-1], stop, rel_tol=1e-9)


#: The damper of docs/design-a-damper.md, and a motor on it that reaches the machine's resonance.
DAMPER = {
    "box.m": 12.0, "box.k": 48e3, "box.c": 30.0, "block.m": 1.1, "stop.gap": 0.018, "stop.restitution": 0.5,
    "drive.amplitude": 0.0, "coupling.k": 0.0,
}
MOTOR = {"inertia": 0.01, "eccentricity": 0.019, "torque": 3.0, "idle": 70.0, "mass": 12.0}
STANDSTILL = 0.5  # rad/s, with which drive_train.py begins


def in_one_piece(p, motor, stop):
    """Box, block and rotor as one system of equations: speed of the rotor and number of impacts, by DOP853 with events.

    The impact law of the whole machine: the rotor resists the box's jump, so that the box's effective mass is m1 - (m r cos φ)²/J.
    Bounces lower than 1e-9 gaps end in rest, because no method can follow infinitely many.
    """
    m1, m2, gap, kappa = p["box.m"], p["block.m"], p["stop.gap"], p["stop.restitution"]
    inertia, eccentricity = motor["inertia"], motor["eccentricity"]

    def rates(t, y, together):
        x, _, v, u, angle, speed = y
        turn = eccentricity * math.cos(angle)
        torque = motor["torque"] * (1.0 - speed / motor["idle"])
        push = eccentricity * speed**2 * math.sin(angle) - p["box.c"] * v - p["box.k"] * x
        mass = m1 + (m2 if together else 0.0)
        a = (push - turn * torque / inertia) / (mass - turn**2 / inertia)
        return [v, u, a, a if together else 0.0, speed, (torque - turn * a) / inertia]

    def flight(t, y):
        return rates(t, y, False)

    def rest(t, y):
        return rates(t, y, True)

    def upper(t, y):
        return y[1] - y[0] - gap

    def lower(t, y):
        return y[0] - y[1] - gap

    def release(t, y):
        return side * rest(t, y)[3]  # the block needs a push away from the stop to stay

    for event in (upper, lower):
        event.terminal, event.direction = True, 1.0
    release.terminal, release.direction = True, 1.0
    time, y, side, impacts = 0.0, np.array([0.0, 0.0, 0.0, 0.0, 0.0, STANDSTILL]), 0.0, 0
    while True:
        events = (release,) if side else (upper, lower)
        run = solve_ivp(rest if side else flight, (time, stop), y, "DOP853", events=events, rtol=1e-10, atol=1e-12, max_step=1e-3)
        assert run.success, run.message
        time, y = run.t[-1], run.y[:, -1].copy()
        if run.status == 0:
            return y[5], impacts
        if side:
            side = 0.0
            y[1] -= 1e-12 * gap * np.sign(y[1] - y[0])
            continue
        side_met = 1.0 if len(run.t_events[0]) else -1.0
        turn = eccentricity * math.cos(y[4])
        free = 1.0 / (m1 - turn**2 / inertia)
        approach = y[3] - y[2]
        pressing = -side_met * flight(time, y)[2]
        bounce = (kappa * approach) ** 2 / (2.0 * abs(pressing) + 1e-300)
        resting = -pressing < 0.0 and bounce < 1e-9 * gap
        impulse = (1.0 if resting else 1.0 + kappa) * approach / (free + 1.0 / m2)
        y[2] += impulse * free
        y[3] -= impulse / m2
        y[5] -= turn / inertia * impulse * free
        impacts += 1
        if resting:
            side = side_met
        else:
            y[1] = y[0] + side_met * gap * (1.0 - 1e-12)


def coupled(fmu, motor_fmu, step, stop, impulses=True):
    """Speed of the rotor at the end: both step with the other's values at the end of the previous step."""
    connections = [("acceleration", "box.a"), ("impulse", "box.impulse")][: 2 if impulses else 1]
    with vibro.Slave(fmu, DAMPER) as machine, vibro.Slave(motor_fmu, MOTOR, name="motor") as motor:
        for i in range(round(stop / step)):
            machine.set("box.f", motor.get("force"))
            for name, output in connections:
                motor.set(name, machine.get(output))
            machine.step(i * step, step)
            motor.step(i * step, step)
        return motor.get("speed")


@pythonfmu_runs
def test_a_motor_on_the_damper_turns_as_in_the_machine_in_one_piece(fmu, tmp_path):
    """With the impulses the coupling converges to the machine; without them to a different one, however short the step."""
    from pythonfmu.builder import FmuBuilder

    FmuBuilder.build_FMU(EXAMPLES / "coupling" / "drive_train.py", dest=tmp_path)
    motor, stop = tmp_path / "DriveTrain.fmu", 2.0
    expected, impacts = in_one_piece(DAMPER, MOTOR, stop)
    assert impacts > 10
    steps = (4e-4, 2e-4)
    right = [coupled(fmu, motor, step, stop) for step in steps]
    wrong = [coupled(fmu, motor, step, stop, impulses=False) for step in steps]
    # First order in the step, and the reaction within an impact: 0.3 % of the box's mass.
    assert abs(right[-1] - expected) < 0.1, (right, expected)
    assert min(abs(speed - expected) for speed in wrong) > 0.5, (wrong, expected)


@pythonfmu_runs
def test_ssp_in_libcosimpy_gives_what_fmpy_gives(archive):
    """Both hosts couple by Jacobi's scheme, and outputs are zero at the start; libcosimpy's times are whole nanoseconds."""
    pytest.importorskip("libcosimpy", reason="libcosimpy has no wheel for this Python or platform")
    ours, theirs = (run(archive, 40.0, 0.01) for run in (ssp.run_fmpy, ssp.run_libcosimpy))
    assert set(theirs) == set(ours)
    for name in ("motor.speed", "motor.force", "machine.box.s", "machine.block.s", "machine.stop.s"):
        assert np.ptp(ours[name]) > 0.1, name
        np.testing.assert_allclose(theirs[name], ours[name], rtol=0, atol=SAME_SYSTEM)
