"""The transmitter's switches under whatever a transmitter may send."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.vessel import find, load
from companion.core.readings import RcInput
from companion.core.setpoint import NeutralSetpoint
from companion.core.tick import Inputs
from companion.supervisor.switches import SETTLE_S
from tests.unit.conftest import Boat

REVOLT = load(find("revolt"))
PERIOD_S = 0.1
CHANNEL = {"RC_MAP_KILL_SW": 5, "RC_MAP_ARM_SW": 6, "RC_MAP_RETURN_SW": 7, "RC_MAP_FLTMODE": 8}
MAPPED = {"MAN_RC_SAFE_CH": 0, **CHANNEL, "COM_FLTMODE1": 4, "COM_FLTMODE6": 0}
BY_FUNCTION = {"MAN_RC_SAFE_CH": 0, "RC5_OPTION": 31, "RC6_OPTION": 153, "RC7_OPTION": 42, "RC8_OPTION": 11}
pulse = st.sampled_from((-1.4, -1.0, -0.5, 0.0, 0.5, 0.6, 1.0, 1.4, math.nan, math.inf))
readings = st.one_of(
    st.none(),
    st.tuples(st.lists(pulse, max_size=10).map(tuple), st.booleans()),
    st.tuples(st.tuples(*(st.sampled_from((-1.0, 1.0)) for _ in range(8))), st.just(False)),
)
runs = st.lists(st.tuples(readings, st.integers(1, 8)), min_size=5, max_size=40)


def moved_on(history: list[Any], channel: int) -> bool:
    """Whether that channel has been low and then high, each for long enough, in readings without a long gap."""
    values = [None if r is None or r[1] or len(r[0]) < channel else r[0][channel - 1] for r in history]
    low = next((i for i, value in enumerate(values) if value is not None and not value > 0.5), None)
    return low is not None and any(value is not None and value > 0.5 for value in values[low:])


@pytest.mark.parametrize("mapped", [MAPPED, BY_FUNCTION], ids=["mapped", "functions"])
@settings(deadline=None, derandomize=True, max_examples=40)
@given(sequence=runs)
def test_nobody_is_armed_with_the_kill_switch_on_nor_without_a_move_of_the_arm_switch(
    mapped: dict[str, float], sequence: list[Any]
) -> None:
    boat = Boat(REVOLT, **mapped)
    history: list[Any] = []
    for reading, ticks in sequence:
        for _ in range(ticks):
            history.append(reading)
            boat.now_s = round(boat.now_s + PERIOD_S, 6)
            boat.supervisor.ground_station_heard(boat.now_s)
            was_armed = boat.status.armed
            rc = None if reading is None else RcInput(boat.now_s, "rc", *reading)
            boat.status = boat.supervisor.update(boat.nav, Inputs(rc=rc), (), boat.now_s)
            setpoint = boat.supervisor.guide(boat.nav, boat.now_s, PERIOD_S)
            killed = rc is not None and not rc.lost and len(rc.channels) > 4 and 0.6 < rc.channels[4] < math.inf
            if killed or boat.supervisor.parts.switches.killed:
                assert not boat.status.armed and isinstance(setpoint, NeutralSetpoint)
            if boat.status.armed and not was_armed:
                assert moved_on(history, CHANNEL["RC_MAP_ARM_SW"])
    assert SETTLE_S > PERIOD_S, "a single reading moves nothing"
