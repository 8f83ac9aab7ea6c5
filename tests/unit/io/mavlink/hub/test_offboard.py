"""Setpoints of MAVSDK, MAVProxy and others: what their masks and frames mean, and what becomes of those that mean
nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import ModeId
from companion.io.mavlink.wire import messages as mavlink
from companion.modes.parts.offboard_target import OffboardTarget
from tests.unit.io.mavlink.hub.conftest import Rig

NAN, INF = math.nan, math.inf
RIGHT = math.radians(90.0)


def local(frame: int, mask: int, *values: float, target: int = 1) -> Any:
    """`values`: x y z, vx vy vz, afx afy afz, yaw, yaw rate; 0 where left out."""
    padded = (*values, *(0.0 for _ in range(11 - len(values))))
    return mavlink.MAVLink_set_position_target_local_ned_message(0, target, 1, frame, mask, *padded)


def world(frame: int, mask: int, lat: int, lon: int, *values: float) -> Any:
    padded = (*values, *(0.0 for _ in range(8 - len(values))))
    return mavlink.MAVLink_set_position_target_global_int_message(0, 1, 1, frame, mask, lat, lon, 0.0, *padded)


def taken(rig: Rig) -> list[OffboardTarget]:
    return [asked[1] for asked in rig.supervisor.asked if asked[0] == "offboard_setpoint"]


# name, message as the client's own wire had it, what is meant
CLIENTS = [
    ("mavsdk position", local(1, 0x9F8, 1, 2, -3, 0, 0, 0, 0, 0, 0, RIGHT), OffboardTarget((1, 2), yaw_rad=RIGHT)),
    (
        "mavsdk velocity",
        local(1, 0x9C7, 0, 0, 0, 1, 2, 0, 0, 0, 0, RIGHT),
        OffboardTarget(velocity=(1, 2), yaw_rad=RIGHT),
    ),
    (
        "mavsdk body",
        local(8, 0x5C7, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 0.5),
        OffboardTarget(velocity=(1, 2), yaw_rate_radps=0.5, body=True, offset=True),
    ),
    ("mavsdk acceleration", local(1, 0xC3F, 0, 0, 0, 0, 0, 0, 0.5, 0.25), OffboardTarget(acceleration=(0.5, 0.25))),
    ("mavsdk both", local(1, 0x9C0, 1, 2, 0, 3, 4, 0, 0, 0, 0, RIGHT), OffboardTarget((1, 2), (3, 4), yaw_rad=RIGHT)),
    ("mavsdk all", local(1, 0x800, 1, 2, 0, 3, 4, 0, 5, 6, 0, RIGHT), OffboardTarget((1, 2), (3, 4), (5, 6), RIGHT)),
    (
        "mavproxy guided forward",
        local(8, 0x5F8, 5.0),
        OffboardTarget((5, 0), yaw_rate_radps=0.0, body=True, offset=True),
    ),
    ("mavproxy position", local(8, 3576, 5, 1), OffboardTarget((5, 1), body=True, offset=True)),
    ("mavproxy velocity", local(8, 4039, 0, 0, 0, 1, 0.5), OffboardTarget(velocity=(1, 0.5), body=True, offset=True)),
    (
        "mavproxy setpos",
        local(9, 0b1111101111111000, 3, 1, 0, 0, 0, 0, 0, 0, 0, RIGHT),
        OffboardTarget((3, 1), yaw_rad=RIGHT, body=True, offset=True),
    ),
    ("offset", local(7, 0xDF8, 3, 1), OffboardTarget((3, 1), offset=True)),
    ("heading alone", local(1, 0x9FF, 0, 0, 0, 0, 0, 0, 0, 0, 0, RIGHT), OffboardTarget(yaw_rad=RIGHT)),
    (
        "rate alone",
        local(12, 0x5FF, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.25),
        OffboardTarget(yaw_rate_radps=0.25, body=True, offset=True),
    ),
    (
        "no heading: keep",
        local(1, 0x9C7, 0, 0, 0, 1, 0, 0, 0, 0, 0, NAN),
        OffboardTarget(velocity=(1, 0), keeps_yaw=True),
    ),
    (
        "heights that are none",
        local(1, 0x9C0, 1, 2, NAN, 3, 4, INF, 0, 0, 0, 0),
        OffboardTarget((1, 2), (3, 4), yaw_rad=0.0),
    ),
]


@pytest.mark.parametrize(("message", "meant"), [row[1:] for row in CLIENTS], ids=[row[0] for row in CLIENTS])
def test_what_clients_send(rig: Rig, message: Any, meant: OffboardTarget) -> None:
    assert rig.ask(message) == []
    (target,) = taken(rig)
    for name in ("position", "velocity", "acceleration", "yaw_rad", "yaw_rate_radps"):
        found, expected = getattr(target, name), getattr(meant, name)
        assert found == (None if expected is None else pytest.approx(expected, rel=1e-6)), name
    assert (target.keeps_yaw, target.body, target.offset) == (meant.keeps_yaw, meant.body, meant.offset)


@pytest.mark.parametrize("frame", [0, 3, 5, 6, 11])
def test_places_on_the_globe(rig: Rig, frame: int) -> None:
    rig.ask(world(frame, 0x9F8, 634400000, 103990000, 0, 0, 0, 0, 0, 0, RIGHT))
    (target,) = taken(rig)
    assert target.position == pytest.approx(rig.vessel.frame.to_ned(63.44, 10.399), abs=1e-6)
    assert target.yaw_rad == pytest.approx(RIGHT) and not target.body and not target.offset
    rig.ask(world(frame, 0x9C7, 0, 0, 1.0, 2.0))
    assert taken(rig)[1] == OffboardTarget(velocity=(1.0, 2.0), yaw_rad=0.0)


NONE_OF_THEM = [
    ("all ignored", local(1, 0xDFF, 1, 2), "nothing is asked for"),
    ("height alone", local(1, 0xDFB, 0, 0, 5), "nothing is asked for"),
    ("forces", local(1, 0xE3F, 0, 0, 0, 0, 0, 0, 5, 5), "forces"),
    ("forces with a point", local(1, 0xA00, 1, 2), "forces"),
    ("half a point", local(1, 0xDFA, 1), "half of a position"),
    ("half a velocity", local(1, 0xDEF, 0, 0, 0, 1), "half of a velocity"),
    ("no number", local(1, 0x9F8, NAN, 2), "not a number"),
    ("no velocity", local(1, 0x9C7, 0, 0, 0, 1, INF), "not a number"),
    ("no acceleration", local(1, 0xC3F, 0, 0, 0, 0, 0, 0, NAN, 0), "not a number"),
    ("no rate", local(8, 0x5C7, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, NAN), "not a number"),
    ("endless heading", local(1, 0x9F8, 1, 2, 0, 0, 0, 0, 0, 0, 0, -INF), "not a number"),
    ("frame of a camera", local(4, 0x9F8, 1, 2), "not a local one"),
    ("local frame for the globe", world(1, 0x9F8, 634400000, 103990000), "not a global one"),
    ("nowhere", world(6, 0x9F8, 0, 0), "no such place"),
    ("beyond the pole", world(6, 0x9F8, 2147483647, 0), "no such place"),
]  # fmt: skip


@pytest.mark.parametrize(("message", "why"), [row[1:] for row in NONE_OF_THEM], ids=[row[0] for row in NONE_OF_THEM])
def test_what_is_no_setpoint_is_dropped_and_said_to_the_sender(rig: Rig, message: Any, why: str) -> None:
    text = "".join(answer.text for answer in rig.ask(message))
    assert text.startswith("Setpoint refused: ") and why in text
    assert taken(rig) == [] and rig.ask(message, message) == []


def test_a_refusal_is_said_again_after_a_while_and_to_nobody_else(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.supervisor.setpoints_refused = "point outside the fence"
    message = local(1, 0x9F8, 1, 2)
    assert [m.text for m in rig.ask(message)] == ["Setpoint refused: point outside the fence"]
    assert rig.ask(message) == [] and rig.desks[1].hear() == []
    assert len(rig.ask(message, desk=1)) == 1 and rig.desks[0].hear() == []
    rig.run(5.1)
    assert "STATUSTEXT" not in {m.get_type() for m in rig.ask(message)}
    rig.supervisor.setpoints_refused = "not in Offboard"
    rig.run(5.1)
    assert "Setpoint refused: not in Offboard" in [m.text for m in rig.ask(message) if m.get_type() == "STATUSTEXT"]
    rig.supervisor.setpoints_refused = "point outside the fence"
    rig.run(30.0)
    assert len([m for m in rig.ask(message) if m.get_type() == "STATUSTEXT"]) == 1


@pytest.mark.parametrize("target", [0, 2])
def test_setpoints_for_others_or_for_everybody_are_not_ours(rig: Rig, target: int) -> None:
    assert rig.ask(local(1, 0x9F8, 1, 2, target=target)) == [] and taken(rig) == []


def test_guided_of_rover_is_offboard_where_setpoints_come_else_hold(make_rig: type[Rig]) -> None:
    """MAVSDK on such a link asks for number 15 and goes on sending only while HEARTBEAT bears it; MAVProxy's `mode
    guided` waits for a go-to."""
    rig = make_rig(["memory:?dialect=ardupilot"])
    rig.command(176, 1.0, 15.0)
    rig.supervisor.setpoints_missing = None
    rig.command(176, 1.0, 15.0)
    assert [asked[1] for asked in rig.supervisor.asked] == [ModeId.HOLD, ModeId.OFFBOARD]
    assert rig.desk.endpoint.persona.custom_mode(ModeId.OFFBOARD) == 15


def test_offboard_of_px4_is_never_hold(rig: Rig) -> None:
    rig.command(176, 1.0, 6.0)
    assert rig.supervisor.asked == [("request_mode", ModeId.OFFBOARD)]
