"""ArduPilot's Guided: which setpoints move a boat that holds and waits for one."""

from __future__ import annotations

import pytest

from companion.core.decision import ModeId
from companion.modes.parts.offboard_target import OffboardTarget
from tests.unit.conftest import Boat

POINT = OffboardTarget(position=(20.0, 5.0))
WAY = OffboardTarget(velocity=(0.3, 0.0))


def waiting(boat: Boat) -> Boat:
    """Guided is chosen before the boat is armed, as scripts do it."""
    assert boat.supervisor.guided.choose(boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    return boat


def give(boat: Boat, target: OffboardTarget, guided: bool = True) -> None:
    assert boat.supervisor.offboard_setpoint(target, boat.now_s, guided) is None
    boat.step()


def goes(boat: Boat) -> bool:
    return any(text.startswith("Going to a point") for text in boat.texts())


def test_a_single_position_is_a_go_to(boat: Boat) -> None:
    give(waiting(boat), POINT)
    boat.step(3.0)
    assert goes(boat) and boat.status.mode is ModeId.HOLD
    assert not any("setpoint" in text for text in boat.texts()), "no stream that could be missed"


def test_each_later_position_is_one_too(boat: Boat) -> None:
    """A ground station that sends its own place every second or two."""
    give(waiting(boat), POINT)
    boat.step(2.0)
    give(boat, OffboardTarget(position=(40.0, 5.0)))
    assert "Going to a point 40 m away" in boat.texts() and boat.status.mode is ModeId.HOLD


@pytest.mark.parametrize("target", [POINT, WAY])
def test_a_stream_begins_offboard(boat: Boat, target: OffboardTarget) -> None:
    waiting(boat)
    for _ in range(3):
        give(boat, target)
    assert boat.status.mode is ModeId.OFFBOARD


def test_a_single_velocity_moves_nothing(boat: Boat) -> None:
    give(waiting(boat), WAY)
    boat.step(2.0)
    assert boat.status.mode is ModeId.HOLD and not goes(boat)


def test_velocities_once_a_second_are_a_stream_as_on_a_rover(boat: Boat) -> None:
    """ArduPilot's pages ask for them every second, and a Rover stops 3 s after the last one."""
    waiting(boat)
    give(boat, WAY)
    for _ in range(6):
        boat.step(0.9)
        give(boat, WAY)
        assert boat.status.mode is ModeId.OFFBOARD
    boat.step(1.0)  # one is lost
    assert boat.status.mode is ModeId.OFFBOARD and not any("no setpoint" in text for text in boat.texts())
    boat.step(2.2)
    assert boat.status.mode is ModeId.HOLD and any("no setpoint for" in text for text in boat.texts())


def test_a_fast_stream_that_ends_is_noticed_as_soon_as_on_other_links(boat: Boat) -> None:
    waiting(boat)
    for _ in range(20):
        give(boat, WAY)
    assert boat.status.mode is ModeId.OFFBOARD
    boat.step(1.2)
    assert boat.status.mode is ModeId.HOLD


def test_another_choice_ends_the_waiting(boat: Boat) -> None:
    waiting(boat)
    assert boat.supervisor.hold_here(boat.now_s).accepted
    for _ in range(3):
        give(boat, POINT)
    assert boat.status.mode is ModeId.HOLD and not goes(boat)


def test_disarming_ends_it(boat: Boat) -> None:
    waiting(boat)
    boat.supervisor.disarm(boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted
    for _ in range(3):
        give(boat, POINT)
    assert boat.status.mode is ModeId.HOLD and not goes(boat)


def test_setpoints_of_links_without_guided_move_nothing(boat: Boat) -> None:
    waiting(boat)
    for _ in range(3):
        give(boat, POINT, guided=False)
    assert boat.status.mode is ModeId.HOLD and not goes(boat)


def test_it_is_shown_as_guided_also_on_its_way_to_points(boat: Boat) -> None:
    """Scripts wait for the mode that they asked for, and end a go-to where it is another: DroneKit's examples."""
    waiting(boat)
    assert boat.status.guided
    give(boat, POINT)
    boat.step(2.0)
    assert boat.supervisor.go_to(*boat.point(10.0, 0.0), None, None, boat.now_s).accepted
    boat.step(2.0)
    assert boat.status.guided and boat.status.mode is ModeId.HOLD


@pytest.mark.parametrize("mode", [ModeId.HOLD, ModeId.MANUAL, ModeId.RTL])
def test_another_choice_is_shown_as_it_is(boat: Boat, mode: ModeId) -> None:
    waiting(boat)
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    boat.step()
    assert not boat.status.guided
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step()
    assert not boat.status.guided


def test_a_failsafe_that_changes_the_mode_is_shown_as_it_is(boat: Boat) -> None:
    waiting(boat)
    boat.wet = True
    boat.step(2.0)
    assert boat.status.mode is ModeId.RTL and not boat.status.guided


def test_a_point_for_guided_is_gone_to(boat: Boat) -> None:
    waiting(boat)
    assert boat.supervisor.guided.go(*boat.point(20.0, 0.0), boat.now_s).accepted
    boat.step(2.0)
    assert "Going to a point 20 m away" in boat.texts() and boat.status.guided
    for _ in range(3):
        give(boat, WAY)
    assert boat.status.mode is ModeId.OFFBOARD, "it still waits for setpoints"
    assert boat.supervisor.guided.go(*boat.point(0.0, 20.0), boat.now_s).accepted
    boat.step()
    assert boat.status.guided and boat.status.mode is ModeId.HOLD


@pytest.mark.parametrize("mode", [ModeId.HOLD, ModeId.MANUAL])
def test_without_guided_a_point_for_it_is_refused(boat: Boat, mode: ModeId) -> None:
    waiting(boat)
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    boat.texts()
    assert not boat.supervisor.guided.go(*boat.point(20.0, 0.0), boat.now_s).accepted
    boat.step()
    assert "Go-to refused: choose Guided first" in boat.texts() and boat.status.mode is mode
