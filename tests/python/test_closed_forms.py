"""Closed forms and orbits compared with the simulation and with each other."""

import numpy as np
import pytest
import vibro_impact as vi

# Remainder of the transient after 1000 periods, and a few roundings.
SETTLED = 1e-9
# Difference of two solutions of one orbit, by Newton's method and in closed form.
SOLVED = 1e-11


@pytest.fixture(scope="module")
def machine():
    return vi.PaperMachine.from_groups(f10=1.5)


def test_exact_orbit_is_the_settled_motion(machine):
    orbit = machine.steady().exact_orbit
    assert orbit.stable and orbit.eigenvalues.shape == (0,) and orbit.multipliers.shape == (6,)
    run = machine.simulate(start=orbit.start, periods=3, per_period=64)
    s, v = orbit.motion(machine.drive_frequency * run.t)
    np.testing.assert_allclose(run.s, s, rtol=0, atol=SETTLED)
    np.testing.assert_allclose(run.v, v, rtol=0, atol=SETTLED)
    section = machine.poincare(periods=1, settle=1000)
    np.testing.assert_allclose(section.s[0], s[0], rtol=0, atol=SETTLED)


def test_approximations_are_off_by_the_mass_ratio(machine):
    off = []
    for epsilon in (0.02, 0.01):
        steady = machine.replace(epsilon=epsilon).steady()
        for theory in (steady.multiple_scales, steady.strong_coupling):
            assert theory.stable and theory.eigenvalues.shape == (4,) and theory.multipliers.shape == (2,)
            off.append(np.abs(theory.amplitudes / steady.exact_orbit.amplitudes - 1).max())
    # The error is of first order: half the mass ratio halves the error, within a third.
    assert max(off) < 0.2 and all(off[i + 2] < 0.67 * off[i] for i in (0, 1))


def test_the_secondary_amplitude_is_within_what_the_paper_says(machine):
    steady = machine.steady()
    assert abs(steady.multiple_scales.A3 / steady.exact_orbit.A3 - 1) < 0.08
    assert machine.replace(f10=0.01).steady().exact_orbit is None
    assert set(machine.replace(f10=0.01).steady().reasons) == {"multiple_scales", "strong_coupling", "exact_orbit"}


def test_orbit_of_a_word_is_the_closed_form(machine):
    exact, half, whole = machine.steady().exact_orbit, machine.orbit("U", symmetric=True), machine.orbit("UL")
    assert half.phases[0] % (2 * np.pi) == pytest.approx(exact.drive_phase, abs=SOLVED)
    np.testing.assert_allclose(np.sort(np.abs(half.multipliers)), np.sort(np.abs(exact.multipliers)), atol=1e-9)
    # The result has the whole word of the symmetric orbit and names its multipliers.
    assert (whole.word, whole.symmetric, whole.passages, whole.multiplier_periods) == ("U", True, 1, 0.5)
    np.testing.assert_allclose(np.abs(whole.multipliers), np.abs(half.multipliers), atol=1e-9)
    settled = machine.orbit()
    assert settled.symmetric and settled.stable
    np.testing.assert_allclose(whole.maxima("x2").max(), exact.amplitudes[1], rtol=1e-10)
    np.testing.assert_allclose(settled.start, exact.start, atol=1e-9)


def test_an_orbit_passed_twice_is_said_to_be_that():
    machine = vi.PaperMachine.from_groups(f10=2.2)
    once, twice = machine.orbit("UL"), machine.orbit("ULUL", period="2T")
    assert (once.word, once.passages, once.multiplier_periods) == ("UL", 1, 1.0)
    assert (twice.periods, len(twice.word), twice.passages, twice.multiplier_periods) == (1, 2, 2, 1.0)
    np.testing.assert_allclose(np.abs(twice.multipliers), np.abs(once.multipliers), atol=1e-9)
    # Beyond the period doubling, the word has an orbit of its own.
    assert machine.replace(f10=2.43).orbit("ULUL", period="2T").periods == 2


def test_the_symmetric_orbit_of_a_block_without_a_spring_is_the_closed_form():
    machine = vi.PaperMachine(coupling_k=0.0)
    exact, orbit = machine.steady().exact_orbit, machine.orbit("U", symmetric=True)
    assert orbit.phases[0] % (2 * np.pi) == pytest.approx(exact.drive_phase, abs=SOLVED)
    branch = orbit.follow("drive_amplitude", 0.1, 0.25)
    assert branch.multiplier_periods == 0.5 and len(branch.value) > 10


def test_an_orbit_with_three_impacts_is_a_motion_of_the_simulator():
    machine = vi.PaperMachine.from_groups(f10=2.7)
    orbit = machine.orbit("UUL")
    run = machine.simulate(start=orbit.start, periods=1, per_period=1)
    np.testing.assert_allclose(run.end, run.s[0].tolist() + run.v[0].tolist(), rtol=0, atol=1e-8)
    assert sorted(run.impacts["stop"]) == [-1, 1, 1]
    speeds = np.sort(run.impacts["speed"])
    np.testing.assert_allclose(speeds, np.sort(orbit.speeds), rtol=0, atol=1e-8)


def test_sections(machine):
    orbit = machine.steady().exact_orbit
    upper, lower = (machine.poincare(at, start=orbit.start, settle=10, periods=20) for at in ("upper", "lower"))
    assert len(upper.t) == len(lower.t) == 20
    np.testing.assert_allclose(upper.phase, orbit.drive_phase, atol=1e-8)
    np.testing.assert_allclose(upper.s[:, 1] - upper.s[:, 0], machine.stop_gap, atol=1e-12)
    np.testing.assert_allclose(lower.s, -upper.s, atol=1e-8)
    quarter = machine.replace(drive_phase=0.3).poincare(phase=np.pi / 2, periods=3, settle=0)
    np.testing.assert_allclose(quarter.phase, np.pi / 2, atol=1e-12)
    assert quarter.t[0] == pytest.approx((np.pi / 2 - 0.3) / machine.drive_frequency)


def test_measures_of_the_exact_orbit(machine):
    orbit = machine.steady().exact_orbit
    names = ["amplitude.x1", "amplitude.x2", "amplitude.x3", "impacts", "class", "exponent"]
    found = machine.measure(names, start=orbit.start, periods=8, settle=10)
    np.testing.assert_allclose([found[n] for n in names[:3]], orbit.amplitudes, rtol=1e-9)
    assert list(found) == names and found["impacts"] == 2.0 and found["class"] == "1T"
    assert set(names) < set(vi.MEASURES) and vi.MEASURES["amplitude.x1"][0] == "m"


def test_energy_is_balanced(machine):
    run = machine.simulate(periods=50)
    e = run.energy
    np.testing.assert_allclose(e["mechanical"], e["mechanical"][0] + e["input"] - e["damped"] - e["impact"], atol=1e-11)
    assert np.abs(run.w).max() <= machine.stop_gap * (1 + 1e-15)


def test_a_run_goes_on_from_its_end(machine):
    whole = machine.simulate(periods=4, per_period=4)
    first = machine.simulate(periods=2, per_period=4)
    second = machine.simulate(start=first.end, periods=2, per_period=4)
    np.testing.assert_allclose(second.s, whole.s[8:], rtol=0, atol=1e-13)
    table = whole.to_pandas()
    assert table.index[-1] == whole.t[-1] and table["block.v"].iloc[-1] == whole.v[-1, 1]
    assert "energy.damped" in table


def test_many_starts_of_one_machine_and_one_by_one(machine):
    starts = [{"x2": x2, "v1": 0.1} for x2 in np.linspace(-0.9, 0.9, 9)]
    ends = vi.simulate_many(machine, starts=starts, periods=10)
    for start, s in zip(starts, ends.s):
        # Ten periods amplify the rounding difference between the two ways.
        np.testing.assert_allclose(machine.simulate(start=start, periods=10, per_period=1).s[-1], s, rtol=0, atol=1e-9)
    again = vi.simulate_many([machine] * 9, starts=ends.states, periods=1)
    assert again.s.shape == (9, 3) and (again.t == machine.period).all()


def test_the_orbit_without_impacts_is_the_swing_of_the_box():
    machine = vi.PaperMachine.from_groups(f10=0.3)
    orbit = machine.orbit(start={"x2": 0.0})
    assert (orbit.word, orbit.stable, len(orbit.phases)) == ("-", True, 0)
    assert orbit.maxima("x1")[0] == pytest.approx(machine.measure(["amplitude.without_block"])["amplitude.without_block"], rel=1e-12)
    np.testing.assert_allclose(machine.simulate(start=orbit.start, periods=1).end, orbit.start, atol=1e-12)
    assert [label for label, _ in orbit.follow("f10", 0.1, 4.0).special] == ["EP", "GR"]
