"""The FMU archives inside the package, and the kit that makes FMUs of other machines."""

from __future__ import annotations

from pathlib import Path

from ._arguments import whole

_NAMES = {2: "VibroImpact3DOF.fmu", 3: "VibroImpact3DOF-FMI3.fmu"}


def fmu_path(version: int = 2) -> Path:
    """The path of the FMU of FMI 2.0 (version 2) or FMI 3.0 (version 3), for FMPy and any other host; both hold this package's engine.

    Raises
    ------
    ValueError, TypeError
        For another version.
    FileNotFoundError
        Where the package was built without the archives.
    """
    return _inside(_NAMES[whole("version", version, 2, 3)])


def kit_path() -> Path:
    """The path of the kit: the library that serves all described machines, with its licences."""
    return _inside("machine-kit.zip")


def _inside(name: str) -> Path:
    path = Path(__file__).with_name("fmu") / name
    if not path.exists():
        raise FileNotFoundError(
            f"{path} is missing: the package was built without it. Make it by `cargo run --bin fmu-build` and build the "
            "package again by `pip install ./python`"
        )
    return path
