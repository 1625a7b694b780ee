"""The score of one result: largest error divided by its magnification, missed and late events, reasons of a failure."""

import bisect
from dataclasses import dataclass, field
from decimal import Decimal

import cases
from results import BadResult, events_of_rows

# Fraction of a step within which a time is an output time: some hosts print nine digits.
SAME_TIME = Decimal("1e-6")
# Largest error relative to the largest value. In chaos the magnification alone allows any error.
DIGITS_LEFT = Decimal("0.01")


@dataclass
class Score:
    case: str
    error: float = None
    first_wrong: str = ""
    missed: int = None
    extra: int = 0
    late: float = None
    reasons: list = field(default_factory=list)

    @property
    def passed(self):
        return not self.reasons


class Truth:
    """The tables of a case as numbers."""

    def __init__(self, case):
        self.case = case
        rows = cases.read_truth(case)
        self.names = [key for key in rows[0] if key != "time" and not key.endswith(" magnification")]
        self.rows = []  # (time, [(values, magnifications), ...]): two sides if an event is at the output time
        for row in rows:
            side = {n: Decimal(row[n]) for n in self.names}, {n: Decimal(row[f"{n} magnification"]) for n in self.names}
            time = Decimal(row["time"])
            if self.rows and self.rows[-1][0] == time:
                self.rows[-1][1].append(side)
            else:
                self.rows.append((time, [side]))
        self.times = [time for time, _ in self.rows]
        self.step = self.times[1] - self.times[0]
        self.sizes = {n: max(abs(values[n]) for _, sides in self.rows for values, _ in sides) or 1 for n in self.names}
        self.events = [
            (Decimal(row["time"]), row["kind"], row["element"], Decimal(row["magnification"]), row["required"] == "yes")
            for row in cases.read_events(case) if row["kind"] != "start"
        ]


def magnified(values, side):
    """Largest error of a row, divided by its magnification."""
    truth, magnification = side
    return max(abs(values[name] - truth[name]) / magnification[name] for name in truth)


def digits_lost(values, side, sizes):
    """Largest error of a row, relative to the largest value of its state."""
    return max(abs(values[name] - value) / sizes[name] for name, value in side[0].items())


def state_errors(truth, result):
    """Two errors of each output: divided by the magnification, and relative to the largest value.

    The row of an output time is the last one there; at an event the nearer side counts.
    """
    times = [time for time, _ in result.rows]
    errors = []
    for k, (time, sides) in enumerate(truth.rows):
        low = bisect.bisect_left(times, time - SAME_TIME * truth.step)
        high = bisect.bisect_right(times, time + SAME_TIME * truth.step)
        if low == high and k == 0:
            errors.append((Decimal(0), Decimal(0)))  # some hosts write no row before their first step
            continue
        if low == high:
            raise BadResult(f"no row has the time {time:f} s, output {k} of {len(truth.rows) - 1}; the table has {len(times)} rows up to {times[-1] if times else 0:f} s")
        values = result.rows[high - 1][1]
        errors.append(min((magnified(values, side), digits_lost(values, side, truth.sizes)) for side in sides))
    return errors


def a_step_late(truth, result, limit):
    """Whether each row has the state of the output before it."""
    found = {time: values for time, values in result.rows}
    pairs = [(found.get(time), before) for (time, _), (_, before) in zip(truth.rows[1:], truth.rows)]
    return all(values and min(magnified(values, side) for side in sides) <= limit for values, sides in pairs)


def instants(events):
    """(time, magnification, required, names) of each instant with events."""
    out = []
    for time, kind, element, magnification, required in events:
        if out and out[-1][0] == time:
            out[-1][2] |= required
            out[-1][3].append(f"{kind} {element}".strip())
        else:
            out.append([time, magnification, required, [f"{kind} {element}".strip()]])
    return out


def match_events(truth, events, limit, score, listed):
    """Matches each required event with the nearest one of the host; of its kind and element if the host writes them.

    Added events are counted if the host has a list of them: rows between the outputs may have other reasons.
    """
    named = any(kind for _, kind, _ in events)
    wanted = truth.events if named else [(t, "", "", m, r) for t, m, r, _ in instants(truth.events)]
    score.missed, score.late, late = 0, 0.0, ""
    for time, kind, element, magnification, required in wanted:
        if not required:
            continue
        times = [t for t, k, e in events if (k, e) == (kind, element)]
        nearest = min(times, key=lambda t: abs(t - time), default=None)
        off = None if nearest is None else abs(nearest - time) / magnification
        if off is None or off > limit and abs(nearest - time) > truth.step:
            score.missed += 1
            what = f"{kind} {element}".strip() or "the event"
            if score.missed == 1:
                score.reasons.append(f"{what} at {float(time):.9g} s is missed")
            continue
        score.late = max(score.late, float(off))
        if (off > limit or abs(nearest - time) > truth.step * DIGITS_LEFT) and not late:
            late = f"an event at {float(time):.9g} s is off by {float(nearest - time):.2g} s, {float(off):.1e} of its magnification"
    if late:
        score.reasons.append(late)
    if named or listed:
        score.extra = sum(is_extra(truth, event, limit) for event in events)
    if score.extra:
        score.reasons.append(f"{score.extra} events that do not happen")


def is_extra(truth, event, limit):
    """Whether no event of the same element is near, without a kind of any; a second name for an event does not count."""
    time, kind, element = event
    near = (abs(t - time) <= limit * m for t, _, e, m, _ in truth.events if e == element or not kind)
    return kind not in ("knot", "sample") and not any(near)


def score_of(truth, result, limit):
    """The score of a result; passed if it has no reasons."""
    score = Score(truth.case.name)
    limit = Decimal(repr(limit))
    try:
        errors = state_errors(truth, result)
    except BadResult as error:
        score.reasons.append(str(error))
        return score
    score.error = float(max(error for error, _ in errors))
    wrong = next((k for k, (error, lost) in enumerate(errors) if error > limit or lost > DIGITS_LEFT), None)
    if wrong is not None:
        score.reasons.append(where_wrong(truth, result, errors, wrong, limit))
    events = result.events if result.events is not None else events_of_rows(result.rows, truth.times)
    if events is not None and truth.events:
        match_events(truth, events, limit, score, result.events is not None)
    elif events and not truth.events:
        score.extra = len(events)
        score.reasons.append(f"{score.extra} events that do not happen")
    return score


def where_wrong(truth, result, errors, k, limit):
    """The reason of a wrong state, with the last event before it."""
    time = truth.times[k]
    if a_step_late(truth, result, limit):
        return "each row has the state of one communication step before"
    before = [row for row in instants([e for e in truth.events if e[1] not in ("knot", "sample")]) if row[0] <= time]
    last = f"; the last event before is {', '.join(before[-1][3][:2])} at {float(before[-1][0]):.9g} s" if before else ""
    error, lost = map(float, errors[k])
    return f"wrong from {float(time):.9g} s on by {error:.1e} of the magnification, {lost:.1e} of the largest value{last}"
