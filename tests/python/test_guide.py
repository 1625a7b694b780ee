"""The Python blocks of docs/python.md, docs/derivatives.md, AGENTS.md and python/package/README.md run, print the shown text, and draw the shown pictures.

`VIBRO_IMPACT_UPDATE=1` rewrites the pictures.
"""

import contextlib
import io
import os
import re
import shutil
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from conftest import ROOT

matplotlib.use("agg")

# Mean difference of a picture relative to full brightness: chaotic motions, and so their dots,
# differ between processors.
SAME_PICTURE = 0.02


def blocks(page):
    """Language, file name if any, and text of each block."""
    return re.findall(r"```(\w*)(?: (\S+))?\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)


def run(page, folder):
    names, printed, count = {}, None, 0
    with contextlib.chdir(folder) if hasattr(contextlib, "chdir") else _folder(folder):
        for language, file, text in blocks(page):
            if file == "no-run":
                continue
            if file:
                Path(file).write_text(text, encoding="utf-8")
            elif language == "python":
                out = io.StringIO()
                with contextlib.redirect_stdout(out):
                    exec(compile(text, f"block {count} of {page}", "exec"), names)
                printed, count = out.getvalue(), count + 1
            elif language == "text":
                assert printed == text, f"{page} says\n{text}\nand the block prints\n{printed}"
    return count


@contextlib.contextmanager
def _folder(path):
    before = Path.cwd()
    os.chdir(path)
    try:
        yield
    finally:
        os.chdir(before)


@pytest.mark.parametrize(("page", "least"), [("python", 8), ("derivatives", 6)])
def test_a_page_prints_and_draws_what_it_shows(page, least, tmp_path):
    (tmp_path / page).mkdir()
    assert run(f"docs/{page}.md", tmp_path) >= least
    made = {path.name for path in (tmp_path / page).iterdir()}
    shown = set(re.findall(rf"\]\({page}/(\w+\.png)\)", (ROOT / f"docs/{page}.md").read_text(encoding="utf-8")))
    assert made == shown
    kept = os.environ.get("VIBRO_IMPACT_PICTURES")
    for name in made:
        if kept:
            Path(kept).mkdir(exist_ok=True)
            shutil.copy(tmp_path / page / name, kept)
        committed = ROOT / "docs" / page / name
        if os.environ.get("VIBRO_IMPACT_UPDATE") == "1":
            committed.parent.mkdir(exist_ok=True)
            shutil.copy(tmp_path / page / name, committed)
        before, now = (matplotlib.image.imread(path) for path in (committed, tmp_path / page / name))
        assert before.shape == now.shape, f"docs/{page}/{name} is another picture; VIBRO_IMPACT_UPDATE=1 writes it anew"
        assert np.abs(before - now).mean() < SAME_PICTURE, f"docs/{page}/{name} is stale; VIBRO_IMPACT_UPDATE=1 writes it anew"


@pytest.mark.parametrize("page", ["python/package/README.md", "AGENTS.md"])
def test_a_page_runs(page, tmp_path):
    assert run(page, tmp_path) == 1


def test_the_examples_of_the_docstrings_are_right():
    import doctest

    import vibro_impact as vi

    for module in (vi, vi._machine):
        found = doctest.testmod(module)
        assert found.attempted and not found.failed
