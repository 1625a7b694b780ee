"""The folders of the cases and their tables."""

import csv
import tomllib
from fractions import Fraction
from pathlib import Path

PAGE = Path("case").with_suffix(".md")  # of each case
FOLDER = Path(__file__).resolve().parent / "cases"


class Case:
    """A case's folder. `case.toml` has title, stop, steps, covers and what a failure means."""

    def __init__(self, name, folder=None):
        self.name = name
        self.folder = folder or FOLDER / name
        self.about = tomllib.loads((self.folder / "case.toml").read_text())
        self.stop = Fraction(self.about["stop"])
        self.steps = self.about["steps"]
        self.step = self.stop / self.steps

    def times(self):
        return [self.step * k for k in range(self.steps + 1)]

    @staticmethod
    def states(machine):
        return [f"{machine.bodies[i].name}.{way}" for i in machine.free() for way in "sv"]


def names():
    return sorted(path.parent.name for path in FOLDER.glob("*/case.toml"))


def read_truth(case):
    return list(csv.DictReader((case.folder / "truth.csv").read_text().splitlines()))


def read_events(case):
    return list(csv.DictReader((case.folder / "events.csv").read_text().splitlines()))
