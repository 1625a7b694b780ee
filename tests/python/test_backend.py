"""The build backend puts existing archives into the package and skips missing ones."""

import importlib.util
import shutil
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


def test_the_pages_for_assistants_go_along_and_their_links_have_targets(backend, tmp_path, monkeypatch):
    with pytest.raises(SystemExit, match="AGENTS.md.* are missing: build from a clone"), backend.pages():
        pass
    (tmp_path / "docs").mkdir()
    for name in backend.PAGES:
        shutil.copyfile(ROOT / name, tmp_path / name)
    inside = [tmp_path / "python/package/vibro_impact" / name for name in backend.PAGES]
    with backend.pages():
        text = inside[0].read_text(encoding="utf-8")
        assert "vi.Machine(" in text and f"({backend.PAGES[1]})" in text and inside[1].is_file()
    assert not any(path.exists() for path in inside)
    # A source distribution has the pages. Below another project it does not take that project's.
    for path in inside:
        path.write_text("ours")
    (tmp_path / "python").rename(tmp_path / "unpacked")
    monkeypatch.setattr(backend, "HERE", tmp_path / "unpacked")
    with backend.pages():
        pass
    assert all((tmp_path / "unpacked/package/vibro_impact" / name).read_text() == "ours" for name in backend.PAGES)
    # They are named in what goes into the wheel, since git ignores them.
    manifest = (ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8")
    assert all(f'vibro_impact/{name}", format = ["sdist", "wheel"]' in manifest for name in backend.PAGES)


def test_an_installed_package_finds_archives_in_a_folder_that_is_named(monkeypatch, tmp_path):
    from vibro_impact import _fmu

    monkeypatch.setattr(_fmu, "_NAMES", {3: "made-later.fmu"})
    with pytest.raises(FileNotFoundError, match="set VIBRO_IMPACT_ARCHIVES to that folder"):
        _fmu.fmu_path(3)
    (tmp_path / "made-later.fmu").write_text("")
    monkeypatch.setenv("VIBRO_IMPACT_ARCHIVES", str(tmp_path))
    assert _fmu.fmu_path(3) == tmp_path / "made-later.fmu"
