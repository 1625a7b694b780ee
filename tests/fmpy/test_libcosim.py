"""The FMU in libcosim (FMI Library's parser and calls); tests/hosts/run.py runs it in more hosts."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import STATES

# The specified bound. Half seconds are exact in binary and in libcosim's nanoseconds, so that
# only the build may differ.
SAME = 1e-10


@pytest.mark.skipif(importlib.util.find_spec("libcosimpy") is None, reason="libcosimpy has no package for this platform")
def test_equals_the_native_run(fmu, native, tmp_path):
    expected, output = native("libcosim"), tmp_path / "states.csv"
    script = Path(__file__).parents[1] / "hosts" / "drive_libcosimpy.py"
    # In a separate process, because it is another host.
    done = subprocess.run([sys.executable, script, fmu, "0.5", str(len(expected) - 1), output],
                          capture_output=True, text=True, timeout=300,
                          env={**os.environ, "NAMES": ",".join(STATES)})
    assert done.returncode == 0, done.stdout + done.stderr
    result = np.genfromtxt(output, delimiter=",", names=True, deletechars="")
    assert len(result) == len(expected) - 1 == 1200
    for name in STATES:
        np.testing.assert_allclose(result[name], expected[name][1:], rtol=0, atol=SAME)
    assert expected["impacts"][-1] > 100
