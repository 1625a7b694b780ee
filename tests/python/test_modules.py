"""The package's modules, read as text: none imports itself through others, even in type hints."""

import ast
import graphlib
import pathlib

import vibro_impact

FOLDER = pathlib.Path(vibro_impact.__file__).parent


def imported(module):
    """Modules of the package that `module` imports, including imports under TYPE_CHECKING."""
    names = {path.stem for path in FOLDER.glob("*.py")}
    found = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {alias.name for alias in node.names}
    return found & names


def test_no_module_imports_itself_by_way_of_others():
    graph = {path.stem: imported(path) for path in FOLDER.glob("*.py")}
    assert graph["_paper_machine"] >= {"_paper_motion", "_paper_values"}
    # CycleError names the cycle.
    graphlib.TopologicalSorter(graph).prepare()
