"""The hash of a walk: one for every tick, each over the one before and the state at its end."""

from __future__ import annotations

import struct
from hashlib import blake2b

from walking_console.sim.simulation import Simulation


class StateHash:
    """``digest`` after every ``note``, as ``ticks.npz`` has it under ``hash``."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        legs = len(simulation.world.machine.legs)
        self._pack = struct.Struct(f"<8s{6 + 3 * legs + 3}d{2 * legs + 1}B").pack
        self.digest = bytes(8)

    def note(self) -> tuple[list[float], bytes]:
        """The state at the end of the tick just run: body, feet and command, then the flags of
        soles, of legs meant to carry, and the mode.
        """
        simulation = self.simulation
        plant = simulation.plant
        command = simulation.command
        asked = command.crab_angle, command.speed, command.turn_rate
        # adding 0.0 turns −0.0 into 0.0
        state = [value + 0.0 for part in (plant.body, *plant.feet, asked) for value in part]
        flags = bytes((*plant.soles, *simulation.walk.carrying(), int(simulation.mode)))
        self.digest = blake2b(self._pack(self.digest, *state, *flags), digest_size=8).digest()
        return state, flags
