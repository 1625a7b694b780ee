"""The package compared with golden files in 60 digits (made by the scripts in tests/data)."""

import csv

import numpy as np
import pytest
import vibro_impact as vi
from conftest import ROOT

# Round-off of the gap after a flight of up to one and a half periods, for states of order one; see
# tests/golden.rs.
GAP_ROUNDING = 2e-14
# Error of times and states, in the system's scales, after up to 150 impacts of a chatter run; see
# tests/golden.rs.
CHATTER = 1e-12
# A rounding amplified by 50 impacts, some of them nearly grazing; see tests/golden.rs.
TWENTY_PERIODS = 5e-11



def begun(time, numbers):
    """Returns a start at a time."""
    return {"time": time, **dict(zip(vi.PaperMachine().columns, numbers))}


FIELDS = {
    "box_mass": "box_m",
    "box_stiffness": "box_k",
    "box_damping": "box_c",
    "block_mass": "block_m",
    "secondary_mass": "secondary_m",
    "secondary_stiffness": "secondary_k",
    "secondary_damping": "secondary_c",
    "coupling_stiffness": "coupling_k",
}


def rows(name):
    with open(ROOT / "tests" / "data" / name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def machine(row):
    names = [*FIELDS, *(n for n in vi.SI_NAMES if n not in FIELDS.values())]
    return vi.PaperMachine(**{FIELDS.get(name, name): float(row[name]) for name in names if name in row})


def state(row, prefix=""):
    return [float(row[prefix + name]) for name in ("x1", "x2", "x3", "v1", "v2", "v3")]


def test_every_graze_is_found_at_its_time_and_none_invented():
    found = 0
    for row in rows("grazing.csv"):
        begin, end = float(row["t0"]), float(row["t_end"])
        run = machine(row).simulate(start=begun(begin, state(row)), times=[end])
        assert len(run.impacts) == int(row["contact"]), row["id"]
        loosened = 1.0
        for impact in run.impacts:
            speed = float(row["speed"])
            late = impact["t"] - begin - float(row["delay"])
            assert abs(late) < 4 * np.finfo(float).eps * abs(impact["t"]) + GAP_ROUNDING / speed, row["id"]
            assert impact["stop"] == int(row["side"])
            loosened += 10 / speed
            found += 1
        np.testing.assert_allclose(run.end, state(row, "e_"), rtol=0, atol=10 * GAP_ROUNDING * loosened, err_msg=row["id"])
    assert found > 250


def test_every_chatter_ends_in_rest_and_lets_go_at_its_time():
    for row in rows("chatter.csv"):
        m, begin = machine(row), float(row["t0"])
        rate = max(m.drive_frequency, np.sqrt(m.box_k / m.box_m))
        run = m.simulate(start=begun(begin, state(row)), times=[float(row["t_end"])])
        if row["kind"] != "start":
            (rest,) = run.rests
            assert rest["stop"] == int(row["side"])
            assert abs(rest["t"] - begin - float(row["rest"])) * rate < CHATTER, row["id"]
        assert len(run.releases) == bool(row["release"]), row["id"]
        if row["release"]:
            assert abs(run.releases["t"][0] - begin - float(row["release"])) * rate < CHATTER, row["id"]
        scale = m.stop_gap * np.array([1, 1, 1, rate, rate, rate])
        assert (np.abs(np.asarray(run.end) - state(row, "e_")) < CHATTER * scale).all(), row["id"]


def test_standard_work_over_twenty_periods():
    m = vi.PaperMachine.from_groups(epsilon=0.1, kappa=0.75, f10=1.5, sigma1=0.0, gamma1=0.4, alpha23=0.2, sigma30=0.0, gamma3=0.4)
    expected, impacts = rows("standard_double_periods.csv"), rows("standard_double_impacts.csv")
    run = m.simulate(start={"x2": 0.9, "v2": 0.5}, times=[float(row["t"]) for row in expected])
    np.testing.assert_allclose(np.hstack([run.s, run.v]), [state(row) for row in expected], rtol=0, atol=TWENTY_PERIODS)
    assert len(run.impacts) == len(impacts) == 50
    for field, column in (("t", "t"), ("speed", "speed"), ("stop", "side")):
        np.testing.assert_allclose(run.impacts[field], [float(row[column]) for row in impacts], rtol=0, atol=TWENTY_PERIODS)


def test_special_points_in_thirty_digits():
    # The symmetric two-impact orbit of the default set over f10: tests/theory/orbits.py gives the
    # digits.
    branch = vi.PaperMachine.from_groups(f10=1.5).orbit("U", symmetric=True).follow("f10", 0.5, 3.0)
    special = dict(branch.special)
    assert special["BP"] == pytest.approx(2.039588865238, abs=1e-11)
    assert "GR" in special and branch.word in ("U", "L") and branch.symmetric
