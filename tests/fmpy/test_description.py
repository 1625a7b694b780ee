"""Content of the archive's descriptions."""

import posixpath
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree


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
    """Neither fmpy nor any other checker tests this."""
    for v in description.modelVariables:
        if v.type == "Real" and v.start is not None:
            start = float(v.start)
            assert v.min is None or start >= float(v.min), v.name
            assert v.max is None or start <= float(v.max), v.name


@pytest.mark.parametrize("version", ["-FMI3", "-FMI3-arrays", "-FMI3-clocked"])
def test_terminals_follow_their_schema_and_name_what_can_be_connected(fmu, version):
    path = fmu.replace(".fmu", f"{version}.fmu")
    description = fmpy.read_model_description(path)
    with zipfile.ZipFile(path) as archive:
        tree = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        pictures = {name for name in archive.namelist() if name.startswith("terminalsAndIcons/")}
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(str(schema))).assertValid(tree)
    causality = {v.name: v.causality for v in description.modelVariables}
    terminals = tree.findall("Terminals/Terminal")
    assert [terminal.get("name") for terminal in terminals] == ["box", "block", "secondary"]
    for terminal in terminals:
        members = {m.get("memberName"): m for m in terminal.findall("TerminalMemberVariable")}
        assert sorted(members) == ["a", "f", "s", "v"]
        for name, member in members.items():
            flows = name == "f"
            assert member.get("variableName") == f"{terminal.get('name')}.{name}"
            assert causality[member.get("variableName")] == ("input" if flows else "output")
            assert member.get("variableKind") == ("inflow" if flows else "signal")
        icon = terminal.find("TerminalGraphicalRepresentation").get("iconBaseName")
        assert f"terminalsAndIcons/{icon}.png" in pictures
    assert {"terminalsAndIcons/icon.png", "terminalsAndIcons/icon.svg"} <= pictures


@pytest.mark.parametrize("version", ["", "-FMI3", "-FMI3-arrays", "-FMI3-clocked"])
def test_reference_files_are_those_of_the_manifest(fmu, version):
    """Compares with the attributes and roles of FMI-LS-REF 1.0.0-alpha.1, whose schema is a draft."""
    folder = "extra/org.fmi-standard.fmi-ls-ref/"
    namespace = "{http://fmi-standard.org/fmi-ls-manifest}"
    path = fmu.replace(".fmu", f"{version}.fmu")
    settable = {v.name for v in fmpy.read_model_description(path).modelVariables if v.initial == "exact"}
    with zipfile.ZipFile(path) as archive:
        manifest = etree.fromstring(archive.read(folder + "fmi-ls-manifest.xml"))
        names = set(archive.namelist())
        sets = [etree.fromstring(archive.read(name)) for name in names if name.endswith(".ssv")]
    assert manifest.tag == "fmiReferences"
    assert manifest.get(f"{namespace}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    assert manifest.get(f"{namespace}fmi-ls-version") == "1.0.0-alpha.1"
    assert manifest.get(f"{namespace}fmi-ls-description").startswith("Layered Standard providing")
    related = manifest.findall("Related")
    assert {one.get("role") for one in related} == {
        "result", "parameter", "serialized-state", "document", "experiment/smoke-test"
    }
    sources = {posixpath.normpath(folder + one.get("source")) for one in related}
    assert len(sources) == len(related) and sources <= names
    assert {name for name in names if name.startswith(folder)} - sources == {folder + "fmi-ls-manifest.xml"}
    ssv = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
    assert len(sets) > 10
    for one in sets:
        parameters = one.findall(f"{ssv}Parameters/{ssv}Parameter")
        assert parameters and {p.get("name") for p in parameters} <= settable


def test_archives_of_one_build_hold_one_library(fmu):
    libraries = []
    for version in ("", "-FMI3", "-FMI3-arrays", "-FMI3-clocked"):
        with zipfile.ZipFile(fmu.replace(".fmu", f"{version}.fmu")) as archive:
            found = [archive.read(name) for name in archive.namelist() if name.startswith("binaries/")]
        libraries.append(found)
    assert len(libraries[0]) == 1 and all(one == libraries[0] for one in libraries)


def test_no_file_of_fmi3_is_in_the_archive_of_fmi2(fmu):
    """The FMI Library logs the version 3.0 of `terminalsAndIcons.xml` as fatal in an FMI 2.0 archive; the icon remains."""
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
    assert not [name for name in names if name.startswith("terminalsAndIcons/")]
    assert "model.png" in names


def test_the_smoke_test_runs_as_it_says(fmu):
    """The experiment's own times and step reproduce its reference result, to the 1e-8 m that its description promises."""
    folder = "extra/org.fmi-standard.fmi-ls-ref/"
    with zipfile.ZipFile(fmu) as archive:
        experiment = etree.fromstring(archive.read(folder + "smoke-test.xml")).find("Experiment")
        source = folder + experiment.find("References").get("source")
        expected = np.genfromtxt(archive.read(source).decode().splitlines(), delimiter=",", names=True, deletechars="")
    columns = [name for name in expected.dtype.names if name.endswith(".s")]
    rows = fmpy.simulate_fmu(
        fmu, fmi_type="CoSimulation", output=columns, start_time=float(experiment.get("startTime")),
        stop_time=float(experiment.get("stopTime")), output_interval=float(experiment.get("stepSize")),
    )
    assert len(rows) == len(expected) > 1000
    for name in columns:
        assert np.ptp(expected[name]) > 0.1
        np.testing.assert_allclose(rows[name], expected[name], rtol=0, atol=1e-8)
