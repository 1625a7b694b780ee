"""The build backend puts existing archives into the package and skips missing ones."""

import importlib.util
import sys
import types

import pytest
from conftest import ROOT


@pytest.fixture
def backend(monkeypatch, tmp_path):
    """The backend, for a package and a `target/` in a separate folder."""
    monkeypatch.setitem(sys.modules, "maturin", types.ModuleType("maturin"))
    spec = importlib.util.spec_from_file_location("backend", ROOT / "python" / "backend.py")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    (tmp_path / "python" / "package" / "vibro_impact").mkdir(parents=True)
    (tmp_path / "target").mkdir()
    monkeypatch.setattr(found, "HERE", tmp_path / "python")
    for name in ("CARGO_TARGET_DIR", "VIBRO_IMPACT_ARCHIVES"):
        monkeypatch.delenv(name, raising=False)
    return found


def inside(tmp_path):
    return sorted(path.name for path in (tmp_path / "python/package/vibro_impact/fmu").iterdir())


def test_a_fresh_clone_is_built_without_archives_and_says_so(backend, tmp_path, capsys):
    backend.fetch_archives()
    told = capsys.readouterr().out
    assert inside(tmp_path) == [] and all(f"{name} is left out" in told for name in backend.ARCHIVES)
    assert "cargo run --bin fmu-build" in told


def test_archives_that_are_made_go_along(backend, tmp_path, monkeypatch):
    for name in backend.ARCHIVES[:2]:
        (tmp_path / "target" / name).write_text(name)
    backend.fetch_archives()
    assert inside(tmp_path) == sorted(backend.ARCHIVES[:2])
    # A release names the folder; then all archives must exist.
    monkeypatch.setenv("VIBRO_IMPACT_ARCHIVES", str(tmp_path / "target"))
    with pytest.raises(SystemExit, match="machine-kit.zip is missing: build it with `cargo run --bin fmu-build`"):
        backend.fetch_archives()


def test_an_installed_package_finds_archives_in_a_folder_that_is_named(monkeypatch, tmp_path):
    from vibro_impact import _fmu

    monkeypatch.setattr(_fmu, "_NAMES", {3: "made-later.fmu"})
    with pytest.raises(FileNotFoundError, match="set VIBRO_IMPACT_ARCHIVES to that folder"):
        _fmu.fmu_path(3)
    (tmp_path / "made-later.fmu").write_text("")
    monkeypatch.setenv("VIBRO_IMPACT_ARCHIVES", str(tmp_path))
    assert _fmu.fmu_path(3) == tmp_path / "made-later.fmu"
