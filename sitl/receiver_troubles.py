"""Honest troubles of a satellite receiver, which no field of its sentences shows: values that come late, solutions that
are left out, multipath. They are faults of the run: `lie_table.py` lists them."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from companion.config.vessel import HomeConfig
from companion.core.geodesy import LocalFrame
from sitl.faults import Faults
from sitl.lie_table import LATEST_S
from sitl.noise import GaussMarkov, Normals, stream
from sitl.sensors import GnssSample

_MULTIPATH_TAU_S = 20.0


class ReceiverTroubles:
    """Call `sent` for each solution of the receiver, and `arrival_s` for each that is sent.

    Remembers the solutions of the last seconds, the multipath and its age, its place in the noise, and when the last
    one arrives.
    """

    def __init__(self, faults: Faults, name: str, home: HomeConfig, dt_s: float, seed: int) -> None:
        """`dt_s`: between two solutions."""
        self._faults, self._name, self._dt_s = faults, name, dt_s
        self._frame = LocalFrame(home.lat_deg, home.lon_deg)
        rng = stream(seed, f"{name} troubles")
        self._uniform = rng.random
        normals = Normals(rng)
        self._multipath = [GaussMarkov(normals, 1.0, _MULTIPATH_TAU_S) for _ in range(2)]
        self._solutions: deque[tuple[float, GnssSample]] = deque()
        self._arrives_s = 0.0
        self._walked_s = dt_s  # of multipath that the next solution has

    def sent(self, sample: GnssSample, t_s: float) -> GnssSample | None:
        """What the receiver sends at `t_s`, stamped with that time; None: this solution is left out."""
        solutions = self._solutions
        solutions.append((t_s, sample))
        while solutions[0][0] < t_s - LATEST_S:
            solutions.popleft()
        late_s = self._size("gnss_late")
        if late_s > 0.0:
            sample = next((old for at_s, old in reversed(solutions) if at_s <= t_s - late_s + 1e-6), solutions[0][1])
        dropped, multipath_m = self._size("gnss_dropped"), self._size("gnss_multipath")
        if dropped > 0.0 and self._uniform() < dropped:
            self._walked_s += self._dt_s
            return None
        return sample if multipath_m == 0.0 else self._reflected(sample, multipath_m)

    def arrival_s(self, due_s: float) -> float:
        """When a solution arrives that is due then: in order."""
        jitter_s = self._size("gnss_jitter")
        self._arrives_s = max(self._arrives_s, due_s + (jitter_s * self._uniform() if jitter_s > 0.0 else 0.0))
        return self._arrives_s

    def _size(self, name: str) -> float:
        return sum(fault.size or 0.0 for fault in self._faults.lies(self._name) if fault.name == name)

    def _reflected(self, sample: GnssSample, sigma_m: float) -> GnssSample:
        north_m, east_m = (sigma_m * walk.update(self._walked_s) for walk in self._multipath)
        self._walked_s = self._dt_s
        if sample.position is None:
            return sample
        lat_deg, lon_deg, altitude_m = sample.position
        north, east = self._frame.to_ned(lat_deg, lon_deg)
        return replace(sample, position=(*self._frame.to_geodetic(north + north_m, east + east_m), altitude_m))
