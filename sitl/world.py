"""The boat's world: hull, thrusters, weather, sensors and their devices, stepped together at 100 Hz, or as often as the fastest sensor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from companion.config import ConfigError, DockConfig, PlantConfig, SitlConfig, ThrusterConfig, VesselConfig
from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.ports import ByteStream
from companion.core.records import quick
from sitl import emulators
from sitl.battery import BatteryModel
from sitl.berth import Berth
from sitl.emulators.device import Surroundings
from sitl.environment import UPDATE_S, Current, Waves, Wind, parse_directed, wind_force
from sitl.faults import Faults, parse
from sitl.hull import Hull
from sitl.jet import Jet
from sitl.memory import MemoryDevice, MemoryStream
from sitl.seaway import Seaway
from sitl.sensors import grade
from sitl.thrusters import Thruster, build
from sitl.tow import Leg, TowedHull
from sitl.traffic import Traffic
from sitl.waters import Waters

EPOCH_UNIX_NS = 1_780_315_200_000_000_000  # 2026-06-01T12:00:00Z, where simulated time begins
STEP_HZ = 100
FASTEST_HZ = 200


@quick
@dataclass(frozen=True, slots=True)
class Truth:
    """What the boat really does. North and east from home; velocities over ground in body axes; thrusters as (force_n, azimuth_rad),
    retractable ones by name as 0 (up) … 1 (down)."""

    t_s: float
    north_m: float
    east_m: float
    yaw_rad: float
    surge_mps: float
    sway_mps: float
    yaw_rate_radps: float
    wind_speed_mps: float
    wind_from_rad: float
    current_north_mps: float
    current_east_mps: float
    thrusters: tuple[tuple[float, float], ...]
    battery_v: float
    battery_remaining: float
    down: Mapping[str, float]


class World:
    """The plant and the devices on it: a `companion.core.ports.World` and the `StreamOpener` of its devices' ports.

    The boat starts at home, at rest over ground, its boards neutral. Time is the caller's: `advance(now_s)` takes as many whole steps as
    have become due since 0.
    """

    def __init__(
        self,
        vessel: VesselConfig,
        *,
        seed: int = 0,
        wind: str | None = None,
        current: str | None = None,
        gnss: str | None = None,
        plant: str | None = None,
        waves_m: float = 0.0,
        faults: Sequence[str] = (),
        push_ned_n: tuple[float, float] = (0.0, 0.0),
        current_variation_mps: float = 0.0,
        capacity_wh: float | None = None,
        epoch_unix_ns: int = EPOCH_UNIX_NS,
        dock: DockConfig | None = None,
        tow: Sequence[Leg] = (),
        waters: Waters | None = None,
    ) -> None:
        """`wind` "MPS@FROM_DEG", `current` "MPS@TOWARDS_DEG", directions from the seed where left out; `gnss`, `plant`, `capacity_wh` None: as
        the vessel's file says; `push_ned_n` a constant force towards north and east on the hull; `dock` None: the vessel's own berth, if it has
        one; `tow`: it is led along these legs, whatever its thrusters do; `waters`: other boats, whose wakes a plant with a seaway feels.
        Raises ConfigError for what the vessel or the arguments do not offer.
        """
        self._vessel = vessel
        self.seed = seed
        self._sitl = _simulation(vessel)
        self._plant = _chosen_plant(vessel, plant)
        gnss = self._sitl.gnss if gnss is None else gnss
        grade(gnss)
        self.faults = Faults(faults, vessel)
        self.wind = Wind(*(parse_directed(wind, "wind") if wind else (0.0, None)), seed)
        self.current = Current(*(parse_directed(current, "current") if current else (0.0, None)), seed, current_variation_mps)
        self.battery = BatteryModel(self._sitl.battery_wh if capacity_wh is None else capacity_wh)
        self.hull = TowedHull(self._plant.hull, tow) if tow else Hull(self._plant.hull)
        self.waters = waters
        self.waves = self._sea(waves_m, seed)
        face = vessel.dock if dock is None else dock
        self.berth = None if face is None else Berth(face, vessel.home, vessel.length_m, vessel.beam_m)
        self.thrusters = _thrusters(vessel.thrusters, self._plant)
        self._retractable = [(c, t) for c, t in zip(vessel.thrusters, self.thrusters, strict=True) if c.retractable]
        self._push_ned_n = push_ned_n
        self._steps = 0
        self._step_hz = FASTEST_HZ if any(sensor.rate_hz > STEP_HZ for sensor in vessel.sensors) else STEP_HZ
        self._step_s = 1.0 / self._step_hz
        self._update_steps = round(UPDATE_S * self._step_hz)
        self._streams: dict[str, MemoryStream] = {}
        common = None if waters is None else waters.common
        self.traffic = Traffic()
        around = Surroundings(
            self.hull, self.waves, self.wind, self.faults, vessel.home, gnss, seed, epoch_unix_ns, self._step_hz, common, self.traffic
        )
        by_name = {config.name: thruster for config, thruster in zip(vessel.thrusters, self.thrusters, strict=True)}
        self.sensors = [emulators.sensor(config, self._port(config.name), around) for config in vessel.sensors]
        self.boards = [
            emulators.board(config, self._port(config.name), by_name, self.battery, self.faults)
            for config in vessel.actuators
        ]
        self._devices = (*self.sensors, *self.boards)
        self._due = [0.0] * len(self._devices)
        self.hull.set_current(self.current.north_mps, self.current.east_mps)
        self.set_state()

    # --- ports -----------------------------------------------------------------------------------------------------

    def open(self, name: str, url: str) -> ByteStream:
        """The port of the device `name`; its `url` is for a real boat. Raises ConfigError for a device that is not there."""
        stream = self._streams.get(name)
        if stream is None:
            raise ConfigError([f"no simulated device named '{name}'; there is {', '.join(self._streams)}"])
        stream.reopen()
        return stream

    def advance(self, now_s: float) -> None:
        """Bring the world up to `now_s`."""
        due = math.floor(now_s * self._step_hz + 1e-6)
        while self._steps < due:
            self._step()

    # --- what tests and scenarios see and set ----------------------------------------------------------------------

    @property
    def t_s(self) -> float:
        """Time that the world has reached."""
        return self._steps / self._step_hz

    @property
    def step_s(self) -> float:
        return self._step_s

    @property
    def truth(self) -> Truth:
        hull = self.hull
        return Truth(
            t_s=self.t_s,
            north_m=hull.north_m,
            east_m=hull.east_m,
            yaw_rad=hull.yaw_rad,
            surge_mps=hull.surge_mps,
            sway_mps=hull.sway_mps,
            yaw_rate_radps=hull.yaw_rate_radps,
            wind_speed_mps=self.wind.speed_mps,
            wind_from_rad=self.wind.from_rad,
            current_north_mps=self.current.north_mps,
            current_east_mps=self.current.east_mps,
            thrusters=tuple([(thruster.force_n, wrap_pi(thruster.azimuth_rad)) for thruster in self.thrusters]),
            battery_v=self.battery.voltage_v,
            battery_remaining=self.battery.remaining,
            down={config.name: thruster.down for config, thruster in self._retractable},
        )

    def set_state(
        self,
        north_m: float = 0.0,
        east_m: float = 0.0,
        yaw_rad: float | None = None,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """Put the boat somewhere, north and east of home; `yaw_rad` None: home's. Velocities over ground in body axes."""
        yaw = self._vessel.home.yaw_rad if yaw_rad is None else yaw_rad
        self.hull.place(north_m, east_m, yaw, surge_mps, sway_mps, yaw_rate_radps)

    def add_fault(self, name: str, duration_s: float = math.inf) -> None:
        """A fault from now on. Raises ConfigError for a name that does not exist."""
        times = f"{self.t_s}" if math.isinf(duration_s) else f"{self.t_s}+{duration_s}"
        self.faults.add(parse(f"{name}@{times}", self._vessel))

    def babble(self, name: str, data: bytes) -> None:
        """Bytes on the port of the device `name` that no device of its kind would say: a bad wire, a wrong baud rate."""
        self._streams[name].device.send(data, self.t_s)

    def set_transmitter(self, channels_us: Sequence[int] | None) -> None:
        """Pulses of the hand-held transmitter on all boards; None: no receiver."""
        for board in self.boards:
            board.rc_us = channels_us

    def _sea(self, height_m: float, seed: int) -> Waves:
        """Waves, and of other boats' wakes those that the plant can feel."""
        wakes = () if self.waters is None else self.waters.wakes
        if not self._plant.seaway:
            return Waves(height_m, self.wind, self._vessel.length_m, seed)
        return Seaway(height_m, self.wind, self._vessel.length_m, seed, self.hull, self._plant.hull.m11_kg, wakes)

    def _port(self, name: str) -> MemoryDevice:
        if name in self._streams:
            raise ConfigError([f"two devices are named '{name}'"])
        stream = self._streams[name] = MemoryStream(name)
        return stream.device

    # --- a step ----------------------------------------------------------------------------------------------------

    def _step(self) -> None:
        self._steps += 1
        t_s = self._steps / self._step_hz
        if self.faults.update(t_s):
            self._apply_faults()
        for board in self.boards:
            board.listen(t_s)
        if self._steps % self._update_steps == 0:
            self._update_weather()
        if self.waters is not None:
            self.waters.advance(t_s)
        self.waves.update(t_s)
        self._push(t_s)
        self._let_speak(t_s)

    def _push(self, t_s: float) -> None:
        """Forces on the hull, and its step."""
        hull = self.hull
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        air_north, air_east = self.wind.north_mps - hull.north_mps, self.wind.east_mps - hull.east_mps
        surge_n, sway_n, yaw_nm = wind_force(
            self._plant.windage, self._vessel.length_m, c * air_north + s * air_east, c * air_east - s * air_north
        )
        for thruster in self.thrusters:
            thruster.step(self._step_s, hull.water_surge_mps)
            x_n, y_n, n_nm = thruster.wrench()
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if self._push_ned_n != (0.0, 0.0):
            x_n, y_n = ned_to_body(*self._push_ned_n, hull.yaw_rad)
            surge_n, sway_n = surge_n + x_n, sway_n + y_n
        if self.waves.push:
            surge_mps2, sway_mps2 = ned_to_body(*self.waves.acceleration(t_s), hull.yaw_rad)
            surge_n += self._plant.hull.m11_kg * surge_mps2
            sway_n += self._plant.hull.m22_kg * sway_mps2
        if isinstance(self.waves, Seaway):
            x_n, y_n, n_nm = self.waves.force()
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if self.berth is not None:
            x_n, y_n, n_nm = self.berth.push(hull)
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        hull.step(surge_n, sway_n, yaw_nm, self._step_s)

    def _let_speak(self, t_s: float) -> None:
        due = self._due
        for i, device in enumerate(self._devices):
            due[i] += device.rate_hz * self._step_s
            if due[i] >= 1.0 - 1e-9:
                due[i] = max(due[i] - 1.0, 0.0)
                device.speak(t_s)

    def _update_weather(self) -> None:
        self.wind.update(UPDATE_S)
        if self.current.varies:
            self.current.update(UPDATE_S)
            self.hull.set_current(self.current.north_mps, self.current.east_mps)
        shares = [(abs(thruster.force_n) / thruster.max_n) ** 1.5 for thruster in self.thrusters]
        self.battery.step(self._sitl.hotel_power_w + self._sitl.full_power_w * sum(shares) / len(shares), UPDATE_S)

    def _apply_faults(self) -> None:
        active = self.faults.active
        for config, thruster in zip(self._vessel.thrusters, self.thrusters, strict=True):
            thruster.dead = f"thruster_{config.name}_dead" in active
            thruster.stalled = f"thruster_{config.name}_stalled" in active
            thruster.stuck = f"thruster_{config.name}_stuck" in active
            thruster.runaway = f"thruster_{config.name}_runaway" in active
            thruster.jammed = f"thruster_{config.name}_jammed" in active
        for name, stream in self._streams.items():
            gone = f"{name}_unplugged" in active
            if gone and stream.plugged:
                stream.device.unplug()
            elif not gone and not stream.plugged:
                stream.device.plug()


def _simulation(vessel: VesselConfig) -> SitlConfig:
    if vessel.sitl is None:
        raise ConfigError([f"{vessel.name}: the vessel's file has no [sitl] table, so there is nothing to simulate"])
    return vessel.sitl


def _thrusters(configs: Sequence[ThrusterConfig], plant: PlantConfig) -> tuple[Thruster, ...]:
    """All thrusters of a vessel, as the plant says that they are; a jet is alone."""
    jet = plant.jet or configs[0].jet
    if configs[0].kind != "jet" or jet is None:
        return build(configs, plant.thruster_lag_s, plant.thruster_x_m)
    return (Jet(configs[0], plant.thruster_lag_s, jet, None if plant.thruster_x_m is None else plant.thruster_x_m[0], plant.nozzle),)


def _chosen_plant(vessel: VesselConfig, name: str | None) -> PlantConfig:
    simulation = _simulation(vessel)
    chosen = simulation.plant if name is None else name
    if chosen not in simulation.plants:
        raise ConfigError([f"{vessel.name}: no plant named '{chosen}'; there is {', '.join(simulation.plants)}"])
    return simulation.plants[chosen]
