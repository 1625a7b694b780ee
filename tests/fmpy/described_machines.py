"""Runs archives of described machines in FMPy: unchanged and bit-identical to the engine, by CVode, and with a parameter set.

`python described_machines.py FOLDER NAME... -- NAME...`: the folder has `NAME.fmu`, `NAME-FMI3.fmu` and `NAME.csv`, the engine's motion.
Machines after the dashes are only run bit for bit in Co-Simulation.
"""

import sys
from pathlib import Path

import fmpy
import numpy as np
from fmpy.validation import validate_fmu

# Rounding in a tenth of a second of the fall of a ball.
ROUNDING = 1e-14
# CVode's relative tolerance, and the accepted difference relative to each variable's largest value:
# errors grow from event to event, and a flank of 200 MN/m amplifies them.
TOLERANCE = 1e-10
EXCHANGE = 1e-5
# Fraction of the run that is also made in Model Exchange by CVode.
PART = 0.1


def check(archive: Path, expected: np.ndarray, **how: bool) -> None:
    """A run at the communication points of the description, compared with the engine's motion."""
    names = list(expected.dtype.names[1:])
    result = fmpy.simulate_fmu(
        str(archive),
        fmi_type="CoSimulation",
        stop_time=expected["time"][-1],
        output_interval=expected["time"][1],
        output=names,
        **how,
    )
    if how:
        # Events are then separate points, and split the steps in which sums are rounded.
        assert len(result) >= len(expected), f"{archive.name} {how}: {len(result)}"
        return
    assert len(result) == len(expected), f"{archive.name}: {len(result)}"
    for name in names:
        different = np.flatnonzero(result[name] != expected[name])
        assert not len(different), f"{archive.name} {name}: {len(different)} from {expected['time'][different[0]]}"


def check_exchange(archive: Path, expected: np.ndarray) -> None:
    """The first part of the run in Model Exchange, compared with the engine's motion."""
    count = int(PART * len(expected))
    names = [name for name in expected.dtype.names[1:] if not name.endswith(".a")]
    result = fmpy.simulate_fmu(
        str(archive),
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=TOLERANCE,
        stop_time=expected["time"][count - 1],
        output_interval=expected["time"][1],
        output=names,
    )
    # The last row at an event's time is the state after the event.
    last = dict(zip(result["time"], result))
    rows = [last[time] for time in expected["time"][:count]]
    for name in names:
        exact = expected[name][:count]
        error = max(abs(row[name] - value) for row, value in zip(rows, exact))
        assert error <= EXCHANGE * max(abs(exact)), f"{archive.name} {name}: {error} of {max(abs(exact))}"


def check_parameter(archive: Path) -> None:
    """A ball that starts at another height."""
    result = fmpy.simulate_fmu(
        str(archive), start_values={"gravity": 1.62}, stop_time=0.1, output_interval=0.1, output=["ball.s"]
    )
    error = abs(result["ball.s"][-1] - 0.5 * 1.62 * 0.1**2)
    assert error < ROUNDING, f"{archive.name}: {error}"


def check_arrays(archive: Path) -> None:
    """The derivatives over a step of a ball that falls freely."""
    description = fmpy.read_model_description(str(archive))
    variables = {variable.name: variable for variable in description.modelVariables}
    shape = [int(dimension.start) for dimension in variables["step.transition"].dimensions]
    assert shape == [2, 2], shape
    unzipped = fmpy.extract(str(archive))
    fmu = fmpy.instantiate_fmu(unzipped, description, fmi_type="CoSimulation")
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.doStep(0.0, 0.25)
    found = fmu.getFloat64([variables["step.transition"].valueReference], nValues=4)
    assert np.allclose(found, [1.0, 0.25, 0.0, 1.0], rtol=0, atol=ROUNDING), found
    fmu.terminate()
    fmu.freeInstance()


def main(folder: Path, names: list[str], stepped: list[str]) -> None:
    for name in names + stepped:
        expected = np.genfromtxt(folder / f"{name}.csv", delimiter=",", names=True, deletechars="")
        for suffix in ["", "-FMI3"]:
            archive = folder / f"{name}{suffix}.fmu"
            problems = validate_fmu(str(archive))
            assert not problems, problems
            check(archive, expected)
            if name in stepped:
                continue
            check_exchange(archive, expected)
            if suffix:
                check(archive, expected, use_event_mode=True)
                check(archive, expected, use_event_mode=True, early_return_allowed=True)
            print(archive.name)
    check_arrays(folder / "bouncing_ball-FMI3-arrays.fmu")
    for suffix in ["", "-FMI3"]:
        check_parameter(folder / f"bouncing_ball{suffix}.fmu")


if __name__ == "__main__":
    dashes = sys.argv.index("--")
    main(Path(sys.argv[1]), sys.argv[2:dashes], sys.argv[dashes + 1 :])
