"""Settings of the physics plant that cannot be are refused with their limits."""

import math

import pytest

from walking_console.sim.mujoco.settings import Physics, ServoSettings


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"step": 0.005}, "step must be from 0.0001 to 0.004, got 0.005"),
        ({"contact_time": 0.001}, "contact_time must be from 0.004"),
        ({"mass_factor": 0.0}, "mass_factor must be from 0.1"),
        ({"friction": -1.0}, "friction must be from 0"),
        ({"tip": 0.0}, "tip must be from 0.001"),
        ({"centre_off": (math.nan, 0.0, 0.0)}, "centre_off must be within 1 m"),
    ],
)
def test_what_cannot_be_is_refused(change, reason):
    with pytest.raises(ValueError, match=reason):
        Physics(**change)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"sag": 0.0}, "sag must be from 1e-05 to 0.1, got 0.0"),
        ({"damping": -0.1}, "damping must be from 0"),
        ({"lead": 5.0}, "lead must be from 0.001 to 1"),
    ],
)
def test_servos_that_cannot_be_are_refused(change, reason):
    with pytest.raises(ValueError, match=reason):
        ServoSettings(**change)
