"""A ground station that orders whatever comes to its mind, in an order that the seed draws: the boat violates no safety
property, each refusal has its reason, and at the end it lies where it was told to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sitl.noise import stream
from sitl.obstacles import RoundObstacle
from sitl.scenarios.boat import heading_error_deg, holds_by_drifting, motor
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, between, distance_to, receiver_error_m
from sitl.scenarios.orders import ACCEPTED, CHOICES, DRIFTING, UNGUARDED, Given, Orders
from sitl.scenarios.positioning import PositioningLog, errors, read
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_PAUSE_S = (4.0, 45.0)  # between two orders
_HEARD_S = 3.0  # after an order, within which its reason is heard
_AGAIN_S = 30.0  # in which the boat says the same refusal once
_LAST_S = 20.0  # in which the boat must lie at its point
_OFF_M, _OFF_DEG = 0.5, 5.0
_LENGTHS, _LENGTHS_BOW = 1.0, 2.0  # that a boat may move in Hold: with sideways thrust, and without
_CLEAR_M = 5.0  # and two lengths: from home to a stone
_RADII_M = (0.5, 2.5)
_AMONG_MPS = 1.5  # among stones


@dataclass(frozen=True, slots=True)
class Order:
    """What was ordered when, the command's result, and what the boat said until `_HEARD_S` after it."""

    t_s: float
    text: str
    result: int
    said: tuple[str, ...]

    @property
    def is_refused(self) -> bool:
        """Whether the boat did not take it."""
        return self.result != ACCEPTED


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Order for `time` seconds, then Hold or RTL for `end`. `orders`: names of those that are drawn from; all where it
    is empty."""
    names = settings["orders"].split(",") if settings["orders"] else list(CHOICES)
    if number(settings, "stones"):
        left_out = (*UNGUARDED, *(DRIFTING if gcs.rig.config.limits.sway_n <= 0.0 else ()))
        names = [name for name in names if name not in left_out]
    if unknown := set(names) - set(CHOICES):
        raise ScenarioError(f"orders={min(unknown)}: some of {', '.join(CHOICES)}")
    draws = stream(gcs.rig.world.seed, "orders")
    gcs.ready()
    orders = Orders(gcs, draws)
    gcs.upload(orders.fence(), mavlink.MAV_MISSION_TYPE_FENCE)
    gcs.rig.world.obstacles.round += _stones(orders, gcs, settings)
    gcs.arm()
    from_s, given = gcs.rig.now_s, []
    while gcs.rig.now_s < from_s + number(settings, "time"):
        given.append(_give(gcs, partial(CHOICES[draws.choice(names)], orders)))
        gcs.sail(max(0.0, draws.uniform(*_PAUSE_S) - _HEARD_S))
        if not gcs.is_armed:
            given.append(_give(gcs, orders.arm))
    given.append(_give(gcs, orders.let_go))
    given.append(_give(gcs, partial(orders.mode, draws.choice(("hold", "rtl")))))
    gcs.sail(number(settings, "end"))
    config = gcs.rig.config
    lengths = _LENGTHS if config.limits.sway_n > 0.0 else _LENGTHS_BOW
    moves_m = gcs.parameter("DP_WATCH_R") if holds_by_drifting(config) else lengths * config.length_m
    return {
        "orders": given,
        "from_s": from_s,
        "moves_m": moves_m,
        "sideways": config.limits.sway_n > 0.0,
        "heading_deg": heading_error_deg(config, gcs.rig.conditions),
    }


def _give(gcs: GroundStation, order: Callable[[], Given]) -> Order:
    began_s, heard = gcs.rig.now_s, len(gcs.texts)
    text, result = order()
    gcs.sail(_HEARD_S)
    return Order(began_s, text, result, tuple(gcs.texts[heard:]))


def _stones(orders: Orders, gcs: GroundStation, settings: Settings) -> list[RoundObstacle]:
    """Round stones that only the lidar knows, none near the boat."""
    draws = stream(gcs.rig.world.seed, "stones")
    clear_m = _CLEAR_M + 2.0 * gcs.rig.config.length_m
    found: list[RoundObstacle] = []
    while len(found) < int(number(settings, "stones")):
        (north_m, east_m), radius_m = orders.point(draws), draws.uniform(*_RADII_M)
        if math.hypot(north_m, east_m) - radius_m > clear_m:
            found.append(RoundObstacle(north_m, east_m, radius_m))
    return found


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Refusals without a reason, and how the boat lies at the end. Writes orders.csv."""
    orders: list[Order] = asked["orders"]
    (folder / "orders.csv").write_text(_table(orders), encoding="utf-8")
    sailed = read(folder, asked["from_s"], math.inf)
    last = between(sailed.truth, sailed.truth[-1]["t_s"] - _LAST_S)
    where = tuple(sum(row[name] for row in last) / len(last) for name in ("north_m", "east_m"))
    metrics = {
        "orders": float(len(orders)),
        "refused": float(sum(order.is_refused for order in orders)),
        "without_reason": float(sum(_is_unsaid(order, orders) for order in orders)),
        "moved_at_end_m": max(distance_to(row, *where) for row in last),
    }
    checks = [
        Check("refusals without a reason", metrics["without_reason"], 0.0, ""),
        Check("moved in the last seconds", metrics["moved_at_end_m"], asked["moves_m"], "m"),
    ]
    if asked["sideways"]:
        ends = errors(PositioningLog(last, sailed.ticks[-len(last) :]))
        metrics["off_at_end_m"] = max(math.hypot(north_m, east_m) for north_m, east_m, _ in ends)
        metrics["off_at_end_deg"] = math.degrees(max(abs(yaw_rad) for *_, yaw_rad in ends))
        off_m, off_deg = _OFF_M + receiver_error_m(settings["gnss"]), _OFF_DEG + asked["heading_deg"]
        checks += [
            Check("off its point in the last seconds", metrics["off_at_end_m"], off_m, "m"),
            Check("off its heading in the last seconds", metrics["off_at_end_deg"], off_deg, "deg"),
        ]
    return metrics, checks


def _is_unsaid(order: Order, orders: Sequence[Order]) -> bool:
    """Whether it was refused without a word; the same refusal is not said twice in `_AGAIN_S`."""
    before = [one for one in orders if order.t_s - _AGAIN_S - _HEARD_S < one.t_s <= order.t_s]
    return order.is_refused and not any(one.is_refused and one.said for one in before)


def _table(orders: Sequence[Order]) -> str:
    rows = (f'{one.t_s:.1f},{one.result},"{one.text}","{" | ".join(one.said)}"' for one in orders)
    return "\n".join(["t_s,result,order,said", *rows, ""])


def _with_lidar(conditions: Conditions, settings: Settings) -> Conditions:
    """A lidar where there are stones, and a speed at which it sees them in time."""
    if not number(settings, "stones"):
        return conditions
    return replace(conditions, lidar=True, parameters={**conditions.parameters, "MPC_XY_VEL_MAX": _AMONG_MPS})


SCENARIO = Scenario(
    name="any_order",
    text="modes, points, missions, circles and sticks drawn by the seed: nothing unsafe, each refusal with its reason",
    vessel="revolt",
    defaults={
        "orders": "",
        "wind": "3",
        "current": "",
        "stones": "0",
        "waves": "",
        "gnss": "rtk",
        "plant": "",
        "model_error": "",
        "time": "600",
        "end": "240",
    },
    needs=(motor,),
    sail=sail,
    measure=measure,
    prepare=_with_lidar,
    by_margins=True,
    lasts_s=850.0,
)
