"""The score of the truth suite: right and broken hosts, and files that cannot be read."""

import sys
import zipfile
from decimal import Decimal
from pathlib import Path

import pytest

if sys.version_info < (3, 11):
    pytest.skip("the truth suite needs tomllib of Python 3.11", allow_module_level=True)
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "truth"), str(Path(__file__).resolve().parent)]

import cases  # noqa: E402
import hosts  # noqa: E402
import hosts_of_one_mass as host  # noqa: E402
import score  # noqa: E402
from machine import read_inputs  # noqa: E402
from results import BadResult, Result, read_events, read_rows  # noqa: E402
from verdict import Truth, score_of  # noqa: E402

LIMIT = 1e-6


def rounded(truth, shift=0):
    """A host that writes the truth in doubles, or the truth of `shift` outputs before."""
    rows = [(time, sides[-1][0]) for time, sides in truth.rows]
    return [(time, {n: Decimal(repr(float(x))) for n, x in rows[max(0, k - shift)][1].items()}) for k, (time, _) in enumerate(rows)]


def by_host(name, **faults):
    truth = Truth(cases.Case(name))
    inputs = read_inputs(truth.case.folder / "input.csv")["load.push.input"][0]
    rows = host.rows(inputs, truth.case.steps, float(truth.case.step), **faults)
    written = [(Decimal(repr(t)), {"mass.s": Decimal(repr(s)), "mass.v": Decimal(repr(v))}) for t, s, v in rows]
    return score_of(truth, Result(written), LIMIT)


@pytest.mark.parametrize("name", cases.names())
def test_closed_form_the_truth_in_doubles_is_off_by_a_rounding(name):
    truth = Truth(cases.Case(name))
    events = [(time, kind, element) for time, kind, element, _, _ in truth.events]
    found = score_of(truth, Result(rounded(truth), events), LIMIT)
    assert found.passed and found.error <= 2**-53 and found.late == (0.0 if events else None), found


@pytest.mark.parametrize("name", ["input_ramps", "input_jumps"])
def test_second_method_a_right_host_passes(name):
    assert by_host(name).passed


@pytest.mark.parametrize("name, faults", [("input_ramps", {"held": True}), ("input_jumps", {"jumps": False}),
                                          ("input_ramps", {"events": False}), ("input_jumps", {"events": False})])
def test_a_host_with_a_fault_fails_in_the_case_for_it(name, faults):
    found = by_host(name, **faults)
    assert not found.passed and found.error > 1e-3
    if "events" in faults:
        first = next(row for row in Truth(cases.Case(name)).events if row[1] == "impact")
        assert f"impact stop.wall at {float(first[0]):.9g} s" in found.reasons[0]
    else:
        assert found.reasons[0].startswith("wrong from ")


def test_a_host_whose_rows_are_a_step_late_is_told_so():
    truth = Truth(cases.Case("stick_slip"))
    found = score_of(truth, Result(rounded(truth, shift=1)), LIMIT)
    assert found.reasons == ["each row has the state of one communication step before"]


def test_missed_late_and_extra_events_are_counted():
    truth = Truth(cases.Case("stick_slip"))
    events = [(time, kind, element) for time, kind, element, _, _ in truth.events]
    late = [(events[0][0] + Decimal("1e-3"), *events[0][1:])] + events[1:]
    extra = events + [(Decimal("0.3"), "impact", "stop.none")]
    missed = score_of(truth, Result(rounded(truth), events[:-1]), LIMIT)
    assert missed.missed == 1 and "is missed" in missed.reasons[0]
    delayed = score_of(truth, Result(rounded(truth), late), LIMIT)
    assert 1e-4 < delayed.late < 1e-2 and "is off by 0.001 s" in delayed.reasons[0]
    assert score_of(truth, Result(rounded(truth), extra), LIMIT).reasons == ["1 events that do not happen"]


def test_added_events_without_a_kind_are_counted_and_states_of_the_start_are_none():
    truth = Truth(cases.Case("stick_slip"))
    times = [(time, "", "") for time, *_ in truth.events]
    assert score_of(truth, Result(rounded(truth), times), LIMIT).passed
    found = score_of(truth, Result(rounded(truth), times + [(Decimal("0.3"), "", "")]), LIMIT)
    assert found.reasons == ["1 events that do not happen"]
    table = read_events(ROOT / "truth/cases/stick_slip/events.csv")
    assert score_of(truth, Result(rounded(truth), table), LIMIT).passed


def test_events_are_read_from_repeated_rows():
    truth = Truth(cases.Case("stick_slip"))
    rows = rounded(truth)
    both = [(time, rows[0][1]) for time, *_ in truth.events for _ in range(2)]
    found = score_of(truth, Result(sorted(rows + both, key=lambda row: row[0])), LIMIT)
    assert found.passed and found.missed == 0
    fewer = score_of(truth, Result(sorted(rows + both[2:], key=lambda row: row[0])), LIMIT)
    assert fewer.missed == 1


def test_a_motion_without_events_has_none():
    truth = Truth(cases.Case("graze_miss"))
    found = score_of(truth, Result(rounded(truth), [(Decimal("0.785"), "impact", "stop.wall")]), LIMIT)
    assert found.reasons == ["1 events that do not happen"]


BAD = {
    "": "is empty; expected a first row with the columns time, block.s",
    "time,block.s,block.v\n0,0,nan\n": "row 2, column `block.v` is 'nan': expected a finite number",
    "time,block.s,block.v\n0,0,0\n0.1,,0\n": "row 3, column `block.s` is '': expected a number",
    "time,block.s,block.v\n0,0,0\n0.1,0\n": "row 3 has 2 cells; expected 3",
    "time,blocks,block.v\n0,0,0\n": "row 1 has no column `block.s`; it has time, blocks, block.v; did you mean to rename `blocks`?",
    "time,block.s,block.v\n1,0,0\n0.5,0,0\n": "row 3 has the time 0.5, before the time 1 of the row above; expected rising times",
    "time,block.s,block.v\n0,0,0\n0,1,2,3\n": "row 3 has 4 cells; expected 3",
    "time,block.s,block.v\n0,1e99999999,0\n": "row 2, column `block.s` is '1e99999999': expected a number of the size of a double",
    "\ufeffübertime": "expected text in UTF-8",
}


@pytest.mark.parametrize("text", BAD)
def test_bad_tables_are_refused_by_row_and_column(text, tmp_path):
    path = tmp_path / "stick_slip.csv"
    path.write_text(text, encoding="utf-16" if "UTF-8" in BAD[text] else "utf-8")
    with pytest.raises(BadResult) as error:
        read_rows(path, ["block.s", "block.v"])
    assert BAD[text] in str(error.value) and str(path) in str(error.value)


def test_cells_after_the_last_column_may_be_empty(tmp_path):
    (tmp_path / "a.csv").write_text("time,block.s,\n0,1,\n")
    assert read_rows(tmp_path / "a.csv", ["block.s"]) == [(0, {"block.s": 1})]


BAD_EVENTS = {
    "": "is empty; expected a first row with the columns time, kind, element",
    "when,kind\n0,impact\n": "row 1 has no column `time`; it has when, kind",
    "time,kind,element\n0.5,impact\n": "row 2 has 2 cells; expected 3",
    "time,kind,element\n\nsoon,impact,stop.wall\n": "row 3, column `time` is 'soon': expected a number",
}


@pytest.mark.parametrize("text", BAD_EVENTS)
def test_bad_events_are_refused_by_row_and_column(text, tmp_path):
    (tmp_path / "a.events.csv").write_text(text)
    with pytest.raises(BadResult) as error:
        read_events(tmp_path / "a.events.csv")
    assert BAD_EVENTS[text] in str(error.value)


def test_missing_rows_are_told(tmp_path, capsys):
    (tmp_path / "stick_slip.csv").write_text("time,block.s,block.v\n0,0,0\n")
    assert score.main(["--results", str(tmp_path), "--case", "stick_slip", "--case", "elastogap"]) == 1
    told = capsys.readouterr().out
    assert "no row has the time 0.0625 s, output 1 of 64; the table has 1 rows up to 0 s" in told
    assert "elastogap.csv: no such file" in told and "| passed | 0 of 2 |" in told


def test_a_command_is_filled_with_the_case_and_its_faults_are_told(tmp_path, capsys):
    script = tmp_path / "host.py"
    script.write_text("import sys, shutil\nassert sys.argv[1:3] == ['4.0', '0.0625'], sys.argv\nshutil.copy(sys.argv[3], sys.argv[4])\n")
    table = ROOT / "truth/cases/stick_slip/truth.csv"
    words = f"{sys.executable} {script} {{stop}} {{step}} {table} {{output}}"
    assert score.main(["--command", words, "--case", "stick_slip"]) == 0
    script.write_text("raise SystemExit('error: no licence\\nsee --help')")
    assert score.main(["--command", words, "--case", "stick_slip"]) == 1
    told = capsys.readouterr().out
    assert "ends with status 1: error: no licence" in told and "This case fails if" not in told


#: Commands that cannot be a host, and what is told.
NO_HOST = {
    "no-such-host {output}": "no-such-host cannot be run: ",
    "host {files}": "the command has {files}; expected one of {fmu2}, {fmu3}, {machine}, ",
    "host {": "the command has a brace that is not closed",
    "host 'a": "the command cannot be split into words: No closing quotation",
    "  ": "the command has no word",
}


@pytest.mark.parametrize("words", NO_HOST)
def test_a_command_that_is_no_host_is_told(words, capsys):
    assert score.main(["--command", words, "--case", "stick_slip"]) == 1
    assert NO_HOST[words] in capsys.readouterr().out


def test_a_host_that_hangs_or_writes_bytes_that_are_no_text_is_told():
    case = cases.Case("stick_slip")
    with pytest.raises(BadResult, match="sleep does not end within 0.1 s"):
        hosts.by_command("sleep 5", timeout=0.1)(case, [])
    script = "import sys; sys.stderr.buffer.write(bytes([0xff])); sys.exit(3)"
    with pytest.raises(BadResult, match="ends with status 3"):
        hosts.by_command(f'{sys.executable} -c "{script}"')(case, [])


def test_a_host_that_writes_nothing_is_not_scored_by_its_run_before(tmp_path):
    case, names = cases.Case("stick_slip"), ["block.s", "block.v"]
    script = tmp_path / "host.py"
    script.write_text("import sys\nfor name in ['states', 'events']: open(f'{sys.argv[1]}/{name}.csv', 'w').write(f'time,{sys.argv[2]}\\n')\n")
    words = f"{sys.executable} {script} {{folder}} {{names}}"
    assert hosts.by_command(words)(case, names).rows == []
    with pytest.raises(BadResult, match="states.csv: no such file"):
        hosts.by_command(f"{sys.executable} -c 0 {{folder}}")(case, names)


@pytest.mark.parametrize("limit", ["nan", "inf", "0", "-1e-6", "small"])
def test_a_limit_that_is_none_is_refused(limit, capsys):
    with pytest.raises(SystemExit):
        score.main(["--results", "nowhere", f"--limit={limit}"])
    assert f"invalid positive value: '{limit}'" in capsys.readouterr().err


@pytest.mark.parametrize("host_name", ["fmpy", "wasmtime"])
def test_a_host_that_is_not_installed_is_told(host_name, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, host_name, None)
    monkeypatch.delitem(sys.modules, "component", raising=False)
    with pytest.raises(SystemExit):
        score.main([host_name])
    assert f"{host_name} is not installed: run `pip install {host_name}`" in capsys.readouterr().err


def test_an_archive_that_is_none_is_told(tmp_path, capsys):
    pytest.importorskip("wasmtime")
    (tmp_path / "StickSlip-FMI3.fmu").write_text("no archive")
    assert score.main(["wasmtime", "--archives", str(tmp_path), "--case", "stick_slip"]) == 1
    assert "the component ends with BadZipFile" in capsys.readouterr().out
    with zipfile.ZipFile(tmp_path / "StickSlip-FMI3.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    assert score.main(["wasmtime", "--archives", str(tmp_path), "--case", "stick_slip"]) == 1
    assert "has no WebAssembly component: make it by `cargo run --bin fmu-build -- --wasm`" in capsys.readouterr().out
