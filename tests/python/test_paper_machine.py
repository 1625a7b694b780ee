"""The machine as a value: names, text, equality, pickling, dependent parameters."""

import copy
import pickle
import warnings

import numpy as np
import pytest
import vibro_impact as vi

SEVERAL = [
    vi.PaperMachine(),
    vi.PaperMachine(box_m=12.0, box_k=48e3, stop_gap=0.0025, drive_frequency=63.1),
    vi.PaperMachine.from_groups(f10=1.5, kappa=0.75),
    vi.PaperMachine.from_groups(alpha23=0.5, epsilon=0.05),
    vi.PaperMachine.from_groups(beta2=0.3, epsilon=0.07, mu13=1.0).replace(epsilon=0.1),
    vi.PaperMachine(box_m=3.0, f10=0.3),
    vi.PaperMachine.from_groups(f10=0.3, epsilon=0.2).replace(block_m=1 / 3).replace(kappa=0.1),
]


@pytest.mark.parametrize("machine", SEVERAL, ids=repr)
def test_text_pickle_and_copy_make_the_same_machine(machine):
    pasted = eval(repr(machine), {"PaperMachine": vi.PaperMachine})
    pickled = [pickle.loads(pickle.dumps(machine, protocol)) for protocol in range(2, 6)]
    for other in [pasted, *pickled, copy.copy(machine), copy.deepcopy(machine)]:
        assert other == machine and hash(other) == hash(machine) and repr(other) == repr(machine)
        assert {n: getattr(other, n) for n in vi.GROUP_NAMES} == {n: getattr(machine, n) for n in vi.GROUP_NAMES}
        # The value also includes which groups keep their values when a parameter changes.
        assert other.replace(epsilon=0.008) == machine.replace(epsilon=0.008)


def test_parameters_have_the_names_of_the_fmu_with_underscores():
    assert vi.SI_NAMES[0] == "box_m" and vi.SI_NAMES[-4] == "drive_phase" and len(vi.SI_NAMES) == 16
    assert vi.SI_NAMES[-3:] == ("load_box", "load_block", "load_secondary")
    assert {name for kind in vi.PaperMachine.__mro__ for name in vars(kind).get("__annotations__", {})} >= set(vi.SI_NAMES + vi.GROUP_NAMES)
    assert vi.PaperMachine(m1=2.0, L=0.5) == vi.PaperMachine(box_m=2.0, stop_gap=0.5)
    assert vi.PaperMachine.from_groups(**{"ε": 0.05}) == vi.PaperMachine.from_groups(epsilon=0.05)
    assert vi.PaperMachine().m1 == 1.0


def test_closed_form_of_the_groups():
    m = vi.PaperMachine(box_m=2.0, box_k=8.0, stop_gap=0.01, f10=1.25)
    assert (m.box_m, m.box_k, m.stop_gap, m.f10) == (2.0, 8.0, 0.01, 1.25)
    assert m.drive_amplitude == pytest.approx(1.25 * 8.0 * 0.01 * m.epsilon, rel=1e-15)
    assert m.period == 2 * np.pi / m.drive_frequency


def test_of_tied_groups_the_one_set_last_is_held():
    weak = vi.PaperMachine.from_groups(alpha23=0.5, epsilon=0.05)
    assert weak.beta2 == 0.05 * 0.5 and weak.mu13 == 20.0
    strong = vi.PaperMachine.from_groups(beta2=0.3, mu13=1.0).replace(epsilon=0.05)
    assert (strong.beta2, strong.mu13) == (0.3, 1.0)
    # In one call, later keywords take precedence, as in successive calls.
    assert vi.PaperMachine.from_groups(beta2=0.3).replace(alpha23=0.5).replace(epsilon=0.05) == weak.replace(alpha23=0.5)


def test_one_change_is_the_machine_made_so():
    for f10 in np.linspace(0.5, 4, 17):
        assert vi.PaperMachine.from_groups(f10=1.5).replace(f10=f10) == vi.PaperMachine.from_groups(f10=f10)
    m = vi.PaperMachine.from_groups(f10=1.5)
    for i in range(100):
        m = m.replace(f10=1 + i / 100).replace(stop_gap=1.0 + i)
    assert len(repr(m)) < 500, "the text does not grow with the history"


def test_it_is_immutable():
    m = vi.PaperMachine()
    for change in [lambda: setattr(m, "box_m", 2.0), lambda: setattr(m, "other", 1), lambda: delattr(m, "box_m")]:
        with pytest.raises(AttributeError, match="immutable"):
            change()
    assert {m: 1}[vi.PaperMachine()] == 1 and m != 1 and m != vi.PaperMachine(box_m=2.0)


def test_a_box_without_a_spring_has_no_groups():
    free = vi.PaperMachine(box_k=0.0)
    assert eval(repr(free), {"PaperMachine": vi.PaperMachine}) == pickle.loads(pickle.dumps(free)) == free
    with pytest.raises(AttributeError, match="box_k = 0.0, and the dimensionless form requires box_k > 0"):
        free.f10
    for refused in [lambda: free.simulate(9), lambda: free.bifurcation(box_c=[0.1, 0.2]), lambda: free.replace(kappa=0.5)]:
        with pytest.raises(ValueError, match="the dimensionless form requires box_k > 0"):
            refused()
    assert len(free.simulate(start={"x2": 0.5, "block_v": 1.0}, periods=200).impacts) > 0
    assert free.replace(box_k=1.0) == vi.PaperMachine(box_k=1.0) and free.steady().multiple_scales is None


DAMPER = dict(
    box_m=12.0, box_k=48e3, box_c=30.0, block_m=0.6, secondary_m=1.2, secondary_k=4800.0, secondary_c=5.0, coupling_k=0.0,
    stop_gap=0.05, stop_restitution=0.6, drive_amplitude=75.0, drive_frequency=62.8,
)  # fmt: skip


def test_half_a_machine_warns_with_what_it_took():
    with pytest.warns(vi.MixedParametersWarning, match=r"drive_amplitude = 0.15, .*stop_gap|stop_gap = 1.*drive_amplitude = 0.15"):
        vi.PaperMachine(box_m=12.0, box_k=48e3)
    with pytest.warns(vi.MixedParametersWarning) as told:
        vi.PaperMachine(**{name: value for name, value in DAMPER.items() if name != "stop_gap"})
    assert told[0].filename == __file__ and "stop_gap = 1" in str(told[0].message) and "box_m" not in str(told[0].message).split(":")[0]
    with pytest.warns(vi.MixedParametersWarning, match="drive_amplitude = 0.15"):
        vi.PaperMachine(box_k=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        whole = vi.PaperMachine(**DAMPER)
        for silent in [
            lambda: vi.PaperMachine(), lambda: vi.PaperMachine.from_groups(f10=1.5), lambda: whole.replace(stop_gap=0.04),
            lambda: vi.PaperMachine().replace(stop_gap=0.5), lambda: vi.PaperMachine(load_block=-0.01), lambda: pickle.loads(pickle.dumps(whole)),
        ]:  # fmt: skip
            silent()


def test_constant_loads_are_parameters():
    upright = vi.PaperMachine(**DAMPER, load_block=-9.81 * 0.6)
    assert upright != vi.PaperMachine(**DAMPER) and upright.load_block == -9.81 * 0.6 and "load_block=-5.88" in repr(upright)
    # A constant load as a parameter and the same load from samples agree up to rounding.
    start = {"block_s": -0.02, "block_v": 0.3}
    sampled = vi.Load("block", [0.0, 10.0], [-9.81 * 0.6] * 2)
    own, other = upright.simulate(start=start, periods=10), vi.PaperMachine(**DAMPER).simulate(start=start, periods=10, loads=[sampled])
    assert len(own.impacts) == len(other.impacts) > 2
    np.testing.assert_allclose(own.s, other.s, rtol=0, atol=1e-12)
    # The mirror image of a motion is a motion under the opposite load, half a drive period later.
    image = upright.replace(load_block=9.81 * 0.6, drive_phase=np.pi).simulate(start={"block_s": 0.02, "block_v": -0.3}, periods=10)
    np.testing.assert_allclose(own.s, -image.s, rtol=0, atol=1e-10)
    # Every study supports the load, also as its parameter; closed forms refuse it.
    diagram = upright.bifurcation(load_block=np.linspace(-6.0, 6.0, 3), periods=(5, 4), start=start)
    assert list(diagram.up.value) == [-6.0, 0.0, 6.0]
    basins = upright.basins({"block.s": (-0.02, "20 mm", 3)}, v2=(-1, 1, 3), settle=10)
    assert basins.names == ("x2", "v2") and not basins.mirror.any()
    assert vi.simulate_many([upright], periods=5).s.shape == (1, 3)
    assert upright.spectrum(periods=5, settle=5).impacts >= 0
    steady = upright.steady()
    assert steady.exact_orbit is None and steady.multiple_scales is None
    assert all("load_block = -5.88" in steady.reasons[name] for name in ("exact_orbit", "multiple_scales", "strong_coupling"))


def test_invariant_many_measures_have_the_bits_of_one_by_one():
    names = ["amplitude.x1", "rms.x2", "impacts", "power.input", "class", "exponent"]
    machines = [vi.PaperMachine.from_groups(f10=f10) for f10 in np.linspace(1.0, 4.0, 7)]
    machines += [machines[0].replace(load_block=-0.004)]
    many = vi.measure_many(machines, names, periods=8, settle=50)
    assert [{name: row[name] for name in names} for row in many] == [machine.measure(names, periods=8, settle=50) for machine in machines]
    starts = [{"x2": 0.5}, {"block_v": 0.7}]
    table = vi.measure_many(machines[3], names[:3], starts=starts, periods=8, settle=5)
    assert [{name: row[name] for name in names[:3]} for row in table] == [
        machines[3].measure(names[:3], start=start, periods=8, settle=5) for start in starts
    ]
    with pytest.raises(ValueError, match="motion 1: .*block"):
        vi.measure_many(machines[:2], names[:1], starts=[{"x2": 0.0}, {"x2": 1.5}], periods=2, settle=2)
    with pytest.raises(TypeError, match="sequence of names"):
        vi.measure_many(machines, "impacts")


def test_second_method_a_sweep_is_the_measures_of_all_combinations():
    found = vi.PaperMachine().sweep(["amplitude.x1", "class"], start={"v2": 1.0}, f10=[1.0, 1.5], kappa=[0.6, 0.7, 0.8], settle=20, periods=4)
    assert [(row["f10"], row["kappa"]) for row in found] == [(f10, kappa) for f10 in (1.0, 1.5) for kappa in (0.6, 0.7, 0.8)]
    for row in found:
        machine = vi.PaperMachine().replace(f10=row["f10"], kappa=row["kappa"])
        assert machine.measure(["amplitude.x1"], start={"v2": 1.0}, settle=20, periods=4)["amplitude.x1"] == row["amplitude.x1"]
    with pytest.raises(TypeError, match="f10: expected a list or an array"):
        vi.PaperMachine().sweep(["class"], f10=1.0)


def test_a_symbol_that_another_name_has_in_small_letters_warns_with_both_units():
    f10 = np.linspace(1.0, 1.5, 2)
    for given in [lambda: vi.PaperMachine().bifurcation(F10=f10, periods=(2, 2)), lambda: vi.PaperMachine().replace(F10=0.2)]:
        with pytest.warns(vi.SimilarNameWarning, match="`F10` is drive_amplitude, in N; `f10` is another") as told:
            given()
        assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vi.PaperMachine().bifurcation(f10=f10, periods=(2, 2))
        vi.PaperMachine().bifurcation(drive_amplitude=f10, periods=(2, 2))
        assert vi.PaperMachine().replace(L=0.5).stop_gap == 0.5


def test_a_motion_that_is_refused_is_told_in_its_row():
    machine, names = vi.PaperMachine(), ["impacts", "class"]
    starts = [{"x2": 0.0}, {"x2": 1.5}, {"x2": 0.5}]
    rows = list(vi.measure_many(machine, names, starts=starts, periods=2, settle=2, errors="row"))
    for row, start in zip(rows[::2], starts[::2]):
        assert {name: row[name] for name in names} == machine.measure(names, start=start, periods=2, settle=2) and row["error"] is None
    assert rows[1]["impacts"] is rows[1]["class"] is None and "block" in rows[1]["error"]
    with pytest.raises(ValueError, match="expected one of 'raise', 'row'"):
        vi.measure_many(machine, names, starts=starts, errors="rows")
    with pytest.raises(ValueError, match="impcts"):
        vi.measure_many(machine, ["impcts"], starts=starts, errors="row")


def test_loads_are_values():
    load = vi.Load("box", [0.0, 1.0, 2.0], [0.0, 0.5, 0.0])
    for other in [pickle.loads(pickle.dumps(load)), eval(repr(load), {"Load": vi.Load}), copy.deepcopy(load)]:
        assert other == load and hash(other) == hash(load)
    assert load != vi.Load("box", [0.0, 1.0, 2.0], [0.0, 0.5, 0.0], "cubic")
    np.testing.assert_array_equal(load([-1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0]), [0, 0, 0.25, 0.5, 0.25, 0, 0])
    with pytest.raises(ValueError, match="read-only"):
        load.t[0] = 1.0


def test_results_can_be_pickled():
    m = vi.PaperMachine()
    for result in [m.simulate(periods=2), m.poincare(periods=2), m.steady(), m.orbit("UL"), m.spectrum(periods=5, settle=5)]:
        again = pickle.loads(pickle.dumps(result))
        assert repr(again) == repr(result)
    theta = np.linspace(0, 6, 7)
    orbit = m.orbit("UL")
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(orbit)).motion(theta), orbit.motion(theta))
