"""Follow: keeps a station on the lead boat."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.core.types import ModeId, Setpoint
from companion.guidance.follow import FollowLaw
from companion.modes.mode import Mode, ModeInputs
from companion.modes.propulsion import can_reverse
from companion.params import Parameters


class FollowMode(Mode):
    """Along the track of the lead boat, or beside it."""

    id = ModeId.FOLLOW
    text = "Follows the lead boat"
    early = True  # ground stations tell of their place only once the boat is in Follow

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self.law = FollowLaw(config, parameters, can_reverse(config.thrusters))

    def check(self, inputs: ModeInputs) -> str | None:
        return inputs.leader_fault or ("no leader heard" if inputs.leader is None else None)

    def enter(self, inputs: ModeInputs) -> str | None:
        if (reason := self.check(inputs)) is not None:
            return reason
        assert inputs.leader is not None
        self.law.start(inputs.nav, inputs.leader, inputs.now_s)
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        nav, leader = inputs.nav, inputs.leader
        assert leader is not None
        motion = self.law.update(nav, leader, inputs.now_s)
        return self.law.setpoint(motion, nav, inputs.dt_s)
