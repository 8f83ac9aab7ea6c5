"""All that is known of obstacles around the boat: what ranging sensors see, radar targets, shoals; which of it moves,
and which sensor has fallen silent."""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from companion.config.reversing import can_reverse
from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import Contact, NavState
from companion.core.events import EventLog
from companion.core.frames import body_to_ned
from companion.core.geodesy import LocalFrame
from companion.core.readings import Depth, DepthAhead, RadarTarget, Ranges
from companion.obstacles.movers import Movers
from companion.obstacles.occupancy import Floats, Occupancy
from companion.obstacles.radar_targets import RadarTargets
from companion.obstacles.shoals import Shoals
from companion.params.store import Parameters

_SILENT_S = 2.0  # a sensor that sends less often is no help
_STANDS_S = 2.5  # a beam that looked one way for so long is not swept: it is missed there
_REACH_M = 300.0  # what is further off is forgotten
_TIDY_S = 1.0
_OWN_M = 0.3  # beyond the hull, within which a sensor sees the boat itself
_MOVER_M, _OLD_S = 1.0, 10.0  # around a mover, circles are its own, unless something has been there for longer
_MOST_PENDING = 50
_MOST_VIEWS = 100

Heard = Ranges | RadarTarget | DepthAhead
Part = tuple[str, int | None]
"""A ranging sensor and, of one with single beams, the direction of this beam in degrees: each may fall silent alone."""
SECTORS = 72
"""Of 5° each, in which displays are told what is around."""
_SECTORS_RAD = np.arange(SECTORS) * math.tau / SECTORS


@dataclass(frozen=True, slots=True)
class _View:
    """What a ranging sensor covers: its first and last sector as bearings, and how far it reaches. `part`: of it."""

    part: Part
    first_rad: float
    last_rad: float
    half_rad: float
    from_north: bool
    most_m: float


class Surroundings:
    """`take(reading)` as they come, `update(nav, depth, now_s)` once a tick.

    Remembers the readings that wait for the tick, the maps of its parts, and when each ranging sensor was heard.
    """

    def __init__(
        self, config: VesselConfig, parameters: Parameters, events: EventLog, frame: Callable[[], LocalFrame]
    ) -> None:
        self._config = config
        self._parameters = parameters
        self._events = events
        self._frame = frame
        self._pending: list[Heard] = []
        self._map = Occupancy()
        self._movers = Movers()
        self._radar = RadarTargets()
        coasts = not (can_reverse(config.thrusters) or config.has_sail)
        self.shoals = Shoals(config.length_m, parameters, coasts)
        self._heard_s: dict[Part, tuple[float, float]] = {}  # since when without a silence, and last
        self._spoke_s: dict[Part, float] = {}  # last, with ranges or without
        self._views: dict[tuple[str, int], _View] = {}  # by sensor and direction
        self._silent: frozenset[Part] = frozenset()
        self._tidied_s = -math.inf
        self._plane: LocalFrame | None = None
        self._jumps = 0

    @property
    def on(self) -> bool:
        """Whether obstacles count."""
        return self._parameters["CP_DIST"] >= 0.0

    @property
    def silent(self) -> tuple[str, ...]:
        """Names of ranging sensors, or of their beams, that have fallen silent; none while obstacles do not count."""
        return tuple(self._names(self._silent)) if self.on else ()

    @property
    def heard(self) -> bool:
        """Whether any ranging sensor has ever been heard."""
        return bool(self._heard_s)

    def take(self, reading: Heard, now_s: float) -> None:
        """A reading. It is entered with the estimate of the next tick."""
        if isinstance(reading, Ranges):
            beam = round(math.degrees(reading.first_rad)) % 360 if len(reading.distances_m) == 1 else None
            part = reading.source, beam
            self._spoke_s[part] = now_s
            since_s, last_s = self._heard_s.setdefault(part, (now_s, now_s))
            if not _is_blind(reading):
                self._heard_s[part] = since_s if now_s - last_s <= _SILENT_S else now_s, now_s
            self._note_view(reading, part)
        if len(self._pending) < _MOST_PENDING:
            self._pending.append(reading)

    def _note_view(self, reading: Ranges, part: Part) -> None:
        """Which directions the sensor covers."""
        if reading.step_rad > 0.0:
            if len(self._views) >= _MOST_VIEWS:
                self._views.clear()
            last = reading.first_rad + (len(reading.distances_m) - 1) * reading.step_rad
            view = _View(part, reading.first_rad, last, 0.5 * reading.step_rad, reading.from_north, reading.most_m)
            self._views[reading.source, round(reading.first_rad / view.half_rad)] = view

    def update(self, nav: NavState, depth: Depth | None, now_s: float) -> None:
        """Enter what has come, forget what is old, and say which sensors fall silent."""
        self._mind_silence(now_s)
        pending, self._pending = self._pending, []
        if not self.on or not nav.position_valid or not nav.heading_valid:
            return
        self._mind_plane(nav)
        for reading in pending:
            self._enter(reading, nav, now_s)
        self.shoals.update(depth, nav, now_s)
        if self.shoals.found is not None:
            text = f"Shoal: {self.shoals.found:.1f} m of water, turning back"
            self._events.say(now_s, TextKind.ATTENTION, "shoal", text)
        if now_s - self._tidied_s >= _TIDY_S:
            self._tidied_s = now_s
            self._map.forget(now_s, self._parameters["CP_FORGET"], (nav.north_m, nav.east_m), _REACH_M)
            self._movers.forget(now_s)
            self._radar.forget(now_s)

    def movers(self, now_s: float) -> list[Contact]:
        """What moves, where it is now."""
        return [*self._movers.contacts(now_s), *self._radar.movers(now_s)]

    def lying(self, now_s: float) -> Floats:
        """What lies: north_m, east_m, radius_m, shape (n, 3). Without the circles of what moves, and without what a
        single scan has seen: for that the boat stops, but it lays no other way and leaves none."""
        seen, ages_s = self._map.confirmed, self._map.confirmed_ages_s(now_s)
        for one in self._movers.contacts(now_s):
            off = np.hypot(seen[:, 0] - one.north_m, seen[:, 1] - one.east_m)
            passing_s = 2.0 * one.radius_m / max(math.hypot(one.north_mps, one.east_mps), 1e-3)
            kept = (off > one.radius_m + _MOVER_M) | (ages_s > max(_OLD_S, passing_s))
            seen, ages_s = seen[kept], ages_s[kept]
        others = [*self._radar.circles(), *self.shoals.circles]
        return np.concatenate((seen, np.asarray(others).reshape(-1, 3))) if others else seen

    def all_circles(self, now_s: float) -> Floats:
        """What lies, and what moves as it is seen now."""
        others = [*self._radar.circles(), *self.shoals.circles]
        others += [(one.north_m, one.east_m, one.radius_m) for one in self._radar.movers(now_s)]
        seen = self._map.circles
        return np.concatenate((seen, np.asarray(others).reshape(-1, 3))) if others else seen

    @property
    def reach_m(self) -> float:
        """How far the ranging sensors reach that are heard; 0 without any."""
        return max((view.most_m for view in self._views.values() if view.part not in self._silent), default=0.0)

    def sectors_m(self, nav: NavState) -> Floats:
        """Distance from the middle of the boat to the nearest thing in each of 72 sectors of 5°, the first ahead, then
        clockwise; infinite where nothing is known to be, NaN where no sensor looks. Shape (72,)."""
        seen = self._map.circles
        others = [*self._radar.circles(), *self.shoals.circles]
        circles = np.concatenate((seen, np.asarray(others).reshape(-1, 3))) if others else seen
        north, east = circles[:, 0] - nav.north_m, circles[:, 1] - nav.east_m
        off = np.hypot(north, east)
        wide = np.arcsin(np.minimum(1.0, circles[:, 2] / np.maximum(off, 1e-6))) + math.pi / SECTORS
        turn = np.arctan2(east, north)[None, :] - nav.yaw_rad - _SECTORS_RAD[:, None]
        inside = np.abs(np.remainder(turn + math.pi, math.tau) - math.pi) < wide[None, :]
        ways = np.where(inside, np.maximum(0.0, off - circles[:, 2])[None, :], math.inf)
        nearest: Floats = ways.min(axis=1, initial=math.inf)
        nearest[np.isinf(nearest) & ~self._looked_at(nav.yaw_rad)] = math.nan
        return nearest

    def _looked_at(self, yaw_rad: float) -> NDArray[np.bool_]:
        """Which of the 72 sectors a sensor covers that is heard."""
        covered = np.zeros(SECTORS, dtype=bool)
        for view in self._views.values():
            if view.part not in self._silent:
                first = view.first_rad - view.half_rad - (yaw_rad if view.from_north else 0.0)
                span = view.last_rad - view.first_rad + 2.0 * view.half_rad
                covered |= np.remainder(_SECTORS_RAD - first, math.tau) <= span + 1e-9
        return covered

    def _enter(self, reading: Heard, nav: NavState, now_s: float) -> None:
        if isinstance(reading, RadarTarget):
            self._radar.take(reading, nav, self._frame())
        elif isinstance(reading, DepthAhead):
            self.shoals.take_ahead(reading, nav, now_s)
        else:
            age_s = max(0.0, now_s - reading.t_s)
            yaw_rad = nav.yaw_rad - age_s * nav.yaw_rate_radps
            x_m, y_m = body_to_ned(reading.x_m, reading.y_m, yaw_rad)
            place = nav.north_m - age_s * nav.north_mps + x_m, nav.east_m - age_s * nav.east_mps + y_m
            scan = self._without_self(reading, yaw_rad)
            hits = self._map.hits(scan, place, yaw_rad)
            self._movers.take(hits, self._map.ages_s(hits, scan.t_s), place, scan.most_m, scan.t_s)
            self._map.take(scan, place, yaw_rad)

    def _without_self(self, scan: Ranges, yaw_rad: float) -> Ranges:
        """The scan without what lies within the hull itself."""
        half_x, half_y = 0.5 * self._config.length_m + _OWN_M, 0.5 * self._config.beam_m + _OWN_M
        turn = -yaw_rad if scan.from_north else 0.0
        kept = []
        for i, off in enumerate(scan.distances_m):
            bearing = scan.first_rad + i * scan.step_rad + turn
            x_m, y_m = scan.x_m + off * math.cos(bearing), scan.y_m + off * math.sin(bearing)
            own = math.isfinite(off) and abs(x_m) < half_x and abs(y_m) < half_y
            kept.append(math.nan if own else off)
        return replace(scan, distances_m=tuple(kept))

    def _mind_silence(self, now_s: float) -> None:
        before = self._silent
        speaking = {name for (name, _), (_, last_s) in self._heard_s.items() if now_s - last_s <= _SILENT_S}
        self._silent = frozenset(
            part
            for part, (since_s, last_s) in self._heard_s.items()
            if now_s - last_s > _SILENT_S and (part[0] not in speaking or last_s - since_s > _STANDS_S)
        )
        blind = {name for (name, _), spoke_s in self._spoke_s.items() if now_s - spoke_s <= _SILENT_S} - speaking
        for name in self._names(self._silent - before):
            text = f"{name} is blind: all its ranges are unknown" if name in blind else f"No ranges from {name}"
            self._events.say(now_s, TextKind.ATTENTION, "ranges_silent", text[:50])
        for name in sorted({name for name, _ in before} - {name for name, _ in self._silent}):
            self._events.say(now_s, TextKind.ROUTINE, "ranges_back", f"Ranges from {name} are back"[:50])

    def _names(self, parts: Set[Part]) -> list[str]:
        """These silent parts for people: the sensor, where all of it is silent, else its beams."""
        heard = {name for name, _ in self._heard_s.keys() - self._silent}
        return sorted({f"{name} at {beam} deg" if name in heard and beam is not None else name for name, beam in parts})

    def _mind_plane(self, nav: NavState) -> None:
        """What was entered in another plane, or before the position jumped, lies elsewhere."""
        plane = self._frame()
        if self._plane is not None and (plane != self._plane or nav.jumps_followed != self._jumps):
            self._map.clear()
            self._movers, self._radar = Movers(), RadarTargets()
            self.shoals.clear()
        self._plane, self._jumps = plane, nav.jumps_followed


def _is_blind(reading: Ranges) -> bool:
    """Whether a scan knows nothing of any direction: not even that nothing is in reach there, which it would tell. A
    single beam that gets no echo cannot tell these apart."""
    return len(reading.distances_m) > 1 and all(map(math.isnan, reading.distances_m))
