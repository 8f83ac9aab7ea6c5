"""One report of a thruster out of what its bridges say."""

from __future__ import annotations

from companion.allocation.feedback import ThrusterReports
from companion.allocation.supervision import FeedbackSupervision, ThrusterFault, Tolerances
from companion.config.vessel import find, load
from companion.core.actuation import Deployment, ThrusterCommand, ThrusterFeedback

STERN = load(find("revolt")).thrusters[0]
TOLERANCES = Tolerances(0.2, 0.3, 1.0, 2.0, 0.0)


def propeller(t_s: float, ok: bool = True) -> ThrusterFeedback:
    return ThrusterFeedback(t_s, "board", 0, 0.4, None, ok, Deployment.LOWERED)


def azimuth(t_s: float, ok: bool = True) -> ThrusterFeedback:
    return ThrusterFeedback(t_s, "drives", 0, None, 1.2, ok)


def test_the_report_of_a_single_bridge() -> None:
    reports = ThrusterReports(2)
    report = ThrusterFeedback(1.0, "board", 1, 0.4, 0.3)
    reports.take(report)
    assert reports.newest == [None, report] and reports.newest[1] is report


def test_two_bridges_each_give_their_part() -> None:
    for order in ((propeller(5.0), azimuth(5.1)), (azimuth(5.0), propeller(5.1))):
        reports = ThrusterReports(1)
        for report in order:
            reports.take(report)
        assert reports.newest == [ThrusterFeedback(5.1, order[1].source, 0, 0.4, 1.2, True, Deployment.LOWERED)]


def test_an_old_part_is_left_out_and_one_fault_counts_for_the_thruster() -> None:
    reports = ThrusterReports(1)
    reports.take(azimuth(1.0))
    reports.take(propeller(1.6))
    (newest,) = reports.newest
    assert newest is not None and (newest.throttle, newest.azimuth_rad, newest.ok) == (0.4, None, True)
    reports.take(azimuth(1.7, ok=False))
    (newest,) = reports.newest
    assert newest is not None and (newest.throttle, newest.azimuth_rad, newest.ok) == (0.4, 1.2, False)
    reports.take(propeller(9.0))
    assert reports.newest[0] is not None and not reports.newest[0].ok, "the failed bridge has not reported a recovery"


def test_supervision_uses_only_measured_parts() -> None:
    supervision, fault = FeedbackSupervision(STERN), None
    for k in range(100):
        report = ThrusterFeedback(0.1 * k, "drives", 0, None, 1.2)
        fault = supervision.update(ThrusterCommand(20.0, 0.9, 0.0), True, report, TOLERANCES, 0.1 * k)
        if fault is not None:
            break
    assert fault is ThrusterFault.STUCK, "by its azimuth alone, whatever its propeller does"
    for k in range(100):
        report = ThrusterFeedback(0.1 * k, "drives", 0, None, 0.0)
        assert (
            FeedbackSupervision(STERN).update(ThrusterCommand(20.0, 0.9, 0.0), True, report, TOLERANCES, 0.1 * k)
            is None
        )
