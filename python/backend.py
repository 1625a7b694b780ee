"""maturin's build backend, which first puts the FMU archives, and the library of those of other machines, into the package.

They are copied from `target/`, where `cargo run --bin fmu-build` makes them; a source distribution brings them along. A package is
complete without them but for `fmu_path` and `fmu`, which then say how to get them: so those that are missing are left out. Where the
environment variable `VIBRO_IMPACT_ARCHIVES` names the folder, as the build of a release does, it must have all of them.
"""

import os
import shutil
from pathlib import Path

import maturin
from maturin import *  # noqa: F403 - the hooks of PEP 517 that need nothing more

ARCHIVES = ("VibroImpact3DOF.fmu", "VibroImpact3DOF-FMI3.fmu", "machine-kit.zip")
HERE = Path(__file__).resolve().parent


def fetch_archives():
    """Copies the archives into the package, and names those that are left out."""
    named = os.environ.get("VIBRO_IMPACT_ARCHIVES")
    folder = Path(named or os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target"))
    inside = HERE / "package" / "vibro_impact" / "fmu"
    inside.mkdir(exist_ok=True)
    for name in ARCHIVES:
        if (folder / name).exists():
            shutil.copyfile(folder / name, inside / name)
        elif not (inside / name).exists():
            if named:
                raise SystemExit(f"{folder / name} is missing: make it by `cargo run --bin fmu-build`")
            print(f"{name} is left out: it is not in {folder}, where `cargo run --bin fmu-build` makes it")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    fetch_archives()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    fetch_archives()
    return maturin.build_sdist(sdist_directory, config_settings)
