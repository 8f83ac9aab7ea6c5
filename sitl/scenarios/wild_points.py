"""Bursts of outliers, 1 m to 1,000 km off and 1 to 20 in a row, and at the end a step that stays, which the boat is
told to follow: of 3 m, or of more than the receiver wanders by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.emulators import is_receiver
from sitl.emulators.gnss import GnssEmulator
from sitl.faults import OFFSETS_M
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, EstimateError, estimate_errors, receiver_error_m
from sitl.scenarios.scenario import Scenario, Settings, number

_COUNTS = (1, 2, 5, 20)
_PAUSE_S = 2.0
_QUIET_WINDOWS = 2  # before the bursts; of a receiver that wanders as many as bursts that keep it out
_QUIET_STARTS = 2  # in each window's length
_RECOVERY_S = 6.0  # after which the receiver is trusted again
_FOLLOW = 0
_LEAST_STEP_M = 3
_STEP_ERRORS = 2.0  # of the receiver's slow error: a smaller step is part of that to any boat
_TRUST_S = 9.0  # after the longest bursts, until a receiver that wanders is trusted again: the estimate comes to it
_STEP_WATCH_S = 5.0  # at least
_MOVED_M = 0.1
_BY_ITSELF = 2.0  # times what the estimate moves by itself: a burst may fall on its largest move
_ACCEPTED_FIXES = 21  # at the new place in a row; the tick after them follows
_ACCEPTED_SHARE = 0.9  # share of the step
_NORTH_EAST = math.sqrt(0.5)  # of the step, on each axis


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold through all bursts, then through the step."""
    gcs.hold_at_home(number(settings, "settle"))
    config = gcs.rig.config
    fix_s = next(1.0 / row.rate_hz for row in config.sensors if is_receiver(row))
    quiet_s, slow_m = gcs.rig.now_s, receiver_error_m(gcs.rig.conditions.gnss)
    trust_s = _TRUST_S if slow_m > 0.0 else 0.0
    windows = _QUIET_WINDOWS if slow_m == 0.0 else len(OFFSETS_M)
    gcs.sail(windows * (_COUNTS[-1] * fix_s + _PAUSE_S + trust_s))
    accepted_s = _ACCEPTED_FIXES * fix_s + 1.0 / config.control_rate_hz
    bursts = []
    for distance_m in OFFSETS_M:
        for count in _COUNTS:
            from_s = gcs.rig.now_s
            gcs.rig.world.add_fault(f"gnss_off_{distance_m}m", (count + 0.5) * fix_s)
            gcs.sail(_COUNTS[-1] * fix_s + _PAUSE_S + (trust_s if count == _COUNTS[-1] else 0.0))
            bursts.append((distance_m, count, from_s, gcs.rig.now_s))
    gcs.sail(_RECOVERY_S)
    gcs.set_parameter("NAV_JUMP_ACT", _FOLLOW)
    step_s, wander_m = gcs.rig.now_s, _receiver_off_m(gcs)
    step_m = next(distance_m for distance_m in OFFSETS_M if distance_m >= max(_LEAST_STEP_M, _STEP_ERRORS * slow_m))
    gcs.rig.world.add_fault(f"gnss_off_{step_m}m")
    gcs.sail(max(_STEP_WATCH_S, 2.0 * accepted_s))
    return {
        "bursts": bursts, "quiet_s": quiet_s, "quiet_windows": windows, "step_s": step_s, "step_m": step_m,
        "wander_m": wander_m, "accepted_s": accepted_s,
    }  # fmt: skip


def _receiver_off_m(gcs: GroundStation) -> tuple[float, float]:
    """The true slow error of the receiver, north and east."""
    return next(sensor.slow_m for sensor in gcs.rig.world.sensors if isinstance(sensor, GnssEmulator))


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """How far a burst moves the estimate, and how soon it follows the step."""
    errors = estimate_errors(folder)
    _, _, from_s, to_s = asked["bursts"][-1]
    still_m = moved_by_itself_m(errors, asked["quiet_s"], to_s - from_s, asked["quiet_windows"])
    moved = {
        (distance, count): _moved([e for e in errors if from_s <= e.t_s <= to_s])
        for distance, count, from_s, to_s in asked["bursts"]
    }
    worst = max(moved, key=lambda burst: moved[burst])
    metrics = {
        "moved_max_m": moved[worst],
        "worst_burst_m": float(worst[0]),
        "worst_burst_count": float(worst[1]),
        "moved_by_itself_m": still_m,
        "step_accepted_s": followed_s(errors, asked, still_m),
    }
    checks = (
        Check("estimate moved by any burst", metrics["moved_max_m"], max(_MOVED_M, _BY_ITSELF * still_m), "m"),
        Check(f"a step of {asked['step_m']} m accepted after", metrics["step_accepted_s"], asked["accepted_s"], "s"),
    )
    return metrics, checks


def _moved(errors: Sequence[EstimateError]) -> float:
    """Largest distance of the estimate's error from what it was before."""
    before = errors[0]
    return max(math.hypot(error.north_m - before.north_m, error.east_m - before.east_m) for error in errors)


def moved_by_itself_m(errors: Sequence[EstimateError], begin_s: float, window_s: float, windows: int) -> float:
    """The largest distance that the receiver's slow error moves the estimate by in windows as long as that of a
    burst. Two windows would not tell it: where a receiver wanders, it grows with their number."""
    begins = [begin_s + window_s * k / _QUIET_STARTS for k in range(_QUIET_STARTS * (windows - 1) + 1)]
    return max(_moved([e for e in errors if from_s <= e.t_s <= from_s + window_s]) for from_s in begins)


def followed_s(errors: Sequence[EstimateError], asked: dict[str, Any], still_m: float) -> float:
    """Time until the estimate is where the receiver now says, but for what it moves by itself; infinite for never. A
    boat that has learnt of the receiver's slow error before gives that up, too: it restarts at the receiver's place."""
    step_s: float = asked["step_s"]
    step_m, (north_m, east_m) = asked["step_m"], asked["wander_m"]
    north_m, east_m = north_m + _NORTH_EAST * step_m, east_m + _NORTH_EAST * step_m
    near_m = (1.0 - _ACCEPTED_SHARE) * step_m + still_m
    for error in errors:
        if error.t_s >= step_s and math.hypot(error.north_m - north_m, error.east_m - east_m) <= near_m:
            return round(error.t_s - step_s, 3)
    return math.inf


SCENARIO = Scenario(
    name="wild_points",
    text="bursts of outliers while holding, judged by how far the estimate moves beyond what it does by itself",
    vessel="revolt",
    defaults={"wind": "2", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "settle": "40"},
    sail=sail,
    measure=measure,
    lasts_s=150.0,
)
