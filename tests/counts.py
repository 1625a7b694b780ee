#!/usr/bin/env python3
"""Counts of the source, which monitor its size and its words.

    python3 tests/counts.py [--packages] [--names] [--wide]

`--packages` counts the lines of Rust by package: code, comments, tests (code and comments of tests). `--names` lists the types that share a name, `--wide` the comments wider than 100 columns. Tests are files named tests.rs or in a
folder of tests, and the code after `#[cfg(test)]`.
"""

import argparse
import collections
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTH = 100
# A name shared by at least this many types is counted.
ALIKE = 4


def files(*patterns):
    """Paths and texts of the files that git tracks."""
    listed = subprocess.run(["git", "ls-files", *patterns], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return {name: (ROOT / name).read_text() for name in listed.split("\n") if name and (ROOT / name).exists()}


def without_tests(texts):
    """Files without test files, cut where their unit tests begin."""
    is_test = re.compile(r"(^|/)(tests?|benches|examples)(/|\.rs$)")
    return {f: t.split("#[cfg(test)]\nmod ")[0] for f, t in texts.items() if not is_test.search(f)}


def lines_of(texts):
    return sum(t.count("\n") for t in texts.values())


def package_of(path):
    """Folder of a file's package."""
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] in ("crates", "web") else parts[0]


def lines_by_kind(path, text):
    """Lines of code, of comments and of tests of a Rust file; blank lines do not count."""
    is_test = path not in without_tests({path: ""})
    own = text if is_test else text.split("#[cfg(test)]\nmod ")[0]
    filled = [line.strip() for line in own.split("\n") if line.strip()]
    comments = sum(line.startswith("//") for line in filled)
    if is_test:
        return 0, 0, len(filled)
    unit = sum(bool(line.strip()) for line in text[len(own) :].split("\n"))
    return len(filled) - comments, comments, unit


def packages(rust):
    """Lines of code, comments and tests, and files, by package."""
    counts = collections.defaultdict(lambda: [0, 0, 0, 0])
    for path, text in rust.items():
        for name in (package_of(path), "all"):
            for i, number in enumerate((*lines_by_kind(path, text), 1)):
                counts[name][i] += number
    return counts


def wide_comments(texts):
    """Locations of comment lines wider than WIDTH; tables and links of documentation cannot be broken."""
    return [
        f"{f}:{number}"
        for f, text in texts.items()
        for number, line in enumerate(text.split("\n"), 1)
        if len(line) > WIDTH and re.match(r"\s*(//[/!]?|#) (?!\||\[[^\]]*\]: )", line)
    ]


def same(texts):
    """Documentation comments whose first words are "The same"."""
    return sum(len(re.findall(r"(?:^|\n)(?![ \t]*///)[^\n]*\n[ \t]*//[/!] The same\b", t)) for t in texts.values())


def types_alike(texts):
    """Names of types with the number of their declarations, if there are several."""
    names = collections.defaultdict(list)
    for f, text in texts.items():
        for name in re.findall(r"^\s*(?:pub(?:\(\w+\))? )?(?:struct|enum|trait|type) (\w+)(?=[^=;]*[{;=(])", text, re.M):
            if f"type {name} = " not in text or re.search(rf"^(?:pub(?:\(\w+\))? )?type {name}\b", text, re.M):
                names[name].append(f)
    return {name: where for name, where in names.items() if len(where) >= ALIKE}


def functions_of_trait(text, name):
    """Functions of a trait in a file."""
    body = re.search(rf"^pub trait {name}\b[^{{]*\{{(.*?)^\}}", text, re.M | re.S).group(1)
    return len(re.findall(r"^    fn ", body, re.M))


def required_of_trait(text, name):
    """Functions of a trait in a file without a default implementation."""
    body = re.search(rf"^pub trait {name}\b[^{{]*\{{(.*?)^\}}", text, re.M | re.S).group(1)
    return len(re.findall(r"^    fn [^;{]*;", body, re.M))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--packages", action="store_true")
    parser.add_argument("--names", action="store_true")
    parser.add_argument("--wide", action="store_true")
    args = parser.parse_args()
    if args.packages:
        print(f"{'code':>8}{'comments':>10}{'tests':>8}{'files':>7}")
        for name, (code, comments, tests, count) in sorted(packages(files("*.rs")).items()):
            print(f"{code:8}{comments:10}{tests:8}{count:7}  {name}")
        return
    both = files("*.rs", "*.py")
    rust = files("*.rs")
    code = without_tests(rust)
    alike = types_alike(code)
    lists = {f for f, t in code.items() if re.search(r"\b(frictions|Friction)\b", t)}
    rows = [
        ("lines of Rust and Python", lines_of(both)),
        ("of these no tests, benches, examples (Rust)", lines_of(code)),
        ("lines of crates/doors/src, crates/paper-component/src, crates/machine-component/src", sum(lines_of(files(f"{d}/*.rs")) for d in ("crates/doors/src", "crates/paper-component/src", "crates/machine-component/src"))),
        ("Rust files beyond 400 lines", sum(t.count("\n") > 400 for t in rust.values())),
        (f"comment lines wider than {WIDTH} columns", len(wide_comments(both))),
        ('documentation that begins "The same"', same(rust)),
        (f"names that {ALIKE} or more types share", len(alike)),
        ("files without tests that name frictions beside the other elements", len(lists)),
        (
            "functions of the doors' traits that a component is written by (Model, Hybrid)",
            sum(functions_of_trait(both[f"crates/doors/src/{name.lower()}.rs"], name) for name in ("Model", "Hybrid")),
        ),
        (
            "of these without a default",
            sum(required_of_trait(both[f"crates/doors/src/{name.lower()}.rs"], name) for name in ("Model", "Hybrid")),
        ),
        ("words of README.md", len((ROOT / "README.md").read_text().split())),
        ("packages in Cargo.lock", (ROOT / "Cargo.lock").read_text().count("[[package]]")),
    ]
    for what, count in rows:
        print(f"{count:8}  {what}")
    if args.names:
        for name, where in sorted(alike.items(), key=lambda pair: -len(pair[1])):
            print(f"{len(where):3} {name}: {' '.join(where)}")
    if args.wide:
        print("\n".join(wide_comments(both)))


if __name__ == "__main__":
    main()
