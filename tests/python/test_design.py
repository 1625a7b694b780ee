"""Designs of machines of your own compared with closed forms."""

import math

import numpy as np
import pytest
import vibro_impact as vi

# Errors: of a settled linear motion's amplitude; of a best design's numbers, which enter squared.
SETTLED = 1e-8
NUMBERS = 1e-5

W = 2 * math.pi * 8


def mount() -> vi.Machine:
    return vi.Machine(
        {
            "name": "Mount",
            "body": {"engine": {"mass": 1.0}},
            "spring": {"mount": {"between": ["ground", "engine"], "stiffness": 1000.0, "damping": 5.0}},
            "load": {"unbalance": {"on": "engine", "amplitude": 1.0, "frequency": 8.0}},
        }
    )


def test_closed_form_the_damping_at_a_limit_of_the_force() -> None:
    limit = 0.8
    exact = math.sqrt((limit**2 * (1000 - W * W) ** 2 - 1000**2) / (1 - limit**2)) / W
    found = mount().design(
        minimize="amplitude.engine.s", vary={"spring.mount.damping": (1.0, "100 N s/m")}, subject_to=["amplitude.mount.f <= 0.8 N"], evaluations=20
    )
    assert found.verdict == "decided" and found.exact and found.gradients and found.rivals
    assert abs(found.values["spring.mount.damping"] / exact - 1) < NUMBERS
    force, check = found.limits["amplitude.mount.f <= 0.8 N"]
    assert check == "met" and force is not None and abs(force / limit - 1) < NUMBERS
    # Every evaluated design has the amplitude of the closed form.
    amplitudes = 1 / np.hypot(1000 - W * W, found.designs[:, 0] * W)
    assert np.allclose(found.goals, amplitudes, rtol=1e-6) and len(found.stages) == len(found.goals)
    assert abs(found.goal * math.hypot(1000 - W * W, found.values["spring.mount.damping"] * W) - 1) < SETTLED
    assert found.machine.parameters["spring.mount.damping"] == found.values["spring.mount.damping"]


def test_closed_form_the_worst_over_single_frequencies() -> None:
    # The stiffness with equal amplitudes at both frequencies, below and above the resonance.
    low, high = 2 * math.pi * 7, 2 * math.pi * 9
    found = mount().replace({"spring.mount.damping": 2.0}).design(
        maximize="amplitude.engine.s", vary={"spring.mount.stiffness": (1500, 4000)}, over={"load.unbalance.frequency": [7.0, "9 Hz"]}, evaluations=20
    )
    # (k - low²)² + (c low)² = (high² - k)² + (c high)²
    exact = 0.5 * (low**2 + high**2 + 2.0**2)
    assert abs(found.values["spring.mount.stiffness"] / exact - 1) < NUMBERS
    assert abs(found.goal * math.hypot(exact - low**2, 2.0 * low) - 1) < NUMBERS


def test_what_cannot_be_sought_is_refused() -> None:
    vary = {"spring.mount.damping": (1.0, 9.0)}
    with pytest.raises(TypeError, match="expected one of them"):
        mount().design(vary=vary)
    with pytest.raises(ValueError, match="class: cannot be the goal, because it has no error bar"):
        mount().design(minimize="class", vary=vary)
    with pytest.raises(ValueError, match="the first value must be less than the second"):
        mount().design(minimize="rms.engine.a", vary={"spring.mount.damping": (9.0, 1.0)})
    with pytest.raises(TypeError, match="a tuple .from, to."):
        mount().design(minimize="rms.engine.a", vary=vary, over={"load.unbalance.frequency": 8.0})
    with pytest.raises(ValueError, match="OUTPUT<=VALUE"):
        mount().design(minimize="rms.engine.a", vary=vary, subject_to="impacts")
