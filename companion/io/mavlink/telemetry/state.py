"""Messages about the vessel's state: mode, arming, health, mission, home, battery."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from companion.core.actuation import ThrusterCondition
from companion.core.decision import MissionState, ModeId
from companion.core.readings import Battery, FixType
from companion.io.mavlink.telemetry.view import (
    UINT8_UNKNOWN,
    UINT16_UNKNOWN,
    View,
    degrees_e7,
    fitted,
    millimetres,
    standard_mode,
)
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona
from companion.mission.plan import PlanKind
from companion.modes.mode import ModeInfo

_STALE_S = 2.0
_ADVANCED, _NOT_SELECTABLE, _AUTO = 1, 2, 4  # MAV_MODE_PROPERTY
_CELL_MOST_MV = 0xFFFE
_SYSTEM_MANAGER, _TAKEOVER_ALLOWED = 1, 2  # GCS_CONTROL_STATUS_FLAGS
_RESET = 1  # MAV_EVENT_CURRENT_SEQUENCE_FLAGS


def heartbeat(view: View, persona: Persona) -> Any:
    """HEARTBEAT; its system status is CRITICAL while a failsafe acts."""
    status = view.status
    if status.failsafes:
        system_status = mavlink.MAV_STATE_CRITICAL
    else:
        system_status = mavlink.MAV_STATE_ACTIVE if status.armed else mavlink.MAV_STATE_STANDBY
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_SURFACE_BOAT,
        persona.autopilot,
        persona.base_mode(status.mode, status.armed),
        view.custom_mode(persona, status.mode),
        system_status,
        3,
    )


def extended_sys_state(view: View, persona: Persona) -> Any:
    """EXTENDED_SYS_STATE. An armed boat is "in the air" until its voyage is over: otherwise QGroundControl offers no
    return, pause or go-to."""
    under_way = view.status.armed and not view.status.landed
    landed = mavlink.MAV_LANDED_STATE_IN_AIR if under_way else mavlink.MAV_LANDED_STATE_ON_GROUND
    return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, landed)


def current_mode(view: View, persona: Persona) -> Any:
    """CURRENT_MODE."""
    status = view.status
    return mavlink.MAVLink_current_mode_message(
        standard_mode(status.mode),
        view.custom_mode(persona, status.mode),
        view.custom_mode(persona, status.intended_mode),
    )


def control_status(view: View, persona: Persona) -> Any:
    """CONTROL_STATUS: which system has operator control, and whether another ground station may take it over. In both
    forms of it: a ground station knows one, and drops the other."""
    system, takeover = view.control
    flags = _SYSTEM_MANAGER | (_TAKEOVER_ALLOWED if takeover else 0)
    return (
        mavlink.MAVLink_control_status_message(system, flags),
        mavlink.CONTROL_STATUS_OWNERS(flags, system, (0,) * 10),
    )


def current_event_sequence(view: View, persona: Persona) -> Any:
    """CURRENT_EVENT_SEQUENCE: the number of the newest event. Before the first event it tells ground stations that the
    numbers begin anew; None for a persona without events."""
    sequence, fresh = view.event_sequence
    if not persona.has_events:
        return None
    return mavlink.MAVLink_current_event_sequence_message(sequence, _RESET if fresh else 0)


def available_modes_monitor(view: View, persona: Persona) -> Any:
    """AVAILABLE_MODES_MONITOR: its number changes with the list of modes."""
    return mavlink.MAVLink_available_modes_monitor_message(view.modes_seq)


def available_mode(modes: Sequence[ModeInfo], index: int, persona: Persona) -> Any:
    """AVAILABLE_MODES of the mode number `index` (from 1)."""
    mode = modes[index - 1]
    declared = mode.declaration
    properties = 0 if declared.selectable else _NOT_SELECTABLE
    properties |= 0 if declared.by_stick else _AUTO
    properties |= _ADVANCED if declared.advanced else 0
    return mavlink.MAVLink_available_modes_message(
        len(modes),
        index,
        standard_mode(declared.id),
        persona.custom_mode(declared.id),
        properties,
        declared.id.value.encode("ascii"),
    )


def sys_status(view: View, persona: Persona) -> Any:
    """SYS_STATUS: which sensors are present and healthy, load and battery."""
    tick = view.tick
    if tick is None:
        return None
    bits = _sensor_bits(view)
    present = enabled = health = 0
    for bit, (is_enabled, is_healthy) in bits.items():
        present |= bit
        enabled |= bit if is_enabled else 0
        health |= bit if is_healthy else 0
    if mavlink.MAV_SYS_STATUS_GEOFENCE not in bits:  # MAVProxy reports a breach where the health bit is missing
        health |= mavlink.MAV_SYS_STATUS_GEOFENCE
    battery = tick.inputs.battery
    voltage = UINT16_UNKNOWN if battery is None else fitted(battery.voltage_v, 1000.0, 0, _CELL_MOST_MV, UINT16_UNKNOWN)
    current = -1 if battery is None else fitted(battery.current_a, 100.0, -1, 0x7FFF, -1)
    remaining = -1 if battery is None else fitted(battery.remaining, 100.0, 0, 100, -1)
    load = fitted(tick.load, 1000.0, 0, 1000, 0)
    return mavlink.MAVLink_sys_status_message(
        present, enabled, health, load, voltage, current, remaining, 0, 0, 0, 0, 0, 0
    )


def _sensor_bits(view: View) -> dict[int, tuple[bool, bool]]:
    """MAV_SYS_STATUS_SENSOR bit → (enabled, healthy), for the sensors that are present."""
    tick, status = view.tick, view.status
    assert tick is not None
    nav, inputs = tick.nav, tick.inputs
    # a boat with a satellite compass may have no IMU; then the IMU bits show whether all its devices are healthy
    without_imu = math.isinf(nav.imu_age_s) and nav.heading_valid and all(device.ok for device in tick.health)
    lies = {distrust.sense for distrust in nav.distrusted}
    imu = (nav.imu_age_s < _STALE_S or without_imu) and "IMU" not in lies
    gyro, accelerometer = imu and "gyro" not in lies, imu and "accelerometer" not in lies
    heading = nav.heading_valid and "heading" not in lies  # the heading source, whichever it is
    receiver = nav.position_valid and nav.fix >= FixType.FIX_2D and lies.isdisjoint(("position", "velocity"))
    bits = {
        mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO: (True, gyro),
        mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL: (True, accelerometer),
        mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG: (True, heading),
        mavlink.MAV_SYS_STATUS_SENSOR_GPS: (True, receiver),
        mavlink.MAV_SYS_STATUS_AHRS: (True, nav.heading_valid and nav.position_valid),
        mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS: (True, ThrusterCondition.FAILED not in tick.conditions),
        mavlink.MAV_SYS_STATUS_PREARM_CHECK: (True, status.armed or not status.arming_refusals),
    }
    if inputs.battery is not None:
        remaining = inputs.battery.remaining
        low = remaining is not None and remaining < view.vessel.parameters["BAT_LOW_THR"]
        bits[mavlink.MAV_SYS_STATUS_SENSOR_BATTERY] = (True, not low)
    if inputs.rc is not None:
        bits[mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER] = (
            True,
            not inputs.rc.lost and view.now_s - inputs.rc.t_s < _STALE_S,
        )
    if status.fence is not None:
        bits[mavlink.MAV_SYS_STATUS_GEOFENCE] = (True, not status.fence.breached)
    return bits


def fence_status(view: View, persona: Persona) -> Any:
    """FENCE_STATUS; None while no fence is in force."""
    fence = view.status.fence
    if fence is None:
        return None
    happened = mavlink.FENCE_BREACH_BOUNDARY if fence.breached or fence.breaches else mavlink.FENCE_BREACH_NONE
    since_ms = 0 if fence.breach_s is None else int(fence.breach_s * 1000.0) & 0xFFFFFFFF
    mitigation = mavlink.FENCE_MITIGATE_VEL_LIMIT if fence.slowed else mavlink.FENCE_MITIGATE_NONE
    return mavlink.MAVLink_fence_status_message(
        int(fence.breached), min(fence.breaches, UINT16_UNKNOWN), happened, since_ms, mitigation
    )


def battery_status(view: View, persona: Persona) -> Any:
    """BATTERY_STATUS of each pack, numbered from 0; None while none is measured."""
    packs = () if view.tick is None else view.tick.inputs.batteries
    return tuple(_pack_status(number, pack, view) for number, pack in enumerate(packs) if pack is not None) or None


def _pack_status(number: int, battery: Battery, view: View) -> Any:
    """BATTERY_STATUS of one pack."""
    cells = [UINT16_UNKNOWN] * 10
    # the whole pack as one "cell", as more cells where the field would overflow
    rest = fitted(battery.voltage_v, 1000.0, 0, 10 * _CELL_MOST_MV, 0)
    for i in range(10):
        cells[i] = min(rest, _CELL_MOST_MV)
        rest -= cells[i]
        if rest <= 0:
            break
    remaining = battery.remaining
    state = mavlink.MAV_BATTERY_CHARGE_STATE_UNDEFINED
    if remaining is not None:
        parameters = view.vessel.parameters
        state = mavlink.MAV_BATTERY_CHARGE_STATE_OK
        if remaining < parameters["BAT_CRIT_THR"]:
            state = mavlink.MAV_BATTERY_CHARGE_STATE_CRITICAL
        elif remaining < parameters["BAT_LOW_THR"]:
            state = mavlink.MAV_BATTERY_CHARGE_STATE_LOW
    current = fitted(battery.current_a, 100.0, -1, 0x7FFF, -1)
    return mavlink.MAVLink_battery_status_message(
        number,
        mavlink.MAV_BATTERY_FUNCTION_ALL,
        0,
        0x7FFF,
        cells,
        current,
        -1,
        -1,
        fitted(remaining, 100.0, 0, 100, -1),
        charge_state=state,
    )


def home_position(view: View, persona: Persona) -> Any:
    """HOME_POSITION; None while home is not set."""
    home = view.status.home
    if home is None:
        return None
    north_m, east_m = view.vessel.frame.to_ned(home.lat_deg, home.lon_deg)
    half_rad = 0.5 * home.yaw_rad if home.yaw_rad is not None else math.nan
    attitude = (
        (math.cos(half_rad), 0.0, 0.0, math.sin(half_rad))
        if home.yaw_rad is not None
        else (math.nan, math.nan, math.nan, math.nan)
    )
    return mavlink.MAVLink_home_position_message(
        degrees_e7(home.lat_deg),
        degrees_e7(home.lon_deg),
        millimetres(home.altitude_m),
        north_m,
        east_m,
        0.0,
        attitude,
        math.nan,
        math.nan,
        math.nan,
        view.unix_us,
    )


def mission_current(view: View, persona: Persona) -> Any:
    """MISSION_CURRENT: item, state and the ids of the three plans."""
    progress, plans = view.status.mission, view.vessel.plans
    in_mode = view.status.mode is ModeId.MISSION
    none = progress.state is MissionState.NO_MISSION
    return mavlink.MAVLink_mission_current_message(
        0 if none else min(progress.seq + persona.first_item, UINT16_UNKNOWN),
        UINT16_UNKNOWN if none else progress.count,
        progress.state,
        0 if none else (1 if in_mode else 2),
        plans.plan_id(PlanKind.MISSION),
        plans.plan_id(PlanKind.FENCE),
        plans.plan_id(PlanKind.RALLY),
    )


def mission_item_reached(view: View, persona: Persona) -> Any:
    """MISSION_ITEM_REACHED of the last item reached; None before the first."""
    seq = view.status.mission.reached_seq
    return (
        None
        if seq is None
        else mavlink.MAVLink_mission_item_reached_message(min(seq + persona.first_item, UINT16_UNKNOWN))
    )


def system_time(view: View, persona: Persona) -> Any:
    """SYSTEM_TIME: by GNSS where known, else by the computer's clock."""
    tick = view.tick
    if tick is None:
        return None
    unix_ns = tick.nav.time_unix_ns or tick.time_unix_ns
    return mavlink.MAVLink_system_time_message(max(0, unix_ns // 1000), view.boot_ms)


def rc_channels(view: View, persona: Persona) -> Any:
    """RC_CHANNELS of the transmitter, 1000…2000 µs; None without an RC receiver."""
    rc = None if view.tick is None else view.tick.inputs.rc
    if rc is None:
        return None
    channels = [fitted(1500.0 + 500.0 * value, 1.0, 800, 2200, UINT16_UNKNOWN) for value in rc.channels[:18]]
    channels += [UINT16_UNKNOWN] * (18 - len(channels))
    return mavlink.MAVLink_rc_channels_message(
        view.boot_ms, min(18, len(rc.channels)), *channels, 0 if rc.lost else UINT8_UNKNOWN
    )
