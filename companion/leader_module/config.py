"""A leader module's TOML → frozen dataclasses. The module can move from lead boat to lead boat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, Name, means
from companion.config.sensor_checks import sensor_problems
from companion.config.sensors import SensorRow
from companion.config.vessel import ConfigError, HomeConfig, validated

Axis = Annotated[int, Field(ge=0, le=63)]


@dataclass(frozen=True, slots=True)
class JoystickConfig:
    """A gamepad at a Linux joystick device. Axes have the numbers that `jstest` shows; `sway_axis` None: there is none.

    A stick pushed away gives −1 and means ahead, unless `reversed` names the axis.
    """

    __pydantic_config__ = STRICT
    device: Annotated[str, means("Linux joystick device.")] = "/dev/input/js0"
    surge_axis: Annotated[Axis, means("Axis of surge, as `jstest` numbers it.")] = 1
    yaw_axis: Annotated[Axis, means("Axis of yaw.")] = 3
    sway_axis: Annotated[Axis | None, means("Axis of sway.")] = 0
    reversed: Annotated[tuple[Literal["surge", "sway", "yaw"], ...], means("Axes that count the other way.")] = ()


@dataclass(frozen=True, slots=True)
class LeaderConfig:
    """A whole leader module.

    `follower`: system id of the vessel that is shown and that the sticks steer; every vessel on `links` receives it.
    `thrifty`: send whole messages only once a second; "auto": on serial links. `local_links`: for a ground station on
    the lead boat. `parameters`: of navigation, as in a vessel's file.
    """

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the module. Logs use it.")]
    system_id: Annotated[
        int,
        Field(ge=1, le=250),
        means("MAVLink system id of this module. It differs from the follower's."),
    ]
    links: Annotated[
        tuple[str, ...],
        Field(min_length=1),
        means("Links towards the follower. Every vessel on them hears the module."),
    ]
    sensors: Annotated[
        tuple[SensorRow, ...],
        Field(alias="sensor", min_length=1),
        means("Sensors of the lead boat, as in a vessel's file."),
    ]
    title: Annotated[str, means("Name for people.")] = ""
    follower: Annotated[
        int,
        Field(ge=1, le=255),
        means("System id of the vessel that is shown here and that the sticks steer (its MAV_SYS_ID)."),
    ] = 1
    rate_hz: Annotated[float, Field(ge=1.0, le=50.0), means("How often the module sends its position.")] = 20.0
    thrifty: Annotated[
        bool | Literal["auto"],
        means("Whole messages once a second only. `auto`: on serial links."),
    ] = "auto"
    local_links: Annotated[tuple[str, ...], means("Links for a ground station on the lead boat.")] = ()
    joystick: Annotated[JoystickConfig | None, means("Gamepad, for the mode Remote.")] = None
    home: Annotated[
        HomeConfig,
        means("Origin of the local frame."),
    ] = field(default_factory=lambda: HomeConfig(0.0, 0.0))
    parameters: Annotated[
        dict[str, float],
        means("Parameters of navigation, as in a vessel's file."),
    ] = field(default_factory=dict)


def bundled_leaders() -> tuple[str, ...]:
    """Names of the examples that the program brings."""
    files = resources.files("companion.leader_module").iterdir()
    return tuple(sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml")))


def find_leader(leader: str) -> Path:
    """The file of a bundled name or a path. Raises ConfigError that says what to do."""
    if leader in bundled_leaders():
        return Path(str(resources.files("companion.leader_module").joinpath(f"{leader}.toml")))
    if Path(leader).is_file():
        return Path(leader)
    raise ConfigError(
        [f"no leader module '{leader}'; bundled: {', '.join(bundled_leaders())}; or give the path of a TOML file"]
    )


def parse_leader(text: str, place: str) -> LeaderConfig:
    """The module in `text`. `place` names the text in messages. Raises ConfigError with every problem."""
    config, located = validated(LeaderConfig, text, place)
    problems: list[tuple[Sequence[str | int], str]] = list(sensor_problems(config.sensors))
    names = [sensor.name for sensor in config.sensors]
    problems += [
        (("sensor", i, "name"), f"'{name}' is used twice") for i, name in enumerate(names) if name in names[:i]
    ]
    if config.system_id == config.follower:
        problems.append((("system_id",), f"{config.system_id} is the follower's; the module needs another"))
    if problems:
        raise ConfigError([located(loc, message) for loc, message in problems])
    return config
