"""The WebAssembly component in an archive, run by wasmtime, against the native library in the same archive, run by FMPy."""

import os
import sys
from ctypes import c_double
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Model, FMU3Slave

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "truth"))
from component import Archive, Instance, Refused  # noqa: E402

# The native library calls the platform's sine and exponential, the component Rust's: they differ by
# a rounding, and impacts multiply this difference.
SAME = 1e-13
STEP, STEPS = 0.01, 100


@pytest.fixture(scope="module")
def path():
    return Path(os.environ["COMPONENT_ARCHIVE"])


@pytest.fixture(scope="module")
def archive(path):
    return Archive(path)


@pytest.fixture(scope="module")
def description(path):
    return read_model_description(str(path))


@pytest.fixture(scope="module")
def native(path, description, tmp_path_factory):
    folder = extract(str(path), str(tmp_path_factory.mktemp("unpacked")))

    def made(kind):
        identifier = description.coSimulation.modelIdentifier
        own = kind(
            guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="native"
        )
        own.instantiate()
        return own

    return made


def floats(description):
    kept = ("output", "local")
    return [own.valueReference for own in description.modelVariables if own.type == "Float64" and own.causality in kept]


def slave(archive, description, **others):
    early = others.get("update") is not None
    return Instance(
        archive, "co-simulation", "one", description.guid, False, True, False, early, [], **others
    )


def begun(instance):
    instance.enter_initialization_mode(None, 0.0, None)
    instance.exit_initialization_mode()
    return instance


def differ(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return np.max(np.abs(a - b) / np.maximum(1.0, np.abs(b)))


def test_second_method_steps_of_the_native_library(archive, description, native):
    ours, other = slave(archive, description), native(FMU3Slave)
    other.enterInitializationMode()
    other.exitInitializationMode()
    begun(ours)
    all_floats = floats(description)
    for k in range(STEPS):
        ours.do_step(k * STEP, STEP, True)
        other.doStep(k * STEP, STEP)
        assert differ(ours.get_float64(all_floats), other.getFloat64(all_floats)) < SAME, k
    whole = [own.valueReference for own in description.modelVariables if own.type == "Int32"]
    assert not whole or ours.get_int32(whole) == list(other.getInt32(whole))
    # Events are logged, and no call is refused.
    assert {message[1:3] for message in ours.log} == {("ok", "logEvents")}


def test_second_method_states_of_the_native_library_in_model_exchange(archive, description, native):
    ours = Instance(archive, "model-exchange", "one", description.guid, False, True)
    other = native(FMU3Model)
    other.enterInitializationMode()
    other.exitInitializationMode()
    begun(ours)
    ours.update_discrete_states()
    other.updateDiscreteStates()
    ours.enter_continuous_time_mode()
    other.enterContinuousTimeMode()
    size = ours.get_number_of_continuous_states()
    count = ours.get_number_of_event_indicators()
    assert (size, count) == (other.getNumberOfContinuousStates(), other.getNumberOfEventIndicators())
    for time in (0.0, 1e-3, 2e-3):
        states = [1e-3 * (k + 1) * (1.0 + time) for k in range(size)]
        ours.set_time(time)
        other.setTime(time)
        ours.set_continuous_states(states)
        array = (c_double * size)(*states)
        other.setContinuousStates(array, size)
        rates, indicators = (c_double * size)(), (c_double * count)()
        other.getContinuousStateDerivatives(rates, size)
        other.getEventIndicators(indicators, count)
        assert differ(ours.get_continuous_state_derivatives(), list(rates)) < SAME
        assert differ(ours.get_event_indicators(), list(indicators)) < SAME
    assert ours.get_nominals_of_continuous_states() and ours.get_continuous_states() == states


def test_invariant_a_restored_state_has_the_same_future(archive, description):
    ours, outputs = begun(slave(archive, description)), floats(description)
    ours.do_step(0.0, 0.3, False)
    saved = ours.get_fmu_state()
    ours.do_step(0.3, 0.3, False)
    first = ours.get_float64(outputs)
    ours.set_fmu_state(saved)
    ours.do_step(0.3, 0.3, False)
    assert ours.get_float64(outputs) == first
    with pytest.raises(Refused, match="error"):
        ours.set_fmu_state(saved[:-1])


def test_invariant_the_host_is_asked_within_a_step_and_ends_it(archive, description):
    asked = []

    def update(time, set_requested, get_allowed, finished, can_return_early):
        asked.append((time, can_return_early))
        return (can_return_early, time)

    ours = begun(slave(archive, description, update=update))
    found = ours.do_step(0.0, 1.0, False)
    time = getattr(found, "last-successful-time")
    assert getattr(found, "early-return") and time < 1.0 and asked[-1] == (time, True)


def test_invariant_errors_have_messages_and_statuses(archive, description):
    wrong = Instance(archive, "co-simulation", "one", "{wrong}", False, True, False, False, [])
    assert wrong.handle is None and "{wrong}" in wrong.log[0][3]
    absent = slave(archive, description, files={})
    assert absent.handle is None and "machine.toml" in absent.log[0][3] and "no file" in absent.log[0][3]
    ours = begun(slave(archive, description))
    with pytest.raises(Refused, match="error"):
        ours.get_float64([10**6])
    name, status, category, message = ours.log[-1]
    assert (name, status, category) == ("one", "error", "logStatusError") and "1000000" in message
    with pytest.raises(Refused, match="error"):
        ours.get_string([1])
    with pytest.raises(Refused, match="error"):
        ours.set_input_derivatives([(1, 1)], [0.0])
    # After an error an instance can be reset (FMI 3.0.2, 2.3.1).
    ours.reset()
    begun(ours).do_step(0.0, 0.1, True)

