"""Fixtures of the tests. `cargo test` sets the two environment variables; to run by hand, build the FMU first."""

import os
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

STATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")


@pytest.fixture(scope="session")
def fmu() -> str:
    """Path of the packaged FMU."""
    default = Path(__file__).parents[2] / "target" / "fmu-test" / "VibroImpact3DOF.fmu"
    path = Path(os.environ.get("VIBRO_IMPACT_FMU", default))
    assert path.exists(), f"{path} is missing: build it with `cargo test`"
    return str(path)


@pytest.fixture(scope="session")
def fmu3(fmu) -> str:
    """Path of the packaged FMU of FMI 3.0, which is next to the FMI 2.0 FMU."""
    return fmu.replace(".fmu", "-FMI3.fmu")


@pytest.fixture(scope="session")
def description3(fmu3):
    return fmpy.read_model_description(fmu3)


@pytest.fixture(scope="session")
def native():
    """Native states by name of the communication step (written by tests/fmpy.rs)."""
    folder = os.environ.get("VIBRO_IMPACT_NATIVE")
    assert folder, "VIBRO_IMPACT_NATIVE names no folder: run this through `cargo test --test fmpy`"
    return lambda name: np.genfromtxt(Path(folder) / f"{name}.csv", delimiter=",", names=True, deletechars="")


@pytest.fixture(scope="session")
def description(fmu):
    return fmpy.read_model_description(fmu)


@pytest.fixture(scope="session")
def period(description) -> float:
    """Drive period of the start values, in s."""
    start = {v.name: v.start for v in description.modelVariables}
    return 2.0 * np.pi / float(start["drive.frequency"])


class Instance:
    """An instance with access by name, and its log messages."""

    def __init__(self, folder, description, name, logging=True):
        self.log = []
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._logged)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._callbacks = callbacks  # the FMU keeps a pointer to it
        self.slave.instantiate(callbacks=callbacks, loggingOn=logging)

    def _logged(self, environment, name, status, category, message):
        self.log.append((status, category.decode(), message.decode()))

    def enter(self):
        """Enters initialization mode, where start values can be set and read."""
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        return self

    def initialize(self):
        self.enter().slave.exitInitializationMode()
        return self

    def get(self, *names):
        return np.array(self.slave.getReal([self.references[n] for n in names]))

    def count(self, *names):
        return self.slave.getInteger([self.references[n] for n in names])

    def set(self, name, value):
        self.slave.setReal([self.references[name]], [value])

    def step(self, time, size):
        self.slave.doStep(currentCommunicationPoint=time, communicationStepSize=size)


@pytest.fixture(scope="session")
def folder(fmu, tmp_path_factory):
    return fmpy.extract(fmu, unzipdir=str(tmp_path_factory.mktemp("fmu")))


@pytest.fixture
def new(folder, description):
    """Makes instances, and frees them after the test."""
    made = []

    def make(name="instance", **options):
        made.append(Instance(folder, description, name, **options))
        return made[-1]

    yield make
    for instance in made:
        instance.slave.freeInstance()
