"""maturin's build backend, preceded by a step that copies the FMU archives, the library for other machines and two pages into the package.

`cargo run --bin fmu-build` makes the files in `target/`; a source distribution contains them. Without them a package is complete except
for `fmu_path` and `fmu`, which then explain how to get the files; so missing files are skipped. If the environment variable
`VIBRO_IMPACT_ARCHIVES` names the folder, as in the build of a release, all files must exist.

The pages are for coding assistants, which find an installed package without its repository: AGENTS.md, and the page of all keys of a
machine's file, to which AGENTS.md links.
"""

import contextlib
import os
import shutil
from pathlib import Path

import maturin
from maturin import *  # noqa: F403 - the hooks of PEP 517 that need no change

ARCHIVES = ("VibroImpact3DOF.fmu", "VibroImpact3DOF-FMI3.fmu", "machine-kit.zip")
PAGES = ("AGENTS.md", "docs/machine-file.md")
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


@contextlib.contextmanager
def pages():
    """Copies the pages from the repository for the time of a build. The sources of a distribution have them in the package already."""
    copied = []
    for name in PAGES:
        inside = HERE / "package" / "vibro_impact" / name
        # A source distribution may lie in a project with an AGENTS.md of its own.
        if HERE.name == "python" and (HERE.parent / name).exists():
            inside.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(HERE.parent / name, inside)
            copied.append(inside)
        elif not inside.exists():
            raise SystemExit(f"{HERE.parent / name} and {inside} are missing: build from a clone or from a source distribution")
    try:
        yield
    finally:
        for path in copied:
            path.unlink()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    fetch_archives()
    with pages():
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    fetch_archives()
    with pages():
        return maturin.build_sdist(sdist_directory, config_settings)
