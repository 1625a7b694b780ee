"""Results display themselves: short texts, small pictures, tables of other packages."""

import pickle
import sys
import xml.etree.ElementTree

import matplotlib
import numpy as np
import pytest
import vibro_impact as vi
from conftest import ROOT

matplotlib.use("agg")
import matplotlib.pyplot as plt
from vibro_impact import plot

DAMPER = vi.Machine(ROOT / "examples" / "assembly" / "damper_with_buffer.toml")
PAPERS = vi.PaperMachine.from_groups(f10=1.5)
STEEL = "stop.steel.gap"
#: Largest size of a result's page and of its text, bytes.
PAGE, TEXT = 50_000, 1500


def results():
    plane = {"box.s": (-1e-3, 1e-3, 130), "box.v": (-1e-2, 1e-2, 3)}
    return [
        PAPERS.simulate(periods=300), DAMPER.simulate(9.0, samples=90_000), PAPERS.poincare(periods=3000), DAMPER.poincare(periods=9),
        DAMPER.poincare("steel", periods=9), PAPERS.poincare("upper", periods=9),
        PAPERS.bifurcation(f10=np.linspace(1, 4, 90), periods=(20, 60)), DAMPER.bifurcation("box.s", {STEEL: np.linspace(4e-3, 5e-3, 4)}, periods=(9, 9)),
        PAPERS.basins({"v2": (-2, 2, 140), "x1": (-1, 1, 3)}, settle=30), DAMPER.basins(plane, settle=9),
        PAPERS.response("f10", 1.4, 1.6, seeds=3, settle=300)[0], DAMPER.orbit().follow(STEEL, "3.9 mm", "4.1 mm"),
        PAPERS.spectrum(periods=90, settle=9), DAMPER.spectrum(periods=9, settle=9),
        DAMPER.sweep(["amplitude.box.s"], {STEEL: [4e-3, 5e-3], "body.box.mass": [12.0, 13.0, 14.0]}, settle=3, periods=2),
        vi.measure_many(PAPERS, {"f10": np.linspace(1, 2, 9)}, ["amplitude.x1", "class"], settle=3, periods=2),
    ]  # fmt: skip


def test_results_show_a_small_picture_and_their_numbers():
    for result in results():
        html, svg, name = result._repr_html_(), result._repr_svg_(), type(result).__name__
        xml.etree.ElementTree.fromstring(svg)
        assert svg in html and name in html and "nan" not in svg, name
        assert 600 < len(svg) <= len(html) < PAGE, (name, len(html))
        assert len(repr(result)) < TEXT, repr(result)
    for result in (PAPERS.steady(), PAPERS.orbit("UL"), DAMPER.transition(0.1)):
        assert "<table>" in result._repr_html_() and result._repr_svg_() is None
    for machine in (PAPERS, DAMPER):
        xml.etree.ElementTree.fromstring(machine._repr_svg_())
        assert len(repr(machine)) < 200
    assert vi.PaperMachine().replace(drive_frequency=0.0)._repr_svg_() is None


def test_a_picture_has_the_extremes_of_the_numbers():
    run = DAMPER.simulate(9.0, samples=90_000)
    low, high = (f"{extreme(run[name] for name in ('box.s', 'block.s', 'pump.s')):.4g}" for extreme in (_least, _largest))
    assert f"displacements, SI: {low} to {high}" in run._repr_svg_()


def _least(columns):
    return min(column.min() for column in columns)


def _largest(columns):
    return max(column.max() for column in columns)


def test_tables_of_other_packages_have_the_numbers():
    for machine in (PAPERS, DAMPER):
        run = machine.simulate(periods=2, per_period=4)
        frame = run.to_pandas()
        assert (frame["box.s"].to_numpy() == run["box.s"]).all() and (frame.index == run.t).all()
    table = DAMPER.sweep(["amplitude.box.s"], {STEEL: [4e-3, 5e-3]}, settle=3, periods=2)
    assert table.to_pandas()["amplitude.box.s"].tolist() == table["amplitude.box.s"].tolist()


def test_xarray_and_parquet_have_the_numbers(tmp_path):
    pytest.importorskip("xarray")
    parquet = pytest.importorskip("pyarrow.parquet")
    run = DAMPER.simulate(periods=2, per_period=4).to_xarray()
    assert run["box.s"].dims == ("time",) and run.time.attrs["units"] == "s"
    table = DAMPER.sweep(["amplitude.box.s", "class"], {STEEL: [4e-3, 5e-3], "body.box.mass": [12.0, -1.0, 14.0]}, settle=3, periods=2, errors="row")
    found = table.to_xarray()
    assert found["amplitude.box.s"].dims == (STEEL, "body.box.mass") and found[STEEL].values.tolist() == [4e-3, 5e-3]
    read = parquet.read_table(table.to_parquet(tmp_path / "table.parquet"))
    assert read.column("amplitude.box.s").to_pylist() == [row["amplitude.box.s"] for row in table] and None in read.column("class").to_pylist()
    assert read.schema.metadata[b"amplitude.box.s"] == b"m"


@pytest.mark.parametrize(("module", "method"), [("pandas", "to_pandas"), ("xarray", "to_xarray")])
def test_what_is_not_installed_is_named_with_its_command(module, method, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=f"{method} requires {module}, which is not installed: `pip install {module}`"):
        getattr(DAMPER.simulate(0.01), method)()


@pytest.mark.parametrize("machine", [PAPERS, DAMPER], ids=["PaperMachine", "Machine"])
def test_every_picture_takes_both_kinds_and_returns_its_axes(machine):
    name = "f10" if machine is PAPERS else STEEL
    value = machine.parameters[name]
    run = machine.simulate(periods=2)
    for draw, result in [
        (plot.history, run), (plot.portrait, run), (plot.forces, run), (plot.section, machine.poincare(periods=9)),
        (plot.bifurcation, machine.bifurcation("box.s", {name: np.linspace(value, 1.1 * value, 3)}, periods=(9, 9))),
        (plot.response, machine.response(name, 0.99 * value, 1.01 * value, seeds=2)), (plot.branch, machine.orbit().follow(name, 0.99 * value, 1.01 * value)),
        (plot.basins, machine.basins({"box.s": (-1e-3, 1e-3, 2), "box.v": (-1e-2, 1e-2, 2)}, settle=9)),
    ]:  # fmt: skip
        axes = plt.figure().gca()
        assert draw(result, axes) is axes and axes.has_data()
        with pytest.raises((TypeError, ValueError), match="expected"):
            draw(3)
        plt.close("all")


def test_forces_are_those_of_the_result():
    run = DAMPER.simulate(0.5)
    axes = plot.forces(run, plt.figure().gca())
    assert [line.get_label() for line in axes.lines] == ["steel.f", "buffer.f"] and (axes.lines[1].get_ydata() == run["buffer.f"]).all()
    own = PAPERS.simulate(periods=9)
    (stems,) = plot.forces(own, plt.figure().gca(), of="upper").collections
    tops = [segment[1][1] for segment in stems.get_segments()]
    assert tops == own.impacts["impulse"][own.impacts["stop"] > 0].tolist()
    with pytest.raises(ValueError, match="of = 'box.s': expected one of"):
        plot.forces(run, of="box.s")
    plt.close("all")


def test_tables_can_be_pickled():
    table = vi.measure_many(PAPERS, {"f10": [1.0, 2.0]}, ["amplitude.x1"], settle=3, periods=2)
    assert list(pickle.loads(pickle.dumps(table))) == list(table)
