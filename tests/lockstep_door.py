"""The door of a script whose boat is a lockstep rig: while the script waits, the boat sails."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.cli.rig import LockstepRig
from companion.core.tick import Tick
from companion.feed_view import greeting
from companion.record.feed_schema import TickEncoder, event_message
from companion.scripting.door import Arrived


class LockstepDoor:
    """`told`: what the script has told its keeper. `limit_s`: of the boat's time, after which a wait fails."""

    def __init__(self, rig: LockstepRig, limit_s: float = 600.0) -> None:
        self._rig, self._limit_s = rig, limit_s
        self.told: list[tuple[str, str]] = []
        config = rig.vessel.config
        devices = [*(sensor.name for sensor in config.sensors), *(bridge.name for bridge in config.actuators)]
        self._encoder = TickEncoder([thruster.name for thruster in config.thrusters], devices)
        self._lines: list[Mapping[str, Any]] = []
        self.greet()
        rig.vessel.add_recorder(self)

    def greet(self) -> None:
        """As the feed does for each new reader."""
        self._lines.append({**greeting(self._rig.vessel, ()), "kind": "hello"})

    def record(self, tick: Tick) -> None:
        self._lines += [event_message(event, tick.time_unix_ns) for event in tick.events]
        self._lines.append(self._encoder.message(tick, 0, 0))

    def close(self) -> None:
        pass

    def now_s(self) -> float:
        return self._rig.now_s

    def send(self, packet: bytes) -> None:
        self._rig.send(packet)

    def wait(self, timeout_s: float) -> Arrived:
        assert self._rig.now_s < self._limit_s, "the script waits in vain"
        self._rig.step()
        lines, self._lines = self._lines, []
        return Arrived(self._rig.receive(), lines)

    def tell(self, kind: str, text: str) -> None:
        self.told.append((kind, text))
