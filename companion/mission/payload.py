"""Items and commands for cameras and gimbals → actions.

Source: MAVLink's common.xml. A command that takes pictures is the boat's own work; all others are passed on to a camera
or gimbal on the links.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from companion.core.payload import Forward, PayloadPart
from companion.mission.commands import Command
from companion.mission.plan import GLOBAL_FRAMES, PlanItem
from companion.mission.tasks import (
    ByDistance,
    ByTime,
    CameraAction,
    PayloadAction,
    StopPictures,
    TakePicture,
    TriggerControl,
)

MOST_CAMERAS = 6  # MAVLink: ids up to 6 are cameras of the autopilot, higher ones are components

Params = Sequence[float]


def payload_of(item: PlanItem) -> PayloadAction | None:
    """The action of a mission item on a camera or gimbal; None for an item of another kind."""
    params = (item.param1, item.param2, item.param3, item.param4, float(item.x), float(item.y), item.z)
    return payload_action(item.command, params, item.frame if item.frame in GLOBAL_FRAMES else None, item.seq)


def payload_action(command: int, params: Params, frame: int | None, seq: int = -1) -> PayloadAction | None:
    """The action of a MAV_CMD with checked parameters; None for a command of another kind."""
    taken = _CAMERA.get(command)
    if taken is not None and (action := taken(params)) is not None:
        return action
    part = PASSED_ON.get(command)
    if part is None:
        return None
    return Forward(part, command, tuple(params), frame, _component(command, params), seq)


def _number(value: float) -> int:
    """A whole number; 0 for NaN and infinity."""
    return int(value) if math.isfinite(value) else 0


def _by_digicam(params: Params) -> CameraAction | None:
    """Param 5 is the shutter; what zooms or focuses is passed on."""
    return TakePicture() if params[4] == params[4] and params[4] != 0.0 else None


def _by_distance(params: Params) -> CameraAction:
    return ByDistance(_number(params[3]), max(0.0, params[0]), _number(params[2]) == 1)


def _by_interval(params: Params) -> CameraAction:
    """Milliseconds; 0 and −1 leave it as it is, which is nothing to do."""
    return ByTime(_number(params[2]), 1e-3 * params[0]) if params[0] > 0.0 else TriggerControl(None, None)


def _start(params: Params) -> CameraAction:
    camera, interval_s, count = _number(params[0]), params[1], _number(params[2])
    if count == 1:
        return TakePicture(camera, _number(params[3]))
    return ByTime(camera, interval_s if interval_s > 0.0 else 0.0, count or None)


def _control(params: Params) -> CameraAction:
    """−1, and NaN, leave a part as it is."""
    enable, reset, pause = (_number(value) if value == value else -1 for value in params[:3])
    return TriggerControl(None if enable < 0 else enable == 1, None if pause < 0 else pause == 1, reset == 1)


_CAMERA: Mapping[int, Callable[[Params], CameraAction | None]] = {
    Command.DO_DIGICAM_CONTROL: _by_digicam,
    Command.DO_SET_CAM_TRIGG_DIST: _by_distance,
    Command.DO_SET_CAM_TRIGG_INTERVAL: _by_interval,
    Command.IMAGE_START_CAPTURE: _start,
    Command.IMAGE_STOP_CAPTURE: lambda params: StopPictures(_number(params[0])),
    Command.DO_TRIGGER_CONTROL: _control,
}
PASSED_ON: Mapping[int, PayloadPart] = {
    Command.DO_DIGICAM_CONTROL: PayloadPart.CAMERA,
    Command.DO_CONTROL_VIDEO: PayloadPart.CAMERA,
    Command.SET_CAMERA_MODE: PayloadPart.CAMERA,
    Command.SET_CAMERA_ZOOM: PayloadPart.CAMERA,
    Command.SET_CAMERA_FOCUS: PayloadPart.CAMERA,
    Command.SET_CAMERA_SOURCE: PayloadPart.CAMERA,
    Command.VIDEO_START_CAPTURE: PayloadPart.CAMERA,
    Command.VIDEO_STOP_CAPTURE: PayloadPart.CAMERA,
    Command.DO_MOUNT_CONFIGURE: PayloadPart.GIMBAL,
    Command.DO_MOUNT_CONTROL: PayloadPart.GIMBAL,
    Command.DO_MOUNT_CONTROL_QUAT: PayloadPart.GIMBAL,
    Command.DO_SET_ROI: PayloadPart.GIMBAL,
    Command.DO_SET_ROI_LOCATION: PayloadPart.GIMBAL,
    Command.DO_SET_ROI_WPNEXT_OFFSET: PayloadPart.GIMBAL,
    Command.DO_SET_ROI_NONE: PayloadPart.GIMBAL,
    Command.DO_SET_ROI_SYSID: PayloadPart.GIMBAL,
    Command.DO_GIMBAL_MANAGER_PITCHYAW: PayloadPart.GIMBAL,
    Command.DO_GIMBAL_MANAGER_CONFIGURE: PayloadPart.GIMBAL,
}
"""Commands that are passed on, and what to."""
PICTURES = frozenset(_CAMERA)
"""Commands that take pictures: the boat's own work."""

_DEVICE_PARAM: Mapping[int, int] = {  # which param names the camera or gimbal, from 0
    Command.DO_GIMBAL_MANAGER_PITCHYAW: 6,
    Command.DO_GIMBAL_MANAGER_CONFIGURE: 6,
    Command.DO_SET_ROI_LOCATION: 0,
    Command.DO_SET_ROI_WPNEXT_OFFSET: 0,
    Command.DO_SET_ROI_NONE: 0,
    Command.DO_SET_ROI_SYSID: 1,
    Command.SET_CAMERA_MODE: 0,
    Command.VIDEO_START_CAPTURE: 0,
    Command.VIDEO_STOP_CAPTURE: 0,
}


def _component(command: int, params: Params) -> int:
    """The component that a command names; 0 for the first that there is."""
    place = _DEVICE_PARAM.get(command)
    number = 0 if place is None else _number(params[place])
    return number if MOST_CAMERAS < number <= 0xFF else 0
