"""Makes the tables of cases: python make.py [--pages] [CASE ...]; without names, of all; with --pages only their pages.

`truth.csv` has the states at the output times, `events.csv` every event. Each value has its magnification: the error of
this value for an error of 1, relative to its size, of any state or the clock at the start, at one of eight earlier times, or, for an event, just before it.
It is found by moving each of these numbers by 1e-15 and following the motion again in 57 digits.
"""

import sys
import time as clock

from gmpy2 import mpfr

import cases
import page
from digits import digits, real
from machine import read
from motion import Motion

NUDGE = mpfr("1e-15")  # 57 digits leave 20 of the difference
RESTARTS = 8
NEAR_TIME = mpfr("1e-60")


def text(x, digits=30):
    """A number in significant digits."""
    if x == 0:
        return "0"
    mantissa, exponent, _ = x.digits(10, digits)
    sign, mantissa = ("-", mantissa[1:]) if mantissa[0] == "-" else ("", mantissa)
    shown = f"{sign}{mantissa[0]}.{mantissa[1:].rstrip('0') or '0'}"
    return shown if exponent == 1 else f"{shown}e{exponent - 1}"


def short(x):
    return f"{float(x):.3g}"


class Magnification:
    def __init__(self, motion, times, states, events):
        self.motion, self.times, self.states, self.events = motion, times, states, events
        self.free = motion.m.free()
        at_outputs = [z for _, left, right in states for z in (left, right) if z]
        size = lambda get: max(abs(get(z)) for z in at_outputs) or mpfr(1)
        self.sizes = [size(lambda z, i=i: z.s[i]) for i in self.free] + [size(lambda z, i=i: z.v[i]) for i in self.free]
        self.of_states = [[list(self.sizes) for _ in row[1:]] for row in states]
        self.of_events = [max(row[0], mpfr("1e-300")) for row in events]

    def at_events(self, slopes):
        """Adds the effect of errors just before an event: they count against the rate at which it is approached."""
        for time, found in slopes:
            for name, effects in found:
                local = sum(size * effect for size, effect in zip(self.sizes, effects))
                for k, row in enumerate(self.events):
                    if abs(row[0] - time) < NEAR_TIME and row[2].endswith(f".{name}"):
                        self.of_events[k] = max(self.of_events[k], local)

    def at_jumps(self):
        """Replaces the magnifications at events by the largest ones of the outputs around.

        A motion that has not yet come to its event differs from one that has by the jump, whatever the error.
        """
        single = [k for k, (_, left, _) in enumerate(self.states) if left is None]
        for k, (_, left, _) in enumerate(self.states):
            if left is not None:
                around = [max((j for j in single if j < k), default=None), min((j for j in single if j > k), default=None)]
                rows = [self.of_states[j][1] for j in around if j is not None]
                self.of_states[k] = [list(map(max, *rows, rows[0])) for _ in range(2)]

    def values(self, z):
        return [z.s[i] for i in self.free] + [z.v[i] for i in self.free]

    @staticmethod
    def keyed(events):
        """(kind, element, how many before it) of each event, after which its time is looked up."""
        seen, keys = {}, []
        for row in events:
            count = seen[row[1:3]] = seen.get(row[1:3], 0) + 1
            keys.append((*row[1:3], count))
        return keys

    def moved(self, first, j):
        """The motion from a state with number j moved; None if neither direction is possible."""
        n = len(self.free)
        for nudge in (NUDGE, -NUDGE):
            z = first.copy()
            if j < n:
                z.s[self.free[j]] += nudge * self.sizes[j]
            elif j < 2 * n:
                z.v[self.free[j - n]] += nudge * self.sizes[j]
            else:
                z.time += nudge * self.times[-1]
            self.motion.hold(z)
            try:
                return self.motion.run(self.times, z)
            except RuntimeError:
                continue
        return None

    def from_start(self, k):
        """Adds the effects of errors at output k."""
        first = self.states[k][2]
        n = len(self.free)
        sums = [[[mpfr(0)] * (2 * n) for _ in row[1:]] for row in self.states]
        late = [mpfr(0)] * len(self.events)
        skipped = sum(1 for row in self.events if row[0] <= first.time)
        for j in range(2 * n + 1):
            run = self.moved(first, j)
            if run is None:
                continue
            states, events = run
            for row, (_, left, right), total in zip(states, self.states[-len(states):], sums[-len(states):]):
                for side, (new, old) in enumerate(((row[1], left), (row[2], right))):
                    if new and old:
                        for i, (a, b) in enumerate(zip(self.values(new), self.values(old))):
                            total[side][i] += abs(a - b) / NUDGE
            new, last = dict(zip(self.keyed(events), events)), {}
            for index, key in enumerate(self.keyed(self.events[skipped:]), skipped):
                if key in new:
                    last[key[:2]] = abs(new[key][0] - self.events[index][0]) / NUDGE
                late[index] += last.get(key[:2], 0)  # a bounce too small for 57 digits: as the one before it
        for row, total in zip(self.of_states, sums):
            for side, sides in enumerate(total):
                row[side] = [max(a, b) for a, b in zip(row[side], sides)]
        self.of_events = [max(a, b) for a, b in zip(self.of_events, late)]


def make(name):
    begun = clock.time()
    case = cases.Case(name)
    machine = read(case.folder, case.stop)
    motion = Motion(machine, case.stop)
    times = [real(t) for t in case.times()]
    states, events = motion.run(times)
    found = Magnification(motion, times, states, events)
    found.at_events(motion.slopes)
    every = max(1, len(states) // RESTARTS)
    digits(False)
    for k in [k for k in range(0, len(states) - 1, every) if states[k][1] is None]:
        found.from_start(k)
    digits(True)
    found.at_jumps()
    write_truth(case, machine, states, found)
    write_events(case, motion, states, events, found)
    print(f"{name}: {len(events)} events, {clock.time() - begun:.1f} s", flush=True)


def write_truth(case, machine, states, found):
    names = case.states(machine)
    n = len(found.free)
    order = [k for i in range(n) for k in (i, n + i)]
    lines = [",".join(["time"] + names + [f"{name} magnification" for name in names])]
    for (time, left, right), magnified in zip(states, found.of_states):
        for z, m in zip((left, right), magnified):
            if z:
                values = found.values(z)
                lines.append(",".join([text(time)] + [text(values[k]) for k in order] + [short(m[k]) for k in order]))
    (case.folder / "truth.csv").write_text("\n".join(lines) + "\n")


def required(events, stop):
    """An event is required of a host unless another one of its element is nearer than a millionth of the run."""
    apart = real(stop) * mpfr("1e-6")
    out = []
    for k, row in enumerate(events):
        same = [abs(other[0] - row[0]) for j, other in enumerate(events) if j != k and other[2] == row[2] and other[0] != row[0]]
        near = row[1] != "close" and same and min(same) < apart
        pushed = row[1] == "impact" and not row[3]  # a stop at rest that takes a share of an impulse
        out.append("no" if row[1] in ("knot", "sample") or near or pushed else "yes")
    return out


def write_events(case, motion, states, events, found):
    lines = ["time,kind,element,value,magnification,required"]
    for part in motion.elements:
        state = found.states[0][2].mode[part.name]
        if state != "":
            lines.append(f"0,start,{part.section},{state},0,no")
    for (time, kind, section, value), m, need in zip(events, found.of_events, required(events, case.stop)):
        lines.append(f"{text(time, 50)},{kind},{section},{'' if value is None else text(value, 20)},{short(m)},{need}")
    (case.folder / "events.csv").write_text("\n".join(lines) + "\n")


def write_page(name):
    case = cases.Case(name)
    (case.folder / cases.PAGE).write_text(page.page(case, read(case.folder, case.stop)))


def main():
    pages = "--pages" in sys.argv
    for name in [word for word in sys.argv[1:] if word != "--pages"] or cases.names():
        write_page(name)
        if not pages:
            make(name)


if __name__ == "__main__":
    main()
