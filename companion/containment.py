"""Keeps a fault of the program from ending the run: one in a driver costs its device, one in a tick that tick."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import TypeVar

from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.ports import Actuator, Sensor
from companion.core.tick import DeviceHealth

T = TypeVar("T")

_DRIVER_FAULTY_S = 2.0  # so long a device counts as faulty after its driver has failed
_MOST_LEFT_OUT = 20  # ticks in a row: what fails for so long does not pass, and a program that begins anew may sail


class Containment:
    """`report`: takes the whole trace of a fault, once for each place in the program. None, as tests and scenarios have
    it: faults of the program are raised. Without memory a tick is left out in any case."""

    report: Callable[[str], None] | None

    def __init__(self, say: Announce) -> None:
        self.report = None
        self._say = say
        self._left_out = 0
        self._drivers: dict[str, tuple[float, str]] = {}  # (when it failed, how), by device
        self._reported: set[str] = set()

    def driver(self, name: str, step: Callable[[], T], otherwise: T, now_s: float) -> T:
        """What that device's driver returns, or `otherwise` where it fails."""
        try:
            return step()
        except MemoryError:
            raise
        except Exception as error:  # whatever is wrong with one driver, the others are heard and driven
            if self.report is None:
                raise
            self._drivers[name] = (now_s, f"driver fails ({type(error).__name__})")
            self._tell_in_full(error)
            return otherwise

    def health(self, device: Sensor | Actuator, now_s: float) -> DeviceHealth:
        """The state of a device; not ok while its driver fails."""
        unknown = DeviceHealth(device.name, ok=False, age_s=None)
        health = self.driver(device.name, lambda: device.health(now_s), unknown, now_s)
        failed_s, text = self._drivers.get(device.name, (-math.inf, ""))
        return health if now_s - failed_s >= _DRIVER_FAULTY_S else replace(health, ok=False, text=text)

    def tick_done(self) -> None:
        """A tick came to its end."""
        self._left_out = 0

    def tick_failed(self, error: Exception, now_s: float) -> None:
        """Announce that a tick is left out; the bridges time out if more follow. Raises `error` where it is the
        _MOST_LEFT_OUT + 1st in a row, or a fault of the program that is to be raised."""
        self._left_out += 1
        starved = isinstance(error, MemoryError)
        if self._left_out > _MOST_LEFT_OUT or not (starved or self.report is not None):
            raise error
        if starved:
            with suppress(MemoryError):
                self._say(now_s, TextKind.ATTENTION, "computer", "Computer: out of memory, a tick is left out")
            return
        text = f"Tick left out: {type(error).__name__}, {_place_of(error)}"
        self._say(now_s, TextKind.ALARM, "tick_failed", text[:50])
        self._tell_in_full(error)

    def _tell_in_full(self, error: Exception) -> None:
        place = _place_of(error)
        if self.report is not None and place not in self._reported:
            self._reported.add(place)
            self.report("".join(traceback.format_exception(error)))


def _place_of(error: Exception) -> str:
    """File and line where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return "unknown place"
    return f"{frames[-1].filename.rpartition('/')[2]}:{frames[-1].lineno}"
