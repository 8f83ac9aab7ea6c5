"""How much of a line a telemetry radio can pass on, by what it says of its buffer (RADIO_STATUS.txbuf).

The air of a radio may carry less than its serial port, and by how much changes with range: SiK, RFD900, ExpressLRS.
What the radio cannot store it drops, in the middle of packets. Source of the rule: PX4, `Mavlink::update_radio_status`,
and ArduPilot, `GCS_MAVLINK::handle_radio_status`, which recovers faster. A buffer that is about to overflow halves the
rate: a port may take thirty times what the air carries.
"""

from __future__ import annotations

_STEPS = ((10, 0.5), (25, 0.75), (50, 0.975), (91, 1.025), (256, 1.1))  # below so many percent free, times so much
_LEAST_S = 0.2  # between two steps: some radios report ten times a second
_SILENT_S = 10.0  # a radio that says no more was exchanged for a cable


class RadioFlow:
    """`take(free_percent, now_s)` each report, `share(now_s)` → the share of the line's rate to use, `least`…1.

    Remembers the share, and when it was changed and a report heard last.
    """

    def __init__(self, least: float) -> None:
        """`least`: a share at which heartbeats and answers still pass."""
        self._least = min(1.0, least)
        self._share = 1.0
        self._heard_s: float | None = None
        self._stepped_s: float | None = None

    def take(self, free_percent: int, now_s: float) -> None:
        """A report of the radio."""
        self._share = self.share(now_s)
        self._heard_s = now_s
        if self._stepped_s is not None and 0.0 <= now_s - self._stepped_s < _LEAST_S:
            return
        self._stepped_s = now_s
        self._share = min(1.0, max(self._least, self._share * _step(free_percent)))

    @property
    def reports(self) -> bool:
        """Whether the radio has ever reported."""
        return self._heard_s is not None

    def share(self, now_s: float) -> float:
        """1 before the first report, and once the radio is silent."""
        return self._share if self._heard_s is not None and now_s - self._heard_s <= _SILENT_S else 1.0


def _step(free_percent: int) -> float:
    return next(factor for below, factor in _STEPS if free_percent < below)
