"""Rows and events that a host or a solver wrote for a case, checked by row and column."""

import csv
import difflib
import sys
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path


LARGEST = sys.float_info.max_10_exp


class BadResult(Exception):
    """A result that cannot be scored; the message names file, row and column."""


@dataclass
class Result:
    """Rows of (time, values by name), in order; events of (time, kind, element), None if the host writes none."""

    rows: list
    events: list = None


def number(text, where):
    try:
        value = Decimal(text.strip())
    except (InvalidOperation, AttributeError):
        raise BadResult(f"{where} is {text!r}: expected a number") from None
    if not value.is_finite():
        raise BadResult(f"{where} is {text!r}: expected a finite number")
    if value and value.adjusted() > LARGEST:
        raise BadResult(f"{where} is {text!r}: expected a number of the size of a double")
    return value


def read_table(path, columns):
    """Heads, and the rows that are not empty as (count, cells)."""
    path = Path(path)
    if not path.is_file():
        raise BadResult(f"{path}: no such file")
    try:
        lines = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines()))
    except UnicodeDecodeError as error:
        raise BadResult(f"{path}: byte {error.start} is {error.object[error.start]:#04x}; expected text in UTF-8") from None
    if not lines:
        raise BadResult(f"{path}: is empty; expected a first row with the columns {', '.join(columns)}")
    heads = [head.strip().strip('"') for head in lines[0]]
    rows = []
    for count, cells in enumerate(lines[1:], 2):
        if cells and (len(cells) < len(heads) or any(cells[len(heads):])):
            raise BadResult(f"{path}: row {count} has {len(cells)} cells; expected {len(heads)}")
        if cells:
            rows.append((count, cells))
    return heads, rows


def read_rows(path, names):
    """Rows of a table with the columns `time` and `names`; other columns are ignored."""
    heads, lines = read_table(path, ["time", *names])
    places = {}
    for name in ["time", *names]:
        if name not in heads:
            near = difflib.get_close_matches(name, heads, 1)
            hint = f"; did you mean to rename `{near[0]}`?" if near else ""
            raise BadResult(f"{path}: row 1 has no column `{name}`; it has {', '.join(heads)}{hint}")
        places[name] = heads.index(name)
    rows = []
    for count, cells in lines:
        at = {name: number(cells[k], f"{path}: row {count}, column `{name}`") for name, k in places.items()}
        time = at.pop("time")
        if rows and time < rows[-1][0]:
            raise BadResult(f"{path}: row {count} has the time {time}, before the time {rows[-1][0]} of the row above; expected rising times")
        rows.append((time, at))
    return rows


def read_events(path):
    """Events of a table with the column `time` and, if present, `kind` and `element`; states of the start are none."""
    heads, lines = read_table(path, ["time", "kind", "element"])
    if "time" not in heads:
        raise BadResult(f"{path}: row 1 has no column `time`; it has {', '.join(heads)}")
    events = []
    for count, cells in lines:
        row = dict(zip(heads, cells))
        events.append((number(row["time"], f"{path}: row {count}, column `time`"), row.get("kind", ""), row.get("element", "")))
    return [event for event in events if event[1] != "start"]


def events_of_rows(rows, times):
    """Times at which a host wrote a row twice, or a row between the output times; None without any."""
    step = times[1] - times[0]
    found, last = [], None
    for time, _ in rows:
        on_grid = abs(time / step - round(time / step)) < Decimal("1e-6")
        if (last is not None and time == last or not on_grid) and (not found or found[-1][0] != time):
            found.append((time, "", ""))
        last = time
    return found or None
