"""The lockstep rig: a whole vessel and its simulated boat in one thread, on a clock that moves when told to.

Scenarios and tests run on it. It is the `sitl.scenarios.rig.Rig` that only this folder can build, since it joins
`companion` and `sitl`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from companion.analysis.log_reader import open_log
from companion.app import Surroundings, build, load_vessel
from companion.cli.common import UsageError
from companion.clock import SimulatedClock
from companion.config import vessel as config_module
from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig
from companion.io.mavlink.wire.links import MemoryLink
from companion.record.disk import REAL_DISK
from sitl.camera import PictureLog
from sitl.magnetometer import with_magnetometer
from sitl.medium import FaultyMedium
from sitl.plant_error import with_plant_error
from sitl.rough_water import is_rough, plant_name
from sitl.scenarios.rig import Conditions, ControllerModel
from sitl.shared_sea import SharedSea, build_shared_sea
from sitl.truth_log import LeaderTruthLog, TruthLog
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions


class LockstepRig:
    """A vessel, its world and a memory link whose far end the scenario holds. Logs into `folder`."""

    def __init__(
        self,
        conditions: Conditions,
        folder: Path,
        shared_sea: SharedSea | None = None,
        link: str = "memory:scenario",
        watch: Callable[[float], None] | None = None,
    ) -> None:
        """`shared_sea`: that of another rig; None: one as the conditions ask for, if they ask for any. `link`: the
        URL of the memory link, with its options. `watch`: is told the length of each tick, in s, after it.

        Raises ConfigError, UsageError for conditions that the vessel cannot meet.
        """
        self.config: VesselConfig = _equipped(conditions)
        self.conditions: Conditions = conditions
        self._folder = folder
        self._watch = watch
        controller = _controller_config(self.config, conditions)
        self.world: World = _world(self.config, conditions, shared_sea)
        self._clock = SimulatedClock(EPOCH_UNIX_NS)
        self._link = MemoryLink(link)
        manifest = {"seed": conditions.seed, "conditions": repr(conditions)}
        around = Surroundings(
            self._clock,
            self.world,
            self.world,
            [self._link],
            None,
            folder,
            False,
            manifest,
            conditions.parameters,
            disk=FaultyMedium(REAL_DISK, self.world.faults),
        )
        self.vessel = build(controller, around)
        thrusters = tuple(thruster.name for thruster in self.config.thrusters)
        self.vessel.add_recorder(TruthLog(folder, self.world, thrusters))
        if self.world.cameras:
            self.vessel.add_recorder(PictureLog(folder, self.world.cameras))
        for boat in () if self.world.shared_sea is None else self.world.shared_sea.boats:
            self.vessel.add_recorder(LeaderTruthLog(folder, boat, self.config.home))
        self._steps = 0
        self._closed = False

    @property
    def now_s(self) -> float:
        """The vessel's time."""
        return self._clock.now_s()

    def step(self) -> None:
        """One tick of the vessel."""
        self._clock.wait(self._steps * self.vessel.period_s, ())
        self.vessel.tick(self._clock.now_s())
        self._steps += 1
        if self._watch is not None:
            self._watch(self.vessel.period_s)

    def pause(self, duration_s: float) -> None:
        """The process stands still while the world goes on: the ticks of that time are skipped."""
        self._steps += max(0, round(duration_s / self.vessel.period_s))

    def set_clock_ahead(self, by_s: float) -> None:
        """Step the host's clock."""
        self._clock.set_ahead(by_s)

    def send(self, data: bytes) -> None:
        """Bytes from the ground station; the vessel reads them with its next tick."""
        self._link.to_vessel(data)

    def deliver(self, data: bytes, at_s: float) -> None:
        """Bytes that reach the vessel between two ticks, at `at_s` but not before the last ones."""
        self._clock.wait(max(at_s, self._clock.now_s()), ())
        self._link.to_vessel(data)
        self.vessel.serve(self._clock.now_s())

    def receive(self) -> bytes:
        """Bytes from the vessel to the ground station since the last call."""
        return self._link.from_vessel()

    def identify(self) -> ControllerModel:
        """Close this rig and identify the hull from its log."""
        from companion.analysis.identify import identify

        self.close()
        fit = identify(open_log(self._folder), out=self._folder).fit
        return ControllerModel(fit.hull, fit.thrusters)

    def rerun_with(self, model: ControllerModel, folder: str) -> LockstepRig:
        """A new rig in the same conditions whose controller uses `model`; it logs into `folder` below this one's."""
        conditions = replace(self.conditions, controller_model=model)
        return LockstepRig(conditions, self._folder / folder, watch=self._watch)

    def second_vessel(self, conditions: Conditions, folder: str) -> LockstepRig:
        """Another vessel in the same sea; it logs into `folder` below this one's. Step both in turn."""
        return LockstepRig(conditions, self._folder / folder, self.world.shared_sea)

    def close(self) -> None:
        """Close the vessel and its log; a second call does nothing."""
        if not self._closed:
            self._closed = True
            self.vessel.close()


def _equipped(conditions: Conditions) -> VesselConfig:
    """The vessel with the thrusters and sensors that the conditions ask for."""
    config = load_vessel(conditions.vessel) if conditions.known is None else conditions.known
    for name in conditions.rotating:
        config = config_module.with_rotating_thruster(config, name)
    if conditions.wind_sensor:
        config = _with_sensor(config, "wind", "nmea0183")
    if conditions.magnetometer:
        config = with_magnetometer(config)
    if conditions.ais:
        config = _with_sensor(config, "ais", "ais")
    if conditions.lidar:
        config = _with_sensor(config, "lidar", "mavlink_range")
    if conditions.sounder:
        config = _with_sensor(config, "sounder", "nmea0183")
    if conditions.camera:
        config = config_module.with_camera(config)
    return _with_moving_base(config) if conditions.moving_base else config


def _with_moving_base(config: VesselConfig) -> VesselConfig:
    """The vessel whose first receiver uses the lead boat's as its base."""
    first = next(sensor for sensor in config.sensors if sensor.driver == "nmea0183")
    sensors = (replace(row, moving_base=True) if row is first else row for row in config.sensors)
    return replace(config, sensors=tuple(sensors))


def _with_sensor(config: VesselConfig, name: str, driver: str) -> VesselConfig:
    sensor = SensorConfig(name=name, driver=driver, port=f"memory:{name}", rate_hz=5.0)
    return replace(config, sensors=(*config.sensors, sensor))


def _controller_config(config: VesselConfig, conditions: Conditions) -> VesselConfig:
    """The vessel as its controller knows it: another hull, no calibration, or a wrong model, where asked for."""
    if conditions.magnetometer == "raw":
        config = config_module.without_calibration(config)
    model = conditions.controller_model
    if isinstance(model, str):
        plants = config.sitl.plants if config.sitl is not None else {}
        if model not in plants:
            raise UsageError(f"no plant '{model}' whose hull the controller could use; there is {', '.join(plants)}")
        config = replace(config, hull=plants[model].hull)
    elif model is not None:
        config = replace(config, hull=model.hull, thrusters=model.thrusters or config.thrusters)
    return config_module.with_model_error(config, conditions.model_error) if conditions.model_error else config


def _world(config: VesselConfig, conditions: Conditions, shared_sea: SharedSea | None) -> World:
    """The simulated boat, at its start."""
    c = conditions
    if shared_sea is None and (c.lead_boats or c.gnss_common):
        shared_sea = build_shared_sea(c.lead_boats, config.home, c.seed, c.gnss_common)
    real = c.real or config
    if c.plant_error and config.sitl is not None:
        name = plant_name(config.sitl, c.plant, is_rough(c.water, config.sitl))
        real = with_plant_error(config, name, c.plant_error, c.seed)
    weather = WorldConditions(
        seed=c.seed,
        wind=c.wind,
        current=c.current,
        gnss=c.gnss,
        plant=c.plant,
        windage_error=c.windage_error,
        water=c.water,
        waves=c.waves,
        wave_drift=c.wave_drift,
        push_ned_n=c.push_ned_n,
        faults=c.faults,
        tow=c.tow,
    )
    world = World(real, weather, shared_sea)
    if c.start is not None:
        world.set_state(*c.start)
    return world
