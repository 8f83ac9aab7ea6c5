"""Whether a heading that seems to drift away from the gyro is late.

A late heading is what the gyro has turned some tenths of a second ago. So it lags while the rate of turn grows, and
comes back when it falls: by latency times rate, and no further. A gyro that is off, or a heading that creeps, goes on.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.nav.integrity.statistics import ScalarCusum

_LATENCIES_S = (0.1, 0.2, 0.3, 0.4, 0.5)  # beyond what the row says; between two of them little is left


def explained_by_latency(
    times_s: Sequence[float],
    headings_rad: Sequence[float],
    turns_rad: Sequence[float],
    first: int,
    slack: tuple[float, float],
    threshold_rad: float,
) -> bool:
    """Whether one latency leaves no drift of `threshold_rad` between headings and turns, both unwrapped, from the index
    `first` on. `slack`: of the sums, in rad/s, and as a share of the turn."""
    return any(
        _drift_rad(times_s, headings_rad, turns_rad, first, slack, late_s) < threshold_rad for late_s in _LATENCIES_S
    )


def _drift_rad(
    times_s: Sequence[float],
    headings_rad: Sequence[float],
    turns_rad: Sequence[float],
    first: int,
    slack: tuple[float, float],
    late_s: float,
) -> float:
    """The largest sum of Page's test at the end, with turns that are late, too."""
    slack_radps, share = slack
    cusum, then, before_rad = ScalarCusum(), 0, 0.0
    for i in range(first, len(times_s)):
        t_s = times_s[i] - late_s
        while then + 1 < i and times_s[then + 1] <= t_s:
            then += 1
        passed_s = times_s[then + 1] - times_s[then] if then < i else 0.0
        part = min(max((t_s - times_s[then]) / passed_s, 0.0), 1.0) if passed_s > 0.0 else 0.0
        turn_rad = turns_rad[then] + part * (turns_rad[then + 1] - turns_rad[then]) if part > 0.0 else turns_rad[then]
        if i > first:
            step_rad = headings_rad[i] - headings_rad[i - 1] - (turn_rad - before_rad)
            turned_rad = abs(turns_rad[i] - turns_rad[i - 1])
            slack_rad = (times_s[i] - times_s[i - 1]) * slack_radps + share * turned_rad
            cusum.update(times_s[i], step_rad, slack_rad)
        before_rad = turn_rad
    return cusum.largest
