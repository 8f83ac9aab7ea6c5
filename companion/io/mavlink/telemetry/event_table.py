"""The events of MAVLink's events interface that the boat can send: one row an event, with what ground stations show.

Identifiers and encoding: libevents, README ("Event definitions", "Serialization"). A message names its arguments from 1
on, as `{3}`. In a remedy a name between <param> and </param> is a parameter that QGroundControl opens.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from companion.core.arming import ArmingCheck
from companion.core.decision import ModeDeclaration, ModeId
from companion.modes.table import DECLARATIONS

COMPONENT_ID = 1  # of the events' namespace; MAV_COMP_ID_AUTOPILOT1
MODES, COMPONENTS, DEVICES, THRUSTERS = "navigation_mode_group_t", "health_component_t", "device_t", "thruster_t"
SIZES: Mapping[str, str] = {  # of the arguments' types, for struct
    "uint8_t": "B",
    "uint32_t": "I",
    MODES: "H",
    COMPONENTS: "H",
    DEVICES: "B",
    THRUSTERS: "B",
}
ERROR, WARNING, PROTOCOL = 0x33, 0x44, 0x88  # levels, internal and external; "protocol" is not shown

ARMING, HEALTH, DEFAULT = "arming_check", "health", "default"
SUMMARY, WITH_CHECKS = "summary", "append_health_and_arming_messages"
_CHECK = ((MODES, "modes"), ("uint8_t", "health_component_index"))  # what every check begins with


@dataclass(frozen=True, slots=True)
class Component:
    """One part of the boat in the health report; its place in the table is its number. `checks`: those whose findings
    count for it."""

    name: str
    label: str
    checks: tuple[ArmingCheck, ...] = ()


HEALTH_COMPONENTS: tuple[Component, ...] = (
    Component("none", "None"),  # libevents asks for it
    Component("gps", "Position", (ArmingCheck.POSITION,)),  # QGroundControl colours its GPS symbol by this name
    Component("heading", "Heading", (ArmingCheck.HEADING,)),
    Component("devices", "Sensors and bridges", (ArmingCheck.DEVICE,)),
    Component("thrusters", "Thrusters", (ArmingCheck.THRUSTER,)),
    Component("battery", "Battery", (ArmingCheck.BATTERY, ArmingCheck.BATTERY_LOW)),
    Component("hull", "Hull", (ArmingCheck.LEAK,)),
    Component(
        "transmitter", "Transmitter", (ArmingCheck.AUTHORITY, ArmingCheck.KILL_SWITCH, ArmingCheck.KILL_SWITCH_FAULT)
    ),
    Component("modes", "Modes", (ArmingCheck.MODE,)),
    Component("fence", "Fence", (ArmingCheck.FENCE,)),
)
COMPONENT_OF: Mapping[ArmingCheck, int] = {check: i for i, row in enumerate(HEALTH_COMPONENTS) for check in row.checks}


@dataclass(frozen=True, slots=True)
class EventRow:
    """One event. `arguments`: (type, name) of each. `kind`: its special meaning in libevents, if any."""

    name: str
    group: str
    message: str
    remedy: str = ""
    arguments: tuple[tuple[str, str], ...] = _CHECK
    kind: str = ""

    @property
    def sub_id(self) -> int:
        """The lower 24 bits of the event's id. They follow from the name alone, so they never change with the table."""
        return zlib.crc32(self.name.encode()) & 0xFFFFFF

    @property
    def id(self) -> int:
        """The event's id."""
        return COMPONENT_ID << 24 | self.sub_id


ARMING_SUMMARY = EventRow(
    "arming_check_summary",
    ARMING,
    "Arming checks",
    arguments=(
        ("uint8_t", "chunk_idx"),
        (COMPONENTS, "error"),
        (COMPONENTS, "warning"),
        (MODES, "can_arm"),
        (MODES, "can_run"),
    ),
    kind=SUMMARY,
)
HEALTH_SUMMARY = EventRow(
    "health_summary",
    HEALTH,
    "Health",
    arguments=(
        ("uint8_t", "chunk_idx"),
        (COMPONENTS, "is_present"),
        (COMPONENTS, "error"),
        (COMPONENTS, "warning"),
    ),
    kind=SUMMARY,
)
NOT_ARMED = EventRow(
    "arming_refused",
    DEFAULT,
    "Not armed:",
    "The list of arming checks has what to do.",
    arguments=(("uint32_t", "custom_mode"),),
    kind=WITH_CHECKS,
)
POSITION = EventRow(
    "position_not_valid",
    ARMING,
    "Position not valid",
    "Wait for a satellite fix; look at antenna and receiver. With <param>ARM_NEED_POS</param> 0 only the modes that "
    "need a position are refused.",
)
HEADING = EventRow(
    "heading_not_valid",
    ARMING,
    "Heading not valid",
    "Wait for the compass or the second antenna; look at `heading` of the sensors in the vessel file. With "
    "<param>ARM_NEED_POS</param> 0 only the modes that need a heading are refused.",
)
DEVICE_NOT_HEARD = EventRow(
    "device_not_heard",
    HEALTH,
    "{3}: nothing heard",
    "Look at its cable, its supply and its port in the vessel file. `companion devices` shows what is plugged in.",
    (*_CHECK, (DEVICES, "device")),
)
DEVICE_LOST = EventRow(
    "device_lost",
    HEALTH,
    "{3}: no good data",
    "It was heard before: look at its cable and supply. The boat has said in a text what its driver complains of.",
    (*_CHECK, (DEVICES, "device")),
)
THRUSTER_FAILED = EventRow(
    "thruster_failed",
    HEALTH,
    "Thruster {3} has failed",
    "Look at its drive, plug and propeller. It counts again when it follows its commands.",
    (*_CHECK, (THRUSTERS, "thruster")),
)
BATTERY_CRITICAL = EventRow(
    "battery_critical",
    ARMING,
    "Battery critical: {3} % left",
    "Charge it. <param>BAT_CRIT_THR</param> is the limit.",
    (*_CHECK, ("uint8_t", "percent")),
)
BATTERY_LOW = EventRow(
    "battery_low",
    ARMING,
    "Battery low: {3} % left",
    "Sail a short way only, or charge it. <param>BAT_LOW_THR</param> is the limit.",
    (*_CHECK, ("uint8_t", "percent")),
)
LEAK = EventRow("water_in_the_hull", ARMING, "Water in the hull", "Find the leak and dry the sensor.")
SAFE_SWITCH = EventRow(
    "safe_switch_on",
    ARMING,
    "The transmitter's safe switch is on",
    "Turn it off. <param>MAN_RC_SAFE_CH</param> is its channel.",
)
KILL_SWITCH = EventRow(
    "kill_switch_on",
    ARMING,
    "The transmitter's kill switch is on",
    "Turn it off. <param>RC_MAP_KILL_SW</param> is its channel.",
)
KILL_SWITCH_FAULT = EventRow(
    "kill_switch_fault",
    ARMING,
    "The kill switch would not work",
    "Give <param>RC_MAP_KILL_SW</param> a channel that the transmitter sends and nothing else uses.",
)
FENCE_PREPARED = EventRow(
    "fence_being_prepared",
    ARMING,
    "The fence is being prepared",
    "Wait: a fence of thousands of zones takes some seconds.",
)
ROWS: tuple[EventRow, ...] = (
    ARMING_SUMMARY,
    HEALTH_SUMMARY,
    NOT_ARMED,
    POSITION,
    HEADING,
    DEVICE_NOT_HEARD,
    DEVICE_LOST,
    THRUSTER_FAILED,
    BATTERY_CRITICAL,
    BATTERY_LOW,
    LEAK,
    SAFE_SWITCH,
    KILL_SWITCH,
    KILL_SWITCH_FAULT,
    FENCE_PREPARED,
)
"""The events that do not depend on a mode."""


def refusal_rows(declared: ModeDeclaration) -> tuple[EventRow, ...]:
    """The events of one mode, in the order of its known refusals, and at last one for a reason that is not among
    them."""
    mode, name = declared.id.value, declared.id.name.lower()
    known = [(refusal.text, refusal.remedy) for refusal in declared.refusals]
    texts = [*known, ("it cannot be entered now", "Choose the mode: the boat then says why it refuses.")]
    return tuple(
        EventRow(f"{name}_refused_{number}", ARMING, f"{mode}: {text}", remedy)
        for number, (text, remedy) in enumerate(texts)
    )


REFUSAL_ROWS: Mapping[ModeId, tuple[EventRow, ...]] = {
    mode: refusal_rows(declared) for mode, declared in DECLARATIONS.items()
}
MODE_BITS: Mapping[ModeId, int] = {mode: 1 << number for number, mode in enumerate(DECLARATIONS)}
"""The bit of each mode in sets of modes: each is a group of its own."""


def all_rows() -> tuple[EventRow, ...]:
    """Every event."""
    return (*ROWS, *(row for rows in REFUSAL_ROWS.values() for row in rows))


def mode_bits(modes: Iterable[ModeId]) -> int:
    """A set of modes as bits."""
    return sum(MODE_BITS[mode] for mode in modes)
