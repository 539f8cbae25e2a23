"""What sensors add to the truth."""

import numpy as np
import pytest

from tests.sim.kinematic.machines import TITAN, all_legs, flat, run, standing_stance
from walking_console.sim.kinematic.plant import KinematicPlant
from walking_console.sim.sensor_noise import SensorNoise


class TestSensors:
    def test_noise_is_seeded_and_does_not_touch_the_machine(self):
        plants = [
            KinematicPlant(
                TITAN,
                flat(),
                standing_stance(),
                noise=SensorNoise(0.002, 0.01),
                rng=np.random.default_rng(7),
            )
            for _ in range(2)
        ]
        readings = [
            [(run(plant, all_legs(-0.05), 1).sense()) for _ in range(20)] for plant in plants
        ]
        assert readings[0] == readings[1]
        assert plants[0].body[3] == 0.0
        spread = np.std([reading.feet_b[0][1] for reading in readings[0]])
        assert 0.001 < spread < 0.004

    def test_noise_without_a_generator_is_refused(self):
        with pytest.raises(ValueError, match="seeded generator"):
            KinematicPlant(TITAN, flat(), standing_stance(), noise=SensorNoise(0.001))
