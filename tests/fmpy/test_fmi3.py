"""The FMI 3.0 archive in fmpy: the four forms of the event protocol, compared with FMI 2.0, the native library and the laws."""

import csv
import io
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from conftest import STATES

# Rounding of velocities of about 1 m/s in the residuals of the laws.
LAW = 1e-12
# Steps that end at impacts divide the flow differently: rounding, propagated through the impacts of
# a stable motion.
CUT = 1e-9
# The error of an impact's time is the rounding of time, plus the rounding of displacements over the
# relative speed.
LOCATED = 1e-12
COUNTS = ("impacts.upper", "impacts.lower")
RECORDED = (*STATES, *COUNTS, "stop.state", "energy.impact", "impacts.lastImpulse")

#: event mode, early return
PROTOCOLS = [(False, False), (False, True), (True, True), (True, False)]

CASES = {
    "default": ({}, 60.0),
    "rest": ({"block.v": 0.3, "stop.restitution": 0.3, "block.f": 0.02, "drive.amplitude": 0.4}, 20.0),
    "chatter": ({"block.s": 0.9, "stop.restitution": 0.6, "block.f": 0.5, "drive.amplitude": 0.05}, 12.0),
    "closed form": ({"mode": 3}, 30.0),
}


def load(time_end):
    """A load on the box in steps: fmpy reads the same value between jumps, wherever a step begins."""
    begins = np.arange(0.0, time_end, 0.5)
    rows = [(time, 0.05 * np.sin(0.7 * begin)) for begin in begins for time in (begin, begin + 0.5)]
    return np.array(rows, dtype=[("time", float), ("box.f", float)])


def run(fmu, start, stop, event_mode=False, early_return=False, signals=None, **options):
    return simulate_fmu(
        fmu, fmi_type="CoSimulation", stop_time=stop, output_interval=0.5, start_values=dict(start), input=signals,
        output=list(RECORDED), use_event_mode=event_mode, early_return_allowed=early_return, **options,
    )


def at(rows, time):
    """The last row at a time."""
    return rows[np.flatnonzero(np.isclose(rows["time"], time, rtol=0.0, atol=1e-9))[-1]]


def values(row, names=STATES):
    return np.array([row[name] for name in names], dtype=float)


def impacts(rows):
    """Pairs of rows at one time with a changed count."""
    total = rows["impacts.upper"] + rows["impacts.lower"]
    same = (np.diff(rows["time"]) == 0.0) & (np.diff(total) > 0)
    return [(rows[i], rows[i + 1]) for i in np.flatnonzero(same)]


@pytest.mark.parametrize("version", ["", "-FMI3", "-FMI3-arrays", "-FMI3-clocked"])
def test_fmpy_finds_nothing_wrong_with_any_archive(fmu, version):
    assert validate_fmu(fmu.replace(".fmu", f"{version}.fmu")) == []


@pytest.mark.parametrize("case", CASES)
def test_without_event_mode_and_early_return_it_is_fmi2_bit_for_bit(fmu, fmu3, case):
    start, stop = CASES[case]
    signals = load(stop) if case == "default" else None
    two, three = run(fmu, start, stop, signals=signals), run(fmu3, start, stop, signals=signals)
    assert len(two) == len(three)
    for name in ("time", *RECORDED):
        assert np.array_equal(two[name], three[name]), name


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("protocol", PROTOCOLS[1:], ids=["early return", "both", "event mode"])
def test_each_protocol_gives_the_same_motion(fmu3, case, protocol):
    start, stop = CASES[case]
    plain, rows = run(fmu3, start, stop), run(fmu3, start, stop, *protocol)
    for time in np.arange(0.0, stop + 0.25, 0.5):
        expected, got = at(plain, time), at(rows, time)
        assert np.abs(values(expected) - values(got)).max() < CUT, (time, expected, got)
        assert values(expected, COUNTS).tolist() == values(got, COUNTS).tolist(), time
    event_mode, early_return = protocol
    irregular = np.abs(rows["time"] / 0.5 - np.round(rows["time"] / 0.5)) > 1e-9
    assert irregular.any() == early_return


@pytest.mark.parametrize("case", CASES)
def test_rows_at_an_impact_obey_its_law(fmu3, description3, case):
    start, stop = CASES[case]
    p = {v.name: float(v.start) for v in description3.modelVariables if v.type == "Float64" and v.start and not v.dimensions}
    p.update(start)
    rows = run(fmu3, start, stop, True, True)
    pairs = impacts(rows)
    assert len(pairs) == rows[-1]["impacts.upper"] + rows[-1]["impacts.lower"] or case == "chatter"
    assert len(pairs) > 5
    m1, m2, kappa = p["box.m"], p["block.m"], p["stop.restitution"]
    for before, after in pairs:
        resting = after["stop.state"] != 1
        for name in ("secondary.s", "secondary.v"):
            assert before[name] == after[name]
        assert abs(before["box.s"] - after["box.s"]) < LAW and abs(before["block.s"] - after["block.s"]) < LAW
        approach, rebound = before["block.v"] - before["box.v"], after["block.v"] - after["box.v"]
        # The bounce that closes chatter ends in rest.
        assert abs(rebound + (0.0 if resting else kappa) * approach) < LAW
        momentum = [m1 * row["box.v"] + m2 * row["block.v"] for row in (before, after)]
        assert abs(momentum[0] - momentum[1]) < LAW
        assert abs(abs(before["block.s"] - before["box.s"]) - p["stop.gap"]) < LAW
        lost = 0.5 * m1 * m2 / (m1 + m2) * (approach**2 - rebound**2)
        assert abs(after["energy.impact"] - before["energy.impact"] - lost) < LAW


def reference(fmu, name):
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read(f"extra/org.fmi-standard.fmi-ls-ref/{name}").decode()
    rows = list(csv.reader(io.StringIO(text)))
    return {column: np.array([float(row[i]) for row in rows[1:]]) for i, column in enumerate(rows[0])}


def test_impacts_are_those_of_the_native_library(fmu3):
    """The reference result of the archive, made by the native library."""
    native = reference(fmu3, "impacts.csv")
    stop = 100.0
    count = int((native["time"] < stop).sum()) // 2
    pairs = impacts(run(fmu3, {}, stop, True, True))
    assert len(pairs) == count > 10
    for i, (before, after) in enumerate(pairs):
        assert abs(before["time"] / native["time"][2 * i] - 1.0) < LOCATED
        for row, k in ((before, 2 * i), (after, 2 * i + 1)):
            expected = np.array([native[name][k] for name in STATES])
            assert np.abs(values(row) - expected).max() < CUT


@pytest.mark.parametrize("version", ["", "-FMI3"])
def test_the_default_experiment_is_the_reference_result(fmu, version):
    """Both archives contain the same file, with nine decimal places."""
    path = fmu.replace(".fmu", f"{version}.fmu")
    expected = reference(path, "default.csv")
    # The result has every fourth step of the default experiment.
    interval = 4.0 * float(fmpy.read_model_description(path).defaultExperiment.stepSize)
    names = ["box.s", "block.s", "secondary.s", *COUNTS]
    rows = simulate_fmu(path, fmi_type="CoSimulation", output_interval=interval, output=names)
    assert len(rows) == len(expected["time"])
    for name in ("box.s", "block.s", "secondary.s"):
        assert np.abs(rows[name] - expected[name]).max() < 2e-9
    for name in COUNTS:
        assert np.array_equal(rows[name], expected[name].astype(int))


class Machine:
    """An FMI 3.0 instance with access by name."""

    def __init__(self, folder, description, event_mode=True, early_return=True, state=None):
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU3Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="machine",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.slave.instantiate(eventModeUsed=event_mode, earlyReturnAllowed=early_return, loggingOn=False)
        self.event_mode = event_mode
        if state is not None:
            saved = self.slave.deserializeFMUState(state)
            self.slave.setFMUState(saved)
            self.slave.freeFMUState(saved)

    def initialize(self, **start):
        self.slave.enterInitializationMode(startTime=0.0)
        for name, value in start.items():
            self.set(name.replace("_", "."), value)
        self.slave.exitInitializationMode()
        return self.update() if self.event_mode else self

    def update(self):
        self.slave.updateDiscreteStates()
        self.slave.enterStepMode()
        return self

    def get(self, *names):
        return np.array(self.slave.getFloat64([self.references[name] for name in names]))

    def set(self, name, value):
        self.slave.setFloat64([self.references[name]], [value])

    def step(self, time, size):
        event, _, _, reached = self.slave.doStep(currentCommunicationPoint=time, communicationStepSize=size)
        return event, reached


@pytest.fixture(scope="module")
def folder3(fmu3, tmp_path_factory):
    return fmpy.extract(fmu3, unzipdir=str(tmp_path_factory.mktemp("fmu3")))


@pytest.fixture
def machine(folder3, description3):
    made = []

    def make(**options):
        made.append(Machine(folder3, description3, **options))
        return made[-1]

    yield make
    for one in made:
        one.slave.freeInstance()


def test_a_restitution_set_at_an_event_is_that_of_its_law(machine):
    one = machine().initialize()
    time, met = 0.0, 0
    while met < 20:
        event, time = one.step(time, 1.0)
        if not event:
            continue
        before = one.get("box.v", "block.v")
        one.slave.enterEventMode()
        kappa = 0.5 + 0.02 * (met % 10)
        one.set("stop.restitution", kappa)
        # The right limit is visible at once and does not change when the event is handled.
        shown = one.get("box.v", "block.v")
        one.slave.updateDiscreteStates()
        after = one.get("box.v", "block.v")
        one.slave.enterStepMode()
        assert shown.tolist() == after.tolist()
        assert abs((after[1] - after[0]) + kappa * (before[1] - before[0])) < LAW
        met += 1


def test_loads_in_every_protocol_give_the_same_motion(fmu3):
    plain = run(fmu3, {}, 40.0, signals=load(40.0))
    for protocol in PROTOCOLS[1:]:
        rows = run(fmu3, {}, 40.0, *protocol, signals=load(40.0))
        assert np.abs(values(plain[-1]) - values(rows[-1])).max() < CUT, protocol


@pytest.mark.parametrize("version", [2, 3])
def test_the_reference_state_is_on_the_settled_motion(fmu, fmu3, machine, new, period, version):
    with zipfile.ZipFile(fmu if version == 2 else fmu3) as archive:
        state = archive.read("extra/org.fmi-standard.fmi-ls-ref/settled.state")
    if version == 2:
        one = new().initialize()
        one.slave.setFMUstate(one.slave.deSerializeFMUstate(state))
    else:
        one = machine(event_mode=False, early_return=False, state=state)
    begin = one.get(*STATES)
    time, steps = 0.0, 40
    for i in range(steps):
        end = period * (i + 1) / steps
        one.step(time, end - time)
        time = end
    # Nine decimal places of the start values, and their decay within a period.
    assert np.abs(one.get(*STATES) - begin).max() < 1e-8


@pytest.mark.parametrize("solver, stop, interval, bound", [("CVode", 30.0, 0.5, 1e-6), ("Euler", 10.0, 1e-3, 0.02)])
def test_model_exchange_agrees_with_co_simulation(fmu3, solver, stop, interval, bound):
    """CVode at 1e-10; Euler, whose steps are the intervals, with an error of first order."""
    own = run(fmu3, {"block.s": 0.9, "block.v": 0.5}, stop)
    host = simulate_fmu(
        fmu3, fmi_type="ModelExchange", solver=solver, stop_time=stop, output_interval=interval, step_size=interval, relative_tolerance=1e-10,
        start_values={"block.s": 0.9, "block.v": 0.5}, output=list(RECORDED), record_events=False,
    )
    assert np.abs(values(own[-1], STATES[:3]) - values(host[-1], STATES[:3])).max() < bound
    assert values(own[-1], COUNTS).tolist() == values(host[-1], COUNTS).tolist()


def test_arrays_are_read_as_they_are_described(fmu, description3, tmp_path):
    """Arrays are in the archive on request, and in none of the main archives."""
    assert not [v.name for v in description3.modelVariables if v.dimensions]
    path = fmu.replace(".fmu", "-FMI3-arrays.fmu")
    description = fmpy.read_model_description(path)
    lengths = {v.name: [int(d.start) for d in v.dimensions] for v in description.modelVariables if v.dimensions}
    assert lengths == {"motion.s": [3], "motion.v": [3], "motion.a": [3], "step.transition": [6, 6], "step.response": [6, 12]}
    folder = fmpy.extract(path, unzipdir=str(tmp_path))
    one = Machine(folder, description, event_mode=False, early_return=False).initialize()
    one.step(0.0, 5.0)
    vector = one.slave.getFloat64([one.references["motion.s"]], nValues=3)
    assert list(vector) == one.get("box.s", "block.s", "secondary.s").tolist()
    one.slave.freeInstance()


@pytest.mark.parametrize("version", ["", "-FMI3"])
def test_euler_at_the_default_step_ends_the_default_experiment(fmu, version):
    """Model Exchange by Euler's method with the step of the description, as in a simple host."""
    path = fmu.replace(".fmu", f"{version}.fmu")
    experiment = fmpy.read_model_description(path).defaultExperiment
    rows = simulate_fmu(
        path, fmi_type="ModelExchange", solver="Euler", step_size=float(experiment.stepSize),
        output_interval=float(experiment.stepSize), output=["box.s", "block.s", "secondary.s", *COUNTS], record_events=False,
    )
    assert rows["time"][-1] == pytest.approx(float(experiment.stopTime))
    assert max(np.abs(rows[name]).max() for name in ("box.s", "block.s", "secondary.s")) < 5.0
    assert rows["impacts.upper"][-1] > 50


@pytest.mark.parametrize("logging", [False, True])
def test_why_a_value_is_discarded_is_said_where_logging_is_on(folder3, description3, logging, capfd):
    """FMI 3.0.2 (2.3.1) forbids messages if logging is off; the page explains how to switch it on."""
    said = []
    machine = FMU3Slave(
        guid=description3.guid, unzipDirectory=folder3, instanceName="machine",
        modelIdentifier=description3.coSimulation.modelIdentifier,
    )
    machine.instantiate(loggingOn=logging, logMessage=lambda *message: said.append(message[3]))
    machine.enterInitializationMode(startTime=0.0)
    references = {v.name: v.valueReference for v in description3.modelVariables}
    with pytest.raises(Exception):
        machine.setFloat64([references["stop.restitution"]], [1.5])
    machine.freeInstance()
    text = " ".join(message.decode() for message in said) + capfd.readouterr().out
    assert ("stop.restitution = 1.5: expected" in text) == logging, text
