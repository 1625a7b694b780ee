"""The FMU archives inside the package, and the kit that makes FMUs of other machines."""

from __future__ import annotations

import os
from pathlib import Path

from ._arguments import whole

_NAMES = {2: "VibroImpact3DOF.fmu", 3: "VibroImpact3DOF-FMI3.fmu"}


def fmu_path(version: int = 2) -> Path:
    """Returns the path of the prebuilt FMU of FMI 2.0 (version 2) or FMI 3.0 (version 3), for FMPy and other hosts.

    Raises
    ------
    ValueError, TypeError
        For another version.
    FileNotFoundError
        If the package was built without the archives; the message explains how to get them.
    """
    return _inside(_NAMES[whole("version", version, 2, 3)])


def kit_path() -> Path:
    """Returns the path of the kit: the library that serves all described machines, with its licences."""
    return _inside("machine-kit.zip")


def _inside(name: str) -> Path:
    """Returns the path of a file in the package, or in the folder named by the environment variable `VIBRO_IMPACT_ARCHIVES`."""
    own = Path(__file__).with_name("fmu") / name
    named = os.environ.get("VIBRO_IMPACT_ARCHIVES")
    for path in [own] + ([Path(named) / name] if named else []):
        if path.exists():
            return path
    raise FileNotFoundError(
        f"{own} is missing: this package was built without it. The wheel of a release contains it. In the repository, `cargo run --bin fmu-build` "
        "builds it in target/: then set VIBRO_IMPACT_ARCHIVES to that folder, or build the package again with `pip install ./python`"
    )
