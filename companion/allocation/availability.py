"""Condition of each thruster: by the report of its board, by its feedback against its command, and by its position if
it retracts."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from companion.allocation.motor_current import CurrentSupervision, LoadFault
from companion.allocation.supervision import FeedbackSupervision, ThrusterFault, Tolerances
from companion.allocation.turn_rate import TurnRate
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import (
    ActuatorCommand,
    Deployment,
    ThrusterCommand,
    ThrusterCondition,
    ThrusterFeedback,
)
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.params.store import Parameters

_STALE_S = 0.5  # an older report does not show the effect of the present command
_TRAVELS = 2.0  # travel times, and a second, after which a thruster that has not arrived is jammed


class Availability:
    """`conditions`: that of every thruster; `up`: indices of those that retract and are not lowered. Changes are
    announced.

    A thruster has failed while its board reports so, while the supervision of its feedback or of its motor's current
    finds a fault (THR_WATCH), or if it is ordered down and does not arrive. From the order to retract on, it does not
    count as lowered.

    What turns slower than the vessel's file says is supervised at the rate that its reports show; `take_turn_rates`
    tells it.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, say: Announce) -> None:
        self._parameters = parameters
        self._tolerances = self._read_tolerances()
        parameters.on_change(self._parameter_changed)
        self._thrusters = tuple(_Thruster(t, i, say) for i, t in enumerate(config.thrusters))
        self.conditions: tuple[ThrusterCondition, ...] = ()
        self.up: frozenset[int] = frozenset()

    def update(
        self,
        feedback: Sequence[ThrusterFeedback | None],
        command: ActuatorCommand | None,
        lower: bool | None,
        silent: Collection[str],
        now_s: float,
    ) -> bool:
        """Call once a tick; returns whether a condition has changed. `feedback`: the newest of each thruster;
        `command`: the last one sent to the bridges; `lower`: the order to the retractable thrusters (None: none);
        `silent`: names of the bridges that do not answer."""
        conditions = tuple(
            [
                t.update(feedback[i], command, lower, silent, self._tolerances, now_s)
                for i, t in enumerate(self._thrusters)
            ]
        )
        if conditions == self.conditions:
            return False
        self.conditions = conditions
        self.up = frozenset(
            i
            for i, condition in enumerate(conditions)
            if condition in (ThrusterCondition.RETRACTED, ThrusterCondition.MOVING)
        )
        return True

    def take_turn_rates(self) -> list[tuple[int, float]]:
        """(index, rad/s) of the thrusters whose rate of turn has changed since the last call."""
        rates = ((i, thruster.take_turn_radps()) for i, thruster in enumerate(self._thrusters))
        return [(i, rate_radps) for i, rate_radps in rates if rate_radps is not None]

    def _parameter_changed(self, name: str, value: float) -> None:
        if name.startswith("THR_"):
            self._tolerances = self._read_tolerances()

    def _read_tolerances(self) -> Tolerances | None:
        parameters = self._parameters
        if not parameters["THR_WATCH"]:
            return None
        return Tolerances(
            parameters["THR_TOL"],
            math.radians(parameters["THR_TOL_AZ"]),
            parameters["THR_LAG"],
            parameters["THR_FAIL_T"],
            parameters["THR_RETRY_T"],
            parameters["THR_TOL_CUR"],
            bool(parameters["THR_LEARN_AZ"]),
        )


class _Thruster:
    """One thruster. Remembers what was last announced of it, and the order to lower or retract with its time."""

    def __init__(self, config: ThrusterConfig, index: int, say: Announce) -> None:
        self._config = config
        self._index = index
        self._say = say
        self._supervision = FeedbackSupervision(config)
        self._turn = TurnRate(config.azimuth_rate_radps) if config.turns else None
        self._new_turn_radps: float | None = None
        self._said_slow = self._armed = False
        self._current = None if config.full_a is None else CurrentSupervision(config.full_a)
        self._ok = True
        self._fault: ThrusterFault | LoadFault | None = None
        self._deployment: Deployment | None = None
        self._lower: bool | None = None
        self._ordered_s = 0.0
        self._late = self._jammed = False

    def update(
        self,
        report: ThrusterFeedback | None,
        command: ActuatorCommand | None,
        lower: bool | None,
        silent: Collection[str],
        tolerances: Tolerances | None,
        now_s: float,
    ) -> ThrusterCondition:
        """The thruster's condition in this tick; announces each change."""
        ok = report is None or report.ok
        if ok != self._ok:
            self._ok = ok
            self._announce_reported(ok, now_s)
        if tolerances is not None and command is not None:
            fresh = report is not None and ok and now_s - report.t_s <= _STALE_S and report.source not in silent
            fault = self._supervise(command, report if fresh else None, tolerances, now_s)
        else:
            fault = None
        if fault is not self._fault:
            self._announce_fault(fault, now_s)
            self._fault = fault
        placed = self._placed(report, lower, now_s) if self._config.retractable else ThrusterCondition.READY
        return ThrusterCondition.FAILED if self._jammed or fault is not None or not ok else placed

    def _supervise(
        self, command: ActuatorCommand, report: ThrusterFeedback | None, tolerances: Tolerances, now_s: float
    ) -> ThrusterFault | LoadFault | None:
        """What its feedback tells, or else its motor's current."""
        demand, armed = command.thrusters[self._index], command.armed
        self._see_turn(demand, armed, report if tolerances.learns_turns else None, now_s)
        fault = self._supervision.update(demand, armed, report, tolerances, now_s)
        if self._current is None:
            return fault
        times_s = tolerances.lag_s, tolerances.after_s, tolerances.retry_s
        current_a = None if report is None else report.current_a
        load = self._current.update(demand.throttle, armed, current_a, tolerances.current, times_s, now_s)
        return fault or load

    def _see_turn(self, demand: ThrusterCommand, armed: bool, report: ThrusterFeedback | None, now_s: float) -> None:
        """Learn how fast it turns, anew at each arming."""
        turn, was_armed = self._turn, self._armed
        self._armed = armed
        if turn is None:
            return
        if armed and not was_armed:
            turn.begin_anew()
            self._turn_at(turn.rate_radps)
            self._said_slow = False
        if not armed or report is None or demand.azimuth_rad is None or report.azimuth_rad is None:
            return
        if turn.update(demand.azimuth_rad, report.azimuth_rad, report.t_s):
            self._turn_at(turn.rate_radps)
        if turn.slow and not self._said_slow:
            self._said_slow = True
            rate, configured = math.degrees(turn.rate_radps), math.degrees(self._config.azimuth_rate_radps)
            text = f"Thruster {self._config.name} turns at {rate:.0f} of {configured:.0f} deg/s"
            self._say(now_s, TextKind.ATTENTION, f"turn_rate_{self._config.name}", text)

    def _turn_at(self, rate_radps: float) -> None:
        self._supervision.turns_at(rate_radps)
        self._new_turn_radps = rate_radps

    def take_turn_radps(self) -> float | None:
        """The rate of turn, where it has changed since the last call."""
        rate_radps, self._new_turn_radps = self._new_turn_radps, None
        return rate_radps

    def _placed(self, report: ThrusterFeedback | None, lower: bool | None, now_s: float) -> ThrusterCondition:
        """Its condition by the reported position, or by the time since the order."""
        if lower is not self._lower:
            self._lower, self._ordered_s = lower, now_s
        deployment = None if report is None else report.deployment
        arrived = now_s - self._ordered_s >= self._config.travel_s
        if deployment is None and lower is not None:
            deployment = Deployment.MOVING if not arrived else Deployment.LOWERED if lower else Deployment.RETRACTED
        if deployment is not self._deployment:
            self._announce_deployment(deployment, lower, now_s)
            self._deployment = deployment
        self._check_travel(deployment, lower, now_s)
        if deployment is Deployment.LOWERED:
            return ThrusterCondition.MOVING if lower is False else ThrusterCondition.READY
        return ThrusterCondition.MOVING if deployment is Deployment.MOVING else ThrusterCondition.RETRACTED

    def _check_travel(self, deployment: Deployment | None, lower: bool | None, now_s: float) -> None:
        there = lower is None or deployment is (Deployment.LOWERED if lower else Deployment.RETRACTED)
        late = not there and now_s - self._ordered_s > _TRAVELS * self._config.travel_s + 1.0
        if late and not self._late:
            kind, what = (TextKind.ALARM, "lower: not used") if lower else (TextKind.ATTENTION, "retract")
            self._say(now_s, kind, f"retraction_{self._config.name}", f"Thruster {self._config.name} does not {what}")
        self._late, self._jammed = late, late and lower is True

    def _announce_deployment(self, deployment: Deployment | None, lower: bool | None, now_s: float) -> None:
        if self._deployment is None or deployment is None:
            return  # the first position is not a change
        way = "is being lowered" if lower else "is being retracted" if lower is False else "is between up and down"
        text = {Deployment.LOWERED: "is lowered", Deployment.RETRACTED: "is retracted", Deployment.MOVING: way}[
            deployment
        ]
        self._say(now_s, TextKind.ROUTINE, f"retraction_{self._config.name}", f"Thruster {self._config.name} {text}")

    def _announce_reported(self, ok: bool, now_s: float) -> None:
        name = self._config.name
        kind, state = (TextKind.ROUTINE, "works again") if ok else (TextKind.ALARM, "failed: not used")
        self._say(now_s, kind, f"thruster_{name}", f"Thruster {name} {state}")

    def _announce_fault(self, fault: ThrusterFault | LoadFault | None, now_s: float) -> None:
        event, name = f"thruster_{self._config.name}", f"Thruster {self._config.name}"
        if fault is None:
            stuck, runaway = self._fault is ThrusterFault.STUCK, self._fault is ThrusterFault.RUNAWAY
            over = "follows again" if stuck else "has stopped" if runaway else "is tried again"
            self._say(now_s, TextKind.ROUTINE, event, f"{name} {over}")
        elif fault is ThrusterFault.RUNAWAY:
            self._say(now_s, TextKind.DANGER, event, f"{name} {fault.value}: cut power")
        else:
            self._say(now_s, TextKind.ALARM, event, f"{name} not used: {fault.value}")
