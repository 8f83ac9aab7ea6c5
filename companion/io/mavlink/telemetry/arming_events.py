"""The arming checks as events, in the order that libevents' protocol of health and arming checks asks for: summary of
the checks, one event for each finding, summary of the health."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from companion.core.arming import ArmingCheck, ArmingFinding, ArmingReport
from companion.core.decision import ModeId
from companion.io.mavlink.telemetry import event_table as table
from companion.io.mavlink.telemetry.event_table import EventRow
from companion.modes.table import DECLARATIONS

ARGUMENT_BYTES = 40
_FIXED: dict[ArmingCheck, EventRow] = {
    ArmingCheck.POSITION: table.POSITION,
    ArmingCheck.HEADING: table.HEADING,
    ArmingCheck.THRUSTER: table.THRUSTER_FAILED,
    ArmingCheck.BATTERY: table.BATTERY_CRITICAL,
    ArmingCheck.BATTERY_LOW: table.BATTERY_LOW,
    ArmingCheck.LEAK: table.LEAK,
    ArmingCheck.AUTHORITY: table.SAFE_SWITCH,
    ArmingCheck.KILL_SWITCH: table.KILL_SWITCH,
    ArmingCheck.KILL_SWITCH_FAULT: table.KILL_SWITCH_FAULT,
    ArmingCheck.FENCE: table.FENCE_PREPARED,
}


@dataclass(frozen=True, slots=True)
class EventContent:
    """What an EVENT says, without its place in the sequence."""

    id: int
    log_levels: int
    arguments: bytes


class ArmingEvents:
    """Makes events of a boat's arming checks. `devices`, `thrusters`: their names, in the order of the metadata."""

    def __init__(self, devices: Sequence[str], thrusters: Sequence[str]) -> None:
        self.devices, self.thrusters = tuple(devices), tuple(thrusters)

    def report(self, report: ArmingReport) -> tuple[EventContent, ...]:
        """All events of one report."""
        errors = _components(finding.check for finding in report.findings if finding.blocks)
        warnings = _components(finding.check for finding in report.findings if not finding.blocks)
        can_arm, can_run = table.mode_bits(report.can_arm), table.mode_bits(report.can_run)
        return (
            content(table.ARMING_SUMMARY, table.PROTOCOL, 0, errors, warnings, can_arm, can_run),
            *(self._event(finding) for finding in report.findings),
            content(table.HEALTH_SUMMARY, table.PROTOCOL, 0, _components(report.measured), errors, warnings),
        )

    def not_armed(self, custom_mode: int) -> EventContent:
        """Arming was refused: ground stations show it with the findings of the last report for that mode."""
        return content(table.NOT_ARMED, table.ERROR, custom_mode)

    def _event(self, finding: ArmingFinding) -> EventContent:
        row, more = self._row(finding)
        modes = table.mode_bits(DECLARATIONS if finding.modes is None else finding.modes)
        level = table.ERROR if finding.blocks else table.WARNING
        return content(row, level, modes, table.COMPONENT_OF[finding.check], *more)

    def _row(self, finding: ArmingFinding) -> tuple[EventRow, tuple[int, ...]]:
        """The row of a finding, and its arguments after the first two."""
        match finding.check:
            case ArmingCheck.DEVICE:
                row = table.DEVICE_NOT_HEARD if finding.value is None else table.DEVICE_LOST
                return row, (_number(self.devices, finding.subject),)
            case ArmingCheck.THRUSTER:
                return _FIXED[finding.check], (_number(self.thrusters, finding.subject),)
            case ArmingCheck.BATTERY | ArmingCheck.BATTERY_LOW:
                return _FIXED[finding.check], (round(100.0 * min(1.0, max(0.0, finding.value or 0.0))),)
            case ArmingCheck.MODE:
                return _refusal_row(next(iter(finding.modes or ())), finding.text), ()
        return _FIXED[finding.check], ()


def content(row: EventRow, log_levels: int, *values: int) -> EventContent:
    """An event with its arguments. Raises struct.error for values that do not fit."""
    layout = "<" + "".join(table.SIZES[kind] for kind, _ in row.arguments)
    return EventContent(row.id, log_levels, struct.pack(layout, *values).ljust(ARGUMENT_BYTES, b"\0"))


def _refusal_row(mode: ModeId, reason: str) -> EventRow:
    rows, known = table.REFUSAL_ROWS[mode], DECLARATIONS[mode].refusals
    return next(
        (row for row, refusal in zip(rows, known, strict=False) if re.fullmatch(refusal.pattern, reason)), rows[-1]
    )


def remedy_of(finding: ArmingFinding) -> str:
    """What to do about a finding, in the words that ground stations show."""
    match finding.check:
        case ArmingCheck.DEVICE:
            remedy = (table.DEVICE_NOT_HEARD if finding.value is None else table.DEVICE_LOST).remedy
        case ArmingCheck.MODE:
            remedy = _refusal_row(next(iter(finding.modes or ())), finding.text).remedy
        case _:
            remedy = _FIXED[finding.check].remedy
    return re.sub(r"</?param>", "", remedy)


def _components(checks: Iterable[ArmingCheck]) -> int:
    """The parts of the boat that these checks are about, as bits."""
    return sum(1 << number for number in {table.COMPONENT_OF[check] for check in checks})


def _number(names: Sequence[str], name: str) -> int:
    """Numbers count from 1; 0 stands for one that the metadata does not have."""
    return names.index(name) + 1 if name in names else 0
