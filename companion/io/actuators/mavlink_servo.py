"""Bridge to an autopilot board (a Pixhawk with ArduPilot) whose servo outputs drive the thrusters, by RC_CHANNELS_OVERRIDE or DO_SET_SERVO.

What the board must be set to, override: SERVOn_FUNCTION = 139 + channel (RCINnScaled), so that SERVO_RC_FS_MSK can send the outputs to SERVOn_TRIM
when the companion falls silent; RC_OVERRIDE_TIME 0.5 (the default holds an override for 3 s); RCn_MIN, _TRIM, _MAX the same as SERVOn_…;
MAV_GCS_SYSID (SYSID_MYGCS) = `system`. Channels above 8 leave a transmitter its own. When released the outputs follow the RC receiver, if there is one.
DO_SET_SERVO: SERVOn_FUNCTION = 0. The board then holds its last pulses for ever, whatever becomes of the companion.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

from companion.config import ActuatorConfig, ConfigError, VesselConfig, azimuths_of
from companion.core.ports import ByteStream
from companion.core.types import ActuatorCommand, Battery, DeviceHealth, RcInput, Reading, ThrusterFeedback
from companion.io.actuators.calibration import AzimuthServo, ThrusterOutput
from companion.io.actuators.mavlink_board import BEAT_LOST_S, MavlinkBoard
from companion.io.actuators.receiver import channels
from companion.io.mavlink import messages as mavlink

_INTERVALS_S = {
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 0.05,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS: 0.1,
}
_IGNORE, _RELEASE = 0xFFFF, 0
_IGNORE_HIGH, _RELEASE_HIGH = 0, 0xFFFE  # of channels above 8
_OVERRIDES = 18
_TRANSMITTERS = 8  # channels that a transmitter keeps
_REPEAT_S = 0.5  # DO_SET_SERVO without a change
_LONGEST_OVERRIDE_S = 1.0
_SETTLE_S = 1.5  # that long outputs may differ from what was sent
_RECENT_S = 0.6
_TOLERANCE_US = 15.0
_REFUSED_S = 2.0
_SILENT_BYTES = 400
_SAFETY = mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
_RECEIVER = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER
_OVERRIDE_TIME, _FAILSAFE_MASK = "RC_OVERRIDE_TIME", "SERVO_RC_FS_MSK"


class MavlinkServoBridge:
    """`ActuatorCommand` → pulses of the board's channels; SERVO_OUTPUT_RAW → `ThrusterFeedback`, SYS_STATUS → `Battery`, RC_CHANNELS → `RcInput`
    where none of the first 8 channels is overridden.

    Disarmed the throttles stand at their trim, which overrides a transmitter, and azimuth servos stay. On closing: trim, then release. What comes
    back is what the board puts out, not what propeller and servo make of it. Thruster indices are those of the vessel.
    Remembers the pulses sent and put out, since when they differ, and refusals.
    """

    def __init__(self, config: ActuatorConfig, vessel: VesselConfig, stream: ByteStream) -> None:
        """Raises ConfigError without its table of channels."""
        if config.mavlink is None:
            raise ConfigError([f"actuator '{config.name}': needs a table [actuator.mavlink] with the channels"])
        self.name = config.name
        self._config, self._mavlink = config, config.mavlink
        names = [thruster.name for thruster in vessel.thrusters]
        self._indices = tuple(names.index(name) for name in config.thrusters)
        driven = [vessel.thrusters[i] for i in self._indices]
        self._outputs = tuple(ThrusterOutput(thruster, pulses=True) for thruster in driven)
        turned = azimuths_of(config, vessel.thrusters, vessel.actuators)
        self._servos = tuple(AzimuthServo(vessel.thrusters[i]) if i in turned else None for i in self._indices)
        self._channels = self._mavlink.channels
        self._azimuth_channels = self._mavlink.azimuth_channels or (0,) * len(driven)
        self._overrides = self._mavlink.method == "override"
        self._board = MavlinkBoard(stream, self._mavlink.system, _INTERVALS_S, (_OVERRIDE_TIME, _FAILSAFE_MASK) if self._overrides else ())
        self._hears_transmitter = not self._overrides or min(self._channels, default=99) > _TRANSMITTERS
        self._sent: dict[int, int] = {}  # pulses by channel
        self._recent: deque[tuple[float, dict[int, int]]] = deque()  # the same, of the last moments
        self._sent_s: dict[int, float] = {}
        self._put_out: dict[int, int] = {}
        self._agreed_s: float | None = None
        self._refused_s: float | None = None
        self._safety_on = self._receiver_lost = False
        self._now_s = 0.0

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings of all that has come in since the last call; of several outputs and receptions the newest."""
        outputs: tuple[float, Any] | None = None
        received: tuple[float, Any] | None = None
        readings: list[Reading] = []
        for arrival_s, message in self._board.read(now_s):
            match message.get_msgId():
                case mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW if message.port == 0:
                    outputs = arrival_s, message
                case mavlink.MAVLINK_MSG_ID_RC_CHANNELS:
                    received = arrival_s, message
                case mavlink.MAVLINK_MSG_ID_SYS_STATUS:
                    readings += self._status(arrival_s, message)
                case mavlink.MAVLINK_MSG_ID_COMMAND_ACK if message.command == mavlink.MAV_CMD_DO_SET_SERVO:
                    if message.result != mavlink.MAV_RESULT_ACCEPTED:  # of which channel is not said, so others' consent takes nothing back
                        self._refused_s = arrival_s
        if outputs is not None:
            readings += self._feedback(*outputs)
        if received is not None and self._hears_transmitter and received[1].chancount > 0:
            pulses = [getattr(received[1], f"chan{i}_raw") for i in range(1, _TRANSMITTERS + 1)]
            readings.append(RcInput(received[0], self.name, channels([0 if us == _IGNORE else us for us in pulses]), self._receiver_lost))
        return readings

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """Heartbeat and requests as they are due; the pulses, once the board is known."""
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
        self._send(pulses, now_s)
        self._recent.append((now_s, pulses))
        while now_s - self._recent[0][0] > _RECENT_S:
            self._recent.popleft()

    def health(self, now_s: float) -> DeviceHealth:
        """Ok while the board lives, puts out what it is sent, and is set so that it lets go when the companion falls silent; else what to do."""
        heard_s = self._board.heard_s
        complaint = self._complaint(now_s)
        counts = f"{self._board.frames} messages"
        age_s = None if heard_s is None else now_s - heard_s
        return DeviceHealth(self.name, not complaint, age_s, f"{complaint} ({counts})" if complaint else counts)

    def fileno(self) -> int | None:
        return self._board.stream.fileno()

    def close(self) -> None:
        """Standstill, and the channels back to whoever else has them."""
        if self._board.address is not None:
            neutral = {channel: round(output.neutral) for channel, output in zip(self._channels, self._outputs, strict=True)}
            self._send(neutral, self._now_s)
            if self._overrides:
                self._board.send(self._now_s, self._override({channel: None for channel in (*self._channels, *self._azimuth_channels) if channel}))
        self._board.stream.close()

    # --- out -------------------------------------------------------------------------------------------------------

    def _send(self, pulses: dict[int, int], now_s: float) -> None:
        if self._overrides:
            self._board.send(now_s, self._override(dict(pulses)))
            self._sent = pulses
            return
        due = [c for c, us in pulses.items() if self._sent.get(c) != us or now_s - self._sent_s.get(c, 0.0) >= _REPEAT_S]
        self._board.send(now_s, *(self._board.command(mavlink.MAV_CMD_DO_SET_SERVO, channel, pulses[channel]) for channel in due))
        self._sent.update(pulses)
        self._sent_s.update(dict.fromkeys(due, now_s))

    def _override(self, pulses: dict[int, int | None]) -> Any:
        """Pulses by channel, None to release it; the channels that are not named stay as they are."""
        assert self._board.address is not None
        values = []
        for channel in range(1, _OVERRIDES + 1):
            low = channel <= _TRANSMITTERS
            pulse_us = pulses.get(channel, _IGNORE if low else _IGNORE_HIGH)
            values.append((_RELEASE if low else _RELEASE_HIGH) if pulse_us is None else pulse_us)
        return mavlink.MAVLink_rc_channels_override_message(*self._board.address, *values)

    # --- in --------------------------------------------------------------------------------------------------------

    def _feedback(self, arrival_s: float, message: Any) -> list[Reading]:
        self._put_out = {channel: getattr(message, f"servo{channel}_raw") for channel in range(1, 17)}
        if self._agreed_s is None or self._astray() is None:
            self._agreed_s = arrival_s
        readings: list[Reading] = []
        for i, index in enumerate(self._indices):
            pulse_us, servo = self._put_out[self._channels[i]], self._servos[i]
            throttle = self._outputs[i].throttle(pulse_us) if pulse_us else 0.0  # no pulses: the drive stands
            turned_us = self._put_out.get(self._azimuth_channels[i], 0)
            azimuth_rad = servo.azimuth_rad(turned_us) if servo is not None and turned_us else None
            readings.append(ThrusterFeedback(arrival_s, self.name, index, throttle, azimuth_rad))
        return readings

    def _astray(self) -> int | None:
        """A channel that does not put out anything near to what it was sent lately."""
        for channel in self._sent:
            lately = [pulses[channel] for _, pulses in self._recent if channel in pulses]
            if lately and not min(lately) - _TOLERANCE_US <= self._put_out.get(channel, 0) <= max(lately) + _TOLERANCE_US:
                return channel
        return None

    def _status(self, arrival_s: float, message: Any) -> list[Reading]:
        present, enabled = message.onboard_control_sensors_present, message.onboard_control_sensors_enabled
        self._safety_on = bool(present & _SAFETY) and not enabled & _SAFETY
        self._receiver_lost = bool(present & _RECEIVER) and not message.onboard_control_sensors_health & _RECEIVER
        if message.voltage_battery in (0, 0xFFFF):
            return []
        current_a = None if message.current_battery < 0 else message.current_battery / 100.0
        remaining = None if message.battery_remaining < 0 else message.battery_remaining / 100.0
        return [Battery(arrival_s, self.name, message.voltage_battery / 1000.0, current_a, remaining)]

    # --- what is wrong, and what to do -----------------------------------------------------------------------------

    def _complaint(self, now_s: float) -> str:
        fault, board = self._board.stream.fault(), self._board
        if fault is not None:
            return fault
        if board.bytes_since_frame >= _SILENT_BYTES:
            return f"bytes arrive but no MAVLink: wrong baud rate in '{self._config.port}', or SERIALn_PROTOCOL of the board is not 2"
        if board.heard_s is None or board.beat_s is None:
            return "no autopilot's heartbeat yet: check the board's power, cable and SERIALn_PROTOCOL"
        if now_s - board.heard_s > self._config.timeout_s or now_s - board.beat_s > BEAT_LOST_S:
            return f"silent for {now_s - min(board.heard_s, board.beat_s):.1f} s: check the board's power and cable; {self._left_alone()}"
        came_s = board.came_s(mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW)
        if came_s is None or now_s - came_s > self._config.timeout_s:
            return "the board does not say what it puts out: it should answer SET_MESSAGE_INTERVAL for SERVO_OUTPUT_RAW"
        return self._settings_complaint() or self._output_complaint(now_s)

    def _left_alone(self) -> str:
        return "it lets go of its outputs by itself" if self._overrides else "IT HOLDS ITS LAST PULSES"

    def _settings_complaint(self) -> str:
        """Of a board that would not let go."""
        parameters = self._board.parameters
        if not self._overrides or self._board.autopilot != mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
            return ""
        if _OVERRIDE_TIME not in parameters or _FAILSAFE_MASK not in parameters:
            return f"the board has not said its {_OVERRIDE_TIME} and {_FAILSAFE_MASK} yet: without them nobody knows whether it would let go"
        held_s = parameters[_OVERRIDE_TIME]
        if not 0.0 < held_s <= _LONGEST_OVERRIDE_S:
            how = f"for {held_s:g} s" if held_s > 0.0 else "for ever" if held_s < 0.0 else "not at all"
            return f"the board holds an override {how}: set its {_OVERRIDE_TIME} to 0.5"
        mask = round(parameters[_FAILSAFE_MASK])
        bare = [channel for channel in self._channels if not mask >> channel - 1 & 1]
        if bare:
            wanted = mask | sum(1 << channel - 1 for channel in self._channels)
            return f"channel {bare[0]} would hold its last pulse when the companion falls silent: set {_FAILSAFE_MASK} to {wanted}"
        return ""

    def _output_complaint(self, now_s: float) -> str:
        if self._safety_on:
            return "the board's safety switch is on: its outputs are dead; press it, or set BRD_SAFETY_DEFLT to 0"
        if self._refused_s is not None and now_s - self._refused_s < _REFUSED_S:
            return "the board refuses DO_SET_SERVO: set SERVOn_FUNCTION of its channels to 0"
        came_s = self._board.came_s(mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW)
        channel = self._astray()
        if channel is None or self._agreed_s is None or came_s is None or came_s - self._agreed_s <= _SETTLE_S:
            return ""
        remedy = f"SERVO{channel}_FUNCTION should be {139 + channel}, MAV_GCS_SYSID {self._mavlink.system}, RC{channel}_MIN … as SERVO{channel}_MIN …"
        if not self._overrides:
            remedy = f"SERVO{channel}_FUNCTION should be 0"
        return f"output {channel} is at {self._put_out.get(channel, 0)} µs, not {self._sent[channel]}: {remedy}"
