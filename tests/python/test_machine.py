"""Described machines: bit-identical to the library and to the command line; errors."""

import csv
import io
import pickle
import re
from pathlib import Path

import fmpy
import numpy as np
import pytest

import vibro_impact as vi

EXAMPLES = Path(__file__).parents[2] / "examples" / "assembly"
#: Rounding of a sum of some hundred terms, relative to 1.
ROUNDING = 1e-12
#: Relative error of a settled motion.
SETTLED = 1e-6


def damper():
    return vi.Machine(EXAMPLES / "damper_with_buffer.toml")


OSCILLATOR = {
    "name": "Oscillator",
    "body": {"mass": {"mass": "2 kg", "start": {"s": 0.1}}},
    "spring": {"mount": {"between": ["ground", "mass"], "stiffness": "800 N/m"}},
    "load": {"force": {"on": "mass", "amplitude": 0.0, "frequency": "3.125 Hz"}},
}


def test_closed_form_derivatives_of_a_ball_and_of_what_has_none():
    text = {
        "name": "Ball",
        "gravity": 10.0,
        "body": {"ball": {"mass": 1.0, "gravity": 1.0}, "sled": {"mass": 1.0}},
        "stop": {"floor": {"between": ["ground", "ball"], "gap": 5.0, "restitution": 0.5}},
        "friction": {"f": {"between": ["ground", "sled"], "force": 0.0}},
    }
    machine = vi.Machine(text)
    run = machine.simulate(1.5, samples=3, derivatives=["stop.floor.gap", "friction.f.force"])
    # The ball falls h = 5 in sqrt(2 h/g) = 1 s, hits the floor with u = 10 m/s and leaves with u/2.
    by_gap = run.derivative("ball.s", "stop.floor.gap")
    assert not by_gap.mask.any() and np.abs(by_gap - [0.0, 0.0, 0.0, 0.75]).max() < ROUNDING
    assert np.abs(run.event_derivative("stop.floor.gap") - [0.1]).max() < ROUNDING
    assert run.derivative("ball.s", "friction.f.force").mask.all()
    assert list(run.lost) == ["friction.f.force"] and "t = 0 s" in run.lost["friction.f.force"]
    alone = machine.simulate(1.5, samples=3)
    assert (alone.values == run.values).all() and (alone.energy == run.energy).all()
    again = pickle.loads(pickle.dumps(run))
    assert (again.derivative("ball.s", "stop.floor.gap") == by_gap).all()
    with pytest.raises(ValueError, match="stop.floor.gap"):
        machine.simulate(1.5, derivatives=["stop.flor.gap"])
    with pytest.raises(ValueError, match="twice"):
        machine.simulate(1.5, derivatives=["gravity", "gravity"])
    with pytest.raises(TypeError, match="expected a list"):
        machine.simulate(1.5, derivatives="gravity")
    for output in ("floor.impacts", "class"):
        with pytest.raises(KeyError, match=f"{output}: has no derivative; expected one of ball.s"):
            run.derivative(output, "stop.floor.gap")
    with pytest.raises(ValueError, match="ball.s: is not a parameter; its start value is `start.ball.s`"):
        machine.simulate(1.5, derivatives=["ball.s"])
    with pytest.raises(KeyError, match="stop.floor.gap"):
        run.derivative("ball.s", "gravity")
    with pytest.raises(KeyError, match="no derivatives were requested"):
        alone.derivative("ball.s", "gravity")


def test_invariant_a_motion_goes_on_from_the_end_of_another(tmp_path):
    machine = damper()
    whole = machine.simulate(1.0, samples=20)
    first = machine.simulate(0.5, samples=1)
    path = first.end.save(tmp_path / "end.toml")
    assert machine.start(path) == first.end == pickle.loads(pickle.dumps(first.end)) and len({first.end, machine.start(first.end)}) == 1
    assert first.end.time == 0.5 and first.end["box.s"] == first["box.s"][-1] and "pump.v" in first.end
    for start in (first.end, path, str(path), dict(first.end)):
        second = machine.simulate(1.0, samples=10, start=start)
        assert second.t[0] == 0.5 and np.abs(second.values - whole.values[10:]).max() < 1e-6
    # Numbers that are not given have the machine's own values.
    assert np.array_equal(machine.simulate("500 ms", samples=1).values, first.values)
    moved = machine.simulate(times=[0.2], start={"time": 0.2, "box.v": "5 cm/s"})
    assert moved["box.v"][0] == 0.05 and moved["box.s"][0] == machine.simulate(times=[0.0])["box.s"][0]
    with pytest.raises(KeyError, match="expected one of time, "):
        first.end["boks.s"]


def test_closed_form_studies_begin_at_their_starts():
    # Undamped, so that each motion keeps its amplitude: 0.6 m/s over 20 rad/s is 3 cm.
    free = vi.Machine({**OSCILLATOR, "load": {}})
    starts = [{"mass.s": 0.01}, {"mass.s": 0.0, "mass.v": 0.6, "time": 3.0}]
    of = {"section": 0.1, "settle": 20}
    amplitudes = [0.01, 0.03]
    for start, amplitude in zip(starts, amplitudes):
        assert abs(free.measure(["amplitude.mass.s"], start=start, **of)["amplitude.mass.s"] - amplitude) < ROUNDING
        (row,) = free.sweep(["amplitude.mass.s"], start=start, parameters={"body.mass.mass": [2.0]}, **of)
        assert abs(row["amplitude.mass.s"] - amplitude) < ROUNDING
        diagram = free.bifurcation("mass.s", start=start, anew=True, section=0.1, periods=(20, 20), **{"body.mass.mass": [2.0, 2.0001]})
        assert abs(diagram.up.maxima[diagram.up.at == 0].max() - amplitude) < SETTLED
    rows = vi.measure_many(free, ["amplitude.mass.s"], starts=starts, **of)
    assert np.abs(np.array([row["amplitude.mass.s"] for row in rows]) - amplitudes).max() < ROUNDING
    ends = vi.simulate_many(free, starts=starts, until=3.5)
    assert abs(ends["mass.s"][1] - 0.03 * np.sin(20.0 * 0.5)) < ROUNDING


def test_second_method_many_trajectories_are_single_ones_with_their_derivatives():
    machines = [damper().replace({"stop.steel.gap": gap}) for gap in (4e-3, 5e-3)]
    start, names = machines[0].simulate(0.3, samples=1).end, ["stop.steel.gap"]
    times = np.linspace(0.3, 0.6, 7)
    runs = vi.simulate_many(machines, starts=start, times=times, derivatives=names)
    for machine, run in zip(machines, runs):
        alone = machine.simulate(times=times, start=start, derivatives=names)
        assert (run.values == alone.values).all() and (run.events == alone.events).all() and run.end == alone.end
        assert run.machine == machine and (run.energy == alone.energy).all()
        found, expected = (r.derivative("box.s", "stop.steel.gap") for r in (run, alone))
        assert (found == expected).all() and np.abs(found[-1]) > 0.0
    assert len(vi.simulate_many(machines[0], starts=[None, start], times=[0.7])) == 2


def test_closed_form_transition_of_an_oscillator_and_products_of_parts():
    oscillator = vi.Machine(OSCILLATOR)
    found = oscillator.transition(0.4, start={"time": 0.1, "mass.s": 0.2})
    angle = 20.0 * 0.3
    expected = [[np.cos(angle), np.sin(angle) / 20.0], [-20.0 * np.sin(angle), np.cos(angle)]]
    assert found.states == ["mass.s", "mass.v"] and found.lost == {} and not found.matrix.mask.any()
    assert np.abs(found.matrix - expected).max() < 20 * ROUNDING
    assert dict(found.start) == {"time": 0.1, "mass.s": 0.2, "mass.v": 0.0} and found.end.time == 0.4
    run = oscillator.simulate(times=[0.4], start={"time": 0.1, "mass.s": 0.2}, derivatives=["start.mass.v", "start.time"])
    assert abs(run.derivative("mass.s", "start.mass.v")[0] - expected[0][1]) < ROUNDING
    assert abs(run.derivative("mass.s", "start.time")[0] - 0.2 * 20.0 * np.sin(angle)) < 100 * ROUNDING
    # Through impacts of the damper.
    machine = damper()
    whole = machine.transition(0.5, start=machine.simulate(0.2, samples=1).end)
    first = machine.transition(0.33, start=whole.start)
    second = machine.transition(0.5, start=first.end)
    assert len(machine.simulate(0.5, start=whole.start).events) > 2
    size = np.abs(second.matrix) @ np.abs(first.matrix)
    assert np.abs(second.matrix @ first.matrix - whole.matrix).max() < 1e-8 * size.max()
    assert machine.start(whole.start).save is not None and "[body.box]\ns = " in whole.start.toml
    assert whole.start.toml.count("[body.box]") == 1


def test_invariant_a_transition_is_lost_where_the_start_touches():
    ball = vi.Machine({
        "name": "Ball", "gravity": 10.0, "body": {"ball": {"mass": 1.0, "gravity": 1.0}},
        "stop": {"floor": {"between": ["ground", "ball"], "gap": 0.0, "restitution": 0.5}},
    })
    found = ball.transition(0.1, start={"ball.v": 1.0})
    assert found.matrix.mask[:, 0].all() and "stop.floor" in found.lost["ball.s"] and "t = 0 s" in found.lost["ball.s"]


def test_closed_form_a_dictionary_is_an_oscillator():
    machine = vi.Machine(OSCILLATOR)
    run = machine.simulate(2.0, samples=500)
    assert run.columns[:3] == ["mass.s", "mass.v", "mass.a"] and list(run) == run.columns
    assert np.abs(run["mass.s"] - 0.1 * np.cos(20.0 * run.t)).max() < ROUNDING
    assert np.abs(run.energy["kinetic"] + run.energy["stored"] - 4.0).max() < ROUNDING
    with pytest.raises(KeyError, match="mass.s"):
        run["mas.s"]


def test_second_method_a_text_a_dictionary_and_a_file_are_one_machine(tmp_path):
    machine = vi.Machine(OSCILLATOR)
    text = vi.Machine(machine.toml)
    path = tmp_path / "machine.toml"
    path.write_text(machine.toml)
    assert machine == text == vi.Machine(path) == vi.Machine(str(path)) == pickle.loads(pickle.dumps(machine))
    assert len({machine, text}) == 1 and machine.name == "Oscillator"
    heavier = machine.replace({"body.mass.mass": "8 kg", "spring.mount.stiffness": 400.0})
    assert heavier != machine and heavier.parameters["body.mass.mass"] == 8.0
    assert machine.parameters["body.mass.mass"] == 2.0 and machine.units["body.mass.mass"] == "kg"


def test_samples_of_blocks_are_no_events():
    run = vi.Machine(EXAMPLES / "servo.toml").simulate(0.5, samples=1)
    kinds = set(run.events["kind"])
    assert "sample" not in kinds and {"limit", "slip"} <= kinds


def test_events_are_structured_and_many_machines_end_on_the_same_bits():
    machine = damper()
    run = machine.simulate(0.5, samples=1)
    hits = run.events[run.events["kind"] == "impact"]
    assert len(hits) > 3 and set(hits["element"]) == {"stop.steel"} and (hits["value"] > 0).all() and (hits["stops"] == 1).all()
    assert (np.diff(run.events["t"]) >= 0).all()
    machines = [machine.replace({"stop.steel.gap": gap}) for gap in (3e-3, 4e-3, 5e-3)]
    ends = vi.simulate_many(machines, until=0.5)
    assert ends.values.shape == (3, len(machine.columns))
    for one, row in zip(machines, ends.values):
        assert (one.simulate(times=[0.5]).values[-1] == row).all()
    assert (ends["block.s"] == ends.values[:, ends.columns.index("block.s")]).all()


def test_second_method_a_sweep_is_the_measures_of_all_combinations():
    axes = {"stop.steel.gap": ["4 mm", "5 mm"], "body.box.mass": [12.0, 13.0]}
    found = damper().sweep(["amplitude.box.s"], axes, settle=5, periods=4, section=0.1)
    assert [(row["stop.steel.gap"], row["body.box.mass"]) for row in found] == [(g, m) for g in (4e-3, 5e-3) for m in (12.0, 13.0)]
    last = damper().replace({"stop.steel.gap": 5e-3, "body.box.mass": 13.0})
    assert found[-1]["amplitude.box.s"] == last.measure(["amplitude.box.s"], settle=5, periods=4, section=0.1)["amplitude.box.s"]


def test_closed_form_exponent_of_an_oscillator():
    # x'' + 4 x' + 400 x = 0 decays with e^-2t.
    machine = vi.Machine({**OSCILLATOR, "spring": {"mount": {**OSCILLATOR["spring"]["mount"], "damping": "8 N s/m"}}})
    assert abs(machine.measure(["exponent"])["exponent"] + 2.0) < 1e-10
    # Both classes of machine use the same word for the spectrum.
    spectrum = machine.spectrum(periods=200)
    assert spectrum.exponents.shape == (2,) and abs(spectrum.exponents + 2.0).max() < 1e-10 and spectrum.period == 1
    assert spectrum.running.shape == (200, 2) and (spectrum.running[-1].sum() - spectrum.exponents.sum()) < 1e-10


def test_invariant_measures_balance_and_a_diagram_shows_what_they_measure():
    machine = damper()
    found = machine.measure(["power.shaker", "power.lost", "maximum.block.s", "class"], periods=12)
    assert abs(found["power.shaker"] - found["power.lost"]) < SETTLED * found["power.lost"]
    gaps = np.linspace(4e-3, 6e-3, 3)
    diagram = machine.bifurcation("block.s", periods=(300, 12), **{"stop.steel.gap": gaps})
    assert np.allclose(diagram.up.value, gaps) and diagram.up.kind[0] == found["class"]
    first = diagram.up.maxima[diagram.up.at == 0]
    assert abs(first.max() - found["maximum.block.s"]) < SETTLED * abs(found["maximum.block.s"])
    ones = [machine.replace({"stop.steel.gap": g}) for g in gaps]
    many = vi.measure_many(ones, ["amplitude.box.s"], periods=12, section=0.1)
    assert [m["amplitude.box.s"] for m in many] == [
        one.measure(["amplitude.box.s"], periods=12)["amplitude.box.s"] for one in ones
    ]


@pytest.mark.parametrize(
    ("what", "error", "words"),
    [
        (lambda: vi.Machine({**OSCILLATOR, "bdy": {}}), ValueError, "bdy"),
        (lambda: vi.Machine({**OSCILLATOR, "gravity": object()}), TypeError, "gravity"),
        (lambda: vi.Machine("nowhere.toml"), ValueError, "nowhere.toml"),
        (lambda: vi.Machine(3), TypeError, "path of a file"),
        (lambda: damper().replace({"stop.stel.gap": 1e-3}), ValueError, "did you mean `stop.steel.gap`"),
        (lambda: damper().replace({"stop.steel.restitution": 1.5}), ValueError, "0 to 1"),
        (lambda: damper().replace({"stop.steel.gap": "5 mN"}), ValueError, "expected one of m, cm, mm, um, in"),
        (lambda: damper().replace({"stop.steel.gap": "5"}), ValueError, "expected a number in m, or a text with a unit"),
        (lambda: damper().replace({"stop.steel.gap": True}), TypeError, "stop.steel.gap"),
        (lambda: damper().simulate(), TypeError, "expected exactly one of until, periods and times"),
        (lambda: damper().simulate(1.0, start={"bx.s": 1.0}), ValueError, "did you mean `box.s`"),
        (lambda: damper().simulate(1.0, start={"box.s": "5"}), ValueError, "expected a number in SI, or a text with a unit"),
        (lambda: damper().simulate(1.0, start={"box.s": "5 N"}), ValueError, "expected one of m, cm, mm, um, in"),
        (lambda: damper().simulate(1.0, start={"box.s": np.nan}), ValueError, "box.s = nan: expected a finite number"),
        (lambda: damper().simulate(1.0, start={3: 1.0}), TypeError, "3 is not a name"),
        (lambda: damper().simulate(1.0, start=3), TypeError, "start is of type int"),
        (lambda: damper().simulate(1.0, start={"block.s": 1.0}), ValueError, "stop.steel.gap = 0.004 m: e - gap = "),
        (lambda: damper().measure(["class"], start={"block.s": 1.0}), ValueError, "a rigid stop requires e <= gap"),
        (lambda: damper().simulate(1.0, start={"time": 2.0}), ValueError, "until = 1.0: must be greater than 2"),
        (lambda: damper().simulate(times=[0.5], start={"time": 2.0}), ValueError, "finite, ascending times >= 2"),
        (lambda: damper().start("nowhere.toml"), ValueError, "nowhere.toml: no such file"),
        (lambda: damper().transition(0.0), ValueError, "until = 0.0"),
        (lambda: damper().simulate(1.0, derivatives=["start.bx.v"]), ValueError, "start.bx.v: no start value has this name; did you mean `start.box.v`"),
        (lambda: vi.simulate_many([damper()], until=1.0, derivatives=["gravity"]), TypeError, "derivatives: requires described machines and `times`"),
        (lambda: vi.simulate_many([damper()], times=[1.0], derivatives=["grvity"]), ValueError, "did you mean `gravity`"),
        (lambda: vi.simulate_many([damper()] * 2, starts=[None] * 3, until=1.0), ValueError, "starts has 3 starts: expected one start, or one for each of 2"),
        (lambda: damper().simulate(-1.0), ValueError, "until"),
        (lambda: damper().simulate(times=[1.0, 0.5]), ValueError, "ascending"),
        (lambda: damper().measure(["amplitude.bx.s"]), ValueError, "did you mean `box.s`?"),
        (lambda: damper().measure(["class"], section="x"), ValueError, 'section x: no stop'),
        (lambda: damper().bifurcation("box.s"), TypeError, "exactly one"),
        (lambda: damper().bifurcation("box.s", periods=3, **{"stop.steel.gap": [1e-3, 2e-3]}), TypeError, "periods = 3: expected a pair"),
        (lambda: damper().bifurcation("box.s", **{"stop.steel.gap": [1e-3, 3e-3, 4e-3]}), ValueError, "stop.steel.gap[1] = 0.003 instead of 0.0025: expected"),
        (lambda: damper().simulate("1 m"), ValueError, "until = '1 m': expected a number in s"),
        (lambda: damper().simulate("1"), ValueError, "until = '1': expected a number in s, or a text with a unit"),
        (lambda: vi.simulate_many([damper(), vi.Machine(OSCILLATOR)], until=1.0), ValueError, "columns"),
        (lambda: vi.simulate_many([damper()], periods=10), TypeError, "a Machine requires `until` or `times`"),
        (lambda: vi.simulate_many([vi.PaperMachine()], times=[1.0]), TypeError, "machines[0] is of type PaperMachine"),
        (lambda: vi.simulate_many([vi.PaperMachine(), damper()]), TypeError, "machines[1] is of type Machine"),
        (lambda: vi.measure_many([damper()], ["class"], starts=[0.0] * 6), TypeError, "starts"),
        (lambda: vi.measure_many([vi.PaperMachine()], ["class"], section=1.0), TypeError, "section"),
        (lambda: damper().sketch().save("damper.jpeg"), ValueError, ".svg or .png"),
        (lambda: damper().fmu("damper.fmu", version=1), ValueError, "version"),
        (lambda: setattr(damper(), "name", "x"), AttributeError, "immutable"),
    ],
)
def test_bad_input_is_refused_by_name(what, error, words):
    with pytest.raises(error, match=re.escape(words)):
        what()


def test_a_jam_is_a_runtime_error_that_names_the_stops():
    jam = vi.Machine(
        'name = "Jam"\n[body.press]\nmotion = { rate = "1 m/s" }\n[body.block]\nmass = "1 kg"\n'
        '[stop.front]\nbetween = ["block", "press"]\ngap = "0.2 m"\nrestitution = 0.5\n'
        '[stop.wall]\nbetween = ["ground", "block"]\ngap = "0.1 m"\nrestitution = 0.0\n'
    )
    with pytest.raises(RuntimeError, match="jammed at t = 0.3.*stop.front"):
        jam.simulate(1.0)


def test_a_design_that_cannot_go_on_is_told_in_its_row():
    jam = vi.Machine(
        'name = "Jam"\n[body.press]\nmotion = { rate = "1 m/s" }\n[body.block]\nmass = "1 kg"\n'
        '[stop.front]\nbetween = ["block", "press"]\ngap = "0.2 m"\nrestitution = 0.5\n'
        '[stop.wall]\nbetween = ["ground", "block"]\ngap = "0.1 m"\nrestitution = 0.0\n'
    )
    names = ["amplitude.block.s", "class"]
    many = [jam.replace({"stop.wall.gap": 1e6}), jam]
    good, bad = vi.measure_many(many, names, settle=1, periods=4, section=0.1, errors="row")
    assert {name: good[name] for name in names} == many[0].measure(names, settle=1, periods=4, section=0.1) and good["error"] is None
    assert bad["amplitude.block.s"] is bad["class"] is None and "jammed" in bad["error"]
    with pytest.raises(RuntimeError, match="motion 1: .*jammed"):
        vi.measure_many(many, names, settle=1, periods=4, section=0.1)
    with pytest.raises(RuntimeError, match="^jammed"):
        jam.measure(names, settle=1, periods=4, section=0.1)


def test_numbers_are_in_si_and_texts_have_their_units():
    machine = damper()  # its file says "4 mm"
    assert machine.replace({"stop.steel.restitution": "0.5"}).parameters["stop.steel.restitution"] == 0.5
    assert machine.replace({"stop.steel.gap": 3e-3}) == machine.replace({"stop.steel.gap": "3 mm"})
    texts, numbers = (
        machine.bifurcation("box.s", periods=(2, 2), **{"stop.steel.gap": gaps})
        for gaps in (["3 mm", "4 mm", "5 mm"], [3e-3, 4e-3, 5e-3])
    )
    assert (texts.up.value == numbers.up.value).all() and (texts.up.maxima == numbers.up.maxima).all()


#: Machines with files from the Rust tests: every kind of element, records, rotation.
NATIVE = ["damper_with_buffer", "gear_backlash", "msl_coupled_clutches", "valve_train"]


def is_same(values, texts):
    """Whether numbers equal the ones in a table of the command line, bit for bit."""
    return values.tobytes() == np.array([float(text) for text in texts]).tobytes()


@pytest.mark.parametrize("name", NATIVE)
def test_second_method_a_motion_has_the_bits_of_the_command_line(native, name):
    machine = vi.Machine(EXAMPLES / f"{name}.toml")
    expected = native["assemblies"][name]
    rows = list(csv.reader(io.StringIO(expected["states"])))
    until = expected["until"]
    run = machine.simulate(until, samples=len(rows) - 2)
    assert rows[0] == ["time", *run.columns]
    columns = list(zip(*rows[1:]))
    assert is_same(run.t, columns[0])
    for column, texts in zip(run.columns, columns[1:]):
        assert is_same(run[column], texts), column
    events = list(csv.DictReader(io.StringIO(expected["events"])))
    assert len(events) > 3 and is_same(run.events["t"], [event["time"] for event in events])
    for field in ("kind", "element"):
        assert list(run.events[field]) == [event[field] for event in events]
    assert is_same(run.events["value"], [event["value"] or 0.0 for event in events])
    ends = vi.simulate_many([machine] * 3, until=until)
    assert (ends.values == machine.simulate(times=[until]).values).all()


@pytest.mark.parametrize("name", NATIVE)
def test_second_method_archives_and_sketch_have_the_bytes_of_the_packager(native, name, tmp_path):
    machine = vi.Machine(EXAMPLES / f"{name}.toml")
    for version, path in native["assemblies"][name]["archives"].items():
        written = machine.fmu(tmp_path / f"{version}.fmu", version=int(version))
        assert written.read_bytes() == Path(path).read_bytes()
    sketch = machine.sketch()
    assert sketch._repr_svg_() == sketch.svg == native["assemblies"][name]["sketch"]
    assert sketch.save(tmp_path / "a.svg").read_text(encoding="utf-8") == sketch.svg
    assert sketch.save(tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    body = next(column for column in machine.columns if column.endswith(".s"))
    assert f">{body[:-2]}<" in sketch.svg and repr(sketch) == f"Sketch({machine.name!r})"


@pytest.mark.parametrize("version", [2, 3])
def test_second_method_the_fmu_of_a_changed_machine_moves_as_simulate_says(version, tmp_path):
    machine = damper().replace({"stop.steel.gap": "5.5 mm"})
    archive = machine.fmu(tmp_path, version)  # in a folder it is named after the machine
    assert archive == tmp_path / {2: "DamperWithBuffer.fmu", 3: "DamperWithBuffer-FMI3.fmu"}[version]
    step, steps = 2.0**-10, 512  # sums of a power of two are exact in every host
    rows = fmpy.simulate_fmu(
        str(archive), stop_time=step * steps, output_interval=step, output=["box.s", "buffer.f"], fmi_type="CoSimulation"
    )
    run = machine.simulate(times=rows["time"])
    assert len(rows) == steps + 1 and (run["box.s"] == rows["box.s"]).all() and (run["buffer.f"] == rows["buffer.f"]).all()


def test_an_fmu_of_any_name_is_written_where_one_is_and_nothing_where_it_cannot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert vi.Machine(OSCILLATOR).fmu() == Path("Oscillator-FMI3.fmu") and (tmp_path / "Oscillator-FMI3.fmu").is_file()
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OSError, match="file"):
        vi.Machine(OSCILLATOR).fmu(tmp_path / "file" / "x.fmu")


def test_a_diagram_of_a_machine_with_a_step_starts_each_value_anew() -> None:
    machine = vi.Machine(
        """
name = "Step"
[body.a]
mass = 1.0
[spring.k]
between = ["ground", "a"]
stiffness = 100.0
damping = 4.0
[load.drive]
on = "a"
amplitude = 1.0
frequency = 1.0
[load.step]
on = "a"
steps = [[200.0, 10.0]]
"""
    )
    values = np.linspace(100.0, 120.0, 3)
    with pytest.raises((RuntimeError, ValueError), match="anew=True"):
        machine.bifurcation("a.s", periods=(40, 4), **{"spring.k.stiffness": values})
    found = machine.bifurcation("a.s", anew=True, periods=(40, 4), **{"spring.k.stiffness": values})
    assert list(found.up.kind) == ["1T"] * 3
    assert not found.hysteresis.any() and list(found.down.kind) == ["refused"] * 3


def test_a_named_parameter_moves_all_that_follows_from_it():
    machine = vi.Machine(EXAMPLES / "play_by_one_number.toml")
    assert machine.replace(backlash="0.2 mm").parameters["backlash"] == 2e-4

    def end(backlash):
        return machine.replace(backlash=backlash).simulate(0.05)["wheel.s"][-1]

    step = 1e-9  # of 0.1 mm: the differences have six correct digits
    slope = (end(1e-4 + step) - end(1e-4 - step)) / (2 * step)
    found = machine.simulate(0.05, derivatives=["backlash"]).derivative("wheel.s", "backlash")[-1]
    assert abs(found - slope) < 1e-4 * abs(slope)
    with pytest.raises(ValueError, match=r"stop\.drive_flank\.gap: follows from `backlash`.*change `backlash` instead"):
        machine.replace({"stop.drive_flank.gap": 1e-4})


def test_closed_form_a_matrix_body_takes_arrays_and_sparse_matrices() -> None:
    """Two masses of 2 kg between walls, 200 N/m of stiffness if both move alike: cos 10 t."""

    class Sparse:
        """The part of SciPy's sparse matrices that the package uses."""

        def __init__(self, dense: np.ndarray) -> None:
            self.dense = dense

        def toarray(self) -> np.ndarray:
            return self.dense

    mass, stiffness = np.diag([2.0, 2.0]), np.array([[300.0, -100.0], [-100.0, 300.0]])

    def machine(mass: object, stiffness: object) -> vi.Machine:
        nodes = {"left": 0, "both": np.array([1.0, 1.0])}
        pair = {"mass": mass, "stiffness": stiffness, "nodes": nodes, "start": {"q": np.array([0.1, 0.1])}}
        return vi.Machine({"name": "Pair", "matrix": {"pair": pair}})

    run = machine(mass, Sparse(stiffness)).simulate(1.0, samples=10)
    assert np.abs(run["pair.both.s"] - 0.2 * np.cos(10.0 * run.t)).max() < 1e-12
    assert machine(mass, stiffness) == machine(mass.tolist(), stiffness.tolist())
    sparse = pytest.importorskip("scipy.sparse")
    for kind in (sparse.csr_matrix, sparse.coo_array):
        assert machine(kind(mass), kind(stiffness)) == machine(mass, stiffness)
