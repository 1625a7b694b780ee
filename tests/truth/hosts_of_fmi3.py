"""A master of FMI 3.0 Co-Simulation with fmpy, rightly or with one fault in its handling of events."""

import shutil
from decimal import Decimal

import fmpy
from fmpy.fmi3 import FMU3Slave


def rows(archive, names, steps, step, fault=""):
    """Rows of the output times. Faults: `ignores early return`, `never enters event mode`."""
    folder = fmpy.extract(archive)
    description = fmpy.read_model_description(archive)
    references = {v.name: v.valueReference for v in description.modelVariables}
    wanted = [references[name] for name in names]
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier,
                    instanceName="machine")
    out = []
    try:
        fmu.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
        fmu.enterInitializationMode(startTime=0.0)
        fmu.exitInitializationMode()
        update(fmu)
        fmu.enterStepMode()
        write = lambda t: out.append((Decimal(repr(t)), dict(zip(names, (Decimal(repr(x)) for x in fmu.getFloat64(wanted))))))
        write(0.0)
        for k in range(steps):
            time, end = k * step, (k + 1) * step
            while time < end:
                event, _, early, reached = fmu.doStep(currentCommunicationPoint=time, communicationStepSize=end - time)
                time = reached if early and fault != "ignores early return" else end
                if event and fault != "never enters event mode":
                    fmu.enterEventMode()
                    update(fmu)
                    fmu.enterStepMode()
            write(end)
    finally:
        fmu.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)
    return out


def update(fmu):
    while fmu.updateDiscreteStates()[0]:
        pass
