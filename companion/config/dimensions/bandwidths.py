"""Parameters of a boat whose gains nobody has tuned: bandwidths and speeds by the thrust there is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from companion.config.devices import SensorConfig
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import GRAVITY_MPS2
from companion.config.dimensions.receivers import grade_of
from companion.config.hull import HullConfig, humps

_SOURCE = "thrust over inertia; ReVolt's tuning at sea"
# Errors at which the proportional part alone takes all thrust. ReVolt's tuned gains are at 0.7 m, 0.43 m and 18°.
_FULL_AT_M, _FULL_AT_RAD = 0.7, 0.3
_LAG_SHARE = 0.25  # bandwidth times the lag of thrust: leaves a phase margin of 60° with the derivative part
# A rudder or a nozzle does not wait for the thrust. The law knows the rate at which it turns. Jets of 1 m in wind of
# 6 m/s turned too weakly at 1.3 rad/s: 3 and 4.4 m off a square, in place of 1.2 and 1.8.
_MOST_STEERED_RADPS = 2.0
_MOST_BY_RECEIVER = {"rtk": 0.6, "sbas": 0.35, "standalone": 0.25}  # rad/s: a wandering position is not chased
_CRUISE_SHARE, _TOP_SHARE, _POSITIONING_SHARE = 0.6, 0.85, 0.25  # of top speed
_ACCELERATION_SHARE = 0.3  # of the thrust
# Of the moment, in turns. A boat without sideways thrust turns on the spot at its corners, where a current carries it
# aside: it turns faster there. In bends the moment that way takes bounds its speed besides.
_TURN_SHARE, _SPIN_SHARE = 0.5, 0.8
_SLOWEST_CRUISE_MPS = 0.3
_HULL_SPEEDS = 1.2
_HUMPS = 1.5  # RescueRunner's
# In positioning; back to the point of a boat that drifts, faster than the drift (RescueRunner's).
_MOST_POSITIONING_MPS, _MOST_BACK_MPS = 0.5, 2.5
_CIRCLE = 3.0  # lengths: radius of the water that a boat with a rudder needs to turn and come back
_MOST_FENCE_M, _MOST_WATCH_M, _MOST_REACHED_M, _MOST_MPS = 50.0, 100.0, 100.0, 25.0  # that the parameters take
_COASTS = 2.0  # lengths that a boat without way astern goes on after the end of a mission before it holds
_DRIFT_CIRCLE = 6.0  # the same without way astern: it coasts after each way back (RescueRunner has 7)
# Lengths of water that it keeps from obstacles, which it cannot brake for: with 3 m RescueRunner touched one in 6 of 16
# runs, with 5 m in none. Others without sideways thrust drift while they turn: a catamaran of 6 m touched one in 4 of
# 20 runs in 6 m/s with 3 m, with 6 m in none of 10.
_DRIFT_CLEAR, _TURN_CLEAR, _LEAST_CLEAR_M, _MOST_CLEAR_M = 1.4, 1.0, 3.0, 20.0
# Lengths, for a boat without sideways thrust: while it turns its bow into a wind of 5 m/s it drifts by up to 1.4.
_BOW_CIRCLE = 1.5
_FENCE_M = {
    "rtk": 0.5,
    "sbas": 2.0,
    "standalone": 2.5,
}  # with sideways thrust: what it errs by, and slow gains let gusts do
# Of the distance in which the course of a boat without sideways thrust follows its bow, as its hull slides outwards at
# about that speed; a length for one that turns in circles. A launch of 7.2 m with a look-ahead of 3.5 m snaked along
# straight lines by ±5 m in still water.
_LATE_SHARE, _SLIDES_MPS, _LEAST_LOOKAHEAD_M, _MOST_LOOKAHEAD_M = 1.25, 0.1, 3.0, 100.0
# Lengths: radius of its turn with full rudder, at every speed. Ships must turn within 2.5 (IMO MSC.137(76)).
_TURN = 2.0


class Speeds(NamedTuple):
    """`top_mps`: at full thrust; `steady_mps`: faster the boat does not keep its course."""

    top_mps: float
    steady_mps: float


def figures(
    hull: HullConfig,
    limits: tuple[float, float, float],
    length_m: float,
    sensors: Sequence[SensorConfig],
    lag_s: float,
    speeds: Speeds,
    needs_flow: bool = False,
    drifts: bool = False,
) -> tuple[Figure, ...]:
    """Defaults of `[parameters]`. `limits`: largest surge N, sway N and yaw Nm; `lag_s`: of the thrust;
    `needs_flow`: the boat steers by a rudder or a nozzle, so that it turns in a circle; `drifts`: it has no way astern,
    so that in Hold it drifts and sails back."""
    surge_n, sway_n, yaw_nm = limits
    receiver = grade_of(sensors)
    by_lag = _LAG_SHARE / max(0.1, lag_s)
    most = min(_MOST_BY_RECEIVER[receiver], by_lag)
    rows = {
        "DP_BW_SURGE": _within(0.1, math.sqrt(surge_n / (hull.m11_kg * _FULL_AT_M)), most),
        "DP_BW_YAW": _within(0.15, math.sqrt(yaw_nm / (hull.m33_kgm2 * _FULL_AT_RAD)), min(0.8, by_lag)),
        "PATH_BW_SURGE": _within(0.15, math.sqrt(surge_n / (hull.m11_kg * _FULL_AT_M)), min(1.0, by_lag)),
        "PATH_BW_YAW": _within(
            0.3,
            math.sqrt(yaw_nm / (hull.m33_kgm2 * _FULL_AT_RAD)),
            _MOST_STEERED_RADPS if needs_flow else min(1.3, 1.6 * by_lag),
        ),
        **_speeds(
            speeds,
            max(_SLOWEST_CRUISE_MPS, min(_cruise_mps(hull, speeds.top_mps, length_m), speeds.steady_mps)),
            surge_n / hull.m11_kg,
            yaw_nm,
            hull,
            _TURN * length_m if needs_flow else 0.0,
            _MOST_BACK_MPS if drifts else _MOST_POSITIONING_MPS,
            sway_n > 0.0,
        ),
        **_circles(
            length_m,
            receiver,
            _DRIFT_CIRCLE if drifts else _CIRCLE if needs_flow else 1.0 if sway_n > 0.0 else _BOW_CIRCLE,
        ),
        "NAV_ACC_RAD": _within(
            1.5 if receiver == "rtk" else 2.0, (_TURN if needs_flow else 0.75) * length_m, _MOST_REACHED_M
        ),
    }
    # Without sideways thrust it may drift through its watch circle, beside the fence too, and beyond that while its bow
    # comes round.
    beyond_m = _COASTS * length_m if drifts else 0.5 * length_m
    rows["FENCE_MARGIN"] = _FENCE_M[receiver] if sway_n > 0.0 else min(_MOST_FENCE_M, rows["DP_WATCH_R"] + beyond_m)
    if sway_n <= 0.0:
        clear_m = (_DRIFT_CLEAR if drifts else _TURN_CLEAR) * length_m
        rows["CP_DIST"] = _within(_LEAST_CLEAR_M, clear_m, _MOST_CLEAR_M)
        rows["PATH_LOOKAHEAD"] = _lookahead_m(hull, rows["WP_SPEED"], length_m if needs_flow else 0.0)
    else:
        rows["DP_BW_SWAY"] = _within(0.1, math.sqrt(sway_n / (hull.m22_kg * _FULL_AT_M)), most)
        rows["DP_ACC_SWAY"] = _within(0.01, _ACCELERATION_SHARE * sway_n / hull.m22_kg, 0.2)
    return tuple(
        Figure(f"parameters.{name}", round(value, 3), 2.0, "thrust over inertia, lag and receiver", _SOURCE)
        for name, value in rows.items()
    )


def _speeds(
    speeds: Speeds,
    cruise_mps: float,
    most_mps2: float,
    yaw_nm: float,
    hull: HullConfig,
    turn_m: float,
    positioning_mps: float,
    can_sway: bool,
) -> dict[str, float]:
    """`turn_m`: radius of the tightest turn; 0 for a boat that turns by a moment of its thrusters. `positioning_mps`:
    the most in positioning."""
    turn_radps2 = yaw_nm / hull.m33_kgm2
    turn_radps, spin_radps = (_spin_radps(hull, share * yaw_nm) for share in (_TURN_SHARE, _SPIN_SHARE))
    if turn_m > 0.0:
        turn_radps = spin_radps = cruise_mps / turn_m
    elif can_sway:
        spin_radps = turn_radps
    positioning = _within(0.1, _POSITIONING_SHARE * speeds.top_mps, positioning_mps)
    return {
        "WP_SPEED": cruise_mps,
        "MPC_XY_VEL_MAX": _within(_SLOWEST_CRUISE_MPS, min(_TOP_SHARE * speeds.top_mps, speeds.steady_mps), _MOST_MPS),
        "DP_SPEED_AHEAD": positioning,
        "DP_SPEED_ASTERN": 0.5 * positioning,
        "DP_SPEED_SWAY": _within(0.05, 0.3 * positioning, 0.15),
        "DP_ACC_SURGE": _within(0.02, _ACCELERATION_SHARE * most_mps2, 0.2),
        "DP_ACC_YAW": _within(0.5, math.degrees(_ACCELERATION_SHARE * turn_radps2), 6.0),
        "DP_YAW_RATE": _within(2.0, math.degrees(0.5 * turn_radps), 8.0),
        "PATH_ACC": _within(0.03, _ACCELERATION_SHARE * most_mps2, 0.8),
        "PATH_ACC_LAT": _within(0.05, _ACCELERATION_SHARE * most_mps2, 1.0),
        "PATH_YAW_RATE": _within(5.0, math.degrees(spin_radps), 30.0),
        "MAN_YAW_RATE": _within(5.0, math.degrees(0.7 * turn_radps), 40.0),
    }


def _lookahead_m(hull: HullConfig, cruise_mps: float, least_m: float) -> float:
    """By the distance in which the course follows the bow."""
    late_m = cruise_mps * hull.sway_lag_s(cruise_mps, _SLIDES_MPS)
    return _within(max(_LEAST_LOOKAHEAD_M, least_m), _LATE_SHARE * late_m, _MOST_LOOKAHEAD_M)


def _spin_radps(hull: HullConfig, moment_nm: float) -> float:
    """Yaw rate at rest at which damping takes the moment."""
    d = hull.damping
    return (math.sqrt(d.n_r**2 + 4.0 * d.n_rr * moment_nm) - d.n_r) / (2.0 * d.n_rr) if d.n_rr > 0.0 else 0.3


def _cruise_mps(hull: HullConfig, top_mps: float, length_m: float) -> float:
    """A share of the top speed. A hull that does not plane is not driven far beyond its hull speed: it steers badly
    there. One that planes is driven well beyond its hump, and no faster among people unless somebody asks for it."""
    most_mps = _HULL_SPEEDS * math.sqrt(GRAVITY_MPS2 * length_m / math.tau)
    if hull.resistance:
        last = humps(hull.resistance)[-1:]
        most_mps = _HUMPS * last[0][0] if last else math.inf
    return max(_SLOWEST_CRUISE_MPS, min(_CRUISE_SHARE * top_mps, most_mps))


def _circles(length_m: float, receiver: str, lengths: float) -> dict[str, float]:
    """Watch circle and alarm circle: by length, receiver and how many lengths the boat needs to turn in."""
    by_receiver = {"rtk": 0.0, "sbas": 2.0, "standalone": 5.0}[receiver]
    watch_m = lengths * length_m + by_receiver
    watch_m = _within(3.0, watch_m, _MOST_WATCH_M)
    return {
        "DP_WATCH_R": watch_m,
        "DP_ALARM_R": 2.0 * watch_m,
    }


def _within(low: float, value: float, high: float) -> float:
    return max(low, min(high, value))
