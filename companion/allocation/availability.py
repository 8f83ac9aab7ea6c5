"""Which thrusters can be counted on: what their boards report, what they do against what they are told, and whether they are down."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

from companion.allocation.supervision import FeedbackSupervision, ThrusterFault, Tolerances
from companion.config import ThrusterConfig, VesselConfig
from companion.core.types import ActuatorCommand, Condition, Deployment, Severity, ThrusterFeedback
from companion.params import Parameters

_STALE_S = 0.5  # a report older than this says nothing of the present command
_TRAVELS = 2.0  # times of travel, and a second, after which a thruster that has not arrived is jammed
_LEFT_OUT = "left out of the allocation"

Say = Callable[[float, Severity, str, str], None]


class Availability:
    """`update(…)` once a tick → whether a condition has changed. `conditions` is of every thruster, `up` the indices of those that retract and
    are not down; changes are said.

    A thruster fails when its board reports so, until it reports it well; by supervision of its feedback (THR_WATCH), which says itself when it is
    over; or when it is told to be down and does not arrive. It is not down from the moment at which it is told to go up.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, say: Say) -> None:
        self._parameters = parameters
        self._tolerances = self._read_tolerances()
        parameters.on_change(self._parameter_changed)
        self._thrusters = tuple(_Thruster(t, i, say) for i, t in enumerate(config.thrusters))
        self.conditions: tuple[Condition, ...] = ()
        self.up: frozenset[int] = frozenset()

    def update(
        self, feedback: Sequence[ThrusterFeedback | None], command: ActuatorCommand | None, lower: bool | None, silent: Collection[str], now_s: float
    ) -> bool:
        """`feedback`: the newest of each thruster; `command`: the last that went to the bridges; `lower`: where retractable thrusters are
        to go from now on; `silent`: names of the bridges that are not well."""
        conditions = tuple([t.update(feedback[i], command, lower, silent, self._tolerances, now_s) for i, t in enumerate(self._thrusters)])
        if conditions == self.conditions:
            return False
        self.conditions = conditions
        self.up = frozenset(i for i, condition in enumerate(conditions) if condition in (Condition.RETRACTED, Condition.MOVING))
        return True

    def _parameter_changed(self, name: str, value: float) -> None:
        if name.startswith("THR_"):
            self._tolerances = self._read_tolerances()

    def _read_tolerances(self) -> Tolerances | None:
        parameters = self._parameters
        if not parameters["THR_WATCH"]:
            return None
        return Tolerances(
            parameters["THR_TOL"], math.radians(parameters["THR_TOL_AZ"]), parameters["THR_LAG"], parameters["THR_FAIL_T"], parameters["THR_RETRY_T"]
        )


class _Thruster:
    """One of them. Remembers what was last said of it, and since when it has been told to go where it goes."""

    def __init__(self, config: ThrusterConfig, index: int, say: Say) -> None:
        self._config = config
        self._index = index
        self._say = say
        self._supervision = FeedbackSupervision(config)
        self._ok = True
        self._fault: ThrusterFault | None = None
        self._deployment: Deployment | None = None
        self._lower: bool | None = None
        self._told_s = 0.0
        self._late = self._jammed = False

    def update(
        self,
        report: ThrusterFeedback | None,
        command: ActuatorCommand | None,
        lower: bool | None,
        silent: Collection[str],
        tolerances: Tolerances | None,
        now_s: float,
    ) -> Condition:
        ok = report is None or report.ok
        if ok != self._ok:
            self._ok = ok
            self._tell_reported(ok, now_s)
        if tolerances is not None and command is not None:
            fresh = report is not None and ok and now_s - report.t_s <= _STALE_S and report.source not in silent
            fault = self._supervision.update(command.thrusters[self._index], command.armed, report if fresh else None, tolerances, now_s)
        else:
            fault = None
        if fault is not self._fault:
            self._tell_fault(fault, now_s)
            self._fault = fault
        placed = self._placed(report, lower, now_s) if self._config.retractable else Condition.READY
        return Condition.FAILED if self._jammed or fault is not None or not ok else placed

    def _placed(self, report: ThrusterFeedback | None, lower: bool | None, now_s: float) -> Condition:
        """By its report, else by the time since it was told."""
        if lower is not self._lower:
            self._lower, self._told_s = lower, now_s
        deployment = None if report is None else report.deployment
        arrived = now_s - self._told_s >= self._config.travel_s
        if deployment is None and lower is not None:
            deployment = Deployment.MOVING if not arrived else Deployment.LOWERED if lower else Deployment.RETRACTED
        if deployment is not self._deployment:
            self._tell_deployment(deployment, lower, now_s)
            self._deployment = deployment
        self._mind_travel(deployment, lower, now_s)
        if deployment is Deployment.LOWERED:
            return Condition.MOVING if lower is False else Condition.READY
        return Condition.MOVING if deployment is Deployment.MOVING else Condition.RETRACTED

    def _mind_travel(self, deployment: Deployment | None, lower: bool | None, now_s: float) -> None:
        there = lower is None or deployment is (Deployment.LOWERED if lower else Deployment.RETRACTED)
        late = not there and now_s - self._told_s > _TRAVELS * self._config.travel_s + 1.0
        if late and not self._late:
            severity, what = (Severity.CRITICAL, f"down: {_LEFT_OUT}") if lower else (Severity.WARNING, "up")
            self._say(now_s, severity, f"retraction_{self._config.name}", f"Thruster {self._config.name} does not go {what}")
        self._late, self._jammed = late, late and lower is True

    def _tell_deployment(self, deployment: Deployment | None, lower: bool | None, now_s: float) -> None:
        if self._deployment is None or deployment is None:
            return  # how it is found is no change
        way = "is on its way down" if lower else "is on its way up" if lower is False else "is neither down nor up"
        text = {Deployment.LOWERED: "is down", Deployment.RETRACTED: "is up", Deployment.MOVING: way}[deployment]
        self._say(now_s, Severity.NOTICE, f"retraction_{self._config.name}", f"Thruster {self._config.name} {text}")

    def _tell_reported(self, ok: bool, now_s: float) -> None:
        name = self._config.name
        severity, state = (Severity.NOTICE, "runs again") if ok else (Severity.CRITICAL, f"does not run: {_LEFT_OUT}")
        self._say(now_s, severity, f"thruster_{name}", f"Thruster {name} {state}")

    def _tell_fault(self, fault: ThrusterFault | None, now_s: float) -> None:
        event, name = f"thruster_{self._config.name}", f"Thruster {self._config.name}"
        if fault is None:
            stuck, runaway = self._fault is ThrusterFault.STUCK, self._fault is ThrusterFault.RUNAWAY
            over = "follows again" if stuck else "stands still again" if runaway else "is tried again"
            self._say(now_s, Severity.NOTICE, event, f"{name} {over}")
        elif fault is ThrusterFault.RUNAWAY:
            self._say(now_s, Severity.ALERT, event, f"{name} {fault.value}: cut power")  # short: within one STATUSTEXT
        else:
            self._say(now_s, Severity.CRITICAL, event, f"{name}: {fault.value}: {_LEFT_OUT}")
