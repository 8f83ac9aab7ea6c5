"""Retractable thrusters: when they must be down, and what the boat lacks while they are up."""

from __future__ import annotations

import math

from companion.allocation.geometry import thrusters_of
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.events import EventLog
from companion.core.readings import RcInput
from companion.modes.mode import Mode
from companion.params.store import Parameters
from companion.positioning.consequence import is_met
from companion.supervisor.helm import Helm

_SWITCH = 0.5  # a switch beyond this is on one side
_HALVINGS = 5


class Retraction:
    """`update(rc, now_s)` once a tick, after modes have changed; then `lower` says whether the thrusters must be down.

    In a mode that allocates, an armed boat has them down at any speed: it may have to stop or hold without warning, and
    the travel takes seconds. In Manual, and disarmed, the operator moves them by command or by a switch of the
    transmitter; nothing moves by itself. Remembers the demand, the switch and when it was heard, which thrusters are
    `up`, and in which mode that was announced.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, helm: Helm, events: EventLog) -> None:
        self._config = config
        self._parameters = parameters
        self._helm = helm
        self._events = events
        self._retractable = frozenset(i for i, t in enumerate(config.thrusters) if t.retractable)
        self._switch: bool | None = None
        self._heard_s = -math.inf  # of the transmitter
        self._said_in: Mode | None = None
        self._sway_left: dict[frozenset[int], float] = {}
        self.lower: bool | None = None
        self.up: frozenset[int] = frozenset()

    def request(self, lower: bool, now_s: float) -> Outcome:
        """Lower or retract, as an operator asks."""
        if not self._retractable:
            return self._refuse(
                Result.DENIED,
                f"{'Lower' if lower else 'Retract'} refused: no retractable thruster",
                now_s,
            )
        if not lower and self._needed:
            return self._refuse(
                Result.TEMPORARILY_REJECTED,
                f"Retract refused: {self._helm.mode.id.value} needs it; choose Manual",
                now_s,
            )
        self.lower = lower
        return ACCEPTED

    def update(self, rc: RcInput | None, now_s: float) -> None:
        """Read the transmitter's switch; lower the thrusters if the active mode needs them."""
        if self._retractable:
            self._read_switch(rc, now_s)
            if self._needed:
                self.lower = True

    def see(self, up: frozenset[int], now_s: float) -> None:
        """Which are not down in this cycle. While armed, announces once in each mode what the boat lacks."""
        self.up = up
        helm = self._helm
        if not up or not helm.armed:
            self._said_in = None
        elif self._said_in is not helm.mode:
            self._said_in = helm.mode
            names = " and ".join(self._config.thrusters[i].name for i in sorted(up))
            self._events.say(
                now_s, TextKind.ATTENTION, "thruster_up", f"{helm.mode.id.value}: {names} not down, {self._lack(up)}"
            )

    @property
    def _needed(self) -> bool:
        return self._helm.armed and self._helm.mode.declaration.allocates

    def _read_switch(self, rc: RcInput | None, now_s: float) -> None:
        """A switch acts when it is moved, not by its position at the start, or after a silence of the transmitter."""
        if rc is None or rc.lost or rc.t_s <= self._heard_s:
            if now_s - self._heard_s > self._parameters["COM_RC_LOSS_T"]:
                self._switch = None
            return
        self._heard_s = rc.t_s
        channel = int(self._parameters["MAN_RC_LOWER_CH"])
        if not 1 <= channel <= len(rc.channels) or not abs(rc.channels[channel - 1]) >= _SWITCH:
            return
        thrown = rc.channels[channel - 1] > 0.0
        if self._switch is not None and thrown != self._switch:
            self.request(thrown, now_s)
        self._switch = thrown

    def _lack(self, up: frozenset[int]) -> str:
        """The sideways force that is left while the boat is not to turn."""
        most_n = self._config.limits.sway_n
        if most_n <= 0.0:
            return "less thrust"
        if up not in self._sway_left:
            self._sway_left[up] = _sway_left_n(self._config, up)
        left_n = self._sway_left[up]
        return "all sideways force left" if left_n >= most_n else f"sideways at most {left_n:.0f} of {most_n:.0f} N"

    def _refuse(self, result: Result, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(result, text)


def _sway_left_n(config: VesselConfig, out: frozenset[int]) -> float:
    """The largest sideways force, N, without surge and yaw, that the thrusters other than `out` give, up to the
    limit."""
    thrusters, limits = thrusters_of(config), config.limits
    scales = (limits.surge_n, limits.sway_n, limits.yaw_nm)
    if is_met(thrusters, scales, Wrench(0.0, limits.sway_n, 0.0), out):
        return limits.sway_n
    low_n, high_n = 0.0, limits.sway_n
    for _ in range(_HALVINGS):
        middle_n = 0.5 * (low_n + high_n)
        met = is_met(thrusters, scales, Wrench(0.0, middle_n, 0.0), out)
        low_n, high_n = (middle_n, high_n) if met else (low_n, middle_n)
    return low_n
