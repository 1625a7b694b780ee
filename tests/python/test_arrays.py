"""Arrays in, arrays out; parts in a folder; executors."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
import vibro_impact as vi
from conftest import ROOT

DAMPER = ROOT / "examples" / "assembly" / "damper_with_buffer.toml"
STEEL, BUFFER, MASS = "stop.steel.gap", "stop.buffer.gap", "body.box.mass"
NAMES = ["amplitude.box.s", "class"]
OF = {"settle": 6, "periods": 4}


def damper():
    return vi.Machine(DAMPER)


def test_second_method_rows_have_the_bits_of_machines_one_by_one():
    gaps = np.linspace(4e-3, 9e-3, 5)
    table = vi.measure_many(damper(), {STEEL: gaps, BUFFER: gaps[::-1]}, NAMES, **OF)
    machines = [damper().replace({STEEL: a, BUFFER: b}) for a, b in zip(gaps, gaps[::-1])]
    alone = vi.measure_many(machines, NAMES, **OF)
    assert [{name: row[name] for name in alone.columns} for row in table] == list(alone)
    assert table[2][STEEL] == gaps[2] and (table[STEEL] == gaps).all() and table.shape == (5,) and len(table) == 5
    ends = vi.simulate_many(damper(), {STEEL: gaps}, until=0.3)
    assert (ends.values == vi.simulate_many([damper().replace({STEEL: a}) for a in gaps], until=0.3).values).all()
    # For the paper's machine: a group, a symbol, a physical parameter after groups.
    machine = vi.PaperMachine.from_groups(f10=1.5)
    f10, gap = np.linspace(1.0, 2.0, 4), np.linspace(0.5, 1.0, 4)
    for arrays in ({"f10": f10}, {"kappa": f10 / 4, "f10": f10}, {"L": gap}, {"stop.gap": gap, "drive.frequency": f10}, {"sigma1": f10, "L": gap}):
        several = [machine.replace(dict(zip(arrays, row))) for row in zip(*arrays.values())]
        found = vi.simulate_many(machine, arrays, periods=20)
        alone = vi.simulate_many(several, periods=20)
        np.testing.assert_array_equal(found.states, alone.states)
        np.testing.assert_array_equal(found.t, alone.t)
        start = {"x2": 0.2, "box.v": 0.01}
        table = vi.measure_many(machine, arrays, ["amplitude.x1", "exponent"], starts=start, **OF)
        assert [row["exponent"] for row in table] == [row["exponent"] for row in vi.measure_many(several, ["exponent"], starts=start, **OF)]


def test_invariant_starts_of_rows_are_those_of_their_machines():
    machine, gaps = vi.PaperMachine(), [0.5, 2.0]
    starts = [{"x1": 0.1, "block.v": 0.02}, {"x2": 0.2}]
    found = vi.simulate_many(machine, {"stop.gap": gaps}, starts=starts, periods=3)
    alone = vi.simulate_many([machine.replace(stop_gap=gap) for gap in gaps], starts=starts, periods=3)
    np.testing.assert_array_equal(found.states, alone.states)
    rows = [machine.replace(stop_gap=gap).simulate(periods=1, per_period=1, start=start).end for gap, start in zip(gaps, starts)]
    again = vi.simulate_many(machine, {"stop.gap": gaps}, starts=[list(np.array(row)) for row in rows], periods=1)
    np.testing.assert_array_equal(again.states, vi.simulate_many(machine, {"stop.gap": gaps}, starts=np.array(rows), periods=1).states)
    same = vi.simulate_many(machine, {"stop.gap": gaps}, starts=iter(starts), periods=3)
    np.testing.assert_array_equal(found.states, same.states)
    np.testing.assert_array_equal(alone.states, vi.simulate_many([machine.replace(stop_gap=gap) for gap in gaps], starts=iter(starts), periods=3).states)
    # A row that is refused requires no start.
    ends = vi.simulate_many(machine, {"kappa": [0.5, 2.0]}, starts=starts, periods=1, errors="row")
    assert ends.error[0] is None and "kappa" in ends.error[1]
    with pytest.raises(ValueError, match="starts has 1 rows: expected one start, or one for each of 2 motions"):
        vi.simulate_many(machine, {"stop.gap": gaps}, starts=[{"x1": 0.1}])


def test_what_is_masked_is_refused_by_its_place():
    masked = np.ma.masked_array([0.0, 1.0, 2.0], [0, 1, 0])
    ends = vi.simulate_many(vi.PaperMachine(), {"kappa": [0.5, 2.0]}, periods=1, errors="row")
    slide = vi.Machine(DAMPER)
    for call, place in [
        (lambda: vi.PaperMachine().simulate(times=masked), r"times\[1\] is masked"),
        (lambda: vi.simulate_many(vi.PaperMachine(), starts=ends.states, periods=1), r"starts\[1, 0\] is masked"),
        (lambda: vi.measure_many(damper(), {MASS: masked}, NAMES), rf"{MASS}\[1\] is masked"),
        (lambda: damper().sweep(NAMES, {MASS: masked}), rf"{MASS}\[1\] is masked"),
        (lambda: vi.Load("box", masked, [0, 1, 2]), r"t\[1\] is masked"),
        (lambda: slide.fit({"box.s": ([0.0, 1.0, 2.0], masked)}, free=[MASS]), r"record\['box.s'\]\[1\]\[1\] is masked"),
        (lambda: slide.fit({"box.s": ([0.0, 1.0], [0.0, 1.0])}, free=[MASS], events={"steel": masked}), r"events\['steel'\]\[1\] is masked"),
    ]:
        with pytest.raises(ValueError, match=f"{place}: expected .*, all finite"):
            call()


def test_what_is_wrong_for_all_rows_is_raised():
    arrays = {STEEL: [4e-3, 5e-3]}
    for names, section, words in [(["amplitude.bx.s"], None, "bx"), (NAMES, "nope", "section nope: no stop, contact or friction")]:
        with pytest.raises(ValueError, match=words):
            vi.measure_many(damper(), arrays, names, section=section, errors="row", **OF)


def test_arrays_of_one_number_and_of_texts_are_taken():
    one = vi.measure_many(damper(), {STEEL: np.array(4e-3)}, NAMES, **OF)
    texts = [vi.measure_many(damper(), {STEEL: value}, NAMES, **OF) for value in ("4 mm", ["4 mm"], np.array(["4 mm"]), np.array(["4 mm"], dtype=object))]
    assert one.shape == texts[0].shape == (1,) and all(table["amplitude.box.s"] == one["amplitude.box.s"] for table in texts)


def test_arrays_are_broadcast_and_results_have_their_shape():
    gaps = np.array([[4e-3], [5e-3]])
    table = vi.measure_many(damper(), {STEEL: gaps, "body.box.mass": [12.0, 13.0, 14.0]}, ["amplitude.box.s"], **OF)
    assert table["amplitude.box.s"].shape == table[STEEL].shape == (2, 3)
    sweep = damper().sweep(["amplitude.box.s"], {STEEL: ["4 mm", "5 mm"], "body.box.mass": [12.0, 13.0, 14.0]}, **OF)
    assert (sweep["amplitude.box.s"] == table["amplitude.box.s"]).all() and sweep.axes == (STEEL, "body.box.mass")
    ends = vi.simulate_many(vi.PaperMachine(), f10=np.array([[1.0, 2.0]]), kappa=np.array([[0.5], [0.6]]), periods=3)
    assert ends["box.s"].shape == (2, 2) and ends.s.shape == (2, 2, 3)
    frame = sweep.to_pandas()
    assert list(frame.columns) == [STEEL, "body.box.mass", "amplitude.box.s", "amplitude.box.s.spread", "unsettled"] and len(frame) == 6


def test_second_method_the_spread_of_a_number_is_its_scatter_over_windows():
    # Consecutive windows of one chaotic motion. A standard deviation from 24 windows is accurate to
    # far better than a factor of three.
    chaotic, window, count, factor = vi.PaperMachine.from_groups(f10=3.6), 60, 24, 3.0
    found = [chaotic.measure(["impacts"], start={"v2": 1.0}, settle=400 + window * k, periods=window) for k in range(count)]
    scatter = np.std([one["impacts"] for one in found], ddof=1)
    spread = np.median([one.spread["impacts"] for one in found])
    assert 0.0 < scatter / factor < spread < scatter * factor, (scatter, spread)
    # A motion that repeats scatters only by rounding; the table has the same spread.
    table = vi.measure_many([vi.PaperMachine.from_groups(f10=1.5), chaotic], ["impacts"], periods=window, starts=[{"v2": 1.0}] * 2)
    assert table.spreads["impacts"][0] < 1e-9 and table["impacts.spread"][1] == found[0].spread["impacts"]


def test_a_row_that_is_refused_says_why_and_the_others_have_numbers():
    masses = {MASS: [12.0, -1.0, 13.0]}
    table = vi.measure_many(damper(), masses, NAMES, errors="row", **OF)
    assert table["amplitude.box.s"].mask.tolist() == [False, True, False] and MASS in table.error[1]
    assert table[1]["amplitude.box.s"] is None and table.error[0] is None
    ends = vi.simulate_many(damper(), masses, until=0.1, errors="row")
    assert ends["box.s"].mask.tolist() == [False, True, False] and MASS in ends.error[1]
    ends = vi.simulate_many(vi.PaperMachine(), kappa=[0.5, 2.0, 0.6], periods=3, errors="row")
    assert ends.s.mask.any(axis=1).tolist() == [False, True, False] and "kappa = 2" in ends.error[1]
    np.testing.assert_array_equal(ends.s[2], vi.simulate_many(vi.PaperMachine(), kappa=[0.6], periods=3).s[0])
    for call in (lambda: vi.measure_many(damper(), masses, NAMES, **OF), lambda: vi.simulate_many(vi.PaperMachine(), kappa=[0.5, 2.0])):
        with pytest.raises(ValueError, match="motion 1: "):
            call()


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: vi.measure_many(damper(), {"stop.stel.gap": [1.0]}, NAMES), ValueError, "did you mean `stop.steel.gap`"),
        (lambda: vi.measure_many([damper()] * 2, {STEEL: [1.0]}, NAMES), TypeError, "with 2 machines: expected one machine"),
        (lambda: vi.measure_many(damper(), {STEEL: [1.0, 2.0], BUFFER: [1.0] * 3}, NAMES), ValueError, "can be broadcast"),
        (lambda: vi.measure_many(damper(), {STEEL: [np.nan]}, NAMES), ValueError, r"stop.steel.gap\[0\] = nan"),
        (lambda: vi.simulate_many(damper(), {STEEL: [1e-3] * 2}, starts=[None] * 3, until=1.0), ValueError, "starts has 3 rows"),
        (lambda: vi.measure_many(damper(), NAMES, executor=3), TypeError, "executor is of type int: expected an object with `submit`"),
        (lambda: vi.simulate_many(vi.PaperMachine(), f11=[1.0]), TypeError, "did you mean `f10`?"),
        (lambda: vi.simulate_many(damper(), {STEEL: [1e-3]}, times=[1.0]), TypeError, "cannot be combined with arrays"),
    ],
)
def test_what_is_refused_is_named(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


class Counting:
    """An executor in this process with only the required method."""

    def __init__(self, fail_at=None):
        self.parts, self.fail_at = 0, fail_at

    def submit(self, function, *arguments):
        self.parts += 1
        future = Future()
        if self.parts == self.fail_at:
            future.set_exception(KeyboardInterrupt())
        else:
            future.set_result(function(*arguments))
        return future


def test_invariant_any_executor_gives_the_same_rows():
    arrays = {STEEL: np.linspace(4e-3, 9e-3, 20)}
    wanted = list(vi.measure_many(damper(), arrays, NAMES, **OF))
    ends = vi.simulate_many(vi.PaperMachine(), f10=np.linspace(1, 2, 20), periods=5)
    with ProcessPoolExecutor(2) as processes, ThreadPoolExecutor(2) as threads:
        for executor in (Counting(), threads, processes):
            assert list(vi.measure_many(damper(), arrays, NAMES, executor=executor, **OF)) == wanted
            found = vi.simulate_many(vi.PaperMachine(), f10=np.linspace(1, 2, 20), periods=5, executor=executor)
            np.testing.assert_array_equal(found.states, ends.states)
        several = [damper().replace({STEEL: gap}) for gap in arrays[STEEL]]
        assert [row["class"] for row in vi.measure_many(several, NAMES, executor=processes, **OF)] == [row["class"] for row in wanted]
        with pytest.raises(ValueError, match="motion 17: "):
            vi.measure_many(damper(), {MASS: [12.0] * 17 + [-1.0]}, NAMES, executor=processes, **OF)


def test_parts_in_a_folder_are_taken_up_again(tmp_path):
    arrays, folder = {STEEL: np.linspace(4e-3, 9e-3, 30)}, tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt) as stop:
        vi.measure_many(damper(), arrays, NAMES, executor=Counting(fail_at=3), checkpoint=folder, **OF)
    kept = sorted(path.name for path in folder.glob("*.part"))
    assert kept == ["00000.part", "00001.part"] and not list(folder.glob("*.writing"))
    partial = stop.value.partial
    assert len(partial) == 30 and partial[15]["class"] and partial[16:] == [None] * 14
    again = Counting()
    table = vi.measure_many(damper(), arrays, NAMES, executor=again, checkpoint=folder, **OF)
    assert again.parts == 2 and list(table) == list(vi.measure_many(damper(), arrays, NAMES, **OF))
    # All parts exist: nothing is computed.
    assert list(vi.measure_many(damper(), arrays, NAMES, executor=Counting(fail_at=1), checkpoint=folder, **OF)) == list(table)
    with pytest.raises(ValueError, match="holds parts of other work, `work = "):
        vi.measure_many(damper().replace({"body.box.mass": 13.0}), arrays, NAMES, checkpoint=folder, **OF)
    whole = (folder / "00000.part").read_text()
    for damaged in ("", "5", "[{", json.dumps([]), whole[:-1], whole.replace("1", "2"), whole.split("\n", 1)[1]):
        (folder / "00000.part").write_text(damaged)
        with pytest.raises(ValueError, match="00000.part is damaged, .* delete this file"):
            vi.measure_many(damper(), arrays, NAMES, checkpoint=folder, **OF)
    for at, kind, words in [(5, TypeError, "checkpoint = 5 is of type int"), (folder / "00000.part", OSError, "checkpoint = .*: expected a folder")]:
        with pytest.raises(kind, match=words):
            vi.measure_many(damper(), arrays, NAMES, checkpoint=at, **OF)
    (folder / "manifest.toml").write_text("")
    with pytest.raises(ValueError, match="its manifest.toml is cut"):
        vi.measure_many(damper(), arrays, NAMES, checkpoint=folder, **OF)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").write_text("")
    with pytest.raises(ValueError, match="no manifest.toml"):
        vi.measure_many(damper(), arrays, NAMES, checkpoint=tmp_path / "other", **OF)
    # Infinite and missing numbers survive the folder.
    machine, f10 = vi.PaperMachine(), np.linspace(1, 2, 9)
    names = ["exponent", "class", "impacts"]
    found = vi.measure_many(machine, {"f10": f10}, names, checkpoint=tmp_path / "papers", **OF)
    assert list(found) == list(vi.measure_many(machine, {"f10": f10}, names, **OF))


KILLED = """
import sys, numpy as np, vibro_impact as vi
print("begun", flush=True)
vi.measure_many(vi.Machine(sys.argv[1]), {"stop.steel.gap": np.linspace(4e-3, 9e-3, 40_000)}, ["class"], settle=30, periods=9, checkpoint=sys.argv[2])
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
def test_a_process_that_is_killed_leaves_whole_parts(tmp_path):
    folder = tmp_path / "parts"
    child = subprocess.Popen([sys.executable, "-c", KILLED, str(DAMPER), str(folder)], stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"begun\n"
    end = time.monotonic() + 60
    while len(list(folder.glob("*.part"))) < 2 and time.monotonic() < end:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    child.wait()
    parts = sorted(folder.glob("*.part"))
    assert len(parts) >= 2
    assert all(len(json.loads(part.read_text().split("\n")[1])) == 200 for part in parts)


def test_ctrl_c_with_a_folder_ends_at_once(tmp_path):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt) as stop:
            vi.measure_many(damper(), {STEEL: np.linspace(4e-3, 9e-3, 100_000)}, ["class"], checkpoint=tmp_path / "parts")
        assert len(stop.value.partial) == 100_000
    finally:
        signal.signal(signal.SIGINT, before)
