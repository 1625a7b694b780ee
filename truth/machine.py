"""The machine file of a case as plain data; every number is the exact value of a double.

Only numbers in SI are accepted here, so that nothing is rounded between the file and the equations.
"""

import csv
import tomllib
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

ZERO = Fraction(0)


class Refused(Exception):
    """A file that this suite cannot read."""


@dataclass
class Signal:
    """constant + sum of amplitude sin(2 pi frequency t + phase) + pieces.

    Each list of pieces has rows (begin, value, end, value at the end): a straight line until `end`,
    None for a constant value. Before the first row the value is `before`.
    """

    constant: Fraction = ZERO
    harmonics: list = field(default_factory=list)
    pieces: list = field(default_factory=list)
    before: list = field(default_factory=list)
    period: Fraction = None  # with which the pieces repeat

    def knots(self):
        return [row[0] for rows in self.pieces for row in rows] + [
            row[2] for rows in self.pieces for row in rows if row[2] is not None
        ]

    def steady(self):
        return not self.harmonics and not self.pieces

    def piece(self, rows, before, time):
        """(begin, value, slope) of the line that is active after `time`."""
        active = None
        for row in rows:
            if row[0] > time:
                break
            active = row
        if active is None:
            return ZERO, before, ZERO
        begin, value, end, later = active
        return begin, value, ZERO if end is None else (later - value) / (end - begin)

    def active(self, time):
        return [self.piece(rows, before, time) for rows, before in zip(self.pieces, self.before)]


@dataclass
class Body:
    name: str
    mass: Fraction = None
    s: Fraction = ZERO
    v: Fraction = ZERO
    weight: Fraction = ZERO
    # Motion of a prescribed body: its position with a constant rate, its rate, or its acceleration.
    position: Signal = None
    rate: Signal = None
    acceleration: Signal = None


@dataclass
class Element:
    kind: str
    name: str
    arms: list
    numbers: dict


@dataclass
class Machine:
    name: str
    bodies: list
    elements: list
    loads: list
    blocks: list

    def free(self):
        return [i for i, body in enumerate(self.bodies) if body.mass is not None]

    def knots(self, stop):
        signals = [s for b in self.bodies for s in (b.rate, b.acceleration) if s]
        signals += [load["signal"] for load in self.loads]
        signals += [x for e in self.elements for x in e.numbers.values() if isinstance(x, Signal)]
        return sorted({t for s in signals for t in s.knots() if 0 < t <= stop})


def number(value, where):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise Refused(f"{where} = {value!r}: expected a number in SI")
    return Fraction(value)


def rows_of(table, hold, where):
    times = [number(row[0], where) for row in table]
    values = [number(row[1], where) for row in table]
    rows = []
    for i, (t, v) in enumerate(zip(times, values)):
        if i + 1 < len(times) and times[i + 1] == t:
            continue  # a jump: the later value applies from here on
        if hold or i + 1 == len(times):
            rows.append((t, v, None, None))
        else:
            rows.append((t, v, times[i + 1], values[i + 1]))
    return rows, values[0]


def repeated(rows, before, period, stop, steps):
    """Rows of every period up to `stop`; in a repeated sum of steps each period begins with its own."""
    out, k = [], 0
    while k * period <= stop:
        if steps and (not rows or rows[0][0] > 0):
            out.append((k * period, before, None, None))
        for begin, value, end, later in rows:
            out.append((k * period + begin, value, None if end is None else k * period + end, later))
        k += 1
    return out


def signal(value, where, stop, given=None):
    if isinstance(value, (int, float)):
        return Signal(number(value, where))
    known = {"constant", "offset", "amplitude", "frequency", "phase", "harmonics", "steps", "table", "interpolation",
             "repeat", "input", "rate", "s", "v", "acceleration", "on", "from", "factor"}
    for key in set(value) - known:
        raise Refused(f"{where}.{key}: this suite has no such key")
    out = Signal(number(value.get("constant", value.get("offset", 0)), where))
    harmonics = list(value.get("harmonics", []))
    if "amplitude" in value:
        harmonics.append(value)
    out.harmonics = [tuple(number(h.get(key, 0), where) for key in ("amplitude", "frequency", "phase")) for h in harmonics]
    out.period = period = number(value["repeat"], where) if "repeat" in value else None
    if "steps" in value:
        total, rows = ZERO, []
        for time, height in value["steps"]:
            total += number(height, where)
            rows.append((number(time, where), total, None, None))
        out.pieces.append(repeated(rows, ZERO, period, stop, True) if period else rows)
        out.before.append(ZERO)
    if "table" in value:
        rows, first = rows_of(value["table"], value.get("interpolation") == "hold", where)
        out.pieces.append(repeated(rows, first, period, stop, False) if period else rows)
        out.before.append(first)
    if value.get("input") and given:
        rows, first = rows_of(*given, where)
        out.pieces.append(rows)
        out.before.append(first)
    return out


def body(name, table, gravity, stop):
    where = f"body.{name}"
    if "motion" not in table:
        start = table.get("start", {})
        mass = number(table.get("mass", table.get("inertia")), where)
        weight = gravity * number(table.get("gravity", 0), where)
        return Body(name, mass, number(start.get("s", 0), where), number(start.get("v", 0), where), weight)
    motion = table["motion"]
    out = Body(name)
    out.s, out.v = number(motion.get("s", 0), where), number(motion.get("v", 0), where)
    if isinstance(motion.get("rate"), dict):
        out.rate = signal(motion["rate"], where, stop)
    elif "acceleration" in motion:
        out.acceleration = signal(motion["acceleration"], where, stop)
    else:
        out.position = signal({k: x for k, x in motion.items() if k != "rate"}, where, stop)
        if out.position.pieces:
            raise Refused(f"{where}: expected harmonics, or a rate or an acceleration with a table")
        out.s, out.v = ZERO, number(motion.get("rate", 0), where)
    return out


SIGNALS = {"friction": ("force", "static"), "stop": ("stiffness",), "spring": ("stiffness",)}
KINDS = ("spring", "damper", "stop", "friction", "freewheel")


def read(folder, stop=ZERO):
    """The machine of a case's folder, with the inputs of `input.csv` (columns: time, then LOAD.input)."""
    folder = Path(folder)
    text = tomllib.loads((folder / "machine.toml").read_text())
    inputs = read_inputs(folder / "input.csv")
    gravity = number(text.get("gravity", 0), "gravity")
    bodies = [body(name, table, gravity, stop) for name, table in text["body"].items()]
    index = {b.name: i for i, b in enumerate(bodies)}
    elements = []
    for kind in KINDS:
        for name, table in text.get(kind, {}).items():
            if "between" in table:
                ends = zip(table["between"], (Fraction(-1), Fraction(1)))
            else:
                ends = ((b, number(a, name)) for b, a in table["arms"].items())
            arms = [(index[b], a) for b, a in ends if b != "ground"]
            numbers = {}
            for key, value in table.items():
                if key in ("between", "arms"):
                    continue
                if key in SIGNALS.get(kind, ()):
                    numbers[key] = signal(value, f"{kind}.{name}", stop)
                elif key == "points":
                    numbers[key] = [(number(e, name), number(f, name)) for e, f in value]
                else:
                    numbers[key] = value if isinstance(value, str) else number(value, f"{kind}.{name}.{key}")
            elements.append(Element(kind, name, arms, numbers))
    loads = []
    for name, table in text.get("load", {}).items():
        load = {"name": name, "on": index[table["on"]], "signal": Signal(), "from": table.get("from")}
        load["factor"] = number(table.get("factor", 1), name)
        if not load["from"]:
            load["signal"] = signal(table, f"load.{name}", stop, inputs.get(f"load.{name}.input"))
        loads.append(load)
    return Machine(text["name"], bodies, elements, loads, blocks(text, index))


def blocks(text, index):
    out = []
    for name, table in text.get("block", {}).items():
        states = table.get("states", len(table.get("a", [])))
        matrix = {k: [[number(x, name) for x in row] for row in table.get(k, [])] for k in "abcd"}
        ways = [(index[i.split(".")[0]], i.split(".")[1]) for i in table["inputs"]]
        out.append({"name": name, "inputs": ways, "states": states, "outputs": table["outputs"],
                    "sample": number(table["sample"], name), **matrix})
    return out


def read_inputs(path):
    """Inputs by name: (rows, whether held). A time that occurs twice is a jump."""
    if not path.exists():
        return {}
    rows = list(csv.reader(path.read_text().splitlines()))
    names = rows[0][1:]
    return {name: ([(float(row[0]), float(row[k + 1])) for row in rows[1:]], False) for k, name in enumerate(names)}
