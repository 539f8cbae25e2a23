"""No leg is lifted while a foot that is meant to carry has no ground or no load."""

from dataclasses import replace

import numpy as np
import pytest

from tests.planner.control.plans import Scripted, flat, now, sensed, state_with, swing_plan
from walking_console.planner.config import Contact
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.contact_reflexes import ContactReflexes
from walking_console.planner.control.encounter import FootState
from walking_console.planner.control.sole_watch import SoleWatch, not_carrying
from walking_console.planner.motion.step_builder import changed
from walking_console.planner.types import Phase

HANGING = (True, False, True, True)
WAIT = Contact().wait_for_sole


def watch(t=None):
    state = state_with(Scripted(None))
    if t is not None:
        state.run.play(swing_plan())
        state.happens(Event.STEP_READY)
        state.run.t = t
    contacts = ContactReflexes(state)
    return state, contacts, SoleWatch(state, contacts)


def test_the_leg_is_kept_down_in_the_tick_it_would_rise_in_and_in_no_other():
    for t, kept in ((0.10, False), (0.245, True), (0.26, False)):
        _, _, soles = watch(t)
        assert soles.keeps_down(t + 0.02, now(soles=HANGING)) is kept
        assert not soles.keeps_down(t + 0.02, now())


def test_a_sole_of_the_leg_that_rises_may_be_off():
    _, _, soles = watch(0.245)
    assert not soles.keeps_down(0.265, now(soles=(False, True, True, True)))


@pytest.mark.parametrize("t", [None, 0.245])
def test_a_leg_that_hangs_is_waited_for_and_then_let_down(t):
    state, contacts, soles = watch(t)
    tick = now(soles=HANGING)
    for _ in range(WAIT):
        assert soles.keeps_standing(tick) if t is None else soles.keeps_down(0.265, tick)
        assert contacts.encounter is None
    assert soles.keeps_standing(tick) if t is None else soles.keeps_down(0.265, tick)
    assert contacts.encounter is not None and contacts.encounter.leg == 1
    assert contacts.encounter.state is FootState.DESCEND
    assert state.activity is Activity.REFLEX


def test_a_leg_lifted_on_purpose_is_no_reason_to_wait():
    state, _, soles = watch()
    state.run.hold(replace(state.run.stance, lifted=(1,)))
    assert not soles.keeps_standing(now(soles=HANGING))


class Loads:
    """What a controller says of loads, N; ``still`` legs that press though they are to rise."""

    loads = (200.0, 200.0, 0.0, 200.0)
    still = ()

    def idle(self, t):
        return tuple(leg for leg, load in enumerate(self.loads) if load == 0.0)

    def presses(self, legs):
        return any(leg in self.still for leg in legs)


def test_a_leg_that_presses_with_less_than_a_tenth_of_its_load_does_not_carry():
    state, _, _ = watch()
    state.run.compliant = Loads()
    light = sensed()._replace(loads=(200.0, 15.0, 0.0, 25.0))
    assert not_carrying(state.run, light, range(4), 0.1) == [1]
    hanging = light._replace(soles=(True, True, True, False))
    assert not_carrying(state.run, hanging, range(4), 0.1) == [1, 3]
    state.run.compliant = None
    assert not_carrying(state.run, light, range(4), 0.1) == []


@pytest.mark.parametrize(
    ("noise", "ground_is_known", "kept"),
    [(0.005, False, True), (0.005, True, False), (0.0, False, False)],
)
def test_where_sensors_scatter_and_ground_is_unknown_a_quarter_of_its_load_is_asked_for(
    noise, ground_is_known, kept
):
    state, _, soles = watch(0.245)
    state.run.compliant = Loads()
    state.run.tolerances = replace(state.run.tolerances, position_noise=noise)
    ground = flat()
    known = np.full(ground.heights.shape, ground_is_known)
    tick = now(terrain=replace(ground, known=known))
    tick.sensing = tick.sensing._replace(loads=(0.0, 40.0, 0.0, 200.0))
    assert soles.keeps_down(0.265, tick) is kept
    assert soles.time_begun(0.265, tick) == (0.245 if kept else 0.265)


def test_a_step_onto_known_ground_begins_in_the_middle_of_a_tick_whatever_hangs():
    state, _, soles = watch(0.245)
    state.run.tolerances = replace(state.run.tolerances, position_noise=0.005)
    assert soles.time_begun(0.265, now(soles=HANGING)) == 0.265


def test_a_leg_that_is_to_carry_nothing_may_hang():
    state, _, _ = watch()
    hanging = sensed()._replace(soles=(True, True, False, True), loads=(200.0, 200.0, 0.0, 200.0))
    assert not_carrying(state.run, hanging, range(4), 0.1) == [2]
    state.run.compliant = Loads()
    assert not_carrying(state.run, hanging, range(4), 0.1) == []


def test_from_a_standstill_a_leg_stays_down_until_it_has_given_its_load_away():
    state, _, soles = watch()
    lifting = swing_plan(advance=0.0)
    phases = (Phase.UP, Phase.UP, *lifting.phases[2:])
    state.run.play(changed(lifting, phases=phases, rates=np.zeros((5, 4))))
    state.run.compliant = Loads()
    assert not soles.keeps_down(0.02, now())
    state.run.compliant.still = (0,)
    assert soles.keeps_down(0.02, now())
    state.run.compliant.still = (1,)
    assert not soles.keeps_down(0.02, now())
