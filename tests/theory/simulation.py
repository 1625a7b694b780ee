"""An independent motion, computed from the equations of motion: Taylor series in flight, Newton's method for the stops.

The state is x1, x2, x3, their velocities and the phase of the drive, in SI units. Nothing here uses the page.
"""

from dataclasses import dataclass, field
from typing import Any, Dict, List, Tuple

import mpmath

DIGITS = 30
STEP = 0.25  # short enough to find every impact
STRIDE = 0.6  # if no impact has to be found; 0.6**28 / 28! is far below the digits
TERMS = 28
GUARD = mpmath.mpf(10) ** -20

Parameters = Dict[str, Any]
State = List[Any]


def basic(**changes: float) -> Parameters:
    """The default data set in unit scales, as decimal fractions; with loads zero."""
    p = dict(m_1="1", k_1="1", c_1="0.1", m_2="0.1", m_3="0.1", k_3="0.1", c_3="0.006", k_23="0.006",
             L="1", kappa="0.75", F_10="0.15", omega_1="1.04")  # fmt: skip
    return {**{k: mpmath.mpf(v) for k, v in p.items()}, **{k: mpmath.mpf(str(v)) for k, v in changes.items()}}


def other() -> Parameters:
    """A data set without ones and small numbers."""
    return basic(m_1=2, k_1=3, c_1=0.25, m_2=0.7, m_3=1.3, k_3=2.1, c_3=0.15, k_23=0.4, L=0.8, kappa=0.6, F_10=2.5, omega_1=1.5)


def accelerations(p: Parameters, z: State) -> List[Any]:
    x_1, x_2, x_3, v_1, _, v_3, theta = z
    return [
        (p["F_10"] * mpmath.sin(theta) - p["c_1"] * v_1 - p["k_1"] * x_1) / p["m_1"],
        -p["k_23"] * (x_2 - x_3) / p["m_2"],
        (-p["k_3"] * x_3 - p["c_3"] * v_3 - p["k_23"] * (x_3 - x_2)) / p["m_3"],
    ]


def series(p: Parameters, z: State) -> List[List[Any]]:
    """Taylor coefficients of x1, x2, x3 about a state."""
    x = [[z[i], z[i + 3]] for i in range(3)]
    sine, cosine = mpmath.sin(z[6]), mpmath.cos(z[6])
    turns = [sine, cosine, -sine, -cosine]
    k_1, c_1 = p["k_1"] / p["m_1"], p["c_1"] / p["m_1"]
    k_3, c_3 = p["k_3"] / p["m_3"], p["c_3"] / p["m_3"]
    k_2, k_23 = p["k_23"] / p["m_2"], p["k_23"] / p["m_3"]
    drive = p["F_10"] / p["m_1"]
    for k in range(TERMS):
        stretch = x[1][k] - x[2][k]
        both = (k + 1) * (k + 2)
        x[0].append((drive * turns[k % 4] - c_1 * (k + 1) * x[0][k + 1] - k_1 * x[0][k]) / both)
        x[1].append(-k_2 * stretch / both)
        x[2].append((k_23 * stretch - k_3 * x[2][k] - c_3 * (k + 1) * x[2][k + 1]) / both)
        drive = drive * p["omega_1"] / (k + 1)
    return x


def value(c: List[Any], h: Any) -> Any:
    return mpmath.polyval(c[::-1], h)


def slope(c: List[Any], h: Any) -> Any:
    return mpmath.polyval([k * a for k, a in enumerate(c)][:0:-1], h)


def at(p: Parameters, z: State, x: List[List[Any]], h: Any) -> State:
    return [value(c, h) for c in x] + [slope(c, h) for c in x] + [z[6] + p["omega_1"] * h]


def flight(p: Parameters, z: State, span: Any) -> State:
    """The free flight over a time, backwards too."""
    count = max(1, int(mpmath.ceil(abs(span) / STRIDE)))
    for _ in range(count):
        z = at(p, z, series(p, z), span / count)
    return z


def strike(p: Parameters, z: State) -> State:
    """The velocities after an impact, by momentum and restitution."""
    m_1, m_2 = p["m_1"], p["m_2"]
    mean = (m_1 * z[3] + m_2 * z[4]) / (m_1 + m_2)
    rebound = -p["kappa"] * (z[4] - z[3])
    return z[:3] + [mean - m_2 / (m_1 + m_2) * rebound, mean + m_1 / (m_1 + m_2) * rebound] + z[5:]


@dataclass
class Run:
    """The end of a motion, and its pieces: (time, length, start, before the impact, after it)."""

    end: State
    impacts: List[Tuple[Any, State, State]] = field(default_factory=list)
    pieces: List[Tuple[State, Any]] = field(default_factory=list)


def run(p: Parameters, z: State, end: Any) -> Run:
    """The motion up to a time, with all its impacts."""
    found = Run(z)
    time = mpmath.mpf(0)
    while end - time > GUARD:
        h = min(mpmath.mpf(STEP), end - time)
        x = series(p, z)
        gap = [b - a for a, b in zip(x[0], x[1])]
        late = value(gap, h)
        if abs(late) > p["L"] + GUARD:
            side = mpmath.sign(late)
            h = mpmath.findroot(lambda t: side * value(gap, t) - p["L"], (h / 2, h))
            before = at(p, z, x, h)
            found.pieces.append((z, h))
            z = strike(p, before)
            time += h
            found.impacts.append((time, before, z))
            continue
        found.pieces.append((z, h))
        z = at(p, z, x, h)
        time += h
    found.end = z
    return found


def differences(map: Any, z: State, step: Any) -> Any:
    """The derivative of a map of states, by central differences."""
    columns = []
    for j in range(len(z)):
        up = map([x + (step if i == j else 0) for i, x in enumerate(z)])
        down = map([x - (step if i == j else 0) for i, x in enumerate(z)])
        columns.append([(a - b) / (2 * step) for a, b in zip(up, down)])
    return mpmath.matrix(columns).T
