"""What a ground station is told that the vehicle is. A persona belongs to a link; the vessel's state knows nothing of
it.

Numbers: PX4's `custom_mode` is main << 16 | sub << 24; ArduPilot's is that of Rover (MAVLink, ardupilotmega.xml,
ROVER_MODE).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from companion.core.decision import ModeDeclaration, ModeId, Need, Order
from companion.io.mavlink.wire import messages as mavlink
from companion.modes.table import DECLARATIONS

_PX4_MODES = {mode: declared.px4 for mode, declared in DECLARATIONS.items()}
_ROVER_MODES = {mode: declared.rover for mode, declared in DECLARATIONS.items()}
_PX4_ALIASES = {number: mode for mode, declared in DECLARATIONS.items() for number in declared.px4_aliases}
_OF_ARDUPILOT = frozenset({mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT})
_ROVER_ORDERS = {number: order for declared in DECLARATIONS.values() for number, order in declared.rover_orders.items()}
_ROVER_ALIASES = {number: mode for mode, declared in DECLARATIONS.items() for number in declared.rover_aliases}


def _base_mode(declared: ModeDeclaration) -> int:
    """MAV_MODE_FLAGs of a mode."""
    flags: int = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    if Need.HEADING in declared.needs:
        flags |= mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    flags |= mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED if declared.by_stick else mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    if declared.has_plan and not declared.by_stick:
        flags |= mavlink.MAV_MODE_FLAG_AUTO_ENABLED
    return flags


_BASE_MODES = {mode: _base_mode(declared) for mode, declared in DECLARATIONS.items()}


@dataclass(frozen=True, slots=True)
class Persona:
    """One identity: autopilot type, mode numbers, how parameters are encoded, what mission item 0 means.

    `bytewise_parameters`: an INT32 travels as its four bytes in the float field (PX4), else as the float of the same
    value (ArduPilot). `home_is_item_zero`: in missions item 0 is home, and the first real item is number 1.
    `offboard_may_wait`: its number of Offboard also means to wait for a go-to, which is Hold, where no setpoints come;
    the go-to may be a single setpoint.
    `zero_yaw_is_unset`: clients of this persona send 0 where MAVLink says NaN for a heading that does not matter.
    `waits_for_its_number`: its clients wait for the very number that they asked for, also where it is an alias: Cockpit
    starts no mission before it sees LOITER.
    `unknown`: messages that its clients do not know. MAVProxy and Mission Planner count each as a lost packet, so they
    come when they change or are asked for, not regularly.
    `overrides`: channels of surge, sway and yaw in RC_CHANNELS_OVERRIDE; None: those of PX4's sticks.
    `calibrates_by_messages`: it reports a compass calibration as MAG_CAL messages (ArduPilot), else as texts (PX4).
    `has_parameter_hash`: its clients keep the parameters, and ask for their hash to know whether they still hold.
    """

    name: str
    autopilot: int
    modes: Mapping[ModeId, int]
    bytewise_parameters: bool
    home_is_item_zero: bool
    zero_yaw_is_unset: bool = False
    offboard_may_wait: bool = False
    waits_for_its_number: bool = False
    calibrates_by_messages: bool = False
    overrides: tuple[int, int, int] | None = None
    packs_main_and_sub: bool = True  # custom_mode is made of a main and a sub mode
    has_parameter_hash: bool = False
    has_events: bool = True  # its clients may know MAVLink's events interface; PX4's numbers of modes stand in them
    unknown: frozenset[int] = frozenset()
    aliases: Mapping[int, ModeId] = field(default_factory=dict)  # numbers that are understood too
    orders: Mapping[int, Order] = field(default_factory=dict)  # how the mode of a number is to be sailed

    def __hash__(self) -> int:
        return hash(self.name)

    def custom_mode(self, mode: ModeId, asked: int | None = None) -> int:
        """The number under which `mode` is sent. `asked`: the number that a client asked for last."""
        if asked is not None and self.waits_for_its_number and self.aliases.get(asked) is mode:
            return asked
        return self.modes[mode]

    def mode(self, custom_mode: int, offered: frozenset[ModeId] = frozenset(ModeId)) -> ModeId | None:
        """The mode that a number asks for, among those offered; None for a number that means none of them."""
        for mode, number in self.modes.items():
            if number == custom_mode and mode in offered:
                return mode
        alias = self.aliases.get(custom_mode)
        return alias if alias in offered else None

    def base_mode(self, mode: ModeId, armed: bool) -> int:
        """HEARTBEAT.base_mode: always with CUSTOM_MODE_ENABLED; the other flags inform only, but for SAFETY_ARMED."""
        return _BASE_MODES[mode] | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0)

    @property
    def first_item(self) -> int:
        """Number, in this persona, of the vessel's mission item 0."""
        return 1 if self.home_is_item_zero else 0


PX4 = Persona(
    "px4",
    mavlink.MAV_AUTOPILOT_PX4,
    _PX4_MODES,
    bytewise_parameters=True,
    home_is_item_zero=False,
    has_parameter_hash=True,
    unknown=_OF_ARDUPILOT,
    aliases=_PX4_ALIASES,
)
GENERIC = Persona(
    "generic",
    mavlink.MAV_AUTOPILOT_GENERIC,
    _PX4_MODES,
    bytewise_parameters=True,
    home_is_item_zero=False,
    unknown=_OF_ARDUPILOT,
    aliases=_PX4_ALIASES,
)
ARDUPILOT = Persona(
    "ardupilot",
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    _ROVER_MODES,
    bytewise_parameters=False,
    home_is_item_zero=True,
    zero_yaw_is_unset=True,
    offboard_may_wait=True,
    waits_for_its_number=True,
    calibrates_by_messages=True,
    overrides=(3, 4, 1),  # Rover's throttle, lateral and steering (RCMAP_THROTTLE, RCMAP_YAW, RCMAP_ROLL)
    packs_main_and_sub=False,
    has_events=False,
    unknown=frozenset(
        {
            mavlink.MAVLINK_MSG_ID_CURRENT_MODE,
            mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES_MONITOR,
            mavlink.MAVLINK_MSG_ID_CONTROL_STATUS,
        }
    ),
    aliases=_ROVER_ALIASES,
    orders=_ROVER_ORDERS,
)

PERSONAS: Mapping[str, Persona] = {persona.name: persona for persona in (PX4, ARDUPILOT, GENERIC)}
DEFAULT_PERSONA = PX4
