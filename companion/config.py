"""A vessel's TOML → frozen dataclasses, with every error of the file at once and its place.

Angles stand in the file in degrees (`azimuth_deg`) and in the dataclasses in radians (`azimuth_rad`); everything else is SI in both.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, TypeAdapter, ValidationError

from companion.config_outputs import Name, RelayConfig, ServoConfig, rest_problems
from companion.core.toml_places import dotted, line_of

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
_FROM_DEGREES = AfterValidator(math.radians)
_FROM_DEGREES_OR_NONE = AfterValidator(lambda degrees: None if degrees is None else math.radians(degrees))
_SECTORS_FROM_DEGREES = AfterValidator(lambda sectors: tuple((math.radians(a), math.radians(b)) for a, b in sectors))

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Latitude = Annotated[float, Field(ge=-89.0, le=89.0)]
Longitude = Annotated[float, Field(ge=-180.0, le=180.0)]


class ConfigError(Exception):
    """A vessel file that cannot be used. `problems` holds one line for each fault, each with its place."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


@dataclass(frozen=True, slots=True)
class HomeConfig:
    """Where the boat lives: the origin of its local frame, and where SITL starts."""

    __pydantic_config__ = _STRICT
    lat_deg: Latitude
    lon_deg: Longitude
    yaw_rad: Annotated[float, Field(alias="heading_deg", ge=-360.0, le=360.0), _FROM_DEGREES] = 0.0
    altitude_m: float = 0.0


@dataclass(frozen=True, slots=True)
class DampingConfig:
    """Hydrodynamic damping in Fossen's derivatives, positive where it resists: X = −(x_u u + x_uu |u|u + x_uuu u³) and so on.

    Y = −(y_v v + y_vv |v|v + y_rv |r|v + y_r r + y_vr |v|r + y_rr |r|r), N likewise with n_.
    """

    __pydantic_config__ = _STRICT
    x_u: float = 0.0
    x_uu: float = 0.0
    x_uuu: float = 0.0
    y_v: float = 0.0
    y_vv: float = 0.0
    y_rv: float = 0.0
    y_r: float = 0.0
    y_vr: float = 0.0
    y_rr: float = 0.0
    n_v: float = 0.0
    n_vv: float = 0.0
    n_rv: float = 0.0
    n_r: float = 0.0
    n_vr: float = 0.0
    n_rr: float = 0.0


@dataclass(frozen=True, slots=True)
class HullConfig:
    """Inertia with added mass, and damping: M = [[m11, 0, 0], [0, m22, m23], [0, m32, m33]]."""

    __pydantic_config__ = _STRICT
    m11_kg: Positive
    m22_kg: Positive
    m33_kgm2: Positive
    m23_kgm: float = 0.0
    m32_kgm: float | None = None  # None: as m23
    damping: DampingConfig = field(default_factory=DampingConfig)


@dataclass(frozen=True, slots=True)
class WindageConfig:
    """Wind areas and coefficients (Fossen 2011, 8.1.3), with (ax, ay) the velocity of the air relative to the boat in body axes:

    X = ½ρ cx A_F V ax, Y = ½ρ cy A_L V ay, N = −ρ cn A_L L ax ay (½ρ cn A_L L V² sin 2γ: the bow turns away from the wind).
    """

    __pydantic_config__ = _STRICT
    frontal_m2: NonNegative = 0.0
    lateral_m2: NonNegative = 0.0
    cx: float = 0.7
    cy: float = 0.9
    cn: float = 0.1


@dataclass(frozen=True, slots=True)
class ThesisModelConfig:
    """What the thesis's own feed-forward believes beside `hull`'s inertia: the bare hull's mass, and damping as printed."""

    __pydantic_config__ = _STRICT
    mass_kg: Positive
    damping: DampingConfig


@dataclass(frozen=True, slots=True)
class ThrusterConfig:
    """One thruster. Force F = ahead_n·u|u| (u ≥ 0) or astern_n·u|u| (u < 0), u the throttle −1…1, within [min_n, max_n].

    `azimuth_rad` is its direction at rest: the way it pushes the boat, clockwise from the bow. Kind "azimuth" turns at most
    `azimuth_rate_radps`, within [azimuth_min_rad, azimuth_max_rad] where those are given, else endlessly, and gives no thrust in a sector of
    `forbidden_rad`, each clockwise from its first to its second direction. A `retractable` one takes `travel_s` between up and down.
    """

    __pydantic_config__ = _STRICT
    name: Name
    kind: Literal["azimuth", "fixed"]
    x_m: float
    y_m: float
    max_n: Positive
    min_n: Annotated[float, Field(le=0.0)]
    ahead_n: Positive
    astern_n: Positive
    force_rate_nps: Positive
    azimuth_rad: Annotated[float, Field(alias="azimuth_deg", ge=-360.0, le=360.0), _FROM_DEGREES] = 0.0
    azimuth_rate_radps: Annotated[float, Field(alias="azimuth_rate_dps", ge=0.0), _FROM_DEGREES] = 0.0
    azimuth_min_rad: Annotated[float | None, Field(alias="azimuth_min_deg"), _FROM_DEGREES_OR_NONE] = None
    azimuth_max_rad: Annotated[float | None, Field(alias="azimuth_max_deg"), _FROM_DEGREES_OR_NONE] = None
    forbidden_rad: Annotated[tuple[tuple[float, float], ...], Field(alias="forbidden_deg"), _SECTORS_FROM_DEGREES] = ()
    manual_azimuth_rad: Annotated[float, Field(alias="manual_azimuth_deg", ge=0.0, le=180.0), _FROM_DEGREES] = 0.0
    dead_band: Annotated[float, Field(ge=0.0, lt=0.5)] = 0.0  # throttle below which nothing turns
    retractable: bool = False
    travel_s: NonNegative = 0.0


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """One sensor: its driver (a row of `companion/io/sensors`), its port, where it sits in body axes, and how good it is.

    Accuracies and noise densities are one sigma, as the filter is to weigh this sensor; wanders are slow errors that averaging does not
    take away. None: by kind; headings 0.4° with a wander of 0.1° from an antenna baseline, 3° with 2° from a compass; positions wander
    8 mm with carrier phase, else by 0.7 of their accuracy.
    """

    __pydantic_config__ = _STRICT
    name: Name
    driver: str
    port: str
    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    heading_offset_rad: Annotated[float, Field(alias="heading_offset_deg", ge=-360.0, le=360.0), _FROM_DEGREES] = 0.0
    rate_hz: Positive = 10.0
    timeout_s: Positive = 2.0
    antennas: Literal[1, 2] = 2  # of a satellite receiver; two give a heading
    latency_s: NonNegative = 0.0  # from the moment of validity to the arrival of the bytes
    heading: Literal["none", "magnetic", "true"] = "none"  # what an inertial sensor's own yaw is worth as a compass
    accuracy_floor_m: Positive = 0.02  # timing and mounting are no better, whatever the receiver says of its positions
    position_wander_m: NonNegative | None = None
    velocity_accuracy_mps: Positive = 0.06  # of a plain fix; with corrections half of that, with carrier phase 0.3
    heading_accuracy_rad: Annotated[float | None, Field(alias="heading_accuracy_deg", gt=0.0, le=45.0), _FROM_DEGREES_OR_NONE] = None
    heading_wander_rad: Annotated[float | None, Field(alias="heading_wander_deg", ge=0.0, le=45.0), _FROM_DEGREES_OR_NONE] = None
    accelerometer_noise_mps2_rthz: Positive = 0.004  # on a hull that shakes: a few times the data sheet's
    gyro_noise_radps_rthz: Annotated[float, Field(alias="gyro_noise_dps_rthz", gt=0.0), _FROM_DEGREES] = 2.0e-4


@dataclass(frozen=True, slots=True)
class ActuatorConfig:
    """One bridge: its driver (a row of `companion/io/actuators`), its port, and the thrusters, servos and relays it drives, by name."""

    __pydantic_config__ = _STRICT
    name: Name
    driver: str
    port: str
    thrusters: tuple[Name, ...]
    timeout_s: Positive = 1.0
    servos: tuple[Name, ...] = ()
    relays: tuple[Name, ...] = ()


@dataclass(frozen=True, slots=True)
class LimitsConfig:
    """What the controller may ask of all thrusters together."""

    __pydantic_config__ = _STRICT
    surge_n: Positive
    sway_n: NonNegative
    yaw_nm: Positive


@dataclass(frozen=True, slots=True)
class DockConfig:
    """The boat's own berth. `lat_deg`, `lon_deg`: the point of its face that lies against the middle of `side`; `yaw_rad`: the boat's heading there.

    `clearance_m` is the room between hull and face that fenders take up, `standoff_m` the clear water from which the boat comes alongside.
    """

    __pydantic_config__ = _STRICT
    lat_deg: Latitude
    lon_deg: Longitude
    yaw_rad: Annotated[float, Field(alias="heading_deg", ge=-360.0, le=360.0), _FROM_DEGREES]
    side: Literal["port", "starboard", "bow", "stern"] = "port"
    standoff_m: Annotated[float, Field(ge=1.0, le=50.0)] = 2.0
    clearance_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.1


@dataclass(frozen=True, slots=True)
class PlantConfig:
    """One set of truth for SITL: the hull as it really is, and what the thrusters really do."""

    __pydantic_config__ = _STRICT
    hull: HullConfig
    windage: WindageConfig = field(default_factory=WindageConfig)
    thruster_lag_s: NonNegative = 0.3
    thruster_x_m: tuple[float, ...] | None = None  # None: where the vessel says


@dataclass(frozen=True, slots=True)
class SitlConfig:
    __pydantic_config__ = _STRICT
    plant: str
    plants: dict[str, PlantConfig]
    gnss: str = "rtk"  # grade of the receiver
    battery_wh: Positive = 900.0
    full_power_w: Positive = 340.0  # of all thrusters together
    hotel_power_w: NonNegative = 20.0


@dataclass(frozen=True, slots=True)
class VesselConfig:
    """A vessel, whole. `hull` and `windage` are the controller's own model; `parameters` go over the table's defaults."""

    __pydantic_config__ = _STRICT
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
    links: tuple[str, ...] = ()
    parameters: dict[str, float] = field(default_factory=dict)
    dock: DockConfig | None = None
    sitl: SitlConfig | None = None


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
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError([f"{place}: not valid TOML: {error}"]) from error
    lines = text.splitlines()

    def located(loc: Sequence[str | int], message: str) -> str:
        line = line_of(lines, loc)
        return f"{place}{f':{line}' if line else ''}: {dotted(loc)}: {message}"

    try:
        config = TypeAdapter(VesselConfig).validate_python(data)
    except ValidationError as error:
        raise ConfigError([located(e["loc"], _remedy(e["msg"])) for e in error.errors()]) from error
    problems = [located(loc, message) for loc, message in _cross_checks(config)]
    if problems:
        raise ConfigError(problems)
    return config


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
    for table in ("thruster", "servo", "relay"):
        problems += _driving_problems(config, table, tables[table])
    problems += rest_problems(config.servos)
    for i, thruster in enumerate(config.thrusters):
        if thruster.kind == "azimuth" and thruster.azimuth_rate_radps <= 0.0:
            problems.append((("thruster", i, "azimuth_rate_dps"), "an azimuth thruster needs a rate above 0"))
        if thruster.retractable != (thruster.travel_s > 0.0):
            text = "a retractable thruster needs the time that it takes" if thruster.retractable else "only for a retractable thruster"
            problems.append((("thruster", i, "travel_s"), text))
        if thruster.forbidden_rad:
            problems += [(("thruster", i, "forbidden_deg"), text) for text in _sector_problems(thruster)]
    if config.hull.m22_kg * config.hull.m33_kgm2 <= config.hull.m23_kgm * (config.hull.m32_kgm or config.hull.m23_kgm):
        problems.append((("hull", "m23_kgm"), "the inertia matrix is not positive definite"))
    if config.sitl is not None:
        if config.sitl.plant not in config.sitl.plants:
            problems.append((("sitl", "plant"), f"no plant named '{config.sitl.plant}'; there is {', '.join(config.sitl.plants)}"))
        for name, plant in config.sitl.plants.items():
            if plant.thruster_x_m is not None and len(plant.thruster_x_m) != len(config.thrusters):
                problems.append((("sitl", "plants", name, "thruster_x_m"), f"needs {len(config.thrusters)} values, one a thruster"))
    return problems


def _driving_problems(config: VesselConfig, table: str, names: Sequence[str]) -> list[tuple[tuple[str | int, ...], str]]:
    """Each thruster, servo or relay is driven by one bridge, and each that a bridge drives is there."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    driven: set[str] = set()
    for i, actuator in enumerate(config.actuators):
        for name in getattr(actuator, f"{table}s"):
            if name not in names:
                problems.append((("actuator", i, f"{table}s"), f"no {table} named '{name}'"))
            if name in driven:
                problems.append((("actuator", i, f"{table}s"), f"'{name}' is driven by two bridges"))
            driven.add(name)
    return problems + [((table,), f"'{name}' is driven by no bridge") for name in sorted(set(names) - driven)]


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
        ),
    )


def with_rotating(config: VesselConfig, name: str) -> VesselConfig:
    """The same vessel with the fixed thruster `name` turning within ±270° at its rate. Raises ConfigError for one that cannot."""
    found = [t for t in config.thrusters if t.name == name and t.azimuth_rate_radps > 0.0]
    if not found:
        raise ConfigError([f"{config.name}: no thruster '{name}' with an azimuth_rate_dps, so it cannot rotate"])
    turning = replace(found[0], kind="azimuth", azimuth_min_rad=math.radians(-270.0), azimuth_max_rad=math.radians(270.0))
    return replace(config, thrusters=tuple(turning if t.name == name else t for t in config.thrusters))


def as_dict(config: VesselConfig) -> dict[str, Any]:
    """For the manifest of a log: the configuration in force, with the field names of this module."""
    return asdict(config)


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
