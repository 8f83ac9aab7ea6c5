"""What a page may ask, and the MAVLink that comes of it."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.console.orders import CommandOrder, OrderError, ParameterOrder, order_of

MODES = {"Hold": 0x03040000}


def made(**asked: Any) -> Any:
    return order_of(asked, MODES)


@pytest.mark.parametrize(
    "asked, number, params",
    [
        ({"order": "arm"}, 400, (1.0,)),
        ({"order": "disarm"}, 400, (0.0,)),
        ({"order": "mode", "mode": "Hold"}, 176, (1.0, float(0x03040000))),
        ({"order": "nudge", "ahead_m": 0.5, "starboard_m": -1, "turn_deg": 0}, 31010, (1.0, 0.5, -1.0, 0.0)),
        ({"order": "heading", "heading_deg": -10}, 31010, (2.0, 350.0)),
        ({"order": "station", "bearing_deg": 135, "distance_m": 20}, 31012, (135.0, 20.0)),
        ({"order": "take_control"}, 32100, (1.0, 1.0)),
        ({"order": "trial_accept"}, 31014, (0.0, 1.0)),
        ({"order": "trial_undo"}, 31014, (0.0, 2.0)),
        ({"order": "restart"}, 246, (1.0,)),
    ],
)
def test_commands(asked: dict[str, Any], number: int, params: tuple[float, ...]) -> None:
    assert order_of(asked, MODES) == CommandOrder(number, params)


def test_a_go_to_has_its_place_and_its_heading_in_radians() -> None:
    order = made(order="go_to", lat_deg=63.4, lon_deg=10.4, heading_deg=90)
    assert order.place == (63.4, 10.4) and order.params[3] == pytest.approx(0.5 * math.pi)
    assert math.isnan(made(order="go_to", lat_deg=63.4, lon_deg=10.4).params[3])


def test_a_trim_is_one_of_the_table() -> None:
    assert made(order="trim", name="DP_BW_SWAY", value=0.5) == ParameterOrder("DP_BW_SWAY", 0.5)


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"order": "terminate"},
        {"order": "mode", "mode": "Fly"},
        {"order": "go_to", "lat_deg": 91, "lon_deg": 0},
        {"order": "go_to", "lat_deg": "63", "lon_deg": 10},
        {"order": "nudge", "ahead_m": True, "starboard_m": 0, "turn_deg": 0},
        {"order": "heading", "heading_deg": float("nan")},
        {"order": "trim", "name": "MAV_SYS_ID", "value": 3},
        {"order": "trim", "name": "DP_BW_SWAY", "value": 99},
    ],
)
def test_what_is_not_in_the_table_goes_nowhere(asked: dict[str, Any]) -> None:
    with pytest.raises(OrderError):
        order_of(asked, MODES)
