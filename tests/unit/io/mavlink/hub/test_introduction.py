"""What clients of the ArduPilot family are told of who the boat is."""

from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.services.introduction import place_to_connect
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.hub.test_commands import ACCEPTED, result

BANNER = 42428


@pytest.mark.parametrize(("url", "manner"), [("memory:?dialect=ardupilot", ", modes as Rover"), ("memory:", "")])
def test_the_banner_that_mission_planner_asks_for(make_rig: Any, named: Any, url: str, manner: str) -> None:
    answers = make_rig([url]).command(BANNER)
    assert result(answers) == ACCEPTED
    texts = [message.text for message in named(answers, "STATUSTEXT")]
    assert texts[0] == f"USV companion 0.1.0{manner}" and texts[1].startswith("Frame: boat, ")
    assert all(len(text) <= 50 for text in texts)


def test_the_banner_is_for_all_to_read(rig: Any) -> None:
    rig.vessel.supervisor.ground_stations.operators = frozenset({1})
    assert result(rig.command(BANNER)) == ACCEPTED


def test_the_old_request_for_the_version(rig: Any, named: Any) -> None:
    answers = rig.ask(mavlink.MAVLink_autopilot_version_request_message(1, 1))
    assert len(named(answers, "AUTOPILOT_VERSION")) == 1 and not named(answers, "COMMAND_ACK")


HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3)


def heard(rig: Any, component: int) -> list[str]:
    rig.desk.component = component
    return [message.text for message in rig.ask(HEARTBEAT) if message.get_type() == "STATUSTEXT"]


def test_mavproxy_is_told_once_where_its_mode_command_works(make_rig: Any) -> None:
    rig = make_rig(["memory:"])
    assert "MAVProxy's mode command needs ?dialect=ardupilot" in heard(rig, 230)
    assert heard(rig, 230) == []


def test_others_and_mavproxy_on_an_ardupilot_link_are_not(make_rig: Any) -> None:
    assert heard(make_rig(["memory:"]), 190) == ["USV companion 0.1.0"]
    assert heard(make_rig(["memory:?dialect=ardupilot"]), 230) == ["USV companion 0.1.0"]


@pytest.mark.parametrize(
    ("names", "place"),
    [
        (["udpout:127.0.0.1:14550", "tcpin:127.0.0.1:5762?dialect=ardupilot"], "TCP port 5762"),
        (["udpin:0.0.0.0:14555?signing=off&dialect=ardupilot"], "UDP port 14555"),
        (["memory:x", "udpout:127.0.0.1:14555?dialect=ardupilot", "tcpin:0.0.0.0:5760"], None),
    ],
)
def test_where_the_rover_names_are(names: list[str], place: str | None) -> None:
    assert place_to_connect(names) == place
