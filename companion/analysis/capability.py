"""DP capability: the wind that a boat can hold against, by its direction, with all thrusters or some lost.

A static balance (IMCA M 140, level 1): wind and current come from the same direction, and the allocation's own solver
finds thrust for their force and moment at once, within the limits of thrusters and controller. What falls short by more
than the allocation's own tolerance is not held.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from companion.allocation.allocator import Allocator
from companion.analysis.figure import new_figure
from companion.analysis.polar import wrench_against
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.actuation import Wrench
from companion.params.store import Parameters
from companion.params.table import table_of

MOST_MPS = 40.0
_HALVINGS = 10
_TURNS_S, _TURNS = 1.0, 25  # the solver turns the thrusters step by step


@dataclass(frozen=True, slots=True)
class Capability:
    """`wind_mps[i]`: the strongest wind from `from_rad[i]`, clockwise from the bow; MOST_MPS: that or more. `lost`:
    names of the thrusters that are lost. `bow_only`: the boat has no sideways thrust."""

    from_rad: tuple[float, ...]
    wind_mps: tuple[float, ...]
    lost: tuple[str, ...]
    current_mps: float
    bow_only: bool = False

    @property
    def least_mps(self) -> float:
        """Wind that is held from every direction."""
        return min(self.wind_mps)


def capability(
    config: VesselConfig, lost: Sequence[str] = (), current_mps: float = 0.0, directions: int = 36
) -> Capability:
    """The capability of a vessel. `current_mps`: from the same direction as the wind.

    Raises ConfigError for a vessel with a jet or a rudder alone, or without windage, and for an unknown thruster.
    """
    names = [thruster.name for thruster in config.thrusters]
    unknown = [name for name in lost if name not in names]
    if unknown:
        raise ConfigError([f"{config.name}: no thruster named {', '.join(unknown)}; it has {', '.join(names)}"])
    if config.thrusters[0].kind == "jet":
        raise ConfigError([f"{config.name}: a jet pushes only ahead, so there is no wind that it holds against"])
    if config.has_rudder:
        text = "a rudder turns the boat only in flow, so there is no wind that it holds against without moving"
        raise ConfigError([f"{config.name}: {text}"])
    if config.has_sail:
        raise ConfigError([f"{config.name}: a sail needs the wind: the speed polar is in the page on sailing"])
    if config.windage.lateral_m2 <= 0.0 or config.windage.frontal_m2 <= 0.0:
        raise ConfigError([f"{config.name}: [windage] gives no areas, so no wind pushes it; add them"])
    angles = tuple(2.0 * math.pi * k / directions for k in range(directions))
    failed = [names.index(name) for name in lost]
    balance = _Balance(config, failed)
    winds = tuple(_strongest(balance, angle, current_mps) for angle in angles)
    return Capability(angles, winds, tuple(lost), current_mps, config.limits.sway_n <= 0.0)


class _Balance:
    """Whether the thrusters can give a wrench. Each question begins with the thrusters at rest."""

    def __init__(self, config: VesselConfig, failed: Sequence[int]) -> None:
        self.config, self._failed = config, failed
        self._parameters = Parameters(config.parameters, table_of(config))

    def holds(self, wrench: Wrench) -> bool:
        """Within the controller's limits, and given by the allocation after it has turned the thrusters."""
        limits = self.config.limits
        if abs(wrench.surge_n) > limits.surge_n or abs(wrench.yaw_nm) > limits.yaw_nm:
            return False
        tolerance = 0.01 if limits.sway_n > 0.0 else 1e-6  # no sideways thrust: only the rounding of 0
        if abs(wrench.sway_n) > limits.sway_n + tolerance * limits.surge_n:
            return False
        allocator = Allocator(self.config, self._parameters)
        for index in self._failed:
            allocator.set_failed(index, True)
        return any(not any(allocator.update(wrench, _TURNS_S).limited) for _ in range(_TURNS))

    def against(self, wind_mps: float, from_rad: float, current_mps: float) -> Wrench:
        """The wrench that balances wind and current from a direction relative to the bow."""
        current = -current_mps * math.cos(from_rad), -current_mps * math.sin(from_rad)
        return wrench_against(self.config, wind_mps, from_rad, current)


def _strongest(balance: _Balance, from_rad: float, current_mps: float) -> float:
    """The strongest wind that is held, by halving."""
    if not balance.holds(balance.against(0.0, from_rad, current_mps)):
        return 0.0
    low, high = 0.0, MOST_MPS
    if balance.holds(balance.against(high, from_rad, current_mps)):
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if balance.holds(balance.against(middle, from_rad, current_mps)) else (low, middle)
    return low


def summary(found: Capability) -> str:
    """Lines for people: the wind by direction every 30 degrees, and what is held from everywhere."""
    lost = f" without {', '.join(found.lost)}" if found.lost else ""
    current = f", current {found.current_mps:g} m/s from the same direction" if found.current_mps else ""
    lines = [f"wind held at a fixed heading{lost}{current}: {found.least_mps:.1f} m/s from every direction"]
    if found.bow_only:
        lines = [
            f"wind held at a fixed heading{lost}{current}. This boat has no sideways thrust,",
            "so it turns its bow to the wind: `companion check` prints the wind in which it can",
        ]
    step = max(1, len(found.from_rad) // 12)
    for angle, wind in list(zip(found.from_rad, found.wind_mps, strict=True))[::step]:
        more = " or more" if wind >= MOST_MPS else ""
        lines.append(f"  from {math.degrees(angle):3.0f} deg: {wind:5.1f} m/s{more}")
    return "\n".join(lines)


def plot(title: str, curves: Sequence[tuple[str, Capability]], out: Path | TextIO) -> None:
    """A polar picture with a curve for each (label, capability), as PNG into a file or as SVG into a text stream.

    Raises ImportError without matplotlib.
    """
    figure = new_figure(7.0, 7.0)
    axes = figure.add_subplot(projection="polar")
    axes.set_theta_zero_location("N")  # type: ignore[attr-defined]
    axes.set_theta_direction(-1)  # type: ignore[attr-defined]
    for number, (label, one) in enumerate(curves):
        angles, winds = (*one.from_rad, one.from_rad[0] + 2.0 * math.pi), (*one.wind_mps, one.wind_mps[0])
        last = number == len(curves) - 1  # thin and whole, so that one below it shows
        axes.plot(angles, winds, label=label, linewidth=1.2 if last else 3.0, linestyle="-" if last else "--")
        axes.fill(angles, winds, alpha=0.08)
    axes.set_title(f"{title}: wind held, m/s, by its direction from the bow")
    axes.legend(loc="lower right")
    figure.savefig(out, dpi=100, format="png" if isinstance(out, Path) else "svg")
