"""What positioning does as its wind sensor falls silent or comes back: the bias takes over what was fed forward, and
gives it back. Without that the boat loses, or has twice, all of the force against the wind at once."""

from __future__ import annotations

from companion.control.bias import BiasForce
from companion.core.frames import body_to_ned, ned_to_body

_MEAN_S = 20.0  # a gust does not last
_RETURN_S = 10.0  # for which a wind that is back is only looked at: a gust would be given back for the mean

Force = tuple[float, float, float]
_NONE: Force = (0.0, 0.0, 0.0)


class WindHandover:
    """`update` every cycle → what to feed forward against. Remembers the mean force (north, east) and moment of the
    wind, for how long it was taken, whether the wind was known, and whether and what is fed forward.

    Of the last update: `gone_nm`, by how much less of the wind's moment is fed forward, where it `changed`;
    `handed_nm`, how much of it the bias has taken over, negative: given back; `came`: whether the wind has become known
    or unknown, None: neither."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the wind: the next update hands nothing over."""
        self._mean = _NONE
        self._taken_s = 0.0
        self._known: bool | None = None
        self._used = self._changed = False
        self._fed = _NONE
        self.handed_nm = self.gone_nm = 0.0
        self.came: bool | None = None

    @property
    def changed(self) -> bool:
        """Whether the wind came, went or was handed over in the last update."""
        return self._changed

    def update(self, wind: Force | None, bias: BiasForce, yaw_rad: float, dt_s: float) -> Force:
        """`wind`: its (surge_n, sway_n, yaw_nm) on the hull; None while it is not known. The same, or zeros while it is
        not fed forward."""
        before, self._known = self._known, wind is not None
        self._changed = before is not None and before != self._known
        self.came, self.handed_nm, fed_nm = (self._known if self._changed else None), 0.0, self._fed[2]
        if self._changed:
            self._leave(bias, yaw_rad)
        self._fed = _NONE if wind is None else self._feed(wind, bias, yaw_rad, dt_s, before is None)
        self.gone_nm = fed_nm - self._fed[2] if self._changed else 0.0
        return self._fed

    def _feed(self, wind: Force, bias: BiasForce, yaw_rad: float, dt_s: float, first: bool) -> Force:
        """What is fed forward against a known wind. `first`: it was known from the beginning."""
        self._take(wind, yaw_rad, dt_s)
        if not self._used and not first and self._taken_s >= _RETURN_S:
            self._hand(bias, yaw_rad, -1.0)
            self._changed = self._used = True
        self._used = self._used or first
        return wind if self._used else _NONE

    def _hand(self, bias: BiasForce, yaw_rad: float, share: float) -> None:
        """To the bias (1) or back (−1)."""
        x, y = ned_to_body(self._mean[0], self._mean[1], yaw_rad)
        self.handed_nm = share * self._mean[2]
        bias.add(-share * x, -share * y, -self.handed_nm, yaw_rad)

    def _leave(self, bias: BiasForce, yaw_rad: float) -> None:
        """Take the mean anew; the bias takes over what was fed forward."""
        if self._used:
            self._hand(bias, yaw_rad, 1.0)
        self._taken_s, self._used = 0.0, False

    def _take(self, wind: Force, yaw_rad: float, dt_s: float) -> None:
        self._taken_s = min(_MEAN_S, self._taken_s + dt_s)
        share = dt_s / self._taken_s if self._taken_s > 0.0 else 0.0
        north, east = body_to_ned(wind[0], wind[1], yaw_rad)
        mean_north, mean_east, mean_nm = self._mean
        self._mean = (
            mean_north + share * (north - mean_north),
            mean_east + share * (east - mean_east),
            mean_nm + share * (wind[2] - mean_nm),
        )
