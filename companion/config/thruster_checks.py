"""What must be true of thrusters. `bridge_checks.py` has the calibration of their drives."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import ThrusterConfig
from companion.config.kinds import Problem

_AGREE = 0.02  # share by which `ahead_n` may differ from the pull of the jet's own curve
_MOST_NOZZLE_RAD = 1.2


def thruster_problems(thrusters: Sequence[ThrusterConfig]) -> list[Problem]:
    """Faults of all thrusters, with their places."""
    problems: list[Problem] = []
    for i, thruster in enumerate(thrusters):
        if thruster.turns and thruster.azimuth_rate_radps <= 0.0:
            text = f"a thruster of kind '{thruster.kind}' needs a rate above 0"
            problems.append((("thruster", i, "azimuth_rate_dps"), text))
        problems += [(("thruster", i, "azimuth_max_deg"), text) for text in _stop_problems(thruster)]
        if thruster.retractable and thruster.travel_s <= 0.0:
            problems.append((("thruster", i, "travel_s"), "a retractable thruster needs the time that it takes"))
        if not thruster.retractable and thruster.travel_s > 0.0:
            problems.append((("thruster", i, "travel_s"), "only for a retractable thruster"))
        if thruster.forbidden_rad:
            problems += [(("thruster", i, "forbidden_deg"), text) for text in _sector_problems(thruster)]
    return problems


def _stop_problems(thruster: ThrusterConfig) -> list[str]:
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    if thruster.kind != "azimuth" or (low is None and high is None):
        return []
    if low is None or high is None:
        return ["give both stops, azimuth_min_deg and azimuth_max_deg, or none for a pod that turns endlessly"]
    if low >= high:
        degrees = f"{math.degrees(high):g} should be more than azimuth_min_deg, {math.degrees(low):g}"
        return [f"{degrees}: exchange the stops; the least is counter-clockwise"]
    return []


def _sector_problems(thruster: ThrusterConfig) -> list[str]:
    problems = []
    if thruster.kind != "azimuth":
        problems.append("a fixed thruster has no sectors")
    if any(
        (thruster.azimuth_rad - start) % math.tau < (end - start) % math.tau for start, end in thruster.forbidden_rad
    ):
        problems.append("the azimuth at rest lies in a forbidden sector")
    if sum((end - start) % math.tau for start, end in thruster.forbidden_rad) >= math.tau:
        problems.append("the forbidden sectors leave no direction")
    return problems


# --- jets ----------------------------------------------------------------------------------------------------------

_TWINS = ". Jets side by side are one: max_n the sum, y_m = 0, and both driven by the same outputs"


def jet_problems(thrusters: Sequence[ThrusterConfig], sway_n: float) -> list[Problem]:
    """Faults of jets and of the vessel around them, with their places. `sway_n`: the side force that the controller may
    ask for."""
    problems: list[Problem] = []
    for i, thruster in enumerate(thrusters):
        if thruster.kind != "jet":
            if thruster.jet is not None:
                problems.append((("thruster", i, "jet"), f"only for a thruster of kind 'jet', not '{thruster.kind}'"))
            continue
        problems += [(("thruster", i, key), text) for key, text in _of_jet(thruster)]
        if len(thrusters) > 1:
            twins = all(other.kind == "jet" for other in thrusters)
            text = "a jet must be the only thruster: leave out the others" + (_TWINS if twins else "")
            problems.append((("thruster", i, "kind"), text))
        if sway_n > 0.0:
            problems.append((("limits", "sway_n"), "a boat driven by a jet cannot push itself sideways: should be 0"))
    return problems


def _of_jet(thruster: ThrusterConfig) -> list[tuple[str, str]]:
    return [*_thrust_problems(thruster), *_nozzle_problems(thruster), *_place_problems(thruster)]


def _thrust_problems(thruster: ThrusterConfig) -> list[tuple[str, str]]:
    problems = []
    if thruster.jet is None:
        problems.append(("kind", "a jet needs its table [thruster.jet]"))
    elif abs(thruster.jet.bollard_n(1.0) - thruster.ahead_n) > _AGREE * thruster.ahead_n:
        pull = f"{thruster.jet.bollard_n(1.0):.0f} N"
        problems.append(("ahead_n", f"the jet's own curve gives {pull} at full throttle and at rest"))
    if thruster.min_n != 0.0:
        problems.append(("min_n", "should be 0: a reverse bucket is not steered"))
    if thruster.dead_band <= 0.0:
        problems.append(("dead_band", "should be above 0: the throttle below which the impeller stands"))
    return problems


def _nozzle_problems(thruster: ThrusterConfig) -> list[tuple[str, str]]:
    problems = []
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    if low is None or high is None or not -_MOST_NOZZLE_RAD < low < 0.0 < high < _MOST_NOZZLE_RAD:
        text = (
            "a nozzle needs stops either side of straight ahead, azimuth_min_deg and azimuth_max_deg, within 68 degrees"
        )
        problems.append(("azimuth_max_deg", text))
    if thruster.forbidden_rad or thruster.retractable:
        problems.append(("forbidden_deg" if thruster.forbidden_rad else "retractable", "not for a jet"))
    return problems


def _place_problems(thruster: ThrusterConfig) -> list[tuple[str, str]]:
    problems = []
    if thruster.azimuth_rad != 0.0 or thruster.y_m != 0.0:
        text = "a jet lies in the middle of the boat and points ahead at rest: y_m and azimuth_deg should be 0"
        problems.append(("y_m" if thruster.y_m != 0.0 else "azimuth_deg", text))
    if thruster.x_m >= 0.0:
        problems.append(("x_m", "a jet is at the stern, behind the middle of the boat"))
    return problems
