"""What the archive says about itself."""

import zipfile

from fmpy.validation import validate_fmu


def test_fmpy_finds_nothing_wrong(fmu):
    assert validate_fmu(fmu) == []


def test_archive_is_complete(fmu):
    with zipfile.ZipFile(fmu) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
    wanted = {"modelDescription.xml", "model.png", "documentation/index.html", "licenses/LICENSE-MIT"}
    assert wanted <= names
    assert any(name.startswith("binaries/") for name in names)
    assert "reconstruction, not the paper" in page and "{{" not in page


def test_every_variable_is_documented(fmu, description):
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    for variable in description.modelVariables:
        assert f"<code>{variable.name}</code>" in page
        assert variable.description


def test_start_values_lie_within_their_range(description):
    """fmpy does not look at this, nor does any other checker."""
    for v in description.modelVariables:
        if v.type == "Real" and v.start is not None:
            start = float(v.start)
            assert v.min is None or start >= float(v.min), v.name
            assert v.max is None or start <= float(v.max), v.name
