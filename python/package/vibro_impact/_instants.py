"""Reporting times of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Optional, Union

import numpy as np

from ._arguments import MOST_PERIODS, Floats, array, number, seconds, whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: Largest number of samples of a motion.
MOST_SAMPLES = 100_000_000


def after(name: str, value: object, begin: float) -> float:
    """Returns `value` as a finite number greater than `begin`."""
    found = number(name, value)
    if not found > begin:
        raise ValueError(f"{name} = {value!r}: must be greater than {begin:g}")
    return found


def listed(times: ArrayLike, begin: float) -> Floats:
    """Returns ascending times that are not before the initial time `begin`."""
    t: Floats = array("times", times, "an array of shape (n,) of times in s").copy()
    allowed = f"expected at least one time, with finite, ascending times >= {begin:g}"
    if len(t) == 0:
        raise ValueError(f"times is empty: {allowed}")
    if not t[0] >= begin:
        raise ValueError(f"times[0] = {t[0]:.12g}: {allowed}")
    falls = np.flatnonzero(np.diff(t) < 0)
    if len(falls):
        i = falls[0] + 1
        raise ValueError(f"times[{i}] = {t[i]:.12g} after {t[i - 1]:.12g}: {allowed}")
    return t


def instants(
    begin: float,
    period: float,
    until: Union[None, float, str],
    periods: Optional[int],
    times: Optional[ArrayLike],
    samples: int,
    per_period: int,
) -> Floats:
    """Returns report times from the initial time on: equal parts until a time or of each period, or the listed times."""
    given = [name for name, value in (("until", until), ("periods", periods), ("times", times)) if value is not None]
    if len(given) != 1:
        raise TypeError(f"{', '.join(given) or 'neither until, periods nor times'}: expected exactly one of until, periods and times")
    if times is not None:
        return listed(times, begin)
    if until is not None:
        end = after("until", seconds("until", until), begin)
        count = whole("samples", samples, 1, MOST_SAMPLES - 1)
        return np.array([end if k == count else begin + (end - begin) * k / count for k in range(count + 1)])
    count = whole("periods", periods, 0, MOST_PERIODS)
    if not np.isfinite(period):
        raise ValueError(f"periods = {periods}: nothing drives the machine periodically; use until or times")
    rows = whole("per_period", per_period, 1, MOST_SAMPLES) * count + 1
    whole("periods * per_period + 1", rows, 1, MOST_SAMPLES)
    if not np.isfinite(begin + period * rows):
        raise ValueError(f"periods = {periods}: the run must end at a finite time")
    found: Floats = begin + period * np.arange(rows) / per_period
    return found
