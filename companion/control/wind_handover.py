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
    wind, for how long it was taken, whether the wind was known, and whether it is fed forward."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the wind: the next update hands nothing over."""
        self._mean = _NONE
        self._taken_s = 0.0
        self._known: bool | None = None
        self._used = self._changed = False

    @property
    def changed(self) -> bool:
        """Whether the wind came, went or was handed over in the last update."""
        return self._changed

    def update(self, wind: Force | None, bias: BiasForce, yaw_rad: float, dt_s: float) -> Force:
        """`wind`: its (surge_n, sway_n, yaw_nm) on the hull; None while it is not known. The same, or zeros while it is
        not fed forward."""
        before, self._known = self._known, wind is not None
        self._changed = before is not None and before != self._known
        if self._changed:
            self._leave(bias, yaw_rad)
        if wind is None:
            return _NONE
        self._take(wind, yaw_rad, dt_s)
        if before is None:
            self._used = True
        elif not self._used and self._taken_s >= _RETURN_S:
            x, y = ned_to_body(self._mean[0], self._mean[1], yaw_rad)
            bias.add(x, y, self._mean[2], yaw_rad)
            self._used = self._changed = True
        return wind if self._used else _NONE

    def _leave(self, bias: BiasForce, yaw_rad: float) -> None:
        """Take the mean anew; the bias takes over what was fed forward."""
        if self._used:
            x, y = ned_to_body(self._mean[0], self._mean[1], yaw_rad)
            bias.add(-x, -y, -self._mean[2], yaw_rad)
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
