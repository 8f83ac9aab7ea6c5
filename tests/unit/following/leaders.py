"""A lead boat on a given way, and boats that do what a setpoint says: a hull without way astern, and one that has it and
turns in place."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import Leader, NavState
from companion.core.setpoint import PathSetpoint, Setpoint, WrenchSetpoint
from tests.unit.estimates import AT_REST

DT_S = 0.1


def leader_at(
    north_m: float = 0.0,
    east_m: float = 0.0,
    *,
    speed_mps: float = 0.0,
    course_rad: float = 0.0,
    **more: float | bool | None,
) -> Leader:
    """It goes `speed_mps` where `course_rad` points its bow; astern where that is negative."""
    leader = Leader(
        7,
        north_m,
        east_m,
        speed_mps * math.cos(course_rad),
        speed_mps * math.sin(course_rad),
        course_rad,
        0.0,
        1.0,
        0.0,
        0.05,
        None,
        astern=speed_mps < -0.3,
    )
    return replace(leader, **more) if more else leader  # type: ignore[arg-type]


class Lead:
    """`step(speed, turn)` → Leader a tick on; it gains speed and turn as a crew would have it."""

    def __init__(self, north_m: float, east_m: float, course_rad: float = 0.0) -> None:
        self.north_m, self.east_m, self.course_rad = north_m, east_m, course_rad
        self.speed_mps = self.turn_radps = 0.0

    def step(self, speed_mps: float, turn_radps: float = 0.0) -> Leader:
        gain = min(1.0, max(-1.0, (speed_mps - self.speed_mps) / DT_S))
        self.speed_mps += gain * DT_S
        self.turn_radps += min(0.15 * DT_S, max(-0.15 * DT_S, turn_radps - self.turn_radps))
        self.course_rad = wrap_pi(self.course_rad + self.turn_radps * DT_S)
        self.north_m += self.speed_mps * math.cos(self.course_rad) * DT_S
        self.east_m += self.speed_mps * math.sin(self.course_rad) * DT_S
        along = math.copysign(1.0, self.speed_mps) * gain
        return leader_at(
            self.north_m,
            self.east_m,
            speed_mps=self.speed_mps,
            course_rad=self.course_rad,
            yaw_rate_radps=self.turn_radps,
            acceleration_mps2=along,
        )


class Jet:
    """Turns no faster than 0.5 rad/s and only with way or thrust on, slows down by its resistance alone, knows where it
    is."""

    def __init__(self, config: VesselConfig, north_m: float, east_m: float, yaw_rad: float = 0.0) -> None:
        self._hull = config.hull
        self.nav = replace(AT_REST, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad)

    def step(self, setpoint: Setpoint) -> NavState:
        nav, hull = self.nav, self._hull
        u, rate = nav.surge_mps, nav.yaw_rate_radps
        drag = hull.drag_n(u) / hull.m11_kg
        wanted, turn = 0.0, 0.0
        if isinstance(setpoint, PathSetpoint) and setpoint.yaw_rad is not None:
            off = wrap_pi(setpoint.yaw_rad - nav.yaw_rad)
            turn = min(0.5, max(-0.5, 1.5 * off + setpoint.yaw_rate_radps))
            wanted = max(setpoint.surge_mps, 2.3 if abs(off) > 0.15 else 0.0)
        u = min(wanted, u + 2.0 * DT_S) if u < wanted else max(wanted, u - drag * DT_S)
        rate += (turn - rate) * DT_S / 0.6
        return self._go(u, rate)

    def _go(self, surge_mps: float, rate_radps: float) -> NavState:
        """Where it is a tick on."""
        nav = self.nav
        yaw = wrap_pi(nav.yaw_rad + rate_radps * DT_S)
        north, east = surge_mps * math.cos(yaw), surge_mps * math.sin(yaw)
        self.nav = replace(
            nav,
            north_m=nav.north_m + north * DT_S,
            east_m=nav.east_m + east * DT_S,
            yaw_rad=yaw,
            surge_mps=surge_mps,
            north_mps=north,
            east_mps=east,
            yaw_rate_radps=rate_radps,
        )
        return self.nav


class Twin(Jet):
    """Turns in place, as fast as PATH_YAW_RATE at most, goes astern, and changes its speed by `thrust_mps2` at most."""

    thrust_mps2 = 0.5
    turns_radps = 0.4

    def step(self, setpoint: Setpoint) -> NavState:
        nav = self.nav
        u, rate = nav.surge_mps, nav.yaw_rate_radps
        wanted, turn = 0.0, 0.0
        if isinstance(setpoint, PathSetpoint) and setpoint.yaw_rad is not None:
            wanted = setpoint.surge_mps
            turn = 1.2 * wrap_pi(setpoint.yaw_rad - nav.yaw_rad) + setpoint.yaw_rate_radps
        gained = self.thrust_mps2 * DT_S
        u += min(gained, max(-gained, wanted - u))
        rate += (min(self.turns_radps, max(-self.turns_radps, turn)) - rate) * DT_S / 0.6
        return self._go(u, rate)


class TwinScrew(Twin):
    """A ship that its rudders turn ahead. Where it makes no way its propellers turn it slowly, with all their thrust: it
    brakes or backs only while it does not turn."""

    ahead_radps, at_rest_radps = 0.25, 0.13

    def step(self, setpoint: Setpoint) -> NavState:
        asked = setpoint.yaw_rad if isinstance(setpoint, PathSetpoint) else None
        brakes = isinstance(setpoint, PathSetpoint) and setpoint.surge_mps < min(0.5, self.nav.surge_mps)
        self.turns_radps = self.at_rest_radps if brakes or self.nav.surge_mps < 0.5 else self.ahead_radps
        turns = asked is not None and abs(wrap_pi(asked - self.nav.yaw_rad)) > 0.1
        self.thrust_mps2 = 0.03 if brakes and turns else 0.3
        return super().step(setpoint)


class RudderBoat(Twin):
    """A launch with one propeller and a rudder. It turns while it pushes itself ahead, in an arc of 9 m or more; astern
    and while it brakes it keeps its heading, and a wrench only drives it along."""

    thrust_mps2 = 0.3

    def step(self, setpoint: Setpoint) -> NavState:
        nav = self.nav
        if not isinstance(setpoint, PathSetpoint):
            wrench = setpoint.wrench if isinstance(setpoint, WrenchSetpoint) else ZERO_WRENCH
            push = min(self.thrust_mps2, max(-self.thrust_mps2, wrench.surge_n / self._hull.m11_kg))
            rate = nav.yaw_rate_radps * (1.0 - DT_S / 1.5)
            return self._go(nav.surge_mps + push * DT_S, rate)
        assert setpoint.yaw_rad is not None
        off, wanted = wrap_pi(setpoint.yaw_rad - nav.yaw_rad), setpoint.surge_mps
        if abs(off) > 0.15 and wanted >= 0.0:
            wanted = max(wanted, 1.0)
        pushes = wanted > 0.0 and wanted > nav.surge_mps - 0.3
        most = max(0.0, nav.surge_mps) / 9.0 if pushes else 0.0
        gained = self.thrust_mps2 * DT_S
        surge = nav.surge_mps + min(gained, max(-gained, wanted - nav.surge_mps))
        rate = nav.yaw_rate_radps + (min(most, max(-most, 1.2 * off)) - nav.yaw_rate_radps) * DT_S / 1.0
        return self._go(surge, rate)


class Carried(Twin):
    """A twin that a known current carries north, against which it cannot push itself sideways."""

    current_mps = 0.6

    def step(self, setpoint: Setpoint) -> NavState:
        super().step(setpoint)
        nav, c, s = self.nav, math.cos(self.nav.yaw_rad), math.sin(self.nav.yaw_rad)
        surge = nav.surge_mps if isinstance(setpoint, PathSetpoint) else self.current_mps * c
        sway = -self.current_mps * s
        north, east = surge * c - sway * s, surge * s + sway * c
        self.nav = replace(
            nav,
            north_m=nav.north_m + (north - nav.north_mps) * DT_S,
            east_m=nav.east_m + (east - nav.east_mps) * DT_S,
            surge_mps=surge,
            sway_mps=sway,
            north_mps=north,
            east_mps=east,
            current_north_mps=self.current_mps,
            current_east_mps=0.0,
            current_accuracy_mps=0.05,
        )
        return self.nav
