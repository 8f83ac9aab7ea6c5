"""What arming checks and failsafes see: the vessel in one tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from companion.core.decision import ModeId
from companion.core.estimate import NavState
from companion.core.tick import DeviceHealth, Inputs
from companion.modes.mode import Mode
from companion.params.store import Parameters
from companion.supervisor.authority import Facts


@dataclass(frozen=True, slots=True)
class Source:
    """What one mode steers by. `fault`: why it is lost, None while it is good; `good_s`: for how long it has been good;
    `stays`: why the boat would not return to the mode by itself."""

    fault: str | None
    good_s: float = math.inf
    stays: str | None = None


GOOD = Source(None)


@dataclass(frozen=True, slots=True)
class Situation:
    """`intended`: the mode last asked for by a person. `mode_refusal`: why the present mode could not be entered now,
    or None.

    `sticks_age_s`: since the sticks in charge were heard, None if none ever were. `ground_station_age_s`
    likewise. `bridges`, `sensors`: health by name. `authority`: what it depends on who is obeyed. `sources`: of the
    modes that declare a failsafe.
    """

    now_s: float
    nav: NavState
    inputs: Inputs
    bridges: Mapping[str, DeviceHealth]
    sensors: Mapping[str, DeviceHealth]
    parameters: Parameters
    armed: bool
    mode: Mode
    intended: Mode
    mode_refusal: str | None
    sticks_age_s: float | None
    ground_station_age_s: float | None
    authority: Facts
    sources: Mapping[ModeId, Source]
    failed_thrusters: tuple[str, ...] = ()
    lost_motions: tuple[str, ...] = ()  # what thrusters that have failed leave the boat unable to do
    keeps_straight: bool = True  # with the thrusters left; otherwise it goes in circles
    fence_preparing: bool = False  # a fence that is set is not in force yet
    kill_switch_fault: str | None = None  # why the transmitter's kill switch would not work
    ticks_late: bool = False  # the computer does not keep up
    worst_late_s: float = 0.0  # the latest of these ticks
    tilt_rad: float | None = None  # of a boat that is capsized
    aground_or_fouled: bool = False  # thrust makes no way
    depth_m: float | None = None  # where it is too shallow
    home_share: float | None = None  # of the battery, with which the boat gets home; None where not known
    range_short: bool = False  # less is left
    silent_ranges: tuple[str, ...] = ()  # ranging sensors that were heard before
    rests: bool = False  # without thrust since its mission ended, as MIS_DONE_ACT says
    fence: str | None = None  # what is wrong with the boat's place, or soon will be


def estimate_refusal(mode: Mode, nav: NavState) -> str | None:
    """Why the estimate is not good enough for `mode`, or None."""
    if mode.needs_position and not nav.position_valid:
        return "position not valid"
    if mode.needs_heading and not nav.heading_valid:
        return "heading not valid"
    return None
