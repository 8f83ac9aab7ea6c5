"""Bridge to an autopilot board (a Pixhawk with ArduPilot) whose servo outputs drive the thrusters, by
RC_CHANNELS_OVERRIDE or DO_SET_SERVO.

What a Rover must be set to, override: SERVOn_FUNCTION = 139 + channel (RCINnScaled) and SERVO_RC_FS_MSK with the
channels' bits, so that its radio failsafe sends the outputs to SERVOn_TRIM (standstill; of an azimuth, its rest);
FS_THR_ENABLE 1 and RC_FS_TIMEOUT 0.5, after which it does so without a receiver; RC_OVERRIDE_TIME 0.5 (it comes with
3), after which a receiver has the outputs: it needs those channels, at centre, for one that it lacks reads as full
astern; RCn_MIN, _TRIM, _MAX the same as SERVOn_…, RCn_DZ 0; MAV_GCS_SYSID (SYSID_MYGCS) = `system`. The failsafe looks
at RC channel 3, so without a receiver that channel is kept at its centre. DO_SET_SERVO: SERVOn_FUNCTION = 0. The board
then holds its last pulses for ever when the companion is silent.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from companion.config.actuators.mavlink_servo import MavlinkServoConfig
from companion.config.driving import azimuths_of
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.actuation import DARK, ActuatorCommand, ThrusterFeedback
from companion.core.ports import ByteStream
from companion.core.readings import Battery, Leak, RcInput, Reading
from companion.core.tick import DeviceHealth
from companion.io.actuators.calibration import AzimuthServo, ThrusterOutput
from companion.io.actuators.mavlink_board import BEAT_LOST_S, MavlinkBoard, MavlinkRelays
from companion.io.mavlink.wire import messages as mavlink
from companion.io.rc_receiver import channels

_INTERVALS_S = {
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 0.05,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS: 0.1,
}
_ESC_TELEMETRY = {  # the first of four channels; ArduPilot numbers motor controllers by their servo channel
    mavlink.MAVLINK_MSG_ID_ESC_TELEMETRY_1_TO_4: 1,
    mavlink.MAVLINK_MSG_ID_ESC_TELEMETRY_5_TO_8: 5,
    mavlink.MAVLINK_MSG_ID_ESC_TELEMETRY_9_TO_12: 9,
    mavlink.MAVLINK_MSG_ID_ESC_TELEMETRY_13_TO_16: 13,
}
_ESC_INTERVAL_S, _ESC_STALE_S = 0.1, 0.5
_NEWEST_COUNTS = (mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW, mavlink.MAVLINK_MSG_ID_RC_CHANNELS)
_IGNORE, _IGNORE_HIGH = 0xFFFF, 0  # a channel of an override, up to 8 and above
_LOW_CHANNELS, _OVERRIDES = 8, 18
_REPEAT_S = 0.5  # DO_SET_SERVO without a change
_LONGEST_OVERRIDE_S = 1.0
_SETTLE_S = 1.5  # that long outputs may differ from what was sent
_RECENT_S = 0.6
_PAUSE_S = 0.5  # without our pulses, after which the board has let go of its outputs, as it should
_TOLERANCE_US = 15.0
_REFUSED_S = 2.0
_MUCH_GARBAGE = 400
_SAFETY = mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
_RECEIVER = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER
_REFUSALS = {
    mavlink.MAV_CMD_DO_SET_SERVO: "the board refuses DO_SET_SERVO: set SERVOn_FUNCTION of its channels to 0",
    mavlink.MAV_CMD_DO_SET_RELAY: (
        "the board refuses DO_SET_RELAY: set RELAYn_FUNCTION of its relays to 1, and their pins"
    ),
}
_LEAK = ("leak", b"leak")
_OVERRIDE_TIME, _FAILSAFE_MASK, _FAILSAFE, _FAILSAFE_TIME = (
    "RC_OVERRIDE_TIME",
    "SERVO_RC_FS_MSK",
    "FS_THR_ENABLE",
    "RC_FS_TIMEOUT",
)
_SETTINGS = (
    _OVERRIDE_TIME,
    _FAILSAFE_MASK,
    _FAILSAFE,
    _FAILSAFE_TIME,
)  # of which older boards lack the last: 0.5 s, fixed
_THROTTLE_CHANNEL, _CENTRE_US = 3, 1500


class MavlinkServoBridge:
    """`ActuatorCommand` → pulses of the board's channels. SERVO_OUTPUT_RAW → `ThrusterFeedback`, SYS_STATUS →
    `Battery`, NAMED_VALUE_FLOAT or _INT "leak" (from a script on the board) → `Leak`. RC_CHANNELS → `RcInput` only
    where nothing is overridden: otherwise the board does not report a lost transmitter. ESC_TELEMETRY of thrusters with
    `full_a` → their current in `ThrusterFeedback`.

    Disarmed, and on closing, the throttles go to their trim and azimuth servos stay; before the first arming those are
    at rest. Feedback is what the board puts out, not what propeller and servo make of it. Thruster indices are those of
    the vessel. Remembers the pulses sent and put out, since when they differ, whether the board
    has answered since, and refusals.
    """

    def __init__(self, config: MavlinkServoConfig, vessel: VesselConfig, stream: ByteStream) -> None:
        """Raises ConfigError without its table of channels."""
        if config.mavlink is None:
            raise ConfigError([f"actuator '{config.name}': needs a table [actuator.mavlink] with the channels"])
        self.name = config.name
        self._config, self._mavlink = config, config.mavlink
        names = [thruster.name for thruster in vessel.thrusters]
        self._indices = tuple(names.index(name) for name in config.thrusters)
        driven = [vessel.thrusters[i] for i in self._indices]
        self._outputs = tuple(ThrusterOutput(thruster, pulses=True) for thruster in driven)
        self._channels = self._mavlink.channels
        self._azimuth_channels = self._mavlink.azimuth_channels or (0,) * len(driven)
        self._ours = [
            channel for channel in (*self._channels, *self._azimuth_channels, *self._mavlink.servo_channels) if channel
        ]
        self._overrides = self._mavlink.method == "override"
        # a channel that nobody overrides would turn a servo to its end
        turned = azimuths_of(config, vessel.thrusters, vessel.actuators)
        self._servos = tuple(
            AzimuthServo(vessel.thrusters[i], begin_at_rest=self._overrides) if i in turned else None
            for i in self._indices
        )
        self._metered = [c for c, one in zip(self._channels, driven, strict=True) if one.full_a is not None]
        telemetry = {
            number: _ESC_INTERVAL_S
            for number, first in _ESC_TELEMETRY.items()
            if any(first <= channel < first + 4 for channel in self._metered)
        }
        self._drawn: dict[int, tuple[float, float]] = {}  # time of arrival and current by channel
        self._board = MavlinkBoard(
            stream, self._mavlink.system, _INTERVALS_S | telemetry, _SETTINGS if self._overrides else ()
        )
        self._auxiliary_servos = tuple([servo.name for servo in vessel.servos].index(name) for name in config.servos)
        self._rests_us = tuple(vessel.servos[i].rest_us for i in self._auxiliary_servos)
        self._auxiliary_relays = tuple([relay.name for relay in vessel.relays].index(name) for name in config.relays)
        self._relays = MavlinkRelays(self._mavlink, self._board)
        self._handlers: Mapping[int, Callable[[float, Any], list[Reading]]] = {
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: self._status,
            mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: self._leak,
            mavlink.MAVLINK_MSG_ID_NAMED_VALUE_INT: self._leak,
            mavlink.MAVLINK_MSG_ID_COMMAND_ACK: self._acknowledged,
            **dict.fromkeys(telemetry, self._metering),
        }
        self._sent: dict[int, int] = {}  # pulses by channel
        self._recent: deque[tuple[float, dict[int, int]]] = deque()  # the same, of the last moments
        self._sent_s: dict[int, float] = {}
        self._put_out: dict[int, int] = {}
        self._agreed_s: float | None = None
        self._astray_s: float | None = None  # since when the board is known not to put out what it is sent
        self._refused: tuple[int, float] | None = None  # the command, and when
        self._safety_on = self._receiver_lost = False
        self._receiver_channels = 0
        self._now_s = 0.0

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings of all that has come in since the last call. Of several outputs or receptions the newest counts."""
        newest: dict[int, tuple[float, Any]] = {}
        readings: list[Reading] = []
        for arrival_s, message in self._board.read(now_s):
            number = message.get_msgId()
            if number in _NEWEST_COUNTS and getattr(message, "port", 0) == 0:
                newest[number] = arrival_s, message
            elif number in self._handlers:
                readings += self._handlers[number](arrival_s, message)
        if outputs := newest.get(mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW):
            readings += self._feedback(*outputs)
        if received := newest.get(mavlink.MAVLINK_MSG_ID_RC_CHANNELS):
            readings += self._received(*received)
        return readings

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """Heartbeat and requests as they are due; the pulses, once the board is known."""
        if now_s - self._now_s >= _PAUSE_S:
            self._agreed_s = now_s  # it needs time to take the pulses up again
        self._now_s = now_s
        self._board.attend(now_s)
        if self._board.address is None:
            return
        pulses: dict[int, int] = {}
        for i, index in enumerate(self._indices):
            thruster = command.thrusters[index]
            pulses[self._channels[i]] = round(self._outputs[i].level(thruster, command.armed, now_s))
            servo = self._servos[i]
            pulse_us = None if servo is None else servo.pulse_us(thruster.azimuth_rad if command.armed else None, now_s)
            if pulse_us is not None:
                pulses[self._azimuth_channels[i]] = round(pulse_us)
        servos, relays = self._auxiliary(command)
        self._send(pulses | servos, now_s)
        self._board.send(now_s, *self._relays.orders(relays, command.beacon, now_s))
        self._recent.append((now_s, pulses))
        while now_s - self._recent[0][0] > _RECENT_S:
            self._recent.popleft()

    def health(self, now_s: float) -> DeviceHealth:
        """Ok while the board lives, puts out what it is sent, and lets go of its outputs when the companion is silent;
        else what to do."""
        heard_s = self._board.heard_s
        complaint = self._complaint(now_s)
        counts = f"{self._board.frames} messages"
        age_s = None if heard_s is None else now_s - heard_s
        return DeviceHealth(self.name, not complaint, age_s, f"{complaint} ({counts})" if complaint else counts)

    def fileno(self) -> int | None:
        """See `Actuator`."""
        return self._board.stream.fileno()

    def close(self) -> None:
        """Standstill. Nothing is released: otherwise the last pulses would hold until the board's failsafe, which lets
        go by itself."""
        if self._board.address is not None:
            neutral = {
                channel: round(output.neutral) for channel, output in zip(self._channels, self._outputs, strict=True)
            }
            self._send(neutral, self._now_s)
            self._board.send(
                self._now_s, *self._relays.orders((False,) * len(self._auxiliary_relays), DARK, self._now_s)
            )
        self._board.stream.close()

    # --- out -------------------------------------------------------------------------------------------------------

    def _auxiliary(self, command: ActuatorCommand) -> tuple[dict[int, int], list[bool]]:
        """Pulses of servos by channel (0: none), and the relays; at rest without a demand."""
        servos, relays = command.auxiliary.servos_us, command.auxiliary.relays
        known = len(servos) > max(self._auxiliary_servos, default=-1) and len(relays) > max(
            self._auxiliary_relays, default=-1
        )
        wanted_us = [servos[i] if known else None for i in self._auxiliary_servos]
        pulses = [rest_us or 0.0 if us is None else us for us, rest_us in zip(wanted_us, self._rests_us, strict=True)]
        return dict(zip(self._mavlink.servo_channels, map(round, pulses), strict=True)), [
            known and relays[i] for i in self._auxiliary_relays
        ]

    def _send(self, pulses: dict[int, int], now_s: float) -> None:
        if self._overrides:
            # without a receiver the board takes a silent throttle channel for a radio that has failed
            idle = {} if self._receiver_channels or _THROTTLE_CHANNEL in self._ours else {_THROTTLE_CHANNEL: _CENTRE_US}
            self._board.send(now_s, self._override(idle | pulses))
            self._sent = pulses
            return
        due = [
            c for c, us in pulses.items() if self._sent.get(c) != us or now_s - self._sent_s.get(c, 0.0) >= _REPEAT_S
        ]
        self._board.send(
            now_s, *(self._board.command(mavlink.MAV_CMD_DO_SET_SERVO, channel, pulses[channel]) for channel in due)
        )
        self._sent.update(pulses)
        self._sent_s.update(dict.fromkeys(due, now_s))

    def _override(self, pulses: Mapping[int, int]) -> Any:
        """Pulses by channel; those that are not named stay as they are."""
        assert self._board.address is not None
        values = [
            pulses.get(channel, _IGNORE if channel <= _LOW_CHANNELS else _IGNORE_HIGH)
            for channel in range(1, _OVERRIDES + 1)
        ]
        return mavlink.MAVLink_rc_channels_override_message(*self._board.address, *values)

    # --- in --------------------------------------------------------------------------------------------------------

    def _received(self, arrival_s: float, message: Any) -> list[Reading]:
        """The transmitter's channels, where nothing is overridden."""
        self._receiver_channels = message.chancount
        if self._overrides or message.chancount == 0:
            return []
        pulses = [getattr(message, f"chan{i}_raw") for i in range(1, _LOW_CHANNELS + 1)]
        sticks = channels([0 if us == _IGNORE else us for us in pulses])
        return [RcInput(arrival_s, self.name, sticks, self._receiver_lost)]

    def _leak(self, arrival_s: float, message: Any) -> list[Reading]:
        return [Leak(arrival_s, self.name, message.value > 0)] if message.name in _LEAK else []

    def _acknowledged(self, arrival_s: float, message: Any) -> list[Reading]:
        """A refusal does not name its channel, so that an acceptance of another one does not end it."""
        if message.command in _REFUSALS and message.result != mavlink.MAV_RESULT_ACCEPTED:
            self._refused = message.command, arrival_s
        return []

    def _feedback(self, arrival_s: float, message: Any) -> list[Reading]:
        self._put_out = {channel: getattr(message, f"servo{channel}_raw") for channel in range(1, 17)}
        self._compare(arrival_s)
        readings: list[Reading] = []
        for i, index in enumerate(self._indices):
            pulse_us, servo = self._put_out[self._channels[i]], self._servos[i]
            throttle = self._outputs[i].throttle(pulse_us) if pulse_us else 0.0  # no pulses: the drive stands
            turned_us = self._put_out.get(self._azimuth_channels[i], 0)
            azimuth_rad = servo.azimuth_rad(turned_us) if servo is not None and turned_us else None
            drawn_s, drawn_a = self._drawn.get(self._channels[i], (-math.inf, None))
            current_a = drawn_a if arrival_s - drawn_s <= _ESC_STALE_S else None
            readings.append(ThrusterFeedback(arrival_s, self.name, index, throttle, azimuth_rad, current_a=current_a))
        return readings

    def _metering(self, arrival_s: float, message: Any) -> list[Reading]:
        """Currents, in 0.01 A, by channel; a motor controller that has sent nothing yet counts no packets."""
        first = _ESC_TELEMETRY[message.get_msgId()]
        for i, (drawn, count) in enumerate(zip(message.current, message.count, strict=True)):
            if count and first + i in self._metered:
                self._drawn[first + i] = arrival_s, drawn / 100.0
        return []

    def _compare(self, arrival_s: float) -> None:
        """Outputs against pulses. At standstill a deaf board agrees too: it must have answered since."""
        if self._agreed_s is None or self._astray() is None:
            self._agreed_s = arrival_s
            answers = (mavlink.MAVLINK_MSG_ID_PARAM_VALUE, mavlink.MAVLINK_MSG_ID_COMMAND_ACK)
            answered_s = max(self._board.came_s(number) or -math.inf for number in answers)
            if self._astray_s is not None and answered_s > self._astray_s:
                self._astray_s = None
        elif arrival_s - self._agreed_s > _SETTLE_S and arrival_s - self._now_s < _PAUSE_S:
            self._astray_s = arrival_s

    def _astray(self) -> int | None:
        """A channel whose output is far from all that it was sent lately."""
        for channel in self._sent:
            lately = [pulses[channel] for _, pulses in self._recent if channel in pulses]
            if (
                lately
                and not min(lately) - _TOLERANCE_US <= self._put_out.get(channel, 0) <= max(lately) + _TOLERANCE_US
            ):
                return channel
        return None

    def _status(self, arrival_s: float, message: Any) -> list[Reading]:
        present, enabled = message.onboard_control_sensors_present, message.onboard_control_sensors_enabled
        self._safety_on = bool(present & _SAFETY) and not enabled & _SAFETY
        self._receiver_lost = bool(present & _RECEIVER) and not message.onboard_control_sensors_health & _RECEIVER
        if message.voltage_battery in (0, 0xFFFF):
            return []
        current_a = None if message.current_battery < 0 else message.current_battery / 100.0
        remaining = None if message.battery_remaining < 0 else min(1.0, message.battery_remaining / 100.0)
        return [Battery(arrival_s, self.name, message.voltage_battery / 1000.0, current_a, remaining)]

    # --- what is wrong, and what to do -----------------------------------------------------------------------------

    def _complaint(self, now_s: float) -> str:
        fault, board = self._board.stream.fault(), self._board
        if fault is not None:
            return fault
        silent = board.heard_s is None or board.beat_s is None or now_s - board.heard_s > self._config.timeout_s
        if silent and board.garbage >= _MUCH_GARBAGE:
            return (
                f"bytes arrive but no MAVLink: wrong baud rate in '{self._config.port}', "
                "or SERIALn_PROTOCOL of the board is not 2"
            )
        if board.heard_s is None or board.beat_s is None:
            return "no autopilot's heartbeat yet: check the board's power, cable and SERIALn_PROTOCOL"
        if now_s - board.heard_s > self._config.timeout_s or now_s - board.beat_s > BEAT_LOST_S:
            silent_s = now_s - min(board.heard_s, board.beat_s)
            return f"silent for {silent_s:.1f} s: check the board's power and cable; {self._left_alone()}"
        came_s = board.came_s(mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW)
        if came_s is None or now_s - came_s > self._config.timeout_s:
            return "the board does not report its outputs: it should answer SET_MESSAGE_INTERVAL for SERVO_OUTPUT_RAW"
        return self._settings_complaint() or self._output_complaint(now_s)

    def _left_alone(self) -> str:
        return "it lets go of its outputs by itself" if self._overrides else "IT HOLDS ITS LAST PULSES"

    def _settings_complaint(self) -> str:
        """Settings with which the board would not let go of its outputs."""
        parameters = self._board.parameters
        if not self._overrides or self._board.autopilot != mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
            return ""
        if missing := [name for name in _SETTINGS[:3] if name not in parameters]:
            return f"the board has not sent its {' and '.join(missing)} yet: its failsafe is unknown"
        if parameters[_FAILSAFE] == 0.0:
            return (
                "the board's radio failsafe is off, so it would hold its last pulses when the companion is silent: "
                f"set {_FAILSAFE} to 1"
            )
        if parameters.get(_FAILSAFE_TIME, 0.5) > _LONGEST_OVERRIDE_S:
            late_s = parameters[_FAILSAFE_TIME]
            return f"the board would notice the companion's silence after {late_s:g} s: set {_FAILSAFE_TIME} to 0.5"
        if 0 < self._receiver_channels < max(self._channels):
            lacks = f"the RC receiver has {self._receiver_channels} channels and lacks {max(self._channels)}"
            return (
                f"{lacks}, which would be full astern when the companion is silent: "
                "unplug it, use one with 16, or other channels"
            )
        held_s = parameters[_OVERRIDE_TIME]
        if not 0.0 < held_s <= _LONGEST_OVERRIDE_S:
            how = f"for {held_s:g} s" if held_s > 0.0 else "for ever" if held_s < 0.0 else "not at all"
            return f"the board holds an override {how}: set its {_OVERRIDE_TIME} to 0.5"
        mask = round(parameters[_FAILSAFE_MASK])
        bare = [channel for channel in self._channels if not mask >> channel - 1 & 1]
        if bare:
            wanted = mask | sum(1 << channel - 1 for channel in self._channels)
            return (
                f"channel {bare[0]} would hold its last pulse when the companion is silent: "
                f"set {_FAILSAFE_MASK} to {wanted}"
            )
        return ""

    def _output_complaint(self, now_s: float) -> str:
        if self._safety_on:
            return "the board's safety switch is on: its outputs are dead; press it, or set BRD_SAFETY_DEFLT to 0"
        if self._refused is not None and now_s - self._refused[1] < _REFUSED_S:
            return _REFUSALS[self._refused[0]]
        if self._astray_s is None:
            return ""
        channel = self._astray()
        if channel is None:
            return "the board does not answer and put out other pulses than it was sent: check its RX wire"
        remedy = f"SERVO{channel}_FUNCTION should be 0"
        if self._overrides:
            remedy = (
                f"SERVO{channel}_FUNCTION should be {139 + channel}, MAV_GCS_SYSID {self._mavlink.system}, "
                f"RC{channel}_MIN … as SERVO{channel}_MIN …, RC{channel}_DZ 0"
            )
        difference = f"output {channel} is at {self._put_out.get(channel, 0)} µs, not {self._sent[channel]}"
        return f"{difference}: {remedy}, or the board does not receive: check its RX wire"
