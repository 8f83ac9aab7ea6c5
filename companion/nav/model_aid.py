"""What the hull model tells the estimate: the current, a velocity while none is measured, the boat's motion in waves,
and which speed is impossible."""

from __future__ import annotations

import math

from companion.config.hull import AT_HULL_SHARE
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import NavigatedBoat, VesselConfig
from companion.core.actuation import Wrench
from companion.core.estimate import Air, WaveMotion
from companion.core.frames import ned_to_body
from companion.nav.current import CurrentObserver, GroundMotion
from companion.nav.solution import Motion
from companion.nav.validity import Validity
from companion.nav.velocity_aid import ModelledVelocity, VelocityAid
from companion.nav.wave_motion import WaveObserver
from companion.params.store import Parameters

_TOP_SPEEDS, _PUSHED_MPS = 2.0, 5.0  # a boat is slower than that many times its top speed, and what current and sea add
_FASTEST_MPS = 60.0  # where no hull model tells the top speed
_CURRENT_AGE_S = 1.0  # age of the position up to which the velocity counts as measured
_AID_AGE_S = 0.2  # age of position and velocity above which neither counts as measured for the aid


class ModelAid:
    """Call `observe` every tick, then `velocity` while an inertial sensor carries the motion. A boat without a hull
    model (a lead boat) has no current, no such velocity and no waves. Remembers the observers of current and waves."""

    def __init__(self, config: NavigatedBoat, parameters: Parameters) -> None:
        self._vessel = config if isinstance(config, VesselConfig) else None
        self._parameters = parameters
        self._impossible_mps = _impossible_mps(self._vessel)
        self._waves = None if self._vessel is None else WaveObserver(self._vessel.hull, self._vessel.length_m)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget the current, and how wrong the model was."""
        self.current = None if self._vessel is None else CurrentObserver(self._vessel)
        self._aid = None if self.current is None else VelocityAid(self.current)

    def is_impossible(self, motion: Motion) -> bool:
        """Whether the boat cannot be as fast."""
        return math.hypot(motion.velocity[0], motion.velocity[1]) > self._impossible_mps

    def observe(
        self, now_s: float, thrust: Wrench | None, motion: Motion | None, air: Air | None, validity: Validity
    ) -> None:
        """Take a tick. `thrust`: on the hull since the last one, None if unknown; `motion`: None while it is unknown or
        impossible; `air`: the true wind, None if unknown."""
        if self.current is None:
            return
        passage = None
        if motion is not None:
            north, east = (None, None) if air is None else air
            velocity = motion.velocity
            passage = GroundMotion(velocity[0], velocity[1], motion.attitude[2], motion.rates[2], north, east)
        measured = now_s - validity.position_s <= _CURRENT_AGE_S or validity.carried(now_s)
        self.current.update(now_s, thrust, passage, measured)

    def velocity(self, now_s: float, motion: Motion, validity: Validity) -> ModelledVelocity | None:
        """As `VelocityAid.update`, after `observe`."""
        if self._aid is None:
            return None
        return self._aid.update(now_s, validity.unmeasured_s(now_s) <= _AID_AGE_S, motion)

    def waves(self, now_s: float, thrust: Wrench | None, motion: Motion, air: Air | None) -> WaveMotion | None:
        """As `WaveObserver.update`; None where DP_WAVES is off."""
        parameters = self._parameters
        if self._waves is None or not parameters["DP_WAVES"]:
            return None
        place_radps = max(parameters["DP_BW_SURGE"], parameters["DP_BW_SWAY"])
        current = None if self.current is None else self.current.estimate(now_s)
        water = (0.0, 0.0) if current is None else current[:2]
        wind = self._wind_force(motion, air)
        return self._waves.update(now_s, thrust, motion, (place_radps, parameters["DP_BW_YAW"]), water, wind)

    def _wind_force(self, motion: Motion, air: Air | None) -> Wrench | None:
        """Of the wind on the hull; None if it is unknown."""
        vessel = self._vessel
        if vessel is None or air is None:
            return None
        north_mps, east_mps = air[0] - motion.velocity[0], air[1] - motion.velocity[1]
        x_mps, y_mps = ned_to_body(north_mps, east_mps, motion.attitude[2])
        return Wrench(*vessel.windage.force(x_mps, y_mps, vessel.length_m, AT_HULL_SHARE))


def _impossible_mps(vessel: VesselConfig | None) -> float:
    """A speed over ground that the boat cannot have."""
    top_mps = math.inf if vessel is None else top_speed_mps(vessel)
    return min(_TOP_SPEEDS * top_mps + _PUSHED_MPS, _FASTEST_MPS)
