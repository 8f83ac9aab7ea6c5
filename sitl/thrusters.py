"""Thrusters: force curve, limits and dead band, lag of the force, rate of turn, time to go up and down."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import NozzleConfig, ThrusterConfig
from companion.core.actuation import Deployment
from companion.core.angles import TWO_PI, wrap_pi

_RUNAWAY_SHARE, _FOULED_SHARE = 0.5, 0.1  # of full force; of the force
_FOULED_LOAD, _BLOCKED_LOAD = 3.0, 2.0  # times the current; of the full current at full throttle (both assumed)


class ThrusterModel:
    """One thruster. In: throttle −1 to 1 and azimuth; out: `force_n` along `azimuth_rad`; `asked` is the throttle.

    Target force: K u|u| with K by sign, within [min_n, max_n], 0 in the dead band. The force follows it with a
    first-order lag. An endless azimuth turns the shorter way at its rate. One with stops goes to the demanded
    direction's nearest turn within them. A retractable thruster is `down` from 0 (up) to 1, at first 1, and gives
    nothing below 1.

    Faults: `dead` gives nothing and does not turn, and its board reports it. The board does not report the others:
    `stalled` gives nothing, `stuck` does not turn, `runaway` runs ahead whatever the command, `jammed` moves neither up
    nor down, `reversed` pushes the other way, `fouled` turns as commanded and gives a tenth of the force. The motor's
    current shows a `dead`, a `stalled` (blocked) and a `fouled` one, to a board that measures it.
    """

    __slots__ = (
        "_ahead_n",
        "_astern_n",
        "_azimuth_rate_radps",
        "_config",
        "_dt_s",
        "_endless",
        "_gear_rad",
        "_gear_share",
        "_lag_s",
        "_least_n",
        "_most_n",
        "_retractable",
        "_share",
        "_target_n",
        "_target_rad",
        "_turns",
        "_x_m",
        "_y_m",
        "asked",
        "azimuth_lag_s",
        "azimuth_rad",
        "backlash_rad",
        "dead",
        "down",
        "force_n",
        "fouled",
        "jammed",
        "lag_on_revolutions",
        "lower",
        "reversed",
        "runaway",
        "stalled",
        "stuck",
    )

    def __init__(self, config: ThrusterConfig, lag_s: float, x_m: float | None = None) -> None:
        self._config = config
        self._ahead_n, self._astern_n = config.ahead_n, config.astern_n
        self._least_n, self._most_n = config.min_n, config.max_n
        self._azimuth_rate_radps, self._retractable = config.azimuth_rate_radps, config.retractable
        self._lag_s = lag_s
        self._dt_s, self._share, self._gear_share = 0.0, 0.0, 0.0  # share of the way to the target in a step of dt_s
        self._endless = config.azimuth_min_rad is None and config.azimuth_max_rad is None
        self._x_m = config.x_m if x_m is None else x_m
        self._y_m = config.y_m
        self._turns = config.turns
        self._target_n = 0.0
        self.azimuth_rad = config.azimuth_rad  # can exceed one turn where there are stops
        self._target_rad = config.azimuth_rad
        self._gear_rad = config.azimuth_rad
        self.azimuth_lag_s = self.backlash_rad = 0.0  # of a drive that is worse than the file says
        self.lag_on_revolutions = False  # True: they follow with the lag, and thrust goes with their square
        self.force_n = 0.0
        self.asked = 0.0
        self.down = 1.0
        self.lower: bool | None = None  # commanded direction of travel; None: stay
        self.dead = self.stalled = self.stuck = self.runaway = self.jammed = self.reversed = self.fouled = False

    @property
    def config(self) -> ThrusterConfig:
        """As the vessel's file has it."""
        return self._config

    @property
    def max_n(self) -> float:
        """The largest force in either direction."""
        return max(self._most_n, -self._least_n)

    def demand(self, throttle: float, azimuth_rad: float | None) -> None:
        """Set throttle and azimuth; None keeps the azimuth demanded before."""
        self.drive(throttle)
        if azimuth_rad is not None:
            self.aim(azimuth_rad)

    def drive(self, throttle: float) -> None:
        """Set the throttle."""
        config = self._config
        u = self.asked = min(max(throttle, -1.0), 1.0)
        if abs(u) < config.dead_band:
            u = 0.0
        force_n = (config.ahead_n if u >= 0.0 else config.astern_n) * u * abs(u)
        self._target_n = min(max(force_n, config.min_n), config.max_n)

    def aim(self, azimuth_rad: float) -> None:
        """Set the azimuth."""
        if self._turns:
            self._target_rad = self._reachable(azimuth_rad)

    def step(self, dt_s: float, surge_mps: float = 0.0, sway_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> None:
        """Advance by `dt_s`. The velocity of the boat through the water counts for jets and rudders only."""
        target_n = self._target_n if not self.runaway else _RUNAWAY_SHARE * self._most_n
        if self.reversed:
            target_n = min(max(-target_n, self._least_n), self._most_n)
        if self._retractable and not self.jammed:
            self._travel(dt_s)
        if self.dead or self.stalled or self.down < 1.0:
            target_n = 0.0
        if dt_s != self._dt_s:
            self._dt_s = dt_s
            self._share = _way_in(dt_s, self._lag_s)
            self._gear_share = _way_in(dt_s, self.azimuth_lag_s)
        if self.lag_on_revolutions:
            self._spin(target_n)
        else:
            self.force_n = self.force_n + (target_n - self.force_n) * self._share if self._lag_s > 0.0 else target_n
        if self._turns and not (self.dead or self.stuck):
            self._turn(dt_s)

    def _spin(self, target_n: float) -> None:
        """Bring the revolutions nearer to those of the force."""
        now = self._throttle_of(self.force_n)
        u = now + (self._throttle_of(target_n) - now) * self._share
        self.force_n = (self._ahead_n if u >= 0.0 else self._astern_n) * u * abs(u)

    def wrench(self) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) on the hull: τ = [cos α, sin α, lx sin α − ly cos α]ᵀ F."""
        force_n = self.given_n if self.fouled else self.force_n
        x_n, y_n = force_n * math.cos(self.azimuth_rad), force_n * math.sin(self.azimuth_rad)
        return x_n, y_n, self._x_m * y_n - self._y_m * x_n

    @property
    def given_n(self) -> float:
        """The force that the water takes: less than the motor's where the propeller is fouled."""
        return _FOULED_SHARE * self.force_n if self.fouled else self.force_n

    @property
    def target_n(self) -> float:
        """The force that it goes to."""
        return self._target_n

    def throttle(self) -> float:
        """The throttle that gives the present force."""
        return self._throttle_of(self.force_n)

    def _throttle_of(self, force_n: float) -> float:
        curve_n = self._ahead_n if force_n >= 0.0 else self._astern_n
        return math.copysign(math.sqrt(abs(force_n) / curve_n), force_n)

    def current_a(self, full_a: float) -> float:
        """What the motor draws, of `full_a` at full throttle: by the cube of the revolutions; blocked, by the square
        of the throttle."""
        if self.dead or self.down < 1.0:
            return 0.0
        if self.stalled:
            return _BLOCKED_LOAD * full_a * self.asked * self.asked
        return (_FOULED_LOAD if self.fouled else 1.0) * full_a * abs(self.throttle()) ** 3

    @property
    def steerable(self) -> bool:
        """Whether its azimuth can turn."""
        return self._turns

    @property
    def deployment(self) -> Deployment | None:
        """What its end switches report; None where it is not retractable."""
        if not self._retractable:
            return None
        return (
            Deployment.LOWERED if self.down >= 1.0 else Deployment.RETRACTED if self.down <= 0.0 else Deployment.MOVING
        )

    def _travel(self, dt_s: float) -> None:
        """Move down, or up out of the water, where it gives no force at once."""
        end = 1.0 if self.lower else 0.0
        if self.lower is None or self.down == end:
            return
        step = dt_s / self._config.travel_s
        self.down = end if abs(end - self.down) <= step * 1.000001 else self.down + math.copysign(step, end - self.down)
        self.force_n = 0.0

    def _turn(self, dt_s: float) -> None:
        if self.backlash_rad or self.azimuth_lag_s:
            self._turn_badly(dt_s)
            return
        error = self._target_rad - self.azimuth_rad
        if not error:
            return
        if self._endless:
            error = wrap_pi(error)
        if error:
            most = self._azimuth_rate_radps * dt_s
            turned = self.azimuth_rad + min(max(error, -most), most)
            self.azimuth_rad = wrap_pi(turned) if self._endless else turned

    def _turn_badly(self, dt_s: float) -> None:
        """Turn the gear with its lag, and the thruster where the gear's play is used up."""
        error = self._target_rad - self._gear_rad
        error = wrap_pi(error) if self._endless else error
        most = self._azimuth_rate_radps * dt_s
        self._gear_rad += min(max(self._gear_share * error, -most), most)
        behind, play = self._gear_rad - self.azimuth_rad, 0.5 * self.backlash_rad
        behind = wrap_pi(behind) if self._endless else behind
        if abs(behind) > play:
            turned = self.azimuth_rad + behind - math.copysign(play, behind)
            self.azimuth_rad = wrap_pi(turned) if self._endless else turned

    def _turn_with_lag(self, drive: NozzleConfig, dt_s: float) -> None:
        """Turn as a nozzle or a blade does: with the drive's lag, at most at its rate."""
        most = drive.rate_radps * dt_s
        share = -math.expm1(-dt_s / drive.lag_s) if drive.lag_s > 0.0 else 1.0
        self.azimuth_rad += min(max(share * (self._target_rad - self.azimuth_rad), -most), most)

    def _reachable(self, azimuth_rad: float) -> float:
        """The turn of this direction that the drive goes to; the nearer stop where none lies between the stops."""
        if self._endless:
            return wrap_pi(azimuth_rad)
        low = -math.inf if self._config.azimuth_min_rad is None else self._config.azimuth_min_rad
        high = math.inf if self._config.azimuth_max_rad is None else self._config.azimuth_max_rad
        nearest = self.azimuth_rad + wrap_pi(azimuth_rad - self.azimuth_rad)
        within = [turn for turn in (nearest, nearest - TWO_PI, nearest + TWO_PI) if low <= turn <= high]
        if within:
            return min(within, key=lambda turn: abs(turn - self.azimuth_rad))
        return min(
            (stop for stop in (low, high) if math.isfinite(stop)), key=lambda stop: abs(wrap_pi(azimuth_rad - stop))
        )


def _way_in(dt_s: float, lag_s: float) -> float:
    """Share of the way to its target that a first-order lag goes in that time."""
    return -math.expm1(-dt_s / lag_s) if lag_s > 0.0 else 1.0


def build(configs: Sequence[ThrusterConfig], lag_s: float, x_m: Sequence[float] | None) -> tuple[ThrusterModel, ...]:
    """All thrusters of a vessel but jets and rudders, at their true places `x_m` where given."""
    places = [None] * len(configs) if x_m is None else list(x_m)
    return tuple(ThrusterModel(config, lag_s, x) for config, x in zip(configs, places, strict=True))
