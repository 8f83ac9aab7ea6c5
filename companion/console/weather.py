"""The capability polar for the board, made anew when the current or the thrusters that work have changed."""

from __future__ import annotations

import asyncio
import math
from typing import Any

from companion.analysis.log_reader import vessel_of
from companion.analysis.polar import Polar, polar
from companion.config.vessel import VesselConfig
from companion.console.board import Board

_LOOK_S = 2.0
_CHANGED_MPS = 0.05


async def keep_polar(board: Board) -> None:
    """For ever, while pages are open. The work is done beside the event loop."""
    last: object = None
    config: VesselConfig | None = None
    known: object = None
    while True:
        if board.pages and board.hello is not None and board.tick is not None:
            if known is not board.hello:
                known, config, last = board.hello, vessel_of(board.hello["configuration"]), None
            assert config is not None
            current, out = _current(board.tick), _out(config, board.tick)
            key = (known, tuple(round(part / _CHANGED_MPS) for part in current), out)
            if key != last:
                last = key
                made = await asyncio.get_running_loop().run_in_executor(None, polar, config, current, out)
                board.tell("capability", polar_message(made, current))
        await asyncio.sleep(_LOOK_S)


def polar_message(made: Polar | None, current_mps: tuple[float, float]) -> dict[str, Any]:
    """The polar as pages get it; without `from_rad` for a boat that has none."""
    if made is None:
        return {"from_rad": None}
    return {
        "from_rad": list(made.from_rad),
        "holds_mps": list(made.holds_mps),
        "worst_mps": list(made.worst_mps),
        "missed": list(made.missed),
        "current_mps": list(current_mps),
    }


def _current(tick: dict[str, Any]) -> tuple[float, float]:
    """The velocity of the water in body axes; zero where it is not known."""
    more, yaw = tick.get("more") or {}, tick["row"]["yaw_rad"]
    north, east = more.get("current_north_mps"), more.get("current_east_mps")
    if north is None or east is None or yaw is None:
        return 0.0, 0.0
    c, s = math.cos(yaw), math.sin(yaw)
    return c * north + s * east, c * east - s * north


def _out(config: VesselConfig, tick: dict[str, Any]) -> tuple[int, ...]:
    row = tick["row"]
    names = [thruster.name for thruster in config.thrusters]
    return tuple(i for i, name in enumerate(names) if row.get(f"{name}_condition") == "failed")
