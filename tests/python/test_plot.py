"""Pictures: the result's numbers, drawn into the given axes."""

import matplotlib
import numpy as np
import pytest
import vibro_impact as vi
from conftest import ROOT

matplotlib.use("agg")
import matplotlib.pyplot as plt
from vibro_impact import plot

OSCILLATOR = {
    "name": "Oscillator",
    "body": {"box": {"mass": 1.0}},
    "spring": {"mount": {"between": ["ground", "box"], "stiffness": 400.0, "damping": 2.0}},
    "stop": {"wall": {"between": ["ground", "box"], "gap": "1 cm", "restitution": 0.8}},
    "load": {"shaker": {"on": "box", "amplitude": "2 N", "frequency": "3 Hz"}},
}

M = vi.PaperMachine.from_groups(f10=1.5)


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def results():
    run = M.simulate(periods=5)
    diagram = M.bifurcation(f10=np.linspace(1, 3, 9), periods=(50, 20))
    return {
        plot.history: run,
        plot.portrait: run,
        plot.section: M.poincare(periods=50),
        plot.bifurcation: diagram,
        plot.basins: M.replace(f10=2.5).basins(v2=(-2, 2, 5), x1=(-1.2, 1.2, 5), settle=100),
        plot.branch: M.orbit("UL").follow("f10", 1.4, 1.6),
    }


def test_every_function_draws_into_the_axes_given_or_the_current_ones():
    for function, result in results().items():
        _, (other, axes) = plt.subplots(1, 2)
        assert function(result, axes) is axes
        assert axes.has_data() and not other.has_data() and axes.get_xlabel() and axes.get_ylabel()
        plt.sca(other)
        assert function(result) is other and other.has_data()


def test_lines_are_the_results_numbers_in_the_bodies_colours():
    run = M.simulate(periods=3)
    axes = plot.history(run, of=("x1", "w"))
    box, block, *stops = axes.lines
    np.testing.assert_array_equal(box.get_ydata(), run.s[:, 0])
    np.testing.assert_array_equal(block.get_ydata(), run.w)
    assert (box.get_color(), block.get_color()) == ("#004696", "#a52882")
    assert sorted(line.get_ydata()[0] for line in stops) == [-1.0, 1.0]


def test_lengths_of_a_small_gap_are_in_mm():
    damper = vi.PaperMachine(
        box_m=12.0, box_k=48e3, box_c=30.0, block_m=1.2, secondary_m=1.0, secondary_k=1e3, secondary_c=1.0, coupling_k=0.0,
        stop_gap=0.015, stop_restitution=0.6, drive_amplitude=75.0, drive_frequency=62.8, drive_phase=0.0,
    )  # fmt: skip
    run = damper.simulate(periods=3)
    axes = plot.history(run, of="w")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), 1e3 * run.w)
    assert axes.get_ylabel() == "$w$ (mm)" and sorted(line.get_ydata()[0] for line in axes.lines[1:]) == [-15.0, 15.0]
    axes = plot.portrait(run, plt.figure().gca(), of="w")
    assert (axes.get_xlabel(), np.nanmax(axes.lines[0].get_xdata())) == ("$w$ (mm)", 1e3 * run.w.max())


def test_many_periods_are_an_envelope():
    run = M.simulate(periods=100)
    axes = plot.history(run, of="x2")
    assert not axes.lines
    (area,) = axes.collections
    corners = area.get_paths()[0].vertices
    assert (corners[:, 1].min(), corners[:, 1].max()) == (run.s[:, 1].min(), run.s[:, 1].max())
    # Each window has four corners.
    assert 4 * 100 <= len(corners) < 4 * 110
    assert len(plot.history(M.simulate(periods=40), plt.figure().gca(), of="x2").lines) == 1


def test_portraits_are_interrupted_at_impacts():
    run = M.simulate(periods=3)
    (line,) = plot.portrait(run, of="x2").lines
    assert np.isnan(line.get_xdata()).sum() == len(run.impacts)
    (line,) = plot.portrait(run, plt.figure().gca(), of="x3").lines
    assert not np.isnan(line.get_xdata()).any()


def test_colours_are_those_of_vibro():
    palette = (ROOT / "crates/figures/src/canvas/palette.rs").read_text()
    for name, constant in {"x1": "BOX", "x2": "BLOCK", "x3": "SECONDARY", "w": "RELATIVE"}.items():
        parts = palette.split(f"pub const {constant}: Colour = Colour(")[1].split(")")[0].split(",")
        assert plot.COLOURS[name] == "#" + "".join(f"{int(part):02x}" for part in parts)


def test_other_displacements_are_refused():
    with pytest.raises(ValueError, match="of = 'x4': expected one of 'x1', 'x2', 'x3', 'w'"):
        plot.history(M.simulate(periods=1), of="x4")


DAMPER = ROOT / "examples" / "assembly" / "damper_with_buffer.toml"


def test_a_machine_of_ones_own_is_drawn_with_its_numbers_and_units():
    damper = vi.Machine(DAMPER)
    run = damper.simulate(0.3)
    axes = plot.history(run)
    for line, name in zip(axes.lines, ("box.s", "block.s", "pump.s")):
        np.testing.assert_array_equal(line.get_xydata().T, [run.t, run[name]])
        assert line.get_label() == name
    axes = plot.history(run, plt.figure().gca(), of="buffer.f")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), run["buffer.f"])
    assert axes.get_ylabel() == "buffer.f (N)"
    axes = plot.portrait(run, plt.figure().gca(), of="steel.e")
    x, y = axes.lines[0].get_data()
    np.testing.assert_array_equal(x[~np.isnan(x)], run["steel.e"])
    np.testing.assert_array_equal(y[~np.isnan(y)], run["steel.rate"])
    hits = run.events["t"][run.events["kind"] == "impact"]
    assert np.isnan(x).sum() == len(set(np.searchsorted(run.t, hits))) > 1
    diagram = damper.bifurcation("box.s", periods=(20, 10), **{"stop.steel.gap": np.linspace(3e-3, 5e-3, 3)})
    axes = plot.bifurcation(diagram, plt.figure().gca(), direction="both")
    for line, way in zip(axes.lines, (diagram.down, diagram.up)):
        np.testing.assert_array_equal(line.get_xydata().T, [way.value[way.at], way.maxima])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("stop.steel.gap (m)", "box.s, maxima (m)")


def test_orbits_basins_and_sections_of_a_machine_of_ones_own_are_drawn_with_their_numbers():
    machine = vi.Machine(OSCILLATOR)
    branch = machine.orbit().follow("load.shaker.frequency", "2.5 Hz", "5 Hz", of="amplitude.box.s")
    axes = plot.branch(branch)
    drawn = np.concatenate([line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 1])
    assert {tuple(point) for point in drawn} == set(zip(branch.value, branch.measure))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("load.shaker.frequency (Hz)", "amplitude.box.s (m)")
    assert "GR" in {text.get_text() for text in axes.texts}
    section = machine.poincare("wall", periods=20)
    axes = plot.section(section, plt.figure().gca())
    np.testing.assert_array_equal(axes.lines[0].get_xydata().T, [section.phase, section.speed])
    axes = plot.section(section, plt.figure().gca(), of="wall.e")
    np.testing.assert_array_equal(axes.lines[0].get_xydata().T, [section["wall.e"], section["wall.rate"]])
    basins = machine.replace({"load.shaker.frequency": 4.2}).basins(**{"box.s": (-0.01, 0.02, 3), "box.v": (-1, 1, 3)}, settle=100)
    axes = plot.basins(basins, plt.figure().gca())
    np.testing.assert_array_equal(axes.images[0].get_array(), basins.cells + 3)
    assert -1 in basins.cells and axes.get_xlabel() == "start of box.s (m)"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [f"{a.kind} {a.word}".strip() for a in basins.attractors]


def test_other_results_are_refused_with_the_kinds_that_are_drawn():
    run = vi.Machine(DAMPER).simulate(0.01)
    for function, kinds in {
        plot.history: "Run or PaperRun", plot.portrait: "Run or PaperRun", plot.section: "Section or PaperSection",
        plot.bifurcation: "Diagram or PaperDiagram", plot.basins: "Basins or PaperBasins",
        plot.branch: "Branch or PaperBranch",
    }.items():  # fmt: skip
        wrong = run if "Run" not in kinds else vi.PaperMachine()
        with pytest.raises(TypeError, match=f"is of type {type(wrong).__name__}: expected {kinds}$"):
            function(wrong)
    with pytest.raises(TypeError, match="axes is of type str: expected Axes"):
        plot.history(run, "box.s")
    with pytest.raises(ValueError, match="did you mean 'box.s'"):
        plot.portrait(run, of="box.v")
