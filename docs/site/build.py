"""Builds the site of the documentation: `python3 docs/site/build.py` writes target/site/html.

The pages are the Markdown files of the repository, unchanged. Further pages are generated from
the programs themselves: the help of every command, the variables of the FMU, and the docstrings of
the Python package. The option `--execute` runs the notebooks. With `--workbench FILE` the site has
the workbench, and each machine of docs/lessons/ a link that opens it there.
"""

import argparse
import base64
import gzip
import os
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "site"
REQUIREMENTS = ["docs/site/requirements.txt", "tests/fmpy/requirements.txt", "tests/python/requirements.txt"]
# A link of Markdown to a file or folder of this repository: its text, name and anchor.
LINK = re.compile(r"\[([^\]]*)\]\(([^)#:\s]+)(#[^)\s]*)?\)")
# A picture of HTML, which GitHub shows in a given width: its file, width and words.
PICTURE = re.compile(r'<img src="([^":]+)" width="(\d+)" alt="([^"]*)">')
# A machine in a page: its text.
MACHINE = re.compile(r"^```toml \S+\n(.*?)^```\n", re.MULTILINE | re.DOTALL)


def opened(machine: str) -> str:
    """The part of a link after `#` that opens this text in the workbench (web/workbench/page/src/link.js)."""
    packed = gzip.compress(machine.encode(), mtime=0)
    return "z=" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def lessons(sources: Path, workbench: str) -> None:
    """Adds the workbench, and below each machine of a lesson the link that opens it there."""
    folder = sources / "docs" / "lessons"
    to = os.path.relpath(sources / "workbench.html", folder)
    for page in folder.glob("*.md"):
        link = lambda found: f'{found[0]}\n<a href="{to}#{opened(found[1])}">Open this machine in the workbench</a>\n'
        page.write_text(MACHINE.sub(link, page.read_text()))
    (TARGET / "html").mkdir(parents=True, exist_ok=True)
    shutil.copyfile(workbench, TARGET / "html" / "workbench.html")


def environment() -> Path:
    """Python of the environment for the build, which is created again if the requirements have changed."""
    folder = TARGET / "venv"
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    wanted = "".join((ROOT / path).read_text() for path in REQUIREMENTS)
    stamp = folder / "complete"
    if not stamp.is_file() or stamp.read_text() != wanted:
        shutil.rmtree(folder, ignore_errors=True)
        venv.create(folder, with_pip=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        files = [argument for path in REQUIREMENTS for argument in ("--requirement", path)]
        subprocess.run([*install, *files], cwd=ROOT, check=True)
        stamp.write_text(wanted)
    return python


def tracked(*patterns: str) -> list[Path]:
    """The files of the repository with these patterns, without the site's own."""
    listed = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, check=True, capture_output=True, text=True)
    return [Path(name) for name in listed.stdout.split("\0") if name and not name.startswith(("docs/site/", "tests/data/"))]


def copy(path: Path, sources: Path) -> None:
    to = sources / path
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(ROOT / path, to)


def gather(sources: Path) -> None:
    """Copies the pages, and every file of the repository to which one of them leads."""
    first = (HERE / "index.md").read_text()
    for _, name, _ in LINK.findall(first):
        copy((HERE / name).resolve().relative_to(ROOT), sources)
    (sources / "index.md").write_text(LINK.sub(lambda link: link[0].replace(link[2], os.path.relpath(HERE / link[2], ROOT)), first))
    for page in tracked("*.md"):
        text = PICTURE.sub(r"![\3](\1){width=\2px}", (ROOT / page).read_text())
        for _, name, _ in LINK.findall(text):
            linked = (ROOT / page.parent / name).resolve()
            inside = linked.is_relative_to(ROOT) and linked.is_file() and linked.suffix != ".md"
            if inside:
                copy(linked.relative_to(ROOT), sources)
        copy(page, sources)
        (sources / page).write_text(LINK.sub(lambda link: retarget(link, page), text))


def retarget(link: re.Match[str], page: Path) -> str:
    """A link to a folder becomes one to its README, or its text alone where it has none."""
    text, name, anchor = link[1], link[2], link[3] or ""
    linked = ROOT / page.parent / name
    if not linked.is_dir():
        return link[0]
    return f"[{text}]({name.rstrip('/')}/README.md{anchor})" if (linked / "README.md").is_file() else text


def reference(sources: Path, of: str, text: str) -> None:
    """Writes a page that is made from a program."""
    (sources / f"reference-{of}.md").write_text(text.rstrip() + "\n")


def commands(sources: Path) -> None:
    """The help of `vibro` and of each of its commands."""
    subprocess.run(["cargo", "build", "--quiet", "--bin", "vibro"], cwd=ROOT, check=True)
    program = TARGET.parent / "debug" / ("vibro.exe" if os.name == "nt" else "vibro")

    def help_of(*words: str) -> str:
        asked = subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True)
        return asked.stdout.replace(str(ROOT), "").rstrip()

    whole = help_of()
    names = re.findall(r"^  ([a-z]+) ", whole.split("Commands:")[1].split("Options:")[0], re.MULTILINE)
    text = ["# The commands of vibro", "What `--help` says.", f"```text\n{whole}\n```"]
    text += [f"## vibro {name}\n\n```text\n{help_of(name)}\n```" for name in names if name != "help"]
    reference(sources, "commands", "\n\n".join(text))


def variables(sources: Path) -> None:
    """The variables of the FMU by the description that it carries."""
    tree = ElementTree.parse(ROOT / "modelDescription" / "fmi3.xml").getroot()
    rows = [
        f"| `{one.get('name')}` | {one.tag} | {one.get('causality', 'local')} | {one.get('unit', '')} "
        f"| {one.get('start', '')} | {one.get('description', '').replace('|', chr(92) + '|')} |"
        for one in tree.find("ModelVariables")
    ]
    head = "| name | type | causality | unit | start | meaning |\n|---|---|---|---|---|---|\n"
    text = f"# Variables of the FMU\n\nWhat `modelDescription.xml` of FMI 3.0 says.\n\n{head}" + "\n".join(rows)
    reference(sources, "fmu", text)


def classes(python: Path, found: dict[str, str], sources: Path) -> None:
    """A page of the Python package's docstrings, in the order of its public names."""
    asked = subprocess.run([python, HERE / "public_names.py"], env=found, check=True, capture_output=True, text=True)
    reference(sources, "python", asked.stdout)


def package(python: Path, where: str) -> dict[str, str]:
    """Environment variables that make the Python package importable, from a folder or a wheel."""
    path = Path(where).resolve()
    if (path / "vibro_impact").is_dir():
        alone = TARGET / "package"
        shutil.copytree(path / "vibro_impact", alone / "vibro_impact", dirs_exist_ok=True)
        return {**os.environ, "PYTHONPATH": str(alone)}
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps", str(path)], check=True)
    return dict(os.environ)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--package", default=str(ROOT / "python"), help="wheel, sources, or folder with vibro_impact")
    parser.add_argument("--execute", action="store_true", help="run the notebooks; without it they are shown as text")
    parser.add_argument("--workbench", help="the page that `web-build workbench` has made")
    chosen = parser.parse_args()
    python = environment()
    variables_of_process = package(python, chosen.package)
    sources = TARGET / "src"
    shutil.rmtree(sources, ignore_errors=True)
    sources.mkdir(parents=True)
    gather(sources)
    if chosen.workbench:
        lessons(sources, chosen.workbench)
    commands(sources)
    variables(sources)
    classes(python, variables_of_process, sources)
    mode = "force" if chosen.execute else "off"
    sphinx = [python, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet"]
    sphinx += ["-b", "html", "-c", HERE, "-d", TARGET / "doctrees", "-D", f"nb_execution_mode={mode}", sources, TARGET / "html"]
    sys.exit(subprocess.run(list(map(str, sphinx)), env=variables_of_process).returncode)


if __name__ == "__main__":
    main()
