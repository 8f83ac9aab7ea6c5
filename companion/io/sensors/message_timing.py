"""How often a device's messages come, and how late."""

from __future__ import annotations

_WINDOW_S = 5.0
_MOST_KINDS = 16
_SLOW_SHARE = 0.8  # of the rate that the vessel's file says


class MessageTiming:
    """Messages as they arrive → a text for people: rates by kind, and how much later messages came than the promptest.

    Counts over windows of 5 s. Remembers the window under way and the text of the last whole one. `expected_hz`: the
    rate in the vessel's file.
    """

    def __init__(self, expected_hz: float) -> None:
        self._expected_hz = expected_hz
        self._counts: dict[str, int] = {}
        self._since_s: float | None = None
        self._last_s = 0.0
        self._late_sum_s = self._late_most_s = 0.0
        self._stamped = 0
        self.text = ""
        self.rates_hz: dict[str, float] = {}

    def note(self, arrival_s: float, kind: str = "") -> None:
        """A message of that kind has arrived."""
        if self._since_s is None or arrival_s - self._last_s > _WINDOW_S:  # after a silence a window of its own
            self._since_s = arrival_s
            self._counts.clear()
        self._last_s = arrival_s
        elapsed_s = arrival_s - self._since_s
        if elapsed_s >= _WINDOW_S:
            self._close(elapsed_s)
            self._since_s = arrival_s
        if kind in self._counts:
            self._counts[kind] += 1
        elif len(self._counts) < _MOST_KINDS:
            self._counts[kind] = 1

    def late(self, late_s: float) -> None:
        """A message with a time of its own came `late_s` later than the promptest would have."""
        self._stamped += 1
        self._late_sum_s += late_s
        self._late_most_s = max(self._late_most_s, late_s)

    def _close(self, elapsed_s: float) -> None:
        self.rates_hz = {kind: count / elapsed_s for kind, count in self._counts.items()}
        parts = [", ".join(f"{kind} {rate:.3g}".lstrip() for kind, rate in self.rates_hz.items()) + " Hz"]
        fastest_hz = max(self.rates_hz.values())
        if fastest_hz < _SLOW_SHARE * self._expected_hz:
            parts.append(f"slower than rate_hz = {self._expected_hz:g}")
        if self._stamped:
            mean_ms, most_ms = 1e3 * self._late_sum_s / self._stamped, 1e3 * self._late_most_s
            parts.append(f"{mean_ms:.0f} ms late, at most {most_ms:.0f}")
        self.text = "; ".join(parts)
        self._counts.clear()
        self._stamped = 0
        self._late_sum_s = self._late_most_s = 0.0
