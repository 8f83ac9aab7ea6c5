"""Which sticks steer, and whether they may: ground station or hand-held transmitter, live, and centred once before they are obeyed."""

from __future__ import annotations

import math

from companion.core.types import ManualInput, RcInput
from companion.params import Parameters

_CENTRED = 0.15
_SWITCH_ON = 0.5
_SWITCH_OFF = 0.2


def beyond_deadband(value: float | None, deadband: float) -> float:
    """−1…1 with the share `deadband` around the centre as 0 and the rest stretched; 0 for an axis that is not there."""
    if value is None or abs(value) <= deadband:
        return 0.0
    return math.copysign(min(1.0, (abs(value) - deadband) / (1.0 - deadband)), value)


def is_centred(manual: ManualInput) -> bool:
    return all(axis is None or abs(axis) <= _CENTRED for axis in (manual.surge, manual.sway, manual.yaw))


class Sticks:
    """Remembers the last sticks of the ground stations and of the transmitter.

    The transmitter's channels are 1 sway, 2 surge, 3 throttle, 4 yaw, positive to starboard and ahead; MAN_AXIS_SURGE chooses between 2 and 3.
    While its safe switch is on, only the transmitter counts. Otherwise the ground station's sticks come first, and are the only ones while they are
    reserved (for a lead boat that steers by remote). `live` is None when all have been silent for COM_RC_LOSS_T.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._station: ManualInput | None = None
        self._transmitter: ManualInput | None = None
        self._must_centre = False
        self._reserved_s: float | None = None  # since when
        self.safe_switch = False
        self.heard = False

    def station_input(self, manual: ManualInput) -> None:
        """Sticks of a ground station; what is not a number is dropped whole."""
        if all(axis is None or math.isfinite(axis) for axis in (manual.surge, manual.sway, manual.yaw)) and math.isfinite(manual.t_s):
            self._station = manual
            self.heard = True

    def hand_over(self, now_s: float, reserved: bool) -> None:
        """Somebody else sends the station's sticks from now on, the only ones if `reserved`: they must be seen centred before they are obeyed."""
        self._station = None
        self._reserved_s = now_s if reserved else None
        self.heard = self.heard or reserved
        self.demand_centre(now_s, even_if_silent=True)

    def update(self, rc: RcInput | None, now_s: float) -> None:
        """Take in the transmitter. A switch whose signal is lost stays where it was last seen, until an operator releases it."""
        usable = rc is not None and not rc.lost and len(rc.channels) >= 4 and all(map(math.isfinite, rc.channels))
        if rc is not None and usable:
            surge = rc.channels[2] if self._parameters["MAN_AXIS_SURGE"] else rc.channels[1]
            self._transmitter = ManualInput(rc.t_s, rc.source, surge, rc.channels[0], rc.channels[3])
            self.heard = True
            self._read_switch(rc)
        live = self.live(now_s)
        if self._must_centre and live is not None and is_centred(live):
            self._must_centre = False

    def _read_switch(self, rc: RcInput) -> None:
        channel = int(self._parameters["MAN_RC_SAFE_CH"])
        if channel == 0:
            self.safe_switch = False
        elif channel <= len(rc.channels):
            self.safe_switch = rc.channels[channel - 1] > (_SWITCH_OFF if self.safe_switch else _SWITCH_ON)

    def transmitter_live(self, now_s: float) -> bool:
        return self._fresh(self._transmitter, now_s)

    def live(self, now_s: float) -> ManualInput | None:
        """The sticks in charge, wherever they stand."""
        if not self.safe_switch and self._fresh(self._station, now_s):
            return self._station
        if self._reserved_s is not None and not self.safe_switch:
            return None
        return self._transmitter if self._fresh(self._transmitter, now_s) else None

    def obeyed(self, now_s: float) -> ManualInput | None:
        """The sticks in charge, once they may steer."""
        return None if self._must_centre else self.live(now_s)

    def demand_centre(self, now_s: float, even_if_silent: bool) -> None:
        """Sticks that are off centre now must be seen centred before they are obeyed; `even_if_silent`: sticks that come later must too."""
        live = self.live(now_s)
        self._must_centre = even_if_silent if live is None else not is_centred(live)

    @property
    def must_centre(self) -> bool:
        return self._must_centre

    def age_s(self, now_s: float) -> float:
        """Since the sticks in charge were last heard; infinite before that."""
        if self._reserved_s is not None and not self.safe_switch:
            return now_s - max(self._reserved_s, -math.inf if self._station is None else self._station.t_s)
        sources = (self._transmitter,) if self.safe_switch else (self._station, self._transmitter)
        return min((now_s - source.t_s for source in sources if source is not None), default=math.inf)

    def release_switch(self) -> None:
        """An operator has taken over from a transmitter that is silent with its switch on."""
        self.safe_switch = False

    def _fresh(self, manual: ManualInput | None, now_s: float) -> bool:
        return manual is not None and now_s - manual.t_s <= self._parameters["COM_RC_LOSS_T"]
