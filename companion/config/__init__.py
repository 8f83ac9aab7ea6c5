"""A vessel's TOML → frozen dataclasses, with every error of the file at once and its place.

Angles stand in the file in degrees (`azimuth_deg`) and in the dataclasses in radians (`azimuth_rad`); everything else is SI in both.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, TypeVar

from pydantic import Field, TypeAdapter, ValidationError

from companion.config.bridge_checks import bridge_problems
from companion.config.bridges import PULSE_DRIVERS as PULSE_DRIVERS
from companion.config.bridges import MavlinkBoardConfig as MavlinkBoardConfig
from companion.config.bridges import OutputConfig as OutputConfig
from companion.config.devices import UNIT_MATRIX as UNIT_MATRIX
from companion.config.devices import ActuatorConfig as ActuatorConfig
from companion.config.devices import JetConfig as JetConfig
from companion.config.devices import MotorConfig as MotorConfig
from companion.config.devices import NozzleConfig as NozzleConfig
from companion.config.devices import SensorConfig as SensorConfig
from companion.config.devices import StepperConfig as StepperConfig
from companion.config.devices import ThrusterConfig as ThrusterConfig
from companion.config.driving import azimuths_of as azimuths_of
from companion.config.driving import driving_problems
from companion.config.fields import FROM_DEGREES, STRICT, Latitude, Longitude, Name, NonNegative, Positive, Vector
from companion.config.hull import DampingConfig as DampingConfig
from companion.config.hull import HullConfig as HullConfig
from companion.config.hull import ThesisModelConfig as ThesisModelConfig
from companion.config.hull import WindageConfig as WindageConfig
from companion.config.hull import resistance_problems
from companion.config.jets import jet_problems
from companion.config.outputs import BatteryConfig as BatteryConfig
from companion.config.outputs import RelayConfig as RelayConfig
from companion.config.outputs import ServoConfig as ServoConfig
from companion.config.outputs import battery_problems, rest_problems
from companion.config.streams import CorrectionsConfig as CorrectionsConfig
from companion.config.streams import NmeaOutConfig as NmeaOutConfig
from companion.config.streams import stream_problems
from companion.core.toml_places import dotted, line_of


class ConfigError(Exception):
    """A vessel file that cannot be used. `problems` holds one line for each fault, each with its place."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


@dataclass(frozen=True, slots=True)
class HomeConfig:
    """Where the boat lives: the origin of its local frame, and where SITL starts."""

    __pydantic_config__ = STRICT
    lat_deg: Latitude
    lon_deg: Longitude
    yaw_rad: Annotated[float, Field(alias="heading_deg", ge=-360.0, le=360.0), FROM_DEGREES] = 0.0
    altitude_m: float = 0.0


@dataclass(frozen=True, slots=True)
class LimitsConfig:
    """What the controller may ask of all thrusters together."""

    __pydantic_config__ = STRICT
    surge_n: Positive
    sway_n: NonNegative
    yaw_nm: Positive


@dataclass(frozen=True, slots=True)
class DockConfig:
    """The boat's own berth. `lat_deg`, `lon_deg`: the point of its face that lies against the middle of `side`; `yaw_rad`: the boat's heading there.

    `clearance_m` is the room between hull and face that fenders take up, `standoff_m` the clear water from which the boat comes alongside.
    """

    __pydantic_config__ = STRICT
    lat_deg: Latitude
    lon_deg: Longitude
    yaw_rad: Annotated[float, Field(alias="heading_deg", ge=-360.0, le=360.0), FROM_DEGREES]
    side: Literal["port", "starboard", "bow", "stern"] = "port"
    standoff_m: Annotated[float, Field(ge=1.0, le=50.0)] = 2.0
    clearance_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.1


@dataclass(frozen=True, slots=True)
class PlantConfig:
    """One set of truth for SITL: the hull as it really is, and what the thrusters really do."""

    __pydantic_config__ = STRICT
    hull: HullConfig
    windage: WindageConfig = field(default_factory=WindageConfig)
    thruster_lag_s: NonNegative = 0.3
    thruster_x_m: tuple[float, ...] | None = None  # None: where the vessel says
    jet: JetConfig | None = None  # None: as the vessel says
    nozzle: NozzleConfig | None = None  # of a jet; None: at once, at the rate that the vessel says
    seaway: bool = False  # waves at the frequency with which the boat meets them, with heave and yaw; else roll, pitch and push alone


@dataclass(frozen=True, slots=True)
class SitlConfig:
    __pydantic_config__ = STRICT
    plant: str
    plants: dict[str, PlantConfig]
    gnss: str = "rtk"  # grade of the receiver
    battery_wh: Positive = 900.0
    full_power_w: Positive = 340.0  # of all thrusters together
    hotel_power_w: NonNegative = 20.0


@dataclass(frozen=True, slots=True)
class VesselConfig:
    """A vessel, whole. `hull` and `windage` are the controller's own model; `parameters` go over the table's defaults."""

    __pydantic_config__ = STRICT
    name: Name
    title: str
    length_m: Positive
    beam_m: Positive
    control_rate_hz: Annotated[float, Field(ge=1.0, le=100.0)]
    home: HomeConfig
    hull: HullConfig
    limits: LimitsConfig
    thrusters: Annotated[tuple[ThrusterConfig, ...], Field(alias="thruster", min_length=1)]
    sensors: Annotated[tuple[SensorConfig, ...], Field(alias="sensor", min_length=1)]
    actuators: Annotated[tuple[ActuatorConfig, ...], Field(alias="actuator", min_length=1)]
    servos: Annotated[tuple[ServoConfig, ...], Field(alias="servo", max_length=16)] = ()
    relays: Annotated[tuple[RelayConfig, ...], Field(alias="relay", max_length=16)] = ()
    windage: WindageConfig = field(default_factory=WindageConfig)
    thesis_model: ThesisModelConfig | None = None
    corrections: tuple[CorrectionsConfig, ...] = ()
    nmea_out: tuple[NmeaOutConfig, ...] = ()
    links: tuple[str, ...] = ()
    operators: tuple[Annotated[int, Field(ge=1, le=255)], ...] = ()  # system ids of the ground stations that may command; none: all
    mmsi: Annotated[int, Field(ge=1, le=999_999_999)] | None = None  # of its own AIS transponder, whose reports are not another vessel's
    parameters: dict[str, float] = field(default_factory=dict)
    dock: DockConfig | None = None
    battery: BatteryConfig | None = None
    sitl: SitlConfig | None = None


class NavigatedBoat(Protocol):
    """What navigation must know of a boat: a vessel, or a lead boat, which has a module aboard and is steered by its crew."""

    @property
    def home(self) -> HomeConfig: ...

    @property
    def sensors(self) -> tuple[SensorConfig, ...]: ...


def bundled() -> tuple[str, ...]:
    """Names of the vessels that come with the program."""
    files = resources.files("companion.vessels").iterdir()
    return tuple(sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml")))


def find(vessel: str) -> Path:
    """The file of a bundled name or a path. Raises ConfigError with the remedy."""
    if vessel in bundled():
        return Path(str(resources.files("companion.vessels").joinpath(f"{vessel}.toml")))
    path = Path(vessel)
    if path.is_file():
        return path
    if vessel.endswith(".toml") or "/" in vessel:
        raise ConfigError([f"{vessel}: no such file"])
    raise ConfigError([f"no vessel named '{vessel}'; bundled: {', '.join(bundled())}; or give the path of a TOML file"])


def load(path: Path) -> VesselConfig:
    """Read and check a vessel's file. Raises ConfigError with every problem and its line."""
    try:
        text = path.read_text(encoding="utf-8")
        return parse(text, str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError([f"{path}: cannot be read: {error}"]) from error


def parse(text: str, place: str) -> VesselConfig:
    """As `load`, for text already in hand; `place` names it in the messages."""
    config, located = validated(VesselConfig, text, place)
    problems = [located(loc, message) for loc, message in _cross_checks(config)]
    if problems:
        raise ConfigError(problems)
    return config


T = TypeVar("T")
Located = Callable[[Sequence[str | int], str], str]


def validated(kind: type[T], text: str, place: str) -> tuple[T, Located]:
    """A TOML's text as one of our dataclasses, and a function that puts file, line and key before a message. Raises ConfigError with every problem."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError([_not_toml(place, str(error))]) from error
    lines = text.splitlines()

    def located(loc: Sequence[str | int], message: str) -> str:
        line = line_of(lines, loc)
        return f"{place}{f':{line}' if line else ''}: {dotted(loc)}: {message}"

    try:
        return TypeAdapter(kind).validate_python(data), located
    except ValidationError as error:
        raise ConfigError([located(e["loc"], _remedy(e["msg"])) for e in error.errors()]) from error


def _not_toml(place: str, reason: str) -> str:
    """tomllib's "Invalid value (at line 6, column 11)" with its line where all others have theirs."""
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", reason)
    return f"{place}:{found[2]}: not valid TOML: {found[1]}, at column {found[3]}" if found else f"{place}: not valid TOML: {reason}"


def _remedy(message: str) -> str:
    """pydantic's wording, turned towards a person who edits a TOML."""
    return message.replace("Unexpected keyword argument", "unknown key; check the spelling").replace("Input should", "should")


def _cross_checks(config: VesselConfig) -> list[tuple[tuple[str | int, ...], str]]:
    """What no single field can know."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    tables = {
        "thruster": [row.name for row in config.thrusters],
        "sensor": [row.name for row in config.sensors],
        "actuator": [row.name for row in config.actuators],
        "servo": [row.name for row in config.servos],
        "relay": [row.name for row in config.relays],
    }
    for table, names in tables.items():
        for i, name in enumerate(names):
            if name in names[:i]:
                problems.append(((table, i, "name"), f"'{name}' is used twice"))
    problems += driving_problems(config.actuators, config.thrusters, tables["servo"], tables["relay"])
    problems += rest_problems(config.servos) + battery_problems(config.battery)
    problems += stream_problems(config.sensors, config.actuators, config.corrections)
    for i, thruster in enumerate(config.thrusters):
        if thruster.turns and thruster.azimuth_rate_radps <= 0.0:
            problems.append((("thruster", i, "azimuth_rate_dps"), f"a thruster of kind '{thruster.kind}' needs a rate above 0"))
        if thruster.retractable != (thruster.travel_s > 0.0):
            text = "a retractable thruster needs the time that it takes" if thruster.retractable else "only for a retractable thruster"
            problems.append((("thruster", i, "travel_s"), text))
        if thruster.forbidden_rad:
            problems += [(("thruster", i, "forbidden_deg"), text) for text in _sector_problems(thruster)]
    problems += magnetometer_problems(config.sensors)
    problems += bridge_problems(config.thrusters, config.actuators, config.servos)
    problems += jet_problems(config.thrusters, config.limits.sway_n)
    problems += resistance_problems(config.hull, ("hull",))
    if config.hull.m22_kg * config.hull.m33_kgm2 <= config.hull.m23_kgm * (config.hull.m32_kgm or config.hull.m23_kgm):
        problems.append((("hull", "m23_kgm"), "the inertia matrix is not positive definite"))
    if config.sitl is not None:
        if config.sitl.plant not in config.sitl.plants:
            problems.append((("sitl", "plant"), f"no plant named '{config.sitl.plant}'; there is {', '.join(config.sitl.plants)}"))
        for name, plant in config.sitl.plants.items():
            if plant.thruster_x_m is not None and len(plant.thruster_x_m) != len(config.thrusters):
                problems.append((("sitl", "plants", name, "thruster_x_m"), f"needs {len(config.thrusters)} values, one a thruster"))
            problems += resistance_problems(plant.hull, ("sitl", "plants", name, "hull"))
    return problems


def magnetometer_problems(sensors: Sequence[SensorConfig]) -> list[tuple[tuple[str | int, ...], str]]:
    """Soft-iron matrices that cannot be undone."""
    text = "has no inverse: a row is missing, or two say the same"
    return [(("sensor", i, "mag_matrix"), text) for i, sensor in enumerate(sensors) if not abs(_determinant(sensor.mag_matrix)) > 0.0]


def _determinant(matrix: tuple[Vector, Vector, Vector]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _sector_problems(thruster: ThrusterConfig) -> list[str]:
    problems = []
    if thruster.kind != "azimuth":
        problems.append("a fixed thruster has no sectors")
    if any((thruster.azimuth_rad - start) % math.tau < (end - start) % math.tau for start, end in thruster.forbidden_rad):
        problems.append("the azimuth at rest lies in a forbidden sector")
    if sum((end - start) % math.tau for start, end in thruster.forbidden_rad) >= math.tau:
        problems.append("the forbidden sectors leave no direction")
    return problems


def placed(path: Path, loc: Sequence[str | int], message: str) -> str:
    """`message` with the file, the line and the key that it is about, for what only other rooms can judge."""
    line = line_of(path.read_text(encoding="utf-8").splitlines(), loc)
    return f"{path}{f':{line}' if line else ''}: {dotted(loc)}: {message}"


def with_home(config: VesselConfig, home: HomeConfig) -> VesselConfig:
    """The same vessel, based elsewhere."""
    return replace(config, home=home)


def with_model_error(config: VesselConfig, fraction: float) -> VesselConfig:
    """The same vessel with a controller that believes in inertia and damping wrong by `fraction`; the plants stay true."""
    hull, damping = config.hull, config.hull.damping
    factor = 1.0 + fraction
    wrong = replace(damping, **{name: getattr(damping, name) * factor for name in damping.__slots__})
    return replace(
        config,
        hull=HullConfig(
            m11_kg=hull.m11_kg * factor,
            m22_kg=hull.m22_kg * factor,
            m33_kgm2=hull.m33_kgm2 * factor,
            m23_kgm=hull.m23_kgm * factor,
            m32_kgm=None if hull.m32_kgm is None else hull.m32_kgm * factor,
            damping=wrong,
            resistance=tuple((speed_mps, force_n * factor) for speed_mps, force_n in hull.resistance),
        ),
    )


def with_rotating(config: VesselConfig, name: str) -> VesselConfig:
    """The same vessel with the fixed thruster `name` turning within ±270° at its rate. Raises ConfigError for one that cannot."""
    found = [t for t in config.thrusters if t.name == name and t.azimuth_rate_radps > 0.0]
    if not found:
        raise ConfigError([f"{config.name}: no thruster '{name}' with an azimuth_rate_dps, so it cannot rotate"])
    turning = replace(found[0], kind="azimuth", azimuth_min_rad=math.radians(-270.0), azimuth_max_rad=math.radians(270.0))
    return replace(config, thrusters=tuple(turning if t.name == name else t for t in config.thrusters))


def without_calibration(config: VesselConfig) -> VesselConfig:
    """The same vessel before anybody calibrated its magnetometers."""
    fresh = {"mag_offset": (0.0, 0.0, 0.0), "mag_matrix": UNIT_MATRIX, "heading_wander_rad": None}
    return replace(config, sensors=tuple(replace(sensor, **fresh) if sensor.heading == "ahrs" else sensor for sensor in config.sensors))  # type: ignore[arg-type]


def as_dict(config: VesselConfig) -> dict[str, Any]:
    """For the manifest of a log: the configuration in force, with the field names of this module, without passwords."""
    return asdict(replace(config, corrections=tuple(replace(row, password="") for row in config.corrections)))


def raw(path: Path) -> dict[str, Any]:
    """The file's tables as they stand there, faults and all; empty where it is no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return {}


def raw_parameters(path: Path) -> dict[str, float]:
    """Entries of `[parameters]` that are numbers, of a file whose other parts may be wrong."""
    entries = raw(path).get("parameters", {})
    numbers = entries.items() if isinstance(entries, dict) else ()
    return {name: float(value) for name, value in numbers if isinstance(value, (int, float)) and not isinstance(value, bool)}


def parameter_lines(path: Path) -> Mapping[str, int]:
    """Line of each entry of `[parameters]`, for messages about what only the parameter table can judge."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return {}
    return {name: line_of(lines, ("parameters", name)) or 0 for name in raw_parameters(path)}
