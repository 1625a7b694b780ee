"""maturin's build backend, with the FMU archives, and the library of those of other machines, put into the package first.

`cargo run --bin fmu-build` makes the archives in `target/`; they are copied from there, or from the folder that the environment
variable `VIBRO_IMPACT_ARCHIVES` names. A source distribution brings them along. Where that folder lacks them the build ends with the
command that makes them; `VIBRO_IMPACT_WITHOUT_ARCHIVES=1` builds a package without them, whose `fmu_path` and `Assembly.fmu` say what is missing.
"""

import os
import shutil
from pathlib import Path

import maturin
from maturin import *  # noqa: F403 - the hooks of PEP 517 that need nothing more

ARCHIVES = ("VibroImpact3DOF.fmu", "VibroImpact3DOF-FMI3.fmu", "machine-kit.zip")
HERE = Path(__file__).resolve().parent


def fetch_archives():
    """Copies the archives into the package; one that is missing is named with the command that makes it."""
    target = os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target")
    folder = Path(os.environ.get("VIBRO_IMPACT_ARCHIVES", target))
    inside = HERE / "package" / "vibro_impact" / "fmu"
    inside.mkdir(exist_ok=True)
    for name in ARCHIVES:
        if (folder / name).exists():
            shutil.copyfile(folder / name, inside / name)
        elif not (inside / name).exists():
            message = f"{folder / name} is missing: make it by `cargo run --bin fmu-build`"
            if os.environ.get("VIBRO_IMPACT_WITHOUT_ARCHIVES") != "1":
                raise SystemExit(message + ", or set VIBRO_IMPACT_WITHOUT_ARCHIVES=1 for a wheel without it")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    fetch_archives()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    fetch_archives()
    return maturin.build_sdist(sdist_directory, config_settings)
