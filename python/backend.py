"""maturin's build backend, preceded by a step that copies the FMU archives and the library for other machines into the package.

`cargo run --bin fmu-build` makes the files in `target/`; a source distribution contains them. Without them a package is complete except
for `fmu_path` and `fmu`, which then explain how to get the files; so missing files are skipped. If the environment variable
`VIBRO_IMPACT_ARCHIVES` names the folder, as in the build of a release, all files must exist.
"""

import os
import shutil
from pathlib import Path

import maturin
from maturin import *  # noqa: F403 - the hooks of PEP 517 that need no change

ARCHIVES = ("VibroImpact3DOF.fmu", "VibroImpact3DOF-FMI3.fmu", "machine-kit.zip")
HERE = Path(__file__).resolve().parent


def fetch_archives():
    """Copies the archives into the package, and lists missing ones."""
    named = os.environ.get("VIBRO_IMPACT_ARCHIVES")
    folder = Path(named or os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target"))
    inside = HERE / "package" / "vibro_impact" / "fmu"
    inside.mkdir(exist_ok=True)
    for name in ARCHIVES:
        if (folder / name).exists():
            shutil.copyfile(folder / name, inside / name)
        elif not (inside / name).exists():
            if named:
                raise SystemExit(f"{folder / name} is missing: build it with `cargo run --bin fmu-build`")
            print(f"{name} is left out: it is not in {folder}; build it with `cargo run --bin fmu-build`")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    fetch_archives()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    fetch_archives()
    return maturin.build_sdist(sdist_directory, config_settings)
