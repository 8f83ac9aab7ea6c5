"""What a log holds beside ticks.csv, for a replay: the thrust that the boards measured, and what devices reported.

Reading log.mcap takes some seconds an hour, so a thread does it; until it is done nothing is measured.
"""

from __future__ import annotations

import threading
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.core.actuation import ThrusterFeedback
from companion.core.readings import Reading
from companion.record import readings
from companion.record.feed_schema import feedback_row

_OLD_S = 5.0  # from which on a report of a board tells nothing any more


class Measured:
    """Thrust as measured, and texts of devices, by the boat's time."""

    def __init__(self, folder: Path, thrusters: int, time_of: Callable[[int], float]) -> None:
        """`time_of`: the boat's time of a Unix time in ns."""
        self._path = readings.path_in(folder)
        self._time_of = time_of
        self._times_s: list[list[float]] = [[] for _ in range(thrusters)]
        self._reports: list[list[ThrusterFeedback]] = [[] for _ in range(thrusters)]
        self._texts: dict[str, tuple[list[float], list[str]]] = {}
        self._thread = threading.Thread(target=self._read, name="log reader", daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Until all is read."""
        self._thread.join()

    def feedback(self, t_s: float) -> list[dict[str, Any] | None]:
        """Of each thruster the newest report at that time, as in the feed; None where there is none, or an old one."""
        return [
            feedback_row(report, t_s) if report is not None and t_s - report.t_s <= _OLD_S else None
            for report in (self._newest(n, t_s) for n in range(len(self._times_s)))
        ]

    def texts(self, t_s: float) -> Mapping[str, str]:
        """What each device has reported last at that time."""
        found = {}
        for name, (times_s, texts) in self._texts.items():
            if (at := bisect_right(times_s, t_s)) > 0:
                found[name] = texts[at - 1]
        return found

    def _newest(self, thruster: int, t_s: float) -> ThrusterFeedback | None:
        at = bisect_right(self._times_s[thruster], t_s)
        return self._reports[thruster][at - 1] if at > 0 else None

    def _read(self) -> None:
        try:
            found: Sequence[Reading] = readings.read_kind(self._path, "feedback", [])
            health = readings.read_health(self._path, [])
        except OSError:
            return
        for report in found:
            if isinstance(report, ThrusterFeedback) and report.index < len(self._times_s):
                self._reports[report.index].append(report)
                self._times_s[report.index].append(report.t_s)
        texts: dict[str, tuple[list[float], list[str]]] = {}
        for unix_ns, device in health:
            times_s, said = texts.setdefault(device.name, ([], []))
            times_s.append(self._time_of(unix_ns))
            said.append(device.text)
        self._texts = texts
