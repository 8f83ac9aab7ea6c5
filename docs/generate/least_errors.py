"""The least error that the positioning law of the ReVolt thesis can have in a step, whatever the water does."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from companion.baselines.positioning import PERIOD_S
from companion.baselines.reference import ThesisReference
from companion.config.vessel import find, load
from companion.params.store import Parameters

_STEP_S = 0.02
_LASTS_S = 60.0
_DAMPINGS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)  # of the inertia, in 1/s


@cache
def least_error(axis: str, inertia: float, step: float) -> float:
    """The largest error, in m or rad, in a step of that size with the law's printed gains and reference, on a body of
    `inertia` (kg or kg m²) whose thrusters obey at once; the least over several linear dampings. `axis`: SURGE, YAW."""
    return min(_largest_error(axis, inertia, share * inertia, step) for share in _DAMPINGS)


def _largest_error(axis: str, inertia: float, damping: float, step: float) -> float:
    parameters = _parameters()
    kp, ki, kd = (parameters[f"DPT_K{term}_{axis}"] for term in "PID")
    place = speed = force = integral = most = 0.0
    each = round(PERIOD_S / _STEP_S)
    for k, (there, fast) in enumerate(_wanted(axis, step)):
        error = place - there
        most = max(most, abs(error))
        if k % each == 0:
            integral -= ki * error * PERIOD_S
            force = integral - kp * error - kd * (speed - fast)
        speed += _STEP_S * (force - damping * speed) / inertia
        place += _STEP_S * speed
    return most


@cache
def _parameters() -> Parameters:
    return Parameters(load(find("revolt")).parameters)


@cache
def _wanted(axis: str, step: float) -> Sequence[tuple[float, float]]:
    """Place and speed of the reference along the axis, at each step of the integration."""
    reference = ThesisReference(_parameters())
    reference.retarget(step if axis == "SURGE" else 0.0, 0.0, step if axis == "YAW" else 0.0)
    wanted = (reference.update(_STEP_S) for _ in range(round(_LASTS_S / _STEP_S)))
    return [(one.north_m, one.surge_mps) if axis == "SURGE" else (one.yaw_rad, one.yaw_rate_radps) for one in wanted]


def inertia_for(axis: str, error: float, step: float, low: float, high: float) -> float:
    """The inertia between both at which `least_error` is `error`."""
    while high - low > 0.01 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if least_error(axis, middle, step) < error else (low, middle)
    return high
