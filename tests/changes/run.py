#!/usr/bin/env python3
"""Mutation tests: small changes of a package's source, which its tests should catch.

    python3 tests/changes/run.py --package vibro-machine --count 40 --seed 1

draws changes at random from a seed, or takes the changes of a file (`--named`), applies one at a time in a copy of the repository with
a separate target folder, and runs the package's test binaries until one fails. It prints a line for each change: caught, SURVIVED,
equivalent (named with its reason in `equivalent.toml`), or not compiled (drawn again). The exit status is 1 if a change survives.
Nothing in this folder is run by `cargo test`.
"""

import argparse
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# Files of each package for drawn changes, unless `--files` names some.
FILES = {
    "vibro-machine": [
        "crates/machine/src/law",
        "crates/machine/src/motion",
        "crates/machine/src/flow",
        "crates/machine/src/flow.rs",
        "crates/machine/src/energy",
        "crates/machine/src/energy.rs",
        "crates/machine/src/mode",
        "crates/machine/src/mode.rs",
        "crates/machine/src/rest",
        "crates/machine/src/rest.rs",
        "crates/machine/src/signals.rs",
    ],
    "vibro-studies": ["crates/studies/src"],
    "vibro-machine-component": ["crates/machine-component/src"],
}

# A test binary counts as hanging after this many times its time without a change, plus this many
# seconds.
SLOWER, MORE = 10.0, 60.0

# Only the changed package is compiled again: a third of the time, with the same arithmetic.
PARTS = 64

# Integers up to this one are indices, exponents and factors. Larger ones are limits of loops and
# the like; a change by one does not affect any result. Floats beyond this limit, or below its
# inverse, are tolerances; so are constants.
MEANT, LIMIT = 2, 1e4

# Pairs that are swapped in both directions. Operators have blanks around them, as rustfmt writes.
# `<` for `<=` is omitted: on floats, the most common operands, it changes only a null set.
SWAPS = [
    (" + ", " - "),
    (" * ", " / "),
    (" += ", " -= "),
    (" *= ", " /= "),
    (" < ", " > "),
    (" <= ", " >= "),
    (" == ", " != "),
    (" && ", " || "),
    (".min(", ".max("),
    ("f64::min", "f64::max"),
    ("min_by(", "max_by("),
    (".any(", ".all("),
    (".is_some()", ".is_none()"),
    ("true", "false"),
]
# Replacements in one direction: the reverse would give code that no one writes.
PUTS = [(" % ", " * ")]
NUMBER = re.compile(r"(?<![\w.])(\d[\d_]*\.\d+(?:e-?\d+)?|\d[\d_]*(?:e-?\d+)?)(?![\w.]|\.\w)")
NEGATIVE = re.compile(r"(?:(?<=[(,=\[{|] )|(?<=[(\[|]))-(?=[\w(&*])")
CONDITION = re.compile(r"\b(if|while) (?!let\b)([^{}]*[^{} ]) \{")
GUARD = re.compile(r"\.filter\(\|([^|]*)\| ([^{}]*)\)")
STATEMENT = re.compile(r"^\s+(?!let\b|use\b|pub\b|mod\b|type\b|const\b|static\b|return\b|#|//|\}|\)|\]|\.)\S.*;$")


def masked(text):
    """The text with blanks in place of non-code: comments, strings, characters, attributes, and unit tests."""
    keep = list(text)
    pattern = re.compile(
        r"//[^\n]*|/\*.*?\*/|r#\".*?\"#|b?\"(?:\\.|[^\"\\])*\"|b?'(?:\\.|[^'\\])'|#!?\[[^\]\n]*\]", re.S
    )
    for found in pattern.finditer(text):
        for i in range(*found.span()):
            if keep[i] != "\n":
                keep[i] = " "
    tests = re.search(r"^#\[cfg\(test\)\]\s*(?:#\[[^\n]*\]\s*)*mod \w+ \{", text, re.M)
    if tests:
        keep[tests.start() :] = [c if c == "\n" else " " for c in keep[tests.start() :]]
    return "".join(keep)


def other_number(literal, rng):
    """Another constant in place of a literal, or the literal itself if another value would be equally valid: limits and tolerances."""
    if "." not in literal and "e" not in literal:
        value = int(literal.replace("_", ""))
        if value > MEANT:
            return literal
        return str(rng.choice([value + 1] if value == 0 else [value - 1, value + 1]))
    value = float(literal.replace("_", ""))
    if value == 0.0:
        return "1.0"
    if not 1.0 / LIMIT < value < LIMIT:
        return literal
    return repr(rng.choice([2.0 * value, value / 2.0, -value]))


def changes_of_line(line, code, rng):
    """Every small change of a line, given with blanks in place of non-code."""
    found = []

    def put(start, end, text):
        changed = line[:start] + text + line[end:]
        if changed != line:
            found.append(changed)

    for old, new in [*SWAPS, *((other, one) for one, other in SWAPS), *PUTS]:
        for hit in re.finditer(re.escape(old), code):
            put(hit.start(), hit.end(), new)
    for hit in NUMBER.finditer(code) if not re.match(r"\s*(pub(\(\w+\))? )?(const|static) ", code) else ():
        put(hit.start(), hit.end(), other_number(hit.group(), rng))
    for hit in NEGATIVE.finditer(code):
        put(hit.start(), hit.end(), "")
    for hit in re.finditer(r"\.abs\(\)", code):
        put(hit.start(), hit.end(), "")
    for hit in CONDITION.finditer(code):
        put(hit.start(2), hit.end(2), f"!({line[hit.start(2) : hit.end(2)]})")
    for hit in GUARD.finditer(code):
        put(hit.start(2), hit.end(2), f"!({line[hit.start(2) : hit.end(2)]})")
    balanced = all(code.count(a) == code.count(b) for a, b in ("()", "[]", "{}"))
    if STATEMENT.match(code) and balanced:
        found.append("")
    return found


def sites(files, rng):
    """All changes as (file, line number, line, replacement line)."""
    out = []
    for file in files:
        text = (ROOT / file).read_text()
        pairs = zip(text.split("\n"), masked(text).split("\n"))
        for number, (line, code) in enumerate(pairs, 1):
            if re.match(r"\s*(pub |use |impl|struct|enum|mod |type |where)", code) and "fn " not in code:
                if not re.match(r"\s*(pub )?(const|static) ", code):
                    continue
            if re.match(r"\s*(pub(\(\w+\))? )?(const )?fn ", code):
                continue
            out += [(file, number, line, changed) for changed in changes_of_line(line, code, rng)]
    return out


TESTED = re.compile(r"#\[cfg\(test\)\]\s*(?:#\[[^\n]*\]\s*)*(?:pub(?:\(\w+\))? )?mod (\w+);")


def is_test(file):
    """Whether a file is compiled only for tests: its own module, or a parent module, is declared so."""
    for path in [file, *file.parents]:
        if path == ROOT:
            return False
        name, folder = path.stem, path.parent
        for parent in (folder.with_suffix(".rs"), folder / "mod.rs", folder / "lib.rs"):
            if parent.exists() and name in TESTED.findall(parent.read_text()):
                return True
    return False


def files_of(args):
    """The requested Rust files, relative to the root, without test files."""
    out = []

    for name in args.files or FILES.get(args.package, []):
        path = ROOT / name
        found = sorted(path.rglob("*.rs")) if path.is_dir() else [path] if path.exists() else []
        out += [f.relative_to(ROOT).as_posix() for f in found if not is_test(f)]
    if not out:
        sys.exit("no files; expected --files with files or folders of the package")
    return out


def tables(path, key="change"):
    """The tables of a TOML file, or none if the file does not exist."""
    return tomllib.loads(path.read_text()).get(key, []) if path.exists() else []


def named(path):
    """Changes of a file: each has `file`, `from`, `to` (parts of lines, with one occurrence), and `what`."""
    out = []
    for change in tables(path):
        text = (ROOT / change["file"]).read_text()
        if text.count(change["from"]) != 1:
            sys.exit(f"{path.name}: {change['from']!r} occurs {text.count(change['from'])} times in {change['file']}; expected once")
        number = text[: text.index(change["from"])].count("\n") + 1
        out.append((change["file"], number, change["from"], change["to"]))
    return out


class Copy:
    """A copy of the repository with a separate target folder."""

    def __init__(self, folder, package, skips_documents):
        self.folder, self.package, self.skips_documents = folder, package, skips_documents
        self.tree = folder / "tree"
        self.environment = dict(os.environ, CARGO_TARGET_DIR=str(folder / "target"), CARGO_TERM_COLOR="never")
        for name in ("PROPTEST_CASES", "PROPTEST_RNG_SEED", "UPDATE"):
            self.environment.pop(name, None)
        self.bring()
        self.marks = folder / f"marks-{package}.json"
        self.catches = json.loads(self.marks.read_text()) if self.marks.exists() else {}
        self.times = {}

    def bring(self):
        """Copies every file that git tracks or would add, and removes deleted files."""
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True,
        ).stdout.decode()
        files = {f for f in listed.split("\0") if f and (ROOT / f).is_file()}
        for file in sorted(files):
            source, copy = ROOT / file, self.tree / file
            if copy.exists() and copy.read_bytes() == source.read_bytes():
                continue
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, copy)
        for copy in [p for p in self.tree.rglob("*") if p.is_file()]:
            if copy.relative_to(self.tree).as_posix() not in files:
                copy.unlink()

    def binaries(self):
        """The arguments of cargo for each test binary of the package."""
        metadata = subprocess.run(
            ["cargo", "metadata", "--no-deps", "--format-version", "1", "--offline"],
            cwd=self.tree, check=True, capture_output=True, env=self.environment,
        ).stdout
        package = next((p for p in json.loads(metadata)["packages"] if p["name"] == self.package), None)
        if package is None:
            sys.exit(f"--package {self.package}: expected a package of this workspace")
        out = []
        for target in package["targets"]:
            if target["kind"] == ["test"]:
                out.append(("--test", target["name"]))
            elif "lib" in target["kind"] or "rlib" in target["kind"]:
                out += [("--lib",)] if target.get("test", True) else []
                out += [("--doc",)] if target.get("doctest") and not self.skips_documents else []
        return out

    def cargo(self, arguments, limit):
        """Runs cargo; returns its status, None after a timeout, and its output."""
        with tempfile.TemporaryFile("w+") as said:
            parts = f"profile.dev.package.{self.package}.codegen-units={PARTS}"
            quick = ["--config", "profile.dev.incremental=true", "--config", parts]
            process = subprocess.Popen(
                ["cargo", *quick, *arguments], cwd=self.tree, env=self.environment,
                stdout=said, stderr=subprocess.STDOUT, start_new_session=True,
            )
            try:
                status = process.wait(limit)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 9)
                process.wait()
                status = None
            said.seek(0)
            return status, said.read()

    def run(self, binary, limit):
        """Builds and runs a test binary: "passed", "failed", "hangs" or "not compiled", with its seconds and its output."""
        arguments = ["-p", self.package, *binary, "--offline", "-q"]
        if binary != ("--doc",):
            status, said = self.cargo(["test", "--no-run", *arguments], None)
            if status != 0:
                return "not compiled", 0.0, said
        start = time.monotonic()
        status, said = self.cargo(["test", *arguments], limit)
        verdict = {0: "passed", None: "hangs"}.get(status, "failed")
        return verdict, time.monotonic() - start, said

    def baseline(self, again):
        """Every test binary passes without a change; returns the time of each, with `--again` from an earlier run."""
        known = self.folder / f"times-{self.package}.json"
        if again and known.exists():
            self.times = {tuple(name.split()): seconds for name, seconds in json.loads(known.read_text()).items()}
            return
        for binary in self.binaries():
            verdict, seconds, said = self.run(binary, None)
            if verdict != "passed":
                sys.exit(f"{' '.join(binary)} {verdict} without any change:\n{said[-3000:]}")
            self.times[binary] = seconds
            print(f"# {' '.join(binary)}: {seconds:.1f} s", flush=True)
        known.write_text(json.dumps({" ".join(binary): seconds for binary, seconds in self.times.items()}))

    def order(self):
        """The test binaries, most catches per time first; documentation tests last, because they are compiled again."""
        value = lambda b: (b == ("--doc",), -(1 + self.catches.get(" ".join(b), 0)) / (2.0 + self.times[b]))
        return sorted(self.times, key=value)

    def judge(self, change):
        """The verdict on a change, with the test binary that caught it and the failed test."""
        file, number, line, instead = change
        path = self.tree / file
        was = path.read_text()
        if "\n" not in line and was.split("\n")[number - 1] == line:
            lines = was.split("\n")
            lines[number - 1] = instead
            changed = "\n".join(lines)
        else:
            changed = was.replace(line, instead, 1)
        path.write_text(changed)
        try:
            for binary in self.order():
                verdict, _, said = self.run(binary, SLOWER * self.times[binary] + MORE)
                if verdict == "not compiled":
                    return "not compiled", ""
                if verdict != "passed":
                    name = " ".join(binary)
                    self.catches[name] = self.catches.get(name, 0) + 1
                    self.marks.write_text(json.dumps(self.catches))
                    test = re.search(r"^test (.*?) \.\.\. FAILED|^    (\S.*)$", said, re.M)
                    hint = "hangs" if verdict == "hangs" else test and (test.group(1) or test.group(2))
                    return "caught", f"{name} {hint or ''}".strip()
            return "SURVIVED", ""
        finally:
            path.write_text(was)


def is_equivalent(change, known):
    """The reason for which a change is listed as equivalent, if it is."""
    file, _, line, instead = change
    for entry in known:
        if (entry["file"], entry["from"], entry["to"]) == (file, line.strip(), instead.strip()):
            return entry["reason"]
    return None


def show(verdict, change, more):
    file, number, line, instead = change
    flat = lambda text: " ".join(text.split()) or "(dropped)"
    print(f"{verdict:12} {file}:{number}  {flat(line)}  =>  {flat(instead)}" + (f"  [{more}]" if more else ""), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--package", default="vibro-machine", help="package whose tests are run")
    parser.add_argument("--files", nargs="+", help="files or folders to change, from the repository's root")
    parser.add_argument("--count", type=int, default=40, help="number of changes that compile")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random draw")
    parser.add_argument("--named", type=pathlib.Path, help="a file of changes instead of drawn ones")
    parser.add_argument("--list", action="store_true", help="print the first --count changes, and run nothing")
    parser.add_argument("--again", action="store_true", help="trust the unchanged package and its times of the last run in this copy")
    parser.add_argument("--skip-documents", action="store_true", help="do not run the examples of the documentation")
    parser.add_argument("--copy", type=pathlib.Path, help="folder of the copy, kept (default: in the temporary folder)")
    args = parser.parse_args()

    known = tables(HERE / "equivalent.toml")
    if args.named:
        drawn = named(args.named)
        args.count = len(drawn)
    else:
        rng = random.Random(args.seed)
        drawn = sites(files_of(args), rng)
        rng.shuffle(drawn)
    if args.list:
        for change in drawn[: args.count]:
            show("", change, "")
        return
    copy = Copy(args.copy or pathlib.Path(tempfile.gettempdir()) / f"vibro-changes-{args.package}", args.package, args.skip_documents)
    copy.baseline(args.again)
    counts = {}
    for change in drawn:
        if sum(n for verdict, n in counts.items() if verdict != "not compiled") >= args.count:
            break
        reason = is_equivalent(change, known)
        verdict, more = ("equivalent", reason) if reason else copy.judge(change)
        counts[verdict] = counts.get(verdict, 0) + 1
        show(verdict, change, more)
    print("# " + ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items())))
    sys.exit(1 if counts.get("SURVIVED") else 0)


if __name__ == "__main__":
    main()
