"""Whether the boat may be armed. A new check is one function and one row of CHECKS."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from companion.supervisor.authority import Action, Request, refusal
from companion.supervisor.situation import Situation

Check = Callable[[Situation], Iterator[str]]


def arming_refusals(situation: Situation) -> tuple[str, ...]:
    """Every reason against arming, for people; empty when arming would be accepted. Without ARM_CHECKS only the reason
    for which the mode cannot be entered."""
    reasons = [reason for check in CHECKS for reason in check(situation)] if situation.parameters["ARM_CHECKS"] else []
    if situation.mode_refusal is not None and situation.mode_refusal not in reasons:
        reasons.append(f"{situation.mode.id.value}: {situation.mode_refusal}")
    return tuple(reasons)


def _position(s: Situation) -> Iterator[str]:
    if s.parameters["ARM_NEED_POS"] and not s.nav.position_valid:
        yield "position not valid"


def _heading(s: Situation) -> Iterator[str]:
    if s.parameters["ARM_NEED_POS"] and not s.nav.heading_valid:
        yield "heading not valid"


def _devices(s: Situation) -> Iterator[str]:
    for device in (*s.sensors.values(), *s.bridges.values()):
        if not device.ok:
            yield f"{device.name}: {device.text or 'no data'}"


def _thrusters(s: Situation) -> Iterator[str]:
    for name in s.failed_thrusters:
        yield f"thruster {name} has failed"


def _battery(s: Situation) -> Iterator[str]:
    battery = s.inputs.battery
    if battery is not None and battery.remaining is not None and battery.remaining < s.parameters["BAT_CRIT_THR"]:
        yield f"battery critical: {100.0 * battery.remaining:.0f} % left"


def _leak(s: Situation) -> Iterator[str]:
    if s.inputs.leak is not None and s.inputs.leak.wet:
        yield "water in the hull"


def _authority(s: Situation) -> Iterator[str]:
    if (reason := refusal(Request(Action.ARM), s.authority)) is not None:
        yield reason


CHECKS: tuple[Check, ...] = (_position, _heading, _devices, _thrusters, _battery, _leak, _authority)
