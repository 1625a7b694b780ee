"""Shared parts of the example scripts: scaling of parameters, FMU instances with access by name, runs with fmpy, a picture."""

from __future__ import annotations

import math
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence, Union

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

if TYPE_CHECKING:
    from numpy.typing import NDArray

Value = Union[float, int, bool, str]
PathLike = Union[str, Path]


def fmi3_beside(fmu: PathLike) -> Path:
    """Returns the FMI 3.0 archive that is made next to an FMI 2.0 archive."""
    return Path(fmu).with_name("VibroImpact3DOF-FMI3.fmu")


#: Where `cargo run --bin fmu-build` puts the FMU, for FMI 2.0 and for FMI 3.0.
FMU = Path(__file__).parents[1] / "target" / "VibroImpact3DOF.fmu"
FMU3 = fmi3_beside(FMU)

#: Displacements (m) and velocities (m/s) of box, block and secondary oscillator.
STATES = ("box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v")

DISCARD = 2  # fmi2Discard


@dataclass(frozen=True)
class Scales:
    """Scales of the dimensionless model: m1 (kg), k1 (N/m) and the gap L (m)."""

    mass: float = 1.0
    stiffness: float = 1.0
    length: float = 1.0

    @property
    def frequency(self) -> float:
        """ω10 = sqrt(k1/m1), rad/s."""
        return math.sqrt(self.stiffness / self.mass)

    @property
    def time(self) -> float:
        """1/ω10, s."""
        return 1.0 / self.frequency


@dataclass(frozen=True)
class Groups:
    """The dimensionless groups of the paper, hats dropped; the defaults are the FMU's (a reconstruction)."""

    epsilon: float = 0.1  # m2/m1
    kappa: float = 0.75  # restitution coefficient
    f10: float = 1.5  # F10/(k1 L ε)
    sigma1: float = 0.4  # ω1/ω10 = 1 + ε σ1
    gamma1: float = 1.0  # c1/(m1 ω10 ε)
    beta2: float = 0.06  # k23/(m2 ω10²)
    sigma30: float = 0.0  # k3/(m3 ω10²) = 1 + ε σ30
    gamma3: float = 0.6  # c3/(m3 ω10 ε)
    mu13: float = 10.0  # m1/m3

    def parameters(self, scales: Scales = Scales()) -> dict[str, float]:
        """Returns the start values of the FMU (SI) for these groups."""
        m1, k1, omega10 = scales.mass, scales.stiffness, scales.frequency
        m2, m3 = self.epsilon * m1, m1 / self.mu13
        return {
            "box.m": m1,
            "box.k": k1,
            "box.c": self.gamma1 * m1 * omega10 * self.epsilon,
            "block.m": m2,
            "secondary.m": m3,
            "secondary.k": (1.0 + self.epsilon * self.sigma30) * m3 * omega10**2,
            "secondary.c": self.gamma3 * m3 * omega10 * self.epsilon,
            "coupling.k": self.beta2 * m2 * omega10**2,
            "stop.gap": scales.length,
            "stop.restitution": self.kappa,
            "drive.amplitude": self.f10 * k1 * scales.length * self.epsilon,
            "drive.frequency": (1.0 + self.epsilon * self.sigma1) * omega10,
        }

    @classmethod
    def of(cls, p: Mapping[str, float]) -> Groups:
        """Returns the groups of a set of SI parameters; box.k must not be 0."""
        omega10 = math.sqrt(p["box.k"] / p["box.m"])
        epsilon = p["block.m"] / p["box.m"]
        return cls(
            epsilon=epsilon,
            kappa=p["stop.restitution"],
            f10=p["drive.amplitude"] / (p["box.k"] * p["stop.gap"] * epsilon),
            sigma1=(p["drive.frequency"] / omega10 - 1.0) / epsilon,
            gamma1=p["box.c"] / (p["box.m"] * omega10 * epsilon),
            beta2=p["coupling.k"] / (p["block.m"] * omega10**2),
            sigma30=(p["secondary.k"] / (p["secondary.m"] * omega10**2) - 1.0) / epsilon,
            gamma3=p["secondary.c"] / (p["secondary.m"] * omega10 * epsilon),
            mu13=p["box.m"] / p["secondary.m"],
        )

    def __str__(self) -> str:
        return ", ".join(f"{name} = {value:.6g}" for name, value in asdict(self).items())


class Slave:
    """A co-simulation instance of any FMI 2.0 FMU, with access by name; use it in `with`, which removes all its files."""

    def __init__(
        self, fmu: PathLike, start: Mapping[str, Value] | None = None, time: float = 0.0, name: str = "instance"
    ) -> None:
        description = fmpy.read_model_description(str(fmu))
        self._variables = {v.name: v for v in description.modelVariables}
        self._folder = fmpy.extract(str(fmu))
        self._slave: Any = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self._slave.instantiate()
        self._slave.setupExperiment(startTime=time)
        for variable, value in (start or {}).items():
            self.set(variable, value)
        self._slave.enterInitializationMode()
        self._slave.exitInitializationMode()
        #: Number of computed steps.
        self.steps = 0

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, *_: object) -> None:
        self._slave.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _reference(self, name: str) -> int:
        if name not in self._variables:
            raise KeyError(f"the FMU has no variable {name}")
        return int(self._variables[name].valueReference)

    def set(self, name: str, value: Value) -> None:
        """Sets a parameter, start value or input."""
        references = [self._reference(name)]
        kind = self._variables[name].type
        if kind == "Real":
            self._slave.setReal(references, [float(value)])
        elif kind == "Boolean":
            self._slave.setBoolean(references, [bool(value)])
        else:
            self._slave.setInteger(references, [int(value)])

    def set_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        """Sets the time derivatives of an input, of orders 1, 2, …, at the communication point."""
        references = [self._reference(name)] * len(derivatives)
        orders = list(range(1, len(derivatives) + 1))
        self._slave.setRealInputDerivatives(references, orders, list(derivatives))

    def get(self, name: str) -> float:
        """Returns the value of a variable."""
        references = [self._reference(name)]
        kind = self._variables[name].type
        if kind == "Real":
            return float(self._slave.getReal(references)[0])
        if kind == "Boolean":
            return float(self._slave.getBoolean(references)[0])
        return float(self._slave.getInteger(references)[0])

    def reals(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Returns several Real variables in one call."""
        return np.array(self._slave.getReal([self._reference(name) for name in names]))

    def derivative(self, unknown: str, known: str) -> float:
        """Returns ∂unknown/∂known at the communication point, by fmi2GetDirectionalDerivative."""
        references = [self._reference(unknown)], [self._reference(known)]
        return float(self._slave.getDirectionalDerivative(*references, [1.0])[0])

    def step(self, time: float, size: float) -> float:
        """Computes a step; returns the time reached, which is earlier than the end if the FMU discards the rest (`stopAtImpact`).

        FMI 2.0 (4.2.4) does not allow a step after a discarded one: restore a state saved before it. This FMU can also continue
        from the time reached.
        """
        self.steps += 1
        try:
            self._slave.doStep(currentCommunicationPoint=time, communicationStepSize=size)
        except FMICallException as error:
            if error.status != DISCARD:
                raise
            return float(self._slave.getRealStatus(DISCARD))  # fmi2LastSuccessfulTime has the same number
        return time + size

    def save(self) -> Any:
        """Returns the complete state; `free` releases it."""
        return self._slave.getFMUstate()

    def restore(self, state: Any) -> None:
        """Returns to a saved state."""
        self._slave.setFMUstate(state)

    def free(self, state: Any) -> None:
        """Frees a saved state."""
        self._slave.freeFMUstate(state)


class EventSlave:
    """A co-simulation instance of an FMI 3.0 FMU whose events the master handles: a step ends before an event, which is then
    handled in Event Mode. Access is by name; use it in `with`, which removes all its files."""

    def __init__(
        self,
        fmu: PathLike,
        start: Mapping[str, Value] | None = None,
        time: float = 0.0,
        name: str = "instance",
        driven: Sequence[str] = (),
    ) -> None:
        """Enters Event Mode, as FMI 3.0 requires. `driven` inputs follow `courses` inside a step; other inputs are held."""
        description = fmpy.read_model_description(str(fmu))
        self._variables = {v.name: v for v in description.modelVariables}
        self._folder = fmpy.extract(str(fmu))
        #: Value of each driven input as a function of time.
        self.courses: dict[str, Callable[[float], float]] = {}
        #: Number of computed steps.
        self.steps = 0
        self._slave: Any = FMU3Slave(
            guid=description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self._slave.instantiate(
            eventModeUsed=True,
            earlyReturnAllowed=True,
            intermediateUpdate=self._inside_a_step if driven else None,
            requiredIntermediateVariables=[self._reference(variable) for variable in driven],
        )
        for variable, value in (start or {}).items():
            self.set(variable, value)
        self._slave.enterInitializationMode(startTime=time)
        self._slave.exitInitializationMode()

    def __enter__(self) -> EventSlave:
        return self

    def __exit__(self, *_: object) -> None:
        self._slave.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _reference(self, name: str) -> int:
        if name not in self._variables:
            raise KeyError(f"the FMU has no variable {name}")
        return int(self._variables[name].valueReference)

    def _inside_a_step(self, _environment: Any, time: float, set_requested: bool, *_: Any) -> None:
        """The intermediate update (FMI 3.0, 4.2.2): the FMU asks for the inputs at times inside the step."""
        if set_requested:
            for name, course in self.courses.items():
                self.set(name, course(time))

    def set(self, name: str, value: Value) -> None:
        """Sets a parameter, start value or input."""
        references = [self._reference(name)]
        kind = self._variables[name].type
        if kind == "Float64":
            self._slave.setFloat64(references, [float(value)])
        elif kind == "Boolean":
            self._slave.setBoolean(references, [bool(value)])
        else:
            self._slave.setInt64(references, [int(value)])

    def get(self, name: str) -> float:
        """Returns the value of a variable."""
        references = [self._reference(name)]
        kind = self._variables[name].type
        if kind == "Float64":
            return float(self._slave.getFloat64(references)[0])
        if kind == "Boolean":
            return float(self._slave.getBoolean(references)[0])
        if kind == "Int32":
            return float(self._slave.getInt32(references)[0])
        return float(self._slave.getInt64(references)[0])

    def reals(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Returns several Float64 variables in one call."""
        return np.array(self._slave.getFloat64([self._reference(name) for name in names]))

    def step(self, time: float, size: float) -> tuple[float, bool]:
        """Computes a step; returns the time reached and whether an event must be handled there before the next step."""
        self.steps += 1
        event, _, early, reached = self._slave.doStep(currentCommunicationPoint=time, communicationStepSize=size)
        return (float(reached) if early else time + size), bool(event)

    def enter_event_mode(self) -> None:
        """Enters Event Mode, in which the variables have their values after the event."""
        self._slave.enterEventMode()

    def update_discrete_states(self) -> float:
        """Executes the event; returns the time of the next event if it is known now, else infinity."""
        *_, known, time = self._slave.updateDiscreteStates()
        return float(time) if known else math.inf

    def enter_step_mode(self) -> None:
        """Leaves Event Mode, so that steps can be computed again."""
        self._slave.enterStepMode()


def start_values(fmu: PathLike = FMU) -> dict[str, float]:
    """Returns the start values of the FMU's Real parameters, without their aliases of FMI 3.0."""
    description = fmpy.read_model_description(str(fmu))
    named = {v.valueReference: v for v in reversed(description.modelVariables)}  # an alias follows its variable
    return {
        v.name: float(v.start)
        for v in reversed(named.values())
        if v.causality == "parameter" and v.type in ("Real", "Float64")
    }


def simulate(
    fmu: PathLike,
    start: Mapping[str, Value],
    periods: float,
    per_period: int = 100,
    output: Sequence[str] = (*STATES, "stop.s", "stop.v", "impacts.upper", "impacts.lower"),
) -> Any:
    """Runs some drive periods with fmpy; returns its structured array, with times in s."""
    period = 2.0 * math.pi / float(start.get("drive.frequency", start_values(fmu)["drive.frequency"]))
    return fmpy.simulate_fmu(
        str(fmu),
        stop_time=periods * period,
        output_interval=period / per_period,  # a reporting interval, not an integration step
        start_values=dict(start),
        output=list(output),
        fmi_type="CoSimulation",
    )


#: Colours of box, block and secondary oscillator in all pictures of this project; in grey they differ by lightness.
COLOURS = {"box": "#004696", "block": "#c84b00", "secondary": "#14a073"}


def plot(result: Any, period: float, path: PathLike) -> None:
    """Draws time histories and the block's motion between the stops."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (history, relative) = pyplot.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    for body, colour in COLOURS.items():
        history.plot(result["time"] / period, result[f"{body}.s"], color=colour, label=body)
    history.set(xlabel="time t/T (–)", ylabel="displacement (m)")
    figure.legend(loc="outside upper left", ncols=3, frameon=False)
    relative.plot(result["stop.s"], result["stop.v"], ".", markersize=2, color=COLOURS["block"])
    relative.set(xlabel="block in the box w (m)", ylabel="dw/dt (m/s)")
    relative.locator_params(axis="x", nbins=5)
    figure.savefig(str(path), dpi=150)
    pyplot.close(figure)
