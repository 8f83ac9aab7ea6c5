"""A sailing rig: the sail on its sheet, the rudder, the keel, and the heel that they make.

As in models of sailing yachts in four degrees of freedom (Xiao and Jouffroy 2014): lift across the apparent wind and
drag along it, by the angle between wind and boom. The wind carries the boom to leeward as far as the sheet lets it. A
heeled rig has the side force times cos φ, and its centre to leeward by its height times sin φ, which turns the bow to
windward. Coefficients: `sitl.foil`. Assumed of a soft sail: it fills 5° off the wind and stalls at 18°, with C_L 1.4 at
an aspect ratio of 2.5; luffing it has drag alone. Of a wing: symmetric, stalls at 15°. At an aspect ratio of 5 that is
C_L 1.2; computed for a NACA 0020 with a tail: 1.16 (J. Mar. Sci. Eng. 13(9), 1640, 2025).
"""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.hull import AIR_KGPM3
from companion.config.rudder import RudderConfig
from companion.config.sail import KeelConfig, SailConfig
from sitl.foil import Foil
from sitl.thrusters import ThrusterModel

_STALL_RAD, _CAMBER_RAD, _FILLED_RAD = math.radians(18.0), math.radians(5.0), math.radians(5.0)
_WING_STALL_RAD = math.radians(15.0)
_RIG_DRAG, _LUFFING_DRAG = 0.04, 0.1
_FIN_STALL_RAD, _FIN_DRAG = math.radians(18.0), 0.01
_IN_THE_HULL = 2.0  # the hull doubles the aspect ratio of a fin below it
_DOWNWASH = 0.3  # share of the keel's angle by which it turns the flow at the rudder
_HEEL_S = 0.7  # in which the boat heels
_BOOM_SHARE = 0.4  # of the sail's width from the mast to the centre of its force
_SLOWEST_MPS = 1.0e-3


class SailRig(ThrusterModel):
    """As `ThrusterModel`: `throttle` is the sheet, 0 free to 1 hauled in, with the winch's lag, and `azimuth_rad` the
    rudder's angle, positive where it pushes to starboard. `feel` gives the wind, then `step`. `heel_rad`: to starboard.
    A wing turns to the wind at once, and by its throttle from there.
    """

    __slots__ = ("_air", "_blade", "_fin", "_keel", "_lever_m", "_sail", "_set", "_width_m", "_wrench", "heel_rad")

    def __init__(
        self,
        config: ThrusterConfig,
        lag_s: float,
        sail: SailConfig,
        rudder: RudderConfig,
        keel: KeelConfig | None,
    ) -> None:
        super().__init__(config, lag_s)
        self._sail, self._keel = sail, keel
        self._set = (
            Foil(sail.aspect, _STALL_RAD, _RIG_DRAG, _CAMBER_RAD, _FILLED_RAD, _LUFFING_DRAG)
            if sail.attack_max_rad is None
            else Foil(sail.aspect, _WING_STALL_RAD, _RIG_DRAG)
        )
        self._width_m = math.sqrt(sail.area_m2 / sail.aspect)
        self._blade = Foil(_IN_THE_HULL * rudder.aspect, _FIN_STALL_RAD, _FIN_DRAG)
        self._lever_m = rudder.x_m
        self._fin = None if keel is None else Foil(_IN_THE_HULL * keel.span_m / keel.chord_m, _FIN_STALL_RAD, _FIN_DRAG)
        self._air = (0.0, 0.0)
        self.heel_rad = 0.0
        self._wrench = (0.0, 0.0, 0.0)

    def feel(self, ahead_mps: float, starboard_mps: float) -> None:
        """The velocity of the air past the boat, in body axes."""
        self._air = (ahead_mps, starboard_mps)

    def step(self, dt_s: float, surge_mps: float = 0.0, sway_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> None:
        """Advance by `dt_s` at that velocity through the water."""
        super().step(dt_s, surge_mps)
        upright = math.cos(self.heel_rad)
        drive_n, push_n, centre_m = self._of_sail(upright)
        capsizing_nm = self._sail.height_m * push_n
        to_rad = math.atan2(capsizing_nm, self._sail.righting_nm)
        self.heel_rad += min(1.0, dt_s / _HEEL_S) * (to_rad - self.heel_rad)
        leeward_m = centre_m + self._sail.height_m * math.sin(self.heel_rad)
        push_n *= upright
        yaw_nm = self._sail.x_m * push_n - leeward_m * drive_n
        keel_rad = 0.0
        if self._fin is not None and self._keel is not None:
            area_m2 = self._keel.span_m * self._keel.chord_m
            side = sway_mps + self._keel.x_m * yaw_rate_radps
            x_n, y_n, keel_rad = _in_water(self._fin, area_m2 * upright, 0.0, surge_mps, side)
            drive_n, push_n, yaw_nm = drive_n + x_n, push_n + y_n, yaw_nm + self._keel.x_m * y_n
        rudder = self.config.rudder
        if rudder is not None:
            side = sway_mps + self._lever_m * yaw_rate_radps
            straightened = self.azimuth_rad + _DOWNWASH * keel_rad
            area_m2 = rudder.area_m2 * rudder.lift_scale * upright
            x_n, y_n, _ = _in_water(self._blade, area_m2, straightened, surge_mps, side)
            drive_n, push_n, yaw_nm = drive_n + x_n, push_n + y_n, yaw_nm + self._lever_m * y_n
        self._wrench = (drive_n, push_n, yaw_nm)

    def wrench(self) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) of sail, keel and rudder on the hull."""
        return self._wrench

    def _of_sail(self, upright: float) -> tuple[float, float, float]:
        """(surge, force to starboard upright, centre to starboard of the middle): of the sail in the apparent wind."""
        ahead, across = self._air[0], self._air[1] * upright
        speed = math.hypot(ahead, across)
        if speed < _SLOWEST_MPS:
            return 0.0, 0.0, 0.0
        if self._sail.attack_max_rad is not None:
            return *self._of_wing(ahead, across, speed, self._sail.attack_max_rad), 0.0
        off_rad = abs(math.atan2(across, -ahead))  # of the wind from the bow
        leeward = 1.0 if across > 0.0 else -1.0
        boom_rad = min(off_rad, self._sail.boom_rad(self.throttle()))
        lift, drag = self._set.coefficients(off_rad - boom_rad)
        pressure = 0.5 * AIR_KGPM3 * self._sail.area_m2 * self._sail.force_scale * speed * speed
        s, c = math.sin(off_rad), math.cos(off_rad)
        centre_m = leeward * _BOOM_SHARE * self._width_m * math.sin(boom_rad)
        return pressure * (lift * s - drag * c), leeward * pressure * (lift * c + drag * s), centre_m

    def _of_wing(self, ahead: float, across: float, speed: float, attack_max_rad: float) -> tuple[float, float]:
        """(surge, force to starboard upright): lift is across the wind, to starboard of one from ahead."""
        lift, drag = self._set.coefficients(self.throttle() * attack_max_rad)
        pull = 0.5 * AIR_KGPM3 * self._sail.area_m2 * self._sail.force_scale * speed
        return pull * (lift * across + drag * ahead), pull * (drag * across - lift * ahead)


def _in_water(
    foil: Foil, area_m2: float, angle_rad: float, surge_mps: float, sway_mps: float
) -> tuple[float, float, float]:
    """(surge, sway, angle of the flow) of a fin turned by `angle_rad`, positive where it pushes to starboard ahead,
    that moves through the water with that velocity."""
    speed = math.hypot(surge_mps, sway_mps)
    drift_rad = math.atan2(sway_mps, surge_mps)
    if speed < _SLOWEST_MPS:
        return 0.0, 0.0, 0.0
    lift, drag = foil.coefficients(angle_rad - drift_rad)
    pressure = 0.5 * WATER_KGPM3 * area_m2 * speed * speed
    s, c = math.sin(drift_rad), math.cos(drift_rad)
    return pressure * (-lift * s - drag * c), pressure * (lift * c - drag * s), drift_rad


def rig_of(config: ThrusterConfig, lag_s: float, keel: KeelConfig | None) -> SailRig | None:
    """The rig of a thruster of kind "sail"; None for another kind."""
    if config.sail is None or config.rudder is None:
        return None
    return SailRig(config, lag_s, config.sail, config.rudder, keel)
