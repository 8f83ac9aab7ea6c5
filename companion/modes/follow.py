"""Follow: keeps a station on the lead boat."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.core.types import ModeId, Setpoint, SetpointKind
from companion.modes.mode import Mode, ModeInputs
from companion.params import Parameters

_GAP_GAIN_1PS = 0.2


class FollowMode(Mode):
    """Pursuit of the lead boat at FLW_TGT_DST."""

    id = ModeId.FOLLOW
    text = "Follows the lead boat"
    early = True  # ground stations tell of their place only once the boat is in Follow

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters

    def check(self, inputs: ModeInputs) -> str | None:
        return inputs.leader_fault or ("no leader heard" if inputs.leader is None else None)

    def enter(self, inputs: ModeInputs) -> str | None:
        return self.check(inputs)

    def update(self, inputs: ModeInputs) -> Setpoint:
        nav, leader = inputs.nav, inputs.leader
        assert leader is not None
        north_m, east_m = leader.north_m - nav.north_m, leader.east_m - nav.east_m
        gap_m = math.hypot(north_m, east_m) - self._parameters["FLW_TGT_DST"]
        speed = math.hypot(leader.north_mps, leader.east_mps) + _GAP_GAIN_1PS * gap_m
        return Setpoint(
            SetpointKind.PATH,
            north_m=nav.north_m,
            east_m=nav.east_m,
            yaw_rad=math.atan2(east_m, north_m),
            surge_mps=min(self._parameters["MPC_XY_VEL_MAX"], max(0.0, speed)),
            target_north_m=leader.north_m,
            target_east_m=leader.east_m,
            distance_to_go_m=gap_m,
        )
