"""The table of the supervisor: every activity can be reached and left, every event happens."""

import pytest

from walking_console.planner.control.activities import (
    PLACING,
    RESUMED,
    STILL,
    TABLE,
    Activity,
    Event,
    after,
)


def reachable(start: Activity) -> set[Activity]:
    found, new = {start}, [start]
    while new:
        onward = {after(activity, event) for activity in new for event in TABLE[activity]}
        new = sorted(onward - found, key=lambda activity: activity.name)
        found |= onward
    return found


def test_every_activity_has_a_row():
    assert set(TABLE) == set(Activity)


@pytest.mark.parametrize("activity", Activity)
def test_from_every_activity_every_other_can_be_reached(activity):
    assert reachable(activity) == set(Activity)


@pytest.mark.parametrize("activity", Activity)
def test_every_activity_is_left_by_some_event(activity):
    assert any(target is not activity for target in TABLE[activity].values())


def test_every_event_happens_somewhere_and_leads_to_one_activity_only():
    targets = {event: {row[event] for row in TABLE.values() if event in row} for event in Event}
    assert all(len(target) == 1 for target in targets.values())


def test_whatever_holds_a_foot_in_the_air_is_resumed_where_it_was_held():
    may_hover = {activity for activity, row in TABLE.items() if Event.NO_PLACE in row}
    assert set(RESUMED) == may_hover
    for activity, event in RESUMED.items():
        assert after(Activity.HOVER, event) is activity
    assert set(TABLE[Activity.HOVER]) == set(RESUMED.values())


def test_everything_but_hovering_can_come_to_rest():
    for activity in set(Activity) - {Activity.HOVER}:
        assert after(activity, Event.AT_REST) is Activity.STAND


def test_feet_are_put_down_only_after_what_swung_them():
    assert set(PLACING) == {
        after(Activity.STEP, Event.CUT_SHORT),
        after(Activity.STEP, Event.TOUCHED),
    }
    assert not set(PLACING) & set(STILL)


@pytest.mark.parametrize("activity", Activity)
@pytest.mark.parametrize("event", Event)
def test_a_pair_without_a_row_raises_and_says_what_there_is(activity, event):
    if event in TABLE[activity]:
        assert after(activity, event) in Activity
        return
    with pytest.raises(RuntimeError, match=f"{event.name} cannot happen at {activity.name}"):
        after(activity, event)
