"""A leader module's TOML → frozen dataclasses: the small computer that is carried from lead boat to lead boat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from companion.config import ConfigError, HomeConfig, SensorConfig, magnetometer_problems, validated
from companion.config.fields import STRICT, Name

Axis = Annotated[int, Field(ge=0, le=63)]


@dataclass(frozen=True, slots=True)
class JoystickConfig:
    """A gamepad at a Linux joystick device. Axes by number, as `jstest` shows them; sway None: it has none. A pushed stick gives −1 there and means ahead, unless
    `reversed` names the axis."""

    __pydantic_config__ = STRICT
    device: str = "/dev/input/js0"
    surge_axis: Axis = 1
    yaw_axis: Axis = 3
    sway_axis: Axis | None = 0
    reversed: tuple[Literal["surge", "sway", "yaw"], ...] = ()


@dataclass(frozen=True, slots=True)
class LeaderConfig:
    """A leader module, whole. `follower`: system id of the vessel that is shown and that the sticks steer; every vessel on `links` hears it.

    `thrifty`: whole messages once a second only; "auto": on serial links. `local_links`: for a ground station on the lead boat. `parameters`: those of
    navigation, as in a vessel's file.
    """

    __pydantic_config__ = STRICT
    name: Name
    system_id: Annotated[int, Field(ge=1, le=250)]
    links: Annotated[tuple[str, ...], Field(min_length=1)]
    sensors: Annotated[tuple[SensorConfig, ...], Field(alias="sensor", min_length=1)]
    title: str = ""
    follower: Annotated[int, Field(ge=1, le=255)] = 1
    rate_hz: Annotated[float, Field(ge=1.0, le=50.0)] = 20.0
    thrifty: bool | Literal["auto"] = "auto"
    local_links: tuple[str, ...] = ()
    joystick: JoystickConfig | None = None
    home: HomeConfig = field(default_factory=lambda: HomeConfig(0.0, 0.0))
    parameters: dict[str, float] = field(default_factory=dict)


def bundled_leaders() -> tuple[str, ...]:
    """Names of the examples that come with the program."""
    files = resources.files("companion.leaders").iterdir()
    return tuple(sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml")))


def find_leader(leader: str) -> Path:
    """The file of a bundled name or a path. Raises ConfigError with the remedy."""
    if leader in bundled_leaders():
        return Path(str(resources.files("companion.leaders").joinpath(f"{leader}.toml")))
    if Path(leader).is_file():
        return Path(leader)
    raise ConfigError([f"no leader module '{leader}'; bundled: {', '.join(bundled_leaders())}; or give the path of a TOML file"])


def parse_leader(text: str, place: str) -> LeaderConfig:
    """Raises ConfigError with every problem; `place` names the text in the messages."""
    config, located = validated(LeaderConfig, text, place)
    problems: list[tuple[Sequence[str | int], str]] = list(magnetometer_problems(config.sensors))
    names = [sensor.name for sensor in config.sensors]
    problems += [(("sensor", i, "name"), f"'{name}' is used twice") for i, name in enumerate(names) if name in names[:i]]
    if config.system_id == config.follower:
        problems.append((("system_id",), f"{config.system_id} is the follower's; the module needs another"))
    if problems:
        raise ConfigError([located(loc, message) for loc, message in problems])
    return config
