"""What must be true of a vessel that is driven by a water jet."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ThrusterConfig

_AGREE = 0.02  # by which the pull said in `ahead_n` may be off from that of the jet's own curve


def jet_problems(thrusters: Sequence[ThrusterConfig], sway_n: float) -> list[tuple[tuple[str | int, ...], str]]:
    """Faults of jets and of the vessel around them, with their places."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    for i, thruster in enumerate(thrusters):
        if thruster.kind != "jet":
            if thruster.jet is not None:
                problems.append((("thruster", i, "jet"), f"only for a thruster of kind 'jet', not '{thruster.kind}'"))
            continue
        problems += [(("thruster", i, key), text) for key, text in _of_jet(thruster)]
        if len(thrusters) > 1:
            problems.append((("thruster", i, "kind"), "a jet must be the only thruster: allocation over a jet and others is not there"))
        if sway_n > 0.0:
            problems.append((("limits", "sway_n"), "a boat driven by a jet cannot push itself sideways: 0, please"))
    return problems


def _of_jet(thruster: ThrusterConfig) -> list[tuple[str, str]]:
    problems = []
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    if thruster.jet is None:
        problems.append(("kind", "a jet needs its table [thruster.jet]"))
    elif abs(thruster.jet.bollard_n(1.0) - thruster.ahead_n) > _AGREE * thruster.ahead_n:
        problems.append(("ahead_n", f"the jet's own curve gives {thruster.jet.bollard_n(1.0):.0f} N at full throttle and at rest"))
    if thruster.min_n != 0.0:
        problems.append(("min_n", "0, please: a reverse bucket is not steered"))
    if low is None or high is None or not -1.2 < low < 0.0 < high < 1.2:
        problems.append(("azimuth_max_deg", "a nozzle needs stops either side of straight ahead, azimuth_min_deg and azimuth_max_deg, within 68 degrees"))
    if thruster.azimuth_rad != 0.0 or thruster.y_m != 0.0:
        problems.append(("azimuth_deg", "a jet lies in the middle of the boat and points ahead at rest: y_m and azimuth_deg 0, please"))
    if thruster.x_m >= 0.0:
        problems.append(("x_m", "a jet is at the stern, behind the middle of the boat"))
    if thruster.dead_band <= 0.0:
        problems.append(("dead_band", "above 0, please: the throttle below which the impeller stands"))
    if thruster.forbidden_rad or thruster.retractable:
        problems.append(("forbidden_deg" if thruster.forbidden_rad else "retractable", "not for a jet"))
    return problems
