"""Right and broken masters of FMI 3.0; the environment's TRUTH_ARCHIVES names the folder of the packed cases."""

import os
import sys
from pathlib import Path

import pytest

fmpy = pytest.importorskip("fmpy")
ARCHIVES = os.environ.get("TRUTH_ARCHIVES")
if not ARCHIVES:
    pytest.skip("TRUTH_ARCHIVES names no folder of archives", allow_module_level=True)
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "truth"), str(Path(__file__).resolve().parent)]

import cases  # noqa: E402
import hosts  # noqa: E402
import hosts_of_fmi3 as master  # noqa: E402
from results import Result  # noqa: E402
from verdict import Truth, score_of  # noqa: E402

LIMIT = 1e-12


def run(name, fault):
    truth = Truth(cases.Case(name))
    archive = str(hosts.archive(truth.case, 3, ARCHIVES))
    return score_of(truth, Result(master.rows(archive, truth.names, truth.case.steps, float(truth.case.step), fault)), LIMIT)


@pytest.mark.parametrize("name", ["impact_pair", "stick_slip", "chatter_to_rest"])
def test_second_method_a_right_master_has_the_truth(name):
    assert run(name, "").passed


@pytest.mark.parametrize("name", ["impact_pair", "stick_slip", "chatter_to_rest"])
def test_a_master_that_ignores_early_return_is_stopped_by_the_machine(name):
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi3DoStep"):
        run(name, "ignores early return")


@pytest.mark.parametrize("name", ["impact_pair", "stick_slip", "chatter_to_rest"])
def test_a_master_that_never_enters_event_mode_has_the_states_and_no_events(name):
    found = run(name, "never enters event mode")
    assert found.passed and found.missed is None
