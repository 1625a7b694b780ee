"""Packs the cases as FMUs for FMI 2.0 and 3.0 into target/truth/: python truth/build.py [CASE ...]

The program `vibro` is the one that VIBRO names, of target/release or target/debug, or on PATH. Its library for machine files
(machine-kit.zip) is the one that --kit names, or one that `cargo run --bin fmu-build` has left under target/.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cases
from hosts import TARGET

ROOT = Path(__file__).resolve().parent.parent


def program():
    found = [os.environ.get("VIBRO"), ROOT / "target/release/vibro", ROOT / "target/debug/vibro", shutil.which("vibro")]
    for path in found:
        if path and Path(path).exists():
            return str(path)
    sys.exit("vibro is not built: run `cargo build --release -p vibro`, or name it in the environment variable VIBRO")


def kit(named):
    if named:
        return named
    found = sorted(ROOT.glob("target/**/machine-kit.zip"), key=lambda path: path.stat().st_mtime)
    if not found:
        sys.exit("machine-kit.zip is not built: run `cargo run --bin fmu-build`, or name it by --kit")
    return str(found[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="*", help="only these cases")
    parser.add_argument("--kit", help="prebuilt library for machine files")
    given = parser.parse_args()
    TARGET.mkdir(parents=True, exist_ok=True)
    chosen = given.case or cases.names()
    for name in chosen:
        for version in "23":
            command = [program(), "fmu", cases.FOLDER / name / "machine.toml", "--fmi", version, "--kit", kit(given.kit), "--out", TARGET]
            subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    print(f"{2 * len(chosen)} archives in {TARGET}")


if __name__ == "__main__":
    main()
