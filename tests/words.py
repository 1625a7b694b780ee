#!/usr/bin/env python3
"""Counts phrases that readers had to read twice, in comments, docstrings, messages and pages.

    python3 tests/words.py                 # hits of each package, against its bound
    python3 tests/words.py --list crates/orbits   # each hit of files below a path
    python3 tests/words.py --changed main  # only lines that differ from a revision

The exit status is 1 if a package has more hits in 100 lines of prose than its bound allows. A hit is
a hint: rewrite the sentence if it is hard, leave it if it is plain. CONTRIBUTING.md has the rules.
"""

import argparse
import collections
import pathlib
import re
import subprocess
import sys
from collections.abc import Iterator
from typing import Optional

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Largest number of hits in 100 lines of prose of each package. A bound only falls.
BOUNDS = {
    ".": 3.8,
    "benches": 4.2,
    "crates/command-line": 1.5,
    "crates/design": 1.5,
    "crates/doors": 1.0,
    "crates/machine": 0.8,
    "crates/numerics": 2.6,
    "crates/orbits": 0.8,
    "crates/paper-component": 1.2,
    "crates/studies": 0.8,
    "docs": 1.6,
    "examples": 2.1,
    "fmu-build": 1.5,
    "python": 1.5,
    "src": 0.7,
    "web/workbench": 2.2,
    "other": 1.0,
}

# Each kind of phrase: a pattern, and whether case counts.
KINDS = {
    "subject without a noun": (r"(?:^|[.;:] )(?:Those|That|What|Which|They|Of|By|With)\b(?! is\b)", True),
    "those of, of which": (r"\b(?:those|that) (?:of|by|in|at|with|from|to|that|which)\b|\b(?:of|by|in|from) which\b|\bthose\b", False),
    "allowed is": (r"\ballowed (?:is|are|in)\b|\bvalid (?:is|are)\b", False),
    "is no, are no": (r"\b(?:is|are|was|were) no (?!longer|more\b)[a-z]", False),
    "stands": (r"\bstands?\b", False),
    "tells, says": (r"\b(?:tells?|told|says?|said) (?:that|what|which|how|so|by|of|the|it)\b", False),
    "anew, at hand, beside, goes on": (r"\banew\b|\bat hand\b|\bbeside\b|\bgo(?:es)? on\b|\bby (?:itself|themselves)\b", False),
    "what … as a subject": (r"\bwhat(?:ever)? (?:is|was|are|were|moves|follows|lies|can|no|has|one|they|it)\b", False),
    "as many … as": (r"\b(?:as|so) (?:many|much|long|far) .{0,30}\bas\b", False),
    "preposition at the end": (r"\b(?:of|by|to|at|in|from|for|with|on)[.;,)]|\b(at at|of of|in in|by by|to to)\b", False),
    "constant without a verb": (
        r"^(?:Most|Least|Longest|Largest|Smallest|Number|Part|Share|Size|Relative|Sum|Times?)\b.*\b(?:that|which)\b",
        True,
    ),
}
PATTERNS = {name: re.compile(pattern, 0 if cased else re.IGNORECASE) for name, (pattern, cased) in KINDS.items()}
SPOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"')
CODE = re.compile(r"`[^`]*`|\$[^$]*\$|\]\([^)]*\)")


def messages(line: str) -> str:
    """String literals of a line that read like sentences."""
    return " ".join(text for text in SPOKEN.findall(line) if text.count(" ") >= 3)


def prose(path: pathlib.Path) -> Iterator[tuple[int, str]]:
    """Line numbers and texts of comments, docstrings, messages, and of a page without its code blocks."""
    in_code = in_docstring = False
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        stripped = line.strip()
        if path.suffix == ".md":
            in_code ^= stripped.startswith("```")
            text = "" if in_code or stripped.startswith(("```", "|--")) else stripped
        elif path.suffix == ".rs":
            comment = re.match(r"\s*//[/!]? ?(.*)", line)
            text = comment.group(1) if comment else messages(line)
        else:
            quotes, was_inside = stripped.count('"""'), in_docstring
            in_docstring ^= quotes == 1
            comment = re.match(r"\s*# ?(.*)", line)
            inside = was_inside or quotes > 0
            text = stripped.strip('"') if inside else comment.group(1) if comment else messages(line)
        text = CODE.sub("x", text)
        if " " in text:
            yield number, text


def listed() -> list[str]:
    """The files with prose that git knows, without tests and the changelog."""
    found = subprocess.run(["git", "ls-files", "*.rs", "*.py", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True)
    skipped = re.compile(r"(^|/)tests?(/|\.rs$|_)|CHANGELOG|_test\.")
    return [file for file in found.stdout.split() if not skipped.search(file) and (ROOT / file).exists()]


def changed(base: str) -> dict[str, set[int]]:
    """By file the lines that differ from a revision."""
    diff = subprocess.run(["git", "diff", "-U0", base], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    lines: dict[str, set[int]] = collections.defaultdict(set)
    file = ""
    for line in diff.splitlines():
        if line.startswith("+++ b/"):
            file = line[6:]
        if hunk := re.match(r"@@ .* \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            lines[file] |= set(range(first, first + count))
    return lines


def package(file: str) -> str:
    """The package that a file belongs to: its folder in `crates` or `web`, else its first folder."""
    parts = file.split("/")
    return "/".join(parts[:2]) if parts[0] in ("crates", "web") else parts[0] if len(parts) > 1 else "."


def hits(file: str, only: Optional[set[int]]) -> Iterator[tuple[int, str, list[str]]]:
    """Each line of prose with the kinds of phrases that it has."""
    for number, text in prose(ROOT / file):
        if only is None or number in only:
            yield number, text, [name for name, pattern in PATTERNS.items() if pattern.search(text)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", metavar="PATH", help="print each hit of the files below a path")
    parser.add_argument("--changed", metavar="REVISION", help="read only lines that differ from this revision")
    args = parser.parse_args()
    lines = changed(args.changed) if args.changed else None
    found: collections.Counter[str] = collections.Counter()
    read: collections.Counter[str] = collections.Counter()
    for file in listed():
        if lines is not None and file not in lines:
            continue
        for number, text, kinds in hits(file, lines[file] if lines is not None else None):
            read[package(file)] += 1
            found[package(file)] += len(kinds)
            if kinds and (args.changed or (args.list and file.startswith(args.list))):
                print(f"{file}:{number}: {', '.join(kinds)}: {text}")
    above = False
    for name in sorted(read):
        rate, bound = 100 * found[name] / read[name], BOUNDS.get(name, BOUNDS["other"])
        above |= rate > bound and not args.changed
        print(f"{name:28} {found[name]:5} hits in {read[name]:6} lines, {rate:5.1f} in 100; bound {bound}")
    whole = 100 * sum(found.values()) / max(sum(read.values()), 1)
    print(f"{'all':28} {sum(found.values()):5} hits in {sum(read.values()):6} lines, {whole:5.1f} in 100")
    sys.exit(1 if above else 0)


if __name__ == "__main__":
    main()
