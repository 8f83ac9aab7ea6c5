"""The simulated boat and its weather: hull, thrusters, sensors and their devices, stepped together.

The step is 10 ms, or 5 ms where a sensor measures more often than 100 times a second.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from companion.config.devices import ThrusterConfig
from companion.config.sea import SeaState
from companion.config.vessel import ConfigError, DockConfig, PlantConfig, SitlConfig, VesselConfig
from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.nearest import did_you_mean
from companion.core.ports import ByteStream
from sitl import emulators
from sitl.battery import BatteryModel
from sitl.berth import BerthModel
from sitl.camera import emulated_cameras
from sitl.emulators.device import RcReceiver, SensedWorld
from sitl.environment import UPDATE_S, CurrentModel, Waves, WindModel, parse_directed, wind_force
from sitl.faults import Faults, parse
from sitl.gusts import Gusts, at_height, at_ten_metres, parse_wind
from sitl.hull_flow import hull_of
from sitl.jet import Jet
from sitl.memory import MemoryDevice, MemoryStream, garbling
from sitl.obstacles import Obstacles
from sitl.otter_equations import OtterHull
from sitl.plant_error import with_wrong_windage
from sitl.rough_water import is_rough, plant_name, rough_plant, wind_sea
from sitl.rudder import Rudder
from sitl.sail import SailRig, rig_of
from sitl.sea import Sea
from sitl.sea_state import components, parse_sea
from sitl.seaway import Seaway
from sitl.sensor_errors import Aboard
from sitl.sensors import grade
from sitl.shared_sea import SharedSea
from sitl.thruster_losses import ThrusterLosses
from sitl.thrusters import ThrusterModel, build
from sitl.tow import TowedHull, TowLeg
from sitl.traffic import Traffic
from sitl.wave_hull import air_height_m, wave_hull

EPOCH_UNIX_NS = 1_780_315_200_000_000_000  # 2026-06-01T12:00:00Z, where simulated time begins
STEP_HZ = 100
FASTEST_HZ = 200
_GROUND_MPS2, _CREEP_MPS = 15.0, 0.1  # deceleration by the ground, in full from that speed on
_STILL = (0.0, 0.0, 0.0)
_HEEL_S = 1.0  # in which a boat heels
_OVER_RADPS, _OVER_RAD = math.radians(60.0), math.radians(170.0)


@dataclass(frozen=True, slots=True)
class WorldConditions:
    """What the boat meets, and what differs from its file.

    A direction that `wind` or `current` leaves out comes from the seed. None means as the vessel's file says.
    """

    seed: int = 0
    wind: str | None = None  # "MPS[@FROM_DEG][/SPECTRUM]"
    current: str | None = None  # "MPS@TOWARDS_DEG" or "MPS"
    water: str | None = None  # "usual" or "rough"
    waves: str | None = None  # "HS[@FROM_DEG][/TP_S]"; empty: flat water
    wave_drift: bool = True  # False: waves move the boat to and fro, and do not push it along
    push_ned_n: tuple[float, float] = (0.0, 0.0)  # constant force on the hull towards north and east
    faults: Sequence[str] = ()  # as `faults.parse` reads them
    gnss: str | None = None  # grade of the receivers, a key of `sensors.GRADES`
    plant: str | None = None  # name of one of the file's plants
    windage_error: float | None = None  # share by which the wind areas differ, each up or down by the seed
    capacity_wh: float | None = None  # of the battery
    dock: DockConfig | None = None
    tow: Sequence[TowLeg] = ()  # towed along these legs, whatever the thrusters do
    epoch_unix_ns: int = EPOCH_UNIX_NS


@dataclass(frozen=True, slots=True)
class Truth:
    """What the boat really does.

    North and east from home, velocities over ground in body axes. `thrusters`: (force_n, azimuth_rad) each. `down`:
    retractable thrusters by name, 0 (up) to 1 (down).
    """

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
    """The plant and its devices: a `companion.core.ports.World`, and the `StreamOpener` of the devices' ports.

    The boat starts at home, at rest over ground, its boards neutral. `advance(now_s)` takes all whole steps up to that
    time.
    """

    def __init__(
        self, vessel: VesselConfig, conditions: WorldConditions | None = None, shared_sea: SharedSea | None = None
    ) -> None:
        """`shared_sea`: lead boats near by, whose wakes a plant with a seaway feels; None: the boat is alone.

        Raises ConfigError for conditions that the vessel's file does not offer.
        """
        self._vessel = vessel
        self._conditions = given = WorldConditions() if conditions is None else conditions
        self._sitl = _simulation(vessel)
        self._rough = is_rough(given.water, self._sitl)
        self._plant = self._made_plant(given)
        self._sea_wind_mps = 0.0  # mean wind at 10 m
        self.faults = Faults(given.faults, vessel)
        self.wind = self._air(given)
        self.current = self._stream(given)
        self.battery = BatteryModel(self._sitl.battery_wh if given.capacity_wh is None else given.capacity_wh)
        self.hull = TowedHull(self._plant.hull, given.tow) if given.tow else hull_of(vessel, self._plant)
        self.shared_sea = shared_sea
        losses, rows = self._plant.losses, vessel.thrusters
        self._felt = losses is not None or any(row.kind in ("jet", "rudder", "sail") for row in rows)
        x_m = self._plant.thruster_x_m or tuple(row.x_m for row in rows)
        self._thruster_places = [(x, row.y_m) for x, row in zip(x_m, rows, strict=True)]
        self._losses = None if losses is None else ThrusterLosses(losses, rows, self._thruster_places)
        self.waves = self._water(given)
        dock = vessel.dock if given.dock is None else given.dock
        kg = self._plant.hull.m22_kg
        self.berth = None if dock is None else BerthModel(dock, vessel.home, vessel.length_m, vessel.beam_m, kg)
        self.thrusters = _thrusters(vessel.thrusters, self._plant)
        self._rig = self.thrusters[0] if isinstance(self.thrusters[0], SailRig) else None
        for thruster in self.thrusters:
            thruster.lag_on_revolutions = self._plant.lag_on == "revolutions"
            if losses is not None:
                thruster.azimuth_lag_s, thruster.backlash_rad = losses.azimuth_lag_s, losses.backlash_rad
        self._retractable = [(c, t) for c, t in zip(vessel.thrusters, self.thrusters, strict=True) if c.retractable]
        self._steps = 0
        self._over_rad = 0.0  # by which the boat has rolled over
        self._heel_rad, self._heel_to_rad = 0.0, 0.0  # by the wind
        self._rolled_rad, self._pitched_rad = 0.0, 0.0  # of a hull that rolls and pitches by itself
        self._stiffness_nm = wave_hull(self._plant.hull, vessel).stiffness_nm
        self._step_hz = FASTEST_HZ if any(sensor.rate_hz > STEP_HZ for sensor in vessel.sensors) else STEP_HZ
        self._step_s = 1.0 / self._step_hz
        self._update_steps = round(UPDATE_S * self._step_hz)
        self._streams: dict[str, MemoryStream] = {}
        self.traffic = Traffic()
        self.obstacles = Obstacles()
        sensed = self._sensed()
        by_name = {config.name: thruster for config, thruster in zip(vessel.thrusters, self.thrusters, strict=True)}
        self.sensors = [emulators.sensor(config, self._port(config.name), sensed) for config in vessel.sensors]
        self.boards = [
            emulators.board(config, self._port(config.name), by_name, self.battery, self.faults)
            for config in vessel.actuators
        ]
        self.cameras = emulated_cameras(vessel.cameras, vessel.actuators, self.boards, self.hull)
        self._devices = (*self.sensors, *self.boards)
        self._due = [0.0] * len(self._devices)
        self.hull.set_current(self.current.north_mps, self.current.east_mps)
        self.set_state()

    def _sensed(self) -> SensedWorld:
        """What the sensors can measure. Raises ConfigError for an unknown grade of receiver."""
        gnss = self._sitl.gnss if self._conditions.gnss is None else self._conditions.gnss
        grade(gnss)
        errors = self._plant.sensor_errors
        return SensedWorld(
            hull=self.hull,
            waves=self.waves,
            wind=self.wind,
            faults=self.faults,
            home=self._vessel.home,
            gnss=gnss,
            seed=self._conditions.seed,
            epoch_unix_ns=self._conditions.epoch_unix_ns,
            step_hz=self._step_hz,
            common=None if self.shared_sea is None else self.shared_sea.common,
            aboard=None if errors is None else Aboard(errors, self.thrusters, self.battery),
            traffic=self.traffic,
            obstacles=self.obstacles,
            boards=frozenset(row.port for row in self._vessel.actuators if row.driver == "mavlink_servo"),
        )

    # --- ports -----------------------------------------------------------------------------------------------------

    def open(self, name: str, url: str) -> ByteStream:
        """The port of the device `name`; `url` is ignored. Raises ConfigError where there is no such device."""
        stream = self._streams.get(name)
        if stream is None:
            raise ConfigError([f"no simulated device named '{name}'; there is {', '.join(self._streams)}"])
        stream.reopen()
        return stream

    def advance(self, now_s: float) -> None:
        """Take all steps that are due by `now_s`."""
        due = math.floor(now_s * self._step_hz + 1e-6)
        while self._steps < due:
            self._step()

    # --- what tests and scenarios read and set ----------------------------------------------------------------------

    @property
    def t_s(self) -> float:
        """Time of the last step."""
        return self._steps / self._step_hz

    @property
    def plant(self) -> PlantConfig:
        """The hull and what acts on it, as they are in this water."""
        return self._plant

    @property
    def seed(self) -> int:
        """Seed of all noise."""
        return self._conditions.seed

    @property
    def step_s(self) -> float:
        """Length of a step."""
        return self._step_s

    @property
    def truth(self) -> Truth:
        """What the boat does now."""
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
        """Put the boat at a place from home; `yaw_rad` None: home's heading. Velocities over ground in body axes."""
        yaw = self._vessel.home.yaw_rad if yaw_rad is None else yaw_rad
        self.hull.place(north_m, east_m, yaw, surge_mps, sway_mps, yaw_rate_radps)

    def add_fault(self, name: str, duration_s: float = math.inf) -> None:
        """Start a fault now. Raises ConfigError for an unknown name."""
        times = f"{self.t_s}" if math.isinf(duration_s) else f"{self.t_s}+{duration_s}"
        self.faults.add(parse(f"{name}@{times}", self._vessel))

    def babble(self, name: str, data: bytes) -> None:
        """Put bytes on the port of the device `name`, as a bad wire or a wrong baud rate would."""
        self._streams[name].device.send(data, self.t_s)

    def set_transmitter(self, channels_us: Sequence[int] | None) -> None:
        """Pulses of the transmitter's channels on the serial RC receivers, else on all boards; None: no RC receiver, or
        no transmitter."""
        serial = [sensor for sensor in self.sensors if isinstance(sensor, RcReceiver)]
        for device in serial or self.boards:
            device.rc_us = channels_us

    def _made_plant(self, given: WorldConditions) -> PlantConfig:
        """The plant that is asked for, as it is in this water, with wind areas as they are there."""
        plant, error = chosen_plant(self._vessel, given.plant, self._rough), given.windage_error
        if self._rough:
            plant = rough_plant(self._vessel, plant, self._sitl.rough)
            error = self._sitl.rough.windage_error if error is None else error
        return with_wrong_windage(plant, error, given.seed) if error else plant

    def _air(self, given: WorldConditions) -> WindModel:
        """The wind at the boat. With a spectrum of gusts it is named by its mean at 10 m; in rough water, which has one
        in any case, a wind that names none is named by its mean at the boat."""
        mean_mps, from_rad, spectrum = parse_wind(given.wind) if given.wind else (0.0, None, "")
        if mean_mps == 0.0 or not (spectrum or self._rough):
            return WindModel(mean_mps, from_rad, given.seed)
        centre = self._plant.wind_centre_m
        height_m = air_height_m(self._plant.hull, self._vessel) if centre is None else centre[1]
        if spectrum:
            at_sea_mps, here_mps = mean_mps, at_height(spectrum, mean_mps, height_m)
        else:
            spectrum, here_mps = self._sitl.rough.gusts, mean_mps
            at_sea_mps = at_ten_metres(spectrum, here_mps, height_m)
        self._sea_wind_mps = at_sea_mps
        return WindModel(here_mps, from_rad, given.seed, Gusts(spectrum, at_sea_mps, height_m, given.seed))

    def _stream(self, given: WorldConditions) -> CurrentModel:
        """The current, which varies and turns in rough water."""
        mean_mps, towards_rad = parse_directed(given.current, "current") if given.current else (0.0, None)
        share = self._sitl.rough.current_share if self._rough else 0.0
        return CurrentModel(mean_mps, towards_rad, given.seed, share * mean_mps)

    def _sea_state(self, given: WorldConditions) -> SeaState | None:
        """The sea state that is set; where none is, in rough water, the one that the wind raises."""
        text = self._sitl.waves if given.waves is None else given.waves
        if self._rough and not text.strip():
            return wind_sea(self._sea_wind_mps, self._sitl.rough.fetch_m)
        return parse_sea(text)

    def _water(self, given: WorldConditions) -> Waves:
        """The sea state, else what the wind alone raises; with wakes where the plant feels them."""
        hull, plant = self.hull, self._plant
        wakes = self.shared_sea.wakes if plant.seaway and self.shared_sea is not None else ()
        state = self._sea_state(given)
        if state is not None:
            boat = wave_hull(plant.hull, self._vessel)
            from_rad = self.wind.mean_from_rad if state.from_rad is None else state.from_rad
            sea = components(state, from_rad, given.seed)
            depth_m = boat.draft_m if plant.losses is None else plant.losses.depth_m or boat.draft_m
            places = [(x_m, y_m, depth_m) for x_m, y_m in self._thruster_places] if self._felt else []
            return Sea(
                sea, boat, hull, self.wind, seed=given.seed, mass_kg=plant.hull.m11_kg, places=places,
                wakes=wakes, drift=given.wave_drift,
            )  # fmt: skip
        if not plant.seaway:
            return Waves(self.wind, given.seed)
        return Seaway(self.wind, self._vessel.length_m, given.seed, hull, plant.hull.m11_kg, wakes)

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
        for camera in self.cameras:
            camera.look(t_s)
        if self._steps % self._update_steps == 0:
            self._update_weather()
        if self.shared_sea is not None:
            self.shared_sea.advance(t_s)
        self._rock(t_s)
        self._push()
        if isinstance(self.hull, OtterHull):
            self._tilt(self.hull)
        self._send_due(t_s)

    def _rock(self, t_s: float) -> None:
        """Roll, pitch and heave of this step, by waves, wind and the hull itself."""
        self.waves.roll_rad -= self._over_rad + self._heel_rad + self._rolled_rad  # waves go on from their own
        self.waves.pitch_rad -= self._pitched_rad
        self.waves.update(t_s)
        if self._rig is not None or self._plant.wind_centre_m is not None:
            self._heel()
        if "capsized" in self.faults.active:
            self._roll_over()

    def _heel(self) -> None:
        """Follow the angle at which the righting moment balances the wind's, or that of the rig."""
        before = self._heel_rad
        if self._rig is not None:
            self._heel_rad = self._rig.heel_rad
        else:
            self._heel_rad += self._step_s / _HEEL_S * (self._heel_to_rad - before)
        self.waves.roll_rad += self._heel_rad
        self.waves.roll_rate_radps += (self._heel_rad - before) / self._step_s

    def _tilt(self, hull: OtterHull) -> None:
        """Add the hull's own attitude to what waves make of it."""
        waves = self.waves
        self._rolled_rad, self._pitched_rad = hull.roll_rad, hull.pitch_rad
        waves.roll_rad += hull.roll_rad
        waves.pitch_rad += hull.pitch_rad
        waves.roll_rate_radps += hull.rolling_radps
        waves.pitch_rate_radps += hull.pitching_radps
        waves.half_step_s = 0.5 * self._step_s  # the hull's rates are means of the step

    def _roll_over(self) -> None:
        rate = _OVER_RADPS if self._over_rad < _OVER_RAD else 0.0
        self._over_rad += rate * self._step_s
        self.waves.roll_rad += self._over_rad
        self.waves.roll_rate_radps += rate

    def _push(self) -> None:
        """Sum the forces on the hull and step it."""
        hull = self.hull
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        air_north, air_east = self.wind.north_mps - hull.north_mps, self.wind.east_mps - hull.east_mps
        surge_n, sway_n, yaw_nm = wind_force(
            self._plant.windage, self._vessel.length_m, c * air_north + s * air_east, c * air_east - s * air_north
        )
        if self._plant.wind_centre_m is not None:
            ahead_m, above_m = self._plant.wind_centre_m
            yaw_nm += ahead_m * sway_n
            self._heel_to_rad = above_m * sway_n / self._stiffness_nm
        if self._rig is not None:
            self._rig.feel(c * air_north + s * air_east, c * air_east - s * air_north)
        surge_n, sway_n, yaw_nm = self._with_thrust(surge_n, sway_n, yaw_nm)
        if self._conditions.push_ned_n != (0.0, 0.0):
            x_n, y_n = ned_to_body(*self._conditions.push_ned_n, hull.yaw_rad)
            surge_n, sway_n = surge_n + x_n, sway_n + y_n
        if isinstance(self.waves, (Sea, Seaway)):
            x_n, y_n, n_nm = self.waves.force()
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if self.berth is not None:
            x_n, y_n, n_nm = self.berth.push(hull)
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if "aground" in self.faults.active:
            x_n, y_n, n_nm = self._ground()
            surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if isinstance(self.waves, Sea):
            north_mps, east_mps, yaw_radps = self.waves.orbit
            orbit = (north_mps, east_mps, 0.0 if self._conditions.tow else yaw_radps)
            hull.step_in_waves(surge_n, sway_n, yaw_nm, self._step_s, orbit)
        else:
            hull.step(surge_n, sway_n, yaw_nm, self._step_s)

    def _with_thrust(self, surge_n: float, sway_n: float, yaw_nm: float) -> tuple[float, float, float]:
        """Step the thrusters in the water at each of them; the wrench with theirs added, less what is lost."""
        hull, sea = self.hull, self.waves
        water = sea.water_at_places() if self._felt and isinstance(sea, Sea) else None
        surge_mps, sway_mps = hull.water_surge_mps, hull.water_sway_mps
        for i, thruster in enumerate(self.thrusters):
            ahead_mps, starboard_mps, _ = _STILL if water is None else water[i]
            thruster.step(self._step_s, surge_mps - ahead_mps, sway_mps - starboard_mps, hull.yaw_rate_radps)
            if self._losses is None:
                x_n, y_n, n_nm = thruster.wrench()
                surge_n, sway_n, yaw_nm = surge_n + x_n, sway_n + y_n, yaw_nm + n_nm
        if self._losses is None:
            return surge_n, sway_n, yaw_nm
        velocity = surge_mps, sway_mps, hull.yaw_rate_radps
        x_n, y_n, n_nm = self._losses.wrench(self.thrusters, velocity, water, self.battery.voltage_v)
        return surge_n + x_n, sway_n + y_n, yaw_nm + n_nm

    def _ground(self) -> tuple[float, float, float]:
        """Force and moment of the ground under the keel: friction that stops the boat and lets it creep."""
        hull, mass = self.hull, self._plant.hull
        speed_mps = math.hypot(hull.surge_mps, hull.sway_mps)
        share = -_GROUND_MPS2 / max(speed_mps, _CREEP_MPS)
        turn = -_GROUND_MPS2 / max(abs(hull.yaw_rate_radps), _CREEP_MPS) * hull.yaw_rate_radps
        return mass.m11_kg * share * hull.surge_mps, mass.m22_kg * share * hull.sway_mps, mass.m33_kgm2 * turn

    def _send_due(self, t_s: float) -> None:
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
            thruster.reversed = f"thruster_{config.name}_reversed" in active
            thruster.fouled = f"thruster_{config.name}_fouled" in active
        for name, stream in self._streams.items():
            gone = f"{name}_unplugged" in active
            if gone and stream.plugged:
                stream.device.unplug()
            elif not gone and not stream.plugged:
                stream.device.plug()
            stream.garbles = garbling(self._conditions.seed, name) if f"{name}_garbled" in active else None


def _simulation(vessel: VesselConfig) -> SitlConfig:
    if vessel.sitl is None:
        raise ConfigError([f"{vessel.name}: the vessel's file has no [sitl] table, so there is nothing to simulate"])
    return vessel.sitl


def _thrusters(configs: Sequence[ThrusterConfig], plant: PlantConfig) -> tuple[ThrusterModel, ...]:
    """The thrusters as the plant has them. A jet is a vessel's only thruster; a sail is the first."""
    first, jet = configs[0], plant.jet or configs[0].jet
    if (rig := rig_of(first, plant.thruster_lag_s, plant.keel)) is not None:
        return (rig, *build(configs[1:], plant.thruster_lag_s, plant.thruster_x_m and plant.thruster_x_m[1:]))
    if first.kind == "jet" and jet is not None:
        x_m = None if plant.thruster_x_m is None else plant.thruster_x_m[0]
        return (Jet(first, plant.thruster_lag_s, jet, x_m, plant.nozzle),)
    found = list(build(configs, plant.thruster_lag_s, plant.thruster_x_m))
    for i, config in enumerate(configs):
        if config.rudder is not None:
            x_m = None if plant.thruster_x_m is None else plant.thruster_x_m[i]
            found[i] = Rudder(config, plant.thruster_lag_s, config.rudder, x_m, plant.nozzle)
    return tuple(found)


def chosen_plant(vessel: VesselConfig, name: str | None, rough: bool = False) -> PlantConfig:
    """The vessel's plant of that name; None: the file's choice for that water. Raises ConfigError where there is
    none."""
    simulation = _simulation(vessel)
    chosen = plant_name(simulation, name, rough)
    if chosen not in simulation.plants:
        meant = did_you_mean(chosen, simulation.plants)
        raise ConfigError([f"{vessel.name}: no plant named '{chosen}'; there is {', '.join(simulation.plants)}{meant}"])
    return simulation.plants[chosen]
