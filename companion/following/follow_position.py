"""The follow position: where the boat keeps relative to the leader, by parameters or as commanded under way."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.events import EventLog
from companion.following.kept_distance import KeptDistance
from companion.params.store import Parameters

_NOTABLE_M = 0.5  # by which another distance is kept than asked for
_NAMES = ("FLW_TGT_DST", "FLW_TGT_FA")


class FollowPosition:
    """`now` is the follow position in force. Remembers a commanded one until the next command, until the boat is
    disarmed, or until FLW_TGT_DST or FLW_TGT_FA is set, and what was announced last."""

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._parameters = parameters
        self._kept = KeptDistance(config, parameters)
        self._events = events
        self._commanded: tuple[float, float] | None = None
        self._told: tuple[tuple[float, float], float, float] | None = None
        parameters.on_change(lambda name, _value: self.drop() if name in _NAMES else None)

    @property
    def now(self) -> tuple[float, float]:
        """(distance_m, bearing_rad in the leader's frame: π astern, 0 ahead, positive to starboard)."""
        if self._commanded is not None:
            return self._commanded
        return self._parameters["FLW_TGT_DST"], wrap_pi(math.radians(self._parameters["FLW_TGT_FA"]))

    def command(self, bearing_rad: float | None, distance_m: float | None, now_s: float) -> Outcome:
        """Another follow position; None keeps the present value. DENIED, with an event, where it is out of range."""
        kept_m, kept_rad = self.now
        bearing_rad = kept_rad if bearing_rad is None else bearing_rad
        distance_m = kept_m if distance_m is None else distance_m
        if not math.isfinite(bearing_rad) or abs(bearing_rad) > 2.0 * math.pi + 1e-6:
            return self._refuse("give -360 to 360 deg", now_s)
        spec = self._parameters.spec("FLW_TGT_DST")
        assert spec is not None
        if not spec.minimum <= distance_m <= spec.maximum:
            return self._refuse(f"give {spec.minimum:g} to {spec.maximum:g} m", now_s)
        if distance_m < self._parameters["FOLL_MIN_DIST"]:
            return self._refuse(f"FOLL_MIN_DIST is {self._parameters['FOLL_MIN_DIST']:g} m", now_s)
        self._commanded = distance_m, wrap_pi(bearing_rad)
        self._tell(now_s)
        return ACCEPTED

    def update(self, following: bool, now_s: float) -> None:
        """Announce a follow position that parameters have changed."""
        if following and self._told is not None and self._told != self._state:
            self._tell(now_s)
        self._told = self._state

    @property
    def text(self) -> str:
        """For people, with what keeps the boat further away."""
        asked_m, least_m, kept_m = self.now[0], self._parameters["FOLL_MIN_DIST"], self._kept.of(self.now)
        if asked_m < least_m:
            return f"{_text(self.now)}, but FOLL_MIN_DIST is {least_m:g} m"
        return _text(self.now) + (f", but {kept_m:.0f} m is kept" if asked_m < kept_m - _NOTABLE_M else "")

    def drop(self) -> None:
        """Back to the parameters."""
        self._commanded = None

    @property
    def _state(self) -> tuple[tuple[float, float], float, float]:
        return self.now, self._parameters["FOLL_MIN_DIST"], self._kept.of(self.now)

    def _tell(self, now_s: float) -> None:
        self._events.say(now_s, TextKind.ROUTINE, "station", f"Follow position: {self.text}")
        self._told = self._state

    def _refuse(self, reason: str, now_s: float) -> Outcome:
        text = f"Follow position refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(Result.DENIED, text)


def _text(position: tuple[float, float]) -> str:
    distance_m, bearing_rad = position
    bearing_deg = round(math.degrees(bearing_rad))
    if abs(bearing_deg) in (0, 180):
        return f"{distance_m:.0f} m {'astern' if bearing_deg else 'ahead'}"
    return f"{distance_m:.0f} m at {abs(bearing_deg)} deg to {'starboard' if bearing_deg > 0 else 'port'}"
