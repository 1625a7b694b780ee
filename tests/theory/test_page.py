"""The page itself: every equation has a check or a reason for none, its table is correct, and GitHub renders its TeX."""

import ast
import os
import re
from functools import lru_cache
from pathlib import Path
from typing import Dict, List, Set, Tuple

from equations import ROOT, displays, equations, page, whole

HERE = Path(__file__).parent

# Equations that state no result: there is nothing they could be checked against.
DEFINITIONS: Dict[int, str] = {
    4: "defines the drive's phase; other tests differentiate it",
    15: "defines the event of release",
    19: "a choice of the simulator, when the acceleration counts as steady",
    81: "defines functions whose zeros are located",
    85: "defines how exponents are counted",
    96: "a choice of the code, when the closed form is accurate enough",
}


@lru_cache(maxsize=None)
def checks() -> Dict[str, Tuple[Set[int], str]]:
    """The tests of this folder that name equations: numbers and docstring."""
    found: Dict[str, Tuple[Set[int], str]] = {}
    for file in sorted(HERE.glob("test_*.py")):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_eq_"):
                numbers = re.match(r"test_eq((?:_\d+)+)_[a-z]", node.name)
                assert numbers, f"{node.name} names no equation"
                assert node.name not in found, f"{node.name} twice"
                found[node.name] = {int(n) for n in numbers.group(1)[1:].split("_")}, ast.get_docstring(node) or ""
    return found


def test_every_equation_is_checked_or_a_definition() -> None:
    named = set().union(*(numbers for numbers, _ in checks().values()))
    missing = set(equations()) - named - set(DEFINITIONS)
    assert not missing, f"equations without a test: {sorted(missing)}"
    assert not named - set(equations()), f"tests of equations that do not exist: {sorted(named - set(equations()))}"
    assert not named & set(DEFINITIONS), "an equation with a test is not a definition"
    assert set(DEFINITIONS) <= set(equations())


def test_names_and_docstrings_of_the_tests_agree() -> None:
    silent: Dict[str, Set[int]] = {}
    for name, (numbers, text) in checks().items():
        spans = [range(int(a), int(b) + 1) for a, b in re.findall(r"\((\d+)\) to \((\d+)\)", text)]
        said = {int(n) for n in re.findall(r"\((\d+)\)", text)}.union(*map(set, spans))
        if numbers - said:
            silent[name] = numbers - said
    assert not silent, f"docstrings without these numbers: {silent}"


def test_a_missing_test_is_noticed() -> None:
    """The two tests above cover everything: the page's equations are numbered in order without gaps."""
    assert sorted(equations()) == list(range(1, len(equations()) + 1)) and len(equations()) == page().count(r"\tag{")
    assert list(equations()) == sorted(equations()), "not in order"
    assert len(displays()) == len(equations())


def rows() -> List[List[str]]:
    """The table of the section that lists the equations."""
    table = page().split("## 16. ")[1]
    lines = [line for line in table.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def numbers_of(cell: str) -> List[int]:
    found: List[int] = []
    for first, last in re.findall(r"\((\d+)\)(?: to \((\d+)\))?", cell):
        found += range(int(first), int(last or first) + 1)
    return found


def test_table_has_every_equation_once() -> None:
    listed = [n for row in rows() for n in numbers_of(row[0])]
    assert listed == sorted(equations())


def test_table_names_the_checks() -> None:
    """The third column names a test of this folder for every equation of its row, or marks it as a definition."""
    for equation, _, check, _ in rows():
        tests = re.findall(r"`(\w+)`", check)
        for name in tests:
            assert name in checks(), f"{name} of the table is not a test of this folder"
        covered = set().union(*(checks()[name][0] for name in tests)) if tests else set()
        for number in numbers_of(equation):
            assert number in covered or (number in DEFINITIONS and "definition" in check), f"({number})"


@lru_cache(maxsize=None)
def sources() -> Tuple[Path, ...]:
    """All Rust files of the repository."""
    files: List[Path] = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [f for f in folders if f not in ("target", "corpus") and not f.startswith(".")]
        files += [Path(folder) / name for name in names if name.endswith(".rs")]
    assert files
    return tuple(files)


@lru_cache(maxsize=None)
def rust() -> str:
    """Their text."""
    return "\n".join(f.read_text(encoding="utf-8") for f in sources())


def test_table_names_code_and_tests_that_exist() -> None:
    """If code or tests are renamed, the table is wrong: correct the table."""
    stems = {f.stem for f in sources()} | {f.parent.name for f in sources()}
    items = set(re.findall(r"\b(?:fn|struct|enum|const|type|mod) (\w+)", rust()))
    for equation, code, _, tests in rows():
        for path in re.findall(r"`([\w:]+)`", code):
            item = path.split("::")[-1]
            assert item in stems | items, f"{equation}: no {path} in the code"
        for name in re.findall(r"`(\w+)`", tests):
            assert name in items, f"{equation}: no test {name}"


def inline() -> List[str]:
    """TeX between single dollars."""
    text = re.sub(r"^\$\$\n.*?\n\$\$$", "", page(), flags=re.S | re.M)
    text = re.sub(r"`[^`\n]*`", "", text)
    assert text.count("$") % 2 == 0
    return re.findall(r"\$([^$]*)\$", text)


def test_tex_survives_markdown() -> None:
    """Nothing that Markdown may change before the formulas are rendered: escaped punctuation, emphasis, tags, table bars."""
    for tex in [*displays(), *inline()]:
        assert not re.search(r"\\[^A-Za-z]", tex), f"escaped punctuation in {tex!r}"
        assert not re.search(r"(?:^|[^A-Za-z0-9])_", tex), f"an underscore that may open emphasis in {tex!r}"
        assert not re.search(r"[*<>|~`#]|operatorname", tex), f"a character Markdown may take in {tex!r}"
        assert tex.count("{") == tex.count("}") and tex.count(r"\left") - tex.count(r"\leftarrow") == tex.count(r"\right"), tex
    for tex in inline():
        assert "\n" not in tex and tex == tex.strip(), f"{tex!r} is not an inline formula on GitHub"
    # A blank line before and after; otherwise it is part of a paragraph.
    for match in re.finditer(r"^\$\$\n.*?\n\$\$$", page(), re.S | re.M):
        assert page()[match.start() - 2 : match.start()] == "\n\n" and page()[match.end() : match.end() + 2] == "\n\n"


def test_inline_formulas_are_recognized() -> None:
    """GitHub requires a blank or an opening bracket before an inline formula, and no letter or digit after it."""
    text = re.sub(r"^\$\$\n.*?\n\$\$$", "", page(), flags=re.S | re.M)
    for match in re.finditer(r"\$[^$\n]*\$", text):
        before, after = text[match.start() - 1], text[match.end() : match.end() + 1]
        assert before in " \n([", f"{match.group()} after {before!r}"
        assert after in " \n.,;:)]", f"{match.group()} before {after!r}"


def test_contents_lead_to_the_sections() -> None:
    def anchor(title: str) -> str:
        return re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")

    titles = re.findall(r"^## (.*)$", whole(), re.M)
    links = re.findall(r"^\d+\. \[.*\]\(#(.*)\)$", whole(), re.M)
    assert links == [anchor(title) for title in titles] and len(links) == 17


def test_equations_referred_to_exist() -> None:
    text = re.sub(r"\$\$.*?\$\$|\$[^$\n]*\$|\d+ \(\d{4}\)", "", page(), flags=re.S)
    for number in re.findall(r"\((\d+)\)", text):
        assert int(number) in equations(), f"({number})"
