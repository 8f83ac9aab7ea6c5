from __future__ import annotations

import struct

import pytest

from companion.core.decision import ModeId
from companion.io.mavlink.wire.personas import ARDUPILOT, GENERIC, PERSONAS, PX4, Persona


@pytest.mark.parametrize("persona", PERSONAS.values(), ids=lambda d: d.name)
def test_every_mode_goes_there_and_back(persona: Persona) -> None:
    numbers = [persona.custom_mode(mode) for mode in ModeId]
    assert len(set(numbers)) == len(numbers)
    assert [persona.mode(number) for number in numbers] == list(ModeId)
    for number in numbers:  # ground-station buttons send them as a float
        assert struct.unpack("<f", struct.pack("<f", float(number)))[0] == number


def test_numbers_that_quickly_go_wrong() -> None:
    assert PX4.custom_mode(ModeId.HOLD) == 0x03040000
    assert PX4.custom_mode(ModeId.FOLLOW) == 0x08040000
    assert GENERIC.modes == PX4.modes
    assert (
        ARDUPILOT.custom_mode(ModeId.MISSION),
        ARDUPILOT.custom_mode(ModeId.RTL),
        ARDUPILOT.custom_mode(ModeId.MANUAL),
    ) == (10, 11, 0)
    assert ARDUPILOT.custom_mode(ModeId.HOLD, asked=5) == 5 and ARDUPILOT.custom_mode(ModeId.MISSION, asked=5) == 10
    assert ARDUPILOT.custom_mode(ModeId.OFFBOARD) == 15 and PX4.custom_mode(ModeId.OFFBOARD) == 0x00060000
    assert PX4.mode(10) is None
    assert ARDUPILOT.mode(0x04040000) is None


def test_aliases_of_rover() -> None:
    everything = frozenset(ModeId)
    assert ARDUPILOT.mode(5) is ModeId.HOLD
    assert ARDUPILOT.mode(12) is ModeId.RTL
    assert ARDUPILOT.mode(12, everything - {ModeId.RTL}) is None
    assert ARDUPILOT.mode(6, everything - {ModeId.FOLLOW}) is None


@pytest.mark.parametrize("mode", ModeId)
def test_base_mode_says_custom_always_and_armed_only_when_armed(mode: ModeId) -> None:
    assert PX4.base_mode(mode, armed=False) & 0b10000001 == 1
    assert PX4.base_mode(mode, armed=True) & 0b10000001 == 0b10000001
    assert not PX4.base_mode(mode, armed=True) & 32  # not a simulation to anybody


def test_what_else_differs() -> None:
    assert (PX4.autopilot, GENERIC.autopilot, ARDUPILOT.autopilot) == (12, 0, 3)
    assert PX4.bytewise_parameters and GENERIC.bytewise_parameters and not ARDUPILOT.bytewise_parameters
    assert (PX4.first_item, ARDUPILOT.first_item) == (0, 1)
