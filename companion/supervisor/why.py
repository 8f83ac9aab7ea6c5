"""Why the boat is as it is: armed or not, in this mode, at this speed. Lines for a person who asks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from companion.core.actuation import ThrusterCondition
from companion.core.setpoint import NeutralSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import Tick
from companion.modes.table import DECLARATIONS
from companion.supervisor.mode_changes import Cause
from companion.supervisor.snapshot import BoatSnapshot

CAUSES: Mapping[Cause, str] = {
    Cause.SAFE_SWITCH: "the transmitter's safe switch is on",
    Cause.TRANSMITTER: "a switch of the transmitter asked for it",
    Cause.OPERATOR: "a ground station asked for it",
    Cause.LEAD_BOAT: "the lead boat's crew asked for it",
    Cause.FAILSAFE: "a failsafe acted",
    Cause.FAILSAFE_OVER: "a failsafe is over",
    Cause.FENCE: "the fence cuts off the way",
    Cause.MODE_FAILED: "a mode failed: see events",
    Cause.OBSTACLE: "an obstacle is in the way, and no way leads round",
    Cause.GUARD_FAILED: "fence or traffic failed: see events",
    Cause.MISSION_ITEM: "the mission asked for it",
    Cause.MISSION_ITEM_REFUSED: "the mission's item was refused: see events",
    Cause.MISSION_END: "the mission has ended",
    Cause.TRIAL_END: "the trial has ended: see events",
    Cause.RESTART: "a mission was interrupted by a restart",
}
"""Each reason for a mode, in the words of an answer to "why"."""

_ONLY_WARNS = 1  # of GF_ACTION
_AXES = ("surge", "sway", "yaw")


def why(boat: BoatSnapshot) -> Iterator[str]:
    """Arming, mode and speed, each with its reason."""
    yield from _arming(boat)
    yield from _mode(boat)
    if boat.tick is not None:
        yield from _speed(boat, boat.tick)


def _arming(boat: BoatSnapshot) -> Iterator[str]:
    status = boat.status
    if status.armed:
        yield "Armed"
    elif not status.arming_refusals:
        yield "Disarmed: nothing speaks against arming"
    else:
        yield "Disarmed; arming would be refused:"
        yield from (f"  {reason}" for reason in status.arming_refusals)
    warnings = [finding.text for finding in boat.report.findings if not finding.blocks]
    yield from (f"  warning: {text}" for text in warnings)


def _mode(boat: BoatSnapshot) -> Iterator[str]:
    status = boat.status
    reason = "as at the start" if boat.cause is None else CAUSES[boat.cause]
    yield f"Mode {status.mode.value}: {reason}"
    if status.intended_mode is not status.mode:
        yield f"  asked for: {status.intended_mode.value}"
    yield from (f"  failsafe lasts: {name}" for name in status.failsafes)
    if status.fence is not None and status.fence.breached:
        only_warns = boat.parameters["GF_ACTION"] == _ONLY_WARNS
        yield "  outside the fence" + ("; GF_ACTION 1 only warns" if only_warns else "")


def _speed(boat: BoatSnapshot, tick: Tick) -> Iterator[str]:
    nav = tick.nav
    now = f"{math.hypot(nav.surge_mps, nav.sway_mps):.2f} m/s" if nav.position_valid else "not known"
    if not boat.status.armed:
        yield f"Speed {now}: no thrust while disarmed"
    elif isinstance(tick.setpoint, NeutralSetpoint):
        yield f"Speed {now}: no thrust: {_why_neutral(boat)}"
    elif DECLARATIONS[boat.status.mode].by_stick:
        yield f"Speed {now}: sticks steer"
    else:
        motion = desired_motion(tick.setpoint)
        yield f"Speed {now}; asked now: {math.hypot(motion.surge_mps, motion.sway_mps):.2f} m/s"
        yield f"  under way: {_cruise(boat)}"
        if isinstance(tick.setpoint, PoseSetpoint):
            yield "  dynamic positioning: it comes to a place, or holds one"
    if boat.status.fence is not None and boat.status.fence.slowed:
        yield "  slowed so that it can stop inside the fence"
    yield from _thrust(boat, tick)


def _why_neutral(boat: BoatSnapshot) -> str:
    if boat.status.failsafes:
        return f"failsafe {boat.status.failsafes[0]}"
    if DECLARATIONS[boat.status.mode].by_stick:
        return "no sticks heard, or not yet centred"
    return "the mode gives none" if boat.cause is None else CAUSES[boat.cause]


def _cruise(boat: BoatSnapshot) -> str:
    asked_mps, most_mps = boat.status.speed_override_mps, boat.parameters["MPC_XY_VEL_MAX"]
    set_mps = boat.parameters["WP_SPEED"] if asked_mps is None else asked_mps
    by = "WP_SPEED" if asked_mps is None else "as asked for"
    return f"{set_mps:.2f} m/s, {by}" if set_mps < most_mps else f"{most_mps:.2f} m/s, at most MPC_XY_VEL_MAX"


def _thrust(boat: BoatSnapshot, tick: Tick) -> Iterator[str]:
    """What the thrusters cannot give."""
    if boat.status.armed and any(tick.allocation.limited):
        short = ", ".join(axis for axis, limited in zip(_AXES, tick.allocation.limited, strict=True) if limited)
        yield f"  thrusters give all they can: {short}"
    for thruster, condition in zip(boat.config.thrusters, tick.conditions, strict=False):
        if condition is not ThrusterCondition.READY:
            yield f"  {thruster.name}: {condition.value}"
