"""Which axes get less than is demanded."""

from __future__ import annotations

from companion.config.vessel import LimitsConfig
from companion.core.actuation import Wrench

LIMITED_SHARE = 0.01
"""Of an axis's limit, from which a shortfall counts."""


def limited_axes(demanded: Wrench | None, achieved: Wrench, limits: LimitsConfig) -> tuple[bool, bool, bool]:
    """(surge, sway, yaw) that fall short; an axis without a limit never does. `demanded` None: none does."""
    if demanded is None:
        return False, False, False
    return (
        abs(demanded.surge_n - achieved.surge_n) > LIMITED_SHARE * limits.surge_n,
        limits.sway_n > 0.0 and abs(demanded.sway_n - achieved.sway_n) > LIMITED_SHARE * limits.sway_n,
        abs(demanded.yaw_nm - achieved.yaw_nm) > LIMITED_SHARE * limits.yaw_nm,
    )
