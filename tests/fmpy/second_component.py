"""Packs the bouncing ball of the doors' examples for both versions and runs it in FMPy: both interface types, and Event Mode.

`python second_component.py FOLDER LIBRARY`: the folder has `fmi2` and `fmi3` with a `modelDescription.xml` each
(`cargo run -p fmi-doors --example describe FOLDER`); `cargo build -p fmi-doors --example bouncing_ball` makes the library.
"""

import shutil
import sys
from pathlib import Path

import fmpy
import numpy as np
from fmpy.validation import validate_fmu

GRAVITY, RESTITUTION, HEIGHT = 9.81, 0.7, 1.0
END = 2.0
# Co-Simulation is exact up to rounding; CVode's tolerance is 1e-9 per step, for some two hundred
# steps.
ROUNDING, SOLVER = 1e-13, 1e-6

flights = 2.0 * np.sqrt(2.0 * HEIGHT / GRAVITY) * RESTITUTION ** np.arange(1, 40)
IMPACTS = np.sqrt(2.0 * HEIGHT / GRAVITY) + np.concatenate([[0.0], np.cumsum(flights)])


def height(time: float) -> float:
    """Height of the ball from the geometric series of its flights."""
    bounces = np.searchsorted(IMPACTS, time)
    if bounces == 0:
        return HEIGHT - 0.5 * GRAVITY * time**2
    since = time - IMPACTS[bounces - 1]
    return np.sqrt(2.0 * GRAVITY * HEIGHT) * RESTITUTION**bounces * since - 0.5 * GRAVITY * since**2


def pack(folder: Path, library: Path) -> Path:
    """The archive of a folder with the library."""
    version = fmpy.read_model_description(str(folder), validate=False).fmiVersion
    platform = fmpy.platform if version == "2.0" else fmpy.platform_tuple
    binaries = folder / "binaries" / platform
    binaries.mkdir(parents=True, exist_ok=True)
    shutil.copy(library, binaries / f"bouncing_ball{fmpy.sharedLibraryExtension}")
    archive = Path(shutil.make_archive(str(folder), "zip", folder))
    return archive.rename(archive.with_suffix(".fmu"))


def check(archive: Path, kind: str, tolerance: float, **how: bool) -> None:
    """A run compared with the closed form."""
    result = fmpy.simulate_fmu(
        str(archive), fmi_type=kind, stop_time=END, output_interval=0.01, relative_tolerance=1e-9, **how
    )
    # At the time of an impact, its last digit decides whether the ball has bounced.
    apart = np.min(np.abs(IMPACTS[:, None] - result["time"][None, :]), axis=0) > 1e-6
    expected = np.array([height(time) for time in result["time"]])
    error = np.max(np.abs(result["h"] - expected)[apart])
    assert error < tolerance, f"{archive.name} {kind} {how}: {error}"
    assert result["bounces"][-1] == np.searchsorted(IMPACTS, END), f"{archive.name} {kind} {how}"
    print(f"{archive.name} {kind} {how}: {error:.1e}")


def main(folder: Path, library: Path) -> None:
    for version in ["fmi2", "fmi3"]:
        archive = pack(folder / version, library)
        problems = validate_fmu(str(archive))
        assert not problems, problems
        check(archive, "CoSimulation", ROUNDING)
        check(archive, "ModelExchange", SOLVER)
        if version == "fmi3":
            check(archive, "CoSimulation", ROUNDING, use_event_mode=True)
            check(archive, "CoSimulation", ROUNDING, use_event_mode=True, early_return_allowed=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
