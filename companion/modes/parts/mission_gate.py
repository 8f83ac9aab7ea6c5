"""The gate of a mission's condition: what comes behind CONDITION_DELAY or CONDITION_DISTANCE waits until it is met."""

from __future__ import annotations

from companion.core.decision import ModeInputs
from companion.core.geodesy import distance_and_bearing
from companion.mission.executor import MissionExecutor
from companion.mission.tasks import Action, DoCondition


class MissionGate:
    """Remembers the gate that is closed now, and since when it is watched."""

    def __init__(self, executor: MissionExecutor) -> None:
        self._executor = executor
        self._gate: DoCondition | None = None
        self._since_s = 0.0

    def restart(self) -> None:
        """A delay counts anew from the next call."""
        self._gate = None

    def mind(self, inputs: ModeInputs) -> list[Action]:
        """Open the gate of a condition once it is met; returns what came free. A delay counts from the first call, and
        again after a pause."""
        freed: list[Action] = []
        while (gate := self._executor.gate) is not None:
            if gate != self._gate:
                self._gate, self._since_s = gate, inputs.now_s
            if not self._is_met(gate, inputs):
                break
            freed += self._executor.open_gate()
        return freed

    def _is_met(self, gate: DoCondition, inputs: ModeInputs) -> bool:
        if gate.delay_s is not None:
            return inputs.now_s - self._since_s >= gate.delay_s
        place = self._executor.next_place
        if place is None or gate.distance_m is None:
            return True
        away_m, _ = distance_and_bearing(inputs.nav.lat_deg, inputs.nav.lon_deg, place[1], place[2])
        return away_m <= gate.distance_m
