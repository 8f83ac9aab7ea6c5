"""The reports of all bridges as one report for each thruster: its throttle may come from one bridge and its azimuth
from another."""

from __future__ import annotations

from dataclasses import replace

from companion.core.actuation import ThrusterFeedback

_STALE_S = 0.5  # a part of a report that is older than the newest by more is not used


class ThrusterReports:
    """`newest`: one report for each thruster, None before the first.

    Each part comes from the newest report that has it; a thruster is ok if all its bridges report so.
    """

    def __init__(self, thrusters: int) -> None:
        self.newest: list[ThrusterFeedback | None] = [None] * thrusters
        self._by_source: tuple[dict[str, ThrusterFeedback], ...] = tuple({} for _ in range(thrusters))

    def take(self, report: ThrusterFeedback) -> None:
        """Take a report in order of arrival."""
        reports = self._by_source[report.index]
        reports[report.source] = report
        self.newest[report.index] = report if len(reports) == 1 else _joined(report, reports)


def _joined(newest: ThrusterFeedback, reports: dict[str, ThrusterFeedback]) -> ThrusterFeedback:
    throttle, azimuth_rad, deployment, ok = newest.throttle, newest.azimuth_rad, newest.deployment, True
    current_a = newest.current_a
    for report in reports.values():
        ok = ok and report.ok
        deployment = report.deployment if deployment is None else deployment
        if newest.t_s - report.t_s <= _STALE_S:
            throttle = report.throttle if throttle is None else throttle
            azimuth_rad = report.azimuth_rad if azimuth_rad is None else azimuth_rad
            current_a = report.current_a if current_a is None else current_a
    return replace(
        newest, throttle=throttle, azimuth_rad=azimuth_rad, deployment=deployment, ok=ok, current_a=current_a
    )
