"""Both classes of machine use the same words; members of only one class are in the table of docs/python.md."""

import inspect
import pickle
import re

import numpy as np
import pytest
import vibro_impact as vi
from conftest import ROOT
from matplotlib.figure import Figure

DAMPER = ROOT / "examples" / "assembly" / "damper_with_buffer.toml"

#: Rounding difference of a motion of 5 periods between two engines, relative to the gap of 1 m.
ROUNDING = 1e-11


def gaps():
    """Returns the names in the first cells of the table of gaps of docs/python.md."""
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    table = re.search(r"\| only in one kind \|.*?\n\|[-| ]+\|\n((?:\|.*\n)+)", page)
    assert table, "docs/python.md has no table of what only one kind has"
    rows = table[1].splitlines()
    assert len(rows) <= 5
    assert all(len(row.split("|")[3].strip()) > 10 for row in rows), "each gap has its reason"
    return {name.rstrip("=") for row in rows for name in re.findall(r"`([\w.]+=?)", row.split("|")[1])}


def public(kind):
    return {name for name in dir(kind) if not name.startswith("_") and name not in vi.PARAMETERS}


def arguments(method):
    """Names and kinds of the arguments that callers give by name."""
    return {name: p.kind for name, p in inspect.signature(method).parameters.items()}


def test_both_have_the_same_methods_but_for_the_table():
    only = public(vi.PaperMachine) ^ public(vi.Machine)
    assert only <= gaps(), "missing in the table"
    assert public(vi.AnyMachine) == public(vi.PaperMachine) & public(vi.Machine)


@pytest.mark.parametrize("name", sorted(public(vi.AnyMachine)))
def test_methods_have_the_same_arguments_but_for_the_table(name):
    of = [getattr(kind, name) for kind in (vi.AnyMachine, vi.PaperMachine, vi.Machine)]
    if isinstance(of[0], property):
        assert all(isinstance(one, property) for one in of)
        return
    base, machine, described = map(arguments, of)
    only = set(machine) ^ set(described)
    assert only <= gaps(), "missing in the table"
    # Shared arguments have the same kind and the same order.
    shared = [argument for argument in machine if argument in described]
    assert shared == [argument for argument in described if argument in machine] == list(base)
    assert all(machine[argument] == described[argument] == base[argument] for argument in shared)


def test_the_table_lists_nothing_that_both_have():
    both = public(vi.AnyMachine) | {a for name in public(vi.AnyMachine) if callable(getattr(vi.AnyMachine, name)) for a in arguments(getattr(vi.AnyMachine, name))}
    assert not (gaps() - {"section", "start", "branches"}) & both


def test_second_method_the_paper_s_machine_moves_as_the_described_one():
    machine = vi.PaperMachine.from_groups(f10=1.5).replace({"load.block": -0.004, "drive.phase": "30 deg"})
    own, other = machine.simulate(periods=5, per_period=8), machine.described().simulate(periods=5, per_period=8)
    for name in machine.columns:
        np.testing.assert_allclose(own[name], other[name], rtol=0, atol=ROUNDING)
    assert own.events["kind"].tolist() == other.events["kind"].tolist() and len(own.events) > 5
    assert own.events["element"].tolist() == other.events["element"].tolist()
    np.testing.assert_allclose(own.events["value"], other.events["value"], rtol=0, atol=1e-9)
    assert machine.period == machine.described().period and "stop.upper" in machine.toml and machine.sketch().svg.startswith("<svg")


@pytest.mark.parametrize("machine", [vi.PaperMachine.from_groups(f10=1.5), vi.Machine(DAMPER)], ids=["PaperMachine", "Machine"])
def test_a_study_is_written_in_one_way(machine):
    gap = "stop.gap" if isinstance(machine, vi.PaperMachine) else "stop.steel.gap"
    value = machine.replace({gap: "5 mm"}).parameters[gap if gap in machine.parameters else "stop_gap"]
    assert value == 0.005 and machine.replace({gap: 5e-3}) == machine.replace({gap: "5 mm"})
    run = machine.simulate(periods=3, per_period=10)
    assert run.t.shape == (31,) and run["box.s"].shape == (31,) and run.t[-1] == pytest.approx(3 * machine.period)
    assert set(machine.columns) <= set(run) and machine.start(run.end) == run.end and run.end.time == run.t[-1]
    assert machine.simulate(2.0 + run.end.time, samples=4, start=run.end).t.shape == (5,)
    # Studies, too, continue a motion from the end of another; both settle to a millionth.
    name = next(iter(machine.measures))
    whole, later = machine.measure([name]), machine.measure([name], start=run.end)
    assert whole[name] == pytest.approx(later[name], rel=1e-6)
    assert machine.poincare(periods=3, settle=5, start=run.end).t[0] > run.end.time
    assert machine.spectrum(periods=9, settle=2).exponents.ndim == 1
    around = machine.parameters["stop_gap" if gap == "stop.gap" else gap]
    diagram = machine.bifurcation("block.s", {gap: np.linspace(around, 1.1 * around, 3)}, periods=(5, 3))
    assert diagram.up.value.shape == (3,)
    basins = machine.basins({"box.s": (-1e-4, "0.1 mm", 2), "box.v": (-1e-3, 1e-3, 2)}, settle=20)
    assert basins.cells.shape == (2, 2)
    assert machine.sweep([name], {gap: [around, 1.1 * around]}, settle=3, periods=2)[name].shape == (2,)
    assert machine.sketch().svg == machine._repr_svg_() and machine.units[gap if gap in machine.units else "stop_gap"] == "m"


def test_response_of_the_papers_machine_is_the_branches_of_settled_orbits():
    machine = vi.PaperMachine.from_groups(f10=1.5)
    (branch,) = machine.response("f10", 1.4, 1.6, seeds=3, settle=300)
    orbit = machine.orbit(settle=300)
    at = np.interp(1.5, *zip(*sorted(zip(branch.value, (maxima[0] for maxima in branch.maxima)))))
    # The maximum is interpolated between points of the branch.
    assert at == pytest.approx(orbit.maxima()[0], rel=1e-3)


def test_wrong_types_name_those_that_are_accepted():
    for call, words in [
        (lambda: vi.fit(3, {}, free=[]), "machine is of type int: expected Machine or PaperMachine"),
        (lambda: vi.measure_many(3, ["class"]), r"machines\[0\] is of type int: expected Machine or PaperMachine"),
        (lambda: vi.PaperMachine().basins([1]), "ranges is of type list: expected a dictionary"),
    ]:
        with pytest.raises(TypeError, match=words):
            call()


@pytest.mark.parametrize("machine", [vi.PaperMachine.from_groups(f10=1.5), vi.Machine(DAMPER)], ids=["PaperMachine", "Machine"])
def test_words_mean_the_same_of_both(machine):
    axes = Figure().add_subplot()
    assert machine.measure(["amplitude.box.s"])["amplitude.box.s"] > 0.0
    table = machine.sweep(["amplitude.box.s"], {"stop.gap" if isinstance(machine, vi.PaperMachine) else "stop.steel.gap": ["20 mm"]}, settle=9, periods=9)
    assert table.units["amplitude.box.s"] == "m" and table["amplitude.box.s"].shape == (1,)
    run = machine.simulate("20 ms", samples=8)
    assert run.t[-1] == 0.02
    vi.plot.history(run, axes, of=["box.s", "block.s"])
    vi.plot.portrait(run, axes, of="box.s")
    vi.plot.section(machine.poincare(periods=3, settle=3), axes, of="box.s")
    orbit = machine.orbit()
    assert orbit.period == pytest.approx(orbit.periods * machine.period)
    with pytest.raises(ValueError, match="period = 'banana'"):
        machine.orbit(period="banana")
    # Without a word, the orbit has the requested period, or the call raises.
    assert machine.orbit(period=f"{orbit.periods}T").periods == orbit.periods
    with pytest.raises(ValueError, match="period|no orbit"):
        machine.orbit(period="2T", tries=1)
    again = pickle.loads(pickle.dumps(orbit))
    assert repr(again) == repr(orbit) and (np.asarray(again.multipliers) == orbit.multipliers).all()
    assert pickle.loads(pickle.dumps(machine.sketch())).svg == machine.sketch().svg


def test_invariant_an_orbit_from_another_process_is_solved_for_again():
    orbit = vi.Machine(DAMPER).orbit()
    again = pickle.loads(pickle.dumps(orbit))
    assert again.measure("amplitude.box.s") == pytest.approx(orbit.measure("amplitude.box.s"), rel=ROUNDING)
    assert again.follow("load.shaker.frequency", 9.5, 10.5).word == orbit.word


def test_second_method_periods_of_a_branch_are_those_of_the_drive():
    machine = vi.PaperMachine.from_groups(f10=1.5)
    frequency = machine.drive_frequency
    branch = machine.orbit("UL").follow("drive_frequency", 0.99 * frequency, 1.01 * frequency)
    np.testing.assert_allclose(branch.period, branch.periods * 2 * np.pi / branch.value, rtol=ROUNDING)
    steady = machine.orbit("UL").follow("f10", 1.4, 1.6)
    assert (steady.period == machine.period).all() and steady.period.shape == steady.value.shape


def test_names_of_version_0_3_are_those_of_described_machines_and_say_the_new_ones():
    run = vi.Machine(DAMPER).simulate(0.1)
    olds = {"Assembly": run.machine, "AssemblyRun": run, "AssemblyOrbit": vi.Machine(DAMPER).orbit()}
    for old, made in olds.items():
        new = type(made).__name__
        with pytest.warns(DeprecationWarning, match=rf"vi\.{old} is now vi\.{new}; the old name works until 0\.5"):
            assert isinstance(made, getattr(vi, old))
    for old, new in vi._OLD_NAMES.items():
        with pytest.warns(DeprecationWarning):
            assert getattr(vi, old) is getattr(vi, new) and new in vi.__all__
    machine = vi.PaperMachine.from_groups(f10=1.5)
    with pytest.warns(DeprecationWarning, match=r"assembly\(\) is now described\(\)"):
        assert machine.assembly() == machine.described()


def test_the_papers_arguments_of_machine_name_the_class_that_takes_them():
    for call, words in [
        (lambda: vi.Machine(gap="4 mm"), r"write vi\.PaperMachine\(gap='4 mm'\)"),
        (lambda: vi.Machine(), r"write vi\.PaperMachine\(\)"),
        (lambda: vi.Machine(DAMPER, kappa=0.5), r"write vi\.PaperMachine\(kappa=0\.5\)"),
        (lambda: vi.Machine("ball.toml", 3), r"vi\.Machine\('ball\.toml', 3\): expected one argument"),
        (lambda: vi.PaperMachine("ball.toml"), r"vi\.PaperMachine\('ball\.toml'\): .*write vi\.Machine\('ball\.toml'\)"),
        (lambda: vi.PaperMachine.from_groups("a"), r"from_groups\('a'\): expected groups as keywords"),
    ]:
        with pytest.raises(TypeError, match=words):
            call()
    with pytest.raises(AttributeError, match=r"write vi\.PaperMachine\.from_groups\(\.\.\.\)"):
        vi.Machine.from_groups(f10=1.5)
    with pytest.raises(AttributeError, match="has no attribute 'from_group'"):
        vi.Machine.from_group()
