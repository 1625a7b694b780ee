"""Prints the page of the Python package: its classes and functions by their docstrings, and its tables."""

import inspect

import vibro_impact as vi


def documented(kind: str, name: str, options: str = "") -> str:
    return f"\n```{{eval-rst}}\n.. auto{kind}:: {name}{options}\n```\n"


def table(found: object) -> str:
    """A dictionary as a table, and any other value as text."""
    if not isinstance(found, dict):
        return "\n" + ", ".join(f"`{name}`" for name in found) + "\n"
    rows = ["| " + " | ".join([f"`{name}`", *cells(value)]) + " |" for name, value in found.items()]
    columns = rows[0].count(" | ") + 1
    return "\n|" + " |" * columns + "\n|" + "---|" * columns + "\n" + "\n".join(rows) + "\n"


def cells(value: object) -> list[str]:
    parts = value if isinstance(value, tuple) else (value,)
    return [str(part).replace("|", "\\|") for part in parts]


public = {name: getattr(vi, name) for name in vi.__all__}
print("# The Python package")
print(documented("module", "vibro_impact"))
for heading, belongs in (("Machines and results", inspect.isclass), ("Functions", inspect.isfunction)):
    print(f"\n## {heading}")
    for name, what in public.items():
        if belongs(what):
            members = "\n   :members:\n   :inherited-members: Result, dict" if inspect.isclass(what) else ""
            print(f"\n### {name}\n", documented("class" if inspect.isclass(what) else "function", f"vibro_impact.{name}", members))
print("\n## Tables")
for name, what in public.items():
    if not callable(what) and name != "__version__":
        print(f"\n### {name}\n", table(what))
print("\n## Pictures\n", documented("module", "vibro_impact.plot", "\n   :members:"))
