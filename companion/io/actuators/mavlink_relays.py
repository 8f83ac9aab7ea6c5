"""Relays of an autopilot board: the vessel's own, and the lamps of the light beacon."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from companion.config import MavlinkBoardConfig
from companion.core.types import Beacon, Light
from companion.io.actuators.mavlink_board import MavlinkBoard
from companion.io.mavlink import messages as mavlink

_REPEAT_S = 1.0
_BLINK_HZ = 1.0


class MavlinkRelays:
    """`orders(on, beacon, now_s)` → DO_SET_RELAY messages: what has changed, and the rest once a second.

    The board keeps its relays as they are when nothing more comes. Remembers what was sent and when.
    """

    def __init__(self, config: MavlinkBoardConfig, board: MavlinkBoard) -> None:
        self._numbers, self._lamps = config.relays, config.lamps
        self._board = board
        self._sent: dict[int, tuple[bool, float]] = {}

    def orders(self, on: Sequence[bool], beacon: Beacon, now_s: float) -> list[Any]:
        """`on`: of the bridge's relays, in order. The board must be known."""
        wanted = dict(zip(self._numbers, on, strict=True))
        for number, light in zip(self._lamps, (beacon.red, beacon.yellow, beacon.green), strict=False):
            wanted[number] = light is Light.STEADY or (light is Light.BLINK and now_s * _BLINK_HZ % 1.0 < 0.5)
        due = []
        for number, state in wanted.items():
            sent = self._sent.get(number)
            if sent is None or sent[0] is not state or now_s - sent[1] >= _REPEAT_S:
                self._sent[number] = state, now_s
                due.append(self._board.command(mavlink.MAV_CMD_DO_SET_RELAY, number, float(state)))
        return due
