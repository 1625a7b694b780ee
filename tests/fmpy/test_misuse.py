"""Bad values are refused with a message that names them, and change nothing."""

import ctypes
import math

import fmpy.fmi2
import numpy as np
import pytest
from conftest import STATES
from fmpy.fmi1 import FMICallException

ERROR = 3


def refused(instance, call, *words):
    """The call returns fmi2Error, and the log gives the reason in these words."""
    instance.log.clear()
    with pytest.raises(FMICallException) as problem:
        call()
    assert problem.value.status == ERROR
    errors = [message for status, category, message in instance.log if category == "logStatusError"]
    assert errors, instance.log
    for word in words:
        assert word in errors[-1], errors


BAD = [
    ("box.m", 0.0),
    ("block.m", -1.0),
    ("secondary.m", math.nan),
    ("stop.restitution", 1.5),
    ("stop.restitution", -0.1),
    ("stop.gap", 0.0),
    ("drive.frequency", math.inf),
    ("box.c", -1e-9),
]


@pytest.mark.parametrize("name,value", BAD)
def test_bad_parameter_is_refused_by_name(new, name, value):
    instance = new().enter()
    before = instance.get(name)
    refused(instance, lambda: instance.set(name, value), name, "expected")
    assert instance.get(name) == before
    instance.slave.exitInitializationMode()
    instance.step(0.0, 1.0)


def test_one_bad_value_of_several_changes_none(new):
    instance = new().enter()
    names = ("box.k", "stop.restitution")
    before = instance.get(*names)
    references = [instance.references[name] for name in names]
    refused(instance, lambda: instance.slave.setReal(references, [2.0, 7.0]), "stop.restitution")
    np.testing.assert_array_equal(instance.get(*names), before)


def test_block_outside_the_box_is_refused(new):
    instance = new()
    instance.set("block.s", 1.5)
    instance.enter()
    refused(instance, instance.slave.exitInitializationMode, "block.s", "stop.gap")
    instance.set("block.s", 0.5)
    instance.slave.exitInitializationMode()
    instance.step(0.0, 1.0)


def test_wrong_reference_is_refused(new):
    instance = new().initialize()
    refused(instance, lambda: instance.slave.getReal([99999]), "99999")
    refused(instance, lambda: instance.slave.getReal([instance.references["impacts.upper"]]), "impacts.upper")


def test_null_pointer_is_refused(new):
    instance = new().initialize()
    refused(instance, lambda: instance.slave.fmi2GetReal(instance.slave.component, None, 1, None), "null")


def test_wrong_guid_gives_no_instance(new):
    instance = new()
    slave = instance.slave
    instance.log.clear()
    for guid in (b"{00000000-0000-0000-0000-000000000000}", b""):
        component = slave.fmi2Instantiate(b"x", fmpy.fmi2.fmi2CoSimulation, guid, b"",
                                          ctypes.byref(instance._callbacks), 0, 1)
        assert not component
        assert "guid" in instance.log[-1][2].lower(), instance.log


def test_bad_steps_are_refused_and_leave_the_state(new, period):
    instance = new().initialize()
    instance.step(0.0, 5.3 * period)
    here, before = 5.3 * period, instance.get(*STATES)
    for point, size in [(here, -0.1), (here, math.nan), (here, math.inf), (math.nan, 0.1), (here + 0.5, 0.1)]:
        refused(instance, lambda: instance.step(point, size))
        np.testing.assert_array_equal(instance.get(*STATES), before)
    instance.step(here, 1e-14)
    instance.step(here, period)
    assert np.abs(instance.get(*STATES) - before).max() > 1e-3


def test_calls_out_of_order_are_refused(new):
    instance = new()
    refused(instance, lambda: instance.step(0.0, 0.1), "fmi2DoStep", "Instantiated")
    refused(instance, instance.slave.exitInitializationMode, "fmi2ExitInitializationMode")
    instance.initialize().step(0.0, 0.1)


def test_altered_state_is_refused(new):
    instance = new().initialize()
    state = instance.slave.getFMUstate()
    plain = instance.slave.serializeFMUstate(state)
    instance.slave.freeFMUstate(state)
    middle = len(plain) // 2
    altered = plain[:middle] + bytes([plain[middle] ^ 1]) + plain[middle + 1:]
    for wrong in (altered, plain[:-1], b"foreign" * 20):
        refused(instance, lambda: instance.slave.deSerializeFMUstate(wrong))
    instance.step(0.0, 0.1)


def test_impacts_are_logged_as_events(new, period):
    instance = new().initialize()
    instance.log.clear()
    instance.step(0.0, 20 * period)
    events = [message for status, category, message in instance.log if category == "logEvents"]
    impacts = sum(instance.count("impacts.upper", "impacts.lower"))
    assert impacts > 10
    assert sum("impact" in message.lower() for message in events) == impacts


def test_silence_when_logging_is_off(new, period):
    instance = new(logging=False).initialize()
    instance.step(0.0, 20 * period)
    assert instance.log == []
