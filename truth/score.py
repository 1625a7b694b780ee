"""Scores a host of FMI or a solver by the cases of this suite.

    python truth/score.py fmpy                                 # all ways of fmpy, by the archives of build.py
    python truth/score.py fmpy --way "FMI 3.0 ME, CVode"
    python truth/score.py wasmtime                             # the components of archives made with --wasm
    python truth/score.py --command "HOST --stop {stop} --interval {step} --output {output} {fmu3}"
    python truth/score.py --results FOLDER                     # NAME.csv and, if there is one, NAME.events.csv

In a command, {fmu2} and {fmu3} are the archives of both versions, {machine} the file, {stop}, {step} and {steps} the output
times, {output} the table to write, {names} the states with commas between them; {input:OPTION} is OPTION and the file of inputs if the case has inputs, and
{variables:OPTION} is OPTION and a name for each state. A host with {folder} writes states.csv and events.csv into it.

The error of a state is divided by its magnification: the result is the relative error of the start that has the same effect.
One rounding is 1.1e-16. A case passes if no such error and no event is off by more than --limit. The exit status is 1 if a
case fails.
"""

import argparse
import importlib
import sys

import cases
import hosts
from results import BadResult
from verdict import Score, Truth, score_of

LIMIT = 1e-6  # a solver with the tolerance 1e-10 reaches 1e-7 in most cases


def scores(run, chosen, limit):
    """The scores of all cases by one way."""
    for name in chosen:
        truth = Truth(cases.Case(name))
        try:
            yield score_of(truth, run(truth.case, truth.names), limit)
        except BadResult as error:
            yield Score(name, reasons=[str(error)])


def brief(error):
    """An error in one digit; below a tenth of a rounding it is 0."""
    return f"{error:.0e}" if error > 1e-17 else "0"


def cell(score):
    if score.error is None:
        return "**no result**"
    shown = brief(score.error)
    if score.missed is not None:
        shown += f", {score.missed} missed" if score.missed else f", {brief(score.late)}"
    return shown if score.passed else f"**{shown}**"


def table(columns):
    """A table in Markdown: a row for each case, a column for each way."""
    names = [score.case for score in next(iter(columns.values()))]
    lines = ["| case | " + " | ".join(columns) + " |", "|---" * (1 + len(columns)) + "|"]
    for k, name in enumerate(names):
        lines.append(f"| `{name}` | " + " | ".join(cell(column[k]) for column in columns.values()) + " |")
    passed = [sum(score.passed for score in column) for column in columns.values()]
    lines.append("| passed | " + " | ".join(f"{count} of {len(names)}" for count in passed) + " |")
    return "\n".join(lines)


def reasons(columns):
    lines = []
    for way, column in columns.items():
        for score in column:
            if score.reasons:
                why = f" This case fails if {cases.Case(score.case).about['fails_if']}." if score.error is not None else ""
                lines.append(f"- {way}, `{score.case}`: {'; '.join(score.reasons)}.{why}")
    return "\n".join(lines)


def positive(text):
    """A finite number above zero."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise ValueError
    return value


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("host", nargs="?", choices=["fmpy", "wasmtime"], help="a host that this script drives")
    parser.add_argument("--command", help="the command line of another host")
    parser.add_argument("--results", metavar="FOLDER", help="a folder with a table for each case")
    parser.add_argument("--way", action="append", choices=sorted(hosts.FMPY), help="only this way of fmpy")
    parser.add_argument("--archives", default=hosts.TARGET, metavar="FOLDER", help="folder of the FMUs (default target/truth)")
    parser.add_argument("--case", action="append", choices=cases.names(), metavar="NAME", help="only this case")
    parser.add_argument("--limit", type=positive, default=LIMIT, help=f"largest error that passes (default {LIMIT:g})")
    parser.add_argument("--title", default="result", help="head of the column of --command and --results")
    given = parser.parse_args(arguments)
    if sum(map(bool, (given.host, given.command, given.results))) != 1:
        parser.error("expected one of: a host, --command, --results")
    if given.host:
        try:
            importlib.import_module(given.host)
        except ImportError:
            parser.error(f"{given.host} is not installed: run `pip install {given.host}`")
    if given.host == "wasmtime":
        ways = {"wasmtime, FMI 3.0 CS": hosts.by_wasmtime(given.archives)}
    elif given.host:
        ways = {way: hosts.by_fmpy(way, given.archives) for way in given.way or hosts.FMPY}
    else:
        ways = {given.title: hosts.by_command(given.command, given.archives) if given.command else hosts.by_folder(given.results)}
    chosen = given.case or cases.names()
    columns = {way: list(scores(run, chosen, given.limit)) for way, run in ways.items()}
    print(table(columns))
    if why := reasons(columns):
        print("\n" + why)
    return 0 if all(score.passed for column in columns.values() for score in column) else 1


if __name__ == "__main__":
    sys.exit(main())
