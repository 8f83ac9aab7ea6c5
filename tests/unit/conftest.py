"""A supervisor with an ideal boat under it: it does exactly what the setpoint says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import NO_AUXILIARY
from companion.core.decision import Severity, Status
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.payload import Forward, Shot
from companion.core.readings import Battery, Depth, Leak, ManualInput, RcInput
from companion.core.setpoint import HeadingSetpoint, PathSetpoint, PoseSetpoint, Setpoint
from companion.core.tick import DeviceHealth, Inputs
from companion.fence.guard import FenceGuard
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.params.store import Parameters
from companion.supervisor.helm import Helm
from companion.supervisor.supervisor import Supervisor
from tests.unit.estimates import AT_REST

DT_S = 0.1


class Boat:
    """Steps the supervisor; `said`, `shots` and `forwards` collect; `setpoint`, `status` and `auxiliary` are the
    newest."""

    def __init__(self, config: VesselConfig, ready: bool = True, **parameters: float) -> None:
        self.config = config
        self.frame = LocalFrame(63.4389, 10.399)
        self.parameters = Parameters(parameters)
        self.plans = Plans()
        self.executor = MissionExecutor(self.plans)
        self.events = EventLog()
        self.supervisor = Supervisor(
            config, self.parameters, self.plans, self.executor, self.events, lambda: self.frame
        )
        self.now_s = 0.0
        self.nav = AT_REST
        self.sticks: tuple[float, float, float] | None = None
        self.rc: tuple[float, ...] | None = None
        self.rc_silent_s: float | None = None  # since then the transmitter sends nothing: its last reading stays
        self.station = True
        self.battery: float | None = None
        self.wet = False
        self.depth_m: float | None = None
        self.pinned = False  # whatever is asked of it, it stays where it is
        self.silent: set[str] = set()
        self.said: list[tuple[str, str]] = []
        self.severities: dict[str, Severity] = {}
        self.shots: list[Shot] = []
        self.forwards: list[Forward] = []
        self.auxiliary = NO_AUXILIARY
        self.setpoint: Setpoint
        self.status: Status
        if ready:
            self.step()

    @property
    def helm(self) -> Helm:
        """The supervisor's: which mode steers, and the modes themselves."""
        return self.supervisor.parts.helm

    @property
    def fence_guard(self) -> FenceGuard:
        """The supervisor's."""
        return self.supervisor.parts.fence

    def forget_home(self) -> None:
        """No home, and none is set again."""
        keeper = self.supervisor.parts.home
        keeper.home = None
        keeper.update = lambda nav, now_s: None  # type: ignore[method-assign]

    def overlook_the_fence(self) -> None:
        """The way that is sailed now is not judged anew for the fence that has just come."""
        self.supervisor.parts.fence_duty._seen_fence = self.fence_guard.key

    def point(self, north_m: float, east_m: float) -> tuple[float, float]:
        return self.frame.to_geodetic(north_m, east_m)

    def upload(
        self,
        *points: tuple[float, float],
        commands: dict[int, PlanItem] | None = None,
        kind: PlanKind = PlanKind.MISSION,
    ) -> None:
        items = []
        for seq, (north_m, east_m) in enumerate(points):
            lat_deg, lon_deg = self.point(north_m, east_m)
            command = 16 if kind is PlanKind.MISSION else 5100
            items.append(
                PlanItem(seq, command, 3, 0.0, 0.0, 0.0, math.nan, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
            )
        for seq, item in (commands or {}).items():
            items.insert(seq, item)
        self.plans.replace(kind, [replace(item, seq=i) for i, item in enumerate(items)])

    def fence(self, *corners: tuple[float, float], keep_out: bool = False) -> None:
        """A fence that the boat must stay in, or a zone that it must keep out of, as north_m, east_m."""
        items, command = [], 5002 if keep_out else 5001
        for seq, corner in enumerate(corners):
            lat_deg, lon_deg = self.point(*corner)
            lat, lon = round(lat_deg * 1e7), round(lon_deg * 1e7)
            items.append(PlanItem(seq, command, 0, float(len(corners)), 0.0, 0.0, 0.0, lat, lon, 0.0))
        self.plans.replace(PlanKind.FENCE, items)

    def tick(self) -> None:
        self.now_s = round(self.now_s + DT_S, 6)
        now = self.now_s
        if self.station:
            self.supervisor.ground_station_heard(now)
        if self.sticks is not None:
            self.supervisor.manual_input(ManualInput(now, "gcs", *self.sticks))
        inputs = Inputs(
            battery=None if self.battery is None else Battery(now, "battery", 12.0, None, self.battery),
            leak=Leak(now, "leak", self.wet),
            depth=None if self.depth_m is None else Depth(now, "sounder", self.depth_m),
            rc=None if self.rc is None else RcInput(self.rc_silent_s or now, "rc", self.rc, lost=False),
        )
        names = [device.name for device in (*self.config.sensors, *self.config.actuators)]
        health = [
            DeviceHealth(name, name not in self.silent, 0.0, "silent" if name in self.silent else "") for name in names
        ]
        if self.nav.t_s != now:
            self.nav = replace(self.nav, t_s=now)
        self.status = self.supervisor.update(self.nav, inputs, health, now)
        self.setpoint = self.supervisor.guide(self.nav, now, DT_S)
        self.obey(self.setpoint)
        self.auxiliary = self.supervisor.outputs(now, DT_S)
        self.shots += self.supervisor.payload.take_shots()
        self.forwards += self.supervisor.payload.take_forwards()
        for event in self.events.drain():
            self.said.append((event.name, event.text))
            self.severities[event.name] = event.severity

    def obey(self, s: Setpoint) -> None:
        """Be where the setpoint says at the next tick."""
        nav, next_s = self.nav, round(self.now_s + DT_S, 6)
        if self.pinned:
            self.nav = replace(nav, t_s=next_s, surge_mps=0.0, sway_mps=0.0, north_mps=0.0, east_mps=0.0)
            return
        north, east, yaw, surge, sway = nav.north_m, nav.east_m, nav.yaw_rad, 0.0, 0.0
        if isinstance(s, PoseSetpoint):
            north, east, yaw, surge, sway = s.north_m, s.east_m, s.yaw_rad, s.surge_mps, s.sway_mps
        elif isinstance(s, PathSetpoint):
            yaw, surge, sway = s.yaw_rad, s.surge_mps, s.sway_mps
        elif isinstance(s, HeadingSetpoint):
            yaw = s.yaw_rad
        north_mps = surge * math.cos(yaw) - sway * math.sin(yaw)
        east_mps = surge * math.sin(yaw) + sway * math.cos(yaw)
        if isinstance(s, PathSetpoint):
            north, east = north + north_mps * DT_S, east + east_mps * DT_S
        lat_deg, lon_deg = self.frame.to_geodetic(north, east)
        self.nav = replace(
            nav,
            t_s=next_s,
            north_m=north,
            east_m=east,
            yaw_rad=yaw,
            surge_mps=surge,
            sway_mps=sway,
            north_mps=north_mps,
            east_mps=east_mps,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
        )

    def step(self, duration_s: float = DT_S) -> None:
        for _ in range(max(1, round(duration_s / DT_S))):
            self.tick()

    def until(self, condition: Callable[[], bool], timeout_s: float = 600.0) -> None:
        end_s = self.now_s + timeout_s
        while not condition():
            assert self.now_s < end_s, f"not within {timeout_s} s; {self.status}; said {self.said[-5:]}"
            self.tick()

    def names(self) -> list[str]:
        return [name for name, _ in self.said]

    def texts(self) -> list[str]:
        return [text for _, text in self.said]

    def away_m(self, north_m: float, east_m: float) -> float:
        return math.hypot(self.nav.north_m - north_m, self.nav.east_m - east_m)


@pytest.fixture(scope="session")
def revolt() -> VesselConfig:
    return load(find("revolt"))


@pytest.fixture
def make_boat(revolt: VesselConfig) -> Callable[..., Boat]:
    def make(config: VesselConfig = revolt, ready: bool = True, **parameters: float) -> Boat:
        return Boat(config, ready, **parameters)

    return make


@pytest.fixture
def boat(make_boat: Callable[..., Boat]) -> Boat:
    return make_boat()
