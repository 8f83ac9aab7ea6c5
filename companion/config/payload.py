"""Cameras, as a vessel's file describes them: what takes the picture, how fast, and where the lens sits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, Name, Positive, means
from companion.config.outputs import RelayConfig, ServoConfig

Problem = tuple[tuple[str | int, ...], str]


@dataclass(frozen=True, slots=True)
class CameraConfig:
    """A camera, numbered from 1 in the order of the file. `kind` says what takes a picture: a relay that closes, a
    servo that presses, or a camera on the MAVLink links that is told to."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the camera. The geotag file has it.")]
    kind: Annotated[
        Literal["relay", "servo", "mavlink"],
        means("What takes a picture: a `relay`, a `servo`, or a `mavlink` camera on one of the links."),
    ]
    relay: Annotated[Name | None, means("The relay that closes. Only for kind `relay`.")] = None
    servo: Annotated[Name | None, means("The servo that presses. Only for kind `servo`.")] = None
    press_us: Annotated[
        float | None,
        Field(ge=500.0, le=2500.0),
        means("Pulse at which the servo presses. Only for kind `servo`."),
    ] = None
    component: Annotated[
        Annotated[int, Field(ge=2, le=255)] | None,
        means("MAVLink component id of the camera; the usual ones are 100 to 105. Only for kind `mavlink`."),
    ] = None
    pulse_s: Annotated[Positive, means("How long a relay stays closed, or a servo pressed.")] = 0.2
    interval_s: Annotated[Positive, means("Shortest time between two pictures that the camera can do.")] = 1.0
    x_m: Annotated[float, means("Position of the lens ahead of the middle of the boat.")] = 0.0
    y_m: Annotated[float, means("Position to starboard of the middle of the boat.")] = 0.0
    z_m: Annotated[float, means("Position below the middle of the boat; negative above it.")] = 0.0


OWN_KEYS: Mapping[str, tuple[str, ...]] = {
    "relay": ("relay",),
    "servo": ("servo", "press_us"),
    "mavlink": ("component",),
}
"""The keys that a kind must have and others must not: one row a kind."""


def camera_problems(
    cameras: Sequence[CameraConfig], servos: Sequence[ServoConfig], relays: Sequence[RelayConfig]
) -> list[Problem]:
    """What is wrong with `[[camera]]`, with its place."""
    problems: list[Problem] = []
    taken: dict[tuple[str, object], str] = {}
    for i, camera in enumerate(cameras):
        problems += _key_problems(camera, i)
        problems += _output_problems(camera, i, {servo.name: servo for servo in servos}, {row.name for row in relays})
        if camera.kind != "mavlink" and camera.interval_s < 2.0 * camera.pulse_s:
            problems.append((("camera", i, "interval_s"), f"should be {2.0 * camera.pulse_s:g} or more, twice pulse_s"))
        for key in OWN_KEYS[camera.kind][:1]:
            used = (key, getattr(camera, key))
            if used[1] is not None and used in taken:
                problems.append((("camera", i, key), f"'{taken[used]}' has it too"))
            taken.setdefault(used, camera.name)
    return problems


def _key_problems(camera: CameraConfig, i: int) -> list[Problem]:
    """Keys of another kind, and keys that this kind lacks."""
    problems: list[Problem] = []
    for kind, keys in OWN_KEYS.items():
        for key in keys:
            given = getattr(camera, key) is not None
            if kind == camera.kind and not given:
                problems.append((("camera", i), f"kind '{kind}' needs {key}"))
            if kind != camera.kind and given:
                problems.append((("camera", i, key), f"only for kind '{kind}', not '{camera.kind}'"))
    return problems


def _output_problems(
    camera: CameraConfig, i: int, servos: Mapping[str, ServoConfig], relays: set[str]
) -> list[Problem]:
    """Outputs that there are not, or that cannot do it."""
    if camera.relay is not None and camera.relay not in relays:
        return [(("camera", i, "relay"), f"no relay named '{camera.relay}'")]
    if camera.servo is None:
        return []
    servo = servos.get(camera.servo)
    if servo is None:
        return [(("camera", i, "servo"), f"no servo named '{camera.servo}'")]
    if servo.rest_us is None:
        return [(("camera", i, "servo"), f"'{servo.name}' needs rest_us, to release the shutter")]
    if camera.press_us is not None and not servo.min_us <= camera.press_us <= servo.max_us:
        return [(("camera", i, "press_us"), f"should be within {servo.min_us:g} to {servo.max_us:g}")]
    return []
