"""Values of the payload: pictures taken, and commands for cameras and gimbals on the links."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class PayloadPart(Enum):
    """What on the links a command is for."""

    CAMERA = "camera"
    GIMBAL = "gimbal"


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture: camera and image numbers, both from 1, and where the lens was when the camera was triggered.

    `number` counts the pictures of that camera since the program started, `count` those of all cameras. `speed_mps` is
    over ground. Accuracies are one sigma, as the estimate believes.
    """

    t_s: float
    camera: int
    name: str
    number: int
    count: int
    lat_deg: float
    lon_deg: float
    altitude_m: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    speed_mps: float
    position_accuracy_m: float
    heading_accuracy_rad: float
    component: int | None = None  # of a camera on the links, which has yet to be told


@dataclass(frozen=True, slots=True)
class Forward:
    """A MAV_CMD that a camera or gimbal on the links is to carry out, by a mission item `seq`. `frame` None: the params
    are those of COMMAND_LONG; else params 5 and 6 are the item's x and y. `component`: that of the camera or gimbal
    meant; 0: the first one."""

    part: PayloadPart
    command: int
    params: tuple[float, ...]
    frame: int | None
    component: int
    seq: int
