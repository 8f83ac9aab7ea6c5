"""Bridge to thrusters on an NMEA 2000 network that speak its thruster messages (128006, 128008), as trolling motors and
azimuth thrusters.

The ÅBOAT's thesis drove its two motors over NMEA 2000, with turn-angle sensors on the same network, and prints no PGNs.
The messages of makers' own remote controls are not public. These are the standard's (NMEA's amendment of 2019-06-13 on
128006, 128007 and 128008; layouts by the CANboat database). Who sends what, and the fields that a command always has,
follow the THRMOD firmware of Paul Reeve.

To each motor, at the address from which its 128006 comes, once a control step (the standard asks for one in 250 ms):

    126208  command group function, priority 2, fast packet: "set these fields of your 128006"
              2  identifier        the motor's `instance`
              3  direction control 0 off (disarmed), 1 ready (no push), 2 to port, 3 to starboard
              4  power enabled     1 armed, 0 not
              6  speed control     1 %, 0…100
              8  command timeout   5 ms: 0.5 s, after which a motor that hears no more stops by itself
              9  azimuth control   0.1 mrad, 0…2π; not to a motor that does not turn, nor disarmed, when it stays

A tunnel thruster pushes to starboard with its azimuth at 90°: "to starboard" is along the azimuth, "to port" against
it. So a reversed motor gets "to port". Speed is in whole percent: the push comes in steps of up to 2 % of full.

    59904   request for 128006, to all, once a second until all motors are known
    60928, 126993, 126996, 59392   see `nmea2000_node`

Heard: 128006 of the motor (what it does), 127245 of a turn-angle sensor (its angle, which counts before the motor's
own), 128008 (what made it stop), 126208 acknowledgement (what it refuses), 127508 and 127506 of battery 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from companion.config.actuators.nmea2000 import MotorConfig, Nmea2000Config
from companion.config.devices import ThrusterConfig
from companion.config.driving import azimuths_of
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.actuation import ActuatorCommand, ThrusterCommand, ThrusterFeedback
from companion.core.angles import TWO_PI, wrap_pi
from companion.core.can_frame import unpack
from companion.core.ports import ByteStream
from companion.core.readings import Battery, Reading
from companion.core.tick import DeviceHealth
from companion.io.actuators.calibration import ThrusterOutput
from companion.io.actuators.nmea2000_node import CLAIM, REQUEST, Node, header

CONTROL, RUDDER, MOTOR, COMMAND, BATTERY, CHARGE = 128006, 127245, 128008, 126208, 127508, 127506
_COMMAND_TIMEOUT_S = 0.5
_FRESH_S = 0.6  # 128006 comes twice a second at least, angles ten times: older says nothing of the moment
_ASK_PERIOD_S = 1.0
_REPORT_PERIOD_S = 0.5
_REFUSED_S = 1.0  # a refusal holds until so long without another
_SILENT_FRAMES, _SILENT_NOISE = 200, 50
_OFF, _AVAILABLE, _TO_PORT, _TO_STARBOARD = 0, 1, 2, 3
_STOPPED_BY = {0: "too hot", 1: "too much current", 4: "low voltage"}  # bits of 128008 that cut the motor out
_CONTROLLED_BY_ANOTHER = 1
_UNREADABLE = (ValueError, TypeError, KeyError, IndexError, OverflowError)  # whatever the decoder says of a frame


class _Motor:
    """What is known of one motor."""

    def __init__(
        self, index: int, config: MotorConfig, thruster: ThrusterConfig, throttle: bool, azimuth: bool
    ) -> None:
        self.index = index
        self.output = ThrusterOutput(thruster, pulses=False)
        self.name = config.thruster
        self.instance = config.instance
        self.sensor = config.instance if config.sensor_instance is None else config.sensor_instance
        self.throttle, self.azimuth = throttle, azimuth  # what this bridge drives of it
        self.address: int | None = None
        self.heard_s: float | None = None
        self.said_level: float | None = None
        self.said_angle_rad: float | None = None
        self.angle_rad: float | None = None  # as its sensor measures it
        self.angle_s = -math.inf
        self.trouble = ""
        self.refusal = ""
        self.refused_s = -math.inf
        self.reported_s = -math.inf

    def feedback(self, source: str, t_s: float, lost: bool = False) -> ThrusterFeedback:
        """All that is known of it at this moment. Its own report of its angle counts only where no sensor measures
        it."""
        self.reported_s = t_s
        fresh = self.heard_s is not None and t_s - self.heard_s <= _FRESH_S
        angle_rad = self.angle_rad if t_s - self.angle_s <= _FRESH_S else self.said_angle_rad if fresh else None
        throttle = (
            self.output.throttle(self.said_level) if fresh and self.throttle and self.said_level is not None else None
        )
        azimuth_rad = self.output.azimuth(angle_rad) if self.azimuth else None
        return ThrusterFeedback(
            t_s, source, self.index, throttle, azimuth_rad, not (lost or self.trouble or self.refusal)
        )


class Nmea2000Bridge:
    """`ActuatorCommand` → 126208 commands; 128006, 127245 and 128008 → `ThrusterFeedback`; 127508, 127506 →
    `Battery`."""

    def __init__(self, config: Nmea2000Config, vessel: VesselConfig, stream: ByteStream) -> None:
        """Raises ConfigError for a thruster without a [[actuator.motor]], and where the packages are missing."""
        self.name = config.name
        self._config = config
        self._stream = stream
        rows = {row.thruster: row for row in config.motors}
        driven = tuple(dict.fromkeys((*config.thrusters, *config.azimuths)))
        missing = [name for name in driven if name not in rows]
        if missing or not driven:
            lacking = missing or ["each thruster"]
            raise ConfigError(
                [f"actuator '{config.name}': needs an [[actuator.motor]] for '{name}'" for name in lacking]
            )
        names = [thruster.name for thruster in vessel.thrusters]
        turned = azimuths_of(config, vessel.thrusters, vessel.actuators)
        self.motors = tuple(
            _Motor(i, rows[name], vessel.thrusters[i], name in config.thrusters, i in turned)
            for name in driven
            for i in (names.index(name),)
        )
        try:
            from nmea2000 import NMEA2000Decoder

            self._node = Node(config.address, f"{vessel.name}/{config.name}", _version())
        except ImportError as error:
            raise ConfigError(
                [f"actuator '{config.name}': {error.name} is not installed: pip install 'usv-companion[can]'"]
            ) from error
        self._handlers: Mapping[int, Callable[[int, dict[str, Any], float], None]] = {
            CONTROL: self._controlled,
            RUDDER: self._turned,
            MOTOR: self._worn,
            COMMAND: self._acknowledged,
            CHARGE: self._charged,
            BATTERY: self._battery,
        }
        self._decoder: Any = NMEA2000Decoder(include_pgns=sorted(self._handlers), units="si")
        self._readings: list[Reading] = []
        self._opened = False
        self._asked_s = -math.inf
        self._charge: float | None = None
        self._heard_s: float | None = None
        self._frames = self._bad = self._frames_since_motor = self._noise = 0

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings of all frames that have come in since the last call, each at its time of arrival."""
        for arrival_s, chunk in self._stream.read(now_s):
            frames, others = unpack(chunk)
            self._bad += others
            self._noise += others
            for identifier, data in frames:
                self._frames += 1
                self._frames_since_motor += 1
                self._take(identifier, data, arrival_s, now_s)
        readings, self._readings = self._readings, []
        return readings

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """One command to each motor that is known; no speed unless armed."""
        if self._stream.fault() is not None:
            self._opened = False
        if not self._opened:
            self._opened = self._stream.fault() is None
            self._send(self._node.start(now_s), now_s)
        self._send(self._node.tick(now_s), now_s)
        if self._node.address is None:
            return
        if any(motor.address is None for motor in self.motors) and now_s - self._asked_s >= _ASK_PERIOD_S:
            self._asked_s = now_s
            self._send(self._node.request(CONTROL), now_s)
        # all of them: then the bridge reports it, and not each motor
        silent = self._heard_s is None or now_s - self._heard_s > self._config.timeout_s
        for motor in self.motors:
            lost_s = (
                now_s
                if motor.heard_s is None or silent
                else max(motor.heard_s + self._config.timeout_s, motor.reported_s + _REPORT_PERIOD_S)
            )
            if now_s > lost_s:
                self._readings.append(motor.feedback(self.name, now_s, lost=True))
            if motor.address is not None:
                self._send(self._command(motor, command.thrusters[motor.index], command.armed, now_s), now_s)

    def health(self, now_s: float) -> DeviceHealth:
        """Ok while one motor is heard and all have been. A single motor that is silent is a thruster that fails."""
        age_s = None if self._heard_s is None else now_s - self._heard_s
        fault = self._stream.fault()
        unknown = [motor.name for motor in self.motors if motor.heard_s is None]
        silent = age_s is None or age_s > self._config.timeout_s
        counts = f"address {self._node.wanted}, {self._frames} frames, {self._bad} bad"
        text = fault or (self._silence(age_s) if silent else self._complaint(unknown, now_s))
        return DeviceHealth(
            self.name, fault is None and not silent and not unknown, age_s, f"{text} ({counts})" if text else counts
        )

    def fileno(self) -> int | None:
        """See `Actuator`."""
        return self._stream.fileno()

    def close(self) -> None:
        """Close the port. The motors stop by themselves."""
        self._stream.close()

    def _complaint(self, unknown: Sequence[str], now_s: float) -> str:
        """What a motor reports or lacks, or an empty text."""
        texts = [
            f"no thruster on the network says that it is {name}: check its power and 'instance'" for name in unknown
        ]
        for motor in self.motors:
            if motor.heard_s is not None and now_s - motor.heard_s > self._config.timeout_s:
                texts.append(f"motor {motor.name} silent for {now_s - motor.heard_s:.1f} s: it stops by itself")
            elif motor.trouble or motor.refusal:
                texts.append(f"motor {motor.name}: {motor.trouble or motor.refusal}")
        return "; ".join(texts)

    def _silence(self, age_s: float | None) -> str:
        if self._noise >= _SILENT_NOISE and self._noise > self._frames_since_motor:
            return (
                "errors on the bus, and no motor's frames: wrong bit rate (NMEA 2000 has 250000), "
                "a terminator missing, or not a CAN bus"
            )
        if self._frames_since_motor >= _SILENT_FRAMES:
            return (
                "the network is alive but has none of the vessel's thrusters: check their power and 'instance', "
                "and that they know PGN 128006"
            )
        if age_s is None:
            return "nothing received yet: check the network's power, its two terminators, and the bit rate, 250000"
        return f"no motor heard for {age_s:.1f} s: check the network's power and plugs; motors stop by themselves"

    def _send(self, frames: bytes, now_s: float) -> None:
        if frames:
            self._stream.write(frames, now_s)

    def _command(self, motor: _Motor, thruster: ThrusterCommand, armed: bool, now_s: float) -> bytes:
        level = motor.output.level(thruster, armed and motor.throttle, now_s)
        percent = min(100, round(100.0 * abs(level)))
        way = _OFF if not armed else _AVAILABLE if percent == 0 else _TO_STARBOARD if level > 0.0 else _TO_PORT
        pairs: list[tuple[int, float]] = [
            (2, motor.instance),
            (3, way),
            (4, int(armed)),
            (6, percent / 100.0),
            (8, _COMMAND_TIMEOUT_S),
        ]
        if armed and motor.azimuth and thruster.azimuth_rad is not None and math.isfinite(thruster.azimuth_rad):
            angle_rad = motor.output.drive_azimuth(thruster.azimuth_rad)
            pairs.append((9, 0.0 if angle_rad is None else angle_rad % TWO_PI))
        field = self._node.field
        fields = [field("functionCode", 1), field("pgn", CONTROL), field("priority", 8), field("reserved_36", 15)]
        fields += [field("numberOfParameters", len(pairs))]
        fields += [
            field(
                "##list##",
                [{"parameter": field("parameter", number), "value": field("value", value)} for number, value in pairs],
            )
        ]
        assert motor.address is not None
        return self._node.encode(COMMAND, "nmeaCommandGroupFunction", fields, motor.address, 2)

    def _take(self, identifier: int, data: bytes, arrival_s: float, now_s: float) -> None:
        pgn, source, destination = header(identifier)
        if source == self._node.wanted and pgn != CLAIM:
            return  # its own, come back
        if pgn in (CLAIM, REQUEST):
            self._send(self._node.heard(pgn, source, destination, data, arrival_s), now_s)
        if pgn not in self._handlers or (pgn == COMMAND and destination != self._node.wanted):
            return
        message = self._decoded(identifier, data)
        if message is None:
            return
        values = {"message": message.id, **{field.id: field.raw_value for field in message.fields}}
        self._handlers[pgn](source, values, arrival_s)

    def _decoded(self, identifier: int, data: bytes) -> Any:
        import can

        try:
            return self._decoder.decode(can.Message(arbitration_id=identifier, data=data, is_extended_id=True))
        except _UNREADABLE:
            self._bad += 1
            return None

    def _controlled(self, source: int, values: dict[str, Any], t_s: float) -> None:
        motor = next((motor for motor in self.motors if motor.instance == values.get("identifier")), None)
        way, speed = values.get("directionControl"), values.get("speedControl")
        if motor is None or source > 251:
            return
        if way not in (_OFF, _AVAILABLE, _TO_PORT, _TO_STARBOARD) or (speed is not None and not 0.0 <= speed <= 1.0):
            self._bad += 1
            return
        motor.address, motor.heard_s = source, t_s
        self._heard_s, self._frames_since_motor, self._noise = t_s, 0, 0
        if int(values.get("controlEvents") or 0) & _CONTROLLED_BY_ANOTHER:
            motor.refusal = "another device on the network controls it"
        elif motor.refusal and t_s - motor.refused_s > _REFUSED_S:
            motor.refusal = ""
        motor.said_level = (
            0.0 if way in (_OFF, _AVAILABLE) else None if speed is None else speed if way == _TO_STARBOARD else -speed
        )
        azimuth_rad = values.get("azimuthControl")
        motor.said_angle_rad = None if azimuth_rad is None else wrap_pi(azimuth_rad)
        self._readings.append(motor.feedback(self.name, t_s))

    def _turned(self, source: int, values: dict[str, Any], t_s: float) -> None:
        angle_rad = values.get("position")
        for motor in self.motors:
            if motor.azimuth and angle_rad is not None and motor.sensor == values.get("instance"):
                motor.angle_rad, motor.angle_s = wrap_pi(angle_rad), t_s
                if motor.heard_s is not None and t_s - motor.heard_s <= self._config.timeout_s:
                    self._readings.append(motor.feedback(self.name, t_s))

    def _worn(self, source: int, values: dict[str, Any], t_s: float) -> None:
        for motor in self.motors:
            if motor.instance == values.get("identifier") and motor.address == source:
                events = int(values.get("motorEvents") or 0)
                motor.trouble = ", ".join(text for bit, text in _STOPPED_BY.items() if events >> bit & 1)

    def _charged(self, source: int, values: dict[str, Any], t_s: float) -> None:
        if values.get("instance") == 0:
            self._charge = values.get("stateOfCharge")

    def _battery(self, source: int, values: dict[str, Any], t_s: float) -> None:
        if values.get("instance") == 0 and values.get("voltage") is not None:
            current_a = values.get("current")
            drawn_a = None if current_a is None else -current_a
            self._readings.append(Battery(t_s, self.name, values["voltage"], drawn_a, self._charge))

    def _acknowledged(self, source: int, values: dict[str, Any], t_s: float) -> None:
        if values["message"] != "nmeaAcknowledgeGroupFunction" or values.get("pgn") != CONTROL:
            return
        if values.get("pgnErrorCode"):
            for motor in self.motors:
                if motor.address == source:
                    motor.refused_s = t_s
                    motor.refusal = f"refuses commands (error {values['pgnErrorCode']})"


def _version() -> str:
    try:
        return version("usv-companion")
    except PackageNotFoundError:
        return "0.0.0"
