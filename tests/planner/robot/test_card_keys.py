"""The limits that the tables of robot cards show are those that cards are checked by."""

import pytest

from walking_console.planner.robot.card_keys import NUMBER, ROBOT_KEYS
from walking_console.planner.robot.model import MachineError, as_data, load_machine, machine_from


def beyond(key):
    """Numbers just outside the limits of a key."""
    tops = (limit for limit in (key.most, key.within) if limit is not None)
    yield from (top + 0.01 for top in tops)
    yield from (low for low in (key.above, key.below) if low is not None)
    yield from (low - 0.01 for low in (key.least,) if low is not None)


@pytest.mark.parametrize(
    ("key", "value"),
    [(key, value) for key in ROBOT_KEYS.values() for value in beyond(key)],
    ids=lambda value: getattr(value, "name", value),
)
def test_the_limits_of_the_tables_are_those_a_card_is_checked_by(key, value):
    data = as_data(load_machine("hexapod"))
    data[key.name] = value if key.shape == NUMBER else [value] * 3
    with pytest.raises(MachineError, match=f"{key.name} must be {key.limits}, got"):
        machine_from(data)
