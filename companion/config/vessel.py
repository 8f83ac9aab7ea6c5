"""A vessel's TOML → frozen dataclasses, with every error of the file at once and its place.

Angles stand in the file in degrees (`azimuth_deg`) and in the dataclasses in radians (`azimuth_rad`); everything else
is SI in both.
"""

from __future__ import annotations

import functools
import math
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field, replace
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, TypeVar

from pydantic import AfterValidator, Field, TypeAdapter, ValidationError

from companion.config.actuators import BridgeRow
from companion.config.actuators.mavlink_servo import MavlinkServoConfig
from companion.config.blades import steered_by_rudder
from companion.config.bridge_checks import bridge_problems
from companion.config.chart import ChartConfig, placed_charts
from companion.config.devices import (
    UNIT_MATRIX,
    JetConfig,
    NozzleConfig,
    SensorConfig,
    ThrusterConfig,
)
from companion.config.dimensions.completion import Completion, completed
from companion.config.dimensions.fins import with_fins
from companion.config.dimensions.receivers import grade_of
from companion.config.driving import driving_problems
from companion.config.fields import (
    FROM_DEGREES,
    STRICT,
    Latitude,
    Longitude,
    Name,
    NonNegative,
    Positive,
    derived,
    means,
)
from companion.config.hull import HullConfig, ThesisModelConfig, WindageConfig, damping_problems, resistance_problems
from companion.config.hull_flow import CrossFlowConfig, Equations, LiftConfig
from companion.config.kinds import Equipment, Problem
from companion.config.losses import LossConfig
from companion.config.mistakes import problems_of
from companion.config.outputs import BatteryConfig, RelayConfig, ServoConfig, battery_problems, rest_problems
from companion.config.overlay import is_overlay, that_count, with_overlay
from companion.config.payload import CameraConfig, camera_problems
from companion.config.rough_water import USUAL, RoughWaterConfig, WaterKind
from companion.config.rudder_checks import rudder_problems
from companion.config.sail import KeelConfig
from companion.config.sail_checks import sail_problems
from companion.config.scripts import ScriptConfig, script_problems
from companion.config.sea import checked_waves
from companion.config.sensor_checks import sensor_problems
from companion.config.sensor_errors import SensorErrorConfig
from companion.config.sensors import SensorRow
from companion.config.streams import CorrectionsConfig, NmeaOutConfig, stream_problems
from companion.config.thruster_checks import jet_problems, thruster_problems
from companion.config.toml_mistakes import toml_mistake
from companion.config.toml_places import dotted, line_of
from companion.core.nearest import nearest


class ConfigError(Exception):
    """A file that cannot be used. `problems` holds one line for each fault, each with its place."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


@dataclass(frozen=True, slots=True)
class HomeConfig:
    """Where the boat lives: the origin of its local frame, and where SITL starts."""

    __pydantic_config__ = STRICT
    lat_deg: Annotated[Latitude, means("Latitude.")]
    lon_deg: Annotated[Longitude, means("Longitude.")]
    yaw_rad: Annotated[
        float,
        Field(alias="heading_deg", ge=-360.0, le=360.0),
        FROM_DEGREES,
        means("Heading in simulation at the start, clockwise from north."),
    ] = 0.0
    altitude_m: Annotated[float, means("Altitude above mean sea level.")] = 0.0


@dataclass(frozen=True, slots=True)
class LimitsConfig:
    """What the controller may ask of all thrusters together."""

    __pydantic_config__ = STRICT
    surge_n: Annotated[Positive, derived("Largest force ahead or astern.")]
    sway_n: Annotated[NonNegative, derived("Largest force sideways. 0 for a boat that cannot push itself sideways.")]
    yaw_nm: Annotated[Positive, derived("Largest moment.")]


@dataclass(frozen=True, slots=True)
class DockConfig:
    """The boat's own berth."""

    __pydantic_config__ = STRICT
    lat_deg: Annotated[
        Latitude,
        means("Latitude of the point of the berth's face that lies against the middle of `side`."),
    ]
    lon_deg: Annotated[Longitude, means("Longitude of that point.")]
    yaw_rad: Annotated[
        float,
        Field(alias="heading_deg", ge=-360.0, le=360.0),
        FROM_DEGREES,
        means("Heading of the boat at the berth, clockwise from north."),
    ]
    side: Annotated[
        Literal["port", "starboard", "bow", "stern"],
        means("Side with which the boat lies against the berth."),
    ] = "port"
    standoff_m: Annotated[
        float,
        Field(ge=1.0, le=50.0),
        means("Clear water from which the boat comes alongside."),
    ] = 2.0
    clearance_m: Annotated[
        float,
        Field(ge=0.0, le=5.0),
        means("Room between hull and face that fenders take up."),
    ] = 0.1


@dataclass(frozen=True, slots=True)
class PlantConfig:
    """One set of truth for SITL: the hull as it really is, and what the thrusters really do."""

    __pydantic_config__ = STRICT
    hull: Annotated[HullConfig, means("The hull as it really is.")]
    windage: Annotated[WindageConfig, means("Wind areas as they really are.")] = field(default_factory=WindageConfig)
    wind_centre_m: Annotated[
        tuple[float, Positive] | None,
        means(
            "Where the wind's force on the side attacks: ahead of the middle and above the water. Left out: by "
            "`cn` of the windage alone, and the wind does not heel the boat."
        ),
    ] = None
    thruster_lag_s: Annotated[NonNegative, means("Time constant with which thrust follows its command.")] = 0.3
    thruster_x_m: Annotated[
        tuple[float, ...] | None,
        means("Where the thrusters really are, one value for each. Left out: where `[[thruster]]` says."),
    ] = None
    jet: Annotated[JetConfig | None, means("The water jet as it really is. Left out: as the thruster says.")] = None
    nozzle: Annotated[
        NozzleConfig | None,
        means(
            "How a jet's nozzle or a rudder really turns. Left out: without lag, at `azimuth_rate_dps` of the thruster."
        ),
    ] = None
    seaway: Annotated[
        bool,
        means(
            "Without a sea state, the wind's chop at the frequency of encounter, with heave and yaw, and the wakes of "
            "lead boats. Otherwise wind only rolls and pitches the boat."
        ),
    ] = False
    keel: Annotated[KeelConfig | None, means("The keel of a sailing boat. Left out: none.")] = None
    losses: Annotated[LossConfig | None, means("What water and battery take of the thrust. Left out: nothing.")] = None
    sensor_errors: Annotated[
        SensorErrorConfig | None, means("What sensors get wrong beyond noise and biases. Left out: nothing.")
    ] = None
    lag_on: Annotated[
        Literal["thrust", "revolutions"],
        means("What of propellers follows with `thruster_lag_s`; thrust goes with the square of the revolutions."),
    ] = "thrust"
    cross_flow: Annotated[
        CrossFlowConfig | None, means("Cross-flow drag by strips. Left out: the damping of the hull alone.")
    ] = None
    lift: Annotated[
        LiftConfig | None, means("Lift of the hull under way. Left out: the damping of the hull alone.")
    ] = None
    equations: Annotated[
        Equations,
        means(
            "Whose equations move the hull: the companion's, by `hull`, or those of the Otter in Fossen's Python "
            "Vehicle Simulator, in six degrees of freedom, of 2023, of 2024, or without two errors. These are an Otter "
            "whatever `hull` says."
        ),
    ] = "companion"


GnssGrade = Literal["rtk", "float", "sbas", "standalone", "basin"]

AS_MODELLED = "as_modelled"
"""Name of the plant whose hull is the controller's own."""


@dataclass(frozen=True, slots=True)
class SitlConfig:
    """The simulated boat: its plants, its receiver, its battery and its sea."""

    __pydantic_config__ = STRICT
    plant: Annotated[
        str,
        means("The plant that is used: a name in `[sitl.plants]`. `as_modelled` is the controller's own hull."),
    ] = AS_MODELLED
    plants: Annotated[dict[str, PlantConfig], means("Plants by name.")] = field(default_factory=dict)
    gnss: Annotated[GnssGrade, derived("Grade of the simulated receiver. Left out: by the sensors.")] = "rtk"
    battery_wh: Annotated[Positive, means("Energy of the simulated battery.")] = 900.0
    full_power_w: Annotated[Positive, means("Power of all thrusters together at full throttle.")] = 340.0
    hotel_power_w: Annotated[NonNegative, means("Power of everything else.")] = 20.0
    waves: Annotated[
        str,
        AfterValidator(checked_waves),
        means("Sea state, `HS[@FROM_DEG][/TP_S]`: significant height, direction it comes from, peak period."),
    ] = ""
    water: Annotated[
        WaterKind,
        means("`usual`, or `rough`: all that water, wind and sensors can do to the boat, together."),
    ] = USUAL
    rough: Annotated[RoughWaterConfig, means('What `water = "rough"` is made of.')] = field(
        default_factory=RoughWaterConfig
    )


@dataclass(frozen=True, slots=True)
class VesselConfig:
    """A vessel, whole. `hull` and `windage` are the controller's own model."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Short name. Folders of state and logs are named after it.")]
    title: Annotated[str, means("Name for people.")]
    length_m: Annotated[Positive, derived("Length over all.")]
    beam_m: Annotated[Positive, derived("Width.")]
    control_rate_hz: Annotated[
        float,
        Field(ge=4.0, le=100.0),
        means("Rate of the control loop. At least 4: bridges go neutral 0.5 s after the last command."),
    ]
    home: Annotated[HomeConfig, means("Where the boat lives.")]
    hull: Annotated[HullConfig, means("The controller's model of the hull.")]
    limits: Annotated[LimitsConfig, derived("What the controller may ask of all thrusters together.")]
    thrusters: Annotated[tuple[ThrusterConfig, ...], Field(alias="thruster", min_length=1), means("Thrusters.")]
    sensors: Annotated[tuple[SensorRow, ...], Field(alias="sensor", min_length=1), means("Sensors.")]
    actuators: Annotated[
        tuple[BridgeRow, ...],
        Field(alias="actuator", min_length=1),
        means("Bridges: the devices that turn commands into thrust."),
    ]
    servos: Annotated[tuple[ServoConfig, ...], Field(alias="servo", max_length=16), means("Servo outputs.")] = ()
    relays: Annotated[tuple[RelayConfig, ...], Field(alias="relay", max_length=16), means("Relays.")] = ()
    cameras: Annotated[tuple[CameraConfig, ...], Field(alias="camera", max_length=6), means("Cameras.")] = ()
    windage: Annotated[
        WindageConfig,
        means("Wind areas and coefficients, as the controller believes them."),
    ] = field(default_factory=WindageConfig)
    thesis_model: Annotated[ThesisModelConfig | None, means("Model of the thesis's own feed-forward.")] = None
    corrections: Annotated[tuple[CorrectionsConfig, ...], means("Sources of RTCM corrections.")] = ()
    nmea_out: Annotated[tuple[NmeaOutConfig, ...], means("Streams of NMEA sentences to others.")] = ()
    links: Annotated[tuple[str, ...], means("Links to ground stations, such as `udpout:192.168.1.10:14550`.")] = ()
    operators: Annotated[
        tuple[Annotated[int, Field(ge=1, le=255)], ...],
        means("System ids of the ground stations that may command. Empty: all."),
    ] = ()
    scripts: Annotated[
        tuple[ScriptConfig, ...], Field(alias="script", max_length=8), means("Scripts that run beside the companion.")
    ] = ()
    charts: Annotated[
        tuple[ChartConfig, ...], Field(alias="chart", max_length=16), means("Charts of known obstacles.")
    ] = ()
    mmsi: Annotated[
        Annotated[int, Field(ge=1, le=999_999_999)] | None,
        means("MMSI of the boat's own AIS transponder, whose reports are not another vessel's."),
    ] = None
    parameters: Annotated[
        dict[str, float],
        means("Parameters over the defaults of the table."),
    ] = field(default_factory=dict)
    dock: Annotated[DockConfig | None, means("The boat's own berth.")] = None
    battery: Annotated[BatteryConfig | None, means("Battery of a board that does not count charge.")] = None
    sitl: Annotated[
        SitlConfig | None,
        means("Simulated boat. Without this table it is the controller's own hull, with the receiver of the sensors."),
    ] = None

    @property
    def has_sail(self) -> bool:
        """Whether a sail drives the boat."""
        return any(thruster.kind == "sail" for thruster in self.thrusters)

    @property
    def has_rudder(self) -> bool:
        """Whether a rudder behind a propeller is all that steers the boat; that of a sail belongs to the sail."""
        return steered_by_rudder(self.thrusters)


class NavigatedBoat(Protocol):
    """What navigation needs of a boat: a vessel, or a lead boat with a module aboard."""

    @property
    def home(self) -> HomeConfig:
        """Origin of the local frame."""
        ...

    @property
    def sensors(self) -> tuple[SensorConfig, ...]:
        """Its sensors, in the order of the file."""
        ...


def bundled() -> tuple[str, ...]:
    """Names of the vessels that come with the program."""
    files = resources.files("companion.vessels").iterdir()
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml") and not is_overlay(f.name))
    )


def find(vessel: str) -> Path:
    """The file of a bundled name or a path. Raises ConfigError with the remedy."""
    if vessel in bundled():
        return Path(str(resources.files("companion.vessels").joinpath(f"{vessel}.toml")))
    path = Path(vessel)
    if path.is_file():
        return path
    if path.is_dir():
        raise ConfigError([f"{vessel}: a folder; give the TOML file in it"])
    beside = {each.stem: each for each in path.parent.glob("*.toml")} if path.parent.is_dir() else {}
    is_file = vessel.endswith(".toml") or "/" in vessel
    found = nearest(path.stem if is_file else vessel, beside if is_file else [*bundled(), *beside])
    meant = "" if found is None else f"; did you mean '{beside.get(found, found)}'?"
    if is_file:
        raise ConfigError([f"{vessel}: no such file{meant}"])
    raise ConfigError([f"no vessel named '{vessel}'; bundled: {', '.join(bundled())}; or a path of a TOML file{meant}"])


def load(path: Path) -> VesselConfig:
    """Read and check a vessel's file, with what a trial found and the operator accepted (`overlay`), or else with the
    damping by its rudders (`with_fins`). The simulated boat stays that of the file. Raises ConfigError with every
    problem and its line."""
    try:
        text, overlays = text_of(path), _overlays_of(path)
        config = parse(text, str(path))
        found = config if not overlays else replace(_overlaid(text, overlays), sitl=config.sitl)
        if found.hull.damping == config.hull.damping:  # a trial finds the fins with the hull
            found = replace(found, hull=with_fins(found.hull, found.thrusters, found.limits.surge_n))
        return replace(found, charts=placed_charts(found.charts, path.parent)) if found.charts else found
    except OSError as error:
        raise ConfigError([f"{path}: cannot be read: {error.strerror or error}"]) from error


def text_of(path: Path) -> str:
    """What a text file holds, without the mark that editors of Windows put at its beginning. Raises OSError;
    ConfigError for what is no text."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError([f"{path}: not text in UTF-8; save it again as UTF-8"]) from error


def _overlays_of(path: Path) -> tuple[Path, ...]:
    """The overlays that count. Raises OSError; ConfigError for one that is no text."""
    try:
        return that_count(path)
    except UnicodeDecodeError as error:
        raise ConfigError([f"{path}: an overlay beside it is not text in UTF-8; save it again as UTF-8"]) from error


def _overlaid(text: str, overlays: tuple[Path, ...]) -> VesselConfig:
    """The vessel with the keys of overlays, the last before all others. Raises ConfigError, OSError."""
    for overlay in overlays:
        try:
            tomllib.loads(text_of(overlay))
        except tomllib.TOMLDecodeError as error:
            raise ConfigError([_not_toml(str(overlay), text_of(overlay), str(error))]) from error
    config, located = validated(
        VesselConfig,
        text,
        str(overlays[-1]),
        lambda data: completed(functools.reduce(with_overlay, overlays, data)),
        numbered=False,
    )
    config = _simulated(config)
    problems = [located(loc, message) for loc, message in _cross_checks(config)]
    if problems:
        raise ConfigError(problems)
    return config


def parse(text: str, place: str) -> VesselConfig:
    """As `load`, for text already in hand; `place` names it in the messages."""
    config, located = validated(VesselConfig, text, place, completed)
    config = _simulated(config)
    problems = [located(loc, message) for loc, message in _cross_checks(config)]
    if problems:
        raise ConfigError(problems)
    return config


def _simulated(config: VesselConfig) -> VesselConfig:
    """The vessel with a plant made of the controller's own hull, where its file asks for no other."""
    sitl = config.sitl or SitlConfig(gnss=grade_of(config.sensors))
    if sitl.plant != AS_MODELLED or AS_MODELLED in sitl.plants:
        return replace(config, sitl=sitl)
    plant = PlantConfig(hull=config.hull, windage=config.windage)
    return replace(config, sitl=replace(sitl, plants={**sitl.plants, AS_MODELLED: plant}))


T = TypeVar("T")
Located = Callable[[Sequence[str | int], str], str]


def validated(
    kind: type[T],
    text: str,
    place: str,
    complete: Callable[[Mapping[str, Any]], Completion] | None = None,
    numbered: bool = True,
) -> tuple[T, Located]:
    """A TOML's text as one of our dataclasses, and a function that puts file, line and key before a message. `complete`
    fills in what follows from other keys. `numbered` False: the keys may stand in another file, so no lines. Raises
    ConfigError with every problem."""
    try:
        data = _tables(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError([_not_toml(place, text, str(error))]) from error
    lines = text.splitlines()

    def located(loc: Sequence[str | int], message: str) -> str:
        line = line_of(lines, loc) if numbered else None
        return f"{place}{f':{line}' if line else ''}: {dotted(loc)}: {message}"

    completion = Completion(data) if complete is None else complete(data)
    problems = list(completion.problems)
    try:
        reader: Any = kind  # mypy takes a class with slots for one that cannot be hashed
        found: T = _reader(reader).validate_python(completion.data)
    except ValidationError as error:
        problems = problems_of(kind, error, data, completion.moot, problems)
    if problems:
        raise ConfigError([located(loc, message) for loc, message in problems])
    return found, located


@cache
def _reader(kind: Any) -> TypeAdapter[Any]:
    """It takes longer to make than to use."""
    return TypeAdapter(kind)


def _not_toml(place: str, text: str, reason: str) -> str:
    """tomllib's "Invalid value (at line 6, column 11)" with its line where all others have theirs."""
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", reason)
    if found is None:
        return f"{place}: not valid TOML: {reason}"
    line = text.split("\n")[int(found[2]) - 1]
    return f"{place}:{found[2]}: not valid TOML: {toml_mistake(found[1], line)}, at column {found[3]}"


def _cross_checks(config: VesselConfig) -> list[Problem]:
    """What no single field can know."""
    servos, relays = [row.name for row in config.servos], [row.name for row in config.relays]
    return [
        *_names_used_twice(config),
        *_links_used_twice(config.links),
        *driving_problems(config.actuators, config.thrusters, servos, relays),
        *rest_problems(config.servos),
        *camera_problems(config.cameras, config.servos, config.relays),
        *script_problems(config.scripts, config.operators, config.parameters),
        *battery_problems(config.battery),
        *stream_problems(config.sensors, config.actuators, config.corrections),
        *thruster_problems(config.thrusters),
        *sensor_problems(config.sensors),
        *bridge_problems(Equipment(config.thrusters, config.actuators, config.servos)),
        *jet_problems(config.thrusters, config.limits.sway_n),
        *rudder_problems(config.thrusters, config.limits.sway_n),
        *sail_problems(config),
        *resistance_problems(config.hull, ("hull",)),
        *damping_problems(config.hull, config.length_m),
        *_inertia_problems(config.hull),
        *([] if config.sitl is None else _sitl_problems(config.sitl, len(config.thrusters))),
    ]


def _names_used_twice(config: VesselConfig) -> list[Problem]:
    problems: list[Problem] = []
    for table in ("thruster", "sensor", "actuator", "servo", "relay", "camera", "script"):
        names = [row.name for row in getattr(config, f"{table}s")]
        problems += [
            ((table, i, "name"), f"'{name}' is used twice") for i, name in enumerate(names) if name in names[:i]
        ]
    sensors = [sensor.name for sensor in config.sensors]  # health, logs and messages know a device by its name alone
    return problems + [
        (("actuator", i, "name"), f"'{bridge.name}' is a sensor's name too: give the bridge another")
        for i, bridge in enumerate(config.actuators)
        if bridge.name in sensors
    ]


def _links_used_twice(links: Sequence[str]) -> list[Problem]:
    plain = [link.partition("?")[0] for link in links]
    return [(("links",), f"'{link}' stands there twice") for i, link in enumerate(plain) if link in plain[:i]]


def _inertia_problems(hull: HullConfig) -> list[Problem]:
    if hull.m22_kg * hull.m33_kgm2 > hull.m23_kgm * hull.yaw_coupling_kgm:
        return []
    return [(("hull", "m23_kgm"), "the inertia matrix is not positive definite")]


def _sitl_problems(sitl: SitlConfig, thrusters: int) -> list[Problem]:
    """Faults of the plants. `thrusters`: how many the vessel has."""
    problems: list[Problem] = []
    if sitl.plant not in sitl.plants:
        text = f"no plant named '{sitl.plant}'; there is {', '.join(sitl.plants)}"
        problems.append((("sitl", "plant"), text))
    if sitl.rough.plant and sitl.rough.plant not in sitl.plants:
        text = f"no plant named '{sitl.rough.plant}'; there is {', '.join(sitl.plants)}"
        problems.append((("sitl", "rough", "plant"), text))
    for name, plant in sitl.plants.items():
        if plant.thruster_x_m is not None and len(plant.thruster_x_m) != thrusters:
            text = f"needs {thrusters} values, one a thruster"
            problems.append((("sitl", "plants", name, "thruster_x_m"), text))
        problems += resistance_problems(plant.hull, ("sitl", "plants", name, "hull"))
        problems += [(("sitl", "plants", name, key), text) for key, text in _flow_problems(plant)]
    return problems


def _flow_problems(plant: PlantConfig) -> list[tuple[str, str]]:
    """Keys of a plant that have no effect beside another, or count twice, each with the reason."""
    damping = plant.hull.damping
    if plant.equations == "companion":
        twice = plant.lift is not None and (damping.y_uv, damping.n_uv, damping.n_ur) != (0.0, 0.0, 0.0)
        return [("lift", "counts y_uv, n_uv and n_ur of the hull's damping twice; leave out one")] if twice else []
    tables = (("cross_flow", plant.cross_flow), ("lift", plant.lift))
    text = "is for the companion's own equations; leave it out, or `equations`"
    return [(key, text) for key, table in tables if table is not None]


def placed(path: Path, loc: Sequence[str | int], message: str) -> str:
    """`message` with the file, the line and the key that it is about, for checks outside this room."""
    line = line_of(text_of(path).splitlines(), loc)
    return f"{path}{f':{line}' if line else ''}: {dotted(loc)}: {message}"


def with_home(config: VesselConfig, home: HomeConfig) -> VesselConfig:
    """The same vessel with another home."""
    return replace(config, home=home)


def with_camera(config: VesselConfig) -> VesselConfig:
    """The same vessel with a camera on a relay of its first bridge, for trials."""
    first = config.actuators[0]
    wired = replace(first, relays=(*first.relays, "shutter"))
    if isinstance(wired, MavlinkServoConfig) and wired.mavlink is not None:
        wired = replace(wired, mavlink=wired.mavlink.with_another_relay())
    bridges = (wired, *config.actuators[1:])
    relay, camera = RelayConfig("shutter", while_disarmed=True), CameraConfig("downward", "relay", relay="shutter")
    return replace(config, relays=(*config.relays, relay), actuators=bridges, cameras=(*config.cameras, camera))


def with_model_error(config: VesselConfig, fraction: float) -> VesselConfig:
    """The same vessel with a controller whose inertia and damping, and force of the sail, are wrong by `fraction`. The
    plants stay true."""
    hull, damping = config.hull, config.hull.damping
    factor = 1.0 + fraction
    wrong = replace(damping, **{name: getattr(damping, name) * factor for name in damping.__slots__})
    return replace(
        config,
        hull=replace(
            hull,
            m11_kg=hull.m11_kg * factor,
            m22_kg=hull.m22_kg * factor,
            m33_kgm2=hull.m33_kgm2 * factor,
            m23_kgm=hull.m23_kgm * factor,
            m32_kgm=None if hull.m32_kgm is None else hull.m32_kgm * factor,
            damping=wrong,
            resistance=tuple((speed_mps, force_n * factor) for speed_mps, force_n in hull.resistance),
        ),
        thrusters=tuple(_with_sail_error(thruster, factor) for thruster in config.thrusters),
    )


def _with_sail_error(thruster: ThrusterConfig, factor: float) -> ThrusterConfig:
    sail = thruster.sail
    return thruster if sail is None else replace(thruster, sail=replace(sail, force_scale=sail.force_scale * factor))


def with_rotating_thruster(config: VesselConfig, name: str) -> VesselConfig:
    """The same vessel with the fixed thruster `name` turning within ±270° at its rate. Raises ConfigError for one that
    cannot."""
    found = [t for t in config.thrusters if t.name == name and t.azimuth_rate_radps > 0.0]
    if not found:
        raise ConfigError([f"{config.name}: no thruster '{name}' with an azimuth_rate_dps, so it cannot rotate"])
    turning = replace(
        found[0], kind="azimuth", azimuth_min_rad=math.radians(-270.0), azimuth_max_rad=math.radians(270.0)
    )
    return replace(config, thrusters=tuple(turning if t.name == name else t for t in config.thrusters))


def without_calibration(config: VesselConfig) -> VesselConfig:
    """The same vessel with magnetometers that are not calibrated."""
    return replace(config, sensors=tuple(_uncalibrated(sensor) for sensor in config.sensors))


def _uncalibrated(sensor: SensorConfig) -> SensorConfig:
    if sensor.heading != "ahrs":
        return sensor
    return replace(sensor, mag_offset=(0.0, 0.0, 0.0), mag_matrix=UNIT_MATRIX, heading_wander_rad=None)


def as_dict(config: VesselConfig) -> dict[str, Any]:
    """The configuration in force for the manifest of a log, with the field names of this module, without passwords."""
    return asdict(replace(config, corrections=tuple(replace(row, password="") for row in config.corrections)))


def raw(path: Path) -> dict[str, Any]:
    """The tables of a file as they are, with their faults; empty where it is no TOML."""
    try:
        return _tables(text_of(path))
    except (OSError, ConfigError, tomllib.TOMLDecodeError):
        return {}


def _tables(text: str) -> dict[str, Any]:
    """The tables of a TOML's text, for the caller to change. Raises tomllib.TOMLDecodeError."""
    return deepcopy(_read_once(text))


@lru_cache(8)
def _read_once(text: str) -> dict[str, Any]:
    """Each check looks at the same file."""
    return tomllib.loads(text)


def raw_parameters(path: Path) -> dict[str, float]:
    """Entries of `[parameters]` that are numbers, of a file whose other parts may be wrong."""
    entries = raw(path).get("parameters", {})
    numbers = entries.items() if isinstance(entries, dict) else ()
    return {
        name: float(value) for name, value in numbers if isinstance(value, (int, float)) and not isinstance(value, bool)
    }
