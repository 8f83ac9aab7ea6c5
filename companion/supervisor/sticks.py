"""The sticks of ground station and transmitter: which are live, and whether they were centred once before they steer.
Whose sticks count is in `authority.py`."""

from __future__ import annotations

import math

from companion.core.readings import ManualInput, RcInput
from companion.params.store import Parameters
from companion.supervisor.authority import Facts, Right, sticks_in_charge

_CENTRED = 0.15
_SWITCH_ON = 0.5
_SWITCH_OFF = 0.2


def is_centred(manual: ManualInput) -> bool:
    """Whether no axis is off centre by more than 15 %."""
    return all(axis is None or abs(axis) <= _CENTRED for axis in (manual.surge, manual.sway, manual.yaw))


class Sticks:
    """Remembers the last sticks of the ground stations and of the transmitter.

    RC_MAP_ROLL, PITCH, THROTTLE and YAW name the transmitter's channels for sway, surge, surge and yaw, positive to
    starboard and ahead; MAN_AXIS_SURGE chooses between the two for surge. `safe_switch`: as last seen.
    `remote_system`: the lead boat that steers by remote, None for none; its sticks come as a ground station's. `heard`:
    sticks were heard once. Sticks that take over from others must be centred first, and so must the first ones of all.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._last: dict[Right, ManualInput | None] = {Right.GROUND_STATION: None, Right.TRANSMITTER: None}
        self._must_centre = False
        self._awaited = False  # the centre was demanded while no sticks were live
        self._read_s = -math.inf  # of the transmitter's reading that was taken last
        self._hand: tuple[Right, str] | None = None  # whose sticks were live last
        self._remote_s = -math.inf  # since when the lead boat steers by remote
        self.remote_system: int | None = None
        self.safe_switch = False
        self.heard = False
        self._asked_of: tuple[bool, int | None] | None = None  # safe switch and remote system,
        self._rights: tuple[Right, ...] = ()  # and whose sticks may steer by them

    def ground_station_input(self, manual: ManualInput) -> None:
        """Sticks of the ground station that steers; ignored if a value is not a number."""
        axes = (manual.surge, manual.sway, manual.yaw)
        if all(axis is None or math.isfinite(axis) for axis in axes) and math.isfinite(manual.t_s):
            self._last[Right.GROUND_STATION] = manual
            self.heard = True

    def hand_over(self, now_s: float, remote_system: int | None) -> None:
        """From now on that lead boat steers by remote; None: no lead boat does. Sticks must be centred first."""
        self._last[Right.GROUND_STATION] = None
        self.remote_system = remote_system
        self._remote_s = -math.inf if remote_system is None else now_s
        self.heard = self.heard or remote_system is not None
        self.demand_centre(now_s)

    def update(self, rc: RcInput | None, now_s: float) -> bool:
        """Take in the transmitter, whose channels are calibrated. A switch whose signal is lost keeps its last position
        until an operator overrules it. Returns whether sticks that are off centre take over now: from others, or as the
        first since `demand_centre`."""
        if not self._parameters["MAN_RC_SAFE_CH"]:
            self.safe_switch = False
        if rc is not None and rc.t_s > self._read_s and not rc.lost and all(map(math.isfinite, rc.channels)):
            self._read_s = rc.t_s
            self._take(rc)
        right, live = next(((r, m) for r, m in self._in_charge() if self._fresh(m, now_s)), (None, None))
        if right is None or live is None:
            return False
        before, self._hand = self._hand, (right, live.source)
        first, self._awaited = self._awaited, False
        taken_over = (first or before not in (None, self._hand)) and not is_centred(live)
        self._must_centre = taken_over or (self._must_centre and not is_centred(live))
        return taken_over

    def _take(self, rc: RcInput) -> None:
        """Sticks whose channel is missing make the whole transmitter unusable; a channel of 0 leaves its axis out."""
        names = (
            "RC_MAP_THROTTLE" if self._parameters["MAN_AXIS_SURGE"] else "RC_MAP_PITCH",
            "RC_MAP_ROLL",
            "RC_MAP_YAW",
        )
        numbers = [int(self._parameters[name]) for name in names]
        if max(numbers) > len(rc.channels):
            return
        surge, sway, yaw = (rc.channels[number - 1] if number else None for number in numbers)
        self._last[Right.TRANSMITTER] = ManualInput(rc.t_s, rc.source, surge, sway, yaw)
        self.heard = True
        self._read_switch(rc)

    def _read_switch(self, rc: RcInput) -> None:
        channel = int(self._parameters["MAN_RC_SAFE_CH"])
        if 1 <= channel <= len(rc.channels):
            self.safe_switch = rc.channels[channel - 1] > (_SWITCH_OFF if self.safe_switch else _SWITCH_ON)

    def transmitter_live(self, now_s: float) -> bool:
        """Whether the transmitter was heard within COM_RC_LOSS_T."""
        return self._fresh(self._last[Right.TRANSMITTER], now_s)

    def transmitter(self, now_s: float) -> ManualInput | None:
        """The transmitter's sticks, in charge or not; None once it has been silent for COM_RC_LOSS_T."""
        manual = self._last[Right.TRANSMITTER]
        return manual if self._fresh(manual, now_s) else None

    def live(self, now_s: float) -> ManualInput | None:
        """The sticks in charge, wherever they stand; None if they have been silent for COM_RC_LOSS_T."""
        return next((manual for _, manual in self._in_charge() if self._fresh(manual, now_s)), None)

    def obeyed(self, now_s: float) -> ManualInput | None:
        """The sticks in charge, once they may steer."""
        return None if self._must_centre else self.live(now_s)

    def demand_centre(self, now_s: float) -> None:
        """Sticks that are off centre now must be seen centred before they are obeyed; where none is heard now, those
        that come first."""
        live = self.live(now_s)
        self._awaited = live is None
        self._must_centre = live is None or not is_centred(live)

    @property
    def must_centre(self) -> bool:
        """Whether the sticks must be centred before they steer."""
        return self._must_centre

    def age_s(self, now_s: float) -> float:
        """Since the sticks in charge were last heard; infinite before that."""
        since_s = -math.inf if self.safe_switch else self._remote_s
        heard_s = (manual.t_s for _, manual in self._in_charge() if manual is not None)
        return now_s - max(since_s, *heard_s, -math.inf)

    def overrule_silent_switch(self, now_s: float) -> None:
        """An operator takes over: the switch of a transmitter that is silent counts no more."""
        if not self.transmitter_live(now_s):
            self.safe_switch = False

    def _in_charge(self) -> list[tuple[Right, ManualInput | None]]:
        given = self.safe_switch, self.remote_system
        if given != self._asked_of:
            facts = Facts(safe_switch=self.safe_switch, remote_system=self.remote_system)
            self._asked_of, self._rights = given, sticks_in_charge(facts)
        return [(right, self._last[right]) for right in self._rights]

    def _fresh(self, manual: ManualInput | None, now_s: float) -> bool:
        return manual is not None and now_s - manual.t_s <= self._parameters["COM_RC_LOSS_T"]
