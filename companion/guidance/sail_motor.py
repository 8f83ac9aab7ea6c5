"""When a boat with a sail uses the motors beside it."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.guidance.sail_wind import SailWind
from companion.params.sailing import BY_MOTOR_ALONE, WITHOUT_WIND
from companion.params.store import Parameters


class SailMotor:
    """`update` once a tick. `drives`: the motors push, and the boat goes where it wants, against the wind too. `alone`:
    they push without the sail, whose sheet is free. `exists`: there is a motor.

    Remembers whether they push, to announce a change.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, say: Announce) -> None:
        self._parameters, self._say = parameters, say
        self.exists = len(config.thrusters) > 1
        self.drives = self.alone = False

    def update(self, wind: SailWind, now_s: float) -> None:
        """Decide by SAIL_MOTOR and by the wind, and say when that changes."""
        if not self.exists:
            return
        use = self._parameters["SAIL_MOTOR"]
        self.alone = use == BY_MOTOR_ALONE
        drives = self.alone or (use == WITHOUT_WIND and (wind.light or wind.failed))
        if drives is not self.drives:
            text = ("By motor, sheet free" if self.alone else "By motor: no wind") if drives else "Under sail"
            self._say(now_s, TextKind.ROUTINE, "sail_motor", text)
        self.drives = drives
