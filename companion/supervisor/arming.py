"""Whether the boat may be armed, and in which modes. A new check is one function and one row of CHECKS."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from companion.core.arming import ArmingCheck, ArmingFinding, ArmingReport
from companion.core.decision import ModeId
from companion.modes.mode import Mode
from companion.supervisor.authority import AuthorityRequest, RequestedAction, Right, refusal
from companion.supervisor.situation import Situation

Looks = Callable[[Situation], Iterator[ArmingFinding]]


def arming_refusals(situation: Situation, right: Right = Right.GROUND_STATION, force: bool = False) -> tuple[str, ...]:
    """Every reason against arming, for people; empty when arming would be accepted. By `force`, or without ARM_CHECKS,
    only the kill switch and the reason for which the mode cannot be entered. `right`: of the one who arms."""
    checked = _checks(situation) and not force
    reasons = [finding.text for check in CHECKS for finding in check(situation)] if checked else []
    request = AuthorityRequest(RequestedAction.ARM if checked else RequestedAction.ARM_BY_FORCE, right)
    if (reason := refusal(request, situation.authority)) is not None:
        reasons.append(reason)
    if situation.mode_refusal is not None and situation.mode_refusal not in reasons:
        reasons.append(f"{situation.mode.id.value}: {situation.mode_refusal}")
    return tuple(reasons)


def arming_report(
    situation: Situation, modes: Mapping[ModeId, Mode], refusals: Mapping[ModeId, str | None]
) -> ArmingReport:
    """Every finding, for the present mode and all others, armed or not. `refusals`: why each mode cannot be entered."""
    findings = [*_general(situation), *_warnings(situation)]
    blocked = any(finding.blocks for finding in findings)
    findings += _estimate(situation, modes)
    findings += [
        ArmingFinding(ArmingCheck.MODE, reason, modes=frozenset({mode}))
        for mode, reason in refusals.items()
        if reason is not None and not _by_estimate(situation, modes[mode], reason)
    ]
    free = {mode for mode, reason in refusals.items() if reason is None}
    allowed = {
        mode
        for mode in free
        if refusal(AuthorityRequest(RequestedAction.CHANGE_MODE, mode=mode), situation.authority) is None
    }
    return ArmingReport(
        tuple(findings), frozenset() if blocked else frozenset(free), frozenset(allowed), _measured(situation)
    )


def _general(situation: Situation) -> Iterator[ArmingFinding]:
    """The findings of CHECKS, without ARM_CHECKS as warnings, and who forbids arming."""
    checked = _checks(situation)
    for check in CHECKS:
        for finding in check(situation):
            yield finding if checked else replace(finding, blocks=False)
    facts = situation.authority
    if (
        reason := refusal(AuthorityRequest(RequestedAction.ARM if checked else RequestedAction.ARM_BY_FORCE), facts)
    ) is not None:
        yield ArmingFinding(ArmingCheck.KILL_SWITCH if facts.kill_switch else ArmingCheck.AUTHORITY, reason)


def _checks(situation: Situation) -> bool:
    return bool(situation.parameters["ARM_CHECKS"])


def _warnings(s: Situation) -> Iterator[ArmingFinding]:
    """What does not speak against arming, but should be known before."""
    remaining = None if s.inputs.battery is None else s.inputs.battery.remaining
    if remaining is not None and s.parameters["BAT_CRIT_THR"] <= remaining < s.parameters["BAT_LOW_THR"]:
        yield ArmingFinding(ArmingCheck.BATTERY_LOW, "battery low", value=remaining, blocks=False)


def _estimate(s: Situation, modes: Mapping[ModeId, Mode]) -> Iterator[ArmingFinding]:
    """What the estimate lacks for some modes, where ARM_NEED_POS does not ask for it in all."""
    if s.parameters["ARM_NEED_POS"] and s.parameters["ARM_CHECKS"]:
        return
    needing_position = frozenset(mode.id for mode in modes.values() if mode.needs_position)
    needing_heading = frozenset(mode.id for mode in modes.values() if mode.needs_heading)
    if not s.nav.position_valid:
        yield ArmingFinding(ArmingCheck.POSITION, "position not valid", modes=needing_position)
    if not s.nav.heading_valid:
        yield ArmingFinding(ArmingCheck.HEADING, "heading not valid", modes=needing_heading)


def _by_estimate(s: Situation, mode: Mode, reason: str) -> bool:
    """Whether the mode is refused for what the estimate lacks, which has a finding of its own."""
    return (mode.needs_position and not s.nav.position_valid and reason == "position not valid") or (
        mode.needs_heading and not s.nav.heading_valid and reason == "heading not valid"
    )


def _measured(s: Situation) -> frozenset[ArmingCheck]:
    measured = set(ArmingCheck)
    if s.inputs.battery is None:
        measured -= {ArmingCheck.BATTERY, ArmingCheck.BATTERY_LOW}
    if s.inputs.leak is None:
        measured.discard(ArmingCheck.LEAK)
    if s.inputs.rc is None:
        measured -= {ArmingCheck.AUTHORITY, ArmingCheck.KILL_SWITCH, ArmingCheck.KILL_SWITCH_FAULT}
    return frozenset(measured)


def _position(s: Situation) -> Iterator[ArmingFinding]:
    if s.parameters["ARM_NEED_POS"] and not s.nav.position_valid:
        yield ArmingFinding(ArmingCheck.POSITION, "position not valid")


def _heading(s: Situation) -> Iterator[ArmingFinding]:
    if s.parameters["ARM_NEED_POS"] and not s.nav.heading_valid:
        yield ArmingFinding(ArmingCheck.HEADING, "heading not valid")


def _devices(s: Situation) -> Iterator[ArmingFinding]:
    for device in (*s.sensors.values(), *s.bridges.values()):
        if not device.ok:
            yield ArmingFinding(
                ArmingCheck.DEVICE, f"{device.name}: {device.text or 'no data'}", device.name, device.age_s
            )


def _thrusters(s: Situation) -> Iterator[ArmingFinding]:
    for name in s.failed_thrusters:
        yield ArmingFinding(ArmingCheck.THRUSTER, f"thruster {name} has failed", name)


def _battery(s: Situation) -> Iterator[ArmingFinding]:
    battery = s.inputs.battery
    if battery is not None and battery.remaining is not None and battery.remaining < s.parameters["BAT_CRIT_THR"]:
        text = f"battery critical: {100.0 * battery.remaining:.0f} % left"
        yield ArmingFinding(ArmingCheck.BATTERY, text, value=battery.remaining)


def _leak(s: Situation) -> Iterator[ArmingFinding]:
    if s.inputs.leak is not None and s.inputs.leak.wet:
        yield ArmingFinding(ArmingCheck.LEAK, "water in the hull")


def _kill_switch(s: Situation) -> Iterator[ArmingFinding]:
    if s.kill_switch_fault is not None:
        yield ArmingFinding(ArmingCheck.KILL_SWITCH_FAULT, s.kill_switch_fault)


def _fence(s: Situation) -> Iterator[ArmingFinding]:
    if s.fence_preparing:
        yield ArmingFinding(ArmingCheck.FENCE, "fence is being prepared: wait")


def _ranges(s: Situation) -> Iterator[ArmingFinding]:
    """Ranges that came over a link, and those of a device that speaks and knows none: one that is silent is refused as
    a device."""
    if s.parameters["CP_DIST"] >= 0.0:
        for name in s.silent_ranges:
            if name not in s.sensors or s.sensors[name].ok:
                yield ArmingFinding(ArmingCheck.DEVICE, f"no ranges from {name}", name)


CHECKS: tuple[Looks, ...] = (
    _position,
    _heading,
    _devices,
    _thrusters,
    _battery,
    _leak,
    _kill_switch,
    _fence,
    _ranges,
)
