"""Curves of special points over two parameters: closed forms of a ball on a vibrating table, refusals, pictures."""

import pickle
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import vibro_impact as vi
from vibro_impact import plot

G, OMEGA = 10.0, 20.0
AMPLITUDE, RESTITUTION = "body.table.motion.amplitude", "stop.floor.restitution"
RANGES = {AMPLITUDE: (0.005, 0.06), RESTITUTION: (0.4, 0.8)}
#: Rounding of a special point, in the amplitude's unit of 1 cm.
ROUNDING = 1e-9


def fold(e):
    """Returns the smallest amplitude of one bounce per period."""
    return np.pi * G * (1 - e) / (1 + e) / OMEGA**2


def flip(e):
    """Returns the amplitude at which one bounce per period has the multiplier -1."""
    return np.hypot(fold(e), 2 * G * (1 + e**2) / (1 + e) ** 2 / OMEGA**2)


@pytest.fixture(scope="module")
def branch():
    ball = vi.Machine({
        "name": "Ball", "gravity": G,
        "body": {"ball": {"mass": 1.0, "gravity": -1.0, "start": {"s": 0.024, "v": np.pi * G / OMEGA}},
                 "table": {"motion": {"amplitude": 0.025, "frequency": f"{OMEGA} rad/s"}}},
        "stop": {"floor": {"between": ["ball", "table"], "gap": 0.0, "restitution": 0.6}},
    })  # fmt: skip
    return ball.orbit("impact floor", period="1T").follow(AMPLITUDE, 0.018, 0.05)


@pytest.mark.parametrize(("label", "exact"), [("LP", fold), ("PD", flip)])
def test_closed_form_of_the_fold_and_flip_curves_of_a_ball_on_a_table(branch, label, exact):
    (point,) = np.flatnonzero(branch.labels == label)
    found = branch.locus(point, RANGES)
    assert (found.names, found.label, found.word, found.periods) == ((AMPLITUDE, RESTITUTION), label, "impact floor", 1)
    amplitude, restitution = found.values.T
    np.testing.assert_allclose(amplitude, exact(restitution), rtol=0, atol=0.01 * ROUNDING)
    assert len(amplitude) > 10 and {0.4, 0.8} == {restitution.min(), restitution.max()}
    np.testing.assert_allclose(found.period, 2 * np.pi / OMEGA, rtol=1e-15)
    assert np.isnan(found.angle).all() and found.period.shape == found.labels.shape == amplitude.shape
    assert [name for name, *_ in found.special] == ["EP", "EP"] and set(found.labels) <= {"", *vi.LOCUS_LABELS}


def test_a_branch_from_another_process_has_the_same_curve(branch):
    (point,) = np.flatnonzero(branch.labels == "PD")
    found, again = (one.locus(int(point), RANGES) for one in (branch, pickle.loads(pickle.dumps(branch))))
    assert (found.values == again.values).all()
    kept = pickle.loads(pickle.dumps(found))
    assert repr(kept) == repr(found) and (kept.values == found.values).all() and kept.special == found.special
    # Texts with units, and the second parameter first.
    other = branch.locus(point, {RESTITUTION: (0.4, 0.8), AMPLITUDE: ("5 mm", "60 mm")})
    assert (other.values == found.values).all()


def test_curves_are_drawn_with_their_numbers(branch):
    curves = [branch.locus(point, RANGES) for point in np.flatnonzero(np.isin(branch.labels, ["LP", "PD"]))]
    axes = plot.locus(curves, Figure().add_subplot())
    drawn = [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 1]
    assert len(drawn) == 2 and all((one == curve.values).all() for one, curve in zip(drawn, curves))
    assert (axes.get_xlabel(), axes.get_ylabel()) == (f"{AMPLITUDE} (m)", RESTITUTION)
    assert {text.get_text() for text in axes.get_legend().get_texts()} == {"LP", "PD"}
    assert "<svg" in curves[0]._repr_svg_() and "nan" not in curves[0]._repr_svg_() and AMPLITUDE in curves[0]._repr_html_()
    for wrong, words in [([], "curves is empty"), (3, "is of type int"), ([branch], r"curves\[0\] is of type Branch")]:
        with pytest.raises((TypeError, ValueError), match=words):
            plot.locus(wrong)


@pytest.mark.parametrize(
    ("ranges", "error", "words"),
    [
        (None, TypeError, "expected the branch's parameter and a second one"),
        ({AMPLITUDE: (0.005, 0.06)}, TypeError, "expected the branch's parameter and a second one"),
        ({RESTITUTION: (0.4, 0.8), "body.ball.mass": (1, 2)}, TypeError, "expected the branch's parameter and a second one"),
        ({AMPLITUDE: 0.005, RESTITUTION: (0.4, 0.8)}, TypeError, f"{AMPLITUDE} = 0.005: expected a range (from, to)"),
        ({AMPLITUDE: (0.04, 0.06), RESTITUTION: (0.4, 0.8)}, ValueError, "must lie in the range 0.04 to 0.06"),
        ({AMPLITUDE: (0.005, 0.06), RESTITUTION: (0.7, 0.8)}, ValueError, "must lie in the range 0.7 to 0.8"),
        ({AMPLITUDE: (0.005, 0.06), RESTITUTION: (0.8, 0.4)}, ValueError, "0.8 to 0.4"),
        ({AMPLITUDE: (0.005, 0.06), "stop.floor.restitutoin": (0.4, 0.8)}, ValueError, "stop.floor.restitution"),
    ],
)
def test_ranges_that_are_refused_are_named(branch, ranges, error, words):
    with pytest.raises(error, match=re.escape(words)):
        branch.locus(np.flatnonzero(branch.labels == "LP")[0], ranges)


def test_points_at_which_no_curve_begins_are_named(branch):
    begins = np.flatnonzero(np.isin(branch.labels, ["LP", "PD"])).tolist()
    plain, end = np.flatnonzero(branch.labels == "")[0], np.flatnonzero(branch.labels == "EP")[0]
    for point, error, words in [
        (plain, ValueError, f"point = {plain}: no curve begins at this point (not special); expected one of {begins}"),
        (end, ValueError, f"point = {end}: no curve begins at this point (EP); expected one of {begins}"),
        (len(branch.value), ValueError, f"expected a whole number from 0 to {len(branch.value) - 1}"),
        ("LP", TypeError, "point = 'LP' is of type str"),
    ]:
        with pytest.raises(error, match=re.escape(words)):
            branch.locus(point, RANGES)
