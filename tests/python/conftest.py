"""Fixtures of the tests. `cargo test -p fmu-build --test python_package` sets the environment variables and installs the package."""

import json
import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def pytest_addoption(parser):
    parser.addoption("--minutes", type=float, default=0.0, help="how long any input is tried")


@pytest.fixture(scope="session")
def native():
    """Results of the library, written by fmu-build/tests/python_package.rs."""
    file = os.environ.get("VIBRO_IMPACT_NATIVE")
    assert file, "VIBRO_IMPACT_NATIVE names no file: run this through `cargo test -p fmu-build --test python_package`"
    return json.loads(Path(file).read_text())
