"""The boat's state on one screen, in the boat's own words, and whether it is ready.

The words come from the boat's shell (SERIAL_CONTROL), the verdict from HEARTBEAT and SYS_STATUS, as any ground station
reads it.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any

from mavsdk.plugins.shell import Device, Shell

from gcs_plugins.usvctl.boat import Boat, NoVessel

COMMANDS = ("status", "devices", "why")
_PROMPT = "usv> "
_PREARM_CHECK = 0x10000000  # MAV_SYS_STATUS_PREARM_CHECK
_CRITICAL = 5  # MAV_STATE_CRITICAL: while a failsafe acts
_PATIENCE_S = 6.0  # for each answer, and for the messages
_TRIES = 3


def show(boat: Boat) -> bool:
    """Print the state. Returns whether the boat is ready: armed, or free to arm, and no failsafe acts.

    Raises NoVessel where the shell or the messages stay out.
    """
    boat.listen("SYS_STATUS")
    shell = _Shell(boat)
    try:
        status, devices, why = (shell.ask(command) for command in COMMANDS)
    finally:
        shell.close()
    print("\n".join(status))
    print("Devices and links:", *(f"  {line}" for line in devices), sep="\n")
    reasons = not_ready(boat)
    if not reasons:
        print("Ready")
        return True
    against = [line.strip() for line in why if line.startswith("  ")] if not boat.armed else []
    print(f"Not ready: {', '.join(reasons)}", *(f"  {line}" for line in against), sep="\n")
    return False


def not_ready(boat: Boat) -> list[str]:
    """What keeps the boat from being ready, in a few words each; empty where nothing does."""
    health, beat = _heard(boat, "SYS_STATUS"), _heard(boat, "HEARTBEAT")
    reasons = []
    if beat["system_status"] >= _CRITICAL:
        reasons.append("a failsafe acts")
    if not boat.armed and not health["onboard_control_sensors_health"] & _PREARM_CHECK:
        reasons.append("arming would be refused")
    return reasons


def _heard(boat: Boat, kind: str) -> Mapping[str, Any]:
    """The newest message of that kind. Raises NoVessel where none comes."""
    boat.wait(lambda: boat.newest(kind) is not None, _PATIENCE_S)
    message = boat.newest(kind)
    if message is None:
        raise NoVessel(f"no {kind} in {_PATIENCE_S:g} s")
    return message


def answer_in(text: str, line: str) -> Sequence[str] | None:
    """The lines with which a shell has answered `line`, from all that it has printed; None until they are complete."""
    _, echoed, rest = text.partition(f"{_PROMPT}{line}\n")
    told, ended, _ = rest.partition(_PROMPT)
    return told.splitlines() if echoed and ended else None


class _Shell:
    """A session in the boat's shell."""

    def __init__(self, boat: Boat) -> None:
        self._boat = boat
        self._shell = Shell(boat.system)
        self._heard = ""
        self._news = threading.Condition()
        self._handle = self._shell.subscribe_receive(self._hear)

    def ask(self, line: str) -> Sequence[str]:
        """The lines of the answer. Raises NoVessel where none comes."""
        for _ in range(_TRIES):  # MAVSDK may lose the first answer, a radio any
            self._shell.send(f"{line}\n", Device.SHELL)
            with self._news:
                if self._news.wait_for(lambda: answer_in(self._heard, line) is not None, _PATIENCE_S / _TRIES):
                    return answer_in(self._heard, line) or ()
        raise NoVessel(f"the boat's shell does not answer in {_PATIENCE_S:g} s")

    def close(self) -> None:
        """End the session, so that others find room."""
        self._shell.unsubscribe_receive(self._handle)
        self._boat.send("SERIAL_CONTROL", device=10, flags=0, timeout=0, baudrate=0, count=0, data=[0] * 70)

    def _hear(self, received: Any, _: Any) -> None:
        with self._news:
            self._heard += received.data
            self._news.notify_all()
