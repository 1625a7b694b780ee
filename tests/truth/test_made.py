"""The tables of the truth suite, made again by the first program and found again by the second one."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("gmpy2")
pytest.importorskip("flint")
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "truth"))

import cases  # noqa: E402
import check  # noqa: E402
import make  # noqa: E402
import page  # noqa: E402
from digits import real  # noqa: E402
from machine import read  # noqa: E402
from motion import Motion  # noqa: E402

# Cases of a second each: impacts to rest, friction, a compliant law, inputs, samples.
FEW = ("chatter_to_rest", "three_balls", "stick_slip", "elastogap", "input_ramps", "input_jumps", "sampled_control", "freewheel", "sliders")


@pytest.mark.parametrize("name", FEW)
def test_golden_states_and_events_are_made_again(name):
    case = cases.Case(name)
    machine = read(case.folder, case.stop)
    states, events = Motion(machine, case.stop).run([real(t) for t in case.times()])
    made = []
    for time, left, right in states:
        for z in (left, right):
            if z:
                numbers = [x for i in machine.free() for x in (z.s[i], z.v[i])]
                made.append([make.text(x) for x in (time, *numbers)])
    kept = [[row[key] for key in row if not key.endswith("magnification")] for row in cases.read_truth(case)]
    assert made == kept
    listed = [(row["time"], row["kind"], row["element"]) for row in cases.read_events(case) if row["kind"] != "start"]
    assert [(make.text(time, 50), kind, element) for time, kind, element, _ in events] == listed


@pytest.mark.parametrize("name", FEW)
def test_second_method_the_second_program_agrees_to_25_digits(name):
    states, times = check.check(name)
    assert states < 1e-25 and times < 1e-25


def test_a_wrong_table_is_found_by_the_second_program(tmp_path):
    folder = tmp_path / "stick_slip"
    folder.mkdir()
    for path in (cases.FOLDER / "stick_slip").iterdir():
        text = path.read_text()
        if path.name == "events.csv":
            text = text.replace("stick,friction.belt_contact", "slip,friction.belt_contact", 1)
        (folder / path.name).write_text(text)
    with pytest.raises((check.Disagrees, ValueError)):
        check.Replay(cases.Case("stick_slip", folder)).run()


@pytest.mark.parametrize("name", cases.names())
def test_golden_pages_have_the_equations_of_their_machine(name):
    case = cases.Case(name)
    assert (case.folder / cases.PAGE).read_text() == page.page(case, read(case.folder, case.stop))


@pytest.mark.parametrize("name", ["held_record", "stiffness_steps"])
def test_a_page_has_every_piece_of_a_signal(name):
    case = cases.Case(name)
    text = (case.folder / cases.PAGE).read_text()
    assert "…" not in text
    if name == "stiffness_steps":
        assert "{0 from 0 s, -60000000 from 0.0002 s, again after each 0.0003 s}" in text
    else:
        [base] = [body for body in read(case.folder, case.stop).bodies if body.name == "base"]
        assert all(f"{page.shown(row[1])} from {page.shown(row[0])} s" in text for row in base.acceleration.pieces[0])
