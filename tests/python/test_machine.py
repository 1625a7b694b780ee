"""The machine as a value: names, text, equality, pickling, what changes with what."""

import copy
import pickle

import numpy as np
import pytest
import vibro_impact as vi

SEVERAL = [
    vi.Machine(),
    vi.Machine(box_m=12.0, box_k=48e3, stop_gap=0.0025, drive_frequency=63.1),
    vi.Machine.from_groups(f10=1.5, kappa=0.75),
    vi.Machine.from_groups(alpha23=0.5, epsilon=0.05),
    vi.Machine.from_groups(beta2=0.3, epsilon=0.07, mu13=1.0).replace(epsilon=0.1),
    vi.Machine(box_m=3.0, f10=0.3),
    vi.Machine.from_groups(f10=0.3, epsilon=0.2).replace(block_m=1 / 3).replace(kappa=0.1),
]


@pytest.mark.parametrize("machine", SEVERAL, ids=repr)
def test_text_pickle_and_copy_make_the_same_machine(machine):
    pasted = eval(repr(machine), {"Machine": vi.Machine})
    pickled = [pickle.loads(pickle.dumps(machine, protocol)) for protocol in range(2, 6)]
    for other in [pasted, *pickled, copy.copy(machine), copy.deepcopy(machine)]:
        assert other == machine and hash(other) == hash(machine) and repr(other) == repr(machine)
        assert {n: getattr(other, n) for n in vi.GROUP_NAMES} == {n: getattr(machine, n) for n in vi.GROUP_NAMES}
        # What follows when a parameter changes is part of the value as well.
        assert other.replace(epsilon=0.008) == machine.replace(epsilon=0.008)


def test_parameters_have_the_names_of_the_fmu_with_underscores():
    assert vi.SI_NAMES[0] == "box_m" and vi.SI_NAMES[-1] == "drive_phase" and len(vi.SI_NAMES) == 13
    assert {name for kind in vi.Machine.__mro__ for name in vars(kind).get("__annotations__", {})} >= set(vi.SI_NAMES + vi.GROUP_NAMES)
    assert vi.Machine(m1=2.0, L=0.5) == vi.Machine(box_m=2.0, stop_gap=0.5)
    assert vi.Machine.from_groups(**{"ε": 0.05}) == vi.Machine.from_groups(epsilon=0.05)
    assert vi.Machine().m1 == 1.0


def test_closed_form_of_the_groups():
    m = vi.Machine(box_m=2.0, box_k=8.0, stop_gap=0.01, f10=1.25)
    assert (m.box_m, m.box_k, m.stop_gap, m.f10) == (2.0, 8.0, 0.01, 1.25)
    assert m.drive_amplitude == pytest.approx(1.25 * 8.0 * 0.01 * m.epsilon, rel=1e-15)
    assert m.period == 2 * np.pi / m.drive_frequency


def test_of_tied_groups_the_one_set_last_is_held():
    weak = vi.Machine.from_groups(alpha23=0.5, epsilon=0.05)
    assert weak.beta2 == 0.05 * 0.5 and weak.mu13 == 20.0
    strong = vi.Machine.from_groups(beta2=0.3, mu13=1.0).replace(epsilon=0.05)
    assert (strong.beta2, strong.mu13) == (0.3, 1.0)
    # A later word counts, as one after the other in one call.
    assert vi.Machine.from_groups(beta2=0.3).replace(alpha23=0.5).replace(epsilon=0.05) == weak.replace(alpha23=0.5)


def test_one_change_is_the_machine_made_so():
    for f10 in np.linspace(0.5, 4, 17):
        assert vi.Machine.from_groups(f10=1.5).replace(f10=f10) == vi.Machine.from_groups(f10=f10)
    m = vi.Machine.from_groups(f10=1.5)
    for i in range(100):
        m = m.replace(f10=1 + i / 100).replace(stop_gap=1.0 + i)
    assert len(repr(m)) < 500, "the text does not grow with the history"


def test_it_is_immutable():
    m = vi.Machine()
    for change in [lambda: setattr(m, "box_m", 2.0), lambda: setattr(m, "other", 1), lambda: delattr(m, "box_m")]:
        with pytest.raises(AttributeError, match="immutable"):
            change()
    assert {m: 1}[vi.Machine()] == 1 and m != 1 and m != vi.Machine(box_m=2.0)


def test_a_box_without_a_spring_has_no_groups():
    free = vi.Machine(box_k=0.0)
    assert eval(repr(free), {"Machine": vi.Machine}) == pickle.loads(pickle.dumps(free)) == free
    with pytest.raises(AttributeError, match="box_k = 0.0, and the dimensionless form needs box_k > 0"):
        free.f10
    for refused in [free.simulate, lambda: vi.bifurcation(free, box_c=[0.1, 0.2]), lambda: free.replace(kappa=0.5)]:
        with pytest.raises(ValueError, match="the dimensionless form needs box_k > 0"):
            refused()
    assert len(free.simulate({"x2": 0.5, "block_v": 1.0}).impacts) > 0
    assert free.replace(box_k=1.0) == vi.Machine(box_k=1.0) and free.steady().multiple_scales is None


def test_loads_are_values():
    load = vi.Load("box", [0.0, 1.0, 2.0], [0.0, 0.5, 0.0])
    for other in [pickle.loads(pickle.dumps(load)), eval(repr(load), {"Load": vi.Load}), copy.deepcopy(load)]:
        assert other == load and hash(other) == hash(load)
    assert load != vi.Load("box", [0.0, 1.0, 2.0], [0.0, 0.5, 0.0], "cubic")
    np.testing.assert_array_equal(load([-1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0]), [0, 0, 0.25, 0.5, 0.25, 0, 0])
    with pytest.raises(ValueError, match="read-only"):
        load.t[0] = 1.0


def test_results_can_be_pickled():
    m = vi.Machine()
    for result in [m.simulate(periods=2), m.poincare(periods=2), m.steady(), m.orbit("UL"), m.lyapunov(periods=5, settle=5)]:
        again = pickle.loads(pickle.dumps(result))
        assert repr(again) == repr(result)
    theta = np.linspace(0, 6, 7)
    orbit = m.orbit("UL")
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(orbit)).motion(theta), orbit.motion(theta))
