"""What the boat has learned of how hard the water resists its turns: said once, and told to the modes."""

from __future__ import annotations

from tests.unit.conftest import Boat

TEXT = "Yaw damping is 2.4 times the vessel file's"


def told(boat: Boat) -> list[str]:
    boat.step()
    return [text for text in boat.texts() if text.startswith("Yaw damping is")]


def test_a_marked_resistance_is_said_once(boat: Boat) -> None:
    boat.supervisor.turns_against(1.5, boat.now_s)
    assert told(boat) == []
    boat.supervisor.turns_against(2.4, boat.now_s)
    assert told(boat) == [TEXT] and len(TEXT) <= 50
    boat.supervisor.turns_against(3.0, boat.now_s)
    assert told(boat) == [TEXT]


def test_modes_are_told(boat: Boat) -> None:
    assert boat.supervisor.parts.mode_inputs(boat.now_s, 0.1).turn_resistance == 1.0
    boat.supervisor.turns_against(3.0, boat.now_s)
    assert boat.supervisor.parts.mode_inputs(boat.now_s, 0.1).turn_resistance == 3.0
