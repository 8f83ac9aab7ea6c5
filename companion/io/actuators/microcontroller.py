"""Bridge to a microcontroller board that drives thrusters, in the frames of `companion.core.microcontroller_frame`."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ActuatorConfig
from companion.config.driving import azimuths_of
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.actuation import ActuatorCommand, Auxiliary, ThrusterFeedback
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    MAX_THRUSTERS,
    WATCHDOG_S,
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    Radio,
    ThrusterDemand,
    encode,
)
from companion.core.ports import ByteStream
from companion.core.readings import Battery, Leak, RcInput, Reading
from companion.core.tick import DeviceHealth
from companion.io.actuators.calibration import ThrusterOutput
from companion.io.crsf_telemetry import CrsfTelemetry
from companion.io.rc_receiver import channels
from companion.io.recognise import Overheard

_IDENT_PERIOD_S = 1.0
_COMMAND_GRACE_S = 1.0  # a board that has not had our commands for so long is asked about its watchdog
_SILENT_BYTES = 400  # that many bytes without one valid frame: not the language or not the speed


class _RadioOnBoard:
    """The way back to a transmitter whose receiver is wired to the board. `open`: the board takes RADIO."""

    def __init__(self, stream: ByteStream) -> None:
        self.open = False
        self._stream = stream

    def write(self, data: bytes, now_s: float) -> None:
        """Send one RADIO frame."""
        self._stream.write(encode(Radio(data)), now_s)

    def fault(self) -> str | None:
        """Why nothing can be sent, or None."""
        return self._stream.fault() if self.open else "the board passes nothing on to an RC receiver"


class MicrocontrollerBridge:
    """`ActuatorCommand` → COMMAND frames, and AUXILIARY frames where it drives servos or relays; STATUS frames →
    `Battery`, `Leak`, `RcInput`, `ThrusterFeedback`. `telemetry` sends the boat's state to the transmitter, where the
    board's RC receiver takes it.

    Of several STATUS frames in one read the newest counts. Thruster indices are those of the vessel. A thruster whose
    azimuth another bridge drives is a fixed one to the board. Remembers the last status, the board's identity, the
    sequence number, when the board was last heard and asked, and since
    when it has had commands without a gap.
    """

    def __init__(self, config: ActuatorConfig, vessel: VesselConfig, stream: ByteStream) -> None:
        """Raises ConfigError for a thruster that the vessel does not have, more of them than a frame holds, or an
        azimuth without its throttle."""
        self.name = config.name
        self._config = config
        self._stream = stream
        names = [thruster.name for thruster in vessel.thrusters]
        unknown = [name for name in config.thrusters if name not in names]
        if unknown:
            raise ConfigError(
                [f"actuator '{config.name}': the vessel has no thruster named '{name}'" for name in unknown]
            )
        if len(config.thrusters) > MAX_THRUSTERS:
            text = f"drives {len(config.thrusters)} thrusters; a board drives up to {MAX_THRUSTERS}"
            raise ConfigError([f"actuator '{config.name}': {text}"])
        alone = [name for name in config.azimuths if name not in config.thrusters]
        if alone:
            texts = [f"a board that turns '{name}' drives its throttle too: add it to 'thrusters'" for name in alone]
            raise ConfigError([f"actuator '{config.name}': {text}" for text in texts])
        self._indices = tuple(names.index(name) for name in config.thrusters)
        self._turned = frozenset(azimuths_of(config, vessel.thrusters, vessel.actuators))
        self._drives = tuple(ThrusterOutput(vessel.thrusters[i], pulses=False) for i in self._indices)
        self._servos = _positions([servo.name for servo in vessel.servos], config.servos)
        self._relays = _positions([relay.name for relay in vessel.relays], config.relays)
        self._outputs: AuxiliaryState | None = None
        self._outputs_s: float | None = None
        self._radio = _RadioOnBoard(stream)
        self.telemetry = CrsfTelemetry(self._radio)
        self._decoder = FrameDecoder()
        self._status: BoardStatus | None = None
        self._ident: Ident | None = None
        self._heard_s: float | None = None
        self._asked_s: float | None = None
        self._writing_since_s: float | None = None
        self._written_s: float | None = None
        self._bytes_since_frame = 0
        self._overheard = Overheard(_SILENT_BYTES)
        self._sequence = 0

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings of the newest status that has come in since the last call, at its time of arrival."""
        newest: tuple[float, BoardStatus] | None = None
        for arrival_s, data in self._stream.read(now_s):
            self._bytes_since_frame += len(data)
            for message in self._decoder.feed(data):
                self._bytes_since_frame = 0
                if isinstance(message, BoardStatus):
                    newest = arrival_s, message
                elif isinstance(message, Ident):
                    self._ident = message
                elif isinstance(message, AuxiliaryState):
                    self._outputs, self._outputs_s = message, arrival_s
            self._overheard.hear(data, self._bytes_since_frame)
        if newest is None:
            return ()
        self._heard_s, self._status = newest
        self._radio.open = self._status.takes_radio
        return self._readings(*newest)

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """One COMMAND frame; neutral throttle unless armed. Asks for the board's identity until it is known."""
        if self._ident is None and (self._asked_s is None or now_s - self._asked_s >= _IDENT_PERIOD_S):
            self._asked_s = now_s
            self._stream.write(encode(IdentRequest()), now_s)
        demands = []
        for index, drive in zip(self._indices, self._drives, strict=True):
            thruster = command.thrusters[index]
            azimuth_rad = drive.drive_azimuth(thruster.azimuth_rad) if index in self._turned else None
            demands.append(ThrusterDemand(drive.level(thruster, command.armed, now_s), azimuth_rad))
        beacon = command.beacon
        self._sequence = (self._sequence + 1) & 0xFF
        message = BoardCommand(
            sequence=self._sequence,
            armed=command.armed,
            thrusters=tuple(demands),
            lower=command.lower,
            red=beacon.red,
            yellow=beacon.yellow,
            green=beacon.green,
        )
        self._stream.write(encode(message), now_s)
        self._write_outputs(command.auxiliary, now_s)
        if self._written_s is None or now_s - self._written_s >= WATCHDOG_S:
            self._writing_since_s = now_s  # the board's watchdog may have tripped for want of commands
        self._written_s = now_s

    def _write_outputs(self, auxiliary: Auxiliary, now_s: float) -> None:
        if not self._servos and not self._relays:
            return
        known = len(auxiliary.servos_us) > max(self._servos, default=-1) and len(auxiliary.relays) > max(
            self._relays, default=-1
        )
        servos = tuple(auxiliary.servos_us[i] if known else None for i in self._servos)
        relays = tuple(known and auxiliary.relays[i] for i in self._relays)
        self._stream.write(encode(AuxiliaryDemand(self._sequence, servos, relays)), now_s)

    def health(self, now_s: float) -> DeviceHealth:
        """Ok while status frames come in time and none reports a fault; else what to do."""
        age_s = None if self._heard_s is None else now_s - self._heard_s
        complaint = self._complaint(now_s)
        counts = f"{self._firmware()}{self._decoder.frames} frames, {self._decoder.errors} bad"
        return DeviceHealth(self.name, not complaint, age_s, f"{complaint} ({counts})" if complaint else counts)

    def fileno(self) -> int | None:
        """See `Actuator`."""
        return self._stream.fileno()

    def close(self) -> None:
        """Close the port. The board's watchdog makes it neutral."""
        self._stream.close()

    def _complaint(self, now_s: float) -> str:
        """What is wrong and what to do, or an empty text."""
        fault = self._stream.fault()
        if fault is not None:
            return fault
        if self._heard_s is None or now_s - self._heard_s > self._config.timeout_s:
            return self._silence(now_s)
        return self._reported(now_s)

    def _silence(self, now_s: float) -> str:
        if self._bytes_since_frame >= _SILENT_BYTES:
            wrong = self._overheard.guess or f"wrong baud rate in '{self._config.port}', or other firmware on the board"
            return f"{self._bytes_since_frame:,} bytes and no valid frame: {wrong}"
        if self._heard_s is None:
            return "nothing received yet: check the board's power, cable and firmware"
        return f"silent for {now_s - self._heard_s:.1f} s: check the board's power and cable; it goes neutral by itself"

    def _reported(self, now_s: float) -> str:
        """What the newest status of the board complains of."""
        status, n = self._status, len(self._indices)
        if status is None:
            return ""
        if len(status.thrusters) != n:
            has = len(status.thrusters)
            return (
                f"the board drives {has} thrusters, the vessel's file gives it {n}: "
                "correct 'thrusters' there or the firmware"
            )
        if status.safe_mode:
            return "the transmitter's safe-mode switch has the thrusters, not the companion: switch it off to go on"
        written_s = self._written_s
        paused = written_s is None or now_s - written_s >= WATCHDOG_S
        writing_s = 0.0 if paused or self._writing_since_s is None else now_s - self._writing_since_s
        if status.neutral_by_watchdog and writing_s > _COMMAND_GRACE_S:
            return (
                "the board hears no commands and is neutral: check the wire from the companion's TX to the board's RX"
            )
        return self._outputs_complaint(now_s) if writing_s > _COMMAND_GRACE_S else ""

    def _outputs_complaint(self, now_s: float) -> str:
        """A board that drives servos or relays reports them too."""
        if not self._servos and not self._relays:
            return ""
        if self._outputs is None or self._outputs_s is None or now_s - self._outputs_s > self._config.timeout_s:
            return (
                "the board does not report its servos and relays: "
                "update its firmware, or remove them from the vessel's file"
            )
        has, given = (len(self._outputs.servos_us), len(self._outputs.relays)), (len(self._servos), len(self._relays))
        if has != given:
            counts = f"{has[0]} servos and {has[1]} relays, the vessel's file gives it {given[0]} and {given[1]}"
            return f"the board has {counts}: correct one of them"
        return ""

    def _firmware(self) -> str:
        return (
            "" if self._ident is None else f"{self._ident.name} firmware {'.'.join(map(str, self._ident.firmware))}, "
        )

    def _readings(self, arrival_s: float, status: BoardStatus) -> list[Reading]:
        name = self.name
        readings: list[Reading] = [Leak(arrival_s, name, status.leak_wet)]
        if status.voltage_v is not None:
            readings.append(Battery(arrival_s, name, status.voltage_v, status.current_a, status.remaining))
        if status.rc_present:
            readings.append(RcInput(arrival_s, name, channels(status.rc_us), status.rc_lost))
        for index, drive, state in zip(self._indices, self._drives, status.thrusters, strict=False):
            azimuth_rad = drive.azimuth(state.azimuth_rad) if index in self._turned else None
            readings.append(
                ThrusterFeedback(
                    arrival_s, name, index, drive.throttle(state.throttle), azimuth_rad, state.ok, state.deployment
                )
            )
        return readings


def _positions(names: Sequence[str], driven: Sequence[str]) -> tuple[int, ...]:
    return tuple(names.index(name) for name in driven)
