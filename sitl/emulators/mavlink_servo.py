"""A board with ArduPilot whose servo outputs drive thrusters: overrides, DO_SET_SERVO, and what it does in silence.

From the sources of ArduPilot Rover 4.6 (RC_Channel, SRV_Channel, radio.cpp, AP_ServoRelayEvents):

Overrides are accepted from MAV_GCS_SYSID alone and last RC_OVERRIDE_TIME. After that a channel has the RC receiver's
value (0 for a channel it lacks), or keeps its own if there never was a receiver. The radio fails when RCMAP_THROTTLE's
channel is below FS_THR_VALUE, or when neither receiver nor override has come for RC_FS_TIMEOUT.

Outputs of function RCINnScaled (139 + n) follow RC channel n. While the radio fails they go to SERVOn_TRIM where
SERVO_RC_FS_MSK says so, else they hold their last pulse. DO_SET_SERVO sets outputs of function 0 for ever; other
outputs refuse it. DO_SET_RELAY lasts for ever too.

Motor controllers with telemetry (those of thrusters whose `full_a` is known) are reported in ESC_TELEMETRY_1_TO_4 and
so on, at the place of their servo channel (AP_ESC_Telem).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.actuators.mavlink_servo import MavlinkServoConfig
from sitl.battery import LOW_REMAINING, LOW_VOLTAGE_V, BatteryModel
from sitl.drives import DriveModel
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import ThrusterModel

_RATE_HZ = 20.0
_CHANNELS = 16
_RELAYS = 6
_CENTRE_US = 1500.0
_LOWEST_US, _HIGHEST_US = 1000.0, 2000.0
_THROTTLE, _THROTTLE_LOST_US = 3, 910.0
_RC_CENTRED = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000, *(1500,) * 8)
_RC_SAFE = (1500, 1500, 1500, 1500, 2000, 1000, 1000, 1000, *(1500,) * 8)
_SCALED = 139
_OUTPUTS = tuple([(channel, f"SERVO{channel}_FUNCTION", f"SERVO{channel}_TRIM") for channel in range(1, _CHANNELS + 1)])
_ESC_TELEMETRY = {11030: "1_to_4", 11031: "5_to_8", 11032: "9_to_12", 11040: "13_to_16"}
"""Numbers of the messages, and the channels of each."""
_OUTPUTS_BIT, _RECEIVER_BIT = mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS, mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER


class MavlinkServoEmulator:
    """The board. Its `parameters` are set as the bridge's documentation asks. `safety_on`: its safety switch stops all
    pulses. `esc_telemetry`: whether its motor controllers report.

    A stopped board gives no pulses, and the drives stand.
    """

    def __init__(
        self,
        config: MavlinkServoConfig,
        port: MemoryDevice,
        thrusters: Sequence[ThrusterModel],
        battery: BatteryModel,
        faults: Faults,
    ) -> None:
        assert config.mavlink is not None  # checked with the configuration
        self.name = config.name
        self.rate_hz = _RATE_HZ
        self.rc_us: Sequence[int] | None = _RC_CENTRED if faults.planned("rc_") else None
        self.safety_on = False
        self._port, self._thrusters, self._battery, self._faults = port, tuple(thrusters), battery, faults
        self._drives = tuple(DriveModel(thruster.config, pulses=True) for thruster in thrusters)
        self._throttle_channels = config.mavlink.channels
        self.esc_telemetry = any(thruster.config.full_a is not None for thruster in thrusters)
        self._telemetry_count = 0
        self._relay_numbers, self._servo_channels = config.mavlink.relays, config.mavlink.servo_channels
        self._azimuth_channels = config.mavlink.azimuth_channels or (0,) * len(thrusters)
        self._link = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._link.robust_parsing = True
        overridden = config.mavlink.method == "override"
        self.parameters: dict[str, float] = {
            "RC_OVERRIDE_TIME": 0.5,
            "RC_FS_TIMEOUT": 0.5,
            "FS_THR_ENABLE": 1.0,
            "SERVO_RC_FS_MSK": 65535.0,
            "MAV_GCS_SYSID": float(config.mavlink.system),
        }
        for channel in range(1, _CHANNELS + 1):
            self.parameters[f"SERVO{channel}_FUNCTION"] = float(_SCALED + channel) if overridden else 0.0
            self.parameters[f"SERVO{channel}_TRIM"] = _CENTRE_US
        for i, drive in enumerate(self._drives):
            self.parameters[f"SERVO{self._throttle_channels[i]}_TRIM"] = drive.level(0.0)
            if self._azimuth_channels[i]:
                self.parameters[f"SERVO{self._azimuth_channels[i]}_TRIM"] = drive.servo_pulse_us(
                    thrusters[i].config.azimuth_rad
                )
        self.pulses_us = [0.0] * (_CHANNELS + 1)  # by channel, from 1
        self.relays = [False] * _RELAYS
        self._overrides: dict[int, tuple[float, float]] = {}  # pulse and time by channel
        self._radio_us = [0.0] * (_CHANNELS + 1)  # RC channels as the board sees them, from 1
        self._frame: Sequence[int] | None = None  # last one from an RC receiver
        self._radio_s = 0.0  # of the last frame or override
        self._intervals_s: dict[int, float] = {}
        self._due_s: dict[int, float] = {}
        self._t_s = 0.0
        self._beat_s = 0.0

    def relay(self, number: int) -> bool:
        """Whether the board's relay is on, by its place in the file's row."""
        return self.relays[self._relay_numbers[number]]

    def servo_us(self, number: int) -> float | None:
        """Pulse of the board's servo, by its place in the file's row."""
        return self.pulses_us[self._servo_channels[number]] or None

    def listen(self, t_s: float) -> None:
        """Handle packets, then set the outputs."""
        self._t_s = t_s
        for _, data in self._port.receive(t_s):
            if self._faults.active.isdisjoint(("mcu_silent", "mcu_deaf")):
                for message in self._link.parse_buffer(data) or ():
                    self._take(message, t_s)
        self._put_out()

    def speak(self, t_s: float) -> None:
        """Send the heartbeat and the telemetry that is due."""
        if "mcu_silent" in self._faults.active:
            return
        if t_s >= self._beat_s:
            self._beat_s = t_s + 1.0
            kind, autopilot = mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
            self._say(
                mavlink.MAVLink_heartbeat_message(
                    kind, autopilot, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, 0, mavlink.MAV_STATE_ACTIVE, 3
                )
            )
            wet = float("leak" in self._faults.active)
            self._say(
                mavlink.MAVLink_named_value_float_message(round(t_s * 1e3), b"leak", wet)
            )  # from a script on the board
        for number, interval_s in self._intervals_s.items():
            if t_s >= self._due_s[number] - 1e-9:
                self._due_s[number] = t_s + interval_s
                if number not in _ESC_TELEMETRY or self.esc_telemetry:
                    self._say(self._telemetry(number))

    # --- in --------------------------------------------------------------------------------------------------------

    def _take(self, message: Any, t_s: float) -> None:
        kind = message.get_type()
        if kind == "RC_CHANNELS_OVERRIDE" and message.get_srcSystem() == self.parameters["MAV_GCS_SYSID"]:
            self._override(message, t_s)
        elif kind == "COMMAND_LONG":
            self._say(mavlink.MAVLink_command_ack_message(message.command, self._obey(message, t_s)))
        elif kind == "PARAM_REQUEST_READ" and message.param_id in self.parameters:
            real = mavlink.MAV_PARAM_TYPE_REAL32
            name, count = message.param_id, len(self.parameters)
            self._say(mavlink.MAVLink_param_value_message(name.encode(), self.parameters[name], real, count, 0xFFFF))

    def _override(self, message: Any, t_s: float) -> None:
        for channel in range(1, _CHANNELS + 1):
            pulse_us = getattr(message, f"chan{channel}_raw")
            if pulse_us == 0xFFFF or (pulse_us == 0 and channel > 8):
                continue
            self._radio_s = t_s
            if pulse_us in (0, 0xFFFE):
                self._overrides.pop(channel, None)
            else:
                self._overrides[channel] = float(pulse_us), t_s

    def _obey(self, message: Any, t_s: float) -> int:
        if message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            number = round(message.param1)
            if number not in (
                mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW,
                mavlink.MAVLINK_MSG_ID_SYS_STATUS,
                mavlink.MAVLINK_MSG_ID_RC_CHANNELS,
                *(_ESC_TELEMETRY if self.esc_telemetry else ()),
            ):
                return int(mavlink.MAV_RESULT_FAILED)
            self._intervals_s[number] = max(message.param2 / 1e6, 1.0 / _RATE_HZ)
            self._due_s[number] = t_s
            return int(mavlink.MAV_RESULT_ACCEPTED)
        if message.command == mavlink.MAV_CMD_DO_SET_RELAY:
            number = round(message.param1)
            if not 0 <= number < _RELAYS:
                return int(mavlink.MAV_RESULT_FAILED)
            self.relays[number] = message.param2 == 1.0
            return int(mavlink.MAV_RESULT_ACCEPTED)
        if message.command != mavlink.MAV_CMD_DO_SET_SERVO:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        channel = round(message.param1)
        if not 1 <= channel <= _CHANNELS or self.parameters[f"SERVO{channel}_FUNCTION"] != 0.0:
            return int(mavlink.MAV_RESULT_FAILED)
        self.pulses_us[channel] = message.param2
        return int(mavlink.MAV_RESULT_ACCEPTED)

    # --- out -------------------------------------------------------------------------------------------------------

    @property
    def _received_us(self) -> Sequence[int] | None:
        """Pulses from the RC receiver; None while there is none, or it has no signal."""
        active = self._faults.active
        if self.rc_us is None or "rc_lost" in active:
            return None
        return _RC_SAFE if "rc_safe" in active else self.rc_us

    def _listen_to_radio(self) -> None:
        received, longest_s = self._received_us, self.parameters["RC_OVERRIDE_TIME"]
        if received is not None:
            self._frame, self._radio_s = received, self._t_s
        if self._frame is not None:
            for channel in range(1, _CHANNELS + 1):
                self._radio_us[channel] = float(self._frame[channel - 1]) if channel <= len(self._frame) else 0.0
        for channel, (pulse_us, taken_s) in self._overrides.items():
            if longest_s < 0.0 or self._t_s - taken_s < longest_s - 1e-9:
                self._radio_us[channel] = pulse_us

    @property
    def _radio_failed(self) -> bool:
        if self.parameters["FS_THR_ENABLE"] == 0.0:
            return False
        return (
            self._radio_us[_THROTTLE] < _THROTTLE_LOST_US
            or self._t_s - self._radio_s >= self.parameters["RC_FS_TIMEOUT"] - 1e-9
        )

    def _put_out(self) -> None:
        self._listen_to_radio()
        failed, parameters, pulses_us, radio_us = self._radio_failed, self.parameters, self.pulses_us, self._radio_us
        for channel, function, trim in _OUTPUTS:
            if parameters[function] != _SCALED + channel:
                continue
            if not failed:
                pulse_us = radio_us[channel]
                pulses_us[channel] = min(_HIGHEST_US, pulse_us) if pulse_us > _LOWEST_US else _LOWEST_US
            elif int(parameters["SERVO_RC_FS_MSK"]) >> channel - 1 & 1:
                pulses_us[channel] = parameters[trim]
        dead = self.safety_on or "mcu_silent" in self._faults.active
        for i, (thruster, drive) in enumerate(zip(self._thrusters, self._drives, strict=True)):
            pulse_us, turned_us = pulses_us[self._throttle_channels[i]], pulses_us[self._azimuth_channels[i]]
            azimuth_rad = drive.servo_azimuth_rad(turned_us) if turned_us and not dead and thruster.steerable else None
            thruster.demand(0.0 if dead or not pulse_us else drive.throttle(pulse_us), azimuth_rad)

    def _esc_telemetry(self, number: int) -> Any:
        """Of four motor controllers; zeros where there is none."""
        from pymavlink.dialects.v20 import ardupilotmega  # which takes 80 ms and 7 MB to import: few boards need it

        channels = _ESC_TELEMETRY[number]
        kind = getattr(ardupilotmega, f"MAVLink_esc_telemetry_{channels}_message")
        first = int(channels.partition("_")[0])
        self._telemetry_count = (self._telemetry_count + 1) & 0xFFFF
        volts, amps, counts = [0] * 4, [0] * 4, [0] * 4
        for channel, thruster in zip(self._throttle_channels, self._thrusters, strict=True):
            full_a = thruster.config.full_a
            if full_a is not None and first <= channel < first + 4:
                volts[channel - first] = round(self._battery.voltage_v * 100.0)
                amps[channel - first] = round(thruster.current_a(full_a) * 100.0)
                counts[channel - first] = self._telemetry_count
        return kind([25] * 4, volts, amps, [0] * 4, [0] * 4, counts)

    def _telemetry(self, number: int) -> Any:
        if number in _ESC_TELEMETRY:
            return self._esc_telemetry(number)
        if number == mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW:
            shown = [0 if self.safety_on else round(pulse_us) for pulse_us in self.pulses_us[1:]]
            return mavlink.MAVLink_servo_output_raw_message(round(self._t_s * 1e6), 0, *shown)
        if number == mavlink.MAVLINK_MSG_ID_RC_CHANNELS:
            count = 0 if self.rc_us is None else len(self.rc_us)
            pulses = [round(pulse_us) for pulse_us in self._radio_us[1:]]
            return mavlink.MAVLink_rc_channels_message(round(self._t_s * 1e3), count, *pulses, 0, 0, 255)
        low, battery = "battery_low" in self._faults.active, self._battery
        voltage_v, remaining = (LOW_VOLTAGE_V, LOW_REMAINING) if low else (battery.voltage_v, battery.remaining)
        present = _OUTPUTS_BIT | (0 if self.rc_us is None else _RECEIVER_BIT)
        enabled = 0 if self.safety_on else _OUTPUTS_BIT
        health = 0 if self._radio_failed else _RECEIVER_BIT
        return mavlink.MAVLink_sys_status_message(
            present,
            enabled,
            health,
            100,
            round(voltage_v * 1000),
            round(battery.current_a * 100),
            round(remaining * 100),
            0,
            0,
            0,
            0,
            0,
            0,
        )

    def _say(self, message: Any) -> None:
        self._port.send(message.pack(self._link), self._t_s)
