"""Waiting for the boat, and watching it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.markup import escape

from gcs_plugins.readout import KINDS, Readout
from gcs_plugins.usvctl.boat import Boat, Refused
from gcs_plugins.usvctl.progress import bar

_PAUSED, _COMPLETE = 4, 5  # MISSION_STATE
_METRES_PER_DEGREE = 111_195.0
_SETTLES_S = 3.0  # within which the heartbeat shows a new mode


def sail(boat: Boat, timeout_s: float) -> None:
    """Wait until the mission is done, and show a bar. Raises Refused when the boat leaves it, or takes longer."""
    boat.listen("MISSION_CURRENT")
    boat.forget("MISSION_CURRENT")
    heard, end_s = boat.texts_heard, time.monotonic() + timeout_s
    boat.wait(lambda: boat.mode == "Mission", _SETTLES_S)
    with bar() as progress:
        task = progress.add_task("mission", total=None)
        while time.monotonic() < end_s:
            current = boat.newest("MISSION_CURRENT")
            if current is not None:
                total = current.get("total") or None
                number = current["seq"] + (not boat.rover_numbers)
                done = current.get("mission_state") == _COMPLETE
                progress.update(
                    task,
                    total=total,
                    completed=total if done else number - 1,
                    description=f"mission, item {number}",
                )
                if done:
                    return
                if boat.mode != "Mission" or not boat.armed:
                    raise Refused(
                        boat.reason(heard)
                        or f"the mission was left for {boat.mode}{'' if boat.armed else ', disarmed'}"
                    )
            boat.wait_next("MISSION_CURRENT", 1.0)
    raise Refused(f"the mission is not done after {timeout_s:g} s")


def arrive(boat: Boat, lat_deg: float, lon_deg: float, within_m: float, timeout_s: float) -> None:
    """Wait until the boat is there. Raises Refused when it leaves Hold, or takes longer."""
    boat.listen("GLOBAL_POSITION_INT")
    heard, end_s = boat.texts_heard, time.monotonic() + timeout_s
    boat.wait(lambda: boat.mode == "Hold", _SETTLES_S)
    while time.monotonic() < end_s:
        position = boat.newest("GLOBAL_POSITION_INT")
        if position is not None and _distance_m(position, lat_deg, lon_deg) <= within_m:
            return
        if boat.mode != "Hold" or not boat.armed:
            raise Refused(boat.reason(heard) or f"the boat changed to {boat.mode}{'' if boat.armed else ', disarmed'}")
        boat.wait_next("GLOBAL_POSITION_INT", 1.0)
    raise Refused(f"not there after {timeout_s:g} s")


def watch(boat: Boat, seconds: float) -> None:
    """Show one line that is updated, on a terminal; else print a line a second. For so long, or until Ctrl-C."""
    readout, console = Readout(), Console(soft_wrap=True)
    boat.listen(*KINDS)
    end_s = time.monotonic() + seconds
    with Live(console=console, auto_refresh=False) as live:
        while time.monotonic() < end_s:
            time.sleep(min(1.0, max(0.0, end_s - time.monotonic())))
            for kind in KINDS:
                fields = boat.newest(kind)
                if fields is not None:
                    readout.hear(kind, _as_message(fields), fields["heard_s"])
            line = " | ".join(readout.lines(time.monotonic()))
            if console.is_terminal:
                live.update(escape(line), refresh=True)
            else:
                print(line, flush=True)


def _as_message(fields: Mapping[str, Any]) -> SimpleNamespace:
    """The fields as attributes. JSON has no NaN: null stands for it."""
    return SimpleNamespace(**{name: math.nan if value is None else value for name, value in fields.items()})


def _distance_m(position: Mapping[str, Any], lat_deg: float, lon_deg: float) -> float:
    north_m = (position["lat"] * 1e-7 - lat_deg) * _METRES_PER_DEGREE
    east_m = (position["lon"] * 1e-7 - lon_deg) * _METRES_PER_DEGREE * math.cos(math.radians(lat_deg))
    return math.hypot(north_m, east_m)
