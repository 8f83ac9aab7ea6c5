"""A board that drives thrusters over `companion.core.microcontroller_frame`, with a watchdog of its own."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ActuatorConfig
from companion.core.actuation import DARK, Beacon, Light
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    RC_CHANNELS,
    WATCHDOG_S,
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    Message,
    Radio,
    ThrusterState,
    encode,
)
from sitl.battery import LOW_REMAINING, LOW_VOLTAGE_V, BatteryModel
from sitl.drives import DriveModel
from sitl.emulators.rc_receiver import shown
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import ThrusterModel

_STATUS_HZ = 20.0
_FIRMWARE = (1, 1, 0)
_RC_CENTRED = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)
_RC_SAFE = (1500, 1500, 1500, 1500, 2000, 1000, 1000, 1000)
_NONE = (0,) * RC_CHANNELS


class MicrocontrollerEmulator:
    """Obeys armed commands; without them it is neutral. `rc_us`: pulses of a transmitter, None without an RC receiver.
    `telemetry`: the CRSF frames for its screen, by type. `outputs`: state of its servos and relays."""

    def __init__(
        self,
        config: ActuatorConfig,
        port: MemoryDevice,
        thrusters: Sequence[ThrusterModel],
        battery: BatteryModel,
        faults: Faults,
    ) -> None:
        self.name = config.name
        self.rate_hz = _STATUS_HZ
        self._port = port
        self.last_command: BoardCommand | None = None
        self.rc_us: Sequence[int] | None = _RC_CENTRED if faults.planned("rc_") else None
        self.telemetry: dict[int, bytes] = {}
        self._thrusters = tuple(thrusters)
        self._drives = tuple(DriveModel(thruster.config, pulses=False) for thruster in thrusters)
        self._battery = battery
        self._faults = faults
        self._decoder = FrameDecoder()
        self._last_command_s: float | None = None
        self._neutral = True
        self._introduced = False
        self._at_rest = AuxiliaryState(0, (None,) * len(config.servos), (False,) * len(config.relays))
        self.outputs = self._at_rest
        self._outputs_s: float | None = None
        self._t_s = 0.0

    def relay(self, number: int) -> bool:
        """Whether the board's relay is on, by its place in the file's row."""
        return self.outputs.relays[number]

    def servo_us(self, number: int) -> float | None:
        """Pulse of the board's servo, by its place in the file's row."""
        return self.outputs.servos_us[number]

    def listen(self, t_s: float) -> None:
        """Handle the commands that have arrived by `t_s`, then the watchdog."""
        self._t_s = t_s
        for _, data in self._port.receive(t_s):
            if self._faults.active.isdisjoint(("mcu_silent", "mcu_deaf")):
                for message in self._decoder.feed(data):
                    self._take(message, t_s)
        if not self._neutral and self._has_expired(self._last_command_s, t_s):
            self._go_neutral()
        if self._outputs_s is not None and self._has_expired(self._outputs_s, t_s):
            self.outputs = self._at_rest

    def _take(self, message: Message, t_s: float) -> None:
        if isinstance(message, BoardCommand) and len(message.thrusters) == len(self._thrusters):
            self.last_command = message
            self._last_command_s = t_s
            self._obey(message)
        elif isinstance(message, IdentRequest):
            self._introduced = False
        elif isinstance(message, AuxiliaryDemand):
            self._switch(message, t_s)
        elif isinstance(message, Radio) and self.rc_us is not None:
            self.telemetry.update(shown(message.data))

    def _has_expired(self, commanded_s: float | None, t_s: float) -> bool:
        """Whether the watchdog trips: the board has stopped, or the last command is too old."""
        stopped = "mcu_silent" in self._faults.active
        return stopped or commanded_s is None or t_s - commanded_s >= WATCHDOG_S - 1e-9

    def speak(self, t_s: float) -> None:
        """Send the state, and once the identity."""
        if "mcu_silent" in self._faults.active:
            return
        if not self._introduced:
            self._introduced = True
            self._port.send(encode(Ident(_FIRMWARE, len(self._thrusters), self.name)), t_s)
        self._port.send(encode(self.status()), t_s)
        if self._outputs_s is not None:
            self._port.send(encode(self.outputs), t_s)

    @property
    def beacon(self) -> Beacon:
        """The lamps as they shine: as commanded, or steady green after the watchdog has tripped and before the first
        command."""
        command = self.last_command
        if command is None:
            return DARK if self._t_s < WATCHDOG_S else Beacon(green=Light.STEADY)
        return Beacon(command.red, command.yellow, Light.STEADY if self._neutral else command.green)

    def status(self) -> BoardStatus:
        """The state that it reports."""
        active = self._faults.active
        low = "battery_low" in active
        rc_lost = "rc_lost" in active
        pulses = _RC_SAFE if "rc_safe" in active else self.rc_us
        return BoardStatus(
            sequence=0 if self.last_command is None else self.last_command.sequence,
            neutral_by_watchdog=self._neutral,
            leak_wet="leak" in active,
            rc_present=pulses is not None,
            rc_lost=pulses is not None and rc_lost,
            voltage_v=LOW_VOLTAGE_V if low else self._battery.voltage_v,
            current_a=self._battery.current_a,
            remaining=LOW_REMAINING if low else self._battery.remaining,
            rc_us=_NONE if pulses is None or rc_lost else tuple(pulses),
            thrusters=tuple(
                [
                    ThrusterState(
                        drive.level(each.throttle()),
                        drive.shown_rad(each.azimuth_rad) if each.steerable else None,
                        not each.dead,
                        each.deployment,
                    )
                    for each, drive in zip(self._thrusters, self._drives, strict=True)
                ]
            ),
            takes_radio=pulses is not None,
        )

    def _switch(self, demand: AuxiliaryDemand, t_s: float) -> None:
        if (len(demand.servos_us), len(demand.relays)) == (len(self._at_rest.servos_us), len(self._at_rest.relays)):
            self.outputs = AuxiliaryState(demand.sequence, demand.servos_us, demand.relays)
            self._outputs_s = t_s

    def _obey(self, command: BoardCommand) -> None:
        self._neutral = False
        for thruster, drive, demand in zip(self._thrusters, self._drives, command.thrusters, strict=True):
            if command.lower is not None:
                thruster.lower = command.lower
            if command.armed:
                thruster.demand(drive.throttle(demand.throttle), drive.azimuth_rad(demand.azimuth_rad))
            else:
                thruster.demand(0.0, None)

    def _go_neutral(self) -> None:
        self._neutral = True
        for thruster in self._thrusters:
            thruster.demand(0.0, None)
