"""What an operator asks for: a refusal opens a window in the ground station, what is done is told quietly."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.decision import Home, ModeId, Outcome, Severity
from companion.mission.tasks import SetRelay
from tests.unit.conftest import Boat

REFUSED: dict[str, Callable[[Boat], Outcome]] = {
    "mode": lambda boat: boat.supervisor.request_mode(ModeId.MISSION, boat.now_s),
    "go-to": lambda boat: boat.supervisor.go_to(*boat.point(5.0, 0.0), None, None, boat.now_s),
    "pause": lambda boat: boat.supervisor.pause(boat.now_s),
    "resume": lambda boat: boat.supervisor.resume(boat.now_s),
    "item": lambda boat: boat.supervisor.set_current(3, False, boat.now_s),
    "speed": lambda boat: boat.supervisor.change_speed(0.0, boat.now_s),
    "home": lambda boat: boat.supervisor.set_home(Home(math.nan, 0.0, 0.0), boat.now_s),
    "nudge": lambda boat: boat.supervisor.nudge(1.0, 0.0, 0.0, boat.now_s),
    "follow": lambda boat: boat.supervisor.following.follow(42, boat.now_s),
    "follow position": lambda boat: boat.supervisor.following.set_follow_position(None, 9999.0, boat.now_s),
    "relay": lambda boat: boat.supervisor.auxiliary.request(SetRelay(15, True), boat.now_s),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_refused_request_is_an_error(boat: Boat, name: str) -> None:
    assert not REFUSED[name](boat).accepted
    boat.step()
    (event,) = [event for event in boat.severities if event.endswith("refused")]
    assert boat.severities[event] is Severity.ERROR


def test_arming_in_vain_is_an_error(boat: Boat) -> None:
    boat.wet = True
    boat.step()
    assert not boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    assert "PreArm: water in the hull" in boat.texts() and boat.severities["arming_refused"] is Severity.ERROR


def test_a_mission_is_sailed_without_a_word_aloud(boat: Boat) -> None:
    """Armed, sailed, held and disarmed: not a text that QGroundControl speaks or opens a window for."""
    boat.upload((15.0, 0.0), (15.0, 15.0))
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: "Mission complete" in boat.texts())
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.change_speed(0.5, boat.now_s)
    boat.supervisor.go_to(*boat.point(20.0, 0.0), None, None, boat.now_s)
    boat.supervisor.set_home(None, boat.now_s)
    boat.supervisor.disarm(boat.now_s)
    boat.step()
    assert {"armed", "mode_changed", "item_reached", "mission_ended", "go_to", "disarmed"} <= set(boat.names())
    assert set(boat.severities.values()) == {Severity.INFO}
